//! The legend: a bar of the palette, its values beside it, their unit above.

use crate::chart::canvas::{Canvas, text_width};
use crate::chart::palette::on_black;
use crate::chart::scale::label;
use crate::chart::{BLACK, Palette, Scale, Style, WHITE, font};
use crate::{Result, usage};

/// Points, each `size` pixels: margin, width of the bar, gap between bar and value, length of a tick.
const MARGIN: usize = 4;
const BAR: usize = 14;
const GAP: usize = 4;
const TICK: usize = 3;

/// What a legend says.
pub struct Legend<'a> {
    /// The values.
    pub scale: &'a Scale,
    /// Their colours.
    pub palette: &'a Palette,
    /// How they are shown.
    pub style: Style,
    /// Their unit.
    pub unit: &'a str,
}

impl Legend<'_> {
    /// Pixels across that it needs with points of this size.
    fn width(&self, size: usize) -> usize {
        let values = self.scale.ticks().map(|(_, value)| text_width(&label(value), size)).max().unwrap_or(0);
        let beside = (MARGIN + BAR + GAP + MARGIN) * size + values;
        beside.max(2 * MARGIN * size + text_width(self.unit, size))
    }

    /// Pixels down that it needs at least: the unit and two values.
    fn least_height(&self, size: usize) -> usize {
        (2 * MARGIN + 5 * font::HEIGHT) * size
    }

    /// The legend beside a picture `rows` high: of the size that is asked for, none if that is 0, or as large as it needs with
    /// points of `size`. Letters are made smaller to fit. More than `memory` bytes are an error.
    pub fn sized(
        &self,
        asked: Option<(usize, usize)>,
        rows: usize,
        size: usize,
        memory: u64,
    ) -> Result<Option<Canvas>> {
        let (width, height) = asked.unwrap_or_else(|| (self.width(size), rows.max(self.least_height(size))));
        if width == 0 || height == 0 {
            return Ok(None);
        }
        let bytes = Canvas::PIXEL_BYTES * width as u64 * height as u64;
        if bytes > memory {
            return usage!("a legend of {width}x{height} takes {} MB; allow it with --memory", bytes >> 20);
        }
        let fits = |s: &usize| self.width(*s) <= width && self.least_height(*s) <= height;
        let size = (1..=size).rev().find(fits).unwrap_or(1);
        Ok(Some(self.draw(width, height, size)))
    }

    /// Drawn on black. Where values would lie upon each other some are left out.
    fn draw(&self, width: usize, height: usize, size: usize) -> Canvas {
        let mut canvas = Canvas::new(width, height);
        canvas.fill(0, 0, width as i64, height as i64, BLACK);
        let px = |points: usize| (points * size) as i64;
        canvas.text(px(MARGIN), px(MARGIN), size, self.unit, WHITE);
        let top = px(MARGIN + font::HEIGHT + font::CAPITAL);
        let bottom = (height as i64 - px(MARGIN + font::CAPITAL / 2)).max(top + 1);
        let long = (bottom - top) as f64;
        for y in top..bottom {
            let share = (bottom as f64 - y as f64 - 0.5) / long;
            if let Some(colour) = self.colour(share) {
                canvas.fill(px(MARGIN), y, px(BAR), 1, colour);
            }
        }
        let n = self.scale.divisions;
        let apart = long / n as f64;
        let every = (px(font::HEIGHT + 2) as f64 / apart).ceil().max(1.0) as usize;
        for (i, (share, value)) in self.scale.ticks().enumerate() {
            let y = bottom - (share * long).round() as i64;
            let thick = (size as i64 + 1) / 2;
            if self.style.has_lines() {
                if i > 0 {
                    let colour = on_black(self.palette.colour(share));
                    canvas.fill(px(MARGIN), y - thick, px(BAR), 2 * thick, colour);
                }
            } else {
                canvas.fill(px(MARGIN + BAR - TICK), y - thick / 2, px(TICK), thick, BLACK);
            }
            // The largest is always there; from it down every so many.
            if (n - i).is_multiple_of(every) {
                let left = px(MARGIN + BAR + GAP);
                canvas.text(left, y - px(font::CAPITAL) / 2, size, &label(value), WHITE);
            }
        }
        canvas
    }

    fn colour(&self, share: f64) -> Option<crate::chart::Colour> {
        let n = self.scale.divisions as f64;
        match self.style {
            Style::Fill => Some(self.palette.colour(share)),
            Style::Bands => Some(self.palette.colour(((share * n).floor() + 0.5) / n)),
            Style::Contours | Style::ContourBands => None,
        }
    }
}
