//! TIFF's directory: tags and their values [TIFF 6.0; BigTIFF].
//!
//! Nothing here trusts a count: a list is read only where the file holds it.

use std::collections::BTreeMap;

use crate::stream::Resolution;
use crate::stream::source::Source;
use crate::{Error, Result, invalid};

/// Numbers of the tags used here.
pub mod tag {
    #![allow(missing_docs)]
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const BITS_PER_SAMPLE: u16 = 258;
    pub const COMPRESSION: u16 = 259;
    pub const PHOTOMETRIC: u16 = 262;
    pub const DESCRIPTION: u16 = 270;
    pub const STRIP_OFFSETS: u16 = 273;
    pub const ORIENTATION: u16 = 274;
    pub const SAMPLES_PER_PIXEL: u16 = 277;
    pub const ROWS_PER_STRIP: u16 = 278;
    pub const STRIP_BYTE_COUNTS: u16 = 279;
    pub const PLANAR: u16 = 284;
    pub const WHITE_POINT: u16 = 318;
    pub const PRIMARIES: u16 = 319;
    pub const TILE_WIDTH: u16 = 322;
    pub const TILE_HEIGHT: u16 = 323;
    pub const TILE_OFFSETS: u16 = 324;
    pub const TILE_BYTE_COUNTS: u16 = 325;
    pub const SAMPLE_FORMAT: u16 = 339;
    pub const STONITS: u16 = 37439;
}

/// More tags than this are damage.
const MOST_TAGS: u64 = 4096;

/// Tags that point to directories: SubIFDs, Exif, GPS, Interoperability.
const OTHER_DIRECTORIES: [u16; 4] = [330, 34665, 34853, 40965];

/// One tag: how many values of which type, and where they stand.
#[derive(Clone, Copy, Debug)]
struct Entry {
    kind: u16,
    count: u64,
    at: u64,
}

/// The tags of a picture.
#[derive(Debug)]
pub struct Directory {
    /// Numbers in the file, 16-bit samples included, have their most significant byte first.
    pub big_endian: bool,
    /// Another picture follows.
    pub next: bool,
    /// Directories beside it hold more: smaller pictures, a camera's.
    pub more: bool,
    /// Where the directory and the values of its tags end.
    pub end: u64,
    entries: BTreeMap<u16, Entry>,
    /// Values of single numbers, read at once.
    numbers: BTreeMap<u16, u64>,
}

/// Bytes of a value of each TIFF type.
fn size(kind: u16) -> Option<u64> {
    match kind {
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 9 | 11 | 13 => Some(4),
        5 | 10 | 12 | 16 | 17 | 18 => Some(8),
        _ => None,
    }
}

/// An unsigned number of 1 to 8 bytes.
fn whole(bytes: &[u8], big_endian: bool) -> u64 {
    let join = |n: u64, byte: &u8| n << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
}

impl Directory {
    /// Reads the directory of a file's first picture.
    pub fn first(source: &mut Source) -> Result<Directory> {
        let head: [u8; 8] = source.array_at(0)?;
        let big_endian = head[0] == b'M';
        let number = |bytes: &[u8]| whole(bytes, big_endian);
        let big = number(&head[2..4]) == 43;
        let at = if big {
            if number(&head[4..6]) != 8 {
                return invalid!("BigTIFF with offsets of {} bytes: expected 8", number(&head[4..6]));
            }
            number(&source.array_at::<8>(8)?)
        } else {
            number(&head[4..8])
        };
        let cut = |e: Error| e.within("TIFF directory");
        let (count, first, entry_size) = if big {
            (number(&source.array_at::<8>(at).map_err(cut)?), at.saturating_add(8), 20)
        } else {
            (number(&source.array_at::<2>(at).map_err(cut)?), at.saturating_add(2), 12)
        };
        if count > MOST_TAGS {
            return invalid!("TIFF directory of {count} tags: expected at most {MOST_TAGS}");
        }
        let mut bytes = Vec::new();
        source.read_at(first, count * entry_size, &mut bytes).map_err(cut)?;
        let end = first + count * entry_size;
        let word = if big { 8 } else { 4 };
        let mut next = Vec::new();
        source.read_at(end, word, &mut next).map_err(cut)?;
        let mut directory = Directory {
            big_endian,
            next: number(&next) != 0,
            more: false,
            end: end + word,
            entries: BTreeMap::new(),
            numbers: BTreeMap::new(),
        };
        for (i, entry) in bytes.chunks_exact(entry_size as usize).enumerate() {
            let (tag, kind) = (number(&entry[..2]) as u16, number(&entry[2..4]) as u16);
            let (count, value) = entry[4..].split_at(word as usize);
            let count = number(count);
            directory.more |= OTHER_DIRECTORIES.contains(&tag);
            let Some(size) = size(kind) else { continue };
            let Some(total) = count.checked_mul(size) else { return invalid!("TIFF tag {tag} of {count} values") };
            let inside = total <= word;
            let here = first + i as u64 * entry_size + 4 + word;
            let at = if inside { here } else { number(value) };
            if total > source.len() {
                return invalid!("TIFF tag {tag} of {count} values is larger than the file");
            }
            if count == 1 && inside && matches!(kind, 1 | 3 | 4 | 16) {
                directory.numbers.insert(tag, number(&value[..size as usize]));
            }
            directory.end = directory.end.max(at.saturating_add(total));
            directory.entries.insert(tag, Entry { kind, count, at });
        }
        Ok(directory)
    }

