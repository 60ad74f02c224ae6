//! K numbers side by side, padded to whole SIMD registers, and what a path makes of them.

use crate::material::{Base, Ink, Tint, fresnel, tint};
use crate::spectral::{Sampling, Spectrum};

/// Values a group: one AVX2 register of f32, half an AVX-512 one.
pub const GROUP: usize = 8;

/// 8 G values, one a wavelength; those beyond the last wavelength are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const G: usize>(pub [[f32; GROUP]; G]);

impl<const G: usize> Lanes<G> {
    /// Every lane the same.
    pub const fn splat(x: f32) -> Self {
        Lanes([[x; GROUP]; G])
    }

    /// From at most 8 G values, padded with 0.
    pub fn from_values(values: &[f64]) -> Self {
        let mut lanes = Self::splat(0.0);
        lanes.0.as_flattened_mut().iter_mut().zip(values).for_each(|(l, v)| *l = *v as f32);
        lanes
    }

    /// Lane by lane product.
    #[inline(always)]
    pub fn multiply(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            for i in 0..GROUP {
                a[i] *= b[i];
            }
        }
    }

    /// Every lane times k.
    #[inline(always)]
    pub fn scale(&mut self, k: f32) {
        self.0.as_flattened_mut().iter_mut().for_each(|x| *x *= k);
    }

    /// Adds k times others.
    #[inline(always)]
    pub fn add_scaled(&mut self, other: &Self, k: f32) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            for i in 0..GROUP {
                a[i] += k * b[i];
            }
        }
    }

    /// A function of every lane.
    #[inline(always)]
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        self.map2(self, |x, _| f(x))
    }

    /// A function of every pair of lanes.
    #[inline(always)]
    pub fn map2(&self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = Self::splat(0.0);
        for (g, (a, b)) in self.0.iter().zip(&other.0).enumerate() {
            for i in 0..GROUP {
                out.0[g][i] = f(a[i], b[i]);
            }
        }
        out
    }

    /// Sum of products.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> f32 {
        let mut sums = [0f32; GROUP];
        for (a, b) in self.0.iter().zip(&other.0) {
            for i in 0..GROUP {
                sums[i] += a[i] * b[i];
            }
        }
        let pairs = [sums[0] + sums[4], sums[1] + sums[5], sums[2] + sums[6], sums[3] + sums[7]];
        (pairs[0] + pairs[2]) + (pairs[1] + pairs[3])
    }

    /// The largest lane; lanes are not negative.
    #[inline(always)]
    pub fn largest(&self) -> f32 {
        // Plain comparisons: f32::max would also look for NaN, at several times the price.
        let larger = |a: f32, b: f32| if b > a { b } else { a };
        let mut top = [0f32; GROUP];
        for a in &self.0 {
            for i in 0..GROUP {
                top[i] = larger(top[i], a[i]);
            }
        }
        let half: [f32; 4] = std::array::from_fn(|i| larger(top[i], top[i + 4]));
        larger(larger(half[0], half[2]), larger(half[1], half[3]))
    }
}

/// The linear map from radiance where a path has got to, to radiance at the eye.
///
/// [`Diagonal`] is that of Eq. (1), where each wavelength goes its own way. Polarised light needs a Mueller matrix a lane,
/// fluorescence a reradiation matrix between lanes: each is a type of its own with its own inks and films, and a scene
/// without them never sees it.
pub trait Throughput: Clone + Send {
    /// The scene's spectra, sampled to the lanes once.
    type Inks: Send + Sync;

    /// The map of a path without events.
    fn identity(inks: &Self::Inks) -> Self;

    /// Puts a surface's tint at the far end; `cos_half` is the cosine between half vector and direction. Returns the most that
    /// any wavelength kept of what it had, or 1 where finding out costs more than it is worth.
    fn tint(&mut self, inks: &Self::Inks, tint: &Tint, cos_half: f32) -> f32;

    /// Multiplies the map by a number.
    fn scale(&mut self, k: f32);

    /// The most that any light could gain, for roulette.
    fn largest(&self) -> f32;
}

/// One factor a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagonal<const G: usize>(pub Lanes<G>);

