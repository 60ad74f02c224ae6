//! Histograms of log luminance: collected, added up over frames, written and read as text.
//!
//! The text is what `pcond -I` takes in Radiance: lines `log10_luminance count`, even steps, cd/m2.

use std::fmt::Write as _;

use crate::{Result, invalid, simd};

/// Steps of the collecting histogram an octave: a power of two, read off the float's bits.
const STEPS: u32 = 32;
/// Smallest luminance collected, 2^-24 = 6e-8 cd/m2: under it an eye sees nothing.
const LOWEST_EXPONENT: i32 = -24;
/// Largest, 2^64.
const HIGHEST_EXPONENT: i32 = 64;
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

    /// Counts luminances one each, as [`Histogram::add`] does.
    pub fn add_all(&mut self, luminances_cd_m2: &[f32]) {
        let lowest = 2f32.powi(LOWEST_EXPONENT).to_bits();
        let span = 2f32.powi(HIGHEST_EXPONENT).to_bits() - lowest;
        // Floats above 0 compare as whole numbers; anything else wraps beyond the span.
        let (low, high) = simd::wide(
            #[inline(always)]
            || {
                luminances_cd_m2.iter().fold((u32::MAX, 0u32), |(low, high), y| {
                    let bits = y.to_bits().wrapping_sub(lowest);
                    let counts = bits < span;
                    (low.min(if counts { bits } else { u32::MAX }), high.max(if counts { bits } else { 0 }))
                })
            },
        );
        if low == u32::MAX {
            return;
        }
        self.min = self.min.min(f32::from_bits(low + lowest));
        self.max = self.max.max(f32::from_bits(high + lowest));
        for y in luminances_cd_m2 {
            let index = y.to_bits().wrapping_sub(lowest) >> (23 - STEPS.trailing_zeros());
            if let Some(count) = self.fine.get_mut(index as usize) {
                *count += 1.0;
            }
        }
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

    /// The weights in `count` even steps of `scale` (a rising function of ln L) from its value at the smallest luminance to
    /// that at the largest, each fine bin spread evenly over its part.
    pub fn even(&self, count: usize, scale: impl Fn(f64) -> f64) -> Even {
        let ends = self.range_cd_m2().map(|(low, high)| [scale(low.ln()), scale(high.ln())]);
        let [low, high] = ends.unwrap_or([0.0, 0.0]);
        self.between(count, low, high, scale)
    }

    /// The same from one value of the scale to another; what lies outside counts in the first and last step.
    pub fn between(&self, count: usize, low: f64, high: f64, scale: impl Fn(f64) -> f64) -> Even {
        let width = (high - low) / count as f64;
        let mut counts = vec![0.0; count];
        for (i, weight) in self.fine.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let (a, b) = Histogram::edges_ln(i);
            let (a, b) = (scale(a).clamp(low, high), scale(b).clamp(low, high));
            let first = if width > 0.0 { (((a - low) / width) as usize).min(count - 1) } else { 0 };
            if b - a <= 1e-12 * (high - low) {
                counts[first] += weight;
                continue;
            }
            for (bin, sum) in counts.iter_mut().enumerate().skip(first) {
                let (from, to) = (low + bin as f64 * width, low + (bin + 1) as f64 * width);
                let overlap = b.min(to) - a.max(from);
                if overlap <= 0.0 {
                    break;
                }
                *sum += weight * overlap / (b - a);
            }
        }
        Even { low, high, counts }
    }

    /// Centres (ln L) and weights of what was counted.
    pub fn weights(&self) -> impl Iterator<Item = (f64, f64)> {
        self.fine.iter().enumerate().filter(|(_, w)| **w > 0.0).map(|(i, w)| {
            let (a, b) = Histogram::edges_ln(i);
            (0.5 * (a + b), *w)
        })
    }

    /// As text, `count` steps of log10 L; nothing where nothing was counted. The first and last line stand at the extremes.
    pub fn to_text(&self, count: usize) -> String {
        let mut text = String::new();
        if self.range_cd_m2().is_none() {
            return text;
        }
        let even = self.even(count, |ln| ln / std::f64::consts::LN_10);
        let step = (even.high - even.low) / count as f64;
        for (i, n) in even.counts.iter().enumerate() {
            let _ = writeln!(text, "{:.6} {n:.6e}", even.low + (i as f64 + 0.5) * step);
        }
        text
    }

    /// From text: 2 to 1024 lines `log10_luminance count`, even steps within 0.001. A step's weight is spread over it.
    pub fn from_text(text: &str) -> Result<Histogram> {
        let mut lines: Vec<(f64, f64)> = Vec::new();
        for (n, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
            let words: Vec<Option<f64>> = line.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
            match words[..] {
                [Some(l), Some(count)] if f64::abs(l) <= 30.0 && (0.0..1e300).contains(&count) => {
                    lines.push((l, count))
                }
                _ => return invalid!("line {}: expected a log10 luminance and a count of 0 or more", n + 1),
            }
        }
        if !(2..=1024).contains(&lines.len()) {
            return invalid!("{} lines; a histogram has 2 to 1024", lines.len());
        }
        let step = (lines[lines.len() - 1].0 - lines[0].0) / (lines.len() - 1) as f64;
        if step.is_nan() || step <= 0.0 || lines.windows(2).any(|p| (p[1].0 - p[0].0 - step).abs() > 1e-3) {
            return invalid!("the steps of log10 luminance are not even");
        }
        let mut h = Histogram::default();
        /// Parts of a step: finer than the collecting bins are wide.
        const PARTS: usize = 32;
        for (l, count) in lines.iter().filter(|l| l.1 > 0.0) {
            for part in 0..PARTS {
                let at = l + step * ((part as f64 + 0.5) / PARTS as f64 - 0.5);
                h.add(10f64.powf(at) as f32, count / PARTS as f64);
            }
        }
        if h.total() > 0.0 { Ok(h) } else { invalid!("all counts are 0, or lie where no eye sees") }
    }
}

/// Weights in even steps of a scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Even {
    /// Scale value where the first step begins.
    pub low: f64,
    /// Where the last one ends.
    pub high: f64,
    /// Weight of each step.
    pub counts: Vec<f64>,
}

impl Even {
    /// Width of a step.
    pub fn width(&self) -> f64 {
        (self.high - self.low) / self.counts.len() as f64
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.counts.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_returns() {
        let mut h = Histogram::default();
        (0..5000).for_each(|i| h.add(10f32.powf(-2.0 + i as f32 / 1000.0), 1.0 + (i % 7) as f64));
        let back = Histogram::from_text(&h.to_text(100)).unwrap();
        assert!((back.total() / h.total() - 1.0).abs() < 1e-5);
        assert!((back.mean_ln() - h.mean_ln()).abs() < 1e-3);
        let (a, b) = (h.range_cd_m2().unwrap(), back.range_cd_m2().unwrap());
        assert!((b.0 / a.0).ln().abs() < 0.01 && (b.1 / a.1).ln().abs() < 0.01, "{a:?} {b:?}");
        for bad in ["", "1 2", "0 1\n1 x", "0 1\n1 2\n3 1", "0 0\n1 0", "0 -1\n1 1", "0 1\n0 1"] {
            assert!(Histogram::from_text(bad).is_err(), "{bad:?}");
        }
    }
}
