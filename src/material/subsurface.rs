//! `type = "subsurface"`: a body that light enters, scatters in and leaves elsewhere, by the dipole of diffusion theory [Jensen
//! 2001]: `interior`, a medium (of which only coefficients and mean cosine count), and the `index` of its smooth surface (1.3).
//!
//! It takes the surface for flat and wide and the body for deep, and light within for diffuse. It is wrong where light is absorbed as
//! much as it is scattered (`specprobe --medium NAME --thickness inf` shows both), in thin parts, and along edges; a `dielectric` with
//! the same `interior` is followed through the body itself (random walk), and is right there. Single scattering is part of the diffuse
//! light. Methods other than path tracing take the light out where it went in.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::entering::Entering;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Base, Effects, Ink, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::dipole::Dipole;

static BACK: Specular = Specular::Mirror;

/// A body by its dipole.
pub struct Subsurface {
    entering: Entering,
    polar: Polar,
    /// Number of the dipole, and of its whole reflectance.
    dipole: u32,
    total: u32,
}

impl Material for Subsurface {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        if !site.front {
            return;
        }
        let out_share = self.entering.share(out.z);
        let sent = 1.0 - out_share;
        lobes.push(Lobe { kernel: &BACK, tint: Tint::None, factor: sent, odds: sent, polar: Some(&self.polar) });
        let tint = Tint::Base(Base::Ink(self.total));
        lobes.push(Lobe { kernel: &self.entering, tint, factor: out_share, odds: out_share, polar: None });
    }

    fn effects(&self) -> Effects {
        Effects { subsurface: true, ..Effects::default() }
    }

    fn dipole(&self, lobe: &Lobe) -> Option<u32> {
        (lobe.tint == Tint::Base(Base::Ink(self.total))).then_some(self.dipole)
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let medium = r.interior()?.ok_or_else(|| r.keys.wrong("key 'interior' is missing"))?;
    let eta = r.within("index", (1.0, 3.0), 1.3)?;
    let [scattering, absorption] = r.interiors.reduced[medium as usize].clone();
    let index = f64::from(eta);
    let total = scattering.combined(&absorption, |s, a| Dipole::new(s, a, index).total());
    let total = r.ink(Ink::Reflectance(total));
    let dipole = r.ink(Ink::Dipole { scattering, absorption, eta: index });
    let polar = Polar::Boundary { eta, through: false };
    Ok(Arc::new(Subsurface { entering: Entering { eta }, polar, dipole, total }))
}
