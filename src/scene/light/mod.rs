//! What shines: surfaces, points, the sun and the sky, all aimed at in one way.

pub mod angular;
pub mod area;
pub mod disk;
pub mod distant;
pub mod environment;
pub mod luminaire;
pub mod picture;
pub mod point;
pub mod polarised;
mod rectangle;
pub mod sky;
pub mod sun;
pub mod tree;

use glam::Vec3A;

pub use area::Emitter;
pub use environment::Environment;
pub use point::Point;
pub use sun::Sun;

/// Most spectra that one light is a sum of.
pub const MOST_PARTS: usize = 6;

/// Radiance as a sum of light spectra times numbers; one spectrum for most lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Number of the first spectrum in the scene's lights; the others follow.
    pub light: u32,
    /// How many.
    pub count: u32,
    /// Their factors.
    pub parts: [f32; MOST_PARTS],
}

impl Emission {
    /// One spectrum times a number.
    #[inline]
    pub fn one(light: u32, part: f32) -> Emission {
        Emission { light, count: 1, parts: [part, 0.0, 0.0, 0.0, 0.0, 0.0] }
    }
}

/// Where light may come from.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// Unit direction to it.
    pub direction: Vec3A,
    /// The place, moved off its surface; `None` for light from beyond the scene.
    pub point: Option<Vec3A>,
    /// Density of the direction, 1/sr; infinite for a point or a sun without a disk, whose `emission` is per density.
    pub pdf: f32,
    /// Radiance; for a point, intensity over distance squared.
    pub emission: Emission,
}

/// Anything that shines.
pub enum Lamp {
    /// A surface.
    Area(Emitter),
    /// A point.
    Point(Point),
    /// The sun's disk.
    Sun(Sun),
    /// Everything around.
    Environment(Environment),
}

impl Lamp {
    /// Chooses where to look for its light as seen from a place; `None` where none of it can be seen.
    #[inline]
    pub fn aim(&self, from: Vec3A, u: [f32; 2]) -> Option<Aim> {
        match self {
            Lamp::Area(e) => e.aim(from, u),
            Lamp::Point(p) => p.aim(from),
            Lamp::Sun(s) => s.aim(u),
            Lamp::Environment(e) => e.aim(u),
        }
    }

    /// A place of it by two numbers in 0..1, as likely as any other; `None` beyond the scene.
    pub fn pivot(&self, u: [f32; 2]) -> Option<Vec3A> {
        match self {
            Lamp::Area(e) => Some(e.pivot(u)),
            Lamp::Point(p) => Some(p.place),
            Lamp::Sun(_) | Lamp::Environment(_) => None,
        }
    }

    /// From beyond the scene: radiance in a direction and the density with which [`Lamp::aim`] finds it.
    pub fn beyond(&self, direction: Vec3A) -> Option<(Emission, f32)> {
        match self {
            Lamp::Sun(s) => s.beyond(direction),
            Lamp::Environment(e) => e.beyond(direction),
            Lamp::Area(_) | Lamp::Point(_) => None,
        }
    }

    /// Degree and axis (unit, at right angles to the direction) of the polarization of light from beyond the scene, if it has any.
    pub fn polarization(&self, direction: Vec3A) -> Option<(f32, Vec3A)> {
        match self {
            Lamp::Environment(e) => e.surround.polarization(direction.as_dvec3()).map(|(d, axis)| (d, axis.as_vec3a())),
            _ => None,
        }
    }

    /// Lies beyond the scene.
    pub fn is_distant(&self) -> bool {
        matches!(self, Lamp::Sun(_) | Lamp::Environment(_))
    }
}
