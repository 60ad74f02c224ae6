//! How a picture was seen: the VIEW line in Radiance's words, directions of its points and back [Radiance, `rpict` -v options].
//!
//! Directions are unit vectors in the eye's own frame: x to the right, y up, z along the line of sight. Points of the picture
//! are u from 0 (left) to 1 (right), v from 0 (bottom) to 1 (top).
//!
//! | type | projection, with x and y offsets from the middle in shares of the picture |
//! |---|---|
//! | `v` perspective | direction ~ (2 x tan(h/2), 2 y tan(v/2), 1) |
//! | `c` cylindrical panorama | azimuth x h, height 2 y tan(v/2) |
//! | `h` hemispherical fisheye | (2 x sin(h/2), 2 y sin(v/2)) are the direction's own x and y |
//! | `a` angular fisheye | angle from the line of sight = hypot(x h, y v) |
//! | `s` planispheric fisheye | stereographic: hypot(2 x tan(h/4), 2 y tan(v/4)) = tan(angle/2) |
//!
//! A parallel view (`l`) has no directions that differ.

use crate::stream::Header;

/// Radiance's assumption where a picture does not say how it was seen, on its long side.
const DEFAULT_DEGREES: f64 = 40.0;
/// Views up to this wide are details, not what an eye saw.
const NARROWEST_DEGREES: f64 = 5.0;

/// Projections with one eye point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `-vtv`
    Perspective,
    /// `-vtc`
    Cylindrical,
    /// `-vth`
    Hemispherical,
    /// `-vta`
    Angular,
    /// `-vts`
    Planispheric,
}

impl Kind {
    /// Radiance's letter after `-vt`.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Perspective => "v",
            Kind::Cylindrical => "c",
            Kind::Hemispherical => "h",
            Kind::Angular => "a",
            Kind::Planispheric => "s",
        }
    }
}

/// A view: projection and angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Projection.
    pub kind: Kind,
    /// Whole angle across, degrees.
    pub horizontal_deg: f64,
    /// Whole angle from bottom to top, degrees.
    pub vertical_deg: f64,
    /// Offset of the middle across, in widths (`-vs`).
    pub shift: f64,
    /// Offset upward, in heights (`-vl`).
    pub lift: f64,
}

impl View {
    /// The view a header states; `None` where there is none, where it is parallel, and where it is no view of an eye (5
    /// degrees or narrower, or angles that the projection cannot have).
    pub fn of(header: &Header) -> Option<View> {
        View::parse(std::str::from_utf8(header.variable("VIEW")?).ok()?)
    }

    /// Radiance's assumption: a perspective of 40 degrees on the long side.
    pub fn assumed(width: usize, height: usize) -> View {
        let long = 2.0 * (DEFAULT_DEGREES / 2.0).to_radians().tan();
        let degrees = |n: usize| 2.0 * (0.5 * long * n as f64 / width.max(height) as f64).atan().to_degrees();
        View {
            kind: Kind::Perspective,
            horizontal_deg: degrees(width),
            vertical_deg: degrees(height),
            shift: 0.0,
            lift: 0.0,
        }
    }

    /// From the text after `VIEW=`. Options that do not matter here (`-vp`, `-vd`, `-vu`, `-vo`, `-va`) are passed over; of
    /// an option that comes twice the last counts.
    ///
    /// ```
    /// use luxpipe::view::{Kind, View};
    /// let v = View::parse(" -vta -vp 0 0 0 -vd 0 1 0 -vh 180 -vv 180").unwrap();
    /// assert_eq!((v.kind, v.horizontal_deg), (Kind::Angular, 180.0));
    /// assert_eq!(View::parse("-vtl -vh 3 -vv 3"), None);
    /// ```
    pub fn parse(text: &str) -> Option<View> {
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let kind = match words.iter().rev().find_map(|w| w.strip_prefix("-vt")).unwrap_or("v") {
            "v" => Kind::Perspective,
            "c" => Kind::Cylindrical,
            "h" => Kind::Hemispherical,
            "a" => Kind::Angular,
            "s" => Kind::Planispheric,
            _ => return None,
        };
        let number = |key: &str, default: f64| {
            words.windows(2).rev().find(|w| w[0] == key).map_or(Some(default), |w| w[1].parse().ok())
        };
        let view = View {
            kind,
            horizontal_deg: number("-vh", 45.0)?,
            vertical_deg: number("-vv", 45.0)?,
            shift: number("-vs", 0.0)?,
            lift: number("-vl", 0.0)?,
        };
        let (h, v) = (view.horizontal_deg, view.vertical_deg);
        let possible = match kind {
            Kind::Perspective => h < 180.0 && v < 180.0,
            Kind::Cylindrical => h <= 360.0 && v < 180.0,
            Kind::Hemispherical => h <= 180.0 && v <= 180.0,
            Kind::Angular => h <= 360.0 && v <= 360.0,
            Kind::Planispheric => h < 360.0 && v < 360.0,
        };
        (possible && h > NARROWEST_DEGREES && v > 0.0 && view.shift.is_finite() && view.lift.is_finite())
            .then_some(view)
    }

