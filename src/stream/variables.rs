//! The variables of a header as they were written: text to numbers, one rule a key.

use crate::color::{Primaries, Xy};
use crate::error::printable;
use crate::stream::header::Adapted;
use crate::stream::meaning::MOST_COMPONENTS;
use crate::stream::{Components, Units};
use crate::{Error, Result, invalid};

/// The variables of a header as they were written.
#[derive(Default)]
pub(super) struct Stated {
    pub format: Option<String>,
    pub ncomp: Option<usize>,
    pub components: Option<Components>,
    pub units: Option<Units>,
    pub units_stale: bool,
    pub splits: Option<Vec<f64>>,
    pub wavelengths: Option<Vec<f64>>,
    pub matrix: [Option<Vec<f64>>; 3],
    pub primaries: Option<Primaries>,
    pub white: Option<Xy>,
    pub adapted: Option<Adapted>,
    pub display: Option<[f64; 2]>,
    pub exposure: f64,
    pub colorcorr: [f64; 3],
    pub rows: Option<usize>,
    pub columns: Option<usize>,
    pub big_endian: bool,
    pub passed: Vec<Vec<u8>>,
}

/// One `KEY=value` line.
struct Variable<'a> {
    line: usize,
    key: &'a [u8],
    value: &'a [u8],
}

impl Variable<'_> {
    fn wrong(&self, right: &str) -> Error {
        let (key, value) = (printable(self.key), printable(self.value));
        Error::Invalid(format!("header line {}: {key}={value}: {right}", self.line))
    }

    fn word(&self) -> Result<&str> {
        std::str::from_utf8(self.value).map_err(|_| self.wrong("expected text"))
    }

    /// Exactly `count` finite numbers, or any number of them for 0.
    fn numbers(&self, count: usize) -> Result<Vec<f64>> {
        let number = |w: &str| w.parse().ok().filter(|x: &f64| x.is_finite());
        let n: Option<Vec<f64>> = self.word().ok().and_then(|t| t.split_ascii_whitespace().map(number).collect());
        n.filter(|n| if count == 0 { !n.is_empty() } else { n.len() == count }).ok_or_else(|| {
            let many = if count == 0 { "a list of".to_string() } else { count.to_string() };
            self.wrong(&format!("expected {many} finite numbers"))
        })
    }

    fn positive(&self, count: usize) -> Result<Vec<f64>> {
        let n = self.numbers(count)?;
        if n.iter().all(|x| *x > 0.0) { Ok(n) } else { Err(self.wrong("must be above 0")) }
    }

    /// A whole number from 1 to `most`.
    fn whole(&self, most: usize) -> Result<usize> {
        let n = self.word().ok().and_then(|t| t.parse::<usize>().ok());
        n.filter(|n| (1..=most).contains(n))
            .ok_or_else(|| self.wrong(&format!("expected a whole number from 1 to {most}")))
    }
}

impl Stated {
    /// Reads all lines; those that are no variable of ours pass on.
    pub fn read(lines: Vec<(usize, Vec<u8>)>) -> Result<Stated> {
        let mut s = Stated { exposure: 1.0, colorcorr: [1.0; 3], ..Stated::default() };
        // In RGBE and XYZE files FORMAT alone gives components and unit.
        let format = lines.iter().rev().find_map(|(_, l)| l.strip_prefix(b"FORMAT="));
        let shared = format.is_some_and(|f| f.starts_with(b"32-bit_rle_"));
        for (line, text) in lines {
            let parts = text.iter().position(|b| *b == b'=').map(|at| (&text[..at], text[at + 1..].trim_ascii()));
            let known = match parts.filter(|(key, _)| !key.iter().any(u8::is_ascii_whitespace)) {
                Some((key, value)) => s.take(&Variable { line, key, value }, shared)?,
                None => {
                    // Another program's history line; an indented one is nobody's.
                    s.units_stale |= !text.starts_with(b"\t") && !text.starts_with(b" ");
                    false
                }
            };
            if !known {
                s.passed.push(text);
            }
        }
        if !(1e-30..1e30).contains(&s.exposure) || s.colorcorr.iter().any(|c| !(1e-30..1e30).contains(c)) {
            return invalid!("header: the product of all EXPOSURE and COLORCORR lines is out of range");
        }
        Ok(s)
    }

