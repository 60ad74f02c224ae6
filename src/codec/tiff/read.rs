//! Rows out of TIFF's strips and tiles.

use std::ops::Range;

use rayon::prelude::*;

use super::directory::{Directory, tag};
use crate::codec::{LONGEST_SCANLINE, Reading};
use crate::color::{Primaries, Xy};
use crate::notes::Notes;
use crate::parallel;
use crate::stream::annotation::Annotation;
use crate::stream::picture::block_rows;
use crate::stream::source::Source;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, invalid};

/// What a decoder may take beside its bytes: inflate's window, tables and buffer.
const BEGUN: usize = 80 << 10;

/// How the pixels of a strip or tile are coded.
pub trait Coder: Send + Sync {
    /// Begins a strip or tile of `width` pixels a row; `bytes` is all there is of it. Beside those it costs a window of deflate at most.
    fn begin(&self, bytes: Vec<u8>, width: usize) -> Box<dyn Rows>;

    /// Fewest bytes that can hold so many pixels: less is damage, found before anything is allocated.
    fn fewest_bytes(&self, width: usize, rows: usize) -> u64;
}

/// A strip or tile being decoded from its top.
pub trait Rows: Send {
    /// Decodes one row into `out`; an error where the bytes end early or make no sense.
    fn row(&mut self, out: &mut [f32]) -> Result<()>;
}

/// Where strips or tiles lie.
struct Chunks {
    offsets: Vec<u64>,
    counts: Vec<u64>,
    /// Of a chunk.
    width: usize,
    /// Of a chunk.
    height: usize,
    /// Chunks side by side.
    across: usize,
}

impl Chunks {
    fn find(directory: &Directory, source: &mut Source, width: usize, height: usize) -> Result<Chunks> {
        let tiled = directory.number(tag::TILE_WIDTH).is_some();
        let (offsets, counts, chunk_width, chunk_height) = if tiled {
            let w = directory.size(tag::TILE_WIDTH, "tile width")?;
            let h = directory.size(tag::TILE_HEIGHT, "tile height")?;
            if w > LONGEST_SCANLINE / 3 {
                return invalid!("TIFF of tiles {w} pixels wide: expected at most {}", LONGEST_SCANLINE / 3);
            }
            (tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS, w, h)
        } else {
            let rows = directory.number(tag::ROWS_PER_STRIP).unwrap_or(u64::MAX).min(height as u64);
            if rows == 0 {
                return invalid!("TIFF with 0 rows a strip");
            }
            (tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS, width, rows as usize)
        };
        let what = if tiled { "tile" } else { "strip" };
        let mut list = |tag: u16| match directory.numbers(tag, source)? {
            Some(list) => Ok(list),
            None => invalid!("TIFF has no list of {what} offsets and byte counts"),
        };
        let (offsets, counts) = (list(offsets)?, list(counts)?);
        let across = width.div_ceil(chunk_width);
        let needed = across as u64 * height.div_ceil(chunk_height) as u64;
        if (offsets.len().min(counts.len()) as u64) < needed {
            return invalid!("TIFF lists {} {what}s: expected {needed}", offsets.len().min(counts.len()));
        }
        Ok(Chunks { offsets, counts, width: chunk_width, height: chunk_height, across })
    }

    /// Where the last of them ends.
    fn end(&self) -> u64 {
        self.offsets.iter().zip(&self.counts).map(|(at, n)| at.saturating_add(*n)).max().unwrap_or(0)
    }
}

/// A TIFF picture being read.
struct Reader<C> {
    source: Source,
    header: Header,
    chunks: Chunks,
    coder: C,
    row: usize,
    /// Bytes of the chunks that were read: beyond the file's length some of them are the same, which is how a small file could
    /// claim any work.
    taken: u64,
    /// Chunks side by side that were begun and have rows left.
    band: Vec<Box<dyn Rows>>,
    band_rows: usize,
    /// A row of a chunk.
    piece: Vec<f32>,
}

/// Reads a picture whose header is settled.
pub fn open<C: Coder + 'static>(
    mut source: Source,
    directory: &Directory,
    header: Header,
    coder: C,
    notes: &Notes,
) -> Result<Box<dyn Picture>> {
    let (columns, rows) = (header.resolution.scanline_len(), header.resolution.scanlines());
    let chunks = Chunks::find(directory, &mut source, columns, rows)?;
    let end = chunks.end().max(directory.end);
    if directory.next {
        notes.add(format!("{}: reading the first of several pictures", source.name));
    } else if end.saturating_add(1) < source.len() && !directory.more {
        notes.add(format!("{}: {} bytes after its last strip and tag are ignored", source.name, source.len() - end));
    }
    let (band, piece) = (Vec::new(), Vec::new());
    Ok(Box::new(Reader { source, header, chunks, coder, row: 0, taken: 0, band, band_rows: 0, piece }))
}

impl<C: Coder> Reader<C> {
    /// Checks that chunks can hold their rows, before anything is allocated for these.
    fn claim(&mut self, chunks: Range<usize>) -> Result<()> {
        let (height, len) = (self.header.resolution.scanlines(), self.source.len());
        for index in chunks {
            let top = index / self.chunks.across * self.chunks.height;
            let rows = self.chunks.height.min(height - top);
            let (offset, count) = (self.chunks.offsets[index], self.chunks.counts[index]);
            if count < self.coder.fewest_bytes(self.chunks.width, rows) {
                return invalid!("picture ends at row {} of {height}: {count} bytes cannot hold {rows} rows", top + 1);
            }
            self.source.check(offset, count).map_err(|e| at_row(e, top, height))?;
            self.taken += count;
            if self.taken > len {
                return invalid!(
                    "row {}: its strips or tiles lie upon each other; expected bytes of their own",
                    top + 1
                );
            }
        }
        Ok(())
    }

