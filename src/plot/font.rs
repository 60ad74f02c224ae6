//! The font that charts are measured and drawn with: DejaVu Sans (see font/README.md).

use ttf_parser::Face;

use crate::plot::raster::Pen;

static BYTES: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

/// The one font.
pub struct Font {
    face: Face<'static>,
}

impl Font {
    /// The font that is part of the program.
    pub fn new() -> Font {
        // Cannot fail on any input: there is none. A wrong file in the source fails the first test that runs.
        Font { face: Face::parse(BYTES, 0).expect("the font is whole") }
    }

    /// Pixels of one unit of the font's own at a size in pixels.
    fn unit(&self, size: f64) -> f64 {
        size / f64::from(self.face.units_per_em())
    }

    /// Width of a line of text, pixels.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        text.chars().map(|c| self.advance(c, size)).sum()
    }

    /// Width of one character, pixels; what the font does not have is as wide as its empty box.
    fn advance(&self, c: char, size: f64) -> f64 {
        let glyph = self.face.glyph_index(c).unwrap_or_default();
        f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0)) * self.unit(size)
    }

    /// The text, cut to a width in pixels.
    pub fn shortened(&self, text: &str, size: f64, longest: f64) -> String {
        let mut cut = text.to_string();
        while self.width(&cut, size) > longest && cut.chars().count() > 2 {
            cut.truncate(cut.trim_end_matches('…').len());
            cut.pop();
            cut.push('…');
        }
        cut
    }

    /// Draws every character with `pen`, the text beginning at 0 on the base line.
    pub fn outline(&self, text: &str, size: f64, pen: &mut Pen) {
        let mut x = 0.0;
        for c in text.chars() {
            pen.move_on(x, self.unit(size));
            self.face.outline_glyph(self.face.glyph_index(c).unwrap_or_default(), pen);
            x += self.advance(c, size);
        }
    }
}
