//! From header lines to what the numbers are: the rules that make two implementations agree (docs/stream.md).

use crate::color::{Primaries, Xy};
use crate::error::printable;
use crate::spectral::Sampling;
use crate::stream::header::{Adapted, RawHeader};
use crate::stream::{Components, Header, Resolution, Units};
use crate::units::{RADIANCE_BAND, RADIANCE_EFFICACY};
use crate::{Error, Result, invalid};

/// Most components a pixel may have: every nanometre from 1 to 4096, or as many Stokes numbers.
pub const MOST_COMPONENTS: usize = 4096;

/// How pixels are coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// 32-bit floats; true when their bytes must be swapped.
    Float(bool),
    /// 64-bit floats; true when their bytes must be swapped.
    Double(bool),
    /// Radiance's shared-exponent RGB.
    Rgbe,
    /// Radiance's shared-exponent XYZ.
    Xyze,
    /// Radiance's shared-exponent spectra: NCOMP mantissas and an exponent, never run-length coded.
    Spectra,
}

/// What the user says in place of the header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// In place of COMPONENTS.
    pub components: Option<Components>,
    /// In place of UNITS.
    pub units: Option<Units>,
    /// In place of WHITE.
    pub white: Option<Xy>,
    /// In place of PRIMARIES.
    pub primaries: Option<Primaries>,
}

/// A header with its meaning settled, and what it takes to reach that meaning.
#[derive(Debug)]
pub struct Meaning {
    /// The header, its units those of the pixels after `factors`.
    pub header: Header,
    /// How pixels are coded.
    pub coding: Coding,
    /// Decoded values times these give the header's units, a factor a component; `None` for all 1.
    pub factors: Option<Vec<f32>>,
    /// What had to be assumed, for standard error.
    pub notes: Vec<String>,
}

/// The variables of a header as they were written.
#[derive(Default)]
struct Stated {
    format: Option<String>,
    ncomp: Option<usize>,
    components: Option<Components>,
    units: Option<Units>,
    units_stale: bool,
    splits: Option<Vec<f64>>,
    wavelengths: Option<Vec<f64>>,
    matrix: [Option<Vec<f64>>; 3],
    primaries: Option<Primaries>,
    white: Option<Xy>,
    adapted: Option<Adapted>,
    display: Option<[f64; 2]>,
    exposure: f64,
    colorcorr: [f64; 3],
    rows: Option<usize>,
    columns: Option<usize>,
    big_endian: bool,
    passed: Vec<Vec<u8>>,
}

/// Settles the meaning of a header.
pub fn settle(raw: RawHeader, overrides: &Overrides) -> Result<Meaning> {
    let mut stated = read_variables(raw.lines)?;
    let resolution = match (raw.resolution, stated.rows, stated.columns) {
        (Some(r), ..) => r,
        (None, Some(rows), Some(columns)) => Resolution::upright(columns, rows),
        _ => return invalid!("no resolution line and no NROWS and NCOLS"),
    };
    let coding = coding(&stated)?;
    let mut notes = Vec::new();
    let mut header = match coding {
        Coding::Rgbe | Coding::Xyze => shared_exponent(coding, &stated, overrides, resolution)?,
        Coding::Spectra => {
            let ncomp = stated.ncomp.ok_or_else(|| Error::Invalid("a spectral picture needs an NCOMP line".into()))?;
            spectrum(&stated, ncomp, resolution, true)?
        }
        Coding::Float(_) | Coding::Double(_) => float(&stated, overrides, resolution, &mut notes)?,
    };
    if header.units == Units::Number && header.components != Components::Y {
        return invalid!("UNITS=none does not go with COMPONENTS={}", header.components);
    }
    let unit_factor = unit_factor(coding, &stated, overrides, &header);
    header.lines = std::mem::take(&mut stated.passed);
    header.adapted = stated.adapted.take();
    header.display = stated.display.filter(|_| header.units == Units::Display);
    header.white = overrides.white.or(stated.white).or(match header.components {
        Components::Rgb => header.primaries.map(|p| p.white),
        _ => None,
    });
    // EXPOSURE is a statement about scene light: it says nothing about display-referred pixels or pure numbers.
    let scene = !matches!(header.units, Units::Display | Units::Number);
    let factor = |i: usize| {
        let corr = if header.ncomp == 3 { stated.colorcorr[i] } else { 1.0 };
        if scene { (unit_factor / (stated.exposure * corr)) as f32 } else { 1.0 }
    };
    let factors: Vec<f32> = (0..header.ncomp).map(factor).collect();
    let factors = factors.iter().any(|f| *f != 1.0).then_some(factors);
    Ok(Meaning { header, coding, factors, notes })
}

