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

use crate::Result;
use crate::notes::Notes;
use crate::stream::Picture;
use crate::stream::meaning::Overrides;
use crate::stream::reader::{self, Input};
use crate::stream::spool::Limits;

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

/// Every format beside the stream's own (floats, RGBE, XYZE, hyperspectral Radiance), which is what remains.
pub static FORMATS: &[Format] = &[tiff::FORMAT, exr::FORMAT, pfm::FORMAT, png::FORMAT];

/// Opens any picture that the filters read.
pub fn open(mut input: Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let first = input.peek(MAGIC)?;
    let name = input.name.clone();
    match FORMATS.iter().find(|f| (f.is)(&first)) {
        Some(format) => (format.open)(input, reading).map_err(|e| e.within(&name)),
        None => reader::open(input, reading.overrides, reading.notes),
    }
}
