//! Scene files. docs/scenes.md is their manual; this file is their grammar.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use glam::DVec3;

use crate::keys::{self, Keys};
use crate::scene::bvh::{Geometry, Primitive, Surface};
use crate::scene::camera::{Camera, Projection};
use crate::scene::emitter::{Emitter, Shape};
use crate::scene::mesh;
use crate::scene::spectrum_key::SpectrumKey;
use crate::scene::{Frame, Light, Material, Scene};
use crate::spectral::{Observer, Spectrum, planck};
use crate::units::K_M;
use crate::{Error, Result};

/// How much light a light's key asks for, before its surfaces are known.
enum Power {
    /// The spectrum is radiance in W/sr/m2/nm, times this.
    Radiance(f64),
    /// Luminance, cd/m2.
    Luminance(f64),
    /// Luminous flux of all its surfaces, lm.
    Lumens(f64),
    /// Radiant flux of all its surfaces, W.
    Watts(f64),
}

/// A light as written.
struct LightKey {
    name: String,
    spectrum: Spectrum,
    /// The spectrum's integral over all wavelengths, W/sr/m2 where it is radiance; `None` where it has no end.
    total: Option<f64>,
    power: Power,
    span_error: Error,
    unused: Error,
}

/// Everything that grows while shapes are read.
#[derive(Default)]
struct Shapes {
    /// In metres.
    solids: Vec<Solid>,
    surfaces: Vec<Surface>,
    /// In metres.
    emitters: Vec<Emitter>,
}

/// A surface in metres, before it gets the geometry's numbers.
enum Solid {
    Triangle([DVec3; 3]),
    Sphere { center: DVec3, radius: f64, inward: bool },
}

impl Solid {
    fn middle(&self) -> DVec3 {
        match self {
            Solid::Triangle([a, b, c]) => (*a + *b + *c) / 3.0,
            Solid::Sphere { center, .. } => *center,
        }
    }

    /// Largest distance of its surface from a point.
    fn reach(&self, from: DVec3) -> f64 {
        match self {
            Solid::Triangle(t) => t.iter().map(|p| p.distance(from)).fold(0.0, f64::max),
            Solid::Sphere { center, radius, .. } => center.distance(from) + radius,
        }
    }

    fn placed(&self, frame: &Frame) -> Primitive {
        match self {
            Solid::Triangle(t) => Primitive::Triangle(t.map(|p| frame.place(p).as_vec3a())),
            Solid::Sphere { center, radius, inward } => Primitive::Sphere {
                center: frame.place(*center).as_vec3a(),
                radius: (radius * frame.scale) as f32,
                inward: *inward,
            },
        }
    }
}

/// The frame about the middle of most surfaces, on the scale of half of them: a far sun or a wide ground plane does not
/// rob the rest of its digits.
fn frame(solids: &[Solid]) -> Frame {
    let median = |mut values: Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    if solids.is_empty() {
        return Frame { centre: DVec3::ZERO, scale: 1.0 };
    }
    let axis = |f: fn(DVec3) -> f64| median(solids.iter().map(|s| f(s.middle())).collect());
    let centre = DVec3::new(axis(|p| p.x), axis(|p| p.y), axis(|p| p.z));
    let reach = median(solids.iter().map(|s| s.reach(centre)).collect());
    Frame { centre, scale: if reach > 0.0 { 1.0 / reach } else { 1.0 } }
}

fn placed_emitter(e: &Emitter, frame: &Frame) -> Emitter {
    let shape = match &e.shape {
        Shape::Rectangle { corner, u, v } => {
            Shape::Rectangle { corner: frame.place(*corner), u: *u * frame.scale, v: *v * frame.scale }
        }
        Shape::Triangle(t) => Shape::Triangle(t.map(|p| frame.place(p))),
        Shape::Sphere { center, radius, inward } => {
            Shape::Sphere { center: frame.place(*center), radius: radius * frame.scale, inward: *inward }
        }
    };
    Emitter { light: e.light, shape }
}

/// Reads a scene file.
pub fn load(path: &Path) -> Result<Scene> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    parse(&text, folder).map_err(|e| e.in_file(path))
}

