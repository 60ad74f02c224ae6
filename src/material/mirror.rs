//! `type = "mirror"`: a smooth mirror of any colour. `reflectance`, the same at every angle, as Radiance's `mirror`.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::specular::Specular;
use crate::material::read::{Paint, Reader};
use crate::material::{Lobe, Lobes, Material, Polar, Site, Tint};

static BACK: Specular = Specular::Mirror;
/// The limit of a very large index: s and p light alike, half a wave apart.
static PERFECT: Polar = Polar::Boundary { eta: 1e9, through: false };

/// An ideal mirror.
pub struct Mirror {
    /// Reflectance.
    pub paint: Paint,
    /// Both sides reflect.
    pub two_sided: bool,
}

impl Material for Mirror {
    fn lobes<'a>(&'a self, site: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        if site.front || self.two_sided {
            let (tint, polar) = (Tint::Base(self.paint.at(site)), Some(&PERFECT));
            lobes.push(Lobe { kernel: &BACK, tint, factor: 1.0, odds: 1.0, polar });
        }
    }

    fn looks_at_site(&self) -> bool {
        self.paint.varies()
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    Ok(Arc::new(Mirror { paint: r.paint()?, two_sided: r.two_sided()? }))
}
