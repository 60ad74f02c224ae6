//! What is asked of a plan, and how one is found: effects and deep paths that a pilot does not miss are left out, then the first rung is
//! taken whose certificate and pilot stay within what is left of the tolerance.

use std::sync::Arc;
use std::time::Duration;

use crate::material::read::Without;
use crate::plan::ladder::{self, Ladder, Model, Rung};
use crate::plan::pilot::{Flight, Pilot};
use crate::plan::products::{self, SAFETY};
use crate::plan::survey::{Lit, Survey};
use crate::render::few::Few;
use crate::render::path;
use crate::render::picture::paths_within;
use crate::scene::Scene;
use crate::spectral::builtin;
use crate::{Error, Result, invalid, usage};

/// What is asked of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// Colour error of any pixel, Delta E 2000.
    pub tolerance: f64,
    /// Dark pixels are looked at up to so many times brighter.
    pub gain: f64,
    /// Pixels of the pilot; 0 for none.
    pub pilot: usize,
    /// Seconds that the picture may take.
    pub time: Option<f64>,
    /// A rung to take, whatever its error; `Some(None)` for full bands.
    pub model: Option<Option<Model>>,
    /// Good under other lamps as well.
    pub relit: bool,
}

/// Lamps that wavelengths are to be good under, where the scene's own may be exchanged: a smooth one, daylight, and lines of two kinds.
const LAMPS: [&str; 5] = ["A", "D65", "FL11", "LED-B3", "LED-RGB1"];
/// Pixels of the pilot that something is left out for.
const FEWEST_PIXELS: usize = 100;
/// Paths a pixel of the pilot.
const PATHS: u32 = 4;
/// What spectrace does unless told.
const SPLIT: u32 = 4;
/// Seconds that a look at its speed takes at most.
const TRIAL_S: f64 = 0.2;
/// Of the tolerance, what an effect may cost that is left out, and what deep paths may.
const SHARE: f64 = 0.25;
/// Bounces beyond which the pilot's paths may have next to nothing.
const DEPTHS: [u32; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 24];
/// Paths end after so many times those: depths fall off by a factor a bounce, so that what one in thousands of paths reaches, one in millions
/// doubles.
const RARE: u32 = 2;

/// An effect that the scene has.
#[derive(Clone, Debug)]
pub struct Effect {
    /// As the plan has it.
    pub name: &'static str,
    /// It is rendered.
    pub on: bool,
    /// What leaving it out costs at most, Delta E 2000.
    pub bound: f64,
}

/// How deep paths go.
#[derive(Clone, Copy, Debug)]
pub struct Depth {
    /// They end after so many bounces.
    pub max_bounces: u32,
    /// What the rest costs at most, Delta E 2000.
    pub tail: f64,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// What paths carry; `None` for full bands.
    pub chosen: Option<(Rung, Arc<Few>)>,
    /// All rungs that were tried, from the first.
    pub tried: Vec<Rung>,
    /// Why that one.
    pub why: String,
    /// Spectra, and products that were looked at.
    pub counts: (usize, usize),
    /// Effects that the scene has.
    pub effects: Vec<Effect>,
    /// Those left out.
    pub without: Without,
    /// Where paths end, if not by lot alone.
    pub depth: Option<Depth>,
    /// All of it tried.
    pub flight: Option<Flight>,
    /// Paths a pixel for the time that was given.
    pub samples: Option<u32>,
}

impl Plan {
    /// Of colour errors, what the picture is expected to stay below: tested, not proved.
    pub fn bound(&self) -> f64 {
        self.chosen.as_ref().map_or(0.0, |c| c.0.bound()) + self.left_out()
    }

    /// What paths carry, in words; `bands` stands for full ones.
    pub fn carried(&self, bands: &str) -> String {
        match &self.chosen {
            Some((Rung { model: Model::Three(channels), .. }, _)) => format!("{channels} colours"),
            Some((rung, _)) => format!("{} wavelengths", rung.rule.nodes_nm.len()),
            None => bands.to_string(),
        }
    }

    /// In a line, with the bands that full ones have.
    pub fn told(&self, bands: usize) -> String {
        let mut text = format!("{}; {}", self.carried(&format!("{bands} bands")), self.why);
        for e in self.effects.iter().filter(|e| !e.on) {
            text += &format!("; without {}, {:.3}", e.name, e.bound);
        }
        if let Some(d) = &self.depth {
            text += &format!("; {} bounces, {:.3}", d.max_bounces, d.tail);
        }
        if let Some(f) = &self.flight {
            text += &format!("; worst of {} pixels tried {:.3}", f.pixels, f.worst);
        }
        text
    }

