//! Photons in media along what the eye sees: the beam radiance estimate [Jarosz 2008]. All photons within a radius of a way count, as
//! far as their light comes through; no steps, and no place where none is found.
//!
//! The radius is that of a sphere that would hold [`super::Options::count`] / 8 photons if they were spread evenly, and shrinks from map
//! to map. Near the boundary of a body part of it lies outside: light is too weak there, by at most half.

use glam::Vec3A;

use crate::medium::density::Way;
use crate::medium::{Inside, Medium};
use crate::render::media;
use crate::render::photon::tree::{self, Photon};
use crate::render::trail::Trail;
use crate::scene::Scene;

/// Radius for so many photons in a sphere; 0 where there are none.
pub fn radius(photons: &[Photon], count: f32) -> f32 {
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for p in photons {
        let at = Vec3A::from_array(p.place);
        (low, high) = (low.min(at), high.max(at));
    }
    let size = high - low;
    let volume = size.x * size.y * size.z;
    let each = volume / photons.len().max(1) as f32;
    if volume.is_finite() { (0.75 * std::f32::consts::FRAC_1_PI * count * each).cbrt() } else { 0.0 }
}

/// Notes the light of photons along a way, in branches of their own.
pub fn note(scene: &Scene, photons: &[Photon], inside: Inside, way: &Way, radius: f32, trail: &mut Trail) {
    let Some(medium) = scene.media.current(inside).filter(|m| m.scattering.is_some()) else { return };
    // Flux is in the scene's units: over an area of theirs it is radiance.
    let area = std::f32::consts::PI * radius * radius;
    tree::along(photons, way, (0.0, way.length), radius, &mut |photon, t, _| {
        let from = Vec3A::from_array(photon.normal);
        let value = medium.phase.value(0.5 * (from - way.direction).length_squared());
        branch(scene, medium, &way.up_to(t), photon, photon.flux * value / area, trail);
    });
}

fn branch(scene: &Scene, medium: &Medium, way: &Way, photon: &Photon, weight: f32, trail: &mut Trail) {
    trail.branch();
    let metres = media::column(scene, medium, way);
    let share = media::note(medium, &medium.inside(metres), trail);
    trail.stored(photon.row, weight * share);
}
