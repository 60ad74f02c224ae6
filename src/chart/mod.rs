//! Numbers as pictures: colours for values, contour lines, a legend that says which is which.

pub mod canvas;
pub mod font;
pub mod legend;
pub mod map;
pub mod palette;
pub mod scale;
pub mod sheet;
pub mod values;

pub use canvas::Canvas;
pub use map::{Map, Style};
pub use palette::Palette;
pub use scale::Scale;

/// A colour in linear light, BT.709, 0 to 1.
pub type Colour = [f32; 3];

/// No light.
pub const BLACK: Colour = [0.0; 3];
/// All of it.
pub const WHITE: Colour = [1.0; 3];
/// What is no number, or is negative where nothing can be: in no palette.
pub const NO_VALUE: Colour = [1.0, 0.0, 1.0];

/// A mixture: `share` of `over`, the rest of `under`.
pub fn mix(under: Colour, over: Colour, share: f32) -> Colour {
    [0, 1, 2].map(|c| under[c] + share * (over[c] - under[c]))
}
