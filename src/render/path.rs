//! Path tracing with next event estimation and multiple importance sampling [Veach 1997].
//!
//! Where a path meets a surface one of the material's lobes is chosen by lot; the lamps are asked for light through that
//! lobe, and the path goes on along it. Where it goes is the same for all wavelengths. What happens to them is noted on the
//! path's [`Trail`]; on the way only an outline of it is known, eight numbers that say how much the path still carries.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3A;

use crate::material::{Lobe, Lobes, Tint};
use crate::notes::Notes;
use crate::render::direct::{Direct, power_heuristic};
use crate::render::inks::Outline;
use crate::render::lanes::Lanes;
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;
use crate::scene::{Hit, Scene};

/// From this bounce on a path may end by lot, with a chance to go on of this times what it carries: measured on the Cornell
/// box and a mesh (docs/performance.md).
const ROULETTE_FROM: u32 = 1;
const ODDS: f32 = 4.0;
/// The same between mirrors.
const MIRRORS: u32 = 32;
/// A path that has not ended by now never will: in a closed room of white walls light has no end.
const MOST_BOUNCES: u32 = 2048;

/// Pairs of a sampler's numbers: two before the first surface, three a bounce.
const FIRST_PAIR: u32 = 2;
const PAIRS: u32 = 3;

/// What can be asked of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Most bounces; light that comes straight from a lamp has none.
    pub max_bounces: u32,
    /// Paths that go on from the first surface that the eye sees, and looks at its lamps, from 1: most of what makes a picture
    /// noisy comes after it.
    pub split: u32,
}

/// Path tracing of a scene.
pub struct PathTracing {
    scene: Arc<Scene>,
    outline: Outline,
    options: Options,
    /// Paths that were ended at [`MOST_BOUNCES`].
    endless: AtomicU64,
}

impl PathTracing {
    /// Of a scene whose spectra have this outline.
    pub fn new(scene: Arc<Scene>, outline: Outline, options: Options) -> PathTracing {
        PathTracing { scene, outline, options, endless: AtomicU64::new(0) }
    }

    fn tracer(&self) -> Tracer<'_> {
        let PathTracing { scene, outline, options: Options { max_bounces, split }, endless } = self;
        Tracer { scene, outline, max_bounces: *max_bounces, split: *split, endless }
    }
}

impl Method for PathTracing {
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        self.tracer().radiance(origin, direction, sampler, trail);
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        self.tracer().irradiance(point, normal, sampler, trail);
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

/// Traces paths through a scene. Cheap to make.
struct Tracer<'a> {
    scene: &'a Scene,
    outline: &'a Outline,
    max_bounces: u32,
    split: u32,
    endless: &'a AtomicU64,
}

/// A path on its way.
#[derive(Clone)]
struct State {
    origin: Vec3A,
    direction: Vec3A,
    way: Way,
    bounce: u32,
    /// Factor of all wavelengths, kept apart: what is the same for all of them is multiplied once.
    weight: f32,
    /// What it would carry on white surfaces.
    share: f32,
    /// What the tints have left of each eighth of the wavelengths.
    outline: Lanes<1>,
}

impl State {
    fn new(origin: Vec3A, direction: Vec3A, way: Way) -> State {
        State { origin, direction, way, bounce: 0, weight: 1.0, share: 1.0, outline: Lanes::splat(1.0) }
    }
}

/// How a path came by its direction.
#[derive(Clone, Copy)]
enum Way {
    /// From the eye or a mirror: no lamp was aimed at.
    Straight,
    /// By a lobe with a density, 1/sr, where lamps were aimed at too.
    Lobe { pdf: f32, from: Vec3A, normal: Vec3A },
}

