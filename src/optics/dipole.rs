//! The classical dipole for subsurface scattering: Jensen, Marschner, Levoy and Hanrahan, "A Practical Model for
//! Subsurface Light Transport" (SIGGRAPH 2001).
//!
//! Light that enters a homogeneous half space at a point is replaced by a source at depth z_r and a mirrored one at
//! height z_v, such that diffusion theory meets the boundary. Each source has a closed antiderivative over the area,
//! so the share within a radius needs no quadrature.

use std::f64::consts::PI;

/// Bracket of the radius in units of z_r, as logarithms: the share falls as r^2 below it and at worst as 1/r above, so
/// that it covers every u that is neither 0 nor 1 in f64.
const LOG_BELOW: f64 = 400.0;
const LOG_ABOVE: f64 = 60.0;
/// Change of the logarithm of the radius that ends the search.
const TOLERANCE: f64 = 1e-10;
/// Steps at most: bisection alone takes 43.
const STEPS: usize = 64;

/// Diffuse reflectance of a homogeneous half space around the point where light enters.
///
/// All lengths are in the one unit whose inverse the coefficients are in; nothing else depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dipole {
    /// Reduced albedo alpha' = sigma_s' / sigma_t', dimensionless, 0 to 1.
    pub albedo: f64,
    /// Reduced extinction sigma_t' = sigma_s' + sigma_a, 1/length.
    pub extinction: f64,
    /// Effective transport coefficient sigma_tr = sqrt(3 sigma_a sigma_t'), 1/length; 0 without absorption.
    pub transport: f64,
    /// Depth of the real source below the surface, z_r = 1 / sigma_t', length.
    pub depth: f64,
    /// Height of the virtual source above the surface, z_v = z_r (1 + 4/3 A), length.
    pub height: f64,
    /// Boundary term A = (1 + F_dr) / (1 - F_dr), dimensionless; 1 where the surface reflects nothing.
    pub boundary: f64,
}

impl Dipole {
    /// The dipole of reduced scattering `sigma_s_prime` and absorption `sigma_a`, both 1/length and 0 or more, and of
    /// the index `eta` inside over outside, 1 to about 2. The diffuse Fresnel reflectance of the inside is Egan and
    /// Hilgeman's fit F_dr = -1.440 / eta^2 + 0.710 / eta + 0.668 + 0.0636 eta, made for eta above 1.
    pub fn new(sigma_s_prime: f64, sigma_a: f64, eta: f64) -> Self {
        let extinction = sigma_s_prime + sigma_a;
        let albedo = if sigma_s_prime == 0.0 { 0.0 } else { sigma_s_prime / extinction };
        let internal = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
        let boundary = (1.0 + internal) / (1.0 - internal);
        let depth = extinction.recip();
        Dipole {
            albedo,
            extinction,
            transport: (3.0 * sigma_a * extinction).sqrt(),
            depth,
            height: depth * (1.0 + 4.0 / 3.0 * boundary),
            boundary,
        }
    }

    /// Diffuse reflectance R_d at the distance `r`, a length of 0 or more, from where the light entered: flux out per
    /// area over flux in, 1/length^2. The sum over both sources of
    /// alpha' / (4 pi) z (1 + sigma_tr d) exp(-sigma_tr d) / d^3 with d = sqrt(r^2 + z^2).
    pub fn radial(&self, r: f64) -> f64 {
        if self.albedo == 0.0 || r.is_infinite() {
            return 0.0;
        }
        let source = |z: f64| {
            let d = r.hypot(z);
            z / d * (d.recip() + self.transport) / d * (-self.transport * d).exp()
        };
        self.albedo / (4.0 * PI) * (source(self.depth) + source(self.height))
    }

    /// The integral of 2 pi r R_d(r) over all r, dimensionless, 0 to 1: the diffuse reflectance under uniform light,
    /// alpha' / 2 (1 + exp(-4/3 A s)) exp(-s) with s = sqrt(3 (1 - alpha')).
    pub fn total(&self) -> f64 {
        if self.albedo == 0.0 {
            return 0.0;
        }
        0.5 * self.albedo * ((-self.transport * self.depth).exp() + (-self.transport * self.height).exp())
    }

    /// The share of `total` that leaves within the radius `r`, a length of 0 or more; dimensionless, 0 to 1, and 0
    /// where nothing is reflected. With r dr = d dd, and as -exp(-sigma_tr d) / d has the derivative
    /// (1 + sigma_tr d) exp(-sigma_tr d) / d^2, a source gives exp(-sigma_tr z) - z / d exp(-sigma_tr d).
    pub fn within(&self, r: f64) -> f64 {
        self.shares(r).0
    }

