//! Eight floats at a time, by AVX2 where the processor has it and by plain arrays elsewhere.
//!
//! Nothing is fused and minima are `a < b ? a : b` in both: they give the same bits.

/// Operations on eight floats, lane by lane.
pub trait Eight: Copy {
    /// Eight floats.
    type F: Copy;

    /// Runs `f`, which must be inlined all the way down, compiled for this instruction set.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;
    /// The same number eight times.
    fn splat(self, x: f32) -> Self::F;
    /// From memory.
    fn load(self, x: &[f32; 8]) -> Self::F;
    /// To memory.
    fn store(self, x: Self::F) -> [f32; 8];
    /// a + b.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a - b.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a / b.
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// The smaller; b where one is not a number.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger; b where one is not a number.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// One bit a lane, the first lane lowest: a <= b.
    fn le(self, a: Self::F, b: Self::F) -> u32;
    /// One bit a lane: a < b.
    fn lt(self, a: Self::F, b: Self::F) -> u32;
    /// `yes` where a <= b, `no` elsewhere and where one is not a number.
    fn where_le(self, a: Self::F, b: Self::F, yes: Self::F, no: Self::F) -> Self::F;
    /// `yes` where a < b, `no` elsewhere and where one is not a number.
    fn where_lt(self, a: Self::F, b: Self::F, yes: Self::F, no: Self::F) -> Self::F;
    /// The least of the lanes, all of which are numbers.
    fn least(self, a: Self::F) -> f32;
}

/// Arrays, which the compiler makes vectors of as wide as the baseline has them.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

#[inline(always)]
fn each(a: [f32; 8], b: [f32; 8], f: impl Fn(f32, f32) -> f32) -> [f32; 8] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn bits(a: [f32; 8], b: [f32; 8], f: impl Fn(f32, f32) -> bool) -> u32 {
    (0..8).fold(0, |m, i| m | (u32::from(f(a[i], b[i])) << i))
}

impl Eight for Plain {
    type F = [f32; 8];

    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
    #[inline(always)]
    fn splat(self, x: f32) -> [f32; 8] {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, x: &[f32; 8]) -> [f32; 8] {
        *x
    }
    #[inline(always)]
    fn store(self, x: [f32; 8]) -> [f32; 8] {
        x
    }
    #[inline(always)]
    fn add(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        each(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        bits(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn lt(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        bits(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn where_le(self, a: [f32; 8], b: [f32; 8], yes: [f32; 8], no: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] <= b[i] { yes[i] } else { no[i] })
    }
    #[inline(always)]
    fn where_lt(self, a: [f32; 8], b: [f32; 8], yes: [f32; 8], no: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] < b[i] { yes[i] } else { no[i] })
    }
    #[inline(always)]
    fn least(self, a: [f32; 8]) -> f32 {
        a.into_iter().fold(f32::INFINITY, |m, x| if x < m { x } else { m })
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m256, _CMP_LE_OQ, _CMP_LT_OQ};

    use pulp::x86::V3;

    use super::Eight;

    impl Eight for V3 {
        type F = __m256;

        #[inline(always)]
        fn run<R>(self, f: impl FnOnce() -> R) -> R {
            self.vectorize(f)
        }
        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            self.avx._mm256_set1_ps(x)
        }
        #[inline(always)]
        fn load(self, x: &[f32; 8]) -> __m256 {
            bytemuck::cast(*x)
        }
        #[inline(always)]
        fn store(self, x: __m256) -> [f32; 8] {
            bytemuck::cast(x)
        }
        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_mul_ps(a, b)
        }
        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_div_ps(a, b)
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_min_ps(a, b)
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_max_ps(a, b)
        }
        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> u32 {
            self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32
        }
        #[inline(always)]
        fn lt(self, a: __m256, b: __m256) -> u32 {
            self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32
        }
        #[inline(always)]
        fn where_le(self, a: __m256, b: __m256, yes: __m256, no: __m256) -> __m256 {
            self.avx._mm256_blendv_ps(no, yes, self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
        }
        #[inline(always)]
        fn where_lt(self, a: __m256, b: __m256, yes: __m256, no: __m256) -> __m256 {
            self.avx._mm256_blendv_ps(no, yes, self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b))
        }
        #[inline(always)]
        fn least(self, a: __m256) -> f32 {
            let four = self.sse._mm_min_ps(self.avx._mm256_castps256_ps128(a), self.avx._mm256_extractf128_ps::<1>(a));
            let two = self.sse._mm_min_ps(four, self.sse._mm_movehl_ps(four, four));
            let one = self.sse._mm_min_ss(two, self.sse._mm_shuffle_ps::<1>(two, two));
            self.sse._mm_cvtss_f32(one)
        }
    }
}

/// The instruction set of this processor.
#[derive(Clone, Copy, Debug)]
pub enum Isa {
    /// AVX2 and better.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// Any.
    Plain,
}

impl Isa {
    /// The widest that this processor has, and [`crate::simd`] may use.
    pub fn best() -> Isa {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = crate::simd::avx2() {
            return Isa::Avx2(v3);
        }
        Isa::Plain
    }
}
