//! ra_pixlog: a picture as Pixar log TIFF; -r goes back to a stream.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::pixarlog::{self, Losses};
use crate::codec::scale::Octaves;
use crate::color::Primaries;
use crate::filter::{Filter, Product, Run};
use crate::filters::{check_master, in_primaries, positive};
use crate::stream::output::Output;
use crate::stream::upright::upright;
use crate::stream::{Block, Picture, Units, spool, writer};
use crate::{Error, Result};

/// Options of `ra_pixlog`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaPixlog {
    /// Primaries of the file; those of an RGB picture, or BT.709
    #[arg(long, value_name = "PRIMARIES")]
    pub to: Option<Primaries>,
    /// cd/m2 of a stored 1; without it the picture is read twice for a power of two, highlights first
    #[arg(long, value_name = "CD_M2")]
    pub stonits: Option<f64>,
    /// Record a display-referred picture all the same
    #[arg(long)]
    pub force: bool,
    /// The other way: read Pixar log TIFF, or any picture, to a float stream
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(RaPixlog);

impl Filter for RaPixlog {
    const NAME: &'static str = "ra_pixlog";
    const ABOUT: &'static str = "Record a picture as Pixar log TIFF: positive RGB of 3.1 orders of magnitude, finely; -r reads one to a float stream";
    const EXAMPLE: &'static str = "ra_pixlog --to BT.2020 scene.hdr scene.tif\nra_pixlog -r scene.tif | picinfo";
    const FORMATS: bool = false;

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        positive("--stonits", self.stonits)?;
        check_master(input.header(), self.force)?;
        let absolute = input.header().units == Units::CdM2 || input.header().sampling.is_some();
        let (input, mut replaced) = writer::bounded(input);
        let mut picture = in_primaries(input, self.to)?;
        let limits = run.options.limits();
        let mut stonits = self.stonits.filter(|_| absolute);
        if absolute && stonits.is_none() {
            let mut octaves = Octaves::default();
            let look = |_: &_, block: &Block| octaves.add(block.data.iter().copied());
            picture = spool::twice(picture, &limits, &run.notes, look)?;
            stonits = Some(octaves.best(pixarlog::BOTTOM, pixarlog::CEILING));
            replaced = writer::settled(&replaced);
        }
        let picture = upright(picture, &limits)?;
        let notes = run.notes.clone();
        let write = Box::new(move |out: &mut Output| {
            let total = writer::pixels(picture.header());
            let mut losses = Losses::default();
            out.attempt(|out| {
                losses = pixarlog::write(picture, stonits, out, &limits, &notes)?;
                Ok(())
            })?;
            let [nan, infinite] = writer::counts(&replaced);
            let scale = stonits.unwrap_or(1.0);
            let parts = [
                (nan, "had NaN set to 0".to_string()),
                (infinite, "had a component infinite or over 1e37".into()),
                (losses.negative, "had a negative component set to 0".into()),
                (losses.over, format!("had a component over {:.4e} set to that", pixarlog::CEILING * scale)),
                (losses.under, format!("were darker than {:.1e} and became black", 3.7e-5 * scale)),
            ];
            writer::note_losses(&parts, total, "ra_loglv would hold every visible colour and luminance", &notes);
            Ok(())
        });
        Ok(Product::Bytes { binary: true, write })
    }
}
