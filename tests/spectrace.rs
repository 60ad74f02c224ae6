//! spectrace and specprobe through the real programs: efforts, parts, rays, and where methods fail.

mod common;

use std::fs;
use std::path::PathBuf;

use common::{fails, floats, program, root, run, split, stdout_of};

/// A scene in a folder of its own.
struct Stage(tempfile::TempDir);

impl Stage {
    fn new(text: &str) -> Stage {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("s.toml"), text).unwrap();
        Stage(folder)
    }

    fn path(&self) -> String {
        self.0.path().join("s.toml").to_str().unwrap().to_string()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Rows of numbers for lines of standard input.
    fn rows(&self, options: &[&str], input: &str) -> Vec<Vec<f64>> {
        let path = self.path();
        let out = stdout_of("spectrace", &[&[path.as_str()], options].concat(), input.as_bytes());
        let text = String::from_utf8(out).unwrap();
        let lines = text.lines().filter(|l| !l.starts_with('#'));
        lines.map(|l| l.split('\t').map(|w| w.parse().unwrap()).collect()).collect()
    }
}

/// A closed grey room of 2 m with a lamp of 0.5 m under its ceiling.
fn room(reflectance: f64, lamp: &str) -> String {
    format!(
        "[camera]\norigin = [0, -0.9, 0]\ntarget = [0, 1, 0]\nup = [0, 0, 1]\nfov_deg = 70\nwidth = 40\nheight = 30\n\
         [materials.wall]\nreflectance = {reflectance}\n\
         [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.5\ninward = true\nmaterial = \"wall\"\n{lamp}"
    )
}

const LAMP: &str = "[lights.l]\nspectrum = \"A\"\nluminance = 1000\n[[shape]]\ntype = \"quad\"\n\
                    points = [[-0.25, -0.25, 0.9], [-0.25, 0.25, 0.9], [0.25, 0.25, 0.9], [0.25, -0.25, 0.9]]\nmaterial = \"wall\"\nlight = \"l\"\n";

#[test]
fn threads_and_rows_change_nothing_at_any_effort() {
    let stage = Stage::new(&room(0.5, LAMP));
    let path = stage.path();
    for effort in [&["--samples", "3"][..], &["--error", "0.2"], &["--error", "0.05", "--samples", "100"]] {
        let render = |more: &[&str]| stdout_of("spectrace", &[&[path.as_str(), "--quiet"], effort, more].concat(), b"");
        let whole = render(&[]);
        assert_eq!(render(&["--threads", "1"]), whole);
        let (_, _, pixels) = split(&whole);
        let mut parts = Vec::new();
        for rows in ["0:1", "1:17", "17:30"] {
            parts.extend_from_slice(split(&render(&["--rows", rows])).2);
        }
        assert_eq!(parts, pixels, "{effort:?}");
    }
}

/// The error that is asked for is the error that comes out: against a long render, over all pixels.
#[test]
fn the_stated_error_is_true() {
    let stage = Stage::new(&room(0.5, LAMP));
    let path = stage.path();
    let y = |options: &[&str]| {
        let out = stdout_of("spectrace", &[&[path.as_str(), "--quiet", "--bands", "4"], options].concat(), b"");
        floats(split(&out).2).chunks(3).map(|p| f64::from(p[1])).collect::<Vec<_>>()
    };
    let reference = y(&["--samples", "4096", "--seed", "9"]);
    for target in [0.1, 0.03] {
        let got = y(&["--error", &target.to_string()]);
        let errors = reference.iter().zip(&got).map(|(a, b)| (b / a - 1.0).powi(2));
        let rms = (errors.sum::<f64>() / got.len() as f64).sqrt();
        assert!(rms < 1.15 * target && rms > 0.1 * target, "asked for {target}, got {rms}");
    }
}

