//! The legend: in a place of the chart where nothing else is, or in rows above it.

use crate::plot::font::Font;
use crate::plot::layout::{BARS, EDGE, INK, Pens};
use crate::plot::sheet::{Anchor, Frame, Point, Shape, Sheet};

/// What a name stands for.
pub enum Sign {
    /// A curve of that place in the list; with marks or without.
    Curve(usize, bool),
    /// Bars.
    Bars,
}

/// The names, set out.
pub struct Legend {
    entries: Vec<(String, Sign)>,
    /// Each name's width, pixels.
    widths: Vec<f64>,
    size: f64,
}

/// Parts of the font's height: a row, a sign, and what is between a sign and its name, between entries, around all.
const ROW: f64 = 1.5;
const SIGN: f64 = 2.9;
const GAP: f64 = 0.6;
const APART: f64 = 1.6;
const AROUND: f64 = 0.6;

impl Legend {
    /// A legend whose names are `size` pixels high and none longer than `longest` pixels.
    pub fn new(entries: Vec<(String, Sign)>, font: &Font, size: f64, longest: f64) -> Legend {
        let longest = (longest - (SIGN + GAP + 2.0 * AROUND) * size).max(size);
        let fit = |(name, sign): (String, Sign)| (font.shortened(&name, size, longest), sign);
        let entries: Vec<(String, Sign)> = entries.into_iter().filter(|e| !e.0.is_empty()).map(fit).collect();
        let widths = entries.iter().map(|e| font.width(&e.0, size)).collect();
        Legend { entries, widths, size }
    }

    fn entry_width(&self, i: usize) -> f64 {
        (SIGN + GAP) * self.size + self.widths[i]
    }

    /// A frame within `chart` that no line of `obstacles` crosses.
    pub fn place(&self, chart: &Frame, obstacles: &[Vec<Point>]) -> Option<Frame> {
        let widest = (0..self.entries.len()).map(|i| self.entry_width(i)).fold(0.0, f64::max);
        let (w, h) = (widest + 2.0 * AROUND * self.size, (self.entries.len() as f64 * ROW + AROUND) * self.size);
        let off = self.size * 0.8;
        let (free_x, free_y) = (chart.width() - w - 2.0 * off, chart.height() - h - 2.0 * off);
        if free_x < 0.0 || free_y < 0.0 {
            return None;
        }
        let places = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 1.0), (0.0, 0.5), (1.0, 0.5)];
        let frames = places.map(|(x, y)| {
            let (left, top) = (chart.left + off + x * free_x, chart.top + off + y * free_y);
            Frame { left, top, right: left + w, bottom: top + h }
        });
        let free = |f: &Frame| {
            let m = self.size * 0.5;
            let wide = Frame { left: f.left - m, top: f.top - m, right: f.right + m, bottom: f.bottom + m };
            obstacles.iter().all(|o| !o.iter().any(|p| wide.holds(*p)) && wide.parts(o).is_empty())
        };
        frames.into_iter().find(free)
    }

    /// Draws one name below the other in a frame from [`Legend::place`].
    pub fn stack(&self, sheet: &mut Sheet, frame: &Frame, pens: &Pens) {
        let corners = [(frame.left, frame.top), (frame.right, frame.top), (frame.right, frame.bottom)];
        let points = [&corners[..], &[(frame.left, frame.bottom)]].concat();
        let round = [&points[..], &points[..1]].concat();
        sheet.add("legend", Shape::Area { points, colour: [255; 3] });
        let width = (self.size / 18.0).max(0.5);
        sheet.add("legend", Shape::Line { points: round, colour: EDGE, width, dash: Vec::new() });
        for i in 0..self.entries.len() {
            let middle = frame.top + (AROUND * 0.5 + (i as f64 + 0.5) * ROW) * self.size;
            self.entry(sheet, i, (frame.left + AROUND * self.size, middle), pens);
        }
    }

    /// The names as rows that are no wider than `width` pixels: places of the first and one past the last.
    fn rows(&self, width: f64) -> Vec<(usize, usize)> {
        let mut rows: Vec<(usize, usize)> = Vec::new();
        let mut used = f64::INFINITY;
        for i in 0..self.entries.len() {
            let more = self.entry_width(i) + APART * self.size;
            if used + more > width + APART * self.size {
                rows.push((i, i));
                used = 0.0;
            }
            used += more;
            if let Some(row) = rows.last_mut() {
                row.1 = i + 1;
            }
        }
        rows
    }

    /// Height of the names in rows, pixels.
    pub fn strip_height(&self, width: f64) -> f64 {
        (self.rows(width).len() as f64 * ROW + 0.4) * self.size
    }

    /// Draws the names in rows above a chart.
    pub fn strip(&self, sheet: &mut Sheet, chart: &Frame, pens: &Pens) {
        let rows = self.rows(chart.width());
        for (row, (first, last)) in rows.iter().enumerate() {
            let mut x = chart.left;
            let middle = chart.top - ((rows.len() - row) as f64 - 0.5) * ROW * self.size - 0.4 * self.size;
            for i in *first..*last {
                self.entry(sheet, i, (x, middle), pens);
                x += self.entry_width(i) + APART * self.size;
            }
        }
    }

    fn entry(&self, sheet: &mut Sheet, i: usize, at: Point, pens: &Pens) {
        let (x, y) = at;
        let end = x + SIGN * self.size;
        match self.entries[i].1 {
            Sign::Curve(place, marks) => {
                sheet.add("legend", pens.line(place, vec![(x, y), (end, y)]));
                if marks {
                    sheet.add("legend", pens.mark(place, ((x + end) / 2.0, y)));
                }
            }
            Sign::Bars => {
                let (top, bottom) = (y - 0.4 * self.size, y + 0.4 * self.size);
                let points = vec![(x, top), (end, top), (end, bottom), (x, bottom)];
                sheet.add("legend", Shape::Area { points, colour: BARS });
            }
        }
        let at = (end + GAP * self.size, y + 0.36 * self.size);
        let text = self.entries[i].0.clone();
        let word = Shape::Text { at, anchor: Anchor::Start, size: self.size, upward: false, colour: INK, text };
        sheet.add("legend", word);
    }
}
