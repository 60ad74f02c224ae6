//! CIE chromaticities [CIE15].

use std::fmt;
use std::str::FromStr;

use crate::{Error, Result, string_serde};

/// CIE 1931 chromaticity coordinates, x and y both in 0..1, y above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Xy {
    /// X / (X + Y + Z)
    pub x: f64,
    /// Y / (X + Y + Z)
    pub y: f64,
}

impl Xy {
    /// Equal-energy white.
    pub const E: Xy = Xy { x: 1.0 / 3.0, y: 1.0 / 3.0 };
    /// D65 as ITU-R BT.709 and sRGB print it.
    pub const D65: Xy = Xy { x: 0.3127, y: 0.3290 };

    /// Tristimulus values of this chromaticity at Y = 1.
    ///
    /// ```
    /// let xyz = luxpipe::color::Xy::D65.xyz();
    /// assert!((xyz[0] - 0.95046).abs() < 1e-5 && xyz[1] == 1.0 && (xyz[2] - 1.08906).abs() < 1e-5);
    /// ```
    pub fn xyz(self) -> [f64; 3] {
        [self.x / self.y, 1.0, (1.0 - self.x - self.y) / self.y]
    }

    /// Chromaticity of tristimulus values; `None` where the sum or Y is not positive and finite.
    pub fn of(xyz: [f64; 3]) -> Option<Xy> {
        let sum = xyz[0] + xyz[1] + xyz[2];
        (sum > 0.0 && sum.is_finite() && xyz[1] > 0.0).then(|| Xy { x: xyz[0] / sum, y: xyz[1] / sum })
    }

    /// Largest difference of a coordinate.
    pub fn distance(self, other: Xy) -> f64 {
        (self.x - other.x).abs().max((self.y - other.y).abs())
    }

    /// True for a chromaticity that a light can have: finite, y above 0, inside the unit triangle with room for rounding.
    pub fn is_physical(self) -> bool {
        self.x > -1e-6 && self.y > 0.0 && self.x + self.y < 1.0 + 1e-6
    }
}

impl FromStr for Xy {
    type Err = Error;
    fn from_str(s: &str) -> Result<Xy> {
        let n: Vec<f64> = s
            .split([',', ' '])
            .filter(|t| !t.is_empty())
            .map(|t| t.parse())
            .collect::<Result<_, _>>()
            .map_err(|_| Error::Invalid(format!("'{s}' is not a chromaticity; give x,y such as 0.3127,0.3290")))?;
        match n[..] {
            [x, y] if (Xy { x, y }).is_physical() => Ok(Xy { x, y }),
            [_, _] => {
                Err(Error::Invalid(format!("chromaticity {s} lies outside the triangle x >= 0, y > 0, x + y <= 1")))
            }
            _ => Err(Error::Invalid(format!("'{s}' is not a chromaticity; give x,y such as 0.3127,0.3290"))),
        }
    }
}

impl fmt::Display for Xy {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{},{}", self.x, self.y)
    }
}
string_serde!(Xy);
