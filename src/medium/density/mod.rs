//! How dense a medium is from place to place: a factor of its coefficients. What a way through it amounts to, the integral of the
//! density along it, is known in closed form for all of them: transmittance has no noise, and no step.
//!
//! One profile, one file whose head is its manual page. Places are those of the scene's frame, lengths its units; a way's direction is
//! a unit vector, its length may be infinite.

pub mod exponential;
pub mod grid;
pub mod homogeneous;
pub mod vol;

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::keys::Keys;

/// A way through a medium.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Where it begins.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
    /// Its length, which may be infinite.
    pub length: f32,
}

impl Way {
    /// The place so far along it.
    pub fn at(&self, t: f32) -> Vec3A {
        self.origin + self.direction * t
    }

    /// Its first part.
    pub fn up_to(&self, length: f32) -> Way {
        Way { length, ..*self }
    }
}

/// A profile.
pub trait Density: Send + Sync + Debug {
    /// The same in the frame of a scene: (place - centre) x scale.
    fn within(&self, centre: DVec3, scale: f64) -> Arc<dyn Density>;

    /// Factor of the coefficients at a place, 0 and more.
    fn at(&self, place: Vec3A) -> f32;

    /// Its integral along a way.
    fn along(&self, way: &Way) -> f32;

    /// How far the integral is `column`; `None` where it is less along the whole way.
    fn reach(&self, way: &Way, column: f32) -> Option<f32>;

    /// Where null collisions serve: the next place at which a medium as dense as the densest of its surroundings would have let
    /// `column` pass, with the density there over that; `None` beyond the way. Begins at `from` along it.
    fn candidate(&self, _way: &Way, _from: f32, _column: f32) -> Option<Candidate> {
        None
    }

    /// Ways through it are followed by null collisions.
    fn by_null_collisions(&self) -> bool {
        false
    }
}

/// A place of a collision that may be none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// How far along the way.
    pub t: f32,
    /// The density there over the densest around, 0..1.
    pub share: f32,
    /// That densest.
    pub most: f32,
}

/// The key `density` of a medium: a number, or `{ exponential = {..} }` or `{ grid = {..} }`; 1 where it is not there. Lengths are
/// `metres` each.
pub fn read(keys: &mut Keys, metres: f64, folder: &Path) -> Result<Arc<dyn Density>> {
    if keys.peek::<f64>("density").is_some() {
        let density = keys.number("density", "must be 0 or more", |d| (0.0..1e30).contains(&d))?.unwrap_or(1.0);
        return Ok(Arc::new(homogeneous::Homogeneous { density: density as f32 }));
    }
    let Some(mut table) = keys.table("density")? else {
        return Ok(Arc::new(homogeneous::Homogeneous { density: 1.0 }));
    };
    let (exponential, grid) = (table.table("exponential")?, table.table("grid")?);
    let density = match (exponential, grid) {
        (Some(k), None) => exponential::read(k, metres)?,
        (None, Some(k)) => grid::read(k, metres, folder)?,
        _ => return Err(table.wrong("expected a number, or one of exponential and grid")),
    };
    table.finish()?;
    Ok(density)
}
