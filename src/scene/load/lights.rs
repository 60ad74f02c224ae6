//! `[lights.NAME]` and `[environment]`: spectra with an amount of light, and where it comes from.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use toml::value::Datetime;

use crate::color::Uplift;
use crate::keys::Keys;
use crate::material::read::spectrum;
use crate::photometry::ies::Photometry;
use crate::scene::light::angular::{About, Angular};
use crate::scene::light::distant::{Cap, Distant};
use crate::scene::light::environment::{Surround, Uniform};
use crate::scene::light::luminaire::Luminaire;
use crate::scene::light::picture::Panorama;
use crate::scene::light::point::{Distribution, Isotropic, Spot};
use crate::scene::light::polarised::Polarised;
use crate::scene::light::sky::{Axes, Clear, General};
use crate::scene::light::{Emitter, Environment, Lamp, MOST_PARTS, Point, Sun};
use crate::scene::load::point;
use crate::scene::{Frame, Light};
use crate::sky::{RadianceSky, place, sun, sun_radiance};
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
    /// Illuminance of a surface that faces it, lx; of a sky, of a horizontal one.
    Lux(f64),
    /// The spectra say it.
    Stated,
}

/// A key and what its number is.
type Amount = (&'static str, fn(f64) -> Power);

const POWERS: [Amount; 7] = [
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
    /// The surfaces that name it, all directions alike unless they are not.
    Area(Option<Arc<Angular>>),
    Point {
        position: DVec3,
        distribution: Arc<dyn Distribution>,
    },
    Sun {
        direction: DVec3,
        diameter_deg: f64,
    },
    /// With the factor that turns lux on a horizontal surface into the unit of its spectrum, sr.
    Environment(Box<dyn Surround>, f64, DVec3),
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
        matches!(self.place, Place::Area(_))
    }
}

/// Reads a light.
pub fn read(name: String, mut k: Keys, metres: f64, folder: &Path) -> Result<Option<LightKey>> {
    let kind = k.get_spanned::<String>("type")?;
    let (place, powers): (Place, &[&str]) = match kind.as_ref().map(|(kind, _)| kind.as_str()) {
        None | Some("area") => {
            (Place::Area(angular(&mut k)?.map(Arc::new)), &["radiance", "luminance", "lumens", "watts"])
        }
        Some("point") => (point_place(&mut k, metres)?, &["candela", "lumens", "watts", "intensity"]),
        Some("spot") => (spot_place(&mut k, metres)?, &["candela", "lumens", "watts", "intensity"]),
        Some("ies") => {
            let (place, candela) = ies_place(&mut k, metres, folder)?;
            return finish(name, k, (place, Some(candela)), &["candela", "lumens"], folder).map(Some);
        }
        Some("sun") => return read_sun(name, k, folder),
        Some(other) => {
            let shown = crate::error::printable(other.as_bytes());
            let span = kind.as_ref().map_or(0..0, |k| k.1.clone());
            return Err(k.wrong_key(
                "type",
                span,
                &format!("no light '{shown}'; there are area, point, spot, ies, sun"),
            ));
        }
    };
    finish(name, k, (place, None), powers, folder).map(Some)
}

