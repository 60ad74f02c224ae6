//! Light from all around: the same everywhere, a sky, a picture. Its radiance is a sum of at most
//! [`super::MOST_PARTS`] spectra with factors that go with the direction.

use std::f64::consts::PI;

use glam::{DVec3, Vec3A};

use crate::scene::light::{Aim, Emission, MOST_PARTS};

/// Radiance by direction.
pub trait Surround: Send + Sync {
    /// How many spectra it is a sum of, at most [`MOST_PARTS`].
    fn parts(&self) -> usize;

    /// Their factors in a unit direction of the scene's axes.
    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS];

    /// Chooses a direction, with its density in 1/sr.
    fn choose(&self, u: [f64; 2]) -> (DVec3, f64);

    /// Density with which [`Surround::choose`] finds a direction.
    fn density(&self, direction: DVec3) -> f64;

    /// Integral of the factors over the sphere, sr: for choosing between lamps and for the picture's white.
    fn integrals_sr(&self) -> [f64; MOST_PARTS];

    /// Degree and axis, at right angles to it, of the polarization of what comes from a direction; `None` without.
    fn polarization(&self, _direction: DVec3) -> Option<(f32, DVec3)> {
        None
    }
}

/// The same in all directions, or in the upper half of them.
pub struct Uniform {
    /// Axis of the half; `None` for the whole sphere.
    pub half: Option<DVec3>,
}

impl Surround for Uniform {
    fn parts(&self) -> usize {
        1
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        let lit = self.half.is_none_or(|up| direction.dot(up) >= 0.0);
        [if lit { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        let z = if self.half.is_some() { u[0] } else { 1.0 - 2.0 * u[0] };
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = (2.0 * PI * u[1]).sin_cos();
        let axis = self.half.unwrap_or(DVec3::Z);
        let (x, y) = axis.any_orthonormal_pair();
        let direction = x * (r * c) + y * (r * s) + axis * z;
        (direction, self.density(direction))
    }

    fn density(&self, direction: DVec3) -> f64 {
        match self.half {
            None => 1.0 / (4.0 * PI),
            Some(up) if direction.dot(up) >= 0.0 => 1.0 / (2.0 * PI),
            Some(_) => 0.0,
        }
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        let whole = if self.half.is_some() { 2.0 * PI } else { 4.0 * PI };
        [whole, 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}

/// A surround with its spectra.
pub struct Environment {
    /// Number of its first spectrum in the scene's lights.
    pub light: u32,
    /// What it looks like.
    pub surround: Box<dyn Surround>,
    /// Unit vector up.
    pub up: DVec3,
}

impl Environment {
    fn emission(&self, direction: DVec3) -> Emission {
        Emission { light: self.light, count: self.surround.parts() as u32, parts: self.surround.factors(direction) }
    }

    /// Integrals of the factors x cosine over the hemisphere above: the horizontal irradiance in the open, in radiances.
    ///
    /// Midpoints on the projected hemisphere, where cosine x solid angle is an area.
    pub fn horizontal_sr(&self) -> [f64; MOST_PARTS] {
        const CIRCLES: u32 = 256;
        let (x, y) = self.up.any_orthonormal_pair();
        let mut sums = [0.0; MOST_PARTS];
        for i in 0..CIRCLES {
            let r = (f64::from(i) + 0.5) / f64::from(CIRCLES);
            let z = (1.0 - r * r).sqrt();
            let ring = PI * (2.0 * f64::from(i) + 1.0) / f64::from(CIRCLES).powi(2);
            for k in 0..4 * CIRCLES {
                let (s, c) = (2.0 * PI * (f64::from(k) + 0.5) / f64::from(4 * CIRCLES)).sin_cos();
                let factors = self.surround.factors((x * c + y * s) * r + self.up * z);
                sums.iter_mut().zip(factors).for_each(|(a, f)| *a += f64::from(f) * ring / f64::from(4 * CIRCLES));
            }
        }
        sums
    }

    /// A direction, likelier where it is bright.
    pub fn aim(&self, u: [f32; 2]) -> Option<Aim> {
        let (direction, pdf) = self.surround.choose(u.map(f64::from));
        (pdf > 0.0).then(|| Aim {
            direction: direction.as_vec3a(),
            point: None,
            pdf: pdf as f32,
            emission: self.emission(direction),
        })
    }

    /// Radiance in a direction.
    pub fn beyond(&self, direction: Vec3A) -> Option<(Emission, f32)> {
        let d = direction.as_dvec3();
        Some((self.emission(d), self.surround.density(d) as f32))
    }
}
