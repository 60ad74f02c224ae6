//! Colour: chromaticities, primaries, white-point adaptation, gamut mapping. Imports only [`crate::spectral`].

pub mod adapt;
pub mod compress;
pub mod difference;
pub mod estimate;
pub mod gamut;
pub mod intent;
pub mod matrix;
pub mod pu21;
pub mod relative;
pub mod rgb;
pub mod uplift;
pub mod white;
pub mod xy;

pub use adapt::Cat;
pub use matrix::Mat3;
pub use relative::Relative;
pub use rgb::Primaries;
pub use uplift::Uplift;
pub use white::White;
pub use xy::Xy;
