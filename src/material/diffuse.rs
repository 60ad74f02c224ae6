//! `type = "diffuse"`: a matt surface. `reflectance` in 0..1, `two_sided = false` blackens the back.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::lambert::Lambert;
use crate::material::read::{Paint, Reader};
use crate::material::{Lobe, Lobes, Material, Site, Tint};

static UP: Lambert = Lambert { through: false };

/// A Lambertian surface.
pub struct Diffuse {
    /// Reflectance.
    pub paint: Paint,
    /// Both sides reflect.
    pub two_sided: bool,
}

impl Material for Diffuse {
    fn lobes<'a>(&'a self, site: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        if let Some(lobe) = self.only(site) {
            lobes.push(lobe);
        }
    }

    fn only(&self, site: &Site) -> Option<Lobe<'_>> {
        let lit = site.front || self.two_sided;
        lit.then(|| Lobe { kernel: &UP, tint: Tint::Base(self.paint.at(site)), factor: 1.0, odds: 1.0, polar: None })
    }

    fn looks_at_site(&self) -> bool {
        self.paint.varies()
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    Ok(Arc::new(Diffuse { paint: r.paint()?, two_sided: r.two_sided()? }))
}
