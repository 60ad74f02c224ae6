//! `type = "dielectric"`: the smooth boundary of a clear body, light is thrown back and bent. `index` inside over outside
//! (1.5), the same for all wavelengths; the front is the outside. Absorption and dispersion inside are not modelled yet.
//!
//! Radiance follows n^2: seen from inside glass of index 1.5 the sky is 2.25 times as bright, and is itself again outside.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::fresnel;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Lobe, Lobes, Material, Site, Tint};

static BACK: Specular = Specular::Mirror;

/// A smooth boundary.
pub struct Dielectric {
    index: f32,
    inward: Specular,
    outward: Specular,
}

impl Dielectric {
    /// `index` inside over outside, above 0.
    pub fn new(index: f32) -> Dielectric {
        Dielectric { index, inward: Specular::Bent { eta: index }, outward: Specular::Bent { eta: 1.0 / index } }
    }
}

impl Material for Dielectric {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        let (eta, on) = if site.front { (self.index, &self.inward) } else { (1.0 / self.index, &self.outward) };
        let sent = fresnel::dielectric(out.z, eta).0;
        lobes.push(Lobe { kernel: &BACK, tint: Tint::None, factor: sent, odds: sent });
        lobes.push(Lobe { kernel: on, tint: Tint::None, factor: 1.0 - sent, odds: 1.0 - sent });
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    Ok(Arc::new(Dielectric::new(r.within("index", (0.25, 4.0), 1.5)?)))
}
