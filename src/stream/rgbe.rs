//! Radiance's shared-exponent pixels: three (or N) mantissa bytes and one exponent [Ward 1991; Radiance `color.c`].
//!
//! Encoding truncates and decoding adds half a step, as Radiance does: the mean is unbiased and decode, encode, decode
//! changes nothing. How the bytes of a scanline lie is [`crate::stream::rle`]'s.

use std::io::BufRead;

use crate::simd::{GROUP, bound};
use crate::stream::groups;
use crate::stream::rle::Planes;
use crate::{Error, Result};

/// 2^(e - 128) for an exponent byte; 0 for the byte 0, which means black. 2^-127 is a subnormal, still exact.
#[inline(always)]
fn scale(e: u8) -> f32 {
    let normal = u32::from(e.saturating_sub(1)) << 23;
    f32::from_bits(if e == 1 { 1 << 22 } else { normal })
}

/// The number that a mantissa byte stands for, in units of [`scale`].
#[inline(always)]
fn mantissa(byte: u8) -> f32 {
    (f32::from(byte) + 0.5) * (1.0 / 256.0)
}

/// Planes to pixel-interleaved triples, each component times its factor.
pub fn decode_pixels(planes: &Planes, factors: [f32; 3], out: &mut [f32]) {
    groups::decode(
        planes,
        out,
        #[inline(always)]
        |bytes, pixels| decode_group(bytes, factors, pixels),
    );
}

#[inline(always)]
fn decode_group([r, g, b, e]: [&[u8; GROUP]; 4], factors: [f32; 3], out: &mut [f32; 3 * GROUP]) {
    for i in 0..GROUP {
        let scale = scale(e[i]);
        out[3 * i] = mantissa(r[i]) * scale * factors[0];
        out[3 * i + 1] = mantissa(g[i]) * scale * factors[1];
        out[3 * i + 2] = mantissa(b[i]) * scale * factors[2];
    }
}

/// Appends a flat scanline of hyperspectral pixels, `ncomp` mantissas and an exponent each, times `factor`.
pub fn spectral_scanline(
    input: &mut dyn BufRead,
    width: usize,
    ncomp: usize,
    factor: f32,
    out: &mut Vec<f32>,
) -> Result<()> {
    let mut pixel = vec![0u8; ncomp + 1];
    for _ in 0..width {
        input.read_exact(&mut pixel).map_err(|e| Error::io("", e))?;
        let scale = scale(pixel[ncomp]);
        out.extend(pixel[..ncomp].iter().map(|byte| mantissa(*byte) * scale * factor));
    }
    Ok(())
}

/// What the encoding could not hold, counted in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// A negative component became 0.
    pub negative: u64,
    /// A component was not a number and became 0.
    pub nan: u64,
    /// A component was infinite or over 1.7e38 and became the largest value.
    pub overflow: u64,
}

impl Losses {
    /// Adds another count.
    pub fn add(&mut self, other: Losses) {
        self.negative += other.negative;
        self.nan += other.nan;
        self.overflow += other.overflow;
    }

    /// Counts what is wrong with a pixel, and brings it into range.
    fn mend(&mut self, c: &mut [f32]) {
        self.nan += u64::from(c.iter().any(|x| x.is_nan()));
        self.negative += u64::from(c.iter().any(|x| *x < 0.0));
        self.overflow += u64::from(c.iter().any(|x| *x > LARGEST));
        c.iter_mut().for_each(|x| *x = bound(*x, 0.0, LARGEST)); // NaN becomes 0
    }
}

/// The largest component that an exponent byte of 255 holds.
const LARGEST: f32 = 255.0 / 256.0 * 1.701_411_8e38;
/// Radiance writes black for colours up to this.
const BLACK: f32 = 1e-32;

/// The exponent byte for the largest component c, that of frexp(c), and the factor that turns components into mantissas.
#[inline(always)]
fn exponent(largest: f32) -> (u8, f32) {
    let exponent = (largest.to_bits() >> 23) as i32 - 126; // frexp: largest = m 2^exponent, 0.5 <= m < 1
    let scale = f32::from_bits(((127 + 8 - exponent) as u32) << 23);
    if largest > BLACK { ((exponent + 128) as u8, scale) } else { (0, 0.0) }
}

