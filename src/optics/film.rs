//! Thin films and stacks by the characteristic matrix of each layer [Abeles 1950; Born and Wolf section 1.6; Macleod]: all
//! reflections within them interfere. A stack without layers is a plain boundary.
//!
//! A band of wavelengths sees the mean over it. Where the fringes of a layer are finer than the band the phases of that layer are
//! spread evenly, so that a film of a millimetre shows what two surfaces without interference would, and not the fringes that
//! a few wavelengths happen to hit.

pub use num_complex::Complex64;

use crate::optics::polarization::Response;
use crate::spectral::Spectrum;

/// A complex index of refraction n + ik by wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Real part, above 0.
    pub n: Spectrum,
    /// Imaginary part, 0 and more.
    pub k: Spectrum,
}

impl Medium {
    /// Clear, the same at each wavelength.
    pub fn clear(n: f64) -> Medium {
        Medium { n: Spectrum::Constant(n), k: Spectrum::Constant(0.0) }
    }

    /// At a wavelength.
    pub fn at(&self, nm: f64) -> Complex64 {
        Complex64::new(self.n.at(nm), self.k.at(nm))
    }

    /// Light goes through.
    pub fn is_clear(&self) -> bool {
        self.k.range().1 <= 0.0
    }
}

/// Layers between two half spaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Where light comes from; clear.
    pub outside: Medium,
    /// From the outside on, thickness in nm.
    pub layers: Vec<(Medium, f64)>,
    /// What lies below.
    pub below: Medium,
}

/// What comes back from a stack and what goes on below it, as shares of the power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// Sent back.
    pub back: Response,
    /// Let through; 0 beyond total reflection.
    pub through: Response,
}

/// Samples of a band at most, and the fringes from which on a layer's phases are spread instead.
const MOST_SAMPLES: usize = 64;
const MOST_FRINGES: f64 = 12.0;

/// n cos(angle inside): the root that decays inwards.
fn normal(n: Complex64, sin: f64) -> Complex64 {
    let root = (n * n - sin * sin).sqrt();
    // At the edge of total reflection rounding may turn the sign.
    if root.im < 0.0 || (root.im == 0.0 && root.re < 0.0) { -root } else { root }
}

/// One layer at one wavelength: its index, and its phase 2 pi n d cos / lambda.
pub type Slab = (Complex64, Complex64);

/// Amplitudes of what comes back and goes on, s and p, fields at right angles to the way; and the power of the latter's squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes {
    /// Sent back: s, p.
    pub back: [Complex64; 2],
    /// Let through, as fields along the surface.
    pub through: [Complex64; 2],
    /// Power of these over that of the light that came; 0 beyond total reflection.
    pub power: [f64; 2],
}

/// Shares of the power at one wavelength.
///
/// ```
/// use luxpipe::optics::film::{Complex64, shares};
/// // MgF2, a quarter of 550 nm thick, on glass: R = ((1.38^2 - 1.52) / (1.38^2 + 1.52))^2.
/// let phase = Complex64::new(std::f64::consts::FRAC_PI_2, 0.0);
/// let got = shares(1.0, 1.0, &[(1.38.into(), phase)], 1.52.into()).back.mean();
/// assert!((got - 0.01260079).abs() < 1e-8);
/// ```
pub fn shares(cos: f64, outside: f64, slabs: &[Slab], below: Complex64) -> Shares {
    let Amplitudes { back: [rs, rp], through: [ts, tp], power: [s, p] } = amplitudes(cos, outside, slabs, below);
    Shares { back: Response::of(rs, rp, 1.0), through: Response::of(ts * s.sqrt(), tp * p.sqrt(), 1.0) }
}

/// Amplitudes at one wavelength: `cos` outside, a clear index there, layers from the outside on, and the index below.
pub fn amplitudes(cos: f64, outside: f64, slabs: &[Slab], below: Complex64) -> Amplitudes {
    let cos = cos.max(1e-9);
    let sin = outside * (1.0 - cos * cos).max(0.0).sqrt();
    let end = normal(below, sin);
    let one = |p: bool| -> (Complex64, Complex64, f64) {
        // Tilted admittances: n cos for s, n / cos for p.
        let admittance = |n: Complex64, normal: Complex64| if p { n * n / normal } else { normal };
        let (first, last) = (admittance(outside.into(), (outside * cos).into()).re, admittance(below, end));
        let (mut e, mut h) = (Complex64::new(1.0, 0.0), last);
        // Fields grow from below up through what absorbs: what they are divided by is kept for what goes through.
        let mut faded = 1.0;
        for (n, phase) in slabs.iter().rev() {
            let y = admittance(*n, normal(*n, sin));
            // Beyond 40 nothing comes back from the other side in double precision.
            let phase = Complex64::new(phase.re, phase.im.min(40.0));
            let (sin, cos) = (phase.sin(), phase.cos());
            let i = Complex64::I;
            (e, h) = (e * cos - h * (i * sin / y), h * cos - e * (i * sin * y));
            let size = e.norm() + h.norm();
            if size > 1e6 {
                (e, h, faded) = (e / size, h / size, faded / size);
            }
        }
        let whole = e * first + h;
        let power = if last.re > 0.0 && last.is_finite() { last.re / first } else { 0.0 };
        ((e * first - h) / whole, Complex64::from(2.0 * first * faded) / whole, power)
    };
    let ((rs, ts, power_s), (rp, tp, power_p)) = (one(false), one(true));
    // Fields at right angles to the way: p changes its sign where light turns back.
    Amplitudes { back: [rs, -rp], through: [ts, tp], power: [power_s, power_p] }
}

