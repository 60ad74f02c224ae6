//! Palettes: materials and sources without shapes, as TOML, CSV or words of a command line. docs/relative-colours.md is
//! their manual.

use std::path::Path;

use crate::color::Xy;
use crate::error::printable;
use crate::keys::{self, Keys};
use crate::material::read::spectrum;
use crate::spectral::Spectrum;
use crate::spectral::key::SpectrumKey;
use crate::{Error, Result, invalid};

/// Shares may miss 1 by this much for rounding.
const ROUNDING: f64 = 1e-6;

/// A diffuse material.
#[derive(Clone, Debug)]
pub struct Material {
    /// Its name, without blanks.
    pub name: String,
    /// Reflectance 0..1.
    pub reflectance: Spectrum,
}

/// A light source.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its name, without blanks.
    pub name: String,
    /// Relative spectral power.
    pub spectrum: Spectrum,
    /// Chromaticity to adapt from, in place of the spectrum's.
    pub white: Option<Xy>,
    /// Share of the luminous flux that visible surfaces receive, 0..1.
    pub share: Option<f64>,
    /// Luminous flux, lm.
    pub lumens: Option<f64>,
    /// Luminance of its surface, cd/m2.
    pub luminance: Option<f64>,
}

/// Materials and sources, each in the order of the list; names are unique among all of them.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    /// Materials.
    pub materials: Vec<Material>,
    /// Sources.
    pub sources: Vec<Source>,
}