    /// Of it, what effects and deep paths have that are left out.
    pub fn left_out(&self) -> f64 {
        self.effects.iter().filter(|e| !e.on).map(|e| e.bound).sum::<f64>() + self.depth.map_or(0.0, |d| d.tail)
    }
}

impl Wish {
    /// Checked.
    ///
    /// # Errors
    /// A tolerance that is not above 0; of usage, a gain below 1.
    pub fn new(tolerance: f64, gain: f64, pilot: usize) -> Result<Wish> {
        if !(tolerance > 0.0 && tolerance <= 100.0) {
            return Err(Error::Invalid(format!("--tolerance {tolerance}: a Delta E 2000 above 0, such as 0.5")));
        }
        if !(1.0..=1e6).contains(&gain) {
            return usage!("--gain {gain}: a factor from 1, such as 10");
        }
        Ok(Wish { tolerance, gain, pilot, time: None, model: None, relit: false })
    }

    /// Plans a scene, which is read `again` without some effects.
    ///
    /// # Errors
    /// A scene without light, a model that the scene cannot be put into, a time without a camera.
    pub fn plan(&self, scene: &Arc<Scene>, again: &dyn Fn(Without) -> Result<Scene>) -> Result<Plan> {
        let mut plan = Plan::default();
        let survey = Survey::of(scene)?;
        let white = products::viewing(&survey, self.gain).white;
        let pilot = match self.pilot > 0 && scene.camera.is_some() {
            true => {
                let max_bounces = scene.max_bounces.unwrap_or(u32::MAX);
                Some(Pilot::new(scene, (white, self.gain), (self.pilot, PATHS), max_bounces)?)
            }
            false => None,
        };
        let mut scene = scene.clone();
        // So few pixels tell nothing of the others.
        if let Some(pilot) = pilot.as_ref().filter(|p| p.pixels() >= FEWEST_PIXELS) {
            self.effects(pilot, &mut scene, again, &mut plan)?;
            self.depth(pilot, &scene, &mut plan)?;
        }
        let mut survey = if plan.without == Without::default() { survey } else { Survey::of(&scene)? };
        if self.relit {
            for name in LAMPS {
                survey.lights.push(Lit::of(&builtin::spectrum(&format!("illuminant_{name}"))?)?);
            }
        }
        self.climb(&survey, &scene, pilot.as_ref(), &mut plan)?;
        if let Some(seconds) = self.time {
            let (Some(pilot), Some(camera)) = (&pilot, &scene.camera) else {
                return usage!("--time needs a pilot, and a scene with a [camera]");
            };
            let few = plan.chosen.as_ref().map(|c| &c.1);
            let most = plan.depth.map(|d| d.max_bounces).or(scene.max_bounces).unwrap_or(u32::MAX);
            let options = path::Options { max_bounces: most, split: SPLIT, pool: true };
            let estimate = pilot.estimate(&scene, few, options)?;
            let size = (camera.width, camera.height);
            let (time, trial_s) = (Duration::from_secs_f64(seconds), (0.05 * seconds).min(TRIAL_S));
            plan.samples = Some(paths_within(&*estimate, time, trial_s, size, (0, camera.height)));
        }
        Ok(plan)
    }

    /// Leaves out what the pilot does not miss.
    fn effects(
        &self,
        pilot: &Pilot,
        scene: &mut Arc<Scene>,
        again: &dyn Fn(Without) -> Result<Scene>,
        plan: &mut Plan,
    ) -> Result<()> {
        let none = Without::default();
        let all = [
            ("polarization", scene.polarised, Without { polarization: true, ..none }),
            ("fluorescence", scene.fluoresces(), Without { fluorescence: true, ..none }),
            ("dispersion", scene.effects.disperses, Without { dispersion: true, ..none }),
        ];
        for (name, _, without) in all.into_iter().filter(|e| e.1) {
            let bound = pilot.fly(&Arc::new(again(without)?), None, None)?.bound();
            let on = bound > SHARE * self.tolerance;
            plan.effects.push(Effect { name, on, bound });
            if !on {
                plan.without = plan.without.or(without);
            }
        }
        if plan.without != none {
            *scene = Arc::new(again(plan.without)?);
        }
        Ok(())
    }

