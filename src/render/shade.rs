//! What a surface shows of the lamps at once, without paths: each lobe lit by every lamp, and what its own directions meet.

use glam::Vec3A;

use crate::material::{Lobe, Lobes};
use crate::medium::Inside;
use crate::medium::density::Way;
use crate::render::direct::{Direct, Look, power_heuristic};
use crate::render::media::{self, Bodies, Lots};
use crate::render::meeting::Meeting;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::render::view;
use crate::scene::light::{Emission, Lamp};
use crate::scene::{Hit, Scene, ray};

/// So many lamps are all looked at; of more, one by lot.
pub const FEW_LAMPS: usize = 8;

/// What a method knows of the light between surfaces.
pub trait Rest: Sync {
    /// Notes what a lobe whose directions are not followed shows of other surfaces: radiance from everywhere, weighed by the lobe.
    fn spread(&self, at: &Meeting, lobe: &Lobe, weight: f32, trail: &mut Trail);

    /// Notes what a surface that a ray has met sends back, but for its own light; `None` where what the ray met is not looked at.
    fn sent(&self, met: Option<&Hit>, direction: Vec3A, weight: f32, pairs: &mut Pairs, trail: &mut Trail);

    /// Notes what the medium on a way gives off, where it is known, and what it lets through of all that is noted later.
    fn between(&self, scene: &Scene, inside: Inside, way: &Way, pairs: &mut Pairs, trail: &mut Trail) {
        view::dim(scene, inside, way, pairs, trail);
    }
}

/// Nothing but the lamps' light.
pub struct LampsAlone;

impl Rest for LampsAlone {
    fn spread(&self, _: &Meeting, _: &Lobe, _: f32, _: &mut Trail) {}

    fn sent(&self, _: Option<&Hit>, _: Vec3A, _: f32, _: &mut Pairs, _: &mut Trail) {}
}

/// Which lobes show what lies in their own directions: lamps, what is beyond the scene, and other surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// None.
    Nothing,
    /// Those that are not matt.
    Gloss,
    /// All.
    All,
}

/// How surfaces are shaded.
#[derive(Clone, Copy)]
pub struct Shade<'a> {
    /// What is there.
    pub scene: &'a Scene,
    /// Light from other surfaces.
    pub rest: &'a dyn Rest,
    /// Lamps may be hidden.
    pub shadows: bool,
    /// Lobes whose directions are followed.
    pub follow: Follow,
    /// The bodies that the eye's side of the surface is in.
    pub inside: Inside,
}

/// Deals out a sampler's pairs.
pub struct Pairs<'a> {
    sampler: &'a Sampler,
    next: u32,
}

impl Pairs<'_> {
    /// From pair number `next` on.
    pub fn new(sampler: &Sampler, next: u32) -> Pairs<'_> {
        Pairs { sampler, next }
    }

    /// The sampler itself.
    pub fn sampler(&self) -> &Sampler {
        self.sampler
    }

    /// The next two numbers in 0..1.
    pub fn pair(&mut self) -> [f32; 2] {
        self.next += 1;
        self.sampler.pair(self.next - 1)
    }
}

/// Notes what lobes send back of light 0, of radiance 1 from everywhere, a branch each.
pub fn note_sent(lobes: &Lobes, out: Vec3A, pairs: &mut Pairs, trail: &mut Trail) {
    for lobe in lobes.iter().filter(|l| !l.kernel.transmits() && !l.kernel.is_straight()) {
        if let Some(turn) = lobe.kernel.sample(out, pairs.pair()) {
            trail.branch();
            trail.tint(&lobe.tint.turned(out, turn.inc));
            trail.light(&Emission::one(0, 1.0), lobe.factor * turn.weight, 0);
        }
    }
}

