//! The sun's spectrum behind a cloudless atmosphere [Preetham 1999, appendix; after Iqbal 1983].
//!
//! L = L0 tR tA tO tG tW, with the wavelength w in micrometres and the relative optical mass [Kasten 1965]
//! m = 1 / (cos Z + 0.15 (93.885 - Z)^-1.253), Z in degrees:
//!
//! | what attenuates | transmittance |
//! |---|---|
//! | molecules (Rayleigh) | tR = exp(-0.008735 w^-4.08 m) |
//! | aerosol (Angstrom) | tA = exp(-beta w^-1.3 m), beta = 0.04608 T - 0.04586 |
//! | ozone, 0.35 cm | tO = exp(-0.35 k_o m) |
//! | mixed gases | tG = exp(-1.41 k_g m / (1 + 118.93 k_g m)^0.45) |
//! | water vapour, 2 cm | tW = exp(-0.2385 k_w 2 m / (1 + 20.07 k_w 2 m)^0.45) |
//!
//! The sun outside the atmosphere is tabulated from 380 to 750 nm, so the result is zero beyond: of the red end, 750 to 780
//! nm, less than 0.01 % of the luminance is missing. The disc is uniform at its mean radiance; of
//! [`super::sun::DIAMETER_DEG`] across it gives 128 klx outside the atmosphere, 4 % less than the solar constant in use now.

use crate::spectral::{Spectrum, builtin};
use crate::{Result, invalid};

use super::clear::TURBIDITY;

/// Spectral radiance of the sun's disc, W/sr/m2/nm every nm from 380 to 750 nm, for the sun at an elevation of 0 to 90
/// degrees and a turbidity of 2 to 10.
pub fn sun_radiance(elevation_deg: f64, turbidity: f64) -> Result<Spectrum> {
    if !(0.0..=90.0).contains(&elevation_deg) {
        return invalid!("the sun's elevation must be 0 to 90 degrees, got {elevation_deg}");
    }
    if !TURBIDITY.contains(&turbidity) {
        return invalid!("turbidity must be {} to {}, got {turbidity}", TURBIDITY.start(), TURBIDITY.end());
    }
    let [outside, ozone, gas, water] =
        ["sun_extraterrestrial", "ozone_absorption", "mixed_gas_absorption", "water_vapour_absorption"]
            .map(builtin::spectrum);
    let (outside, ozone, gas, water) = (outside?, ozone?, gas?, water?);
    let m = optical_mass(90.0 - elevation_deg);
    let beta = 0.046_083_658 * turbidity - 0.045_860_259;
    let transmittance = |nm: f64| {
        let um = nm / 1000.0;
        let rayleigh = 0.008735 * um.powf(-4.08) * m;
        let aerosol = beta * um.powf(-1.3) * m;
        let ozone = 0.35 * ozone.at(nm) * m;
        let g = gas.at(nm) * m;
        let w = 2.0 * water.at(nm) * m;
        let lines = 1.41 * g / (1.0 + 118.93 * g).powf(0.45) + 0.2385 * w / (1.0 + 20.07 * w).powf(0.45);
        (-(rayleigh + aerosol + ozone + lines)).exp()
    };
    Spectrum::from_points((380..=750).map(f64::from).map(|nm| (nm, outside.at(nm) * transmittance(nm))).collect())
}

/// Relative optical mass of the atmosphere at a zenith angle in degrees: 1 at the zenith, 36.5 at the horizon [Kasten 1965].
fn optical_mass(zenith_deg: f64) -> f64 {
    1.0 / (zenith_deg.to_radians().cos() + 0.15 * (93.885 - zenith_deg).powf(-1.253))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::Observer;
    use crate::units::K_M;

    const PAPER_SOLID_ANGLE: f64 = 6.8e-5;

    fn illuminance(s: &Spectrum) -> f64 {
        K_M * PAPER_SOLID_ANGLE * Observer::cie1931().unwrap().integrate(s)[1]
    }

    /// The luminous solar constant is 133 334 lx (S. Darula, R. Kittler, C. Gueymard, Reference luminous solar constant and
    /// solar luminance for illuminance calculations, Solar Energy 79, 2005): the paper's table lies 4 % below it.
    #[test]
    fn outside_the_atmosphere_the_sun_gives_the_solar_constant() {
        let lux = illuminance(&builtin::spectrum("sun_extraterrestrial").unwrap());
        assert!((lux / 133_334.0 - 0.96).abs() < 0.005, "{lux}");
    }

    /// Kasten's own table (A new table and approximation formula for the relative optical air mass, 1965).
    #[test]
    fn optical_mass_of_kasten() {
        for (zenith, want) in [(0.0, 1.0), (60.0, 1.994), (80.0, 5.6), (85.0, 10.4)] {
            let got = optical_mass(zenith);
            assert!((got / want - 1.0).abs() < 0.01, "{zenith}: {got}");
        }
    }

    /// At 550 nm, sun overhead, turbidity 2, by hand: 0.10014 + 0.10073 + 0.02975 in an optical mass of 0.99949.
    #[test]
    fn attenuation_by_hand() {
        let m = 1.0 / (1.0 + 0.15 / 93.885f64.powf(1.253));
        let exponent =
            0.008735 * 0.55f64.powf(-4.08) + (0.046083658 * 2.0 - 0.045860259) * 0.55f64.powf(-1.3) + 0.35 * 0.085;
        let want = 25503.8 * (-m * exponent).exp();
        let got = sun_radiance(90.0, 2.0).unwrap().at(550.0);
        assert!((got / want - 1.0).abs() < 1e-9, "{got} {want}");
        assert!((got / 25503.8 - 0.79414).abs() < 2e-5, "{}", got / 25503.8);
    }

    #[test]
    fn lower_and_hazier_suns_are_dimmer_and_redder() {
        let ratio = |s: &Spectrum| s.at(650.0) / s.at(450.0);
        let high = sun_radiance(60.0, 3.0).unwrap();
        for other in [sun_radiance(10.0, 3.0).unwrap(), sun_radiance(60.0, 6.0).unwrap()] {
            assert!(illuminance(&other) < illuminance(&high) && ratio(&other) > ratio(&high));
        }
        for (elevation, turbidity) in
            [(-0.1, 3.0), (91.0, 3.0), (45.0, 1.9), (45.0, 10.1), (f64::NAN, 3.0), (45.0, f64::NAN)]
        {
            assert!(sun_radiance(elevation, turbidity).is_err());
        }
    }
}
