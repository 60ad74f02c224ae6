//! ra_png: a display-referred picture as PNG.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::png;
use crate::filter::{Filter, Product, Run};
use crate::stream::upright::upright;
use crate::stream::{Components, Picture, Units};
use crate::{Error, Result, usage};

/// Options of `ra_png`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RaPng {
    /// Bits a component: 8 or 16
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub bits: u8,
    /// Luminance that becomes white, for pictures in cd/m2 that no tone mapping has seen
    #[arg(long, value_name = "CD_M2")]
    pub white_luminance: Option<f64>,
}
clap_defaults!(RaPng);

impl Filter for RaPng {
    const NAME: &'static str = "ra_png";
    const ABOUT: &'static str = "Write linear RGB for a display as PNG with the sRGB curve, colour space tagged";
    const EXAMPLE: &'static str = "pcond < scene.lux | xyz2rgb --gamut desaturate | ra_png > scene.png";
    const FORMATS: bool = false;

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        let header = input.header();
        if header.components != Components::Rgb {
            return crate::invalid!("expected RGB, the picture is {}; run xyz2rgb first", header.components);
        }
        if ![8, 16].contains(&self.bits) {
            return usage!("--bits {}: PNG has 8 or 16", self.bits);
        }
        let factor = match (header.units, self.white_luminance) {
            (Units::Display, None) => 1.0,
            (Units::Display, Some(_)) => {
                return usage!("--white-luminance goes with cd/m2; the picture is display-referred");
            }
            (_, Some(l)) if l > 0.0 && l.is_finite() => (1.0 / l) as f32,
            (_, Some(l)) => return usage!("--white-luminance {l} must be above 0"),
            (_, None) => {
                return crate::invalid!("the picture is in cd/m2; run pcond first, or give --white-luminance");
            }
        };
        let (bits, notes) = (self.bits, run.notes.clone());
        let picture = upright(input, &run.options.limits())?;
        let total = header_pixels(&*picture);
        let write = Box::new(move |out: &mut crate::stream::output::Output| {
            let clipped = png::write(picture, factor, bits, out)?;
            if clipped.pixels > 0 {
                notes.add(format!(
                    "{} of {total} pixels had components outside 0 to 1 ({:.3} to {:.3}) and were clipped; xyz2rgb --gamut desaturate keeps their hue",
                    clipped.pixels, clipped.range.0, clipped.range.1
                ));
            }
            Ok(())
        });
        Ok(Product::Bytes { binary: true, write })
    }
}

fn header_pixels(picture: &dyn Picture) -> u64 {
    let r = picture.header().resolution;
    r.width as u64 * r.height as u64
}
