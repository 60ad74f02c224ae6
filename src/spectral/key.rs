//! A spectrum as a scene names it: a number, a built-in table or a file, inline pairs, a blackbody,
//! daylight, or a glass by formula.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};

use crate::spectral::{Spectrum, builtin, glass, planck, text};
use crate::{Error, Result};

/// What the file says.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumKey {
    /// `0.78`
    Constant(f64),
    /// `"cornell_white"` or `"paint/red.csv"`, a file that [`text`] reads
    Named(String),
    /// `[[400, 0.1], [700, 0.9]]`
    Pairs(Vec<(f64, f64)>),
    /// `{ blackbody = 2856 }`, kelvin
    Blackbody(f64),
    /// `{ daylight = 6504 }`, kelvin
    Daylight(f64),
    /// `{ sellmeier = [B1, B2, B3, C1, C2, C3] }`, um^2
    Sellmeier(Vec<f64>),
    /// `{ cauchy = [A, B, C] }`, um^2 and um^4
    Cauchy(Vec<f64>),
}

impl SpectrumKey {
    /// The spectrum; files are looked for beside the scene.
    pub fn resolve(self, folder: &Path) -> Result<Spectrum> {
        match self {
            SpectrumKey::Constant(c) if c.is_finite() => Ok(Spectrum::Constant(c)),
            SpectrumKey::Constant(c) => Err(Error::Invalid(format!("{c} is not finite"))),
            SpectrumKey::Pairs(points) => Spectrum::from_points(points),
            SpectrumKey::Blackbody(kelvin) => planck::blackbody(kelvin),
            SpectrumKey::Daylight(kelvin) => planck::daylight(kelvin),
            SpectrumKey::Sellmeier(c) => glass::sellmeier(&c),
            SpectrumKey::Cauchy(c) => glass::cauchy(&c),
            SpectrumKey::Named(name) if text::is_file(&name) => {
                let path = folder.join(&name);
                let content = crate::files::read_to_string(&path).map_err(|e| {
                    Error::Invalid(format!("cannot read '{}': {e}", crate::error::printable(name.as_bytes())))
                })?;
                text::parse(&name, &content).map_err(|e| e.within(&crate::error::printable(name.as_bytes())))
            }
            SpectrumKey::Named(name) => builtin::spectrum(&name),
        }
    }
}

/// As a word on a command line or in a CSV cell: a number, a name, or TOML where it begins with a bracket.
///
/// ```
/// use luxpipe::spectral::key::SpectrumKey;
/// assert_eq!("{ blackbody = 2856 }".parse::<SpectrumKey>().unwrap(), SpectrumKey::Blackbody(2856.0));
/// assert_eq!("D65".parse::<SpectrumKey>().unwrap(), SpectrumKey::Named("D65".into()));
/// ```
impl FromStr for SpectrumKey {
    type Err = Error;
    fn from_str(s: &str) -> Result<SpectrumKey> {
        if s.starts_with(['[', '{']) {
            let value = toml::de::ValueDeserializer::parse(s).and_then(SpectrumKey::deserialize);
            let one_line = |m: &str| m.lines().map(str::trim).collect::<Vec<_>>().join(" ");
            return value.map_err(|e| {
                Error::Invalid(format!("'{}': {}", crate::error::printable(s.as_bytes()), one_line(e.message())))
            });
        }
        Ok(s.parse().map_or_else(|_| SpectrumKey::Named(s.to_string()), SpectrumKey::Constant))
    }
}

struct KeyVisitor;

impl<'de> Visitor<'de> for KeyVisitor {
    type Value = SpectrumKey;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, the name of a built-in spectrum, a .csv, .spd or .dat file, [[nm, value], ...], or a table of blackbody = K, daylight = K, sellmeier = [...] or cauchy = [...]")
    }

    fn visit_i64<E>(self, v: i64) -> Result<SpectrumKey, E> {
        Ok(SpectrumKey::Constant(v as f64))
    }

    fn visit_f64<E>(self, v: f64) -> Result<SpectrumKey, E> {
        Ok(SpectrumKey::Constant(v))
    }

    fn visit_str<E>(self, v: &str) -> Result<SpectrumKey, E> {
        Ok(SpectrumKey::Named(v.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<SpectrumKey, A::Error> {
        let mut pairs = Vec::new();
        while let Some([nm, value]) = seq.next_element::<[f64; 2]>()? {
            pairs.push((nm, value));
        }
        Ok(SpectrumKey::Pairs(pairs))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<SpectrumKey, A::Error> {
        let Some(key) = map.next_key::<String>()? else { return Err(A::Error::custom("empty table")) };
        let spectrum = match key.as_str() {
            "blackbody" => SpectrumKey::Blackbody(map.next_value()?),
            "daylight" => SpectrumKey::Daylight(map.next_value()?),
            "sellmeier" => SpectrumKey::Sellmeier(map.next_value()?),
            "cauchy" => SpectrumKey::Cauchy(map.next_value()?),
            _ => return Err(A::Error::unknown_field("other", &["blackbody", "daylight", "sellmeier", "cauchy"])),
        };
        if map.next_key::<String>()?.is_some() {
            return Err(A::Error::custom("expected one key"));
        }
        Ok(spectrum)
    }
}

impl<'de> Deserialize<'de> for SpectrumKey {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(KeyVisitor)
    }
}
