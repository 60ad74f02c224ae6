//! ra_loglv: a picture as LogLuv TIFF; -r goes back to a stream.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::logluv::strips::{self, Writing};
use crate::codec::logluv::{Coding, Losses};
use crate::codec::scale::Octaves;
use crate::filter::{Filter, Product, Run};
use crate::filters::{check_master, positive};
use crate::stream::output::Output;
use crate::stream::upright::upright;
use crate::stream::{Components, Picture, Units, picture, spool, tristimulus, writer};
use crate::{Error, Result};

/// Options of `ra_loglv`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaLoglv {
    /// 24-bit words, which hold 4.8 orders of magnitude; reads the picture twice unless --stonits is given
    #[arg(long)]
    pub bits24: bool,
    /// 16 bits of luminance and no colour
    #[arg(long, conflicts_with = "bits24")]
    pub luminance: bool,
    /// cd/m2 of a stored luminance of 1: 1 by default, and for 24 bits a power of two chosen from the picture, highlights first
    #[arg(long, value_name = "CD_M2")]
    pub stonits: Option<f64>,
    /// Spread each code by noise of a step's width, the same for equal pictures
    #[arg(long)]
    pub dither: bool,
    /// Record a display-referred picture all the same
    #[arg(long)]
    pub force: bool,
    /// The other way: read LogLuv TIFF, or any picture, to a float stream
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(RaLoglv);

/// Stored luminances of 24-bit words, less a little at both ends.
const RANGE_24: [f64; 2] = [0.000_243, 15.74];

impl Filter for RaLoglv {
    const NAME: &'static str = "ra_loglv";
    const ABOUT: &'static str =
        "Record a picture as LogLuv TIFF, 32, 24 or 16 bits a pixel; -r reads one to a float stream";
    const EXAMPLE: &'static str =
        "spectrace scenes/cornell.toml | ra_loglv > cornell.tif\nra_loglv -r cornell.tif | vonkries --to D65 | picinfo";
    const FORMATS: bool = false;
    const SUFFIXES: &'static [&'static str] = &["tif", "tiff"];

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        positive("--stonits", self.stonits)?;
        check_master(input.header(), self.force)?;
        let absolute = input.header().units == Units::CdM2 || input.header().sampling.is_some();
        let coding = match (self.bits24, self.luminance || input.header().components == Components::Y) {
            (true, false) => Coding::Log24,
            (true, true) => return Err(Error::Usage("--bits24 holds colours; leave it out for luminance".into())),
            (false, luminance) => {
                if luminance {
                    Coding::LogL16
                } else {
                    Coding::Log32
                }
            }
        };
        let (input, mut replaced) = writer::bounded(input);
        let mut picture = match input.header().components {
            Components::Y => input,
            _ if coding == Coding::LogL16 => luminance(tristimulus(input)?),
            _ => tristimulus(input)?,
        };
        let limits = run.options.limits();
        let mut stonits = absolute.then_some(self.stonits.unwrap_or(1.0));
        if coding == Coding::Log24 && absolute && self.stonits.is_none() {
            let mut octaves = Octaves::default();
            let look = |_: &_, block: &crate::stream::Block| octaves.add(block.data.chunks_exact(3).map(|p| p[1]));
            picture = spool::twice(picture, &limits, &run.notes, look)?;
            stonits = Some(octaves.best(RANGE_24[0], RANGE_24[1]));
            replaced = writer::settled(&replaced);
        }
        let picture = upright(picture, &limits)?;
        let (notes, writing) = (run.notes.clone(), Writing { coding, stonits, dither: self.dither });
        let write = Box::new(move |out: &mut Output| {
            let total = writer::pixels(picture.header());
            let mut losses = Losses::default();
            out.attempt(|out| {
                losses = strips::write(picture, writing, out, &limits, &notes)?;
                Ok(())
            })?;
            report(&losses, writing, &replaced, total, &notes);
            Ok(())
        });
        Ok(Product::Bytes { binary: true, write })
    }
}

/// Y alone.
fn luminance(input: Box<dyn Picture>) -> Box<dyn Picture> {
    let mut header = input.header().clone();
    (header.components, header.ncomp) = (Components::Y, 1);
    picture::map_across(input, header, |from, to| {
        to.iter_mut().zip(from.chunks_exact(3)).for_each(|(y, xyz)| *y = xyz[1]);
    })
}

/// One line for all that the encoding could not hold.
fn report(losses: &Losses, writing: Writing, replaced: &writer::Replaced, total: u64, notes: &crate::notes::Notes) {
    let Losses { over, under, negative, chroma } = *losses;
    let small = writing.coding == Coding::Log24;
    let scale = writing.stonits.unwrap_or(1.0);
    let (bottom, top) = if small { (2.43e-4 * scale, 15.9 * scale) } else { (5.4e-20 * scale, 1.8e19 * scale) };
    let [nan, infinite] = writer::counts(replaced);
    let parts = [
        (nan, "had NaN set to black".to_string()),
        (infinite, "had a component infinite or over 1e37".into()),
        (over, format!("were brighter than {top:.2e} and set to that")),
        (under, format!("were darker than {bottom:.2e} and set to black")),
        (negative, "had negative luminance, which reads back as black".into()),
        (chroma, "had a chromaticity outside the encoding's and were moved to its edge".into()),
    ];
    let hint = if small && nan + negative == 0 { "LogLuv of 32 bits (without --bits24)" } else { "ra_exr --float" };
    writer::note_losses(&parts, total, &format!("{hint} would hold more"), notes);
}
