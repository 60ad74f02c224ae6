//! Radiosity and photon map through the real programs: closed forms, parts, kept solutions, and where they fail.

mod common;

use std::fs;
use std::path::PathBuf;

use common::{fails, run, split, stdout_of};

const METHODS: [&str; 2] = ["radiosity", "photon"];

/// A folder with a scene.
struct Stage(tempfile::TempDir);

impl Stage {
    fn new(scene: &str) -> Stage {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        Stage(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn path(&self) -> String {
        self.file("scene.toml").display().to_string()
    }

    /// Illuminances of points.
    fn lux(&self, args: &[&str], points: &str) -> Vec<f64> {
        let path = self.path();
        let all = [&[path.as_str(), "--irradiance", "--quiet"], args].concat();
        let out = String::from_utf8(stdout_of("spectrace", &all, points.as_bytes())).unwrap();
        out.lines().map(|l| l.split('\t').nth(1).unwrap().trim().parse().unwrap()).collect()
    }
}

fn quad(points: [[f64; 3]; 4], material: &str, rest: &str) -> String {
    format!("[[shape]]\ntype = \"quad\"\npoints = {points:?}\nmaterial = \"{material}\"\n{rest}\n")
}

/// A closed box: walls, floor and ceiling of materials `wall`, `floor`, `ceiling`; the ceiling shines with exitance 100.
fn closed(size: [f64; 3], rho: [f64; 3]) -> String {
    let [a, b, c] = size;
    let mut text = String::from("[lights.l]\nspectrum = \"E\"\nluminance = 31.830988618379067\n");
    for (name, rho) in ["wall", "floor", "ceiling"].iter().zip(rho) {
        text += &format!("[materials.{name}]\nreflectance = {rho}\n");
    }
    text += &quad([[0.0, 0.0, 0.0], [a, 0.0, 0.0], [a, b, 0.0], [0.0, b, 0.0]], "floor", "");
    text += &quad([[0.0, 0.0, c], [0.0, b, c], [a, b, c], [a, 0.0, c]], "ceiling", "light = \"l\"");
    text += &quad([[0.0, 0.0, 0.0], [0.0, b, 0.0], [0.0, b, c], [0.0, 0.0, c]], "wall", "");
    text += &quad([[a, 0.0, 0.0], [a, 0.0, c], [a, b, c], [a, b, 0.0]], "wall", "");
    text += &quad([[0.0, 0.0, 0.0], [0.0, 0.0, c], [a, 0.0, c], [a, 0.0, 0.0]], "wall", "");
    text + &quad([[0.0, b, 0.0], [a, b, 0.0], [a, b, c], [0.0, b, c]], "wall", "")
}

const CAMERA: &str =
    "[camera]\norigin = [2, 0.5, 1.5]\ntarget = [2, 4, 1]\nup = [0, 0, 1]\nfov_deg = 60\nwidth = 12\nheight = 8\n";

/// With one element a wall the exact six-by-six solution of the cases radiosity-cube-A and radiosity-room-C comes out, which is not
/// the truth: mean radiosities of wall, floor, ceiling.
#[test]
fn one_element_a_wall_is_the_six_by_six_solution() {
    let cases = [
        ([1.0, 1.0, 1.0], [0.5, 0.5, 0.5], [0.18183627, 0.18174583, 1.0909091 - 1.0], 100.0),
        ([4.0, 4.0, 3.0], [0.5, 0.2, 0.7], [19.525801, 9.1120374, 111.60704 - 100.0], 1.0),
    ];
    for (size, rho, radiosities, scale) in cases {
        let [a, b, c] = size;
        let stage = Stage::new(&closed(size, rho));
        let (x, y, z) = (a / 2.0, b / 2.0, c / 2.0);
        let points = format!("0 {y} {z} 1 0 0\n{x} {y} 0 0 0 1\n{x} {y} {c} 0 0 -1\n");
        let options =
            ["--method", "radiosity", "--show", "mesh", "--divide", "1", "--element-rays", "65535", "--bands", "4"];
        let got = stage.lux(&[&options[..], &["--samples", "1"]].concat(), &points);
        for i in 0..3 {
            let want = scale * radiosities[i] / rho[i];
            assert!((got[i] / want - 1.0).abs() < 0.005, "{size:?}, {i}: {} for {want}", got[i]);
        }
    }
}

/// Light hardly ends at a reflectance of 0.99, and yet a few steps find all of it.
#[test]
fn a_white_sphere_converges() {
    let scene = "[lights.p]\ntype = \"point\"\nspectrum = \"E\"\nlumens = 1000\nposition = [0, 0, 0]\n[materials.w]\nreflectance = 0.99\n\
                 [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.5\ninward = true\nmaterial = \"w\"\n";
    let stage = Stage::new(scene);
    let want = 1000.0 / (4.0 * std::f64::consts::PI * 2.25) / 0.01;
    let got =
        stage.lux(&["--method", "radiosity", "--bands", "4", "--samples", "16"], "0 0 -1.5 0 0 1\n0.2 0 0 1 0 0\n");
    for lux in got {
        assert!((lux / want - 1.0).abs() < 0.01, "{lux} for {want}");
    }
    let out =
        run("spectrace", &[&stage.path(), "--irradiance", "--method", "radiosity", "--bands", "4"], b"0 0 0 0 0 1\n");
    let said = String::from_utf8(out.stderr).unwrap();
    assert!(said.contains("residual") && !said.contains("did not converge"), "{said}");
}

#[test]
fn threads_rows_and_files_change_nothing() {
    let stage = Stage::new(&(closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7]) + CAMERA));
    let path = stage.path();
    let shows = [
        ("radiosity", "mesh"),
        ("radiosity", "direct"),
        ("radiosity", "gather"),
        ("photon", "direct"),
        ("photon", "gather"),
    ];
    for (method, show) in shows {
        let file = stage.file(&format!("{method}.{show}"));
        let file = file.to_str().unwrap();
        let mut base =
            vec![path.as_str(), "--quiet", "--method", method, "--show", show, "--samples", "3", "--bands", "8"];
        if method == "photon" {
            base.extend(["--photons", "20000"]);
        }
        let of = |more: &[&str]| stdout_of("spectrace", &[&base[..], more].concat(), b"");
        let pixels = |bytes: &[u8]| split(bytes).2.to_vec();
        let whole = of(&[]);
        assert!(pixels(&whole) == pixels(&of(&["--threads", "1"])), "{method} {show}");
        assert!(pixels(&whole) == pixels(&of(&["--solution", file])), "{method} {show}: solved");
        assert!(pixels(&whole) == pixels(&of(&["--solution", file])), "{method} {show}: kept");
        let (top, bottom) = (of(&["--rows", "0:3"]), of(&["--rows", "3:8"]));
        assert!(pixels(&whole) == [pixels(&top), pixels(&bottom)].concat(), "{method} {show}: rows");
    }
}

