//! pcond: map world luminance to what a display can show, by histogram adjustment: technique C of [Ward 2001], the method of
//! [Ward 1997] (see `tone::histogram`).

use std::fmt::{self, Write as _};
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::display as medium;
use crate::filter::{Filter, Product, Run};
use crate::stream::output::Output;
use crate::stream::{Components, Header, Picture, Units, picture, spool, tristimulus};
use crate::tone::Curve;
use crate::tone::fovea::{self, Fovea};
use crate::tone::histogram::Display;
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, string_serde, usage};

/// Options of `pcond`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pcond {
    /// Display to map for, by name or file: its black and white, ambient light included
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with_all = ["ldmax", "lddyn"])]
    pub display: Option<medium::Display>,
    /// Luminance of the display's white, cd/m2
    #[arg(short = 'u', long, value_name = "CD_M2", default_value_t = 100.0)]
    pub ldmax: f64,
    /// Contrast of the display: white over black
    #[arg(short = 'd', long, value_name = "RATIO", default_value_t = 100.0)]
    pub lddyn: f64,
    /// One factor for all pixels, from the mean of log luminance; a scene that fits the display is shifted until all of it
    /// shows
    #[arg(short = 'l', long, conflicts_with = "exposure")]
    pub linear: bool,
    /// One given factor for all pixels, in Radiance's sense (179 cd/m2 becomes white at 1), or with a sign in stops
    #[arg(short = 'e', long, value_name = "FACTOR", allow_hyphen_values = true)]
    pub exposure: Option<Stops>,
    /// Write the map to FILE: 100 lines of world and display luminance, cd/m2
    #[arg(short = 'x', long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "crate::options::lossy")]
    pub map: Option<PathBuf>,
}
clap_defaults!(Pcond);

/// An exposure as Radiance's filters take it, with its spelling.
#[derive(Clone, Debug, PartialEq)]
pub struct Stops {
    text: String,
    factor: f64,
}

impl FromStr for Stops {
    type Err = Error;
    fn from_str(text: &str) -> Result<Stops> {
        let number: Option<f64> = text.parse().ok().filter(|x: &f64| x.is_finite());
        let factor = number.map(|n| if text.starts_with(['+', '-']) { n.exp2() } else { n });
        match factor.filter(|f| (1e-30..1e30).contains(f)) {
            Some(factor) => Ok(Stops { text: text.to_string(), factor }),
            None => Err(Error::Invalid(format!("'{text}': expected a factor such as 0.5, or stops such as -1 or +2"))),
        }
    }
}

impl fmt::Display for Stops {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}
string_serde!(Stops);

/// Lines of a map file.
const MAP_LINES: usize = 100;

impl Pcond {
    fn range(&self) -> Result<Display> {
        if let Some(d) = &self.display {
            return Ok(Display { max_cd_m2: d.white_cd_m2, min_cd_m2: d.black_cd_m2 });
        }
        if !(self.ldmax > 0.0 && self.ldmax <= 1e6) {
            return usage!("--ldmax {} is no luminance of a display's white", self.ldmax);
        }
        if !(self.lddyn > 1.0 && self.lddyn <= 1e9) {
            return usage!("--lddyn {} is no contrast; it must be over 1", self.lddyn);
        }
        Ok(Display { max_cd_m2: self.ldmax, min_cd_m2: self.ldmax / self.lddyn })
    }

    /// The factor of `--exposure`: display value for 1 cd/m2.
    fn fixed_factor(&self) -> Option<f64> {
        self.exposure.as_ref().map(|e| e.factor / RADIANCE_EFFICACY)
    }

    /// Writes `--map`, whole or not at all.
    fn write_map(&self, curve: &Curve, range_cd_m2: (f64, f64)) -> Result<()> {
        let Some(path) = self.map.as_ref() else { return Ok(()) };
        if path.as_os_str() == "-" {
            return usage!("--map needs a file: standard output carries the picture");
        }
        let mut text = String::new();
        for (world, display) in curve.sampled(range_cd_m2, MAP_LINES) {
            let _ = writeln!(text, "{world:.6e} {display:.6e}");
        }
        let mut out = Output::create(Some(path), false)?;
        std::io::Write::write_all(&mut out, text.as_bytes()).map_err(|e| out.error(e))?;
        out.finish()
    }
}

/// All pixels times one factor, which the header records as Radiance counts exposure.
fn scaled(input: Box<dyn Picture>, mut header: Header, display_per_cd_m2: f64) -> Box<dyn Picture> {
    header.lines.push(format!("MAPPED_EXPOSURE={:.4e}", display_per_cd_m2 * RADIANCE_EFFICACY).into_bytes());
    let factor = display_per_cd_m2 as f32;
    picture::map(input, header, move |pixels| pixels.iter_mut().for_each(|x| *x *= factor))
}

impl Filter for Pcond {
    const NAME: &'static str = "pcond";
    const ABOUT: &'static str =
        "Map world luminance to a display by histogram adjustment (reads its input twice, or keeps it)";
    const EXAMPLE: &'static str =
        "vonkries --to D65 < scene.lux | pcond | xyz2rgb --gamut desaturate | ra_png > scene.png";

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if input.header().units == Units::Display {
            return crate::invalid!("the picture is display-referred already (UNITS=display)");
        }
        if input.header().units == Units::Relative {
            return crate::invalid!(
                "the picture is relative (UNITS=relative); a scene has cd/m2, say so with --units cd/m2"
            );
        }
        let display = self.range()?;
        let input = tristimulus(input)?;
        let mut header = input.header().clone();
        header.become_tristimulus(Components::Xyz, Units::Display);
        header.display = Some([display.min_cd_m2, display.max_cd_m2]);
        if let Some(factor) = self.fixed_factor() {
            if self.map.is_some() {
                return usage!("--map goes with a map that the picture decides, not with --exposure");
            }
            return Ok(Product::Picture(scaled(input, header, factor)));
        }
        if let (_, _, true) = fovea::cells(input.header()) {
            run.notes.add("no VIEW line with an angle of view: taking 40 degrees on the long side");
        }
        let mut seen = Fovea::new(input.header());
        let mut replaced = 0u64;
        let input = spool::twice(input, &run.options.limits(), &run.notes, |_, block| {
            replaced += block.data.chunks_exact(3).filter(|p| !p[1].is_finite()).count() as u64;
            seen.add(block);
        })?;
        if replaced > 0 {
            run.notes.add(format!("{replaced} pixels with a luminance that is not finite became black"));
        }
        let histogram = seen.histogram();
        let Some(range) = histogram.range_cd_m2() else {
            run.notes.add("the picture is black: nothing to map");
            self.write_map(&Curve::linear(1.0, display), (display.min_cd_m2, display.max_cd_m2))?;
            return Ok(Product::Picture(picture::map(input, header, |pixels| pixels.fill(0.0))));
        };
        if self.linear {
            let factor = histogram.linear_factor(display);
            self.write_map(&Curve::linear(factor, display), range)?;
            return Ok(Product::Picture(scaled(input, header, factor / display.max_cd_m2)));
        }
        let curve = histogram.adjusted(display);
        self.write_map(&curve, range)?;
        let table = curve.table();
        let apply = move |pixels: &mut [f32]| {
            for pixel in pixels.chunks_exact_mut(3) {
                let factor = table.factor(pixel[1]);
                // A colour without light, or one that is not a number, is black.
                pixel.iter_mut().for_each(|x| *x = if x.is_finite() { *x * factor } else { 0.0 });
            }
        };
        Ok(Product::Picture(picture::map_on_all_threads(input, header, apply)))
    }
}
