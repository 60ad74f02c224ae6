//! Materials as scene files write them. One line a kind in [`KINDS`]; a material's keys are read in its own file.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use crate::error::printable;
use crate::keys::Keys;
use crate::material::texture::Texture;
use crate::material::{Base, Ink, Material, Site};
use crate::material::{
    boundary, coated, conductor, dielectric, diffuse, film, fluorescent, glass, grating, mirror, mixture,
};
use crate::material::{radiance, sheet, subsurface, translucent, wavy};
use crate::spectral::Spectrum;
use crate::spectral::key::SpectrumKey;
use crate::{Error, Result};

/// Reads one kind of material from its table.
pub type Read = fn(&mut Reader) -> Result<Arc<dyn Material>>;

/// All kinds of material, by the word after `type`.
pub const KINDS: &[(&str, Read)] = &[
    ("diffuse", diffuse::read),
    ("conductor", conductor::read),
    ("coated", coated::read),
    ("mirror", mirror::read),
    ("glass", glass::read),
    ("dielectric", dielectric::read),
    ("film", film::read),
    ("grating", grating::read),
    ("wave_rough", wavy::read),
    ("boundary", boundary::read),
    ("fluorescent", fluorescent::read),
    ("translucent", translucent::read),
    ("subsurface", subsurface::read),
    ("polarizer", sheet::read_polarizer),
    ("retarder", sheet::read_retarder),
    ("plastic", radiance::read_plastic),
    ("metal", radiance::read_metal),
    ("trans", radiance::read_trans),
    ("mixture", mixture::read),
];

/// What a body absorbs by a key of its own: a medium without a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interior {
    /// Number of the absorption coefficient, 1/m.
    pub absorption: u32,
}

/// The media that bodies may be filled with.
#[derive(Clone, Debug, Default)]
pub struct Interiors {
    /// Names of those of the scene file: numbers 0, 1, ...
    pub names: Vec<String>,
    /// Reduced scattering and absorption coefficients of each, 1/m.
    pub reduced: Vec<[Spectrum; 2]>,
    /// What bodies absorb by keys of their own: the numbers after those.
    pub bodies: Vec<Interior>,
}

impl Interiors {
    /// Number of the medium that a key names, if it is there.
    pub fn named(&self, keys: &mut Keys, key: &'static str) -> Result<Option<u32>> {
        let Some((name, span)) = keys.get_spanned::<String>(key)? else { return Ok(None) };
        let known = self.names.iter().position(|n| *n == name).map(|i| i as u32);
        let unknown = || {
            let shown = printable(name.as_bytes());
            keys.wrong_key(key, span, &format!("no medium '{shown}'; there are {}", self.names.join(", ")))
        };
        known.ok_or_else(unknown).map(Some)
    }
}

/// A material with its name.
pub type Named = (String, Arc<dyn Material>);

/// What materials of a scene share while they are read.
pub struct Reader<'k, 'a> {
    /// The material's table.
    pub keys: &'k mut Keys<'a>,
    /// Where files lie.
    pub folder: &'k Path,
    /// Metres in one of the scene's lengths.
    pub metres: f64,
    /// Spectra of all materials so far.
    pub inks: &'k mut Vec<Ink>,
    /// What bodies may be filled with.
    pub interiors: &'k mut Interiors,
    /// Materials read before this one.
    pub before: &'k [Named],
    /// Effects that materials are read without.
    pub without: Without,
}

/// Effects that a scene is read without: what a plan found that it does not need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Without {
    /// Light is its amount alone.
    pub polarization: bool,
    /// Fluorescent surfaces keep what they reflect.
    pub fluorescence: bool,
    /// Bodies have the index that they have at 555 nm.
    pub dispersion: bool,
}

impl Without {
    /// Those of both.
    pub fn or(self, o: Without) -> Without {
        Without {
            polarization: self.polarization || o.polarization,
            fluorescence: self.fluorescence || o.fluorescence,
            dispersion: self.dispersion || o.dispersion,
        }
    }
}

/// A surface's colour: a spectrum, or a texture of them.
#[derive(Clone)]
pub enum Paint {
    /// The same everywhere.
    Plain(Base),
    /// A function of the place.
    Texture(Arc<Texture>),
    /// The mesh's own colours; white without.
    Vertex,
}

impl Paint {
    /// The colour at a site.
    #[inline]
    pub fn at(&self, site: &Site) -> Base {
        match self {
            Paint::Plain(base) => *base,
            Paint::Texture(t) => Base::Rgb(t.at(site.uv.map(f64::from), site.place)),
            Paint::Vertex => Base::Rgb(site.colour.unwrap_or([1.0; 3])),
        }
    }

    /// Needs to know where.
    pub fn varies(&self) -> bool {
        !matches!(self, Paint::Plain(_))
    }
}

impl Reader<'_, '_> {
    /// A spectrum and its place.
    pub fn spectrum(&mut self, key: &'static str) -> Result<Option<(Spectrum, Range<usize>)>> {
        spectrum(self.keys, key, self.folder)
    }

    /// Registers a spectrum.
    pub fn ink(&mut self, ink: Ink) -> u32 {
        number(self.inks, ink)
    }

    /// `interior`: number of the medium that fills the body behind the front.
    pub fn interior(&mut self) -> Result<Option<u32>> {
        self.interiors.named(self.keys, "interior")
    }

    /// Number of the medium that only absorbs, by a coefficient's number.
    pub fn absorbing(&mut self, absorption: u32) -> u32 {
        let Interiors { names, bodies, .. } = &mut *self.interiors;
        names.len() as u32 + number(bodies, Interior { absorption })
    }

