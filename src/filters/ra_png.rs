//! ra_png: a display-referred picture as PNG.

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::png;
use crate::display::{Display, Transfer};
use crate::filter::{Filter, Product, Run};
use crate::stream::upright::upright;
use crate::stream::{Components, Header, Picture, Units, picture};
use crate::{Error, Result, usage};

/// Options of `ra_png`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaPng {
    /// Display that the picture is for, by name or file: its curve and bits
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath)]
    pub display: Option<Display>,
    /// Bits a component: 8 or 16; the display's, or 8
    #[arg(long, value_name = "N")]
    pub bits: Option<u8>,
    /// Luminance that becomes white, for pictures in cd/m2 that no tone mapping has seen
    #[arg(long, value_name = "CD_M2")]
    pub white_luminance: Option<f64>,
    /// Dither: round up or down by a fixed pattern, so that slow ramps keep their mean
    #[arg(long)]
    pub dither: bool,
    /// The other way: read PNG, or any picture, to a float stream
    #[arg(short, long, conflicts_with_all = ["display", "bits", "white_luminance", "dither"])]
    pub reverse: bool,
}
clap_defaults!(RaPng);

impl Filter for RaPng {
    const NAME: &'static str = "ra_png";
    const ABOUT: &'static str =
        "Write linear RGB for a display as PNG, its curve and colours tagged; -r reads one to a float stream";
    const EXAMPLE: &'static str =
        "pcond < scene.lux | xyz2rgb --gamut desaturate | ra_png > scene.png\nra_png -r scene.png | picinfo";
    const FORMATS: bool = false;

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            return Ok(Product::Picture(input));
        }
        let header = input.header();
        if header.components != Components::Rgb {
            return crate::invalid!("expected RGB, the picture is {}; run xyz2rgb first", header.components);
        }
        let bits = self.bits.or(self.display.as_ref().map(|d| d.bits)).unwrap_or(8);
        if ![8, 16].contains(&bits) {
            return usage!("--bits {bits}: PNG has 8 or 16");
        }
        if let Some(d) = &self.display {
            check_display(d, header)?;
        }
        let transfer = self.display.as_ref().map_or(Transfer::Srgb, |d| d.transfer.clone());
        let range_cd_m2 = self.display.as_ref().map(Display::range).or(header.display).unwrap_or([0.0, 100.0]);
        let factor = match (header.units, self.white_luminance) {
            (Units::Display | Units::Relative, None) => 1.0,
            (Units::Display | Units::Relative, Some(_)) => {
                return usage!("--white-luminance goes with cd/m2; the picture is {}", header.units);
            }
            (_, Some(l)) if l > 0.0 && l.is_finite() => (1.0 / l) as f32,
            (_, Some(l)) => return usage!("--white-luminance {l} must be above 0"),
            (_, None) => {
                return crate::invalid!("the picture is in cd/m2; run pcond first, or give --white-luminance");
            }
        };
        let coding = png::Coding { factor, bits, transfer, range_cd_m2, dither: self.dither };
        let notes = run.notes.clone();
        // What the file's text says: the display, or the luminance that became white.
        let shown = self.display.as_ref().map(Display::range).or(self.white_luminance.map(|l| [0.0, l]));
        let mut header = header.clone();
        header.display = shown.or(header.display);
        let input = picture::map(input, header, |_| {});
        let picture = upright(input, &run.options.limits())?;
        let total = header_pixels(&*picture);
        let write = Box::new(move |out: &mut crate::stream::output::Output| {
            let clipped = png::write(picture, &coding, out)?;
            if clipped.pixels > 0 {
                notes.add(format!(
                    "{} of {total} pixels had components outside 0 to 1 ({:.3} to {:.3}) and were clipped; xyz2rgb --gamut desaturate keeps their hue, ra_exr --float would hold them",
                    clipped.pixels, clipped.range.0, clipped.range.1
                ));
            }
            if clipped.beyond_hlg > 0 {
                notes.add(format!(
                    "{} of {total} pixels are of colours brighter than HLG has at this white, and were clipped",
                    clipped.beyond_hlg
                ));
            }
            Ok(())
        });
        Ok(Product::Bytes { binary: true, write })
    }
}

/// A picture made for another display, or in other primaries, is not for this one.
fn check_display(display: &Display, header: &Header) -> Result<()> {
    header.display.map_or(Ok(()), |range| display.check_range(range))?;
    match header.primaries {
        Some(p) if p.distance(&display.primaries) > 1e-3 => {
            crate::invalid!(
                "the picture has primaries {p}, display {display} has {}; give xyz2rgb --display {display}",
                display.primaries
            )
        }
        _ => Ok(()),
    }
}

fn header_pixels(picture: &dyn Picture) -> u64 {
    let r = picture.header().resolution;
    r.width as u64 * r.height as u64
}