    /// Twice the fewest bounces whose rest the pilot does not miss.
    fn depth(&self, pilot: &Pilot, scene: &Arc<Scene>, plan: &mut Plan) -> Result<()> {
        let depths: Vec<u32> = DEPTHS.into_iter().filter(|d| scene.max_bounces.is_none_or(|m| RARE * *d < m)).collect();
        let (mut from, mut to) = (0, depths.len());
        while from < to {
            let middle = (from + to) / 2;
            // What effects cost is in it once more: on the safe side.
            let tail = pilot.fly(scene, None, Some(depths[middle]))?.bound();
            if tail <= SHARE * self.tolerance {
                (to, plan.depth) = (middle, Some(Depth { max_bounces: RARE * depths[middle], tail }));
            } else {
                from = middle + 1;
            }
        }
        Ok(())
    }

    /// The first rung that is good enough.
    fn climb(&self, survey: &Survey, scene: &Arc<Scene>, pilot: Option<&Pilot>, plan: &mut Plan) -> Result<()> {
        plan.counts = (survey.shares.len(), 0);
        let max_bounces = plan.depth.map(|d| d.max_bounces);
        let in_bands = |plan: &mut Plan, why: String| {
            plan.why = why;
            plan.flight = pilot.map(|p| p.fly(scene, None, max_bounces)).transpose()?;
            Ok(())
        };
        match (&survey.needs_bands, self.model) {
            (_, Some(None)) => return in_bands(plan, "asked for".into()),
            (Some(why), Some(Some(model))) => return invalid!("--model {model}: full bands are needed: {why}"),
            (Some(why), None) => return in_bands(plan, why.clone()),
            (None, _) => {}
        }
        let mut ladder = Ladder::new(survey, self.gain);
        plan.counts.1 = ladder.products();
        let left = self.tolerance - plan.left_out();
        let asked = self.model.flatten();
        let mut rungs = asked.map_or(ladder::RUNGS.to_vec(), |m| vec![m]);
        if self.relit {
            rungs.retain(|m| matches!(m, Model::Wavelengths(_)));
            if rungs.is_empty() {
                return usage!("--relight: channels are of the lamps that they were made under");
            }
        }
        let mut refused = String::new();
        for model in rungs {
            // What is asked for is to be as good as it gets.
            let rung = match ladder.rung(model, if asked.is_some() { 0.0 } else { left }) {
                Ok(rung) => rung,
                Err(e) if asked.is_some() => return Err(e),
                // A light that the channels cannot make: wavelengths can.
                Err(_) => continue,
            };
            plan.tried.push(rung.clone());
            if rung.bound() > left && asked.is_none() {
                continue;
            }
            let mut few = rung.few(survey, scene)?;
            few.rule.weights.truncate(scene.lights.len());
            let few = Arc::new(few);
            plan.flight = pilot.map(|p| p.fly(scene, Some(&few), max_bounces)).transpose()?;
            if let Some(flight) = plan.flight.filter(|f| asked.is_none() && f.bound() > self.tolerance) {
                refused = format!("; the pilot misses the tolerance with {model}: {:.3}", flight.worst);
                continue;
            }
            let seen = if ladder.whole { "all" } else { "of a part of the" };
            let found = format!(
                "{SAFETY} times the worst of {seen} products of {} spectra under {} lights is {:.3}, the worst found of more surfaces {:.3}",
                survey.shares.len(),
                survey.lights.len(),
                SAFETY * rung.worst,
                rung.deep
            );
            plan.why = match asked {
                None if left < self.tolerance => {
                    format!("{found}: within {left:.3}, which what is left out leaves of {}{refused}", self.tolerance)
                }
                None => format!("{found}: within {left:.3}{refused}"),
                Some(_) => format!("asked for; {found}"),
            };
            plan.chosen = Some((rung, few));
            return Ok(());
        }
        let last = plan.tried.last().map_or(f64::INFINITY, Rung::bound);
        let why = match last <= left {
            true => refused.trim_start_matches("; ").to_string(),
            false => format!("16 wavelengths miss the tolerance: what bounds their error is {last:.3}{refused}"),
        };
        in_bands(plan, why)
    }
}