/// Reads a scene's text; files it names lie in `folder`.
pub fn parse(text: &str, folder: &Path) -> Result<Scene> {
    let mut keys = keys::parse(text)?;
    let metres = unit(&mut keys)?;
    let camera = keys.table("camera")?.ok_or_else(|| Error::Invalid("the scene has no [camera]".into()))?;
    let camera = read_camera(camera, metres)?;
    let max_bounces = keys.number("max_bounces", "must be a whole number from 0", |x| x >= 0.0 && x.fract() == 0.0)?;
    let mut materials = Vec::new();
    for (name, table) in keys.tables("materials")? {
        materials.push(read_material(name, table, folder)?);
    }
    let mut lights = Vec::new();
    for (name, table) in keys.tables("lights")? {
        lights.push(read_light(name, table, folder)?);
    }
    let index = |names: Vec<&str>| names.into_iter().enumerate().map(|(i, n)| (n.to_string(), i)).collect();
    let named = Names {
        materials: index(materials.iter().map(|m: &Material| m.name.as_str()).collect()),
        lights: index(lights.iter().map(|l: &LightKey| l.name.as_str()).collect()),
    };
    let mut shapes = Shapes::default();
    for table in keys.array("shape")? {
        read_shape(table, metres, folder, &named, &mut shapes)?;
    }
    keys.finish()?;
    let lights =
        lights.into_iter().enumerate().map(|(i, l)| settle_light(l, i, &shapes.emitters)).collect::<Result<_>>()?;
    let frame = frame(&shapes.solids);
    let primitives = shapes.solids.iter().map(|s| s.placed(&frame)).collect();
    Ok(Scene {
        camera: camera.within(frame),
        materials,
        lights,
        geometry: Geometry::build(primitives, shapes.surfaces)?,
        emitters: shapes.emitters.iter().map(|e| placed_emitter(e, &frame)).collect(),
        frame,
        max_bounces: max_bounces.map(|b| b as u32),
    })
}

