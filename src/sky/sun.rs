//! The sun's disc: a small cone of directions, all equally bright.
//!
//! A disc of angular radius r and radiance L, wholly above the horizon, gives a horizontal surface E = L pi sin^2 r cos Z.

use std::f64::consts::{PI, TAU};

use super::{angle, unit};
use crate::{Result, invalid};

/// Mean angular diameter of the sun, degrees.
pub const DIAMETER_DEG: f64 = 0.533;

/// A uniform disc.
#[derive(Clone, Debug, PartialEq)]
pub struct SunDisc {
    centre: [f64; 3],
    /// Two directions across, at right angles.
    across: [[f64; 3]; 2],
    radius: f64,
}

impl SunDisc {
    /// A disc about a direction; its whole angle is above 0 and at most 180 degrees ([`DIAMETER_DEG`] is the sun's).
    pub fn new(centre: [f64; 3], diameter_deg: f64) -> Result<SunDisc> {
        let centre = unit("the sun", centre)?;
        if !(diameter_deg > 0.0 && diameter_deg <= 180.0) {
            return invalid!("the sun's diameter must be above 0 and at most 180 degrees, got {diameter_deg}");
        }
        Ok(SunDisc { centre, across: across(centre), radius: (0.5 * diameter_deg).to_radians() })
    }

    /// Direction to the centre.
    pub fn centre(&self) -> [f64; 3] {
        self.centre
    }

    /// Solid angle, steradians: 4 pi sin^2(r/2).
    pub fn solid_angle(&self) -> f64 {
        2.0 * TAU * (0.5 * self.radius).sin().powi(2)
    }

    /// True for directions (unit vectors) that meet the disc.
    pub fn contains(&self, direction: [f64; 3]) -> bool {
        angle(direction, self.centre) <= self.radius
    }

    /// Irradiance that the disc at radiance 1 gives a surface whose normal lies at `cos_incidence` from its centre, the whole
    /// disc on the normal's side.
    ///
    /// ```
    /// use luxpipe::sky::{SunDisc, direction, sun};
    /// let disc = SunDisc::new(direction(30.0, 0.0), sun::DIAMETER_DEG).unwrap();
    /// assert!((disc.irradiance(0.5) / 3.3983328e-5 - 1.0).abs() < 1e-7);
    /// ```
    pub fn irradiance(&self, cos_incidence: f64) -> f64 {
        PI * self.radius.sin().powi(2) * cos_incidence
    }

    /// A direction for a point of the unit square; equal areas there have equal solid angles.
    pub fn sample(&self, u: [f64; 2]) -> [f64; 3] {
        // 1 - cos of the angle from the centre, small: the cosine itself would lose half its digits.
        let height = u[0] * 2.0 * (0.5 * self.radius).sin().powi(2);
        let out = (height * (2.0 - height)).max(0.0).sqrt();
        let (s, c) = (TAU * u[1]).sin_cos();
        std::array::from_fn(|i| self.centre[i] * (1.0 - height) + out * (c * self.across[0][i] + s * self.across[1][i]))
    }

    /// Density of [`SunDisc::sample`] in a direction, 1/sr.
    pub fn pdf(&self, direction: [f64; 3]) -> f64 {
        if self.contains(direction) { 1.0 / self.solid_angle() } else { 0.0 }
    }
}

/// Two directions at right angles to `z` and each other, z = x cross y.
fn across(z: [f64; 3]) -> [[f64; 3]; 2] {
    // The axis that z is farthest from.
    let other = if z[0].abs() < z[1].abs() { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let x = cross(other, z);
    let length = x.iter().map(|v| v * v).sum::<f64>().sqrt();
    let x = x.map(|v| v / length);
    [x, cross(z, x)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::direction;

    #[test]
    fn irradiance_of_the_closed_form() {
        // E = L pi sin^2(alpha/2) cos Z, evaluated elsewhere in double precision.
        let want = [(0.0, 6.7966656e-5), (30.0, 5.8860851e-5), (60.0, 3.3983328e-5), (75.0, 1.7591065e-5)];
        for (zenith, e) in want {
            let disc = SunDisc::new(direction(90.0 - zenith, 10.0), DIAMETER_DEG).unwrap();
            assert!((disc.irradiance(f64::to_radians(zenith).cos()) / e - 1.0).abs() < 1e-7);
        }
    }

    /// The mean of cos Z over samples times the solid angle is the irradiance again.
    #[test]
    fn samples_integrate_to_the_irradiance() {
        for (elevation, diameter) in [(70.0, DIAMETER_DEG), (50.0, 40.0), (90.0, 180.0)] {
            let disc = SunDisc::new(direction(elevation, 200.0), diameter).unwrap();
            let n = 200;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = [(i / n) as f64 + 0.5, (i % n) as f64 + 0.5].map(|x| x / n as f64);
                let d = disc.sample(u);
                assert!((d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
                assert_eq!(disc.pdf(d), 1.0 / disc.solid_angle());
                sum += d[2];
            }
            let got = disc.solid_angle() * sum / (n * n) as f64;
            let want = disc.irradiance(elevation.to_radians().sin());
            assert!((got / want - 1.0).abs() < 1e-9, "{got} {want}");
        }
    }

    #[test]
    fn edges() {
        let disc = SunDisc::new([0.0, 0.0, 5.0], 1.0).unwrap();
        assert!(disc.contains(direction(89.5001, 0.0)) && !disc.contains(direction(89.4999, 0.0)));
        assert_eq!(disc.pdf(direction(89.0, 3.0)), 0.0);
        for bad in [0.0, -1.0, 181.0, f64::NAN] {
            assert!(SunDisc::new([0.0, 0.0, 1.0], bad).is_err());
        }
    }
}
