//! Exposures to one light.
//!
//! Channel c of a pixel is the weighted mean of what the exposures j say of it, light x of its code over the exposure's amount q:
//!
//! E_c = sum_j w_cj x_c(z_cj) / q_j / sum_j w_cj,   w_cj = q_j H_j (L_j + eps l(z_cj) + eps^2)
//!
//! - H_j is the smallest over the channels of a fall from 1 to 0 towards white: where one channel clips the exposure is left out for
//!   all three, or the two others alone would tint what is bright.
//! - l rises from 0 at black to 1, and L_j is its smallest over the channels: one weight for three, so that errors of exposure times
//!   have no colour. Saturated colours have no exposure in which all three channels are well; for them the terms with eps = 0.001
//!   let each channel go its own way.
//! - q_j is what shot noise asks for: the mean is then all light gathered over all exposure. Means of light and not of its logarithm
//!   have no bias where it is dark.
//! - The shortest exposure keeps H = 1, the longest l = 1: something is always left. Where a channel clips even in the shortest, its
//!   light is a lower bound; it is raised to the pixel's brightest channel, so that a white lamp stays white.

use super::curve::Curves;
use super::lens::Lens;
use super::read::Shot;
use crate::color::Mat3;

/// Weight of a channel's own way where the common one vanishes.
const EPS: f32 = 1e-3;
/// Shares of all codes over which weights rise above black and fall below white.
const RISE: f64 = 0.11;
const FALL: f64 = 0.08;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Measured.
    Well,
    /// Black in the longest exposure: at most what is written.
    Black,
    /// White in the shortest exposure in some channel: at least what is written.
    White,
}

/// A bracket with all it takes to merge it.
pub struct Merge {
    /// In the order of their amounts.
    shots: Vec<Shot>,
    amounts: Vec<f32>,
    /// How many at the front are the shortest, at the end the longest.
    shortest: usize,
    longest: usize,
    /// Light of each code, by channel.
    light: [Vec<f32>; 3],
    /// Weight of each code towards white, towards black.
    fall: Vec<f32>,
    rise: Vec<f32>,
    /// The lens.
    pub lens: Lens,
}

