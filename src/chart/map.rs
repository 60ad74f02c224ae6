//! Values as colours, bands or contour lines.

use crate::chart::palette::on_black;
use crate::chart::{BLACK, Colour, NO_VALUE, Palette, Scale, mix};

/// How values are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A colour for each value.
    Fill,
    /// One colour a division.
    Bands,
    /// Lines at the ends of divisions.
    Contours,
    /// The same as bands that are wide where values change little: a quarter of each division.
    ContourBands,
}

impl Style {
    /// Leaves ground between lines.
    pub fn has_lines(self) -> bool {
        matches!(self, Style::Contours | Style::ContourBands)
    }
}

/// A field of values, ready to be shown.
pub struct Map {
    width: usize,
    height: usize,
    /// Divisions above the scale's lower end; NaN for what has no place.
    places: Vec<f32>,
    divisions: f64,
    palette: Palette,
    style: Style,
    /// Width of a contour line, pixels.
    line: f32,
}

/// Part of a division on each side of its end that a contour band takes.
const BAND: f32 = 0.125;

impl Map {
    /// From values, `width` a row. Values that are not finite have no place, nor have negative ones on a scale that begins
    /// at 0 or above.
    pub fn new(width: usize, mut values: Vec<f32>, scale: &Scale, palette: Palette, style: Style, line: f32) -> Map {
        let n = scale.divisions as f64;
        for value in &mut values {
            let has = value.is_finite() && (*value >= 0.0 || scale.min < 0.0);
            *value = if has { (scale.share(f64::from(*value)) * n) as f32 } else { f32::NAN };
        }
        Map { width, height: values.len() / width, places: values, divisions: n, palette, style, line }
    }

    /// The colour of a pixel on its ground, if there is one.
    pub fn colour(&self, x: usize, y: usize, ground: Option<Colour>) -> Colour {
        let place = self.places[y * self.width + x];
        if place.is_nan() {
            return NO_VALUE;
        }
        let shown = |divisions: f64| self.palette.colour(divisions / self.divisions);
        match self.style {
            Style::Fill => shown(f64::from(place)),
            Style::Bands => shown(f64::from(place).floor().min(self.divisions - 1.0) + 0.5),
            Style::Contours => self.line(x, y, place, ground),
            Style::ContourBands => {
                let level = place.round();
                let inside = level > 0.0 && (place - level).abs() < BAND;
                if inside { on_black(shown(f64::from(level))) } else { ground.unwrap_or(BLACK) }
            }
        }
    }

    /// A pixel of a contour line: how far the level lies is what is missing to it over the slope.
    fn line(&self, x: usize, y: usize, place: f32, ground: Option<Colour>) -> Colour {
        let under = ground.unwrap_or(BLACK);
        let at = |x: usize, y: usize| {
            let p = self.places[y.min(self.height - 1) * self.width + x.min(self.width - 1)];
            if p.is_nan() { place } else { p }
        };
        let reach = (self.line / 2.0 + 1.0) as usize;
        let (mut low, mut high) = (place, place);
        for row in y.saturating_sub(reach)..=y + reach {
            for column in x.saturating_sub(reach)..=x + reach {
                let p = at(column, row);
                (low, high) = (low.min(p), high.max(p));
            }
        }
        // Levels crossed nearby; of several the one nearest to this pixel.
        let (first, last) = (low.floor() + 1.0, high.floor());
        if first > last {
            return under;
        }
        let level = place.round().clamp(first, last);
        let dx = at(x + 1, y) - at(x.saturating_sub(1), y);
        let dy = at(x, y + 1) - at(x, y.saturating_sub(1));
        let slope = 0.5 * dx.hypot(dy);
        let far = if slope > 0.0 { (place - level).abs() / slope } else { f32::INFINITY };
        let share = |half: f32| (half + 0.5 - far).clamp(0.0, 1.0);
        let colour = self.palette.colour(f64::from(level) / self.divisions);
        match ground {
            None => mix(under, on_black(colour), share(self.line / 2.0)),
            // A dark rim keeps it apart from the picture.
            Some(_) => {
                mix(mix(under, BLACK, 0.7 * share(self.line / 2.0 + 1.0)), on_black(colour), share(self.line / 2.0))
            }
        }
    }
}
