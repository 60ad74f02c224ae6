//! Lamps, skies, textures and placed shapes through the real program, each against a closed form.

mod common;

use std::f64::consts::PI;
use std::fs;

use common::{data_path, stdout_of, stream};

const BALL: &str = "[materials.m]\nreflectance = 0\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, -3]\nradius = 0.5\nmaterial = \"m\"\n";

/// XYZ for each line.
fn answers(folder: &tempfile::TempDir, scene: &str, options: &[&str], lines: &str) -> Vec<[f64; 3]> {
    let path = folder.path().join("s.toml");
    fs::write(&path, scene).unwrap();
    let out = stdout_of("spectrace", &[&[path.to_str().unwrap()], options].concat(), lines.as_bytes());
    let text = String::from_utf8(out).unwrap();
    let row = |l: &str| l.split('\t').map(|w| w.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
    text.lines().map(row).collect()
}

fn lux(scene: &str, lines: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    answers(&folder, scene, &["--irradiance", "--samples", "4096"], lines).iter().map(|a| a[1]).collect()
}

fn near(got: f64, want: f64, rel: f64) {
    assert!((got - want).abs() <= rel * want.abs(), "{got} for {want}");
}

#[test]
fn points_spots_and_luminaires() {
    let at = "position = [0, 0, 3]\ndirection = [0, 0, -1]\nspectrum = \"A\"\n";
    let under = "0 0 0 0 0 1\n1 0 0 0 0 1\n4 0 0 0 0 1\n";
    let e = lux(
        &format!("{BALL}[lights.p]\ntype = \"point\"\nspectrum = \"A\"\nposition = [0, 0, 3]\nlumens = 1000\n"),
        under,
    );
    near(e[0], 8.842, 1e-4); // 79.577 cd at 3 m
    let e = lux(&format!("{BALL}[lights.s]\ntype = \"spot\"\n{at}field_deg = 60\nlumens = 1000\n"), under);
    near(e[0], 1000.0 / (2.0 * PI * (1.0 - 30f64.to_radians().cos())) / 9.0, 1e-4);
    assert_eq!(e[2], 0.0);
    // A Lambertian luminaire of 1000 lm: 1000 / pi cd straight down, the cosine beside.
    let ies = data_path("ies/lambertian.ies");
    let e = lux(&format!("{BALL}[lights.i]\ntype = \"ies\"\n{at}file = {ies:?}\n"), under);
    near(e[0], 1000.0 / PI / 9.0, 2e-3);
    near(e[1], 1000.0 / PI * 9.0 / 100.0, 5e-3);
    let e = lux(&format!("{BALL}[lights.i]\ntype = \"ies\"\n{at}file = {ies:?}\nlumens = 500\n"), under);
    near(e[0], 500.0 / PI / 9.0, 2e-3);
}

/// Preetham's sky and sun at 30 degrees, turbidity 3: 24.0 and 33.3 klx (docs/lighting.md, where they are checked apart).
#[test]
fn clear_skies_and_their_sun() {
    let sun = "[0.8660254037844386, 0, 0.5]";
    let up = "0 0 0 0 0 1\n";
    let e = lux(&format!("{BALL}[environment]\ntype = \"clear\"\nturbidity = 3\nsun = {sun}\n"), up);
    near(e[0], 24.0e3, 5e-3);
    let e = lux(&format!("{BALL}[lights.sun]\ntype = \"sun\"\ndirection = {sun}\nturbidity = 3\n"), up);
    near(e[0], 33.3e3, 5e-3);
    let e =
        lux(&format!("{BALL}[lights.sun]\ntype = \"sun\"\ndirection = {sun}\nspectrum = \"D65\"\nlux = 100000\n"), up);
    near(e[0], 50e3, 1e-4);
    // Panes in between: what glass of 6 mm lets through at 60 degrees.
    let pane = "[materials.g]\ntype = \"glass\"\ndepth = 0.03\n[[shape]]\ntype = \"quad\"\nmaterial = \"g\"\n\
                points = [[-9, -9, 1], [9, -9, 1], [9, 9, 1], [-9, 9, 1]]\n";
    let e = lux(
        &format!("{BALL}{pane}[lights.sun]\ntype = \"sun\"\ndirection = {sun}\nspectrum = \"D65\"\nlux = 100000\n"),
        up,
    );
    near(e[0], 50e3 * 0.8124218, 2e-4);
}

/// A sky by date and place is that of the sun's direction then; with the sun on the horizon it is finite, below it there is no light.
#[test]
fn skies_by_date_and_place() {
    let up = "0 0 0 0 0 1\n";
    let at =
        |time: &str, north: &str| format!("{{ date = {time}, latitude = 39.742476, longitude = -105.1786{north} }}");
    let sky = |sun: &str| lux(&format!("{BALL}[environment]\ntype = \"clear\"\nturbidity = 3\nsun = {sun}\n"), up)[0];
    let sun = |sun: &str, normal: &str| {
        let light = format!("{BALL}[lights.sun]\ntype = \"sun\"\ndirection = {sun}\nturbidity = 3\n");
        lux(&light, &format!("0 0 0 {normal}\n"))[0]
    };
    // NREL's example: 50.11 degrees from the zenith, 194.34 from north by east.
    let (zenith, azimuth) = (50.127f64.to_radians(), 194.34f64.to_radians());
    let [e, n, u] = [zenith.sin() * azimuth.sin(), zenith.sin() * azimuth.cos(), zenith.cos()];
    let noon = at("2003-10-17T12:30:30-07:00", "");
    near(sky(&noon), sky(&format!("[{e}, {n}, {u}]")), 1e-3);
    let facing = sun(&noon, &format!("{e} {n} {u}"));
    near(sun(&noon, "0 0 1") / facing, u, 1e-3);
    near(sun(&noon, "0 -1 0") / facing, -n, 1e-3);
    // +x is north: what was south is -x.
    let turned = at("2003-10-17T12:30:30-07:00", ", north = [1, 0, 0]");
    near(sun(&turned, "-1 0 0") / facing, -n, 1e-3);
    let rising = sky(&at("2003-10-17T06:25:00-07:00", ""));
    // Preetham's low suns do not fall off as dusk does (docs/lighting.md: 17 klx at 5 degrees), but they are finite.
    assert!(rising > 100.0 && rising < 12e3, "{rising} lx at sunrise");
    let night = at("2003-10-17T23:00:00-07:00", "");
    // A lamp of 79.577 cd at 3 m is all there is then.
    let lamp = "[lights.p]\ntype = \"point\"\nspectrum = \"A\"\nposition = [0, 0, 3]\nlumens = 1000\n";
    let dark = format!(
        "{BALL}{lamp}[environment]\ntype = \"clear\"\nturbidity = 3\nsun = {night}\n[lights.sun]\ntype = \"sun\"\ndirection = {night}\nturbidity = 3\n"
    );
    near(lux(&dark, up)[0], 8.842, 1e-4);
    let scene = |sun: &str| format!("{BALL}[environment]\ntype = \"clear\"\nturbidity = 3\nsun = {sun}\n");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    for (sun, word) in [
        ("{ date = 2003-10-17T12:30:30, latitude = 0, longitude = 0 }", "offset from UTC"),
        ("{ date = 2003-10-17T12:30:30Z, latitude = 91, longitude = 0 }", "-90 to 90"),
        ("{ date = 2003-10-17T12:30:30Z, latitude = 0 }", "longitude"),
        ("{ date = 2003-10-17T12:30:30Z, latitude = 0, longitude = 0, height = 3 }", "height"),
        ("{ date = 1803-10-17T12:30:30Z, latitude = 0, longitude = 0 }", "1950 to 2050"),
        ("{ date = 2003-10-17T12:30:30Z, latitude = 0, longitude = 0, north = [0, 0, 1] }", "north"),
    ] {
        fs::write(&path, scene(sun)).unwrap();
        common::fails("spectrace", &["--irradiance", path.to_str().unwrap()], up.as_bytes(), 1, word);
    }
}

/// A panorama whose right half shines: a surface that faces right gets pi L of its colour, one that faces left nothing.
#[test]
fn panoramas_shine_in_their_colours() {
    let folder = tempfile::tempdir().unwrap();
    let xyz = [30.0f32, 20.0, 40.0];
    let pixels: Vec<f32> = (0..64 * 32).flat_map(|i| if i % 64 < 32 { [0.0; 3] } else { xyz }).collect();
    let lines = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.3290";
    fs::write(folder.path().join("sky.lux"), stream(lines, "-Y 32 +X 64", &pixels)).unwrap();
    let scene = format!("{BALL}[environment]\ntype = \"picture\"\nfile = \"sky.lux\"\nmiddle = [0, 1, 0]\nscale = 2\n");
    let got = answers(&folder, &scene, &["--irradiance", "--samples", "16384"], "0 0 0 1 0 0\n0 0 0 -1 0 0\n");
    for (got, want) in got[0].iter().zip(xyz) {
        near(*got, 2.0 * PI * f64::from(want), 5e-3);
    }
    assert!(got[1][1].abs() < 1e-3, "{:?}", got[1]);
    let rays = answers(&folder, &scene, &["--rays", "--samples", "1"], "0 0 0 1 1 0.2\n0 0 0 -1 1 0.2\n");
    near(rays[0][1], 40.0, 1e-3);
    assert_eq!(rays[1][1], 0.0);
}

/// Radiance of matt surfaces under a sky of 1: their reflectance, wherever they were put.
#[test]
fn placed_groups_and_textures() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.ply"), "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float red\nproperty float green\nproperty float blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 0.6 0.6 0.6\n1 0 0 0.6 0.6 0.6\n0 1 0 0.6 0.6 0.6\n3 0 1 2\n").unwrap();
    let scene = "[environment]\nspectrum = \"E\"\nluminance = 1\n[materials.half]\nreflectance = 0.5\n[materials.third]\nreflectance = 0.3\n\
        [materials.check]\ntexture = { type = \"checker\", values = [0.2, 0.8], size = 1, space = \"place\" }\n[materials.vertex]\ntexture = \"vertex\"\n\
        [[group]]\nname = \"tile\"\n[[group.shape]]\ntype = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 1\nmaterial = \"half\"\n\
        [[shape]]\ntype = \"instance\"\ngroup = \"tile\"\ntranslate = [10, 0, 0]\n\
        [[shape]]\ntype = \"instance\"\ngroup = \"tile\"\nscale = [-3, 1, 1]\nrotate = [0, 0, 1, 90]\ntranslate = [20, 0, 0]\nmaterial = \"third\"\n\
        [[shape]]\ntype = \"quad\"\npoints = [[30, 0, 0], [34, 0, 0], [34, 4, 0], [30, 4, 0]]\nmaterial = \"check\"\n\
        [[shape]]\ntype = \"mesh\"\nfile = \"c.ply\"\nscale = 2\ntranslate = [40, 0, 0]\nmaterial = \"vertex\"\n\
        [[shape]]\ntype = \"cylinder\"\nbase = [50, 0, -1]\ntop = [50, 0, 1]\nradius = 0.5\nmaterial = \"half\"\n";
    let down = |x: f64, y: f64| format!("{x} {y} 5 0 0 -1\n");
    let lines = [
        down(10.5, 0.2),
        down(11.5, 0.0),
        down(20.0, 2.5),
        down(22.5, 0.0),
        down(30.5, 0.5),
        down(31.5, 0.5),
        down(40.5, 0.5),
        "55 0 0 -1 0 0\n".into(),
    ]
    .concat();
    let got = answers(&folder, scene, &["--rays", "--samples", "1024"], &lines);
    // sRGB's red, green and blue sum to 1 as closely as their tables do, and end at 380 and 780 nm.
    for (got, want) in got.iter().zip([0.5, 1.0, 0.3, 1.0, 0.2, 0.8, 0.6, 0.5]) {
        near(got[1], want, 3e-3);
    }
}

