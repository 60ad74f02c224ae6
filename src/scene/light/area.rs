//! Shining surfaces and how to aim at them: rectangles, triangles, disks and spheres by the solid angle they fill, cylinders
//! by area.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::scene::light::angular::Angular;
use crate::scene::light::disk::SphericalEllipse;
use crate::scene::light::rectangle::{Quick, SphericalRectangle};
use crate::scene::light::{Aim, Emission};
use crate::scene::ray;

/// Below this solid angle (sr) the spherical formulas lose digits, and a point of the area is as good.
const SMALL: f64 = 1e-5;

/// A surface that shines to its front.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Index of the light.
    pub light: usize,
    /// Its form.
    pub shape: Shape,
    /// How its radiance goes with the angle to the normal; `None` the same everywhere.
    pub angular: Option<Arc<Angular>>,
    /// A flat one in single precision.
    flat: Option<Flat>,
    /// The largest coordinate of a box around it.
    reach: f32,
}

/// Size in the frame's units from which on a surface is vast.
const VAST: f32 = 64.0;

/// A parallelogram or triangle seen from afar: a place of its area is as good as one of its solid angle, and far cheaper.
#[derive(Clone, Copy, Debug)]
struct Flat {
    corner: Vec3A,
    sides: [Vec3A; 2],
    triangle: bool,
    normal: Vec3A,
    area: f32,
    /// Lengths of the sides.
    size: [f32; 2],
    middle: Vec3A,
    /// Squared distance of the middle from which on it is far.
    far2: f32,
}

/// Far is where the area over the squared distance of the nearest place is below this.
const FAR: f64 = 0.25;

impl Flat {
    fn new(shape: &Shape) -> Option<Flat> {
        let (corner, u, v, triangle) = match shape {
            Shape::Rectangle { corner, u, v } => (*corner, *u, *v, false),
            Shape::Triangle([a, b, c]) => (*a, *b - *a, *c - *a, true),
            _ => return None,
        };
        let cross = u.cross(v);
        let area = cross.length() * if triangle { 0.5 } else { 1.0 };
        let middle = corner + (u + v) * if triangle { 1.0 / 3.0 } else { 0.5 };
        let reach = [corner, corner + u, corner + v].iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let far = (area / FAR).sqrt() + reach;
        Some(Flat {
            corner: corner.as_vec3a(),
            sides: [u.as_vec3a(), v.as_vec3a()],
            triangle,
            normal: cross.normalize().as_vec3a(),
            area: area as f32,
            size: [u.length() as f32, v.length() as f32],
            middle: middle.as_vec3a(),
            far2: (far * far) as f32,
        })
    }

    #[inline]
    fn is_far(&self, from: Vec3A) -> bool {
        (self.middle - from).length_squared() > self.far2
    }

    /// From nearer: a rectangle by its solid angle where single precision has the digits for it. Most views are from afar: this
    /// and what follows from it stay out of their way.
    #[inline(never)]
    fn quick(&self, from: Vec3A) -> Option<Quick> {
        if self.triangle { None } else { Quick::new(from, self.corner, self.sides, self.size, self.normal) }
    }

    #[inline(never)]
    fn place_near(&self, from: Vec3A, seen: &Quick, sample: [f32; 2]) -> Place {
        let [a, b] = seen.sample(sample);
        let point = self.corner + self.sides[0] * a + self.sides[1] * b;
        Place { point, normal: self.normal, direction: (point - from).normalize(), pdf: 1.0 / seen.solid_angle }
    }

    /// Any place of the area as likely as any other.
    fn spot(&self, [s, t]: [f32; 2]) -> Vec3A {
        let (a, b) = if self.triangle {
            let root = s.sqrt();
            (root * (1.0 - t), root * t)
        } else {
            (s, t)
        };
        self.corner + self.sides[0] * a + self.sides[1] * b
    }

