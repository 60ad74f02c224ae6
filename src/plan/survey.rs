//! The spectra that light of a scene can meet, as shares of it on a fine grid, and the lights it comes from.

use crate::material::Ink;
use crate::optics::fresnel;
use crate::plan::products::BOUNCES;
pub use crate::render::few::RANGE_NM;
use crate::render::film::light_weights;
use crate::scene::Scene;
use crate::spectral::{Observer, Rule, Sampling, Spectrum};
use crate::units::K_M;
use crate::{Result, invalid};

/// Bins of the fine grid over them: 2 nm.
pub const BINS: usize = 200;
/// Candidates for a rule's wavelengths, nm apart.
const STEP_NM: f64 = 2.5;
/// More spectra than that of materials are not multiplied with each other.
const MOST_SHARES: usize = 64;
/// Spectra that differ less than this at every wavelength are one.
const ALIKE: f64 = 2e-3;
/// Optical depths, by the mean of all wavelengths, at which what a body absorbs is looked at.
const DEPTHS: [f64; 4] = [0.1, 0.5, 1.5, 4.0];
/// Cosines at which metals are.
const COSINES: [f32; 3] = [1.0, 0.5, 0.17364818];

/// What light can meet: the share of it that is left.
#[derive(Clone, Debug)]
pub struct Share {
    /// Mean of each bin.
    pub fine: Vec<f64>,
    /// At each candidate.
    pub at: Vec<f64>,
}

/// A light on the fine grid.
#[derive(Clone, Debug)]
pub struct Lit {
    /// What the light of each bin weighs in X, Y and Z, all of it Y = 100.
    pub weights: [Vec<f64>; 3],
    /// cd/m2 that 1 stands for; 0 of light that cannot be seen.
    pub scale: f64,
}

/// All of a scene.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The candidates, nm.
    pub candidates_nm: Vec<f64>,
    /// Spectra, no two alike; none that is grey.
    pub shares: Vec<Share>,
    /// Lights, in the scene's order.
    pub lights: Vec<Lit>,
    /// Which of them gives most light.
    pub dominant: usize,
    /// Surfaces in turn that light can meet.
    pub surfaces: usize,
    /// Why nothing but full bands will do, if so.
    pub needs_bands: Option<String>,
}

impl Survey {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Result<Survey> {
        let lights: Vec<&Spectrum> = scene.lights.iter().map(|l| &l.radiance).collect();
        let mut survey = Survey::of_spectra(&[], &lights)?;
        survey.needs_bands = reason(scene);
        survey.dominant = scene.dominant()?.map_or(0, |d| d.0);
        survey.surfaces = scene.max_bounces.map_or(BOUNCES, |m| (m as usize).min(BOUNCES));
        // Light that goes through a medium keeps what its extinction leaves, whatever that is made of.
        let made_of = scene.media.list.iter().filter_map(|m| Some([m.absorption, m.scattering?]));
        let parts: Vec<u32> = made_of.flatten().collect();
        for (ink, number) in scene.inks.iter().zip(0u32..) {
            match ink {
                Ink::Depth(_) if parts.contains(&number) => {}
                Ink::Reflectance(s) => survey.meet(|nm| s.at(nm)),
                Ink::Depth(s) => {
                    let mean = s.mean(RANGE_NM.0, RANGE_NM.1);
                    for depth in DEPTHS.iter().filter(|_| mean > 0.0) {
                        survey.meet(|nm| (-s.at(nm) * depth / mean).exp());
                    }
                }
                Ink::Index { n, k } => {
                    for cos in COSINES {
                        survey.meet(|nm| fresnel::conductor(cos, n.at(nm) as f32, k.at(nm) as f32).into());
                    }
                }
                Ink::Film(_) | Ink::Reradiation { .. } | Ink::Grating(_) | Ink::Dipole { .. } => {}
            }
        }
        for ink in scene.media.list.iter().filter_map(|m| scene.inks.get(m.scattering? as usize)) {
            // What scatters does so by its coefficient, with any length before it: its largest value makes it a share.
            if let Ink::Depth(s) = ink {
                let most = s.range().1;
                survey.meet(|nm| s.at(nm) / most);
            }
        }
        if scene.looks_at_site.contains(&true) {
            // Pictures are mixtures of these.
            scene.srgb.iter().for_each(|s| survey.meet(|nm| s.at(nm)));
        }
        if survey.lights.iter().all(|l| l.scale == 0.0) {
            return invalid!("nothing in the scene gives off light that can be seen");
        }
        Ok(survey)
    }

