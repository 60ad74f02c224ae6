//! Scene files. docs/scenes.md is their manual; these files are their grammar.

pub mod camera;
pub mod lights;
pub mod shapes;
mod solid;

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec3, Vec3A};

use crate::color::Uplift;
use crate::keys::{self, Keys};
use crate::material::read::{Interiors, Without};
use crate::material::{Effects, Ink, read as materials};
use crate::medium::{self, Medium};
use crate::scene::light::tree::LightTree;
use crate::scene::{Light, Scene};
use crate::spectral::Spectrum;
use crate::{Error, Result};

use shapes::Shapes;

/// Reads a scene file.
pub fn load(path: &Path) -> Result<Scene> {
    load_without(path, Without::default())
}

/// The same without some effects.
pub fn load_without(path: &Path, without: Without) -> Result<Scene> {
    let text = crate::files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    parse_without(&text, folder, without).map_err(|e| e.in_file(path))
}

/// A scene's materials without the scene.
pub struct Materials {
    /// With their names, in order.
    pub materials: Vec<materials::Named>,
    /// The spectra that they refer to.
    pub inks: Vec<Ink>,
    /// Basis of RGB colours.
    pub srgb: [Spectrum; 3],
    /// The media of the file, in order.
    pub media: Vec<Medium>,
    /// Metres in one of the file's lengths.
    pub unit_m: f64,
    /// What was noticed while they were read, a line each.
    pub remarks: Vec<String>,
}

/// Reads the materials and media of a scene file.
pub fn materials(path: &Path) -> Result<Materials> {
    let text = crate::files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let read = || {
        let (mut keys, mut inks) = (keys::parse(&text)?, Vec::new());
        let metres = unit(&mut keys)?;
        let (media, mut interiors, _) = read_media(&mut keys, folder, metres, &mut inks)?;
        let (tables, all) = (keys.tables("materials")?, Without::default());
        let materials = materials::read_all(tables, folder, metres, &mut inks, &mut interiors, all)?;
        let (srgb, remarks) = (Uplift::new()?.basis().clone(), keys.notes().take());
        Ok(Materials { materials, inks, srgb, media, unit_m: metres, remarks })
    };
    read().map_err(|e: Error| e.in_file(path))
}

/// Reads a scene's text; files it names lie in `folder`.
pub fn parse(text: &str, folder: &Path) -> Result<Scene> {
    parse_without(text, folder, Without::default())
}

/// The same without some effects.
pub fn parse_without(text: &str, folder: &Path, without: Without) -> Result<Scene> {
    let mut keys = keys::parse(text)?;
    let notes = keys.notes().clone();
    let metres = unit(&mut keys)?;
    let camera = keys.table("camera")?.map(|k| camera::read(k, metres)).transpose()?;
    let max_bounces = keys.number("max_bounces", "must be a whole number from 0", |x| x >= 0.0 && x.fract() == 0.0)?;
    let polarization = keys.get::<bool>("polarization")?;
    let mut inks = Vec::new();
    let (media, mut interiors, glows) = read_media(&mut keys, folder, metres, &mut inks)?;
    let everywhere = interiors.named(&mut keys, "medium")?;
    let tables = keys.tables("materials")?;
    let materials = materials::read_all(tables, folder, metres, &mut inks, &mut interiors, without)?;
    let effects = materials.iter().fold(Effects::default(), |e, m| e.or(m.1.effects()));
    let lights = keys.tables("lights")?.into_iter().map(|(name, k)| lights::read(name, k, metres, folder));
    let mut lights = lights.collect::<Result<Vec<_>>>()?;
    if let Some(k) = keys.table("environment")? {
        lights.push(lights::read_environment(k, folder)?);
    }
    // The sun of a night gives none.
    let night = lights.iter().any(Option::is_none);
    let lights: Vec<_> = lights.into_iter().flatten().collect();
    let index = |names: Vec<&str>| names.into_iter().enumerate().map(|(i, n)| (n.to_string(), i)).collect();
    let named = Names {
        materials: index(materials.iter().map(|m| m.0.as_str()).collect()),
        // Numbered as they stand among all lights.
        lights: lights.iter().enumerate().filter(|l| l.1.is_area()).map(|(i, l)| (l.name.clone(), i)).collect(),
    };
    let groups = shapes::read_groups(&mut keys, metres, folder, &named)?;
    let mut shapes = Shapes::default();
    for table in keys.array("shape")? {
        shapes::read(table, metres, folder, &named, &groups, &mut shapes)?;
    }
    keys.finish()?;
    let frame = shapes.frame(&groups);
    let (mut lights, lamps) = lights::settle(lights, &shapes.emitters, shapes.placed_emitters(&frame), &frame)?;
    let tree = LightTree::new(&lamps, &lights::power(&lights, &lamps, &frame)?);
    let mut media = medium::read::settle(media, &interiors.bodies, &inks, everywhere)?;
    for medium in &mut media.list {
        medium.density = medium.density.within(frame.centre, frame.scale);
        medium.glow = medium.glow.map(|i| lights.len() as u32 + i);
    }
    lights.extend(glows.into_iter().map(|(name, radiance)| Light { name, radiance }));
    let rough = shapes.is_smooth(&groups);
    if night {
        notes.add("the sun is below the horizon: it gives no light, and its sky none");
    }
    Ok(Scene {
        camera: camera.map(|c| c.within(frame)),
        clear: materials.iter().any(|m| m.1.is_clear()),
        polarised: !without.polarization
            && polarization
                .unwrap_or_else(|| effects.polarises || lamps.iter().any(|l| l.polarization(Vec3A::Z).is_some())),
        effects,
        media,
        looks_at_site: materials.iter().map(|m| rough || m.1.looks_at_site()).collect(),
        materials: materials.into_iter().map(|m| m.1).collect(),
        inks,
        srgb: Uplift::new()?.basis().clone(),
        lights,
        geometry: shapes.geometry(groups, &frame)?,
        lamps,
        tree,
        frame,
        unit_m: metres,
        remarks: notes.take(),
        max_bounces: max_bounces.map(|b| b as u32),
    })
}

