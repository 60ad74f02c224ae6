//! `[lights.NAME]` and `[environment]`: spectra with an amount of light, and where it comes from.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::keys::Keys;
use crate::material::read::spectrum;
use crate::scene::light::environment::{Surround, Uniform};
use crate::scene::light::point::{Cosine, Distribution, Isotropic, Spot};
use crate::scene::light::{Emitter, Environment, Lamp, Point, Sun};
use crate::scene::load::point;
use crate::scene::{Frame, Light};
use crate::spectral::key::SpectrumKey;
use crate::spectral::{Observer, Spectrum, planck};
use crate::units::K_M;
use crate::{Error, Result};

/// How much light a light's key asks for, before its surfaces are known.
#[derive(Clone, Copy)]
enum Power {
    /// The spectrum is radiance in W/sr/m2/nm (intensity in W/sr/nm of a point), times this.
    Absolute(f64),
    /// Luminance, cd/m2.
    Luminance(f64),
    /// Luminous flux of all its surfaces, lm.
    Lumens(f64),
    /// Radiant flux of all its surfaces, W.
    Watts(f64),
    /// Luminous intensity where its distribution is 1, cd.
    Candela(f64),
    /// Illuminance of a surface that faces it, lx.
    Lux(f64),
}

const POWERS: [(&str, fn(f64) -> Power); 7] = [
    ("radiance", Power::Absolute),
    ("intensity", Power::Absolute),
    ("luminance", Power::Luminance),
    ("lumens", Power::Lumens),
    ("watts", Power::Watts),
    ("candela", Power::Candela),
    ("lux", Power::Lux),
];

/// Where a light's light comes from.
enum Place {
    /// The surfaces that name it.
    Area,
    Point {
        position: DVec3,
        distribution: Arc<dyn Distribution>,
    },
    Sun {
        direction: DVec3,
        diameter_deg: f64,
    },
    Environment(Box<dyn Surround>),
}

/// A light as written.
pub struct LightKey {
    /// Its name.
    pub name: String,
    spectra: Vec<Spectrum>,
    /// The spectrum's integral over all wavelengths, W/sr/m2 where it is radiance; `None` where it has no end.
    total: Option<f64>,
    power: Power,
    place: Place,
    span_error: Error,
    unused: Error,
}

impl LightKey {
    /// Shapes may have it.
    pub fn is_area(&self) -> bool {
        matches!(self.place, Place::Area)
    }
}

/// Reads a light.
pub fn read(name: String, mut k: Keys, metres: f64, folder: &Path) -> Result<LightKey> {
    let kind = k.get_spanned::<String>("type")?;
    let (place, powers): (Place, &[&str]) = match kind.as_ref().map(|(kind, _)| kind.as_str()) {
        None | Some("area") => (Place::Area, &["radiance", "luminance", "lumens", "watts"]),
        Some("point") => (point_place(&mut k, metres)?, &["candela", "lumens", "watts", "intensity"]),
        Some("spot") => (spot_place(&mut k, metres)?, &["candela", "lumens", "watts", "intensity"]),
        Some("sun") => (sun_place(&mut k)?, &["radiance", "luminance", "lux"]),
        Some(other) => {
            let shown = crate::error::printable(other.as_bytes());
            let span = kind.as_ref().map_or(0..0, |k| k.1.clone());
            return Err(k.wrong_key("type", span, &format!("no light '{shown}'; there are area, point, spot, sun")));
        }
    };
    finish(name, k, place, powers, folder)
}

/// Reads the environment.
pub fn read_environment(mut k: Keys, folder: &Path) -> Result<LightKey> {
    let kind = k.get_spanned::<String>("type")?;
    match kind.as_ref().map(|(kind, _)| kind.as_str()) {
        None | Some("uniform") => {
            let half = k.get::<bool>("upper_half")?.unwrap_or(false);
            let up = up_axis(&mut k)?;
            let surround = Box::new(Uniform { half: half.then_some(up) });
            finish("environment".into(), k, Place::Environment(surround), &["radiance", "luminance", "lux"], folder)
        }
        Some(other) => {
            let shown = crate::error::printable(other.as_bytes());
            let span = kind.as_ref().map_or(0..0, |k| k.1.clone());
            Err(k.wrong_key("type", span, &format!("no environment '{shown}'; there is uniform")))
        }
    }
}