/// Encodes one pixel by truncation.
///
/// ```
/// use luxpipe::stream::rgbe::{encode_pixel, Losses};
/// assert_eq!(encode_pixel([1.0, 0.5, 0.25], &mut Losses::default()), [128, 64, 32, 129]);
/// ```
pub fn encode_pixel(mut c: [f32; 3], losses: &mut Losses) -> [u8; 4] {
    if !c.iter().all(|x| (0.0..=LARGEST).contains(x)) {
        losses.mend(&mut c);
    }
    let (e, scale) = exponent(c[0].max(c[1]).max(c[2]));
    [(c[0] * scale) as u8, (c[1] * scale) as u8, (c[2] * scale) as u8, e]
}

/// Encodes a scanline of triples, each times `factor`.
pub fn encode_pixels(triples: &[f32], factor: f32, planes: &mut Planes, losses: &mut Losses) {
    groups::encode(
        triples,
        planes,
        #[inline(always)]
        |group, bytes| encode_group(group, factor, bytes, losses),
    );
}

/// Encodes pixels side by side, in whole numbers, as positive floats compare as their bits do; those with a component that is too
/// large or not a number by themselves.
#[inline(always)]
fn encode_group(triples: &[f32; 3 * GROUP], factor: f32, [r, g, b, e]: [&mut [u8; GROUP]; 4], losses: &mut Losses) {
    const TOP: i32 = LARGEST.to_bits() as i32;
    let (mut bits, mut largest, mut negative, mut widest) = ([[0u32; GROUP]; 3], [0u32; GROUP], 0, 0);
    let [reds, greens, blues] = &mut bits;
    for i in 0..GROUP {
        let x = (triples[3 * i] * factor).to_bits() as i32;
        let y = (triples[3 * i + 1] * factor).to_bits() as i32;
        let z = (triples[3 * i + 2] * factor).to_bits() as i32;
        widest = widest.max(x & i32::MAX).max(y & i32::MAX).max(z & i32::MAX);
        // A sign for what is under 0, none for -0.
        negative += (x & x.wrapping_sub(1) | y & y.wrapping_sub(1) | z & z.wrapping_sub(1)) as u32 >> 31;
        let [x, y, z] = [(x & !(x >> 31)) as u32, (y & !(y >> 31)) as u32, (z & !(z >> 31)) as u32];
        largest[i] = x.max(y).max(z);
        (reds[i], greens[i], blues[i]) = (x, y, z);
    }
    if widest > TOP {
        let colours = triples.as_chunks::<3>().0.iter().map(|c| c.map(|x| x * factor));
        for (i, colour) in colours.enumerate() {
            [r[i], g[i], b[i], e[i]] = encode_pixel(colour, losses);
        }
        return;
    }
    losses.negative += u64::from(negative);
    for i in 0..GROUP {
        let largest = largest[i];
        // The significand's leading eight bits, less by as many as the component's exponent is under the largest one's.
        let byte = |bits: u32| {
            let shift = 16 + (largest >> 23) - (bits >> 23);
            ((bits & 0x007f_ffff) | 0x0080_0000) >> shift.min(31)
        };
        let visible = if largest > BLACK.to_bits() { u32::MAX } else { 0 };
        r[i] = (byte(reds[i]) & visible) as u8;
        g[i] = (byte(greens[i]) & visible) as u8;
        b[i] = (byte(blues[i]) & visible) as u8;
        e[i] = (((largest >> 23) + 2) & visible) as u8;
    }
}

