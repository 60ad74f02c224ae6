//! The CIE standard general skies [CIE S 011] (ISO 15469): 15 distributions of relative luminance, from overcast to turbid.
//!
//! L / Lz = f(chi) phi(Z) / (f(Zs) phi(0)), with Z the angle from the zenith, chi the angle from the sun, Zs the sun's from
//! the zenith, phi(Z) = 1 + a exp(b / cos Z), f(chi) = 1 + c (exp(d chi) - exp(d pi/2)) + e cos^2 chi. The sun's disc is no
//! part of it. The standard says nothing of colour, nor how bright the zenith is: give one, or divide a measured
//! illuminance by [`CieSky::horizontal`].

use std::f64::consts::{FRAC_PI_2, TAU};

use super::{angle, unit};
use crate::{Result, invalid};

/// Parameters a..e of the types, in their order.
const TABLE: &str = include_str!("../../spectra/tables/cie_general_skies.csv");
/// Circles of the quadrature, each with four times as many points on its azimuths.
const CIRCLES: usize = 256;

/// A sky of one of the 15 types over a place where the sun stands in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct CieSky {
    /// a, b of the gradation, c, d, e of the indicatrix.
    parameters: [f64; 5],
    sun: [f64; 3],
    /// f(Zs) phi(0)
    zenith: f64,
}

impl CieSky {
    /// Type 1 to 15, and the direction to the sun (also where the type does not depend on it), on or above the horizon.
    pub fn new(kind: u32, sun: [f64; 3]) -> Result<CieSky> {
        let row = TABLE.lines().find_map(|line| line.strip_prefix(&format!("{kind},")));
        let numbers: Vec<f64> = row.unwrap_or_default().split(',').filter_map(|n| n.parse().ok()).collect();
        let Ok(parameters) = <[f64; 5]>::try_from(numbers) else {
            return invalid!("a CIE general sky is of type 1 to 15, got {kind}");
        };
        let sun = unit("the sun", sun)?;
        if sun[2] < 0.0 {
            return invalid!("the sun must be above the horizon, got {:.3} degrees", sun[2].asin().to_degrees());
        }
        let mut sky = CieSky { parameters, sun, zenith: 1.0 };
        sky.zenith = sky.indicatrix(angle(sun, [0.0, 0.0, 1.0])) * sky.gradation(1.0);
        Ok(sky)
    }

    fn gradation(&self, cos_z: f64) -> f64 {
        let [a, b, ..] = self.parameters;
        1.0 + a * (b / cos_z).exp()
    }

    fn indicatrix(&self, chi: f64) -> f64 {
        let [_, _, c, d, e] = self.parameters;
        1.0 + c * ((d * chi).exp() - (d * FRAC_PI_2).exp()) + e * chi.cos().powi(2)
    }

    /// Luminance in a direction (a unit vector) over that of the zenith; 0 below the horizon.
    ///
    /// ```
    /// use luxpipe::sky::{CieSky, direction};
    /// let overcast = CieSky::new(1, direction(60.0, 0.0)).unwrap();
    /// assert!((overcast.relative(direction(90.0, 0.0)) - 1.0).abs() < 1e-12);
    /// // at the horizon: 1 / (1 + 4 exp(-0.7))
    /// assert!((overcast.relative(direction(1e-9, 0.0)) - 0.334858).abs() < 1e-6);
    /// ```
    pub fn relative(&self, direction: [f64; 3]) -> f64 {
        if direction[2] < 0.0 {
            return 0.0;
        }
        self.indicatrix(angle(direction, self.sun)) * self.gradation(direction[2].max(f64::MIN_POSITIVE)) / self.zenith
    }

    /// Diffuse illuminance of a horizontal surface over the luminance of the zenith, steradians: pi for a uniform sky.
    ///
    /// Midpoints on the projected hemisphere, where cos Z dw is an area: within 1e-4 for all types.
    pub fn horizontal(&self) -> f64 {
        let circle = |i: usize| {
            let (low, high) = (i as f64 / CIRCLES as f64, (i + 1) as f64 / CIRCLES as f64);
            let radius = 0.5 * (low + high);
            let up = (1.0 - radius * radius).sqrt();
            let around = 4 * CIRCLES;
            let sum: f64 = (0..around)
                .map(|j| {
                    let (s, c) = (TAU * (j as f64 + 0.5) / around as f64).sin_cos();
                    self.relative([radius * c, radius * s, up])
                })
                .sum();
            0.5 * TAU * (high * high - low * low) * sum / around as f64
        };
        (0..CIRCLES).map(circle).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::direction;
    use std::f64::consts::PI;

    /// The standard's formula integrated by an independent program (converged quadrature, six digits), sun at 60 degrees.
    const HORIZONTAL: [f64; 15] = [
        2.44954, 2.08602, 2.76999, 2.31542, PI, 2.58416, 2.42123, 2.32838, 3.45932, 3.17026, 2.98906, 3.19057, 3.02585,
        3.21696, 3.01586,
    ];

    #[test]
    fn horizontal_illuminance_of_all_types() {
        for (kind, want) in (1..).zip(HORIZONTAL) {
            let got = CieSky::new(kind, direction(60.0, 25.0)).unwrap().horizontal();
            assert!((got / want - 1.0).abs() < 1e-4, "type {kind}: {got} {want}");
        }
    }

    /// Without an indicatrix E / Lz = pi (1 + 2 a E3(-b)) / (1 + a exp b), E3 the exponential integral by its series.
    #[test]
    fn azimuthally_uniform_types_meet_the_closed_form() {
        let e3 = |x: f64| {
            let mut term = 1.0;
            let series: f64 = (1..40)
                .map(|k| {
                    term *= -x / f64::from(k);
                    term / f64::from(k)
                })
                .sum();
            let e1 = -0.577_215_664_901_532_9 - x.ln() - series;
            0.5 * ((-x).exp() * (1.0 - x) + x * x * e1)
        };
        for (kind, a, b) in [(1, 4.0, -0.7), (3, 1.1, -0.8), (5, 0.0, -1.0)] {
            let want = PI * (1.0 + 2.0 * a * e3(-b)) / (1.0 + a * f64::exp(b));
            let got = CieSky::new(kind, direction(20.0, 0.0)).unwrap().horizontal();
            assert!((got / want - 1.0).abs() < 2e-5, "type {kind}: {got} {want}");
        }
    }

    #[test]
    fn brightest_at_the_sun_and_black_below() {
        let sun = direction(40.0, 70.0);
        for kind in 12..=15 {
            let sky = CieSky::new(kind, sun).unwrap();
            let at_sun = sky.relative(sun);
            assert!((0..1000).all(|i| sky.relative(direction(40.0, f64::from(i) * 0.36)) <= at_sun));
            assert_eq!(sky.relative(direction(-0.1, 70.0)), 0.0);
            assert!(sky.relative([1.0, 0.0, 0.0]).is_finite());
        }
    }

    #[test]
    fn other_types_and_a_sun_below_are_refused() {
        for (kind, sun) in
            [(0, [0.0, 0.0, 1.0]), (16, [0.0, 0.0, 1.0]), (1, [1.0, 0.0, -0.1]), (1, [0.0; 3]), (1, [f64::NAN; 3])]
        {
            assert!(CieSky::new(kind, sun).is_err(), "{kind} {sun:?}");
        }
    }
}
