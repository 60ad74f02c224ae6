//! PU21, a perceptually uniform encoding of luminance, under which measures made for display values serve for HDR
//! [Mantiuk 2021]: the variant `banding_glare`, which the authors recommend.

/// Luminances the encoding is fitted to, cd/m2.
pub const RANGE: [f64; 2] = [0.005, 10_000.0];

/// What stands for the peak in a PSNR of encoded luminance, as in the authors' `pu21_metric.m`: the code of 100 cd/m2.
pub const PEAK: f64 = 256.0;

/// p1 to p7 of `banding_glare`.
const P: [f64; 7] =
    [0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166, 0.9099517204, 596.3148142];

/// The code of a luminance in cd/m2, which must lie in [`RANGE`]: 0 at 0.005, about 256 at 100, 595.39 at 10000.
///
/// ```
/// use luxpipe::color::pu21::encode;
/// // The ends as VQEG's siti-tools list them, and the authors' anchor.
/// assert!(encode(0.005).abs() < 1e-6);
/// assert!((encode(10_000.0) - 595.3939).abs() < 1e-4);
/// assert!((encode(100.0) - 256.0).abs() < 1.0);
/// ```
pub fn encode(cd_m2: f64) -> f64 {
    let power = cd_m2.powf(P[3]);
    P[6] * (((P[0] + P[1] * power) / (1.0 + P[2] * power)).powf(P[4]) - P[5])
}
