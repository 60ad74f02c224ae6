//! Cameras: a pixel and a place in it to a ray.
//!
//! Perspective, the fisheyes and the cylinder are Radiance's views ([`crate::view`]). A panorama holds the whole sphere,
//! longitude across and latitude down (its middle is the direction of view); Radiance has no word for it.

use glam::{DVec3, Vec3A};

use crate::scene::Frame;
use crate::view::{Kind, View};
use crate::{Result, invalid};

/// How directions become places on the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole; half extents of the image plane at unit distance.
    Perspective,
    /// Parallel rays; half extents in metres.
    Parallel,
    /// One of Radiance's other views.
    Wide(Kind),
    /// Equal steps of longitude and latitude.
    Panorama,
}

/// A lens in place of a pinhole: what lies at `focus_m` is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the opening, m.
    pub radius_m: f64,
    /// Distance of the sharp plane along the direction of view, m.
    pub focus_m: f64,
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
    /// Of a wide view.
    view: Option<View>,
    lens: Option<Lens>,
    /// Diameter of the opening that light is diffracted at, m.
    pub pupil_m: Option<f64>,
    frame: Frame,
}

impl Camera {
    /// From a point, a point looked at and an upward direction. `extent` is the horizontal field of view in degrees, the
    /// width seen in metres for parallel, without meaning for a panorama; the height follows from the pixels, which are
    /// square in the middle of the picture.
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
        let aspect = size.1 as f64 / size.0 as f64;
        let half_width = match projection {
            Projection::Perspective if extent > 0.0 && extent < 179.9 => (extent / 2.0).to_radians().tan(),
            Projection::Perspective => return invalid!("fov_deg {extent} must be between 0 and 180"),
            Projection::Parallel if extent > 0.0 && extent.is_finite() => extent / 2.0,
            Projection::Parallel => return invalid!("width_seen {extent} must be above 0"),
            Projection::Wide(_) | Projection::Panorama => 1.0,
        };
        let half = [half_width, half_width * aspect];
        let view = match projection {
            Projection::Wide(kind) => Some(wide(kind, extent, aspect)?),
            _ => None,
        };
        let up = right.cross(forward);
        let frame = Frame { centre: DVec3::ZERO, scale: 1.0 };
        Ok(Camera {
            width: size.0,
            height: size.1,
            projection,
            origin,
            forward,
            right,
            up,
            half,
            view,
            lens: None,
            pupil_m: None,
            frame,
        })
    }

    /// The same camera, its rays in the numbers of `frame`.
    pub fn within(self, frame: Frame) -> Camera {
        Camera { frame, ..self }
    }

    /// The same camera with a lens; `None` without perspective.
    pub fn with_lens(self, lens: Lens) -> Option<Camera> {
        (self.projection == Projection::Perspective).then_some(Camera { lens: Some(lens), ..self })
    }

    /// The same view with other pixels; width and height keep the shape of the picture if one of them is given.
    pub fn resized(mut self, width: Option<usize>, height: Option<usize>) -> Result<Camera> {
        let aspect = self.width as f64 / self.height as f64;
        let at_least_one = |x: f64| (x.round() as usize).max(1);
        (self.width, self.height) = match (width, height) {
            (None, None) => (self.width, self.height),
            (Some(w), None) => (w, at_least_one(w as f64 / aspect)),
            (None, Some(h)) => (at_least_one(h as f64 * aspect), h),
            (Some(w), Some(h)) => (w, h),
        };
        let aspect = self.height as f64 / self.width as f64;
        self.half[1] = self.half[0] * aspect;
        if let Some(view) = self.view.filter(|_| height.is_some()) {
            self.view = Some(wide(view.kind, view.horizontal_deg, aspect)?);
        }
        Ok(self)
    }

    /// Takes two more numbers in 0..1 for its lens.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Origin in the scene's frame and unit direction through pixel coordinates that count from the upper left corner of
    /// the picture, and a place on the lens; `None` outside the circle of a fisheye.
    pub fn ray(&self, x: f64, y: f64, lens: [f32; 2]) -> Option<(Vec3A, Vec3A)> {
        let (origin, direction) = self.way(x, y, lens)?;
        Some((self.frame.place(origin).as_vec3a(), direction.as_vec3a()))
    }

    /// The same in metres, in full precision.
    fn way(&self, x: f64, y: f64, lens: [f32; 2]) -> Option<(DVec3, DVec3)> {
        let right = (2.0 * x / self.width as f64 - 1.0) * self.half[0];
        let up = (1.0 - 2.0 * y / self.height as f64) * self.half[1];
        let mut origin = self.origin;
        let direction = match (&self.projection, &self.view) {
            (Projection::Perspective, _) => {
                let sharp = self.forward + self.right * right + self.up * up;
                match self.lens {
                    None => sharp,
                    Some(Lens { radius_m, focus_m }) => {
                        let [a, b] = crate::material::kernel::disk(lens).map(f64::from);
                        let aside = (self.right * a + self.up * b) * radius_m;
                        origin += aside;
                        sharp - aside / focus_m
                    }
                }
            }
            (Projection::Parallel, _) => {
                origin += self.right * right + self.up * up;
                self.forward
            }
            (Projection::Wide(_), Some(view)) => {
                let [a, b, c] = view.direction(x / self.width as f64, 1.0 - y / self.height as f64)?;
                self.right * a + self.up * b + self.forward * c
            }
            _ => {
                let turn = |x: f64| x * std::f64::consts::PI;
                let (sin_lon, cos_lon) = turn(2.0 * x / self.width as f64 - 1.0).sin_cos();
                let (sin_lat, cos_lat) = turn(0.5 - y / self.height as f64).sin_cos();
                (self.right * sin_lon + self.forward * cos_lon) * cos_lat + self.up * sin_lat
            }
        };
        Some((origin, direction.normalize()))
    }

    /// The picture's right at a place, in the scene, at right angles to the ray there: where +Q of Stokes vectors lies.
    pub fn rightwards(&self, x: f64, y: f64) -> Option<Vec3A> {
        let (_, here) = self.way(x, y, [0.5; 2])?;
        // A step that does not leave the picture; parallel rays all go the same way.
        let step = if x > 0.5 * self.width as f64 { -1e-3 } else { 1e-3 };
        let there = self.way(x + step, y, [0.5; 2]).map_or(here, |r| r.1);
        let along = |v: DVec3| (v - here * v.dot(here)).normalize_or_zero();
        let right =
            if there.distance(here) > 1e-11 { along((there - here) * step.signum()) } else { along(self.right) };
        Some(right.as_vec3a())
    }

    /// The view in Radiance's words, for a VIEW line; `None` for a panorama.
    pub fn view(&self) -> Option<String> {
        let three = |v: DVec3| format!("{} {} {}", v.x + 0.0, v.y + 0.0, v.z + 0.0); // + 0.0 turns -0 to 0
        let (kind, angles) = match (&self.projection, &self.view) {
            (Projection::Perspective, _) => ("v", self.half.map(|h| 2.0 * h.atan().to_degrees())),
            (Projection::Parallel, _) => ("l", self.half.map(|h| 2.0 * h)),
            (Projection::Wide(kind), Some(v)) => (kind.word(), [v.horizontal_deg, v.vertical_deg]),
            _ => return None,
        };
        Some(format!(
            "-vt{kind} -vp {} -vd {} -vu {} -vh {:.6} -vv {:.6} -vo 0 -va 0 -vs 0 -vl 0",
            three(self.origin),
            three(self.forward),
            three(self.up),
            angles[0],
            angles[1]
        ))
    }
}

/// A wide view whose pixels are square in the middle; `aspect` is height over width.
fn wide(kind: Kind, horizontal_deg: f64, aspect: f64) -> Result<View> {
    let vertical_deg = match kind {
        Kind::Perspective => 2.0 * (aspect * (horizontal_deg / 2.0).to_radians().tan()).atan().to_degrees(),
        Kind::Cylindrical => 2.0 * (aspect * (horizontal_deg / 2.0).to_radians()).atan().to_degrees(),
        Kind::Hemispherical => 2.0 * (aspect * (horizontal_deg / 2.0).to_radians().sin()).min(1.0).asin().to_degrees(),
        Kind::Angular => aspect * horizontal_deg,
        Kind::Planispheric => 4.0 * (aspect * (horizontal_deg / 4.0).to_radians().tan()).atan().to_degrees(),
    };
    let text = format!("-vt{} -vh {horizontal_deg} -vv {vertical_deg}", kind.word());
    match View::parse(&text) {
        Some(view) => Ok(view),
        None => invalid!("fov_deg {horizontal_deg} is more, or less, than this projection shows"),
    }
}