    /// A chunk as it lies in the file, which was claimed.
    fn fetch(&mut self, index: usize) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.source.read_at(self.chunks.offsets[index], self.chunks.counts[index], &mut bytes)?;
        Ok(bytes)
    }

    /// Whole strips, as many as make up `rows`, on all threads.
    fn strips(&mut self, rows: usize, block: &mut Block) -> Result<()> {
        let (first, count) = (self.row / self.chunks.height, rows / self.chunks.height);
        let last = self.header.resolution.scanlines().div_ceil(self.chunks.height);
        let last = last.min(first + count.max(1));
        self.claim(first..last)?;
        let strips = (first..last).map(|i| self.fetch(i)).collect::<Result<Vec<_>>>()?;
        let whole = (last - first) * self.chunks.height;
        block.rows = whole.min(self.header.resolution.scanlines() - self.row);
        let row_floats = self.header.scanline_floats();
        block.data.resize(block.rows * row_floats, 0.0);
        let (top, height) = (self.row, self.header.resolution.scanlines());
        let (coder, width, each) = (&self.coder, self.chunks.width, self.chunks.height);
        // A strip's decoder lives no longer than the strip, or many small ones would fill the memory.
        let decode = |(i, (part, bytes)): (usize, (&mut [f32], Vec<u8>))| -> Result<()> {
            let mut strip = coder.begin(bytes, width);
            for (n, row) in part.chunks_exact_mut(row_floats).enumerate() {
                strip.row(row).map_err(|e| at_row(e, top + i * each + n, height))?;
            }
            Ok(())
        };
        let parts = block.data.chunks_mut(each * row_floats);
        if parallel::threads() == 1 {
            return parts.zip(strips).enumerate().try_for_each(decode);
        }
        // The first failure in the picture's order counts.
        let parts = block.data.par_chunks_mut(each * row_floats);
        let results: Vec<Result<()>> = parts.zip(strips).enumerate().map(decode).collect();
        results.into_iter().collect()
    }

    /// Up to `rows` rows of one band of tiles, or of a tall strip.
    fn rows_of_band(&mut self, rows: usize, block: &mut Block) -> Result<()> {
        let (row_floats, chunk) = (self.header.scanline_floats(), self.chunks.width);
        if self.band_rows == 0 {
            let first = self.row / self.chunks.height * self.chunks.across;
            let band = first..first + self.chunks.across;
            let height = self.chunks.height.min(self.header.resolution.scanlines() - self.row);
            self.claim(band.clone())?;
            self.piece.resize(chunk * self.header.ncomp, 0.0);
            if band.len() > 1 && band.len() * BEGUN > 4 * height * row_floats {
                return self.band_at_once(first, height, block);
            }
            let packed = band.map(|i| self.fetch(i)).collect::<Result<Vec<_>>>()?;
            self.band = packed.into_iter().map(|bytes| self.coder.begin(bytes, chunk)).collect();
            self.band_rows = height;
        }
        block.rows = rows.min(self.band_rows);
        self.band_rows -= block.rows;
        block.data.resize(block.rows * row_floats, 0.0);
        for (n, line) in block.data.chunks_exact_mut(row_floats).enumerate() {
            for (rows, part) in self.band.iter_mut().zip(line.chunks_mut(self.piece.len())) {
                rows.row(&mut self.piece).map_err(|e| at_row(e, self.row + n, self.header.resolution.scanlines()))?;
                part.copy_from_slice(&self.piece[..part.len()]);
            }
        }
        Ok(())
    }

    /// A whole band of tiles one after the other, where their rows take less room than their decoders.
    fn band_at_once(&mut self, first: usize, rows: usize, block: &mut Block) -> Result<()> {
        let (row_floats, piece) = (self.header.scanline_floats(), self.piece.len());
        block.rows = rows;
        block.data.resize(rows * row_floats, 0.0);
        for i in 0..self.chunks.across {
            let bytes = self.fetch(first + i)?;
            let mut tile = self.coder.begin(bytes, self.chunks.width);
            for (n, line) in block.data.chunks_exact_mut(row_floats).enumerate() {
                let part = &mut line[i * piece..row_floats.min((i + 1) * piece)];
                tile.row(&mut self.piece).map_err(|e| at_row(e, self.row + n, self.header.resolution.scanlines()))?;
                part.copy_from_slice(&self.piece[..part.len()]);
            }
        }
        Ok(())
    }
}

/// Where a picture ends too early.
fn at_row(e: Error, row: usize, height: usize) -> Error {
    match e {
        io @ Error::Io { .. } => io,
        e => Error::Invalid(format!("picture ends at row {} of {height}: {e}", row + 1)),
    }
}

impl<C: Coder> Picture for Reader<C> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let height = self.header.resolution.scanlines();
        if self.row == height {
            block.rows = 0;
            block.data.clear();
            return Ok(false);
        }
        let rows = block_rows(&self.header, height - self.row);
        let whole = self.chunks.across == 1 && self.chunks.width == self.header.resolution.scanline_len();
        let done = if whole && self.chunks.height <= rows.max(1) {
            self.strips(rows, block)
        } else {
            self.rows_of_band(rows, block)
        };
        done.map_err(|e| e.within(&self.source.name))?;
        self.row += block.rows;
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        (self.row, self.band_rows, self.taken) = (0, 0, 0);
        Ok(true)
    }
}

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
