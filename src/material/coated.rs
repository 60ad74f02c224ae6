//! `type = "coated"`: a clear coat over a matt base, as varnished wood, glazed tiles, most plastics. `reflectance` of the base,
//! `index` of the coat (1.5), `roughness` of its upper side 0..1 (0).
//!
//! Light passes the coat twice and is thrown back at it from below by the share k, the coat's diffuse reflectance from
//! inside: f = (1 - E(out)) (1 - E(inc)) / (pi (1 - E mean)) x R (1 - k) / (1 - k R), 1 - k = (1 - E mean) / n^2. For a
//! smooth coat it is that of Saunderson; a white base gives all light back, at every roughness.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::albedo::Albedo;
use crate::material::conductor::SMOOTH;
use crate::material::kernel::complement::Complement;
use crate::material::kernel::ggx::Ggx;
use crate::material::kernel::specular::Specular;
use crate::material::read::{Paint, Reader};
use crate::material::{Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::fresnel;

static BACK: Specular = Specular::Mirror;

/// A coat over a matt base.
pub struct Coated {
    paint: Paint,
    index: f32,
    rough: Option<Ggx>,
    base: Complement,
    inside: f32,
    polar: Polar,
    two_sided: bool,
}

impl Coated {
    /// `index` from 1, `alpha` in 0..1.
    pub fn new(paint: Paint, index: f32, alpha: f32, two_sided: bool) -> Coated {
        let rough = (alpha >= SMOOTH).then_some(Ggx { alpha, eta: Some(index) });
        let albedo = match &rough {
            Some(ggx) => Albedo::of(ggx),
            None => Albedo::from_fn(|cos| fresnel::dielectric(cos, index).0),
        };
        let inside = 1.0 - (1.0 - albedo.mean()) / (index * index);
        let polar = Polar::Boundary { eta: index, through: false };
        Coated { paint, index, rough, base: Complement::new(albedo), inside, polar, two_sided }
    }
}

impl Material for Coated {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        if !(site.front || self.two_sided) {
            return;
        }
        let (albedo, polar) = (self.base.albedo.at(out.z), Some(&self.polar));
        match &self.rough {
            Some(ggx) => {
                let (tint, odds) = (Tint::None, albedo.max(1e-4));
                lobes.push(Lobe { kernel: ggx, tint, factor: 1.0, odds, polar });
            }
            None => {
                let factor = fresnel::dielectric(out.z, self.index).0;
                lobes.push(Lobe { kernel: &BACK, tint: Tint::None, factor, odds: factor, polar });
            }
        }
        let tint = Tint::Beneath(self.paint.at(site), self.inside);
        lobes.push(Lobe { kernel: &self.base, tint, factor: 1.0, odds: (1.0 - albedo).max(1e-4), polar: None });
    }

    fn looks_at_site(&self) -> bool {
        self.paint.varies()
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (index, roughness) = (r.within("index", (1.0, 4.0), 1.5)?, r.within("roughness", (0.0, 1.0), 0.0)?);
    Ok(Arc::new(Coated::new(r.paint()?, index, roughness, r.two_sided()?)))
}
