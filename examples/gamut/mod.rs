//! What the gamut methods and intents of `xyz2rgb` do to colours that a display cannot make: shared by `make intents` and
//! tests/gamut.rs. XYZ are relative to the display's white, Y = 1, D65 throughout.
#![allow(dead_code)] // the page and the tests each use their part

pub mod blue;
pub mod errors;
pub mod methods;
pub mod sets;

use errors::Errors;
use luxpipe::color::Primaries;
use methods::{METHODS, shown};
use sets::Set;

/// One table: a row a method.
fn table(set: &Set, primaries: &str) -> String {
    let gamut: Primaries = primaries.parse().expect("a name");
    let rows = METHODS.iter().map(|method| {
        let e = Errors::of(&set.colours, &shown(method, gamut, &set.colours));
        format!("| `{method}` | {} |\n", e.cells().join(" | "))
    });
    format!("## {} in {primaries}\n\n{}\n\n{HEAD}{}", set.title, set.what, rows.collect::<String>())
}

const HEAD: &str = "\
| method | hue CIELAB mean | max | hue Oklab mean | max | chroma ratio | luminance % | Delta E mean | max | moved % |
|---|---|---|---|---|---|---|---|---|---|
";

/// All of docs/gamut.md.
pub fn page() -> String {
    let (picture, locus, pointer) = (sets::picture(), sets::locus(), sets::pointer());
    let tables = [
        table(&picture, "BT.709"),
        table(&locus, "BT.709"),
        table(&pointer, "BT.709"),
        table(&pointer, "P3"),
        table(&pointer, "BT.2020"),
        blue::page(),
    ];
    format!("{}\n{}", include_str!("head.md"), tables.join("\n"))
}
