//! Radiance's materials, and the tables of the scene language that they become.
//!
//! | Radiance's | arguments | becomes |
//! |---|---|---|
//! | plastic, metal | R G B specular roughness | `plastic`, `metal` |
//! | trans | R G B specular roughness transmitted transmitted-specular | `trans` |
//! | mirror | R G B | `mirror`, black behind |
//! | glass | R G B (index 1.52) | `glass` |
//! | dielectric | R G B index Hartmann | `dielectric`: RGB is what one unit of length lets through, the index n + Hartmann / nm |
//! | light, illum, glow, spotlight | R G B ... | a light, 179 cd/m2 for 1 W/sr/m2, on a body that is black |

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write as _;

use glam::DVec3;

use crate::Result;
use crate::notes::Notes;
use crate::radiance::colour::Colours;
use crate::radiance::modifier::{Kind, Modifiers, Resolved, times};
use crate::radiance::object::Object;
use crate::radiance::write::{key, list, number, spectrum};
use crate::radiance::xform::Motion;
use crate::spectral::{Observer, Spectrum};
use crate::units::RADIANCE_EFFICACY;

/// A material as it was defined, lengths and directions moved to where it stands.
#[derive(Clone, Debug)]
pub enum Material {
    /// Any that does not shine.
    Body(Body),
    /// One that does.
    Light(Shine),
    /// One that is looked through as if it were not there.
    Invisible,
}