    fn place(&self, from: Vec3A, s: [f32; 2]) -> Option<Place> {
        let point = self.spot(s);
        let to = point - from;
        let along = -to.dot(self.normal);
        (along > 0.0).then(|| {
            let squared = to.length_squared();
            let distance = squared.sqrt();
            let pdf = squared * distance / (along * self.area);
            Place { point, normal: self.normal, direction: to / distance, pdf }
        })
    }
}

/// Forms that can be aimed at.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A corner and two sides at a right angle; the front is the side of `u` x `v`.
    Rectangle {
        /// Corner.
        corner: DVec3,
        /// One side.
        u: DVec3,
        /// The other.
        v: DVec3,
    },
    /// The front is the side from which the corners run counter-clockwise.
    Triangle([DVec3; 3]),
    /// The front is outside, or inside where `inward`.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
        /// Shines into itself.
        inward: bool,
    },
    /// A flat disk.
    Disk {
        /// Centre.
        center: DVec3,
        /// Unit normal of the front.
        normal: DVec3,
        /// Radius.
        radius: f64,
        /// Radius of the hole in the middle; 0 for none.
        inner: f64,
    },
    /// An open frustum of a cone.
    Cone {
        /// Middle of one end.
        base: DVec3,
        /// From there to the middle of the other end.
        axis: DVec3,
        /// Radii of both ends.
        radii: [f64; 2],
        /// Shines into itself.
        inward: bool,
    },
    /// An open tube.
    Cylinder {
        /// Middle of one end.
        base: DVec3,
        /// From there to the middle of the other end.
        axis: DVec3,
        /// Radius.
        radius: f64,
        /// Shines into itself.
        inward: bool,
    },
}

/// A place chosen on an emitter.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The place.
    point: Vec3A,
    /// The front's unit normal there.
    normal: Vec3A,
    /// Unit direction from where one stands.
    direction: Vec3A,
    /// Density of that direction, 1/sr.
    pdf: f32,
}

impl Emitter {
    /// A surface with its light.
    pub fn new(light: usize, shape: Shape) -> Emitter {
        let mut emitter = Emitter { light, flat: Flat::new(&shape), shape, angular: None, reach: 0.0 };
        let ([low, high], ..) = emitter.bounds();
        emitter.reach = low.abs().max(high.abs()).max_element() as f32;
        emitter
    }

    /// Reaches so far that single precision cannot tell a place on it from one just in front of it: whether it is seen is asked
    /// by what is met, not by whether anything lies before the place.
    pub fn is_vast(&self) -> bool {
        self.reach > VAST
    }

    /// Area in m2.
    pub fn area_m2(&self) -> f64 {
        match &self.shape {
            Shape::Rectangle { u, v, .. } => u.cross(*v).length(),
            Shape::Triangle([a, b, c]) => 0.5 * (*b - *a).cross(*c - *a).length(),
            Shape::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Shape::Disk { radius, inner, .. } => PI * (radius * radius - inner * inner),
            Shape::Cone { axis, radii: [a, b], .. } => PI * (a + b) * axis.length().hypot(b - a),
            Shape::Cylinder { axis, radius, .. } => 2.0 * PI * radius * axis.length(),
        }
    }