#[test]
fn a_killed_render_goes_on_to_the_same_bytes() {
    let stage = Stage::new(&room(0.5, LAMP));
    let path = stage.path();
    let kept = stage.file("kept");
    let kept = kept.to_str().unwrap();
    let options = ["--width", "400", "--height", "300", "--samples", "16", "--quiet"];
    let whole = stdout_of("spectrace", &[&[path.as_str()], &options[..]].concat(), b"");
    let mut child = std::process::Command::new(program("spectrace"))
        .args([&[path.as_str(), "--checkpoint", kept], &options[..]].concat())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // Killed once some rows are there.
    while fs::metadata(kept).map_or(0, |m| m.len()) < 200_000 {
        assert!(child.try_wait().unwrap().is_none(), "it was done before it was killed");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The last block may be cut anywhere.
    let mut bytes = fs::read(kept).unwrap();
    bytes.truncate(bytes.len() - 1000);
    fs::write(kept, &bytes).unwrap();
    fails(
        "spectrace",
        &[&[path.as_str(), "--checkpoint", kept, "--seed", "2"], &options[..]].concat(),
        b"",
        1,
        "other options",
    );
    let again = stdout_of("spectrace", &[&[path.as_str(), "--checkpoint", kept], &options[..]].concat(), b"");
    assert!(again == whole, "the bytes differ");
    assert!(!stage.file("kept").exists());
    fs::write(stage.file("kept"), "something else").unwrap();
    fails("spectrace", &[&path, "--checkpoint", kept], b"", 1, "is no checkpoint");
}

#[test]
fn time_is_kept_and_told() {
    let stage = Stage::new(&room(0.5, LAMP));
    let path = stage.path();
    let start = std::time::Instant::now();
    let timed = run("spectrace", &[&path, "--split", "2", "--time", "1.5", "--format", "rgbe"], b"");
    let seconds = start.elapsed().as_secs_f64();
    assert!(timed.status.success() && seconds < 6.0, "{seconds} s");
    let note = String::from_utf8(timed.stderr).unwrap();
    let paths = note.split("--samples ").nth(1).unwrap().split(' ').next().unwrap().to_string();
    assert_eq!(
        stdout_of("spectrace", &[&path, "--samples", &paths, "--format", "rgbe", "--split", "2"], b""),
        timed.stdout
    );
}

/// A sphere with a lamp of 1000 lm in its middle: 79.58 lx straight, and as much again from walls of a half.
#[test]
fn points_and_rays_are_answered_line_by_line() {
    let lamp = "[lights.p]\ntype = \"point\"\nspectrum = \"E\"\nposition = [0, 0, 0]\nlumens = 1000\n";
    let text = room(0.5, lamp).replace("radius = 1.5", "radius = 1");
    let stage = Stage::new(&text);
    let input = "# a comment\n0 0 -1 0 0 1\n\n1 0 0 -2 0 0\n";
    let rows = stage.rows(&["--irradiance", "--error", "0.005", "--with-error"], input);
    assert_eq!(rows.len(), 2);
    for row in &rows {
        assert_eq!(row.len(), 5);
        assert!((row[1] - 159.155).abs() < 4.5 * row[3] + 0.1 && row[3] <= 0.0051 * row[1] && row[3] > 0.0, "{row:?}");
    }
    // Radiance of the wall is E rho / pi.
    let rays = stage.rows(&["--rays", "--error", "0.005"], "0.1 0.1 0.1 0 1 0\n");
    assert!((rays[0][1] / (159.155 * 0.5 / std::f64::consts::PI) - 1.0).abs() < 0.03, "{rays:?}");
    // Spectra: 4 bands of an equal-energy lamp are alike.
    let bands =
        stage.rows(&["--irradiance", "--output", "spectrum", "--bands", "4", "--samples", "64"], "0 0 -1 0 0 1\n");
    assert!(bands[0].len() == 4 && bands[0].iter().all(|b| (b / bands[0][0] - 1.0).abs() < 1e-4), "{bands:?}");
    // Raw floats both ways.
    let record: Vec<u8> = [0f32, 0.0, -1.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let raw = stdout_of("spectrace", &[&stage.path(), "--irradiance", "--float", "--samples", "64"], &record);
    let text = stage.rows(&["--irradiance", "--samples", "64"], "0 0 -1 0 0 1\n");
    assert!(floats(&raw).iter().zip(&text[0]).all(|(a, b)| (f64::from(*a) / b - 1.0).abs() < 1e-5));
    let path = stage.path();
    for (options, input, word) in [
        (&["--rays"][..], "0 0 0 0 0 1\n0 0 0 1\n", "line 2: expected six numbers"),
        (&["--rays"], "0 0 0 0 0 0\n", "line 1: expected a point and a direction"),
        (&["--irradiance"], "0 0 0 nan 0 0\n", "line 1: expected a point and a normal"),
        (&["--rays", "--float"], "12345", "cut off"),
    ] {
        let output = run("spectrace", &[&[path.as_str()], options].concat(), input.as_bytes());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && message.contains(word) && message.lines().count() == 1, "{message}");
    }
    fails("spectrace", &[&path, "--float"], b"", 2, "--rays or --irradiance");
    fails("spectrace", &[&path, "--rays", "--time", "1"], b"", 2, "--time");
}

/// Under an open uniform sky of D65 a horizontal point has all daylight there is; D65's own EDI is its lux.
#[test]
fn a_report_says_what_lighting_asks() {
    let sky = "[environment]\ntype = \"uniform\"\nspectrum = \"D65\"\nlux = 1000\n[materials.m]\nreflectance = 0\n\
               [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, -50]\nradius = 1\nmaterial = \"m\"\n";
    let stage = Stage::new(sky);
    let row = &stage.rows(&["--irradiance", "--report", "--samples", "4096"], "0 0 0 0 0 1\n")[0];
    let [lux, cct, duv] = [row[0], row[1], row[2]];
    assert!((lux - 1000.0).abs() < 2.0 && (cct - 6503.0).abs() < 15.0 && (duv - 0.0032).abs() < 2e-4, "{row:?}");
    assert!(row[3..8].iter().all(|edi| (edi / lux - 1.0).abs() < 0.005), "{row:?}");
    assert!((row[8] - 100.0).abs() < 0.2, "{row:?}");
    // With a lamp a daylight factor means nothing.
    let lit = format!("{sky}[lights.p]\ntype = \"point\"\nspectrum = \"A\"\nposition = [0, 0, 3]\ncandela = 1\n");
    assert!(Stage::new(&lit).rows(&["--irradiance", "--report", "--samples", "4"], "0 0 0 0 0 1\n")[0][8].is_nan());
}

/// Walls that reflect everything: light never ends, the run does, and says so.
#[test]
fn a_closed_white_room_is_cut_and_reported() {
    let stage = Stage::new(&room(1.0, LAMP));
    let output = run("spectrace", &[&stage.path(), "--width", "8", "--samples", "1"], b"");
    let note = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && note.contains("were cut after 2048 bounces"), "{note}");
    assert!(floats(split(&output.stdout).2).iter().all(|v| v.is_finite()));
}

