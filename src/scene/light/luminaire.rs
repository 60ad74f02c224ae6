//! A luminaire's photometry (IES LM-63) as a point's distribution: candela over the peak.

use glam::{DVec3, Vec3A};

use crate::photometry::ies::Photometry;
use crate::scene::light::point::Distribution;
use crate::scene::light::sky::Axes;

/// A photometry hung in the scene.
pub struct Luminaire {
    photometry: Photometry,
    axes: Axes,
    peak: f64,
}

impl Luminaire {
    /// `down` is where its nadir points, `c0` about where its horizontal angle 0 does (the part at right angles to `down`
    /// counts); `None` without light or where both are parallel.
    pub fn new(photometry: Photometry, down: DVec3, c0: DVec3) -> Option<Luminaire> {
        let peak = photometry.peak();
        // Axes::facing makes `ahead` the second axis; the luminaire's +x is C0, so +y is up x C0.
        let axes = Axes::facing(-down, (-down).cross(c0))?;
        (peak > 0.0).then_some(Luminaire { photometry, axes, peak })
    }

    /// Largest intensity, cd.
    pub fn peak_cd(&self) -> f64 {
        self.peak
    }
}

impl Distribution for Luminaire {
    fn factor(&self, direction: Vec3A) -> f32 {
        (self.photometry.intensity(self.axes.inward(direction.as_dvec3())) / self.peak) as f32
    }

    fn integral_sr(&self) -> f64 {
        self.photometry.flux_lm() / self.peak
    }
}
