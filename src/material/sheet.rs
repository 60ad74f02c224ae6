//! `type = "polarizer"`: a thin sheet that lets light through along its `axis`, a direction of the scene: `transmittance` along it
//! (1) and `leak` across it (0), shares of the power.
//!
//! `type = "retarder"`: a thin sheet that lets all through, and whose wave across the (fast) `axis` falls behind by `retardance_nm`:
//! 137.5 is a quarter of a wave at 550 nm.
//!
//! Light goes straight on, unreflected. Where it comes aslant, the axis is at right angles to it and to the sheet's other axis.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Effects, Lobe, Lobes, Material, Polar, Site, Tint};

static ON: Specular = Specular::Straight;

/// A polarising sheet.
pub struct Sheet {
    share: f32,
    polar: Polar,
    axis: DVec3,
}

impl Material for Sheet {
    fn lobes<'a>(&'a self, _: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        let (factor, polar) = (self.share, Some(&self.polar));
        lobes.push(Lobe { kernel: &ON, tint: Tint::None, factor, odds: factor, polar });
    }

    fn is_clear(&self) -> bool {
        true
    }

    fn effects(&self) -> Effects {
        Effects { polarises: true, aligns: true, ..Effects::default() }
    }

    fn axis(&self, _: &Site) -> Option<DVec3> {
        Some(self.axis)
    }
}

fn axis(r: &mut Reader) -> Result<DVec3> {
    let axis = DVec3::from(r.keys.need::<[f64; 3]>("axis")?).normalize_or_zero();
    if axis == DVec3::ZERO || !axis.is_finite() { Err(r.keys.wrong("axis: no direction")) } else { Ok(axis) }
}

/// Reads a polariser.
pub fn read_polarizer(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let axis = axis(r)?;
    let (along, across) = (r.within("transmittance", (0.0, 1.0), 1.0)?, r.within("leak", (0.0, 1.0), 0.0)?);
    if across > along {
        return Err(r.keys.wrong("leak must not be above transmittance"));
    }
    let polar = Polar::Sheet { along, across, retardance_nm: 0.0 };
    Ok(Arc::new(Sheet { share: 0.5 * (along + across), polar, axis }))
}

/// Reads a retarder.
pub fn read_retarder(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let axis = axis(r)?;
    let right = "must lie in -1e6 to 1e6";
    let nm = r.keys.number("retardance_nm", right, |x| x.abs() <= 1e6)?;
    let retardance_nm = nm.ok_or_else(|| r.keys.wrong("key 'retardance_nm' is missing"))? as f32;
    Ok(Arc::new(Sheet { share: 1.0, polar: Polar::Sheet { along: 1.0, across: 1.0, retardance_nm }, axis }))
}
