//! Drawing directions in proportion to how bright a sky or a surrounding picture is: a piecewise constant density over a
//! grid of latitudes and longitudes, inverted by rows and then along a row.
//!
//! Rows are equal steps of the angle from the zenith (+z), columns equal steps of the azimuth from +x toward +y; within a
//! cell the density per solid angle is constant. The map from the unit square is continuous along each row and monotone in
//! both coordinates, so points that are well spread there stay so on the sphere.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::{Result, invalid};

/// Most cells of a grid.
const MOST: usize = 1 << 26;
/// Points along each side of a cell where the weight is asked for.
const PROBES: usize = 2;

/// Which directions there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// All of them.
    Sphere,
    /// Those with z above 0.
    Upper,
}

impl Region {
    /// Solid angle, steradians.
    pub fn solid_angle(self) -> f64 {
        if self == Region::Sphere { 2.0 * TAU } else { TAU }
    }

    fn polar(self) -> f64 {
        if self == Region::Sphere { PI } else { FRAC_PI_2 }
    }
}

/// A density over directions.
#[derive(Clone, Debug)]
pub struct Environment {
    region: Region,
    columns: usize,
    /// Cosines of the rows' edges, from the top down.
    edges: Vec<f64>,
    /// Probability above each row's lower edge.
    rows: Vec<f64>,
    /// Of each row, the probability within it left of each cell's right edge.
    cells: Vec<f64>,
    /// Density of each cell, 1/sr.
    density: Vec<f64>,
    integral: f64,
}

impl Environment {
    /// A grid of `rows` x `columns` cells over a region, weighted by the mean of `weight(direction)` at four points of each
    /// cell, and the share `uniform` (0 to 1) of all samples spread evenly over the region. Light that falls between the
    /// points is only found by that share: keep it above 0 unless the weight has no finer detail than the grid.
    pub fn new(
        region: Region,
        [rows, columns]: [usize; 2],
        uniform: f64,
        weight: impl Fn([f64; 3]) -> f64,
    ) -> Result<Environment> {
        if rows == 0 || columns == 0 || rows.saturating_mul(columns) > MOST {
            return invalid!("a grid of {rows} x {columns} cells; both must be above 0 and the product at most {MOST}");
        }
        if !(0.0..=1.0).contains(&uniform) {
            return invalid!("the uniform share must be 0 to 1, got {uniform}");
        }
        let mut edges: Vec<f64> = (0..=rows).map(|i| (region.polar() * i as f64 / rows as f64).cos()).collect();
        edges[rows] = if region == Region::Upper { 0.0 } else { -1.0 };
        let mut density = Vec::with_capacity(rows * columns);
        for i in 0..rows * columns {
            let mean = probe(&edges[i / columns..], i % columns, columns, &weight);
            if !(mean >= 0.0 && mean.is_finite()) {
                return invalid!(
                    "the weight of row {}, column {} is {mean}; it must be finite and not negative",
                    i / columns,
                    i % columns
                );
            }
            density.push(mean);
        }
        Ok(Environment::from_means(region, columns, edges, density, uniform))
    }

    /// The tables from the cells' mean weights.
    fn from_means(region: Region, columns: usize, edges: Vec<f64>, mut density: Vec<f64>, uniform: f64) -> Environment {
        let solid = |row: usize| (edges[row] - edges[row + 1]) * TAU / columns as f64;
        let rows: Vec<f64> =
            density.chunks(columns).enumerate().map(|(i, row)| row.iter().sum::<f64>() * solid(i)).collect();
        let integral: f64 = rows.iter().sum();
        // A black surrounding has nothing to be drawn by.
        let share = if integral > 0.0 { uniform } else { 1.0 };
        let scale = if integral > 0.0 { (1.0 - share) / integral } else { 0.0 };
        density.iter_mut().for_each(|d| *d = *d * scale + share / region.solid_angle());
        let mut cells = density.clone();
        cells.chunks_mut(columns).for_each(accumulate);
        let mut marginal: Vec<f64> =
            density.chunks(columns).enumerate().map(|(i, row)| row.iter().sum::<f64>() * solid(i)).collect();
        accumulate(&mut marginal);
        Environment { region, columns, edges, rows: marginal, cells, density, integral }
    }

