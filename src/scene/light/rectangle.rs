//! A rectangle as seen from a point: every direction that meets it is equally likely [Urena 2013], in double precision and,
//! for most views, in single.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use glam::{DVec3, Vec3A, Vec4, Vec4Swizzles, vec4};

/// In single precision. The four angles of the spherical rectangle are added as products of unit complex numbers, so that one
/// arc tangent does.
#[derive(Clone, Copy, Debug)]
pub struct Quick {
    x: [f32; 2],
    y: [f32; 2],
    z: f32,
    size: [f32; 2],
    /// Components z of the normals of the planes through the sides along x.
    b: [f32; 2],
    /// Cosine and sine of the angle k.
    k: [f32; 2],
    /// sr.
    pub solid_angle: f32,
}

/// Below this (sr) single precision has no digits left for the excess of the angles over a full turn.
const ENOUGH: f32 = 0.03;

fn turn([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a * c - b * d, a * d + b * c]
}

impl Quick {
    /// From a point in front; `None` where double precision is needed. `size` are the lengths of the `sides`, which are at a
    /// right angle, `normal` is their unit normal.
    #[inline]
    pub fn new(from: Vec3A, corner: Vec3A, sides: [Vec3A; 2], size: [f32; 2], normal: Vec3A) -> Option<Quick> {
        let d = corner - from;
        let [x0, y0] = [0, 1].map(|i| d.dot(sides[i]) / size[i]);
        let (x1, y1) = (x0 + size[0], y0 + size[1]);
        let z = d.dot(normal);
        // Planes through the eye and a side, in turn: components z of their normals, and one less their squares, which would be
        // lost in a difference.
        let v = vec4(-y0, x1, y1, -x0);
        let z2 = Vec4::splat(z * z);
        let length2 = v * v + z2;
        let n = v / vec4(length2.x.sqrt(), length2.y.sqrt(), length2.z.sqrt(), length2.w.sqrt());
        let rest = z2 / length2;
        let cos = -n * n.yzwx();
        let sin2 = rest + n * n * rest.yzwx();
        let corner = |i: usize| [cos[i], sin2[i].sqrt()];
        let (front, back) = (turn(corner(0), corner(1)), turn(corner(2), corner(3)));
        let all = turn(front, back);
        let angle = all[1].atan2(all[0]);
        let solid_angle = if angle < 0.0 { angle + TAU } else { angle };
        // An excess of nearly nothing may come out as nearly a full turn.
        (ENOUGH..TAU - ENOUGH).contains(&solid_angle).then_some(Quick {
            x: [x0, x1],
            y: [y0, y1],
            z,
            size,
            b: [n.x, n.z],
            k: [back[0], -back[1]],
            solid_angle,
        })
    }

    /// Fractions of the two sides.
    #[inline]
    pub fn sample(&self, s: [f32; 2]) -> [f32; 2] {
        let (sin, cos) = (s[0] * self.solid_angle).sin_cos();
        let [cos, sin] = turn([cos, sin], self.k);
        let fu = (cos * self.b[0] - self.b[1]) / sin;
        let cu = (1f32.copysign(fu) / (fu * fu + self.b[0] * self.b[0]).sqrt()).clamp(-1.0, 1.0);
        let xu = (cu * self.z.abs() / (1.0 - cu * cu).max(1e-30).sqrt()).clamp(self.x[0], self.x[1]);
        let d2 = xu * xu + self.z * self.z;
        let [h0, h1] = self.y.map(|y| y / (d2 + y * y).sqrt());
        let h = h0 + s[1] * (h1 - h0);
        let yv = (h * (d2 / (1.0 - h * h).max(1e-30)).sqrt()).clamp(self.y[0], self.y[1]);
        [(xu - self.x[0]) / self.size[0], (yv - self.y[0]) / self.size[1]]
    }
}

/// A rectangle as seen from a point [Urena 2013], its names.
pub struct SphericalRectangle {
    from: DVec3,
    axes: [DVec3; 3],
    x0: f64,
    x1: f64,
    y0: f64,
    y1: f64,
    z0: f64,
    b0: f64,
    b1: f64,
    k: f64,
    /// sr.
    pub solid_angle: f64,
}

