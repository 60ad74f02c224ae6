//! Pictures of RGBE or XYZE: scanlines are unpacked one after the other, since none says how long it is, and become floats on
//! all threads.

use super::reader::{Input, explain};
use super::rle::{self, Planes};
use super::{Block, Header, Picture, picture, rgbe};
use crate::Result;
use crate::notes::Notes;
use crate::parallel::Pieces;

/// The file, as far as it is read.
struct Coded {
    input: Input,
    header: Header,
    decoder: rle::Decoder,
    /// Byte position of the first pixel, for seekable input.
    start: u64,
    row: usize,
    notes: Notes,
}

/// Some scanlines.
#[derive(Default)]
struct Scanlines {
    planes: Planes,
    block: Block,
}

impl AsMut<Block> for Scanlines {
    fn as_mut(&mut self) -> &mut Block {
        &mut self.block
    }
}

impl Pieces for Coded {
    type Piece = Scanlines;
    /// The components' factors.
    type Tools = [f32; 3];

    fn fill(&mut self, _: &[f32; 3], piece: &mut Scanlines) -> Result<bool> {
        let total = self.header.resolution.scanlines();
        if self.row == total {
            return Ok(false);
        }
        let (rows, width) =
            (picture::block_rows(&self.header, total - self.row), self.header.resolution.scanline_len());
        for row in 0..rows {
            let unpacked = self.decoder.scanline(&mut self.input.bytes, width, &mut piece.planes, row * width);
            unpacked.map_err(|e| explain(e, self.row + row + 1, total).within(&self.input.name))?;
        }
        piece.planes.iter_mut().for_each(|plane| plane.truncate(rows * width));
        piece.block.rows = rows;
        self.row += rows;
        if self.row == total && self.decoder.is_mixed() {
            let name = &self.input.name;
            self.notes.add(format!("{name}: some rows are run lengths and some are not: it may be damaged"));
        }
        if self.row == total && (self.decoder.has_rest() || self.input.has_rest()) {
            self.notes.add(format!("{}: bytes after the last row are ignored", self.input.name));
        }
        Ok(true)
    }

    fn work(factors: &[f32; 3], Scanlines { planes, block }: &mut Scanlines) -> Result<()> {
        block.data.resize(3 * planes[0].len(), 0.0);
        rgbe::decode_pixels(planes, *factors, &mut block.data);
        Ok(())
    }

    fn rewind(&mut self) -> Result<bool> {
        self.decoder.clear();
        self.row = 0;
        self.input.restart(self.start)
    }
}

/// A picture whose input stands before its first pixel, at byte `start` if it is seekable.
pub(super) fn open(input: Input, start: u64, header: Header, factors: [f32; 3], notes: Notes) -> Box<dyn Picture> {
    let coded = Coded { input, header: header.clone(), decoder: rle::Decoder::default(), start, row: 0, notes };
    picture::of_pieces(header, coded, factors)
}
