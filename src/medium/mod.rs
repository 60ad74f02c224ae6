//! Participating media, Eq. (2): what fills the space between surfaces and takes light away, scatters it, and gives some off.
//!
//! A medium has coefficients by wavelength in 1/m (absorption sigma_a, scattering sigma_s; extinction sigma_t is their sum), times a
//! [`density::Density`] from place to place, and a [`phase::Phase`] that all wavelengths share. What a body absorbs is a medium too.
//! It fills the inside of bodies whose material names it as `interior`, or all space that no body's fills.
//!
//! Where bodies overlap the medium of the highest priority counts; of equal ones that of the body entered last ([`Inside`]).

pub mod density;
pub mod inside;
pub mod phase;
pub mod read;

use std::sync::Arc;

use density::Density;
use phase::Phase;

use crate::material::{Ink, Tint, tint};
use crate::simd;
use crate::spectral::Spectrum;

pub use inside::Inside;

/// What fills a body, or all space.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Its place among the scene's media.
    pub number: u32,
    /// Name in the scene file.
    pub name: String,
    /// Of overlapping media the one of the highest priority counts.
    pub priority: i32,
    /// Number of the extinction coefficient (an [`crate::material::Ink::Depth`]), 1/m.
    pub extinction: u32,
    /// Smallest and largest extinction coefficient of all wavelengths, 1/m.
    pub extremes: [f32; 2],
    /// Number of the absorption coefficient.
    pub absorption: u32,
    /// Number of the scattering coefficient, where it scatters.
    pub scattering: Option<u32>,
    /// Number of the light whose radiance is its source function, where it gives off light: a body thick enough shines so.
    pub glow: Option<u32>,
    /// The coefficients where they are the same at every wavelength.
    pub grey: Option<Grey>,
    /// How scattered light is spread.
    pub phase: Arc<dyn Phase>,
    /// From place to place.
    pub density: Arc<dyn Density>,
}

/// Coefficients of a grey medium, 1/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grey {
    /// Absorption.
    pub absorption: f32,
    /// Scattering.
    pub scattering: f32,
}

impl Medium {
    /// What it leaves of light after so many metres of it.
    pub fn inside(&self, metres: f32) -> Tint {
        Tint::Inside { depth: self.extinction, metres, over: 1.0 }
    }

    /// Reduced scattering coefficient sigma_s (1 - g), and the absorption coefficient, 1/m.
    pub fn reduced(&self, inks: &[Ink]) -> [Spectrum; 2] {
        let [absorption, scattering] = self.coefficients(inks);
        [scattering.scaled(1.0 - self.phase.mean_cosine()), absorption]
    }

    /// Absorption and scattering coefficients where the density is 1, 1/m.
    pub fn coefficients(&self, inks: &[Ink]) -> [Spectrum; 2] {
        [Some(self.absorption), self.scattering].map(|i| match i.map(|i| &inks[i as usize]) {
            Some(Ink::Depth(s)) => s.clone(),
            _ => Spectrum::Constant(0.0),
        })
    }

    /// A tint of it as a number, where that is all it is.
    #[inline]
    pub fn grey_share(&self, tint: &Tint) -> Option<f32> {
        let Grey { absorption, scattering } = self.grey?;
        let extinction = absorption + scattering;
        match *tint {
            Tint::Inside { metres, over, .. } => Some(over * simd::exp(-extinction * metres)),
            Tint::Collision { metres, over, .. } => Some(over * scattering * simd::exp(-extinction * metres)),
            Tint::Glow { part, metres, .. } => {
                let part = if Some(part) == self.scattering { scattering } else { absorption };
                Some(tint::glow(extinction, part, metres))
            }
            Tint::Null { share, .. } => Some(1.0 - extinction * share),
            _ => None,
        }
    }
}

/// The media of a scene.
#[derive(Clone, Debug, Default)]
pub struct Media {
    /// By number; those that scene files name first, in the order of their names.
    pub list: Vec<Medium>,
    /// What fills all space that no body's fills.
    pub everywhere: Option<u32>,
    /// Ways through any of them are followed by null collisions.
    pub by_null_collisions: bool,
}

impl Media {
    /// Any scatters light.
    pub fn scatter(&self) -> bool {
        self.list.iter().any(|m| m.scattering.is_some())
    }

    /// Any gives off light.
    pub fn glow(&self) -> bool {
        self.list.iter().any(|m| m.glow.is_some())
    }

    /// The one that counts inside bodies.
    #[inline]
    pub fn current(&self, inside: Inside) -> Option<&Medium> {
        if inside.is_empty() {
            return self.everywhere.map(|i| &self.list[i as usize]);
        }
        let mut best: Option<&Medium> = None;
        for i in inside.latest_first() {
            let medium = self.list.get(i as usize)?;
            if best.is_none_or(|b| medium.priority > b.priority) {
                best = Some(medium);
            }
        }
        best
    }
}
