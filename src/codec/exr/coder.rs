//! From the bytes of a block to those of its samples and back: the `exr` crate's compression, behind checks of its own
//! assumptions.
//!
//! A block's samples lie row by row, in a row channel by channel in order of their names, little endian.

use ::exr::compression::Compression;
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds, LevelMode, SampleType, Text, TileDescription};
use ::exr::meta::header::Header;

use super::head::{Channel, Sample};
use crate::{Error, Result, invalid};

/// No block may be larger, packed or not.
const LARGEST_BLOCK: usize = 1 << 30;
/// Of DWA, whose bytes may stand for so much and whose unpacking takes so many times the room.
const LARGEST_DWA: usize = 1 << 27;

/// A rectangle of a block: columns, rows, and its first row counted from the window's top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

/// Packs and unpacks blocks.
pub(super) struct Coder {
    compression: Compression,
    channels: Vec<Channel>,
    subsampled: bool,
    /// What the crate wants to know of a file; sizes that stand in no block's way.
    header: Header,
    /// The same for bytes without structure: one half each two of them.
    plain: Header,
}

impl Coder {
    pub fn new(compression: Compression, channels: &[Channel]) -> Result<Coder> {
        use Compression::{B44, B44A, DWAA, DWAB};
        let subsampled = channels.iter().any(|c| c.every != [1, 1]);
        if subsampled && matches!(compression, B44 | B44A | DWAA(_) | DWAB(_)) {
            return Err(Error::Unsupported(format!(
                "subsampled channels under {compression} are not read; store it with zip or piz"
            )));
        }
        let uneven = |c: &Channel| !compression.scan_lines_per_block().is_multiple_of(c.every[1]);
        if matches!(compression, Compression::PIZ | Compression::PXR24) && channels.iter().any(uneven) {
            return Err(Error::Unsupported("channels with samples every so many rows are not read".into()));
        }
        let describe = |c: &Channel| ChannelDescription {
            name: Text::new_or_none(&c.name).unwrap_or_default(),
            sample_type: match c.sample {
                Sample::Uint => SampleType::U32,
                Sample::Half => SampleType::F16,
                Sample::Float => SampleType::F32,
            },
            quantize_linearly: c.linear,
            sampling: Vec2(c.every[0], c.every[1]),
        };
        let half = Channel { name: "H".into(), sample: Sample::Half, linear: false, every: [1, 1] };
        Ok(Coder {
            compression,
            header: stand_in(compression, channels.iter().map(describe)),
            plain: stand_in(compression, std::iter::once(describe(&half))),
            channels: channels.to_vec(),
            subsampled,
        })
    }

    /// Rows of a block.
    pub fn rows(&self) -> usize {
        self.compression.scan_lines_per_block()
    }

    /// Bytes of the samples of one row, counted from the window's top.
    pub fn row_bytes(&self, row: usize, width: usize) -> usize {
        let here = |c: &&Channel| row.is_multiple_of(c.every[1]);
        self.channels.iter().filter(here).map(|c| c.sample.bytes() * (width / c.every[0])).sum()
    }

    /// Bytes of all samples of an area; `None` beyond [`LARGEST_BLOCK`].
    pub fn bytes(&self, area: Area) -> Option<usize> {
        let pixel: usize = self.channels.iter().map(|c| c.sample.bytes()).sum();
        let bound = pixel.checked_mul(area.width)?.checked_mul(area.height)?;
        let dwa = matches!(self.compression, Compression::DWAA(_) | Compression::DWAB(_));
        if bound > if dwa { LARGEST_DWA } else { LARGEST_BLOCK } {
            return None;
        }
        if !self.subsampled {
            return Some(bound);
        }
        Some((area.top..area.top + area.height).map(|row| self.row_bytes(row, area.width)).sum())
    }

    /// Refuses a block whose pixels its packed bytes could not hold, before anything is allocated for them.
    pub fn justified(&self, area: Area, packed: u64) -> Result<usize> {
        use Compression::{DWAA, DWAB, RLE, Uncompressed};
        // The most a byte can stand for: deflate 1032, PIZ's runs 410, DWA runs of blocks under deflate.
        let (most, floor) = match self.compression {
            Uncompressed => (1, 0),
            RLE => (64, 0),
            DWAA(_) | DWAB(_) => (1 << 16, 0),
            _ => (2048, 1 << 12),
        };
        match self.bytes(area) {
            Some(bytes) if bytes as u64 > packed.saturating_mul(most) + floor => {
                invalid!("a block of {packed} bytes cannot hold {} x {} pixels", area.width, area.height)
            }
            Some(bytes) if packed > bytes as u64 || packed == 0 => {
                invalid!("a block of {packed} bytes for {} x {} pixels", area.width, area.height)
            }
            Some(bytes) => Ok(bytes),
            None => invalid!("a block of {} x {} pixels is too large", area.width, area.height),
        }
    }