/// Geometry where it is touchy: the same picture at 0.1 mm and a thousand kilometres away.
#[test]
fn scale_and_place_do_not_matter() {
    let base = room(0.5, LAMP);
    let at = |unit: f64, shift: f64| {
        let lamp = LAMP.replace("-0.25, -0.25, 0.9", "A").replace("-0.25, 0.25, 0.9", "B");
        let lamp = lamp.replace("0.25, 0.25, 0.9", "C").replace("0.25, -0.25, 0.9", "D");
        let p = |x: f64, y: f64, z: f64| format!("{}, {}, {}", x * unit + shift, y * unit, z * unit);
        let lamp = lamp.replace('A', &p(-0.25, -0.25, 0.9)).replace('B', &p(-0.25, 0.25, 0.9));
        let lamp = lamp.replace('C', &p(0.25, 0.25, 0.9)).replace('D', &p(0.25, -0.25, 0.9));
        let lamp = lamp.replace(&format!("spectrum = \"{}\"", p(-0.25, -0.25, 0.9)), "spectrum = \"A\"");
        room(0.5, &lamp)
            .replace("origin = [0, -0.9, 0]", &format!("origin = [{}]", p(0.0, -0.9, 0.0)))
            .replace("target = [0, 1, 0]", &format!("target = [{}]", p(0.0, 1.0, 0.0)))
            .replace("center = [0, 0, 0]", &format!("center = [{}]", p(0.0, 0.0, 0.0)))
            .replace("radius = 1.5", &format!("radius = {}", 1.5 * unit))
    };
    let mean = |text: &str| {
        let out =
            stdout_of("spectrace", &[&Stage::new(text).path(), "--samples", "32", "--bands", "4", "--quiet"], b"");
        let values = floats(split(&out).2);
        assert!(values.iter().all(|v| *v > 0.0), "a leak or a shadow on itself");
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
    };
    let want = mean(&base);
    for (unit, shift) in [(1e-4, 0.0), (1.0, 1e6), (1e3, 0.0)] {
        let got = mean(&at(unit, shift));
        assert!((got / want - 1.0).abs() < 1e-3, "unit {unit}, shift {shift}: {got} for {want}");
    }
}

