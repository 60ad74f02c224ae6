//! `type = "fluorescent"`: a matt surface that gives light off at longer wavelengths than it took in. `matrix`, a CSV file with
//! a measured (Donaldson) matrix in equal bands, rows out, columns in, reflectance on its diagonal; or `reflectance` with the
//! `absorption` of a dye (the share it takes in), its `emission` (photons, any unit) and its `quantum_yield` (1).
//!
//! No photon gains energy, and no more come out than went in; what would is refused. Light is taken in from 300 nm on.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::diffuse::Diffuse;
use crate::material::kernel::lambert::Lambert;
use crate::material::read::{Paint, Reader};
use crate::material::{Base, Ink, Lobe, Lobes, Material, Site, Tint};
use crate::optics::reradiation::Reradiation;
use crate::spectral::Spectrum;

static UP: Lambert = Lambert { through: false };

/// A fluorescent Lambertian surface.
pub struct Fluorescent {
    ink: u32,
    two_sided: bool,
}

impl Material for Fluorescent {
    fn lobes<'a>(&'a self, site: &Site, _: Vec3A, lobes: &mut Lobes<'a>) {
        if let Some(lobe) = self.only(site) {
            lobes.push(lobe);
        }
    }

    fn only(&self, site: &Site) -> Option<Lobe<'_>> {
        let lit = site.front || self.two_sided;
        lit.then_some(Lobe { kernel: &UP, tint: Tint::Fluorescent(self.ink), factor: 1.0, odds: 1.0, polar: None })
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (reflectance, dye) = match r.keys.get_spanned::<String>("matrix")? {
        Some((file, span)) => {
            let text = crate::files::read_to_string(r.folder.join(&file));
            let text = text.map_err(|e| r.keys.wrong_key("matrix", span.clone(), &format!("cannot read it: {e}")))?;
            Reradiation::from_csv(&text).map_err(|e| r.keys.wrong_key("matrix", span, &e.to_string()))?
        }
        None => {
            let mut part = |key: &'static str| Ok::<_, crate::Error>(r.spectrum(key)?.map(|s| s.0));
            let (reflectance, absorption) = (part("reflectance")?, part("absorption")?);
            let (emission, quantum_yield) = (part("emission")?, part("quantum_yield")?);
            let (Some(reflectance), Some(absorption), Some(emission)) = (reflectance, absorption, emission) else {
                return Err(r.keys.wrong("give matrix, or reflectance, absorption and emission"));
            };
            if reflectance.range().0 < 0.0 || reflectance.range().1 > 1.0 {
                return Err(r.keys.wrong("reflectance must lie in 0 to 1"));
            }
            let quantum_yield = quantum_yield.unwrap_or(Spectrum::Constant(1.0));
            let dye = Reradiation::dye(&reflectance, &absorption, &emission, &quantum_yield);
            (reflectance, dye.map_err(|e| r.keys.wrong(&e.to_string()))?)
        }
    };
    if r.without.fluorescence {
        let paint = Paint::Plain(Base::Ink(r.ink(Ink::Reflectance(reflectance))));
        return Ok(Arc::new(Diffuse { paint, two_sided: r.two_sided()? }));
    }
    let ink = r.ink(Ink::Reradiation { reflectance, dye: Arc::new(dye) });
    Ok(Arc::new(Fluorescent { ink, two_sided: r.two_sided()? }))
}
