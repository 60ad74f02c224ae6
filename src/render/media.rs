//! Ways through media as renderers ask for them: columns in metres, what is left of light, and how scattering polarises.

use glam::Vec3A;

use crate::material::{Polar, Tint};
use crate::medium::density::{Candidate, Way};
use crate::medium::{Inside, Medium};
use crate::optics::polarization::Rotation;
use crate::render::plane;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::Scene;
use crate::scene::light::Emission;

/// A way from a place along a direction to another that lies there, or without end.
pub fn between(origin: Vec3A, direction: Vec3A, to: Option<Vec3A>) -> Way {
    Way { origin, direction, length: to.map_or(f32::INFINITY, |p| (p - origin).dot(direction).max(0.0)) }
}

/// Columns are no longer than that, so that no coefficient of 0 makes nothing of infinity.
const LONGEST_M: f32 = 1e30;

/// Numbers in 0..1, as many as are asked for: null collisions have no end that a net of points could know.
#[derive(Clone, Copy, Debug)]
pub struct Lots(u64);

impl Lots {
    /// Those of a path; of a scene that has no use for them, none.
    #[inline]
    pub fn of(scene: &Scene, sampler: &Sampler) -> Lots {
        if !scene.media.by_null_collisions {
            return Lots(0);
        }
        let [a, b] = sampler.pair(0x2fff_ffff);
        Lots(u64::from(a.to_bits()) << 32 | u64::from(b.to_bits()))
    }

    /// The next one [Steele 2014].
    pub fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    /// An optical depth after which something happens.
    pub fn column(&mut self) -> f32 {
        -(-self.draw()).ln_1p()
    }
}

/// The bodies that a look at a lamp begins in.
pub struct Bodies<'a> {
    /// Their media.
    pub inside: Inside,
    /// Where its way begins: rays begin a little off surfaces, which in a dense medium is a way of its own.
    pub from: Vec3A,
    /// For null collisions.
    pub lots: &'a mut Lots,
}

/// Column of a way through a medium, m.
pub fn column(scene: &Scene, medium: &Medium, way: &Way) -> f32 {
    scene.frame.length_m(medium.density.along(way)).min(LONGEST_M)
}

/// Where along a way the column is so many metres.
pub fn reach(scene: &Scene, medium: &Medium, way: &Way, metres: f32) -> Option<f32> {
    medium.density.reach(way, scene.frame.units(metres))
}

/// Column of a unit of the way at a place, m.
pub fn density(scene: &Scene, medium: &Medium, place: Vec3A) -> f32 {
    scene.frame.length_m(medium.density.at(place))
}

/// The next place at which light may collide where a medium is as dense as around it everywhere, after so many metres of that.
pub fn candidate(scene: &Scene, medium: &Medium, way: &Way, from: f32, metres: f32) -> Option<Candidate> {
    medium.density.candidate(way, from, scene.frame.units(metres))
}

/// Notes what a medium gives off along a way of so many metres, where it does.
pub fn glow(medium: &Medium, metres: f32, weight: f32, trail: &mut Trail) {
    let Some(light) = medium.glow else { return };
    let tint = Tint::Glow { depth: medium.extinction, part: medium.absorption, metres };
    let share = note(medium, &tint, trail);
    trail.light(&Emission::one(light, 1.0), weight * share, usize::from(medium.grey.is_none()));
}

/// Notes a medium's tint, or gives it as a number where that is all it is.
#[inline]
pub fn note(medium: &Medium, tint: &Tint, trail: &mut Trail) -> f32 {
    medium.grey_share(tint).unwrap_or_else(|| {
        trail.tint(tint);
        1.0
    })
}

/// Notes what the medium of the bodies that a way lies in leaves of light, and gives what is the same for all wavelengths.
/// It goes along `direction` to a place, or without end.
pub fn dim(scene: &Scene, bodies: &mut Bodies, direction: Vec3A, to: Option<Vec3A>, trail: &mut Trail) -> f32 {
    let Some(medium) = scene.media.current(bodies.inside) else { return 1.0 };
    dim_way(scene, medium, &between(bodies.from, direction, to), bodies.lots, trail)
}

/// The same of one medium.
pub fn dim_way(scene: &Scene, medium: &Medium, way: &Way, lots: &mut Lots, trail: &mut Trail) -> f32 {
    if medium.density.by_null_collisions() {
        return ratio_track(scene, medium, way, lots, trail);
    }
    let metres = column(scene, medium, way);
    if metres > 0.0 { note(medium, &medium.inside(metres), trail) } else { 1.0 }
}

/// The same by null collisions, each of which leaves what is not as dense as the densest medium around [Novak 2014].
pub fn ratio_track(scene: &Scene, medium: &Medium, way: &Way, lots: &mut Lots, trail: &mut Trail) -> f32 {
    let [_, most] = medium.extremes;
    if most <= 0.0 {
        return 1.0;
    }
    let (mut from, mut share) = (0.0, 1.0);
    while let Some(c) = candidate(scene, medium, way, from, lots.column() / most) {
        share *= note(medium, &Tint::Null { depth: medium.extinction, share: c.share / most }, trail);
        from = c.t;
    }
    share
}

/// Notes how scattering polarises light that comes from along `inc` and leaves against `direction`, both from the eye on, and turns the
/// frame.
pub fn polarise(medium: &Medium, direction: Vec3A, inc: Vec3A, frame: &mut Vec3A, trail: &mut Trail) {
    if !medium.phase.is_rayleigh() {
        trail.depolarise();
        *frame = plane::across(inc);
        return;
    }
    let s = direction.cross(inc).normalize_or(plane::across(inc));
    trail.polarise(&Polar::Rayleigh, direction.dot(inc), Rotation::between(s, *frame, -direction));
    *frame = s;
}
