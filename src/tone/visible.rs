//! The map that keeps most of what is visible: `pcond --goal visibility`, and what `-h` does.
//!
//! On the scale of threshold steps ([`Count::Whole`]) a map of slope s shows a difference of k thresholds as about k s
//! thresholds of the display. Slope 1 or less shows nothing that was invisible. A difference that an observer reliably sees,
//! [`SURE`] thresholds or more, stays visible where the slope is at least s* = 1 / SURE or a little more, and is lost where
//! it is less, however little less: visibility has no halves.
//!
//! A scene that has no more steps than the display is shifted ([`exposed`]): all stays visible. Of a longer scene only a part
//! can stay, and the best map gives slope s* to the luminances with most pixels a step and next to none to the others. That
//! is what is done here, with three departures so that the map hangs continuously on the picture, each small enough to keep
//! 95 % of what the best map keeps:
//! - pixels a step are means over [`REACH`] steps up and down, so that the sides of a peak come along with it;
//! - luminances near the mean are preferred by up to [`PREFERENCE`] of all pixels a step, which decides between equals;
//! - the others still get [`REST`] of the display together, so that differences of many thresholds show.

use crate::tone::adjust::{exposed, lengths, smoothstep};
use crate::tone::histogram::Histogram;
use crate::tone::threshold::Count;
use crate::tone::{Curve, Display, Scale};

/// Thresholds of a difference that is to stay visible.
pub const SURE: f64 = 1.25;
/// The slope that keeps it, over the least one: room for the map's own grain.
const MARGIN: f64 = 1.02;
/// Steps of the map.
const STEPS: usize = 256;
/// Thresholds that a step's neighbours lie away.
const REACH: f64 = 2.0;
/// Share of all pixels a step.
const PREFERENCE: f64 = 1e-3;
/// Share of all pixels a step over which the slope goes from the rest's to s*.
const SOFT: f64 = 2e-5;
/// Share of the display for what is not kept.
const REST: f64 = 0.008;

/// The scale it counts by; eyes may come from a brighter place, 0 for rested ones.
pub fn scale(adapted_cd_m2: f64) -> Scale {
    Scale::visibility(Count::Whole, adapted_cd_m2)
}

/// Least slope at a world luminance that shows [`SURE`] thresholds as one.
fn keeping_slope(scale: &Scale, ln_luminance: f64) -> f64 {
    let l = ln_luminance.exp();
    let seen = l + SURE * scale.threshold_cd_m2(l);
    let steps = scale.world(seen.ln()) - scale.world(ln_luminance);
    (MARGIN / steps.max(1.0)).min(1.0)
}

/// The map.
pub fn visible(histogram: &Histogram, display: Display, scale: &Scale) -> Curve {
    let (scene, shown) = lengths(histogram, display, scale);
    if scene <= shown {
        return exposed(histogram, display, scale);
    }
    let even = histogram.even(STEPS, |ln| scale.world(ln));
    let width = even.width();
    let places: Vec<f64> = (0..STEPS).map(|i| even.low + (i as f64 + 0.5) * width).collect();
    let least: Vec<f64> = places.iter().map(|p| keeping_slope(scale, scale.world_ln(*p))).collect();
    // A difference is carried by the steps from its darker side up.
    let below = (SURE / width).ceil() as usize;
    let keeping: Vec<f64> =
        (0..STEPS).map(|i| least[i.saturating_sub(below)..=i].iter().fold(0.0, |m: f64, s| m.max(*s))).collect();
    let wanted = wanted(&even.counts, width);
    let slopes = slopes(&wanted, &keeping, shown / width);
    let mut at = scale.display(display.min_cd_m2.ln());
    let top = scale.display(display.max_cd_m2.ln());
    let mut points = vec![(scale.world_ln(even.low), scale.display_ln(at))];
    // Within a step too the map is straight on the scale, not in logarithms.
    const PARTS: usize = 4;
    for (place, slope) in places.iter().zip(&slopes) {
        for part in 1..=PARTS {
            at = (at + slope * width / PARTS as f64).min(top);
            let world = place + (part as f64 / PARTS as f64 - 0.5) * width;
            points.push((scale.world_ln(world), scale.display_ln(at)));
        }
    }
    Curve::new(points, display)
}

/// How much each step is wanted: pixels a threshold step over its surroundings, as a share of all, and the preference.
fn wanted(counts: &[f64], width: f64) -> Vec<f64> {
    let total: f64 = counts.iter().sum();
    let mut sums = vec![0.0];
    for count in counts {
        sums.push(sums[sums.len() - 1] + count / total);
    }
    let below = |x: f64| {
        let x = x.clamp(0.0, counts.len() as f64);
        let i = (x as usize).min(counts.len() - 1);
        sums[i] + (sums[i + 1] - sums[i]) * (x - i as f64)
    };
    let mean = counts.iter().enumerate().map(|(i, c)| c / total * (i as f64 + 0.5)).sum::<f64>();
    let reach = REACH / width;
    let wanted = |i: usize| {
        let x = i as f64 + 0.5;
        let density = (below(x + reach) - below(x - reach)) / (2.0 * REACH);
        density + PREFERENCE * (1.0 - 2.0 * (x - mean).abs() / counts.len() as f64)
    };
    (0..counts.len()).map(wanted).collect()
}

/// Slopes that add up to `sum`: s* where a step is wanted more than some level, the rest's elsewhere.
fn slopes(wanted: &[f64], keeping: &[f64], sum: f64) -> Vec<f64> {
    let rest = REST * sum / wanted.len() as f64;
    let at = |level: f64| -> Vec<f64> {
        let slope = |(w, s): (&f64, &f64)| rest + (s - rest).max(0.0) * smoothstep((w - level) / SOFT + 0.5);
        wanted.iter().zip(keeping).map(slope).collect()
    };
    let all: f64 = keeping.iter().sum();
    if all <= sum {
        // All of it can be kept, and something is left over: slopes go on toward 1.
        let more = (sum - all) / (wanted.len() as f64 - all);
        return keeping.iter().map(|s| s + more * (1.0 - s)).collect();
    }
    let (mut low, mut high) = (-2.0 * PREFERENCE - SOFT, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle).iter().sum::<f64>() >= sum { low = middle } else { high = middle }
    }
    at(high)
}
