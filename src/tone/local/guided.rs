//! The edge-preserving base: the guided filter of a plane by itself [He 2013].
//!
//! In every window of radius r the base is taken for a line in the plane u itself, base = a u + b, fitted to u with a penalty
//! e a^2 [He 2013, Eq. (5), (6), with the plane as its own guide]:
//!
//! a = var / (var + e), b = (1 - a) mean
//!
//! and each pixel takes the mean of a and of b over the windows that hold it [Eq. (8)]. Where u varies by much less than
//! sqrt(e), a is near 0 and the base is smooth; at an edge much higher than sqrt(e), a is near 1 and the base is the edge. Since
//! base and u rise and fall together (0 <= a < 1), no gradient is turned round, as a bilateral base can.
//!
//! What fails, and when. An edge of height h leaves about e / h of itself in the detail, on either side, where a window just
//! reaches over it: that is the halo. Fine texture within r of a strong edge belongs to the base there, and is compressed with it.
//! Steps of about sqrt(e) are split between both.

use super::cells::{Cells, Place, Plane};

/// A window's radius in cells lies between this and about twice as much, once pixels suffice.
const RADIUS_CELLS: usize = 8;

/// The lines of all windows, in cells.
pub struct Guided {
    a: Cells,
    b: Cells,
    places: Vec<Place>,
}

/// Pixels along a cell's side for a window of this radius.
pub fn side(radius: usize) -> usize {
    ((2 * radius + 1) / (2 * RADIUS_CELLS + 1)).max(1)
}

impl Guided {
    /// Of a plane, with windows of `radius` pixels (2 r + 1 across) and the penalty e in the plane's unit squared. Exact to
    /// radius 16; from there windows are whole cells, within 7 % of the radius asked for.
    pub fn new(plane: Plane, radius: usize, penalty: f32) -> Guided {
        let side = side(radius);
        let reach = ((2 * radius + 1) as f64 / side as f64 - 1.0) / 2.0;
        let window = vec![1.0; reach.round() as usize + 1];
        // Squares about the middle of the range: a variance is a small difference of large numbers.
        let range = plane.values.iter().fold((f32::MAX, f32::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        let pivot = (range.0 + range.1) / 2.0;
        let mean = Cells::new(plane, side, |x| x - pivot).blurred(&window);
        let square = Cells::new(plane, side, |x| (x - pivot) * (x - pivot)).blurred(&window);
        let slope = |(m, s): (&f32, &f32)| {
            let variance = (s - m * m).max(0.0);
            variance / (variance + penalty)
        };
        let a: Vec<f32> = mean.means().iter().zip(square.means()).map(slope).collect();
        let b = mean.means().iter().zip(&a).map(|(m, a)| (1.0 - a) * (m + pivot)).collect();
        let (a, b) = (mean.with(a).blurred(&window), mean.with(b).blurred(&window));
        Guided { places: a.places(plane.width), a, b }
    }

    /// Replaces `base` by the base of row y, whose values are `row`.
    pub fn row(&self, y: usize, row: &[f32], base: &mut Vec<f32>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        self.a.at_row(y, &mut a);
        self.b.at_row(y, &mut b);
        base.clear();
        base.extend(row.iter().zip(&self.places).map(|(u, p)| p.of_row(&a) * u + p.of_row(&b)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane of noise over a step: repeatable, with edges.
    fn noise(width: usize, height: usize) -> Vec<f32> {
        let mut state = 1u32;
        (0..width * height)
            .map(|i| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / 16_777_216.0 + if i % width > width / 2 { 5.0 } else { 0.0 }
            })
            .collect()
    }

    /// The filter as its equations stand, every window summed anew.
    fn naive(u: &[f32], width: usize, r: usize, e: f64) -> Vec<f64> {
        let height = u.len() / width;
        let mean = |f: &dyn Fn(usize) -> f64, x: usize, y: usize| {
            let (mut sum, mut n) = (0.0, 0.0);
            for j in y.saturating_sub(r)..(y + r + 1).min(height) {
                for i in x.saturating_sub(r)..(x + r + 1).min(width) {
                    sum += f(j * width + i);
                    n += 1.0;
                }
            }
            sum / n
        };
        let at = |k: usize| f64::from(u[k]);
        let lines: Vec<(f64, f64)> = (0..u.len())
            .map(|k| {
                let (x, y) = (k % width, k / width);
                let m = mean(&at, x, y);
                let variance = mean(&|k| (at(k) - m).powi(2), x, y);
                let a = variance / (variance + e);
                (a, m - a * m)
            })
            .collect();
        let base = |k: usize| {
            let (x, y) = (k % width, k / width);
            mean(&|k| lines[k].0, x, y) * at(k) + mean(&|k| lines[k].1, x, y)
        };
        (0..u.len()).map(base).collect()
    }

    fn base(u: &[f32], width: usize, radius: usize, penalty: f32) -> Vec<f32> {
        let guided = Guided::new(Plane { values: u, width }, radius, penalty);
        let (mut all, mut row) = (Vec::new(), Vec::new());
        for (y, values) in u.chunks_exact(width).enumerate() {
            guided.row(y, values, &mut row);
            all.extend_from_slice(&row);
        }
        all
    }

    #[test]
    fn small_windows_agree_with_every_window_summed_anew() {
        for (width, height, radius) in [(23, 17, 1), (23, 17, 4), (40, 9, 12), (1, 30, 5), (3, 3, 16)] {
            let u = noise(width, height);
            let want = naive(&u, width, radius, 0.1);
            for (got, want) in base(&u, width, radius, 0.1).iter().zip(&want) {
                assert!((f64::from(*got) - want).abs() < 2e-5, "{width} x {height}, radius {radius}: {got} {want}");
            }
        }
    }

    /// Cells of several pixels change a step of 5 with noise by some hundredths, at worst.
    #[test]
    fn wide_windows_agree_nearly() {
        let (width, height, radius) = (110, 70, 25); // cells of 3
        assert_eq!(side(radius), 3);
        let u = noise(width, height);
        let want = naive(&u, width, radius, 0.1);
        let pairs: Vec<f64> = base(&u, width, radius, 0.1).iter().zip(&want).map(|(a, b)| f64::from(*a) - b).collect();
        let rms = (pairs.iter().map(|d| d * d).sum::<f64>() / pairs.len() as f64).sqrt();
        let worst = pairs.iter().fold(0f64, |m, d| m.max(d.abs()));
        println!("guided filter in cells of 3: rms {rms:.4}, worst {worst:.4} of a step of 5");
        assert!(rms < 0.01 && worst < 0.06, "{rms} {worst}");
    }
}
