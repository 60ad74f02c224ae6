//! File formats other than the stream's own. One format, one file, whose head is its manual page; a new one is named in
//! [`FORMATS`], and every filter reads it.

pub mod exr;
pub mod logluv;
pub mod noise;
pub mod pfm;
pub mod pixarlog;
pub mod png;
pub mod scale;
pub mod tiff;

use crate::notes::Notes;
use crate::stream::Picture;
use crate::stream::meaning::Overrides;
use crate::stream::reader::{self, Input};
use crate::stream::spool::Limits;
use crate::{Result, invalid};

/// How to know a format, and how to read it.
pub struct Format {
    /// What people call it.
    pub name: &'static str,
    /// True for the first bytes of such a file; at most [`MAGIC`] are shown.
    pub is: fn(&[u8]) -> bool,
    /// Opens it.
    pub open: fn(Input, &Reading) -> Result<Box<dyn Picture>>,
}

/// What surrounds the reading of a picture.
pub struct Reading<'a> {
    /// What the user says in place of the file.
    pub overrides: &'a Overrides,
    /// What may be kept of input that must be read in any order.
    pub limits: &'a Limits,
    /// Remarks for standard error.
    pub notes: &'a Notes,
}

/// Bytes that tell formats apart.
pub const MAGIC: usize = 8;

/// A scanline of more floats (1 GiB) is refused: no input of sensible size could fill it.
pub const LONGEST_SCANLINE: usize = 1 << 28;

/// Every format beside the stream's own (floats, RGBE, XYZE, hyperspectral Radiance), which is what remains.
pub static FORMATS: &[Format] = &[tiff::FORMAT, exr::FORMAT, pfm::FORMAT, png::FORMAT];

/// Opens any picture that the filters read.
pub fn open(mut input: Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let first = input.peek(MAGIC)?;
    let name = input.name.clone();
    let picture = match FORMATS.iter().find(|f| (f.is)(&first)) {
        Some(format) => (format.open)(input, reading).map_err(|e| e.within(&name))?,
        None => reader::open(input, reading.overrides, reading.notes)?,
    };
    let floats = picture.header().scanline_floats();
    if floats > LONGEST_SCANLINE {
        return invalid!("{name}: a scanline of {floats} floats is too long: expected at most {LONGEST_SCANLINE}");
    }
    Ok(picture)
}
