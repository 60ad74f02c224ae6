//! Cameras: a pixel and a place in it to a ray.

use glam::{DVec3, Vec3A};

use crate::scene::Frame;
use crate::{Result, invalid};

/// How directions become places on the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole; half extents of the image plane at unit distance.
    Perspective,
    /// Parallel rays; half extents in metres.
    Parallel,
}

/// A camera. Image right is forward x up.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    projection: Projection,
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half: [f64; 2],
    frame: Frame,
}

impl Camera {
    /// From a point, a point looked at and an upward direction. `extent` is the horizontal field of view in degrees for
    /// perspective, the width seen in metres for parallel; the height follows from the pixels, which are square.
    pub fn new(
        projection: Projection,
        origin: DVec3,
        target: DVec3,
        up: DVec3,
        extent: f64,
        size: (usize, usize),
    ) -> Result<Camera> {
        let forward = (target - origin).normalize_or_zero();
        let right = forward.cross(up).normalize_or_zero();
        if forward == DVec3::ZERO || right == DVec3::ZERO || !right.is_finite() {
            return invalid!(
                "the camera needs a target away from its origin, and an up that is not the direction of view"
            );
        }
        let half_width = match projection {
            Projection::Perspective if extent > 0.0 && extent < 179.9 => (extent / 2.0).to_radians().tan(),
            Projection::Perspective => return invalid!("fov_deg {extent} must be between 0 and 180"),
            Projection::Parallel if extent > 0.0 && extent.is_finite() => extent / 2.0,
            Projection::Parallel => return invalid!("width_seen {extent} must be above 0"),
        };
        let half = [half_width, half_width * size.1 as f64 / size.0 as f64];
        let up = right.cross(forward);
        let frame = Frame { centre: DVec3::ZERO, scale: 1.0 };
        Ok(Camera { width: size.0, height: size.1, projection, origin, forward, right, up, half, frame })
    }

    /// The same camera, its rays in the numbers of `frame`.
    pub fn within(self, frame: Frame) -> Camera {
        Camera { frame, ..self }
    }

    /// The same view with other pixels; width and height keep the shape of the picture if one of them is given.
    pub fn resized(mut self, width: Option<usize>, height: Option<usize>) -> Camera {
        let aspect = self.width as f64 / self.height as f64;
        let at_least_one = |x: f64| (x.round() as usize).max(1);
        (self.width, self.height) = match (width, height) {
            (None, None) => (self.width, self.height),
            (Some(w), None) => (w, at_least_one(w as f64 / aspect)),
            (None, Some(h)) => (at_least_one(h as f64 * aspect), h),
            (Some(w), Some(h)) => (w, h),
        };
        self.half[1] = self.half[0] * self.height as f64 / self.width as f64;
        self
    }

    /// Origin in the scene's frame and unit direction through pixel coordinates that count from the upper left corner of the picture.
    pub fn ray(&self, x: f64, y: f64) -> (Vec3A, Vec3A) {
        let right = (2.0 * x / self.width as f64 - 1.0) * self.half[0];
        let up = (1.0 - 2.0 * y / self.height as f64) * self.half[1];
        let offset = self.right * right + self.up * up;
        match self.projection {
            Projection::Perspective => {
                (self.frame.place(self.origin).as_vec3a(), (self.forward + offset).normalize().as_vec3a())
            }
            Projection::Parallel => (self.frame.place(self.origin + offset).as_vec3a(), self.forward.as_vec3a()),
        }
    }

    /// The view in Radiance's words, for a VIEW line.
    pub fn view(&self) -> String {
        let three = |v: DVec3| format!("{} {} {}", v.x + 0.0, v.y + 0.0, v.z + 0.0); // + 0.0 turns -0 to 0
        let (kind, angles) = match self.projection {
            Projection::Perspective => ("v", self.half.map(|h| 2.0 * h.atan().to_degrees())),
            Projection::Parallel => ("l", self.half.map(|h| 2.0 * h)),
        };
        format!(
            "-vt{kind} -vp {} -vd {} -vu {} -vh {:.6} -vv {:.6} -vo 0 -va 0 -vs 0 -vl 0",
            three(self.origin),
            three(self.forward),
            three(self.up),
            angles[0],
            angles[1]
        )
    }
}
