//! Thermal radiators and daylight [CIE15].

use super::{Spectrum, builtin};
use crate::units::{C1L_W_M2_SR, C2_M_K};
use crate::{Result, invalid};

/// Spectral radiance of a blackbody, W/sr/m2/nm, every nm from 250 to 2500 nm.
///
/// ```
/// let s = luxpipe::spectral::planck::blackbody(2856.0).unwrap();
/// assert!((s.at(560.0) - 268.008).abs() < 0.001);
/// ```
pub fn blackbody(kelvin: f64) -> Result<Spectrum> {
    if !(100.0..=1e6).contains(&kelvin) {
        return invalid!("a blackbody's temperature must be 100 to 1000000 K, got {kelvin}");
    }
    let radiance = |nm: f64| {
        let m = nm * 1e-9;
        C1L_W_M2_SR / m.powi(5) / ((C2_M_K / (m * kelvin)).exp() - 1.0) * 1e-9
    };
    Spectrum::from_points((250..=2500).map(|nm| (nm as f64, radiance(nm as f64))).collect())
}

/// Radiance of a blackbody over all wavelengths, W/sr/m2: sigma T^4 / pi (Stefan and Boltzmann).
///
/// ```
/// assert!((luxpipe::spectral::planck::total_radiance(2856.0) / 1.2009e6 - 1.0).abs() < 1e-4);
/// ```
pub fn total_radiance(kelvin: f64) -> f64 {
    5.670_374_419e-8 * kelvin.powi(4) / std::f64::consts::PI
}

/// CIE daylight of a correlated colour temperature of 4000 to 25000 K, relative (100 at 560 nm).
///
/// The locus is the CIE's cubic in 1000/T; T is on the scale of c2 = 1.438e-2 m K on which the D illuminants stand
/// (D65 is 6504 K).
pub fn daylight(kelvin: f64) -> Result<Spectrum> {
    if !(4000.0..=25000.0).contains(&kelvin) {
        return invalid!("daylight is defined from 4000 to 25000 K, got {kelvin}");
    }
    let (x, y) = daylight_xy(kelvin);
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m;
    let m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
    let s = [builtin::spectrum("daylight_S0")?, builtin::spectrum("daylight_S1")?, builtin::spectrum("daylight_S2")?];
    let Spectrum::Table(grid) = &s[0] else { return invalid!("daylight_S0 is not a table") };
    Spectrum::from_points(grid.iter().map(|(nm, s0)| (*nm, s0 + m1 * s[1].at(*nm) + m2 * s[2].at(*nm))).collect())
}

/// Chromaticity of the daylight locus.
///
/// ```
/// let (x, y) = luxpipe::spectral::planck::daylight_xy(6504.0);
/// assert!((x - 0.3127).abs() < 1e-4 && (y - 0.3291).abs() < 1e-4);
/// ```
pub fn daylight_xy(kelvin: f64) -> (f64, f64) {
    let t = 1000.0 / kelvin;
    let x = if kelvin <= 7000.0 {
        0.244063 + 0.09911 * t + 2.9678 * t * t - 4.6070 * t.powi(3)
    } else {
        0.237040 + 0.24748 * t + 1.9018 * t * t - 2.0064 * t.powi(3)
    };
    (x, -3.0 * x * x + 2.870 * x - 0.275)
}
