//! Rows out of TIFF's strips and tiles.

use std::marker::PhantomData;
use std::ops::Range;

use super::directory::{Directory, tag};
use crate::codec::LONGEST_SCANLINE;
use crate::notes::Notes;
use crate::parallel::Pieces;
use crate::stream::picture::{self, block_rows};
use crate::stream::source::Source;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, invalid};

/// What a decoder may take beside its bytes: inflate's window, tables and buffer.
const BEGUN: usize = 80 << 10;

/// Strips of so many blocks' rows are decoded whole, each by one thread; taller ones row by row.
const TALLEST: usize = 8;

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

    /// After the last row that the picture has of it, up to `values` more may follow. An error where its bytes end otherwise, for a
    /// coding that can tell.
    fn end(&mut self, _values: usize) -> Result<()> {
        Ok(())
    }
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

/// The file, as far as it is read.
struct Chunked<C> {
    source: Source,
    row: usize,
    /// Bytes of the chunks that were read: beyond the file's length some of them are the same, which is how a small file could
    /// claim any work.
    taken: u64,
    /// Chunks side by side that were begun and have rows left.
    band: Vec<Box<dyn Rows>>,
    band_rows: usize,
    /// A row of a chunk.
    piece: Vec<f32>,
    coder: PhantomData<C>,
}

/// What stays the same from row to row.
struct Plan<C> {
    /// Of the file, for messages.
    name: String,
    header: Header,
    chunks: Chunks,
    coder: C,
}

/// Some rows, in strips yet to be decoded where there are any.
#[derive(Default)]
struct Strips {
    first_row: usize,
    packed: Vec<Vec<u8>>,
    block: Block,
}

impl AsMut<Block> for Strips {
    fn as_mut(&mut self) -> &mut Block {
        &mut self.block
    }
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
    let plan = Plan { name: source.name.clone(), header: header.clone(), chunks, coder };
    let (band, piece) = (Vec::new(), Vec::new());
    let file = Chunked { source, row: 0, taken: 0, band, band_rows: 0, piece, coder: PhantomData };
    Ok(picture::of_pieces(header, file, plan))
}

impl<C: Coder + 'static> Pieces for Chunked<C> {
    type Piece = Strips;
    type Tools = Plan<C>;

    fn fill(&mut self, plan: &Plan<C>, piece: &mut Strips) -> Result<bool> {
        let height = plan.header.resolution.scanlines();
        if self.row == height {
            return Ok(false);
        }
        let rows = block_rows(&plan.header, height - self.row);
        let whole = plan.chunks.across == 1 && plan.chunks.width == plan.header.resolution.scanline_len();
        piece.first_row = self.row;
        piece.packed.clear();
        let done = if whole && plan.chunks.height <= rows.max(1).saturating_mul(TALLEST) {
            self.strips(plan, rows, piece)
        } else {
            self.rows_of_band(plan, rows, &mut piece.block)
        };
        done.map_err(|e| e.within(&plan.name))?;
        self.row += piece.block.rows;
        Ok(true)
    }

    fn work(plan: &Plan<C>, Strips { first_row, packed, block }: &mut Strips) -> Result<()> {
        let row_floats = plan.header.scanline_floats();
        if !packed.is_empty() {
            block.data.resize(block.rows * row_floats, 0.0);
        }
        let parts = block.data.chunks_mut(plan.chunks.height * row_floats);
        for (i, (part, bytes)) in parts.zip(packed.drain(..)).enumerate() {
            // A strip's decoder lives no longer than the strip, or many small ones would fill the memory.
            let mut strip = plan.coder.begin(bytes, plan.chunks.width);
            for (n, row) in part.chunks_exact_mut(row_floats).enumerate() {
                let at = *first_row + i * plan.chunks.height + n;
                strip.row(row).map_err(|e| plan.at_row(e, at).within(&plan.name))?;
            }
            let rows = part.len() / row_floats;
            let padding = (plan.chunks.height - rows) * row_floats;
            let last = *first_row + i * plan.chunks.height + rows;
            strip.end(padding).map_err(|e| plan.at_end(e, last).within(&plan.name))?;
        }
        Ok(())
    }

    fn rewind(&mut self) -> Result<bool> {
        (self.row, self.band_rows, self.taken) = (0, 0, 0);
        Ok(true)
    }
}