/// Indices by name.
struct Names {
    materials: BTreeMap<String, usize>,
    lights: BTreeMap<String, usize>,
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

fn point(keys: &mut Keys, key: &'static str) -> Result<DVec3> {
    let p: [f64; 3] = keys.need(key)?;
    let p = DVec3::from(p);
    let fits = p.is_finite() && p.abs().max_element() < 1e12;
    if fits { Ok(p) } else { Err(keys.wrong(&format!("{key}: a coordinate is not finite or beyond 1e12"))) }
}

fn read_camera(mut k: Keys, metres: f64) -> Result<Camera> {
    let (kind, span) = k.get_spanned::<String>("type")?.unwrap_or(("perspective".into(), 0..0));
    let origin = point(&mut k, "origin")? * metres;
    let target = point(&mut k, "target")? * metres;
    let up = point(&mut k, "up")?;
    let (projection, extent) = match kind.as_str() {
        "perspective" => (Projection::Perspective, k.need("fov_deg")?),
        "parallel" => (Projection::Parallel, k.need::<f64>("width_seen")? * metres),
        _ => return Err(k.wrong_key("type", span, "expected perspective or parallel")),
    };
    let whole = |x: f64| (1.0..=1e6).contains(&x) && x.fract() == 0.0;
    let right = "must be a whole number of pixels from 1";
    let width = k.number("width", right, whole)?.unwrap_or(512.0);
    let height = k.number("height", right, whole)?.unwrap_or(width);
    let camera = Camera::new(projection, origin, target, up, extent, (width as usize, height as usize));
    let camera = camera.map_err(|e| k.wrong(&e.to_string()))?;
    k.finish()?;
    Ok(camera)
}

/// The spectrum of a key, with its place.
pub(super) fn spectrum(k: &mut Keys, key: &'static str, folder: &Path) -> Result<Option<(Spectrum, Range<usize>)>> {
    match k.get_spanned::<SpectrumKey>(key)? {
        None => Ok(None),
        Some((s, span)) => match s.resolve(folder) {
            Ok(s) => Ok(Some((s, span))),
            Err(e) => Err(k.wrong_key(key, span, &e.to_string())),
        },
    }
}

fn read_material(name: String, mut k: Keys, folder: &Path) -> Result<Material> {
    if let Some((kind, span)) = k.get_spanned::<String>("type")?.filter(|(kind, _)| kind != "diffuse") {
        let kind = crate::error::printable(kind.as_bytes());
        return Err(k.wrong_key("type", span, &format!("no material '{kind}'; there is diffuse")));
    }
    let Some((reflectance, span)) = spectrum(&mut k, "reflectance", folder)? else {
        return Err(k.wrong("key 'reflectance' is missing"));
    };
    let (low, high) = reflectance.range();
    if low < 0.0 || high > 1.0 {
        return Err(k.wrong_key("reflectance", span, &format!("runs from {low} to {high}; it must lie in 0 to 1")));
    }
    let two_sided = k.get("two_sided")?.unwrap_or(true);
    k.finish()?;
    Ok(Material { name, reflectance, two_sided })
}

fn read_light(name: String, mut k: Keys, folder: &Path) -> Result<LightKey> {
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
    let positive = |x: f64| x > 0.0 && x < 1e30;
    let right = "must be above 0 and below 1e30";
    let given: Vec<Power> = [
        k.number("radiance", right, positive)?.map(Power::Radiance),
        k.number("luminance", right, positive)?.map(Power::Luminance),
        k.number("lumens", right, positive)?.map(Power::Lumens),
        k.number("watts", right, positive)?.map(Power::Watts),
    ]
    .into_iter()
    .flatten()
    .collect();
    let span_error = k.wrong("no visible light: its luminance cannot be set");
    let unused = k.wrong("no shape has it");
    let total = match (kelvin, &spectrum) {
        (Some(kelvin), _) => Some(planck::total_radiance(kelvin)),
        (None, Spectrum::Table(_)) => Some(spectrum.integral(0.0, f64::INFINITY)),
        (None, Spectrum::Constant(_)) => None,
    };
    match <[Power; 1]>::try_from(given) {
        Ok([Power::Watts(_)]) if total.is_none() => Err(k.wrong("watts need a spectrum that ends; this is constant")),
        Ok([power]) => {
            k.finish()?;
            Ok(LightKey { name, spectrum, total, power, span_error, unused })
        }
        Err(_) => Err(k.wrong("give one of radiance, luminance, lumens, watts")),
    }
}

/// Scales a light's spectrum to radiance in W/sr/m2/nm, now that the area of its surfaces is known.
fn settle_light(key: LightKey, index: usize, emitters: &[Emitter]) -> Result<Light> {
    let area: f64 = emitters.iter().filter(|e| e.light == index).map(Emitter::area_m2).sum();
    let luminance = K_M * Observer::cie1931()?.integrate(&key.spectrum)[1];
    let (wanted, have) = match key.power {
        Power::Radiance(factor) => (factor, 1.0),
        Power::Luminance(l) => (l, luminance),
        Power::Lumens(flux) => (flux / (PI * area), luminance),
        Power::Watts(flux) => (flux / (PI * area), key.total.unwrap_or(0.0)),
    };
    if area == 0.0 {
        return Err(key.unused);
    }
    if !(have > 0.0 && have.is_finite() && wanted.is_finite()) {
        return Err(key.span_error);
    }
    Ok(Light { name: key.name, radiance: key.spectrum.scaled(wanted / have) })
}

fn read_shape(mut k: Keys, metres: f64, folder: &Path, names: &Names, shapes: &mut Shapes) -> Result<()> {
    let Some((kind, span)) = k.get_spanned::<String>("type")? else { return Err(k.wrong("key 'type' is missing")) };
    let material = look_up(&mut k, "material", &names.materials)?;
    let material = material.ok_or_else(|| k.wrong("key 'material' is missing"))? as u32;
    let light = look_up(&mut k, "light", &names.lights)?;
    k.get::<String>("name")?;
    let mut add = Adder { shapes, material, light };
    match kind.as_str() {
        "quad" => {
            let (points, span) =
                k.get_spanned::<[[f64; 3]; 4]>("points")?.ok_or_else(|| k.wrong("key 'points' is missing"))?;
            let p = points.map(|p| DVec3::from(p) * metres);
            add.quad(p).map_err(|e| k.wrong_key("points", span, &e))?;
        }
        "box" => {
            let (a, b) = (point(&mut k, "min")? * metres, point(&mut k, "max")? * metres);
            add.cuboid(a, b).map_err(|e| k.wrong(&e))?;
        }
        "sphere" => {
            let center = point(&mut k, "center")? * metres;
            let positive = |x: f64| x > 0.0 && x < 1e9;
            let radius =
                k.number("radius", "must be above 0", positive)?.ok_or_else(|| k.wrong("key 'radius' is missing"))?;
            let inward = k.get("inward")?.unwrap_or(false);
            add.sphere(center, radius * metres, inward);
        }
        "mesh" => {
            let (file, span) = k.get_spanned::<String>("file")?.ok_or_else(|| k.wrong("key 'file' is missing"))?;
            let scale = k.number("scale", "must be above 0", |x| x > 0.0 && x < 1e9)?.unwrap_or(1.0);
            let shift = DVec3::from(k.get::<[f64; 3]>("translate")?.unwrap_or_default());
            let mesh =
                mesh::load(&folder.join(&file)).map_err(|e| k.wrong_key("file", span.clone(), &e.to_string()))?;
            let place = |corner: u32| (mesh.place(corner) * scale + shift) * metres;
            // Scans and CAD have triangles without area: nothing can be seen of them, or shine.
            let whole = mesh.triangles.iter().filter(|t| add.triangle(t.map(place)).is_ok());
            if whole.count() == 0 {
                return Err(k.wrong_key("file", span, "no face has an area"));
            }
        }
        other => {
            let other = crate::error::printable(other.as_bytes());
            return Err(k.wrong_key("type", span, &format!("no shape '{other}'; there are quad, box, sphere, mesh")));
        }
    }
    k.finish()
}

fn look_up(k: &mut Keys, key: &'static str, names: &BTreeMap<String, usize>) -> Result<Option<usize>> {
    let Some((name, span)) = k.get_spanned::<String>(key)? else { return Ok(None) };
    let known = || names.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let name_shown = crate::error::printable(name.as_bytes());
    let unknown = || k.wrong_key(key, span, &format!("no {key} '{name_shown}'; there are {}", known()));
    names.get(&name).copied().ok_or_else(unknown).map(Some)
}

/// Adds surfaces that share a material and a light.
struct Adder<'a> {
    shapes: &'a mut Shapes,
    material: u32,
    light: Option<usize>,
}

