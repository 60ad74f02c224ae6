//! Path tracing with next event estimation and multiple importance sampling [Veach 1997].
//!
//! Where a path meets a surface one of the material's lobes is chosen by lot; the lamps are asked for light through that
//! lobe, and the path goes on along it. Where it goes is the same for all wavelengths. What happens to them is noted on the
//! path's [`Trail`]; on the way only an outline of it is known, eight numbers that say how much the path still carries.
//!
//! In scenes with effects beyond Eq. (1) a path may split where wavelengths go apart ([`Comb`]), knows the body that it is in and,
//! where polarization counts, the frame of its Stokes vectors ([`plane`]). All that is compiled apart: other scenes have none of it.

mod beneath;
mod pooled;
mod state;
mod volume;

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3A;

use crate::material::{Lobe, Lobes, Tint};
use crate::medium::{Inside, Medium};
use crate::notes::Notes;
use crate::render::comb::{Comb, Parts};
use crate::render::direct::{Direct, power_heuristic};
use crate::render::flight::Rates;
use crate::render::inks::Outline;
use crate::render::lanes::Lanes;
use crate::render::media::{Bodies, Lots};
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::plane;
use crate::render::pool::Pool;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;
use crate::scene::{Hit, Scene, ray};
use beneath::Dipoles;
use state::{Beside, Known, State, Way};
use volume::Passed;

/// From this bounce on a path may end by lot, with a chance to go on of this times what it carries: measured on the Cornell
/// box and a mesh (docs/performance.md).
const ROULETTE_FROM: u32 = 1;
const ODDS: f32 = 4.0;
/// The same between mirrors.
const MIRRORS: u32 = 32;
/// A path that has not ended by now never will: in a closed room of white walls light has no end.
const MOST_BOUNCES: u32 = 2048;
/// The same within media, where light of a thick cloud scatters a million times before it leaves.
const MOST_SCATTERINGS: u32 = 1 << 24;

/// Pairs of a sampler's numbers: two before the first surface, three a bounce.
const FIRST_PAIR: u32 = 2;
const PAIRS: u32 = 3;

/// The pair that says where wavelengths lie at which a path splits: one for the whole of it.
const WAVELENGTHS: u32 = 0x4000_0000;

/// What can be asked of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Most bounces; light that comes straight from a lamp has none.
    pub max_bounces: u32,
    /// Paths that go on from the first surface that the eye sees, and looks at its lamps, from 1: most of what makes a picture
    /// noisy comes after it.
    pub split: u32,
    /// Paths of neighbouring pixels are pooled ([`crate::render::pool`]).
    pub pool: bool,
}

/// Path tracing of a scene.
pub struct PathTracing {
    scene: Arc<Scene>,
    outline: Outline,
    options: Options,
    comb: Comb,
    polarised: bool,
    /// Of each medium, and the share of looks at lamps from it that follow its phase function.
    rates: Vec<Rates>,
    by_phase: Vec<f32>,
    /// Of each body that is one, by number.
    dipoles: Vec<(u32, Dipoles)>,
    /// A place, and the bodies that it is in: the camera's.
    eye: Option<(Vec3A, Inside)>,
    /// Paths that were ended at [`MOST_BOUNCES`].
    endless: AtomicU64,
}

impl PathTracing {
    /// Of a scene whose spectra have this outline, for these wavelengths; with Stokes vectors or without.
    pub fn new(scene: Arc<Scene>, outline: Outline, options: Options, comb: Comb, polarised: bool) -> PathTracing {
        let rates = Rates::of(&scene.media, &outline);
        let by_phase = scene.media.list.iter().map(|m| volume::by_phase(&scene, m)).collect();
        let dipoles = (0..scene.inks.len() as u32).filter_map(|i| Some((i, Dipoles::new(&outline, i)?))).collect();
        let place = scene.camera.as_ref().and_then(|c| c.ray(0.5, 0.5, [0.5; 2])).map(|r| r.0);
        let eye = place.map(|p| (p, scene.inside(p)));
        PathTracing {
            scene,
            outline,
            options,
            comb,
            polarised,
            rates,
            by_phase,
            dipoles,
            eye,
            endless: AtomicU64::new(0),
        }
    }

