//! Radiance's shared-exponent pixels: three (or N) mantissa bytes and one exponent [Ward 1991; Radiance `color.c`].
//!
//! Encoding truncates and decoding adds half a step, as Radiance does: the mean is unbiased and decode, encode, decode
//! changes nothing. Scanlines come flat, in the old run-length code (pixel 1 1 1 n repeats the last pixel) or the new one
//! (2 2 hi lo, then four byte planes, each in runs).

use std::io::BufRead;

use crate::simd::bound;
use crate::{Error, Result, invalid};

/// Widths that the new run-length code is written for.
const NEW_RLE: std::ops::RangeInclusive<usize> = 17..=32767;
/// Shortest run worth writing.
const SHORTEST_RUN: usize = 4;

/// 2^(e - 136) for each exponent byte; 0 for the byte 0, which means black. 2^(1 - 136) is a subnormal, still exact.
fn exponents() -> [f32; 256] {
    std::array::from_fn(|e| if e == 0 { 0.0 } else { 2f64.powi(e as i32 - 136) as f32 })
}

/// Decodes scanlines of RGBE or XYZE.
pub struct Decoder {
    /// Value of the last mantissa bit, by exponent byte.
    step: [f32; 256],
    /// A scanline as four planes: mantissas and exponents.
    planes: [Vec<u8>; 4],
}

impl Default for Decoder {
    fn default() -> Self {
        Decoder { step: exponents(), planes: Default::default() }
    }
}

impl Decoder {
    /// Decodes one scanline of `width` pixels, times `factors`, and appends three floats a pixel to `out`.
    pub fn scanline(
        &mut self,
        input: &mut dyn BufRead,
        width: usize,
        factors: [f32; 3],
        out: &mut Vec<f32>,
    ) -> Result<()> {
        self.read_planes(input, width)?;
        let start = out.len();
        out.resize(start + 3 * width, 0.0);
        let [r, g, b, e] = &self.planes;
        for (i, pixel) in out[start..].chunks_exact_mut(3).enumerate() {
            let step = self.step[usize::from(e[i])];
            pixel[0] = (f32::from(r[i]) + 0.5) * step * factors[0];
            pixel[1] = (f32::from(g[i]) + 0.5) * step * factors[1];
            pixel[2] = (f32::from(b[i]) + 0.5) * step * factors[2];
        }
        Ok(())
    }

    fn read_planes(&mut self, input: &mut dyn BufRead, width: usize) -> Result<()> {
        for plane in &mut self.planes {
            plane.clear();
        }
        let first = four(input)?;
        if first[0] == 2 && first[1] == 2 && first[2] < 128 {
            let stated = usize::from(first[2]) << 8 | usize::from(first[3]);
            if stated != width {
                return invalid!("a run-length coded scanline says it is {stated} pixels wide, the picture is {width}");
            }
            for plane in &mut self.planes {
                read_plane(input, width, plane)?;
            }
            return Ok(());
        }
        self.read_old(input, width, first)
    }

    /// Flat pixels with old-style repeats.
    fn read_old(&mut self, input: &mut dyn BufRead, width: usize, mut pixel: [u8; 4]) -> Result<()> {
        let mut shift = 0;
        loop {
            if pixel[..3] == [1, 1, 1] {
                let count = usize::from(pixel[3]) << shift;
                let done = self.planes[0].len();
                let Some(last) = done.checked_sub(1) else { return invalid!("a scanline begins with a repeat count") };
                if count > width - done {
                    return invalid!("a repeat of {count} pixels runs past the end of the scanline");
                }
                for plane in &mut self.planes {
                    plane.resize(done + count, plane[last]);
                }
                shift = (shift + 8).min(24);
            } else {
                for (plane, byte) in self.planes.iter_mut().zip(pixel) {
                    plane.push(byte);
                }
                shift = 0;
            }
            if self.planes[0].len() == width {
                return Ok(());
            }
            pixel = four(input)?;
        }
    }
}

fn four(input: &mut dyn BufRead) -> Result<[u8; 4]> {
    let mut pixel = [0; 4];
    input.read_exact(&mut pixel).map_err(|e| Error::io("", e))?;
    Ok(pixel)
}

