//! The first rung that is good enough: 4, 8, 12 or 16 wavelengths, whole registers; else full bands.

use crate::Result;
use crate::plan::fit::Fit;
use crate::plan::products::{self, Products, SAFETY};
use crate::plan::survey::Survey;
use crate::spectral::Rule;

/// Numbers of wavelengths.
pub const RUNGS: [usize; 4] = [4, 8, 12, 16];
/// Of a rule that misses the tolerance, so many of its worst products are learned, so often.
const LEARNED: usize = 60;
const LESSONS: usize = 3;

/// One rung, and what it was found to be.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Wavelengths that were asked for: a scene of greys needs less.
    pub asked: usize,
    /// For lights of Y = 100; of the rung that is chosen for those of the scene, cd/m2.
    pub rule: Rule,
    /// Delta E 2000 of the worst product of up to four surfaces.
    pub worst: f64,
    /// Of the worst that was found of more surfaces.
    pub deep: f64,
}

impl Rung {
    /// What the picture's error is expected to stay below: tested, not proved.
    pub fn bound(&self) -> f64 {
        (SAFETY * self.worst).max(self.deep)
    }
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The rule, or full bands.
    pub chosen: Option<Rung>,
    /// All rungs that were tried, from the first.
    pub tried: Vec<Rung>,
    /// Why that one.
    pub why: String,
    /// Spectra, and products that were looked at.
    pub counts: (usize, usize),
}

impl Plan {
    /// For a tolerance in Delta E 2000, to a viewer who lifts dark pixels by up to `gain`; of no fewer wavelengths than `least`.
    pub fn of(survey: &Survey, tolerance: f64, gain: f64, least: usize) -> Result<Plan> {
        let mut plan = Plan { chosen: None, tried: Vec::new(), why: String::new(), counts: (survey.shares.len(), 0) };
        if let Some(why) = &survey.needs_bands {
            plan.why = why.clone();
            return Ok(plan);
        }
        let viewing = products::viewing(survey, gain);
        let (all, whole) = Products::of(survey);
        plan.counts.1 = all.met.len();
        let mut nodes = Vec::new();
        let mut fit = Fit::new(survey, &all, viewing);
        for k in RUNGS {
            fit.choose(&mut nodes, k);
            let mut best: Option<Rung> = None;
            for lesson in 0..=LESSONS {
                let rule = fit.weigh(&nodes);
                let errors = all.errors(survey, &nodes, &rule, &viewing);
                let worst = errors.iter().copied().fold(0.0, f64::max);
                let (more, more_errors) = all.deeper(survey, &nodes, &rule, &viewing, &errors);
                let deep = more_errors.iter().copied().fold(0.0, f64::max);
                let rung = Rung { asked: k, rule, worst, deep };
                let bound = rung.bound();
                if best.as_ref().is_none_or(|b| bound < b.bound()) {
                    best = Some(rung);
                }
                if bound <= tolerance || bound > 4.0 * tolerance || lesson == LESSONS {
                    break;
                }
                fit.learn(&all, &products::worst(&errors, LEARNED));
                fit.learn(&more, &products::worst(&more_errors, LEARNED));
            }
            let Some(mut rung) = best else { continue };
            plan.tried.push(rung.clone());
            if rung.bound() <= tolerance && k >= least {
                for (weights, light) in rung.rule.weights.iter_mut().zip(&survey.lights) {
                    weights.iter_mut().flatten().for_each(|w| *w *= light.scale);
                }
                let seen = if whole { "all" } else { "of a part of the" };
                plan.why = format!(
                    "{SAFETY} times the worst of {seen} products of {} spectra under {} lights is {:.3}, the worst found of more than four \
                     surfaces {:.3}: within {tolerance}",
                    survey.shares.len(),
                    survey.lights.len(),
                    SAFETY * rung.worst,
                    rung.deep
                );
                plan.chosen = Some(rung);
                return Ok(plan);
            }
        }
        let last = plan.tried.last().map_or(f64::INFINITY, Rung::bound);
        plan.why = match last <= tolerance {
            true => format!("the pilot misses the tolerance with {} wavelengths", RUNGS[3]),
            false => format!("{} wavelengths miss the tolerance: what bounds their error is {last:.3}", RUNGS[3]),
        };
        Ok(plan)
    }
}
