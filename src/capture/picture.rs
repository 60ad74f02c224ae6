//! The merged picture as it flows, and the mask beside it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::merge::{Colours, Merge, Seen};
use crate::notes::Notes;
use crate::stream::output::Output;
use crate::stream::picture::block_rows;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, parallel};

/// Levels of the mask: what was seen well, what is black in every exposure, what is white.
pub const MASK_LEVELS: [u8; 3] = [0, 128, 255];

/// A bracket, merged a block of rows at a time on all threads.
pub struct Merged {
    header: Header,
    merge: Merge,
    colours: Colours,
    scale: f64,
    row: usize,
    /// Where the mask goes, and its rows so far.
    mask: Option<(PathBuf, Vec<u8>)>,
    black: u64,
    white: u64,
    notes: Notes,
}

impl Merged {
    /// `header` has the size that the lens leaves; `scale` makes light what the header says.
    pub fn new(
        header: Header,
        merge: Merge,
        colours: Colours,
        scale: f64,
        mask: Option<PathBuf>,
        notes: Notes,
    ) -> Merged {
        let mask = mask.map(|path| (path, Vec::new()));
        Merged { header, merge, colours, scale, row: 0, mask, black: 0, white: 0, notes }
    }

    /// Writes the mask and says how much it marks.
    fn end(&mut self) -> Result<()> {
        let [_, _, width, height] = self.merge.lens.part;
        let share = |n: u64| 100.0 * n as f64 / (width * height) as f64;
        let (white, black) = (std::mem::take(&mut self.white), std::mem::take(&mut self.black));
        if white > 0 {
            self.notes.add(format!(
                "{white} pixels ({:.2} %) are white even in the shortest exposure: their light is a lower bound (--mask shows them)",
                share(white)
            ));
        }
        if black > 0 {
            self.notes.add(format!(
                "{black} pixels ({:.2} %) are black even in the longest exposure: their light is an upper bound (--mask shows them)",
                share(black)
            ));
        }
        let Some((path, mask)) = self.mask.take() else { return Ok(()) };
        let mut out = Output::create(Some(&path), true)?;
        let (w, h) = (width as u32, height as u32); // at most MOST_PIXELS of src/capture/read.rs
        let mut encoder = png::Encoder::new(&mut out, w, h);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&mask)?;
            writer.finish()
        });
        written.map_err(|e| match e {
            png::EncodingError::IoError(e) => out.error(e),
            other => Error::Invalid(format!("{}: {other}", path.display())),
        })?;
        out.finish()
    }
}

impl Picture for Merged {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let [left, top, width, height] = self.merge.lens.part;
        block.rows = block_rows(&self.header, height - self.row).min(height - self.row);
        block.data.clear();
        if block.rows == 0 {
            self.end()?;
            return Ok(false);
        }
        block.data.resize(3 * width * block.rows, 0.0);
        let (merge, colours, scale) = (&self.merge, &self.colours, self.scale);
        let place = |row: usize, i: usize| (left + i % width, top + row + i / width);
        let (row, black, white) = (self.row, AtomicU64::new(0), AtomicU64::new(0));
        parallel::for_pieces(&mut block.data, 3, |first, piece| {
            for (i, pixel) in piece.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let (x, y) = place(row, first + i);
                let Some(light) = merge.light(x, y) else { continue };
                *pixel = colours.apply(light, scale);
                match merge.seen(x, y) {
                    Seen::Black => drop(black.fetch_add(1, Relaxed)),
                    Seen::White => drop(white.fetch_add(1, Relaxed)),
                    Seen::Well => {}
                }
            }
        });
        self.black += black.into_inner();
        self.white += white.into_inner();
        if let Some((_, mask)) = &mut self.mask {
            mask.extend((0..width * block.rows).map(|i| {
                let (x, y) = place(row, i);
                if merge.lens.gain(x, y).is_some() { MASK_LEVELS[merge.seen(x, y) as usize] } else { MASK_LEVELS[0] }
            }));
        }
        self.row += block.rows;
        Ok(true)
    }
}
