//! Radiance's own bytes for the same pixels.

mod common;

use std::fs;

use common::{floats, root, split, stdout_of};

fn data(name: &str) -> Vec<u8> {
    fs::read(root().join("tests/data").join(name)).unwrap()
}

/// What a filter writes has the pixel bytes of a file that Radiance wrote.
fn same_pixels(args: &[&str], input: &str, want: &str) {
    let got = stdout_of("ra_rgbe", &[&["--quiet"], args].concat(), &data(input));
    let want = data(want);
    assert_eq!(split(&got).1, split(&want).1);
    assert!(split(&got).2 == split(&want).2, "{args:?} of {input}");
}

#[test]
fn rgbe_has_rcombs_bytes() {
    same_pixels(&[], "radiance_bytes.lux", "radiance_bytes.rgbe");
}

/// Old forms come back as the new run-length code, whose choice of runs is Radiance's.
#[test]
fn flat_pixels_have_ra_rgbes_runs() {
    same_pixels(&[], "radiance_bytes.flat", "radiance_bytes.rgbe");
}

/// The matrix of Radiance's primaries, whose white is 1/3 although four digits of it are printed. `ra_xyze` writes flat
/// pixels, which ours equal once their runs are undone.
#[test]
fn xyze_has_ra_xyzes_pixels() {
    let got = stdout_of("ra_rgbe", &["--xyze", "--quiet"], &data("radiance_bytes.rgbe"));
    let decoded = |xyze: &[u8]| floats(split(&stdout_of("ra_rgbe", &["-r"], xyze)).2);
    assert_eq!(decoded(&got), decoded(&data("radiance_bytes.xyze")));
    assert!(split(&got).2.len() < split(&data("radiance_bytes.xyze")).2.len());
}

#[test]
fn spectra_have_rcombs_bytes() {
    same_pixels(&["--spectra"], "radiance_spectra.lux", "radiance_spectra.hsr");
    // And they come back within the step of their shared exponent, in W/sr/m2/nm.
    let want = floats(split(&data("radiance_spectra.lux")).2);
    let got = floats(split(&stdout_of("ra_rgbe", &["-r"], &data("radiance_spectra.hsr"))).2);
    for (got, want) in got.chunks(18).zip(want.chunks(18)) {
        let step = want.iter().fold(0f32, |m, x| m.max(*x)) / 128.0;
        assert!(got.iter().zip(want).all(|(a, b)| (a * 407.73 - b).abs() <= step), "{got:?} {want:?}");
    }
}
