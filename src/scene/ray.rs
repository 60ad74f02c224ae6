//! Rays and the small geometry around them.

use glam::Vec3A;

/// Moves a point off its surface, to the side that `normal` points to, by a few units in the last place: far enough that a
/// ray from there does not meet the surface again, near enough not to be seen [Waechter 2019], a quarter of that paper's
/// steps: the places come to the last bit of the surface here.
pub fn offset(point: Vec3A, normal: Vec3A) -> Vec3A {
    const NEAR: f32 = 1.0 / 32.0;
    const FLOAT_SCALE: f32 = 1.0 / 262_144.0;
    const INT_SCALE: f32 = 64.0;
    let one = |p: f32, n: f32| {
        let steps = (INT_SCALE * n) as i32;
        let moved = f32::from_bits((p.to_bits() as i32).wrapping_add(if p < 0.0 { -steps } else { steps }) as u32);
        if p.abs() < NEAR { p + FLOAT_SCALE * n } else { moved }
    };
    Vec3A::new(one(point.x, normal.x), one(point.y, normal.y), one(point.z, normal.z))
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
