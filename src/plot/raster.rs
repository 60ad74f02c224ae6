//! A sheet as PNG, edges smoothed.

use std::io::Write;

use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};
use ttf_parser::OutlineBuilder;

use crate::plot::font::Font;
use crate::plot::sheet::{Anchor, Colour, Point, Shape, Sheet};
use crate::{Error, Result};

impl Sheet {
    /// Writes the sheet as a PNG file of 8 bits a component.
    pub fn png(&self, out: &mut impl Write) -> Result<()> {
        let pixels = self.pixels()?;
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let failed = |e: png::EncodingError| match e {
            png::EncodingError::IoError(e) => Error::io("", e),
            other => Error::Invalid(other.to_string()),
        };
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&pixels).map_err(failed)?;
        writer.finish().map_err(failed)
    }

    /// R, G, B of each pixel, rows top down.
    fn pixels(&self) -> Result<Vec<u8>> {
        let too_large = || Error::Invalid("the chart is too large".into());
        let mut map = Pixmap::new(self.width, self.height).ok_or_else(too_large)?;
        map.fill(tiny_skia::Color::WHITE);
        let font = Font::new();
        for (_, shape) in &self.shapes {
            draw(&mut map, &font, shape);
        }
        // White below everything: nothing is left clear.
        Ok(map.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect())
    }
}

fn paint(colour: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    let [r, g, b] = colour;
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

fn path(points: &[Point], close: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (i, (x, y)) in points.iter().enumerate() {
        if i == 0 { builder.move_to(*x as f32, *y as f32) } else { builder.line_to(*x as f32, *y as f32) }
    }
    if close {
        builder.close();
    }
    builder.finish()
}

/// Draws one shape; one without extent leaves no trace.
fn draw(map: &mut Pixmap, font: &Font, shape: &Shape) {
    let identity = Transform::identity();
    match shape {
        Shape::Line { points, colour, width, dash } => {
            let dash = StrokeDash::new(dash.iter().map(|d| *d as f32).collect(), 0.0);
            let (line_cap, line_join) = (LineCap::Butt, LineJoin::Round);
            let stroke = Stroke { width: *width as f32, line_cap, line_join, dash, ..Stroke::default() };
            if let Some(path) = path(points, false) {
                map.stroke_path(&path, &paint(*colour), &stroke, identity, None);
            }
        }
        Shape::Area { points, colour } => {
            if let Some(path) = path(points, true) {
                map.fill_path(&path, &paint(*colour), FillRule::Winding, identity, None);
            }
        }
        Shape::Disc { at, radius, colour } => {
            if let Some(path) = PathBuilder::from_circle(at.0 as f32, at.1 as f32, *radius as f32) {
                map.fill_path(&path, &paint(*colour), FillRule::Winding, identity, None);
            }
        }
        Shape::Text { at, anchor, size, upward, colour, text } => {
            let width = font.width(text, *size);
            let back = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * width,
                Anchor::End => width,
            };
            let place = Transform::from_translate(at.0 as f32, at.1 as f32);
            let place = if *upward { place.pre_rotate(-90.0) } else { place };
            let place = place.pre_translate(-back as f32, 0.0);
            let mut pen = Pen { builder: PathBuilder::new(), x: 0.0, unit: 0.0 };
            font.outline(text, *size, &mut pen);
            if let Some(path) = pen.builder.finish() {
                map.fill_path(&path, &paint(*colour), FillRule::Winding, place, None);
            }
        }
    }
}

/// Draws characters one behind the other, upright.
pub struct Pen {
    builder: PathBuilder,
    /// Where the character begins, pixels.
    x: f32,
    /// Pixels of a unit of the font.
    unit: f32,
}

impl Pen {
    /// Where the next character begins, and pixels of a unit of the font.
    pub fn move_on(&mut self, x: f64, unit: f64) {
        (self.x, self.unit) = (x as f32, unit as f32);
    }

    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.unit, -y * self.unit)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
