//! Scenes written for Radiance: `.rad` files and `.vf` views, read into this package's own scene language (docs/radiance.md is the manual).
//!
//! | read | becomes |
//! |---|---|
//! | polygon, sphere, bubble, cylinder, tube, cone, cup, ring | the shape of its own, front for front |
//! | source | a sun up to below 180 degrees, a part of the environment from there |
//! | mesh | the OBJ that it was made of |
//! | plastic, metal, trans, glass, dielectric, mirror | the material of that name |
//! | light, illum, glow, spotlight | a light on a black body |
//! | spectrum, specfile | multiplied into the spectrum of the material |
//! | brightfunc of `gensky`, `gendaylit` | `gensky`, `gendaylit` of the environment's parts |
//! | alias, comments, `!xform ... FILE` | followed |
//!
//! No command is run. Everything else that Radiance knows is refused with its line, or left out and counted; what it does not know is
//! always refused, since it mostly means a miscounted argument further up.
//!
//! RGB is that of Radiance's primaries under equal-energy white ([`colour`]); radiance in W/sr/m2 is 1/179 of cd/m2.

pub mod colour;
mod distant;
mod lex;
mod material;
mod modifier;
mod object;
mod read;
mod surface;
pub mod view;
mod write;
pub mod xform;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::notes::Notes;
use crate::radiance::material::Palette;
use crate::radiance::modifier::Modifiers;
use crate::{Error, Result};

/// How to read.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Leave out what cannot be read, and count it.
    pub skip_unknown: bool,
}

/// A line of a file, for complaints.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// The file as it was named.
    pub file: Rc<str>,
    /// From 1.
    pub line: usize,
}

impl Place {
    /// The scene is wrong here.
    pub fn wrong(&self, message: impl std::fmt::Display) -> Error {
        Error::Invalid(format!("{}: line {}: {message}", self.file, self.line))
    }

    /// The scene is right, and more than this program reads.
    pub fn unsupported(&self, message: impl std::fmt::Display) -> Error {
        Error::Unsupported(format!("{}: line {}: {message}", self.file, self.line))
    }
}

/// A scene as it grows: what has been defined, and the TOML of what has been placed.
pub(crate) struct Scene {
    skip_unknown: bool,
    modifiers: Modifiers,
    palette: Palette,
    sky: Vec<distant::Part>,
    suns: String,
    shapes: String,
    /// How many there are, copies counted.
    placed: usize,
    /// Kinds of what was left out, with their numbers.
    left_out: BTreeMap<String, usize>,
    notes: Notes,
}

/// Most surfaces of a scene: a slip in `-a` shall not fill the memory.
const MOST_SURFACES: usize = 1 << 19;

impl Scene {
    /// Counts something left out.
    fn leave_out(&mut self, what: &str) {
        *self.left_out.entry(what.to_string()).or_default() += 1;
    }

    /// Leaves something out that cannot be read, or refuses it.
    fn refuse(&mut self, place: &Place, what: &str, message: &str) -> Result<()> {
        if !self.skip_unknown {
            return Err(place.unsupported(format!("{message}; --skip-unknown leaves it out")));
        }
        self.leave_out(what);
        Ok(())
    }

    /// Room for another surface.
    fn count(&mut self, place: &Place) -> Result<()> {
        self.placed += 1;
        if self.placed > MOST_SURFACES {
            return Err(place.wrong(format!("more than {MOST_SURFACES} surfaces; expected fewer copies")));
        }
        Ok(())
    }
}

/// The scene of these files, in their order, as TOML; '-' is standard input. `camera` and `unit` come from elsewhere. Remarks go to
/// `notes`. Errors name file and line.
pub fn convert(
    files: &[PathBuf],
    camera: Option<&view::View>,
    size: (usize, usize),
    unit: &str,
    options: &Options,
    notes: &Notes,
) -> Result<String> {
    let mut scene = Scene {
        skip_unknown: options.skip_unknown,
        modifiers: Modifiers::default(),
        palette: Palette::new()?,
        sky: Vec::new(),
        suns: String::new(),
        shapes: String::new(),
        placed: 0,
        left_out: BTreeMap::new(),
        notes: notes.clone(),
    };
    for file in files {
        read::file(file, &mut scene)?;
    }
    let names: Vec<String> = files.iter().map(|f| shown(f)).collect();
    let mut text = format!("# rad2scene {}\n", names.join(" "));
    if unit != "m" {
        let _ = writeln!(text, "unit = {}", write::quoted(unit)); // a String takes it
    }
    if let Some(camera) = camera {
        text += &camera.toml(size)?;
    }
    text += scene.palette.materials();
    text += scene.palette.lights();
    text += &scene.suns;
    text += &distant::environment(&scene.sky);
    text += &scene.shapes;
    if scene.placed == 0 && scene.sky.is_empty() && scene.suns.is_empty() {
        notes.add("no surface is left: the scene is empty");
    }
    for (kind, count) in &scene.left_out {
        notes.add(format!("{count} x {kind} left out"));
    }
    Ok(text)
}

/// A file's name on one line; '-' is standard input.
fn shown(path: &Path) -> String {
    match path.as_os_str().as_encoded_bytes() {
        b"-" => "standard input".into(),
        name => crate::error::printable(name),
    }
}
