//! Displays: what a medium can show, as a TOML file. `displays/` ships some; a path names another.

pub mod fit;
pub mod macbeth;
pub mod readings;
pub mod transfer;

use std::f64::consts::PI;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use toml::de::DeValue;

use crate::color::{Mat3, Primaries, Xy};
use crate::keys::{self, Keys};
use crate::{Error, Result, string_serde};

pub use transfer::Transfer;

static FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/displays.rs"));

/// Contrast beyond which black counts as this part of white.
const LARGEST_CONTRAST: f64 = 1e6;

/// One description of a medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Display {
    /// The name or file it was asked for by.
    pub name: String,
    /// Primaries and white.
    pub primaries: Primaries,
    /// Luminance of white, ambient light included, cd/m2.
    pub white_cd_m2: f64,
    /// Luminance of black, ambient light included, cd/m2.
    pub black_cd_m2: f64,
    /// Light to code values.
    pub transfer: Transfer,
    /// Bits a component.
    pub bits: u8,
}

impl Display {
    /// The shipped displays' names.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|f| f.0)
    }

    /// Black and white as a DISPLAY line has them.
    pub fn range(&self) -> [f64; 2] {
        [self.black_cd_m2, self.white_cd_m2]
    }

    /// True when a stream mapped for `range` was mapped for this display.
    pub fn shows(&self, range: [f64; 2]) -> bool {
        range.iter().zip(self.range()).all(|(a, b)| (a - b).abs() <= 1e-3 * b)
    }

    /// XYZ in cd/m2 that codes 0..1 show: black, of white's chromaticity, and the primaries' light above it.
    ///
    /// ```
    /// let d: luxpipe::display::Display = "srgb".parse().unwrap();
    /// assert!((d.light([1.0; 3])[1] - d.white_cd_m2).abs() < 1e-9 && (d.light([0.0; 3])[1] - d.black_cd_m2).abs() < 1e-9);
    /// ```
    pub fn light(&self, codes: [f64; 3]) -> [f64; 3] {
        let [black, white] = self.range();
        let m = self.primaries.to_xyz().unwrap_or(Mat3::IDENTITY); // a display's primaries span an area
        let over = m.apply(self.transfer.light(codes, (black, white), m.0[1]));
        let neutral = self.primaries.white.xyz();
        [0, 1, 2].map(|i| over[i] * (white - black) + neutral[i] * black)
    }

    /// The keys of its file, ambient light within `lmax` and `lmin`.
    pub fn to_toml(&self) -> String {
        let p = self.primaries.numbers().map(|x| significant(x, 6)).join(",");
        let transfer = match &self.transfer {
            Transfer::Srgb => "\"srgb\"".to_string(),
            Transfer::Pq => "\"pq\"".to_string(),
            Transfer::Hlg => "\"hlg\"".to_string(),
            Transfer::Gamma(g) => format!("{{ gamma = {} }}", significant(*g, 5)),
            Transfer::Table(light) => {
                let rows: Vec<String> = light.chunks(8).map(|r| list(r.iter())).collect();
                format!("{{ table = [\n  {}\n] }}", rows.join(",\n  "))
            }
        };
        format!(
            "primaries = \"{p}\"\nlmax = {}\nlmin = {}\nambient_lux = 0\nreflectance = 0\ntransfer = {transfer}\nbits = {}\n",
            significant(self.white_cd_m2, 7),
            significant(self.black_cd_m2, 7),
            self.bits
        )
    }

    /// Refuses a picture that was mapped for another display's range.
    pub fn check_range(&self, range: [f64; 2]) -> Result<()> {
        if self.shows(range) {
            return Ok(());
        }
        crate::invalid!(
            "the picture was mapped for {} to {} cd/m2, display {self} shows {:.4} to {:.4}; give pcond --display {self}",
            range[0],
            range[1],
            self.black_cd_m2,
            self.white_cd_m2
        )
    }

    fn parse(name: &str, text: &str) -> Result<Display> {
        let mut k = keys::parse(text)?;
        let (primaries, span) =
            k.get_spanned::<Primaries>("primaries")?.ok_or_else(|| k.wrong("key 'primaries' is missing"))?;
        let white = k.get::<Xy>("white")?.unwrap_or(primaries.white);
        let primaries = Primaries { white, ..primaries };
        if primaries.is_xyz() || primaries.to_xyz().is_none() {
            return Err(k.wrong_key("primaries", span, "span no area"));
        }
        let luminance = |x: f64| (0.0..=1e6).contains(&x);
        let lmax = k.number("lmax", "must be a luminance above 0 in cd/m2", |x| luminance(x) && x > 0.0)?;
        let lmin = k.number("lmin", "must be a luminance from 0 in cd/m2", luminance)?;
        let lux = k.number("ambient_lux", "must be 0 to 1000000", luminance)?.unwrap_or(0.0);
        let reflectance = k.number("reflectance", "must be 0 to 1", |x| (0.0..=1.0).contains(&x))?.unwrap_or(0.0);
        let (Some(lmax), Some(lmin)) = (lmax, lmin) else { return Err(k.wrong("keys 'lmax' and 'lmin' are needed")) };
        let transfer = transfer(&mut k)?;
        let bits = k.number("bits", "must be 8 or 16", |x| x == 8.0 || x == 16.0)?.unwrap_or(8.0) as u8;
        let veil = lux * reflectance / PI;
        let white_cd_m2 = lmax + veil;
        // A black without light has no logarithm; a millionth of white is as black as can be told.
        let black_cd_m2 = (lmin + veil).max(white_cd_m2 / LARGEST_CONTRAST);
        if lmax <= lmin {
            return Err(k.wrong("lmin must be below lmax"));
        }
        k.finish()?;
        Ok(Display { name: name.to_string(), primaries, white_cd_m2, black_cd_m2, transfer, bits })
    }
}

