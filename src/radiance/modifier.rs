//! What primitives may be modified by, by name: materials, patterns, aliases. A name means what was last defined.

use std::collections::HashMap;
use std::path::Path;

use crate::error::printable;
use crate::radiance::Scene;
use crate::radiance::material::{self, Material};
use crate::radiance::object::{Object, VOID};
use crate::radiance::read::{Around, beside};
use crate::radiance::xform::{Motion, motion};
use crate::sky::RadianceSky;
use crate::spectral::Spectrum;
use crate::{Error, Result};

/// Patterns, textures, mixtures and materials that Radiance has and this program has not.
const PATTERNS: &[&str] = &[
    "brightfunc",
    "brightdata",
    "brighttext",
    "colorfunc",
    "colordata",
    "colorpict",
    "colortext",
    "specfunc",
    "specdata",
    "specpict",
    "texfunc",
    "texdata",
];
const MATERIALS: &[&str] = &[
    "plastic2",
    "metal2",
    "trans2",
    "ashik2",
    "interface",
    "prism1",
    "prism2",
    "mist",
    "antimatter",
    "plasfunc",
    "metfunc",
    "transfunc",
    "BRTDfunc",
    "plasdata",
    "metdata",
    "transdata",
    "BSDF",
    "aBSDF",
    "WGMDfunc",
    "mixfunc",
    "mixdata",
    "mixpict",
    "mixtext",
];

/// A sky's brightness function, in the scene's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// Key of the scene language: gensky or gendaylit.
    pub key: &'static str,
    /// Its arguments, the sun turned.
    pub numbers: Vec<f64>,
    /// Where its zenith is.
    pub zenith: [f64; 3],
}

/// What a name stands for.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Multiplies spectra.
    Spectrum(Spectrum),
    /// Multiplies the light of a source.
    Sky(Pattern),
    /// Left out: what it modifies stays plain.
    Nothing,
    /// Ends the chain.
    Material(Material),
    /// A material left out: so is what has it.
    Unread(String),
}

/// One with what modifies it in turn.
#[derive(Clone, Debug)]
struct Modifier {
    kind: Kind,
    under: Option<usize>,
}

/// All so far.
#[derive(Default)]
pub struct Modifiers {
    list: Vec<Modifier>,
    by_name: HashMap<String, usize>,
}

/// The chain of a surface's modifiers, summed up.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// Its material, with the name that a surface knows it by.
    pub material: Option<Material>,
    /// What multiplies its spectra.
    pub spectrum: Option<Spectrum>,
    /// What multiplies its light.
    pub sky: Option<Pattern>,
    /// The kind of a material that was left out.
    pub unread: Option<String>,
}

impl Modifiers {
    /// Number of a name; `None` for `void`.
    pub fn find(&self, name: &str, object: &Object) -> Result<Option<usize>> {
        if name == VOID {
            return Ok(None);
        }
        self.by_name.get(name).copied().map(Some).ok_or_else(|| self.missing(name, object))
    }

    fn missing(&self, name: &str, object: &Object) -> Error {
        let shown = printable(name.as_bytes());
        let hint = if self.by_name.is_empty() { "nothing is defined" } else { "it is not defined" };
        object.wrong(format!(
            "modifier '{shown}': {hint} before this line; expected a material or pattern from further up, or void"
        ))
    }

    fn define(&mut self, name: &str, kind: Kind, under: Option<usize>) {
        self.list.push(Modifier { kind, under });
        self.by_name.insert(name.to_string(), self.list.len() - 1);
    }

    /// `modifier alias new old`: the old one by another name, and with another modifier unless that is its own or `inherit`.
    fn alias(&mut self, object: &Object) -> Result<()> {
        let old = object.strings.first().map_or("", String::as_str);
        let Some(of) = self.find(old, object)? else {
            return Err(object.wrong("an alias of void; expected the name of a modifier from further up"));
        };
        if object.modifier == "inherit" {
            self.by_name.insert(object.name.clone(), of);
            return Ok(());
        }
        let under = self.find(&object.modifier, object)?;
        let kind = self.list[of].kind.clone();
        self.define(&object.name, kind, under);
        Ok(())
    }

