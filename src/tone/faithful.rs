//! The map of least colour difference: `pcond --goal colour`.
//!
//! Of all rising maps that give each step of world luminance one of [`LEVELS`] of the display's, the one with the least mean
//! Delta E 2000 over pixels between the scene and what the display shows of it, after what its primaries cannot make has been
//! moved toward grey of equal luminance (`xyz2rgb --gamut desaturate`). The scene is seen under its white at Yn, the picture
//! under the display's; shadows count lifted as everywhere in luxpipe (see `pcompare`): by min(gain, max(1, Yn / 2 Y)).
//!
//! Each choice costs the same whatever the others are, but for having to rise: a shortest path, found exactly in one sweep
//! over steps and levels.

use crate::color::difference::{ciede2000, lab};
use crate::color::{Mat3, Primaries};
use crate::parallel;
use crate::tone::palette::{Palette, Step};
use crate::tone::{Curve, Display};

/// Levels of the display, even in CIE lightness.
const LEVELS: usize = 201;
/// Shadows are lifted up to this.
const GAIN: f64 = 10.0;
/// The scene's white when nobody says it: this share of pixels is darker.
const WHITE_QUANTILE: f64 = 0.99;

/// Where colours are seen.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// Black and white.
    pub display: Display,
    /// Primaries and white.
    pub primaries: Primaries,
}

/// The map; `white_cd_m2` is the scene's white Yn, or the 99th percentile. `None` when no pixel has light, or the primaries
/// span no area.
pub fn faithful(palette: &Palette, medium: Medium, white_cd_m2: Option<f64>) -> Option<Curve> {
    let white = white_cd_m2.or_else(|| palette.quantile_cd_m2(WHITE_QUANTILE))?;
    let seen = Seen { medium, from_xyz: medium.primaries.from_xyz()?, to_xyz: medium.primaries.to_xyz()?, white };
    let steps: Vec<&Step> = palette.steps().collect();
    let total: f64 = steps.iter().map(|s| s.count as f64).sum();
    let levels: Vec<f64> =
        (0..LEVELS).map(|k| luminance(100.0 * k as f64 / (LEVELS - 1) as f64, medium.display)).collect();
    let mut costs: Vec<(usize, Vec<f64>)> = (0..steps.len()).map(|i| (i, Vec::new())).collect();
    parallel::for_pieces(&mut costs, 1, |_, piece| {
        for (i, row) in piece {
            let step = steps[*i];
            let weight = step.count as f64 / (total * step.colours.len() as f64);
            let cost =
                |shown: &f64| step.colours.iter().map(|(l, c)| seen.difference(f64::from(*l), *c, *shown)).sum::<f64>();
            *row = levels.iter().map(|shown| weight * cost(shown)).collect();
        }
    });
    let rows: Vec<Vec<f64>> = costs.into_iter().map(|c| c.1).collect();
    let chosen = cheapest_rise(&rows);
    let point = |(step, k): (&&Step, usize)| {
        let mean = step.colours.iter().map(|c| f64::from(c.0).ln()).sum::<f64>() / step.colours.len() as f64;
        (mean, levels[k].ln())
    };
    Some(Curve::new(steps.iter().zip(chosen).map(point).collect(), medium.display))
}

/// Level of each row such that levels never fall and the costs add up to least.
pub fn cheapest_rise(rows: &[Vec<f64>]) -> Vec<usize> {
    let mut best: Vec<f64> = vec![0.0; rows.first().map_or(0, Vec::len)];
    let mut from: Vec<Vec<u16>> = Vec::with_capacity(rows.len());
    for row in rows {
        let (mut least, mut at) = (f64::MAX, 0);
        let mut back = Vec::with_capacity(row.len());
        for (k, (sum, cost)) in best.iter_mut().zip(row).enumerate() {
            if *sum < least {
                (least, at) = (*sum, k);
            }
            back.push(at as u16);
            *sum = least + cost;
        }
        from.push(back);
    }
    let end = (0..best.len()).min_by(|a, b| best[*a].total_cmp(&best[*b])).unwrap_or(0);
    let mut chosen = vec![end; rows.len()];
    for i in (1..rows.len()).rev() {
        chosen[i - 1] = from[i][chosen[i]] as usize;
    }
    chosen
}

