//! Rough surfaces by wave optics [He 1991; the paper's 6]: heights with a Gaussian distribution of rms sigma and a Gaussian
//! autocorrelation of length tau. What is flat against the wavelength reflects as a mirror, damped by exp(-g),
//! g = ((2 pi sigma / lambda) (cos in + cos out))^2 (the mirror's is (4 pi sigma cos / lambda)^2); the rest goes into an incoherent lobe
//!
//! f = |F|^2 / pi x G S D / (cos in cos out), D = (pi^2 tau^2 / 4 lambda^2) sum over m of g^m exp(-g) / (m! m) exp(-(v tau)^2 / 4 m),
//!
//! v what the surface's plane sees of the change of the wave vector, G a factor of geometry, S shadowing. Light that is reflected
//! more than once in the pits is not in it.

/// A rough surface; lengths in nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// Rms height.
    pub sigma_nm: f32,
    /// Autocorrelation length.
    pub tau_nm: f32,
}

/// Beyond this g the sum is its limit of many terms, geometrical optics.
const MANY: f32 = 40.0;

impl Rough {
    /// g for two cosines.
    #[inline(always)]
    pub fn g(&self, cos_out: f32, cos_inc: f32, lambda_nm: f32) -> f32 {
        let phase = std::f32::consts::TAU * self.sigma_nm / lambda_nm * (cos_out + cos_inc);
        phase * phase
    }

    /// What the mirror keeps.
    ///
    /// ```
    /// use luxpipe::optics::roughness::Rough;
    /// // 27.6 nm rms at 550 nm: (4 pi sigma / lambda)^2 = 0.3977.
    /// let kept = Rough { sigma_nm: 27.6, tau_nm: 1000.0 }.coherent(1.0, 550.0);
    /// assert!((kept - (-0.397_7f32).exp()).abs() < 1e-3);
    /// ```
    #[inline(always)]
    pub fn coherent(&self, cos: f32, lambda_nm: f32) -> f32 {
        (-self.g(cos, cos, lambda_nm)).exp()
    }

    /// The sum over m for g and x = (v tau)^2 / 4: sum of g^m exp(-g) / (m! m) exp(-x / m).
    #[inline(always)]
    fn sum(g: f32, x: f32) -> f32 {
        if g > MANY {
            return (-x / g).exp() / g;
        }
        let (mut term, mut sum) = ((-g).exp(), 0.0);
        let most = (g + 8.0 * g.sqrt() + 8.0) as u32;
        for m in 1..=most {
            let m = m as f32;
            term *= g / m;
            sum += term / m * (-x / m).exp();
        }
        sum
    }

    /// (v tau)^2 / 4 for the square of what the plane sees of out + inc.
    fn x(&self, across2: f32, lambda_nm: f32) -> f32 {
        let k_tau = std::f32::consts::TAU * self.tau_nm / lambda_nm;
        0.25 * k_tau * k_tau * across2
    }

    /// D without the surface's own factors.
    #[inline(always)]
    fn d(&self, g: f32, across2: f32, lambda_nm: f32) -> f32 {
        let t = std::f32::consts::PI * self.tau_nm / lambda_nm;
        0.25 * t * t * Rough::sum(g, self.x(across2, lambda_nm))
    }

    /// The same surface as seen from two directions: where they graze it the valleys are hidden, and what is left is smoother.
    /// sigma = sigma0 / sqrt(1 + (z / sigma0)^2), sqrt(pi / 2) z = (sigma0 / 4) (K_out + K_inc) exp(-z^2 / 2 sigma0^2),
    /// K = tan erfc(tau cot / 2 sigma0) [He 1991].
    pub fn seen(&self, cos_out: f32, cos_inc: f32) -> Rough {
        let k = |cos: f32| {
            let tan = f64::from((1.0 - cos * cos).max(0.0).sqrt() / cos.max(1e-6));
            if tan > 1e-6 { tan * libm::erfc(self.slope_limit() / tan) } else { 0.0 }
        };
        let side = 0.25 * (k(cos_out) + k(cos_inc)) * (2.0 / std::f64::consts::PI).sqrt();
        if side < 1e-6 {
            return *self;
        }
        // z exp(z^2 / 2) = side, z in units of sigma0: Newton from above.
        let mut z = side.min(1.0 + (2.0 * side.max(1.0).ln()).sqrt());
        for _ in 0..8 {
            let e = (0.5 * z * z).exp();
            z -= (z * e - side) / (e * (1.0 + z * z));
        }
        Rough { sigma_nm: self.sigma_nm / (1.0 + z * z).sqrt() as f32, ..*self }
    }

    /// tau / 2 sigma.
    fn slope_limit(&self) -> f64 {
        f64::from(self.tau_nm) / (2.0 * f64::from(self.sigma_nm).max(1e-9))
    }

