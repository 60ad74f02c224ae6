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

/// Radiance's own programs take what we write; RADIANCE_BIN is their folder, as pyradiance installs them. Without it there is nothing to ask.
#[test]
fn radiances_programs_accept_our_pictures() {
    let Some(bin) = std::env::var_os("RADIANCE_BIN").map(std::path::PathBuf::from) else { return };
    let folder = tempfile::tempdir().unwrap();
    let ask = |name: &str, args: &[&str]| {
        let output = std::process::Command::new(bin.join(name)).args(args).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{name} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let lines = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3333333 0.3333333\nVIEW= -vta -vh 180 -vv 180\nPRIMARIES= 1 0 0 1 0 0 .333 .333";
    // Greys from 10 cd/m2 up, a bright spot among them.
    let side = 64;
    let grey = |i: usize| if i % side / 4 == 9 && i / side / 4 == 6 { 20_000.0f32 } else { 10.0 + (i % 97) as f32 };
    let pixels: Vec<f32> = (0..side * side).flat_map(|i| [grey(i); 3]).collect();
    let floats_in = common::stream(lines, &format!("-Y {side} +X {side}"), &pixels);
    fs::write(folder.path().join("ours.lux"), &floats_in).unwrap();
    fs::write(folder.path().join("ours.hdr"), stdout_of("ra_rgbe", &["-"], &floats_in)).unwrap();
    let numbers = |text: Vec<u8>| -> Vec<f64> {
        String::from_utf8(text).unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect()
    };
    // Luminance is 179 times what pvalue calls brightness.
    let seen = numbers(ask("pvalue", &["-o", "-b", "-h", "-H", "-d", "ours.hdr"]));
    assert_eq!(seen.len(), side * side);
    for (i, got) in seen.iter().enumerate() {
        let want = f64::from(grey(i));
        assert!((179.0 * got / want - 1.0).abs() < 0.006, "pixel {i}: {} for {want}", 179.0 * got);
    }
    let doubled = ask("rcomb", &["-s", "2", "ours.lux"]);
    // A matrix by NROWS and NCOLS, without a resolution line.
    let bytes = &doubled[doubled.len() - 12 * side * side..];
    assert!(
        floats(bytes).iter().zip(&pixels).all(|(a, b)| (a / (2.0 * b) - 1.0).abs() < 1e-5),
        "rcomb reads our floats"
    );
    let filtered = ask("pfilt", &["-1", "-e", "1", "-x", "32", "-y", "32", "ours.hdr"]);
    let info = String::from_utf8(stdout_of("picinfo", &[], &filtered)).unwrap();
    assert!(info.contains("32 x 32"), "{info}");
    ask("ra_tiff", &["ours.hdr", "ours.tif"]);
    assert!(fs::read(folder.path().join("ours.tif")).unwrap().len() > side * side);
    let glare = String::from_utf8(ask("evalglare", &["-vta", "-vh", "180", "-vv", "180", "ours.hdr"])).unwrap();
    assert!(glare.contains("dgp"), "{glare}");
}
