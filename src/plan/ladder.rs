//! The rungs that a scene's light may be carried by: three relative colours, 4, 8, 12 or 16 wavelengths (whole registers). What misses them
//! all needs full bands.

use crate::compare::Viewing;
use crate::plan::channels::{Channels, Converter};
use crate::plan::fit::Fit;
use crate::plan::products::{self, Products, SAFETY};
use crate::plan::survey::Survey;
use crate::render::few::Few;
use crate::scene::Scene;
use crate::spectral::Rule;
use crate::{Result, invalid};

/// What light is carried by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Three channels.
    Three(Channels),
    /// So many wavelengths, chosen for the scene.
    Wavelengths(usize),
}

impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Model::Three(channels) => channels.fmt(f),
            Model::Wavelengths(k) => k.fmt(f),
        }
    }
}

/// The rungs, from the lowest.
pub const RUNGS: [Model; 5] = [
    Model::Three(Channels::Relative),
    Model::Wavelengths(4),
    Model::Wavelengths(8),
    Model::Wavelengths(12),
    Model::Wavelengths(16),
];
/// Of a rule that misses the tolerance, so many of its worst products are learned, so often.
const LEARNED: usize = 60;
const LESSONS: usize = 3;

/// One rung, and what it was found to be.
#[derive(Clone, Debug)]
pub struct Rung {
    /// What was asked for: a scene of greys needs fewer wavelengths.
    pub model: Model,
    /// For lights of Y = 100.
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

    /// What paths carry on this rung in a scene.
    pub fn few(&self, survey: &Survey, scene: &Scene) -> Result<Few> {
        Ok(match self.model {
            Model::Three(channels) => Converter::new(channels, survey)?.few(survey, scene),
            Model::Wavelengths(_) => Few { rule: survey.scaled(&self.rule), converted: None },
        })
    }
}

/// A scene's rungs, worked out one by one.
pub struct Ladder<'a> {
    survey: &'a Survey,
    viewing: Viewing,
    all: Products,
    /// All products of up to four surfaces were looked at.
    pub whole: bool,
    fit: Option<Fit<'a>>,
    nodes: Vec<usize>,
}

impl<'a> Ladder<'a> {
    /// For a viewer who lifts dark pixels by up to `gain`.
    pub fn new(survey: &'a Survey, gain: f64) -> Ladder<'a> {
        let (all, whole) = Products::of(survey);
        Ladder { survey, viewing: products::viewing(survey, gain), all, whole, fit: None, nodes: Vec::new() }
    }

    /// Products that are looked at.
    pub fn products(&self) -> usize {
        self.all.met.len()
    }

    /// One rung, as good as it gets; no better than the tolerance asks for. Wavelengths must be asked for in ascending numbers.
    ///
    /// # Errors
    /// Channels under a light that their space can hardly make.
    pub fn rung(&mut self, model: Model, tolerance: f64) -> Result<Rung> {
        match model {
            Model::Three(channels) => self.three(channels),
            Model::Wavelengths(k) => self.wavelengths(k, tolerance),
        }
    }

    fn three(&mut self, channels: Channels) -> Result<Rung> {
        let converter = Converter::new(channels, self.survey)?;
        let (survey, rule) = (converter.survey(self.survey), converter.rule().clone());
        let (errors, more_errors, _) = self.judge(&survey, &[0, 1, 2], &rule);
        let (worst, deep) = (largest(&errors), largest(&more_errors));
        Ok(Rung { model: Model::Three(channels), rule, worst, deep })
    }

    /// Errors of the products, of deeper ones, and those.
    fn judge(&mut self, survey: &Survey, nodes: &[usize], rule: &Rule) -> (Vec<f64>, Vec<f64>, Products) {
        let mut errors = self.all.errors(survey, nodes, rule, &self.viewing);
        if !self.whole {
            let mut more = self.all.climbed(survey, nodes, rule, &self.viewing, &errors);
            errors.extend(more.errors(survey, nodes, rule, &self.viewing));
            self.all.append(&mut more);
        }
        let (more, more_errors) = self.all.deeper(survey, nodes, rule, &self.viewing, &errors);
        (errors, more_errors, more)
    }

    fn wavelengths(&mut self, k: usize, tolerance: f64) -> Result<Rung> {
        let fit = self.fit.take().unwrap_or_else(|| Fit::new(self.survey, &self.all, self.viewing));
        fit.choose(&mut self.nodes, k);
        self.weighed(fit, k, tolerance)
    }

    /// The best rule of wavelengths that are given.
    ///
    /// # Errors
    /// Wavelengths that no plan has.
    pub fn at(&mut self, nm: &[f64]) -> Result<Rung> {
        let place = |nm: &f64| self.survey.candidates_nm.iter().position(|c| (c - nm).abs() < 1e-6);
        match nm.iter().map(place).collect::<Option<Vec<usize>>>() {
            Some(nodes) => self.nodes = nodes,
            None => return invalid!("these wavelengths are of no plan, or of channels"),
        }
        let fit = Fit::new(self.survey, &self.all, self.viewing);
        self.weighed(fit, nm.len(), 0.0)
    }

    fn weighed(&mut self, mut fit: Fit<'a>, k: usize, tolerance: f64) -> Result<Rung> {
        let mut best: Option<Rung> = None;
        for lesson in 0..=LESSONS {
            let rule = fit.weigh(&self.nodes);
            let (errors, more_errors, more) = self.judge(self.survey, &self.nodes.clone(), &rule);
            let (worst, deep) = (largest(&errors), largest(&more_errors));
            let rung = Rung { model: Model::Wavelengths(k), rule, worst, deep };
            let bound = rung.bound();
            if best.as_ref().is_none_or(|b| bound < b.bound()) {
                best = Some(rung);
            }
            // What is far off learns nothing that would help; a tolerance of 0 asks for the best.
            let far = tolerance > 0.0 && bound > 4.0 * tolerance;
            if bound <= tolerance || far || lesson == LESSONS {
                break;
            }
            fit.learn(&self.all, &products::worst(&errors, LEARNED));
            fit.learn(&more, &products::worst(&more_errors, LEARNED));
        }
        self.fit = Some(fit);
        match best {
            Some(best) => Ok(best),
            None => invalid!("no rule of {k} wavelengths has finite errors"),
        }
    }
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}
