//! `type = "wave_rough"`: a rough metal by wave optics [He 1991]. `metal` = Ag, Al, Au, Cu, or spectra `n` and `k`; `sigma_nm` the
//! rms height of its surface, `tau_nm` the length over which heights resemble each other.
//!
//! A mirror's part is left by the heights that are small against the wavelength, more of the long ones than of the short: polished
//! metal is reddish in its mirror, bluish beside it. Light that is reflected more than once in the pits is lost.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::conductor::read_metal;
use crate::material::kernel::incoherent::Incoherent;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Ink, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::roughness::Rough;

static BACK: Specular = Specular::Mirror;

/// A rough metal.
pub struct WaveRough {
    index: u32,
    lobe: Incoherent,
    polar: Polar,
    two_sided: bool,
}

impl Material for WaveRough {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        if !(site.front || self.two_sided) {
            return;
        }
        let (index, rough, cos) = (self.index, self.lobe.rough, out.z);
        let seen = rough.seen(cos, cos);
        let (kept, polar) = (seen.coherent(cos, 700.0), Some(&self.polar));
        let tint = Tint::Coherent { index, rough: seen, cos };
        lobes.push(Lobe { kernel: &BACK, tint, factor: 1.0, odds: kept, polar });
        let odds = if rough.sigma_nm > 0.0 { (1.0 - seen.coherent(cos, 400.0)).max(1e-3) } else { 0.0 };
        let tint = Tint::Incoherent { index, rough, cosines: [1.0; 3] };
        lobes.push(Lobe { kernel: &self.lobe, tint, factor: 1.0, odds, polar });
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (n, k) = read_metal(r)?;
    let index = r.ink(Ink::Index { n, k });
    let mut length = |key: &'static str, low: f64| {
        let number = r.keys.number(key, &format!("must lie in {low} to 1e6"), |x| (low..=1e6).contains(&x))?;
        number.map(|x| x as f32).ok_or_else(|| r.keys.wrong(&format!("key '{key}' is missing")))
    };
    let (sigma_nm, tau_nm) = (length("sigma_nm", 0.0)?, length("tau_nm", 1.0)?);
    if sigma_nm > tau_nm {
        return Err(r
            .keys
            .wrong("sigma_nm must not be above tau_nm: slopes that steep are no surface for this theory"));
    }
    let polar = Polar::Index { index, eta: 1.0, front: true, through: false };
    let lobe = Incoherent::new(Rough { sigma_nm, tau_nm });
    Ok(Arc::new(WaveRough { index, lobe, polar, two_sided: r.two_sided()? }))
}
