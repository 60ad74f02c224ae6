//! Tone mapping: from the luminances of a world to those of a display. Knows nothing of rays or files.
//!
//! [`fovea`] looks at the picture, [`histogram`] counts its luminances; [`adjust`], [`visible`], [`print`](mod@print) and
//! [`faithful`] are rules that make a [`Curve`] of them, one for each goal; [`veil`], [`acuity`] and [`mesopic`] are what the
//! eye does to the light first. [`local`] goes its own way, place by place.

pub mod acuity;
pub mod adjust;
pub mod classic;
pub mod curve;
pub mod faithful;
pub mod fovea;
pub mod histogram;
pub mod local;
pub mod mesopic;
pub mod palette;
pub mod print;
pub mod scale;
pub mod threshold;
pub mod veil;
pub mod visible;

pub use curve::Curve;
pub use histogram::Histogram;
pub use scale::Scale;

/// Contrast of a display that counts beside its own white: the eye's glare hides what is darker.
const SEEN_AT_ONCE: f64 = 1000.0;

/// The display's range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Luminance of white, cd/m2.
    pub max_cd_m2: f64,
    /// Luminance of black, cd/m2, above 0.
    pub min_cd_m2: f64,
}

impl Display {
    /// ln of black and white.
    pub fn ln(&self) -> (f64, f64) {
        (self.min_cd_m2.ln(), self.max_cd_m2.ln())
    }

    /// What is seen of it at once: all of it, or the three decades below white where it has more.
    ///
    /// ```
    /// use luxpipe::tone::Display;
    /// assert_eq!(Display { max_cd_m2: 1000.0, min_cd_m2: 0.005 }.seen().min_cd_m2, 1.0);
    /// assert_eq!(Display { max_cd_m2: 100.0, min_cd_m2: 1.0 }.seen().min_cd_m2, 1.0);
    /// ```
    pub fn seen(self) -> Display {
        Display { min_cd_m2: self.min_cd_m2.max(self.max_cd_m2 / SEEN_AT_ONCE), ..self }
    }

    /// The luminance in the middle of its range, by ratio.
    pub fn middle_cd_m2(&self) -> f64 {
        (self.min_cd_m2 * self.max_cd_m2).sqrt()
    }
}