    fn has_effects(&self) -> bool {
        self.polarised || self.scene.effects.any() || self.scene.is_filled()
    }

    fn tracer<E: Beside>(&self) -> Tracer<'_, E> {
        let PathTracing { scene, outline, options: Options { max_bounces, split, .. }, comb, .. } = self;
        let (max_bounces, split, polarised) = (*max_bounces, *split, self.polarised);
        let (rates, by_phase, dipoles) = (&self.rates, &self.by_phase, &self.dipoles);
        let (eye, endless) = (self.eye, &self.endless);
        Tracer {
            scene,
            outline,
            max_bounces,
            split,
            comb,
            polarised,
            rates,
            by_phase,
            dipoles,
            eye,
            endless,
            beside: PhantomData,
        }
    }
}

impl Method for PathTracing {
    fn pools(&self) -> bool {
        // A lamp that a head's own path meets is its alone: only what surfaces send on is pooled.
        self.options.pool && self.options.max_bounces > 1 && !self.has_effects()
    }

    fn pooled(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail, pool: &mut Pool) {
        self.tracer::<()>().pooled(origin, direction, sampler, trail, pool);
    }

    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        if self.has_effects() {
            self.tracer::<Known>().radiance(origin, direction, sampler, trail);
        } else {
            self.tracer::<()>().radiance(origin, direction, sampler, trail);
        }
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        if self.has_effects() {
            self.tracer::<Known>().irradiance(point, normal, sampler, trail);
        } else {
            self.tracer::<()>().irradiance(point, normal, sampler, trail);
        }
    }

    fn report(&self, notes: &Notes) {
        let endless = self.endless.load(Ordering::Relaxed);
        if endless > 0 {
            notes.add(format!(
                "{endless} paths were cut after {MOST_BOUNCES} bounces: light hardly ends in this scene, and what is left of it \
                 is missing"
            ));
        }
    }
}

/// Traces paths through a scene, with effects or without. Cheap to make.
struct Tracer<'a, E> {
    scene: &'a Scene,
    outline: &'a Outline,
    max_bounces: u32,
    split: u32,
    comb: &'a Comb,
    polarised: bool,
    rates: &'a [Rates],
    by_phase: &'a [f32],
    dipoles: &'a [(u32, Dipoles)],
    eye: Option<(Vec3A, Inside)>,
    endless: &'a AtomicU64,
    beside: PhantomData<E>,
}

impl<'a, E: Beside> Tracer<'a, E> {
    fn start(&self, (origin, direction): (Vec3A, Vec3A), way: Way, frame: Vec3A, sampler: &Sampler) -> State<E> {
        let inside = || match self.eye {
            _ if !self.scene.is_filled() => (Inside::default(), Lots::of(self.scene, sampler)),
            Some((place, inside)) if place == origin => (inside, Lots::of(self.scene, sampler)),
            _ => (self.scene.inside(origin), Lots::of(self.scene, sampler)),
        };
        let beside = E::new(self.comb.single(), origin, frame, inside);
        State { origin, direction, way, bounce: 0, weight: 1.0, share: 1.0, outline: Lanes::splat(1.0), beside }
    }

