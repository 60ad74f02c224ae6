//! Light spread as the cosine has it: f = 1/pi, to the front or through to the back.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3A;

use super::{Kernel, Turn, Value, disk};

/// Perfectly diffuse.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    /// Through the surface.
    pub through: bool,
}

/// A direction with density cos/pi about +z.
pub fn cosine(u: [f32; 2]) -> Vec3A {
    let [x, y] = disk(u);
    Vec3A::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

impl Kernel for Lambert {
    #[inline]
    fn evaluate(&self, _: Vec3A, inc: Vec3A) -> Value {
        let cos = if self.through { -inc.z } else { inc.z };
        let f_cos = cos.max(0.0) * FRAC_1_PI;
        Value { f_cos, pdf: f_cos }
    }

    #[inline]
    fn sample(&self, _: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let mut inc = cosine(u);
        inc.z = inc.z.max(1e-7);
        let pdf = inc.z * FRAC_1_PI;
        inc.z = if self.through { -inc.z } else { inc.z };
        Some(Turn { inc, weight: 1.0, pdf })
    }

    fn transmits(&self) -> bool {
        self.through
    }

    fn is_matt(&self) -> bool {
        true
    }
}
