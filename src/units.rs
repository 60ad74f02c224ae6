//! Constants that carry units, each with its source.

/// Luminous efficacy of monochromatic radiation at 540 THz, lm/W (SI brochure; 683 as the paper's time used it, where
/// 683.002 at 555 nm is the modern rounding of the same definition).
pub const K_M: f64 = 683.0;

/// Radiance's "white efficacy", lm/W: luminance = 179 x (weighted RGB radiance in W/sr/m2) [Radiance `color.h`].
pub const RADIANCE_EFFICACY: f64 = 179.0;

/// Integral of the CIE 1931 luminosity function over wavelength, nm (1 nm table, 360-830 nm).
pub const YBAR_INTEGRAL_NM: f64 = 106.857;

/// Radiance's hyperspectral files hold a band value c with L = c x 179 / (683 x 106.857) W/sr/m2/nm: an equal spectrum of
/// c then has the luminance 179 c that a grey RGB of c has.
///
/// ```
/// assert!((1.0 / luxpipe::units::RADIANCE_BAND - 407.73).abs() < 0.01);
/// ```
pub const RADIANCE_BAND: f64 = RADIANCE_EFFICACY / (K_M * YBAR_INTEGRAL_NM);

/// Second radiation constant h c / k, m K (CODATA 2018).
pub const C2_M_K: f64 = 1.438_776_877e-2;

/// First radiation constant for radiance 2 h c^2, W m2 / sr (CODATA 2018).
pub const C1L_W_M2_SR: f64 = 1.191_042_972e-16;