impl Adder<'_> {
    fn emitter(&mut self, shape: Shape) -> Option<u32> {
        let light = self.light?;
        self.shapes.emitters.push(Emitter { light, shape });
        Some(self.shapes.emitters.len() as u32 - 1)
    }

    fn push(&mut self, solid: Solid, emitter: Option<u32>) {
        self.shapes.solids.push(solid);
        self.shapes.surfaces.push(Surface { material: self.material, emitter });
    }

    fn triangle(&mut self, p: [DVec3; 3]) -> Result<(), String> {
        check_triangle(p)?;
        let emitter = self.emitter(Shape::Triangle(p));
        self.push(Solid::Triangle(p), emitter);
        Ok(())
    }

    /// Triangles 0 1 2 and 0 2 3; a rectangle shines as one.
    fn quad(&mut self, p: [DVec3; 4]) -> Result<(), String> {
        let (u, v) = (p[1] - p[0], p[3] - p[0]);
        let size = u.length() + v.length();
        let turn = |a: usize, b: usize, c: usize| (p[b] - p[a]).cross(p[c] - p[b]);
        let first = turn(0, 1, 2);
        if [turn(1, 2, 3), turn(2, 3, 0), turn(3, 0, 1)].iter().any(|t| t.dot(first) < 0.0) {
            return Err("the corners do not go round a convex quad".into());
        }
        let rectangle = (p[2] - (p[0] + u + v)).length() < 1e-6 * size && u.dot(v).abs() < 1e-6 * size * size;
        if !rectangle {
            return self.triangle([p[0], p[1], p[2]]).and_then(|()| self.triangle([p[0], p[2], p[3]]));
        }
        check_triangle([p[0], p[1], p[2]])?;
        let emitter = self.emitter(Shape::Rectangle { corner: p[0], u, v });
        for t in [[p[0], p[1], p[2]], [p[0], p[2], p[3]]] {
            self.push(Solid::Triangle(t), emitter);
        }
        Ok(())
    }

    fn sphere(&mut self, center: DVec3, radius: f64, inward: bool) {
        let emitter = self.emitter(Shape::Sphere { center, radius, inward });
        self.push(Solid::Sphere { center, radius, inward }, emitter);
    }

    /// Six rectangles that face outward.
    fn cuboid(&mut self, a: DVec3, b: DVec3) -> Result<(), String> {
        if !(b - a).cmpgt(DVec3::ZERO).all() {
            return Err("max must be above min in every coordinate".into());
        }
        let at = |x: usize, y: usize, z: usize| DVec3::new([a.x, b.x][x], [a.y, b.y][y], [a.z, b.z][z]);
        let faces = [
            [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
            [at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)],
            [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
            [at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)],
            [at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)],
            [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
        ];
        faces.into_iter().try_for_each(|f| self.quad(f))
    }
}

fn check_triangle(p: [DVec3; 3]) -> Result<(), String> {
    if p.iter().any(|p| !p.is_finite() || p.abs().max_element() >= 1e9) {
        return Err("a corner is not finite or beyond 1e9 m".into());
    }
    let (u, v) = (p[1] - p[0], p[2] - p[0]);
    // Thinner than floats can tell from a line.
    if u.cross(v).length() > 1e-7 * u.length() * v.length() {
        Ok(())
    } else {
        Err("three corners lie on one line".into())
    }
}
