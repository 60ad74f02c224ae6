//! Direct light: lamps looked at from a surface, through panes where there are any.

use glam::Vec3A;

use crate::material::Lobe;
use crate::render::media::{self, Bodies};
use crate::render::meeting::Meeting;
use crate::render::plane;
use crate::render::trail::Trail;
use crate::scene::light::{Aim, Lamp};
use crate::scene::{Hit, Scene, ray};

/// Panes that are looked through at most.
const MOST_PANES: usize = 64;

/// A scene's lamps.
#[derive(Clone, Copy)]
pub struct Direct<'a> {
    /// With its lamps.
    pub scene: &'a Scene,
}

/// One look at one lamp.
#[derive(Clone, Copy)]
pub struct Look {
    /// Number of the lamp.
    pub lamp: usize,
    /// With which it was chosen.
    pub chance: f32,
    /// Chooses a place on it.
    pub u: [f32; 2],
    /// The lobe's own directions are followed as well, and may run into the lamp.
    pub may_run_into: bool,
    /// Something may stand between.
    pub shadows: bool,
}

impl Direct<'_> {
    /// Next event estimation: one place on one lamp, weighed against the chance of running into it.
    /// `frame` is that of the Stokes vectors of light that leaves, where polarization counts; `bodies` those on the side that light comes
    /// from, where there are any.
    #[inline(always)]
    pub fn look(
        &self,
        at: &Meeting,
        lobe: &Lobe,
        share: f32,
        mut u: [f32; 2],
        beside: (Option<Vec3A>, Option<Bodies>),
        trail: &mut Trail,
    ) {
        let (from, normal) = at.start(lobe.kernel.transmits());
        let Some((lamp, chance)) = self.scene.tree.choose(from, Some(normal), &mut u[0]) else { return };
        let look = Look { lamp, chance, u, may_run_into: true, shadows: true };
        self.look_in(at, lobe, share, &look, beside, trail);
    }

    /// The light of one lamp that leaves through a lobe, times `share`; see [`Direct::look`].
    #[inline(always)]
    pub fn look_in(
        &self,
        at: &Meeting,
        lobe: &Lobe,
        share: f32,
        look: &Look,
        (mut frame, mut bodies): (Option<Vec3A>, Option<Bodies>),
        trail: &mut Trail,
    ) {
        let scene = self.scene;
        let transmits = lobe.kernel.transmits();
        let (from, normal) = at.start(transmits);
        let Look { lamp: chosen, chance, u, may_run_into, shadows } = *look;
        let Some(aim) = scene.lamps[chosen].aim(from, u) else { return };
        let inc = at.local(aim.direction);
        if aim.direction.dot(normal) <= 0.0 || (inc.z < 0.0) != transmits {
            return;
        }
        let value = lobe.kernel.evaluate(at.out, inc);
        if value.f_cos <= 0.0 {
            return;
        }
        let open = !shadows || self.is_open(from, chosen, &aim);
        if !(open || scene.clear) {
            return;
        }
        let weight = share
            * if aim.pdf.is_finite() {
                let pdf = aim.pdf * chance;
                value.f_cos / pdf * if may_run_into { power_heuristic(pdf, value.pdf) } else { 1.0 }
            } else {
                value.f_cos / chance
            };
        let before = trail.aside();
        if lobe.tint.turns() {
            trail.tint(&lobe.tint.turned(at.out, inc));
        }
        if let Some(frame) = &mut frame {
            plane::follow(at, lobe, inc, frame, trail);
        }
        let seen = match open {
            true => Some(self.open_way(chosen, &aim, frame, bodies.as_mut(), trail)),
            false => self.see_through(from, chosen, &aim, frame, bodies.as_mut(), trail),
        };
        match seen {
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

    /// Light of a lamp that was aimed at from a place off all surfaces: notes what it goes through, and gives what that leaves of all
    /// wavelengths alike; `None` where something opaque stands between.
    pub fn light_of(
        &self,
        from: Vec3A,
        lamp: usize,
        aim: &Aim,
        frame: Option<Vec3A>,
        bodies: Option<&mut Bodies>,
        trail: &mut Trail,
    ) -> Option<f32> {
        if self.scene.clear {
            return self.see_through(from, lamp, aim, frame, bodies, trail);
        }
        self.is_open(from, lamp, aim).then(|| self.open_way(lamp, aim, frame, bodies, trail))
    }

    /// Notes that light, unpolarised, times a weight; nothing where something opaque stands between.
    pub fn note(&self, from: Vec3A, lamp: usize, aim: &Aim, weight: f32, bodies: &mut Bodies, trail: &mut Trail) {
        let before = trail.aside();
        match self.light_of(from, lamp, aim, None, Some(bodies), trail) {
            Some(share) => trail.light(&aim.emission, weight * share, trail.len() - before),
            None => trail.truncate(before),
        }
    }

    /// Notes what becomes of light on its way from a lamp where no surface stands in it.
    #[inline(always)]
    fn open_way(
        &self,
        lamp: usize,
        aim: &Aim,
        frame: Option<Vec3A>,
        bodies: Option<&mut Bodies>,
        trail: &mut Trail,
    ) -> f32 {
        let share = bodies.map_or(1.0, |b| media::dim(self.scene, b, aim.direction, aim.point, trail));
        if let (Some(frame), None) = (frame, aim.point) {
            plane::lamp(&self.scene.lamps[lamp], aim.direction, frame, trail);
        }
        share
    }

    /// Looks at a lamp through panes and notes their tints; what they leave of all wavelengths alike, or `None` where something
    /// opaque stands between.
    fn see_through(
        &self,
        mut from: Vec3A,
        lamp: usize,
        aim: &Aim,
        mut frame: Option<Vec3A>,
        mut bodies: Option<&mut Bodies>,
        trail: &mut Trail,
    ) -> Option<f32> {
        let mut share = 1.0;
        for _ in 0..MOST_PANES {
            // Out of a body there is a surface to go through: only what lies next on the way is asked.
            let within = bodies.as_ref().is_some_and(|b| !b.inside.is_empty());
            let hit = if within || !self.is_open(from, lamp, aim) {
                self.scene.geometry.closest(from, aim.direction)
            } else {
                None
            };
            if within && hit.is_none() {
                self.surface(from, bodies.as_deref_mut());
            }
            let beyond = |hit: &Hit| aim.point.is_some_and(|p| hit.t >= (p - from).dot(aim.direction));
            let Some(hit) = hit.filter(|h| h.surface.emitter != Some(lamp as u32) && !(within && beyond(h))) else {
                return Some(share * self.open_way(lamp, aim, frame, bodies, trail));
            };
            let (left, next) = self.pane(&hit, aim.direction, &mut frame, bodies.as_deref_mut(), trail)?;
            (share, from) = (share * left, next);
        }
        None
    }

    /// There is no way out of the bodies that a place is in: it lies so near to their surface that rounding has put it beyond.
    fn surface(&self, from: Vec3A, bodies: Option<&mut Bodies>) {
        if let Some(bodies) = bodies.filter(|b| !b.inside.is_empty()) {
            bodies.inside = self.scene.inside(from);
        }
    }

    /// What is met along a direction, through panes: a lamp's surface, or nothing (what lies beyond the scene); `None` where it is opaque.
    /// Notes what is on the way, and gives what that leaves of all wavelengths alike.
    pub fn along(
        &self,
        mut from: Vec3A,
        direction: Vec3A,
        frame: &mut Option<Vec3A>,
        mut bodies: Option<&mut Bodies>,
        trail: &mut Trail,
    ) -> Option<(Option<Hit>, f32)> {
        let mut share = 1.0;
        for _ in 0..MOST_PANES {
            let hit = self.scene.geometry.closest(from, direction);
            let lamp = hit.filter(|h| h.surface.emitter.is_some() && h.normal.dot(direction) < 0.0);
            if hit.is_none() || lamp.is_some() {
                if hit.is_none() {
                    self.surface(from, bodies.as_deref_mut());
                }
                if let Some(bodies) = bodies {
                    share *= media::dim(self.scene, bodies, direction, lamp.map(|h| h.point), trail);
                }
                return Some((lamp, share));
            }
            let (left, next) = self.pane(&hit?, direction, frame, bodies.as_deref_mut(), trail)?;
            (share, from) = (share * left, next);
        }
        None
    }

    /// Notes what the way to a pane and the pane itself do to light; what both leave of all wavelengths alike, and where the way goes on.
    /// `None` where it is opaque.
    fn pane(
        &self,
        hit: &Hit,
        direction: Vec3A,
        frame: &mut Option<Vec3A>,
        mut bodies: Option<&mut Bodies>,
        trail: &mut Trail,
    ) -> Option<(f32, Vec3A)> {
        let material = &self.scene.materials[hit.surface.material as usize];
        if !material.is_clear() {
            return None;
        }
        let mut share = 1.0;
        if let Some(bodies) = &mut bodies {
            share *= media::dim(self.scene, bodies, direction, Some(hit.point), trail);
            bodies.from = hit.point;
        }
        let next = ray::onward(hit.point, direction, hit.normal, hit.reach);
        if material.is_void() {
            let front = hit.normal.dot(direction) < 0.0;
            bodies.into_iter().for_each(|b| b.inside = b.inside.beyond(material.interior(), front));
            return Some((share, next));
        }
        let (meeting, lobes) = Meeting::with_lobes(self.scene, hit, direction);
        let lobe = lobes.iter().find(|l| l.kernel.is_straight())?;
        trail.tint(&lobe.tint);
        if let Some(frame) = frame {
            if lobe.polar.is_none() {
                trail.depolarise();
            }
            plane::follow(&meeting, lobe, -meeting.out, frame, trail);
        }
        if let Some(bodies) = bodies {
            bodies.inside = meeting.beyond(bodies.inside);
        }
        Some((share * lobe.factor, next))
    }
}

/// Weight of the first of two ways to find the same light, densities a and b [Veach 1997].
pub fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}
