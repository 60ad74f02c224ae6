//! vonkries: move a picture from the scene's white to the display's, Eq. (6) and (7) of [Ward 2001].

use std::io::Write;

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::{Cat, Mat3, Primaries, White, Xy, adapt, matrix};
use crate::filter::{Filter, Product, Run};
use crate::stream::header::Adapted;
use crate::stream::{Picture, picture, tristimulus};
use crate::{Error, Result, usage};

/// Options of `vonkries`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Vonkries {
    /// White the scene was lit with: an illuminant, x,y, a temperature such as 2856K, or 'header' for the picture's WHITE
    #[arg(long, value_name = "WHITE", default_value = "header")]
    pub from: White,
    /// White to show it under
    #[arg(long, value_name = "WHITE", default_value = "D65")]
    pub to: White,
    /// Sensor matrix
    #[arg(long, value_enum, value_name = "CAT", default_value = "cmccat2000")]
    pub cat: Cat,
    /// Degree of adaptation: 1 complete, 0 none
    #[arg(long, value_name = "D", default_value_t = 1.0)]
    pub degree: f64,
    /// Read no picture; print the XYZ to XYZ matrix, three lines of three numbers
    #[arg(long)]
    pub print: bool,
    /// With --print: concatenated with XYZ to RGB of these primaries, as Eq. (7) has it
    #[arg(long, value_name = "PRIMARIES", num_args = 0..=1, default_missing_value = "BT.709", requires = "print")]
    pub rgb: Option<Primaries>,
}
clap_defaults!(Vonkries);

impl Vonkries {
    fn matrix(&self, from: Xy) -> Result<(Mat3, Xy)> {
        if !(0.0..=1.0).contains(&self.degree) {
            return usage!("--degree {} lies outside 0 to 1", self.degree);
        }
        let to = self.to.xy().ok_or_else(|| Error::Usage("--to needs a white, not 'header'".into()))?;
        Ok((adapt::von_kries(self.cat, from, to, self.degree)?, to))
    }

    fn print(self) -> Result<Product> {
        let from = self.from.xy().ok_or_else(|| Error::Usage("--print needs --from WHITE".into()))?;
        let (mut m, _) = self.matrix(from)?;
        if let Some(primaries) = self.rgb {
            let to_rgb =
                primaries.from_xyz().ok_or_else(|| Error::Usage("--rgb: these primaries span no area".into()))?;
            m = to_rgb.times(&m);
        }
        let text: String = m.0.iter().map(|r| r.map(eight_digits).join(" ") + "\n").collect();
        let write = Box::new(move |out: &mut crate::stream::output::Output| {
            out.write_all(text.as_bytes()).map_err(|e| out.error(e))
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

/// Eight significant digits, plain notation.
fn eight_digits(x: f64) -> String {
    let before_point = if x == 0.0 { 1 } else { x.abs().log10().floor() as i32 + 1 };
    format!("{x:.*}", (8 - before_point).clamp(0, 20) as usize)
}

impl Filter for Vonkries {
    const NAME: &'static str = "vonkries";
    const ABOUT: &'static str = "Adapt a picture from one white point to another (von Kries, Eq. 6)";
    const EXAMPLE: &'static str =
        "vonkries --to D65 < cornell.lux > adapted.lux\nvonkries --from 0.4475,0.4075 --to D65 --print --rgb";

    /// `--print` needs no picture.
    fn reads(&self) -> bool {
        !self.print
    }

    fn start(self, input: Option<Box<dyn Picture>>, _: &Run) -> Result<Product> {
        let Some(input) = input else { return self.print() };
        let input = tristimulus(input)?;
        let from = self.from.xy().or(input.header().white).ok_or_else(|| {
            Error::Invalid("the picture has no WHITE line; say what it was lit with: --from A, --from x,y".into())
        })?;
        let (m, to) = self.matrix(from)?;
        let m = m.to_f32();
        let mut header = input.header().clone();
        header.white = Some(to);
        let cat = self.cat.name();
        header.adapted = Some(Adapted { from, to, cat, degree: self.degree });
        Ok(Product::Picture(picture::map(input, header, move |pixels| matrix::multiply_rows(&m, pixels))))
    }
}
