//! Paths through media, Eq. (2): what is left of light on the way to a surface, what a medium gives off along it, where it scatters.
//!
//! On each way the lamps are looked at from one place, drawn by how far light flies or by the angle at which the lamp sees it
//! (equiangular), both weighed by the density of either; so that a medium as thin as air shows its beams without waiting for a
//! collision. Apart from that the path itself flies on or scatters by lot. Where it has scattered both find lamps, by power heuristics.

use glam::Vec3A;

use crate::material::Tint;
use crate::medium::Medium;
use crate::medium::density::Way as Line;
use crate::render::direct::power_heuristic;
use crate::render::flight::{Equiangular, Flight};
use crate::render::media;
use crate::render::path::{
    Beside, FIRST_PAIR, MOST_BOUNCES, MOST_SCATTERINGS, ODDS, PAIRS, ROULETTE_FROM, State, Tracer, Way,
};
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::Hit;

/// Pairs of a sampler's numbers that ways through media take, four each, numbered by ways.
const FIRST: u32 = 0x2000_0000;
const EACH: u32 = 4;
/// Columns from which on it goes without end, m.
const LONG: f32 = 1e20;
/// Notes of a path at most: light that hardly ends must not take all memory.
const MOST_NOTES: usize = 1 << 22;

/// What became of a path on its way to a surface.
pub(super) enum Passed {
    /// It is there.
    Through,
    /// It scattered, and has another way.
    Scattered,
    /// It ended.
    Ended,
}

/// A few units in the last place of where a surface was met.
fn last(hit: Option<&Hit>) -> f32 {
    hit.map_or(0.0, |h| 4.0 * f32::EPSILON * h.reach)
}

/// A look at the lamps from a way.
struct Glance {
    /// Chosen from here.
    lamp: usize,
    chance: f32,
    place: f32,
    /// Column up to there, m.
    column: f32,
    /// Density of the place, per unit of the way.
    density: f32,
}

