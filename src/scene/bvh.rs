//! All surfaces of a scene under one bounding volume hierarchy (obvhs, eight-wide and compressed).

use std::time::Duration;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};

use crate::{Result, invalid};

/// A surface without its attributes.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// Front side: the one from which the corners run counter-clockwise.
    Triangle([Vec3A; 3]),
    /// Front side: outside, or inside where `inward`.
    Sphere {
        /// Centre.
        center: Vec3A,
        /// Radius, m.
        radius: f32,
        /// The front is the inside.
        inward: bool,
    },
}

/// What a surface is made of, and whether it shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Index of the material.
    pub material: u32,
    /// Index of the emitter it belongs to.
    pub emitter: Option<u32>,
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// The point, on the surface to the last bit.
    pub point: Vec3A,
    /// Unit normal of the front side.
    pub normal: Vec3A,
    /// What was met.
    pub surface: Surface,
}

impl Boundable for Primitive {
    fn aabb(&self) -> Aabb {
        match self {
            Primitive::Triangle(v) => Aabb::from_points(v),
            Primitive::Sphere { center, radius, .. } => Aabb::new(*center - *radius, *center + *radius),
        }
    }
}

impl Primitive {
    /// Distance to the nearest crossing in the ray's range; infinity for none.
    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> f32 {
        match self {
            Primitive::Triangle([v0, v1, v2]) => {
                // Moeller and Trumbore 1997.
                let (e1, e2) = (*v0 - *v1, *v2 - *v0);
                let ng = e1.cross(e2);
                let c = *v0 - ray.origin;
                let r = ray.direction.cross(c);
                let inv_det = 1.0 / ng.dot(ray.direction);
                let (u, v) = (r.dot(e2) * inv_det, r.dot(e1) * inv_det);
                // A ray in the triangle's plane has an infinite or NaN inv_det, which fails here.
                if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
                    return f32::INFINITY;
                }
                within(ng.dot(c) * inv_det, ray)
            }
            Primitive::Sphere { center, radius, .. } => {
                // The discriminant from the distance of the centre to the ray: no cancellation far away (Haines 2019).
                let f = ray.origin - *center;
                let a = ray.direction.length_squared();
                let b = -f.dot(ray.direction);
                let off = f + ray.direction * (b / a);
                let under = *radius * *radius - off.length_squared();
                if under < 0.0 {
                    return f32::INFINITY;
                }
                let q = b + (a * under).sqrt().copysign(b);
                let c = f.length_squared() - *radius * *radius;
                let (t0, t1) = (c / q, q / a);
                let near = within(t0.min(t1), ray);
                if near.is_finite() { near } else { within(t0.max(t1), ray) }
            }
        }
    }

    /// The crossing at distance t as a point on the surface, and the front's unit normal there.
    fn locate(&self, ray: &Ray, t: f32) -> (Vec3A, Vec3A) {
        let p = ray.origin + ray.direction * t;
        match self {
            Primitive::Triangle([v0, v1, v2]) => {
                let (e1, e2) = (*v1 - *v0, *v2 - *v0);
                let normal = e1.cross(e2).normalize();
                // Barycentric, so that the point lies in the plane as well as floats can say.
                let d = p - *v0;
                let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
                let (d1, d2) = (d.dot(e1), d.dot(e2));
                let scale = 1.0 / (d11 * d22 - d12 * d12);
                let (b1, b2) = ((d22 * d1 - d12 * d2) * scale, (d11 * d2 - d12 * d1) * scale);
                let q = *v0 + e1 * b1 + e2 * b2;
                (if q.is_finite() { q } else { p }, normal)
            }
            Primitive::Sphere { center, radius, inward } => {
                let out = (p - *center).normalize();
                (*center + out * *radius, if *inward { -out } else { out })
            }
        }
    }
}

#[inline(always)]
fn within(t: f32, ray: &Ray) -> f32 {
    if t >= ray.tmin && t <= ray.tmax { t } else { f32::INFINITY }
}

/// Surfaces in the order of the hierarchy's leaves.
pub struct Geometry {
    bvh: CwBvh,
    primitives: Vec<Primitive>,
    surfaces: Vec<Surface>,
}

impl Geometry {
    /// Builds the hierarchy over at least one surface.
    pub fn build(primitives: Vec<Primitive>, surfaces: Vec<Surface>) -> Result<Geometry> {
        if primitives.is_empty() {
            return invalid!("the scene has no shape");
        }
        let bvh = build_cwbvh(&primitives, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = bvh.primitive_indices.iter().map(|i| *i as usize);
        let surfaces = order.clone().map(|i| surfaces[i]).collect();
        let primitives = order.map(|i| primitives[i]).collect();
        Ok(Geometry { bvh, primitives, surfaces })
    }

    /// Number of surfaces.
    pub fn len(&self) -> usize {
        self.primitives.len()
    }

    /// Never true: a scene has at least one surface.
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty()
    }

    /// The nearest surface along a ray.
    pub fn closest(&self, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        let ray = Ray::new(origin, direction, 0.0, f32::MAX);
        let mut found = RayHit::none();
        let any = self.bvh.ray_traverse(ray, &mut found, |ray, i| self.primitives[i].intersect(ray));
        if !any {
            return None;
        }
        let i = found.primitive_id as usize;
        let (point, normal) = self.primitives[i].locate(&ray, found.t);
        Some(Hit { t: found.t, point, normal, surface: self.surfaces[i] })
    }

    /// True when nothing stands between a point and what lies beyond the scene.
    pub fn unoccluded(&self, from: Vec3A, direction: Vec3A) -> bool {
        let ray = Ray::new(from, direction, 0.0, f32::MAX);
        self.bvh.ray_traverse_miss(ray, |ray, i| self.primitives[i].intersect(ray))
    }

    /// True when nothing stands between two points, both already moved off their surfaces.
    pub fn visible(&self, from: Vec3A, to: Vec3A) -> bool {
        let ray = Ray::new(from, to - from, 0.0, 1.0);
        self.bvh.ray_traverse_miss(ray, |ray, i| {
            let t = self.primitives[i].intersect(ray);
            if t < 1.0 { t } else { f32::INFINITY }
        })
    }
}