    /// A tag that holds one whole number, or the first of a short list.
    pub fn number(&self, tag: u16) -> Option<u64> {
        self.numbers.get(&tag).copied()
    }

    /// A size that must be there: 1 to 2^31 - 1.
    pub fn size(&self, tag: u16, name: &str) -> Result<usize> {
        match self.number(tag) {
            Some(n) if (1..=i32::MAX as u64).contains(&n) => Ok(n as usize),
            Some(n) => invalid!("TIFF {name} is {n}: expected 1 to {}", i32::MAX),
            None => invalid!("TIFF has no {name}"),
        }
    }

    /// A tag must have one of these values.
    pub fn expect(&self, tag: u16, name: &str, fits: &[u64], default: u64) -> Result<()> {
        match self.number(tag).unwrap_or(default) {
            value if fits.contains(&value) => Ok(()),
            value => {
                let fits: Vec<String> = fits.iter().map(u64::to_string).collect();
                invalid!("TIFF {name} {value} does not go with its compression: expected {}", fits.join(" or "))
            }
        }
    }

    /// Size and scan order.
    pub fn resolution(&self) -> Result<Resolution> {
        let columns = self.size(tag::WIDTH, "width")?;
        let rows = self.size(tag::HEIGHT, "height")?;
        let orientation = self.number(tag::ORIENTATION).unwrap_or(1);
        let by_rows = orientation < 5;
        let (width, height) = if by_rows { (columns, rows) } else { (rows, columns) };
        Ok(Resolution {
            width,
            height,
            by_rows,
            from_right: matches!(orientation, 2 | 3 | 6 | 7),
            from_bottom: matches!(orientation, 3 | 4 | 7 | 8),
        })
    }

    /// All values of a tag of whole numbers.
    pub fn numbers(&self, tag: u16, source: &mut Source) -> Result<Option<Vec<u64>>> {
        let Some((bytes, kind)) = self.bytes(tag, source)? else { return Ok(None) };
        if !matches!(kind, 1 | 3 | 4 | 16) {
            return invalid!("TIFF tag {tag} has type {kind}: expected whole numbers");
        }
        let size = size(kind).unwrap_or(1) as usize;
        Ok(Some(bytes.chunks_exact(size).map(|b| whole(b, self.big_endian)).collect()))
    }

    /// All values of a tag of floats, doubles or fractions.
    pub fn reals(&self, tag: u16, source: &mut Source) -> Result<Option<Vec<f64>>> {
        let Some((bytes, kind)) = self.bytes(tag, source)? else { return Ok(None) };
        let number = |b: &[u8]| whole(b, self.big_endian);
        let value = |b: &[u8]| match kind {
            5 => number(&b[..4]) as f64 / number(&b[4..]) as f64,
            10 => f64::from(number(&b[..4]) as u32 as i32) / f64::from(number(&b[4..]) as u32 as i32),
            11 => f64::from(f32::from_bits(number(b) as u32)),
            12 => f64::from_bits(number(b)),
            _ => f64::NAN,
        };
        let size = size(kind).unwrap_or(1) as usize;
        Ok(Some(bytes.chunks_exact(size).map(value).collect()))
    }

    /// A text without its closing zeros.
    pub fn text(&self, tag: u16, source: &mut Source) -> Result<Option<Vec<u8>>> {
        let Some((mut bytes, _)) = self.bytes(tag, source)? else { return Ok(None) };
        while bytes.last() == Some(&0) {
            bytes.pop();
        }
        Ok(Some(bytes))
    }

    fn bytes(&self, tag: u16, source: &mut Source) -> Result<Option<(Vec<u8>, u16)>> {
        let Some(entry) = self.entries.get(&tag) else { return Ok(None) };
        let mut bytes = Vec::new();
        let total = entry.count * size(entry.kind).unwrap_or(1); // fits: checked when the directory was read
        source.read_at(entry.at, total, &mut bytes).map_err(|e| e.within(&format!("TIFF tag {tag}")))?;
        Ok(Some((bytes, entry.kind)))
    }
}
