//! pcond: map world luminance to what a display can show, by histogram adjustment: technique C of [Ward 2001], the method of
//! [Ward 1997] (see `tone::histogram`).

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::display as medium;
use crate::filter::{Filter, Product, Run};
use crate::stream::output::Output;
use crate::stream::{Components, Picture, Units, picture, spool, tristimulus};
use crate::tone::Curve;
use crate::tone::fovea::{self, Fovea};
use crate::tone::histogram::Display;
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, usage};

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
    /// One factor for all pixels, from the mean of log luminance
    #[arg(short = 'l', long)]
    pub linear: bool,
    /// One given factor for all pixels, in Radiance's sense (179 cd/m2 becomes white at 1), or with a sign in stops
    #[arg(short = 'e', long, value_name = "FACTOR", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// Write the map to FILE: 100 lines of world and display luminance, cd/m2
    #[arg(short = 'x', long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub map: Option<PathBuf>,
}
clap_defaults!(Pcond);

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
    fn fixed_factor(&self) -> Result<Option<f64>> {
        let Some(text) = &self.exposure else { return Ok(None) };
        let wrong =
            || Error::Usage(format!("--exposure '{text}': expected a factor such as 0.5, or stops such as -1 or +2"));
        let number: f64 = text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(wrong)?;
        let factor = if text.starts_with(['+', '-']) { number.exp2() } else { number };
        if !(1e-30..1e30).contains(&factor) {
            return Err(wrong());
        }
        Ok(Some(factor / RADIANCE_EFFICACY))
    }

    /// Writes `--map`, whole or not at all.
    fn write_map(&self, curve: &Curve, range_cd_m2: (f64, f64)) -> Result<()> {
        let Some(path) = &self.map else { return Ok(()) };
        let mut text = String::new();
        for (world, display) in curve.sampled(range_cd_m2, MAP_LINES) {
            let _ = writeln!(text, "{world:.6e} {display:.6e}");
        }
        let mut out = Output::create(Some(path), false)?;
        std::io::Write::write_all(&mut out, text.as_bytes()).map_err(|e| out.error(e))?;
        out.finish()
    }
}

/// The factor of a linear map, as Radiance counts exposure.
fn mapped_exposure(display_per_cd_m2: f64) -> Vec<u8> {
    format!("MAPPED_EXPOSURE={:.4e}", display_per_cd_m2 * RADIANCE_EFFICACY).into_bytes()
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
        if let Some(factor) = self.fixed_factor()? {
            header.lines.push(mapped_exposure(factor));
            let factor = factor as f32;
            let scale = move |pixels: &mut [f32]| pixels.iter_mut().for_each(|x| *x *= factor);
            return Ok(Product::Picture(picture::map(input, header, scale)));
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
            return Ok(Product::Picture(picture::map(input, header, |pixels| pixels.fill(0.0))));
        };
        let curve = if self.linear {
            let factor = histogram.linear_factor(display);
            header.lines.push(mapped_exposure(factor / display.max_cd_m2));
            Curve::linear(factor, display)
        } else {
            histogram.adjusted(display)
        };
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
