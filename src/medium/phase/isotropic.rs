//! `"isotropic"`: light that scatters goes everywhere alike.

use std::f32::consts::PI;
use std::sync::Arc;

use crate::Result;
use crate::keys::Keys;
use crate::medium::phase::Phase;

/// 1 / 4 pi.
#[derive(Clone, Copy, Debug)]
pub struct Isotropic;

impl Phase for Isotropic {
    fn value(&self, _: f32) -> f32 {
        0.25 / PI
    }

    fn sample(&self, u: f32) -> f32 {
        2.0 * u
    }

    fn mean_cosine(&self) -> f64 {
        0.0
    }
}

/// Reads one.
pub fn read(_: &mut Keys) -> Result<Arc<dyn Phase>> {
    Ok(Arc::new(Isotropic))
}
