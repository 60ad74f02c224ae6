//! Spheres, disks, open cylinders and cones, one at a time.

use std::f32::consts::{PI, TAU};

use glam::Vec3A;

use super::Primitive;
use crate::scene::ray::frame;

/// A curved surface or a disk.
#[derive(Clone, Copy, Debug)]
pub enum Round {
    /// A whole sphere.
    Sphere {
        /// Centre.
        center: Vec3A,
        /// Radius.
        radius: f32,
        /// The front is the inside.
        inward: bool,
    },
    /// A disk, or a ring.
    Disk {
        /// Centre.
        center: Vec3A,
        /// Unit normal of the front.
        normal: Vec3A,
        /// Outer radius.
        radius: f32,
        /// Radius of the hole.
        inner: f32,
    },
    /// A tube without caps.
    Cylinder {
        /// Middle of one end.
        base: Vec3A,
        /// Unit vector to the other end.
        axis: Vec3A,
        /// Distance of the ends.
        height: f32,
        /// Radius.
        radius: f32,
        /// The front is the inside.
        inward: bool,
    },
    /// A frustum of a cone without caps.
    Cone {
        /// Middle of one end.
        base: Vec3A,
        /// Unit vector to the other end.
        axis: Vec3A,
        /// Distance of the ends.
        height: f32,
        /// Radii of both ends.
        radii: [f32; 2],
        /// The front is the inside.
        inward: bool,
    },
}

/// The two solutions of a circle about the origin of radius r crossed at f + d t, in order, for vectors of any number of
/// dimensions. The discriminant comes from the distance of the centre to the ray, which does not cancel far away (Haines et
/// al. 2019).
#[inline(always)]
fn roots(f: Vec3A, d: Vec3A, radius: f32) -> Option<(f32, f32)> {
    let a = d.length_squared();
    let b = -f.dot(d);
    let off = f + d * (b / a);
    let under = radius * radius - off.length_squared();
    // Touching is missing; not a number where the ray runs along a cylinder's axis.
    if under.is_nan() || under <= 0.0 {
        return None;
    }
    let q = b + (a * under).sqrt().copysign(b);
    let c = f.length_squared() - radius * radius;
    let (t0, t1) = (c / q, q / a);
    Some((t0.min(t1), t0.max(t1)))
}

/// Where a line f + d t crosses the surface at a distance of r + k h from the axis, h the height above the base: in order, the other
/// half of the double cone among them.
fn cone_roots(f: Vec3A, d: Vec3A, axis: Vec3A, r: f32, k: f32) -> Option<(f32, f32)> {
    // From the place of the ray nearest to the base: the differences below cancel less there.
    let shift = -f.dot(d) / d.length_squared();
    let near = f + d * shift;
    let (fh, dh) = (near.dot(axis), d.dot(axis));
    let (fa, da) = (across(near, axis), across(d, axis));
    let here = r + k * fh;
    let a = da.length_squared() - (k * dh) * (k * dh);
    let b = fa.dot(da) - k * here * dh;
    let c = (fa.length() - here) * (fa.length() + here);
    let under = b * b - a * c;
    if under.is_nan() || under <= 0.0 {
        return None;
    }
    let q = -(b + under.sqrt().copysign(b));
    // Along a ruling there is one crossing: the other goes to infinity.
    let (t0, t1) = (shift + c / q, shift + q / a);
    Some(if t0 <= t1 { (t0, t1) } else { (t1, t0) })
}

fn across(v: Vec3A, axis: Vec3A) -> Vec3A {
    v - axis * v.dot(axis)
}

impl Round {
    /// `None` for triangles and parallelograms.
    pub fn of(primitive: &Primitive) -> Option<Round> {
        match *primitive {
            Primitive::Triangle(_) | Primitive::Parallelogram { .. } => None,
            Primitive::Sphere { center, radius, inward } => Some(Round::Sphere { center, radius, inward }),
            Primitive::Disk { center, normal, radius, inner_radius } => {
                Some(Round::Disk { center, normal: normal.normalize_or_zero(), radius, inner: inner_radius })
            }
            Primitive::Cylinder { base, axis, radius, inward } => {
                let (height, axis) = (axis.length(), axis.normalize_or_zero());
                Some(Round::Cylinder { base, axis, height, radius, inward })
            }
            Primitive::Cone { base, axis, radii, inward } => {
                let (height, axis) = (axis.length(), axis.normalize_or_zero());
                Some(Round::Cone { base, axis, height, radii, inward })
            }
        }
    }

