//! `[media.NAME]`: coefficients as `absorption` and `scattering`, or `extinction` and `albedo`, spectra in 1/m (`per = "mm"`, `"cm"`:
//! in 1/mm, 1/cm); `phase` and `density` as in their files; `emission`, the spectral radiance of the medium where it is thick
//! (W/sr/m2/nm; with `luminance` in cd/m2 only its shape counts): light that comes of absorption's reverse, as flames give it off and
//! hot gas. `priority`, a whole number (0).

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use crate::Result;
use crate::keys::Keys;
use crate::material::Ink;
use crate::material::read::{Interior, number, spectrum};
use crate::medium::{Grey, Inside, Media, Medium, density, phase};
use crate::spectral::{Observer, Spectrum};
use crate::units::K_M;

/// What media of a scene share while they are read.
pub struct Context<'c> {
    /// Where files lie.
    pub folder: &'c Path,
    /// Metres in one of the scene's lengths.
    pub metres: f64,
    /// Spectra of all materials and media so far.
    pub inks: &'c mut Vec<Ink>,
    /// Source functions of media that give off light; a medium's [`Medium::glow`] is its number among them.
    pub glows: &'c mut Vec<(String, Spectrum)>,
}

/// Reads the tables.
pub fn read_all(tables: Vec<(String, Keys)>, context: &mut Context) -> Result<Vec<Medium>> {
    tables.into_iter().map(|(name, keys)| read(name, keys, context)).collect()
}

/// A coefficient within bounds, as it is without end.
fn coefficient(k: &mut Keys, key: &'static str, most: f64, folder: &Path) -> Result<Option<(Spectrum, Range<usize>)>> {
    let Some((s, span)) = spectrum(k, key, folder)? else { return Ok(None) };
    let (low, high) = s.range();
    if low < 0.0 || high > most {
        return Err(k.wrong_key(key, span, &format!("runs from {low} to {high}; it must lie in 0 to {most}")));
    }
    Ok(Some((s.extended(), span)))
}

/// Absorption and scattering in the file's unit.
fn coefficients(k: &mut Keys, folder: &Path) -> Result<[Spectrum; 2]> {
    const MOST: f64 = 1e12;
    let none = || Spectrum::Constant(0.0);
    let absorption = coefficient(k, "absorption", MOST, folder)?;
    let scattering = coefficient(k, "scattering", MOST, folder)?;
    let (extinction, albedo) = (coefficient(k, "extinction", MOST, folder)?, coefficient(k, "albedo", 1.0, folder)?);
    match (absorption, scattering, extinction, albedo) {
        (None, None, Some((t, _)), albedo) => {
            let albedo = albedo.map_or_else(none, |a| a.0);
            Ok([t.combined(&albedo, |t, a| t * (1.0 - a)), t.combined(&albedo, |t, a| t * a)])
        }
        (None, None, None, _) => Err(k.wrong("give absorption and scattering, or extinction and albedo")),
        (a, s, None, None) => Ok([a, s].map(|c| c.map_or_else(none, |c| c.0))),
        _ => Err(k.wrong("give absorption and scattering, or extinction and albedo, not both")),
    }
}

fn emission(k: &mut Keys, folder: &Path) -> Result<Option<Spectrum>> {
    let luminance = k.number("luminance", "must be 0 or more", |l| (0.0..1e30).contains(&l))?;
    match (spectrum(k, "emission", folder)?, luminance) {
        (None, None) => Ok(None),
        (None, Some(_)) => Err(k.wrong("luminance goes with emission")),
        (Some((s, span)), _) if s.range().0 < 0.0 => Err(k.wrong_key("emission", span, "must not be below 0")),
        (Some((s, _)), None) => Ok(Some(s)),
        (Some((s, span)), Some(wanted)) => {
            let have = K_M * Observer::cie1931()?.integrate(&s)[1];
            if have <= 0.0 {
                return Err(k.wrong_key("emission", span, "has no visible light that luminance could scale"));
            }
            Ok(Some(s.scaled(wanted / have)))
        }
    }
}

fn read(name: String, mut k: Keys, context: &mut Context) -> Result<Medium> {
    let per_m = match k.get_spanned::<String>("per")? {
        None => 1.0,
        Some((unit, span)) => match unit.as_str() {
            "m" => 1.0,
            "cm" => 100.0,
            "mm" => 1000.0,
            "km" => 0.001,
            _ => return Err(k.wrong_key("per", span, "expected km, m, cm or mm")),
        },
    };
    let [absorption, scattering] = coefficients(&mut k, context.folder)?.map(|s| s.scaled(per_m));
    let emission = emission(&mut k, context.folder)?;
    let phase = phase::read(&mut k)?;
    let density = density::read(&mut k, context.metres, context.folder)?;
    let priority = k.get::<i32>("priority")?.unwrap_or(0);
    k.finish()?;
    let glow = emission.map(|s| {
        context.glows.push((name.clone(), s));
        context.glows.len() as u32 - 1
    });
    let grey = match (&absorption, &scattering) {
        (Spectrum::Constant(a), Spectrum::Constant(s)) => Some(Grey { absorption: *a as f32, scattering: *s as f32 }),
        _ => None,
    };
    let extinction = absorption.combined(&scattering, |a, s| a + s);
    let mut ink = |s: Spectrum| number(context.inks, Ink::Depth(s));
    Ok(Medium {
        number: 0,
        name,
        priority,
        extremes: extremes(&extinction),
        extinction: ink(extinction),
        absorption: ink(absorption),
        scattering: (scattering.range().1 > 0.0).then(|| ink(scattering)),
        glow,
        grey,
        phase,
        density,
    })
}

fn extremes(extinction: &Spectrum) -> [f32; 2] {
    let (low, high) = extinction.range();
    [low as f32, high as f32]
}

/// The media of a scene: those of its file, and what bodies absorb by keys of their own.
pub fn settle(named: Vec<Medium>, bodies: &[Interior], inks: &[Ink], everywhere: Option<u32>) -> Result<Media> {
    let absorbing = |i: &Interior| Medium {
        number: 0,
        extremes: match &inks[i.absorption as usize] {
            Ink::Depth(s) => extremes(s),
            _ => [0.0; 2],
        },
        name: "absorption".into(),
        priority: 0,
        extinction: i.absorption,
        absorption: i.absorption,
        scattering: None,
        glow: None,
        grey: None,
        phase: Arc::new(phase::isotropic::Isotropic),
        density: Arc::new(density::homogeneous::Homogeneous { density: 1.0 }),
    };
    let mut list: Vec<Medium> = named.into_iter().chain(bodies.iter().map(absorbing)).collect();
    if list.len() > Inside::MOST {
        return crate::invalid!("{} media, absorbing bodies included; at most {}", list.len(), Inside::MOST);
    }
    list.iter_mut().zip(0..).for_each(|(medium, number)| medium.number = number);
    let by_null_collisions = list.iter().any(|m| m.density.by_null_collisions());
    Ok(Media { list, everywhere, by_null_collisions })
}
