//! A disk as seen from a point: a spherical ellipse [Guillen 2017]. Its azimuth about the middle is chosen as in an ellipse of
//! the same half axes on an equal-area map, its distance from the middle by solid angle: near enough to equal density
//! (equal for small and for centred disks), and every step has a closed form and an exact density.

use std::f64::consts::PI;

use glam::DVec3;

/// The cone under which a disk is seen.
pub struct SphericalEllipse {
    from: DVec3,
    center: DVec3,
    normal: DVec3,
    axes: [DVec3; 3],
    /// Tangents of the half axes.
    tan: [f64; 2],
    /// The half axes on an equal-area map: sqrt(2 (1 - cos)).
    flat: [f64; 2],
}

impl SphericalEllipse {
    /// From a point in front of the disk; `None` behind it.
    pub fn new(from: DVec3, center: DVec3, normal: DVec3, radius: f64) -> Option<SphericalEllipse> {
        let to = center - from;
        let height = -to.dot(normal);
        if height <= 0.0 {
            return None;
        }
        // The plane through the eye and the disk's axis holds the longest and the shortest way to the rim.
        let aside = to + normal * height;
        let y = if aside.length_squared() > 1e-24 * radius * radius {
            aside.normalize()
        } else {
            normal.any_orthonormal_vector()
        };
        let x = y.cross(normal);
        let (near, far) = ((to - y * radius).normalize(), (to + y * radius).normalize());
        let z = (near + far).normalize_or_zero();
        // Half the angle between them, by a formula that keeps its digits for small ones.
        let tan_y = (far - near).length() / (far + near).length();
        // Where the middle of the cone meets the disk's plane, and the chord across.
        let along = height / -z.dot(normal);
        let middle = z * along - to;
        let half_chord = (radius * radius - middle.length_squared()).max(0.0).sqrt();
        let tan_x = half_chord / along;
        let flat = |t: f64| {
            let cos = 1.0 / (1.0 + t * t).sqrt();
            (2.0 * (t * t * cos * cos / (1.0 + cos))).sqrt()
        };
        let axes = [x, z.cross(x), z];
        let fits = z != DVec3::ZERO && tan_x > 0.0 && tan_y > 0.0 && tan_x.is_finite() && tan_y.is_finite();
        fits.then(|| SphericalEllipse {
            from,
            center,
            normal,
            axes,
            tan: [tan_x, tan_y],
            flat: [flat(tan_x), flat(tan_y)],
        })
    }

    /// Density of the azimuth (cos, sin), 1/rad, and 1 - cos of the rim there.
    fn azimuth(&self, cos: f64, sin: f64) -> (f64, f64) {
        let radius2 = |[a, b]: [f64; 2]| 1.0 / ((cos / a).powi(2) + (sin / b).powi(2));
        let density = radius2(self.flat) / (2.0 * PI * self.flat[0] * self.flat[1]);
        let tan2 = radius2(self.tan);
        let rim_cos = 1.0 / (1.0 + tan2).sqrt();
        (density, tan2 * rim_cos * rim_cos / (1.0 + rim_cos))
    }

    /// A point of the disk and the density of its direction, 1/sr.
    pub fn sample(&self, s: [f64; 2]) -> Option<(DVec3, f64)> {
        let (sin, cos) = (2.0 * PI * s[0]).sin_cos();
        let (a, b) = (self.flat[0] * cos, self.flat[1] * sin);
        let length = a.hypot(b);
        let (cos, sin) = (a / length, b / length);
        let (density, rim) = self.azimuth(cos, sin);
        let down = s[1] * rim;
        let across = (down * (2.0 - down)).max(0.0).sqrt();
        let [x, y, z] = self.axes;
        let direction = x * (across * cos) + y * (across * sin) + z * (1.0 - down);
        let along = (self.center - self.from).dot(self.normal) / direction.dot(self.normal);
        let pdf = density / rim;
        (along > 0.0 && pdf.is_finite()).then(|| (self.from + direction * along, pdf))
    }

    /// Density, 1/sr, of a direction (of any length) that meets the disk.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let (a, b) = (direction.dot(self.axes[0]), direction.dot(self.axes[1]));
        let length = a.hypot(b);
        let (cos, sin) = if length > 0.0 { (a / length, b / length) } else { (1.0, 0.0) };
        let (density, rim) = self.azimuth(cos, sin);
        density / rim
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of 1 / pdf is the solid angle, the mean of cos / pdf the form factor, whose closed form is known.
    #[test]
    fn a_disk_fills_its_solid_angle() {
        for (height, aside, radius) in
            [(2.0, 0.0, 0.5), (2.0, 4.0, 0.5), (0.1, 0.5, 2.0), (0.01, 0.99, 1.0), (30.0, 1.0, 0.1)]
        {
            let center = DVec3::new(aside, 0.0, height);
            let seen = SphericalEllipse::new(DVec3::ZERO, center, -DVec3::Z, radius).unwrap();
            let n = 400;
            let mut e = 0.0;
            for i in 0..n * n {
                let s = [((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64];
                let (p, pdf) = seen.sample(s).unwrap();
                assert!((p - center).length() <= radius * (1.0 + 1e-6), "{p} is off the disk");
                assert!((seen.pdf(p) / pdf - 1.0).abs() < 1e-6);
                e += p.normalize().z / pdf;
            }
            let e = e / (n * n) as f64;
            let (h2, d2, a2) = (height * height, aside * aside, radius * radius);
            let want = PI / 2.0 * (1.0 - (h2 + d2 - a2) / ((h2 + d2 + a2).powi(2) - 4.0 * a2 * d2).sqrt());
            assert!((e / want - 1.0).abs() < 2e-3, "{height} {aside} {radius}: {e} for {want}");
        }
    }
}