/// A lamp of 1e9 that is hidden and one of 1e-3 that is not; a small bright source in a dark room: no fireflies beyond what
/// the error says, and the right mean.
#[test]
fn unequal_lamps_and_a_small_bright_one() {
    let shade = "[materials.black]\nreflectance = 0\n[lights.sun]\nspectrum = \"E\"\nluminance = 1e9\n[[shape]]\ntype = \"sphere\"\n\
                 center = [0.4, 0, 0.9]\nradius = 0.02\nmaterial = \"black\"\nlight = \"sun\"\n[[shape]]\ntype = \"sphere\"\n\
                 center = [0.4, 0, 0.9]\nradius = 0.03\nmaterial = \"black\"\n[lights.glow]\nspectrum = \"E\"\nluminance = 1e-3\n\
                 [[shape]]\ntype = \"sphere\"\ncenter = [-0.4, 0, 0.9]\nradius = 0.05\nmaterial = \"black\"\nlight = \"glow\"\n";
    let stage = Stage::new(&room(0.2, shade).replace("radius = 1.5", "radius = 100"));
    let e = stage.rows(&["--irradiance", "--error", "0.02", "--with-error"], "-0.4 0 -1 0 0 1\n");
    // pi L (r / d)^2 from the front of the ball, and next to nothing from walls a hundred metres away.
    let want = std::f64::consts::PI * 1e-3 * (0.05f64 / 1.9).powi(2);
    assert!((e[0][1] - want).abs() < 4.5 * e[0][3] + 0.01 * want, "{e:?} for {want}");
    let bright = "[materials.black]\nreflectance = 0\n[lights.led]\nspectrum = \"E\"\nlumens = 1000\n[[shape]]\ntype = \"sphere\"\n\
                  center = [0.2, 0.1, 0.3]\nradius = 0.001\nmaterial = \"black\"\nlight = \"led\"\n";
    let stage = Stage::new(&room(0.05, bright).replace("radius = 1.5", "radius = 1"));
    let e = stage.rows(&["--irradiance", "--error", "0.005", "--with-error"], "0 0 -1 0 0 1\n");
    let to = [0.2f64, 0.1, 1.3];
    let d2: f64 = to.iter().map(|x| x * x).sum();
    let want = 79.5775 * to[2] / d2.powf(1.5) + 79.5775 * 0.05 / 0.95;
    assert!((e[0][1] - want).abs() < 4.5 * e[0][3] + 0.002 * want, "{e:?} for {want}");
}