    /// What a surface with modifier number `first` has.
    pub fn resolve(&self, first: usize) -> Resolved {
        let mut found = Resolved { material: None, spectrum: None, sky: None, unread: None };
        let mut next = Some(first);
        // A modifier is older than what it modifies: this ends.
        while let Some(modifier) = next.map(|i| &self.list[i]) {
            match &modifier.kind {
                Kind::Spectrum(s) => {
                    found.spectrum = Some(match found.spectrum.take() {
                        None => s.clone(),
                        Some(other) => times(&other, s),
                    });
                }
                Kind::Sky(pattern) => found.sky = Some(pattern.clone()),
                Kind::Nothing => {}
                Kind::Material(m) if found.material.is_none() && found.unread.is_none() => {
                    found.material = Some(m.clone())
                }
                Kind::Unread(kind) if found.material.is_none() && found.unread.is_none() => {
                    found.unread = Some(kind.clone())
                }
                Kind::Material(_) | Kind::Unread(_) => {}
            }
            next = modifier.under;
        }
        found
    }
}

/// The product of two spectra.
pub fn times(a: &Spectrum, b: &Spectrum) -> Spectrum {
    match (a, b) {
        (Spectrum::Constant(c), s) | (s, Spectrum::Constant(c)) => s.scaled(*c),
        _ => a.combined(b, |x, y| x * y),
    }
}

impl Scene {
    /// Takes a primitive to where it belongs.
    pub fn add(&mut self, object: Object, around: &Around, folder: &Path) -> Result<()> {
        if crate::radiance::surface::KINDS.contains(&object.kind.as_str()) {
            return self.surface(&object, around, folder);
        }
        if object.kind == "alias" {
            return self.modifiers.alias(&object);
        }
        let under = if object.modifier == "inherit" {
            return Err(object.wrong("only an alias has the modifier 'inherit'"));
        } else {
            self.modifiers.find(&object.modifier, &object)?
        };
        let kind = self.modifier(&object, &around.motion, folder)?;
        self.modifiers.define(&object.name, kind, under);
        Ok(())
    }

    fn modifier(&mut self, object: &Object, moved: &Motion, folder: &Path) -> Result<Kind> {
        if let Some(material) = material::read(object, moved, &self.modifiers, &self.notes)? {
            return Ok(material);
        }
        let kind = object.kind.as_str();
        match kind {
            "spectrum" => return Ok(Kind::Spectrum(spectrum(object)?)),
            "specfile" => return Ok(Kind::Spectrum(spectrum_file(object, folder)?)),
            "brightfunc" => {
                if let Some(pattern) = sky(object, moved)? {
                    return Ok(Kind::Sky(pattern));
                }
            }
            _ => {}
        }
        if PATTERNS.contains(&kind) {
            self.refuse(&object.place, kind, &format!("{} is a pattern or texture that is not read", object.shown()))?;
            return Ok(Kind::Nothing);
        }
        if MATERIALS.contains(&kind) {
            self.refuse(&object.place, kind, &format!("{} is a material that is not read", object.shown()))?;
            return Ok(Kind::Unread(kind.to_string()));
        }
        let message =
            "Radiance knows no such type; expected one, or the line before has more or fewer arguments than it says";
        Err(object.wrong(message))
    }
}

/// Evenly spaced values between two wavelengths, either way round.
fn spectrum(object: &Object) -> Result<Spectrum> {
    let right = "expected two wavelengths in nm and three values or more";
    let [from, to, values @ ..] = object.reals.as_slice() else { return Err(object.wrong(right)) };
    if values.len() < 3 || !object.strings.is_empty() {
        return Err(object.wrong(right));
    }
    let step = (to - from) / (values.len() - 1) as f64;
    points(object, values.iter().enumerate().map(|(i, v)| (from + step * i as f64, *v)).collect())
}