    /// The radius within which the share `u`, 0 to 1, of `total` leaves; a length, good to 1e-6 of itself. It is the
    /// inverse of `within`: 0 for u = 0 and where nothing is reflected, infinite for u = 1.
    ///
    /// Newton's method on the logarithms, kept inside a bracket by bisection.
    pub fn radius(&self, u: f64) -> f64 {
        if u <= 0.0 || self.albedo == 0.0 {
            return 0.0;
        }
        if u >= 1.0 {
            return f64::INFINITY;
        }
        if u.is_nan() {
            return u;
        }
        // The smaller one of u and 1 - u keeps its relative precision in both tails.
        let inner = u < 0.5;
        let target = if inner { u.ln() } else { (1.0 - u).ln() };
        let (mut low, mut high) = (self.depth.ln() - LOG_BELOW, self.depth.ln() + LOG_ABOVE);
        let mut x = self.depth.ln();
        for _ in 0..STEPS {
            let r = x.exp();
            let (within, beyond) = self.shares(r);
            let share = if inner { within } else { beyond };
            let excess = share.ln() - target;
            if (excess > 0.0) == inner {
                high = x;
            } else {
                low = x;
            }
            let slope = 2.0 * PI * r * r * self.radial(r) / (self.total() * share);
            let newton = x - if inner { excess } else { -excess } / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let step = (next - x).abs();
            x = next;
            if step < TOLERANCE {
                break;
            }
        }
        x.exp()
    }

