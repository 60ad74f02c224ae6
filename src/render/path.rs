//! Path tracing with next event estimation and multiple importance sampling [Veach 1997].
//!
//! Where a path meets a surface one of the material's lobes is chosen by lot; the lamps are asked for light through that
//! lobe, and the path goes on along it. Where it goes is the same for all wavelengths. What happens to them is noted on the
//! path's [`Trail`]; on the way only an outline of it is known, eight numbers that say how much the path still carries.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3A;

use crate::material::kernel::lambert::Lambert;
use crate::material::{Kernel, Lobe, Lobes, Tint};
use crate::render::inks::Outline;
use crate::render::lanes::Lanes;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::light::{Aim, Lamp};
use crate::scene::{Hit, Scene, ray};

/// From this bounce on a path may end by lot, with a chance to go on of this times what it carries: measured on the Cornell
/// box and a mesh (docs/performance.md).
const ROULETTE_FROM: u32 = 1;
const ODDS: f32 = 4.0;
/// The same between mirrors.
const MIRRORS: u32 = 32;
/// A path that has not ended by now never will: in a closed room of white walls light has no end.
pub const MOST_BOUNCES: u32 = 2048;

/// Pairs of a sampler's numbers: two before the first surface, three a bounce.
const FIRST_PAIR: u32 = 2;
const PAIRS: u32 = 3;

/// Traces paths through a scene. Cheap to make.
pub struct Tracer<'a> {
    /// What is there.
    pub scene: &'a Scene,
    /// Outlines of its spectra.
    pub outline: &'a Outline,
    /// Most bounces that are asked for.
    pub max_bounces: u32,
    /// Paths that go on from the first surface that the eye sees, and looks at its lamps, from 1: most of what makes a picture
    /// noisy comes after it.
    pub split: u32,
    /// Paths that were ended at [`MOST_BOUNCES`].
    pub endless: &'a AtomicU64,
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

/// A surface that a path has met, in the frame of its shading normal.
struct Meeting {
    /// The geometric normal on the side that the path came from.
    side: Vec3A,
    point: Vec3A,
    axes: [Vec3A; 3],
    out: Vec3A,
}

impl Meeting {
    fn new(hit: &Hit, front: bool, shading: Vec3A, direction: Vec3A) -> Meeting {
        let side = if front { hit.normal } else { -hit.normal };
        let mut z = if front { shading } else { -shading };
        // An interpolated normal can turn away from who looks at it.
        if z.dot(direction) > -1e-4 {
            z = side;
        }
        let (x, y) = ray::frame(z);
        let mut meeting = Meeting { side, point: hit.point, axes: [x, y, z], out: Vec3A::Z };
        meeting.out = meeting.local(-direction);
        meeting.out.z = meeting.out.z.max(1e-6);
        meeting
    }

    fn local(&self, v: Vec3A) -> Vec3A {
        Vec3A::new(v.dot(self.axes[0]), v.dot(self.axes[1]), v.dot(self.axes[2]))
    }

    fn world(&self, v: Vec3A) -> Vec3A {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// Normal of the side on which a lobe's light arrives, and a start of rays there.
    fn start(&self, transmits: bool) -> (Vec3A, Vec3A) {
        let side = if transmits { -self.side } else { self.side };
        (ray::offset(self.point, side), side)
    }

    /// Cosine between half vector and direction of a reflection.
    fn cos_half(&self, inc: Vec3A) -> f32 {
        (self.out + inc).normalize_or_zero().dot(self.out).clamp(0.0, 1.0)
    }
}

impl<'a> Tracer<'a> {
    /// Follows one path from the eye and leaves its trail: radiance.
    pub fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
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
    pub fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        static WHITE: Lambert = Lambert { through: false };
        let (x, y) = ray::frame(normal);
        let meeting = Meeting { side: normal, point, axes: [x, y, normal], out: Vec3A::Z };
        let lobe = Lobe { kernel: &WHITE, tint: Tint::None, factor: 1.0, odds: 1.0 };
        self.look_at_light(&meeting, &lobe, 1.0, sampler.pair(0), trail);
        if let Some(turn) = WHITE.sample(Vec3A::Z, sampler.pair(1)) {
            let (origin, normal) = meeting.start(false);
            let way = Way::Lobe { pdf: turn.pdf, from: origin, normal };
            self.follow(State::new(origin, meeting.world(turn.inc), way), sampler, trail);
        }
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
            self.look_at_light(meeting, lobe, state.weight, for_lamp, trail);
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