impl<'a> Tracer<'a> {
    /// Follows one path from the eye and leaves its trail: radiance.
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut state = State::new(origin, direction, Way::Straight);
        let Some((meeting, lobe)) = self.arrive(&mut state, sampler, trail) else { return };
        if self.split == 1 || lobe.kernel.is_specular() {
            if self.go_on(&mut state, &meeting, &lobe, sampler, trail) {
                self.follow(state, sampler, trail);
            }
            return;
        }
        state.share = 1.0 / self.split as f32;
        state.weight *= state.share;
        trail.fork();
        for k in 0..self.split {
            let (mut state, sampler) = (state.clone(), sampler.branch(k, self.split));
            trail.branch();
            if self.go_on(&mut state, &meeting, &lobe, &sampler, trail) {
                self.follow(state, &sampler, trail);
            }
        }
    }

    /// Follows one path from a point and leaves the trail of what falls on it: irradiance over pi, as a white matt surface would
    /// show it.
    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let meeting = Meeting::facing(point, normal);
        self.direct().look(&meeting, &Lobe::WHITE, 1.0, sampler.pair(0), trail);
        if let Some(turn) = Lobe::WHITE.kernel.sample(Vec3A::Z, sampler.pair(1)) {
            let (origin, normal) = meeting.start(false);
            let way = Way::Lobe { pdf: turn.pdf, from: origin, normal };
            self.follow(State::new(origin, meeting.world(turn.inc), way), sampler, trail);
        }
    }

    fn direct(&self) -> Direct<'a> {
        Direct { scene: self.scene }
    }

    /// Follows a path to its end.
    fn follow(&self, mut state: State, sampler: &Sampler, trail: &mut Trail) {
        while let Some((meeting, lobe)) = self.arrive(&mut state, sampler, trail) {
            if !self.go_on(&mut state, &meeting, &lobe, sampler, trail) {
                return;
            }
        }
    }

    /// Goes to the next surface, takes its light and chooses a lobe by lot; `None` where the path ends there.
    #[inline(always)]
    fn arrive(&self, state: &mut State, sampler: &Sampler, trail: &mut Trail) -> Option<(Meeting, Lobe<'a>)> {
        let Some(hit) = self.scene.geometry.closest(state.origin, state.direction) else {
            self.leave(state, trail);
            return None;
        };
        let front = hit.normal.dot(state.direction) < 0.0;
        if let Some(lamp) = hit.surface.emitter.filter(|_| front) {
            self.meet(lamp as usize, &hit, state, trail);
        }
        if state.bounce >= self.max_bounces {
            return None;
        }
        if state.bounce >= MOST_BOUNCES {
            self.endless.fetch_add(1, Ordering::Relaxed);
            return None;
        }
        let pair = FIRST_PAIR + PAIRS * state.bounce;
        let (site, shading) = self.scene.site(&hit, front);
        let meeting = Meeting::new(&hit, front, shading, state.direction);
        let scene: &'a Scene = self.scene;
        let material = &scene.materials[hit.surface.material as usize];
        let lobe = match material.only(&site) {
            Some(lobe) => lobe,
            None => {
                let mut lobes = Lobes::default();
                material.lobes(&site, meeting.out, &mut lobes);
                let lot = if lobes.len() > 1 { sampler.pair(pair)[0] } else { 0.0 };
                lobes.choose(lot)?
            }
        };
        state.weight *= lobe.factor;
        if !lobe.tint.turns() {
            self.tint(state, &lobe.tint, 1.0, trail);
        }
        Some((meeting, lobe))
    }

    /// Asks the lamps through a lobe and leaves the surface along it; false where the path ends by lot or has nowhere to go.
    #[inline(always)]
    fn go_on(&self, state: &mut State, meeting: &Meeting, lobe: &Lobe, sampler: &Sampler, trail: &mut Trail) -> bool {
        let [lots, for_lamp, for_turn] = sampler.three(FIRST_PAIR + PAIRS * state.bounce);
        if !lobe.kernel.is_specular() {
            self.direct().look(meeting, lobe, state.weight, for_lamp, trail);
        }
        let Some(turn) = lobe.kernel.sample(meeting.out, for_turn) else { return false };
        if lobe.tint.turns() {
            self.tint(state, &lobe.tint, meeting.cos_half(turn.inc), trail);
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
            if lots[1] >= odds {
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
    fn tint(&self, state: &mut State, tint: &Tint, cos_half: f32, trail: &mut Trail) {
        self.outline.tint(&mut state.outline, tint, cos_half);
        trail.tint(tint, cos_half);
    }

    /// A path ran into a lamp: weighed against the chance of having aimed at it.
    fn meet(&self, lamp: usize, hit: &Hit, state: &State, trail: &mut Trail) {
        let Lamp::Area(emitter) = &self.scene.lamps[lamp] else { return };
        let weight = match state.way {
            Way::Straight => 1.0,
            Way::Lobe { pdf, from, normal } => {
                let chance = self.scene.tree.chance(lamp, from, Some(normal));
                power_heuristic(pdf, if chance > 0.0 { emitter.pdf(from, hit.point, hit.normal) * chance } else { 0.0 })
            }
        };
        trail.light(&emitter.emission(), weight * state.weight, 0);
    }

    /// A path left the scene: what lies beyond.
    fn leave(&self, state: &State, trail: &mut Trail) {
        for lamp in self.scene.tree.distant() {
            let Some((emission, pdf)) = self.scene.lamps[lamp].beyond(state.direction) else { continue };
            let weight = match state.way {
                Way::Straight => 1.0,
                Way::Lobe { pdf: by_lobe, from, normal } => {
                    power_heuristic(by_lobe, pdf * self.scene.tree.chance(lamp, from, Some(normal)))
                }
            };
            trail.light(&emission, weight * state.weight, 0);
        }
    }
}

/// A vector that is a unit vector but for rounding, without a root.
fn unit(v: Vec3A) -> Vec3A {
    v * (1.5 - 0.5 * v.length_squared())
}
