//! `density = 1`: everywhere the same.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::medium::density::{Density, Way};

/// A factor.
#[derive(Clone, Copy, Debug)]
pub struct Homogeneous {
    /// Of the coefficients.
    pub density: f32,
}

impl Density for Homogeneous {
    fn within(&self, _: DVec3, _: f64) -> Arc<dyn Density> {
        Arc::new(*self)
    }

    fn at(&self, _: Vec3A) -> f32 {
        self.density
    }

    fn along(&self, way: &Way) -> f32 {
        if self.density > 0.0 { self.density * way.length } else { 0.0 }
    }

    fn reach(&self, way: &Way, column: f32) -> Option<f32> {
        // 0 / 0 is no distance.
        Some(column / self.density).filter(|t| *t < way.length)
    }
}
