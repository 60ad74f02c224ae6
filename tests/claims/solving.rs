//! Solving the rendering equation.

use super::*;

/// Mean error of irradiance at the middles of a closed room's sides over their mean: (centre_B - exitance) / reflectance of
/// radiosity-room-C in tests/ref/validation.toml.
pub fn room_error(method: &[&str]) -> f64 {
    const POINTS: &[u8] = b"2 2 0 0 0 1\n0 2 1.5 1 0 0\n2 2 3 0 0 -1\n";
    let truth = [10.6497 / 0.2, 20.0279 / 0.5, (110.951 - 100.0) / 0.7];
    let sides = [1.0, 4.0, 1.0];
    let args = [&["scenes/room-c.toml", "--irradiance", "--quiet", "--bands", "4"][..], method].concat();
    let got = irradiances(&args, POINTS);
    assert_eq!(got.len(), 3);
    let error: f64 = (0..3).map(|i| sides[i] * (got[i] - truth[i]).abs()).sum();
    error / (0..3).map(|i| sides[i] * truth[i]).sum::<f64>()
}

pub fn irradiances(args: &[&str], points: &[u8]) -> Vec<f64> {
    let out = String::from_utf8(stdout_of("spectrace", args, points)).unwrap();
    out.lines().map(|l| l.split('\t').nth(1).unwrap().trim().parse().unwrap()).collect()
}

/// Percent of the light under a ball of clear glass that radiosity finds: the scene of tests/methods.rs, paths as truth.
pub fn radiosity_behind_glass() -> f64 {
    let scene = "[lights.l]\nspectrum = \"E\"\nluminance = 20000\n[materials.floor]\nreflectance = 0.7\n\
        [materials.glass]\ntype = \"dielectric\"\nindex = 1.5\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0.7]\nradius = 0.5\nmaterial = \"glass\"\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [1.5, 0.5, 3]\nradius = 0.3\nmaterial = \"floor\"\nlight = \"l\"\n\
        [[shape]]\ntype = \"quad\"\npoints = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]]\nmaterial = \"floor\"\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.toml");
    std::fs::write(&file, scene).unwrap();
    let at = |i: i32| f64::from(i % 8) / 8.0 - 0.44;
    let points: String = (0..64).map(|i| format!("{} {} 0 0 0 1\n", -0.46 + at(i), -0.15 + at(i / 8))).collect();
    let sum = |method: &[&str]| -> f64 {
        let args = [&[file.to_str().unwrap(), "--irradiance", "--quiet", "--bands", "4"][..], method].concat();
        irradiances(&args, points.as_bytes()).iter().sum()
    };
    100.0 * sum(&["--method", "radiosity", "--samples", "64"]) / sum(&["--samples", "4096"])
}

/// Error in percent of a row that `make bench-methods` measured.
pub fn bench_methods(row: &str) -> f64 {
    let text = std::fs::read_to_string(root().join("docs/methods.csv")).unwrap();
    let line = text.lines().find(|l| l.starts_with(&format!("{row},"))).unwrap_or_else(|| panic!("no row '{row}'"));
    line.rsplit(',').next().unwrap().parse().unwrap()
}