/// A type of the scene language, a colour and numbers.
#[derive(Clone, Debug)]
pub struct Body {
    kind: &'static str,
    /// Key of the colour, and the lowest value it may have.
    colour: (&'static str, f64),
    rgb: [f64; 3],
    /// Further lines.
    keys: String,
}

/// Radiance in W/sr/m2.
#[derive(Clone, Debug)]
pub struct Shine {
    /// Its colour and amount.
    pub rgb: [f64; 3],
    /// Whole angle in degrees and direction of a spotlight.
    pub spot: Option<(f64, DVec3)>,
    /// An illum: seen as something else in Radiance.
    pub illum: bool,
}

/// Reads a material; `None` where the type is none of these.
pub fn read(object: &Object, moved: &Motion, known: &Modifiers, notes: &Notes) -> Result<Option<Kind>> {
    let material = match object.kind.as_str() {
        "plastic" | "metal" => {
            let [r, g, b, specular, roughness] = object.exactly("R G B specular roughness")?;
            let kind = if object.kind == "metal" { "metal" } else { "plastic" };
            Material::Body(normal(object, kind, [r, g, b], &[("specular", specular), ("roughness", roughness)])?)
        }
        "trans" => {
            let [r, g, b, specular, roughness, t, ts] =
                object.exactly("R G B specular roughness transmitted transmitted-specular")?;
            let keys =
                [("specular", specular), ("roughness", roughness), ("transmitted", t), ("transmitted_specular", ts)];
            Material::Body(normal(object, "trans", [r, g, b], &keys)?)
        }
        "mirror" => match object.strings.as_slice() {
            [] => {
                let mut body = normal(object, "mirror", object.exactly("R G B")?, &[])?;
                body.keys = "two_sided = false\n".into();
                Material::Body(body)
            }
            [other] => return alternate(object, other, known).map(Some),
            _ => return Err(object.wrong("expected at most one word, the material that is seen in its place")),
        },
        "glass" => Material::Body(glass(object)?),
        "dielectric" => Material::Body(dielectric(object, moved)?),
        "light" | "illum" | "glow" | "spotlight" => Material::Light(shine(object, moved, notes)?),
        _ => return Ok(None),
    };
    Ok(Some(Kind::Material(material)))
}

fn fractions(object: &Object, what: &str, numbers: &[f64]) -> Result<()> {
    match numbers.iter().find(|x| !(0.0..=1.0).contains(*x)) {
        Some(x) => Err(object.wrong(format!("{what}: {x} must lie in 0 to 1"))),
        None => Ok(()),
    }
}

fn normal(object: &Object, kind: &'static str, rgb: [f64; 3], numbers: &[(&str, f64)]) -> Result<Body> {
    fractions(object, "RGB", &rgb)?;
    let mut keys = String::new();
    for (name, x) in numbers {
        fractions(object, name, &[*x])?;
        let _ = writeln!(keys, "{name} = {}", number(*x)); // a String takes it
    }
    Ok(Body { kind, colour: ("reflectance", 0.0), rgb, keys })
}

/// What is seen in place of a mirror, which then only relays lights: light finds its way without it here.
fn alternate(object: &Object, other: &str, known: &Modifiers) -> Result<Kind> {
    let Some(index) = known.find(other, object)? else { return Ok(Kind::Material(Material::Invisible)) };
    match known.resolve(index) {
        Resolved { material: Some(m), spectrum: None, sky: None, .. } => Ok(Kind::Material(m)),
        Resolved { unread: Some(kind), .. } => Ok(Kind::Unread(kind)),
        _ => Err(object.wrong("what is seen in its place must be a material without a pattern")),
    }
}

fn glass(object: &Object) -> Result<Body> {
    let mut keys = String::new();
    let rgb = match object.reals[..] {
        [r, g, b, index] if object.strings.is_empty() => {
            if !(1.0..=4.0).contains(&index) {
                return Err(object.wrong(format!("the index {index} must lie in 1 to 4")));
            }
            keys = format!("index = {}\n", number(index));
            [r, g, b]
        }
        _ => object.exactly("R G B, or R G B index")?,
    };
    fractions(object, "RGB", &rgb)?;
    // Nothing at all has no optical depth.
    Ok(Body { kind: "glass", colour: ("transmissivity", 1e-6), rgb, keys })
}

fn dielectric(object: &Object, moved: &Motion) -> Result<Body> {
    let [r, g, b, index, hartmann] = object.exactly("R G B index Hartmann's constant")?;
    let rgb = [r, g, b].map(|x| x.min(1.0)); // Radiance takes more for 1
    fractions(object, "RGB", &rgb)?;
    let at = |nm: f64| index + hartmann / nm;
    if [360.0, 830.0].iter().any(|nm| !(0.25..=4.0).contains(&at(*nm))) {
        return Err(object.wrong(format!("the index {index} with Hartmann's constant {hartmann} leaves 0.25 to 4")));
    }
    let text = if hartmann == 0.0 {
        number(index)
    } else {
        let points = (0..=47).map(|i| f64::from(360 + 10 * i)).map(|nm| (nm, at(nm)));
        spectrum(&Spectrum::Table(points.collect()))
    };
    let keys = format!("index = {text}\nthickness = {}\n", number(moved.scale));
    Ok(Body { kind: "dielectric", colour: ("transmittance", 1e-40), rgb, keys })
}

fn shine(object: &Object, moved: &Motion, notes: &Notes) -> Result<Shine> {
    let mut spot = None;
    let rgb = match object.kind.as_str() {
        "glow" => {
            let [r, g, b, radius] = object.exactly("R G B, largest distance")?;
            if radius < 0.0 {
                notes.add(format!(
                    "{}: it shines on nothing in Radiance (distance below 0), and on everything here",
                    object.shown()
                ));
            }
            [r, g, b]
        }
        "spotlight" => {
            let [r, g, b, angle_deg, x, y, z] = object.exactly("R G B angle x y z")?;
            let aim = moved.vector(DVec3::new(x, y, z));
            note_focus(object, aim.length(), notes);
            let aim = aim.normalize_or_zero();
            if aim == DVec3::ZERO || !(angle_deg > 0.0 && angle_deg <= 360.0) {
                return Err(
                    object.wrong("expected an angle above 0 and at most 360 degrees, and a direction with a length")
                );
            }
            spot = Some((angle_deg, aim));
            [r, g, b]
        }
        "illum" if object.strings.len() == 1 => object
            .reals
            .as_slice()
            .try_into()
            .map_err(|_| object.wrong(format!("has {} numbers; expected 3: R G B", object.reals.len())))?,
        _ => object.exactly("R G B")?,
    };
    if rgb.iter().any(|c| *c < 0.0 || *c > 1e20) {
        return Err(object.wrong("light must be from 0 to 1e20 W/sr/m2"));
    }
    Ok(Shine { rgb, spot, illum: object.kind == "illum" })
}

/// The length of a spotlight's direction puts the point that its light comes from so far behind the lamp: a distance d then counts as d +
/// that. A lamp of a radiance cannot do so.
fn note_focus(object: &Object, length: f64, notes: &Notes) {
    if length > 0.01 {
        let length = number(length);
        notes.add(format!(
            "{}: its direction is {length} long, a focus so far behind the lamp in Radiance and in the lamp here: at a distance d it is (1 + {length} / d)^2 times as bright; a short direction makes both alike",
            object.shown()
        ));
    }
}

/// What a surface is written with.
#[derive(Clone, Debug)]
pub struct Look {
    /// Name of its material.
    pub material: String,
    /// Name of its light.
    pub light: Option<String>,
    /// Whole angle and direction that its light is within.
    pub spot: Option<(f64, DVec3)>,
}

/// A spectrum and its luminance in cd/m2.
#[derive(Clone, Debug)]
pub struct Glare {
    /// Its shape.
    pub spectrum: Spectrum,
    /// Its amount; 0 for none.
    pub luminance: f64,
}

/// Materials and lights that surfaces have asked for.
pub struct Palette {
    colours: Colours,
    observer: Observer,
    white: f64,
    materials: String,
    lights: String,
    names: BTreeSet<String>,
    looks: HashMap<usize, Option<Look>>,
    black: Option<String>,
}

impl Palette {
    /// Empty.
    pub fn new() -> Result<Palette> {
        let observer = Observer::cie1931()?;
        let white = observer.integrate(&Spectrum::Constant(1.0))[1];
        let (materials, lights) = (String::new(), String::new());
        let (names, looks, black) = (BTreeSet::new(), HashMap::new(), None);
        Ok(Palette { colours: Colours::new()?, observer, white, materials, lights, names, looks, black })
    }