/// The display's luminance in cd/m2 at a CIE lightness between its black's and 100.
fn luminance(lightness: f64, display: Display) -> f64 {
    let black = lab([0.0, display.min_cd_m2 / display.max_cd_m2, 0.0], [1.0; 3])[0];
    let l = black + (100.0 - black) * lightness / 100.0;
    let y = if l > 8.0 { ((l + 16.0) / 116.0).powi(3) } else { l * 27.0 / 24389.0 };
    (y * display.max_cd_m2).clamp(display.min_cd_m2, display.max_cd_m2)
}

struct Seen {
    medium: Medium,
    from_xyz: Mat3,
    to_xyz: Mat3,
    white: f64,
}

impl Seen {
    /// Delta E 2000 of a colour (XYZ of unit luminance) at world luminance `l` shown at display luminance `shown`.
    fn difference(&self, l: f64, colour: [f32; 3], shown: f64) -> f64 {
        let Medium { display, primaries } = self.medium;
        let white = primaries.white.xyz();
        let share = (shown - display.min_cd_m2) / (display.max_cd_m2 - display.min_cd_m2);
        let rgb = self.from_xyz.apply(colour.map(|x| f64::from(x) * share));
        let light = self.to_xyz.apply(desaturated(rgb, share));
        let (black, range) = (display.min_cd_m2 / display.max_cd_m2, 1.0 - display.min_cd_m2 / display.max_cd_m2);
        let scene = l / self.white;
        let lift = if scene * GAIN <= 0.5 { GAIN } else { (0.5 / scene).max(1.0) };
        let reference = colour.map(|x| lift * f64::from(x) * scene);
        let picture = [0, 1, 2].map(|i| lift * (light[i] * range + white[i] * black));
        ciede2000(lab(picture, white), lab(reference, white))
    }
}

/// Toward the grey of equal luminance until all components are within 0 and 1, as [`crate::color::gamut::desaturate`].
fn desaturated(rgb: [f64; 3], grey: f64) -> [f64; 3] {
    let (low, high) = (rgb[0].min(rgb[1]).min(rgb[2]), rgb[0].max(rgb[1]).max(rgb[2]));
    let below = if low < 0.0 { grey / (grey - low) } else { 1.0 };
    let above = if high > 1.0 { (1.0 - grey) / (high - grey) } else { 1.0 };
    let keep = below.min(above).max(0.0);
    rgb.map(|x| grey + (x - grey) * keep)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEDIUM: Medium =
        Medium { display: Display { max_cd_m2: 100.0, min_cd_m2: 0.01 }, primaries: Primaries::BT709 };

    #[test]
    fn a_scene_that_the_display_can_show_is_shown_as_it_is() {
        let mut palette = Palette::default();
        for i in 0..4000 {
            let l = 10f32.powf(-1.0 + 3.0 * i as f32 / 4000.0);
            palette.add(l, [0.9505, 1.0, 1.089].map(|x| x * l));
        }
        let curve = faithful(&palette, MEDIUM, Some(100.0)).unwrap();
        for l in [1.0, 3.0, 10.0, 30.0, 90.0] {
            // Levels are half a unit of lightness apart.
            let [a, b] = [curve.at(l), l].map(|y| lab([0.0, y / 100.0, 0.0], [1.0; 3])[0]);
            assert!((a - b).abs() < 0.6, "{l}: {}", curve.at(l));
        }
    }

    #[test]
    fn no_rise_is_cheaper() {
        let cost = |i: usize, k: usize| ((i * 37 + k * 61) % 23) as f64;
        let rows: Vec<Vec<f64>> = (0..5).map(|i| (0..6).map(|k| cost(i, k)).collect()).collect();
        let sum = |levels: &[usize]| -> f64 { levels.iter().enumerate().map(|(i, k)| cost(i, *k)).sum() };
        let mut best = f64::MAX;
        for code in 0..6usize.pow(5) {
            let levels: Vec<usize> = (0..5).map(|i| code / 6usize.pow(i) % 6).collect();
            if levels.windows(2).all(|w| w[0] <= w[1]) {
                best = best.min(sum(&levels));
            }
        }
        let chosen = cheapest_rise(&rows);
        assert!(chosen.windows(2).all(|w| w[0] <= w[1]));
        assert_eq!(sum(&chosen), best);
    }
}