    /// Integral of the weight over the region as the grid sees it, weight x sr.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// A direction for a point of the unit square (each coordinate at least 0 and below 1), and its density, 1/sr.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 3], f64) {
        let (row, down) = invert(&self.rows, u[0]);
        let (column, along) = invert(&self.cells[row * self.columns..][..self.columns], u[1]);
        let z = self.edges[row] + down * (self.edges[row + 1] - self.edges[row]);
        let (s, c) = (TAU * (column as f64 + along) / self.columns as f64).sin_cos();
        let across = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        ([across * c, across * s, z], self.density[row * self.columns + column])
    }

    /// Density of a direction (a unit vector), 1/sr; 0 outside the region.
    pub fn pdf(&self, [x, y, z]: [f64; 3]) -> f64 {
        if self.region == Region::Upper && z < 0.0 {
            return 0.0;
        }
        let turn = y.atan2(x) / TAU;
        let turn = if turn < 0.0 { turn + 1.0 } else { turn };
        let column = ((turn * self.columns as f64) as usize).min(self.columns - 1);
        // The edges descend.
        let row = self.edges[1..self.edges.len() - 1].partition_point(|edge| *edge >= z);
        self.density[row * self.columns + column]
    }
}

/// Mean weight of a cell between its row's two edges.
fn probe(edges: &[f64], column: usize, columns: usize, weight: impl Fn([f64; 3]) -> f64) -> f64 {
    let at = |i: usize| ((i / PROBES) as f64 + 0.5, (i % PROBES) as f64 + 0.5);
    let points = (0..PROBES * PROBES).map(at).map(|(i, j)| {
        let z = edges[0] + (edges[1] - edges[0]) * i / PROBES as f64;
        let (s, c) = (TAU * (column as f64 + j / PROBES as f64) / columns as f64).sin_cos();
        let across = (1.0 - z * z).max(0.0).sqrt();
        weight([across * c, across * s, z])
    });
    points.sum::<f64>() / (PROBES * PROBES) as f64
}

/// Weights to the shares of their sum up to and with each; even ones where there is no sum.
fn accumulate(weights: &mut [f64]) {
    let n = weights.len();
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    for (i, w) in weights.iter_mut().enumerate() {
        sum += *w;
        *w = if total > 0.0 { sum / total } else { (i + 1) as f64 / n as f64 };
    }
    weights[n - 1] = 1.0;
}