    /// Follows one path from the eye and leaves its trail: radiance.
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut state = self.start((origin, direction), Way::Straight, trail.frame, sampler);
        let Some((meeting, lobe)) = self.arrive(&mut state, sampler, trail) else { return };
        self.beyond_first(state, &meeting, &lobe, sampler, trail);
    }

    /// From the first surface on.
    fn beyond_first(&self, mut state: State<E>, meeting: &Meeting, lobe: &Lobe, sampler: &Sampler, trail: &mut Trail) {
        if let Some(parts) = self.parts(&mut state, meeting, lobe, sampler) {
            return self.go_apart(&state, meeting, lobe, &parts, sampler, trail);
        }
        if self.split == 1 || lobe.kernel.is_specular() {
            return self.go(state, meeting, lobe, sampler, trail);
        }
        state.share = 1.0 / self.split as f32;
        state.weight *= state.share;
        trail.fork();
        for k in 0..self.split {
            trail.branch();
            self.go(state.clone(), meeting, lobe, &sampler.branch(k, self.split), trail);
        }
    }

    /// Leaves a surface and follows the path to its end.
    #[inline(always)]
    fn go(&self, mut state: State<E>, meeting: &Meeting, lobe: &Lobe, sampler: &Sampler, trail: &mut Trail) {
        if self.go_on(&mut state, meeting, lobe, sampler, trail) {
            self.follow(state, sampler, trail);
        }
    }

    /// Follows one path from a point and leaves the trail of what falls on it: irradiance over pi, as a white matt surface would
    /// show it.
    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let meeting = Meeting::facing(point, normal);
        let frame = self.polarised.then_some(Vec3A::X);
        let mut inside = self.scene.is_filled().then(|| (self.scene.inside(point), Lots::of(self.scene, sampler)));
        let bodies = inside.as_mut().map(|(inside, lots)| Bodies { inside: *inside, from: point, lots });
        self.direct().look(&meeting, &Lobe::WHITE, 1.0, sampler.pair(0), (frame, bodies), trail);
        if let Some(turn) = Lobe::WHITE.kernel.sample(Vec3A::Z, sampler.pair(1)) {
            let (origin, normal) = meeting.start(false);
            let way = Way::Lobe { pdf: turn.pdf, from: origin, normal };
            let direction = meeting.world(turn.inc);
            if self.polarised {
                trail.depolarise();
            }
            let frame = plane::across(direction);
            self.follow(self.start((origin, direction), way, frame, sampler), sampler, trail);
        }
    }

    fn direct(&self) -> Direct<'a> {
        Direct { scene: self.scene }
    }

    /// Follows a path to its end.
    fn follow(&self, mut state: State<E>, sampler: &Sampler, trail: &mut Trail) {
        while let Some((meeting, lobe)) = self.arrive(&mut state, sampler, trail) {
            if let Some(parts) = self.parts(&mut state, &meeting, &lobe, sampler) {
                return self.go_apart(&state, &meeting, &lobe, &parts, sampler, trail);
            }
            if !self.go_on(&mut state, &meeting, &lobe, sampler, trail) {
                return;
            }
        }
    }

    /// Into how many parts a path splits at a lobe, if it does.
    #[inline(always)]
    fn parts(&self, state: &mut State<E>, meeting: &Meeting, lobe: &Lobe, sampler: &Sampler) -> Option<Parts> {
        if state.beside.known()?.nm.is_some() || !self.scene.effects.disperses {
            return None;
        }
        let spread = lobe.kernel.spread(meeting.out);
        if spread > 0.0 { self.comb.parts(spread, sampler.pair(WAVELENGTHS)[0]) } else { None }
    }

    /// Leaves a surface in parts, each with the wavelengths that go about its way. All take the same numbers: what differs between
    /// them is their wavelength alone.
    #[inline(never)]
    fn go_apart(
        &self,
        state: &State<E>,
        meeting: &Meeting,
        lobe: &Lobe,
        parts: &Parts,
        sampler: &Sampler,
        trail: &mut Trail,
    ) {
        trail.fork();
        for k in 0..parts.count {
            let (window, nm) = self.comb.part(parts, k);
            let mut state = state.clone();
            state.beside.known().into_iter().for_each(|known| known.nm = Some(nm));
            trail.branch();
            trail.tint(&Tint::Window(window));
            if self.go_on(&mut state, meeting, lobe, sampler, trail) {
                self.follow(state, sampler, trail);
            }
        }
        trail.join();
    }

    /// Goes to the next surface, takes its light and chooses a lobe by lot; `None` where the path ends there. On the way it may
    /// scatter.
    #[inline(always)]
    fn arrive(&self, state: &mut State<E>, sampler: &Sampler, trail: &mut Trail) -> Option<(Meeting, Lobe<'a>)> {
        let hit = loop {
            let hit = self.scene.geometry.closest(state.origin, state.direction);
            if E::EFFECTS && self.scene.is_filled() {
                match self.pass(hit.as_ref(), state, sampler, trail) {
                    Passed::Through => {}
                    Passed::Scattered => continue,
                    Passed::Ended => return None,
                }
                if let Some(hit) = &hit
                    && self.crosses(hit, state)
                {
                    continue;
                }
            }
            let Some(hit) = hit else {
                self.leave(state, trail);
                return None;
            };
            break hit;
        };
        let front = hit.normal.dot(state.direction) < 0.0;
        if let Some(lamp) = hit.surface.emitter.filter(|_| front) {
            self.meet(lamp as usize, &hit, state, trail);
        }
        if state.bounce >= self.max_bounces {
            return None;
        }
        let scatterings = state.beside.known().map_or(0, |known| known.scatterings);
        if state.bounce - scatterings >= MOST_BOUNCES {
            self.endless();
            return None;
        }
        let pair = FIRST_PAIR + PAIRS * state.bounce;
        let (site, shading) = self.scene.site(&hit, front);
        let mut meeting = Meeting::new(&hit, front, shading, state.direction);
        let scene: &'a Scene = self.scene;
        let material = &scene.materials[hit.surface.material as usize];
        if E::EFFECTS {
            if let Some(axis) = material.axis(&site) {
                meeting.align(axis.as_vec3a());
            }
            meeting.interior = material.interior().map(|medium| (medium, front));
        }
        let lobe = match material.only(&site) {
            Some(lobe) => {
                meeting.matt &= lobe.kernel.is_matt() && !lobe.kernel.transmits();
                lobe
            }
            None => {
                meeting.matt = false;
                let mut lobes = Lobes::default();
                material.lobes(&site, meeting.out, &mut lobes);
                let lot = if lobes.len() > 1 { sampler.pair(pair)[0] } else { 0.0 };
                lobes.choose(lot)?
            }
        };
        state.weight *= lobe.factor;
        if E::EFFECTS && self.polarised && lobe.polar.is_none() {
            trail.depolarise();
        }
        if E::EFFECTS
            && let Some(ink) = material.dipole(&lobe)
        {
            let meeting = self.beneath(ink, &hit, &meeting, state, sampler, trail)?;
            return Some((meeting, Lobe { tint: Tint::None, ..lobe }));
        }
        if !lobe.tint.turns() {
            self.tint(state, &lobe.tint, trail);
        }
        Some((meeting, lobe))
    }

    /// Goes through a surface that does nothing to light but tell media apart; false where it does more.
    fn crosses(&self, hit: &Hit, state: &mut State<E>) -> bool {
        let material = &self.scene.materials[hit.surface.material as usize];
        if !material.is_void() || hit.surface.emitter.is_some() {
            return false;
        }
        let front = hit.normal.dot(state.direction) < 0.0;
        if let Some(known) = state.beside.known() {
            known.inside = known.inside.beyond(material.interior(), front);
            known.from = hit.point;
        }
        state.origin = ray::onward(hit.point, state.direction, hit.normal, hit.reach);
        true
    }

    /// A path is cut.
    fn endless(&self) {
        self.endless.fetch_add(1, Ordering::Relaxed);
    }

    fn rates(&self, medium: &Medium) -> &Rates {
        &self.rates[medium.number as usize]
    }

    /// Asks the lamps through a lobe and leaves the surface along it; false where the path ends by lot or has nowhere to go.
    #[inline(always)]
    fn go_on(
        &self,
        state: &mut State<E>,
        meeting: &Meeting,
        lobe: &Lobe,
        sampler: &Sampler,
        trail: &mut Trail,
    ) -> bool {
        if let Some(nm) = state.beside.known().and_then(|known| known.nm)
            && let Some(single) = lobe.kernel.at(nm)
        {
            return self.leave_by(state, meeting, &Lobe { kernel: &single, ..*lobe }, sampler, trail);
        }
        self.leave_by(state, meeting, lobe, sampler, trail)
    }

    #[inline(always)]
    fn leave_by(
        &self,
        state: &mut State<E>,
        meeting: &Meeting,
        lobe: &Lobe,
        sampler: &Sampler,
        trail: &mut Trail,
    ) -> bool {
        let [lots, for_lamp, for_turn] = sampler.three(FIRST_PAIR + PAIRS * state.bounce);
        if !lobe.kernel.is_specular() {
            let filled = E::EFFECTS && self.scene.is_filled();
            let beside = state.beside.known().map_or((None, None), |known| {
                let inside = if lobe.kernel.transmits() { meeting.beyond(known.inside) } else { known.inside };
                let bodies = filled.then_some(Bodies { inside, from: meeting.point, lots: &mut known.lots });
                (self.polarised.then_some(known.frame), bodies)
            });
            self.direct().look(meeting, lobe, state.weight, for_lamp, beside, trail);
        }
        self.turn(state, meeting, lobe, (lots[1], for_turn), trail)
    }

    /// Leaves a surface along a lobe; false where the path ends by lot or has nowhere to go.
    #[inline(always)]
    fn turn(
        &self,
        state: &mut State<E>,
        meeting: &Meeting,
        lobe: &Lobe,
        (lot, for_turn): (f32, [f32; 2]),
        trail: &mut Trail,
    ) -> bool {
        let Some(turn) = lobe.kernel.sample(meeting.out, for_turn) else { return false };
        if lobe.tint.turns() {
            self.tint(state, &lobe.tint.turned(meeting.out, turn.inc), trail);
        }
        if let Some(known) = state.beside.known() {
            if self.polarised {
                plane::follow(meeting, lobe, turn.inc, &mut known.frame, trail);
            }
            if lobe.kernel.transmits() {
                known.inside = meeting.beyond(known.inside);
            }
            known.from = meeting.point;
        }
        state.weight *= turn.weight;
        let carried = state.weight * self.outline.value(&state.outline);
        if carried <= 0.0 {
            return false;
        }
        let odds = ODDS * carried / state.share;
        // Chains of mirrors are short as a rule, and what comes at their end is worth its price.
        let from = if lobe.kernel.is_specular() { MIRRORS } else { ROULETTE_FROM };
        if state.bounce >= from && odds < 1.0 {
            if lot >= odds {
                return false;
            }
            state.weight /= odds;
        }
        state.direction = unit(meeting.world(turn.inc));
        let (from, normal) = meeting.start(lobe.kernel.transmits());
        // A shading normal may send light through a surface that lets none pass.
        if state.direction.dot(normal) <= 0.0 {
            return false;
        }
        state.origin = from;
        if turn.pdf.is_finite() {
            state.way = Way::Lobe { pdf: turn.pdf, from, normal };
        } else if !lobe.kernel.is_straight() {
            state.way = Way::Straight;
        }
        state.bounce += 1;
        true
    }

    /// Notes what a surface does to the wavelengths.
    fn tint(&self, state: &mut State<E>, tint: &Tint, trail: &mut Trail) {
        self.outline.tint(&mut state.outline, tint);
        trail.tint(tint);
    }

    /// A path ran into a lamp: weighed against the chance of having aimed at it.
    fn meet(&self, lamp: usize, hit: &Hit, state: &State<E>, trail: &mut Trail) {
        let Lamp::Area(emitter) = &self.scene.lamps[lamp] else { return };
        let weight = self.against(lamp, state, |from| emitter.pdf(from, hit.point, hit.normal));
        if weight > 0.0 {
            trail.light(&emitter.emission(-hit.normal.dot(state.direction)), weight * state.weight, 0);
        }
    }

    /// Weight of a way that found a lamp which could have been aimed at, with a density of directions there from a place.
    #[inline(always)]
    fn against(&self, lamp: usize, state: &State<E>, density: impl FnOnce(Vec3A) -> f32) -> f32 {
        let (pdf, from, chance) = match state.way {
            Way::Straight => return 1.0,
            Way::Lobe { pdf, from, normal } => (pdf, from, self.scene.tree.chance(lamp, from, Some(normal))),
            Way::Scattered => return 0.0,
        };
        power_heuristic(pdf, if chance > 0.0 { density(from) * chance } else { 0.0 })
    }

    /// A path left the scene: what lies beyond.
    fn leave(&self, state: &mut State<E>, trail: &mut Trail) {
        if matches!(state.way, Way::Scattered) {
            return;
        }
        for lamp in self.scene.tree.distant() {
            let Some((emission, pdf)) = self.scene.lamps[lamp].beyond(state.direction) else { continue };
            let before = trail.aside();
            if let Some(known) = state.beside.known().filter(|_| self.polarised) {
                plane::lamp(&self.scene.lamps[lamp], state.direction, known.frame, trail);
            }
            let weight = self.against(lamp, state, |_| pdf);
            trail.light(&emission, weight * state.weight, trail.len() - before);
        }
    }
}

/// A vector that is a unit vector but for rounding, without a root.
fn unit(v: Vec3A) -> Vec3A {
    v * (1.5 - 0.5 * v.length_squared())
}