impl<E: Beside> Tracer<'_, E> {
    /// Follows a path through the medium that it is in, as far as the surface that it would meet.
    #[inline(never)]
    pub(super) fn pass(&self, hit: Option<&Hit>, state: &mut State<E>, sampler: &Sampler, trail: &mut Trail) -> Passed {
        let Some(known) = state.beside.known() else { return Passed::Through };
        if let Some(hit) = hit.filter(|h| h.normal.dot(state.direction) > 0.0)
            && let Some(own) = self.scene.materials[hit.surface.material as usize].interior()
            && !known.inside.holds(own)
        {
            // A surface that is not closed, or met by rounding: what is met from behind has been inside.
            known.inside = known.inside.entered(own);
        }
        let number = known.ways;
        known.ways += 1;
        if hit.is_none() && !known.inside.is_empty() {
            // No way out of a body: rounding may have put the place beyond its surface.
            known.inside = self.scene.inside(state.origin);
        }
        let Some(medium) = self.scene.media.current(known.inside) else { return Passed::Through };
        let line = media::between(known.from, state.direction, hit.map(|h| h.point));
        let scatters = medium.scattering.filter(|_| state.bounce < self.max_bounces);
        let nulls = medium.density.by_null_collisions();
        let all = if nulls && medium.glow.is_none() { f32::NAN } else { media::column(self.scene, medium, &line) };
        if all == 0.0 {
            return Passed::Through;
        }
        media::glow(medium, all, state.weight, trail);
        let Some(scattering) = scatters else {
            match nulls {
                true => state.weight *= media::ratio_track(self.scene, medium, &line, &mut known.lots, trail),
                false => self.dim(medium, state, &Tint::Inside { depth: medium.extinction, metres: all }, trail),
            }
            return Passed::Through;
        };
        if state.bounce - known.scatterings >= MOST_BOUNCES
            || known.scatterings >= MOST_SCATTERINGS
            || trail.len() > MOST_NOTES
        {
            self.endless();
            return Passed::Ended;
        }
        let pairs = [0, 1, 2, 3].map(|i| sampler.pair(FIRST + EACH * number + i));
        let flight = self.rates(medium).flight(self.outline, &state.outline);
        let chosen_from = self.glance(medium, &line, all, &flight, state, &pairs, trail);
        let found = match nulls {
            true => self.fly_by_null_collisions(medium, scattering, &line, state, pairs[3], trail),
            false => self.fly(medium, scattering, (&line, all), &flight, state, pairs[3], trail),
        };
        match found {
            None => Passed::Through,
            // Not beyond the surface, by rounding.
            Some(t) => {
                self.scatter(medium, line.at(t.min(line.length - last(hit))), chosen_from, state, sampler, trail)
            }
        }
    }

    /// Draws how far light flies, and notes what becomes of it: where it scatters, or `None` where it reaches the end of the way.
    fn fly(
        &self,
        medium: &Medium,
        scattering: u32,
        (line, all): (&Line, f32),
        flight: &Flight,
        state: &mut State<E>,
        lots: [f32; 2],
        trail: &mut Trail,
    ) -> Option<f32> {
        let depth = medium.extinction;
        let column = flight.column(lots);
        let reached = if column < all { media::reach(self.scene, medium, line, column) } else { None };
        if reached.is_some() {
            state.weight /= flight.density(column);
            self.dim(medium, state, &Tint::Collision { depth, scattering, metres: column }, trail);
        } else {
            state.weight /= flight.survival(all);
            self.dim(medium, state, &Tint::Inside { depth, metres: all }, trail);
        }
        reached
    }

    /// The same without knowing the way's column: at places of the densest medium around light scatters by lot, or nothing happens
    /// [Woodcock 1965; Miller 2019]. The exponentials of all wavelengths are that of the densest, and cancel.
    fn fly_by_null_collisions(
        &self,
        medium: &Medium,
        scattering: u32,
        line: &Line,
        state: &mut State<E>,
        lots: [f32; 2],
        trail: &mut Trail,
    ) -> Option<f32> {
        let (depth, rates) = (medium.extinction, self.rates(medium));
        let flight = rates.flight(self.outline, &state.outline);
        let sigma = flight.chosen(lots[0]);
        // Each rate's density of what has happened, over the densest's.
        let mut odds: Vec<(f32, f32)> = flight.each().map(|(s, share)| (s / rates.most, share)).collect();
        let mut from = 0.0;
        loop {
            let known = state.beside.known()?;
            let column = known.lots.column() / rates.most;
            let Some(c) = media::candidate(self.scene, medium, line, from, column) else {
                state.weight /= odds.iter().map(|o| o.1).sum::<f32>();
                return None;
            };
            from = c.t;
            if known.lots.next() < sigma / rates.most * c.share {
                // Per column of the densest: sigma_s share over sum of the rates' shares.
                state.weight /= odds.iter().map(|(s, o)| s * rates.most * o).sum::<f32>();
                self.dim(medium, state, &Tint::Collision { depth, scattering, metres: 0.0 }, trail);
                return Some(c.t);
            }
            odds.iter_mut().for_each(|(s, o)| *o *= 1.0 - *s * c.share);
            self.dim(medium, state, &Tint::Null { depth, share: c.share / rates.most }, trail);
        }
    }

    /// Looks at a lamp from one place of a way. Returns from where it was chosen.
    #[allow(clippy::too_many_arguments)]
    fn glance(
        &self,
        medium: &Medium,
        line: &Line,
        all: f32,
        flight: &Flight,
        state: &mut State<E>,
        &[for_near, places, mut for_lamp, _]: &[[f32; 2]; 4],
        trail: &mut Trail,
    ) -> Vec3A {
        // Where it is chosen says nothing of where it is looked at: else the weights of both ways to a lamp would not add up to 1.
        let all = if all.is_nan() { media::column(self.scene, medium, line) } else { all };
        let near = flight.within(all, for_near);
        let chosen_from = line.at(media::reach(self.scene, medium, line, near).unwrap_or(0.0));
        let Some((lamp, chance)) = self.scene.tree.choose(chosen_from, None, &mut for_lamp[0]) else {
            return chosen_from;
        };
        let pivot = self.scene.lamps[lamp].aim(chosen_from, for_lamp).and_then(|aim| aim.point);
        let equal = pivot.and_then(|p| {
            let foot = (p - line.origin).dot(line.direction);
            Equiangular::new(foot, (p - line.at(foot)).length(), line.length)
        });
        let Some((place, column)) = self.place(medium, line, all, flight, equal, places) else { return chosen_from };
        let scale = media::density(self.scene, medium, line.at(place));
        let mut density = scale * flight.density_within(column, all);
        density = match equal {
            Some(equal) => 0.5 * (density + equal.density(place)),
            None if all < LONG => 0.5 * (density + scale / all),
            None => density,
        };
        if density > 0.0 && scale > 0.0 {
            let glance = Glance { lamp, chance, place, column, density: density / scale };
            self.look_from(medium, line, &glance, state, for_lamp, trail);
        }
        chosen_from
    }

    /// Draws a place of a way by either density, and the column up to it.
    fn place(
        &self,
        medium: &Medium,
        line: &Line,
        all: f32,
        flight: &Flight,
        equal: Option<Equiangular>,
        lots: [f32; 2],
    ) -> Option<(f32, f32)> {
        let by_flight = |lots: [f32; 2]| {
            let column = flight.within(all, lots);
            Some((media::reach(self.scene, medium, line, column)?, column))
        };
        if equal.is_none() && all >= LONG {
            return by_flight([lots[1], lots[0]]);
        }
        if lots[0] < 0.5 {
            return by_flight([lots[1], 2.0 * lots[0]]);
        }
        let Some(equal) = equal else {
            // From beyond the scene light may be as strong at the far end.
            let column = (2.0 * lots[0] - 1.0) * all;
            return Some((media::reach(self.scene, medium, line, column)?, column));
        };
        let place = equal.place(2.0 * lots[0] - 1.0);
        let within = place > 0.0 && place < line.length;
        within.then(|| (place, media::column(self.scene, medium, &line.up_to(place))))
    }

    /// Notes a lamp's light that scatters at a place of a way.
    fn look_from(
        &self,
        medium: &Medium,
        line: &Line,
        Glance { lamp, chance, place, column, density }: &Glance,
        state: &mut State<E>,
        u: [f32; 2],
        trail: &mut Trail,
    ) {
        let from = line.at(*place);
        let Some(aim) = self.scene.lamps[*lamp].aim(from, u) else { return };
        let value = medium.phase.value(0.5 * (aim.direction - line.direction).length_squared());
        let weight = if aim.pdf.is_finite() {
            let pdf = aim.pdf * chance;
            value / pdf * power_heuristic(pdf, value)
        } else {
            value / chance
        };
        let Some(known) = state.beside.known() else { return };
        let before = trail.len();
        let Some(scattering) = medium.scattering else { return };
        let tint = Tint::Collision { depth: medium.extinction, scattering, metres: *column };
        let weight = weight * media::note(medium, &tint, trail);
        let mut frame = self.polarised.then_some(known.frame);
        if let Some(frame) = &mut frame {
            media::polarise(medium, line.direction, aim.direction, frame, trail);
        }
        let mut inside = media::Bodies { inside: known.inside, from, lots: &mut known.lots };
        match self.direct().light_of(from, *lamp, &aim, frame, Some(&mut inside), trail) {
            Some(share) => trail.light(&aim.emission, state.weight * weight * share / density, trail.len() - before),
            None => trail.truncate(before),
        }
    }

    /// Sends a path on from where it has scattered.
    fn scatter(
        &self,
        medium: &Medium,
        place: Vec3A,
        chosen_from: Vec3A,
        state: &mut State<E>,
        sampler: &Sampler,
        trail: &mut Trail,
    ) -> Passed {
        let [lots, _, for_turn] = sampler.three(FIRST_PAIR + PAIRS * state.bounce);
        let carried = state.weight * self.outline.value(&state.outline);
        if !(carried > 0.0) {
            return Passed::Ended;
        }
        let odds = ODDS * carried / state.share;
        if state.bounce >= ROULETTE_FROM && odds < 1.0 {
            if lots[1] >= odds {
                return Passed::Ended;
            }
            state.weight /= odds;
        }
        let (direction, versine) = medium.phase.turned(state.direction, for_turn);
        if let Some(known) = state.beside.known() {
            if self.polarised {
                media::polarise(medium, state.direction, direction, &mut known.frame, trail);
            }
            known.scatterings += 1;
            known.from = place;
        }
        (state.origin, state.direction) = (place, direction);
        state.way = Way::Scattered { pdf: medium.phase.value(versine), from: place, chosen_from };
        state.bounce += 1;
        Passed::Scattered
    }

    /// Notes what a medium leaves; of a grey one it is a weight.
    fn dim(&self, medium: &Medium, state: &mut State<E>, tint: &Tint, trail: &mut Trail) {
        match medium.grey_share(tint) {
            Some(k) => state.weight *= k,
            None => self.tint(state, tint, trail),
        }
    }
}
