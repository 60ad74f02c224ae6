//! Plans as TOML, each line with its reason.
//!
//! A plan holds for the spectra that it was made for: a number made of all of them stands in it, and another scene's is refused.

use std::fmt::Write as _;
use std::path::Path;

use crate::error::printable;
use crate::keys::{self, Keys};
use crate::plan::{Pilot, Plan, Wish};
use crate::scene::Scene;
use crate::spectral::Rule;
use crate::{Error, Result, invalid};

/// What a plan says to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Wavelengths {
    /// Those of a rule.
    Few(Rule),
    /// Full bands.
    Bands,
}

/// Stands for all spectra of a scene, and for what decides between a rule and bands: FNV-1a of how they print.
pub fn fingerprint(scene: &Scene) -> u64 {
    let text =
        format!("{:?} {:?} {:?} {:?}", scene.inks, scene.lights, scene.effects, scene.looks_at_site.contains(&true));
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The text of a plan for a scene.
pub fn write(scene: &Scene, name: &str, plan: &Plan, pilot: Option<&Pilot>, wish: &Wish) -> String {
    let quoted = |s: &str| toml::Value::String(s.into()).to_string();
    let mut text = String::from("# What a scene needs, by specplan; spectrace --plan renders by it.\n\n");
    let _ = writeln!(text, "scene = {}", quoted(name));
    let _ = writeln!(
        text,
        "fingerprint = \"{:016x}\" # of its spectra: another scene's plan is refused",
        fingerprint(scene)
    );
    let _ = writeln!(text, "tolerance = {:?} # Delta E 2000", wish.tolerance);
    let _ = writeln!(text, "gain = {:?} # dark pixels are looked at up to so much brighter\n", wish.gain);
    if let Some(p) = pilot {
        text.push_str("[pilot] # the same paths in full bands beside it\n");
        let _ = writeln!(text, "pixels = {}\npaths = {}\nwhite_y = {:?} # cd/m2", p.pixels, p.paths, p.white_y);
        let share = 100.0 * p.share();
        let _ = writeln!(text, "worst = {:.4} # {share:.2} % of pixels are no worse, with 99 % confidence\n", p.worst);
    }
    let _ = writeln!(text, "[wavelengths]\nwhy = {}", quoted(&plan.why));
    for rung in &plan.tried {
        let _ = writeln!(
            text,
            "# {:2} wavelengths: worst product {:.3}, of more surfaces {:.3}, bound {:.3}",
            rung.asked,
            rung.worst,
            rung.deep,
            rung.bound()
        );
    }
    let Some(rung) = &plan.chosen else {
        text.push_str("mode = \"bands\"\n");
        return text;
    };
    text.push_str("mode = \"few\"\n");
    let list = |x: &[f64], digits: usize| x.iter().map(|x| format!("{x:.digits$e}")).collect::<Vec<_>>().join(", ");
    let nm: Vec<String> = rung.rule.nodes_nm.iter().map(|x| format!("{x:?}")).collect();
    let _ = writeln!(text, "nm = [{}]", nm.join(", "));
    for (light, weights) in scene.lights.iter().zip(&rung.rule.weights) {
        let _ = writeln!(text, "\n[[wavelengths.light]] # XYZ in cd/m2 of what is left of it at each wavelength");
        let _ = writeln!(text, "name = {}", quoted(&light.name));
        for (c, w) in ["x", "y", "z"].iter().zip(weights) {
            let _ = writeln!(text, "{c} = [{}]", list(w, 9));
        }
    }
    text
}

/// Reads a plan that must have been made for this scene.
///
/// # Errors
/// One line with the file, the place and what would be right: a plan of another scene, a number of weights that is not that of the
/// wavelengths, weights below 0, unknown keys.
pub fn read(path: &Path, scene: &Scene) -> Result<Wavelengths> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    parse(&text, scene).map_err(|e| e.in_file(path))
}

fn parse(text: &str, scene: &Scene) -> Result<Wavelengths> {
    let mut top = keys::parse(text)?;
    let name: String = top.need("scene")?;
    let (made_for, span): (String, _) = match top.get_spanned("fingerprint")? {
        Some(found) => found,
        None => return Err(top.wrong("key 'fingerprint' is missing")),
    };
    if made_for != format!("{:016x}", fingerprint(scene)) {
        let name = printable(name.as_bytes());
        let message = format!(
            "this plan was made for other spectra ('{name}' as it was then); make one for this scene with specplan"
        );
        return Err(top.wrong_key("fingerprint", span, &message));
    }
    top.number("tolerance", "is no Delta E 2000 above 0", |x| x > 0.0 && x.is_finite())?;
    top.number("gain", "is no factor from 1", |x| x >= 1.0 && x.is_finite())?;
    if let Some(mut pilot) = top.table("pilot")? {
        for key in ["pixels", "paths", "white_y", "worst"] {
            pilot.number(key, "is no number of 0 or more", |x| x >= 0.0 && x.is_finite())?;
        }
        pilot.finish()?;
    }
    let Some(mut k) = top.table("wavelengths")? else { return Err(top.wrong("table 'wavelengths' is missing")) };
    top.finish()?;
    k.get::<String>("why")?;
    let mode: String = k.need("mode")?;
    let wavelengths = match mode.as_str() {
        "bands" => Wavelengths::Bands,
        "few" => Wavelengths::Few(rule(&mut k, scene)?),
        other => return Err(k.wrong(&format!("mode '{}' is neither few nor bands", printable(other.as_bytes())))),
    };
    k.finish()?;
    Ok(wavelengths)
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
