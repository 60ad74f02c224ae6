//! LogLuv: log luminance and CIE 1976 u'v', the paper's encoding for absolute pictures [Larson 1998; libtiff `tif_luv.c`].
//!
//! | coding | word | luminance | chromaticity |
//! |---|---|---|---|
//! | 32 bit | sign, 15, 8, 8 | 2^((Le + 1/2)/256 - 64): 5.4e-20 to 1.8e19, steps of 0.27 % | u' and v' in steps of 1/410 |
//! | 24 bit | 10, 14 | 2^((Le + 1/2)/64 - 12): 2.4e-4 to 15.9, steps of 1.1 % | 16289 squares of 0.0035 in u'v' |
//! | LogL, 16 bit | sign, 15 | as 32 bit, negative too | none |
//!
//! Stored luminance times StoNits is cd/m2. The words are libtiff's for every finite colour, as its default is for 32 bit and
//! without its dither for 24 bit: quantised downward, read back from the middle of the step.
//!
//! Losses, all counted: luminance under the range is black, over it the largest; of what is negative 32 and 24 bit read back
//! black; a chromaticity outside the square 0..0.624 (32 bit) or the visible colours (24 bit) moves to their edge, at the same
//! luminance. NaN is black. Memory: a block of rows.

pub mod cells;
pub mod rows;
pub mod strips;

use std::f64::consts::LN_2;

use crate::simd::GROUP;
use crate::stream::groups;
use crate::stream::rle::Planes;
use cells::Cells;

/// What the words hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// 32-bit colour.
    Log32,
    /// 24-bit colour.
    Log24,
    /// 16-bit luminance.
    LogL16,
}

/// Codes per unit of u' and v' in 32-bit words.
const UV_SCALE: f64 = 410.0;
/// u' and v' of equal-energy white, to the digits of libtiff.
const NEUTRAL: (f64, f64) = (0.210_526_316, 0.473_684_211);
/// From here on a luminance is the largest 32-bit one.
const TOP_32: f64 = 1.837_197_6e19;
/// Up to here a luminance is black in 32 bit.
const BLACK_32: f64 = 5.413_676_9e-20;
/// The same for 24 bit.
const TOP_24: f64 = 15.742;
/// The same for 24 bit.
const BLACK_24: f64 = 0.000_242_83;

/// What the encoding could not hold, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Luminance over the range, or infinite.
    pub over: u64,
    /// Luminance above 0 and under the range.
    pub under: u64,
    /// Negative luminance that reads back as black.
    pub negative: u64,
    /// Chromaticity outside.
    pub chroma: u64,
}

impl Losses {
    /// Adds another count.
    pub fn add(&mut self, other: Losses) {
        self.over += other.over;
        self.under += other.under;
        self.negative += other.negative;
        self.chroma += other.chroma;
    }
}

/// Added to luminance and chromaticity codes before they are cut: 0 without dither.
pub type Dither = [f64; 3];

/// A logarithm to the base of 2 as libtiff takes it.
fn log2(y: f64) -> f64 {
    (1.0 / LN_2) * y.ln()
}

/// 16 bits of luminance, the sign first.
///
/// ```
/// use luxpipe::codec::logluv::{Losses, luminance_16};
/// assert_eq!(luminance_16(1.0, 0.0, &mut Losses::default()), 0x4000);
/// ```
pub fn luminance_16(y: f32, dither: f64, losses: &mut Losses) -> u16 {
    let (size, sign) = (f64::from(y.abs()), if y < 0.0 { 0x8000 } else { 0 });
    if size >= TOP_32 {
        losses.over += 1;
        0x7fff | sign
    } else {
        // Just above the end a code is cut to 0, which is black too, as NaN is.
        let code = if size > BLACK_32 { (256.0 * (log2(size) + 64.0) + dither) as u16 } else { 0 };
        losses.under += u64::from(code == 0 && size > 0.0);
        if code == 0 { 0 } else { code.min(0x7fff) | sign }
    }
}

/// u' and v', or `None` where there is no colour.
fn chromaticity([x, y, z]: [f32; 3]) -> Option<(f64, f64)> {
    let [x, y, z] = [x, y, z].map(f64::from);
    let sum = x + 15.0 * y + 3.0 * z;
    (sum > 0.0).then(|| (4.0 * x / sum, 9.0 * y / sum))
}

/// The 32-bit word of a colour.
///
/// ```
/// use luxpipe::codec::logluv::{Losses, word_32};
/// assert_eq!(word_32([0.95042845, 1.0, 1.0889004], [0.0; 3], &mut Losses::default()), 0x400051c0);
/// ```
pub fn word_32(xyz: [f32; 3], dither: Dither, losses: &mut Losses) -> u32 {
    let xyz = mended(xyz);
    let luminance = luminance_16(xyz[1], dither[0], losses);
    losses.negative += u64::from(luminance & 0x8000 != 0);
    let chroma = if luminance == 0 { None } else { chromaticity(xyz) };
    losses.chroma += u64::from(luminance != 0 && chroma.is_none());
    let (u, v) = chroma.unwrap_or(NEUTRAL);
    let mut code = |x: f64, dither: f64| {
        let x = UV_SCALE * x;
        losses.chroma += u64::from(chroma.is_some() && !(0.0..256.0).contains(&x));
        (if x <= 0.0 { 0.0 } else { x + dither }) as u8 // 255 and above is 255
    };
    let (u, v) = (code(u, dither[1]), code(v, dither[2]));
    u32::from(luminance) << 16 | u32::from(u) << 8 | u32::from(v)
}

