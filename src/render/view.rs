//! The eye's way to the surfaces that methods other than path tracing show: through panes and by mirrors.

use glam::Vec3A;

use crate::material::{Lobe, Lobes};
use crate::render::meeting::Meeting;
use crate::render::shade::Pairs;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;
use crate::scene::{Hit, Scene};

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
}

/// Notes the light of lamps, and of what is beyond the scene, along a ray; goes on along lobes that are to be `followed` (of
/// several of them one, by lot), and has the others of each place shown.
pub fn look<'a>(
    scene: &'a Scene,
    (mut origin, mut direction): (Vec3A, Vec3A),
    pairs: &mut Pairs,
    trail: &mut Trail,
    followed: impl Fn(&Lobe) -> bool,
    mut show: impl FnMut(&Seen, &Lobe<'a>, &mut Pairs, &mut Trail),
) {
    for _ in 0..MOST {
        let Some(hit) = scene.geometry.closest(origin, direction) else {
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
        trail.fork();
        let mut on = Lobes::default();
        for lobe in lobes.iter() {
            if followed(lobe) {
                on.push(*lobe);
            } else {
                trail.branch();
                show(&Seen { hit: &hit, front, at: &at }, lobe, pairs, trail);
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
        origin = at.start(lobe.kernel.transmits()).0;
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
