//! Rays and the small geometry around them.

use glam::Vec3A;

/// Moves a point off its surface, to the side that `normal` points to, by a few units in the last place of `reach`, the largest
/// coordinate that the place was computed from: far enough that a ray from there does not meet the surface again, near enough not
/// to be seen. Where a wide floor is met near the origin it is the floor's corners that rounding goes by, not the place's own
/// coordinates, as in Waechter and Binder (2019).
#[inline]
pub fn offset(point: Vec3A, normal: Vec3A, reach: f32) -> Vec3A {
    const SHARE: f32 = 1.0 / 131_072.0;
    const NEAR: f32 = 1.0 / 1_048_576.0;
    point + normal * (SHARE * reach.max(NEAR))
}

/// Moves a point of a surface on along a way through it, as far as [`offset`] moves it off: a way that goes straight on stays on its
/// line. Where it grazes the surface, off the surface.
pub fn onward(point: Vec3A, direction: Vec3A, normal: Vec3A, reach: f32) -> Vec3A {
    let cos = direction.dot(normal);
    let side = if cos < 0.0 { -normal } else { normal };
    let off = offset(point, side, reach);
    if cos.abs() < 0.02 { off } else { point + direction * ((off - point).dot(side) / cos.abs()) }
}

/// Two vectors that complete a unit vector to an orthonormal frame (Duff et al. 2017).
pub fn frame(n: Vec3A) -> (Vec3A, Vec3A) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3A::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3A::new(b, sign + n.y * n.y * a, -n.y))
}

/// A direction about `n` with density cos/pi, from two numbers in 0..1 (Malley's method).
pub fn cosine_direction(n: Vec3A, u: [f32; 2]) -> Vec3A {
    let local = crate::material::kernel::lambert::cosine(u);
    let (s, t) = frame(n);
    (s * local.x + t * local.y + n * local.z).normalize()
}
