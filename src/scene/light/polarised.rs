//! A sky whose light is polarised as molecules polarise what they scatter [Rayleigh]: at right angles to the plane of sun and
//! direction, by `most` sin^2 / (1 + cos^2) of the angle to the sun. What is scattered more than once, and by dust, makes `most`
//! less than 1: 0.75 to 0.85 on clear days.

use glam::DVec3;

use crate::optics::polarization::rayleigh;
use crate::scene::light::MOST_PARTS;
use crate::scene::light::environment::Surround;

/// Another sky's light, polarised.
pub struct Polarised {
    /// How bright it is.
    pub sky: Box<dyn Surround>,
    /// Unit direction to the sun.
    pub sun: DVec3,
    /// Degree of polarization at right angles to it.
    pub most: f64,
}

impl Surround for Polarised {
    fn parts(&self) -> usize {
        self.sky.parts()
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        self.sky.factors(direction)
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        self.sky.choose(u)
    }

    fn density(&self, direction: DVec3) -> f64 {
        self.sky.density(direction)
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        self.sky.integrals_sr()
    }

    fn polarization(&self, direction: DVec3) -> Option<(f32, DVec3)> {
        let axis = direction.cross(self.sun).normalize_or(direction.any_orthonormal_vector());
        Some(((self.most * rayleigh(direction.dot(self.sun))) as f32, axis))
    }
}