fn read_variables(lines: Vec<(usize, Vec<u8>)>) -> Result<Stated> {
    let mut s = Stated { exposure: 1.0, colorcorr: [1.0; 3], ..Stated::default() };
    // In RGBE and XYZE files FORMAT alone gives components and unit.
    let format = lines.iter().rev().find_map(|(_, l)| l.strip_prefix(b"FORMAT="));
    let shared = format.is_some_and(|f| f.starts_with(b"32-bit_rle_"));
    for (number, line) in lines {
        let variable = line.iter().position(|b| *b == b'=').map(|at| (&line[..at], line[at + 1..].trim_ascii()));
        let Some((key, value)) = variable.filter(|(key, _)| !key.iter().any(u8::is_ascii_whitespace)) else {
            s.units_stale |= s.units.is_some() && !line.starts_with(b"\t") && !line.starts_with(b" ");
            s.passed.push(line);
            continue;
        };
        let wrong = |right: &str| {
            let (key, value) = (printable(key), printable(value));
            Error::Invalid(format!("header line {number}: {key}={value}: {right}"))
        };
        let numbers = |count: usize| {
            let n: Option<Vec<f64>> = std::str::from_utf8(value)
                .ok()
                .map(|t| t.split_ascii_whitespace().map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect())
                .unwrap_or(None);
            n.filter(|n| if count == 0 { !n.is_empty() } else { n.len() == count }).ok_or_else(|| {
                let many = if count == 0 { "a list of".to_string() } else { count.to_string() };
                wrong(&format!("expected {many} finite numbers"))
            })
        };
        let positive = |count: usize| {
            let n = numbers(count)?;
            if n.iter().all(|x| *x > 0.0) { Ok(n) } else { Err(wrong("must be above 0")) }
        };
        let whole = || {
            let n = std::str::from_utf8(value).ok().and_then(|t| t.parse::<usize>().ok());
            n.filter(|n| (1..=i32::MAX as usize).contains(n)).ok_or_else(|| wrong("expected a whole number from 1"))
        };
        let word = || std::str::from_utf8(value).map_err(|_| wrong("expected text"));
        match key {
            b"FORMAT" => s.format = Some(word()?.to_string()),
            b"NCOMP" => {
                s.ncomp = Some(whole()?);
                if s.ncomp.is_some_and(|n| n > MOST_COMPONENTS) {
                    return Err(wrong(&format!("at most {MOST_COMPONENTS} components")));
                }
            }
            b"NROWS" => s.rows = Some(whole()?),
            b"NCOLS" => s.columns = Some(whole()?),
            b"UNITS" | b"COMPONENTS" if shared => {
                // Passed on by programs that do not know them; only ours for display pictures means something.
                s.units = (key == b"UNITS" && value == b"display").then_some(Units::Display).or(s.units);
                s.units_stale &= key != b"UNITS";
            }
            b"COMPONENTS" => s.components = Some(word()?.parse().map_err(|_| wrong("unknown components"))?),
            b"UNITS" => {
                s.units = Some(
                    word()?
                        .parse()
                        .map_err(|_| wrong("expected W/sr/m2/nm, W/sr/m2, cd/m2, relative, display or none"))?,
                );
                s.units_stale = false;
            }
            b"WAVELENGTH_SPLITS" => s.splits = Some(numbers(4)?),
            b"WAVELENGTHS" => s.wavelengths = Some(numbers(0)?),
            b"XYZ_MATRIX_X" => s.matrix[0] = Some(numbers(0)?),
            b"XYZ_MATRIX_Y" => s.matrix[1] = Some(numbers(0)?),
            b"XYZ_MATRIX_Z" => s.matrix[2] = Some(numbers(0)?),
            b"PRIMARIES" => {
                let p = Primaries::from_numbers(&numbers(8)?);
                s.primaries = Some(p.ok_or_else(|| wrong("these primaries span no area or their white is none"))?);
            }
            b"WHITE" => s.white = Some(xy(&numbers(2)?).ok_or_else(|| wrong("is no chromaticity"))?),
            b"DISPLAY" => {
                let n = numbers(2)?;
                if n[0] < 0.0 || n[1] <= n[0] {
                    return Err(wrong("expected Lmin and a larger Lmax in cd/m2"));
                }
                s.display = Some([n[0], n[1]]);
            }
            b"ADAPTED" => s.adapted = Some(adapted(value).ok_or_else(|| wrong("expected xy, xy, matrix and degree"))?),
            b"EXPOSURE" => s.exposure *= positive(1)?.iter().product::<f64>(),
            b"COLORCORR" => {
                let c = positive(3)?;
                s.colorcorr = [0, 1, 2].map(|i| s.colorcorr[i] * c[i]);
            }
            b"BigEndian" => s.big_endian = value == b"1",
            _ => s.passed.push(line),
        }
    }
    if !(1e-30..1e30).contains(&s.exposure) || s.colorcorr.iter().any(|c| !(1e-30..1e30).contains(c)) {
        return invalid!("header: the product of all EXPOSURE and COLORCORR lines is out of range");
    }
    Ok(s)
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

fn coding(s: &Stated) -> Result<Coding> {
    let swap = s.big_endian != cfg!(target_endian = "big");
    match s.format.as_deref() {
        Some("float") => Ok(Coding::Float(swap)),
        Some("double") => Ok(Coding::Double(swap)),
        Some("32-bit_rle_rgbe") => Ok(Coding::Rgbe),
        Some("32-bit_rle_xyze") => Ok(Coding::Xyze),
        Some("Radiance_spectra") => Ok(Coding::Spectra),
        Some(other) => Err(Error::Unsupported(format!(
            "FORMAT={}: expected float, double, 32-bit_rle_rgbe, 32-bit_rle_xyze or Radiance_spectra",
            printable(other.as_bytes())
        ))),
        None => invalid!("the header has no FORMAT line; expected FORMAT=float, 32-bit_rle_rgbe ..."),
    }
}

/// RGBE and XYZE: FORMAT alone gives components and unit, other lines may be stale.
fn shared_exponent(coding: Coding, s: &Stated, o: &Overrides, resolution: Resolution) -> Result<Header> {
    if s.ncomp.is_some_and(|n| n != 3) {
        return invalid!("NCOMP={} in a picture of 3 components", s.ncomp.unwrap_or(0));
    }
    let display = s.units == Some(Units::Display) && !s.units_stale;
    let units = o.units.unwrap_or(if display { Units::Display } else { Units::CdM2 });
    let components = if coding == Coding::Rgbe { Components::Rgb } else { Components::Xyz };
    let mut header = Header::new(resolution, components, 3, units);
    if coding == Coding::Rgbe {
        header.primaries = Some(o.primaries.or(s.primaries).filter(|p| !p.is_xyz()).unwrap_or(Primaries::RADIANCE));
    }
    Ok(header)
}

/// A spectrum; `radiance` when the file holds Radiance's band values.
fn spectrum(s: &Stated, ncomp: usize, resolution: Resolution, radiance: bool) -> Result<Header> {
    let sampling = match (&s.wavelengths, &s.splits) {
        (Some(nm), _) => Sampling::points(nm.clone()).map_err(|e| e.within("WAVELENGTHS"))?,
        (None, Some(w)) => Sampling::bins(w[0], w[3], ncomp).map_err(|e| e.within("WAVELENGTH_SPLITS"))?,
        (None, None) if radiance => Sampling::bins(780.0, 380.0, ncomp)?,
        (None, None) => return invalid!("a spectrum needs a WAVELENGTHS or a WAVELENGTH_SPLITS line"),
    };
    if let Some(w) = s.splits.as_ref().filter(|w| s.wavelengths.is_none() && w[0] <= w[3]) {
        return invalid!("WAVELENGTH_SPLITS= {} ... {}: expected the long end first", w[0], w[3]);
    }
    if sampling.count() != ncomp {
        return invalid!("NCOMP={ncomp}, but {} wavelengths are listed", sampling.count());
    }
    let mut header = Header::new(resolution, Components::Spectrum, ncomp, Units::SpectralRadiance);
    header.sampling = Some(sampling);
    header.xyz_matrix = match &s.matrix {
        [None, None, None] => None,
        [Some(x), Some(y), Some(z)] if [x, y, z].iter().all(|r| r.len() == ncomp) => {
            Some([x.clone(), y.clone(), z.clone()])
        }
        _ => return invalid!("XYZ_MATRIX_X, _Y and _Z must all be there with {ncomp} numbers each"),
    };
    Ok(header)
}

fn float(s: &Stated, o: &Overrides, resolution: Resolution, notes: &mut Vec<String>) -> Result<Header> {
    let ncomp = s.ncomp.unwrap_or(3);
    let components = match o.components.or(s.components) {
        Some(c) => c,
        None if s.splits.is_some() || s.wavelengths.is_some() => Components::Spectrum,
        None if ncomp == 3 && s.primaries.is_some_and(|p| p.is_xyz()) => Components::Xyz,
        None if ncomp == 3 => Components::Rgb,
        None => {
            return invalid!("NCOMP={ncomp} and no COMPONENTS line; say what they are with --components");
        }
    };
    let fits = match components {
        Components::Y => ncomp == 1,
        Components::Xyz | Components::Rgb => ncomp == 3,
        Components::Spectrum | Components::Response => true,
        Components::Stokes => ncomp.is_multiple_of(4),
    };
    if !fits {
        return invalid!("COMPONENTS={components} does not go with NCOMP={ncomp}");
    }
    if components == Components::Spectrum {
        let stated = o.units.or(s.units);
        if stated.is_some_and(|u| u != Units::SpectralRadiance) {
            return invalid!("a spectrum has UNITS=W/sr/m2/nm, not {}", stated.map_or("", Units::name));
        }
        if stated.is_none() {
            notes.push("no UNITS line: taking the spectrum as Radiance's band values".into());
        }
        return spectrum(s, ncomp, resolution, stated.is_none());
    }
    if components == Components::Stokes {
        let points = s.wavelengths.clone().map(Sampling::points).transpose()?;
        let bins = s.splits.as_ref().map(|w| Sampling::bins(w[0], w[3], ncomp / 4)).transpose()?;
        let mut header = Header::new(resolution, components, ncomp, Units::SpectralRadiance);
        header.sampling = points.or(bins);
        return match &header.sampling {
            Some(sampling) if sampling.count() == ncomp / 4 => Ok(header),
            _ => invalid!("a Stokes picture of {} wavelengths must list as many", ncomp / 4),
        };
    }
    let units = o.units.or(s.units);
    if components == Components::Response {
        return Ok(Header::new(resolution, components, ncomp, units.unwrap_or(Units::Weighted)));
    }
    if matches!(units, Some(Units::SpectralRadiance | Units::Weighted)) {
        return invalid!("UNITS={} does not go with COMPONENTS={components}", units.map_or("", Units::name));
    }
    if s.components.is_none() && o.components.is_none() {
        let what = if components == Components::Xyz { "XYZ in cd/m2" } else { "RGB in W/sr/m2 (179 lm/W)" };
        if units.is_none() {
            notes.push(format!("no COMPONENTS line: taking the floats as {what}"));
        }
    }
    let mut header = Header::new(resolution, components, ncomp, units.unwrap_or(Units::CdM2));
    if components == Components::Rgb {
        header.primaries = Some(o.primaries.or(s.primaries).filter(|p| !p.is_xyz()).unwrap_or(Primaries::RADIANCE));
    }
    Ok(header)
}

/// What stands between the numbers in the file (EXPOSURE divided out) and the header's units.
fn unit_factor(coding: Coding, s: &Stated, o: &Overrides, header: &Header) -> f64 {
    let stated = o.units.or(s.units);
    match (coding, header.components) {
        (Coding::Rgbe, _) => RADIANCE_EFFICACY,
        (Coding::Spectra, _) => RADIANCE_BAND,
        (Coding::Float(_) | Coding::Double(_), Components::Rgb) if stated.is_none() => RADIANCE_EFFICACY,
        (Coding::Float(_) | Coding::Double(_), Components::Spectrum) if stated.is_none() => RADIANCE_BAND,
        _ => 1.0,
    }
}