    /// Corners of a box around it, and the cone of its normals: axis and cosine of the half angle.
    pub fn bounds(&self) -> ([DVec3; 2], DVec3, f64) {
        let hull = |points: &[DVec3]| {
            let low = points.iter().fold(DVec3::INFINITY, |a, p| a.min(*p));
            [low, points.iter().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p))]
        };
        match &self.shape {
            Shape::Rectangle { corner, u, v } => {
                let all = [*corner, *corner + *u, *corner + *v, *corner + *u + *v];
                (hull(&all), u.cross(*v).normalize(), 1.0)
            }
            Shape::Triangle(t) => (hull(t), (t[1] - t[0]).cross(t[2] - t[0]).normalize(), 1.0),
            Shape::Sphere { center, radius, .. } => ([*center - *radius, *center + *radius], DVec3::Z, -1.0),
            Shape::Disk { center, normal, radius, .. } => ([*center - *radius, *center + *radius], *normal, 1.0),
            Shape::Cone { base, axis, radii: [a, b], .. } => {
                let top = *base + *axis;
                (hull(&[*base - *a, *base + *a, top - *b, top + *b]), DVec3::Z, -1.0)
            }
            Shape::Cylinder { base, axis, radius, .. } => {
                let [low, high] = hull(&[*base, *base + *axis]);
                ([low - *radius, high + *radius], DVec3::Z, -1.0)
            }
        }
    }

    /// Its radiance at a cosine with the normal.
    #[inline]
    pub fn emission(&self, cos: f32) -> Emission {
        Emission::one(self.light as u32, self.angular.as_ref().map_or(1.0, |a| a.factor(cos)))
    }

    /// Its flux over its area and the radiance that its light's spectrum is, sr.
    pub fn etendue_sr(&self) -> f64 {
        self.angular.as_ref().map_or(PI, |a| a.integral_sr(true))
    }

    /// Aims at its light as seen from a place.
    #[inline]
    pub fn aim(&self, from: Vec3A, u: [f32; 2]) -> Option<Aim> {
        let Place { point, normal, direction, pdf } = self.place(from, u)?;
        let emission = self.emission(-direction.dot(normal));
        Some(Aim { direction, point: Some(ray::offset(point, normal, self.reach)), pdf, emission })
    }

    /// A place of it, whoever looks: any of its area as likely as any other, but for round ones, whose middle or axis does.
    pub fn pivot(&self, [s, t]: [f32; 2]) -> Vec3A {
        match (&self.flat, &self.shape) {
            (Some(flat), _) => flat.spot([s, t]),
            (None, Shape::Sphere { center, .. }) => center.as_vec3a(),
            (None, Shape::Cylinder { base, axis, .. } | Shape::Cone { base, axis, .. }) => {
                (*base + *axis * f64::from(s)).as_vec3a()
            }
            (None, Shape::Disk { center, normal, radius, inner }) => {
                on_ring(*center, *normal, [*inner, *radius], [s, t].map(f64::from)).as_vec3a()
            }
            // Flat ones all have it.
            (None, Shape::Rectangle { corner, .. } | Shape::Triangle([corner, ..])) => corner.as_vec3a(),
        }
    }

    /// Chooses a place as seen from `from`; `None` where the front cannot be seen.
    #[inline]
    fn place(&self, from: Vec3A, sample: [f32; 2]) -> Option<Place> {
        if let Some(flat) = self.flat.as_ref().filter(|f| f.is_far(from)) {
            return flat.place(from, sample);
        }
        if let Some(flat) = &self.flat {
            if flat.normal.dot(from - flat.corner) <= 0.0 {
                return None;
            }
            if let Some(seen) = flat.quick(from) {
                return Some(flat.place_near(from, &seen, sample));
            }
        }
        self.place_exactly(from, sample)
    }

    /// In double precision: rare for flat ones, and kept out of the way of the rest.
    #[inline(never)]
    fn place_exactly(&self, from: Vec3A, sample: [f32; 2]) -> Option<Place> {
        let from = from.as_dvec3();
        let s = sample.map(f64::from);
        let (point, normal, pdf) = match &self.shape {
            Shape::Rectangle { corner, u, v } => {
                let normal = u.cross(*v).normalize();
                if normal.dot(from - *corner) <= 0.0 {
                    return None;
                }
                let seen = SphericalRectangle::new(from, *corner, *u, *v);
                if seen.solid_angle > SMALL {
                    (seen.sample(s), normal, 1.0 / seen.solid_angle)
                } else {
                    let point = *corner + *u * s[0] + *v * s[1];
                    (point, normal, area_pdf(from, point, normal, self.area_m2()))
                }
            }
            Shape::Triangle(t) => {
                let normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
                if normal.dot(from - t[0]) <= 0.0 {
                    return None;
                }
                let seen = SphericalTriangle::new(from, t);
                if seen.solid_angle > SMALL {
                    (seen.sample(from, t[0], normal, s), normal, 1.0 / seen.solid_angle)
                } else {
                    let root = s[0].sqrt();
                    let point = t[0] * (1.0 - root) + t[1] * (root * (1.0 - s[1])) + t[2] * (root * s[1]);
                    (point, normal, area_pdf(from, point, normal, self.area_m2()))
                }
            }
            Shape::Sphere { center, radius, inward } => aim_at_sphere(from, *center, *radius, *inward, s)?,
            Shape::Disk { center, normal, radius, inner } if *inner > 0.0 => {
                if normal.dot(from - *center) <= 0.0 {
                    return None;
                }
                let point = on_ring(*center, *normal, [*inner, *radius], s);
                (point, *normal, area_pdf(from, point, *normal, self.area_m2()))
            }
            Shape::Disk { center, normal, radius, .. } => {
                let seen = SphericalEllipse::new(from, *center, *normal, *radius)?;
                let (point, pdf) = seen.sample(s)?;
                (point, *normal, pdf)
            }
            Shape::Cone { base, axis, radii, inward } => {
                let (point, out) = on_cone(*base, *axis, *radii, s);
                let normal = if *inward { -out } else { out };
                if normal.dot(from - point) <= 0.0 {
                    return None;
                }
                (point, normal, area_pdf(from, point, normal, self.area_m2()))
            }
            Shape::Cylinder { base, axis, radius, inward } => {
                let (x, y) = axis.normalize().any_orthonormal_pair();
                let (sin, cos) = (2.0 * PI * s[1]).sin_cos();
                let out = x * cos + y * sin;
                let point = *base + *axis * s[0] + out * *radius;
                let normal = if *inward { -out } else { out };
                if normal.dot(from - point) <= 0.0 {
                    return None;
                }
                (point, normal, area_pdf(from, point, normal, self.area_m2()))
            }
        };
        let direction = (point - from).normalize();
        (pdf > 0.0 && pdf.is_finite() && direction.is_finite()).then(|| Place {
            point: point.as_vec3a(),
            normal: normal.as_vec3a(),
            direction: direction.as_vec3a(),
            pdf: pdf as f32,
        })
    }

    /// Density, 1/sr, with which [`Emitter::aim`] chooses the direction from `from` to `point` on this emitter.
    pub fn pdf(&self, from: Vec3A, point: Vec3A, normal: Vec3A) -> f32 {
        if let Some(flat) = self.flat.as_ref().filter(|f| f.is_far(from)) {
            let to = point - from;
            let squared = to.length_squared();
            return squared * squared.sqrt() / (to.dot(flat.normal).abs() * flat.area);
        }
        if let Some(seen) = self.flat.as_ref().and_then(|f| f.quick(from)) {
            return 1.0 / seen.solid_angle;
        }
        let from = from.as_dvec3();
        let by_area = || area_pdf(from, point.as_dvec3(), normal.as_dvec3(), self.area_m2());
        let by_angle = |angle: f64| if angle > SMALL { 1.0 / angle } else { by_area() };
        let pdf = match &self.shape {
            Shape::Rectangle { corner, u, v } => by_angle(SphericalRectangle::new(from, *corner, *u, *v).solid_angle),
            Shape::Triangle(t) => by_angle(SphericalTriangle::new(from, t).solid_angle),
            Shape::Sphere { center, radius, .. } => match cone(from, *center, *radius) {
                Some(one_minus_cos) => 1.0 / (2.0 * PI * one_minus_cos),
                None => by_area(),
            },
            Shape::Disk { inner, .. } if *inner > 0.0 => by_area(),
            Shape::Disk { center, normal, radius, .. } => SphericalEllipse::new(from, *center, *normal, *radius)
                .map_or(0.0, |seen| seen.pdf(point.as_dvec3() - from)),
            Shape::Cylinder { .. } | Shape::Cone { .. } => by_area(),
        };
        pdf as f32
    }
}