impl Palette {
    /// Reads a list: CSV by its name or its first line, else TOML.
    pub fn load(path: &Path) -> Result<Palette> {
        let text = crate::files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let named = |e: &str| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e));
        let csv = named("csv") || !named("toml") && looks_like_csv(&text);
        let palette = if csv { Palette::from_csv(&text, folder) } else { Palette::from_toml(&text, folder) };
        palette.map_err(|e| e.in_file(path))
    }

    /// `[materials.NAME] reflectance = SPECTRUM` and `[sources.NAME] spectrum = SPECTRUM`, with `share` or `lumens`,
    /// `white` and `luminance`; files lie in `folder`.
    pub fn from_toml(text: &str, folder: &Path) -> Result<Palette> {
        let mut keys = keys::parse(text)?;
        let mut palette = Palette::default();
        for (name, mut k) in keys.tables("materials")? {
            let Some((reflectance, span)) = spectrum(&mut k, "reflectance", folder)? else {
                return Err(k.wrong("key 'reflectance' is missing"));
            };
            let wrong = k.wrong("");
            palette.add_material(name, reflectance).map_err(|e| match e {
                Wrong::Spectrum(m) => k.wrong_key("reflectance", span, &m),
                Wrong::Name(m) => at(wrong, &m),
            })?;
            k.finish()?;
        }
        for (name, k) in keys.tables("sources")? {
            palette.read_source(name, k, folder)?;
        }
        keys.finish()?;
        Ok(palette)
    }

    fn read_source(&mut self, name: String, mut k: Keys, folder: &Path) -> Result<()> {
        let Some((spectrum, span)) = spectrum(&mut k, "spectrum", folder)? else {
            return Err(k.wrong("key 'spectrum' is missing"));
        };
        let positive = |x: f64| x > 0.0 && x < 1e30;
        let source = Source {
            name,
            spectrum,
            white: k.get("white")?,
            share: k.number("share", "must lie in 0 to 1", |x| (0.0..=1.0).contains(&x))?,
            lumens: k.number("lumens", "must be above 0", positive)?,
            luminance: k.number("luminance", "must be above 0", positive)?,
        };
        let wrong = k.wrong("");
        self.add_source(source).map_err(|e| match e {
            Wrong::Spectrum(m) => k.wrong_key("spectrum", span, &m),
            Wrong::Name(m) => at(wrong, &m),
        })?;
        k.finish()
    }

    /// Lines `material,NAME,SPECTRUM` and `source,NAME,SPECTRUM[,SHARE]`; comments from `#`, one line of column names.
    pub fn from_csv(text: &str, folder: &Path) -> Result<Palette> {
        let mut palette = Palette::default();
        for (n, line) in text.lines().enumerate() {
            let line = line.trim();
            if !(line.is_empty() || line.starts_with('#') || line.starts_with("kind,")) {
                palette.read_line(line, folder).map_err(|e| e.within(&format!("line {}", n + 1)))?;
            }
        }
        Ok(palette)
    }

    fn read_line(&mut self, line: &str, folder: &Path) -> Result<()> {
        let shape = || {
            let shown = printable(line.as_bytes());
            Error::Invalid(format!(
                "expected 'material,NAME,SPECTRUM' or 'source,NAME,SPECTRUM[,SHARE]', got '{shown}'"
            ))
        };
        let mut cells = line.splitn(3, ',').map(str::trim);
        let (Some(kind), Some(name), Some(rest)) = (cells.next(), cells.next(), cells.next()) else {
            return Err(shape());
        };
        // A spectrum in brackets may hold commas of its own.
        let end = if rest.starts_with(['[', '{']) { rest.rfind([']', '}']).map_or(0, |i| i + 1) } else { 0 };
        let end = end + rest[end..].find(',').unwrap_or(rest.len() - end);
        let share = rest[end..].strip_prefix(',').map(str::trim);
        let spectrum = rest[..end].trim().parse::<SpectrumKey>()?.resolve(folder)?;
        match (kind, share) {
            ("material", None) => Ok(self.add_material(name.into(), spectrum)?),
            ("source", share) => {
                let mut source = Source::new(name, spectrum);
                if let Some(text) = share.filter(|t| !t.is_empty()) {
                    let number = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
                    let shown = printable(text.as_bytes());
                    let wrong = || Error::Invalid(format!("share '{shown}' must be a number from 0 to 1"));
                    source.share = Some(number.ok_or_else(wrong)?);
                }
                Ok(self.add_source(source)?)
            }
            _ => Err(shape()),
        }
    }

    /// A material from a word `SPECTRUM` or `NAME=SPECTRUM`; files lie in the current folder.
    pub fn add_material_word(&mut self, word: &str) -> Result<()> {
        let (name, spectrum) = read_word(word)?;
        Ok(self.add_material(name, spectrum)?)
    }

    /// A source from such a word.
    pub fn add_source_word(&mut self, word: &str) -> Result<()> {
        let (name, spectrum) = read_word(word)?;
        Ok(self.add_source(Source::new(&name, spectrum))?)
    }

    fn add_material(&mut self, name: String, reflectance: Spectrum) -> Result<(), Wrong> {
        self.check_name(&name)?;
        let (low, high) = reflectance.range();
        if low < 0.0 || high > 1.0 {
            let name = if name.is_empty() { String::new() } else { format!("material '{name}' ") };
            return Err(Wrong::Spectrum(format!("{name}runs from {low} to {high}; it must lie in 0 to 1")));
        }
        self.materials.push(Material { name, reflectance });
        Ok(())
    }

    fn add_source(&mut self, source: Source) -> Result<(), Wrong> {
        self.check_name(&source.name)?;
        let (low, high) = source.spectrum.range();
        if low < 0.0 || high <= 0.0 {
            let name = &source.name;
            return Err(Wrong::Spectrum(format!("source '{name}' runs from {low} to {high}; light must be positive")));
        }
        self.sources.push(source);
        Ok(())
    }

    /// Names stand in tables and in Radiance's files, where a material hides another of its name.
    fn check_name(&self, name: &str) -> Result<(), Wrong> {
        let shown = printable(name.as_bytes());
        let barred = |c: char| c.is_whitespace() || c.is_control() || ",\"'\\#=".contains(c);
        if name.is_empty() || name.contains(barred) {
            return Err(Wrong::Name(format!("the name '{shown}' has blanks, commas, quotes, = or #, or is empty")));
        }
        let taken = self.materials.iter().map(|m| &m.name).chain(self.sources.iter().map(|s| &s.name));
        if taken.into_iter().any(|n| n == name) {
            return Err(Wrong::Name(format!("the name '{shown}' is given twice")));
        }
        Ok(())
    }

    /// Gives every source its share where the list allows it, and checks their sum.
    pub fn settle_shares(&mut self) -> Result<()> {
        if self.sources.is_empty() {
            return invalid!("no source; expected at least one to be white beside");
        }
        let lumens: Vec<f64> = self.sources.iter().filter_map(|s| s.lumens).collect();
        let shares: Vec<f64> = self.sources.iter().filter_map(|s| s.share).collect();
        if !lumens.is_empty() {
            if !shares.is_empty() || lumens.len() != self.sources.len() {
                return invalid!("sources: give lumens of all of them, or shares, not both");
            }
            let sum: f64 = lumens.iter().sum();
            self.sources.iter_mut().for_each(|s| s.share = s.lumens.map(|l| l / sum));
            return Ok(());
        }
        let sum: f64 = shares.iter().sum();
        if sum > 1.0 + ROUNDING {
            return invalid!("sources: the shares sum to {sum}; they are parts of 1");
        }
        if shares.len() + 1 == self.sources.len() {
            self.sources.iter_mut().filter(|s| s.share.is_none()).for_each(|s| s.share = Some((1.0 - sum).max(0.0)));
        }
        Ok(())
    }

    /// Index of the source with the largest known share, the first if none is known; or the one named.
    pub fn dominant(&self, name: Option<&str>) -> Result<usize> {
        if let Some(name) = name {
            return self.sources.iter().position(|s| s.name == name).ok_or_else(|| {
                let names: Vec<&str> = self.sources.iter().map(|s| s.name.as_str()).collect();
                Error::Usage(format!("no source '{}'; there are {}", printable(name.as_bytes()), names.join(", ")))
            });
        }
        let mut best = 0;
        for (i, s) in self.sources.iter().enumerate() {
            if s.share.unwrap_or(-1.0) > self.sources[best].share.unwrap_or(-1.0) {
                best = i;
            }
        }
        Ok(best)
    }
}