    /// Of spectra by themselves: what a rule is fitted to where there is no scene.
    ///
    /// # Errors
    /// None but of the program's own tables.
    pub fn of_spectra(shares: &[&Spectrum], lights: &[&Spectrum]) -> Result<Survey> {
        let candidates_nm = candidates();
        let lights = lights.iter().map(|s| Lit::of(s)).collect::<Result<_>>()?;
        let mut survey =
            Survey { shares: Vec::new(), lights, needs_bands: None, candidates_nm, dominant: 0, surfaces: BOUNCES };
        shares.iter().for_each(|s| survey.meet(|nm| s.at(nm)));
        Ok(survey)
    }

    /// A rule for lights of Y = 100 as one for these, cd/m2.
    pub fn scaled(&self, rule: &Rule) -> Rule {
        let mut rule = rule.clone();
        for (weights, light) in rule.weights.iter_mut().zip(&self.lights) {
            weights.iter_mut().flatten().for_each(|w| *w *= light.scale);
        }
        rule
    }

    /// One more, unless there is one like it.
    fn meet(&mut self, share: impl Fn(f64) -> f64) {
        let fine = fine(&share);
        let alike = |a: &[f64]| a.iter().zip(&fine).all(|(a, b)| (a - b).abs() < ALIKE);
        let grey = fine.iter().all(|x| (x - fine[0]).abs() < ALIKE);
        if !grey && !self.shares.iter().any(|s| alike(&s.fine)) {
            self.shares.push(Share { at: self.candidates_nm.iter().map(|nm| share(*nm)).collect(), fine });
        }
    }
}

fn candidates() -> Vec<f64> {
    let count = ((RANGE_NM.1 - RANGE_NM.0) / STEP_NM) as usize;
    (0..=count).map(|i| RANGE_NM.0 + STEP_NM * i as f64).collect()
}

/// Means of a spectrum over the bins.
pub fn fine(spectrum: impl Fn(f64) -> f64) -> Vec<f64> {
    let width = (RANGE_NM.1 - RANGE_NM.0) / BINS as f64;
    // Linear within a quarter of a bin: tables are every nanometre at their finest.
    let mean = |i: usize| {
        let at = |k: f64| spectrum(RANGE_NM.0 + width * (i as f64 + k));
        0.25 * (at(0.125) + at(0.375) + at(0.625) + at(0.875))
    };
    (0..BINS).map(mean).collect()
}

impl Lit {
    /// Of a light's radiance.
    pub fn of(radiance: &Spectrum) -> Result<Lit> {
        let (sampling, observer) = (Sampling::bins(RANGE_NM.0, RANGE_NM.1, BINS)?, Observer::cie1931()?);
        let weights = observer.cmf.each_ref().map(|cmf| {
            let mut long_first = light_weights(radiance, &sampling, RANGE_NM, &cmf.scaled(K_M));
            long_first.reverse();
            long_first
        });
        let luminance: f64 = weights[1].iter().sum();
        let scale = luminance.max(0.0) / 100.0;
        let over = |x: f64| if scale > 0.0 { x / scale } else { 0.0 };
        Ok(Lit { weights: weights.map(|w| w.into_iter().map(over).collect()), scale })
    }

    /// XYZ of the light itself, Y = 100; black if it cannot be seen.
    pub fn xyz(&self) -> [f64; 3] {
        self.weights.each_ref().map(|w| w.iter().sum())
    }
}

/// What needs wavelengths of its own, whatever the colours.
fn reason(scene: &Scene) -> Option<String> {
    let has = |what: fn(&Ink) -> bool| scene.inks.iter().any(what);
    let why = [
        (scene.fluoresces(), "a surface fluoresces: light changes its wavelength"),
        (scene.effects.disperses, "wavelengths go apart, and a few of them would show as bands of colour"),
        (has(|i| matches!(i, Ink::Film(_))), "thin films interfere, finer than a few wavelengths tell"),
        (has(|i| matches!(i, Ink::Grating(_))), "a grating sends each wavelength its own way"),
        (
            scene.effects.subsurface,
            "light leaves bodies elsewhere than where it went in: its colour is no product of a few spectra",
        ),
        (scene.media.glow(), "a medium gives off light of its own"),
    ];
    let below = |l: &&crate::scene::Light| l.radiance.range().0 < 0.0;
    let sky = scene.lights.iter().find(below).map(|l| format!("the light '{}' has parts below zero", l.name));
    let many =
        (scene.inks.len() > MOST_SHARES).then(|| format!("{} spectra are too many to multiply", scene.inks.len()));
    why.iter().find(|w| w.0).map(|w| w.1.to_string()).or(sky).or(many)
}
