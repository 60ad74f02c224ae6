//! Optics of waves, one effect a file, each with the formula that it implements and a number that it is held to: light at smooth
//! boundaries ([`fresnel`]), its polarization ([`polarization`]), thin films and stacks ([`film`]), gratings ([`grating`]),
//! openings ([`aperture`]), rough surfaces near the wavelength ([`roughness`]), fluorescence ([`reradiation`]); and of particles in
//! layers ([`slab`]) and below surfaces ([`dipole`]).
//!
//! Conventions: the time factor is exp(-i w t), so an index n + ik with k > 0 absorbs. The s axis is along (direction to where
//! light goes) x (normal), the same before and after; p = k x s, k the direction in which light travels. At normal incidence
//! then r_p = -r_s.

pub mod aperture;
pub mod dipole;
pub mod film;
pub mod fresnel;
pub mod grating;
pub mod polarization;
pub mod reradiation;
pub mod roughness;
pub mod slab;
