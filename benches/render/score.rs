//! How far a render lies from a long one of the same scene, and how noisy it is.

use luxpipe::color::difference::delta_e_2000;

/// Independent renders of one picture, their mean the best guess of it.
pub struct Renders {
    /// Components a pixel.
    pub channels: usize,
    /// Each [pixel][component].
    pub pictures: Vec<Vec<f32>>,
}

impl Renders {
    /// Mean of those of the pictures that `chosen` picks.
    pub fn mean_of(&self, chosen: impl Fn(usize) -> bool) -> Vec<f64> {
        let few: Vec<&Vec<f32>> =
            self.pictures.iter().enumerate().filter(|(i, _)| chosen(*i)).map(|(_, p)| p).collect();
        (0..few[0].len()).map(|k| few.iter().map(|p| f64::from(p[k])).sum::<f64>() / few.len() as f64).collect()
    }

    /// Mean of all.
    pub fn mean(&self) -> Vec<f64> {
        self.mean_of(|_| true)
    }

    /// Variance of the mean, from how the pictures differ; zeros for one picture.
    pub fn variance(&self) -> Vec<f64> {
        let (n, mean) = (self.pictures.len() as f64, self.mean());
        let squares = |k: usize| self.pictures.iter().map(|p| (f64::from(p[k]) - mean[k]).powi(2)).sum::<f64>();
        (0..mean.len()).map(|k| if n > 1.0 { squares(k) / (n - 1.0) / n } else { 0.0 }).collect()
    }
}

impl Renders {
    /// Variance of the mean of the sum of a component over some pixels, from how that sum differs.
    fn variance_of_sum(&self, pixels: &[usize], component: usize) -> f64 {
        let of = |p: &Vec<f32>| pixels.iter().map(|i| f64::from(p[i * self.channels + component])).sum::<f64>();
        let sums: Vec<f64> = self.pictures.iter().map(of).collect();
        let n = sums.len() as f64;
        let mean = sums.iter().sum::<f64>() / n;
        sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0) / n
    }

    /// Root mean square of Y's standard error over the mean of Y, from how the pictures differ.
    pub fn noise_of_mean(&self) -> f64 {
        let y = |all: &[f64]| all.iter().skip(1).step_by(3).sum::<f64>() / (all.len() / 3) as f64;
        y(&self.variance()).sqrt() / y(&self.mean())
    }
}

/// A long render, and what errors are measured in.
pub struct Reference {
    /// Independent renders.
    pub renders: Renders,
    mean: Vec<f64>,
    variance: Vec<f64>,
    /// Pixels that count: none that sees the lamp.
    pub counts: Vec<bool>,
    /// XYZ of the lamp's chromaticity at the 99th percentile of Y.
    white: [f64; 3],
    /// Mean Delta E 2000 that the reference's own noise makes.
    own: f64,
}

/// Errors of a render.
#[derive(Clone, Copy)]
pub struct Errors {
    /// Mean Delta E 2000.
    pub delta_e: f64,
    /// Root of the mean squared error of Y over mean Y.
    pub relative_rmse: f64,
}

fn xyz(picture: &[f64], pixel: usize) -> [f64; 3] {
    [0, 1, 2].map(|c| picture[3 * pixel + c])
}

impl Reference {
    /// `lamp` has Y = 1.
    pub fn new(renders: Renders, counts: Vec<bool>, lamp: [f64; 3]) -> Reference {
        let (mean, variance) = (renders.mean(), renders.variance());
        let mut y: Vec<f64> = (0..counts.len()).filter(|p| counts[*p]).map(|p| mean[3 * p + 1]).collect();
        y.sort_by(f64::total_cmp);
        let white = lamp.map(|c| c * y[y.len() * 99 / 100]);
        let mut reference = Reference { renders, mean, variance, counts, white, own: 0.0 };
        // The halves differ by twice the noise of their mean.
        let halves = [0, 1].map(|half| reference.renders.mean_of(|i| i % 2 == half));
        reference.own = 0.5 * reference.delta_e(&halves[0], &halves[1]);
        reference
    }

