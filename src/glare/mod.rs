//! Glare: what an eye sees of the lights in its field of view, from a fisheye picture.
//!
//! The field is every pixel within 90 degrees of the line of sight, each with its solid angle w, luminance L and angle t from
//! the line of sight. From it [`sources`] finds the lights that glare, [`position`] weighs where they are, and [`indices`]
//! sums them up. Everything follows published formulas, and where these leave a choice, evalglare 3.06 [Wienold 2006].

pub mod findings;
pub mod indices;
pub mod position;
pub mod sources;

use crate::parallel;
use crate::view::View;

/// Luminances of a picture and the directions they come from: rows top down.
pub struct Field {
    /// How it was seen.
    pub view: View,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// cd/m2, `width` x `height` of them.
    pub luminance: Vec<f32>,
    /// Values that were no luminance (negative or not finite) and became 0.
    pub replaced: u64,
}

/// One pixel as the eye has it.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Unit vector: right, up, along the line of sight.
    pub direction: [f64; 3],
    /// Solid angle, sr.
    pub solid_angle_sr: f64,
    /// cd/m2
    pub luminance: f64,
}

impl Ray {
    /// Illuminance it gives at the eye, on a plane across the line of sight: L w cos t.
    pub fn illuminance_lux(&self) -> f64 {
        self.luminance * self.solid_angle_sr * self.direction[2]
    }
}

/// Sums over a field, or over a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Solid angle, sr.
    pub solid_angle_sr: f64,
    /// Sum of L w, lm/m2 without a cosine.
    pub flux: f64,
    /// Sum of L w cos t, lux.
    pub illuminance_lux: f64,
}

impl Sums {
    /// Takes in a pixel.
    pub fn add(&mut self, ray: &Ray) {
        self.solid_angle_sr += ray.solid_angle_sr;
        self.flux += ray.luminance * ray.solid_angle_sr;
        self.illuminance_lux += ray.illuminance_lux();
    }

    /// Both together.
    pub fn plus(&self, other: &Sums) -> Sums {
        Sums {
            solid_angle_sr: self.solid_angle_sr + other.solid_angle_sr,
            flux: self.flux + other.flux,
            illuminance_lux: self.illuminance_lux + other.illuminance_lux,
        }
    }

    /// The rest without a part.
    pub fn minus(&self, part: &Sums) -> Sums {
        Sums {
            solid_angle_sr: self.solid_angle_sr - part.solid_angle_sr,
            flux: (self.flux - part.flux).max(0.0),
            illuminance_lux: (self.illuminance_lux - part.illuminance_lux).max(0.0),
        }
    }

    /// Mean luminance, cd/m2; 0 of nothing.
    pub fn mean(&self) -> f64 {
        if self.solid_angle_sr > 0.0 { self.flux / self.solid_angle_sr } else { 0.0 }
    }
}

impl Field {
    /// A field without pixels yet.
    pub fn new(view: View, width: usize, height: usize) -> Field {
        Field { view, width, height, luminance: Vec::new(), replaced: 0 }
    }

    /// Takes in the next luminances of an upright picture.
    pub fn add(&mut self, values: &[f32]) {
        for l in values {
            let seen = *l >= 0.0 && l.is_finite();
            self.replaced += u64::from(!seen);
            self.luminance.push(if seen { *l } else { 0.0 });
        }
    }

    /// The pixel of that index; `None` outside the fisheye's circle and behind the eye.
    pub fn ray(&self, index: usize) -> Option<Ray> {
        let (du, dv) = (1.0 / self.width as f64, 1.0 / self.height as f64);
        let u = ((index % self.width) as f64 + 0.5) * du;
        let v = 1.0 - ((index / self.width) as f64 + 0.5) * dv;
        let direction = self.view.direction(u, v).filter(|d| d[2] >= 0.0)?;
        let solid_angle_sr = self.view.solid_angle_sr(u, v, du, dv);
        Some(Ray { direction, solid_angle_sr, luminance: f64::from(self.luminance[index]) })
    }

    /// Every pixel that the eye sees, with its index.
    pub fn rays(&self) -> impl Iterator<Item = (usize, Ray)> {
        (0..self.luminance.len()).filter_map(|i| Some((i, self.ray(i)?)))
    }

    /// Sums over all of it. For one luminance L over a whole hemisphere the illuminance is pi L.
    ///
    /// ```
    /// use luxpipe::{glare::Field, view::View};
    /// let mut field = Field::new(View::parse("-vta -vh 180 -vv 180").unwrap(), 200, 200);
    /// field.add(&[100.0; 40000]);
    /// let sums = field.sums();
    /// assert!((sums.illuminance_lux - 314.16).abs() < 0.1 && (sums.mean() - 100.0).abs() < 1e-9);
    /// ```
    pub fn sums(&self) -> Sums {
        let mut rows = vec![Sums::default(); self.height];
        parallel::for_pieces(&mut rows, 1, |first, rows| {
            for (row, sums) in rows.iter_mut().enumerate() {
                let start = (first + row) * self.width;
                (start..start + self.width).filter_map(|i| self.ray(i)).for_each(|ray| sums.add(&ray));
            }
        });
        rows.iter().fold(Sums::default(), |all, row| all.plus(row))
    }
}
