//! How far a picture lies from a reference: colour differences as a viewer who may lift the shadows sees them, and errors of
//! luminance.

use crate::color::difference::{ciede2000, distance, lab, luv_at};
use crate::color::pu21;
use crate::parallel;
use crate::statistics::Distribution;

/// What two pictures are looked at under.
#[derive(Clone, Copy, Debug)]
pub struct Viewing {
    /// XYZ of the white, what L* = 100 stands for, in the pictures' unit.
    pub white: [f64; 3],
    /// Dark pixels are multiplied by up to this before colours are compared, at least 1.
    pub gain: f64,
    /// Luminances in cd/m2 that Y = 0 and Y = 1 stand for; without them there is no PU21.
    pub shown: Option<[f64; 2]>,
}

/// How two pixels differ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// A component is NaN or infinite in one of them: nothing else is set.
    pub left_out: bool,
    /// Delta E*uv.
    pub uv: f64,
    /// Delta E*ab.
    pub ab: f64,
    /// Delta E 2000.
    pub e2000: f64,
    /// Y of the pixel less Y of the reference.
    pub y: f64,
    /// Y of the reference.
    pub reference_y: f64,
    /// Difference of the PU21 codes.
    pub pu21: f64,
    /// A luminance lay outside the encoding's range and was moved to its end.
    pub clamped: bool,
}

impl Viewing {
    /// What both pixels are multiplied by where the reference has this Y: up to `gain`, no further than to half the white's.
    ///
    /// ```
    /// let v = luxpipe::compare::Viewing { white: [95.0, 100.0, 109.0], gain: 10.0, shown: None };
    /// assert_eq!([0.0, 1.0, 10.0, 50.0, 1000.0].map(|y| v.lift(y)), [10.0, 10.0, 5.0, 1.0, 1.0]);
    /// ```
    pub fn lift(&self, reference_y: f64) -> f64 {
        let half = 0.5 * self.white[1];
        if reference_y * self.gain <= half { self.gain } else { (half / reference_y).max(1.0) }
    }

    /// How a pixel differs from the reference's; both XYZ.
    pub fn difference(&self, pixel: [f32; 3], reference: [f32; 3]) -> Difference {
        if pixel.iter().chain(&reference).any(|x| !x.is_finite()) {
            return Difference { left_out: true, ..Difference::default() };
        }
        let (pixel, reference) = (pixel.map(f64::from), reference.map(f64::from));
        let lift = self.lift(reference[1]);
        let (a, b) = (pixel.map(|x| x * lift), reference.map(|x| x * lift));
        let (lab_a, lab_b) = (lab(a, self.white), lab(b, self.white));
        let (pu21, clamped) = self.pu21(pixel[1], reference[1]);
        Difference {
            left_out: false,
            uv: distance(luv_at(lab_a[0], a, self.white), luv_at(lab_b[0], b, self.white)),
            ab: distance(lab_a, lab_b),
            e2000: ciede2000(lab_a, lab_b),
            y: pixel[1] - reference[1],
            reference_y: reference[1],
            pu21,
            clamped,
        }
    }

    /// Difference of the PU21 codes, and whether either luminance had to be clamped.
    fn pu21(&self, a: f64, b: f64) -> (f64, bool) {
        let Some([black, white]) = self.shown else { return (0.0, false) };
        let [low, high] = pu21::RANGE;
        let luminances = [a, b].map(|y| black + (white - black) * y);
        let [a, b] = luminances.map(|l| pu21::encode(l.clamp(low, high)));
        (a - b, luminances.iter().any(|l| !(low..=high).contains(l)))
    }

    /// The same for whole rows, on all threads.
    pub fn differences(&self, pixels: &[f32], reference: &[f32], into: &mut Vec<Difference>) {
        into.resize(pixels.len() / 3, Difference::default());
        parallel::for_pieces(into, 1, |first, piece| {
            let pairs = pixels[3 * first..].chunks_exact(3).zip(reference[3 * first..].chunks_exact(3));
            for (d, (a, b)) in piece.iter_mut().zip(pairs) {
                *d = self.difference([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
            }
        });
    }
}

/// Errors of a whole picture.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Delta E*uv.
    pub uv: Distribution,
    /// Delta E*ab.
    pub ab: Distribution,
    /// Delta E 2000.
    pub e2000: Distribution,
    /// Absolute value of the relative error of Y, where the reference's Y is above 0.
    pub relative: Distribution,
    /// Pixels left out of everything: not finite.
    pub left_out: u64,
    /// Pixels whose luminance was clamped for PU21.
    pub clamped: u64,
    /// Largest Y of the reference.
    pub peak_y: f64,
    relative_sum: f64,
    squared: f64,
    squared_relative: f64,
    squared_pu21: f64,
}

impl Totals {
    /// Adds pixels in picture order: the sums do not depend on threads or blocks.
    pub fn add(&mut self, differences: &[Difference], viewing: &Viewing) {
        let floor = 1e-4 * viewing.white[1].powi(2);
        for d in differences {
            if d.left_out {
                self.left_out += 1;
                continue;
            }
            self.uv.add(d.uv);
            self.ab.add(d.ab);
            self.e2000.add(d.e2000);
            if d.reference_y > 0.0 {
                self.relative.add((d.y / d.reference_y).abs());
                self.relative_sum += d.y / d.reference_y;
            }
            self.squared += d.y * d.y;
            self.squared_relative += d.y * d.y / (d.reference_y * d.reference_y + floor);
            self.squared_pu21 += d.pu21 * d.pu21;
            self.peak_y = self.peak_y.max(d.reference_y);
            self.clamped += u64::from(d.clamped);
        }
    }

    /// Pixels compared.
    pub fn count(&self) -> u64 {
        self.uv.count()
    }

    /// Mean of (a - b) / b over Y, signed; `None` where the reference is nowhere above 0.
    pub fn relative_mean(&self) -> Option<f64> {
        (self.relative.count() > 0).then(|| self.relative_sum / self.relative.count() as f64)
    }

    /// Mean of (a - b)^2 / (b^2 + 1e-4 Yn^2) over Y.
    pub fn relative_mse(&self) -> f64 {
        self.squared_relative / self.count() as f64
    }

    /// PSNR of Y against the reference's largest, dB; infinite for equal pictures.
    pub fn psnr_y(&self) -> f64 {
        decibels(self.peak_y, self.squared / self.count() as f64)
    }

    /// PSNR of Y in the PU21 encoding against [`pu21::PEAK`], dB.
    pub fn psnr_pu21(&self) -> f64 {
        decibels(pu21::PEAK, self.squared_pu21 / self.count() as f64)
    }
}

fn decibels(peak: f64, mean_square: f64) -> f64 {
    if mean_square == 0.0 { f64::INFINITY } else { 10.0 * (peak * peak / mean_square).log10() }
}