/// The 24-bit word of a colour.
///
/// ```
/// use luxpipe::codec::logluv::{Losses, cells::Cells, word_24};
/// let word = word_24([0.95042845, 1.0, 1.0889004], [0.0; 3], &Cells::get(), &mut Losses::default());
/// assert_eq!(word >> 14, 64 * 12);
/// ```
pub fn word_24(xyz: [f32; 3], dither: Dither, cells: &Cells, losses: &mut Losses) -> u32 {
    let xyz = mended(xyz);
    let y = f64::from(xyz[1]);
    let luminance = if y >= TOP_24 {
        losses.over += 1;
        0x3ff
    } else {
        let code = if y > BLACK_24 { (64.0 * (log2(y) + 12.0) + dither[0]) as u32 } else { 0 };
        losses.under += u64::from(code == 0 && y > 0.0);
        losses.negative += u64::from(y < 0.0);
        code.min(0x3ff)
    };
    let chroma = if luminance == 0 { None } else { chromaticity(xyz) };
    losses.chroma += u64::from(luminance != 0 && chroma.is_none());
    let (u, v) = chroma.unwrap_or(NEUTRAL);
    let (code, inside) = cells.code(u, v, [dither[1], dither[2]]);
    losses.chroma += u64::from(!inside);
    luminance << 14 | code
}

/// NaN as black, infinities as the largest floats: no word depends on how a processor casts them.
fn mended(xyz: [f32; 3]) -> [f32; 3] {
    if xyz.iter().any(|x| x.is_nan()) { [0.0; 3] } else { xyz.map(|x| x.clamp(f32::MIN, f32::MAX)) }
}

/// Luminance of a 16-bit code.
pub fn luminance_of(code: u16) -> f32 {
    let size = match code & 0x7fff {
        0 => return 0.0,
        code => ((f64::from(code) + 0.5) / 256.0 - 64.0).exp2() as f32,
    };
    if code & 0x8000 == 0 { size } else { -size }
}

/// X/Y and Z/Y of u' and v'.
#[inline(always)]
fn over_y(u: f64, v: f64) -> (f64, f64) {
    let inverse = 1.0 / (4.0 * v);
    (9.0 * u * inverse, (12.0 - 3.0 * u - 20.0 * v) * inverse)
}

/// Tables for decoding.
pub struct Decoder {
    /// 2^((k + 1/2) / 256)
    mantissas: [f32; 256],
    /// X/Y and Z/Y of each 14-bit chromaticity.
    cells: Vec<(f32, f32)>,
    /// Luminance of each 10-bit code.
    luminances: Vec<f32>,
}

impl Decoder {
    /// For words of that kind.
    pub fn new(coding: Coding) -> Decoder {
        let mantissa = |k: usize| ((k as f64 + 0.5) / 256.0).exp2() as f32;
        let luminance = |code: u32| if code == 0 { 0.0 } else { ((f64::from(code) + 0.5) / 64.0 - 12.0).exp2() as f32 };
        let colour = |code: u32| {
            let (u, v) = Cells::get().centre(code).unwrap_or(NEUTRAL);
            let (x, z) = over_y(u, v);
            (x as f32, z as f32)
        };
        let small = coding == Coding::Log24;
        Decoder {
            mantissas: std::array::from_fn(mantissa),
            cells: if small { (0..1 << 14).map(colour).collect() } else { Vec::new() },
            luminances: if small { (0..1 << 10).map(luminance).collect() } else { Vec::new() },
        }
    }

    /// The colour of a 24-bit word.
    #[inline(always)]
    pub fn colour_24(&self, word: u32) -> [f32; 3] {
        let y = self.luminances[(word >> 14 & 0x3ff) as usize];
        let (x, z) = self.cells[(word & 0x3fff) as usize];
        [x * y, y, z * y]
    }

    /// Planes of 32-bit words to triples, each times `factor`; what has a sign is black.
    pub fn decode_32(&self, planes: &Planes, factor: f32, out: &mut [f32]) {
        groups::decode(
            planes,
            out,
            #[inline(always)]
            |bytes, pixels| self.group(bytes, factor, pixels),
        );
    }

    #[inline(always)]
    fn group(&self, [high, low, u, v]: [&[u8; GROUP]; 4], factor: f32, out: &mut [f32; 3 * GROUP]) {
        let mut mantissas = [0f32; GROUP];
        for i in 0..GROUP {
            mantissas[i] = self.mantissas[usize::from(low[i])];
        }
        for i in 0..GROUP {
            let power = f32::from_bits((u32::from(high[i] & 0x7f) + 63) << 23);
            let visible = high[i] < 0x80 && (high[i] | low[i]) != 0;
            let y = if visible { mantissas[i] * power * factor } else { 0.0 };
            let u = (f64::from(u[i]) + 0.5) * (1.0 / UV_SCALE);
            let v = (f64::from(v[i]) + 0.5) * (1.0 / UV_SCALE);
            let (x, z) = over_y(u, v);
            out[3 * i] = (x * f64::from(y)) as f32;
            out[3 * i + 1] = y;
            out[3 * i + 2] = (z * f64::from(y)) as f32;
        }
    }
}
