//! Run-time choice of the instruction set.
//!
//! The default build must be fast on AVX2 and AVX-512 without flags, so hot loops are compiled once for each and picked
//! here. Rust never fuses a multiply with an add by itself: every choice gives the same bits. `LUXPIPE_SIMD` chooses less than
//! the processor has, so that this can be seen.

use std::ffi::OsStr;
use std::sync::OnceLock;

use pulp::Arch;

use crate::{Result, usage};

/// The variable of the environment that chooses.
const VARIABLE: &str = "LUXPIPE_SIMD";

/// Runs `f` compiled for the widest instruction set this processor has. `f` and what it calls must be inlined
/// (`#[inline(always)]`), or they stay compiled for the baseline.
#[inline(always)]
pub fn wide<R>(f: impl FnOnce() -> R) -> R {
    arch().dispatch(f)
}

#[inline]
fn arch() -> &'static Arch {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    // A word that is none of them was refused before: see `check`.
    ARCH.get_or_init(|| std::env::var_os(VARIABLE).and_then(|v| named(&v)).unwrap_or_default())
}

/// The instruction set of a name, or the widest below it that this processor has.
fn named(name: &OsStr) -> Option<Arch> {
    match name.to_str()? {
        "plain" => Some(Arch::Scalar),
        #[cfg(target_arch = "x86_64")]
        "avx2" => Some(pulp::x86::V3::try_new().map_or(Arch::Scalar, Arch::V3)),
        #[cfg(not(target_arch = "x86_64"))]
        "avx2" => Some(Arch::Scalar),
        "" | "widest" => Some(Arch::new()),
        _ => None,
    }
}

/// What the environment asks for is known.
///
/// # Errors
/// A word in LUXPIPE_SIMD that is none of plain, avx2, widest.
pub fn check() -> Result<()> {
    match std::env::var_os(VARIABLE) {
        Some(word) if named(&word).is_none() => {
            usage!("{VARIABLE}={}: expected plain, avx2 or widest", word.to_string_lossy())
        }
        _ => Ok(()),
    }
}

/// AVX2, where [`wide`] may use it.
#[cfg(target_arch = "x86_64")]
pub fn avx2() -> Option<pulp::x86::V3> {
    if matches!(arch(), Arch::Scalar) { None } else { pulp::x86::V3::try_new() }
}

/// What [`wide`] chooses here, for people.
pub fn width() -> &'static str {
    match arch() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(_) => "AVX-512",
        #[cfg(target_arch = "x86_64")]
        Arch::V3(_) => "AVX2",
        _ => "no wider registers than every one of its kind",
    }
}

/// Pixels worked on together: so many that loops over them stay loops, which the compiler turns into vectors of any width, and so
/// few that all about them stays in the nearest cache.
pub const GROUP: usize = 64;

/// A row's end, made up to a group.
pub fn padded<T: Copy + Default, const N: usize>(rest: &[T]) -> [T; N] {
    let mut group = [T::default(); N];
    group[..rest.len()].copy_from_slice(rest);
    group
}

/// True when every |x| is at most `limit`, which is finite; NaN and infinities are not. Whole numbers compare as floats of one
/// sign do, and their largest is found a register at a time.
pub fn all_within(values: &[f32], limit: f32) -> bool {
    let largest = wide(
        #[inline(always)]
        || values.iter().fold(0u32, |m, x| m.max(x.to_bits() & 0x7fff_ffff)),
    );
    largest <= limit.to_bits()
}

/// x between low and high, NaN at low: what `clamp` is not.
#[inline(always)]
#[allow(clippy::manual_clamp)]
pub fn bound(x: f32, low: f32, high: f32) -> f32 {
    x.max(low).min(high)
}

/// e^x for x <= 0 within 2e-7 of it relative; 0 below -87, NaN never. Without a branch, so that loops over it become vectors.
///
/// ```
/// assert!((luxpipe::simd::exp(-1.0) - 0.36787944).abs() < 5e-8 && luxpipe::simd::exp(-1e30) == 0.0);
/// ```
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    // x = n ln 2 + r, |r| <= ln 2 / 2; ln 2 in two parts, the first of few bits.
    const ROUND: f32 = 12_582_912.0;
    let x = bound(x, -88.0, 0.0);
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (x - n * 0.693_359_4) - n * -2.121_944_4e-4;
    // Cephes' polynomial for exp(r) on that range.
    let p = 1.987_569_1e-4;
    let p = p * r + 1.398_199_9e-3;
    let p = p * r + 8.333_452e-3;
    let p = p * r + 4.166_579_6e-2;
    let p = p * r + 0.166_666_65;
    let p = p * r + 0.5;
    let value = p * r * r + r + 1.0;
    // The last bits of what was rounded are n: into the exponent without a conversion.
    let scale = f32::from_bits(rounded.to_bits().wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23);
    if x < -87.0 { 0.0 } else { value * scale }
}

#[cfg(test)]
mod tests {
    #[test]
    fn exponentials_are_those_of_the_library() {
        for i in 0..200_000 {
            let x = -(i as f32) * 4.3e-4;
            let want = f64::from(x).exp();
            assert!((f64::from(super::exp(x)) - want).abs() <= 2e-7 * want, "{x}: {} {want}", super::exp(x));
        }
        assert_eq!([super::exp(-90.0), super::exp(f32::NEG_INFINITY), super::exp(-0.0)], [0.0, 0.0, 1.0]);
    }
}
