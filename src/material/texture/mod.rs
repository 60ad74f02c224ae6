//! Textures: reflectance as a function of where a surface is hit. What comes out is linear sRGB, 0..1; turning it into
//! spectra is the material's business.
//!
//! | `type` | keys |
//! |---|---|
//! | `checker` | `values` (two, each a number or linear sRGB), `size` of a square, `space` = `uv` (default) or `place` |
//! | `picture` | `file`, `wrap` = `repeat` (default), `clamp` or `mirror` |
//!
//! Texture coordinates begin at a picture's bottom left, u to the right, v upward.

pub mod checker;
pub mod picture;

use std::path::Path;

use glam::DVec3;

use crate::Result;
use crate::error::printable;
use crate::keys::Keys;

pub use checker::Checker;
pub use picture::{Picture, Wrap};

/// A function of texture coordinates or of the place.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// Squares or cubes of two values in turn.
    Checker(Checker),
    /// A picture.
    Picture(Picture),
}

impl Texture {
    /// Linear sRGB, 0..1, at texture coordinates and a place in metres, of which it takes the one it is a function of.
    pub fn at(&self, uv: [f64; 2], place: DVec3) -> [f32; 3] {
        match self {
            Texture::Checker(checker) => checker.at(uv, place),
            Texture::Picture(picture) => picture.at(uv),
        }
    }

    /// True where it needs texture coordinates, which not every shape has.
    pub fn needs_uv(&self) -> bool {
        !matches!(self, Texture::Checker(Checker { space: checker::Space::Place, .. }))
    }

    /// Reads a texture's table to its end; its file lies in `folder`, and a unit of length has `metres`.
    pub fn read(mut k: Keys, folder: &Path, metres: f64) -> Result<Texture> {
        let Some((kind, span)) = k.get_spanned::<String>("type")? else {
            return Err(k.wrong("key 'type' is missing; there are checker, picture"));
        };
        let texture = match kind.as_str() {
            "checker" => Texture::Checker(Checker::read(&mut k, metres)?),
            "picture" => Texture::Picture(Picture::read(&mut k, folder)?),
            other => {
                let other = printable(other.as_bytes());
                return Err(k.wrong_key("type", span, &format!("no texture '{other}'; there are checker, picture")));
            }
        };
        k.finish().map(|()| texture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys;

    #[test]
    fn tables_are_read_to_their_end() {
        let read = |text: &str| Texture::read(keys::parse(text).unwrap(), Path::new("/nowhere"), 0.01);
        let texture =
            read("type = \"checker\"\nvalues = [0.1, [0.2, 0.3, 0.4]]\nsize = 50\nspace = \"place\"").unwrap();
        assert!(!texture.needs_uv());
        // Squares of 50 cm.
        assert_eq!(texture.at([0.0; 2], DVec3::new(0.25, 0.25, 0.25)), [0.1; 3]);
        assert_eq!(texture.at([0.0; 2], DVec3::new(0.75, 0.25, 0.25)), [0.2, 0.3, 0.4]);
        assert!(read("type = \"checker\"\nvalues = [0, 1]\nsize = 0.5").unwrap().needs_uv());
        for (bad, word) in [
            ("", "'type' is missing"),
            ("type = \"marble\"", "no texture 'marble'"),
            ("type = \"checker\"\nsize = 1", "'values' is missing"),
            ("type = \"checker\"\nvalues = [0, 1]", "'size' is missing"),
            ("type = \"checker\"\nvalues = [0, 1.5]\nsize = 1", "line 2, column 10: values: 1.5 must lie in 0 to 1"),
            ("type = \"checker\"\nvalues = [0, 1]\nsize = 0", "size: 0 must be above 0"),
            ("type = \"checker\"\nvalues = [0, 1]\nsize = 1\nwrap = \"clamp\"", "unknown key"),
            ("type = \"checker\"\nvalues = [0, 1]\nsize = 1\nspace = \"xyz\"", "space"),
            ("type = \"picture\"", "'file' is missing"),
            ("type = \"picture\"\nfile = \"none.png\"", "line 2, column 8: file: /nowhere/none.png"),
        ] {
            let message = read(bad).unwrap_err().to_string();
            assert!(message.contains(word), "{bad}: {message}");
        }
    }
}
