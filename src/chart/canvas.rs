//! A small picture to draw on: points with a colour, or none yet.

use crate::chart::{Colour, font};

/// Rows top down.
#[derive(Clone, Debug)]
pub struct Canvas {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    points: Vec<Option<Colour>>,
}

impl Canvas {
    /// What a pixel takes.
    pub const PIXEL_BYTES: u64 = size_of::<Option<Colour>>() as u64;

    /// Nothing drawn yet.
    pub fn new(width: usize, height: usize) -> Canvas {
        Canvas { width, height, points: vec![None; width * height] }
    }

    /// What is drawn there.
    pub fn at(&self, x: usize, y: usize) -> Option<Colour> {
        if x < self.width && y < self.height { self.points[y * self.width + x] } else { None }
    }

    /// Fills a rectangle, what lies on the canvas of it.
    pub fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Colour) {
        let cut = |from: i64, n: i64, end: usize| {
            from.clamp(0, end as i64) as usize..(from + n).clamp(0, end as i64) as usize
        };
        for row in cut(y, height, self.height) {
            let across = cut(x, width, self.width);
            self.points[row * self.width..][across].fill(Some(colour));
        }
    }

    /// Writes a line of text, its letters' upper left corner at (x, y), each point `size` pixels wide.
    pub fn text(&mut self, x: i64, y: i64, size: usize, text: &str, colour: Colour) {
        let size = size as i64;
        for (i, c) in text.chars().enumerate() {
            let left = x + (i * font::ADVANCE) as i64 * size;
            for (row, bits) in font::glyph(c).into_iter().enumerate() {
                for column in (0..font::WIDTH).filter(|column| bits >> (font::WIDTH - 1 - column) & 1 == 1) {
                    self.fill(left + column as i64 * size, y + row as i64 * size, size, size, colour);
                }
            }
        }
    }

    /// The same with a rim of another colour, so that it reads on any ground.
    pub fn rimmed_text(&mut self, x: i64, y: i64, size: usize, text: &str, colour: Colour, rim: Colour) {
        let step = (size as i64 + 1) / 2;
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            self.text(x + dx * step, y + dy * step, size, text, rim);
        }
        self.text(x, y, size, text, colour);
    }
}

/// Pixels that a line of text takes across.
pub fn text_width(text: &str, size: usize) -> usize {
    (text.chars().count() * font::ADVANCE).saturating_sub(1) * size
}