/// 0 below a, 1 above b, smooth between.
fn smooth_step(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Merge {
    /// Shots of one size and depth in the order of their amounts; codes of `range`, shares of the largest, count.
    pub fn new(shots: Vec<Shot>, amounts: &[f64], curves: &Curves, range: (f64, f64), lens: Lens) -> Merge {
        let largest = shots.first().map_or(255, |s| s.codes.largest());
        let (low, high) = range;
        let code = |z: usize| z as f64 / largest as f64;
        let fall = |z| 1.0 - smooth_step((high - FALL).max(0.5 * (low + high)), high, code(z));
        let rise = |z| smooth_step(low, (low + RISE).min(0.5 * (low + high)), code(z));
        let like = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        let ends = [amounts.first(), amounts.last()].map(|e| e.copied().unwrap_or(1.0));
        Merge {
            shortest: amounts.iter().filter(|a| like(**a, ends[0])).count(),
            longest: amounts.iter().filter(|a| like(**a, ends[1])).count(),
            light: [0, 1, 2].map(|c| curves.table(c, largest)),
            fall: (0..=largest).map(|z| fall(z) as f32).collect(),
            rise: (0..=largest).map(|z| rise(z) as f32).collect(),
            amounts: amounts.iter().map(|a| *a as f32).collect(),
            shots,
            lens,
        }
    }

    /// Pixels across and down, before the lens cuts.
    pub fn size(&self) -> (usize, usize) {
        self.shots.first().map_or((0, 0), |s| (s.width, s.height))
    }

    /// Light of a pixel in the camera's channels, the lens made good; `None` outside its circle.
    pub fn light(&self, x: usize, y: usize) -> Option<[f32; 3]> {
        let gain = self.lens.gain(x, y)?;
        let light = self.mean(y * self.size().0 + x);
        Some([0, 1, 2].map(|c| light[c] * (gain * self.lens.factors[c]) as f32))
    }

    /// What is known of a pixel.
    pub fn seen(&self, x: usize, y: usize) -> Seen {
        let i = y * self.size().0 + x;
        let any_white = |s: &Shot| s.codes.pixel(i).iter().any(|z| self.fall[*z] == 0.0);
        let all_black = |s: &Shot| s.codes.pixel(i).iter().all(|z| self.rise[*z] == 0.0);
        if self.shots[..self.shortest].iter().all(any_white) {
            Seen::White
        } else if self.shots[self.shots.len() - self.longest..].iter().all(all_black) {
            Seen::Black
        } else {
            Seen::Well
        }
    }

    /// The weighted mean, by channel.
    fn mean(&self, pixel: usize) -> [f32; 3] {
        let (mut sum, mut total) = ([0f32; 3], [0f32; 3]);
        let long = self.shots.len() - self.longest;
        let mut clipped = [0f32; 3];
        for (j, (shot, amount)) in self.shots.iter().zip(&self.amounts).enumerate() {
            let z = shot.codes.pixel(pixel);
            let fall = z.map(|z| self.fall[z]);
            let own = if j < long { z.map(|z| self.rise[z]) } else { [1.0; 3] };
            let all = if j < self.shortest { 1.0 } else { fall[0].min(fall[1]).min(fall[2]) };
            let common = own[0].min(own[1]).min(own[2]);
            for c in 0..3 {
                // q cancels in the sum: light over amount, times amount.
                let weight = all * (common + EPS * own[c] + EPS * EPS);
                sum[c] += weight * self.light[c][z[c]];
                total[c] += weight * amount;
            }
            if j == 0 {
                clipped = fall.map(|f| 1.0 - f);
            }
        }
        let light = [0, 1, 2].map(|c| sum[c] / total[c]);
        let most = light[0].max(light[1]).max(light[2]);
        [0, 1, 2].map(|c| light[c] + clipped[c] * (most - light[c]))
    }
}

/// From the camera's channels to the picture's components, and their luminance.
#[derive(Clone, Copy, Debug)]
pub struct Colours {
    /// To XYZ; `None` leaves them RGB.
    pub matrix: Option<Mat3>,
    /// Luminance of each channel.
    pub luminance: [f64; 3],
}

impl Colours {
    /// Components of a pixel times `scale`.
    pub fn apply(&self, light: [f32; 3], scale: f64) -> [f32; 3] {
        let v = light.map(f64::from);
        self.matrix.map_or(v, |m| m.apply(v)).map(|x| (x * scale) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::Choice;
    use super::super::exposure::Settings;
    use super::super::read::Codes;
    use super::*;
    use crate::display::transfer::srgb_encode;

    const TIMES: [f64; 7] = [1e-3, 1.0 / 250.0, 1.0 / 60.0, 1.0 / 15.0, 0.25, 1.0, 4.0];

    /// Pixels in a row through sRGB at the seven times, rounded to `largest`.
    fn merged(pixels: &[[f64; 3]], largest: f64) -> (Vec<[f32; 3]>, Vec<Seen>) {
        let shots = TIMES.map(|t| {
            let code = |e: &f64| (srgb_encode((e * t).clamp(0.0, 1.0)) * largest).round();
            let all = pixels.iter().flatten();
            let codes = if largest > 255.0 {
                Codes::Sixteen(all.map(|e| code(e) as u16).collect())
            } else {
                Codes::Eight(all.map(|e| code(e) as u8).collect())
            };
            Shot { name: String::new(), width: pixels.len(), height: 1, codes, settings: Settings::default() }
        });
        let curves = Curves::Known(Choice::Srgb);
        let lens = Lens::none(pixels.len(), 1);
        let merge = Merge::new(shots.to_vec(), &TIMES, &curves, (0.008, 0.98), lens);
        (0..pixels.len()).map(|x| (merge.light(x, 0).unwrap(), merge.seen(x, 0))).unzip()
    }

    /// The case debevec-synthetic-bracket with the curve known: the case's own best merge has an rms of 0.00515.
    #[test]
    fn light_comes_back_over_four_decades() {
        let pixels: Vec<[f64; 3]> = (0..2000).map(|i| [10f64.powf(-2.2 + 4.4 * f64::from(i) / 1999.0); 3]).collect();
        for (largest, most) in [(255.0, 0.006), (65535.0, 1e-4)] {
            let (light, seen) = merged(&pixels, largest);
            let square: f64 = light.iter().zip(&pixels).map(|(a, b)| (f64::from(a[1]) / b[1]).ln().powi(2)).sum();
            let rms = (square / 2000.0).sqrt();
            eprintln!("{largest}: rms of ln E {rms:.5}");
            assert!(rms < most && seen.iter().all(|s| *s == Seen::Well), "{largest}: {rms}");
        }
    }

    /// Colours keep their ratios, saturated ones included, at any brightness that an exposure sees.
    #[test]
    fn nothing_is_tinted() {
        for ratio in [[1.0, 1.0, 1.0], [1.0, 0.8, 0.6], [1.0, 0.02, 0.004], [0.01, 0.3, 1.0]] {
            let scales = (0..400).map(|i| 10f64.powf(-0.2 + 3.1 * f64::from(i) / 399.0));
            let pixels: Vec<[f64; 3]> = scales.map(|s| ratio.map(|r| r * s)).collect();
            let (light, _) = merged(&pixels, 255.0);
            for (got, want) in light.iter().zip(&pixels) {
                for c in 0..3 {
                    // Dark channels of a bright pixel are codes of a few: their share of the light is what must be right.
                    let off = (f64::from(got[c]) - want[c]).abs() / want.iter().fold(0.0, |m: f64, x| m.max(*x));
                    assert!(off < 0.025, "{want:?} is {got:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_beyond_is_marked_and_stays_neutral() {
        let (light, seen) = merged(&[[5e3, 5e3, 4e3], [1e5, 2e3, 3e2], [1e-5, 1e-5, 1e-5], [1.0, 1.0, 1.0]], 255.0);
        assert_eq!(seen, [Seen::White, Seen::White, Seen::Black, Seen::Well]);
        assert_eq!(light[0], [light[0][0]; 3]);
        assert!(light[0][0] >= 999.0 && light[1][2] < 0.32 * light[1][0], "{light:?}");
        assert!(light[2].iter().all(|x| *x < 1e-3));
    }
}