/// A scene's inks sampled to lanes.
pub struct Inks<const G: usize> {
    inks: Vec<Sampled<G>>,
    rgb: [Lanes<G>; 3],
    /// 1 for each wavelength, 0 beyond the last.
    live: Lanes<G>,
}

/// One ink in lanes.
enum Sampled<const G: usize> {
    /// With its largest lane.
    One(Lanes<G>, f32),
    Index(Lanes<G>, Lanes<G>),
}

impl<const G: usize> Inks<G> {
    /// Samples a scene's inks and the basis of its RGB colours.
    pub fn new(inks: &[Ink], rgb: &[Spectrum; 3], sampling: &Sampling) -> Self {
        let lanes = |s: &Spectrum| Lanes::from_values(&sampling.sample(s));
        let sampled = |ink: &Ink| match ink {
            Ink::Reflectance(s) | Ink::Depth(s) => {
                let lanes = lanes(s);
                Sampled::One(lanes, lanes.largest())
            }
            Ink::Index { n, k } => Sampled::Index(lanes(n), lanes(k)),
        };
        let live = Lanes::from_values(&vec![1.0; sampling.count()]);
        Inks { inks: inks.iter().map(sampled).collect(), rgb: rgb.each_ref().map(lanes), live }
    }

    #[inline(always)]
    fn one(&self, i: u32) -> &Lanes<G> {
        match &self.inks[i as usize] {
            Sampled::One(lanes, _) | Sampled::Index(lanes, _) => lanes,
        }
    }

    #[inline(always)]
    fn most(&self, i: u32) -> f32 {
        match &self.inks[i as usize] {
            Sampled::One(_, most) => *most,
            Sampled::Index(..) => 1.0,
        }
    }

    /// A base that is no plain ink.
    fn mixed(&self, base: &Base) -> Lanes<G> {
        match base {
            Base::Grey(r) => Lanes::splat(*r),
            Base::Ink(i) => *self.one(*i),
            Base::Rgb(c) => {
                let mut sum = Lanes::splat(0.0);
                for (basis, c) in self.rgb.iter().zip(c) {
                    sum.add_scaled(basis, *c);
                }
                sum
            }
        }
    }
}

impl<const G: usize> Throughput for Diagonal<G> {
    type Inks = Inks<G>;

    #[inline(always)]
    fn identity(inks: &Inks<G>) -> Self {
        Diagonal(inks.live)
    }

    #[inline(always)]
    fn tint(&mut self, inks: &Inks<G>, tint: &Tint, cos_half: f32) -> f32 {
        match tint {
            Tint::None => 1.0,
            Tint::Base(Base::Ink(i)) => {
                self.0.multiply(inks.one(*i));
                inks.most(*i)
            }
            Tint::Base(Base::Grey(r)) => {
                self.0.scale(*r);
                *r
            }
            other => {
                self.tint_slowly(inks, other, cos_half);
                1.0
            }
        }
    }

    #[inline(always)]
    fn scale(&mut self, k: f32) {
        self.0.scale(k);
    }

    #[inline(always)]
    fn largest(&self) -> f32 {
        self.0.largest()
    }
}

impl<const G: usize> Diagonal<G> {
    #[inline(never)]
    fn tint_slowly(&mut self, inks: &Inks<G>, tint: &Tint, cos_half: f32) {
        match tint {
            Tint::None => {}
            Tint::Base(base) => self.0.multiply(&inks.mixed(base)),
            Tint::Beneath(base, k) => self.0.multiply(&inks.mixed(base).map(|r| tint::beneath(r, *k))),
            Tint::Metal(i) => {
                if let Sampled::Index(n, k) = &inks.inks[*i as usize] {
                    self.0.multiply(&n.map2(k, |n, k| fresnel::conductor(cos_half, n, k)));
                }
            }
            Tint::Repeated { mean, albedo } => self.0.multiply(&inks.one(*mean).map(|r| tint::repeated(r, *albedo))),
            Tint::Panes { depth, stack, back } => {
                self.0.multiply(&inks.one(*depth).map(|d| stack.share(d, *back)));
            }
        }
    }
}
