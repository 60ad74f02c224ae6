//! Histograms of log luminance, and the map that adjusts them: [Ward 1997], technique C of the paper.
//!
//! The cumulative distribution P of ln L gives ln Ld = ln Ldmin + P (ln Ldmax - ln Ldmin). Where a peak would give the
//! display more contrast than the world had, its counts are trimmed to the *linear ceiling*: with T the counts left,
//! a bin of width db may hold at most T db / (ln Ldmax - ln Ldmin), which makes d ln Ld / d ln Lw at most 1.
//!
//! The original repeats the trimming until little is trimmed and gives up, with a jump to a linear map, when little is
//! left. Here the fixed point of the trimming is solved for exactly, and the map glides into the linear one as the share
//! of counts that survive falls from 30 % to 2.5 %, so that no small change of the picture makes a large one of the map.

use crate::tone::Curve;

/// Steps of the collecting histogram an octave: a power of two, read off the float's bits.
const STEPS: u32 = 32;
/// Smallest luminance collected, 2^-24 = 6e-8 cd/m2: under it an eye sees nothing.
const LOWEST_EXPONENT: i32 = -24;
/// Largest, 2^64.
const HIGHEST_EXPONENT: i32 = 64;
/// Bins of the adjusted histogram.
pub const BINS: usize = 100;
/// With this share of the counts surviving the trimming, or less, the map is linear.
const LINEAR_BELOW: f64 = 0.025;
/// With this share or more it is the adjusted histogram alone.
const ADJUSTED_ABOVE: f64 = 0.30;

/// Weights over log luminance.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    fine: Vec<f64>,
    min: f32,
    max: f32,
}

impl Default for Histogram {
    fn default() -> Self {
        let octaves = (HIGHEST_EXPONENT - LOWEST_EXPONENT) as usize;
        Histogram { fine: vec![0.0; octaves * STEPS as usize], min: f32::MAX, max: 0.0 }
    }
}

/// The display's range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Luminance of white, cd/m2.
    pub max_cd_m2: f64,
    /// Luminance of black, cd/m2, above 0.
    pub min_cd_m2: f64,
}

impl Histogram {
    /// Counts one luminance in cd/m2; what no eye sees (under 6e-8) and what is no luminance (NaN, infinite) is left out.
    pub fn add(&mut self, luminance_cd_m2: f32, weight: f64) {
        let lowest = 2f32.powi(LOWEST_EXPONENT);
        if !(luminance_cd_m2 >= lowest && luminance_cd_m2 < 2f32.powi(HIGHEST_EXPONENT)) {
            return;
        }
        let index = (luminance_cd_m2.to_bits() - lowest.to_bits()) >> (23 - STEPS.trailing_zeros());
        self.fine[index as usize] += weight;
        self.min = self.min.min(luminance_cd_m2);
        self.max = self.max.max(luminance_cd_m2);
    }

    /// Adds `other`, all its weights times `factor`.
    pub fn merge(&mut self, other: &Histogram, factor: f64) {
        self.fine.iter_mut().zip(&other.fine).for_each(|(a, b)| *a += b * factor);
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// Sum of all weights.
    pub fn total(&self) -> f64 {
        self.fine.iter().sum()
    }

    /// Smallest and largest luminance counted, cd/m2; `None` when nothing was.
    pub fn range_cd_m2(&self) -> Option<(f64, f64)> {
        (self.max > 0.0).then(|| (f64::from(self.min), f64::from(self.max)))
    }

    /// Ends of fine bin i, as natural logarithms. A step is even in value within its octave.
    fn edges_ln(i: usize) -> (f64, f64) {
        let at = |k: usize| {
            let (octave, step) = (k / STEPS as usize, k % STEPS as usize);
            let exponent = f64::from(LOWEST_EXPONENT) + octave as f64;
            exponent * std::f64::consts::LN_2 + (1.0 + step as f64 / f64::from(STEPS)).ln()
        };
        (at(i), at(i + 1))
    }

    /// Mean of ln L.
    pub fn mean_ln(&self) -> f64 {
        let weighted = |(i, w): (usize, &f64)| {
            let (a, b) = Histogram::edges_ln(i);
            w * 0.5 * (a + b)
        };
        self.fine.iter().enumerate().map(weighted).sum::<f64>() / self.total()
    }

    /// The weights in [`BINS`] even steps of ln L from `low` to `high`, each fine bin spread evenly over its width.
    fn coarse(&self, low: f64, high: f64) -> Vec<f64> {
        let width = (high - low) / BINS as f64;
        let mut bins = vec![0.0; BINS];
        for (i, weight) in self.fine.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let (a, b) = Histogram::edges_ln(i);
            let (a, b) = (a.clamp(low, high), b.clamp(low, high));
            if b <= a {
                let bin = ((a - low) / width) as usize;
                bins[bin.min(BINS - 1)] += weight;
                continue;
            }
            let first = (((a - low) / width) as usize).min(BINS - 1);
            for (bin, count) in bins.iter_mut().enumerate().skip(first) {
                let (from, to) = (low + bin as f64 * width, low + (bin + 1) as f64 * width);
                let overlap = b.min(to) - a.max(from);
                if overlap <= 0.0 {
                    break;
                }
                *count += weight * overlap / (b - a);
            }
        }
        bins
    }

    /// The linear map that shows the log-mean luminance at the middle of the display's range; a scene that fits the
    /// display is shifted until all of it fits. Returns the factor Ld / Lw.
    pub fn linear_factor(&self, display: Display) -> f64 {
        let Some((low, high)) = self.range_cd_m2() else { return display.max_cd_m2 };
        let factor = (display.max_cd_m2 * display.min_cd_m2).sqrt() / self.mean_ln().exp();
        let (a, b) = (display.min_cd_m2 / low, display.max_cd_m2 / high);
        factor.clamp(a.min(b), a.max(b))
    }

