//! A clear sky from the sun's place and the turbidity [Preetham 1999]: luminance and chromaticity by Perez's five-parameter
//! distribution, spectra by the CIE daylight components.
//!
//! Each of Y, x, y is Q(Z, g) = Qz F(Z, g) / F(0, Zs), F = (1 + A exp(B / cos Z)) (1 + C exp(D g) + E cos^2 g), with Z the
//! angle from the zenith, g from the sun, Zs the sun's from the zenith; A..E and Qz are polynomials of the turbidity T and Zs
//! (spectra/tables/preetham_sky.csv). The spectrum is c0 S0 + c1 S1 + c2 S2 with the c that have that Y, x and y under the
//! CIE 1931 observer exactly: the paper's M1 = c1 / c0 and M2 = c2 / c0 solved for instead of taken from the CIE's rounded
//! formulas.
//!
//! With the sun 20 degrees up or more and T up to 6 that sum is positive over the visible; lower suns have yellows near the
//! horizon that no mixture of the components makes without negative light, which [`ClearSky::spectrum`] cuts off.
//!
//! What it is good for: T from 2 (clear) over 3 (a common fair day) to 6 (haze), the sun well above the horizon. The range
//! of atmospheres it represents well is smaller than that of its parameters [Zotti 2007], and sunsets and high turbidity are
//! its known weak points [Hosek 2012]. Turbidities beyond 2 to 10 are refused, for there the formulas soon turn negative (the
//! gradation at the zenith below 1.6, the zenith's luminance under a sun on the horizon above 11.2), as is a sun below the
//! horizon. The ground does not light it, and the sun's disc is no part of it: [`super::beam`].

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use super::{angle, unit};
use crate::color::{Mat3, Xy};
use crate::spectral::{Observer, Spectrum, builtin};
use crate::units::K_M;
use crate::{Error, Result, invalid};

/// Turbidities that the model takes.
pub const TURBIDITY: RangeInclusive<f64> = 2.0..=10.0;

/// The polynomials' coefficients by name.
const TABLE: &str = include_str!("../../spectra/tables/preetham_sky.csv");

/// A clear sky.
#[derive(Clone, Debug)]
pub struct ClearSky {
    sun: [f64; 3],
    /// A..E of Y, x, y.
    perez: [[f64; 5]; 3],
    /// Qz / F(0, Zs) of Y (cd/m2), x, y.
    scale: [f64; 3],
    /// XYZ in cd/m2 to the coefficients.
    to_basis: Mat3,
    basis: [Spectrum; 3],
    photopic: Spectrum,
}

impl ClearSky {
    /// The sky with the sun in a direction on or above the horizon, at a turbidity of 2 to 10.
    pub fn new(sun: [f64; 3], turbidity: f64) -> Result<ClearSky> {
        let sun = unit("the sun", sun)?;
        if sun[2] < 0.0 {
            return invalid!("the sun must be above the horizon, got {:.3} degrees", sun[2].asin().to_degrees());
        }
        if !TURBIDITY.contains(&turbidity) {
            return invalid!("turbidity must be {} to {}, got {turbidity}", TURBIDITY.start(), TURBIDITY.end());
        }
        let theta = angle(sun, [0.0, 0.0, 1.0]);
        let mut perez = [[0.0; 5]; 3];
        for (q, parameters) in ["Y", "x", "y"].into_iter().zip(&mut perez) {
            for (p, value) in ["A", "B", "C", "D", "E"].into_iter().zip(parameters) {
                let [slope, constant, ..] = coefficients(&format!("perez_{q}_{p}"))?;
                *value = slope * turbidity + constant;
            }
        }
        let zenith =
            [zenith_luminance(theta, turbidity)?, zenith_xy("x", theta, turbidity)?, zenith_xy("y", theta, turbidity)?];
        let scale = std::array::from_fn(|i| zenith[i] / distribution(&perez[i], 1.0, theta));
        let basis =
            [builtin::spectrum("daylight_S0")?, builtin::spectrum("daylight_S1")?, builtin::spectrum("daylight_S2")?];
        let observer = Observer::cie1931()?;
        let columns = basis.each_ref().map(|s| observer.integrate(s).map(|v| v * K_M));
        let to_xyz = Mat3(std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row])));
        let to_basis =
            to_xyz.inverse().ok_or_else(|| Error::Invalid("the daylight components have no inverse".into()))?;
        let [_, photopic, _] = observer.cmf;
        Ok(ClearSky { sun, perez, scale, to_basis, basis, photopic })
    }

    /// Luminance in cd/m2 and chromaticity in a direction (a unit vector); `None` below the horizon.
    pub fn luminance_xy(&self, direction: [f64; 3]) -> Option<(f64, Xy)> {
        if direction[2] < 0.0 {
            return None;
        }
        let gamma = angle(direction, self.sun);
        let cos_z = direction[2].max(f64::MIN_POSITIVE);
        let [y_cd_m2, x, y] = std::array::from_fn(|i| self.scale[i] * distribution(&self.perez[i], cos_z, gamma));
        Some((y_cd_m2, Xy { x, y }))
    }

    /// XYZ in cd/m2 in a direction; black below the horizon.
    pub fn xyz(&self, direction: [f64; 3]) -> [f64; 3] {
        self.luminance_xy(direction).map_or([0.0; 3], |(luminance, xy)| xy.xyz().map(|v| v * luminance))
    }

    /// The spectral radiance in a direction as multiples of [`ClearSky::basis`], W/sr/m2/nm; zeros below the horizon. The sum
    /// may be negative at some wavelengths: [`ClearSky::spectrum`] is not.
    ///
    /// ```
    /// use luxpipe::sky::{ClearSky, direction};
    /// use luxpipe::spectral::Observer;
    /// let sky = ClearSky::new(direction(45.0, 0.0), 3.0).unwrap();
    /// let d = direction(60.0, 90.0);
    /// let c = sky.coefficients(d);
    /// let observer = Observer::cie1931().unwrap();
    /// let y: f64 = c.iter().zip(sky.basis()).map(|(c, s)| c * 683.0 * observer.integrate(s)[1]).sum();
    /// assert!((y / sky.xyz(d)[1] - 1.0).abs() < 1e-12);
    /// ```
    pub fn coefficients(&self, direction: [f64; 3]) -> [f64; 3] {
        self.to_basis.apply(self.xyz(direction))
    }

    /// Spectral radiance in a direction, W/sr/m2/nm from 300 to 830 nm: as the coefficients say where that is positive, 0
    /// elsewhere, and scaled to the luminance again. Where the sun stands low, yellows beyond daylight's need it.
    pub fn spectrum(&self, direction: [f64; 3]) -> Result<Spectrum> {
        let c = self.coefficients(direction);
        let luminance = self.xyz(direction)[1];
        let Spectrum::Table(grid) = &self.basis[0] else { return invalid!("daylight_S0 is not a table") };
        let value = |nm: f64| (0..3).map(|i| c[i] * self.basis[i].at(nm)).sum::<f64>().max(0.0);
        let kept = Spectrum::from_points(grid.iter().map(|(nm, _)| (*nm, value(*nm))).collect())?;
        let got = K_M * self.photopic.product_integral(&kept, 0.0, f64::INFINITY);
        Ok(if got > 0.0 { kept.scaled(luminance / got) } else { kept })
    }

    /// The CIE daylight components S0, S1, S2, 300 to 830 nm.
    pub fn basis(&self) -> &[Spectrum; 3] {
        &self.basis
    }
}

