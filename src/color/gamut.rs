//! Bringing linear RGB into the range that a display or an encoding has.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::simd::GROUP;
use crate::simd::bound;

/// What to do with colours that the primaries cannot make.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Gamut {
    /// Leave them: negative components and components over 1 stay
    None,
    /// Clip each component: fast, and it changes hue and luminance
    Clip,
    /// Move toward the grey of equal luminance until every component fits: hue in XYZ kept, luminance kept
    Desaturate,
    /// Technique A: all saturations divided by what the most saturated colour needs
    Shrink,
    /// Technique B: saturations under the knee kept, the rest bent into what is left
    Compress,
}

/// The range that a component may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// 0 and up: scene-referred light.
    Positive,
    /// 0 to 1: display-referred light.
    Unit,
}

/// Components beyond this are brought to it before they are mapped, so that no sum overflows: no light is as strong.
const LARGEST: f32 = 1e37;

/// Keeps what is mapped finite; NaN stays what it is.
#[inline(always)]
pub fn tame(rgb: &mut [[f32; GROUP]; 3]) {
    for plane in rgb {
        for x in plane {
            *x = if *x > LARGEST { LARGEST } else { *x };
            *x = if *x < -LARGEST { -LARGEST } else { *x };
        }
    }
}

/// Clips to the limit.
#[inline(always)]
pub fn clip(rgb: &mut [[f32; GROUP]; 3], limit: Limit) {
    let top = match limit {
        Limit::Positive => f32::MAX,
        Limit::Unit => 1.0,
    };
    for plane in rgb {
        for x in plane {
            *x = bound(*x, 0.0, top); // NaN becomes 0
        }
    }
}

/// Moves each colour toward the grey of its own luminance until it fits; `y` is the luminance row of RGB to XYZ.
///
/// A luminance outside the limit is first brought to its end: such a colour becomes black or white.
#[inline(always)]
pub fn desaturate(rgb: &mut [[f32; GROUP]; 3], y: &[f32; 3], limit: Limit) {
    let top = match limit {
        Limit::Positive => f32::MAX,
        Limit::Unit => 1.0,
    };
    for i in 0..GROUP {
        let [r, g, b] = [rgb[0][i], rgb[1][i], rgb[2][i]];
        let grey = bound(y[0] * r + y[1] * g + y[2] * b, 0.0, top);
        let (low, high) = (r.min(g).min(b), r.max(g).max(b));
        // Share of the way from grey to the colour that stays inside: 1 where nothing sticks out.
        let below = if low < 0.0 { grey / (grey - low) } else { 1.0 };
        let above = if high > top { (top - grey) / (high - grey) } else { 1.0 };
        let keep = below.min(above).max(0.0);
        let outside = low < 0.0 || high > top; // keep may round to 1
        for plane in rgb.iter_mut() {
            let moved = bound(grey + (plane[i] - grey) * keep, 0.0, top);
            plane[i] = if outside { moved } else { plane[i] };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const Y709: [f32; 3] = [0.212639, 0.715169, 0.072192];

    fn one(rgb: [f32; 3], limit: Limit) -> [f32; 3] {
        let mut planes = rgb.map(|x| [x; GROUP]);
        desaturate(&mut planes, &Y709, limit);
        planes.map(|p| p[GROUP - 1])
    }

    fn luminance(rgb: [f32; 3]) -> f32 {
        rgb.iter().zip(Y709).map(|(a, b)| a * b).sum()
    }

    proptest! {
        #[test]
        fn desaturation_keeps_luminance_and_fits(r in -1f32..3.0, g in -1f32..3.0, b in -1f32..3.0) {
            let y = luminance([r, g, b]);
            let out = one([r, g, b], Limit::Unit);
            prop_assert!(out.iter().all(|x| (0.0..=1.0).contains(x)));
            prop_assert!((luminance(out) - y.clamp(0.0, 1.0)).abs() < 2e-6);
        }

        #[test]
        fn what_sticks_out_by_rounding_fits(r in 0.1f32..0.9, g in 0.1f32..0.9, tiny in 1e-12f32..1e-6) {
            let out = one([r, g, -tiny], Limit::Unit);
            prop_assert!(out.iter().all(|x| (0.0..=1.0).contains(x)), "{out:?}");
        }

        #[test]
        fn colours_inside_are_untouched(r in 0f32..=1.0, g in 0f32..=1.0, b in 0f32..=1.0) {
            prop_assert_eq!(one([r, g, b], Limit::Unit), [r, g, b]);
        }
    }
}
