//! The map that makes most of a print: the paper's Figure 5, `pcond --print`.
//!
//! Of all rising maps it maximises the mean over pixels of the logarithm of contrast,
//!
//! ```text
//! sum_i p_i ln s_i,   s_i = (B_i+1 - B_i) / b,   B = ln(L + veil)
//! ```
//!
//! where p_i is the share of pixels in the i-th of even steps b of world ln L, B the log luminance of the print as it is seen
//! (its gloss reflects a veil of the room), under three conditions: s_i <= 1 (no more contrast than the world has), all B
//! between black and white of the print, and B_i+1 <= C_i, the brightest at which the print's dyes make the colours that the
//! picture has in step i and brighter. So a picture of strong colours comes out darker rather than paler.
//!
//! Without the C this is histogram adjustment: s_i = min(1, p_i / (mu b)), mu such that the range is used up, the stationary
//! point of the Lagrangian. The C bound sums of the first s_i, a nested family, for which the decomposition of [Groenevelt
//! 1991] is exact: solve without them, take the step that oversteps most, make it hold there, and solve both sides apart.
//! In luminance, where the veil is subtracted again, dark tones get more contrast than on a screen.
//!
//! C_i is where 90 % of the step's colours fit, and at most [`DARKEST`] under white; the rest are darkened pixel by pixel.

use crate::color::Mat3;
use crate::tone::adjust::BINS;
use crate::tone::histogram::Histogram;
use crate::tone::palette::{Palette, brightest_share};
use crate::tone::{Curve, Display};

/// Share of a step's colours that a map need not fit.
const UNFIT: f64 = 0.10;
/// How far colours may darken the whole, in ln L: one stop.
pub const DARKEST: f64 = std::f64::consts::LN_2;

/// The map: `display` has the print's black and white with the veil, `from_xyz` its primaries.
pub fn print(histogram: &Histogram, palette: &Palette, display: Display, from_xyz: &Mat3) -> Curve {
    let even = histogram.even(BINS, |ln| ln);
    let width = even.width();
    let (black, white) = display.ln();
    if width <= 0.0 || even.total() <= 0.0 {
        return crate::tone::adjust::exposed(histogram, display, &crate::tone::Scale::Ratio);
    }
    let caps = caps(palette, display, from_xyz, even.low, width);
    let caps: Vec<f64> = caps.into_iter().map(|c| c - black).collect();
    let rises = optimum(&even.counts, width, &caps);
    // What fits with room to spare stands as high as its colours let it.
    let mut at = 0.0;
    let ends: Vec<f64> = rises
        .iter()
        .map(|r| {
            at += r;
            at
        })
        .collect();
    let spare = ends.iter().zip(&caps).map(|(e, c)| c - e).fold(white - black, f64::min).max(0.0);
    let mut points = vec![(even.low, black + spare)];
    points.extend(ends.iter().enumerate().map(|(i, e)| (even.low + (i + 1) as f64 * width, black + spare + e)));
    Curve::new(points, display)
}

/// Highest ln L at the upper edge of each step, rising.
fn caps(palette: &Palette, display: Display, from_xyz: &Mat3, low: f64, width: f64) -> Vec<f64> {
    let (_, white) = display.ln();
    let mut caps = vec![white; BINS];
    for step in palette.steps() {
        let mut fits: Vec<f64> = step.colours.iter().map(|c| brightest_share(from_xyz, c.1)).collect();
        fits.sort_by(f64::total_cmp);
        let share = fits[((UNFIT * fits.len() as f64) as usize).min(fits.len() - 1)];
        let luminance = display.min_cd_m2 + share * (display.max_cd_m2 - display.min_cd_m2);
        let cap = luminance.ln().max(white - DARKEST);
        for (l, _) in &step.colours {
            let i = (((f64::from(*l).ln() - low) / width).max(0.0) as usize).min(BINS - 1);
            caps[i] = caps[i].min(cap);
        }
    }
    for i in (0..BINS - 1).rev() {
        caps[i] = caps[i].min(caps[i + 1]);
    }
    caps
}

/// Rises of B over steps of `width` that maximise the sum of counts x ln(rise), each at most `width`, the sum of the first i
/// at most caps[i-1]; caps rise.
pub fn optimum(counts: &[f64], width: f64, caps: &[f64]) -> Vec<f64> {
    let mut rises = vec![0.0; counts.len()];
    let mut parts = vec![(0, counts.len(), 0.0, caps[counts.len() - 1])];
    while let Some((from, to, start, end)) = parts.pop() {
        let part = spread(&counts[from..to], width, end - start);
        let mut sum = start;
        let mut worst = (1e-12, 0, 0.0);
        for (i, rise) in part.iter().enumerate().take(to - from - 1) {
            sum += rise;
            if sum - caps[from + i] > worst.0 {
                worst = (sum - caps[from + i], from + i + 1, caps[from + i]);
            }
        }
        if worst.1 > 0 {
            parts.push((from, worst.1, start, worst.2));
            parts.push((worst.1, to, worst.2, end));
        } else {
            rises[from..to].copy_from_slice(&part);
        }
    }
    rises
}

