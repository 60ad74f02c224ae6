//! `"rayleigh"`: particles much smaller than the wave, such as air: p = 3 / (16 pi) (1 + cos^2). Where polarization counts, what
//! scatters at right angles is polarised altogether.

use std::f32::consts::PI;
use std::sync::Arc;

use crate::Result;
use crate::keys::Keys;
use crate::medium::phase::Phase;

/// A dipole's, in the mean over its orientations.
#[derive(Clone, Copy, Debug)]
pub struct Rayleigh;

impl Phase for Rayleigh {
    fn value(&self, versine: f32) -> f32 {
        let cos = 1.0 - versine;
        3.0 / (16.0 * PI) * (1.0 + cos * cos)
    }

    fn sample(&self, u: f32) -> f32 {
        // cos^3 + 3 cos = 8 u' - 4 by Cardano's formula.
        let half = 2.0 * (1.0 - 2.0 * u);
        let root = (half + (half * half + 1.0).sqrt()).cbrt();
        (1.0 - (root - 1.0 / root)).clamp(0.0, 2.0)
    }

    fn mean_cosine(&self) -> f64 {
        0.0
    }

    fn is_rayleigh(&self) -> bool {
        true
    }
}

/// Reads one.
pub fn read(_: &mut Keys) -> Result<Arc<dyn Phase>> {
    Ok(Arc::new(Rayleigh))
}