    /// The tables of materials.
    pub fn materials(&self) -> &str {
        &self.materials
    }

    /// The tables of lights.
    pub fn lights(&self) -> &str {
        &self.lights
    }

    /// A name that nothing has yet, like this one.
    pub fn unique(&mut self, name: &str) -> String {
        let mut tried = name.to_string();
        let mut n = 1;
        while !self.names.insert(tried.clone()) {
            n += 1;
            tried = format!("{name}.{n}");
        }
        tried
    }

    /// What surfaces with modifier number `first`, which they know as `name`, are written with; `None` where they are not seen.
    pub fn look(&mut self, first: usize, name: &str, resolved: &Resolved, surface: &Object) -> Result<Option<Look>> {
        if let Some(look) = self.looks.get(&first) {
            return Ok(look.clone());
        }
        let look = match &resolved.material {
            None | Some(Material::Invisible) => None,
            Some(Material::Body(body)) => {
                let material = self.body(name, body, resolved, surface)?;
                Some(Look { material, light: None, spot: None })
            }
            Some(Material::Light(shine)) => {
                let glare = self.glare(shine, resolved);
                let light = (glare.luminance > 0.0).then(|| self.light(name, &glare, shine));
                Some(Look { material: self.black(), light, spot: shine.spot })
            }
        };
        self.looks.insert(first, look.clone());
        Ok(look)
    }

    fn body(&mut self, name: &str, body: &Body, resolved: &Resolved, surface: &Object) -> Result<String> {
        let (colour, least) = body.colour;
        let mut values = self.colours.spectrum(body.rgb);
        if let Some(pattern) = &resolved.spectrum {
            values = times(&values, pattern);
        }
        let high = values.range().1;
        if high > 1.0 + 1e-6 {
            let shown = crate::error::printable(name.as_bytes());
            return Err(
                surface.wrong(format!("{colour} of '{shown}' with its spectrum reaches {high}; it must lie in 0 to 1"))
            );
        }
        let name = self.unique(name);
        let values = values.map(|v| v.clamp(least, 1.0));
        let _ = write!(self.materials, "\n[materials.{}]\ntype = \"{}\"\n", key(&name), body.kind); // a String takes it
        let _ = write!(self.materials, "{colour} = {}\n{}", spectrum(&values), body.keys);
        Ok(name)
    }

    /// A light's spectrum, and its amount: 179 cd/m2 for 1 W/sr/m2.
    pub fn glare(&self, shine: &Shine, resolved: &Resolved) -> Glare {
        let plain = self.colours.spectrum(shine.rgb);
        let spectrum = resolved.spectrum.as_ref().map_or(plain.clone(), |pattern| times(&plain, pattern));
        let luminance = RADIANCE_EFFICACY * self.observer.integrate(&spectrum)[1] / self.white;
        // Only its shape counts: near 1 it is easier to read.
        let high = spectrum.range().1;
        Glare { spectrum: if high > 0.0 { spectrum.scaled(1.0 / high) } else { spectrum }, luminance }
    }

    fn light(&mut self, name: &str, glare: &Glare, shine: &Shine) -> String {
        let name = self.unique(name);
        let _ = write!(self.lights, "\n[lights.{}]\n{}", key(&name), glare.keys()); // a String takes it
        if let Some((angle_deg, _)) = shine.spot.filter(|s| s.0 < 180.0) {
            let half = angle_deg / 2.0;
            let angles = [[0.0, 1.0], [half, 1.0], [half + 1e-3, 0.0]].map(list);
            let _ = writeln!(self.lights, "angles = [{}]", angles.join(", "));
        }
        name
    }

    /// What a lamp itself sends back: nothing.
    fn black(&mut self) -> String {
        if let Some(name) = &self.black {
            return name.clone();
        }
        let name = self.unique("black");
        let _ = write!(self.materials, "\n[materials.{}]\nreflectance = 0\n", key(&name)); // a String takes it
        self.black = Some(name.clone());
        name
    }
}

impl Glare {
    /// Its lines.
    pub fn keys(&self) -> String {
        format!("spectrum = {}\nluminance = {}\n", spectrum(&self.spectrum), number(self.luminance))
    }
}
