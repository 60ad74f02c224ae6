//! K numbers side by side, padded to whole SIMD registers.

/// Values a group: one AVX2 register of f32, half an AVX-512 one.
pub const GROUP: usize = 8;

/// 8 G values, one a wavelength; those beyond the last wavelength are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const G: usize>(pub [[f32; GROUP]; G]);

/// Which of some shares, that sum to 1, a number in 0..1 chooses; never one of nothing, unless all are.
pub fn chosen(shares: &[f32], lot: f32) -> usize {
    let mut left = lot;
    let mut last = 0;
    for (i, share) in shares.iter().enumerate().filter(|s| *s.1 > 0.0) {
        last = i;
        if left < *share {
            break;
        }
        left -= share;
    }
    last
}

/// By value: what is read and what is written cannot be the same memory, and the loop becomes a vector. (The standard library's
/// loops over arrays would be compiled for the baseline.)
#[inline(always)]
fn each(a: [f32; GROUP], b: [f32; GROUP], f: impl Fn(f32, f32) -> f32) -> [f32; GROUP] {
    let mut out = [0f32; GROUP];
    for i in 0..GROUP {
        out[i] = f(a[i], b[i]);
    }
    out
}

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
            *a = each(*a, *b, |a, b| a * b);
        }
    }

    /// Lane by lane product with a function of others. All lanes are one row for it: of a long function the compiler would make vectors
    /// across groups, gathered and scattered.
    #[inline(always)]
    pub fn multiply_by(&mut self, [a, b]: [&Self; 2], f: impl Fn(f32, f32) -> f32) {
        let (a, b) = (a.0.as_flattened(), b.0.as_flattened());
        for ((lane, a), b) in self.0.as_flattened_mut().iter_mut().zip(a).zip(b) {
            *lane *= f(*a, *b);
        }
    }

    /// Every lane times k.
    #[inline(always)]
    pub fn scale(&mut self, k: f32) {
        for a in &mut self.0 {
            *a = each(*a, [k; GROUP], |a, k| a * k);
        }
    }

    /// Adds k to every lane.
    #[inline(always)]
    pub fn add(&mut self, k: f32) {
        for a in &mut self.0 {
            *a = each(*a, [k; GROUP], |a, k| a + k);
        }
    }

    /// Adds k times others.
    #[inline(always)]
    pub fn add_scaled(&mut self, other: &Self, k: f32) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a = each(*a, *b, |a, b| a + k * b);
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
        for (out, (a, b)) in out.0.iter_mut().zip(self.0.iter().zip(&other.0)) {
            *out = each(*a, *b, &f);
        }
        out
    }

    /// Sum of products.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> f32 {
        let mut sums = [0f32; GROUP];
        for (a, b) in self.0.iter().zip(&other.0) {
            sums = each(sums, each(*a, *b, |a, b| a * b), |sum, product| sum + product);
        }
        let pairs = [sums[0] + sums[4], sums[1] + sums[5], sums[2] + sums[6], sums[3] + sums[7]];
        (pairs[0] + pairs[2]) + (pairs[1] + pairs[3])
    }

    /// The largest lane; lanes are not negative, and those beyond the last wavelength do not count where they are 0.
    #[inline(always)]
    pub fn largest(&self) -> f32 {
        let mut top = [0f32; GROUP];
        for a in &self.0 {
            top = each(top, *a, |a, b| if b > a { b } else { a });
        }
        top.into_iter().fold(0.0, |a, b| if b > a { b } else { a })
    }
}
