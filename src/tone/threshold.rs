//! The smallest difference of luminance that an eye adapted to a luminance sees, and contrast counted in such steps.
//!
//! The fit of rod and cone thresholds of [Ferwerda 1996], as [Ward 1997] joins them: log10 dLt of l = log10 La,
//!
//! | l | log10 dLt |
//! |---|---|
//! | under -3.94 | -2.86 |
//! | under -1.44 | (0.405 l + 1.6)^2.18 - 2.86 |
//! | under -0.0184 | l - 0.395 |
//! | under 1.9 | (0.249 l + 0.65)^2.7 - 0.72 |
//! | above | l - 1.255 |
//!
//! The pieces miss each other by up to 0.012 (at -1.44); they are kept as published.

use std::f64::consts::LN_10;

/// Threshold dLt in cd/m2 of an eye adapted to a luminance in cd/m2, 0 and up.
///
/// ```
/// use luxpipe::tone::threshold::threshold_cd_m2;
/// assert!((threshold_cd_m2(100.0).log10() - 0.745).abs() < 1e-9);
/// assert!((threshold_cd_m2(0.01).log10() + 2.26183).abs() < 1e-5);
/// ```
pub fn threshold_cd_m2(adaptation_cd_m2: f64) -> f64 {
    let l = adaptation_cd_m2.max(0.0).log10();
    let log = if l < -3.94 {
        -2.86
    } else if l < -1.44 {
        (0.405 * l + 1.6).powf(2.18) - 2.86
    } else if l < -0.0184 {
        l - 0.395
    } else if l < 1.9 {
        (0.249 * l + 0.65).powf(2.7) - 0.72
    } else {
        l - 1.255
    };
    10f64.powf(log)
}

/// ln L of the first and last node of the tables: darkness to a nuclear flash.
const LOWEST_LN: f64 = -9.0 * LN_10;
const HIGHEST_LN: f64 = 20.0 * LN_10;
/// Nodes an e-fold.
const NODES: usize = 48;

/// How a difference of more than nothing is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// The integral of dL / dLt(L).
    Integral,
    /// Whole thresholds one upon the other: from L to L + dLt(L) is exactly one step. With d = d dLt / dL the integrand is
    /// d / ln(1 + d) times the integral's, exact where dLt is linear, as it nearly is everywhere.
    Whole,
}

/// Luminance in threshold steps from darkness, as a table over ln L.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    at: Vec<f64>,
    adapted_cd_m2: f64,
}

impl Steps {
    /// `adapted_cd_m2`: eyes that come from a brighter place keep its threshold where theirs would be lower; 0 for eyes that
    /// have had their time.
    ///
    /// ```
    /// use luxpipe::tone::threshold::{Count, Steps, threshold_cd_m2};
    /// let steps = Steps::new(Count::Whole, 0.0);
    /// let (l, next) = (20.0f64, 20.0 + threshold_cd_m2(20.0));
    /// assert!((steps.of(next.ln()) - steps.of(l.ln()) - 1.0).abs() < 0.01);
    /// ```
    pub fn new(count: Count, adapted_cd_m2: f64) -> Steps {
        let h = 1.0 / NODES as f64;
        let nodes = ((HIGHEST_LN - LOWEST_LN) * NODES as f64) as usize + 1;
        let threshold = |l: f64| threshold_cd_m2(l.max(adapted_cd_m2));
        let density = |ln: f64| {
            let l = ln.exp();
            let rise = (threshold(l * 1.01) - threshold(l / 1.01)) / (l * (1.01 - 1.0 / 1.01));
            let whole = if count == Count::Whole && rise > 1e-6 { rise / rise.ln_1p() } else { 1.0 };
            l / threshold(l) * whole
        };
        let mut sum = LOWEST_LN.exp() / threshold(0.0);
        let mut at = Vec::with_capacity(nodes);
        at.push(sum);
        for i in 1..nodes {
            let a = LOWEST_LN + (i - 1) as f64 * h;
            sum += h / 6.0 * (density(a) + 4.0 * density(a + 0.5 * h) + density(a + h));
            at.push(sum);
        }
        Steps { at, adapted_cd_m2 }
    }

    /// Threshold in cd/m2 at a luminance in cd/m2 for these eyes.
    pub fn threshold_cd_m2(&self, luminance_cd_m2: f64) -> f64 {
        threshold_cd_m2(luminance_cd_m2.max(self.adapted_cd_m2))
    }

    /// Steps from darkness to ln L; linear in L under 1e-9 cd/m2.
    pub fn of(&self, ln_luminance: f64) -> f64 {
        let x = (ln_luminance - LOWEST_LN) * NODES as f64;
        if x < 0.0 {
            return self.at[0] * (ln_luminance - LOWEST_LN).exp();
        }
        let i = (x as usize).min(self.at.len() - 2);
        self.at[i] + (self.at[i + 1] - self.at[i]) * (x - i as f64)
    }

    /// ln L at a number of steps above 0.
    pub fn ln_luminance(&self, steps: f64) -> f64 {
        if steps < self.at[0] {
            return LOWEST_LN + (steps.max(f64::MIN_POSITIVE) / self.at[0]).ln();
        }
        let i = self.at.partition_point(|s| *s <= steps).clamp(1, self.at.len() - 1) - 1;
        LOWEST_LN + (i as f64 + (steps - self.at[i]) / (self.at[i + 1] - self.at[i])) / NODES as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_the_published_fit() {
        // tests/ref/README.md: tvi-ferwerda, by an independent evaluation of the formula.
        let l = [-6.0, -5.0, -4.0, -3.5, -3.0, -2.5, -2.0, -1.5, -1.2, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0];
        let want = [
            -2.86, -2.86, -2.86, -2.83548, -2.73517, -2.54636, -2.26183, -1.87628, -1.595, -1.395, -0.895, -0.407488,
            -0.2184, 0.0301553, 0.344724, 0.745, 1.745, 3.745,
        ];
        for (l, want) in l.iter().zip(want) {
            assert!((threshold_cd_m2(10f64.powf(*l)).log10() - want).abs() < 1e-4, "{l}");
        }
    }

    #[test]
    fn steps_rise_and_return() {
        for (count, adapted) in [(Count::Integral, 0.0), (Count::Whole, 0.0), (Count::Whole, 300.0)] {
            let steps = Steps::new(count, adapted);
            let mut last = 0.0;
            for i in -120..190 {
                let ln = f64::from(i) / 10.0 * LN_10;
                let s = steps.of(ln);
                assert!(s > last, "{ln}");
                last = s;
                assert!((steps.ln_luminance(s) - ln).abs() < 1e-6, "{ln}");
            }
        }
    }

    #[test]
    fn one_threshold_is_one_whole_step() {
        let steps = Steps::new(Count::Whole, 0.0);
        for i in -60..60 {
            let l = 10f64.powf(f64::from(i) / 10.0);
            let up = steps.of((l + threshold_cd_m2(l)).ln()) - steps.of(l.ln());
            // The published pieces have a corner of 3 % at -1.44 and smaller ones elsewhere.
            assert!((up - 1.0).abs() < 0.03, "{l}: {up}");
        }
    }

    #[test]
    fn bright_eyes_see_little_in_the_dark() {
        let steps = Steps::new(Count::Integral, 1000.0);
        let rested = Steps::new(Count::Integral, 0.0);
        assert!(steps.of(0.0) < 0.1 * rested.of(0.0));
        let (a, b) = (2000f64.ln(), 4000f64.ln());
        assert!((steps.of(b) - steps.of(a) - (rested.of(b) - rested.of(a))).abs() < 1e-9);
    }
}
