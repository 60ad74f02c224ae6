//! RGB primaries and the matrices that follow from them [SMPTE RP 177; ITU-R BT.709, BT.2020; Radiance `color.h`].

use std::fmt;
use std::str::FromStr;

use super::{Mat3, Xy};
use crate::{Error, Result, string_serde};

/// Chromaticities of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red, green, blue.
    pub rgb: [Xy; 3],
    /// The white that R = G = B shows.
    pub white: Xy,
}

const fn primaries(n: [f64; 8]) -> Primaries {
    Primaries {
        rgb: [Xy { x: n[0], y: n[1] }, Xy { x: n[2], y: n[3] }, Xy { x: n[4], y: n[5] }],
        white: Xy { x: n[6], y: n[7] },
    }
}

/// The named sets, with the spellings that select them.
pub const NAMED: [(&str, Primaries); 8] = [
    ("BT.709", Primaries::BT709),
    ("P3", primaries([0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.3290])),
    ("BT.2020", Primaries::BT2020),
    ("Adobe", primaries([0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290])),
    ("Radiance", Primaries::RADIANCE),
    ("AP0", primaries([0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767])),
    ("AP1", primaries([0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767])),
    ("XYZ", Primaries::XYZ),
];

impl Primaries {
    /// ITU-R BT.709 and sRGB.
    pub const BT709: Primaries = primaries([0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]);
    /// ITU-R BT.2020.
    pub const BT2020: Primaries = primaries([0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.3290]);
    /// Radiance's default: equal-energy white, and not sRGB.
    pub const RADIANCE: Primaries = primaries([0.64, 0.33, 0.29, 0.60, 0.15, 0.06, 1.0 / 3.0, 1.0 / 3.0]);
    /// What a stream of XYZ states.
    pub const XYZ: Primaries = primaries([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.333, 0.333]);

    /// From the eight numbers of a PRIMARIES line; `None` unless they span an area and the white is physical. Radiance's own
    /// as Radiance prints them, to four digits, are its exact ones.
    pub fn from_numbers(n: &[f64]) -> Option<Primaries> {
        let p = primaries(n.try_into().ok()?);
        if p.distance(&Primaries::RADIANCE) <= 5e-5 {
            return Some(Primaries::RADIANCE);
        }
        let finite = n.iter().all(|x| x.is_finite() && x.abs() <= 8.0);
        (finite && p.white.is_physical() && (p.is_xyz() || p.to_xyz().is_some())).then_some(p)
    }

    /// True for the eight numbers that mark XYZ (white given to three digits or more).
    pub fn is_xyz(&self) -> bool {
        self.rgb == Primaries::XYZ.rgb && self.white.distance(Primaries::XYZ.white) < 1e-3
    }

    /// The matrix from linear RGB to XYZ that maps (1,1,1) to the white at Y = 1; `None` when the primaries are
    /// collinear. A primary with y <= 0 (ACES AP0 blue) is legal.
    ///
    /// ```
    /// let y = luxpipe::color::Primaries::BT709.to_xyz().unwrap().0[1];
    /// assert!((y[0] - 0.212639).abs() < 1e-6 && (y[1] - 0.715169).abs() < 1e-6 && (y[2] - 0.072192).abs() < 1e-6);
    /// ```
    pub fn to_xyz(&self) -> Option<Mat3> {
        let columns = self.rgb.map(|p| [p.x, p.y, 1.0 - p.x - p.y]);
        let m = Mat3([0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]]));
        let s = m.inverse()?.apply(self.white.xyz());
        let m = m.times(&Mat3::diagonal(s));
        m.inverse().map(|_| m)
    }

    /// The matrix from XYZ to linear RGB.
    ///
    /// ```
    /// let c709 = luxpipe::color::Primaries::BT709.from_xyz().unwrap().0;
    /// assert!((c709[0][0] - 3.240970).abs() < 1e-6 && (c709[2][1] + 0.203977).abs() < 1e-6);
    /// ```
    pub fn from_xyz(&self) -> Option<Mat3> {
        self.to_xyz()?.inverse()
    }

    /// [`Primaries::from_xyz`] rounded to four decimals, as papers of 2001 print and use it.
    ///
    /// ```
    /// let c709 = luxpipe::color::Primaries::BT709.from_xyz_rounded().unwrap().0;
    /// assert_eq!(c709[0], [3.2410, -1.5374, -0.4986]);
    /// ```
    pub fn from_xyz_rounded(&self) -> Option<Mat3> {
        Some(Mat3(self.from_xyz()?.0.map(|r| r.map(|x| (x * 1e4).round() / 1e4))))
    }

    /// The eight numbers, as a PRIMARIES line holds them.
    pub fn numbers(&self) -> [f64; 8] {
        let [r, g, b] = self.rgb;
        [r.x, r.y, g.x, g.y, b.x, b.y, self.white.x, self.white.y]
    }

    /// Largest difference of any of the eight numbers.
    pub fn distance(&self, other: &Primaries) -> f64 {
        self.numbers().iter().zip(other.numbers()).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs()))
    }
}

impl FromStr for Primaries {
    type Err = Error;
    fn from_str(s: &str) -> Result<Primaries> {
        let plain = |t: &str| t.to_ascii_lowercase().replace(['.', '-', ' ', '_'], "");
        let wanted = match plain(s).as_str() {
            "srgb" | "rec709" | "709" => "bt709".to_string(),
            "displayp3" | "dcip3" => "p3".to_string(),
            "rec2020" | "2020" => "bt2020".to_string(),
            "adobergb" => "adobe".to_string(),
            "acescg" | "acesap1" => "ap1".to_string(),
            "acesap0" => "ap0".to_string(),
            other => other.to_string(),
        };
        if let Some((_, p)) = NAMED.iter().find(|(name, _)| plain(name) == wanted) {
            return Ok(*p);
        }
        let numbers: Option<Vec<f64>> = s.split([',', ' ']).filter(|t| !t.is_empty()).map(|t| t.parse().ok()).collect();
        numbers.as_deref().and_then(Primaries::from_numbers).ok_or_else(|| {
            let names: Vec<_> = NAMED.iter().map(|(n, _)| *n).collect();
            Error::Invalid(format!(
                "'{s}' names no primaries; give one of {} or eight numbers xr,yr,xg,yg,xb,yb,xw,yw that span an area",
                names.join(", ")
            ))
        })
    }
}

impl fmt::Display for Primaries {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some((name, _)) = NAMED.iter().find(|(_, p)| p == self) {
            return f.write_str(name);
        }
        let n = self.numbers().map(|x| x.to_string());
        f.write_str(&n.join(","))
    }
}
string_serde!(Primaries);
