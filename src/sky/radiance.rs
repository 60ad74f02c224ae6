//! The skies of Radiance's `gensky` and `gendaylit`: the brightness functions of `skybright.cal` and `perezlum.cal`, term by term, so
//! that a sky described for Radiance is the same one here. Values are W/sr/m2 in Radiance's sense: 179 lm/W makes them cd/m2.
//!
//! | function | is |
//! |---|---|
//! | `skybr` 1 | the CIE clear sky of 1973, Kittler's |
//! | `skybr` 2, 3 | the CIE overcast sky of Moon and Spencer, (1 + 2 sin h) / 3; a uniform one |
//! | `skybr` 4 | the intermediate sky of Matsuura |
//! | `skybright` | the all-weather sky of Perez and others (1993), five coefficients |
//!
//! Near the horizon, within half a degree, either goes over to the brightness of the ground.

use std::f64::consts::FRAC_PI_2;

use super::unit;
use crate::{Result, invalid};

/// Radiance's own zenith.
const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// What is above the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Above {
    Clear { zenith: f64, normalization: f64 },
    Overcast { zenith: f64 },
    Uniform { zenith: f64 },
    Intermediate { zenith: f64, normalization: f64 },
    Perez { diffuse: f64, coefficients: [f64; 5] },
}

/// A sky with its ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceSky {
    above: Above,
    ground: f64,
    /// As it was given: Radiance does not make it a unit vector again.
    sun: [f64; 3],
    zenith: [f64; 3],
}

impl RadianceSky {
    /// The real arguments of `skybr` of `skybright.cal`: the type 1 to 4, brightness of zenith and ground, and for types 1 and 4 the
    /// normalization and the direction to the sun.
    ///
    /// ```
    /// use luxpipe::sky::RadianceSky;
    /// let overcast = RadianceSky::gensky(&[2.0, 30.0, 5.0]).unwrap();
    /// assert!((overcast.at([0.0, 0.0, 1.0]) - 30.0).abs() < 1e-4);
    /// assert!((overcast.at([0.0, 0.0, -1.0]) - 5.0).abs() < 1e-9);
    /// ```
    pub fn gensky(numbers: &[f64]) -> Result<RadianceSky> {
        checked(numbers)?;
        match *numbers {
            [kind, zenith, ground, ..] if kind == 2.0 || kind == 3.0 => {
                let above = if kind == 2.0 { Above::Overcast { zenith } } else { Above::Uniform { zenith } };
                Ok(RadianceSky { above, ground, sun: UP, zenith: UP })
            }
            [kind, zenith, ground, normalization, x, y, z] if (kind == 1.0 || kind == 4.0) && normalization > 0.0 => {
                let above = match kind {
                    1.0 => Above::Clear { zenith, normalization },
                    _ => Above::Intermediate { zenith, normalization },
                };
                Ok(RadianceSky { above, ground, sun: sun([x, y, z])?, zenith: UP })
            }
            _ => invalid!(
                "expected the arguments of skybr: 2 or 3, zenith, ground; or 1 or 4, zenith, ground, normalization above 0, sun x y z"
            ),
        }
    }

    /// The real arguments of `skybright` of `perezlum.cal`: normalization of the sky, brightness of the ground, Perez's five
    /// coefficients, the direction to the sun.
    pub fn gendaylit(numbers: &[f64]) -> Result<RadianceSky> {
        checked(numbers)?;
        match *numbers {
            [diffuse, ground, a, b, c, d, e, x, y, z] => {
                let above = Above::Perez { diffuse, coefficients: [a, b, c, d, e] };
                Ok(RadianceSky { above, ground, sun: sun([x, y, z])?, zenith: UP })
            }
            _ => invalid!("expected the ten arguments of skybright: sky, ground, five coefficients, sun x y z"),
        }
    }

    /// The same sky, its zenith in that direction; the sun stays where it is.
    pub fn with_zenith(self, zenith: [f64; 3]) -> Result<RadianceSky> {
        Ok(RadianceSky { zenith: unit("the zenith", zenith)?, ..self })
    }

    /// Brightness in a direction, a unit vector; not negative.
    pub fn at(&self, direction: [f64; 3]) -> f64 {
        let z = dot(direction, self.zenith).clamp(-1.0, 1.0);
        let (sky, ground) = ((z + 1.01).powi(10), (z + 1.01).powi(-10));
        ((sky * self.above(direction, z) + ground * self.ground) / (sky + ground)).max(0.0)
    }