/// A place of a ring between two radii, any of its area as likely as any other.
fn on_ring(center: DVec3, normal: DVec3, [inner, radius]: [f64; 2], s: [f64; 2]) -> DVec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (2.0 * PI * s[1]).sin_cos();
    center + (x * cos + y * sin) * (inner * inner + (radius * radius - inner * inner) * s[0]).sqrt()
}

/// The same of a frustum, with its outward normal there.
fn on_cone(base: DVec3, axis: DVec3, [a, b]: [f64; 2], s: [f64; 2]) -> (DVec3, DVec3) {
    let (x, y) = axis.normalize().any_orthonormal_pair();
    let (sin, cos) = (2.0 * PI * s[1]).sin_cos();
    let out = x * cos + y * sin;
    let r = (a * a + (b * b - a * a) * s[0]).max(0.0).sqrt();
    let h = (s[0] * (a + b) / (r + a)).min(1.0);
    let normal = (out * axis.length() - axis.normalize() * (b - a)).normalize();
    (base + axis * h + out * (a + (b - a) * h), normal)
}

fn area_pdf(from: DVec3, point: DVec3, normal: DVec3, area: f64) -> f64 {
    let d = point - from;
    let squared = d.length_squared();
    squared * squared.sqrt() / (d.dot(normal).abs() * area)
}