    /// Distance to the nearest crossing at 0 < t < `limit`; infinity for none.
    pub fn intersect(&self, origin: Vec3A, direction: Vec3A, limit: f32) -> f32 {
        let within = |t: f32| t > 0.0 && t < limit;
        match self {
            Round::Sphere { center, radius, .. } => match roots(origin - *center, direction, *radius) {
                Some((near, _)) if within(near) => near,
                Some((_, far)) if within(far) => far,
                _ => f32::INFINITY,
            },
            Round::Disk { center, normal, radius, inner } => {
                let f = origin - *center;
                let t = -normal.dot(f) / normal.dot(direction);
                let away = (f + direction * t).length_squared();
                let inside = away <= radius * radius && away >= inner * inner;
                if inside && within(t) { t } else { f32::INFINITY }
            }
            Round::Cylinder { base, axis, height, radius, .. } => {
                let f = origin - *base;
                let between = |t: f32| {
                    let h = (f + direction * t).dot(*axis);
                    within(t) && h >= 0.0 && h <= *height && *height > 0.0
                };
                match roots(across(f, *axis), across(direction, *axis), *radius) {
                    Some((near, _)) if between(near) => near,
                    Some((_, far)) if between(far) => far,
                    _ => f32::INFINITY,
                }
            }
            Round::Cone { base, axis, height, radii: [a, b], .. } => {
                let f = origin - *base;
                // Between the ends the radius is positive: the other half of the double cone is not met.
                let between = |t: f32| {
                    let h = (f + direction * t).dot(*axis);
                    within(t) && h >= 0.0 && h <= *height && *height > 0.0
                };
                match cone_roots(f, direction, *axis, *a, (b - a) / height) {
                    Some((near, _)) if between(near) => near,
                    Some((_, far)) if between(far) => far,
                    _ => f32::INFINITY,
                }
            }
        }
    }

    /// The point of the surface nearest to a crossing, the front's unit normal there, and u and v in 0..1: longitude and
    /// colatitude of a sphere about z; angle and radius of a disk; angle and height of a cylinder, angles from the first of
    /// [`frame`]'s vectors.
    pub fn locate(&self, crossing: Vec3A) -> (Vec3A, Vec3A, [f32; 2]) {
        let facing = |out: Vec3A, inward: bool| if inward { -out } else { out };
        match self {
            Round::Sphere { center, radius, inward } => {
                let out = (crossing - *center).normalize_or(Vec3A::Z);
                let uv = [turn(out.y, out.x), out.z.clamp(-1.0, 1.0).acos() / PI];
                (*center + out * *radius, facing(out, *inward), uv)
            }
            Round::Disk { center, normal, radius, inner } => {
                let away = across(crossing - *center, *normal);
                let (s, t) = frame(*normal);
                let v = (away.length() - inner) / (radius - inner);
                (*center + away, *normal, [turn(away.dot(t), away.dot(s)), if v > 0.0 { v.min(1.0) } else { 0.0 }])
            }
            Round::Cylinder { base, axis, height, radius, inward } => {
                let f = crossing - *base;
                let h = f.dot(*axis).clamp(0.0, height.max(0.0));
                let (s, t) = frame(*axis);
                let out = across(f, *axis).normalize_or(s);
                let uv = [turn(out.dot(t), out.dot(s)), if *height > 0.0 { h / height } else { 0.0 }];
                (*base + *axis * h + out * *radius, facing(out, *inward), uv)
            }
            Round::Cone { base, axis, height, radii: [a, b], inward } => {
                let f = crossing - *base;
                let h = f.dot(*axis).clamp(0.0, height.max(0.0));
                let (s, t) = frame(*axis);
                let out = across(f, *axis).normalize_or(s);
                let share = if *height > 0.0 { h / height } else { 0.0 };
                let normal = (out * *height - *axis * (b - a)).normalize_or(out);
                let point = *base + *axis * h + out * (a + (b - a) * share);
                (point, facing(normal, *inward), [turn(out.dot(t), out.dot(s)), share])
            }
        }
    }

    /// The largest coordinate of a box around it.
    pub fn reach(&self) -> f32 {
        match self {
            Round::Sphere { center, radius, .. } | Round::Disk { center, radius, .. } => {
                center.abs().max_element() + radius.abs()
            }
            Round::Cylinder { base, height, radius, .. } => base.abs().max_element() + height + radius.abs(),
            Round::Cone { base, height, radii: [a, b], .. } => base.abs().max_element() + height + a.abs().max(b.abs()),
        }
    }

    /// Lower and upper corner of a box around it.
    pub fn bounds(&self) -> (Vec3A, Vec3A) {
        // Half the extent of a circle about a unit normal along each axis.
        let reach = |n: Vec3A, radius: f32| (Vec3A::ONE - n * n).max(Vec3A::ZERO).map(f32::sqrt) * radius.abs();
        match self {
            Round::Sphere { center, radius, .. } => (*center - radius.abs(), *center + radius.abs()),
            Round::Disk { center, normal, radius, .. } => {
                let r = reach(*normal, *radius);
                (*center - r, *center + r)
            }
            Round::Cylinder { base, axis, height, radius, .. } => {
                let (r, top) = (reach(*axis, *radius), *base + *axis * *height);
                (base.min(top) - r, base.max(top) + r)
            }
            Round::Cone { base, axis, height, radii: [a, b], .. } => {
                let (low, high, top) = (reach(*axis, *a), reach(*axis, *b), *base + *axis * *height);
                ((*base - low).min(top - high), (*base + low).max(top + high))
            }
        }
    }
}

/// Angle as a fraction of a turn in 0..1.
fn turn(y: f32, x: f32) -> f32 {
    let turn = y.atan2(x) / TAU;
    if turn < 0.0 { (turn + 1.0).min(1.0) } else { turn }
}
