//! `type = "translucent"`: a thin matt sheet, as paper, a lampshade, a leaf. `reflectance` and `transmittance`, spectra that sum
//! to at most 1; both sides are alike.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::lambert::Lambert;
use crate::material::read::Reader;
use crate::material::{Base, Lobe, Lobes, Material, Site, Tint};
use crate::spectral::spectrum::breaks;

static UP: Lambert = Lambert { through: false };
static DOWN: Lambert = Lambert { through: true };

/// A diffusing sheet.
pub struct Translucent {
    reflectance: Base,
    transmittance: Base,
    /// About the shares, for choosing.
    odds: [f32; 2],
}

impl Material for Translucent {
    fn lobes<'a>(&'a self, _: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        let sides: [(&'static Lambert, Base); 2] = [(&UP, self.reflectance), (&DOWN, self.transmittance)];
        for ((kernel, base), odds) in sides.into_iter().zip(self.odds) {
            lobes.push(Lobe { kernel, tint: Tint::Base(base), factor: 1.0, odds, polar: None });
        }
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (Some((back, _)), Some((on, _))) = (r.spectrum("reflectance")?, r.spectrum("transmittance")?) else {
        return Err(r.keys.wrong("give reflectance and transmittance"));
    };
    let (nodes, ends) = (breaks(&[&back, &on], 250.0, 2500.0), [380.0, 780.0]);
    if let Some(nm) = nodes.iter().chain(&ends).find(|nm| back.at(**nm) + on.at(**nm) > 1.0 + 1e-9) {
        return Err(r.keys.wrong(&format!("reflectance and transmittance sum to more than 1 at {nm} nm")));
    }
    let lowest = back.range().0.min(on.range().0);
    if lowest < 0.0 {
        return Err(r.keys.wrong("reflectance and transmittance must not be below 0"));
    }
    let mean =
        |s: &crate::spectral::Spectrum| if s.range().1 > 0.0 { (s.mean(400.0, 700.0) as f32).max(0.01) } else { 0.0 };
    let odds = [mean(&back), mean(&on)];
    Ok(Arc::new(Translucent { reflectance: r.base(back), transmittance: r.base(on), odds }))
}