    /// Whole size of the picture on the surface where a step of 1 at its middle is one radian.
    pub fn extent(&self) -> (f64, f64) {
        let half = |degrees: f64| (degrees / 2.0).to_radians();
        let (h, v) = (half(self.horizontal_deg), half(self.vertical_deg));
        match self.kind {
            Kind::Perspective => (2.0 * h.tan(), 2.0 * v.tan()),
            Kind::Cylindrical => (2.0 * h, 2.0 * v.tan()),
            Kind::Hemispherical => (2.0 * h.sin(), 2.0 * v.sin()),
            Kind::Angular => (2.0 * h, 2.0 * v),
            Kind::Planispheric => (4.0 * (h / 2.0).tan(), 4.0 * (v / 2.0).tan()),
        }
    }

    /// Direction of a point of the picture; `None` outside the circle of a fisheye.
    ///
    /// ```
    /// use luxpipe::view::View;
    /// let v = View::parse("-vta -vh 180 -vv 180").unwrap();
    /// let [x, y, z] = v.direction(0.75, 0.5).unwrap(); // half way to the right edge: 45 degrees
    /// assert!((x - 0.5f64.sqrt()).abs() < 1e-12 && y.abs() < 1e-12 && (z - 0.5f64.sqrt()).abs() < 1e-12);
    /// ```
    pub fn direction(&self, u: f64, v: f64) -> Option<[f64; 3]> {
        let (width, height) = self.extent();
        let (x, y) = ((u + self.shift - 0.5) * width, (v + self.lift - 0.5) * height);
        let unit = |x: f64, y: f64, z: f64| {
            let n = (x * x + y * y + z * z).sqrt();
            Some([x / n, y / n, z / n])
        };
        let r = x.hypot(y);
        match self.kind {
            Kind::Perspective => unit(x, y, 1.0),
            Kind::Cylindrical => unit(x.sin(), y, x.cos()),
            Kind::Hemispherical => (r <= 1.0).then(|| [x, y, (1.0 - r * r).max(0.0).sqrt()]),
            Kind::Angular => (r <= std::f64::consts::PI).then(|| {
                let s = if r > 1e-9 { r.sin() / r } else { 1.0 };
                [x * s, y * s, r.cos()]
            }),
            Kind::Planispheric => {
                let q = r * r / 4.0; // tan^2 of half the angle
                Some([x / (1.0 + q), y / (1.0 + q), (1.0 - q) / (1.0 + q)])
            }
        }
    }

    /// Where a direction (any length) lies in the picture's plane, inside or outside of it; `None` where it has no image.
    pub fn locate(&self, direction: [f64; 3]) -> Option<(f64, f64)> {
        let [x, y, z] = direction;
        let n = (x * x + y * y + z * z).sqrt();
        let across = x.hypot(y);
        let (px, py) = match self.kind {
            Kind::Perspective if z > 0.0 => (x / z, y / z),
            Kind::Cylindrical if x.hypot(z) > 0.0 => (x.atan2(z), y / x.hypot(z)),
            Kind::Hemispherical if z >= 0.0 && n > 0.0 => (x / n, y / n),
            Kind::Angular if n > 0.0 => {
                let s = if across > 1e-12 * n { across.atan2(z) / across } else { 1.0 / n };
                (x * s, y * s)
            }
            Kind::Planispheric if n + z > 1e-12 * n => (2.0 * x / (n + z), 2.0 * y / (n + z)),
            _ => return None,
        };
        let (width, height) = self.extent();
        Some((px / width + 0.5 - self.shift, py / height + 0.5 - self.lift))
    }

