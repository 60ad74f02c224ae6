//! specprobe on media, by the real program.

use std::process::Command;

fn probe(arguments: &[&str]) -> Vec<Vec<String>> {
    let scene = tempfile::NamedTempFile::new().unwrap();
    let text = "[media.marble]\nscattering = \"medium_marble_scattering\"\nabsorption = \"medium_marble_absorption\"\nper = \"mm\"\n\
                [media.air]\nscattering = 1e-5\nphase = \"rayleigh\"\n[media.fog]\nextinction = 1\nalbedo = 0.9\n";
    std::fs::write(scene.path(), text).unwrap();
    let o = Command::new(env!("CARGO_BIN_EXE_specprobe")).arg(scene.path()).args(arguments).output().unwrap();
    assert!(o.status.success(), "{}", String::from_utf8_lossy(&o.stderr));
    let text = String::from_utf8(o.stdout).unwrap();
    let lines = text.lines().filter(|l| !l.starts_with('#'));
    lines.map(|l| l.split('\t').map(String::from).collect()).collect()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap()
}

/// Green marble as a half space: its specular part by Fresnel, exact transport and the dipole by their tables.
#[test]
fn half_spaces() {
    let rows =
        probe(&["--medium", "marble", "--thickness", "inf", "--index", "1.5", "--angles", "0", "--wavelengths", "540"]);
    let row: Vec<f64> = rows[0].iter().map(|w| number(w)).collect();
    let [_, _, reflectance, transmittance, specular, dipole] = row[..] else { panic!("{rows:?}") };
    assert!((specular - 0.04).abs() < 1e-6 && transmittance == 0.0);
    assert!((reflectance - specular - 0.76749).abs() < 2e-5, "{reflectance}");
    assert!((dipole - (0.04 + 0.96 * 0.79096)).abs() < 2e-5, "{dipole}");
    assert_eq!(rows[1][0], "diffuse");
}

/// A slab of the table of isotropic scattering: albedo 0.9, depth 1.
#[test]
fn slabs() {
    let rows = probe(&["--medium", "fog", "--thickness", "1", "--angles", "0,60", "--wavelengths", "550"]);
    let want = [[0.26741, 0.591625], [0.393662, 0.41484], [0.352712, 0.474746]];
    for (row, [r, t]) in rows.iter().zip(want) {
        assert!((number(&row[2]) - r).abs() < 1e-5 && (number(&row[3]) - t).abs() < 1e-5, "{row:?}");
    }
}

/// The dipole's profile per area of the scene's lengths, here m2; a phase function, and its polarization.
#[test]
fn profiles_and_phases() {
    let rows = probe(&["--medium", "marble", "--radii", "0.001", "--index", "1.5", "--wavelengths", "540"]);
    assert!((number(&rows[0][2]) / 0.034330027e6 - 1.0).abs() < 1e-5, "{rows:?}");
    let rows = probe(&["--medium", "air", "--angles", "0,60,90", "--wavelengths", "550"]);
    let of: Vec<f64> = rows[1..].iter().map(|r| number(&r[2])).collect();
    assert!(of.iter().zip([1.5, 0.9375, 0.75]).all(|(a, b)| (a - b).abs() < 1e-5), "{of:?}");
    let rows = probe(&["--medium", "air", "--angles", "90", "--wavelengths", "550", "--mueller"]);
    let matrix: Vec<f64> = rows[1][1..].iter().map(|w| number(w)).collect();
    assert!((matrix[0] - matrix[1]).abs() < 1e-6 && matrix[0] > 0.0, "{matrix:?}");
}

/// What cannot be asked for is refused with status 2.
#[test]
fn wrong_questions() {
    let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/fogbox.toml");
    for arguments in [
        &["--medium", "none"][..],
        &["--medium", "fog", "--thickness", "-1"],
        &["--medium", "fog", "--thickness", "1", "--angles", "95"],
        &["--medium", "fog", "--index", "9"],
        &["--thickness", "1"],
    ] {
        let o = Command::new(env!("CARGO_BIN_EXE_specprobe")).arg(&scene).args(arguments).output().unwrap();
        assert_eq!(o.status.code(), Some(2), "{arguments:?}: {}", String::from_utf8_lossy(&o.stderr));
    }
}
