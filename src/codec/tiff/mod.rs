//! The TIFF container: directories, strips and tiles of either byte order, classic and BigTIFF. What is in the strips is
//! [`super::logluv`]'s and [`super::pixarlog`]'s; other TIFF is refused by name.
//!
//! Written: one picture in strips of about a quarter of a megabyte of floats, its first pixel top left; WHITE in tag 318, PRIMARIES in
//! 319 (RGB), StoNits in 37439, and the header's other lines in ImageDescription (270). BigTIFF where the file could pass
//! 4 GiB. Read: the first picture of a file; one held in a single strip is held compressed.

pub mod directory;
pub mod read;
pub mod remarks;
pub mod write;

use crate::codec::{Format, Reading, logluv, pixarlog};
use crate::stream::Picture;
use crate::stream::reader::Input;
use crate::stream::source::Source;
use crate::{Error, Result};
use directory::{Directory, tag};

/// How to know and read it.
pub const FORMAT: Format = Format {
    name: "TIFF",
    is: |first| [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| first.starts_with(magic)),
    open,
};

fn open(input: Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let mut source = Source::new(input, reading.limits, reading.notes)?;
    let directory = Directory::first(&mut source)?;
    let compression = directory.number(tag::COMPRESSION).unwrap_or(1);
    match compression {
        logluv::strips::COMPRESSION_32 | logluv::strips::COMPRESSION_24 => {
            logluv::strips::open(source, directory, reading)
        }
        pixarlog::COMPRESSION => pixarlog::open(source, directory, reading),
        other => Err(Error::Unsupported(format!(
            "TIFF with compression {other}: expected LogLuv (34676, 34677) or Pixar log (32909)"
        ))),
    }
}