    /// The shares of `total` within and beyond `r`, each without cancellation.
    fn shares(&self, r: f64) -> (f64, f64) {
        if self.albedo == 0.0 {
            return (0.0, 0.0);
        }
        if r.is_infinite() {
            return (1.0, 0.0);
        }
        let source = |z: f64| {
            let d = r.hypot(z);
            // d - z, from r^2 = (d - z) (d + z).
            let longer = r * (r / (d + z));
            let (start, fade) = ((-self.transport * z).exp(), -self.transport * longer);
            let inner = longer / d - z / d * fade.exp_m1();
            (start * inner, start * (z / d) * fade.exp())
        };
        let (real, mirrored) = (source(self.depth), source(self.height));
        let scale = 0.5 * self.albedo / self.total();
        (scale * (real.0 + mirrored.0), scale * (real.1 + mirrored.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Index, reduced scattering and absorption per mm, and the total reflectance with that index and with 1.5, of
    /// apple, chicken, ketchup, marble, skim milk and skin (the formula with the coefficients of the paper's table).
    const MATERIALS: [(f64, [[f64; 3]; 4]); 6] = [
        (1.3, [[2.29, 2.39, 1.97], [0.003, 0.0034, 0.046], [0.84642, 0.84068, 0.52785], [0.80596, 0.79911, 0.47062]]),
        (1.3, [[0.15, 0.21, 0.38], [0.015, 0.077, 0.19], [0.31368, 0.15581, 0.12644], [0.28675, 0.15048, 0.12325]]),
        (
            1.3,
            [[0.18, 0.07, 0.03], [0.061, 0.97, 1.45], [0.16384, 0.0063369, 0.0018298], [0.15781, 0.0063188, 0.0018253]],
        ),
        (1.5, [[2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071], [0.83019, 0.79096, 0.75261], [0.83019, 0.79096, 0.75261]]),
        (1.3, [[0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142], [0.81495, 0.81298, 0.6823], [0.7688, 0.76651, 0.62201]]),
        (1.3, [[0.74, 0.88, 1.01], [0.032, 0.17, 0.48], [0.43596, 0.22733, 0.131], [0.3892, 0.214, 0.12752]]),
    ];

    /// Radius in mm and R_d per mm^2 of marble, green.
    const PROFILE: [(f64, f64); 6] = [
        (0.1, 0.5067872),
        (0.5, 0.13321223),
        (1.0, 0.034330027),
        (2.0, 0.0089836144),
        (5.0, 0.0010084474),
        (10.0, 9.2514432e-05),
    ];

    fn marble() -> Dipole {
        Dipole::new(2.62, 0.0041, 1.5)
    }

    /// Ordinary, conservative, strongly absorbing and index-matched media, and one in metres.
    fn media() -> [Dipole; 5] {
        [
            marble(),
            Dipole::new(1.0, 0.0, 1.3),
            Dipole::new(0.03, 1.45, 1.3),
            Dipole::new(2.0, 0.5, 1.0),
            Dipole::new(2190.0, 2.1, 1.5),
        ]
    }

    #[track_caller]
    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{found} instead of {expected} +- {tolerance}");
    }

    #[test]
    fn total_matches_the_table() {
        for (eta, [scattering, absorption, own, glass]) in MATERIALS {
            let coefficients = scattering.iter().zip(absorption);
            for ((s, a), (own, glass)) in coefficients.zip(own.iter().zip(glass)) {
                close(Dipole::new(*s, a, eta).total(), *own, 6e-6);
                close(Dipole::new(*s, a, 1.5).total(), glass, 6e-6);
            }
        }
    }

    #[test]
    fn total_matches_the_formula_in_the_albedo() {
        for medium in media() {
            let s = (3.0 * (1.0 - medium.albedo)).sqrt();
            let formula = 0.5 * medium.albedo * (1.0 + (-4.0 / 3.0 * medium.boundary * s).exp()) * (-s).exp();
            close(medium.total(), formula, 1e-12);
        }
    }

    #[test]
    fn radial_profile_matches_the_table() {
        for (r, expected) in PROFILE {
            close(marble().radial(r) / expected, 1.0, 1e-7);
        }
        close(marble().total(), 0.7909602, 1e-7);
    }

    /// The trapezium rule in ln r over the profile itself.
    #[test]
    fn total_is_the_integral_of_the_profile() {
        let step = 1e-3;
        for medium in media() {
            let sum: f64 = (-20_000..20_000)
                .map(|i| medium.depth * (step * f64::from(i)).exp())
                .map(|r| 2.0 * PI * r * r * medium.radial(r) * step)
                .sum();
            close(sum, medium.total(), 1e-6);
        }
    }

    #[test]
    fn within_runs_from_nothing_to_everything() {
        for medium in media() {
            assert_eq!(medium.within(0.0), 0.0);
            assert_eq!(medium.within(f64::INFINITY), 1.0);
            close(medium.within(1e12 * medium.depth), 1.0, 1e-11);
            assert_eq!(medium.radial(f64::INFINITY), 0.0);
        }
    }

    #[test]
    fn within_grows_by_the_light_of_a_ring() {
        for medium in media() {
            for scale in [1e-3, 0.1, 1.0, 5.0] {
                let r = scale * medium.depth;
                let slope = (medium.within(1.0001 * r) - medium.within(0.9999 * r)) / (0.0002 * r);
                let ring = 2.0 * PI * r * medium.radial(r) / medium.total();
                close(slope / ring, 1.0, 1e-5);
            }
        }
    }

    /// Both tails, the innermost one as area times the profile's peak.
    #[test]
    fn radius_inverts_within() {
        for medium in media() {
            for u in [1e-6, 1e-3, 0.1, 0.4999, 0.5, 0.7, 0.99, 0.999_999] {
                let r = medium.radius(u);
                let slope = 2.0 * PI * r * medium.radial(r) / medium.total();
                close((medium.within(r) - u) / (slope * r), 0.0, 1e-8);
            }
            let r = medium.radius(1e-300);
            close(PI * r * r * medium.radial(0.0) / medium.total() / 1e-300, 1.0, 1e-6);
            let last = medium.radius(1.0 - f64::EPSILON);
            assert!(last.is_finite() && last > medium.radius(0.999_999));
            assert_eq!(medium.radius(0.0), 0.0);
            assert_eq!(medium.radius(1.0), f64::INFINITY);
        }
    }

    /// Without absorption everything returns, and the share beyond r falls as (z_r + z_v) / (2 r).
    #[test]
    fn nothing_is_lost_without_absorption() {
        let medium = Dipole::new(0.8, 0.0, 1.4);
        assert_eq!(medium.transport, 0.0);
        assert_eq!(medium.total(), 1.0);
        let far = 1e6;
        close((1.0 - medium.within(far)) * 2.0 * far / (medium.depth + medium.height), 1.0, 1e-8);
        close(medium.radius(1.0 - 0.5_f64.powi(40)) * 0.5_f64.powi(39), medium.depth + medium.height, 1e-8);
    }

    #[test]
    fn nothing_returns_without_scattering() {
        for medium in [Dipole::new(0.0, 1.0, 1.3), Dipole::new(0.0, 0.0, 1.3)] {
            assert_eq!(medium.total(), 0.0);
            for r in [0.0, 1.0, f64::INFINITY] {
                assert_eq!(medium.radial(r), 0.0);
                assert_eq!(medium.within(r), 0.0);
            }
            assert_eq!(medium.radius(0.5), 0.0);
        }
    }

    #[test]
    fn undefined_input_stays_undefined() {
        assert!(marble().within(f64::NAN).is_nan());
        assert!(marble().radius(f64::NAN).is_nan());
        assert!(Dipole::new(f64::NAN, 1.0, 1.3).total().is_nan());
    }
}