#[test]
fn kept_solutions_are_of_one_scene_and_whole() {
    let scene = closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7]);
    for method in METHODS {
        let stage = Stage::new(&(scene.clone() + CAMERA));
        let (path, file) = (stage.path(), stage.file("kept"));
        let name = file.to_str().unwrap();
        let mut base =
            vec![path.as_str(), "--quiet", "--method", method, "--bands", "8", "--samples", "1", "--solution", name];
        if method == "photon" {
            base.extend(["--photons", "2000"]);
        }
        stdout_of("spectrace", &base, b"");
        let whole = fs::read(&file).unwrap();
        // Another camera sees the same light.
        fs::write(stage.file("scene.toml"), scene.clone() + &CAMERA.replace("[2, 4, 1]", "[0, 4, 2]")).unwrap();
        stdout_of("spectrace", &base, b"");
        fails("spectrace", &[&base[..], &["--seed", "3"]].concat(), b"", 1, "other options");
        for changed in [
            scene.replace("reflectance = 0.2", "reflectance = 0.21"),
            scene.replace("luminance = 31", "luminance = 32"),
        ] {
            fs::write(stage.file("scene.toml"), changed + CAMERA).unwrap();
            fails("spectrace", &base, b"", 1, "of another scene");
        }
        fs::write(stage.file("scene.toml"), scene.clone() + CAMERA).unwrap();
        for cut in [0, 10, 30, 45, 60, whole.len() / 2, whole.len() - 1] {
            fs::write(&file, &whole[..cut]).unwrap();
            fails("spectrace", &base, b"", 1, "solution");
        }
        for at in [50, 70, whole.len() / 3, whole.len() - 2] {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            fs::write(&file, bytes).unwrap();
            fails("spectrace", &base, b"", 1, "damaged");
        }
    }
}

