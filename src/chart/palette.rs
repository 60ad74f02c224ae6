//! Colours for shares of a scale.

use std::fmt;
use std::str::FromStr;

use crate::chart::{Colour, WHITE};
use crate::display::transfer::srgb_decode;
use crate::{Error, Result, string_serde};

/// Tables in palettes/, by name.
const TABLES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/palettes.rs"));

/// How many colours a palette has: twelve bits.
const COLOURS: usize = 4096;

/// A palette: a table of palettes/ or one of these formulas in v, the share.
///
/// | name | red, green, blue |
/// |---|---|
/// | `spec` | Radiance's, blue over green to red, in linear light: 1.6 v - 0.6; 8/3 v up to 3/8, then 1.6 - 1.6 v; 1 - 8/3 v |
/// | `hot` | 3 v; 3 v - 1; 3 v - 2, as a screen takes them: black, red, yellow, white |
/// | `pm3d` | sqrt v; v^3; sin 2 pi v, as a screen takes them: gnuplot's |
/// | `grey` | even steps of what a screen takes |
#[derive(Clone, PartialEq)]
pub struct Palette {
    name: String,
    colours: Vec<Colour>,
}

impl Palette {
    /// The colour of a share of the scale.
    ///
    /// ```
    /// let spec: luxpipe::chart::Palette = "spec".parse().unwrap();
    /// assert_eq!((spec.colour(0.0), spec.colour(1.0)), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
    /// ```
    pub fn colour(&self, share: f64) -> Colour {
        self.colours[((share * COLOURS as f64) as usize).min(COLOURS - 1)]
    }
}

fn formula(name: &str, v: f64) -> Option<[f64; 3]> {
    let screen = |rgb: [f64; 3]| Some(rgb.map(|x| srgb_decode(x.clamp(0.0, 1.0))));
    match name {
        "spec" => {
            let green = if v < 0.375 { 8.0 / 3.0 * v } else { 1.6 - 1.6 * v };
            Some([1.6 * v - 0.6, green, 1.0 - 8.0 / 3.0 * v].map(|x| x.clamp(0.0, 1.0)))
        }
        "hot" => screen([3.0 * v, 3.0 * v - 1.0, 3.0 * v - 2.0]),
        "pm3d" => screen([v.sqrt(), v.powi(3), (2.0 * std::f64::consts::PI * v).sin()]),
        "grey" => screen([v; 3]),
        _ => None,
    }
}

/// Rows of red, green and blue as a screen takes them, at even steps.
fn table(text: &str) -> Option<Vec<[f64; 3]>> {
    let rows = text.lines().filter(|l| !l.starts_with('#') && !l.is_empty());
    let numbers =
        |l: &str| <[f64; 3]>::try_from(l.split(',').filter_map(|x| x.parse().ok()).collect::<Vec<f64>>()).ok();
    rows.map(numbers).collect::<Option<Vec<_>>>().filter(|rows| rows.len() > 1)
}

fn between(rows: &[[f64; 3]], v: f64) -> [f64; 3] {
    let place = v * (rows.len() - 1) as f64;
    let i = (place as usize).min(rows.len() - 2);
    let share = place - i as f64;
    [0, 1, 2].map(|c| srgb_decode(rows[i][c] + share * (rows[i + 1][c] - rows[i][c])))
}

impl FromStr for Palette {
    type Err = Error;
    fn from_str(name: &str) -> Result<Palette> {
        let name = match name {
            "def" => "spec", // as Radiance has it
            "gray" => "grey",
            other => other,
        };
        let rows = TABLES.iter().find(|(n, _)| *n == name).and_then(|(_, text)| table(text));
        let colour = |i: usize| {
            let v = i as f64 / (COLOURS - 1) as f64;
            let rgb = rows.as_ref().map(|r| between(r, v)).or_else(|| formula(name, v))?;
            Some(rgb.map(|x| x as f32))
        };
        let colours: Option<Vec<Colour>> = (0..COLOURS).map(colour).collect();
        let tables: Vec<&str> = TABLES.iter().map(|(n, _)| *n).collect();
        let unknown =
            || Error::Invalid(format!("no palette '{name}'; there are spec, hot, pm3d, grey, {}", tables.join(", ")));
        Ok(Palette { name: name.into(), colours: colours.ok_or_else(unknown)? })
    }
}

impl fmt::Display for Palette {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl fmt::Debug for Palette {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Palette({})", self.name)
    }
}
string_serde!(Palette);

/// A colour that shows on a black ground: as it is, or lightened.
pub fn on_black(colour: Colour) -> Colour {
    let luminance = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
    if luminance < 0.06 { super::mix(colour, WHITE, 0.12) } else { colour }
}