/// Reads the environment.
pub fn read_environment(mut k: Keys, folder: &Path) -> Result<Option<LightKey>> {
    let kind = k.get_spanned::<String>("type")?;
    let up = up_axis(&mut k)?;
    let name = "environment".to_string();
    let powers = ["radiance", "luminance", "lux"];
    match kind.as_ref().map(|(kind, _)| kind.as_str()) {
        None | Some("uniform") => {
            let half = k.get::<bool>("upper_half")?.unwrap_or(false);
            let surround = Box::new(Uniform { half: half.then_some(up) });
            finish(name, k, (Place::Environment(surround, PI, up), None), &powers, folder).map(Some)
        }
        Some("cie") => {
            let right = "must be a whole number from 1 to 15";
            let sky = k.number("sky", right, |x| (1.0..=15.0).contains(&x) && x.fract() == 0.0)?;
            let sky = sky.ok_or_else(|| k.wrong("key 'sky' is missing"))?;
            let Some(to_sun) = to_sun(&mut k, "sun", up)? else { return Ok(None) };
            let sky = General::new(sky as u32, to_sun, up).map_err(|e| k.wrong(&e.to_string()))?;
            let lux = sky.horizontal_sr();
            let sky = polarised(&mut k, Box::new(sky), to_sun)?;
            finish(name, k, (Place::Environment(sky, lux, up), None), &powers, folder).map(Some)
        }
        Some("clear") => {
            let turbidity = k.need("turbidity")?;
            let Some(to_sun) = to_sun(&mut k, "sun", up)? else { return Ok(None) };
            let sky = Clear::new(turbidity, to_sun, up).map_err(|e| k.wrong(&e.to_string()))?;
            let (basis, sky) = (sky.basis(), polarised(&mut k, Box::new(sky), to_sun)?);
            stated(name, k, basis, Place::Environment(sky, PI, up)).map(Some)
        }
        Some("picture") => {
            let (file, span) = k.get_spanned::<String>("file")?.ok_or_else(|| k.wrong("key 'file' is missing"))?;
            let middle = k.get::<[f64; 3]>("middle")?.map_or_else(|| up.any_orthonormal_vector(), DVec3::from);
            let axes = Axes::facing(up, middle).ok_or_else(|| k.wrong("middle: must not be the direction up"))?;
            let factor = k.number("scale", "must be above 0", |x| x > 0.0 && x < 1e30)?.unwrap_or(1.0);
            let picture = Panorama::open(&folder.join(&file), axes, factor, k.notes());
            let picture = picture.map_err(|e| k.wrong_key("file", span, &e.to_string()))?;
            let basis = Uplift::new()?.lights().to_vec();
            stated(name, k, basis, Place::Environment(Box::new(picture), PI, up)).map(Some)
        }
        Some("distant") => {
            let (basis, distant) = distant(&mut k, up, folder)?;
            stated(name, k, basis, Place::Environment(Box::new(distant), PI, up)).map(Some)
        }
        Some(other) => {
            let shown = crate::error::printable(other.as_bytes());
            let span = kind.as_ref().map_or(0..0, |k| k.1.clone());
            let message = format!("no environment '{shown}'; there are uniform, cie, clear, picture, distant");
            Err(k.wrong_key("type", span, &message))
        }
    }
}

/// The parts of `type = "distant"`, and their spectra in W/sr/m2/nm.
fn distant(k: &mut Keys, up: DVec3, folder: &Path) -> Result<(Vec<Spectrum>, Distant)> {
    let observer = Observer::cie1931()?;
    let (mut spectra, mut caps) = (Vec::new(), Vec::new());
    let parts = k.array("part")?;
    if parts.is_empty() || parts.len() > MOST_PARTS {
        return Err(k.wrong(&format!("part: expected 1 to {MOST_PARTS} tables [[environment.part]]")));
    }
    for mut part in parts {
        let toward = direction(&mut part, "toward")?;
        let right = "must be above 0 and at most 360";
        let angle_deg = part.number("angle_deg", right, |x| x > 0.0 && x <= 360.0)?.unwrap_or(180.0);
        let luminance = part.number("luminance", "must be above 0 and below 1e30", |x| x > 0.0 && x < 1e30)?;
        let luminance = luminance.ok_or_else(|| part.wrong("key 'luminance' is missing"))?;
        let spectrum = spectrum(&mut part, "spectrum", folder)?;
        let (spectrum, span) = spectrum.ok_or_else(|| part.wrong("key 'spectrum' is missing"))?;
        let (low, y) = (spectrum.range().0, observer.integrate(&spectrum)[1]);
        if low < 0.0 || y <= 0.0 {
            return Err(part.wrong_key("spectrum", span, "light must be positive, and some of it visible"));
        }
        let sky = radiance_sky(&mut part)?;
        spectra.push(spectrum.scaled(luminance / (K_M * y)));
        caps.push((Cap::new(toward, angle_deg, sky), luminance));
        part.finish()?;
    }
    Ok((spectra, Distant::new(caps, up).map_err(|e| k.wrong(&e.to_string()))?))
}

/// `gensky` or `gendaylit`, the arguments of Radiance's function, with `sky_up`, where these have their zenith.
fn radiance_sky(k: &mut Keys) -> Result<Option<RadianceSky>> {
    let both =
        [("gensky", k.get_spanned::<Vec<f64>>("gensky")?), ("gendaylit", k.get_spanned::<Vec<f64>>("gendaylit")?)];
    let zenith = k.get::<[f64; 3]>("sky_up")?.unwrap_or([0.0, 0.0, 1.0]);
    let mut found = None;
    for (key, given) in both {
        let Some((numbers, span)) = given else { continue };
        let sky = if key == "gensky" { RadianceSky::gensky(&numbers) } else { RadianceSky::gendaylit(&numbers) };
        let sky = sky.and_then(|sky| sky.with_zenith(zenith)).map_err(|e| k.wrong_key(key, span, &e.to_string()))?;
        if found.replace(sky).is_some() {
            return Err(k.wrong("give gensky or gendaylit, not both"));
        }
    }
    Ok(found)
}