/// The bin of a cumulative table that u falls into, and where in it, 0 to 1. Never a bin without weight.
fn invert(table: &[f64], u: f64) -> (usize, f64) {
    let i = table.partition_point(|t| *t <= u).min(table.len() - 1);
    let low = if i > 0 { table[i - 1] } else { 0.0 };
    (i, ((u - low) / (table[i] - low)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::{CieSky, ClearSky, direction};

    /// Points of the unit square, n x n stratified.
    fn square(n: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..n * n).map(move |i| [(i / n) as f64 + 0.5, (i % n) as f64 + 0.5].map(|x| x / n as f64))
    }

    /// The mean of f / pdf over samples.
    fn estimate(e: &Environment, n: usize, f: impl Fn([f64; 3]) -> f64) -> f64 {
        let sum: f64 = square(n).map(|u| e.sample(u)).map(|(d, pdf)| f(d) / pdf).sum();
        sum / (n * n) as f64
    }

    fn lump([x, y, z]: [f64; 3]) -> f64 {
        (6.0 * (0.6 * x - 0.64 * y + 0.48 * z)).exp()
    }

    /// Integral of exp(k d.a) over the sphere: 4 pi sinh k / k; of z^2: 4 pi / 3; of z on the upper half: pi.
    #[test]
    fn closed_forms() {
        let sphere = Environment::new(Region::Sphere, [64, 128], 0.1, lump).unwrap();
        let want = 2.0 * TAU * 6f64.sinh() / 6.0;
        assert!((sphere.integral() / want - 1.0).abs() < 1e-3, "{}", sphere.integral());
        assert!((estimate(&sphere, 300, lump) / want - 1.0).abs() < 1e-3);
        assert!((estimate(&sphere, 300, |d| d[2] * d[2]) / (2.0 * TAU / 3.0) - 1.0).abs() < 1e-2);
        let upper = Environment::new(Region::Upper, [32, 16], 0.0, |d| d[2]).unwrap();
        assert!((upper.integral() / PI - 1.0).abs() < 1e-3);
        let got = estimate(&upper, 200, |d| d[2]) / PI;
        assert!((got - 1.0).abs() < 1e-3, "{got}");
        let sky = CieSky::new(12, direction(60.0, 20.0)).unwrap();
        let e = Environment::new(Region::Upper, [64, 128], 0.05, |d| sky.relative(d)).unwrap();
        assert!((estimate(&e, 256, |d| sky.relative(d) * d[2]) / sky.horizontal() - 1.0).abs() < 1e-3);
    }

    /// pdf integrates to 1: by a sum over directions that have nothing to do with the grid.
    #[test]
    fn the_density_is_normalised() {
        let clear = ClearSky::new(direction(20.0, 200.0), 3.0).unwrap();
        for (region, share) in [(Region::Sphere, 0.0), (Region::Upper, 0.2)] {
            let e = Environment::new(region, [31, 57], share, |d| clear.xyz(d)[1]).unwrap();
            let even = |[u, v]: [f64; 2]| {
                let z = if region == Region::Upper { u } else { 2.0 * u - 1.0 };
                let (s, c) = (TAU * v).sin_cos();
                [(1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z]
            };
            let mean: f64 = square(1000).map(|u| e.pdf(even(u))).sum::<f64>() / 1e6;
            assert!((mean * region.solid_angle() - 1.0).abs() < 2e-3, "{}", mean * region.solid_angle());
        }
    }

    /// Random points counted in 12 x 8 solid angles against the density's integral there: chi-square with 95 degrees of
    /// freedom is below 145 in 99.9 % of cases.
    #[test]
    fn samples_follow_the_density() {
        let e = Environment::new(Region::Sphere, [24, 24], 0.1, lump).unwrap();
        let (mut counted, mut expected) = ([0.0f64; 96], [0.0f64; 96]);
        let bin = |[x, y, z]: [f64; 3]| {
            let polar = ((z.acos() / PI * 12.0) as usize).min(11);
            let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
            polar * 8 + ((turn * 8.0) as usize).min(7)
        };
        let n = 100_000u64;
        for i in 0..n {
            let random = |k: u64| (crate::statistics::scrambled(2 * i + k) >> 11) as f64 / (1u64 << 53) as f64;
            let (d, pdf) = e.sample([random(0), random(1)]);
            assert!((e.pdf(d) / pdf - 1.0).abs() < 1e-12);
            counted[bin(d)] += 1.0;
        }
        for (row, edge) in e.edges.windows(2).enumerate() {
            for column in 0..24 {
                let solid = (edge[0] - edge[1]) * TAU / 24.0;
                expected[row / 2 * 8 + column / 3] += n as f64 * e.density[row * 24 + column] * solid;
            }
        }
        let chi: f64 = counted.iter().zip(&expected).map(|(c, e)| (c - e).powi(2) / e).sum();
        assert!(chi < 145.0, "{chi}");
    }

    /// A stratum of the square lands in one run of rows: as u grows so does the angle from the zenith.
    #[test]
    fn the_map_is_monotone() {
        let e = Environment::new(Region::Sphere, [16, 16], 0.0, |d| if d[2] > 0.3 { 0.0 } else { lump(d) }).unwrap();
        let heights: Vec<f64> = (0..1000).map(|i| e.sample([f64::from(i) / 1000.0, 0.4]).0[2]).collect();
        assert!(heights.windows(2).all(|w| w[1] <= w[0]));
        assert!(heights[0] < 0.4);
    }

    #[test]
    fn edges_and_errors() {
        let black = Environment::new(Region::Upper, [4, 4], 0.0, |_| 0.0).unwrap();
        assert_eq!(black.integral(), 0.0);
        assert!((black.sample([0.3, 0.7]).1 * TAU - 1.0).abs() < 1e-12);
        assert_eq!(black.pdf([0.6, 0.0, -0.8]), 0.0);
        for e in [&black, &Environment::new(Region::Sphere, [3, 5], 0.0, |d| f64::from(d[0] > 0.0)).unwrap()] {
            for u in [[0.0, 0.0], [1.0 - 1e-16, 1.0 - 1e-16], [0.0, 1.0], [1.0, 0.0]] {
                let (d, pdf) = e.sample(u);
                assert!(pdf > 0.0 && d.iter().all(|x| x.is_finite()), "{u:?} {d:?} {pdf}");
            }
        }
        assert!(Environment::new(Region::Sphere, [0, 4], 0.0, |_| 1.0).is_err());
        assert!(Environment::new(Region::Sphere, [usize::MAX, 4], 0.0, |_| 1.0).is_err());
        assert!(Environment::new(Region::Sphere, [4, 4], 1.5, |_| 1.0).is_err());
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(Environment::new(Region::Sphere, [4, 4], 0.1, |_| bad).is_err());
        }
    }
}
