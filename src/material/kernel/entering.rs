//! Light that enters a smooth body from everywhere, spread evenly below its surface: f = T(inc) / pi, T the Fresnel transmittance.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::lambert::cosine;
use super::{Kernel, Turn, Value};
use crate::optics::fresnel;

/// Into a body of this index.
#[derive(Clone, Copy, Debug)]
pub struct Entering {
    /// Index inside over outside.
    pub eta: f32,
}

impl Entering {
    /// Share of light at a cosine that goes in; by reciprocity, that comes out.
    pub fn share(&self, cos: f32) -> f32 {
        1.0 - fresnel::dielectric(cos, self.eta).0
    }
}

impl Kernel for Entering {
    fn evaluate(&self, _: Vec3A, inc: Vec3A) -> Value {
        let pdf = inc.z.max(0.0) * FRAC_1_PI;
        Value { f_cos: pdf * self.share(inc.z.max(0.0)), pdf }
    }

    fn sample(&self, _: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let mut inc = cosine(u);
        inc.z = inc.z.max(1e-7);
        Some(Turn { inc, weight: self.share(inc.z), pdf: inc.z * FRAC_1_PI })
    }
}