    /// Solid angle in sr of a piece of the picture around (u, v), `du` wide and `dv` high, small against a radian: its area
    /// times the projection's at its middle. 0 outside the view.
    ///
    /// ```
    /// use luxpipe::view::View;
    /// let v = View::parse("-vta -vh 180 -vv 180").unwrap();
    /// let degree = 1.0 / 180.0;
    /// assert!((v.solid_angle_sr(0.5, 0.5, degree, degree) - 1f64.to_radians().powi(2)).abs() < 1e-12);
    /// assert!((v.solid_angle_sr(0.75, 0.5, degree, degree) / 1f64.to_radians().powi(2) - 0.9003).abs() < 1e-4);
    /// ```
    pub fn solid_angle_sr(&self, u: f64, v: f64, du: f64, dv: f64) -> f64 {
        let Some([_, y, z]) = self.direction(u, v) else { return 0.0 };
        let (width, height) = self.extent();
        let density = match self.kind {
            Kind::Perspective => z.powi(3),
            Kind::Cylindrical => (1.0 - y * y).powf(1.5),
            // The rim's rings are infinitely dense; a piece of them is not.
            Kind::Hemispherical => 1.0 / z.max(0.1 * (du * width).sqrt()),
            Kind::Angular => {
                let r = z.clamp(-1.0, 1.0).acos();
                if r > 1e-6 { r.sin() / r } else { 1.0 }
            }
            Kind::Planispheric => (0.5 * (1.0 + z)).powi(2),
        };
        density * du * width * dv * height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const VIEWS: [&str; 6] = [
        "-vtv -vh 60 -vv 40 -vs .2 -vl -.1",
        "-vtc -vh 360 -vv 90",
        "-vth -vh 180 -vv 180",
        "-vta -vh 180 -vv 180",
        "-vta -vh 360 -vv 360",
        "-vts -vh 300 -vv 300",
    ];

    #[test]
    fn every_direction_is_found_again() {
        for text in VIEWS {
            let view = View::parse(text).unwrap();
            let mut seen = 0;
            for i in 0..40 {
                for j in 0..40 {
                    let (u, v) = ((f64::from(i) + 0.5) / 40.0, (f64::from(j) + 0.5) / 40.0);
                    let Some(d) = view.direction(u, v) else { continue };
                    assert!((d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12, "{text}");
                    let (p, q) = view.locate(d.map(|x| 3.0 * x)).unwrap();
                    assert!((p - u).hypot(q - v) < 1e-9, "{text} {u} {v} {p} {q}");
                    seen += 1;
                }
            }
            assert!(seen > 1000, "{text}");
        }
    }

    #[test]
    fn solid_angles_sum_to_what_is_seen() {
        // Closed forms: a fisheye of 180 degrees sees 2 pi, of 360 all; a perspective 4 asin(sin(h/2) sin(v/2)).
        let perspective = 4.0 * (30f64.to_radians().sin() * 20f64.to_radians().sin()).asin();
        let cylinder = 4.0 * PI * 45f64.to_radians().sin();
        let cap = 2.0 * PI * (1.0 - 150f64.to_radians().cos());
        for (text, want, tolerance) in [
            ("-vtv -vh 60 -vv 40", perspective, 1e-4),
            ("-vtc -vh 360 -vv 90", cylinder, 1e-4),
            ("-vth -vh 180 -vv 180", 2.0 * PI, 5e-3),
            ("-vta -vh 180 -vv 180", 2.0 * PI, 2e-3),
            ("-vta -vh 360 -vv 360", 4.0 * PI, 2e-3),
            ("-vts -vh 300 -vv 300", cap, 2e-3),
        ] {
            let view: View = View::parse(text).unwrap();
            let n = 400;
            let limit = (view.horizontal_deg / 2.0).to_radians().cos();
            let fisheye = !matches!(view.kind, Kind::Perspective | Kind::Cylindrical);
            let cell = |i: usize, j: usize| {
                let (u, v) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
                let outside = fisheye && view.direction(u, v).is_none_or(|d| d[2] < limit);
                if outside { 0.0 } else { view.solid_angle_sr(u, v, 1.0 / n as f64, 1.0 / n as f64) }
            };
            let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| cell(i, j))).sum();
            assert!((sum / want - 1.0f64).abs() < tolerance, "{text}: {sum} {want}");
        }
    }
}
