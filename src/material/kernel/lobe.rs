//! Radiance's rough transmission: a Gaussian about the straight way on,
//! f |cos inc| = exp((2 d.inc - 2) / a^2) / (pi a^2) sqrt(|cos inc| / cos out), d the straight direction.
//!
//! At grazing directions that formula passes on more light than came; there f is divided by its own albedo, the larger one
//! of both directions, which keeps it reciprocal.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::Vec3A;

use super::{Kernel, Turn, Value};
use crate::material::albedo::Albedo;

/// Light that goes on with a spread.
#[derive(Clone, Debug)]
pub struct Onward {
    roughness: f32,
    /// Of the formula as it stands.
    albedo: Option<Arc<Albedo>>,
}

impl Onward {
    /// With Radiance's roughness, above 0.
    pub fn new(roughness: f32) -> Onward {
        let raw = Onward { roughness, albedo: None };
        Onward { roughness, albedo: Some(Arc::new(Albedo::of(&raw))) }
    }

    /// What stands beside the Gaussian.
    fn side(&self, cos_out: f32, cos_inc: f32) -> f32 {
        let most = self.albedo.as_ref().map_or(1.0, |a| a.at(cos_out).max(a.at(cos_inc)).max(1.0));
        (cos_inc / cos_out).sqrt() / most
    }

    /// The Gaussian in 1 - cos has the density exp(-2 (1 - cos) / a^2) / (pi a^2 (1 - exp(-4 / a^2))) on the sphere.
    fn density(&self, cos: f32) -> f32 {
        let a2 = self.roughness * self.roughness;
        (2.0 * (cos - 1.0) / a2).exp() * FRAC_1_PI / (a2 * self.whole())
    }

    fn whole(&self) -> f32 {
        1.0 - (-4.0 / (self.roughness * self.roughness)).exp()
    }
}

impl Kernel for Onward {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        if inc.z >= 0.0 {
            return Value::default();
        }
        let pdf = self.density(-out.dot(inc));
        Value { f_cos: pdf * self.whole() * self.side(out.z, -inc.z), pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let a2 = self.roughness * self.roughness;
        let down = -0.5 * a2 * (1.0 - u[0] * self.whole()).ln();
        let cos = 1.0 - down;
        let sin = (down * (2.0 - down)).max(0.0).sqrt();
        let (s, c) = (2.0 * PI * u[1]).sin_cos();
        let axis = -out;
        let (x, y) = axis.any_orthonormal_pair();
        let inc = (axis * cos + (x * c + y * s) * sin).normalize();
        (inc.z < 0.0).then(|| Turn { inc, weight: self.whole() * self.side(out.z, -inc.z), pdf: self.density(cos) })
    }

    fn transmits(&self) -> bool {
        true
    }
}