/// Appends hyperspectral pixels of `ncomp` components, each times `factor`: mantissas and an exponent, flat.
///
/// ```
/// use luxpipe::stream::rgbe::{encode_spectra, Losses};
/// let mut out = Vec::new();
/// encode_spectra(&[1.0, 0.5, 0.25, 0.0], 4, 1.0, &mut out, &mut Losses::default());
/// assert_eq!(out, [128, 64, 32, 0, 129]);
/// ```
pub fn encode_spectra(values: &[f32], ncomp: usize, factor: f32, out: &mut Vec<u8>, losses: &mut Losses) {
    let mut scaled = vec![0f32; ncomp];
    for pixel in values.chunks_exact(ncomp) {
        scaled.iter_mut().zip(pixel).for_each(|(s, x)| *s = x * factor);
        if !scaled.iter().all(|x| (0.0..=LARGEST).contains(x)) {
            losses.mend(&mut scaled);
        }
        let (e, scale) = exponent(scaled.iter().fold(0.0, |m, x| m.max(*x)));
        out.extend(scaled.iter().map(|x| (x * scale) as u8));
        out.push(e);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decode(pixels: &[[u8; 4]]) -> Vec<f32> {
        let planes: Planes = std::array::from_fn(|c| pixels.iter().map(|p| p[c]).collect());
        let mut out = vec![0.0; 3 * pixels.len()];
        decode_pixels(&planes, [1.0; 3], &mut out);
        out
    }

    #[test]
    fn one_decodes_to_half_a_step_more() {
        assert_eq!(decode(&[[128, 128, 128, 129]]), [1.0 + 1.0 / 256.0; 3]);
    }

    #[test]
    fn every_exponent_has_its_power_of_two() {
        for e in 1..=255u8 {
            assert_eq!(f64::from(scale(e)), 2f64.powi(i32::from(e) - 128), "{e}");
        }
        assert_eq!(scale(0), 0.0);
    }

    #[test]
    fn extremes_are_counted_and_never_brighter() {
        let mut losses = Losses::default();
        assert_eq!(encode_pixel([-0.5, 1.0, 2.0], &mut losses), [0, 64, 128, 130]);
        assert_eq!(encode_pixel([f32::NAN, 0.0, 0.0], &mut losses), [0; 4]);
        assert_eq!(encode_pixel([f32::INFINITY, 1.0, 0.0], &mut losses), [255, 0, 0, 255]);
        assert_eq!(losses, Losses { negative: 1, nan: 1, overflow: 1 });
    }

    fn component() -> impl Strategy<Value = f32> {
        let special = prop::sample::select(vec![0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-33]);
        prop_oneof![20 => (-30f32..38.0).prop_map(|x| 10f32.powf(x)), 1 => special]
    }

    proptest! {
        #[test]
        fn coding_is_idempotent(pixels in prop::collection::vec(prop::array::uniform3(-30f32..38.0), 1..40)) {
            let colors: Vec<[f32; 3]> = pixels.iter().map(|p| p.map(|x| 10f32.powf(x))).collect();
            let mut losses = Losses::default();
            let once: Vec<[u8; 4]> = colors.iter().map(|c| encode_pixel(*c, &mut losses)).collect();
            let back = decode(&once);
            for (c, d) in colors.iter().flatten().zip(&back) {
                let top = back.iter().fold(0f32, |m, x| m.max(*x));
                prop_assert!((c - d).abs() <= top / 128.0);
            }
            let twice: Vec<[u8; 4]> = back.chunks(3).map(|c| encode_pixel([c[0], c[1], c[2]], &mut losses)).collect();
            prop_assert_eq!(once, twice);
        }

        /// Whole scanlines are coded as single pixels are, and losses counted alike.
        #[test]
        fn groups_agree_with_pixels(values in prop::collection::vec(component(), 1..200)) {
            let triples = &values[..values.len() / 3 * 3];
            let (mut planes, mut all) = (Planes::default(), Losses::default());
            encode_pixels(triples, 1.0, &mut planes, &mut all);
            let mut each = Losses::default();
            for (i, c) in triples.chunks(3).enumerate() {
                let want = encode_pixel([c[0], c[1], c[2]], &mut each);
                prop_assert_eq!(planes.each_ref().map(|p| p[i]), want);
            }
            prop_assert_eq!(all, each);
        }
    }
}
