//! Up to eight triangles or parallelograms tested at once.
//!
//! The test is watertight (Woop, Benthin and Wald 2013): corners are moved to the ray's origin and sheared until the ray is
//! the last axis, the same sums for a corner whichever surface it belongs to. An edge function is the difference of two
//! rounded products, and rounding is monotonic: its sign is right or it is zero, and zero counts as inside on both sides of
//! the edge. So no ray passes between two surfaces that share corners.

use glam::{DVec3, Vec3A};

use super::eight::Eight;
use super::ray::Ray;
use crate::simd;

/// Surfaces of N corners: `corners[c][axis][lane]`. Lanes without a surface have all corners in one point.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Block<const N: usize> {
    /// Coordinates.
    pub corners: [[[f32; 8]; 3]; N],
    /// Index of the primitive.
    pub ids: [u32; 8],
}

/// Three corners, counter-clockwise from the front.
pub type Triangles = Block<3>;

/// Parallelograms: corner, corner + u, corner + u + v, corner + v.
pub type Quads = Block<4>;

impl<const N: usize> Block<N> {
    /// Without a surface.
    pub fn empty() -> Block<N> {
        Block { corners: [[[0.0; 8]; 3]; N], ids: [u32::MAX; 8] }
    }

    /// Puts a surface into a lane.
    pub fn set(&mut self, lane: usize, corners: [Vec3A; N], id: u32) {
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            for (row, x) in rows.iter_mut().zip(corner.to_array()) {
                row[lane] = x;
            }
        }
        self.ids[lane] = id;
    }

    /// A corner of the surface in a lane.
    #[inline(always)]
    pub fn corner(&self, corner: usize, lane: usize) -> Vec3A {
        let [x, y, z] = &self.corners[corner];
        Vec3A::new(x[lane & 7], y[lane & 7], z[lane & 7])
    }

    /// A corner relative to the ray's origin: across the ray sheared, along it as it is. No closure here or below goes through
    /// the standard library, which would compile it for the baseline.
    #[inline(always)]
    fn sheared<S: Eight>(&self, s: S, ray: &Ray, corner: usize) -> [S::F; 3] {
        let rows = &self.corners[corner];
        // Remainders for the compiler: no axis is out of bounds.
        let [x, y, z] = [ray.axes[0] % 3, ray.axes[1] % 3, ray.axes[2] % 3];
        let o = ray.origin.to_array();
        let along = s.sub(s.load(&rows[z]), s.splat(o[z]));
        let across = s.sub(s.load(&rows[x]), s.splat(o[x]));
        let up = s.sub(s.load(&rows[y]), s.splat(o[y]));
        let (sx, sy) = (s.splat(ray.shear[0]), s.splat(ray.shear[1]));
        [s.sub(across, s.mul(sx, along)), s.sub(up, s.mul(sy, along)), along]
    }

    #[inline(always)]
    fn all_sheared<S: Eight>(&self, s: S, ray: &Ray) -> [[S::F; 3]; N] {
        let mut corners = [[s.splat(0.0); 3]; N];
        for (i, corner) in corners.iter_mut().enumerate() {
            *corner = self.sheared(s, ray, i);
        }
        corners
    }
}

/// Twice the signed area between the ray and an edge, across the ray.
#[inline(always)]
fn edge<S: Eight>(s: S, a: &[S::F; 3], b: &[S::F; 3]) -> S::F {
    s.sub(s.mul(a[0], b[1]), s.mul(a[1], b[0]))
}

/// Where a ray crosses a surface with sides u and v at a corner, a distance t away: the place, the unit normal, and fractions
/// of the sides. The place is a sum along the surface: it lies on it as well as floats can say. `most` bounds the second
/// fraction where rounding went beyond the surface.
#[inline(always)]
fn locate([corner, u, v]: [Vec3A; 3], ray: &Ray, t: f32, most: impl Fn(f32) -> f32) -> (Vec3A, Vec3A, [f32; 2]) {
    let (from, across) = (ray.origin + ray.direction * t - corner, u.cross(v));
    let squared = across.length_squared();
    let (normal, [a, b]) = if squared > 1e-30 && squared < 1e30 {
        let scale = 1.0 / squared;
        (across * scale.sqrt(), [from.cross(v).dot(across) * scale, u.cross(from).dot(across) * scale])
    } else {
        extreme(u, v, from, ray.direction)
    };
    let a = simd::bound(a, 0.0, 1.0);
    let b = simd::bound(b, 0.0, most(a));
    (corner + u * a + v * b, normal, [a, b])
}

/// Normal and fractions of surfaces so small or large that squares leave the range of floats. One that is a mere line has no
/// plane and perhaps no fractions: it faces the ray, and the corner will do.
#[cold]
fn extreme(u: Vec3A, v: Vec3A, from: Vec3A, direction: Vec3A) -> (Vec3A, [f32; 2]) {
    let (u, v, from) = (u.as_dvec3(), v.as_dvec3(), from.as_dvec3());
    let across = u.cross(v);
    let squared = across.length_squared();
    if squared <= 0.0 {
        return (-direction.as_dvec3().normalize().as_vec3a(), [0.0, 0.0]);
    }
    let fraction = |c: DVec3| (c.dot(across) / squared) as f32;
    (across.normalize().as_vec3a(), [fraction(from.cross(v)), fraction(u.cross(from))])
}

