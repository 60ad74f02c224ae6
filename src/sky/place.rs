//! Where the sun stands, by date and place [Michalsky 1988]: the Astronomical Almanac's approximation, within 0.01 degrees from 1950 to
//! 2050. It is the sun's own place, not bent by the air, which lifts it by half a degree at the horizon.

use toml::value::{Datetime, Offset};

use super::direction;
use crate::{Result, invalid};

/// Years that the approximation is good for.
const YEARS: std::ops::RangeInclusive<u16> = 1950..=2050;

/// Unit vector [east, north, up] to the sun at a time with its offset from UTC, at a latitude (north above 0) and a longitude (east above
/// 0), degrees. Below the horizon its last number is negative.
///
/// # Errors
/// A time without date, clock or offset, a year outside 1950 to 2050, a latitude beyond 90 or a longitude beyond 180 degrees.
///
/// The example of NREL's own algorithm [Reda 2004]: zenith angle 50.1 degrees with the air's lift of 0.01, azimuth 194.34 from north.
/// ```
/// let time = "2003-10-17T12:30:30-07:00".parse().unwrap();
/// let [east, north, up] = luxpipe::sky::place::to_sun(&time, 39.742476, -105.1786).unwrap();
/// assert!((up.acos().to_degrees() - 50.12).abs() < 0.02);
/// assert!((east.atan2(north).to_degrees() + 360.0 - 194.34).abs() < 0.02);
/// ```
pub fn to_sun(time: &Datetime, latitude_deg: f64, longitude_deg: f64) -> Result<[f64; 3]> {
    if !(latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0) {
        return invalid!("latitude {latitude_deg} and longitude {longitude_deg}: -90 to 90 and -180 to 180 degrees");
    }
    let (days, hours) = since_2000(time)?;
    let at = |base: f64, each: f64| (base + each * days).rem_euclid(360.0).to_radians();
    let (mean_longitude, anomaly) = (at(280.460, 0.985_647_4), at(357.528, 0.985_600_3));
    let longitude = mean_longitude + (1.915 * anomaly.sin() + 0.020 * (2.0 * anomaly).sin()).to_radians();
    let obliquity = (23.439 - 4e-7 * days).to_radians();
    let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
    let declination = (obliquity.sin() * longitude.sin()).asin();
    let greenwich_hours = 6.697_375 + 0.065_709_824_2 * days + hours;
    let hour_angle = (15.0 * greenwich_hours + longitude_deg).to_radians() - right_ascension;
    let latitude = latitude_deg.to_radians();
    // From the equator's axes to the horizon's.
    let (toward_pole, across) = (declination.sin(), declination.cos());
    let south = across * hour_angle.cos();
    let up = toward_pole * latitude.sin() + south * latitude.cos();
    let north = toward_pole * latitude.cos() - south * latitude.sin();
    let east = -across * hour_angle.sin();
    Ok(direction(up.clamp(-1.0, 1.0).asin().to_degrees(), north.atan2(east).to_degrees()))
}

/// Days since noon of 2000-01-01, UTC, and hours of the day.
fn since_2000(time: &Datetime) -> Result<(f64, f64)> {
    let (Some(date), Some(clock), Some(offset)) = (time.date, time.time, time.offset) else {
        return invalid!("{time}: expected date, time and offset from UTC, such as 2026-06-21T14:00:00+02:00");
    };
    if !YEARS.contains(&date.year) {
        return invalid!("{time}: the sun's place is known from {} to {}", YEARS.start(), YEARS.end());
    }
    let minutes_ahead = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => minutes,
    };
    let (year, month, day) = (i64::from(date.year), i64::from(date.month), i64::from(date.day));
    // Days by the Gregorian calendar, years from March on.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let number =
        365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + (153 * month + 2) / 5 + day;
    let seconds = f64::from(clock.second.unwrap_or(0)) + f64::from(clock.nanosecond.unwrap_or(0)) / 1e9;
    let hours =
        f64::from(clock.hour) + f64::from(clock.minute) / 60.0 + seconds / 3600.0 - f64::from(minutes_ahead) / 60.0;
    // 2000-01-01 by that count.
    const BEGIN: i64 = 730_426;
    Ok(((number - BEGIN) as f64 + hours / 24.0 - 0.5, hours))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elevation_deg(time: &str, latitude_deg: f64, longitude_deg: f64) -> f64 {
        to_sun(&time.parse().unwrap(), latitude_deg, longitude_deg).unwrap()[2].asin().to_degrees()
    }

    /// On the equator at equinox the sun passes the zenith; at the pole it stands on the horizon; midwinter's noon is as low as the
    /// latitude and the obliquity say; it rises in the east and sets in the west.
    #[test]
    fn the_sun_stands_where_almanacs_have_it() {
        // Equinox of 2024-03-20T03:06Z: noon there where it is noon, by the equation of time 7.4 minutes late.
        let noon = "2024-03-20T12:07:24Z";
        assert!(elevation_deg(noon, 0.0, 0.0) > 89.7);
        assert!(elevation_deg("2024-03-20T03:06:00Z", 90.0, 0.0).abs() < 0.02);
        let midwinter = elevation_deg("2024-12-21T12:00:00+01:00", 52.0, 15.0);
        assert!((midwinter - (90.0 - 52.0 - 23.44)).abs() < 0.05, "{midwinter}");
        let morning = to_sun(&"2024-03-20T06:10:00Z".parse().unwrap(), 0.0, 0.0).unwrap();
        assert!(morning[0] > 0.99 && morning[2].abs() < 0.05, "{morning:?}");
        let evening = to_sun(&"2024-03-20T18:10:00Z".parse().unwrap(), 0.0, 0.0).unwrap();
        assert!(evening[0] < -0.99 && evening[2].abs() < 0.05, "{evening:?}");
        assert!(elevation_deg("2024-06-21T00:00:00Z", 52.0, 0.0) < -10.0);
        // The same moment by another clock.
        let (a, b) = (
            elevation_deg("2024-06-21T23:30:00Z", 10.0, 120.0),
            elevation_deg("2024-06-22T07:30:00+08:00", 10.0, 120.0),
        );
        assert!((a - b).abs() < 1e-9);
        for bad in ["2024-06-21T23:30:00", "2024-06-21", "1900-06-21T23:30:00Z"] {
            assert!(to_sun(&bad.parse().unwrap(), 0.0, 0.0).is_err(), "{bad}");
        }
        assert!(
            to_sun(&noon.parse().unwrap(), 91.0, 0.0).is_err()
                && to_sun(&noon.parse().unwrap(), 0.0, f64::NAN).is_err()
        );
    }
}
