//! ra_pfm: a picture as a portable float map; -r goes back to a stream.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::pfm;
use crate::color::Primaries;
use crate::filter::{Filter, Product, Run};
use crate::filters::in_primaries;
use crate::stream::output::Output;
use crate::stream::upright::upright;
use crate::stream::{Components, Picture, tristimulus, writer};
use crate::{Error, Result};

/// Options of `ra_pfm`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaPfm {
    /// Primaries for XYZ and spectra that become RGB; XYZ writes them as they are
    #[arg(long, value_name = "PRIMARIES", default_value = "BT.709")]
    pub to: Primaries,
    /// Most significant byte first
    #[arg(long)]
    pub big_endian: bool,
    /// The other way: read PFM, or any picture, to a float stream
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(RaPfm);

impl Filter for RaPfm {
    const NAME: &'static str = "ra_pfm";
    const ABOUT: &'static str =
        "Write a picture as PFM, plain floats bottom up, which keeps no header; -r reads one to a float stream";
    const EXAMPLE: &'static str = "ra_pfm scene.hdr scene.pfm\nra_pfm -r scene.pfm | picinfo";
    const FORMATS: bool = false;
    const SUFFIXES: &'static [&'static str] = &["pfm"];

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        // A matrix would make NaN of infinities, and few readers of the format expect either.
        let (input, replaced) = writer::bounded(input);
        let picture = match input.header().components {
            Components::Y => input,
            _ if self.to.is_xyz() => tristimulus(input)?,
            _ => in_primaries(input, Some(self.to))?,
        };
        let limits = run.options.limits();
        let picture = upright(picture, &limits)?;
        let notes = run.notes.clone();
        let write = Box::new(move |out: &mut Output| {
            let total = writer::pixels(picture.header());
            out.attempt(|out| pfm::write(picture, self.big_endian, out, &limits, &notes))?;
            let [nan, infinite] = writer::counts(&replaced);
            let parts = [
                (nan, "had NaN set to 0".to_string()),
                (infinite, "had a component infinite or over 1e37 set to that".into()),
            ];
            writer::note_losses(&parts, total, "a float stream holds all numbers", &notes);
            Ok(())
        });
        Ok(Product::Bytes { binary: true, write })
    }
}
