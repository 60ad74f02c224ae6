//! Quantities and files of lighting practice.
//!
//! | module | holds |
//! |---|---|
//! | [`ies`] | luminaires' intensities from LM-63 files |

pub mod ies;