/// min(width, x count) with the x for which they add up to `sum`; all `width` where that is not more.
fn spread(counts: &[f64], width: f64, sum: f64) -> Vec<f64> {
    let occupied = counts.iter().filter(|c| **c > 0.0).count() as f64;
    if occupied * width <= sum {
        // Steps without pixels share what is left: they have no contrast to lose.
        let empty = counts.len() as f64 - occupied;
        let rest = if empty > 0.0 { ((sum - occupied * width) / empty).min(width) } else { 0.0 };
        return counts.iter().map(|c| if *c > 0.0 { width } else { rest }).collect();
    }
    let mut order: Vec<f64> = counts.to_vec();
    order.sort_by(|a, b| b.total_cmp(a));
    let (mut rest, mut left) = (order.iter().sum::<f64>(), sum);
    let mut x = 0.0;
    for count in &order {
        x = left / rest;
        if count * x <= width {
            break;
        }
        rest -= count;
        left -= width;
    }
    counts.iter().map(|c| (c * x).min(width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn objective(counts: &[f64], rises: &[f64]) -> f64 {
        counts.iter().zip(rises).filter(|(c, _)| **c > 0.0).map(|(c, r)| c * r.max(1e-300).ln()).sum()
    }

    /// The best of all maps whose rises are multiples of the width's 12th part.
    fn brute(counts: &[f64], caps: &[f64]) -> f64 {
        const PARTS: i32 = 12;
        fn from(i: usize, sum: i32, counts: &[f64], caps: &[f64], rises: &mut Vec<f64>) -> f64 {
            if i == counts.len() {
                return objective(counts, rises);
            }
            let mut best = f64::MIN;
            for r in 0..=PARTS {
                if f64::from(sum + r) / f64::from(PARTS) <= caps[i] + 1e-12 {
                    rises.push(f64::from(r) / f64::from(PARTS));
                    best = best.max(from(i + 1, sum + r, counts, caps, rises));
                    rises.pop();
                }
            }
            best
        }
        from(0, 0, counts, caps, &mut Vec::new())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn no_map_does_better(
            counts in prop::collection::vec(prop_oneof![Just(0.0), 0.01f64..10.0], 2..6),
            steps in prop::collection::vec(0.05f64..1.2, 5),
        ) {
            let caps: Vec<f64> = steps[..counts.len()].iter().scan(0.0, |s, x| { *s += x; Some(*s) }).collect();
            let ours = optimum(&counts, 1.0, &caps);
            let mut sum = 0.0;
            for (rise, cap) in ours.iter().zip(&caps) {
                sum += rise;
                prop_assert!((0.0..=1.0 + 1e-12).contains(rise) && sum <= cap + 1e-9, "{ours:?} {caps:?}");
            }
            let (best, got) = (brute(&counts, &caps), objective(&counts, &ours));
            prop_assert!(got >= best - 1e-9 * (1.0 + best.abs()), "{got} {best} {counts:?} {caps:?} {ours:?}");
        }
    }

    #[test]
    fn strong_colours_darken_the_picture() {
        use crate::color::Primaries;
        let m = Primaries::BT709.from_xyz().unwrap();
        let display = Display { max_cd_m2: 100.0, min_cd_m2: 1.0 };
        let picture = |colour: [f32; 3]| {
            let (mut h, mut p) = (Histogram::default(), Palette::default());
            for i in 0..3000 {
                let l = 10f32.powf(i as f32 / 1000.0);
                h.add(l, 1.0);
                let c = if l > 300.0 { colour } else { [0.95, 1.0, 1.09] };
                p.add(l, c.map(|x| x * l));
            }
            print(&h, &p, display, &m)
        };
        let (grey, red) = (picture([0.95, 1.0, 1.09]), picture([0.4124 / 0.2126, 1.0, 0.0193 / 0.2126]));
        assert!((grey.at(999.0) - 100.0).abs() < 1.0);
        assert!((red.at(999.0) - 50.0).abs() < 1.0); // red ends at 22 cd/m2, a stop is the most
        assert!(red.at(10.0) < grey.at(10.0));
    }
}