/// Photons near edges and in corners are as dense as elsewhere: means over places and runs lie within 3 % of paths.
#[test]
fn photons_know_edges_and_corners() {
    let stage = Stage::new(&closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7]));
    let near = [0.005, 0.02, 0.05, 0.1];
    let along = [0.7, 1.3, 2.1, 2.9, 3.4];
    type Place = fn(f64, f64) -> String;
    let kinds: [(&str, Place); 5] = [
        ("floor's edge", |d, s| format!("{d} {s} 0 0 0 1\n")),
        ("wall's foot", |d, s| format!("0 {s} {d} 1 0 0\n")),
        ("wall's head", |d, s| format!("0 {s} {} 1 0 0\n", 3.0 - d)),
        ("floor's corner", |d, s| format!("{d} {} 0 0 0 1\n", d * (0.5 + 0.2 * s))),
        ("ceiling's edge", |d, s| format!("{d} {s} 3 0 0 -1\n")),
    ];
    for (name, place) in kinds {
        let points: String = near.iter().flat_map(|d| along.iter().map(move |s| place(*d, *s))).collect();
        let mean = |lux: Vec<f64>| lux.iter().sum::<f64>() / lux.len() as f64;
        let truth = mean(stage.lux(&["--samples", "4096", "--bands", "4"], &points));
        let runs = ["1", "2", "3", "4"].map(|seed| {
            let options =
                ["--method", "photon", "--photons", "400000", "--samples", "16", "--bands", "4", "--seed", seed];
            mean(stage.lux(&options, &points))
        });
        let got = runs.iter().sum::<f64>() / 4.0;
        assert!((got / truth - 1.0).abs() < 0.03, "{name}: {got} for {truth}");
    }
}

/// A partition that stands on the floor, and cuts through elements: where it is dark behind it, it stays dark; where a dim lamp
/// shines behind it, what the elements under it have of the other side leaks as far as they reach.
#[test]
fn a_partition_leaks_no_further_than_its_elements() {
    let size = [4.0, 2.0, 2.0];
    let lamp = |x: f64, light: &str| {
        quad([[x, 0.5, 1.9], [x, 1.5, 1.9], [x + 0.7, 1.5, 1.9], [x + 0.7, 0.5, 1.9]], "wall", light)
    };
    let dark = closed(size, [0.5, 0.5, 0.5]).replace("light = \"l\"", "")
        + &quad([[1.37, 0.0, 0.0], [1.37, 2.0, 0.0], [1.37, 2.0, 2.0], [1.37, 0.0, 2.0]], "wall", "")
        + &lamp(0.3, "light = \"l\"");
    let dim = format!("{dark}[lights.m]\nspectrum = \"E\"\nluminance = 1\n{}", lamp(2.6, "light = \"m\""));
    let bright = "0.7 1 0 0 0 1\n";
    let behind = "1.40 1 0 0 0 1\n1.5 1 0 0 0 1\n2.5 1 0 0 0 1\n4 1 1 -1 0 0\n1.37 1 1 1 0 0\n";
    let lux = |scene: &str, options: &[&str], points: &str| {
        let points = bright.to_string() + points;
        Stage::new(scene).lux(&[options, &["--bands", "4"]].concat(), &points)
    };
    let radiosity = ["--method", "radiosity", "--show", "mesh", "--samples", "1", "--divide"];
    for options in
        [&["--method", "photon", "--photons", "200000", "--samples", "8"][..], &[&radiosity[..], &["5"]].concat()]
    {
        let got = lux(&dark, options, behind);
        assert!(got[0] > 5.0 && got[1..].iter().all(|lux| *lux == 0.0), "{options:?}: {got:?}");
    }
    let far = "2.5 1 0 0 0 1\n4 1 1 -1 0 0\n";
    let truth = lux(&dim, &["--samples", "16384"], far);
    let leak = |divide: &str| {
        let got = lux(&dim, &[&radiosity[..], &[divide]].concat(), far);
        [1, 2].map(|i| got[i] / truth[i] - 1.0)
    };
    let (coarse, fine) = (leak("4"), leak("48"));
    for i in 0..2 {
        assert!(coarse[i] > 0.2 && fine[i] < 0.2 * coarse[i], "{fine:?} {coarse:?}");
    }
}

