//! Low-discrepancy points: Sobol's first two dimensions, Owen-scrambled by hashes, a fresh shuffle and scramble for every
//! pair of dimensions [Burley 2020]. A pixel's points depend on its place, the seed and nothing else.

use crate::simd;

/// The points of one sample of one pixel.
#[derive(Clone, Debug)]
pub struct Sampler {
    seed: u32,
    /// The sample's number, its bits from the other end.
    reversed: u32,
}

/// Tell the scrambles of the two dimensions of a pair apart.
const FIRST: u32 = 0x68bc_21eb;
const SECOND: u32 = 0x02e5_be93;

impl Sampler {
    /// Sample number `index` of the pixel at (x, y).
    pub fn new(x: u32, y: u32, index: u32, seed: u32) -> Sampler {
        let pixel = hash(hash(x ^ hash(seed)) ^ y);
        Sampler { seed: pixel, reversed: index.reverse_bits() }
    }

    /// The sample's number.
    pub fn index(&self) -> u32 {
        self.reversed.reverse_bits()
    }

    /// The points of path `k` of `count` into which this sample's path splits: one net over all samples and splits.
    #[inline]
    pub fn branch(&self, k: u32, count: u32) -> Sampler {
        let index = self.reversed.reverse_bits().wrapping_mul(count).wrapping_add(k);
        Sampler { seed: self.seed ^ 0x85eb_ca6b, reversed: index.reverse_bits() }
    }

    /// Point number `pair` of the unit square: dimensions 2 pair and 2 pair + 1.
    #[inline]
    pub fn pair(&self, pair: u32) -> [f32; 2] {
        let seed = self.of_pair(pair);
        // Scrambling the index shuffles the sequence and leaves every aligned run of 2^m points a net.
        let index = laine_karras(self.reversed, seed).reverse_bits();
        [unit(scramble(index, hash(seed ^ FIRST))), unit(scramble(pascal(index), hash(seed ^ SECOND)))]
    }

    /// Points number `pair`, `pair` + 1 and `pair` + 2, side by side in the processor: the same as [`Sampler::pair`] gives.
    #[inline]
    pub fn three(&self, pair: u32) -> [[f32; 2]; 3] {
        let mut out = [0f32; 8];
        simd::wide(
            #[inline(always)]
            || {
                // Of the four numbers of a half the last is not used.
                let (mut seeds, mut index) = ([0u32; 8], [0u32; 8]);
                for i in 0..4 {
                    let seed = self.of_pair(pair.wrapping_add(i as u32));
                    let shuffled = laine_karras(self.reversed, seed).reverse_bits();
                    (seeds[i], seeds[i + 4]) = (seed ^ FIRST, seed ^ SECOND);
                    (index[i], index[i + 4]) = (shuffled, pascal(shuffled));
                }
                for i in 0..8 {
                    out[i] = unit(scramble(index[i], hash(seeds[i])));
                }
            },
        );
        [0, 1, 2].map(|i| [out[i], out[i + 4]])
    }

    /// Brings things into an order of the sample's own, another for another `salt`; each is as likely as the others.
    pub fn shuffle<T>(&self, salt: u32, things: &mut [T]) {
        let mut lot = hash(self.seed ^ hash(self.reversed ^ hash(salt)));
        for last in (1..things.len()).rev() {
            lot = hash(lot.wrapping_add(0x9e37_79b9));
            // The high half of the product: a number in 0..=last.
            let chosen = (u64::from(lot) * (last as u64 + 1)) >> 32;
            things.swap(last, chosen as usize);
        }
    }

    #[inline(always)]
    fn of_pair(&self, pair: u32) -> u32 {
        hash(self.seed.wrapping_add(pair.wrapping_mul(0x9e37_79b9)))
    }
}

/// The largest number up to `count` that shares a pixel well: four to seven times a power of two, or less than four, so that its
/// points are a few whole nets.
///
/// ```
/// # use luxpipe::render::sampler::shared_well;
/// assert_eq!([1, 7, 64, 666, 900].map(shared_well), [1, 7, 64, 640, 896]);
/// ```
pub fn shared_well(count: u32) -> u32 {
    let low = count.max(1).ilog2().saturating_sub(2);
    count >> low << low
}

/// Sobol's second dimension with its bits reversed: the Pascal matrix modulo 2, a sum over supersets of each bit index.
#[inline(always)]
fn pascal(mut x: u32) -> u32 {
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^ ((x >> 16) & 0x0000_ffff)
}

/// Owen scrambling of a number whose bits stand reversed; returns it the right way round.
#[inline(always)]
fn scramble(reversed: u32, seed: u32) -> u32 {
    laine_karras(reversed, seed).reverse_bits()
}

/// Each bit is flipped by a hash of the bits below it.
#[inline(always)]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x
}

/// A 32-bit mixer (lowbias32, Wellons 2018).
#[inline(always)]
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// 24 bits to 0 <= u < 1.
#[inline(always)]
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every elementary interval of a (0, m, 2)-net holds exactly one point, whatever the scramble.
    #[test]
    fn each_pair_of_dimensions_is_a_net() {
        for seed in 0..8 {
            let samplers: Vec<Sampler> = (0..64).map(|i| Sampler::new(3, 5, i, seed)).collect();
            for pair in 0..6 {
                let points: Vec<[f32; 2]> = samplers.iter().map(|s| s.pair(pair)).collect();
                for split in 0..=6 {
                    let (nx, ny) = (1 << split, 64 >> split);
                    let mut boxes = vec![0; 64];
                    for p in &points {
                        boxes[(p[0] * nx as f32) as usize * ny + (p[1] * ny as f32) as usize] += 1;
                    }
                    assert!(boxes.iter().all(|n| *n == 1), "seed {seed}, {nx} x {ny}: {boxes:?}");
                }
            }
        }
    }

    #[test]
    fn three_are_three_pairs() {
        for i in 0..100 {
            let s = Sampler::new(i, 7, i * 977, i ^ 5);
            assert_eq!(s.three(3 * i), [s.pair(3 * i), s.pair(3 * i + 1), s.pair(3 * i + 2)]);
        }
    }

    #[test]
    fn pixels_and_pairs_are_independent() {
        let n = 4096;
        let mut sum = 0.0;
        for i in 0..n {
            let a = Sampler::new(i, 0, 0, 1).pair(0)[0];
            let b = Sampler::new(i + 1, 0, 0, 1).pair(0)[0];
            sum += f64::from((a - 0.5) * (b - 0.5));
        }
        // 12 x covariance of independent uniforms has a standard deviation of 1 / sqrt(n).
        assert!((12.0 * sum / f64::from(n)).abs() < 5.0 / f64::from(n).sqrt());
    }
}
