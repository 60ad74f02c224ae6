//! `type = "boundary"`: the surface of a body that is not there but for what fills it: light goes straight on. `interior`, the name of
//! the medium behind its front: fog, smoke, a slab of equal index.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Effects, Lobe, Lobes, Material, Polar, Site, Tint};

static ON: Specular = Specular::Straight;
/// Polarization goes through unchanged.
static THROUGH: Polar = Polar::Sheet { along: 1.0, across: 1.0, retardance_nm: 0.0 };

/// Where a medium begins.
pub struct Boundary {
    interior: u32,
}

impl Material for Boundary {
    fn lobes<'a>(&'a self, _: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        lobes.push(Lobe { kernel: &ON, tint: Tint::None, factor: 1.0, odds: 1.0, polar: Some(&THROUGH) });
    }

    fn is_clear(&self) -> bool {
        true
    }

    fn is_void(&self) -> bool {
        true
    }

    fn effects(&self) -> Effects {
        Effects { fills: true, ..Effects::default() }
    }

    fn interior(&self) -> Option<u32> {
        Some(self.interior)
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let interior = r.interior()?.ok_or_else(|| r.keys.wrong("key 'interior' is missing"))?;
    Ok(Arc::new(Boundary { interior }))
}
