//! Mean, extremes and percentiles of any number of values, in memory that does not grow with them.

/// Bits of a value as f32 that its bin leaves out: 1024 bins an octave stay.
const DROPPED: u32 = 13;

/// How values are distributed: 8 MB, however many they are.
///
/// A percentile is the mean of the bin it falls into, so within 1 part in 1024, and exact where the values of that bin are
/// equal. Values added in the same order give the same bits.
///
/// ```
/// let mut d = luxpipe::statistics::Distribution::default();
/// (1..=1000).for_each(|i| d.add(f64::from(i)));
/// assert_eq!((d.count(), d.mean(), d.max()), (1000, Some(500.5), Some(1000.0)));
/// assert!((d.percentile(95.0).unwrap() / 950.0 - 1.0).abs() < 1.0 / 1024.0);
/// ```
#[derive(Clone, Debug)]
pub struct Distribution {
    counts: Vec<u64>,
    sums: Vec<f64>,
    count: u64,
    sum: f64,
    max: f64,
}

impl Default for Distribution {
    fn default() -> Self {
        let bins = 1 << (32 - DROPPED);
        Distribution { counts: vec![0; bins], sums: vec![0.0; bins], count: 0, sum: 0.0, max: f64::NEG_INFINITY }
    }
}

impl Distribution {
    /// Counts a finite value.
    pub fn add(&mut self, x: f64) {
        let i = bin(x);
        self.counts[i] += 1;
        self.sums[i] += x;
        self.count += 1;
        self.sum += x;
        self.max = self.max.max(x);
    }

    /// How many values there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; `None` of none.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// The largest; `None` of none.
    pub fn max(&self) -> Option<f64> {
        (self.count > 0).then_some(self.max)
    }

    /// The smallest value that at least `percent` of all do not exceed (nearest rank); `None` of none.
    pub fn percentile(&self, percent: f64) -> Option<f64> {
        let rank = ((percent / 100.0 * self.count as f64).ceil() as u64).max(1);
        let mut below = 0;
        let found = self.counts.iter().position(|n| {
            below += n;
            below >= rank
        });
        found.map(|i| self.sums[i] / self.counts[i] as f64)
    }
}

/// Bins ascend with the value: the bits of a float do, once those of negatives are turned.
fn bin(x: f64) -> usize {
    let bits = (x as f32).to_bits();
    let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    (ascending >> DROPPED) as usize
}

/// A number that stands for bytes, the same on every machine and in every version: FNV-1a [Fowler 1991].
///
/// ```
/// assert_eq!(luxpipe::statistics::fnv1a(b"foobar"), 0x85944171f73967e8);
/// ```
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// A number drawn from a number, as the finalizer of [Steele 2014]: equal for equal, else as good as random.
pub fn scrambled(n: u64) -> u64 {
    let z = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The normal distribution: the share below `x` standard deviations, by its power series [Marsaglia 2004].
///
/// ```
/// use luxpipe::statistics::normal_cdf;
/// assert!((normal_cdf(1.0) - 0.841344746068543).abs() < 1e-14);
/// assert!((normal_cdf(-1.96) - 0.0249978951482204).abs() < 1e-14);
/// assert_eq!((normal_cdf(-9.0), normal_cdf(9.0)), (0.0, 1.0));
/// ```
pub fn normal_cdf(x: f64) -> f64 {
    if x.abs() > 8.0 || x.is_nan() {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut sum, mut term, mut n) = (x, x, 1.0);
    while term.abs() > 1e-18 * sum.abs() {
        n += 2.0;
        term *= x * x / n;
        sum += term;
    }
    0.5 + sum * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn percentiles_are_those_of_a_sorted_list(mut values in prop::collection::vec(-1e6f64..1e6, 1..200), p in 0.0f64..100.0) {
            let mut d = Distribution::default();
            values.iter().for_each(|x| d.add(*x));
            values.sort_by(f64::total_cmp);
            let rank = ((p / 100.0 * values.len() as f64).ceil() as usize).max(1);
            let (got, want) = (d.percentile(p).unwrap(), values[rank - 1]);
            prop_assert!((got - want).abs() <= want.abs() / 1024.0 + 1e-38, "{got} {want}");
        }
    }

    #[test]
    fn equal_values_come_back_exactly_and_none_is_none() {
        let mut d = Distribution::default();
        assert_eq!((d.mean(), d.max(), d.percentile(50.0)), (None, None, None));
        (0..10).for_each(|_| d.add(0.1));
        assert!((d.percentile(99.0).unwrap() - 0.1).abs() < 1e-16);
        [f64::from(f32::MAX), 1e300, -1e300, 0.0, -0.0].iter().for_each(|x| d.add(*x));
        assert_eq!(d.percentile(0.0), Some(-1e300));
        assert_eq!(d.percentile(100.0), Some(1e300));
    }
}