/// A sky with its polarization, where `polarization` says the most of it.
fn polarised(k: &mut Keys, sky: Box<dyn Surround>, sun: DVec3) -> Result<Box<dyn Surround>> {
    let most = k.number("polarization", "must lie in 0 to 1", |x| (0.0..=1.0).contains(&x))?;
    Ok(match most {
        Some(most) => Box::new(Polarised { sky, sun, most }),
        None => sky,
    })
}

/// A light whose spectra are absolute already.
fn stated(name: String, k: Keys, spectra: Vec<Spectrum>, place: Place) -> Result<LightKey> {
    let (span_error, unused) = (k.wrong("no light"), k.wrong("no shape has it"));
    k.finish()?;
    Ok(LightKey { name, spectra, total: None, power: Power::Stated, place, span_error, unused })
}

fn up_axis(k: &mut Keys) -> Result<DVec3> {
    let up = DVec3::from(k.get::<[f64; 3]>("up")?.unwrap_or([0.0, 0.0, 1.0])).normalize_or_zero();
    if up == DVec3::ZERO || !up.is_finite() { Err(k.wrong("up: no direction")) } else { Ok(up) }
}

fn direction(k: &mut Keys, key: &'static str) -> Result<DVec3> {
    let d = point(k, key)?.normalize_or_zero();
    if d == DVec3::ZERO { Err(k.wrong(&format!("{key}: has no length"))) } else { Ok(d) }
}

/// The direction to the sun: given, or by `{ date, latitude, longitude, north }`. `None` while it is below the horizon by date: then
/// neither it nor its sky gives light.
fn to_sun(k: &mut Keys, key: &'static str, up: DVec3) -> Result<Option<DVec3>> {
    if !matches!(k.peek::<toml::Value>(key), Some(toml::Value::Table(_))) {
        return direction(k, key).map(Some);
    }
    let Some(mut at) = k.table(key)? else { return Ok(None) };
    let time: Datetime = at.need("date")?;
    let (latitude, longitude): (f64, f64) = (at.need("latitude")?, at.need("longitude")?);
    let north = match at.get::<[f64; 3]>("north")? {
        Some(north) => DVec3::from(north),
        None if up == DVec3::Z => DVec3::Y,
        None => return Err(at.wrong("key 'north' is missing: a direction, since up is not z")),
    };
    let north = (north - up * north.dot(up)).normalize_or_zero();
    if north == DVec3::ZERO || !north.is_finite() {
        return Err(at.wrong("north: must not be the direction up"));
    }
    let [east_part, north_part, up_part] =
        place::to_sun(&time, latitude, longitude).map_err(|e| at.wrong(&e.to_string()))?;
    at.finish()?;
    let sun = north.cross(up) * east_part + north * north_part + up * up_part;
    Ok((up_part >= 0.0).then_some(sun))
}

fn point_place(k: &mut Keys, metres: f64) -> Result<Place> {
    let position = point(k, "position")? * metres;
    let distribution: Arc<dyn Distribution> = match angular(k)? {
        None => Arc::new(Isotropic),
        Some(angular) => Arc::new(About { axis: direction(k, "direction")?.as_vec3a(), angular }),
    };
    Ok(Place::Point { position, distribution })
}