/// A faceted ball with smooth normals is lit as a ball is, within what its outline differs.
#[test]
fn smooth_normals_light_as_the_true_surface() {
    let folder = tempfile::tempdir().unwrap();
    let (rings, sectors) = (24, 48);
    let mut obj = String::new();
    for i in 0..=rings {
        for k in 0..sectors {
            let (t, p) = (PI * f64::from(i) / f64::from(rings), 2.0 * PI * f64::from(k) / f64::from(sectors));
            obj += &format!("v {} {} {}\n", t.sin() * p.cos(), t.sin() * p.sin(), t.cos());
        }
    }
    for i in 1..rings - 1 {
        for k in 0..sectors {
            let at = |i: i32, k: i32| i * sectors + k % sectors + 1;
            obj += &format!("f {} {} {} {}\n", at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
        }
    }
    fs::write(folder.path().join("ball.obj"), obj).unwrap();
    let lamp = "[lights.s]\ntype = \"sun\"\nspectrum = \"E\"\nlux = 3.14159265\ndirection = [0.6, -0.8, 0]\ndiameter_deg = 0.01\n[materials.w]\nreflectance = 1\n";
    let lines: String =
        (0..40).map(|i| format!("{} -5 {} 0 1 0\n", 0.021 * f64::from(i) - 0.3, 0.013 * f64::from(i) - 0.2)).collect();
    let look = |shape: &str| {
        answers(&folder, &format!("{lamp}{shape}"), &["--rays", "--samples", "8", "--max-bounces", "1"], &lines)
    };
    let ball = look("[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"w\"\n");
    let mesh = |more: &str| look(&format!("[[shape]]\ntype = \"mesh\"\nfile = \"ball.obj\"\nmaterial = \"w\"\n{more}"));
    let worst = |other: &[[f64; 3]]| ball.iter().zip(other).map(|(a, b)| (b[1] / a[1] - 1.0).abs()).fold(0.0, f64::max);
    let (smooth, flat) = (worst(&mesh("smooth_deg = 180\n")), worst(&mesh("")));
    assert!(smooth < 0.01 && flat > 0.03, "smooth {smooth}, flat {flat}");
}

/// Radiance's materials mean here what they mean there (tests/ref/radiance_materials.csv).
#[test]
fn materials_of_radiance_are_radiances() {
    let text = fs::read_to_string(common::root().join("tests/ref/radiance_materials.csv")).unwrap();
    let lines = text.lines().filter(|l| !l.starts_with('#') && !l.starts_with("material"));
    let rows: Vec<Vec<&str>> = lines.map(|l| l.split(',').collect()).collect();
    assert!(rows.len() > 50);
    let folder = tempfile::tempdir().unwrap();
    let mut rest = &rows[..];
    while let Some(first) = rest.first() {
        let n = rest.iter().take_while(|r| r[..7] == first[..7]).count();
        let (some, after) = rest.split_at(n);
        rest = after;
        let sun: f64 = first[6].parse().unwrap();
        let (up, across) = sun.to_radians().sin_cos();
        let extra = if first[0] == "trans" {
            format!("transmitted = {}\ntransmitted_specular = {}\n", first[4], first[5])
        } else {
            String::new()
        };
        let scene = format!(
            "[lights.s]\ntype = \"sun\"\nspectrum = \"E\"\nlux = 1\ndirection = [{across}, 0, {up}]\ndiameter_deg = 0.5\n[materials.m]\ntype = \"{}\"\nreflectance = {}\nspecular = {}\nroughness = {}\n{extra}[[shape]]\ntype = \"quad\"\npoints = [[-100, -100, 0], [100, -100, 0], [100, 100, 0], [-100, 100, 0]]\nmaterial = \"m\"\n",
            first[0], first[1], first[2], first[3]
        );
        let view = |r: &Vec<&str>| {
            let (z, x) = r[7].parse::<f64>().unwrap().to_radians().sin_cos();
            format!("{} 0 {} {x} 0 {}\n", -5.0 * x, 5.0 * z, -z)
        };
        let lines: String = some.iter().map(view).collect();
        let got =
            answers(&folder, &scene, &["--rays", "--samples", "16384", "--bands", "2", "--max-bounces", "1"], &lines);
        for (row, got) in some.iter().zip(got) {
            let want: f64 = row[8].parse().unwrap();
            assert!((got[1] - want).abs() < 6e-3 * want, "{row:?}: {}", got[1]);
        }
    }
}
