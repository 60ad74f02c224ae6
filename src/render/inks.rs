//! A scene's spectra in lanes, and what a tint makes of light that comes by.

use crate::material::{Base, Ink, Tint, fresnel, tint};
use crate::render::lanes::{GROUP, Lanes};
use crate::spectral::{Sampling, Spectrum};

/// A scene's inks sampled to 8 G lanes.
pub struct Inks<const G: usize> {
    inks: Vec<Sampled<G>>,
    rgb: [Lanes<G>; 3],
}

/// One ink in lanes.
enum Sampled<const G: usize> {
    One(Lanes<G>),
    Index(Lanes<G>, Lanes<G>),
}

impl<const G: usize> Inks<G> {
    /// Samples a scene's inks and the basis of its RGB colours.
    pub fn new(inks: &[Ink], rgb: &[Spectrum; 3], sampling: &Sampling) -> Self {
        Self::by(inks, rgb, |s| Lanes::from_values(&sampling.sample(s)))
    }

    fn by(inks: &[Ink], rgb: &[Spectrum; 3], lanes: impl Fn(&Spectrum) -> Lanes<G>) -> Self {
        let sampled = |ink: &Ink| match ink {
            Ink::Reflectance(s) | Ink::Depth(s) => Sampled::One(lanes(s)),
            Ink::Index { n, k } => Sampled::Index(lanes(n), lanes(k)),
        };
        Inks { inks: inks.iter().map(sampled).collect(), rgb: rgb.each_ref().map(lanes) }
    }

    #[inline(always)]
    fn one(&self, i: u32) -> &Lanes<G> {
        match &self.inks[i as usize] {
            Sampled::One(lanes) | Sampled::Index(lanes, _) => lanes,
        }
    }

    /// A base that is no plain ink.
    #[inline(always)]
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

    /// What a tint leaves of light; `cos_half` is the cosine between half vector and direction.
    #[inline(always)]
    pub fn tint(&self, light: &mut Lanes<G>, tint: &Tint, cos_half: f32) {
        match tint {
            Tint::Base(Base::Ink(i)) => light.multiply(self.one(*i)),
            Tint::Base(Base::Grey(r)) => light.scale(*r),
            other => self.tint_slowly(light, other, cos_half),
        }
    }

    #[inline(never)]
    fn tint_slowly(&self, light: &mut Lanes<G>, tint: &Tint, cos_half: f32) {
        match tint {
            Tint::None => {}
            Tint::Base(base) => light.multiply(&self.mixed(base)),
            Tint::Beneath(base, k) => light.multiply(&self.mixed(base).map(|r| tint::beneath(r, *k))),
            Tint::Metal(i) => {
                if let Sampled::Index(n, k) = &self.inks[*i as usize] {
                    light.multiply(&n.map2(k, |n, k| fresnel::conductor(cos_half, n, k)));
                }
            }
            Tint::Repeated { mean, albedo } => light.multiply(&self.one(*mean).map(|r| tint::repeated(r, *albedo))),
            Tint::Panes { depth, stack, back } => {
                light.multiply(&self.one(*depth).map(|d| stack.share(d, *back)));
            }
        }
    }
}

/// Eight numbers for any number of wavelengths: how much a path still carries of what counts, near enough for the lots that
/// decide whether it goes on. Each stands for an eighth of the wavelengths, by their mean: a path is worth about the same however
/// finely its wavelengths are divided, and never nothing where there is something.
pub struct Outline {
    inks: Inks<1>,
    /// How much each eighth counts in X, Y and Z: the largest of the three sums is what a path is worth. `None` where every
    /// wavelength is asked for by itself, and the largest counts.
    shares: Option<[Lanes<1>; 3]>,
}

impl Outline {
    /// `counts` says how much each wavelength counts in three sums, `None` that each is asked for by itself; where none counts in
    /// a sum, all do.
    pub fn new(inks: &[Ink], rgb: &[Spectrum; 3], sampling: &Sampling, counts: Option<&[Vec<f64>; 3]>) -> Outline {
        let each = sampling.count().div_ceil(GROUP);
        let all = vec![1.0; sampling.count()];
        let or_all = |c: &[f64]| if c.iter().sum::<f64>() > 0.0 { c.to_vec() } else { all.clone() };
        let share = |c: &[f64]| {
            let c = or_all(c);
            let total: f64 = c.iter().sum();
            Lanes::from_values(&c.chunks(each).map(|c| c.iter().sum::<f64>() / total).collect::<Vec<_>>())
        };
        let shares = counts.map(|c| c.each_ref().map(|c| share(c.as_slice())));
        let joint = |[x, y, z]: &[Vec<f64>; 3]| (0..all.len()).map(|i| x[i] + y[i] + z[i]).collect::<Vec<_>>();
        let counts = counts.map_or_else(|| all.clone(), |c| or_all(&joint(c)));
        let sums: Vec<f64> = counts.chunks(each).map(|c| c.iter().sum()).collect();
        let mean = |values: &[f64], counts: &[f64], sum: f64| match sum {
            0.0 => values.iter().sum::<f64>() / values.len() as f64,
            sum => values.iter().zip(counts).map(|(v, c)| v * c).sum::<f64>() / sum,
        };
        let lanes = |s: &Spectrum| {
            let values = sampling.sample(s);
            let parts = values.chunks(each).zip(counts.chunks(each)).zip(&sums);
            Lanes::from_values(&parts.map(|((v, c), sum)| mean(v, c, *sum)).collect::<Vec<_>>())
        };
        Outline { inks: Inks::by(inks, rgb, lanes), shares }
    }

    /// What a tint leaves.
    #[inline]
    pub fn tint(&self, carried: &mut Lanes<1>, tint: &Tint, cos_half: f32) {
        self.inks.tint(carried, tint, cos_half);
    }

    /// How much that is in all.
    #[inline]
    pub fn value(&self, carried: &Lanes<1>) -> f32 {
        match &self.shares {
            Some(shares) => {
                let [x, y, z] = shares;
                carried.dot(x).max(carried.dot(y)).max(carried.dot(z))
            }
            None => carried.largest(),
        }
    }
}