/// `cosine_power`, or `angles`, a table of degrees and factors.
fn angular(k: &mut Keys) -> Result<Option<Angular>> {
    let power = k.number("cosine_power", "must be from 0", |x| (0.0..1e6).contains(&x))?;
    let table = k.get_spanned::<Vec<[f64; 2]>>("angles")?;
    match (power, table) {
        (None, None) => Ok(None),
        (Some(power), None) => Ok(Some(Angular::Cosine(power as f32))),
        (None, Some((points, span))) => match Angular::table(&points) {
            None => Err(k.wrong_key(
                "angles",
                span,
                "expected [degrees, factor] from 0 upwards to at most 180, one factor above 0",
            )),
            some => Ok(some),
        },
        (Some(_), Some(_)) => Err(k.wrong("give cosine_power or angles, not both")),
    }
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

/// Where a luminaire's horizontal angle 0 points unless given: +x for one that hangs, turned with its nadir for others.
fn turned_x(down: DVec3) -> DVec3 {
    let down = down.normalize_or(-DVec3::Z);
    if down.z > 0.999_999 { DVec3::X } else { DQuat::from_rotation_arc(-DVec3::Z, down) * DVec3::X }
}

/// The luminaire, and the intensity that its file states.
fn ies_place(k: &mut Keys, metres: f64, folder: &Path) -> Result<(Place, Power)> {
    let (file, span) = k.get_spanned::<String>("file")?.ok_or_else(|| k.wrong("key 'file' is missing"))?;
    let wrong = |message: &str| k.wrong_key("file", span.clone(), message);
    let bytes = crate::files::read(folder.join(&file)).map_err(|e| wrong(&format!("cannot read it: {e}")))?;
    let photometry = Photometry::parse(&bytes).map_err(|e| wrong(&e.to_string()))?;
    if photometry.peak() <= 0.0 {
        return Err(wrong("gives no light"));
    }
    let position = point(k, "position")? * metres;
    let down = if k.peek::<toml::Value>("direction").is_some() { direction(k, "direction")? } else { -DVec3::Z };
    let c0 = k.get::<[f64; 3]>("c0")?.map_or_else(|| turned_x(down), DVec3::from);
    let luminaire = Luminaire::new(photometry, down, c0);
    let luminaire = luminaire.ok_or_else(|| k.wrong("c0: must not be parallel to direction"))?;
    let peak = Power::Candela(luminaire.peak_cd());
    Ok((Place::Point { position, distribution: Arc::new(luminaire) }, peak))
}

/// The sun: behind a clear atmosphere (`turbidity`), or with a spectrum and an amount of its own.
fn read_sun(name: String, mut k: Keys, folder: &Path) -> Result<Option<LightKey>> {
    let up = up_axis(&mut k)?;
    let Some(direction) = to_sun(&mut k, "direction", up)? else { return Ok(None) };
    let diameter = k.number("diameter_deg", "must be above 0 and below 180", |x| x > 0.0 && x < 180.0)?;
    let place = Place::Sun { direction, diameter_deg: diameter.unwrap_or(sun::DIAMETER_DEG) };
    match k.get::<f64>("turbidity")? {
        None => finish(name, k, (place, None), &["radiance", "luminance", "lux"], folder).map(Some),
        Some(turbidity) => {
            let elevation = direction.dot(up).asin().to_degrees();
            let spectrum = sun_radiance(elevation, turbidity).map_err(|e| k.wrong(&e.to_string()))?;
            stated(name, k, vec![spectrum], place).map(Some)
        }
    }
}

/// The spectrum and the amount of light.
fn finish(
    name: String,
    mut k: Keys,
    (place, default): (Place, Option<Power>),
    powers: &[&str],
    folder: &Path,
) -> Result<LightKey> {
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
    if given.is_empty() {
        given.extend(default);
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
        Place::Area(angular) => (angular.as_ref().map_or(PI, |a| a.integral_sr(true)) * area_m2, 0.0),
        Place::Point { distribution, .. } => (distribution.integral_sr(), 0.0),
        Place::Sun { diameter_deg, .. } => (0.0, PI * (diameter_deg / 2.0).to_radians().sin().powi(2)),
        Place::Environment(_, horizontal_sr, _) => (0.0, *horizontal_sr),
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
    let directed = |mut emitter: Emitter| {
        if let Place::Area(angular) = &keys[emitter.light].place {
            emitter.angular = angular.clone();
        }
        Lamp::Area(emitter)
    };
    let mut lamps: Vec<Lamp> = placed.into_iter().map(directed).collect();
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
            Power::Stated => (1.0, 1.0),
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
            Place::Area(_) => {}
            Place::Point { position, distribution } => lamps.push(Lamp::Point(Point {
                light,
                place: frame.place(position).as_vec3a(),
                factor: (frame.scale * frame.scale) as f32,
                distribution,
            })),
            Place::Sun { direction, diameter_deg } => {
                lamps.push(Lamp::Sun(Sun::new(light, direction, diameter_deg)?));
            }
            Place::Environment(surround, _, up) => lamps.push(Lamp::Environment(Environment { light, surround, up })),
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
        Lamp::Area(e) => e.etendue_sr() * y[e.light] * e.area_m2(),
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
