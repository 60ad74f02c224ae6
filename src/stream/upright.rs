//! Turning any scan order into rows top down, pixels left to right, for formats that have no other.

use crate::stream::spool::Limits;
use crate::stream::{Block, Header, Picture, Resolution};
use crate::{Error, Result};

/// The picture with `-Y height +X width`. Mirrored rows are turned one by one; other orders need the whole picture, which
/// is kept in memory (an error beyond `limits.memory`).
pub fn upright(mut input: Box<dyn Picture>, limits: &Limits) -> Result<Box<dyn Picture>> {
    let r = input.header().resolution;
    if r == Resolution::upright(r.width, r.height) {
        return Ok(input);
    }
    let mut header = input.header().clone();
    header.resolution = Resolution::upright(r.width, r.height);
    if r.by_rows && !r.from_bottom {
        let (ncomp, width) = (header.ncomp, r.width);
        return Ok(Box::new(MirroredRows { input, header, ncomp, width }));
    }
    let bytes = 8 * header.scanline_floats() as u64 * r.height as u64; // twice: as stored and upright
    if bytes > limits.memory {
        return Err(Error::Unsupported(format!(
            "turning a picture stored as '{r}' upright takes {} MB; allow it with --memory",
            bytes.div_ceil(1 << 20)
        )));
    }
    let n = header.ncomp;
    // Scanlines as they come first: memory grows with what arrives, not with what a header claims.
    let mut scanlines: Vec<f32> = Vec::new();
    let mut block = Block::default();
    while input.next(&mut block)? {
        scanlines.extend_from_slice(&block.data);
    }
    let len = r.scanline_len();
    let mut all = Vec::with_capacity(scanlines.len());
    for y in 0..r.height {
        let y = if r.from_bottom { r.height - 1 - y } else { y };
        for x in 0..r.width {
            let x = if r.from_right { r.width - 1 - x } else { x };
            let (line, at) = if r.by_rows { (y, x) } else { (x, y) };
            all.extend_from_slice(&scanlines[(line * len + at) * n..][..n]);
        }
    }
    Ok(Box::new(Whole { header, data: all, done: false }))
}

struct MirroredRows {
    input: Box<dyn Picture>,
    header: Header,
    ncomp: usize,
    width: usize,
}

impl Picture for MirroredRows {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        for line in block.data.chunks_exact_mut(self.width * self.ncomp) {
            line.reverse(); // pixels and, within each, components
            line.chunks_exact_mut(self.ncomp).for_each(<[f32]>::reverse);
        }
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.input.rewind()
    }
}

/// A picture held as one block.
struct Whole {
    header: Header,
    data: Vec<f32>,
    done: bool,
}

impl Picture for Whole {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        if std::mem::replace(&mut self.done, true) {
            block.rows = 0;
            block.data.clear();
            return Ok(false);
        }
        block.rows = self.header.resolution.height;
        block.data = std::mem::take(&mut self.data);
        Ok(true)
    }
}