    /// Smith's shadowing for Gaussian slopes of rms sqrt(2) sigma / tau, one direction [He 1991, after Smith 1967].
    pub fn shadow(&self, cos: f32) -> f32 {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        if sin < 1e-6 {
            return 1.0;
        }
        let h = self.slope_limit() * f64::from(cos / sin);
        let erfc = libm::erfc(h);
        let lambda = 0.5 * ((-h * h).exp() / (std::f64::consts::PI.sqrt() * h.max(1e-12)) - erfc);
        ((1.0 - 0.5 * erfc) / (lambda + 1.0)) as f32
    }

    /// The incoherent lobe times |cos inc| of a surface as it is [`Rough::seen`], without Fresnel's factor, 1/sr. `half` is the cosine between the half vector and
    /// either direction.
    #[inline(always)]
    pub fn incoherent_cos(&self, cos_out: f32, cos_inc: f32, half: f32, shadow: f32, lambda_nm: f32) -> f32 {
        let vz = cos_out + cos_inc;
        // |out + inc| = 2 half.
        let v2 = 4.0 * half * half;
        // Where s and p axes of both directions span the same planes, the rest of G is 1.
        let geometry = (v2 / vz).powi(2);
        let d = self.d(self.g(cos_out, cos_inc, lambda_nm), (v2 - vz * vz).max(0.0), lambda_nm);
        std::f32::consts::FRAC_1_PI * geometry * shadow * d / cos_out
    }

    /// Density over the plane of out + inc with which [`Rough::draw`] chooses: the lobe's own, without its factors of geometry.
    pub fn density(&self, cos_out: f32, across2: f32, lambda_nm: f32) -> f32 {
        let g = self.g(cos_out, cos_out, lambda_nm);
        let k_tau = std::f32::consts::TAU * self.tau_nm / lambda_nm;
        // Integral of exp(-x / m) over the plane is 4 pi m / (k tau)^2, of the whole sum therefore 1 - exp(-g).
        let all = 4.0 * std::f32::consts::PI / (k_tau * k_tau) * -(-g).exp_m1();
        if all > 0.0 { Rough::sum(g, self.x(across2, lambda_nm)) / all } else { 0.0 }
    }

    /// A change of the direction in the surface's plane, by two numbers in 0..1.
    pub fn draw(&self, cos_out: f32, lambda_nm: f32, u: [f32; 2]) -> [f32; 2] {
        let g = self.g(cos_out, cos_out, lambda_nm);
        // The number of terms is Poisson's, but not 0.
        let (m, left) = if g > MANY { (g, u[0]) } else { Rough::term(g, u[0]) };
        let k_tau = std::f32::consts::TAU * self.tau_nm / lambda_nm;
        let r = 2.0 / k_tau * (m * -(1.0 - left).max(1e-30).ln()).sqrt();
        let (sin, cos) = (std::f32::consts::TAU * u[1]).sin_cos();
        [r * cos, r * sin]
    }

    fn term(g: f32, u: f32) -> (f32, f32) {
        let all = -(-g).exp_m1();
        let (mut m, mut term, mut left) = (1.0f32, g * (-g).exp(), u * all);
        while left >= term && m < 200.0 {
            left -= term;
            m += 1.0;
            term *= g / m;
        }
        (m, if term > 0.0 { (left / term).clamp(0.0, 1.0 - f32::EPSILON) } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With gentle slopes, what the mirror has lost is in the lobe: near the normal both together are 1 from roughness far below the
    /// wavelength to far above.
    #[test]
    fn mirror_and_lobe_share_the_light() {
        for sigma_nm in [1.0, 20.0, 60.0, 200.0, 1000.0, 5000.0] {
            let rough = Rough { sigma_nm, tau_nm: 60.0 * f32::max(sigma_nm, 400.0) };
            for nm in [400.0, 700.0] {
                let n = 200;
                let mut sum = 0.0;
                for i in 0..n {
                    for j in 0..n {
                        let u = [(i as f32 + 0.5) / n as f32, (j as f32 + 0.5) / n as f32];
                        let [x, y] = rough.draw(1.0, nm, u);
                        let across2 = x * x + y * y;
                        let cos = (1.0 - across2).max(0.0).sqrt();
                        let half = ((1.0 + cos) / 2.0).sqrt();
                        // Density over the plane is the lobe's over cos.
                        let lobe = rough.incoherent_cos(1.0, cos, half, 1.0, nm) / cos;
                        sum += lobe / rough.density(1.0, across2, nm);
                    }
                }
                let lobe = sum / (n * n) as f32 * if rough.g(1.0, 1.0, nm) < 1e-6 { 0.0 } else { 1.0 };
                let all = rough.coherent(1.0, nm) + lobe;
                assert!((all - 1.0).abs() < 0.01, "sigma {sigma_nm} nm at {nm}: {all}");
            }
        }
    }
}
