//! Diffraction at openings: Airy's pattern of a circular one, a slit's.

use std::sync::OnceLock;

use libm::{j0, j1};

/// First zero of J1 over pi: the first dark ring of an opening D lies at 1.219670 lambda / D.
pub const FIRST_RING: f64 = 1.219_669_891_266_504_5;

/// Angle of the first dark ring of a circular opening, rad.
///
/// ```
/// let arcsec = luxpipe::optics::aperture::first_ring_rad(2e-3, 550.0).to_degrees() * 3600.0;
/// assert!((arcsec - 69.183118).abs() < 1e-3);
/// ```
pub fn first_ring_rad(diameter_m: f64, lambda_nm: f64) -> f64 {
    FIRST_RING * lambda_nm * 1e-9 / diameter_m
}

/// Angle of the first minimum of a slit, rad.
///
/// ```
/// let deg = luxpipe::optics::aperture::slit_minimum_rad(100e-6, 633.0).to_degrees();
/// assert!((deg - 0.36268471).abs() < 1e-6);
/// ```
pub fn slit_minimum_rad(width_m: f64, lambda_nm: f64) -> f64 {
    (lambda_nm * 1e-9 / width_m).asin()
}

/// Share of the light within v = pi D sin(angle) / lambda of the axis: 1 - J0^2 - J1^2 [Rayleigh 1881].
///
/// ```
/// use luxpipe::optics::aperture::{FIRST_RING, encircled};
/// assert!((encircled(FIRST_RING * std::f64::consts::PI) - 0.837785).abs() < 1e-6);
/// ```
pub fn encircled(v: f64) -> f64 {
    1.0 - j0(v).powi(2) - j1(v).powi(2)
}

/// Density of light over the plane of v, 1 / (4 pi) (2 J1(v) / v)^2: its integral is 1.
pub fn density(v: f64) -> f64 {
    let amplitude = if v.abs() < 1e-4 { 1.0 } else { 2.0 * j1(v) / v };
    amplitude * amplitude * 0.25 * std::f64::consts::FRAC_1_PI
}

/// The pattern's light by v, to be drawn from. Beyond [`Airy::END`] 0.2 % of it is left out: the rest counts as all.
pub struct Airy {
    /// Encircled shares at steps of v.
    shares: Vec<f64>,
}

impl Airy {
    /// Tabulated once.
    pub fn get() -> &'static Airy {
        static AIRY: OnceLock<Airy> = OnceLock::new();
        AIRY.get_or_init(Airy::new)
    }

    /// The largest v.
    pub const END: f64 = 320.0;
    const STEP: f64 = 1.0 / 16.0;

    /// Tabulated.
    pub fn new() -> Airy {
        let count = (Airy::END / Airy::STEP) as usize;
        let mut shares: Vec<f64> = (0..=count).map(|i| encircled(i as f64 * Airy::STEP)).collect();
        let all = shares[count];
        shares.iter_mut().for_each(|s| *s /= all);
        Airy { shares }
    }

    /// v of a number in 0..1.
    pub fn draw(&self, u: f64) -> f64 {
        let i = self.shares.partition_point(|s| *s <= u).clamp(1, self.shares.len() - 1);
        let (a, b) = (self.shares[i - 1], self.shares[i]);
        let f = if b > a { ((u - a) / (b - a)).clamp(0.0, 1.0) } else { 0.5 };
        // Within a step the area is even.
        let (low, high) = ((i - 1) as f64, i as f64);
        (low * low + f * (high * high - low * low)).sqrt() * Airy::STEP
    }

    /// Density over the plane of v with which it is drawn.
    pub fn drawn(&self, v: f64) -> f64 {
        let x = v / Airy::STEP;
        let i = x as usize;
        if i + 1 >= self.shares.len() {
            return 0.0;
        }
        let area = std::f64::consts::PI * Airy::STEP * Airy::STEP * (2 * i + 1) as f64;
        (self.shares[i + 1] - self.shares[i]) / area
    }
}

impl Default for Airy {
    fn default() -> Self {
        Airy::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_is_the_pattern() {
        for (ring, want) in [(1.2196699, 0.837785), (2.2331306, 0.9099), (3.2383155, 0.9376)] {
            assert!((encircled(ring * std::f64::consts::PI) - want).abs() < 2e-4);
        }
        let airy = Airy::new();
        let n = 20000;
        for v in [1.0, 3.8317, 7.0, 30.0] {
            let within = (0..n).filter(|i| airy.draw((f64::from(*i) + 0.5) / f64::from(n)) < v).count();
            let want = encircled(v) / encircled(Airy::END);
            assert!((within as f64 / f64::from(n) - want).abs() < 1e-3, "{v}");
        }
        // The density drawn by is a mean of the pattern's over a step.
        for v in [0.5, 2.0, 5.0] {
            assert!((airy.drawn(v) / density(v) * encircled(Airy::END) - 1.0).abs() < 0.1, "{v}");
        }
    }
}
