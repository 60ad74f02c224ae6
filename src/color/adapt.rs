//! White-point adaptation by the von Kries rule, Eq. (6) of [Ward 2001]: scale the cone-like responses so that the source
//! white becomes the destination white.

use std::fmt;
use std::str::FromStr;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::{Mat3, Xy};
use crate::{Error, Result, invalid, string_serde};

/// The sensor sharpening matrix behind an adaptation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Cat {
    /// CMCCAT2000, as Eq. (6) prints it (Li, Luo, Rigg 2000)
    Cmccat2000,
    /// Hunt-Pointer-Estevez cones, equal-energy normalised
    Vonkries,
    /// Bradford, linearised (Lam 1985)
    Bradford,
    /// Spectrally sharpened sensors (Finlayson, Suesstrunk 2000), the matrix Radiance uses
    Sharp,
    /// CIECAM02
    Cat02,
    /// CAM16 (Li et al. 2017)
    Cat16,
}

impl Cat {
    /// As the command line spells it.
    pub fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |v| v.get_name().to_string())
    }

    /// XYZ to sensor responses.
    pub fn matrix(self) -> Mat3 {
        Mat3(match self {
            Cat::Cmccat2000 => [[0.7982, 0.3389, -0.1371], [-0.5918, 1.5512, 0.0406], [0.0008, 0.0239, 0.9753]],
            Cat::Vonkries => [[0.38971, 0.68898, -0.07868], [-0.22981, 1.18340, 0.04641], [0.0, 0.0, 1.0]],
            Cat::Bradford => [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]],
            Cat::Sharp => [[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]],
            Cat::Cat02 => [[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]],
            Cat::Cat16 => {
                [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]]
            }
        })
    }
}

/// How complete an adaptation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Degree {
    /// 1 complete, 0 none.
    Fixed(f64),
    /// By CMCCAT2000's formula from the luminances that the eye is adapted to.
    Auto,
}

impl FromStr for Degree {
    type Err = Error;
    fn from_str(s: &str) -> Result<Degree> {
        match s.parse() {
            _ if s == "auto" => Ok(Degree::Auto),
            Ok(d) if (0.0..=1.0).contains(&d) => Ok(Degree::Fixed(d)),
            _ => Err(Error::Invalid(format!("degree '{s}': expected 0 to 1, or auto"))),
        }
    }
}

impl fmt::Display for Degree {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Degree::Fixed(d) => write!(f, "{d}"),
            Degree::Auto => f.write_str("auto"),
        }
    }
}
string_serde!(Degree);

/// Degree of adaptation of CMCCAT2000 [Li 2000]: D = F (0.08 lg((La + Ld) / 2) + 0.76 - 0.45 (La - Ld) / (La + Ld)), held
/// to 0..1. La and Ld are the luminances of the adapting fields of the scene and of the display, cd/m2; F is 1 in an
/// average surround, 0.8 in a dim or dark one.
///
/// ```
/// let d = luxpipe::color::adapt::cmccat2000_degree(100.0, 100.0, 1.0);
/// assert!((d - 0.92).abs() < 1e-12);
/// ```
pub fn cmccat2000_degree(la_cd_m2: f64, ld_cd_m2: f64, surround: f64) -> f64 {
    let sum = la_cd_m2 + ld_cd_m2;
    (surround * (0.08 * (sum / 2.0).log10() + 0.76 - 0.45 * (la_cd_m2 - ld_cd_m2) / sum)).clamp(0.0, 1.0)
}

/// Gains beyond this turn noise into colour: such a white is refused.
const LARGEST_GAIN: f64 = 100.0;

/// Eq. (6): the matrix that takes XYZ seen under white `from` to XYZ seen under white `to`, both at Y = 1, with the given
/// degree of adaptation (1 complete, 0 none; the gains are 1 + degree x (gain - 1)).
///
/// Errors: a white whose sensor response is not positive, or that asks for a gain over 100 or under 1/100.
///
/// ```
/// use luxpipe::color::{Cat, Xy, adapt::von_kries};
/// let m = von_kries(Cat::Cmccat2000, Xy { x: 0.4475, y: 0.4075 }, Xy::D65, 1.0).unwrap();
/// let white = m.apply(Xy { x: 0.4475, y: 0.4075 }.xyz());
/// assert!((white[0] - Xy::D65.xyz()[0]).abs() < 1e-12 && (white[1] - 1.0).abs() < 1e-12);
/// ```
pub fn von_kries(cat: Cat, from: Xy, to: Xy, degree: f64) -> Result<Mat3> {
    let m = cat.matrix();
    let (source, target) = (m.apply(from.xyz()), m.apply(to.xyz()));
    let mut gain = [1.0; 3];
    for (i, name) in ["red", "green", "blue"].iter().enumerate() {
        for (white, response) in [(from, source[i]), (to, target[i])] {
            if response.is_nan() || response <= 0.0 {
                return invalid!("white {white} has a {name} sensor response of {response:.8}; it must be above 0");
            }
        }
        gain[i] = 1.0 + degree * (target[i] / source[i] - 1.0);
        if !(1.0 / LARGEST_GAIN..=LARGEST_GAIN).contains(&gain[i]) {
            return invalid!(
                "adapting {from} to {to} multiplies the {name} sensor by {:.4}; 0.01 to 100 is sensible, choose another white",
                gain[i]
            );
        }
    }
    let inverse = m.inverse().unwrap_or(Mat3::IDENTITY); // the six matrices above are regular
    Ok(inverse.times(&Mat3::diagonal(gain)).times(&m))
}
