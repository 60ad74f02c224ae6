//! `type = "dielectric"`: the boundary of a clear body, light is thrown back and bent. `index` inside over outside (1.5), a number,
//! or a spectrum such as `"glass_BK7_n"` or `{ sellmeier = [...] }`: then wavelengths go their own ways where an eye would see it.
//! `roughness` 0..1, the alpha of GGX (0). `absorption` of the inside, 1/m, a spectrum; or `transmittance` of a `thickness`, as
//! glass makers have it; or `interior`, the name of a medium. The front is the outside.
//!
//! Radiance follows n^2: seen from inside glass of index 1.5 the sky is 2.25 times as bright, and is itself again outside. What
//! more than one reflection in a rough boundary's pits would give comes back [Kulla 2017]: nothing is lost. Light is inside where
//! it has come through a front, or meets a surface from behind; of bodies within bodies the inner one counts.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::albedo::Albedo;
use crate::material::conductor::SMOOTH;
use crate::material::kernel::bend::{Bend, Index};
use crate::material::kernel::complement::Complement;
use crate::material::kernel::ggx::Ggx;
use crate::material::kernel::ggx_through::{GgxThrough, Rest, RoughBend, rests, shares};
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Effects, Ink, Kernel, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::fresnel;
use crate::spectral::Spectrum;

static BACK: Specular = Specular::Mirror;

/// What is seen of it from one side.
struct Side {
    /// Index on the other side over that here, in the middle of the spectrum.
    eta: f32,
    on: Box<dyn Kernel>,
    polar: [Polar; 2],
    rough: Option<Pits>,
}

/// A rough boundary's reflection, and what one of them loses.
struct Pits {
    back: Ggx,
    /// Share of light that one reflection gives back.
    share: Albedo,
    /// And what one reflection loses.
    lost: Complement,
    thrown_back: f32,
    through: Rest,
}

/// A boundary.
pub struct Dielectric {
    sides: [Side; 2],
    /// Number of the index where it depends on the wavelength, and that at the spectrum's ends.
    index: Option<(u32, Index)>,
    interior: Option<u32>,
}

impl Dielectric {
    /// `index` inside over outside in the middle of the spectrum; `table` where it depends on the wavelength.
    /// `interior` is the number of the medium inside.
    pub fn new(index: f32, table: Option<(u32, Index)>, alpha: f32, interior: Option<u32>) -> Dielectric {
        let etas = [index, 1.0 / index];
        let mut pits: [Option<Pits>; 2] = [None, None];
        if alpha >= SMOOTH {
            let [front, behind] = etas.map(|eta| shares(alpha, eta));
            let (through, back) = rests([&front.1, &behind.1], index);
            for (i, (through, (share, lost))) in through.into_iter().zip([front, behind]).enumerate() {
                // With a table the reflectance is the tint's.
                let back_lobe = Ggx { alpha, eta: table.is_none().then_some(etas[i]) };
                pits[i] = Some(Pits { back: back_lobe, share, lost, thrown_back: back[i], through });
            }
        }
        let side = |i: usize, rough: Option<Pits>| {
            let (eta, front) = (etas[i], i == 0);
            let on: Box<dyn Kernel> = match (&table, &rough) {
                (None, None) => Box::new(Specular::Bent { eta }),
                (None, Some(_)) => Box::new(GgxThrough { alpha, eta }),
                (Some((_, index)), None) => Box::new(Bend { index: index.clone(), front }),
                (Some((_, index)), Some(_)) => Box::new(RoughBend { alpha, index: index.clone(), front }),
            };
            let polar = [false, true].map(|through| match &table {
                None => Polar::Boundary { eta, through },
                Some((index, _)) => Polar::Index { index: *index, eta, front, through },
            });
            Side { eta, on, polar, rough }
        };
        let [front, back] = pits;
        Dielectric { sides: [side(0, front), side(1, back)], index: table, interior }
    }

    /// Share of light thrown back, of all wavelengths about.
    fn sent(&self, side: &Side, cos: f32, front: bool) -> f32 {
        match &self.index {
            None => fresnel::dielectric(cos, side.eta).0,
            Some((_, index)) => {
                let one = |n: f32| fresnel::dielectric(cos, if front { n } else { 1.0 / n }).0;
                index.ends.iter().map(|n| one(*n)).sum::<f32>() / index.ends.len() as f32
            }
        }
    }
}

