//! Run-time choice of the instruction set.
//!
//! The default build must be fast on AVX2 and AVX-512 without flags, so hot loops are compiled once for each and picked
//! here. Rust never fuses a multiply with an add by itself: every choice gives the same bits.

use std::sync::OnceLock;

/// Runs `f` compiled for the widest instruction set this processor has. `f` and what it calls must be inlined
/// (`#[inline(always)]`), or they stay compiled for the baseline.
#[inline(always)]
pub fn wide<R>(f: impl FnOnce() -> R) -> R {
    static ARCH: OnceLock<pulp::Arch> = OnceLock::new();
    ARCH.get_or_init(pulp::Arch::new).dispatch(f)
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
