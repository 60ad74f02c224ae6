//! What counts as contrast: ratios of luminance, or steps of visibility. A map that adds none has slope 1 or less on such a
//! scale, and one that shifts by a constant keeps all.

use crate::tone::threshold::{Count, Steps};

/// A rising function of ln L.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// ln L itself: a shift is an exposure.
    Ratio,
    /// Thresholds of the eye: of the world's side (perhaps adapted to a brighter place) and of the display's.
    Visibility {
        /// Steps of the world.
        world: Box<Steps>,
        /// Steps of the display.
        display: Box<Steps>,
    },
}

impl Scale {
    /// Threshold steps for eyes that come from `adapted_cd_m2` (0: rested).
    pub fn visibility(count: Count, adapted_cd_m2: f64) -> Scale {
        let display = Box::new(Steps::new(count, 0.0));
        let world = if adapted_cd_m2 > 0.0 { Box::new(Steps::new(count, adapted_cd_m2)) } else { display.clone() };
        Scale::Visibility { world, display }
    }

    /// The world's threshold at a luminance, cd/m2; 0 where contrast is a ratio.
    pub fn threshold_cd_m2(&self, luminance_cd_m2: f64) -> f64 {
        match self {
            Scale::Ratio => 0.0,
            Scale::Visibility { world, .. } => world.threshold_cd_m2(luminance_cd_m2),
        }
    }

    /// A world luminance on the scale.
    pub fn world(&self, ln_luminance: f64) -> f64 {
        match self {
            Scale::Ratio => ln_luminance,
            Scale::Visibility { world, .. } => world.of(ln_luminance),
        }
    }

    /// The world's ln L at a place on the scale.
    pub fn world_ln(&self, place: f64) -> f64 {
        match self {
            Scale::Ratio => place,
            Scale::Visibility { world, .. } => world.ln_luminance(place),
        }
    }

    /// A display luminance on the scale.
    pub fn display(&self, ln_luminance: f64) -> f64 {
        match self {
            Scale::Ratio => ln_luminance,
            Scale::Visibility { display, .. } => display.of(ln_luminance),
        }
    }

    /// The display's ln L at a place on the scale.
    pub fn display_ln(&self, place: f64) -> f64 {
        match self {
            Scale::Ratio => place,
            Scale::Visibility { display, .. } => display.ln_luminance(place),
        }
    }
}