impl Shade<'_> {
    /// Notes the light that leaves through a lobe: of lamps, of what lies in its own direction, and ambient.
    pub fn lobe(&self, at: &Meeting, lobe: &Lobe, pairs: &mut Pairs, trail: &mut Trail) {
        if !lobe.tint.turns() {
            trail.tint(&lobe.tint);
        }
        let follow = match self.follow {
            Follow::Nothing => false,
            Follow::Gloss => !lobe.kernel.is_matt(),
            Follow::All => true,
        };
        if !lobe.kernel.is_specular() {
            self.lamps(at, lobe, follow, pairs, trail);
        }
        let Some(turn) = lobe.kernel.sample(at.out, pairs.pair()) else { return };
        if lobe.tint.turns() {
            trail.tint(&lobe.tint.turned(at.out, turn.inc));
        }
        let weight = lobe.factor * turn.weight;
        if follow {
            self.reflected(at, lobe, (at.world(turn.inc).normalize(), turn.pdf), weight, pairs, trail);
        } else {
            self.rest.spread(at, lobe, weight, trail);
        }
    }

    fn lamps(&self, at: &Meeting, lobe: &Lobe, follow: bool, pairs: &mut Pairs, trail: &mut Trail) {
        let direct = Direct { scene: self.scene };
        let count = self.scene.lamps.len();
        let look = |lamp: usize, chance, u| {
            let may_run_into = follow && self.may_meet(lamp);
            Look { lamp, chance, u, may_run_into, shadows: self.shadows }
        };
        if count <= FEW_LAMPS {
            for lamp in 0..count {
                let look = look(lamp, 1.0, pairs.pair());
                let mut lots = Lots::of(self.scene, pairs.sampler());
                direct.look_in(at, lobe, lobe.factor, &look, (None, self.bodies(at, lobe, &mut lots)), trail);
            }
            return;
        }
        let (mut u, (from, normal)) = (pairs.pair(), at.start(lobe.kernel.transmits()));
        if let Some((lamp, chance)) = self.scene.tree.choose(from, Some(normal), &mut u[0]) {
            let mut lots = Lots::of(self.scene, pairs.sampler());
            let bodies = self.bodies(at, lobe, &mut lots);
            direct.look_in(at, lobe, lobe.factor, &look(lamp, chance, u), (None, bodies), trail);
        }
    }

    /// Those that a look through a lobe begins in, where space is filled at all.
    fn bodies<'l>(&self, at: &Meeting, lobe: &Lobe, lots: &'l mut Lots) -> Option<Bodies<'l>> {
        self.scene.is_filled().then(|| Bodies { inside: self.beyond(at, lobe), from: at.point, lots })
    }

    /// The bodies on the side that a lobe's light comes from.
    fn beyond(&self, at: &Meeting, lobe: &Lobe) -> Inside {
        if lobe.kernel.transmits() { at.beyond(self.inside) } else { self.inside }
    }

    /// Without shadows no ray meets a surface.
    fn may_meet(&self, lamp: usize) -> bool {
        self.shadows || self.scene.lamps[lamp].is_distant()
    }

    /// The surface that is met along a direction from a place, rays from `from`; media on the way there are noted, and their boundaries
    /// gone through.
    fn met(
        &self,
        mut place: Vec3A,
        mut from: Vec3A,
        direction: Vec3A,
        mut inside: Inside,
        pairs: &mut Pairs,
        trail: &mut Trail,
    ) -> Option<Hit> {
        const MOST_CROSSED: usize = 64;
        for _ in 0..MOST_CROSSED {
            let hit = self.shadows.then(|| self.scene.geometry.closest(from, direction)).flatten();
            let way = media::between(place, direction, hit.as_ref().map(|h| h.point));
            self.rest.between(self.scene, inside, &way, pairs, trail);
            let hit = hit?;
            let material = &self.scene.materials[hit.surface.material as usize];
            if !material.is_void() {
                return Some(hit);
            }
            inside = inside.beyond(material.interior(), hit.normal.dot(direction) < 0.0);
            (place, from) = (hit.point, ray::onward(hit.point, direction, hit.normal, hit.reach));
        }
        None
    }

    /// What lies in a lobe's own direction, which has a density.
    fn reflected(
        &self,
        at: &Meeting,
        lobe: &Lobe,
        (direction, pdf): (Vec3A, f32),
        weight: f32,
        pairs: &mut Pairs,
        trail: &mut Trail,
    ) {
        let (scene, (from, normal)) = (self.scene, at.start(lobe.kernel.transmits()));
        if direction.dot(normal) <= 0.0 {
            return;
        }
        // The chance that a look at the lamps finds the same.
        let by_look = |lamp, density: f32| {
            let looks_at_all = scene.lamps.len() <= FEW_LAMPS;
            let chance = if looks_at_all { 1.0 } else { scene.tree.chance(lamp, from, Some(normal)) };
            if pdf.is_finite() { power_heuristic(pdf, density * chance) } else { 1.0 }
        };
        let hit = if scene.is_filled() {
            self.met(at.point, from, direction, self.beyond(at, lobe), pairs, trail)
        } else {
            self.shadows.then(|| scene.geometry.closest(from, direction)).flatten()
        };
        if let Some(hit) = hit {
            let lamp = hit.surface.emitter.filter(|_| hit.normal.dot(direction) < 0.0).map(|l| l as usize);
            if let Some((lamp, Lamp::Area(e))) = lamp.map(|l| (l, &scene.lamps[l])) {
                let share = weight * by_look(lamp, e.pdf(from, hit.point, hit.normal));
                trail.light(&e.emission(-hit.normal.dot(direction)), share, 0);
            }
            return self.rest.sent(Some(&hit), direction, weight, pairs, trail);
        }
        for lamp in scene.tree.distant() {
            if let Some((emission, density)) = scene.lamps[lamp].beyond(direction) {
                trail.light(&emission, weight * by_look(lamp, density), 0);
            }
        }
        // Without shadows nothing is met: surroundings are those of a closed room where nothing lies beyond.
        if !self.shadows && scene.tree.distant().next().is_none() {
            self.rest.sent(None, direction, weight, pairs, trail);
        }
    }
}
