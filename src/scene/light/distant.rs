//! What Radiance's distant sources show: caps of the sky, each with a spectrum, the same in all its directions or by the brightness
//! function of a sky.

use std::f64::consts::PI;

use glam::DVec3;

use crate::Result;
use crate::photometry::environment::{Environment as Directions, Region};
use crate::scene::light::MOST_PARTS;
use crate::scene::light::environment::Surround;
use crate::scene::light::sky::{Axes, Drawn};
use crate::sky::RadianceSky;

/// Rows and columns of the grid that directions are drawn by, and the share drawn from everywhere.
const GRID: [usize; 2] = [180, 360];
const EVERYWHERE: f64 = 0.02;

/// All directions within an angle of one.
pub struct Cap {
    toward: DVec3,
    cos: f64,
    sky: Option<RadianceSky>,
}

impl Cap {
    /// About a direction, `angle_deg` the whole angle across, up to 360; `sky` in the scene's axes.
    pub fn new(toward: DVec3, angle_deg: f64, sky: Option<RadianceSky>) -> Cap {
        // The horizon of half the sphere is just that, whatever a cosine's last digit says.
        let cos = if angle_deg == 180.0 { 0.0 } else { (angle_deg / 2.0).to_radians().cos() };
        Cap { toward, cos, sky }
    }

    fn factor(&self, direction: DVec3) -> f64 {
        match &self.sky {
            _ if direction.dot(self.toward) < self.cos => 0.0,
            None => 1.0,
            Some(sky) => sky.at(direction.to_array()),
        }
    }
}

/// Several caps.
pub struct Distant {
    caps: Vec<Cap>,
    drawn: Drawn,
    integrals_sr: [f64; MOST_PARTS],
}

impl Distant {
    /// Caps with the luminance that each has where its factor is 1, and the direction up.
    pub fn new(caps: Vec<(Cap, f64)>, up: DVec3) -> Result<Distant> {
        let axes = Axes::new(up);
        let bright = |d: [f64; 3]| caps.iter().map(|(cap, l)| l * cap.factor(axes.outward(d))).sum::<f64>();
        let directions = Directions::new(Region::Sphere, GRID, EVERYWHERE, bright)?;
        let mut integrals_sr = [0.0; MOST_PARTS];
        for (sum, (cap, _)) in integrals_sr.iter_mut().zip(&caps) {
            *sum = match &cap.sky {
                None => 2.0 * PI * (1.0 - cap.cos),
                Some(_) => Directions::new(Region::Sphere, GRID, 0.0, |d| cap.factor(axes.outward(d)))?.integral(),
            };
        }
        let caps = caps.into_iter().map(|c| c.0).collect();
        Ok(Distant { caps, drawn: Drawn::new(axes, directions), integrals_sr })
    }
}

impl Surround for Distant {
    fn parts(&self) -> usize {
        self.caps.len()
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        let mut factors = [0.0; MOST_PARTS];
        factors.iter_mut().zip(&self.caps).for_each(|(f, cap)| *f = cap.factor(direction) as f32);
        factors
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        self.drawn.choose(u)
    }

    fn density(&self, direction: DVec3) -> f64 {
        self.drawn.density(direction)
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        self.integrals_sr
    }
}
