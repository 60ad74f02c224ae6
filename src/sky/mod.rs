//! Skies and the sun. A direction is a unit vector [east, north, up] (any two horizontal axes will do, up is the third); a
//! sky is black below the horizon.
//!
//! | module | holds |
//! |---|---|
//! | [`cie`] | the 15 standard general skies: relative luminance |
//! | [`clear`] | Preetham's clear sky: absolute spectral radiance |
//! | [`radiance`] | those of Radiance's `gensky` and `gendaylit` |
//! | [`beam`] | the sun's own spectrum behind a clear atmosphere |
//! | [`sun`] | the sun's disc: solid angle, sampling |
//! | [`place`] | where it stands, by date and place |

pub mod beam;
pub mod cie;
pub mod clear;
pub mod place;
pub mod radiance;
pub mod sun;

pub use beam::sun_radiance;
pub use cie::CieSky;
pub use clear::ClearSky;
pub use radiance::RadianceSky;
pub use sun::SunDisc;

use crate::{Result, invalid};

/// The angle between two unit vectors, exact also for small ones.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let difference: f64 = a.iter().zip(&b).map(|(p, q)| (p - q) * (p - q)).sum();
    let sum: f64 = a.iter().zip(&b).map(|(p, q)| (p + q) * (p + q)).sum();
    2.0 * difference.sqrt().atan2(sum.sqrt())
}

/// A direction of length 1.
fn unit(name: &str, direction: [f64; 3]) -> Result<[f64; 3]> {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return invalid!("{name} must be a direction, three finite numbers that are not all 0, got {direction:?}");
    }
    Ok(direction.map(|x| x / length))
}

/// Unit vector to a point of the sky: elevation above the horizon and azimuth from the first axis toward the second, degrees.
///
/// ```
/// let [x, y, z] = luxpipe::sky::direction(30.0, 90.0);
/// assert!(x.abs() < 1e-15 && (y - 0.75f64.sqrt()).abs() < 1e-15 && (z - 0.5).abs() < 1e-15);
/// ```
pub fn direction(elevation_deg: f64, azimuth_deg: f64) -> [f64; 3] {
    let (up, across) = elevation_deg.to_radians().sin_cos();
    let (y, x) = azimuth_deg.to_radians().sin_cos();
    [across * x, across * y, up]
}