fn up_axis(k: &mut Keys) -> Result<DVec3> {
    let up = DVec3::from(k.get::<[f64; 3]>("up")?.unwrap_or([0.0, 0.0, 1.0])).normalize_or_zero();
    if up == DVec3::ZERO || !up.is_finite() { Err(k.wrong("up: no direction")) } else { Ok(up) }
}

fn direction(k: &mut Keys, key: &'static str) -> Result<DVec3> {
    let d = point(k, key)?.normalize_or_zero();
    if d == DVec3::ZERO { Err(k.wrong(&format!("{key}: has no length"))) } else { Ok(d) }
}

fn point_place(k: &mut Keys, metres: f64) -> Result<Place> {
    let position = point(k, "position")? * metres;
    let right = "must be from 0";
    let power = k.number("cosine_power", right, |x| (0.0..1e6).contains(&x))?;
    let distribution: Arc<dyn Distribution> = match power {
        None => Arc::new(Isotropic),
        Some(power) => Arc::new(Cosine { axis: direction(k, "direction")?.as_vec3a(), power: power as f32 }),
    };
    Ok(Place::Point { position, distribution })
}

fn spot_place(k: &mut Keys, metres: f64) -> Result<Place> {
    let position = point(k, "position")? * metres;
    let axis = direction(k, "direction")?;
    let angle = |x: f64| x > 0.0 && x <= 360.0;
    let right = "must be above 0 and at most 360";
    let outer = k.number("field_deg", right, angle)?.ok_or_else(|| k.wrong("key 'field_deg' is missing"))?;
    let inner = k.number("beam_deg", right, |x| angle(x) && x <= outer)?.unwrap_or(outer);
    Ok(Place::Point { position, distribution: Arc::new(Spot::new(axis, inner / 2.0, outer / 2.0)) })
}

fn sun_place(k: &mut Keys) -> Result<Place> {
    let direction = direction(k, "direction")?;
    let diameter = k.number("diameter_deg", "must be above 0 and below 180", |x| x > 0.0 && x < 180.0)?;
    Ok(Place::Sun { direction, diameter_deg: diameter.unwrap_or(0.533) })
}

/// The spectrum and the amount of light.
fn finish(name: String, mut k: Keys, place: Place, powers: &[&str], folder: &Path) -> Result<LightKey> {
    let kelvin = match k.peek::<SpectrumKey>("spectrum") {
        Some(SpectrumKey::Blackbody(kelvin)) => Some(kelvin),
        _ => None,
    };
    let Some((spectrum, span)) = spectrum(&mut k, "spectrum", folder)? else {
        return Err(k.wrong("key 'spectrum' is missing"));
    };
    let (low, high) = spectrum.range();
    if low < 0.0 || high <= 0.0 {
        return Err(k.wrong_key("spectrum", span, &format!("runs from {low} to {high}; light must be positive")));
    }
    let mut given = Vec::new();
    for (key, power) in POWERS.iter().filter(|p| powers.contains(&p.0)) {
        let number = k.number(key, "must be above 0 and below 1e30", |x| x > 0.0 && x < 1e30)?;
        given.extend(number.map(power));
    }
    let span_error = k.wrong("no visible light: its luminance cannot be set");
    let unused = k.wrong("no shape has it");
    let total = match (kelvin, &spectrum) {
        (Some(kelvin), _) => Some(planck::total_radiance(kelvin)),
        (None, Spectrum::Table(_)) => Some(spectrum.integral(0.0, f64::INFINITY)),
        (None, Spectrum::Constant(_)) => None,
    };
    match given.as_slice() {
        [Power::Watts(_)] if total.is_none() => Err(k.wrong("watts need a spectrum that ends; this is constant")),
        [power] => {
            let power = *power;
            k.finish()?;
            Ok(LightKey { name, spectra: vec![spectrum], total, power, place, span_error, unused })
        }
        _ => Err(k.wrong(&format!("give one of {}", powers.join(", ")))),
    }
}

