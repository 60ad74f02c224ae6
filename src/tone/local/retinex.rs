//! The surround of a multi-scale retinex [Jobson 1997].
//!
//! R = sum over n of w_n (ln L - ln (F_n * L)), F_n a Gaussian, w_n = 1/N [Jobson 1997, Eq. (1), (2)], on luminance alone, so
//! that colours stay. Theirs has three scales of 15, 80 and 250 pixels on pictures of about 512: a narrow one for texture, a wide
//! one for even light. Here they are 1/5, 1 and 3 times the scale asked for. The mean of ln (F_n * L) is the surround, R the
//! centre's contrast to it.
//!
//! What fails, and when. A Gaussian looks over every edge: the dark side of a strong one is set against light and becomes darker
//! still, the bright side brighter, to three sigma on either side. That is the halo, and it grows with the step. Wide even fields
//! turn grey, since the surround is the field itself.

use super::cells::{Cells, Place, Plane};

/// Standard deviations over the scale asked for.
pub const SIGMAS: [f64; 3] = [0.2, 1.0, 3.0];

/// A Gaussian's standard deviation is this many cells or more, once pixels suffice: under 2 % from the exact one.
const SIGMA_CELLS: f64 = 4.0;

/// Where a Gaussian is cut, in standard deviations.
const CUT: f64 = 3.5;

/// A plane of surrounds.
pub struct Surround {
    scales: Vec<(Cells, Vec<Place>)>,
    top: f32,
}

/// Pixels along a cell's side for a Gaussian of this many pixels.
pub fn side(sigma: f64) -> usize {
    ((sigma / SIGMA_CELLS) as usize).max(1)
}

/// F * f(plane) for a Gaussian F of `sigma` pixels, in cells. What averaging over cells and reading between them blur already
/// (variances (s^2 - 1) / 12 and s^2 / 6) is taken off the variance.
fn gaussian(plane: Plane, sigma: f64, f: impl Fn(f32) -> f32 + Sync) -> Cells {
    let side = side(sigma);
    let s2 = (side * side) as f64;
    let done = if side > 1 { (s2 - 1.0) / 12.0 + s2 / 6.0 } else { 0.0 };
    let sigma = ((sigma * sigma - done).max(0.0) / s2).sqrt();
    let weight = |k: usize| (-0.5 * (k as f64 / sigma).powi(2)).exp() as f32;
    let reach = (CUT * sigma).ceil() as usize;
    let half: Vec<f32> = (0..=reach).map(|k| if k == 0 { 1.0 } else { weight(k) }).collect();
    Cells::new(plane, side, f).blurred(&half)
}

impl Surround {
    /// Of a plane of ln L, for a scale in pixels.
    pub fn new(plane: Plane, scale: f64) -> Surround {
        let top = plane.values.iter().fold(f32::MIN, |m, x| m.max(*x));
        let one = |ratio: &f64| {
            // Over the largest, so that nothing overflows; what is 1e38 times darker than its surround has lost it anyway.
            let light = gaussian(plane, ratio * scale, |u| (u - top).exp());
            let ln = light.means().iter().map(|l| l.max(f32::MIN_POSITIVE).ln()).collect();
            let cells = light.with(ln);
            let places = cells.places(plane.width);
            (cells, places)
        };
        Surround { scales: SIGMAS.iter().map(one).collect(), top }
    }

    /// Replaces `base` by the surround of row y, in ln L.
    pub fn row(&self, y: usize, base: &mut Vec<f32>) {
        base.clear();
        base.resize(self.scales[0].1.len(), self.top);
        let mut line = Vec::new();
        for (cells, places) in &self.scales {
            cells.at_row(y, &mut line);
            base.iter_mut().zip(places).for_each(|(b, p)| *b += p.of_row(&line) / SIGMAS.len() as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum over every pixel, for a step, a point and noise.
    #[test]
    fn the_gaussian_in_cells_agrees_with_direct_convolution() {
        let (width, height) = (96usize, 60usize);
        let mut values: Vec<f32> =
            (0..width * height).map(|i| ((i * i * 7919) % 1009) as f32 / 1009.0 + f32::from(i % width > 40)).collect();
        values[20 * width + 70] = 300.0;
        for sigma in [0.7f64, 3.0, 9.0, 17.0] {
            let cells = gaussian(Plane { values: &values, width }, sigma, |x| x);
            let places = cells.places(width);
            let kernel = |n: usize, center: usize| -> Vec<f64> {
                let w: Vec<f64> = (0..n).map(|i| (-0.5 * ((i as f64 - center as f64) / sigma).powi(2)).exp()).collect();
                let sum: f64 = w.iter().sum();
                w.iter().map(|w| w / sum).collect()
            };
            let (mut worst, mut row) = (0f64, Vec::new());
            let (mut low, mut high) = (f64::MAX, f64::MIN);
            for y in (0..height).step_by(3) {
                cells.at_row(y, &mut row);
                let down = kernel(height, y);
                for x in (0..width).step_by(3) {
                    let across = kernel(width, x);
                    let line =
                        |j: usize| values[j * width..].iter().zip(&across).map(|(v, w)| f64::from(*v) * w).sum::<f64>();
                    let want: f64 = down.iter().enumerate().map(|(j, w)| w * line(j)).sum();
                    worst = worst.max((f64::from(places[x].of_row(&row)) - want).abs());
                    (low, high) = (low.min(want), high.max(want));
                }
            }
            println!(
                "Gaussian of {sigma} pixels, cells of {}: off by {:.4} of the range",
                side(sigma),
                worst / (high - low)
            );
            assert!(worst < 0.02 * (high - low), "{sigma}: {worst} of {low} to {high}");
        }
    }
}
