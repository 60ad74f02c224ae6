//! A picture as it flows: a header now, rows on demand, a block at a time.

use crate::Result;
use crate::parallel::{self, Ahead, Pieces};
use crate::stream::Header;

/// Bytes of a block that the caches and a pipe like; a block always holds at least one scanline.
const BLOCK_BYTES: usize = 256 << 10;

/// Consecutive scanlines, pixel-interleaved.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Number of scanlines in `data`.
    pub rows: usize,
    /// `rows` x scanline x components floats.
    pub data: Vec<f32>,
}

/// A source of scanlines in scan order.
pub trait Picture: Send {
    /// What the picture is.
    fn header(&self) -> &Header;

    /// Replaces `block` by the next scanlines; false, and an empty block, after the last.
    fn next(&mut self, block: &mut Block) -> Result<bool>;

    /// Goes back before the first scanline, if that costs nothing but reading again; false if it cannot.
    fn rewind(&mut self) -> Result<bool> {
        Ok(false)
    }
}

/// Scanlines a block should hold.
pub fn block_rows(header: &Header, left: usize) -> usize {
    (BLOCK_BYTES / (4 * header.scanline_floats())).clamp(1, left.max(1))
}

type InPlace = Box<dyn Fn(&mut [f32]) + Send + Sync>;
type Across = Box<dyn Fn(&[f32], &mut [f32]) + Send + Sync>;

enum Work {
    InPlace(InPlace),
    Across(Across),
}

/// A picture whose pixels are those of another one, mapped row by row.
pub struct Mapped {
    input: Box<dyn Picture>,
    header: Header,
    work: Work,
    parallel: bool,
    spare: Block,
}

/// Maps pixels in place: `f` gets whole pixels, any number of them. Light work, done on the calling thread.
pub fn map(
    input: Box<dyn Picture>,
    header: Header,
    f: impl Fn(&mut [f32]) + Send + Sync + 'static,
) -> Box<dyn Picture> {
    Box::new(Mapped { input, header, work: Work::InPlace(Box::new(f)), parallel: false, spare: Block::default() })
}

/// Maps pixels in place on all threads, for work that outweighs handing it out.
pub fn map_on_all_threads(
    input: Box<dyn Picture>,
    header: Header,
    f: impl Fn(&mut [f32]) + Send + Sync + 'static,
) -> Box<dyn Picture> {
    Box::new(Mapped { input, header, work: Work::InPlace(Box::new(f)), parallel: true, spare: Block::default() })
}

/// Maps pixels to pixels of another number of components: `f` gets whole pixels and room for as many.
pub fn map_across(
    input: Box<dyn Picture>,
    header: Header,
    f: impl Fn(&[f32], &mut [f32]) + Send + Sync + 'static,
) -> Box<dyn Picture> {
    Box::new(Mapped { input, header, work: Work::Across(Box::new(f)), parallel: true, spare: Block::default() })
}

impl Picture for Mapped {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        match &self.work {
            Work::InPlace(f) => {
                let more = self.input.next(block)?;
                if self.parallel {
                    parallel::for_pieces(&mut block.data, self.header.ncomp, |_, piece| f(piece));
                } else {
                    f(&mut block.data);
                }
                Ok(more)
            }
            Work::Across(f) => {
                let more = self.input.next(&mut self.spare)?;
                let (from, to) = (self.input.header().ncomp, self.header.ncomp);
                let pixels = self.spare.data.len() / from;
                block.rows = self.spare.rows;
                block.data.resize(pixels * to, 0.0);
                let source = &self.spare.data;
                parallel::for_pieces(&mut block.data, to, |first, piece| {
                    f(&source[first * from..][..piece.len() / to * from], piece);
                });
                Ok(more)
            }
        }
    }

    fn rewind(&mut self) -> Result<bool> {
        self.input.rewind()
    }
}

/// A picture whose rows are decoded ahead, on all threads.
struct Decoded<P: Pieces> {
    header: Header,
    pieces: Ahead<P>,
}

/// A picture of pieces that each hold a block.
pub fn of_pieces<P: Pieces<Piece: AsMut<Block>>>(header: Header, source: P, tools: P::Tools) -> Box<dyn Picture> {
    Box::new(Decoded { header, pieces: Ahead::new(source, tools) })
}

impl<P: Pieces<Piece: AsMut<Block>>> Picture for Decoded<P> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.pieces.next(|piece| std::mem::swap(piece.as_mut(), block))?;
        if !more {
            block.rows = 0;
            block.data.clear();
        }
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.pieces.rewind()
    }
}

/// A picture that says something after its last row.
struct AtEnd<F> {
    input: Box<dyn Picture>,
    say: Option<F>,
}

/// Calls `say` once the last row has been read.
pub fn at_end(input: Box<dyn Picture>, say: impl FnOnce() + Send + 'static) -> Box<dyn Picture> {
    Box::new(AtEnd { input, say: Some(say) })
}

impl<F: FnOnce() + Send> Picture for AtEnd<F> {
    fn header(&self) -> &Header {
        self.input.header()
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        if let Some(say) = self.say.take_if(|_| !more) {
            say();
        }
        Ok(more)
    }
}

/// A picture that comes in blocks and goes in pieces, beside others whose blocks are of other sizes.
pub struct Side {
    picture: Box<dyn Picture>,
    block: Block,
    at: usize,
}

impl Side {
    /// Nothing is read yet.
    pub fn new(picture: Box<dyn Picture>) -> Side {
        Side { picture, block: Block::default(), at: 0 }
    }

    /// Makes sure that there is a rest; false after the last row.
    pub fn fill(&mut self) -> Result<bool> {
        while self.at == self.block.data.len() {
            self.at = 0;
            if !self.picture.next(&mut self.block)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// What is read and not taken yet.
    pub fn rest(&self) -> &[f32] {
        &self.block.data[self.at..]
    }

    /// Takes so many floats of the rest.
    pub fn take(&mut self, floats: usize) {
        self.at += floats;
    }
}

/// Multiplies each pixel's components by their factors.
pub fn scale(data: &mut [f32], factors: &[f32]) {
    for pixel in data.chunks_exact_mut(factors.len()) {
        pixel.iter_mut().zip(factors).for_each(|(x, f)| *x *= f);
    }
}