impl<C: Coder> Chunked<C> {
    /// Checks that chunks can hold their rows, before anything is allocated for these.
    fn claim(&mut self, plan: &Plan<C>, chunks: Range<usize>) -> Result<()> {
        let (height, len) = (plan.header.resolution.scanlines(), self.source.len());
        for index in chunks {
            let top = index / plan.chunks.across * plan.chunks.height;
            let rows = plan.chunks.height.min(height - top);
            let (offset, count) = (plan.chunks.offsets[index], plan.chunks.counts[index]);
            if count < plan.coder.fewest_bytes(plan.chunks.width, rows) {
                return invalid!("picture ends at row {} of {height}: {count} bytes cannot hold {rows} rows", top + 1);
            }
            self.source.check(offset, count).map_err(|e| plan.at_row(e, top))?;
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
    fn fetch(&mut self, plan: &Plan<C>, index: usize) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.source.read_at(plan.chunks.offsets[index], plan.chunks.counts[index], &mut bytes)?;
        Ok(bytes)
    }

    /// Whole strips, as many as make up `rows`.
    fn strips(&mut self, plan: &Plan<C>, rows: usize, piece: &mut Strips) -> Result<()> {
        let (each, height) = (plan.chunks.height, plan.header.resolution.scanlines());
        let first = self.row / each;
        let last = height.div_ceil(each).min(first + (rows / each).max(1));
        self.claim(plan, first..last)?;
        for i in first..last {
            piece.packed.push(self.fetch(plan, i)?);
        }
        piece.block.rows = ((last - first) * each).min(height - self.row);
        Ok(())
    }

    /// Up to `rows` rows of one band of tiles, or of a tall strip.
    fn rows_of_band(&mut self, plan: &Plan<C>, rows: usize, block: &mut Block) -> Result<()> {
        let (row_floats, chunk) = (plan.header.scanline_floats(), plan.chunks.width);
        if self.band_rows == 0 {
            let first = self.row / plan.chunks.height * plan.chunks.across;
            let band = first..first + plan.chunks.across;
            let height = plan.chunks.height.min(plan.header.resolution.scanlines() - self.row);
            self.claim(plan, band.clone())?;
            self.piece.resize(chunk * plan.header.ncomp, 0.0);
            if band.len() > 1 && band.len() * BEGUN > 4 * height * row_floats {
                return self.band_at_once(plan, first, height, block);
            }
            let packed = band.map(|i| self.fetch(plan, i)).collect::<Result<Vec<_>>>()?;
            self.band = packed.into_iter().map(|bytes| plan.coder.begin(bytes, chunk)).collect();
            self.band_rows = height;
        }
        block.rows = rows.min(self.band_rows);
        self.band_rows -= block.rows;
        block.data.resize(block.rows * row_floats, 0.0);
        for (n, line) in block.data.chunks_exact_mut(row_floats).enumerate() {
            for (rows, part) in self.band.iter_mut().zip(line.chunks_mut(self.piece.len())) {
                rows.row(&mut self.piece).map_err(|e| plan.at_row(e, self.row + n))?;
                part.copy_from_slice(&self.piece[..part.len()]);
            }
        }
        if self.band_rows == 0 {
            let last = self.row + block.rows;
            let padding = (last.next_multiple_of(plan.chunks.height) - last) * self.piece.len();
            self.band.iter_mut().try_for_each(|rows| rows.end(padding).map_err(|e| plan.at_end(e, last)))?;
        }
        Ok(())
    }

    /// A whole band of tiles one after the other, where their rows take less room than their decoders.
    fn band_at_once(&mut self, plan: &Plan<C>, first: usize, rows: usize, block: &mut Block) -> Result<()> {
        let (row_floats, piece) = (plan.header.scanline_floats(), self.piece.len());
        block.rows = rows;
        block.data.resize(rows * row_floats, 0.0);
        for i in 0..plan.chunks.across {
            let bytes = self.fetch(plan, first + i)?;
            let mut tile = plan.coder.begin(bytes, plan.chunks.width);
            for (n, line) in block.data.chunks_exact_mut(row_floats).enumerate() {
                let part = &mut line[i * piece..row_floats.min((i + 1) * piece)];
                tile.row(&mut self.piece).map_err(|e| plan.at_row(e, self.row + n))?;
                part.copy_from_slice(&self.piece[..part.len()]);
            }
            let padding = (plan.chunks.height - rows) * piece;
            tile.end(padding).map_err(|e| plan.at_end(e, self.row + rows))?;
        }
        Ok(())
    }
}

impl<C> Plan<C> {
    /// Where a strip or tile ends otherwise than it should.
    fn at_end(&self, e: Error, rows: usize) -> Error {
        Error::Invalid(format!("the strip or tile that ends with row {rows} is damaged: {e}"))
    }

    /// Where a picture ends too early.
    fn at_row(&self, e: Error, row: usize) -> Error {
        match e {
            io @ Error::Io { .. } => io,
            e => {
                let height = self.header.resolution.scanlines();
                Error::Invalid(format!("picture ends at row {} of {height}: {e}", row + 1))
            }
        }
    }
}