    /// The sky's part, continued below the horizon.
    fn above(&self, direction: [f64; 3], z: f64) -> f64 {
        let cos = dot(direction, self.sun);
        let (gamma, cos2) = (cos.clamp(-1.0, 1.0).acos(), cos * cos);
        match self.above {
            Above::Clear { zenith, normalization } => {
                let gradation = if z > 0.01 { 1.0 - (-0.32 / z).exp() } else { 1.0 };
                zenith * (0.91 + 10.0 * (-3.0 * gamma).exp() + 0.45 * cos2) * gradation / normalization
            }
            Above::Overcast { zenith } => zenith * (1.0 + 2.0 * z) / 3.0,
            Above::Uniform { zenith } => zenith,
            Above::Intermediate { zenith, normalization } => {
                let (zt, eta) = (dot(self.sun, self.zenith).clamp(-1.0, 1.0).acos(), z.acos());
                let first = (1.35 * (5.631 - 3.59 * eta).sin() + 3.12) * (4.396 - 2.6 * zt).sin() + 6.37 - eta;
                let second = (-0.563 * gamma * ((2.629 - eta) * (1.562 - zt) + 0.812)).exp();
                zenith * first / 2.326 * second / normalization
            }
            Above::Perez { diffuse, coefficients: [a, b, c, d, e] } => {
                let gradation = 1.0 + a * (b / z.max(0.01)).exp();
                diffuse * gradation * (1.0 + c * (d * gamma).exp() + e * cos2)
            }
        }
    }

    /// Irradiance by the half above, of a surface that faces +z where the zenith is, in the sky's unit times sr.
    pub fn horizontal_sr(&self) -> f64 {
        // Midpoints on the projected hemisphere, where cosine x solid angle is an area.
        const CIRCLES: u32 = 128;
        let mut sum = 0.0;
        for i in 0..CIRCLES {
            let r = (f64::from(i) + 0.5) / f64::from(CIRCLES);
            let z = (1.0 - r * r).sqrt();
            for j in 0..4 * CIRCLES {
                let (sin, cos) = (FRAC_PI_2 * (f64::from(j) + 0.5) / f64::from(CIRCLES)).sin_cos();
                sum += self.at([r * cos, r * sin, z]) * 2.0 * r / f64::from(4 * CIRCLES * CIRCLES);
            }
        }
        sum * std::f64::consts::PI
    }
}

fn sun(direction: [f64; 3]) -> Result<[f64; 3]> {
    unit("the sun", direction).map(|_| direction)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(&b).map(|(p, q)| p * q).sum()
}

fn checked(numbers: &[f64]) -> Result<()> {
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { invalid!("an argument is not finite") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::approx_constant)] // numbers as Radiance printed them

    use super::*;

    /// Of the overcast sky without a ground, 7 pi / 9 of the zenith (Moon and Spencer), less what the mixture near the horizon takes.
    #[test]
    fn overcast_has_its_illuminance() {
        let sky = RadianceSky::gensky(&[2.0, 9.0, 3.0]).unwrap();
        assert!((sky.horizontal_sr() / (7.0 * std::f64::consts::PI) - 1.0).abs() < 2e-3, "{}", sky.horizontal_sr());
    }

    /// What `rcalc -f skybright.cal` and `-f perezlum.cal` of Radiance 6.0a print for these arguments and directions.
    #[test]
    fn functions_are_radiances() {
        let cases = include!("../../tests/data/rad/skies.in");
        for (perez, numbers, [x, y, z], want) in cases {
            let sky = if perez { RadianceSky::gendaylit(numbers) } else { RadianceSky::gensky(numbers) };
            let got = sky.unwrap().at(unit("it", [x, y, z]).unwrap());
            assert!((got - want).abs() <= 2e-5 * f64::abs(want), "{numbers:?} {x} {y} {z}: {got} for {want}");
        }
    }

    #[test]
    fn wrong_arguments_are_refused() {
        for numbers in [&[][..], &[5.0, 1.0, 1.0], &[1.0, 1.0, 1.0], &[1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]] {
            assert!(RadianceSky::gensky(numbers).is_err(), "{numbers:?}");
        }
        assert!(RadianceSky::gendaylit(&[1.0; 9]).is_err() && RadianceSky::gendaylit(&[f64::NAN; 10]).is_err());
    }
}
