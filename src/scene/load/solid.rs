//! Surfaces in metres, before they get the geometry's numbers.

use glam::{DAffine3, DVec3};

use crate::scene::Frame;
use crate::scene::geometry::{Primitive, Surface};
use crate::scene::light::area::Shape;
use crate::scene::load::shapes::GroupShapes;
use crate::scene::mesh::Mesh;

/// Triangles of a mesh whose place counts for the frame, at most.
const MOST_BOXES: usize = 4096;

/// One or more surfaces.
pub(super) enum Solid {
    /// A shape by itself.
    One { shape: Shape, surface: Surface },
    /// A mesh, a material for each of its groups, and the number of its first emitter.
    Mesh { mesh: Box<Mesh>, materials: Vec<u32>, emitter: Option<u32> },
    /// A group, from its metres to the scene's.
    Placed { group: usize, transform: DAffine3, material: Option<u32> },
}

/// Box around points.
pub(super) fn hull(points: impl IntoIterator<Item = DVec3>) -> [DVec3; 2] {
    points.into_iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

impl Solid {
    /// Adds boxes around its surfaces, with weights that sum to their number.
    pub(super) fn boxes(&self, groups: &[GroupShapes], boxes: &mut Vec<([DVec3; 2], f64)>) {
        match self {
            Solid::One { shape, .. } => boxes.push((around(shape), 1.0)),
            Solid::Mesh { mesh, .. } => {
                let step = mesh.triangles.len().div_ceil(MOST_BOXES).max(1);
                let some = mesh.triangles.iter().step_by(step);
                boxes.extend(some.map(|t| (hull(t.map(|c| mesh.place(c))), step as f64)));
            }
            Solid::Placed { group, transform, .. } => {
                let [low, high] = groups[*group].bounds();
                let corner = |i: usize| {
                    let pick = |bit: usize, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
                    DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
                };
                boxes.push((hull((0..8).map(|i| transform.transform_point3(corner(i)))), 1.0));
            }
        }
    }
}

fn around(shape: &Shape) -> [DVec3; 2] {
    match shape {
        Shape::Rectangle { corner, u, v } => hull([*corner, *corner + *u, *corner + *v, *corner + *u + *v]),
        Shape::Triangle(t) => hull(*t),
        Shape::Sphere { center, radius, .. } | Shape::Disk { center, radius, .. } => {
            [*center - *radius, *center + *radius]
        }
        Shape::Cylinder { base, axis, radius, .. } => {
            let [low, high] = hull([*base, *base + *axis]);
            [low - *radius, high + *radius]
        }
        Shape::Cone { base, axis, radii: [a, b], .. } => {
            let top = *base + *axis;
            hull([*base - *a, *base + *a, top - *b, top + *b])
        }
    }
}

/// A shape in the numbers of a frame.
pub(super) fn placed(shape: &Shape, frame: &Frame) -> Shape {
    let place = |p: DVec3| frame.place(p);
    let scale = frame.scale;
    match shape {
        Shape::Rectangle { corner, u, v } => Shape::Rectangle { corner: place(*corner), u: *u * scale, v: *v * scale },
        Shape::Triangle(t) => Shape::Triangle(t.map(place)),
        Shape::Sphere { center, radius, inward } => {
            Shape::Sphere { center: place(*center), radius: radius * scale, inward: *inward }
        }
        Shape::Disk { center, normal, radius, inner } => {
            Shape::Disk { center: place(*center), normal: *normal, radius: radius * scale, inner: inner * scale }
        }
        Shape::Cone { base, axis, radii, inward } => {
            let radii = radii.map(|r| r * scale);
            Shape::Cone { base: place(*base), axis: *axis * scale, radii, inward: *inward }
        }
        Shape::Cylinder { base, axis, radius, inward } => {
            Shape::Cylinder { base: place(*base), axis: *axis * scale, radius: radius * scale, inward: *inward }
        }
    }
}

/// A shape as the geometry has it.
pub(super) fn primitive(shape: &Shape, frame: &Frame) -> Primitive {
    match placed(shape, frame) {
        Shape::Rectangle { corner, u, v } => {
            Primitive::Parallelogram { corner: corner.as_vec3a(), u: u.as_vec3a(), v: v.as_vec3a() }
        }
        Shape::Triangle(t) => Primitive::Triangle(t.map(|p| p.as_vec3a())),
        Shape::Sphere { center, radius, inward } => {
            Primitive::Sphere { center: center.as_vec3a(), radius: radius as f32, inward }
        }
        Shape::Disk { center, normal, radius, inner } => Primitive::Disk {
            center: center.as_vec3a(),
            normal: normal.as_vec3a(),
            radius: radius as f32,
            inner_radius: inner as f32,
        },
        Shape::Cylinder { base, axis, radius, inward } => {
            Primitive::Cylinder { base: base.as_vec3a(), axis: axis.as_vec3a(), radius: radius as f32, inward }
        }
        Shape::Cone { base, axis, radii, inward } => {
            let radii = radii.map(|r| r as f32);
            Primitive::Cone { base: base.as_vec3a(), axis: axis.as_vec3a(), radii, inward }
        }
    }
}
