//! From values to shares of a scale and back, linear or logarithmic.

use crate::{Result, usage};

/// A scale, cut in equal divisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value at share 0.
    pub min: f64,
    /// Value at share 1.
    pub max: f64,
    /// Equal ratios for equal shares.
    pub logarithmic: bool,
    /// Parts between the two ends.
    pub divisions: usize,
}

impl Scale {
    /// A scale up to `top`, or to a round value from the `largest` up; from `min`, or 0, or `decades` below the top if it is
    /// logarithmic.
    pub fn chosen(
        top: Option<f64>,
        min: Option<f64>,
        decades: Option<f64>,
        divisions: usize,
        largest: Option<f64>,
    ) -> Result<Scale> {
        let max = top.unwrap_or_else(|| match largest.filter(|x| *x > min.unwrap_or(0.0)) {
            Some(x) => round_up(x),
            None => min.map_or(1.0, |min| min + min.abs().max(1.0)),
        });
        let min = min.unwrap_or(decades.map_or(0.0, |decades| max / 10f64.powf(decades)));
        let logarithmic = decades.is_some();
        if min >= max || !(max - min).is_finite() || (logarithmic && min <= 0.0) {
            return usage!("the scale goes from {min} to {max}; --min must be below the top, and above 0 with --log");
        }
        Ok(Scale { min, max, logarithmic, divisions })
    }

    /// Where a value lies, from 0 to 1; what lies beyond is at the end. NaN stays NaN.
    ///
    /// ```
    /// use luxpipe::chart::Scale;
    /// let s = Scale { min: 10.0, max: 1000.0, logarithmic: true, divisions: 4 };
    /// assert!((s.share(100.0) - 0.5).abs() < 1e-12 && (s.value(0.5) - 100.0).abs() < 1e-9);
    /// assert_eq!((s.share(0.0), s.share(1e9)), (0.0, 1.0));
    /// ```
    pub fn share(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        };
        if value.is_nan() { value } else { share.clamp(0.0, 1.0) }
    }

    /// The value there.
    pub fn value(&self, share: f64) -> f64 {
        if self.logarithmic {
            self.min * (self.max / self.min).powf(share)
        } else {
            self.min + share * (self.max - self.min)
        }
    }

    /// Values at the ends of the divisions, from below.
    pub fn ticks(&self) -> impl Iterator<Item = (f64, f64)> {
        let n = self.divisions;
        (0..=n).map(move |i| i as f64 / n as f64).map(|share| (share, self.value(share)))
    }
}

/// The next number that reads well: 1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8 times a power of ten.
///
/// ```
/// use luxpipe::chart::scale::round_up;
/// assert_eq!([0.7, 1000.0, 1001.0, 43000.0].map(round_up), [0.8, 1000.0, 1200.0, 50000.0]);
/// ```
pub fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = x.log10().floor() as i32;
    // Tens of the step as a quotient or a product of whole numbers: the nearest double.
    let times = |n: f64| if power > 0 { n * 10f64.powi(power - 1) } else { n / 10f64.powi(1 - power) };
    let steps = [10.0, 12.0, 16.0, 20.0, 24.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0];
    steps.map(times).into_iter().find(|step| *step >= x * (1.0 - 1e-12)).filter(|s| s.is_finite()).unwrap_or(x)
}

/// Three significant digits where that is short, without idle zeros.
///
/// ```
/// use luxpipe::chart::scale::label;
/// let labels = [0.0, 1000.0, 12345.0, 12.5, 0.31623, 1.2e-7, 2.5e8].map(label);
/// assert_eq!(labels, ["0", "1000", "12300", "12.5", "0.316", "1.2e-7", "2.5e8"]);
/// ```
pub fn label(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { "?".into() };
    }
    let trim =
        |s: &str| if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.').to_string() } else { s.into() };
    let rounded = format!("{x:.2e}");
    let (digits, power) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    match power.parse::<i32>().unwrap_or(0) {
        -3..=5 => {
            let plain: f64 = rounded.parse().unwrap_or(x);
            trim(&format!("{plain:.5}"))
        }
        power => format!("{}e{power}", trim(digits)),
    }
}