/// Solid angle or area that turns flux into the light's own unit, and solid angle that turns lux into it.
fn extents(key: &LightKey, area_m2: f64) -> (f64, f64) {
    match &key.place {
        Place::Area => (PI * area_m2, 0.0),
        Place::Point { distribution, .. } => (distribution.integral_sr(), 0.0),
        Place::Sun { direction, diameter_deg } => (0.0, Sun::new(0, *direction, *diameter_deg).projected_sr()),
        Place::Environment(_) => (0.0, PI),
    }
}

/// Scales spectra to radiance in W/sr/m2/nm (W/sr/nm for points), now that the area of surfaces is known; the lamps are the
/// placed surfaces and then the others.
pub fn settle(
    keys: Vec<LightKey>,
    surfaces: &[Emitter],
    placed: Vec<Emitter>,
    frame: &Frame,
) -> Result<(Vec<Light>, Vec<Lamp>)> {
    let mut lights = Vec::new();
    let mut lamps: Vec<Lamp> = placed.into_iter().map(Lamp::Area).collect();
    let observer = Observer::cie1931()?;
    for (i, key) in keys.into_iter().enumerate() {
        let area: f64 = surfaces.iter().filter(|e| e.light == i).map(Emitter::area_m2).sum();
        let luminance = K_M * observer.integrate(&key.spectra[0])[1];
        let (flux, lux) = extents(&key, area);
        let (wanted, have) = match key.power {
            Power::Absolute(factor) => (factor, 1.0),
            Power::Luminance(l) | Power::Candela(l) => (l, luminance),
            Power::Lumens(l) => (l / flux, luminance),
            Power::Watts(w) => (w / flux, key.total.unwrap_or(0.0)),
            Power::Lux(e) => (e / lux, luminance),
        };
        if key.is_area() && area == 0.0 {
            return Err(key.unused);
        }
        if !(have > 0.0 && have.is_finite() && wanted.is_finite()) {
            return Err(key.span_error);
        }
        let light = lights.len() as u32;
        lights.extend(key.spectra.iter().map(|s| Light { name: key.name.clone(), radiance: s.scaled(wanted / have) }));
        match key.place {
            Place::Area => {}
            Place::Point { position, distribution } => lamps.push(Lamp::Point(Point {
                light,
                place: frame.place(position).as_vec3a(),
                factor: (frame.scale * frame.scale) as f32,
                distribution,
            })),
            Place::Sun { direction, diameter_deg } => {
                lamps.push(Lamp::Sun(Sun::new(light, direction, diameter_deg)));
            }
            Place::Environment(surround) => lamps.push(Lamp::Environment(Environment { light, surround })),
        }
    }
    Ok((lights, lamps))
}

/// Luminous power of each lamp in the frame's units; equal where any is nothing.
pub fn power(lights: &[Light], lamps: &[Lamp], frame: &Frame) -> Result<Vec<f64>> {
    let observer = Observer::cie1931()?;
    // Once a light: a shining mesh has as many lamps as triangles.
    let y: Vec<f64> = lights.iter().map(|l| observer.integrate(&l.radiance)[1]).collect();
    let one = |lamp: &Lamp| match lamp {
        Lamp::Area(e) => PI * y[e.light] * e.area_m2(),
        Lamp::Point(p) => y[p.light as usize] * p.distribution.integral_sr() * frame.scale * frame.scale,
        Lamp::Sun(s) => y[s.light()] * s.solid_angle_sr(),
        Lamp::Environment(e) => {
            let parts = e.surround.integrals_sr();
            (0..e.surround.parts()).map(|i| y[e.light as usize + i] * parts[i]).sum()
        }
    };
    let power: Vec<f64> = lamps.iter().map(one).collect();
    Ok(if power.iter().all(|p| *p > 0.0) { power } else { vec![1.0; power.len()] })
}
