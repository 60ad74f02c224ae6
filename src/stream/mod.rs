//! What flows between filters: a Radiance information header, a resolution line and raw 32-bit floats
//! (docs/stream.md). Everything a filter reads, RGBE, XYZE and hyperspectral included, becomes a [`Picture`] of floats in
//! the units its header states.

pub mod annotation;
pub mod groups;
pub mod header;
pub mod luminance;
pub mod meaning;
pub mod output;
pub mod picture;
pub mod reader;
pub mod resolution;
pub mod rgbe;
pub mod rle;
mod scanlines;
pub mod source;
pub mod spool;
pub mod tristimulus;
pub mod upright;
mod variables;
pub mod writer;

pub use header::{Components, Header, Units};
pub use luminance::luminance;
pub use picture::{Block, Picture};
pub use resolution::Resolution;
pub use tristimulus::tristimulus;
