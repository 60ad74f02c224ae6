//! XYZ from a few numbers a path in place of full bands: wavelengths that were chosen for a scene, or channels.

use std::sync::Arc;

use crate::Result;
use crate::material::Ink;
use crate::render::estimate::{Quantity, What};
use crate::spectral::{Rule, Sampling, Spectrum};

/// Wavelengths that count, nm: what rules are made for.
pub const RANGE_NM: (f64, f64) = (380.0, 780.0);

/// What paths carry, and what becomes of it.
#[derive(Clone, Debug)]
pub struct Few {
    /// The wavelengths, and XYZ by light.
    pub rule: Rule,
    /// A scene's spectra in place of its own, where what is carried is no light of a wavelength.
    pub converted: Option<Converted>,
}

/// A scene's spectra as something else.
#[derive(Clone, Debug)]
pub struct Converted {
    /// Inks in the scene's order.
    pub inks: Vec<Ink>,
    /// Basis of pictures.
    pub srgb: [Spectrum; 3],
}

impl Few {
    /// XYZ by it.
    pub fn quantity(self: Arc<Few>, seed: u32) -> Result<Quantity> {
        let sampling = Sampling::points(self.rule.nodes_nm.clone())?;
        Ok(Quantity { sampling, range_nm: RANGE_NM, what: What::Xyz, seed, few: Some(self) })
    }
}