/// A data file of one dimension: `1`, then `first last number`, or `0 0 number` and the wavelengths, then the values.
fn spectrum_file(object: &Object, folder: &Path) -> Result<Spectrum> {
    let [name] = object.strings.as_slice() else {
        return Err(object.wrong("expected the name of one data file"));
    };
    let shown = printable(name.as_bytes());
    let bytes = crate::files::read(beside(folder, Path::new(name)));
    let bytes = bytes.map_err(|e| object.wrong(format!("cannot read '{shown}': {e}")))?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let lines = text.lines().filter(|l| !l.trim_start().starts_with('#'));
    let numbers: Option<Vec<f64>> = lines.flat_map(str::split_ascii_whitespace).map(|w| w.parse().ok()).collect();
    let wrong =
        || object.wrong(format!("'{shown}' is no data of one dimension; expected 1, first last number, values"));
    match numbers.as_deref() {
        Some([1.0, 0.0, 0.0, n, rest @ ..]) if rest.len() as f64 == 2.0 * n => {
            let (nm, values) = rest.split_at(rest.len() / 2);
            points(object, nm.iter().copied().zip(values.iter().copied()).collect())
        }
        Some([1.0, from, to, n, values @ ..]) if values.len() as f64 == *n && values.len() > 1 => {
            let step = (to - from) / (n - 1.0);
            points(object, values.iter().enumerate().map(|(i, v)| (from + step * i as f64, *v)).collect())
        }
        _ => Err(wrong()),
    }
}

/// Samples stand for bins in Radiance: the first and the last reach half a step further.
fn points(object: &Object, mut list: Vec<(f64, f64)>) -> Result<Spectrum> {
    if list.first().map(|p| p.0) > list.last().map(|p| p.0) {
        list.reverse();
    }
    if let ([a, b, ..], [.., y, z]) = (list.as_slice(), list.as_slice()) {
        let ends = [(1.5 * a.0 - 0.5 * b.0, a.1), (1.5 * z.0 - 0.5 * y.0, z.1)];
        list.insert(0, ends[0]);
        list.push(ends[1]);
    }
    if list.iter().any(|p| p.1 < 0.0) {
        return Err(object.wrong("a value is negative"));
    }
    Spectrum::from_points(list).map_err(|e| object.wrong(e))
}

/// The function of `gensky` or `gendaylit`; `None` for any other. Its words may end with transforms.
fn sky(object: &Object, moved: &Motion) -> Result<Option<Pattern>> {
    let [variable, file, transform @ ..] = object.strings.as_slice() else { return Ok(None) };
    let file = Path::new(file).file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
    let key = match (variable.as_str(), file.as_str()) {
        ("skybr", "skybright.cal") => "gensky",
        ("skybright", "perezlum.cal") => "gendaylit",
        _ => return Ok(None),
    };
    let checked =
        if key == "gensky" { RadianceSky::gensky(&object.reals) } else { RadianceSky::gendaylit(&object.reals) };
    checked.map_err(|e| object.wrong(e))?;
    let (own, rest) = motion(transform).map_err(|e| object.wrong(e))?;
    if let Some(word) = rest.first() {
        return Err(object.wrong(format!("'{}' is no transform", printable(word.as_bytes()))));
    }
    let all = own.then(moved);
    let turned = |v: [f64; 3]| (all.vector(v.into()) / all.scale).to_array();
    let mut numbers = object.reals.clone();
    if let [.., x, y, z] = numbers.as_mut_slice()
        && (key == "gendaylit" || object.reals.len() == 7)
    {
        [*x, *y, *z] = turned([*x, *y, *z]);
    }
    Ok(Some(Pattern { key, numbers, zenith: turned([0.0, 0.0, 1.0]) }))
}
