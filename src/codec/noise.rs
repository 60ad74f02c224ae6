//! Noise for dithering: a number for each pixel and channel that does not depend on threads, blocks or time.

/// In steps: the largest LogLuv codes of floats come this near to the middle.
const MARGIN: f64 = 1e-4;

/// From -1/2 to 1/2, evenly spread, less a little at both ends: what was read back from the middle of a step, and rounded to a
/// float, stays in it.
#[inline]
pub fn offset(x: usize, y: usize, channel: usize) -> f64 {
    let mut h = (x as u64) << 32 ^ (y as u64) << 2 ^ channel as u64;
    // The finaliser of splitmix64 mixes all bits [Steele 2014].
    h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^= h >> 31;
    (1.0 - 2.0 * MARGIN) * ((h >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
}
