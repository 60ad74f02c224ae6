//! Skies as surroundings: the CIE's general ones with a spectrum of the user's choice, and Preetham's clear one with its own.

use glam::DVec3;

use crate::Result;
use crate::photometry::environment::{Environment as Directions, Region};
use crate::scene::light::MOST_PARTS;
use crate::scene::light::environment::Surround;
use crate::sky::{CieSky, ClearSky};
use crate::spectral::Spectrum;

/// Rows and columns of the grid that directions are drawn by, and the share drawn from everywhere.
const GRID: [usize; 2] = [90, 360];
const EVERYWHERE: f64 = 0.02;

/// The sky's axes in the scene's: the last is up.
#[derive(Clone, Copy, Debug)]
pub struct Axes([DVec3; 3]);

impl Axes {
    /// With this unit vector up.
    pub fn new(up: DVec3) -> Axes {
        let (x, y) = up.any_orthonormal_pair();
        Axes([x, y, up])
    }

    /// With the second axis as near to `ahead` as it can be.
    pub fn facing(up: DVec3, ahead: DVec3) -> Option<Axes> {
        let right = ahead.cross(up).normalize_or_zero();
        (right != DVec3::ZERO).then(|| Axes([right, up.cross(right), up]))
    }

    /// A direction of the scene in these axes.
    pub fn inward(&self, d: DVec3) -> [f64; 3] {
        self.0.map(|a| a.dot(d))
    }

    /// And back.
    pub fn outward(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.0[0] * x + self.0[1] * y + self.0[2] * z
    }
}

/// Directions drawn by brightness on a grid, in axes of the scene.
pub struct Drawn {
    axes: Axes,
    directions: Directions,
}

impl Drawn {
    /// A grid in these axes.
    pub fn new(axes: Axes, directions: Directions) -> Drawn {
        Drawn { axes, directions }
    }

    /// A direction of the scene in the grid's axes.
    pub fn inward(&self, direction: DVec3) -> [f64; 3] {
        self.axes.inward(direction)
    }

    /// See [`Surround::choose`].
    pub fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        let (d, pdf) = self.directions.sample(u);
        (self.axes.outward(d), pdf)
    }

    /// See [`Surround::density`].
    pub fn density(&self, direction: DVec3) -> f64 {
        self.directions.pdf(self.axes.inward(direction))
    }
}

/// A CIE general sky; 1 at the zenith.
pub struct General {
    sky: CieSky,
    drawn: Drawn,
    integral_sr: f64,
}

impl General {
    /// Type 1 to 15, directions of the scene.
    pub fn new(kind: u32, sun: DVec3, up: DVec3) -> Result<General> {
        let axes = Axes::new(up);
        let sky = CieSky::new(kind, axes.inward(sun))?;
        let directions = Directions::new(Region::Upper, GRID, EVERYWHERE, |d| sky.relative(d))?;
        let integral_sr = directions.integral();
        Ok(General { sky, drawn: Drawn::new(axes, directions), integral_sr })
    }

    /// Horizontal illuminance over the zenith's luminance, sr.
    pub fn horizontal_sr(&self) -> f64 {
        self.sky.horizontal()
    }
}

impl Surround for General {
    fn parts(&self) -> usize {
        1
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        [self.sky.relative(self.drawn.inward(direction)) as f32, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        self.drawn.choose(u)
    }

    fn density(&self, direction: DVec3) -> f64 {
        self.drawn.density(direction)
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        [self.integral_sr, 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}

/// Preetham's sky: three spectra, the CIE daylight components.
pub struct Clear {
    sky: ClearSky,
    drawn: Drawn,
    integrals: [f64; 3],
}

impl Clear {
    /// Turbidity 2 to 10, directions of the scene.
    pub fn new(turbidity: f64, sun: DVec3, up: DVec3) -> Result<Clear> {
        let axes = Axes::new(up);
        let sky = ClearSky::new(axes.inward(sun), turbidity)?;
        let directions = Directions::new(Region::Upper, GRID, EVERYWHERE, |d| sky.xyz(d)[1].max(0.0))?;
        let mut integrals = [0.0; 3];
        for (i, sum) in integrals.iter_mut().enumerate() {
            let part = Directions::new(Region::Upper, GRID, 0.0, |d| sky.coefficients(d)[i].max(0.0))?;
            *sum = part.integral();
        }
        Ok(Clear { sky, drawn: Drawn::new(axes, directions), integrals })
    }

    /// Its spectra, W/sr/m2/nm.
    pub fn basis(&self) -> Vec<Spectrum> {
        self.sky.basis().to_vec()
    }
}

impl Surround for Clear {
    fn parts(&self) -> usize {
        3
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        let [a, b, c] = self.sky.coefficients(self.drawn.inward(direction));
        [a as f32, b as f32, c as f32, 0.0, 0.0, 0.0]
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        self.drawn.choose(u)
    }

    fn density(&self, direction: DVec3) -> f64 {
        self.drawn.density(direction)
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        let [a, b, c] = self.integrals;
        [a, b, c, 0.0, 0.0, 0.0]
    }
}
