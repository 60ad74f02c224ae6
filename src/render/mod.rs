//! Solutions of Eq. (1) of the paper.
//!
//! A [`method::Method`] follows light from where it is asked for and leaves a [`Trail`]: which surfaces tinted it and where light
//! joined it. Followed back to the eye in K wavelengths at once, it says what arrived of each light, and a [`Film`] knows what
//! that light's spectrum makes of it: bands of radiance, or XYZ by one 3 x K matrix a light. Only that way back knows how many
//! wavelengths there are. All methods share the scene, the sampler, the trail, the lanes, the film and the
//! [`estimate::Estimate`] that a pixel or a ray is.

pub mod balance;
pub mod beam;
pub mod checkpoint;
pub mod comb;
pub mod direct;
pub mod estimate;
pub mod few;
pub mod film;
pub mod films;
pub mod flight;
pub mod inks;
pub mod lanes;
pub mod layers;
pub mod local;
pub mod march;
pub mod media;
pub mod meeting;
pub mod method;
pub mod path;
pub mod photon;
pub mod picture;
pub mod plane;
pub mod pool;
pub mod radiosity;
pub mod rays;
pub mod report;
pub mod reradiate;
pub mod sampler;
pub mod shade;
pub mod solution;
pub mod stored;
pub mod tile;
pub mod trail;
pub mod view;
pub mod wavelengths;

pub use film::Film;
pub use lanes::Lanes;
pub use trail::Trail;