    /// Next event estimation: one place on one lamp, weighed against the chance of running into it.
    fn look_at_light(&self, at: &Meeting, lobe: &Lobe, share: f32, mut u: [f32; 2], trail: &mut Trail) {
        let scene = self.scene;
        let transmits = lobe.kernel.transmits();
        let (from, normal) = at.start(transmits);
        let Some((chosen, chance)) = scene.tree.choose(from, Some(normal), &mut u[0]) else { return };
        let Some(aim) = scene.lamps[chosen].aim(from, u) else { return };
        let inc = at.local(aim.direction);
        if aim.direction.dot(normal) <= 0.0 || (inc.z < 0.0) != transmits {
            return;
        }
        let value = lobe.kernel.evaluate(at.out, inc);
        if value.f_cos <= 0.0 {
            return;
        }
        let open = self.is_open(from, chosen, &aim);
        if !(open || scene.clear) {
            return;
        }
        let weight = share
            * if aim.pdf.is_finite() {
                let pdf = aim.pdf * chance;
                value.f_cos / pdf * power_heuristic(pdf, value.pdf)
            } else {
                value.f_cos / chance
            };
        let before = trail.len();
        if lobe.tint.turns() {
            trail.tint(&lobe.tint, at.cos_half(inc));
        }
        match if open { Some(1.0) } else { self.see_through(from, chosen, &aim, trail) } {
            Some(share) => trail.light(&aim.emission, weight * share, trail.len() - before),
            None => trail.truncate(before),
        }
    }

    /// Nothing stands between a place and where a lamp was aimed at.
    fn is_open(&self, from: Vec3A, lamp: usize, aim: &Aim) -> bool {
        let geometry = &self.scene.geometry;
        match (aim.point, &self.scene.lamps[lamp]) {
            (Some(_), Lamp::Area(e)) if e.is_vast() => {
                geometry.closest(from, aim.direction).is_some_and(|h| h.surface.emitter == Some(lamp as u32))
            }
            (Some(point), _) => geometry.visible(from, point),
            (None, _) => geometry.unoccluded(from, aim.direction),
        }
    }

    /// Looks at a lamp through panes and notes their tints; what they leave of all wavelengths alike, or `None` where something
    /// opaque stands between.
    fn see_through(&self, mut from: Vec3A, lamp: usize, aim: &Aim, trail: &mut Trail) -> Option<f32> {
        const MOST_PANES: usize = 64;
        let mut share = 1.0;
        for _ in 0..MOST_PANES {
            if self.is_open(from, lamp, aim) {
                return Some(share);
            }
            let Some(hit) = self.scene.geometry.closest(from, aim.direction) else { return Some(share) };
            let material = &self.scene.materials[hit.surface.material as usize];
            if !material.is_clear() {
                return None;
            }
            let front = hit.normal.dot(aim.direction) < 0.0;
            let (site, shading) = self.scene.site(&hit, front);
            let meeting = Meeting::new(&hit, front, shading, aim.direction);
            let mut lobes = Lobes::default();
            material.lobes(&site, meeting.out, &mut lobes);
            let lobe = lobes.iter().find(|l| l.kernel.is_straight())?;
            trail.tint(&lobe.tint, 1.0);
            share *= lobe.factor;
            from = meeting.start(true).0;
        }
        None
    }
}

/// A vector that is a unit vector but for rounding, without a root.
fn unit(v: Vec3A) -> Vec3A {
    v * (1.5 - 0.5 * v.length_squared())
}

/// Weight of the first of two ways to find the same light, densities a and b [Veach 1997].
fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}
