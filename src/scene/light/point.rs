//! Lights without extent: a point, a spot, a luminaire by its photometry. Paths cannot run into them.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::scene::light::{Aim, Emission};

/// How intensity goes with direction, as a factor of the light's spectrum.
pub trait Distribution: Send + Sync {
    /// Factor along a unit direction away from the lamp, in the scene's axes.
    fn factor(&self, direction: Vec3A) -> f32;

    /// Integral of the factor over the sphere, sr.
    fn integral_sr(&self) -> f64;
}

/// The same everywhere.
pub struct Isotropic;

impl Distribution for Isotropic {
    fn factor(&self, _: Vec3A) -> f32 {
        1.0
    }

    fn integral_sr(&self) -> f64 {
        4.0 * std::f64::consts::PI
    }
}

/// A cone of light: full within `inner`, smoothly less to nothing at `outer`, by the cosine.
pub struct Spot {
    axis: Vec3A,
    cos_inner: f32,
    cos_outer: f32,
}

impl Spot {
    /// Half angles in degrees, 0 <= inner <= outer <= 180.
    pub fn new(axis: DVec3, inner_deg: f64, outer_deg: f64) -> Spot {
        let cos = |deg: f64| deg.to_radians().cos() as f32;
        Spot { axis: axis.normalize().as_vec3a(), cos_inner: cos(inner_deg), cos_outer: cos(outer_deg) }
    }
}

impl Distribution for Spot {
    fn factor(&self, direction: Vec3A) -> f32 {
        let cos = direction.dot(self.axis);
        if cos >= self.cos_inner {
            return 1.0;
        }
        let x = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The smooth step 3 x^2 - 2 x^3 has the mean 1/2.
    fn integral_sr(&self) -> f64 {
        let (inner, outer) = (f64::from(self.cos_inner), f64::from(self.cos_outer));
        2.0 * std::f64::consts::PI * ((1.0 - inner) + 0.5 * (inner - outer))
    }
}

/// A point that shines; the light's spectrum is its intensity, W/sr/nm, in the frame's units (x scale^2).
pub struct Point {
    /// Number of its spectrum.
    pub light: u32,
    /// Place in the scene's frame.
    pub place: Vec3A,
    /// Factor of this point.
    pub factor: f32,
    /// Where it goes.
    pub distribution: Arc<dyn Distribution>,
}

impl Point {
    /// The only direction there is.
    pub fn aim(&self, from: Vec3A) -> Option<Aim> {
        let to = self.place - from;
        let squared = to.length_squared();
        let direction = to / squared.sqrt();
        let factor = self.factor * self.distribution.factor(-direction) / squared;
        (factor > 0.0 && factor.is_finite()).then(|| Aim {
            direction,
            point: Some(self.place),
            pdf: f32::INFINITY,
            emission: Emission::one(self.light, factor),
        })
    }
}
