//! A plane in square cells: what a wide window needs to know of a picture, at a cost that the window's width does not change.
//!
//! A window many pixels wide sees no single pixel. The plane is averaged over cells of s x s pixels, windows run over cells,
//! and the result is read between the cells' centres by bilinear interpolation, as the fast guided filter [He 2015] does. s
//! grows with the window, so that a window is never more than some 50 cells wide: the work is linear in the pixels, and all but
//! the averaging is done on 1/s^2 of them. Every weight is positive: unlike running sums and recursive filters, a lamp of 1e8
//! leaves no rounding behind in a shadow of 1e-6.
//!
//! Beyond the picture's edge there is nothing: windows are cut and their weights made up to 1. Cells at the right and lower
//! edge may hold fewer pixels, and weigh less.

use crate::parallel;

/// Means over cells.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Pixels along a cell's side.
    side: usize,
    /// Cells along a row.
    columns: usize,
    /// Pixels that each column of cells is wide, and each row of cells high.
    weights: [Vec<f32>; 2],
    /// Means, row by row.
    means: Vec<f32>,
}

/// Consecutive rows of a plane of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// The numbers, row by row.
    pub values: &'a [f32],
    /// Numbers in a row.
    pub width: usize,
}

/// Pixels in each of the cells that cover `pixels` of them.
fn weights(pixels: usize, side: usize) -> Vec<f32> {
    (0..pixels.div_ceil(side)).map(|i| side.min(pixels - i * side) as f32).collect()
}

impl Cells {
    /// Means of f(value) over cells of `side` x `side` pixels.
    pub fn new(plane: Plane, side: usize, f: impl Fn(f32) -> f32 + Sync) -> Cells {
        let Plane { values, width } = plane;
        let weights = [weights(width, side), weights(values.len() / width, side)];
        let columns = weights[0].len();
        let mut means = vec![0f32; columns * weights[1].len()];
        parallel::for_pieces(&mut means, columns, |first, piece| {
            let mut sums = vec![0f64; columns];
            for (j, out) in (first..).zip(piece.chunks_exact_mut(columns)) {
                sums.fill(0.0);
                let rows = values[j * side * width..].chunks_exact(width).take(side);
                for row in rows {
                    for (sum, cell) in sums.iter_mut().zip(row.chunks(side)) {
                        *sum += cell.iter().map(|x| f64::from(f(*x))).sum::<f64>();
                    }
                }
                for ((mean, sum), w) in out.iter_mut().zip(&sums).zip(&weights[0]) {
                    *mean = (sum / f64::from(w * weights[1][j])) as f32;
                }
            }
        });
        Cells { side, columns, weights, means }
    }

    /// Pixels along a cell's side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// The means, row by row.
    pub fn means(&self) -> &[f32] {
        &self.means
    }

    /// The same cells with other values.
    pub fn with(&self, means: Vec<f32>) -> Cells {
        Cells { means, weights: self.weights.clone(), ..*self }
    }

    /// Weighted means over a window: `half[k]` is the weight of a cell k cells away, along rows and along columns.
    pub fn blurred(&self, half: &[f32]) -> Cells {
        let (columns, rows) = (self.columns, self.weights[1].len());
        let norm = |weights: &[f32]| -> Vec<f32> {
            (0..weights.len()).map(|i| window(half, i, weights.len()).map(|(k, w)| w * weights[k]).sum()).collect()
        };
        let (across, down) = (norm(&self.weights[0]), norm(&self.weights[1]));
        let mut along = vec![0f32; columns * rows];
        parallel::for_pieces(&mut along, columns, |first, piece| {
            let reach = half.len() - 1;
            let mut line = vec![0f32; columns + 2 * reach];
            for (row, out) in self.means[first * columns..].chunks_exact(columns).zip(piece.chunks_exact_mut(columns)) {
                for ((to, x), w) in line[reach..].iter_mut().zip(row).zip(&self.weights[0]) {
                    *to = x * w;
                }
                out.iter_mut().zip(&line[reach..]).for_each(|(o, x)| *o = half[0] * x);
                for (k, w) in half.iter().enumerate().skip(1) {
                    let sides = line[reach - k..].iter().zip(&line[reach + k..]);
                    out.iter_mut().zip(sides).for_each(|(o, (a, b))| *o += w * (a + b));
                }
                out.iter_mut().zip(&across).for_each(|(o, n)| *o /= n);
            }
        });
        let mut means = vec![0f32; columns * rows];
        parallel::for_pieces(&mut means, columns, |first, piece| {
            for (j, out) in (first..).zip(piece.chunks_exact_mut(columns)) {
                for (k, w) in window(half, j, rows) {
                    let w = w * self.weights[1][k] / down[j];
                    out.iter_mut().zip(&along[k * columns..]).for_each(|(o, x)| *o += w * x);
                }
            }
        });
        self.with(means)
    }

    /// Where the pixels of a row lie between the centres of cells.
    pub fn places(&self, width: usize) -> Vec<Place> {
        (0..width).map(|x| Place::of(x, self.side, self.columns)).collect()
    }

    /// Replaces `out` by the cells' values at a row of pixels, still one for each column of cells.
    pub fn at_row(&self, y: usize, out: &mut Vec<f32>) {
        let Place { low, high, share } = Place::of(y, self.side, self.weights[1].len());
        let row = |j: u32| &self.means[j as usize * self.columns..][..self.columns];
        out.clear();
        out.extend(row(low).iter().zip(row(high)).map(|(a, b)| a + share * (b - a)));
    }
}

/// The cells within reach of cell i of n, with their weights.
fn window(half: &[f32], i: usize, n: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    let reach = half.len() - 1;
    (i.saturating_sub(reach)..(i + reach + 1).min(n)).map(move |k| (k, half[k.abs_diff(i)]))
}

/// A pixel between the centres of two cells.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    low: u32,
    high: u32,
    /// 0 at the lower centre, 1 at the upper.
    share: f32,
}

impl Place {
    fn of(pixel: usize, side: usize, cells: usize) -> Place {
        let t = (pixel as f64 + 0.5) / side as f64 - 0.5;
        let t = t.clamp(0.0, (cells - 1) as f64);
        let low = t as usize;
        Place { low: low as u32, high: (low + 1).min(cells - 1) as u32, share: (t - low as f64) as f32 }
    }

    /// The value of a row from [`Cells::at_row`] here.
    #[inline(always)]
    pub fn of_row(&self, row: &[f32]) -> f32 {
        let (a, b) = (row[self.low as usize], row[self.high as usize]);
        a + self.share * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any window over cells of any size leaves a constant what it is, the picture's edges and cut cells included.
    #[test]
    fn a_constant_stays_what_it_is() {
        for (width, height, side) in [(1, 1, 1), (7, 5, 3), (1, 40, 4), (33, 2, 8), (64, 64, 16)] {
            let values = vec![2.5f32; width * height];
            let cells = Cells::new(Plane { values: &values, width }, side, |x| x).blurred(&[1.0, 0.7, 0.2]);
            assert!(cells.means().iter().all(|m| (m - 2.5).abs() < 1e-6), "{width} x {height} in {side}");
            let mut row = Vec::new();
            cells.at_row(height - 1, &mut row);
            assert!(cells.places(width).iter().all(|p| (p.of_row(&row) - 2.5).abs() < 1e-6));
        }
    }
}
