//! A disk of light at infinity, the sun: equal radiance over its solid angle 2 pi (1 - cos half) = 4 pi sin^2(half / 2).

use std::f64::consts::PI;

use glam::{DVec3, Vec3A};

use crate::scene::light::{Aim, Emission};

/// A distant disk.
pub struct Sun {
    light: u32,
    axes: [DVec3; 3],
    /// 1 - cos of the half angle, kept apart since it is 1e-5 for the sun.
    one_minus_cos: f64,
    /// Tangent of the half angle, for precise tests of directions.
    sin2: f64,
}

impl Sun {
    /// Direction to it and its angular diameter in degrees, above 0 and under 180.
    pub fn new(light: u32, direction: DVec3, diameter_deg: f64) -> Sun {
        let axis = direction.normalize();
        let (s, t) = axis.any_orthonormal_pair();
        let half = (diameter_deg / 2.0).to_radians();
        let one_minus_cos = 2.0 * (half / 2.0).sin().powi(2);
        Sun { light, axes: [s, t, axis], one_minus_cos, sin2: half.sin().powi(2) }
    }

    /// Its number in the scene's lights.
    pub fn light(&self) -> usize {
        self.light as usize
    }

    /// Solid angle, sr.
    pub fn solid_angle_sr(&self) -> f64 {
        2.0 * PI * self.one_minus_cos
    }

    /// Irradiance of a surface that faces it, for radiance 1: integral of the cosine over the disk, pi sin^2 half.
    pub fn projected_sr(&self) -> f64 {
        PI * self.sin2
    }

    /// A place on the disk.
    pub fn aim(&self, u: [f32; 2]) -> Option<Aim> {
        let down = f64::from(u[0]) * self.one_minus_cos;
        let sin = (down * (2.0 - down)).max(0.0).sqrt();
        let (s, c) = (2.0 * PI * f64::from(u[1])).sin_cos();
        let direction = self.axes[0] * (sin * c) + self.axes[1] * (sin * s) + self.axes[2] * (1.0 - down);
        Some(Aim {
            direction: direction.as_vec3a(),
            point: None,
            pdf: self.pdf(),
            emission: Emission::one(self.light, 1.0),
        })
    }

    fn pdf(&self) -> f32 {
        (1.0 / self.solid_angle_sr()) as f32
    }

    /// Radiance where a direction meets the disk.
    pub fn beyond(&self, direction: Vec3A) -> Option<(Emission, f32)> {
        let d = direction.as_dvec3();
        let inside =
            d.dot(self.axes[2]) > 0.0 && d.cross(self.axes[2]).length_squared() <= self.sin2 * d.length_squared();
        let inside = if self.one_minus_cos < 1.0 { inside } else { d.dot(self.axes[2]) >= 1.0 - self.one_minus_cos };
        inside.then(|| (Emission::one(self.light, 1.0), self.pdf()))
    }
}