/// 1 - cos of the half angle of the cone in which a sphere is seen from outside; `None` from inside.
fn cone(from: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let squared = (center - from).length_squared();
    let sin2 = radius * radius / squared;
    // 1 - sqrt(1 - s) without cancellation for far, small spheres.
    (squared > radius * radius * (1.0 + 1e-9)).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
}

fn aim_at_sphere(from: DVec3, center: DVec3, radius: f64, inward: bool, s: [f64; 2]) -> Option<(DVec3, DVec3, f64)> {
    let phi = 2.0 * PI * s[1];
    let Some(one_minus_cos) = cone(from, center, radius) else {
        if !inward {
            return None;
        }
        let z = 1.0 - 2.0 * s[0];
        let r = (1.0 - z * z).max(0.0).sqrt();
        let out = DVec3::new(r * phi.cos(), r * phi.sin(), z);
        let point = center + out * radius;
        return Some((point, -out, area_pdf(from, point, out, 4.0 * PI * radius * radius)));
    };
    if inward {
        return None; // from outside the front, within, lies behind the sphere's own back
    }
    let to_center = center - from;
    let distance = to_center.length();
    let axis = to_center / distance;
    let cos = 1.0 - s[0] * one_minus_cos;
    let sin2 = (s[0] * one_minus_cos * (2.0 - s[0] * one_minus_cos)).max(0.0);
    let (t, b) = axis.any_orthonormal_pair();
    let direction = axis * cos + (t * phi.cos() + b * phi.sin()) * sin2.sqrt();
    let along = distance * cos - (radius * radius - distance * distance * sin2).max(0.0).sqrt();
    let out = (from + direction * along - center).normalize();
    Some((center + out * radius, out, 1.0 / (2.0 * PI * one_minus_cos)))
}

/// A triangle as seen from a point [Arvo 1995], its names.
struct SphericalTriangle {
    corners: [DVec3; 3],
    cos_alpha: f64,
    sin_alpha: f64,
    cos_c: f64,
    alpha: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    fn new(from: DVec3, t: &[DVec3; 3]) -> Self {
        let [a, b, c] = t.map(|p| (p - from).normalize());
        let (ab, bc, ca) = (a.cross(b).normalize(), b.cross(c).normalize(), c.cross(a).normalize());
        let between = |u: DVec3, v: DVec3| u.angle_between(-v);
        let (alpha, beta, gamma) = (between(ab, ca), between(bc, ab), between(ca, bc));
        let solid_angle = alpha + beta + gamma - PI;
        let solid_angle = if solid_angle.is_finite() { solid_angle } else { 0.0 };
        SphericalTriangle {
            corners: [a, b, c],
            cos_alpha: alpha.cos(),
            sin_alpha: alpha.sin(),
            cos_c: a.dot(b),
            alpha,
            solid_angle,
        }
    }

