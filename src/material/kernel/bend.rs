//! Through the smooth boundary of a body whose index depends on the wavelength.

use std::sync::Arc;

use glam::Vec3A;

use super::single::Single;
use super::specular::Specular;
use super::{Kernel, Turn, Value};
use crate::spectral::Spectrum;

/// Wavelengths that stand for the visible spectrum, nm: its ends as the eye sees them, and where it sees best.
pub const ENDS_NM: [f64; 3] = [410.0, 555.0, 680.0];

/// An index by wavelength, and its values at [`ENDS_NM`].
#[derive(Clone, Debug)]
pub struct Index {
    /// Inside over outside.
    pub n: Arc<Spectrum>,
    /// At the ends and the middle.
    pub ends: [f32; 3],
}

impl Index {
    /// From a table that goes on beyond its ends.
    pub fn new(n: Spectrum) -> Index {
        let ends = ENDS_NM.map(|nm| n.at(nm) as f32);
        Index { n: Arc::new(n), ends }
    }

    /// Index beyond the boundary over that on the side that light leaves to.
    pub fn eta(&self, nm: f32, front: bool) -> f32 {
        let n = self.n.at(nm.into()) as f32;
        if front { n } else { 1.0 / n }
    }

    /// The same in the middle of the spectrum.
    pub fn middle(&self, front: bool) -> f32 {
        if front { self.ends[1] } else { 1.0 / self.ends[1] }
    }

    /// Angle between the ways that the ends of the spectrum take for light that leaves with this cosine; all of it where one end
    /// is reflected totally.
    pub fn spread(&self, cos: f32, front: bool) -> f32 {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let angle = |n: f32| {
            let s = if front { sin / n } else { sin * n };
            (s < 1.0).then(|| s.asin())
        };
        match (angle(self.ends[0]), angle(self.ends[2])) {
            (Some(a), Some(b)) => (a - b).abs(),
            (None, None) => 0.0,
            _ => 1.0,
        }
    }
}

/// The boundary, for light that leaves to one of its sides. What it squeezes of the radiance is in the tint, by wavelength.
#[derive(Clone, Debug)]
pub struct Bend {
    /// Of the body.
    pub index: Index,
    /// Light leaves to the outside.
    pub front: bool,
}

impl Kernel for Bend {
    fn evaluate(&self, _: Vec3A, _: Vec3A) -> Value {
        Value::default()
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        self.at(ENDS_NM[1] as f32)?.sample(out, u)
    }

    fn transmits(&self) -> bool {
        true
    }

    fn is_specular(&self) -> bool {
        true
    }

    fn spread(&self, out: Vec3A) -> f32 {
        self.index.spread(out.z, self.front)
    }

    fn at(&self, nm: f32) -> Option<Single> {
        Some(Single::Bent(Specular::Bent { eta: self.index.eta(nm, self.front) }))
    }
}
