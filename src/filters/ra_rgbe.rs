//! ra_rgbe: a picture as Radiance RGBE or XYZE; -r goes back to floats.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::Primaries;
use crate::filter::{Filter, Product, Run};
use crate::filters::check_master;
use crate::stream::output::Output;
use crate::stream::{Components, Picture, Units, tristimulus, writer};
use crate::{Error, Result, invalid};

/// What becomes of negative components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Negatives {
    /// Set to 0, as Radiance does: fast, and it changes hue and luminance
    Clip,
    /// Moved toward the grey of equal luminance until none is left
    Desaturate,
}

/// Options of `ra_rgbe`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaRgbe {
    /// Write XYZE, which holds every visible colour
    #[arg(long)]
    pub xyze: bool,
    /// Write Radiance's hyperspectral pixels, from a spectrum of equal bins
    #[arg(long, conflicts_with = "xyze")]
    pub spectra: bool,
    /// Primaries for XYZ and spectra that become RGBE
    #[arg(long, value_name = "PRIMARIES", default_value = "Radiance", conflicts_with_all = ["xyze", "spectra"])]
    pub to: Primaries,
    /// Colours with negative components
    #[arg(long, value_enum, value_name = "HOW", default_value = "clip")]
    pub gamut: Negatives,
    /// Record a display-referred picture all the same
    #[arg(long)]
    pub force: bool,
    /// The other way: decode RGBE, XYZE or hyperspectral Radiance to floats
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(RaRgbe);

impl Filter for RaRgbe {
    const NAME: &'static str = "ra_rgbe";
    const ABOUT: &'static str =
        "Record a picture as Radiance RGBE, XYZE or hyperspectral pixels; -r decodes to a float stream";
    const EXAMPLE: &'static str =
        "spectrace scenes/cornell.toml | ra_rgbe > cornell.hdr\nra_rgbe -r < cornell.hdr | picinfo";
    const FORMATS: bool = false;
    const SUFFIXES: &'static [&'static str] = &["hdr", "pic", "rgbe", "xyze", "hsr", "lux"];

    /// `.lux` is a float stream as it flows.
    fn for_suffix(suffix: &str) -> Self {
        RaRgbe { xyze: suffix == "xyze", spectra: suffix == "hsr", reverse: suffix == "lux", ..Default::default() }
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        check_master(input.header(), self.force)?;
        if input.header().units == Units::Relative {
            return invalid!(
                "the picture is relative (UNITS=relative); the format holds light, say --units cd/m2 to take it so"
            );
        }
        let (input, replaced) = writer::bounded(input);
        if self.spectra {
            if input.header().components != Components::Spectrum {
                return invalid!("--spectra records a spectrum, and the picture is {}", input.header().components);
            }
            let notes = run.notes.clone();
            let write = Box::new(move |out: &mut Output| writer::write_spectra(input, replaced, out, &notes));
            return Ok(Product::Bytes { binary: true, write });
        }
        let (picture, format) = if self.xyze {
            (tristimulus(input)?, "32-bit_rle_xyze")
        } else {
            let input = if input.header().ncomp == 3 { input } else { tristimulus(input)? };
            (writer::to_rgb(input, self.to)?, "32-bit_rle_rgbe")
        };
        let (notes, desaturate) = (run.notes.clone(), self.gamut == Negatives::Desaturate && !self.xyze);
        let write = Box::new(move |out: &mut Output| {
            writer::write_shared_exponent(picture, replaced, format, desaturate, out, &notes)
        });
        Ok(Product::Bytes { binary: true, write })
    }
}