    /// Takes a variable in; false for one that is none of ours.
    fn take(&mut self, v: &Variable, shared: bool) -> Result<bool> {
        match v.key {
            b"FORMAT" => self.format = Some(v.word()?.to_string()),
            b"NCOMP" => self.ncomp = Some(v.whole(MOST_COMPONENTS)?),
            b"NROWS" => self.rows = Some(v.whole(i32::MAX as usize)?),
            b"NCOLS" => self.columns = Some(v.whole(i32::MAX as usize)?),
            b"COMPONENTS" if shared => {} // passed on by programs that do not know it
            b"UNITS" => self.take_units(v, shared)?,
            b"COMPONENTS" => self.components = Some(v.word()?.parse().map_err(|_| v.wrong("unknown components"))?),
            b"WAVELENGTH_SPLITS" => self.splits = Some(v.numbers(4)?),
            b"WAVELENGTHS" => self.wavelengths = Some(v.numbers(0)?),
            b"XYZ_MATRIX_X" => self.matrix[0] = Some(v.numbers(0)?),
            b"XYZ_MATRIX_Y" => self.matrix[1] = Some(v.numbers(0)?),
            b"XYZ_MATRIX_Z" => self.matrix[2] = Some(v.numbers(0)?),
            b"PRIMARIES" => {
                let p = Primaries::from_numbers(&v.numbers(8)?);
                self.primaries = Some(p.ok_or_else(|| v.wrong("these primaries span no area or their white is none"))?);
            }
            b"WHITE" => self.white = Some(xy(&v.numbers(2)?).ok_or_else(|| v.wrong("is no chromaticity"))?),
            b"DISPLAY" => match v.numbers(2)?[..] {
                [black, white] if black >= 0.0 && white > black => self.display = Some([black, white]),
                _ => return Err(v.wrong("expected Lmin and a larger Lmax in cd/m2")),
            },
            b"ADAPTED" => {
                self.adapted = Some(adapted(v.value).ok_or_else(|| v.wrong("expected xy, xy, matrix and degree"))?);
            }
            b"EXPOSURE" => self.exposure *= v.positive(1)?.iter().product::<f64>(),
            b"COLORCORR" => {
                let c = v.positive(3)?;
                self.colorcorr = [0, 1, 2].map(|i| self.colorcorr[i] * c[i]);
            }
            b"BigEndian" => self.big_endian = v.value == b"1",
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// In a shared-exponent file only `display` means something, and only until another program adds its line.
    fn take_units(&mut self, v: &Variable, shared: bool) -> Result<()> {
        let units =
            v.word()?.parse().map_err(|_| v.wrong("expected W/sr/m2/nm, W/sr/m2, cd/m2, relative, display or none"));
        self.units = match units {
            Ok(units) if !shared || units == Units::Display => Some(units),
            Err(e) if !shared => return Err(e),
            _ => None,
        };
        self.units_stale = false;
        Ok(())
    }
}

fn xy(n: &[f64]) -> Option<Xy> {
    let xy = Xy { x: n[0], y: n[1] };
    xy.is_physical().then_some(xy)
}

fn adapted(value: &[u8]) -> Option<Adapted> {
    let words: Vec<&str> = std::str::from_utf8(value).ok()?.split_ascii_whitespace().collect();
    let [x0, y0, x1, y1, cat, degree] = words[..] else { return None };
    let n = |t: &str| t.parse::<f64>().ok().filter(|x| x.is_finite());
    Some(Adapted { from: xy(&[n(x0)?, n(y0)?])?, to: xy(&[n(x1)?, n(y1)?])?, cat: cat.to_string(), degree: n(degree)? })
}
