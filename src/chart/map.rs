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

    /// A pixel of a contour line, by how far the nearest crossings of a level lie across and up or down: a line through both
    /// passes at a b / hypot(a, b).
    fn line(&self, x: usize, y: usize, place: f32, ground: Option<Colour>) -> Colour {
        let under = ground.unwrap_or(BLACK);
        let nearest = |a: Crossing, b: Crossing| if a.0 <= b.0 { a } else { b };
        let across = nearest(self.crossing(x, y, place, -1, 0), self.crossing(x, y, place, 1, 0));
        let along = nearest(self.crossing(x, y, place, 0, -1), self.crossing(x, y, place, 0, 1));
        let (far, level) = match (across.0.is_finite(), along.0.is_finite()) {
            (false, false) => return under,
            (true, true) if across.0 + along.0 > 0.0 => {
                (across.0 * along.0 / across.0.hypot(along.0), nearest(across, along).1)
            }
            _ => nearest(across, along),
        };
        let share = |half: f32| (half + 0.5 - far).clamp(0.0, 1.0);
        let colour = on_black(self.palette.colour(f64::from(level) / self.divisions));
        // A dark rim keeps it apart from a picture.
        let rim = if ground.is_some() { 0.7 * share(self.line / 2.0 + 1.0) } else { 0.0 };
        mix(mix(under, BLACK, rim), colour, share(self.line / 2.0))
    }

    /// The first level crossed on the way from a pixel in one direction.
    fn crossing(&self, x: usize, y: usize, place: f32, dx: isize, dy: isize) -> Crossing {
        let reach = (self.line / 2.0 + 1.5) as usize + 1;
        let (mut x, mut y, mut here) = (x, y, place);
        for step in 0..reach {
            let (Some(next_x), Some(next_y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { break };
            if next_x >= self.width || next_y >= self.height {
                break;
            }
            (x, y) = (next_x, next_y);
            let there = self.places[y * self.width + x];
            if there.is_nan() {
                break;
            }
            if there.floor() != here.floor() {
                let level = if there > here { here.floor() + 1.0 } else { here.floor() };
                return (step as f32 + (level - here) / (there - here), level);
            }
            here = there;
        }
        (f32::INFINITY, 0.0)
    }
}

/// Distance in pixels, and the level.
type Crossing = (f32, f32);
