//! PFM, the portable float map [Debevec 1997]: a text header, then 32-bit floats, rows bottom up.
//!
//! `PF` holds three components, `Pf` one; a negative scale means little endian, its size multiplies the values. The format
//! says nothing of colours or units and keeps no header lines: a picture read from it is taken for linear BT.709 RGB (one
//! component: luminance) in cd/m2, with a note, unless the user says otherwise.
//!
//! `ra_pfm` writes NaN as 0 and what is infinite or over 1e37 as 1e37, and counts them.
//!
//! Rows lie bottom up, so a file is read and written from its end; a pipe is kept first.

use std::io::{BufWriter, Seek, SeekFrom, Write};

use crate::codec::{Format, Reading};
use crate::color::Primaries;
use crate::error::printable;
use crate::notes::Notes;
use crate::stream::meaning::Overrides;
use crate::stream::output::Output;
use crate::stream::picture::block_rows;
use crate::stream::source::Source;
use crate::stream::spool::Limits;
use crate::stream::{Block, Components, Header, Picture, Resolution, Units};
use crate::{Error, Result, invalid};

/// How to know and read it.
pub const FORMAT: Format =
    Format { name: "PFM", is: |first| first.starts_with(b"PF") || first.starts_with(b"Pf"), open };

/// Bytes in which the header must end.
const LONGEST_HEADER: usize = 256;

/// Rows being read from the end of the file.
struct Reader {
    source: Source,
    header: Header,
    /// Where the pixels begin.
    start: u64,
    swap: bool,
    factor: f32,
    row: usize,
    bytes: Vec<u8>,
}

fn open(input: crate::stream::reader::Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let mut source = Source::new(input, reading.limits, reading.notes)?;
    let mut first = Vec::new();
    source.read_at(0, source.len().min(LONGEST_HEADER as u64), &mut first)?;
    let (words, start) = header_words(&first)?;
    let [kind, width, height, scale] = &words;
    let size = |n: &str| {
        let digits = n.bytes().all(|b| b.is_ascii_digit());
        n.parse::<usize>().ok().filter(|n| digits && (1..=i32::MAX as usize).contains(n))
    };
    let (Some(width), Some(height)) = (size(width), size(height)) else {
        let stated = printable(format!("{width} {height}").as_bytes());
        return invalid!("PFM of size '{stated}': expected two whole numbers from 1 to {}", i32::MAX);
    };
    let Some(scale) = scale.parse::<f32>().ok().filter(|s| s.is_finite() && *s != 0.0) else {
        return invalid!("PFM with scale '{}': expected a number that is not 0", printable(scale.as_bytes()));
    };
    let ncomp = if kind == "PF" { 3 } else { 1 };
    let resolution = Resolution::upright(width, height);
    let header = assumed(resolution, ncomp, reading.overrides, reading.notes, &source.name)?;
    let pixels = (width as u64).checked_mul(height as u64).and_then(|n| n.checked_mul(4 * ncomp as u64));
    let here = source.len() - start;
    match pixels {
        Some(pixels) if pixels <= here => {
            if pixels < here {
                reading.notes.add(format!("{}: {} bytes after the last row are ignored", source.name, here - pixels));
            }
        }
        // Rows come bottom up: what is missing is the top of the picture.
        _ => {
            let row = 4 * ncomp as u64 * width as u64;
            return invalid!("picture ends at row {} of {height}, from the bottom", here / row + 1);
        }
    }
    let swap = (scale > 0.0) == cfg!(target_endian = "little");
    Ok(Box::new(Reader { source, header, start, swap, factor: scale.abs(), row: 0, bytes: Vec::new() }))
}

/// The four words of a header and where the pixels begin: one white space (or CR LF) after the last word.
fn header_words(first: &[u8]) -> Result<([String; 4], u64)> {
    let mut words: [String; 4] = Default::default();
    let mut n = 0;
    for (at, byte) in first.iter().enumerate() {
        if !byte.is_ascii_whitespace() {
            words[n].push(char::from(*byte));
        } else if !words[n].is_empty() {
            n += 1;
            if n == 4 {
                let crlf = *byte == b'\r' && first.get(at + 1) == Some(&b'\n');
                return Ok((words, at as u64 + 1 + u64::from(crlf)));
            }
        }
    }
    invalid!("PFM header: expected 'PF', width, height and scale in the first {LONGEST_HEADER} bytes")
}

