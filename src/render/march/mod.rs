//! The paper's own way through a medium: "stepping through each position along the path, starting with the radiance leaving a surface",
//! Eq. (2). Single scattering by looking at the lamps from each step ([`steps`]); with a zonal solution ([`solve`]) also what has
//! scattered before, and what surfaces send ([`Options::zonal`]).
//!
//! By itself it shows what the lamps light, on surfaces and in media, and nothing else. With zones light is even in a cube: it cannot
//! show shafts of light that has scattered before, and a cube thicker than a mean free path blurs what goes on in it (reported). Zones
//! scatter everywhere alike, whatever the phase function.

pub mod exchange;
pub mod solve;
pub mod steps;
pub mod zones;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3A;

use crate::material::{Lobe, Tint};
use crate::medium::Inside;
use crate::medium::density::Way;
use crate::notes::Notes;
use crate::render::flight::Rates;
use crate::render::inks::Outline;
use crate::render::media;
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, Pairs, Rest, Shade};
use crate::render::stored::{NOTHING, Stored};
use crate::render::trail::Trail;
use crate::render::view::{self, Seen};
use crate::render::wavelengths::Wavelengths;
use crate::scene::{Hit, Scene};
use crate::{Result, parallel};

use solve::Solution;
use steps::Steps;
use zones::NONE;

/// The first pair of a sampler's numbers that is free.
const FIRST_PAIR: u32 = 2;

/// What can be asked of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Optical depth of a step.
    pub step: f32,
    /// Light that has scattered before, by zones.
    pub zonal: Option<solve::Options>,
}

/// Marches through a scene.
pub struct March {
    scene: Arc<Scene>,
    step: f32,
    rates: Vec<Rates>,
    zonal: Option<Solution>,
    ways: AtomicU64,
    taken: AtomicU64,
}

impl March {
    /// Balances the zones, where they are asked for.
    pub fn new(scene: Arc<Scene>, outline: &Outline, o: &Options, wavelengths: &dyn Wavelengths) -> Result<March> {
        parallel::ready();
        let rates = Rates::of(&scene.media, outline);
        let zonal = o.zonal.map(|z| Solution::new(&scene, &z, wavelengths)).transpose()?;
        let (ways, taken) = Default::default();
        Ok(March { scene, step: o.step, rates, zonal, ways, taken })
    }

    /// Notes what a way's medium gives off and lets through.
    fn travel(&self, inside: Inside, way: &Way, pairs: &mut Pairs, trail: &mut Trail) {
        let steps = Steps { scene: &self.scene, rates: &self.rates, step: self.step };
        let count = steps.march(inside, way, pairs, trail, |step, trail| {
            let Some(Solution { zones, stored, .. }) = &self.zonal else { return };
            let lights = stored.lights.len() as u32;
            for (zone, share) in zones.around(step.place, step.medium.number) {
                for light in 0..lights {
                    trail.stored((zones.count() as u32 + zone) * lights + light, step.weight * share);
                }
            }
        });
        self.ways.fetch_add(1, Ordering::Relaxed);
        self.taken.fetch_add(count as u64, Ordering::Relaxed);
    }

    fn shade(&self, inside: Inside) -> Shade<'_> {
        let follow = if self.zonal.is_some() { Follow::All } else { Follow::Gloss };
        Shade { scene: &self.scene, rest: self, shadows: true, follow, inside }
    }
}

impl Rest for March {
    fn spread(&self, _: &Meeting, _: &Lobe, _: f32, _: &mut Trail) {}

    fn between(&self, _: &Scene, inside: Inside, way: &Way, pairs: &mut Pairs, trail: &mut Trail) {
        let Some(Solution { zones, stored, .. }) = &self.zonal else { return self.travel(inside, way, pairs, trail) };
        let lights = stored.lights.len() as u32;
        let Some(medium) = self.scene.media.current(inside) else { return };
        media::glow(medium, media::column(&self.scene, medium, way), 1.0, trail);
        let depth = medium.extinction;
        zones.walk(&self.scene, inside, way, |zone, _, metres| {
            if let (Some(part), true) = (medium.scattering, zone != NONE) {
                trail.fork();
                trail.branch();
                trail.tint(&Tint::Glow { depth, part, metres });
                for light in 0..lights {
                    trail.stored(zone * lights + light, 1.0);
                }
                trail.branch();
            }
            trail.tint(&medium.inside(metres));
        });
    }

    fn sent(&self, met: Option<&Hit>, direction: Vec3A, weight: f32, _: &mut Pairs, trail: &mut Trail) {
        let (Some(Solution { zones, stored, .. }), Some(hit)) = (&self.zonal, met) else { return };
        let lights = stored.lights.len() as u32;
        if let Some(element) = zones.met(hit, hit.normal.dot(direction) < 0.0) {
            (0..lights).for_each(|light| trail.stored(element * lights + light, weight));
        }
    }
}

impl Method for March {
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut pairs = Pairs::new(sampler, FIRST_PAIR);
        let eye = view::Eye { scene: &self.scene, origin, direction };
        eye.look(
            &mut pairs,
            trail,
            |lobe| lobe.kernel.is_specular(),
            |inside, way, pairs, trail| self.travel(inside, way, pairs, trail),
            |seen: &Seen, lobe, pairs, trail| self.shade(seen.inside).lobe(seen.at, lobe, pairs, trail),
        );
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let at = Meeting::facing(point, normal);
        let mut shade = self.shade(self.scene.inside(point));
        shade.follow = Follow::All;
        shade.lobe(&at, &Lobe::WHITE, &mut Pairs::new(sampler, FIRST_PAIR), trail);
    }

    fn stored(&self) -> &Stored {
        self.zonal.as_ref().map_or(&NOTHING, |z| &z.stored)
    }

    fn report(&self, notes: &Notes) {
        let (ways, taken) = (self.ways.load(Ordering::Relaxed).max(1), self.taken.load(Ordering::Relaxed));
        notes.add(format!(
            "march: {:.1} steps a way, of an optical depth of {}",
            taken as f64 / ways as f64,
            self.step
        ));
        let Some(Solution { zones, account, .. }) = &self.zonal else {
            notes.add("light that has scattered before, or comes from other surfaces, is left out: see --method zonal");
            return;
        };
        notes.add(format!(
            "zonal: {} zones and {} tiles; exchange areas close to {:.1e}, the rays' noise in them {:.1} %; {} steps, residual {:.1e}",
            zones.zones.len(),
            zones.tiles.len(),
            account.closure,
            100.0 * account.noise,
            account.steps,
            account.residual
        ));
        if account.steps >= solve::MOST_STEPS {
            notes.add("the balance did not converge: surfaces and media absorb next to nothing, and light hardly ends");
        }
        if account.thickest > 1.0 {
            notes.add(format!(
                "zones are up to {:.1} mean free paths wide, and blur what goes on in them: more --zones, or --method path",
                account.thickest
            ));
        }
        if self.scene.media.list.iter().any(|m| m.scattering.is_some() && m.phase.mean_cosine().abs() > 0.01) {
            notes.add(
                "zones scatter everywhere alike; the phase function counts for light straight from the lamps only",
            );
        }
    }
}
