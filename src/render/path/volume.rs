//! Paths through media, Eq. (2): what is left of light on the way to a surface, what a medium gives off along it, where it scatters.
//!
//! On each way the lamps are looked at from one place, drawn by how far light flies or by the angle at which the lamp sees it
//! (equiangular), both weighed by the density of either; so that a medium as thin as air shows its beams without waiting for a
//! collision. From there a lamp is aimed at, or a direction in which light would scatter followed to one, weighed alike. Apart from that
//! the path itself flies on or scatters by lot; lamps that it runs into next have been found already.

use glam::Vec3A;

use crate::material::Tint;
use crate::medium::Medium;
use crate::medium::density::Way as Line;
use crate::render::flight::{Equiangular, Flight, Spread};
use crate::render::media::{self, Bodies, Lots};
use crate::render::path::state::{Beside, State, Way};
use crate::render::path::{MOST_BOUNCES, MOST_SCATTERINGS, ROULETTE_FROM, Tracer};
use crate::render::plane;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;
use crate::scene::{Hit, Scene};

/// Pairs of a sampler's numbers that ways through media take, six each, numbered by ways.
const FIRST: u32 = 0x2000_0000;
const EACH: u32 = 6;
/// Where along a way lamps are chosen from, by how far light flies: what is near to any of these places is not left out.
const QUANTILES: [f32; 3] = [0.15, 0.5, 0.85];
/// A path may end by lot where it scatters, with a chance to go on of this times what it carries: measured on the fog box
/// (docs/media.md).
const ODDS: f32 = 1.5;
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

/// Share of looks from a medium that follow its phase function: as narrow as that is beside what lamps look like from the middle of
/// the scene, at most half; none where it is nowhere as narrow as half a sky, which aiming at any lamp is.
pub(super) fn by_phase(scene: &Scene, medium: &Medium) -> f32 {
    let peak = medium.phase.value(0.0).max(medium.phase.value(2.0));
    if peak <= std::f32::consts::FRAC_1_PI * 0.5 {
        return 0.0;
    }
    let one = |lamp: &Lamp| lamp.aim(Vec3A::ZERO, [0.5; 2]).map_or(0.0, |aim| peak / (peak + aim.pdf));
    scene.lamps.iter().map(one).fold(0.0, f32::max).min(0.5)
}

/// How places are drawn beside how far light flies.
enum Second {
    /// By the angle at which a lamp sees them.
    Angles(Equiangular),
    /// By column, where no lamp is nearer to one place than to another.
    Column(Spread),
}

impl Second {
    /// Its share of all places.
    fn share(&self) -> f32 {
        match self {
            Second::Column(spread) if spread.ends() => 0.3,
            _ => 0.25,
        }
    }

    /// Density of a place with a column, where a unit of the way has `scale` metres of it.
    fn density(&self, place: f32, column: f32, scale: f32, flight: &Flight) -> f32 {
        match self {
            Second::Angles(angles) => angles.density(place),
            Second::Column(spread) => scale * spread.density(column, flight),
        }
    }
}

/// A look at the lamps from a way.
struct Glance<'a> {
    medium: &'a Medium,
    /// Places, from one of which the lamp was chosen.
    chosen_from: [Vec3A; QUANTILES.len()],
    /// Share of looks that follow the phase function.
    by_phase: f32,
    place: Vec3A,
    /// Column up to there, m.
    column: f32,
    /// Density of the place, per column.
    density: f32,
}