impl SphericalRectangle {
    /// From a point off the rectangle's plane; `u` and `v` at a right angle.
    pub fn new(from: DVec3, corner: DVec3, u: DVec3, v: DVec3) -> Self {
        let (x, y) = (u.normalize(), v.normalize());
        let mut z = x.cross(y);
        let d = corner - from;
        let mut z0 = d.dot(z);
        if z0 > 0.0 {
            (z, z0) = (-z, -z0);
        }
        let (x0, y0) = (d.dot(x), d.dot(y));
        let (x1, y1) = (x0 + u.length(), y0 + v.length());
        // Components z of the normals of the four planes through the eye and a side.
        let nz = |a0: f64, a1: f64, b: f64| {
            let n = DVec3::new(a0, b, z0).cross(DVec3::new(a1, b, z0));
            n.z / n.length()
        };
        let n0 = nz(x0, x1, y0);
        let n1 = {
            let n = DVec3::new(x1, y0, z0).cross(DVec3::new(x1, y1, z0));
            n.z / n.length()
        };
        let n2 = nz(x1, x0, y1);
        let n3 = {
            let n = DVec3::new(x0, y1, z0).cross(DVec3::new(x0, y0, z0));
            n.z / n.length()
        };
        let angle = |a: f64, b: f64| (-a * b).clamp(-1.0, 1.0).acos();
        // The normals' x and y parts are at right angles for neighbours, so that only z enters the angles between them.
        let (g0, g1, g2, g3) = (angle(n0, n1), angle(n1, n2), angle(n2, n3), angle(n3, n0));
        let k = 2.0 * PI - g2 - g3;
        SphericalRectangle { from, axes: [x, y, z], x0, x1, y0, y1, z0, b0: n0, b1: n2, k, solid_angle: g0 + g1 - k }
    }

    /// A place that is any direction as likely as any other.
    pub fn sample(&self, s: [f64; 2]) -> DVec3 {
        let au = s[0] * self.solid_angle + self.k;
        let fu = (au.cos() * self.b0 - self.b1) / au.sin();
        let cu = (1f64.copysign(fu) / (fu * fu + self.b0 * self.b0).sqrt()).clamp(-1.0, 1.0);
        let xu = (-(cu * self.z0) / (1.0 - cu * cu).max(1e-300).sqrt()).clamp(self.x0, self.x1);
        let d = (xu * xu + self.z0 * self.z0).sqrt();
        let h0 = self.y0 / (d * d + self.y0 * self.y0).sqrt();
        let h1 = self.y1 / (d * d + self.y1 * self.y1).sqrt();
        let h = h0 + s[1] * (h1 - h0);
        let yv = if h * h < 1.0 - 1e-15 { h * d / (1.0 - h * h).sqrt() } else { self.y1 };
        let [x, y, z] = self.axes;
        self.from + x * xu + y * yv.clamp(self.y0, self.y1) + z * self.z0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In single precision the same solid angle and the same places as in double.
    #[test]
    fn quick_is_as_good() {
        let (u, v) = (DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 0.7, 0.0));
        let corner = DVec3::new(-0.6, 0.2, 0.1);
        let normal = u.cross(v).normalize().as_vec3a();
        let (mut seen, mut worst) = (0, 0f64);
        for i in 0..4000 {
            let [a, b, c] = [0.7548776662, 0.5698402910, 0.4346].map(|r| (f64::from(i) * r).fract());
            let from = DVec3::new(4.0 * a - 2.0, 3.0 * b - 1.0, 0.1 + 2.0 * c * c * c * c).as_vec3a();
            let size = [u.length() as f32, v.length() as f32];
            let Some(quick) = Quick::new(from, corner.as_vec3a(), [u.as_vec3a(), v.as_vec3a()], size, normal) else {
                continue;
            };
            seen += 1;
            let whole = SphericalRectangle::new(from.as_dvec3(), corner, u, v);
            assert!((f64::from(quick.solid_angle) / whole.solid_angle - 1.0).abs() < 2e-4, "from {from}: {quick:?}");
            for s in [[0.03, 0.6], [0.5, 0.5], [0.97, 0.1], [0.0, 0.0], [0.9999, 0.9999]] {
                let at = quick.sample(s.map(|s: f64| s as f32)).map(f64::from);
                let off = (corner + u * at[0] + v * at[1] - whole.sample(s)).length();
                // As directions: places far along a grazing rectangle are many to an angle.
                let angle = off * f64::from(quick.z.abs()) / (whole.sample(s) - from.as_dvec3()).length_squared();
                worst = worst.max(angle);
            }
        }
        assert!(seen > 1000 && worst < 2e-4, "{seen} views, {worst} rad");
    }
}