impl Triangles {
    /// Point, unit normal and weights of the second and third corner where a ray crosses a lane's triangle, and the largest
    /// coordinate of its corners.
    #[inline(always)]
    pub fn locate(&self, lane: usize, ray: &Ray, t: f32) -> (Vec3A, Vec3A, [f32; 2], f32) {
        let (a, b, c) = (self.corner(0, lane), self.corner(1, lane), self.corner(2, lane));
        let (point, normal, bary) = locate([a, b - a, c - a], ray, t, |x| 1.0 - x);
        (point, normal, bary, a.abs().max(b.abs()).max(c.abs()).max_element())
    }
}

impl Quads {
    /// In the order of the block.
    pub fn corners(corner: Vec3A, u: Vec3A, v: Vec3A) -> [Vec3A; 4] {
        [corner, corner + u, corner + (u + v), corner + v]
    }

    /// Point, unit normal and fractions of u and v where a ray crosses a lane's parallelogram, and the largest coordinate of its
    /// corners.
    #[inline(always)]
    pub fn locate(&self, lane: usize, ray: &Ray, t: f32) -> (Vec3A, Vec3A, [f32; 2], f32) {
        let (a, b, d) = (self.corner(0, lane), self.corner(1, lane), self.corner(3, lane));
        let (point, normal, bary) = locate([a, b - a, d - a], ray, t, |_| 1.0);
        let reach = a.abs().max(b.abs()).max(d.abs()).max((b + (d - a)).abs()).max_element();
        (point, normal, bary, reach)
    }
}

/// Twice the signed areas between the ray and the edges, the first from the first corner to the second.
#[inline(always)]
fn edges<S: Eight, const N: usize>(s: S, corners: &[[S::F; 3]; N]) -> [S::F; N] {
    let mut areas = [s.splat(0.0); N];
    for i in 0..N {
        areas[i] = edge(s, &corners[i], &corners[(i + 1) % N]);
    }
    areas
}

/// The least and the largest.
#[inline(always)]
fn range<S: Eight, const N: usize>(s: S, areas: &[S::F; N]) -> [S::F; 2] {
    let (mut low, mut high) = (areas[0], areas[0]);
    for area in &areas[1..] {
        (low, high) = (s.min(low, *area), s.max(high, *area));
    }
    [low, high]
}

/// Where rays cross surfaces.
pub trait Crossed {
    /// One bit a lane that is crossed at 0 < t < `limit`, and distances that hold for those.
    fn cross<S: Eight>(&self, s: S, ray: &Ray, limit: f32) -> (u32, S::F);
    /// Distances in lanes that are crossed at 0 < t, infinite in the others.
    fn distances<S: Eight>(&self, s: S, ray: &Ray) -> S::F;
}

impl<const N: usize> Crossed for Block<N>
where
    Block<N>: Planar<N>,
{
    #[inline(always)]
    fn cross<S: Eight>(&self, s: S, ray: &Ray, limit: f32) -> (u32, S::F) {
        let corners = self.all_sheared(s, ray);
        let areas = edges(s, &corners);
        let ([low, high], zero) = (range(s, &areas), s.splat(0.0));
        let inside = s.le(zero, low) | s.le(high, zero);
        if inside == 0 {
            return (0, zero);
        }
        let t = Self::distance(s, ray, &corners, &areas);
        (inside & s.lt(zero, t) & s.lt(t, s.splat(limit)), t)
    }

    #[inline(always)]
    fn distances<S: Eight>(&self, s: S, ray: &Ray) -> S::F {
        let corners = self.all_sheared(s, ray);
        let areas = edges(s, &corners);
        let ([low, high], zero, none) = (range(s, &areas), s.splat(0.0), s.splat(f32::INFINITY));
        let t = Self::distance(s, ray, &corners, &areas);
        let t = s.where_le(zero, low, t, s.where_le(high, zero, t, none));
        s.where_lt(zero, t, t, none)
    }
}

/// How far away planes lie that are known by their corners.
pub trait Planar<const N: usize> {
    /// From sheared corners and the areas beside the edges; no number for a ray in the surface's plane.
    fn distance<S: Eight>(s: S, ray: &Ray, corners: &[[S::F; 3]; N], areas: &[S::F; N]) -> S::F;
}

impl Planar<3> for Triangles {
    #[inline(always)]
    fn distance<S: Eight>(s: S, ray: &Ray, [a, b, c]: &[[S::F; 3]; 3], [ab, bc, ca]: &[S::F; 3]) -> S::F {
        let scale = s.div(s.splat(ray.shear[2]), s.add(s.add(*bc, *ca), *ab));
        let along = s.add(s.add(s.mul(*bc, a[2]), s.mul(*ca, b[2])), s.mul(*ab, c[2]));
        s.mul(along, scale)
    }
}

impl Planar<4> for Quads {
    #[inline(always)]
    fn distance<S: Eight>(s: S, ray: &Ray, [a, b, _, d]: &[[S::F; 3]; 4], [ab, bc, cd, da]: &[S::F; 4]) -> S::F {
        // Opposite edges' areas are as the distances from them, and all four add up to twice the whole.
        let whole = s.add(s.add(*ab, *cd), s.add(*bc, *da));
        let scale = s.div(s.splat(2.0 * ray.shear[2]), whole);
        let u = s.mul(*da, s.sub(b[2], a[2]));
        let v = s.mul(*ab, s.sub(d[2], a[2]));
        let along = s.add(s.mul(s.mul(s.splat(0.5), whole), a[2]), s.add(u, v));
        s.mul(along, scale)
    }
}