/// A box without a bottom that stands on the floor lights the room as one with a bottom: its dark inside does not count.
#[test]
fn the_inside_of_a_box_does_not_count() {
    let room = closed([4.0, 4.0, 3.0], [0.5, 0.5, 0.7]);
    let corners = [[1.3, 1.1], [2.4, 1.1], [2.4, 2.6], [1.3, 2.6]];
    let side = |i: usize| {
        let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % 4]);
        quad([[ax, ay, 0.0], [bx, by, 0.0], [bx, by, 1.2], [ax, ay, 1.2]], "wall", "")
    };
    let level = |z: f64| quad(corners.map(|[x, y]| [x, y, z]), "wall", "");
    let open = room + &(0..4).map(side).collect::<String>() + &level(1.2);
    let shut = open.clone() + &level(0.0005);
    let points = "1.1 2 0 0 0 1\n2.5 2.7 0 0 0 1\n4 2 0.5 -1 0 0\n2 2 3 0 0 -1\n1.3 2 0.3 -1 0 0\n3.5 0.5 0 0 0 1\n";
    let lux = |scene: &str| {
        let options =
            ["--method", "radiosity", "--show", "mesh", "--divide", "9", "--element-rays", "4096", "--bands", "4"];
        Stage::new(scene).lux(&options, points)
    };
    for (open, shut) in lux(&open).iter().zip(lux(&shut)) {
        assert!((open / shut - 1.0).abs() < 0.005, "{open} for {shut}");
    }
}

/// A wall of a millimetre between a bright room and a dim one, looked at from both sides, on it and a decimetre from it.
#[test]
fn thin_walls_keep_rooms_apart() {
    let lamp = |x: f64, light: &str| {
        quad([[x, 0.5, 1.9], [x, 1.5, 1.9], [x + 0.7, 1.5, 1.9], [x + 0.7, 0.5, 1.9]], "wall", light)
    };
    let wall = |x: f64| quad([[x, 0.0, 0.0], [x, 2.0, 0.0], [x, 2.0, 2.0], [x, 0.0, 2.0]], "wall", "");
    let rooms = closed([4.0, 2.0, 2.0], [0.5; 3]).replace("light = \"l\"", "");
    let dim = "[lights.m]\nspectrum = \"E\"\nluminance = 3\n";
    let lamps = lamp(0.3, "light = \"l\"") + dim + &lamp(2.9, "light = \"m\"");
    let points = "1 1 0 0 0 1\n1.9 1 0 0 0 1\n2 1 1 -1 0 0\n2.001 1 1 1 0 0\n2.1 1 0 0 0 1\n3 1 0 0 0 1\n";
    like_paths(&(rooms + &wall(2.0) + &wall(2.001) + &lamps), points, 0.05);
}

/// A lamp that stands out from a wall like a shelf: next to where it touches, away from it, and in what it shades.
#[test]
fn a_lamp_touches_a_wall() {
    let room = closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7]).replace("light = \"l\"", "");
    let shelf = quad([[0.0, 1.0, 1.5], [0.0, 3.0, 1.5], [0.5, 3.0, 1.5], [0.5, 1.0, 1.5]], "wall", "light = \"l\"");
    let points = "0 2 1.45 1 0 0\n0 2 1.3 1 0 0\n0 2 1.7 1 0 0\n0.1 2 0 0 0 1\n2 2 0 0 0 1\n2 2 3 0 0 -1\n";
    like_paths(&(room + &shelf), points, 0.06);
}

/// Radiosity and photons give what paths give.
fn like_paths(scene: &str, points: &str, tolerance: f64) {
    let stage = Stage::new(scene);
    let lux = |options: &[&str]| stage.lux(&[options, &["--bands", "4"]].concat(), points);
    let truth = lux(&["--samples", "4096"]);
    for options in [
        &["radiosity", "--samples", "64", "--mesh-error", "0.04"][..],
        &["photon", "--photons", "400000", "--samples", "16"],
    ] {
        let got = lux(&[&["--method"], options].concat());
        for (got, truth) in got.iter().zip(&truth) {
            assert!((got / truth - 1.0).abs() < tolerance, "{options:?}: {got} for {truth}");
        }
    }
}