impl Stack {
    /// A plain boundary.
    pub fn boundary(outside: Medium, below: Medium) -> Stack {
        Stack { outside, layers: Vec::new(), below }
    }

    /// Seen from below; `below` must be clear.
    pub fn reversed(&self) -> Stack {
        let layers = self.layers.iter().rev().cloned().collect();
        Stack { outside: self.below.clone(), layers, below: self.outside.clone() }
    }

    /// Phase of a layer at a wavelength.
    fn phase(&self, layer: usize, cos: f64, nm: f64) -> Complex64 {
        let (medium, thickness_nm) = &self.layers[layer];
        let sin = self.outside.n.at(nm) * (1.0 - cos * cos).max(0.0).sqrt();
        normal(medium.at(nm), sin) * (std::f64::consts::TAU * thickness_nm / nm)
    }

    /// Whole fringes that all layers make between two wavelengths.
    pub fn fringes(&self, cos: f64, low_nm: f64, high_nm: f64) -> f64 {
        let turns = |l: usize| (self.phase(l, cos, low_nm).re - self.phase(l, cos, high_nm).re).abs();
        (0..self.layers.len()).map(turns).sum::<f64>() / std::f64::consts::PI
    }

    /// Fringes from the normal to grazing light at a wavelength.
    pub fn turns(&self, nm: f64) -> f64 {
        let turns = |l: usize| (self.phase(l, 1.0, nm).re - self.phase(l, 0.0, nm).re).abs();
        (0..self.layers.len()).map(turns).sum::<f64>() / std::f64::consts::PI
    }

    /// At one wavelength, `cos` the cosine outside.
    pub fn at(&self, cos: f64, nm: f64) -> Shares {
        let slab = |l: usize| (self.layers[l].0.at(nm), self.phase(l, cos, nm));
        let slabs: Vec<Slab> = (0..self.layers.len()).map(slab).collect();
        shares(cos, self.outside.n.at(nm), &slabs, self.below.at(nm))
    }

