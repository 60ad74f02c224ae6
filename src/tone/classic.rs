//! Histogram adjustment as Radiance's pcond does it, for comparison and for scripts that rely on it: `pcond --classic`.
//! Facts measured on Radiance 6.0a; the method is [Ward 1997].
//!
//! - Luminances are held within 1e-7 and 1e7 cd/m2, the largest counted as 1.01 of itself; 100 bins of ln L, the range then
//!   stretched by 100/99 downward and the lowest bin halved into the one below.
//! - All bins are cut to the ceiling of the map before the pass; passes go on while they trim more than 2.5 % of what is left.
//! - When 2.5 % of the original total is left or less, the map is linear: the mean of ln L goes to the middle of the display's
//!   range, or by visibility thresholds keep their ratio there. So it is too for a scene that fits.

use crate::tone::histogram::Histogram;
use crate::tone::threshold::threshold_cd_m2;
use crate::tone::{Curve, Display};

/// Luminances between which it looks, cd/m2.
const RANGE_CD_M2: (f64, f64) = (1e-7, 1e7);
const BINS: usize = 100;
/// Share of the counts at which it stops and gives up.
const ENOUGH: f64 = 0.025;

/// The map; `sensitivity` is the ceiling of `-s`.
pub fn adjusted(histogram: &Histogram, display: Display, sensitivity: bool) -> Curve {
    let Some((low, high)) = histogram.range_cd_m2() else { return Curve::linear(1.0, display) };
    let (low, high) = (low.max(RANGE_CD_M2.0).ln(), (high * 1.01).min(RANGE_CD_M2.1).ln());
    let (ln_min, ln_max) = display.ln();
    if high - low <= ln_max - ln_min {
        return linear(histogram, display, sensitivity);
    }
    let (mut counts, low) = binned(histogram, low, high);
    let start: f64 = counts.iter().sum();
    let width = (high - low) / BINS as f64;
    loop {
        let total: f64 = counts.iter().sum();
        if total <= ENOUGH * start {
            return linear(histogram, display, sensitivity);
        }
        let map = cumulative(&counts, total, (ln_min, ln_max));
        let mut trimmed = 0.0;
        for (i, count) in counts.iter_mut().enumerate() {
            let (world, shown) = (low + (i as f64 + 0.5) * width, 0.5 * (map[i] + map[i + 1]));
            let slope = if sensitivity {
                let (lw, ld) = (world.exp(), shown.exp());
                threshold_cd_m2(ld) / threshold_cd_m2(lw) * lw / ld
            } else {
                1.0
            };
            let ceiling = total * width / (ln_max - ln_min) * slope;
            trimmed += (*count - ceiling).max(0.0);
            *count = count.min(ceiling);
        }
        if trimmed <= ENOUGH * total {
            let total = counts.iter().sum();
            let map = cumulative(&counts, total, (ln_min, ln_max));
            return Curve::new((0..=BINS).map(|i| (low + i as f64 * width, map[i])).collect(), display);
        }
    }
}

/// 100 bins, the range stretched, the lowest halved into the new one below.
fn binned(histogram: &Histogram, low: f64, high: f64) -> (Vec<f64>, f64) {
    let stretched = high - (high - low) * BINS as f64 / (BINS - 1) as f64;
    let mut counts = histogram.between(BINS, stretched, high, |ln| ln).counts;
    let half = 0.5 * counts[1];
    counts[0] += half;
    counts[1] -= half;
    (counts, stretched)
}

/// ln Ld at the edges of the bins.
fn cumulative(counts: &[f64], total: f64, (ln_min, ln_max): (f64, f64)) -> Vec<f64> {
    let mut sum = 0.0;
    let mut map = vec![ln_min];
    for count in counts {
        sum += count;
        map.push(ln_min + (ln_max - ln_min) * (sum / total).min(1.0));
    }
    map
}

/// One factor for all.
fn linear(histogram: &Histogram, display: Display, sensitivity: bool) -> Curve {
    let (world, shown) = (histogram.mean_ln().exp(), display.middle_cd_m2());
    let factor = if sensitivity { threshold_cd_m2(shown) / threshold_cd_m2(world) } else { shown / world };
    Curve::linear(factor, display)
}