/// F(Z, g).
fn distribution(&[a, b, c, d, e]: &[f64; 5], cos_z: f64, gamma: f64) -> f64 {
    (1.0 + a * (b / cos_z).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
}

/// Luminance of the zenith, cd/m2, for the sun's zenith angle in radians.
fn zenith_luminance(theta: f64, turbidity: f64) -> Result<f64> {
    let [a, b, c, d] = coefficients("zenith_Y")?;
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * theta);
    Ok(1000.0 * ((a * turbidity + b) * chi.tan() + c * turbidity + d))
}

/// A chromaticity coordinate of the zenith.
fn zenith_xy(axis: &str, theta: f64, turbidity: f64) -> Result<f64> {
    let power = |n: u32| -> Result<f64> {
        let row = coefficients(&format!("zenith_{axis}_{n}"))?;
        Ok(row.iter().fold(0.0, |sum, c| sum * theta + c))
    };
    Ok((power(2)? * turbidity + power(1)?) * turbidity + power(0)?)
}

/// One row of the table.
fn coefficients(name: &str) -> Result<[f64; 4]> {
    let row = TABLE.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(','));
    let numbers: Vec<f64> = row.unwrap_or_default().split(',').filter_map(|n| n.parse().ok()).collect();
    numbers.try_into().map_err(|_| Error::Invalid(format!("preetham_sky.csv: {name} needs four numbers")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::direction;

    fn skies() -> impl Iterator<Item = (f64, f64, ClearSky)> {
        let turbidities = [2.0, 3.0, 4.0, 6.0, 8.0, 10.0];
        let all = turbidities.into_iter().flat_map(|t| [0.0, 5.0, 15.0, 30.0, 60.0, 90.0].map(|e| (e, t)));
        all.map(|(e, t)| (e, t, ClearSky::new(direction(e, 0.0), t).unwrap()))
    }

    fn directions() -> impl Iterator<Item = [f64; 3]> {
        (0..=30).flat_map(|i| (0..24).map(move |j| direction(f64::from(i) * 3.0, f64::from(j) * 15.0)))
    }

    /// The paper's formulas at T = 3, Zs = 45 degrees worked by hand: chi = (4/9 - 1/40) 90 degrees = 37.75 degrees.
    #[test]
    fn the_zenith_by_hand() {
        let sky = ClearSky::new(direction(45.0, 123.0), 3.0).unwrap();
        let (luminance, xy) = sky.luminance_xy([0.0, 0.0, 1.0]).unwrap();
        let want = 1000.0 * ((4.0453 * 3.0 - 4.9710) * 37.75f64.to_radians().tan() - 0.2155 * 3.0 + 2.4192);
        assert!((luminance / want - 1.0).abs() < 1e-12, "{luminance} {want}");
        let (t1, t2, t3) = (PI / 4.0, 0.616850, 0.484473);
        let x = 9.0 * (0.00166 * t3 - 0.00375 * t2 + 0.00209 * t1)
            + 3.0 * (-0.02903 * t3 + 0.06377 * t2 - 0.03202 * t1 + 0.00394)
            + (0.11693 * t3 - 0.21196 * t2 + 0.06052 * t1 + 0.25886);
        let y = 9.0 * (0.00275 * t3 - 0.00610 * t2 + 0.00317 * t1)
            + 3.0 * (-0.04214 * t3 + 0.08970 * t2 - 0.04153 * t1 + 0.00516)
            + (0.15346 * t3 - 0.26756 * t2 + 0.06670 * t1 + 0.26688);
        assert!((xy.x - x).abs() < 1e-6 && (xy.y - y).abs() < 1e-6, "{xy} {x} {y}");
    }

    /// Everywhere in the domain the luminance is positive and the colour one of daylight.
    #[test]
    fn the_whole_domain_is_physical() {
        for (elevation, turbidity, sky) in skies() {
            for d in directions() {
                let (luminance, xy) = sky.luminance_xy(d).unwrap();
                assert!(luminance > 0.0 && luminance < 2e6, "{elevation} {turbidity} {d:?}: {luminance}");
                assert!(xy.x > 0.2 && xy.x < 0.5 && xy.y > 0.2 && xy.y < 0.5, "{elevation} {turbidity} {d:?}: {xy}");
            }
        }
    }

    /// Coefficients give back luminance and chromaticity, and agree with the CIE's M1 and M2 to their rounding.
    #[test]
    fn spectra_have_the_luminance_and_the_colour() {
        let observer = Observer::cie1931().unwrap();
        for (_, _, sky) in skies() {
            let integrals = sky.basis().each_ref().map(|s| observer.integrate(s));
            for d in directions().step_by(7) {
                let c = sky.coefficients(d);
                let (luminance, xy) = sky.luminance_xy(d).unwrap();
                let xyz: [f64; 3] = std::array::from_fn(|k| K_M * (0..3).map(|i| c[i] * integrals[i][k]).sum::<f64>());
                assert!((xyz[1] / luminance - 1.0).abs() < 1e-11);
                assert!(Xy::of(xyz).unwrap().distance(xy) < 1e-11);
                let m = 0.0241 + 0.2562 * xy.x - 0.7341 * xy.y;
                let m1 = (-1.3515 - 1.7703 * xy.x + 5.9114 * xy.y) / m;
                let m2 = (0.0300 - 31.4424 * xy.x + 30.0717 * xy.y) / m;
                let rounded: [f64; 3] =
                    std::array::from_fn(|k| integrals[0][k] + m1 * integrals[1][k] + m2 * integrals[2][k]);
                let off = Xy::of(rounded).unwrap().distance(xy);
                assert!(off < 5e-4, "{xy}: {off}");
            }
        }
    }

    /// Spectra are not negative and keep the luminance; with the sun 20 degrees up or more, and a turbidity of 6 or less, they
    /// keep the colour too, for the components need no cutting in the visible.
    #[test]
    fn spectra_are_not_negative() {
        let observer = Observer::cie1931().unwrap();
        let high = [2.0, 3.0, 4.0, 5.0, 6.0].into_iter().flat_map(|t| [20.0, 25.0, 40.0, 75.0].map(|e| (e, t)));
        let high = high.map(|(e, t)| (e, t, ClearSky::new(direction(e, 0.0), t).unwrap()));
        for (elevation, turbidity, sky) in skies().chain(high) {
            for d in directions().step_by(19) {
                let s = sky.spectrum(d).unwrap();
                let (luminance, xy) = sky.luminance_xy(d).unwrap();
                let xyz = observer.integrate(&s).map(|v| K_M * v);
                assert!(s.range().0 >= 0.0 && (xyz[1] / luminance - 1.0).abs() < 1e-11);
                let off = Xy::of(xyz).unwrap().distance(xy);
                let exact = elevation >= 20.0 && turbidity <= 6.0;
                assert!(!exact || off < 1e-11, "{elevation} {turbidity} {d:?}: {off}");
            }
        }
        assert_eq!(skies().next().unwrap().2.spectrum([0.0, 0.6, -0.8]).unwrap().range(), (0.0, 0.0));
    }

    #[test]
    fn outside_the_domain() {
        let up = [0.0, 0.0, 1.0];
        for (sun, turbidity) in [(up, 1.9), (up, 10.1), (up, f64::NAN), (direction(-0.1, 0.0), 3.0), ([0.0; 3], 3.0)] {
            assert!(ClearSky::new(sun, turbidity).is_err());
        }
        let sky = ClearSky::new(up, 3.0).unwrap();
        assert_eq!(sky.coefficients([0.6, 0.0, -0.8]), [0.0; 3]);
        assert!(sky.coefficients([1.0, 0.0, 0.0]).iter().all(|c| c.is_finite()));
    }
}
