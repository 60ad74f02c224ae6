//! Eq. (1) of the paper by path tracing [Kajiya 1986].
//!
//! A path leaves a [`Trail`]: which surfaces tinted it and where light joined it. Followed back to the eye in K wavelengths at
//! once, it says what arrived of each light, and a [`Film`] knows what that light's spectrum makes of it: bands of radiance, or
//! XYZ by one 3 x K matrix a light. Only that way back knows how many wavelengths there are.
//! Another method shares the scene, the sampler, the trail, the lanes and the film, and offers an [`estimate::Estimate`].

pub mod checkpoint;
pub mod estimate;
pub mod film;
pub mod inks;
pub mod lanes;
pub mod path;
pub mod picture;
pub mod rays;
pub mod report;
pub mod sampler;
pub mod trail;

pub use film::Film;
pub use lanes::Lanes;
pub use trail::Trail;