/// What three or one floats mean where nothing says it.
fn assumed(resolution: Resolution, ncomp: usize, o: &Overrides, notes: &Notes, name: &str) -> Result<Header> {
    let rgb = ncomp == 3;
    let components = o.components.unwrap_or(if rgb { Components::Rgb } else { Components::Y });
    let fits = if rgb { matches!(components, Components::Rgb | Components::Xyz) } else { components == Components::Y };
    if !fits {
        return invalid!("--components {components} does not go with PFM of {ncomp} components");
    }
    let units = o.units.unwrap_or(Units::CdM2);
    if units == Units::SpectralRadiance || (units == Units::Number && rgb) {
        return invalid!("--units {units} does not go with COMPONENTS={components}");
    }
    let mut header = Header::new(resolution, components, ncomp, units);
    if components == Components::Rgb {
        header.primaries = Some(o.primaries.unwrap_or(Primaries::BT709));
    }
    header.white = o.white.or(header.primaries.map(|p| p.white));
    if o.components.is_none() || o.units.is_none() {
        let what = if rgb { format!("{components} of BT.709 primaries") } else { "luminance".to_string() };
        let what = if components == Components::Xyz { components.to_string() } else { what };
        notes.add(format!("{name}: PFM says nothing of its numbers: taking them for {what} in {units}"));
    }
    Ok(header)
}

impl Picture for Reader {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let height = self.header.resolution.height;
        let rows = block_rows(&self.header, height - self.row);
        block.data.clear();
        block.rows = 0;
        if self.row == height {
            return Ok(false);
        }
        let row = self.header.scanline_floats();
        let first_stored = (height - self.row - rows) as u64;
        let at = self.start + first_stored * 4 * row as u64;
        let read = self.source.read_at(at, 4 * (rows * row) as u64, &mut self.bytes);
        read.map_err(|e| e.within(&self.source.name))?;
        let value = |b: &[u8]| {
            let bits = u32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
            f32::from_bits(if self.swap { bits.swap_bytes() } else { bits }) * self.factor
        };
        for line in self.bytes.chunks_exact(4 * row).rev() {
            block.data.extend(line.chunks_exact(4).map(value));
        }
        block.rows = rows;
        self.row += rows;
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.row = 0;
        Ok(true)
    }
}

/// Writes an upright picture of one or three components.
pub fn write(
    mut picture: Box<dyn Picture>,
    big_endian: bool,
    out: &mut Output,
    limits: &Limits,
    notes: &Notes,
) -> Result<()> {
    let mut block = Block::default();
    let mut more = picture.next(&mut block)?;
    let header = picture.header().clone();
    let (width, height) = (header.resolution.width, header.resolution.height);
    let kind = if header.ncomp == 3 { "PF" } else { "Pf" };
    let text = format!("{kind}\n{width} {height}\n{}\n", if big_endian { "1.0" } else { "-1.0" });
    let row = 4 * header.scanline_floats();
    let mut file = BufWriter::with_capacity(64 << 10, out.in_any_order(limits)?);
    let failed = |e| Error::io("", e);
    file.write_all(text.as_bytes()).map_err(failed)?;
    let (mut left, mut bytes) = (height, Vec::new());
    while more {
        left -= block.rows;
        bytes.clear();
        for line in block.data.chunks_exact(row / 4).rev() {
            if big_endian {
                bytes.extend(line.iter().flat_map(|x| x.to_be_bytes()));
            } else {
                bytes.extend(line.iter().flat_map(|x| x.to_le_bytes()));
            }
        }
        file.seek(SeekFrom::Start(text.len() as u64 + left as u64 * row as u64)).map_err(failed)?;
        file.write_all(&bytes).map_err(failed)?;
        more = picture.next(&mut block)?;
    }
    file.into_inner().map_err(|e| failed(e.into_error()))?.finish(notes)
}
