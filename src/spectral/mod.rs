//! Spectra: tables, observers, light sources and the sampling that carries them through a pipe.

pub mod builtin;
pub mod glass;
pub mod key;
pub mod observer;
pub mod planck;
pub mod rule;
pub mod sampling;
pub mod spectrum;
pub mod text;

pub use observer::Observer;
pub use rule::Rule;
pub use sampling::Sampling;
pub use spectrum::Spectrum;
