//! High dynamic range images. tests/encodings.rs holds these to libtiff and numpy, steps to closed forms.

use super::*;

pub fn all_visible() -> &'static [Xyz] {
    static COLOURS: LazyLock<Vec<Xyz>> = LazyLock::new(|| visible::colours(RANGES[0]));
    &COLOURS
}

/// CIEDE2000 of all visible colours.
pub fn errors(name: &str) -> Errors {
    Errors::of(all_visible(), &named(name).seen(all_visible()))
}

/// Percent of the visible colours, by area in u'v', whose chromaticity the encoding has no place for.
pub fn outside(name: &str) -> f64 {
    let encoding = named(name);
    let trip = encoding.trip(&encoding.components(all_visible()));
    100.0 * trip.outside as f64 / all_visible().len() as f64
}

/// Orders of magnitude of D65 greys that come back within 1 %.
pub fn orders(encoding: &Encoding) -> f64 {
    grey::orders(grey::range(encoding, 0.01))
}

/// Percent between neighbouring luminances, at most.
pub fn step(encoding: &Encoding) -> f64 {
    100.0 * grey::steps(encoding).largest
}

/// Of the paper's four formats, those that keep 99.9 % of the visible chromaticities and four orders of magnitude.
pub fn formats_that_hold_all() -> f64 {
    let formats = ["RGBE", "Pixar log BT.709", "LogLuv24", "LogLuv32"].into_iter();
    formats.filter(|name| outside(name) < 0.1 && orders(&named(name)) > 4.0).count() as f64
}

/// Bytes of the Cornell box with a renderer's noise (tests/ref/README.md), its unit taken as 100 cd/m2.
pub fn cornell_bytes(command: &[&str]) -> f64 {
    let values: Vec<f32> = npy(&root().join("tests/ref/a_cornell_xyz.npy")).iter().map(|x| 100.0 * x).collect();
    let input = stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2", "-Y 128 +X 128", &values);
    stdout_of(command[0], &[&command[1..], &["--quiet"]].concat(), &input).len() as f64
}
