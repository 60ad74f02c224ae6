//! A sheet of lines, areas and words, in pixels from the upper left corner.

/// A point, pixels.
pub type Point = (f64, f64);

/// A colour of the screen, sRGB codes.
pub type Colour = [u8; 3];

/// Where a word stands beside its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Begins there.
    Start,
    /// Is centred on it.
    Middle,
    /// Ends there.
    End,
}

/// What is drawn.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Joined points.
    Line {
        /// At least two.
        points: Vec<Point>,
        /// Its colour.
        colour: Colour,
        /// Pixels.
        width: f64,
        /// Pixels drawn and left out in turn; an even number of them, none for a whole line.
        dash: Vec<f64>,
    },
    /// A filled polygon.
    Area {
        /// Its corners.
        points: Vec<Point>,
        /// Its colour.
        colour: Colour,
    },
    /// A disc.
    Disc {
        /// Its middle.
        at: Point,
        /// Pixels.
        radius: f64,
        /// Its colour.
        colour: Colour,
    },
    /// A line of text.
    Text {
        /// On its base line.
        at: Point,
        /// Which end of it.
        anchor: Anchor,
        /// Height of the font, pixels.
        size: f64,
        /// Written from below upward.
        upward: bool,
        /// Its colour.
        colour: Colour,
        /// The words.
        text: String,
    },
}

/// What was laid out.
#[derive(Clone, Debug)]
pub struct Sheet {
    pub(super) width: u32,
    pub(super) height: u32,
    /// For readers of the SVG that do not see.
    pub(super) title: String,
    /// In the order of drawing, each with what it belongs to.
    pub(super) shapes: Vec<(&'static str, Shape)>,
}

impl Sheet {
    /// An empty sheet.
    pub fn new(width: u32, height: u32, title: &str) -> Sheet {
        Sheet { width, height, title: title.to_string(), shapes: Vec::new() }
    }

    /// Draws on top of what is there. `class` says what the shape belongs to.
    pub fn add(&mut self, class: &'static str, shape: Shape) {
        self.shapes.push((class, shape));
    }

    /// Draws a line without dashes.
    pub fn line(&mut self, class: &'static str, from: Point, to: Point, colour: Colour, width: f64) {
        self.add(class, Shape::Line { points: vec![from, to], colour, width, dash: Vec::new() });
    }
}

/// A rectangle, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First column.
    pub left: f64,
    /// First row.
    pub top: f64,
    /// Behind the last column.
    pub right: f64,
    /// Below the last row.
    pub bottom: f64,
}

impl Frame {
    /// Width in pixels.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Height in pixels.
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// The point is within or on the edge.
    pub fn holds(&self, p: Point) -> bool {
        p.0 >= self.left && p.0 <= self.right && p.1 >= self.top && p.1 <= self.bottom
    }

    /// Some of a segment is within [Liang 1984]: the part that is.
    pub fn part(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut from, mut to) = (0.0f64, 1.0f64);
        let sides = [(-dx, a.0 - self.left), (dx, self.right - a.0), (-dy, a.1 - self.top), (dy, self.bottom - a.1)];
        for (toward, room) in sides {
            if toward == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if toward < 0.0 {
                from = from.max(room / toward);
            } else {
                to = to.min(room / toward);
            }
        }
        let at = |t: f64| {
            if t <= 0.0 {
                a
            } else if t >= 1.0 {
                b
            } else {
                (a.0 + t * dx, a.1 + t * dy)
            }
        };
        (from <= to).then(|| (at(from), at(to)))
    }

    /// The parts of a line that are within.
    pub fn parts(&self, line: &[Point]) -> Vec<Vec<Point>> {
        let mut parts: Vec<Vec<Point>> = Vec::new();
        for (a, b) in line.iter().zip(line.iter().skip(1)) {
            let Some((from, to)) = self.part(*a, *b) else { continue };
            match parts.last_mut() {
                Some(last) if last.last() == Some(&from) => last.push(to),
                _ => parts.push(vec![from, to]),
            }
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let frame = Frame { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };
        assert_eq!(
            frame.parts(&[(-5.0, 5.0), (5.0, 5.0), (5.0, 20.0), (8.0, 20.0), (8.0, 9.0)]),
            [vec![(0.0, 5.0), (5.0, 5.0), (5.0, 10.0)], vec![(8.0, 10.0), (8.0, 9.0)]]
        );
        assert!(frame.parts(&[(-5.0, 8.0), (3.0, 16.0)]).is_empty());
        assert!(frame.parts(&[(1.0, 1.0)]).is_empty());
    }
}
