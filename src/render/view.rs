//! The eye's way to the surfaces that methods other than path tracing show: through panes and by mirrors.

use glam::Vec3A;

use crate::material::{Lobe, Lobes};
use crate::medium::Inside;
use crate::medium::density::Way;
use crate::render::media::{self, Lots};
use crate::render::meeting::Meeting;
use crate::render::shade::Pairs;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;
use crate::scene::{Hit, Scene, ray};

/// Panes and mirrors that the eye is followed through at most.
const MOST: usize = 64;

/// A place that the eye sees.
pub struct Seen<'a> {
    /// The surface.
    pub hit: &'a Hit,
    /// Its front.
    pub front: bool,
    /// As its material sees it.
    pub at: &'a Meeting,
    /// The bodies that the eye's side of it is in.
    pub inside: Inside,
}

/// Notes what a medium leaves of light along a way, and its own; what it scatters is left out.
pub fn dim(scene: &Scene, inside: Inside, way: &Way, pairs: &mut Pairs, trail: &mut Trail) {
    let Some(medium) = scene.media.current(inside) else { return };
    if medium.glow.is_some() {
        media::glow(medium, media::column(scene, medium, way), 1.0, trail);
    }
    let share = media::dim_way(scene, medium, way, &mut Lots::of(scene, pairs.sampler()), trail);
    trail.scale(share);
}

/// Who looks.
pub struct Eye<'a> {
    /// At what.
    pub scene: &'a Scene,
    /// From where.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
}

impl<'a> Eye<'a> {
    /// Notes the light of lamps, and of what is beyond the scene, along a ray; goes on along lobes that are to be `followed` (of
    /// several of them one, by lot), has ways through what fills space noted by `travel`, and the other lobes of each place shown.
    pub fn look(
        &self,
        pairs: &mut Pairs,
        trail: &mut Trail,
        followed: impl Fn(&Lobe) -> bool,
        mut travel: impl FnMut(Inside, &Way, &mut Pairs, &mut Trail),
        mut show: impl FnMut(&Seen, &Lobe<'a>, &mut Pairs, &mut Trail),
    ) {
        let Eye { scene, mut origin, mut direction } = *self;
        let mut inside = scene.inside(origin);
        // Where the way itself begins: rays begin a little off surfaces.
        let mut from = origin;
        for _ in 0..MOST {
            let hit = scene.geometry.closest(origin, direction);
            if scene.is_filled() {
                let way = media::between(from, direction, hit.as_ref().map(|h| h.point));
                travel(inside, &way, pairs, trail);
            }
            let Some(hit) = hit else {
                for lamp in scene.tree.distant() {
                    if let Some((emission, _)) = scene.lamps[lamp].beyond(direction) {
                        trail.light(&emission, 1.0, 0);
                    }
                }
                return;
            };
            let front = hit.normal.dot(direction) < 0.0;
            if let Some(Lamp::Area(e)) = hit.surface.emitter.filter(|_| front).map(|l| &scene.lamps[l as usize]) {
                trail.light(&e.emission(-hit.normal.dot(direction)), 1.0, 0);
            }
            let (at, lobes) = Meeting::with_lobes(scene, &hit, direction);
            from = hit.point;
            if scene.materials[hit.surface.material as usize].is_void() {
                inside = at.beyond(inside);
                origin = ray::onward(hit.point, direction, hit.normal, hit.reach);
                continue;
            }
            trail.fork();
            let mut on = Lobes::default();
            for lobe in lobes.iter() {
                if followed(lobe) {
                    on.push(*lobe);
                } else {
                    trail.branch();
                    show(&Seen { hit: &hit, front, at: &at, inside }, lobe, pairs, trail);
                }
            }
            // The last branch, since it may fork again.
            let lot = if on.len() > 1 { pairs.pair()[0] } else { 0.0 };
            let Some(lobe) = on.choose(lot) else { return };
            let Some(turn) = lobe.kernel.sample(at.out, pairs.pair()) else { return };
            trail.branch();
            trail.tint(&lobe.tint.turned(at.out, turn.inc));
            trail.scale(lobe.factor * turn.weight);
            if !lobe.kernel.is_straight() {
                direction = at.world(turn.inc).normalize();
            }
            if lobe.kernel.transmits() {
                inside = at.beyond(inside);
            }
            origin = at.start(lobe.kernel.transmits()).0;
        }
    }
}

/// The surface that a point lies on, and whether its front faces the normal; `None` in mid-air.
pub fn under(scene: &Scene, point: Vec3A, normal: Vec3A) -> Option<(Hit, bool)> {
    let hit = scene.geometry.closest(point, -normal)?;
    // As far as a point of it may have been moved off.
    let near = hit.t <= 1e-4 * hit.reach.max(point.abs().max_element()).max(1e-3);
    let cos = hit.normal.dot(normal);
    (near && cos.abs() > 0.999).then_some((hit, cos > 0.0))
}