    fn pixels(&self) -> impl Iterator<Item = usize> {
        (0..self.counts.len()).filter(|p| self.counts[*p])
    }

    fn delta_e(&self, a: &[f64], b: &[f64]) -> f64 {
        let all: Vec<f64> = self.pixels().map(|p| delta_e_2000(xyz(a, p), xyz(b, p), self.white)).collect();
        all.iter().sum::<f64>() / all.len() as f64
    }

    /// Errors of a picture made without this reference's samples. The reference's own noise is taken out: of the squared
    /// error by its variance, of Delta E as of any length of independent parts.
    pub fn errors(&self, picture: &[f64]) -> Errors {
        let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
        for i in self.pixels().map(|p| 3 * p + 1) {
            squares += (picture[i] - self.mean[i]).powi(2) - self.variance[i];
            sum += self.mean[i];
            count += 1.0;
        }
        let seen = self.delta_e(picture, &self.mean);
        Errors {
            delta_e: (seen * seen - self.own * self.own).max(0.0).sqrt(),
            relative_rmse: (squares / count).max(0.0).sqrt() / (sum / count),
        }
    }

    /// Others' renders against this one over blocks of 8 x 8 pixels that see no lamp: ratio of the means of Y, worst and mean
    /// |z|, z the difference over both standard errors. Our pixels have noise in common, theirs have none.
    pub fn agreement(&self, others: &Renders, size: usize) -> [f64; 3] {
        let (mean, variance) = (others.mean(), others.variance());
        let (mut sums, mut worst, mut total, mut count) = ([0.0; 2], 0f64, 0.0, 0.0);
        for block in 0..(size / 8).pow(2) {
            let corner = block / (size / 8) * 8 * size + block % (size / 8) * 8;
            let pixels: Vec<usize> = (0..64).map(|i| corner + i / 8 * size + i % 8).collect();
            if pixels.iter().any(|p| !self.counts[*p]) {
                continue;
            }
            let over = |values: &[f64], c: usize| pixels.iter().map(|p| values[3 * p + c]).sum::<f64>();
            sums[0] += over(&mean, 1);
            sums[1] += over(&self.mean, 1);
            for c in 0..3 {
                let spread = (over(&variance, c) + self.renders.variance_of_sum(&pixels, c)).sqrt();
                let z = (over(&mean, c) - over(&self.mean, c)).abs() / spread;
                worst = worst.max(z);
                total += z;
                count += 1.0;
            }
        }
        [sums[0] / sums[1], worst, total / count]
    }
}

/// Noise of the mean of some renders: for each component the root of its mean variance over its mean, over the pixels that
/// count; then the median over components with more than 1 % of the brightest one's light.
pub fn noise(renders: &Renders, counts: &[bool]) -> f64 {
    let (mean, variance, n) = (renders.mean(), renders.variance(), renders.channels);
    let pixels: Vec<usize> = (0..counts.len()).filter(|p| counts[*p]).collect();
    let over = |values: &[f64], c: usize| pixels.iter().map(|p| values[p * n + c]).sum::<f64>() / pixels.len() as f64;
    let light: Vec<f64> = (0..n).map(|c| over(&mean, c)).collect();
    let brightest = light.iter().copied().fold(0.0, f64::max);
    let lit = (0..n).filter(|c| light[*c] > 0.01 * brightest);
    let mut all: Vec<f64> = lit.map(|c| over(&variance, c).sqrt() / light[c]).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Root mean square over the pixels that count of the noise of Y in one of the renders, over that pixel's own Y.
pub fn relative_noise(renders: &Renders, counts: &[bool]) -> f64 {
    let (mean, variance, n) = (renders.mean(), renders.variance(), renders.pictures.len() as f64);
    let lit = (0..counts.len()).filter(|p| counts[*p]).map(|p| 3 * p + 1).filter(|i| mean[*i] > 0.0);
    let squares: Vec<f64> = lit.map(|i| n * variance[i] / (mean[i] * mean[i])).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