impl Glance<'_> {
    /// Density of a direction by both ways to draw one, 1/sr.
    fn both(&self, by_lamp: f32, by_phase: f32) -> f32 {
        (1.0 - self.by_phase) * by_lamp + self.by_phase * by_phase
    }

    /// Notes that light scatters there, over the density of the place; what of it is a number.
    fn collision(&self, trail: &mut Trail) -> f32 {
        let Medium { extinction: depth, scattering, .. } = *self.medium;
        let over = 1.0 / self.density;
        let tint = scattering.map(|scattering| Tint::Collision { depth, scattering, metres: self.column, over });
        tint.map_or(0.0, |tint| media::note(self.medium, &tint, trail))
    }
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
        let all = media::column(self.scene, medium, &line);
        if all == 0.0 {
            return Passed::Through;
        }
        media::glow(medium, all, state.weight, trail);
        let Some(scattering) = scatters else {
            match nulls {
                true => state.weight *= media::ratio_track(self.scene, medium, &line, &mut known.lots, trail),
                false => self.dim(medium, state, &medium.inside(all), trail),
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
        let first = FIRST + EACH * number;
        let ([lots, places, for_way], [choice, flown, for_turn]) = (sampler.three(first), sampler.three(first + 3));
        let flight = self.rates(medium).flight(self.outline, &state.outline, all);
        self.glance(medium, (&line, all), &flight, state, [lots, places, for_way, choice], trail);
        let found = match nulls {
            true => self.fly_by_null_collisions((medium, scattering), &line, &flight, state, flown, trail),
            false => self.fly((medium, scattering), (&line, all), &flight, state, flown, trail),
        };
        match found {
            None => Passed::Through,
            // Not beyond the surface, by rounding.
            Some(t) => {
                let place = line.at(t.min(line.length - last(hit)));
                if state.bounce == 0 && self.split > 1 {
                    self.spread(medium, place, state, first, sampler, trail);
                    return Passed::Ended;
                }
                self.scatter(medium, place, state, (lots[1], for_turn), trail)
            }
        }
    }

    /// Draws how far light flies, and notes what becomes of it: where it scatters, or `None` where it reaches the end of the way.
    fn fly(
        &self,
        (medium, scattering): (&Medium, u32),
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
            let over = 1.0 / flight.density(column);
            self.dim(medium, state, &Tint::Collision { depth, scattering, metres: column, over }, trail);
        } else {
            let over = 1.0 / flight.survival();
            self.dim(medium, state, &Tint::Inside { depth, metres: all, over }, trail);
        }
        reached
    }

    /// The same without knowing the way's column: at places of the densest medium around light scatters by lot, or nothing happens
    /// [Woodcock 1965; Miller 2019]. The exponentials of all wavelengths are that of the densest, and cancel.
    fn fly_by_null_collisions(
        &self,
        (medium, scattering): (&Medium, u32),
        line: &Line,
        flight: &Flight,
        state: &mut State<E>,
        lots: [f32; 2],
        trail: &mut Trail,
    ) -> Option<f32> {
        let (depth, rates) = (medium.extinction, self.rates(medium));
        let sigma = flight.choose(lots[0]);
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
            if known.lots.draw() < sigma / rates.most * c.share {
                // Per column of the densest: sigma_s share over sum of the rates' shares.
                let over = 1.0 / odds.iter().map(|(s, o)| s * rates.most * o).sum::<f32>();
                self.dim(medium, state, &Tint::Collision { depth, scattering, metres: 0.0, over }, trail);
                return Some(c.t);
            }
            odds.iter_mut().for_each(|(s, o)| *o *= 1.0 - *s * c.share);
            self.dim(medium, state, &Tint::Null { depth, share: c.share / rates.most }, trail);
        }
    }

    /// Looks for a lamp's light from one place of a way, or along a direction in which it would scatter there: all that scatters once
    /// before it comes to a lamp is found so.
    fn glance(
        &self,
        medium: &Medium,
        (line, all): (&Line, f32),
        flight: &Flight,
        state: &mut State<E>,
        [lots, places, for_way, choice]: [[f32; 2]; 4],
        trail: &mut Trail,
    ) {
        let mut for_lamp = for_way;
        let chosen_from = self.vantages(medium, line, flight, lots[0]);
        let Some((lamp, chance)) = self.choose(&chosen_from, choice[1], &mut for_lamp[0]) else { return };
        let pivot = self.scene.lamps[lamp].pivot(for_lamp);
        let angles = pivot.and_then(|p| {
            let foot = (p - line.origin).dot(line.direction);
            Equiangular::new(foot, (p - line.at(foot)).length(), line.length)
        });
        let second = angles.map_or_else(|| Second::Column(Spread::new(all, flight)), Second::Angles);
        let Some((place, column)) = self.place(medium, line, flight, &second, places) else { return };
        let scale = media::density(self.scene, medium, line.at(place));
        let (share, other) = (second.share(), second.density(place, column, scale, flight));
        let density = (1.0 - share) * scale * flight.density_within(column) + share * other;
        if density > 0.0 && scale > 0.0 {
            let by_phase = self.by_phase[medium.number as usize];
            let glance =
                Glance { medium, chosen_from, by_phase, place: line.at(place), column, density: density / scale };
            if choice[0] < by_phase {
                self.look_along(&glance, line.direction, state, for_way, trail);
            } else {
                self.look_from(&glance, line.direction, state, (lamp, chance), for_lamp, trail);
            }
        }
    }

    /// Places of a way from which a lamp is chosen, where there is a choice. They say nothing of where it is looked at: else the shares
    /// of both ways to it would not sum to 1.
    fn vantages(&self, medium: &Medium, line: &Line, flight: &Flight, lot: f32) -> [Vec3A; QUANTILES.len()] {
        let mut places = [line.origin; QUANTILES.len()];
        if self.scene.lamps.len() > 1 {
            for (place, q) in places.iter_mut().zip(QUANTILES) {
                let column = flight.within([lot, q]);
                *place = line.at(media::reach(self.scene, medium, line, column).unwrap_or(0.0));
            }
        }
        places
    }

    /// Chooses a lamp from one of these places, with its chance from any of them; a number that helps comes back in 0..1.
    fn choose(&self, from: &[Vec3A], lot: f32, u: &mut f32) -> Option<(usize, f32)> {
        if self.scene.lamps.len() == 1 {
            return Some((0, 1.0));
        }
        let place = from[((lot * from.len() as f32) as usize).min(from.len() - 1)];
        let (lamp, _) = self.scene.tree.choose(place, None, u)?;
        Some((lamp, self.chance(lamp, from)))
    }

    /// Chance of a lamp, chosen from any of these places.
    fn chance(&self, lamp: usize, from: &[Vec3A]) -> f32 {
        if self.scene.lamps.len() == 1 {
            return 1.0;
        }
        from.iter().map(|p| self.scene.tree.chance(lamp, *p, None)).sum::<f32>() / from.len() as f32
    }

    /// Draws a place of a way by either density, and the column up to it.
    fn place(
        &self,
        medium: &Medium,
        line: &Line,
        flight: &Flight,
        second: &Second,
        [lot, other]: [f32; 2],
    ) -> Option<(f32, f32)> {
        let reach = |column: f32| Some((media::reach(self.scene, medium, line, column)?, column));
        let share = second.share();
        if lot >= share {
            return reach(flight.within([other, (lot - share) / (1.0 - share)]));
        }
        let lot = lot / share;
        match second {
            Second::Column(spread) => reach(spread.column([other, lot], flight)),
            Second::Angles(angles) => {
                let place = angles.place(lot);
                let within = place > 0.0 && place < line.length;
                within.then(|| (place, media::column(self.scene, medium, &line.up_to(place))))
            }
        }
    }

    /// Notes a lamp's light that scatters at a place of a way.
    fn look_from(
        &self,
        glance: &Glance,
        direction: Vec3A,
        state: &mut State<E>,
        (lamp, chance): (usize, f32),
        u: [f32; 2],
        trail: &mut Trail,
    ) {
        let Glance { medium, by_phase, place, .. } = *glance;
        let Some(aim) = self.scene.lamps[lamp].aim(place, u) else { return };
        let value = medium.phase.value(0.5 * (aim.direction - direction).length_squared());
        let weight = if aim.pdf.is_finite() {
            value / glance.both(aim.pdf * chance, value)
        } else {
            value / (chance * (1.0 - by_phase))
        };
        let Some(known) = state.beside.known() else { return };
        let before = trail.aside();
        let weight = weight * glance.collision(trail) * state.weight;
        let mut frame = self.polarised.then_some(known.frame);
        if let Some(frame) = &mut frame {
            media::polarise(medium, direction, aim.direction, frame, trail);
        }
        let mut bodies = Bodies { inside: known.inside, from: place, lots: &mut known.lots };
        match self.direct().light_of(place, lamp, &aim, frame, Some(&mut bodies), trail) {
            Some(share) => trail.light(&aim.emission, weight * share, trail.len() - before),
            None => trail.truncate(before),
        }
    }

    /// Notes the lamps that are met where light scatters to at a place of a way.
    fn look_along(&self, glance: &Glance, direction: Vec3A, state: &mut State<E>, u: [f32; 2], trail: &mut Trail) {
        let Glance { medium, chosen_from, place, .. } = *glance;
        let (toward, versine) = medium.phase.turned(direction, u);
        let value = medium.phase.value(versine);
        let Some(known) = state.beside.known() else { return };
        let before = trail.aside();
        let weight = glance.collision(trail) * state.weight * value;
        let mut frame = self.polarised.then_some(known.frame);
        if let Some(frame) = &mut frame {
            media::polarise(medium, direction, toward, frame, trail);
        }
        let mut bodies = Bodies { inside: known.inside, from: place, lots: &mut known.lots };
        let found = self.direct().along(place, toward, &mut frame, Some(&mut bodies), trail);
        let aside = trail.len() - before;
        let chance = |lamp: usize| self.chance(lamp, &chosen_from);
        match found {
            None => trail.truncate(before),
            Some((Some(hit), share)) => {
                let lamp = hit.surface.emitter.map_or(0, |l| l as usize);
                let Lamp::Area(emitter) = &self.scene.lamps[lamp] else { return trail.truncate(before) };
                let pdf = emitter.pdf(place, hit.point, hit.normal) * chance(lamp);
                let emission = emitter.emission(-hit.normal.dot(toward));
                trail.light(&emission, weight * share / glance.both(pdf, value), aside);
            }
            Some((None, share)) => {
                // Each of them has a copy of what is on the way.
                let mut first = true;
                for lamp in self.scene.tree.distant() {
                    let Some((emission, pdf)) = self.scene.lamps[lamp].beyond(toward) else { continue };
                    let start = trail.len();
                    if !first {
                        trail.repeat(before, aside);
                    }
                    let own = if first { before } else { start };
                    first = false;
                    if let Some(frame) = frame {
                        plane::lamp(&self.scene.lamps[lamp], toward, frame, trail);
                    }
                    let weight = weight * share / glance.both(pdf * chance(lamp), value);
                    trail.light(&emission, weight, trail.len() - own);
                }
                if first {
                    trail.truncate(before);
                }
            }
        }
    }

    /// Several paths go on from where light scatters that has met no surface before, as they do from a surface.
    fn spread(
        &self,
        medium: &Medium,
        place: Vec3A,
        state: &mut State<E>,
        first: u32,
        sampler: &Sampler,
        trail: &mut Trail,
    ) {
        let share = 1.0 / self.split as f32;
        state.share *= share;
        state.weight *= share;
        trail.fork();
        for k in 0..self.split {
            let (mut state, sampler) = (state.clone(), sampler.branch(k, self.split));
            state.beside.known().into_iter().for_each(|known| known.lots = Lots::of(self.scene, &sampler));
            trail.branch();
            let for_turn = sampler.pair(first + EACH - 1);
            if let Passed::Scattered = self.scatter(medium, place, &mut state, (0.0, for_turn), trail) {
                self.follow(state, &sampler, trail);
            }
        }
    }

    /// Sends a path on from where it has scattered.
    fn scatter(
        &self,
        medium: &Medium,
        place: Vec3A,
        state: &mut State<E>,
        (lot, for_turn): (f32, [f32; 2]),
        trail: &mut Trail,
    ) -> Passed {
        let carried = state.weight * self.outline.value(&state.outline);
        if carried.is_nan() || carried <= 0.0 {
            return Passed::Ended;
        }
        let odds = ODDS * carried / state.share;
        if state.bounce >= ROULETTE_FROM && odds < 1.0 {
            if lot >= odds {
                return Passed::Ended;
            }
            state.weight /= odds;
        }
        let (direction, _) = medium.phase.turned(state.direction, for_turn);
        if let Some(known) = state.beside.known() {
            if self.polarised {
                media::polarise(medium, state.direction, direction, &mut known.frame, trail);
            }
            known.scatterings += 1;
            known.from = place;
        }
        (state.origin, state.direction) = (place, direction);
        state.way = Way::Scattered;
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
