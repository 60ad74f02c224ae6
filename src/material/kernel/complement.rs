//! What a rough surface has lost after one reflection, given back so that nothing is missing [Kulla 2017]:
//! f = (1 - E(out)) (1 - E(inc)) / (pi (1 - E mean)), E the surface's albedo for a direction. The same form carries light to
//! the base under a rough coat and out again.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::Vec3A;

use super::lambert::cosine;
use super::{Kernel, Turn, Value};
use crate::material::albedo::Albedo;

/// The complement of an albedo.
#[derive(Clone, Debug)]
pub struct Complement(pub Arc<Albedo>);

impl Complement {
    fn over_pi(&self, out: Vec3A, inc: Vec3A) -> f32 {
        (1.0 - self.0.at(out.z)) * (1.0 - self.0.at(inc.z)) / (1.0 - self.0.mean()).max(1e-9)
    }
}

impl Kernel for Complement {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        let pdf = inc.z.max(0.0) * FRAC_1_PI;
        Value { f_cos: self.over_pi(out, inc) * pdf, pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let mut inc = cosine(u);
        inc.z = inc.z.max(1e-7);
        Some(Turn { inc, weight: self.over_pi(out, inc), pdf: inc.z * FRAC_1_PI })
    }
}
