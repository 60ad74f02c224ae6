//! `type = "conductor"`: a metal from its measured complex index. `metal = "Au"` (Ag, Al, Au, Cu) or spectra `n` and `k`;
//! `roughness` 0..1, the alpha of GGX; below 1e-3 the surface is smooth.
//! Beyond its table a metal's index goes on as it ended.
//!
//! A rough metal reflects light more than once in its pits; what one reflection loses comes back by [Kulla 2017], so a
//! lossless metal reflects everything at every roughness.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::albedo::Albedo;
use crate::material::kernel::complement::Complement;
use crate::material::kernel::ggx::Ggx;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Ink, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::fresnel;
use crate::spectral::{Spectrum, builtin};

/// GGX with a smaller alpha is a mirror: its highlight is narrower than f32 directions can aim.
pub const SMOOTH: f32 = 1e-3;

static BACK: Specular = Specular::Mirror;

/// A metal.
pub struct Conductor {
    index: u32,
    mean: u32,
    rough: Option<(Ggx, Complement)>,
    polar: Polar,
    two_sided: bool,
}

impl Conductor {
    /// `index` is the number of the metal's index, `mean` that of its mean reflectance.
    pub fn new(index: u32, mean: u32, alpha: f32, two_sided: bool) -> Conductor {
        let rough = (alpha >= SMOOTH).then(|| {
            let ggx = Ggx { alpha, eta: None };
            (ggx, Complement::new(Albedo::of(&ggx)))
        });
        let polar = Polar::Index { index, eta: 1.0, front: true, through: false };
        Conductor { index, mean, rough, polar, two_sided }
    }
}

impl Material for Conductor {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        if !(site.front || self.two_sided) {
            return;
        }
        let polar = Some(&self.polar);
        let metal = Tint::Metal { index: self.index, cos_half: 1.0 };
        let Some((ggx, rest)) = &self.rough else {
            lobes.push(Lobe { kernel: &BACK, tint: metal, factor: 1.0, odds: 1.0, polar });
            return;
        };
        let albedo = rest.albedo.at(out.z);
        lobes.push(Lobe { kernel: ggx, tint: metal, factor: 1.0, odds: albedo, polar });
        let tint = Tint::Repeated { mean: self.mean, albedo: rest.albedo.mean() };
        lobes.push(Lobe { kernel: rest, tint, factor: 1.0, odds: (1.0 - albedo).max(1e-3), polar: None });
    }
}

/// A metal's index: `metal`, or `n` and `k`; beyond the tables it goes on as it ended.
pub fn read_metal(r: &mut Reader) -> Result<(Spectrum, Spectrum)> {
    let metal = r.keys.get_spanned::<String>("metal")?;
    let (n, k) = match (metal, r.spectrum("n")?, r.spectrum("k")?) {
        (Some((name, span)), None, None) => {
            let table = |part: &str| builtin::spectrum(&format!("{name}_{part}"));
            match (table("n"), table("k")) {
                (Ok(n), Ok(k)) => (n, k),
                _ => return Err(r.keys.wrong_key("metal", span, "expected Ag, Al, Au or Cu, or spectra n and k")),
            }
        }
        (None, Some((n, _)), Some((k, _))) => (n, k),
        _ => return Err(r.keys.wrong("give metal, or spectra n and k")),
    };
    if n.range().0 < 0.0 || k.range().0 < 0.0 {
        return Err(r.keys.wrong("n and k must not be below 0"));
    }
    Ok((n.extended(), k.extended()))
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (n, k) = read_metal(r)?;
    let mean = mean_reflectance(&n, &k)?;
    let roughness = r.within("roughness", (0.0, 1.0), 0.0)?;
    let index = r.ink(Ink::Index { n, k });
    let mean = r.ink(Ink::Reflectance(mean));
    Ok(Arc::new(Conductor::new(index, mean, roughness, r.two_sided()?)))
}

/// 2 x integral of F cos over the cosine, at each wavelength of both tables.
fn mean_reflectance(n: &Spectrum, k: &Spectrum) -> Result<Spectrum> {
    let mean = |nm: f64| {
        let albedo = Albedo::from_fn(|cos| fresnel::conductor(cos, n.at(nm) as f32, k.at(nm) as f32));
        f64::from(albedo.mean()).min(1.0)
    };
    let mut nodes: Vec<f64> = crate::spectral::spectrum::breaks(&[n, k], 1.0, 1e6);
    nodes.retain(|nm| nm.is_finite());
    if nodes.len() < 2 {
        return Ok(Spectrum::Constant(mean(550.0)));
    }
    Spectrum::from_points(nodes.into_iter().map(|nm| (nm, mean(nm))).collect())
}
