//! Frames of polarised light along a path: where x lies at each surface, and how a Stokes vector is turned from one to the next.

use glam::Vec3A;

use crate::material::{Lobe, Polar};
use crate::optics::polarization::Rotation;
use crate::render::meeting::Meeting;
use crate::render::trail::Trail;
use crate::scene::light::Lamp;

/// Notes what a lobe does to the polarization of light that comes along `inc` (in the frame of the meeting), and turns the frame
/// of the light that left, `frame`, into that of the light that comes. That a lobe leaves light unpolarised has been noted.
pub fn follow(at: &Meeting, lobe: &Lobe, inc: Vec3A, frame: &mut Vec3A, trail: &mut Trail) {
    let Some(polar) = lobe.polar else {
        *frame = across(at.world(inc));
        return;
    };
    let (s, cos) = plane(polar, at.out, inc);
    let s = at.world(s);
    trail.polarise(polar, cos, Rotation::between(s, *frame, at.world(at.out)));
    *frame = s;
}

/// The axis at right angles to the plane of incidence, or a sheet's own, and the cosine of the way out with the (micro-)normal.
fn plane(polar: &Polar, out: Vec3A, inc: Vec3A) -> (Vec3A, f32) {
    let own = Vec3A::Y.cross(out);
    if polar.has_axis() {
        return (own.normalize_or(Vec3A::X), 1.0);
    }
    let (by_ways, by_normal) = (out.cross(inc), out.cross(Vec3A::Z));
    let s = [by_ways, by_normal, own].into_iter().find(|v| v.length_squared() > 1e-9).unwrap_or(Vec3A::X);
    let cos = if inc.z > 0.0 {
        (0.5 * (1.0 + out.dot(inc))).max(0.0).sqrt()
    } else {
        // The facet that bends the one into the other.
        let normal = polar.eta().map_or(Vec3A::Z, |eta| (out + inc * eta).normalize_or(Vec3A::Z));
        out.dot(normal).abs()
    };
    (s.normalize(), cos.min(1.0))
}

/// Notes the polarization of what a lamp beyond the scene gives off along a direction to it, seen in a frame.
pub fn lamp(lamp: &Lamp, direction: Vec3A, frame: Vec3A, trail: &mut Trail) {
    if let Some((degree, axis)) = lamp.polarization(direction) {
        // As a sheet would make it of unpolarised light, its first number left out.
        let polar = Polar::Sheet { along: 1.0 + degree, across: 1.0 - degree, retardance_nm: 0.0 };
        trail.polarise(&polar, 1.0, Rotation::between(axis, frame, -direction));
    }
}

/// A direction at right angles to another, level where it can be.
pub fn across(direction: Vec3A) -> Vec3A {
    direction.cross(Vec3A::Z).normalize_or(Vec3A::X)
}
