//! `density = { exponential = { scale_height = 1200 } }`: falls by e with every `scale_height` that a place lies higher, as air and
//! haze do; 1 at the height of `base` (a point, [0, 0, 0]). `up` is where it falls ([0, 0, 1]). It goes on below the base, ever denser.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::keys::Keys;
use crate::medium::density::{Density, Way};

/// exp(-(height over the base) / scale height).
#[derive(Clone, Copy, Debug)]
pub struct Exponential {
    base: DVec3,
    up: DVec3,
    scale_height: f64,
    // The same for floats: exponent = offset - slope . place.
    slope: Vec3A,
    offset: f32,
}

impl Exponential {
    /// `up` of any length, `scale_height` above 0.
    pub fn new(base: DVec3, up: DVec3, scale_height: f64) -> Exponential {
        let up = up.normalize();
        let slope = up / scale_height;
        Exponential { base, up, scale_height, slope: slope.as_vec3a(), offset: slope.dot(base) as f32 }
    }

    /// Density at the start, and by how much the exponent falls in a unit of the way.
    fn start(&self, way: &Way) -> (f32, f32) {
        (self.at(way.origin), self.slope.dot(way.direction))
    }
}

impl Density for Exponential {
    fn within(&self, centre: DVec3, scale: f64) -> Arc<dyn Density> {
        Arc::new(Exponential::new((self.base - centre) * scale, self.up, self.scale_height * scale))
    }

    fn at(&self, place: Vec3A) -> f32 {
        (self.offset - self.slope.dot(place)).exp()
    }

    /// d0 (1 - exp(-k t)) / k.
    fn along(&self, way: &Way) -> f32 {
        let (start, k) = self.start(way);
        // Level ways may be endless: 0 times infinity is nothing to go by.
        let x = if k == 0.0 { 0.0 } else { k * way.length };
        if x.abs() < 1e-4 {
            // Level ways; the first two terms of the series.
            return start * way.length * (1.0 - 0.5 * x);
        }
        start * (-(-x).exp_m1() / k)
    }

    fn reach(&self, way: &Way, column: f32) -> Option<f32> {
        let (start, k) = self.start(way);
        let level = column / start;
        let y = k * level;
        let t = if y.abs() < 1e-4 { level * (1.0 + 0.5 * y) } else { -(-y).ln_1p() / k };
        // Upward no more than d0 / k is there: the logarithm of what is below 0.
        (t < way.length).then_some(t)
    }
}

/// Reads one.
pub fn read(mut keys: Keys, metres: f64) -> Result<Arc<dyn Density>> {
    let Some(height) = keys.number("scale_height", "must be above 0", |h| h > 0.0 && h < 1e12)? else {
        return Err(keys.wrong("key 'scale_height' is missing"));
    };
    let base = DVec3::from(keys.get::<[f64; 3]>("base")?.unwrap_or([0.0; 3]));
    let up = DVec3::from(keys.get::<[f64; 3]>("up")?.unwrap_or([0.0, 0.0, 1.0]));
    if !base.is_finite() || base.abs().max_element() > 1e12 || up.normalize_or_zero() == DVec3::ZERO {
        return Err(keys.wrong("base: a point, up: a direction"));
    }
    keys.finish()?;
    Ok(Arc::new(Exponential::new(base * metres, up, height * metres)))
}
