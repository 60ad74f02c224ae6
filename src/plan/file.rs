//! Plans as TOML, each line with its reason.
//!
//! A plan holds for the spectra that it was made for: a number made of all of them stands in it, and another scene's is refused.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::{is_deceptive, printable};
use crate::keys::{self, Keys};
use crate::material::read::Without;
use crate::plan::channels::{Channels, Converter};
use crate::plan::survey::Survey;
use crate::plan::{Model, Plan, Wish};
use crate::render::few::Few;
use crate::scene::Scene;
use crate::spectral::Rule;
use crate::statistics::fnv1a;
use crate::{Error, Result, invalid};

/// What a plan says to do.
#[derive(Clone, Debug, Default)]
pub struct Orders {
    /// What paths carry; `None` for full bands.
    pub wavelengths: Wavelengths,
    /// Effects that the scene is read without.
    pub without: Without,
    /// Most bounces.
    pub max_bounces: Option<u32>,
    /// Paths a pixel.
    pub samples: Option<u32>,
}

/// What paths carry.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Wavelengths {
    /// Wavelengths of a rule.
    Few(Rule),
    /// Channels.
    Three(Channels),
    /// Full bands.
    #[default]
    Bands,
}

impl Wavelengths {
    /// For a scene, which has been read without what the plan leaves out.
    pub fn few(&self, scene: &Scene) -> Result<Option<Few>> {
        Ok(match self {
            Wavelengths::Bands => None,
            Wavelengths::Few(rule) => Some(Few { rule: rule.clone(), converted: None }),
            Wavelengths::Three(channels) => {
                let survey = Survey::of(scene)?;
                Some(Converter::new(*channels, &survey)?.few(&survey, scene))
            }
        })
    }
}

/// Stands for a scene's spectra, for what decides between a rule and bands, and for the extent of its surfaces, which depth and effects
/// hang on: made of how they print.
pub fn fingerprint(scene: &Scene) -> u64 {
    let varied = scene.looks_at_site.contains(&true);
    let text = format!("{:?} {:?} {varied} {:x}", scene.inks, scene.effects, scene.fingerprint());
    fnv1a(text.as_bytes())
}

/// The text of a plan for a scene.
pub fn write(scene: &Scene, name: &str, plan: &Plan, wish: &Wish) -> String {
    let mut text = String::from("# What a scene needs, by specplan; spectrace --plan renders by it.\n\n");
    let _ = writeln!(text, "scene = {}", quoted(name));
    let _ = writeln!(
        text,
        "fingerprint = \"{:016x}\" # of its spectra and its extent: another scene's plan is refused",
        fingerprint(scene)
    );
    let _ = writeln!(text, "tolerance = {:?} # Delta E 2000", wish.tolerance);
    let _ = writeln!(text, "gain = {:?} # dark pixels are looked at up to so much brighter\n", wish.gain);
    let _ = writeln!(text, "[method]\nuse = \"path\" # it alone has every effect, and noise that cancels in a pilot\n");
    for effect in &plan.effects {
        let _ = writeln!(text, "[effects.{}]\non = {}", effect.name, effect.on);
        let _ = writeln!(
            text,
            "bound = {:.4} # Delta E 2000 of the pilot's worst pixel without it, and a quarter\n",
            effect.bound
        );
    }
    if let Some(depth) = &plan.depth {
        let _ = writeln!(text, "[depth]\nmax_bounces = {}", depth.max_bounces);
        let _ = writeln!(
            text,
            "tail = {:.4} # Delta E 2000 of the pilot's worst pixel without paths of more than half of that, and a quarter\n",
            depth.tail
        );
    }
    if let Some(samples) = plan.samples {
        let seconds = wish.time.unwrap_or(0.0);
        let _ = writeln!(
            text,
            "[effort]\nsamples = {samples} # paths a pixel in {seconds} s, as fast as this machine was\n"
        );
    }
    if let Some(p) = &plan.flight {
        text.push_str("[pilot] # all of this on the same paths as in full\n");
        let _ = writeln!(text, "pixels = {}\npaths = {}\nwhite_y = {:?} # cd/m2", p.pixels, p.paths, p.white_y);
        let share = 100.0 * p.share();
        let _ = writeln!(text, "worst = {:.4} # {share:.2} % of pixels are no worse, with 99 % confidence\n", p.worst);
    }
    wavelengths(&mut text, scene, plan);
    text
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if is_deceptive(c) => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out + "\""
}

fn wavelengths(text: &mut String, scene: &Scene, plan: &Plan) {
    let _ = writeln!(text, "[wavelengths]\nwhy = {}", quoted(&plan.why));
    for rung in &plan.tried {
        let _ = writeln!(
            text,
            "# {:>8}: worst product {:.3}, of more surfaces {:.3}, bound {:.3}",
            rung.model.to_string(),
            rung.worst,
            rung.deep,
            rung.bound()
        );
    }
    let Some((rung, few)) = &plan.chosen else {
        text.push_str("mode = \"bands\"\n");
        return;
    };
    if let Model::Three(channels) = rung.model {
        let _ =
            writeln!(text, "mode = \"{channels}\" # three channels, made of the scene's spectra when it is rendered");
        return;
    }
    text.push_str("mode = \"few\"\n");
    let list = |x: &[f64]| x.iter().map(|x| format!("{x:.9e}")).collect::<Vec<_>>().join(", ");
    let nm: Vec<String> = few.rule.nodes_nm.iter().map(|x| format!("{x:?}")).collect();
    let _ = writeln!(text, "nm = [{}]", nm.join(", "));
    for (light, weights) in scene.lights.iter().zip(&few.rule.weights) {
        let _ = writeln!(text, "\n[[wavelengths.light]] # XYZ in cd/m2 of what is left of it at each wavelength");
        let _ = writeln!(text, "name = {}", quoted(&light.name));
        for (c, w) in ["x", "y", "z"].iter().zip(weights) {
            let _ = writeln!(text, "{c} = [{}]", list(w));
        }
    }
}

