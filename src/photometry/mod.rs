//! Quantities and files of lighting practice.
//!
//! | module | holds |
//! |---|---|
//! | [`alphaopic`] | what light does to the eye's five receptors, CIE S 026 |
//! | [`cct`] | correlated colour temperature and Duv |
//! | [`environment`] | drawing directions by how bright they are |
//! | [`ies`] | luminaires' intensities from LM-63 files |

pub mod alphaopic;
pub mod cct;
pub mod environment;
pub mod ies;

pub use alphaopic::AlphaOpic;
pub use environment::Environment;