    /// The adjusted map.
    pub fn adjusted(&self, display: Display) -> Curve {
        let factor = self.linear_factor(display);
        let Some((low, high)) = self.range_cd_m2() else { return Curve::linear(factor, display) };
        let (ln_min, ln_max) = (display.min_cd_m2.ln(), display.max_cd_m2.ln());
        let (low, high) = (low.ln(), high.ln());
        let range = ln_max - ln_min;
        if high - low <= range {
            return Curve::linear(factor, display);
        }
        let mut bins = self.coarse(low, high);
        let share = trim(&mut bins, (high - low) / BINS as f64 / range);
        let blend = smoothstep((share - LINEAR_BELOW) / (ADJUSTED_ABOVE - LINEAR_BELOW));
        let total: f64 = bins.iter().sum();
        let mut sum = 0.0;
        let mut points = Vec::with_capacity(BINS + 1);
        for i in 0..=BINS {
            let ln_world = low + (high - low) * i as f64 / BINS as f64;
            let adjusted = ln_min + range * (sum / total).min(1.0);
            let linear = (ln_world + factor.ln()).clamp(ln_min, ln_max);
            points.push((ln_world, linear + blend * (adjusted - linear)));
            sum += bins.get(i).copied().unwrap_or(0.0);
        }
        Curve::new(points, display)
    }
}

/// Trims each bin to the share `ceiling` of what is left in all; returns the share of the counts that survive.
///
/// With T the counts left, T = sum of min(c, ceiling T): the right side is concave in T with slope (occupied bins) x
/// ceiling at 0, so that one positive solution exists when that is over 1. With the m fullest bins at the ceiling,
/// T = (counts of the others) / (1 - m ceiling).
fn trim(bins: &mut [f64], ceiling: f64) -> f64 {
    let before: f64 = bins.iter().sum();
    let mut order: Vec<f64> = bins.to_vec();
    order.sort_by(|a, b| b.total_cmp(a));
    let mut rest = before;
    let mut left = 0.0;
    for (m, count) in order.iter().enumerate() {
        let share = 1.0 - m as f64 * ceiling;
        if share <= 0.0 {
            break;
        }
        let t = rest / share;
        if *count <= ceiling * t {
            left = t;
            break;
        }
        rest -= count;
    }
    // No solution: the occupied bins span less than the display's range. Any T makes them all equal, a linear map.
    let limit =
        if left > 0.0 { ceiling * left } else { order.iter().copied().filter(|c| *c > 0.0).fold(f64::MAX, f64::min) };
    bins.iter_mut().for_each(|c| *c = c.min(limit));
    left / before
}

fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DISPLAY: Display = Display { max_cd_m2: 100.0, min_cd_m2: 1.0 };

    fn spike(f: f64) -> Histogram {
        let mut h = Histogram::default();
        for i in 0..5000 {
            h.add(10f64.powf(-1.0 + 5.0 * (i as f64 + 0.5) / 5000.0) as f32, (1.0 - f) / 5000.0);
        }
        h.add(10.0, f);
        h
    }

    #[test]
    fn a_scene_that_fits_keeps_its_contrast() {
        let mut h = Histogram::default();
        [0.5, 1.0, 7.0, 20.0].iter().for_each(|l| h.add(*l, 1.0));
        let curve = h.adjusted(DISPLAY);
        assert!((curve.at(20.0) / curve.at(0.5) - 40.0).abs() < 1e-3);
        assert!(curve.at(20.0) <= 100.0 && curve.at(0.5) >= 1.0);
    }

    #[test]
    fn there_is_no_cliff_at_the_fall_back() {
        // Radiance's pcond jumps by 5.8 times at f = 0.97602 for a change of 1e-6.
        let mut last: Option<Vec<f64>> = None;
        for step in 0..=2000 {
            let f = 0.80 + 0.0001 * step as f64;
            let curve = spike(f.min(1.0)).adjusted(DISPLAY);
            let now: Vec<f64> = [0.2, 1.0, 10.0, 100.0, 1000.0, 9000.0].iter().map(|l| curve.at(*l).ln()).collect();
            if let Some(last) = &last {
                let jump = now.iter().zip(last).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
                assert!(jump <= 0.1, "{jump} at {f}");
            }
            last = Some(now);
        }
    }

    proptest! {
        #[test]
        fn maps_rise_stay_on_the_display_and_add_no_contrast(
            samples in prop::collection::vec((-6f64..8.0, 0.01f64..10.0), 1..60),
        ) {
            let mut h = Histogram::default();
            samples.iter().for_each(|(l, w)| h.add(10f64.powf(*l) as f32, *w));
            let curve = h.adjusted(DISPLAY);
            let (low, high) = h.range_cd_m2().unwrap();
            let at: Vec<(f64, f64)> = (0..=400).map(|i| low.ln() + (high / low).ln() * i as f64 / 400.0)
                .map(|ln| (ln, curve.at(ln.exp()).ln())).collect();
            for pair in at.windows(2) {
                let (dw, dd) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                prop_assert!(dd >= -1e-9 && dd <= dw * (1.0 + 1e-6) + 1e-9, "{dd} over {dw}");
                prop_assert!(pair[1].1 <= 100f64.ln() + 1e-9 && pair[0].1 >= -1e-9);
            }
        }
    }
}
