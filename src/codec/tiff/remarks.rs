//! What a TIFF says beside its pixels.

use super::directory::{Directory, tag};
use crate::codec::Reading;
use crate::color::{Primaries, Xy};
use crate::stream::annotation::Annotation;
use crate::stream::source::Source;
use crate::{Result, invalid};

/// What a TIFF says beside its pixels.
pub struct Remarks {
    /// The ImageDescription.
    pub annotation: Annotation,
    /// Tag 318, where it is a chromaticity.
    pub white: Option<Xy>,
    /// Tag 319 with that white.
    pub primaries: Option<Primaries>,
    /// cd/m2 of a stored luminance of 1.
    pub stonits: Option<f64>,
}

impl Remarks {
    /// Reads them all; what makes no sense is a note.
    pub fn read(directory: &Directory, source: &mut Source, reading: &Reading) -> Result<Remarks> {
        let text = directory.text(tag::DESCRIPTION, source)?.unwrap_or_default();
        let annotation = Annotation::parse(&text)?;
        let mut reals = |tag: u16| directory.reals(tag, source);
        let white = reals(tag::WHITE_POINT)?;
        let primaries = reals(tag::PRIMARIES)?;
        let stonits = reals(tag::STONITS)?;
        let odd = |what: &str| reading.notes.add(format!("{}: its {what} makes no sense and is ignored", source.name));
        let xy = white.and_then(|w| match w[..] {
            [x, y] if (Xy { x, y }).is_physical() => Some(Xy { x, y }),
            _ => {
                odd("WhitePoint");
                None
            }
        });
        let primaries = primaries.and_then(|p| {
            let white = annotation.primaries().map(|p| p.white).or(xy).unwrap_or(Xy::D65);
            let found = Primaries::from_numbers(&[&p[..], &[white.x, white.y]].concat());
            if found.is_none() {
                odd("PrimaryChromaticities");
            }
            found
        });
        let stonits = match stonits.as_deref() {
            Some([s, ..]) if (1e-30..1e30).contains(s) => Some(*s),
            Some(_) => return invalid!("StoNits is not a number from 1e-30 to 1e30"),
            None => None,
        };
        Ok(Remarks { annotation, white: xy, primaries, stonits })
    }
}