    fn sample(&self, from: DVec3, on_plane: DVec3, normal: DVec3, s: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.corners;
        let (sin_phi, cos_phi) = (s[0] * self.solid_angle - self.alpha).sin_cos();
        let u = cos_phi - self.cos_alpha;
        let v = sin_phi + self.sin_alpha * self.cos_c;
        let numerator = (v * cos_phi - u * sin_phi) * self.cos_alpha - v;
        let denominator = (v * sin_phi + u * cos_phi) * self.sin_alpha;
        let cos_b = if denominator == 0.0 { 1.0 } else { (numerator / denominator).clamp(-1.0, 1.0) };
        let across = (c - a * c.dot(a)).normalize_or_zero();
        let c_new = a * cos_b + across * (1.0 - cos_b * cos_b).max(0.0).sqrt();
        let z = 1.0 - s[1] * (1.0 - c_new.dot(b));
        let toward = (c_new - b * c_new.dot(b)).normalize_or_zero();
        let direction = b * z + toward * (1.0 - z * z).max(0.0).sqrt();
        from + direction * (normal.dot(on_plane - from) / normal.dot(direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> Vec<Emitter> {
        let quad = Shape::Rectangle {
            corner: DVec3::new(-1.0, -1.0, 0.0),
            u: DVec3::new(2.0, 0.0, 0.0),
            v: DVec3::new(0.0, 3.0, 0.0),
        };
        let triangle =
            Shape::Triangle([DVec3::new(-1.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 0.3), DVec3::new(0.0, 1.5, 0.0)]);
        let ball = Shape::Sphere { center: DVec3::new(0.2, 0.0, 0.0), radius: 0.7, inward: false };
        let room = Shape::Sphere { center: DVec3::ZERO, radius: 9.0, inward: true };
        let disk = Shape::Disk { center: DVec3::new(0.1, 0.2, 0.0), normal: DVec3::Z, radius: 1.3, inner: 0.0 };
        let ring = Shape::Disk { center: DVec3::new(0.1, 0.2, 0.0), normal: DVec3::Z, radius: 1.3, inner: 0.6 };
        let shade = Shape::Cone { base: DVec3::new(0.2, 0.1, -2.0), axis: DVec3::Z, radii: [0.9, 0.2], inward: false };
        let (base, axis) = (DVec3::new(0.2, 0.1, -2.0), DVec3::new(0.3, 0.0, 1.5));
        let tube = Shape::Cylinder { base, axis, radius: 0.4, inward: false };
        [quad, triangle, ball, room, disk, tube, ring, shade].into_iter().map(|shape| Emitter::new(0, shape)).collect()
    }

    /// Irradiance from unit radiance by aiming equals the integral over a fine grid of the area.
    #[test]
    fn aiming_integrates_the_cosine_law() {
        let normal = Vec3A::new(0.1, -0.2, -1.0).normalize();
        for (i, emitter) in shapes().iter().enumerate() {
            for from in [Vec3A::new(0.3, 0.2, 1.0), Vec3A::new(-1.5, 2.0, 3.0), Vec3A::new(0.9, -0.9, 0.8)] {
                let n = 256;
                let (mut sum, mut check, mut count) = (0.0, 0.0f64, 0.0);
                for a in 0..n {
                    for b in 0..n {
                        let s = [(a as f32 + 0.5) / n as f32, (b as f32 + 0.5) / n as f32];
                        let Some(aim) = emitter.place(from, s) else { continue };
                        let again = emitter.pdf(from, aim.point, aim.normal);
                        assert!((aim.pdf / again - 1.0).abs() < 2e-3, "shape {i}: {} {again}", aim.pdf);
                        assert!(aim.normal.dot(-aim.direction) > -1e-3, "shape {i} shows its back");
                        sum += f64::from(normal.dot(aim.direction).max(0.0) / aim.pdf);
                        // The mean of cos / distance^2 / pdf over directions is the area seen from the front.
                        count += 1.0;
                        let d = f64::from((aim.point - from).length_squared());
                        check += d / f64::from(-aim.direction.dot(aim.normal)).max(1e-6) / f64::from(aim.pdf);
                    }
                }
                let want = by_area(emitter, from, normal);
                let got = sum / f64::from(n * n);
                assert!((got - want).abs() < 4e-3 * want.max(0.05), "shape {i} from {from}: {got} for {want}");
                if matches!(emitter.shape, Shape::Rectangle { .. } | Shape::Triangle(_)) {
                    assert!(
                        (check / count / emitter.area_m2() - 1.0).abs() < 2e-2,
                        "shape {i}: area {}",
                        check / count
                    );
                }
            }
        }
    }

    fn by_area(emitter: &Emitter, from: Vec3A, normal: Vec3A) -> f64 {
        let n = 1000;
        let mut sum = 0.0;
        for a in 0..n {
            for b in 0..n {
                let (s, t) = ((a as f64 + 0.5) / n as f64, (b as f64 + 0.5) / n as f64);
                let (p, front) = match &emitter.shape {
                    Shape::Rectangle { corner, u, v } => (*corner + *u * s + *v * t, u.cross(*v).normalize()),
                    Shape::Triangle([p, q, r]) => {
                        let root = s.sqrt();
                        (
                            *p * (1.0 - root) + *q * (root * (1.0 - t)) + *r * (root * t),
                            (*q - *p).cross(*r - *p).normalize(),
                        )
                    }
                    Shape::Sphere { center, radius, inward } => {
                        let (z, phi) = (1.0 - 2.0 * s, 2.0 * PI * t);
                        let r = (1.0 - z * z).sqrt();
                        let out = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                        (*center + out * *radius, if *inward { -out } else { out })
                    }
                    Shape::Disk { center, normal, radius, inner } => {
                        let (x, y) = normal.any_orthonormal_pair();
                        let (r, phi) = ((inner * inner * (1.0 - s) + radius * radius * s).sqrt(), 2.0 * PI * t);
                        (*center + x * (r * phi.cos()) + y * (r * phi.sin()), *normal)
                    }
                    // Rings of equal area, by cutting the whole cone from its apex.
                    Shape::Cone { base, axis, radii: [a, b], .. } => {
                        let (x, y) = axis.normalize().any_orthonormal_pair();
                        let (sin, cos) = (2.0 * PI * t).sin_cos();
                        let r = (a * a + (b * b - a * a) * s).sqrt();
                        let (out, h) = (x * cos + y * sin, (r - a) / (b - a));
                        let tilt = (out * axis.length() - axis.normalize() * (b - a)).normalize();
                        (*base + *axis * h + out * r, tilt)
                    }
                    Shape::Cylinder { base, axis, radius, inward } => {
                        let (x, y) = axis.normalize().any_orthonormal_pair();
                        let out = x * (2.0 * PI * t).cos() + y * (2.0 * PI * t).sin();
                        (*base + *axis * s + out * *radius, if *inward { -out } else { out })
                    }
                };
                let d = p - from.as_dvec3();
                let w = d.normalize();
                let seen = (-w.dot(front)).max(0.0) * w.dot(normal.as_dvec3()).max(0.0) / d.length_squared();
                sum += seen * emitter.area_m2() / f64::from(n * n);
            }
        }
        sum
    }
}
