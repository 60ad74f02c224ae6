//! luxpipe takes light from a scene description to a display in small Unix filters, with its colours right.
//!
//! Modules in reading order; each imports only from those before it.
//!
//! | module | holds |
//! |---|---|
//! | [`error`], [`units`], [`notes`], [`simd`], [`parallel`], [`statistics`], [`json`] | what everything needs |
//! | [`spectral`] | spectra, observers, light sources, sampling |
//! | [`color`] | chromaticities, primaries, adaptation, gamut |
//! | [`compare`] | how far two pictures lie apart |
//! | [`stream`] | the picture that flows between filters |
//! | [`options`], [`keys`] | options as data, TOML tables |
//! | [`display`] | what a medium can show, and its curve |
//! | [`codec`] | file formats other than the stream's own |
//! | [`tone`] | from world luminance to the display's |
//! | [`plot`] | charts as SVG and PNG |
//! | [`scene`] | scenes as TOML, shapes, materials, lights, cameras |
//! | [`render`] | Eq. (1) by path tracing |
//! | [`filter`], [`filters`] | what a filter is, and the filters |
//! | [`pipeline`], [`cli`] | filters chained in one process; command lines |
//!
//! Units: wavelengths in nm; spectral radiance in W/sr/m2/nm; XYZ and luminance in cd/m2; scenes in metres unless they say
//! otherwise. Names carry the unit where two could be confused (`luminance_cd_m2`, `lambda_nm`).
//!
//! Bibliography, by the keys used in comments:
//! - [Ward 2001] G. Ward, *High Dynamic Range Imaging*, IS&T/SID 9th Color Imaging Conference, 2001. "The paper".
//! - [Ward 1991] G. Ward, *Real Pixels*, Graphics Gems II, 1991.
//! - [Ward 1997] G. Ward Larson, H. Rushmeier, C. Piatko, *A Visibility Matching Tone Reproduction Operator for High Dynamic
//!   Range Scenes*, IEEE TVCG 3(4), 1997.
//! - [Larson 1998] G. Ward Larson, *The LogLuv Encoding for Full Gamut, High Dynamic Range Images*, Journal of Graphics Tools
//!   3(1), 1998; as libtiff has it (`tif_luv.c`, `uvcode.h`).
//! - [Steele 2014] G. Steele, D. Lea, C. Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014.
//! - [CIE15] CIE 015, *Colorimetry*.
//! - [Kajiya 1986] J. Kajiya, *The Rendering Equation*, SIGGRAPH 86.
//! - [Veach 1997] E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, Stanford, 1997.
//! - [Arvo 1995] J. Arvo, *Stratified Sampling of Spherical Triangles*, SIGGRAPH 95.
//! - [Urena 2013] C. Urena, M. Fajardo, A. King, *An Area-Preserving Parametrization for Spherical Rectangles*, EGSR 2013.
//! - [Burley 2020] B. Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4), 2020.
//! - [Sharma 2005] G. Sharma, W. Wu, E. Dalal, *The CIEDE2000 Color-Difference Formula*, Color Res. Appl. 30(1), 2005.
//! - [Okabe 2008] M. Okabe, K. Ito, *Color Universal Design: how to make figures and presentations that are friendly to colorblind
//!   people*, 2008.
//! - [Liang 1984] Y. Liang, B. Barsky, *A New Concept and Method for Line Clipping*, ACM Transactions on Graphics 3(1), 1984.
//! - [Ottosson 2020] B. Ottosson, *A perceptual color space for image processing*, 2020.
//! - [Li 2000] C. Li, M. R. Luo, B. Rigg, *Simplification of the CMCCAT97*, IS&T/SID 8th Color Imaging Conference, 2000.
//! - [Mantiuk 2021] R. Mantiuk, M. Azimi, *PU21: A novel perceptually uniform encoding for adapting existing quality metrics
//!   for HDR*, Picture Coding Symposium 2021; parameters from the authors' github.com/gfxdisp/pu21.
//! - [Waechter 2019] C. Waechter, N. Binder, *A Fast and Robust Method for Avoiding Self-Intersection*, Ray Tracing Gems, 2019.

pub mod cli;
pub mod codec;
pub mod color;
pub mod compare;
pub mod display;
pub mod error;
pub mod filter;
pub mod filters;
pub mod json;
pub mod keys;
pub mod notes;
pub mod options;
pub mod parallel;
pub mod pipeline;
pub mod plot;
pub mod render;
pub mod scene;
pub mod simd;
pub mod spectral;
pub mod statistics;
pub mod stream;
pub mod tone;
pub mod units;

pub use error::{Error, Result};

/// Serde by way of `Display` and `FromStr`: a value has one spelling on the command line, in TOML and in a history line.
/// A bare TOML number is taken as its text, an array of numbers as that text with commas.
#[macro_export]
macro_rules! string_serde {
    ($type:ty) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.collect_str(self)
            }
        }
        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                let text = $crate::options::Scalar::deserialize(d)?.to_string();
                text.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}
