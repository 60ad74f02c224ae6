//! A header as a text inside another format (TIFF's ImageDescription, an EXR or PNG text), and back: history, unknown lines
//! and what the numbers mean, without sizes and coding, which the format itself states.

use crate::color::{Primaries, Xy};
use crate::spectral::Sampling;
use crate::stream::header::{LONGEST_HEADER, LONGEST_LINE};
use crate::stream::meaning::Overrides;
use crate::stream::variables::Stated;
use crate::stream::{Components, Header, Units};
use crate::{Result, invalid};

/// First line of a text of ours.
const MAGIC: &[u8] = b"#?RADIANCE";

/// The text that stands for `header`, a line each, UTF-8 only as far as the header's lines are.
pub fn text(header: &Header) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    out.push(b'\n');
    for line in &header.lines {
        out.extend_from_slice(line);
        out.push(b'\n');
    }
    out.extend_from_slice(header.variables().as_bytes());
    out
}

/// A text that came with a picture, its variables read.
pub struct Annotation(Stated);

impl Annotation {
    /// Reads a text. One that is not of ours is a remark: its lines are kept, indented, so that none is a variable.
    pub fn parse(text: &[u8]) -> Result<Annotation> {
        if text.len() > LONGEST_HEADER {
            return invalid!("its text has {} bytes; at most {LONGEST_HEADER} are kept", text.len());
        }
        let ours = text.starts_with(MAGIC);
        let clean = |line: &[u8]| -> Vec<u8> {
            let visible = line.iter().map(|b| if *b < b' ' && *b != b'\t' { b' ' } else { *b });
            let mut line: Vec<u8> = if ours { Vec::new() } else { b"\t".to_vec() };
            line.extend(visible);
            line.truncate(line.trim_ascii_end().len());
            line
        };
        let lines = text.split(|b| *b == b'\n').map(clean).enumerate().map(|(i, line)| (i + 1, line));
        let skipped = usize::from(ours); // the magic line
        let kept = lines.skip(skipped).filter(|(_, l)| !l.trim_ascii().is_empty() && l.len() <= LONGEST_LINE);
        Stated::read(kept.collect()).map(Annotation).map_err(|e| e.within("text"))
    }

    /// What UNITS says.
    pub fn units(&self) -> Option<Units> {
        self.0.units
    }

    /// What COMPONENTS says.
    pub fn components(&self) -> Option<Components> {
        self.0.components
    }

    /// What PRIMARIES says.
    pub fn primaries(&self) -> Option<Primaries> {
        self.0.primaries.filter(|p| !p.is_xyz())
    }

    /// What WHITE says.
    pub fn white(&self) -> Option<Xy> {
        self.0.white
    }

    /// What WAVELENGTHS or WAVELENGTH_SPLITS says of a spectrum of `count` components.
    pub fn sampling(&self, count: usize) -> Option<Sampling> {
        let sampling = match (&self.0.wavelengths, &self.0.splits) {
            (Some(nm), _) => Sampling::points(nm.clone()).ok(),
            (None, Some(w)) if w[0] > w[3] => Sampling::bins(w[0], w[3], count).ok(),
            _ => None,
        };
        sampling.filter(|s| s.count() == count)
    }

    /// The picture's header: what the format itself states stands in `own` and wins over the text, the user's word over
    /// both.
    pub fn settle(self, mut own: Header, overrides: &Overrides) -> Result<Header> {
        let Annotation(stated) = self;
        if let Some(c) = overrides.components {
            let three = |c| matches!(c, Components::Xyz | Components::Rgb);
            if c != own.components && !(three(c) && three(own.components)) {
                return invalid!("--components {c} does not go with a picture of {}", own.components);
            }
            own.components = c;
        }
        if let Some(units) = overrides.units {
            let spectral = |u| u == Units::SpectralRadiance;
            if spectral(units) != spectral(own.units) || units == Units::Number {
                return invalid!("--units {units} does not go with a picture in {}", own.units);
            }
            own.units = units;
        }
        own.primaries = match own.components {
            Components::Rgb => overrides.primaries.or(own.primaries).or(stated.primaries).filter(|p| !p.is_xyz()),
            _ => None,
        };
        let implied = own.primaries.map(|p| p.white);
        own.white = overrides.white.or(own.white).or(stated.white).or(implied);
        if let ([Some(x), Some(y), Some(z)], Components::Spectrum) = (&stated.matrix, own.components)
            && [x, y, z].iter().all(|row| row.len() == own.ncomp)
        {
            own.xyz_matrix = Some([x.clone(), y.clone(), z.clone()]);
        }
        own.adapted = stated.adapted;
        own.display = stated.display.filter(|_| own.units == Units::Display);
        own.lines = stated.passed;
        Ok(own)
    }
}