    /// The samples of a block that [`Coder::justified`] let pass, `bytes` of them.
    pub fn unpack(&self, packed: Vec<u8>, area: Area, bytes: usize) -> Result<Vec<u8>> {
        use Compression::{DWAA, DWAB, PIZ, PXR24};
        if matches!(self.compression, DWAA(_) | DWAB(_)) && packed.len() != bytes {
            self.check_dwa(&packed, area)?;
        }
        let unpacked = if !self.subsampled {
            self.compression.decompress_image_section_from_le(&self.header, packed, rectangle(area), false)
        } else if matches!(self.compression, PIZ | PXR24) && packed.len() != bytes {
            let pixels = area.width * area.height;
            if !bytes.is_multiple_of(pixels) {
                return Err(Error::Unsupported("subsampled channels of these types are not read".into()));
            }
            let mut header = self.header.clone();
            header.channels.bytes_per_pixel = bytes / pixels;
            self.compression.decompress_image_section_from_le(&header, packed, rectangle(area), false)
        } else {
            // The crate counts every channel in full; these compressions do not look at channels.
            let halves = Area { top: 0, width: bytes / 2, height: 1 };
            self.compression.decompress_image_section_from_le(&self.plain, packed, rectangle(halves), false)
        };
        match unpacked {
            Ok(samples) if samples.len() == bytes => Ok(samples),
            Ok(_) => invalid!("a block is damaged"),
            Err(e) => Err(plain_error(e)),
        }
    }

    /// Packs samples in the machine's byte order.
    pub fn pack(&self, samples: Vec<u8>, area: Area) -> Result<Vec<u8>> {
        self.compression.compress_image_section_to_le(&self.header, samples, rectangle(area)).map_err(plain_error)
    }

    /// DWA blocks begin with eleven numbers, by some of which the crate allocates.
    fn check_dwa(&self, packed: &[u8], area: Area) -> Result<()> {
        let number = |i: usize| {
            let b = packed.get(8 * i..8 * i + 8)?;
            Some(u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        };
        let blocks = (area.width.div_ceil(8) * area.height.div_ceil(8) * self.channels.len()) as u64;
        let bytes: usize = self.channels.iter().map(|c| c.sample.bytes()).sum();
        let bytes = (bytes * area.width * area.height) as u64;
        let most = [(1, bytes), (6, 2 * bytes + 64), (7, bytes), (8, 64 * blocks), (9, blocks)];
        let fits = |(i, most): (usize, u64)| number(i).is_some_and(|n| n <= most);
        if most.into_iter().all(fits) { Ok(()) } else { invalid!("a block is damaged: its sizes do not fit") }
    }
}

/// A header under which the crate codes blocks of any size up to [`LARGEST_BLOCK`].
fn stand_in(compression: Compression, channels: impl Iterator<Item = ChannelDescription>) -> Header {
    let side = (1 << 30) - 2;
    let tiles = TileDescription {
        tile_size: Vec2(side, side),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    };
    let header = Header::new(Text::default(), Vec2(1, 1), channels.collect());
    Header { compression, blocks: BlockDescription::Tiles(tiles), layer_size: Vec2(side, side), ..header }
}

fn rectangle(area: Area) -> IntegerBounds {
    // Rows count for subsampling alone, and blocks begin at multiples of every factor that is read.
    IntegerBounds { position: Vec2(0, 0), size: Vec2(area.width, area.height) }
}

fn plain_error(e: ::exr::error::Error) -> Error {
    match e {
        ::exr::error::Error::NotSupported(what) => Error::Unsupported(what.into_owned()),
        ::exr::error::Error::Io(e) => Error::io("", e),
        ::exr::error::Error::Invalid(what) => Error::Invalid(format!("a block is damaged: {what}")),
        ::exr::error::Error::Aborted => Error::Invalid("a block is damaged".into()),
    }
}