impl Source {
    fn new(name: &str, spectrum: Spectrum) -> Source {
        Source { name: name.to_string(), spectrum, white: None, share: None, lumens: None, luminance: None }
    }
}

/// What is wrong with an entry.
enum Wrong {
    Name(String),
    Spectrum(String),
}

impl From<Wrong> for Error {
    fn from(w: Wrong) -> Error {
        match w {
            Wrong::Name(m) | Wrong::Spectrum(m) => Error::Invalid(m),
        }
    }
}

/// A place with its message still to come.
fn at(place: Error, message: &str) -> Error {
    Error::Invalid(format!("{place} {message}"))
}

fn looks_like_csv(text: &str) -> bool {
    let first = text.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with('#')).unwrap_or("");
    ["kind,", "material,", "source,"].iter().any(|k| first.starts_with(k))
}

/// `NAME=SPECTRUM`, or a spectrum that names itself: `D65`, `paint/red.csv` as red, `{ blackbody = 2856 }` as
/// blackbody_2856.
fn read_word(word: &str) -> Result<(String, Spectrum)> {
    let named = word.split_once('=').filter(|_| !word.starts_with(['[', '{']));
    let text = named.map_or(word, |n| n.1).trim();
    let resolved = text.parse::<SpectrumKey>().and_then(|key| key.resolve(Path::new(".")));
    let name = match named {
        Some((name, _)) => name.trim().to_string(),
        None => {
            let stem = Path::new(text).file_stem().filter(|_| crate::spectral::text::is_file(text));
            let text = stem.map_or(text.into(), |s| s.to_string_lossy());
            let words = text.split(|c: char| !(c.is_alphanumeric() || "-._".contains(c))).filter(|w| !w.is_empty());
            words.collect::<Vec<_>>().join("_")
        }
    };
    Ok((name, resolved?))
}