    /// The mean over a band.
    pub fn mean(&self, cos: f64, low_nm: f64, high_nm: f64) -> Shares {
        if low_nm == high_nm || self.layers.is_empty() {
            return self.at(cos, 0.5 * (low_nm + high_nm));
        }
        let each: Vec<f64> = (0..self.layers.len())
            .map(|l| (self.phase(l, cos, low_nm).re - self.phase(l, cos, high_nm).re).abs() / std::f64::consts::PI)
            .collect();
        let fine: f64 = each.iter().filter(|f| **f <= MOST_FRINGES).sum();
        let spread = each.iter().any(|f| *f > MOST_FRINGES);
        let samples = if spread { MOST_SAMPLES } else { (4.0 * fine).ceil() as usize + 2 }.min(MOST_SAMPLES);
        let mut sum = Shares::default();
        for i in 0..samples {
            let nm = low_nm + (high_nm - low_nm) * (i as f64 + 0.5) / samples as f64;
            let slab = |l: usize| {
                let mut phase = self.phase(l, cos, nm);
                if each[l] > MOST_FRINGES {
                    // Points of a lattice, the wavelength one dimension of it and each thick layer another.
                    let step = [19, 27, 43, 11, 5, 35][l % 6];
                    phase.re = std::f64::consts::PI * (step * i % samples) as f64 / samples as f64;
                }
                (self.layers[l].0.at(nm), phase)
            };
            let slabs: Vec<Slab> = (0..self.layers.len()).map(slab).collect();
            let one = shares(cos, self.outside.n.at(nm), &slabs, self.below.at(nm));
            sum = Shares { back: sum.back.plus(one.back), through: sum.through.plus(one.through) };
        }
        let k = 1.0 / samples as f64;
        Shares { back: sum.back.scaled(k), through: sum.through.scaled(k) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel;

    #[test]
    fn a_stack_without_layers_is_fresnel() {
        for deg in [0.0, 30.0, 56.309932, 80.0, 89.0] {
            let cos = f64::to_radians(deg).cos();
            for (outside, below) in [(1.0, 1.5), (1.5, 1.0), (1.0, 1.0)] {
                let got = shares(cos, outside, &[], below.into());
                let (s, p, _) = fresnel::polarised(cos, below / outside);
                assert!((got.back.s - s).abs() < 1e-10 && (got.back.p - p).abs() < 1e-10, "{deg} {outside}");
                assert!((got.through.s + s - 1.0).abs() < 1e-10 && (got.through.p + p - 1.0).abs() < 1e-10, "{deg}");
            }
            let (s, p, retardance) = fresnel::conductor_polarised(cos, 0.43, 2.455);
            let got = shares(cos, 1.0, &[], Complex64::new(0.43, 2.455)).back;
            assert!((got.s - s).abs() < 1e-12 && (got.p - p).abs() < 1e-12);
            // arg(-rp conj(rs)) = arg of -conj(rs conj(rp)).
            let cross = -got.cross.conj();
            assert!((cross.im.atan2(cross.re).to_degrees().abs() - retardance).abs() < 1e-9);
        }
    }

    /// Power that enters each layer and does not leave it is what it absorbs: with what comes back and goes through it is all.
    #[test]
    fn nothing_is_lost() {
        let n = [Complex64::new(1.38, 0.0), Complex64::new(2.3, 0.0), Complex64::new(1.46, 0.0)];
        for deg in [0.0, 20.0, 55.0, 75.0, 89.0] {
            let cos = f64::to_radians(deg).cos();
            let slabs: Vec<Slab> = n.iter().map(|n| (*n, normal(*n, f64::to_radians(deg).sin()) * 2.1)).collect();
            let got = shares(cos, 1.0, &slabs, 1.52.into());
            for (r, t) in [(got.back.s, got.through.s), (got.back.p, got.through.p)] {
                assert!((r + t - 1.0).abs() < 1e-12, "{deg}: {r} + {t}");
            }
            // Through or back, from either side: the same power.
            let sin_below = f64::to_radians(deg).sin() / 1.52;
            let other: Vec<Slab> = slabs.iter().rev().copied().collect();
            let back = shares((1.0 - sin_below * sin_below).sqrt(), 1.52, &other, 1.0.into());
            assert!((back.through.s - got.through.s).abs() < 1e-12 && (back.through.p - got.through.p).abs() < 1e-12);
        }
    }

    /// Layers in which all light ends are the half space of their medium, however many there are.
    #[test]
    fn thick_metals_do_not_overflow() {
        let metal = Medium { n: Spectrum::Constant(1.5), k: Spectrum::Constant(3.0) };
        for count in [1, 9, 30, 64] {
            let layers = vec![(metal.clone(), 1e5); count];
            let stack = Stack { outside: Medium::clear(1.0), layers, below: Medium::clear(1.5) };
            for deg in [0.0, 45.0, 89.0] {
                let cos = f64::to_radians(deg).cos();
                let (got, want) = (stack.at(cos, 550.0), shares(cos, 1.0, &[], Complex64::new(1.5, 3.0)));
                assert!((got.back.mean() - want.back.mean()).abs() < 1e-9, "{count} {deg}: {:?}", got.back);
                assert!(got.through.mean().abs() < 1e-30);
            }
        }
    }

    /// A thin layer under a thick one interferes with itself alone: as a sum over many wavelengths says.
    #[test]
    fn thick_and_thin_layers_do_not_mix() {
        let layers = vec![(Medium::clear(1.5), 1e6), (Medium::clear(2.3), 10_000.0)];
        let stack = Stack { outside: Medium::clear(1.0), layers, below: Medium::clear(3.5) };
        let n = 200_000;
        let nm = |i: i32| 532.5 + 5.0 * (f64::from(i) + 0.5) / f64::from(n);
        let want = (0..n).map(|i| stack.at(1.0, nm(i)).back.mean()).sum::<f64>() / f64::from(n);
        let got = stack.mean(1.0, 532.5, 537.5).back.mean();
        assert!((got / want - 1.0).abs() < 0.02, "{got} for {want}");
    }

    /// A film of a millimetre is two surfaces without interference, whatever the band; one of no thickness is none.
    #[test]
    fn fringes_finer_than_the_band_are_averaged() {
        let film = |nm: f64| Stack {
            outside: Medium::clear(1.0),
            layers: vec![(Medium::clear(1.33), nm)],
            below: Medium::clear(1.0),
        };
        for deg in [0.0, 45.0, 75.0] {
            let cos = f64::to_radians(deg).cos();
            let (s, p, _) = fresnel::polarised(cos, 1.33);
            let got = film(1e6).mean(cos, 547.5, 552.5).back;
            for (got, r) in [(got.s, s), (got.p, p)] {
                assert!((got - 2.0 * r / (1.0 + r)).abs() < 1e-5, "{deg}: {got} for {}", 2.0 * r / (1.0 + r));
            }
            assert!(film(0.0).mean(cos, 540.0, 560.0).back.mean() < 1e-15);
            // Just below the fringes from which phases are spread the mean over wavelengths says about the same.
            let thick = film(1.0e6 * MOST_FRINGES / film(1e6).fringes(cos, 547.5, 552.5) * 0.99);
            assert!(
                (thick.mean(cos, 547.5, 552.5).back.mean() / (2.0 * 0.5 * (s / (1.0 + s) + p / (1.0 + p))) - 1.0).abs()
                    < 0.05
            );
        }
    }
}
