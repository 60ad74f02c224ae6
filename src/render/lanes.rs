//! K numbers side by side, padded to whole SIMD registers, and what a path makes of them.

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

    /// The largest lane.
    #[inline(always)]
    pub fn largest(&self) -> f32 {
        let mut top = [0f32; GROUP];
        for a in &self.0 {
            for i in 0..GROUP {
                top[i] = top[i].max(a[i]);
            }
        }
        top.iter().fold(0.0, |m, x| m.max(*x))
    }
}

/// The linear map from radiance where a path has got to, to radiance at the eye.
///
/// [`Diagonal`] is that of Eq. (1), where each wavelength goes its own way. Polarised light needs a Mueller matrix a lane,
/// fluorescence a reradiation matrix between lanes: each is a type of its own with its own events and films, and a scene
/// without them never sees it.
pub trait Throughput: Clone + Send {
    /// What a surface does to light, sampled to the lanes once a scene.
    type Event: Send + Sync;

    /// The map of a path without events.
    fn identity() -> Self;

    /// Puts one more event at the far end.
    fn then(&mut self, event: &Self::Event);

    /// Multiplies the map by a number.
    fn scale(&mut self, k: f32);

    /// The most that any light could gain, for roulette.
    fn largest(&self) -> f32;
}

/// One factor a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagonal<const G: usize>(pub Lanes<G>);

impl<const G: usize> Throughput for Diagonal<G> {
    type Event = Lanes<G>;

    #[inline(always)]
    fn identity() -> Self {
        Diagonal(Lanes::splat(1.0))
    }

    #[inline(always)]
    fn then(&mut self, event: &Lanes<G>) {
        self.0.multiply(event);
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
