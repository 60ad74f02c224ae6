//! Eq. (2) by steps along a way: in each the light of the lamps that scatters there, and what the medium lets through of all that
//! comes from beyond.
//!
//! A step is a share of an optical depth long, by the densest wavelength that is still seen there, and no longer than a share of the
//! distance to the nearest lamp; what it takes away and gives off is exact for a source that is even in it. Where in the step the lamps
//! are looked at is one number for all steps of a way, which a pixel's samples share evenly.

use glam::Vec3A;

use crate::material::Tint;
use crate::medium::density::Way;
use crate::medium::{Inside, Medium};
use crate::render::direct::Direct;
use crate::render::flight::Rates;
use crate::render::media::{self, Bodies, Lots};
use crate::render::shade::{FEW_LAMPS, Pairs};
use crate::render::trail::Trail;
use crate::scene::Scene;
use crate::scene::light::Lamp;

/// Steps of a way at most.
const MOST_STEPS: usize = 4096;
/// Wavelengths of which less is left count no more.
const SEEN: f32 = 1e-7;

/// One step of a way.
pub struct Step<'a> {
    /// Its medium.
    pub medium: &'a Medium,
    /// Where the lamps are looked at.
    pub place: Vec3A,
    /// The way's direction, from the eye.
    pub direction: Vec3A,
    /// Of all that is noted, where it is no tint.
    pub weight: f32,
}

/// Steps through the media of a scene.
pub struct Steps<'a> {
    /// With its media.
    pub scene: &'a Scene,
    /// Of each medium.
    pub rates: &'a [Rates],
    /// Optical depth of a step, and its length over the distance to a lamp.
    pub step: f32,
}

impl<'a> Steps<'a> {
    /// Notes what a way's medium gives off, and scatters of the lamps' light and of what `more` notes of each step; then what it lets
    /// through, for all that is noted later. Returns how many steps it took.
    pub fn march(
        &self,
        inside: Inside,
        way: &Way,
        pairs: &mut Pairs,
        trail: &mut Trail,
        mut more: impl FnMut(&Step, &mut Trail),
    ) -> usize {
        let Some(medium) = self.scene.media.current(inside) else { return 0 };
        let all = media::column(self.scene, medium, way);
        if all <= 0.0 {
            return 0;
        }
        media::glow(medium, all, 1.0, trail);
        let depth = medium.extinction;
        let Some(scattering) = medium.scattering else {
            let share = media::note(medium, &medium.inside(all), trail);
            trail.scale(share);
            return 1;
        };
        let jitter = pairs.pair()[0];
        let (mut t, mut column, mut weight, mut count) = (0.0f32, 0.0f32, 1.0f32, 0);
        while count < MOST_STEPS && t < way.length {
            let Some((next_t, next)) = self.next(medium, way, t, column, all) else { break };
            let metres = next - column;
            count += 1;
            if metres > 0.0 {
                trail.fork();
                trail.branch();
                let share = media::note(medium, &Tint::Glow { depth, part: scattering, metres }, trail);
                let at = media::reach(self.scene, medium, way, column + jitter * metres).unwrap_or(t);
                let (place, direction, weighed) = (way.at(at), way.direction, weight * share);
                let step = Step { medium, place, direction, weight: weighed };
                self.lamps(&step, inside, pairs, trail);
                more(&step, trail);
                trail.branch();
                weight *= media::note(medium, &medium.inside(metres), trail);
            }
            (t, column) = (next_t, next);
        }
        // What is left beyond the last step that anybody sees.
        if all > column {
            weight *= media::note(medium, &medium.inside(all - column), trail);
        }
        trail.scale(weight);
        count
    }

    /// The end of the step that begins at `t`, and the column up to it.
    fn next(&self, medium: &Medium, way: &Way, t: f32, column: f32, all: f32) -> Option<(f32, f32)> {
        let seen = self.rates[medium.number as usize].sigma().iter().filter(|s| (-**s * column).exp() > SEEN);
        let sigma = seen.fold(0.0f32, |a, b| a.max(*b));
        if sigma <= 0.0 {
            return None;
        }
        let by_depth = column + self.step / sigma;
        let end = media::reach(self.scene, medium, way, by_depth).map_or((way.length, all), |t| (t, by_depth));
        let nearest = t + 2.0 * self.step * self.nearest(way.at(t));
        if nearest < end.0 && nearest > t {
            return Some((nearest, media::column(self.scene, medium, &way.up_to(nearest)).max(column)));
        }
        Some(end)
    }

    /// Distance of the nearest of a few lamps.
    fn nearest(&self, place: Vec3A) -> f32 {
        let distance = |lamp: &Lamp| lamp.aim(place, [0.5; 2]).and_then(|aim| aim.point).map(|p| p.distance(place));
        let few = self.scene.lamps.iter().take(FEW_LAMPS);
        few.filter_map(distance).fold(f32::INFINITY, f32::min)
    }

    /// Notes the light of the lamps that scatters in a step.
    fn lamps(&self, step: &Step, inside: Inside, pairs: &mut Pairs, trail: &mut Trail) {
        let count = self.scene.lamps.len();
        if count <= FEW_LAMPS {
            for lamp in 0..count {
                let u = pairs.pair();
                self.lamp(step, inside, (lamp, 1.0), u, pairs, trail);
            }
            return;
        }
        let mut u = pairs.pair();
        if let Some(chosen) = self.scene.tree.choose(step.place, None, &mut u[0]) {
            self.lamp(step, inside, chosen, u, pairs, trail);
        }
    }

    fn lamp(
        &self,
        step: &Step,
        inside: Inside,
        (lamp, chance): (usize, f32),
        u: [f32; 2],
        pairs: &mut Pairs,
        trail: &mut Trail,
    ) {
        let Some(aim) = self.scene.lamps[lamp].aim(step.place, u) else { return };
        let value = step.medium.phase.value(0.5 * (aim.direction - step.direction).length_squared());
        let density = if aim.pdf.is_finite() { aim.pdf * chance } else { chance };
        let mut lots = Lots::of(self.scene, pairs.sampler());
        let mut bodies = Bodies { inside, from: step.place, lots: &mut lots };
        let direct = Direct { scene: self.scene };
        direct.note(step.place, lamp, &aim, step.weight * value / density, &mut bodies, trail);
    }
}