fn list<'a>(numbers: impl Iterator<Item = &'a f64>) -> String {
    numbers.map(|x| significant(*x, 8)).collect::<Vec<_>>().join(", ")
}

/// A number rounded to so many digits, plain notation.
fn significant(x: f64, digits: i32) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let after_point = (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 17) as usize;
    let text = format!("{x:.after_point$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

fn transfer(k: &mut Keys) -> Result<Transfer> {
    let Some(value) = k.take("transfer") else { return Ok(Transfer::Srgb) };
    let span = value.span();
    let wrong = |message: &str| k.wrong_key("transfer", span.clone(), message);
    match value.into_inner() {
        DeValue::String(s) => match s.as_ref() {
            "srgb" => Ok(Transfer::Srgb),
            "pq" => Ok(Transfer::Pq),
            "hlg" => Ok(Transfer::Hlg),
            _ => Err(wrong("expected srgb, pq, hlg, { gamma = G } or { table = [...] }")),
        },
        DeValue::Table(table) => {
            let number = |v: &DeValue| match v {
                DeValue::Integer(i) => i.as_str().parse::<f64>().ok(),
                DeValue::Float(f) => f.as_str().parse::<f64>().ok().filter(|x| x.is_finite()),
                _ => None,
            };
            let one =
                table.iter().next().filter(|_| table.len() == 1).map(|(k, v)| (k.get_ref().as_ref(), v.get_ref()));
            match one {
                Some(("gamma", v)) => {
                    let g = number(v).filter(|g| (0.2..=10.0).contains(g));
                    g.map(Transfer::Gamma).ok_or_else(|| wrong("gamma must be 0.2 to 10"))
                }
                Some(("table", DeValue::Array(a))) => {
                    let light: Option<Vec<f64>> = a.iter().map(|v| number(v.get_ref())).collect();
                    let rises = |l: &Vec<f64>| {
                        l.len() >= 2 && l[0] == 0.0 && l[l.len() - 1] == 1.0 && l.windows(2).all(|w| w[0] < w[1])
                    };
                    let light = light.filter(rises);
                    light.map(Transfer::Table).ok_or_else(|| wrong("a table must rise from 0 to 1"))
                }
                _ => Err(wrong("expected { gamma = G } or { table = [...] }")),
            }
        }
        _ => Err(wrong("expected srgb, pq, hlg, { gamma = G } or { table = [...] }")),
    }
}

impl FromStr for Display {
    type Err = Error;
    fn from_str(s: &str) -> Result<Display> {
        if let Some((name, text)) = FILES.iter().find(|f| f.0 == s) {
            return Display::parse(name, text).map_err(|e| e.within(name));
        }
        let path = Path::new(s);
        if !s.ends_with(".toml") {
            let names: Vec<_> = Display::names().collect();
            let s = crate::error::printable(s.as_bytes());
            return Err(Error::Invalid(format!("'{s}' is no display; give {} or a .toml file", names.join(", "))));
        }
        let text = crate::files::read_to_string(path).map_err(|e| Error::Invalid(format!("cannot read '{s}': {e}")))?;
        Display::parse(s, &text).map_err(|e| e.in_file(path))
    }
}

impl fmt::Display for Display {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.name)
    }
}
string_serde!(Display);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_displays_parse() {
        assert!(Display::names().count() >= 5);
        for name in Display::names() {
            let d: Display = name.parse().unwrap();
            assert!(d.white_cd_m2 / d.black_cd_m2 > 10.0, "{name}");
        }
        let srgb: Display = "srgb".parse().unwrap();
        assert!((srgb.white_cd_m2 - 80.2037).abs() < 1e-4 && (srgb.black_cd_m2 - 0.4037).abs() < 1e-4);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let table = Transfer::Table((0..=8).map(|i| (f64::from(i) / 8.0).powf(2.5)).collect());
        for transfer in [Transfer::Srgb, Transfer::Pq, Transfer::Hlg, Transfer::Gamma(2.25), table] {
            let d = Display { transfer, white_cd_m2: 123.0, ..Display::from_str("print").unwrap() };
            let back = Display::parse("print", &d.to_toml()).unwrap();
            assert!(back.primaries.distance(&d.primaries) < 1e-6, "{}", d.to_toml());
            let (a, b) = (back.light([0.1, 0.45, 0.8]), d.light([0.1, 0.45, 0.8]));
            assert!(a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-5), "{}", d.to_toml());
            assert!((back.white_cd_m2 - 123.0).abs() < 1e-4 && (back.black_cd_m2 / d.black_cd_m2 - 1.0).abs() < 1e-6);
        }
        assert_eq!(significant(0.000123456789, 4), "0.0001235");
        assert_eq!(significant(1200.0, 3), "1200");
    }

    #[test]
    fn faults_are_named() {
        let good = "primaries = \"BT.709\"\nlmax = 80\nlmin = 0.2\n";
        assert!(Display::parse("x", good).is_ok());
        assert_eq!(
            Display::parse("x", &good.replace("lmin = 0.2", "lmin = 0")).unwrap().black_cd_m2,
            80.0 / LARGEST_CONTRAST
        );
        for (from, to, word) in [
            ("lmax = 80", "lmax = 0", "lmax"),
            ("lmax = 80", "lmax = 0.1", "below lmax"),
            ("lmin = 0.2", "lmin = -1", "from 0"),
            ("lmin = 0.2", "", "needed"),
            ("\"BT.709\"", "\"BT.70\"", "primaries"),
            ("lmin = 0.2", "lmin = 0.2\ntransfer = \"log\"", "pq"),
            ("lmin = 0.2", "lmin = 0.2\ntransfer = { gamma = 0 }", "gamma"),
            ("lmin = 0.2", "lmin = 0.2\ntransfer = { table = [0, 0.5, 0.4, 1] }", "rise"),
            ("lmin = 0.2", "lmin = 0.2\nbit = 8", "unknown"),
        ] {
            let message = Display::parse("x", &good.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(word), "{to}: {message}");
        }
    }
}
