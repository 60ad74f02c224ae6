//! White points by name, chromaticity or colour temperature.

use std::fmt;
use std::str::FromStr;

use super::Xy;
use crate::spectral::{Observer, builtin, planck};
use crate::{Error, Result, string_serde};

/// Published chromaticities for the 2-degree observer [CIE15, table T.3; ITU-R BT.709 for D65]. Other illuminants are
/// integrated from their spectrum.
const PUBLISHED: [(&str, Xy); 8] = [
    ("A", Xy { x: 0.44758, y: 0.40745 }),
    ("B", Xy { x: 0.34842, y: 0.35161 }),
    ("C", Xy { x: 0.31006, y: 0.31616 }),
    ("D50", Xy { x: 0.34567, y: 0.35850 }),
    ("D55", Xy { x: 0.33242, y: 0.34743 }),
    ("D65", Xy::D65),
    ("D75", Xy { x: 0.29902, y: 0.31485 }),
    ("E", Xy::E),
];

/// How a user names a white.
#[derive(Clone, Debug, PartialEq)]
pub enum White {
    /// A standard illuminant, a chromaticity or a temperature, with the spelling it came in.
    Fixed(String, Xy),
    /// The picture's own WHITE.
    Header,
    /// The mean colour of its brightest hundredth.
    Auto,
    /// The mean colour of all its pixels.
    Grey,
}

impl White {
    /// The chromaticity; `None` where a picture has to be asked.
    pub fn xy(&self) -> Option<Xy> {
        match self {
            White::Fixed(_, xy) => Some(*xy),
            White::Header | White::Auto | White::Grey => None,
        }
    }
}

/// Chromaticity of an illuminant by name, in any case.
pub fn illuminant(name: &str) -> Option<Xy> {
    if let Some((_, xy)) = PUBLISHED.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)) {
        return Some(*xy);
    }
    builtin::text(&format!("illuminant_{name}"))?;
    let spectrum = builtin::spectrum(&format!("illuminant_{name}")).ok()?;
    Xy::of(Observer::cie1931().ok()?.integrate(&spectrum))
}

/// Chromaticity of a colour temperature: the Planckian locus below 4000 K, the daylight locus from there on.
fn temperature(kelvin: f64) -> Result<Xy> {
    if kelvin >= 4000.0 {
        planck::daylight(kelvin)?;
        let (x, y) = planck::daylight_xy(kelvin);
        return Ok(Xy { x, y });
    }
    Xy::of(Observer::cie1931()?.integrate(&planck::blackbody(kelvin)?))
        .ok_or_else(|| Error::Invalid(format!("a blackbody of {kelvin} K has no visible light")))
}

impl FromStr for White {
    type Err = Error;
    fn from_str(s: &str) -> Result<White> {
        match s.to_ascii_lowercase().as_str() {
            "header" => return Ok(White::Header),
            "auto" => return Ok(White::Auto),
            "grey" | "gray" => return Ok(White::Grey),
            _ => {}
        }
        let fixed = |xy| White::Fixed(s.to_string(), xy);
        if let Some(xy) = illuminant(s) {
            return Ok(fixed(xy));
        }
        if let Some(kelvin) = s.strip_suffix(['K', 'k']).and_then(|t| t.parse().ok()) {
            return temperature(kelvin).map(fixed);
        }
        if s.contains(',') {
            return s.parse().map(fixed);
        }
        Err(Error::Invalid(format!(
            "'{}' names no white; give an illuminant (A, B, C, D50, D65, E, FL11, LED-B3 ...), x,y, a temperature such as 2856K, header, auto or grey",
            crate::error::printable(s.as_bytes())
        )))
    }
}

impl fmt::Display for White {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            White::Fixed(name, _) => name,
            White::Header => "header",
            White::Auto => "auto",
            White::Grey => "grey",
        })
    }
}
string_serde!(White);

#[cfg(test)]
mod tests {
    use super::*;

    /// The published whites agree with the spectra they belong to.
    #[test]
    fn published_whites_follow_from_their_spectra() {
        let observer = Observer::cie1931().unwrap();
        for (name, xy) in PUBLISHED {
            let spectrum = builtin::spectrum(&format!("illuminant_{name}")).unwrap();
            let got = Xy::of(observer.integrate(&spectrum)).unwrap();
            assert!(got.distance(xy) < 1e-4, "{name}: {got} is not {xy}");
        }
    }
}