/// Reads a plan that must have been made for this scene, which has all its effects.
///
/// # Errors
/// One line with the file, the place and what would be right: a plan of another scene, a number of weights that is not that of the
/// wavelengths, weights below 0, unknown keys.
pub fn read(path: &Path, scene: &Scene) -> Result<Orders> {
    let text = crate::files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    parse(&text, scene).map_err(|e| e.in_file(path))
}

fn parse(text: &str, scene: &Scene) -> Result<Orders> {
    let not_below_0 = |x: f64| x >= 0.0 && x.is_finite();
    let mut top = keys::parse(text)?;
    let name: String = top.need("scene")?;
    let (made_for, span): (String, _) = match top.get_spanned("fingerprint")? {
        Some(found) => found,
        None => return Err(top.wrong("key 'fingerprint' is missing")),
    };
    if made_for != format!("{:016x}", fingerprint(scene)) {
        let name = printable(name.as_bytes());
        let message = format!(
            "this plan was made for another scene ('{name}' as it was then); make one for this one with specplan"
        );
        return Err(top.wrong_key("fingerprint", span, &message));
    }
    top.number("tolerance", "is no Delta E 2000 above 0", |x| x > 0.0 && x.is_finite())?;
    top.number("gain", "is no factor from 1", |x| x >= 1.0 && x.is_finite())?;
    let mut orders = Orders::default();
    if let Some(mut method) = top.table("method")? {
        let used: String = method.need("use")?;
        if used != "path" {
            return Err(
                method.wrong(&format!("use '{}': path is the only method of plans", printable(used.as_bytes())))
            );
        }
        method.finish()?;
    }
    if let Some(mut effects) = top.table("effects")? {
        let Without { polarization, fluorescence, dispersion } = &mut orders.without;
        for (name, out) in [("polarization", polarization), ("fluorescence", fluorescence), ("dispersion", dispersion)]
        {
            let Some(mut effect) = effects.table(name)? else { continue };
            *out = !effect.need::<bool>("on")?;
            effect.number("bound", "is no Delta E 2000", not_below_0)?;
            effect.finish()?;
        }
        effects.finish()?;
    }
    if let Some(mut depth) = top.table("depth")? {
        let whole = |x: f64| (0.0..=4e9).contains(&x) && x.fract() == 0.0;
        orders.max_bounces = depth.number("max_bounces", "is no number of bounces", whole)?.map(|x| x as u32);
        depth.number("tail", "is no Delta E 2000", not_below_0)?;
        depth.finish()?;
    }
    if let Some(mut effort) = top.table("effort")? {
        let whole = |x: f64| (1.0..=4e9).contains(&x) && x.fract() == 0.0;
        orders.samples = effort.number("samples", "is no number of paths", whole)?.map(|x| x as u32);
        effort.finish()?;
    }
    if let Some(mut pilot) = top.table("pilot")? {
        for key in ["pixels", "paths", "white_y", "worst"] {
            pilot.number(key, "is no number of 0 or more", not_below_0)?;
        }
        pilot.finish()?;
    }
    let Some(mut k) = top.table("wavelengths")? else { return Err(top.wrong("table 'wavelengths' is missing")) };
    top.finish()?;
    k.get::<String>("why")?;
    let mode: String = k.need("mode")?;
    orders.wavelengths = match (mode.as_str(), mode.parse()) {
        ("bands", _) => Wavelengths::Bands,
        ("few", _) => Wavelengths::Few(rule(&mut k, scene)?),
        (_, Ok(channels)) => Wavelengths::Three(channels),
        (other, _) => {
            return Err(
                k.wrong(&format!("mode '{}' is neither few nor relative nor bands", printable(other.as_bytes())))
            );
        }
    };
    k.finish()?;
    Ok(orders)
}

fn rule(k: &mut Keys, scene: &Scene) -> Result<Rule> {
    let nm: Vec<f64> = k.need("nm")?;
    if nm.len() > 64 || !nm.iter().all(|x| (250.0..=2500.0).contains(x)) {
        return Err(k.wrong("nm: up to 64 wavelengths from 250 to 2500 are right"));
    }
    let mut weights = Vec::new();
    let lights = k.array("light")?;
    if lights.len() != scene.lights.len() {
        return invalid!("{} lights in [[wavelengths.light]]; the scene has {}", lights.len(), scene.lights.len());
    }
    for (mut l, light) in lights.into_iter().zip(&scene.lights) {
        let name: String = l.need("name")?;
        if name != light.name {
            let (name, right) = (printable(name.as_bytes()), printable(light.name.as_bytes()));
            return Err(l.wrong(&format!("'{name}' stands where the scene has '{right}'")));
        }
        weights.push([l.need("x")?, l.need("y")?, l.need("z")?]);
        l.finish()?;
    }
    Rule::new(nm, weights)
}
