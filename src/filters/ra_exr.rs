//! ra_exr: a picture as OpenEXR; -r goes back to a stream.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::exr::{self, Compression, Depth};
use crate::color::Primaries;
use crate::filter::{Filter, Product, Run};
use crate::stream::output::Output;
use crate::stream::upright::upright;
use crate::stream::writer::Replaced;
use crate::stream::{Components, Picture, tristimulus, writer};
use crate::{Error, Result, invalid, usage};

/// Options of `ra_exr`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaExr {
    /// 32 bits a sample, every number as it is (the default for spectra)
    #[arg(long)]
    pub float: bool,
    /// 16 bits a sample, up to 65504, to 1 in 2048 (the default for colour and luminance)
    #[arg(long, conflicts_with = "float")]
    pub half: bool,
    /// Primaries to write, or XYZ; without it RGB keeps its own, XYZ becomes BT.709, spectra stay spectra
    #[arg(long, value_name = "PRIMARIES")]
    pub to: Option<Primaries>,
    /// How blocks of rows are compressed, all without loss
    #[arg(long, value_enum, value_name = "HOW", default_value = "zip")]
    pub compression: Compression,
    /// Divide by this luminance, which the file records; otherwise a half picture is scaled only if it must be
    #[arg(long, value_name = "CD_M2")]
    pub white_luminance: Option<f64>,
    /// The other way: read OpenEXR, or any picture, to a float stream
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(RaExr);

impl Filter for RaExr {
    const NAME: &'static str = "ra_exr";
    const ABOUT: &'static str =
        "Write a picture as OpenEXR, half or float, spectra in the published layout; -r reads one to a float stream";
    const EXAMPLE: &'static str = "ra_exr scene.hdr scene.exr\nra_exr -r scene.exr | picinfo";
    const FORMATS: bool = false;
    const SUFFIXES: &'static [&'static str] = &["exr"];

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        let white_luminance = self.white_luminance.map(|l| l as f32);
        if white_luminance.is_some_and(|l| !(1e-30..=1e30).contains(&l)) {
            return usage!("--white-luminance {}: expected cd/m2 above 0", self.white_luminance.unwrap_or_default());
        }
        let spectral = |c| matches!(c, Components::Spectrum | Components::Stokes);
        let (picture, replaced) = self.colours(input)?;
        let float = self.float || (spectral(picture.header().components) && !self.half);
        let depth = if float { Depth::Float } else { Depth::Half };
        let options = exr::Options { depth, compression: self.compression, white_luminance };
        let limits = run.options.limits();
        let picture = upright(picture, &limits)?;
        let notes = run.notes.clone();
        let write = Box::new(move |out: &mut Output| {
            out.attempt(|out| exr::write(picture, replaced, options, out, &limits, &notes))
        });
        Ok(Product::Bytes { binary: true, write })
    }
}

impl RaExr {
    /// The picture in the colours it is written in.
    fn colours(&self, input: Box<dyn Picture>) -> Result<(Box<dyn Picture>, Option<Replaced>)> {
        let header = input.header();
        let to = match (header.components, self.to) {
            (Components::Response, _) => {
                return invalid!("a picture of {} is no colour and no spectrum", header.components);
            }
            (Components::Xyz, None) => Primaries::BT709,
            (Components::Xyz, Some(to)) if to.is_xyz() => return Ok((input, None)),
            (Components::Rgb, Some(to)) if header.primaries == Some(to) => return Ok((input, None)),
            (_, None) => return Ok((input, None)),
            (_, Some(to)) => to,
        };
        // A matrix would make NaN of infinities.
        let (input, replaced) = writer::bounded(input);
        let xyz = tristimulus(input)?;
        let picture = if to.is_xyz() { xyz } else { writer::to_rgb(xyz, to)? };
        Ok((picture, Some(replaced)))
    }
}
