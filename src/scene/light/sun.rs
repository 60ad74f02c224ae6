//! A disk of light at infinity, the sun: [`crate::sky::SunDisc`] with a spectrum.

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::scene::light::{Aim, Emission};
use crate::sky::SunDisc;

/// A distant disk.
pub struct Sun {
    light: u32,
    disc: SunDisc,
}

impl Sun {
    /// Direction to it and its angular diameter in degrees, above 0 and at most 180.
    pub fn new(light: u32, direction: DVec3, diameter_deg: f64) -> Result<Sun> {
        Ok(Sun { light, disc: SunDisc::new(direction.to_array(), diameter_deg)? })
    }

    /// Its number in the scene's lights.
    pub fn light(&self) -> usize {
        self.light as usize
    }

    /// Solid angle, sr.
    pub fn solid_angle_sr(&self) -> f64 {
        self.disc.solid_angle()
    }

    /// Irradiance of a surface that faces it, for radiance 1.
    pub fn projected_sr(&self) -> f64 {
        self.disc.irradiance(1.0)
    }

    /// A place on the disk.
    pub fn aim(&self, u: [f32; 2]) -> Option<Aim> {
        let direction = DVec3::from(self.disc.sample(u.map(f64::from))).as_vec3a();
        Some(Aim { direction, point: None, pdf: self.pdf(), emission: Emission::one(self.light, 1.0) })
    }

    fn pdf(&self) -> f32 {
        (1.0 / self.disc.solid_angle()) as f32
    }

    /// Radiance where a direction meets the disk.
    pub fn beyond(&self, direction: Vec3A) -> Option<(Emission, f32)> {
        let inside = self.disc.contains(direction.as_dvec3().normalize().to_array());
        inside.then(|| (Emission::one(self.light, 1.0), self.pdf()))
    }
}
