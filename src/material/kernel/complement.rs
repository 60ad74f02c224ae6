//! What a rough surface has lost after one reflection, given back so that nothing is missing [Kulla 2017]:
//! f = (1 - E(out)) (1 - E(inc)) / (pi (1 - E mean)), E the surface's albedo for a direction. The same form carries light to
//! the base under a rough coat and out again, or to the other side.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::Vec3A;

use super::lambert::cosine;
use super::{Kernel, Turn, Value};
use crate::material::albedo::Albedo;

/// The complement of an albedo.
#[derive(Clone, Debug)]
pub struct Complement {
    /// The albedo.
    pub albedo: Arc<Albedo>,
    /// Light goes through the surface.
    pub through: bool,
}

impl Complement {
    /// Of what is above a surface.
    pub fn new(albedo: Albedo) -> Complement {
        Complement { albedo: Arc::new(albedo), through: false }
    }

    fn over_pi(&self, out: Vec3A, inc: Vec3A) -> f32 {
        let e = &self.albedo;
        (1.0 - e.at(out.z)) * (1.0 - e.at(inc.z.abs())) / (1.0 - e.mean()).max(1e-9)
    }
}

impl Kernel for Complement {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        let cos = if self.through { -inc.z } else { inc.z };
        let pdf = cos.max(0.0) * FRAC_1_PI;
        Value { f_cos: self.over_pi(out, inc) * pdf, pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let mut inc = cosine(u);
        inc.z = inc.z.max(1e-7);
        let (weight, pdf) = (self.over_pi(out, inc), inc.z * FRAC_1_PI);
        inc.z = if self.through { -inc.z } else { inc.z };
        Some(Turn { inc, weight, pdf })
    }

    fn transmits(&self) -> bool {
        self.through
    }
}
