//! What a scene needs: the cheapest model whose colours stay within a tolerance.
//!
//! [`survey`] lists the spectra that light of a scene can meet, [`products`] what becomes of light that meets several of them in turn,
//! [`fit`] makes a rule of K wavelengths for those, [`channels`] three channels in place of wavelengths, [`ladder`] has them as rungs with
//! the error of each, and [`pilot`] tries on a few pixels what is left out: effects, deep paths, wavelengths. What fails climbs a rung.

pub mod channels;
pub mod file;
pub mod fit;
pub mod ladder;
pub mod least;
pub mod pilot;
pub mod products;
pub mod survey;
pub mod wish;

pub use ladder::{Ladder, Model, Rung};
pub use pilot::{Flight, Pilot};
pub use wish::{Plan, Wish};