/// One byte plane: a code over 128 is a run of code - 128 copies of the next byte, 1 to 128 that many literal bytes.
fn read_plane(input: &mut dyn BufRead, width: usize, plane: &mut Vec<u8>) -> Result<()> {
    while plane.len() < width {
        let mut code = [0; 1];
        input.read_exact(&mut code).map_err(|e| Error::io("", e))?;
        let code = usize::from(code[0]);
        let (count, run) = if code > 128 { (code - 128, true) } else { (code, false) };
        if count == 0 || count > width - plane.len() {
            return invalid!(
                "run-length code {code} does not fit the {} pixels left of the scanline",
                width - plane.len()
            );
        }
        let start = plane.len();
        if run {
            let mut value = [0; 1];
            input.read_exact(&mut value).map_err(|e| Error::io("", e))?;
            plane.resize(start + count, value[0]);
        } else {
            plane.resize(start + count, 0);
            input.read_exact(&mut plane[start..]).map_err(|e| Error::io("", e))?;
        }
    }
    Ok(())
}

/// Appends a flat scanline of hyperspectral pixels, `ncomp` mantissas and an exponent each, times `factor`.
pub fn spectral_scanline(
    input: &mut dyn BufRead,
    width: usize,
    ncomp: usize,
    factor: f32,
    out: &mut Vec<f32>,
) -> Result<()> {
    let step = exponents();
    let mut pixel = vec![0u8; ncomp + 1];
    for _ in 0..width {
        input.read_exact(&mut pixel).map_err(|e| Error::io("", e))?;
        let step = step[usize::from(pixel[ncomp])];
        out.extend(pixel[..ncomp].iter().map(|byte| (f32::from(*byte) + 0.5) * step * factor));
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
}

/// The largest component that an exponent byte of 255 holds.
const LARGEST: f32 = 255.0 / 256.0 * 1.701_411_8e38;

/// Encodes one pixel by truncation: the largest component c gets the exponent of frexp(c).
///
/// ```
/// use luxpipe::stream::rgbe::{encode_pixel, Losses};
/// assert_eq!(encode_pixel([1.0, 0.5, 0.25], &mut Losses::default()), [128, 64, 32, 129]);
/// ```
pub fn encode_pixel(mut c: [f32; 3], losses: &mut Losses) -> [u8; 4] {
    let largest = c[0].max(c[1]).max(c[2]);
    // NaN fails every comparison, so one test finds all that needs care.
    let plain = c[0] >= 0.0 && c[1] >= 0.0 && c[2] >= 0.0 && largest <= LARGEST;
    if !plain {
        losses.nan += u64::from(c.iter().any(|x| x.is_nan()));
        losses.negative += u64::from(c.iter().any(|x| *x < 0.0));
        losses.overflow += u64::from(c.iter().any(|x| *x > LARGEST));
        c = c.map(|x| bound(x, 0.0, LARGEST)); // NaN becomes 0
    }
    let largest = c[0].max(c[1]).max(c[2]);
    if largest <= 1e-32 {
        return [0; 4];
    }
    let exponent = (largest.to_bits() >> 23) as i32 - 126; // frexp: largest = m 2^exponent, 0.5 <= m < 1
    let scale = f32::from_bits(((127 + 8 - exponent) as u32) << 23);
    [(c[0] * scale) as u8, (c[1] * scale) as u8, (c[2] * scale) as u8, (exponent + 128) as u8]
}

/// Appends one scanline: new run-length code for widths 17 to 32767, flat otherwise, as Radiance writes them.
pub fn encode_scanline(pixels: &[[u8; 4]], out: &mut Vec<u8>) {
    if !NEW_RLE.contains(&pixels.len()) {
        out.extend(pixels.iter().flatten());
        return;
    }
    out.extend([2, 2, (pixels.len() >> 8) as u8, pixels.len() as u8]);
    let mut plane = vec![0; pixels.len()];
    for channel in 0..4 {
        for (byte, pixel) in plane.iter_mut().zip(pixels) {
            *byte = pixel[channel];
        }
        encode_plane(&plane, out);
    }
}

/// Radiance's own choice of runs (`fwritecolrs`), so that equal pixels give equal bytes: runs of at least four; two or
/// three equal bytes before such a run go out as a short run when they are all that precedes it.
fn encode_plane(plane: &[u8], out: &mut Vec<u8>) {
    let mut at = 0;
    while at < plane.len() {
        // The next long run begins at `begin`.
        let (mut begin, mut run) = (at, 0);
        while begin < plane.len() {
            run = plane[begin..].iter().take(127).take_while(|b| **b == plane[begin]).count();
            if run >= SHORTEST_RUN {
                break;
            }
            begin += run;
        }
        let before = begin - at;
        if before > 1 && before < SHORTEST_RUN && plane[at..begin].iter().all(|b| *b == plane[at]) {
            out.extend([128 + before as u8, plane[at]]);
            at = begin;
        }
        while at < begin {
            let count = (begin - at).min(128);
            out.push(count as u8);
            out.extend(&plane[at..at + count]);
            at += count;
        }
        if run >= SHORTEST_RUN {
            out.extend([128 + run as u8, plane[begin]]);
            at += run;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decode(bytes: &[u8], width: usize) -> Result<Vec<f32>> {
        let mut out = Vec::new();
        Decoder::default().scanline(&mut &*bytes, width, [1.0; 3], &mut out)?;
        Ok(out)
    }

    #[test]
    fn the_measured_bytes_of_a_20_pixel_row() {
        // Radiance 6.0 wrote `02 02 00 14 | 94 80 | 94 40 | 94 20 | 94 81` for twenty pixels (128, 64, 32, 129).
        let mut out = Vec::new();
        encode_scanline(&[[128, 64, 32, 129]; 20], &mut out);
        assert_eq!(out, [2, 2, 0, 20, 0x94, 0x80, 0x94, 0x40, 0x94, 0x20, 0x94, 0x81]);
    }

    #[test]
    fn one_decodes_to_half_a_step_more() {
        assert_eq!(decode(&[128, 128, 128, 129], 1).unwrap(), [1.0 + 1.0 / 256.0; 3]);
    }

    #[test]
    fn old_runs_of_two_markers() {
        // A pixel, then 43 + 1 x 256 repeats of it: 300 pixels.
        let out = decode(&[128, 64, 32, 129, 1, 1, 1, 43, 1, 1, 1, 1], 300).unwrap();
        assert!(out.chunks(3).all(|p| p == &out[..3]));
    }

    #[test]
    fn extremes_are_counted_and_never_brighter() {
        let mut losses = Losses::default();
        assert_eq!(encode_pixel([-0.5, 1.0, 2.0], &mut losses), [0, 64, 128, 130]);
        assert_eq!(encode_pixel([f32::NAN, 0.0, 0.0], &mut losses), [0; 4]);
        assert_eq!(encode_pixel([f32::INFINITY, 1.0, 0.0], &mut losses), [255, 0, 0, 255]);
        assert_eq!(losses, Losses { negative: 1, nan: 1, overflow: 1 });
    }

    proptest! {
        #[test]
        fn coding_is_idempotent(pixels in prop::collection::vec(prop::array::uniform3(-30f32..38.0), 1..40)) {
            let colors: Vec<[f32; 3]> = pixels.iter().map(|p| p.map(|x| 10f32.powf(x))).collect();
            let mut losses = Losses::default();
            let once: Vec<[u8; 4]> = colors.iter().map(|c| encode_pixel(*c, &mut losses)).collect();
            let mut bytes = Vec::new();
            encode_scanline(&once, &mut bytes);
            let back = decode(&bytes, once.len()).unwrap();
            for (c, d) in colors.iter().flatten().zip(&back) {
                let top = back.iter().fold(0f32, |m, x| m.max(*x));
                prop_assert!((c - d).abs() <= top / 128.0);
            }
            let twice: Vec<[u8; 4]> = back.chunks(3).map(|c| encode_pixel([c[0], c[1], c[2]], &mut losses)).collect();
            prop_assert_eq!(once, twice);
        }
    }
}
