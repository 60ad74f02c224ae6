//! Eq. (1) of the paper by path tracing [Kajiya 1986].
//!
//! A path carries a [`Throughput`]: the linear map from light at its far end to light at the eye. Where it meets light, the
//! connection goes to a [`Film`], which knows what each light's spectrum makes of that map: bands of radiance, or XYZ by
//! one 3 x K matrix a light. Throughput and film are type parameters, so that a scene pays for nothing it does not have.
//! Another method shares the scene, the sampler, the lanes and the film, and offers an [`estimate::Estimate`].

pub mod checkpoint;
pub mod estimate;
pub mod film;
pub mod lanes;
pub mod path;
pub mod picture;
pub mod rays;
pub mod report;
pub mod sampler;

pub use film::Film;
pub use lanes::{Diagonal, Lanes, Throughput};