    /// A reflectance in 0..1 that must be there: `reflectance`, or `texture` in its place.
    pub fn paint(&mut self) -> Result<Paint> {
        let plain = self.reflectance("reflectance")?;
        match (plain, self.texture()?) {
            (Some(base), None) => Ok(Paint::Plain(base)),
            (None, Some(texture)) => Ok(texture),
            (None, None) => Err(self.keys.wrong("key 'reflectance' is missing (or 'texture')")),
            (Some(_), Some(_)) => Err(self.keys.wrong("give reflectance or texture, not both")),
        }
    }

    /// A spectrum within 0..1.
    pub fn reflectance(&mut self, key: &'static str) -> Result<Option<Base>> {
        let Some((reflectance, span)) = self.spectrum(key)? else { return Ok(None) };
        let (low, high) = reflectance.range();
        if low < 0.0 || high > 1.0 {
            return Err(self.keys.wrong_key(key, span, &format!("runs from {low} to {high}; it must lie in 0 to 1")));
        }
        Ok(Some(self.base(reflectance)))
    }

    /// A reflectance as surfaces refer to it.
    pub fn base(&mut self, reflectance: Spectrum) -> Base {
        match reflectance {
            Spectrum::Constant(r) => Base::Grey(r as f32),
            table => Base::Ink(self.ink(Ink::Reflectance(table))),
        }
    }

    /// `texture = "vertex"`, or a table of [`crate::material::texture`].
    fn texture(&mut self) -> Result<Option<Paint>> {
        if let Some(word) = self.keys.peek::<String>("texture") {
            let (_, span) = self.keys.get_spanned::<String>("texture")?.unwrap_or_default();
            let wrong = || self.keys.wrong_key("texture", span, "expected \"vertex\" or a table");
            return if word == "vertex" { Ok(Some(Paint::Vertex)) } else { Err(wrong()) };
        }
        let Some(table) = self.keys.table("texture")? else { return Ok(None) };
        Ok(Some(Paint::Texture(Arc::new(Texture::read(table, self.folder, self.metres)?))))
    }

    /// A number within bounds, or its default.
    pub fn within(&mut self, key: &'static str, bounds: (f64, f64), default: f64) -> Result<f32> {
        let right = format!("must lie in {} to {}", bounds.0, bounds.1);
        let number = self.keys.number(key, &right, |x| (bounds.0..=bounds.1).contains(&x))?;
        Ok(number.unwrap_or(default) as f32)
    }

    /// Both sides of the surface are alike, which is the default.
    pub fn two_sided(&mut self) -> Result<bool> {
        Ok(self.keys.get("two_sided")?.unwrap_or(true))
    }
}

/// Number of one among others, to which it is added where it is new.
pub fn number<T: PartialEq>(list: &mut Vec<T>, one: T) -> u32 {
    let known = list.iter().position(|l| *l == one);
    known.unwrap_or_else(|| {
        list.push(one);
        list.len() - 1
    }) as u32
}

/// The spectrum of a key, with its place.
pub fn spectrum(k: &mut Keys, key: &'static str, folder: &Path) -> Result<Option<(Spectrum, Range<usize>)>> {
    match k.get_spanned::<SpectrumKey>(key)? {
        None => Ok(None),
        Some((s, span)) => match s.resolve(folder) {
            Ok(s) => Ok(Some((s, span))),
            Err(e) => Err(k.wrong_key(key, span, &e.to_string())),
        },
    }
}

/// Reads the tables `[materials.NAME]`; mixtures after what they are made of.
pub fn read_all(
    tables: Vec<(String, Keys)>,
    folder: &Path,
    metres: f64,
    inks: &mut Vec<Ink>,
    interiors: &mut Interiors,
    without: Without,
) -> Result<Vec<Named>> {
    let is_mixture = |k: &Keys| k.peek::<String>("type").is_some_and(|t| t == "mixture");
    let (mixtures, plain): (Vec<_>, Vec<_>) = tables.into_iter().partition(|(_, k)| is_mixture(k));
    let plain_count = plain.len();
    let mut materials: Vec<Named> = Vec::new();
    for (name, mut keys) in plain.into_iter().chain(mixtures) {
        let read = kind(&mut keys)?;
        let material = read(&mut Reader {
            keys: &mut keys,
            folder,
            metres,
            inks,
            interiors,
            before: &materials[..plain_count.min(materials.len())],
            without,
        })?;
        keys.finish()?;
        materials.push((name, material));
    }
    materials.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(materials)
}

fn kind(keys: &mut Keys) -> Result<Read> {
    let Some((kind, span)) = keys.get_spanned::<String>("type")? else { return Ok(diffuse::read) };
    match KINDS.iter().find(|k| k.0 == kind) {
        Some((_, read)) => Ok(*read),
        None => {
            let known: Vec<&str> = KINDS.iter().map(|k| k.0).collect();
            let message = format!("no material '{}'; there are {}", printable(kind.as_bytes()), known.join(", "));
            Err(keys.wrong_key("type", span, &message))
        }
    }
}

/// Index of a material by name, for mixtures.
pub fn named(r: &Reader, name: &str) -> Result<Arc<dyn Material>, Error> {
    let found = r.before.iter().find(|m| m.0 == name).map(|m| m.1.clone());
    found
        .ok_or_else(|| r.keys.wrong(&format!("of: no material '{}' that is not a mixture", printable(name.as_bytes()))))
}