/// Media as they are read, their names, and the source functions of those that give off light.
type ReadMedia = (Vec<Medium>, Interiors, Vec<(String, Spectrum)>);

/// Reads `[media.NAME]`.
fn read_media(keys: &mut Keys, folder: &Path, metres: f64, inks: &mut Vec<Ink>) -> Result<ReadMedia> {
    let mut glows = Vec::new();
    let mut context = medium::read::Context { folder, metres, inks, glows: &mut glows };
    let media = medium::read::read_all(keys.tables("media")?, &mut context)?;
    let names = media.iter().map(|m| m.name.clone()).collect();
    let reduced = media.iter().map(|m| m.reduced(inks)).collect();
    Ok((media, Interiors { names, reduced, bodies: Vec::new() }, glows))
}

/// Indices by name.
pub struct Names {
    /// Of materials.
    pub materials: BTreeMap<String, usize>,
    /// Of lights that shapes may have.
    pub lights: BTreeMap<String, usize>,
}

fn unit(keys: &mut Keys) -> Result<f64> {
    match keys.get_spanned::<String>("unit")? {
        None => Ok(1.0),
        Some((name, span)) => match name.as_str() {
            "m" => Ok(1.0),
            "cm" => Ok(0.01),
            "mm" => Ok(0.001),
            "in" => Ok(0.0254),
            "ft" => Ok(0.3048),
            _ => Err(keys.wrong_key("unit", span, "expected m, cm, mm, in or ft")),
        },
    }
}

/// A place or direction.
pub fn point(keys: &mut Keys, key: &'static str) -> Result<DVec3> {
    let p: [f64; 3] = keys.need(key)?;
    let p = DVec3::from(p);
    let fits = p.is_finite() && p.abs().max_element() < 1e12;
    if fits { Ok(p) } else { Err(keys.wrong(&format!("{key}: a coordinate is not finite or beyond 1e12"))) }
}

/// Index of the material or light that a key names.
pub fn look_up(k: &mut Keys, key: &'static str, names: &BTreeMap<String, usize>) -> Result<Option<usize>> {
    let Some((name, span)) = k.get_spanned::<String>(key)? else { return Ok(None) };
    let known = || names.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let name_shown = crate::error::printable(name.as_bytes());
    let unknown = || k.wrong_key(key, span, &format!("no {key} '{name_shown}'; there are {}", known()));
    names.get(&name).copied().ok_or_else(unknown).map(Some)
}