/// A lamp seen through a glass sphere: photons bring what paths bring, where radiosity has nothing.
#[test]
fn caustics_are_those_of_paths() {
    let scene = "[lights.l]\nspectrum = \"E\"\nluminance = 20000\n[materials.floor]\nreflectance = 0.7\n\
        [materials.glass]\ntype = \"dielectric\"\nindex = 1.5\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0.7]\nradius = 0.5\nmaterial = \"glass\"\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [1.5, 0.5, 3]\nradius = 0.3\nmaterial = \"floor\"\nlight = \"l\"\n";
    let floor = quad([[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [4.0, 4.0, 0.0], [-4.0, 4.0, 0.0]], "floor", "");
    let stage = Stage::new(&format!("{scene}{floor}"));
    let at = |i: i32| f64::from(i % 8) / 8.0 - 0.44;
    let points: String = (0..64).map(|i| format!("{} {} 0 0 0 1\n", -0.46 + at(i), -0.15 + at(i / 8))).collect();
    let sum = |args: &[&str]| stage.lux(&[args, &["--bands", "4"]].concat(), &points).iter().sum::<f64>();
    let paths = sum(&["--samples", "16384"]);
    let photons = sum(&["--method", "photon", "--photons", "500000", "--samples", "8", "--count", "50"]);
    let radiosity = sum(&["--method", "radiosity", "--samples", "64"]);
    assert!((photons / paths - 1.0).abs() < 0.05, "{photons} for {paths}");
    assert!(radiosity < 0.7 * paths, "{radiosity} of {paths}");
}

#[test]
fn what_radiosity_cannot_show_is_said() {
    let shiny = closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7])
        .replace("[materials.floor]\n", "[materials.floor]\ntype = \"plastic\"\n");
    let shiny = shiny.replace("reflectance = 0.2", "reflectance = 0.2\nspecular = 0.05\nroughness = 0.1");
    let stage = Stage::new(&(shiny + CAMERA));
    let out = run("spectrace", &[&stage.path(), "--method", "radiosity", "--samples", "1", "--bands", "8"], b"");
    let said = String::from_utf8(out.stderr).unwrap();
    assert!(out.status.success() && said.contains("20.0 % of the area has gloss"), "{said}");
}

#[test]
fn faults_are_named() {
    let stage = Stage::new(&(closed([4.0, 4.0, 3.0], [0.5, 0.2, 0.7]) + CAMERA));
    let path = stage.path();
    let of = |more: &[&'static str]| -> Vec<String> {
        [&[path.as_str()], more].concat().iter().map(|s| s.to_string()).collect()
    };
    let cases: [(&[&str], i32, &str); 9] = [
        (&["--method", "photon", "--divide", "2"], 2, "--method radiosity"),
        (&["--method", "radiosity", "--photons", "2"], 2, "--method photon"),
        (&["--solution", "x"], 2, "--method radiosity or photon"),
        (&["--method", "photon", "--show", "mesh"], 2, "--method radiosity"),
        (&["--method", "photon", "--error", "0.1"], 2, "--samples"),
        (&["--method", "radiosity", "--mesh-error", "0"], 2, "0.0001"),
        (&["--method", "radiosity", "--element-rays", "0"], 2, "1 to 65535"),
        // A million elements a wall are more than memory that was granted, which is said before it is taken.
        (&["--method", "radiosity", "--divide", "1000", "--solver-memory", "512"], 1, "12000000 elements"),
        (&["--method", "photon", "--photons", "1000000", "--solver-memory", "1"], 1, "--solver-memory"),
    ];
    for (more, status, word) in cases {
        let args = of(more);
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        fails("spectrace", &args, b"", status, word);
    }
    let dark = Stage::new(
        "[materials.m]\nreflectance = 0.5\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n",
    );
    for method in METHODS {
        fails("spectrace", &[&dark.path(), "--irradiance", "--method", method], b"0 0 0 0 0 1\n", 1, "gives off light");
    }
}
