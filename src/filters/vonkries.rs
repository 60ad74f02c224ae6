//! vonkries: move a picture from the scene's white to the display's, Eq. (6) and (7) of [Ward 2001].

use std::io::Write;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::adapt::{self, Degree};
use crate::color::estimate::WhiteEstimate;
use crate::color::{Cat, Mat3, Primaries, White, Xy, matrix};
use crate::display::Display;
use crate::filter::{Filter, Product, Run};
use crate::stream::header::Adapted;
use crate::stream::{Picture, picture, spool, tristimulus};
use crate::{Error, Result, usage};

/// Options of `vonkries`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Vonkries {
    /// White the scene was lit with: an illuminant, x,y, a temperature such as 2856K, 'header' for the picture's WHITE, or a
    /// guess: 'auto' from its brightest hundredth, 'grey' from the mean of all (these read the picture twice)
    #[arg(long, value_name = "WHITE", default_value = "header")]
    pub from: White,
    /// White to show it under
    #[arg(long, value_name = "WHITE", default_value = "D65")]
    pub to: White,
    /// Display to show it on, by name or file: its white in place of --to
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with = "to")]
    pub display: Option<Display>,
    /// Sensor matrix
    #[arg(long, value_enum, value_name = "CAT", default_value = "cmccat2000")]
    pub cat: Cat,
    /// Degree of adaptation: 1 complete, 0 none, or 'auto' by CMCCAT2000's formula from --la and --ld
    #[arg(long, value_name = "D", default_value = "1")]
    pub degree: Degree,
    /// Luminance that an eye in the scene is adapted to, cd/m2
    #[arg(long, value_name = "CD_M2", default_value_t = 100.0)]
    pub la: f64,
    /// Luminance that an eye before the display is adapted to, cd/m2
    #[arg(long, value_name = "CD_M2", default_value_t = 20.0)]
    pub ld: f64,
    /// Factor F of that formula: 1 in an average surround, 0.8 in a dim or dark one
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub surround: f64,
    /// Read no picture; print the XYZ to XYZ matrix, three lines of three numbers
    #[arg(long)]
    pub print: bool,
    /// With --print: concatenated with XYZ to RGB of these primaries, as Eq. (7) has it
    #[arg(long, value_name = "PRIMARIES", num_args = 0..=1, default_missing_value = "BT.709", requires = "print")]
    pub rgb: Option<Primaries>,
}
clap_defaults!(Vonkries);

impl Vonkries {
    fn degree(&self) -> Result<f64> {
        let default = Vonkries::default();
        let luminances = (self.la, self.ld, self.surround) != (default.la, default.ld, default.surround);
        match self.degree {
            Degree::Fixed(_) if luminances => usage!("--la, --ld and --surround go with --degree auto"),
            Degree::Fixed(d) => Ok(d),
            Degree::Auto
                if [self.la, self.ld].iter().all(|l| (1e-6..1e9).contains(l))
                    && (0.0..=1.0).contains(&self.surround) =>
            {
                Ok(adapt::cmccat2000_degree(self.la, self.ld, self.surround))
            }
            Degree::Auto => usage!("--la and --ld must be luminances above 0, --surround 0 to 1"),
        }
    }

    fn matrix(&self, from: Xy) -> Result<(Mat3, Xy)> {
        let to = match &self.display {
            Some(d) => d.primaries.white,
            None => self.to.xy().ok_or_else(|| Error::Usage("--to needs a white, not one of a picture".into()))?,
        };
        Ok((adapt::von_kries(self.cat, from, to, self.degree()?)?, to))
    }

    /// The source white, and the picture ready to be read.
    fn source(&self, input: Box<dyn Picture>, run: &Run) -> Result<(Xy, Box<dyn Picture>)> {
        if let White::Fixed(_, xy) = self.from {
            return Ok((xy, input));
        }
        if self.from == White::Header {
            let missing =
                "the picture has no WHITE line; say what it was lit with: --from A, --from x,y, or guess: --from auto";
            return Ok((input.header().white.ok_or_else(|| Error::Invalid(missing.into()))?, input));
        }
        let mut estimate = WhiteEstimate::default();
        let input = spool::twice(input, &run.options.limits(), &run.notes, |_, block| estimate.add(&block.data))?;
        let (guess, how) = match self.from {
            White::Auto => (estimate.brightest(), "brightest hundredth"),
            _ => (estimate.grey(), "mean of all pixels"),
        };
        let missing = "no white can be guessed: no pixel has the colour of a light";
        let xy = guess.filter(|xy| xy.is_physical()).ok_or_else(|| Error::Invalid(missing.into()))?;
        run.notes.add(format!("white {:.4},{:.4} guessed from the {how}", xy.x, xy.y));
        Ok((xy, input))
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
    let x = if x.abs() < 1e-14 { 0.0 } else { x }; // rounding of an identity
    // The exponent after rounding: 0.999999999 is 1.0000000.
    let exponent = format!("{x:.7e}").split_once('e').and_then(|e| e.1.parse::<i32>().ok()).unwrap_or(0);
    format!("{x:.*}", (7 - exponent).clamp(0, 20) as usize)
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

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let Some(input) = input else { return self.print() };
        let input = tristimulus(input)?;
        let (from, input) = self.source(input, run)?;
        let (m, to) = self.matrix(from)?;
        let m = m.to_f32();
        let mut header = input.header().clone();
        header.white = Some(to);
        let cat = self.cat.name();
        header.adapted = Some(Adapted { from, to, cat, degree: self.degree()? });
        Ok(Product::Picture(picture::map(input, header, move |pixels| matrix::multiply_rows_finite(&m, pixels))))
    }
}
