//! Tone mapping: from the luminances of a world to those of a display. Knows nothing of rays or files.

pub mod curve;
pub mod fovea;
pub mod histogram;
pub mod local;

pub use curve::Curve;
pub use histogram::Histogram;