impl Material for Dielectric {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        let front = site.front;
        let side = &self.sides[usize::from(!front)];
        let [back, on] = side.polar.each_ref().map(Some);
        let Some(pits) = &side.rough else {
            let sent = self.sent(side, out.z, front);
            let (tints, factors) = match &self.index {
                None => ([Tint::None; 2], [sent, 1.0 - sent]),
                Some((index, _)) => {
                    let tint = |through| Tint::Boundary { index: *index, cos: out.z, front, through };
                    ([tint(false), tint(true)], [1.0; 2])
                }
            };
            // Where the whole spectrum is reflected nothing goes through, and nothing is asked for it.
            lobes.push(Lobe { kernel: &BACK, tint: tints[0], factor: factors[0], odds: sent, polar: back });
            lobes.push(Lobe { kernel: &*side.on, tint: tints[1], factor: factors[1], odds: 1.0 - sent, polar: on });
            return;
        };
        let (back_tint, on_tint) = match &self.index {
            None => (Tint::None, Tint::None),
            Some((index, _)) => {
                (Tint::Facet { index: *index, front, cos_half: 1.0 }, Tint::Squeezed { index: *index, front })
            }
        };
        let (all, sent) = (pits.lost.albedo.at(out.z), pits.share.at(out.z));
        let (rest, goes_on) = ((1.0 - all).max(0.0), (all - sent).max(0.01));
        lobes.push(Lobe { kernel: &pits.back, tint: back_tint, factor: 1.0, odds: sent.max(0.01), polar: back });
        lobes.push(Lobe { kernel: &*side.on, tint: on_tint, factor: 1.0, odds: goes_on, polar: on });
        let odds = rest * pits.thrown_back;
        lobes.push(Lobe { kernel: &pits.lost, tint: Tint::None, factor: pits.thrown_back, odds, polar: None });
        let odds = rest * (1.0 - pits.thrown_back);
        // The same way back at every wavelength: what is squeezed follows its own index.
        let (tint, factor) = match &self.index {
            Some((index, _)) if front => (Tint::Squeezed { index: *index, front }, side.eta * side.eta),
            _ => (Tint::None, 1.0),
        };
        lobes.push(Lobe { kernel: &pits.through, tint, factor, odds, polar: None });
    }

    fn effects(&self) -> Effects {
        Effects { disperses: self.index.is_some(), fills: self.interior.is_some(), ..Effects::default() }
    }

    fn interior(&self) -> Option<u32> {
        self.interior
    }
}

/// An index of refraction: a number, or a spectrum with its number; within 0.25 to 4 where it is seen.
pub fn read_index(r: &mut Reader, default: f64) -> Result<(f32, Option<(u32, Index)>)> {
    let Some((index, span)) = r.spectrum("index")? else { return Ok((default as f32, None)) };
    let index = index.extended();
    let (low, high) = index.range();
    if !(low >= 0.25 && high <= 4.0) {
        return Err(r.keys.wrong_key("index", span, &format!("runs from {low} to {high}; it must lie in 0.25 to 4")));
    }
    match index {
        Spectrum::Constant(n) => Ok((n as f32, None)),
        n if r.without.dispersion => Ok((n.at(555.0) as f32, None)),
        n => {
            let ink = r.ink(Ink::Index { n: n.clone(), k: Spectrum::Constant(0.0) });
            let index = Index::new(n);
            Ok((index.ends[1], Some((ink, index))))
        }
    }
}

/// `absorption`, or `transmittance` of a `thickness`.
fn read_absorption(r: &mut Reader) -> Result<Option<u32>> {
    let thickness = r.keys.number("thickness", "must be above 0", |x| x > 0.0 && x < 1e9)?;
    let depth = match (r.spectrum("absorption")?, r.spectrum("transmittance")?, thickness) {
        (None, None, None) => return Ok(None),
        (Some((a, _)), None, None) if a.range().0 >= 0.0 => a.extended(),
        (Some((_, span)), None, None) => return Err(r.keys.wrong_key("absorption", span, "must not be below 0")),
        (None, Some((t, span)), Some(thickness)) => {
            let (low, high) = t.range();
            if low <= 0.0 || high > 1.0 {
                let message = format!("runs from {low} to {high}; it must be above 0 and at most 1");
                return Err(r.keys.wrong_key("transmittance", span, &message));
            }
            let metres = thickness * r.metres;
            t.extended().map(|t| -t.ln() / metres)
        }
        _ => return Err(r.keys.wrong("give absorption (1/m), or transmittance with its thickness")),
    };
    Ok(Some(r.ink(Ink::Depth(depth))))
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (index, table) = read_index(r, 1.5)?;
    let roughness = r.within("roughness", (0.0, 1.0), 0.0)?;
    let interior = match (read_absorption(r)?, r.interior()?) {
        (Some(_), Some(_)) => return Err(r.keys.wrong("give interior, or what the body absorbs, not both")),
        (Some(absorption), None) => Some(r.absorbing(absorption)),
        (None, interior) => interior,
    };
    Ok(Arc::new(Dielectric::new(index, table, roughness, interior)))
}
