//! xyz2rgb: tristimulus values to linear RGB, Eq. (5) of [Ward 2001], and back.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::gamut::{self, Gamut, Limit};
use crate::color::{Primaries, matrix};
use crate::filter::{Filter, Product, Run};
use crate::stream::{Components, Picture, Units, picture, tristimulus};
use crate::{Error, Result, invalid};

/// Options of `xyz2rgb`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Xyz2rgb {
    /// Primaries of the RGB: BT.709, P3, BT.2020, Adobe, Radiance, AP0, AP1, or eight numbers
    #[arg(long, value_name = "PRIMARIES", default_value = "BT.709")]
    pub to: Primaries,
    /// What to do with colours that these primaries cannot make
    #[arg(long, value_enum, value_name = "HOW", default_value = "none")]
    pub gamut: Gamut,
    /// The other way: RGB to XYZ
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(Xyz2rgb);

/// Whites further apart than this in x or y are worth a word.
const SAME_WHITE: f64 = 0.003;

impl Filter for Xyz2rgb {
    const NAME: &'static str = "xyz2rgb";
    const ABOUT: &'static str = "Convert XYZ to linear RGB of any primaries, bring it into their gamut; -r goes back";
    const EXAMPLE: &'static str = "pcond < scene.lux | xyz2rgb --gamut desaturate | ra_png > scene.png";

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            if input.header().components != Components::Rgb {
                return invalid!("-r expects RGB, the picture is {}", input.header().components);
            }
            return tristimulus(input).map(Product::Picture);
        }
        let input = tristimulus(input)?;
        let mut header = input.header().clone();
        let span = || Error::Usage("--to: these primaries span no area".into());
        let m = self.to.from_xyz().ok_or_else(span)?.to_f32();
        let y = self.to.to_xyz().ok_or_else(span)?.0[1].map(|x| x as f32);
        if let Some(white) = header.white.filter(|w| w.distance(self.to.white) > SAME_WHITE) {
            run.notes.add(format!(
                "the picture's white is {white}, that of {} is {}; vonkries adapts, xyz2rgb does not",
                self.to, self.to.white
            ));
        }
        let limit = if header.units == Units::Display { Limit::Unit } else { Limit::Positive };
        header.become_tristimulus(Components::Rgb, header.units);
        header.primaries = Some(self.to);
        let gamut = self.gamut;
        let convert = move |pixels: &mut [f32]| {
            matrix::for_planes(
                pixels,
                #[inline(always)]
                |p| {
                    *p = matrix::multiply_planes(&m, p);
                    match gamut {
                        Gamut::None => {}
                        Gamut::Clip => gamut::clip(p, limit),
                        Gamut::Desaturate => gamut::desaturate(p, &y, limit),
                    }
                },
            )
        };
        Ok(Product::Picture(picture::map(input, header, convert)))
    }
}
