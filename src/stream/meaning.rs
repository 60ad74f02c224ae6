//! From header lines to what the numbers are: the rules that make two implementations agree (docs/stream.md).

use crate::color::{Primaries, Xy};
use crate::error::printable;
use crate::spectral::Sampling;
use crate::stream::header::RawHeader;
use crate::stream::variables::Stated;
use crate::stream::{Components, Header, Resolution, Units};
use crate::units::{RADIANCE_BAND, RADIANCE_EFFICACY};
use crate::{Error, Result, invalid};

/// Most components a pixel may have: every nanometre from 1 to 4096, or as many Stokes numbers.
pub const MOST_COMPONENTS: usize = 4096;

/// Begins the line that names a light of [`Components::Layers`].
pub const LAYER: &[u8] = b"LAYER=";
/// Key of the line that tells which scene they are of ([`crate::scene::Scene::fingerprint`]).
pub const LAYERS_OF: &str = "LAYERS_OF";

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

/// Settles the meaning of a header.
pub fn settle(raw: RawHeader, overrides: &Overrides) -> Result<Meaning> {
    let mut stated = Stated::read(raw.lines)?;
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
    if header.units == Units::Number && !matches!(header.components, Components::Y | Components::Layers) {
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
        Components::Spectrum | Components::Response | Components::Layers => true,
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
    if components == Components::Layers {
        return layers(s, ncomp, resolution);
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

/// A light a LAYER line, each with as many wavelengths.
fn layers(s: &Stated, ncomp: usize, resolution: Resolution) -> Result<Header> {
    let lights = s.passed.iter().filter(|l| l.starts_with(LAYER)).count();
    let count = ncomp / lights.max(1);
    let sampling = match (&s.wavelengths, &s.splits) {
        (Some(nm), _) => Sampling::points(nm.clone())?,
        (None, Some(w)) if count > 0 => Sampling::bins(w[0], w[3], count)?,
        _ => return invalid!("layers of lights must list their wavelengths"),
    };
    if lights * sampling.count() != ncomp {
        return invalid!("NCOMP={ncomp} is not {lights} LAYER lines times {} wavelengths", sampling.count());
    }
    let mut header = Header::new(resolution, Components::Layers, ncomp, Units::Number);
    header.sampling = Some(sampling);
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
