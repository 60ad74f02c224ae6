//! Which map: the goal, and where its histogram comes from.

use std::io::Read;
use std::path::Path;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::color::Primaries;
use crate::tone::threshold::Count;
use crate::tone::{Curve, Display, Histogram, Scale, adjust, classic, faithful, palette::Palette, print, visible};
use crate::{Error, Result, invalid};

/// What the map is to keep: the paper's fifth recommendation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Goal {
    /// Contrast where most pixels are: histogram adjustment
    Contrast,
    /// Most of what is visible, and nothing that is not
    Visibility,
    /// Colours: the least mean Delta E 2000 after gamut mapping
    Colour,
}

/// Surround of the display.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Surround {
    /// A lit room: contrast exponent 1
    Average,
    /// A living room in the evening: 1.25
    Dim,
    /// A cinema: 1.5
    Dark,
}

impl Surround {
    /// Exponent on the share of the display's range [Bartleson and Breneman 1967; Hunt].
    pub fn exponent(self) -> f64 {
        match self {
            Surround::Average => 1.0,
            Surround::Dim => 1.25,
            Surround::Dark => 1.5,
        }
    }
}

/// How to make the map.
#[derive(Clone, Debug)]
pub enum Rule {
    /// All contrast kept, the ends clipped.
    Linear,
    /// Histogram adjustment on a scale.
    Adjusted(Scale),
    /// As Radiance's pcond, with the ceiling of `-s` or not.
    Classic(bool),
    /// Visibility.
    Visible(Scale),
    /// Least colour difference, the scene's white if it is known.
    Faithful(Primaries, Option<f64>),
    /// Most contrast in a print of these primaries.
    Print(Primaries),
}

impl Rule {
    /// For a goal; `adapted_cd_m2` is where the eyes come from, 0 for rested ones.
    pub fn of(goal: Goal, sensitivity: bool, adapted_cd_m2: f64, primaries: Primaries, white: Option<f64>) -> Rule {
        match goal {
            Goal::Contrast if sensitivity => Rule::Adjusted(Scale::visibility(Count::Integral, adapted_cd_m2)),
            Goal::Contrast => Rule::Adjusted(Scale::Ratio),
            Goal::Visibility => Rule::Visible(visible::scale(adapted_cd_m2)),
            Goal::Colour => Rule::Faithful(primaries, white),
        }
    }

    /// Needs to know the picture's colours.
    pub fn needs_palette(&self) -> bool {
        matches!(self, Rule::Faithful(..) | Rule::Print(_))
    }

    /// The map for a histogram that is not empty.
    pub fn map(&self, histogram: &Histogram, palette: &Palette, display: Display) -> Result<Curve> {
        Ok(match self {
            Rule::Linear => adjust::exposed(histogram, display, &Scale::Ratio),
            Rule::Adjusted(scale) => adjust::adjusted(histogram, display, scale).0,
            Rule::Classic(sensitivity) => classic::adjusted(histogram, display, *sensitivity),
            Rule::Visible(scale) => visible::visible(histogram, display, scale),
            Rule::Faithful(primaries, white) => {
                let medium = faithful::Medium { display, primaries: *primaries };
                match faithful::faithful(palette, medium, *white) {
                    Some(curve) => curve,
                    None => return invalid!("no pixel has a colour to be kept"),
                }
            }
            Rule::Print(primaries) => match primaries.from_xyz() {
                Some(m) => print::print(histogram, palette, display, &m),
                None => return invalid!("the print's primaries span no area"),
            },
        })
    }
}

/// The text of a file, or of standard input for `-`.
fn text_of(path: &Path) -> Result<String> {
    let mut text = String::new();
    let read = if path == Path::new("-") {
        std::io::stdin().lock().read_to_string(&mut text).map(|_| ())
    } else {
        crate::files::open(path).and_then(|mut f| f.read_to_string(&mut text)).map(|_| ())
    };
    read.map_err(|e| Error::io(path.display().to_string(), e))?;
    Ok(text)
}

/// A histogram of `picinfo --histogram` or Radiance's `phisto`.
pub fn read_histogram(path: &Path) -> Result<Histogram> {
    Histogram::from_text(&text_of(path)?).map_err(|e| e.within(&path.display().to_string()))
}

/// Pixels, x and y from the lower left corner, one pair a line.
pub fn read_fixations(path: &Path, width: usize, height: usize) -> Result<Vec<[usize; 2]>> {
    let mut list = Vec::new();
    for (n, line) in text_of(path)?.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let words: Vec<Option<f64>> =
            line.split([' ', '\t', ',']).filter(|w| !w.is_empty()).map(|w| w.parse().ok()).collect();
        match words[..] {
            [Some(x), Some(y)] if x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64 => {
                list.push([x as usize, y as usize]);
            }
            _ => {
                return invalid!(
                    "{}: line {}: expected x and y of a pixel within {width} x {height}, from the lower left",
                    path.display(),
                    n + 1
                );
            }
        }
    }
    if list.is_empty() { invalid!("{}: no fixations", path.display()) } else { Ok(list) }
}

/// A map that `pcond -x` wrote.
pub fn read_map(path: &Path, display: Display) -> Result<Curve> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (n, line) in text_of(path)?.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let words: Vec<Option<f64>> = line.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
        match words[..] {
            [Some(world), Some(shown)] if f64::min(world, shown) > 0.0 && f64::max(world, shown) < 1e30 => {
                points.push((world.ln(), shown.ln()));
            }
            _ => return invalid!("{}: line {}: expected world and display luminance, cd/m2", path.display(), n + 1),
        }
    }
    let rises = points.windows(2).all(|p| p[0].0 < p[1].0 && p[0].1 <= p[1].1);
    if points.is_empty() || !rises {
        return invalid!("{}: no map: its luminances must rise", path.display());
    }
    Ok(Curve::new(points, display))
}