/// A mesh of a closed ball with a camera inside: no ray finds a gap between its triangles.
#[test]
fn closed_meshes_leak_no_light() {
    let mut obj = String::new();
    let (rings, sectors) = (24, 48);
    for i in 0..=rings {
        for k in 0..sectors {
            let (t, p) = (
                std::f64::consts::PI * f64::from(i) / f64::from(rings),
                std::f64::consts::TAU * f64::from(k) / f64::from(sectors),
            );
            obj += &format!("v {} {} {}\n", t.sin() * p.cos(), t.sin() * p.sin(), t.cos());
        }
    }
    for i in 0..rings {
        for k in 0..sectors {
            let at = |i: i32, k: i32| i * sectors + k % sectors + 1;
            let (a, b, c, d) = (at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
            obj += &if i == 0 {
                format!("f {a} {d} {c}\n")
            } else if i == rings - 1 {
                format!("f {a} {d} {b}\n")
            } else {
                format!("f {a} {d} {c} {b}\n")
            };
        }
    }
    let text = "[camera]\ntype = \"panorama\"\norigin = [0, 0, 0]\ntarget = [0, 1, 0]\nup = [0, 0, 1]\nwidth = 512\n[materials.m]\nreflectance = 0\n\
                [environment]\nspectrum = \"E\"\nluminance = 1\n[[shape]]\ntype = \"mesh\"\nfile = \"ball.obj\"\nmaterial = \"m\"\n";
    let stage = Stage::new(text);
    fs::write(stage.file("ball.obj"), obj).unwrap();
    let out = stdout_of("spectrace", &[&stage.path(), "--samples", "16", "--bands", "1", "--quiet"], b"");
    assert!(floats(split(&out).2).iter().all(|v| *v == 0.0), "light comes through");
}

/// An index of 1 is not there; a smooth coat or metal is the limit of a rough one.
#[test]
fn limits_of_materials() {
    let text = "[materials.air]\ntype = \"dielectric\"\nindex = 1\n[materials.pane]\ntype = \"glass\"\nindex = 1\n\
                [materials.smooth]\ntype = \"conductor\"\nmetal = \"Au\"\n[materials.nearly]\ntype = \"conductor\"\nmetal = \"Au\"\nroughness = 0.0012\n";
    let stage = Stage::new(text);
    let probe = |name: &str| {
        let out = stdout_of(
            "specprobe",
            &[&stage.path(), "--material", name, "--angles", "0,60,89.9", "--wavelengths", "450,650"],
            b"",
        );
        let text = String::from_utf8(out).unwrap();
        let rows = text.lines().skip(1);
        rows.map(|l| l.split('\t').map(|w| w.parse().unwrap()).collect::<Vec<f64>>()).collect::<Vec<_>>()
    };
    for name in ["air", "pane"] {
        assert!(probe(name).iter().all(|r| r[2].abs() < 1e-5 && (r[3] - 1.0).abs() < 1e-5), "{name}");
    }
    for (a, b) in probe("smooth").iter().zip(probe("nearly")).take(4) {
        assert!((a[2] - b[2]).abs() < 5e-3, "{a:?} {b:?}");
    }
    // A camera inside glass under a sky of 1 sees n^2.
    let inside = "[environment]\nspectrum = \"E\"\nluminance = 1\n[materials.g]\ntype = \"dielectric\"\nindex = 1.5\n\
                  [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"g\"\n";
    let rows = Stage::new(inside).rows(&["--rays", "--samples", "512"], "0 0 0 0 0 1\n0.2 0 0.1 1 1 0\n");
    assert!(rows.iter().all(|r| (r[1] - 2.25).abs() < 0.02), "{rows:?}");
    fails("specprobe", &[&stage.path(), "--material", "none"], b"", 2, "the scene has air, nearly, pane, smooth");
    fails("specprobe", &[&stage.path(), "--material", "air", "--angles", "90"], b"", 2, "--angles");
}

/// The pictures of the projections lie where Radiance's views have them.
#[test]
fn cameras_say_their_view() {
    for (kind, word) in [
        ("type = \"fisheye\"", "-vta"),
        ("type = \"hemispherical\"", "-vth"),
        ("type = \"planispheric\"", "-vts"),
        ("type = \"cylinder\"\nheight = 12", "-vtc"),
        ("type = \"panorama\"", "latlong"),
        ("type = \"parallel\"\nwidth_seen = 2", "-vtl"),
        ("fov_deg = 60\nlens_radius = 0.05\nfocus = 1", "-vtv"),
    ] {
        let text = room(0.5, LAMP).replace("fov_deg = 70\nwidth = 40\nheight = 30", &format!("{kind}\nwidth = 48"));
        let out =
            stdout_of("spectrace", &[&Stage::new(&text).path(), "--samples", "2", "--bands", "2", "--quiet"], b"");
        let (lines, _, pixels) = split(&out);
        assert!(lines.iter().any(|l| l.contains(word)), "{kind}: {lines:?}");
        assert!(floats(pixels).iter().any(|v| *v > 0.0), "{kind}");
    }
    let scene = root().join("scenes/cornell.toml");
    assert!(scene.exists());
}

#[test]
fn faults_of_scenes_name_their_place() {
    let quad = "[[shape]]\ntype = \"quad\"\npoints = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nmaterial = \"m\"\n";
    let m = "[materials.m]\nreflectance = 0.5\n";
    for (text, word) in [
        (format!("{m}{quad}[lights.l]\ntype = \"laser\"\n"), "no light 'laser'; there are area, point, spot, ies, sun"),
        (
            format!("{m}{quad}[lights.l]\ntype = \"point\"\nspectrum = \"E\"\nposition = [0,0,1]\n"),
            "give one of candela, lumens",
        ),
        (
            format!("{m}{quad}[environment]\ntype = \"cie\"\nsky = 16\nsun = [0,0,1]\n"),
            "sky: 16 must be a whole number from 1 to 15",
        ),
        (format!("{m}{quad}[environment]\ntype = \"clear\"\nturbidity = 3\nsun = [0,0,-1]\n"), "sun"),
        (format!("{m}{quad}[environment]\ntype = \"picture\"\nfile = \"none.hdr\"\n"), "none.hdr"),
        (format!("[materials.m]\ntype = \"velvet\"\n{quad}"), "no material 'velvet'; there are diffuse, conductor"),
        (format!("[materials.m]\ntype = \"conductor\"\nmetal = \"Pt\"\n{quad}"), "expected Ag, Al, Au or Cu"),
        (format!("[materials.m]\ntype = \"glass\"\nindex = 0.9\n{quad}"), "index: 0.9 must lie in 1 to 4"),
        (format!("[materials.m]\ntype = \"mixture\"\nof = [\"a\"]\nshares = [1.0]\n{quad}"), "no material 'a'"),
        (
            format!(
                "{m}{quad}[materials.a]\ntype = \"mixture\"\nof = [\"m\"]\nshares = [1.0]\n[materials.b]\ntype = \"mixture\"\nof = [\"a\"]\nshares = [1.0]\n"
            ),
            "no material 'a' that is not a mixture",
        ),
        (format!("{m}[[shape]]\ntype = \"instance\"\ngroup = \"g\"\n"), "group"),
        (format!("{m}[[shape]]\ntype = \"torus\"\nmaterial = \"m\"\n"), "no shape 'torus'"),
        (format!("{m}[[shape]]\ntype = \"mesh\"\nfile = \"bad.obj\"\nmaterial = \"m\"\n"), "face 2 (line 5)"),
    ] {
        let stage = Stage::new(&text);
        fs::write(stage.file("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n").unwrap();
        fails("spectrace", &[&stage.path(), "--irradiance"], b"", 1, word);
    }
}

/// Every thread that is asked for works: the clock ticks of each, read while the program runs.
#[cfg(target_os = "linux")]
#[test]
fn all_threads_work() {
    let stage = Stage::new(&room(0.5, LAMP));
    let mut child = std::process::Command::new(program("spectrace"))
        .args([&stage.path(), "--quiet", "--threads", "3", "--time", "3"])
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let tasks = format!("/proc/{}/task", child.id());
    let ticks = |task: fs::DirEntry| {
        let stat = fs::read_to_string(task.path().join("stat")).unwrap_or_default();
        let after_name = stat.rsplit(')').next().unwrap_or_default().to_string();
        after_name.split_whitespace().nth(11).and_then(|t| t.parse::<u64>().ok()).unwrap_or(0)
    };
    let mut working = 0;
    while child.try_wait().unwrap().is_none() {
        let now = fs::read_dir(&tasks).map_or(0, |all| all.flatten().map(ticks).filter(|t| *t >= 5).count());
        working = working.max(now);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(child.wait().unwrap().success());
    assert!(working >= 3, "{working} of 3 threads worked");
}

const LOCAL: [&str; 3] = ["--method", "local", "--quiet"];

/// In a sphere interreflected light is the same everywhere, and local illumination exact.
#[test]
fn local_illumination_is_exact_in_a_sphere() {
    let lamp = "[lights.p]\ntype = \"point\"\nspectrum = \"E\"\nlumens = 1000\nposition = [0, 0, 0]\n";
    for rho in [0.2, 0.8] {
        let scene = room(rho, lamp);
        let stage = Stage::new(&scene[scene.find("[materials").unwrap()..]);
        let rows = stage
            .rows(&[&LOCAL[..], &["--irradiance", "--samples", "64"]].concat(), "0 0 -1.5 0 0 1\n0 1.5 0 0 -1 0\n");
        // 1000 lm on 4 pi R^2, and rho / (1 - rho) times that from the wall.
        let want = 1000.0 / (4.0 * std::f64::consts::PI * 2.25) / (1.0 - rho);
        for row in rows {
            assert!((row[1] / want - 1.0).abs() < 0.005, "reflectance {rho}: {} for {want}", row[1]);
        }
    }
}

#[test]
fn local_illumination_without_its_constant_is_direct_light() {
    let block =
        "[[shape]]\ntype = \"disk\"\ncenter = [0.2, 0, 0.5]\nnormal = [0, 0, 1]\nradius = 0.25\nmaterial = \"wall\"\n";
    let stage = Stage::new(&room(0.6, &format!("{LAMP}{block}")));
    let points = "0 0 -1 0 0 1\n0.5 0.2 -0.8 0 0 1\n0.3 0 0.45 0 0 1\n-0.6 0 0 1 0 0\n";
    let ask = |more: &[&str]| stage.rows(&[more, &["--irradiance", "--samples", "4096", "--quiet"]].concat(), points);
    let direct = ask(&["--method", "local", "--ambient", "0"]);
    // A path of no bounce that falls on a point has met a lamp.
    let paths = ask(&["--max-bounces", "0"]);
    let open = ask(&["--method", "local", "--ambient", "0", "--no-shadows"]);
    let ambient = ask(&["--method", "local", "--ambient", "10"]);
    for i in 0..4 {
        let (d, p) = (direct[i][1], paths[i][1]);
        assert!((d - p).abs() < 0.01 * p + 1e-6, "point {i}: {d} for {p}");
        assert!(open[i][1] >= d * 0.999, "point {i}");
        let constant = ambient[i][1] - d;
        assert!((constant - 10.0 * std::f64::consts::PI).abs() < 0.01, "point {i}: {constant}");
    }
    assert!(direct[2][1] == 0.0 && open[2][1] > 100.0, "{direct:?}");
}

#[test]
fn local_illumination_reflects_the_sky_and_sees_through_panes() {
    let scene = "[environment]\nspectrum = \"E\"\nluminance = 100\n[materials.m]\ntype = \"mirror\"\nreflectance = 0.9\n\
                 [materials.g]\ntype = \"glass\"\n[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 5\n\
                 material = \"m\"\n[[shape]]\ntype = \"disk\"\ncenter = [20, 0, 0]\nnormal = [0, 0, 1]\nradius = 5\nmaterial = \"g\"\n";
    let stage = Stage::new(scene);
    let rays = "0.1 0.2 3 0 0 -1\n20.1 0.2 3 0 0 -1\n";
    let of = |more: &[&str]| stage.rows(&[&["--rays", "--samples", "16", "--quiet"], more].concat(), rays);
    let (paths, local) = (of(&[]), of(&["--method", "local"]));
    assert!((local[0][1] - 90.0).abs() < 0.01, "{local:?}");
    // A pane reflects and passes a sky of 100 on: all but a little.
    assert!((local[1][1] - paths[1][1]).abs() < 0.01 * paths[1][1], "{local:?} {paths:?}");
    let dull = of(&["--method", "local", "--no-reflections", "--ambient", "0"]);
    assert_eq!(dull[0][1], 0.0);
}

#[test]
fn local_illumination_says_what_it_stands_for() {
    let stage = Stage::new(&room(0.5, LAMP));
    let path = stage.path();
    let out = run("spectrace", &[&path, "--method", "local", "--samples", "2"], b"");
    let said = String::from_utf8(out.stderr).unwrap();
    assert!(said.contains("keeps the balance") && said.contains("strong interreflection"), "{said}");
    let whole = stdout_of("spectrace", &[&[path.as_str(), "--samples", "3"], &LOCAL[..]].concat(), b"");
    let one = stdout_of("spectrace", &[&[path.as_str(), "--samples", "3", "--threads", "1"], &LOCAL[..]].concat(), b"");
    assert!(whole == one);
    fails("spectrace", &[&path, "--method", "local", "--split", "2"], b"", 2, "--method path");
    fails("spectrace", &[&path, "--ambient", "3"], b"", 2, "--method local");
    fails("spectrace", &[&path, "--method", "local", "--ambient", "-1"], b"", 2, "auto");
    fails("spectrace", &[&path, "--error", "0.1", "--samples", "8"], b"", 2, "at least 32");
    fails("spectrace", &[&path, "--report"], b"", 2, "--irradiance");
}

/// Pictures that a scene names are read as any other is: what lies behind their pixels is told.
#[test]
fn odd_pictures_of_a_scene_are_told_of() {
    let (mut whole, light) = (
        b"PF\n2 1\n-1\n".to_vec(),
        "[lights.l]\ntype = \"point\"\nspectrum = \"E\"\nposition = [0, 0, 1]\ncandela = 1\n",
    );
    [0.25f32, 0.5, 0.5, 0.5, 0.25, 0.5].iter().for_each(|v| whole.extend(v.to_le_bytes()));
    let odd = [&whole[..], b"trail"].concat();
    let rest = "[camera]\norigin = [0, 0, 2]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_deg = 40\nwidth = 2\n[[shape]]\ntype = \"quad\"\n\
                points = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]\nmaterial = \"m\"\n";
    let texture = "[materials.m]\ntexture = { type = \"picture\", file = \"p.pfm\" }\n";
    let sky = "[materials.m]\nreflectance = 0.5\n[environment]\ntype = \"picture\"\nfile = \"p.pfm\"\n";
    for text in [texture, sky] {
        let stage = Stage::new(&format!("{text}{light}{rest}"));
        for (bytes, told) in [(&whole, false), (&odd, true)] {
            fs::write(stage.file("p.pfm"), bytes).unwrap();
            let done = run("spectrace", &[&stage.path(), "--samples", "1"], b"");
            let said = String::from_utf8(done.stderr).unwrap();
            assert!(done.status.success() && said.contains("5 bytes after the last row") == told, "{said}");
        }
    }
}
