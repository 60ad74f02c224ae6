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
pub mod strips;

use std::f64::consts::LN_2;

use crate::color::matrix::{LANES, split};
use crate::simd;
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

/// Closer to a whole number than this, a code is found by itself in double precision: what many have in single precision is
/// good to 7e-5 (five roundings of numbers up to 256).
const NEAR: f32 = 1e-4;
/// A float this large has no fraction: adding it rounds, and its last bits then count.
const ROUND: f32 = 12_582_912.0;

/// Signs gathered from many pixels: a comparison is a difference of bits, whose sign says how it went, since positive floats
/// compare as their bits do. One test at the end then serves all.
struct Signs([i32; LANES]);

impl Signs {
    /// True where a difference was negative.
    #[inline(always)]
    fn any(&self) -> bool {
        self.0.iter().fold(0, |all, sign| all | sign) < 0
    }

    /// A sign for each number that comes close to a whole one.
    #[inline(always)]
    fn near_whole(&mut self, x: &[f32; LANES]) {
        for (sign, x) in self.0.iter_mut().zip(x) {
            let distance = (x - ((x + ROUND) - ROUND)).abs();
            *sign |= distance.to_bits() as i32 - NEAR.to_bits() as i32;
        }
    }

    /// A sign for each number that is not from 0 to under 256.
    #[inline(always)]
    fn outside_byte(&mut self, x: &[f32; LANES]) {
        for (sign, x) in self.0.iter_mut().zip(x) {
            let bits = x.to_bits() as i32;
            *sign |= bits | (256f32.to_bits() as i32 - 1).wrapping_sub(bits);
        }
    }
}

/// The largest whole number under each, where none is whole.
#[inline(always)]
fn floor(x: &[f32; LANES]) -> [i32; LANES] {
    let mut parts = [0; LANES];
    for i in 0..LANES {
        parts[i] = (x[i] - 0.5 + ROUND).to_bits() as i32 - ROUND.to_bits() as i32;
    }
    parts
}

/// `steps` codes an octave: the whole part of steps x log2 y, and the fraction that may still change it.
#[inline(always)]
fn log_codes(y: &[f32; LANES], steps: f32, signs: &mut Signs) -> [i32; LANES] {
    let (mut octaves, mut part) = ([0i32; LANES], [0f32; LANES]);
    for i in 0..LANES {
        // y = 2^e m, m from sqrt(1/2) to sqrt(2); log2 m = 2 / ln 2 atanh((m - 1) / (m + 1)).
        let bits = y[i].to_bits();
        let upper = (bits & 0x007f_ffff) > 0x0035_04f3;
        let m = f32::from_bits((bits & 0x007f_ffff) | if upper { 0x3f00_0000 } else { 0x3f80_0000 });
        octaves[i] = (bits >> 23) as i32 - 127 + i32::from(upper);
        let t = (m - 1.0) / (m + 1.0);
        let t2 = t * t;
        let series = 1.0 + t2 * (1.0 / 3.0 + t2 * (0.2 + t2 * (1.0 / 7.0 + t2 * (1.0 / 9.0))));
        part[i] = steps * (2.0 / LN_2) as f32 * t * series;
    }
    signs.near_whole(&part);
    let mut codes = floor(&part);
    for i in 0..LANES {
        codes[i] += octaves[i] * steps as i32;
    }
    codes
}

/// Encodes triples, each times `factor`, to the four byte planes of 32-bit words.
pub fn encode_32(triples: &[f32], factor: f32, planes: &mut Planes, losses: &mut Losses) {
    planes.iter_mut().for_each(|plane| plane.resize(triples.len() / 3, 0));
    simd::wide(
        #[inline(always)]
        || {
            let mut at = 0;
            while let Some(group) = triples[3 * at..].first_chunk::<{ 3 * LANES }>() {
                let (codes, signs, under) = group_32(group, factor);
                losses.under += under as u64;
                planes.iter_mut().zip(&codes).for_each(|(plane, code)| plane[at..at + LANES].copy_from_slice(code));
                if signs.any() {
                    for i in (0..LANES).filter(|i| signs.0[*i] < 0) {
                        some_32(&group[3 * i..3 * i + 3], factor, planes, at + i, losses);
                    }
                }
                at += LANES;
            }
            some_32(&triples[3 * at..], factor, planes, at, losses);
        },
    );
}

/// Pixel by pixel.
#[cold]
fn some_32(triples: &[f32], factor: f32, planes: &mut Planes, at: usize, losses: &mut Losses) {
    for (i, c) in triples.chunks_exact(3).enumerate() {
        let word = word_32([c[0] * factor, c[1] * factor, c[2] * factor], [0.0; 3], losses);
        planes.iter_mut().zip(word.to_be_bytes()).for_each(|(plane, byte)| plane[at + i] = byte);
    }
}

/// The planes of a group, a sign for each pixel that must be looked at by itself (negative, too bright, hardly above black,
/// outside the square of chromaticities, or at the edge of a code), and how many were too dark.
#[inline(always)]
fn group_32(group: &[f32; 3 * LANES], factor: f32) -> ([[u8; LANES]; 4], Signs, i32) {
    let mut signs = Signs([0; LANES]);
    let Plain { xyz: [x, y, z], black, under } =
        plain(group, factor, [BLACK_32 as f32, 1.1e-19, TOP_32 as f32], &mut signs);
    let (mut u, mut v) = ([0f32; LANES], [0f32; LANES]);
    for i in 0..LANES {
        let scale = UV_SCALE as f32 / (x[i] + 15.0 * y[i] + 3.0 * z[i]);
        u[i] = 4.0 * x[i] * scale;
        v[i] = 9.0 * y[i] * scale;
    }
    let l = log_codes(&y, 256.0, &mut signs);
    signs.near_whole(&u);
    signs.near_whole(&v);
    signs.outside_byte(&u);
    signs.outside_byte(&v);
    let (u, v) = (floor(&u), floor(&v));
    let mut planes = [[0u8; LANES]; 4];
    for i in 0..LANES {
        let l = (l[i] + 256 * 64) & !black[i];
        planes[0][i] = (l >> 8) as u8;
        planes[1][i] = l as u8;
        planes[2][i] = u[i] as u8;
        planes[3][i] = v[i] as u8;
    }
    (planes, signs, under)
}

/// Pixels ready to be coded together.
struct Plain {
    xyz: [[f32; LANES]; 3],
    /// All bits for what is black.
    black: [i32; LANES],
    /// How many of those are above 0.
    under: i32,
}

/// What black pixels are while they are coded: of neutral chromaticity, which black has, and at the edge of no code.
const GREY: i32 = 1.5f32.to_bits() as i32;

/// Triples times `factor`, those up to `black` made grey. A sign for each whose Y lies between `black` and `bottom` or from
/// `top` on, is negative, or that is not finite.
#[inline(always)]
fn plain(group: &[f32; 3 * LANES], factor: f32, [black, bottom, top]: [f32; 3], signs: &mut Signs) -> Plain {
    const INFINITY: i32 = f32::INFINITY.to_bits() as i32;
    let [limit, bottom, top] = [black, bottom, top].map(|y| y.to_bits() as i32);
    let values = split(group);
    let luminances = values[1].map(|y| (y * factor).to_bits() as i32);
    let mut plain = Plain { xyz: [[0f32; LANES]; 3], black: [0; LANES], under: 0 };
    // Masks by shifted signs throughout: comparisons and choices between floats are made pixel by pixel, or by masked stores.
    for (i, y) in luminances.into_iter().enumerate() {
        plain.black[i] = y.wrapping_sub(1).wrapping_sub(limit) >> 31;
        plain.under -= plain.black[i] & y.wrapping_neg() >> 31;
    }
    for (plane, value) in plain.xyz.iter_mut().zip(&values) {
        for i in 0..LANES {
            let bits = (value[i] * factor).to_bits() as i32 & !plain.black[i] | GREY & plain.black[i];
            plane[i] = f32::from_bits(bits as u32);
        }
    }
    let xyz = &plain.xyz;
    for i in 0..LANES {
        let y = xyz[1][i].to_bits() as i32 | luminances[i] & i32::MIN;
        let (x, z) = (xyz[0][i].to_bits() as i32 & i32::MAX, xyz[2][i].to_bits() as i32 & i32::MAX);
        signs.0[i] |= y | y.wrapping_sub(bottom) | (top - 1).wrapping_sub(y) | (INFINITY - 1 - x) | (INFINITY - 1 - z);
    }
    plain
}

/// Encodes triples, each times `factor`, to 24-bit words, appended with the most significant byte first.
pub fn encode_24(triples: &[f32], factor: f32, cells: &Cells, out: &mut Vec<u8>, losses: &mut Losses) {
    simd::wide(
        #[inline(always)]
        || {
            let mut groups = triples.chunks_exact(3 * LANES);
            for group in groups.by_ref() {
                let Some(coded) = group.first_chunk().map(|group| group_24(group, factor, cells)) else { break };
                let (words, signs, under) = coded;
                losses.under += under as u64;
                let mut bytes = [0; 3 * LANES];
                for (three, word) in bytes.chunks_exact_mut(3).zip(&words) {
                    three.copy_from_slice(&word.to_be_bytes()[1..]);
                }
                if signs.any() {
                    for i in (0..LANES).filter(|i| signs.0[*i] < 0) {
                        some_24(&group[3 * i..3 * i + 3], factor, cells, &mut bytes[3 * i..3 * i + 3], losses);
                    }
                }
                out.extend_from_slice(&bytes);
            }
            let rest = groups.remainder();
            let start = out.len();
            out.resize(start + rest.len(), 0);
            some_24(rest, factor, cells, &mut out[start..], losses);
        },
    );
}

#[cold]
fn some_24(triples: &[f32], factor: f32, cells: &Cells, out: &mut [u8], losses: &mut Losses) {
    for (c, bytes) in triples.chunks_exact(3).zip(out.chunks_exact_mut(3)) {
        let word = word_24([c[0] * factor, c[1] * factor, c[2] * factor], [0.0; 3], cells, losses);
        bytes.copy_from_slice(&word.to_be_bytes()[1..]);
    }
}

/// The words of a group, a sign for each pixel that must be looked at by itself, and how many were too dark.
#[inline(always)]
fn group_24(group: &[f32; 3 * LANES], factor: f32, cells: &Cells) -> ([u32; LANES], Signs, i32) {
    let mut signs = Signs([0; LANES]);
    let Plain { xyz: [x, y, z], black, under } =
        plain(group, factor, [BLACK_24 as f32, 5e-4, TOP_24 as f32], &mut signs);
    let (mut u, mut row) = ([0f32; LANES], [0f32; LANES]);
    for i in 0..LANES {
        let scale = 1.0 / (x[i] + 15.0 * y[i] + 3.0 * z[i]);
        u[i] = 4.0 * x[i] * scale;
        row[i] = (9.0 * y[i] * scale - cells::V_START as f32) * (1.0 / cells::SIDE) as f32;
    }
    let l = log_codes(&y, 64.0, &mut signs);
    signs.near_whole(&row);
    signs.outside_byte(&row);
    let rows = floor(&row);
    let mut words = [0u32; LANES];
    for i in 0..LANES {
        let (code, near) = cells.in_row(rows[i] as u8, u[i], NEAR);
        signs.0[i] |= near;
        words[i] = (((l[i] + 64 * 12) & !black[i]) as u32) << 14 | code;
    }
    (words, signs, under)
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
        simd::wide(
            #[inline(always)]
            || {
                let lanes = |plane: &[u8], at: usize| plane[at..].first_chunk::<LANES>().copied();
                let [a, b, c, d] = planes;
                let mut at = 0;
                while let (Some(out), Some(a), Some(b), Some(c), Some(d)) =
                    (out[3 * at..].first_chunk_mut(), lanes(a, at), lanes(b, at), lanes(c, at), lanes(d, at))
                {
                    self.group(&[a, b, c, d], factor, out);
                    at += LANES;
                }
                let left = a.len() - at;
                if left > 0 {
                    let mut last = [[0u8; LANES]; 4];
                    last.iter_mut().zip(planes).for_each(|(l, plane)| l[..left].copy_from_slice(&plane[at..]));
                    let mut colours = [0f32; 3 * LANES];
                    self.group(&last, factor, &mut colours);
                    out[3 * at..].copy_from_slice(&colours[..3 * left]);
                }
            },
        );
    }

    #[inline(always)]
    fn group(&self, [high, low, u, v]: &[[u8; LANES]; 4], factor: f32, out: &mut [f32; 3 * LANES]) {
        let (mut y, mut xz) = ([0f32; LANES], [[0f64; LANES]; 2]);
        for i in 0..LANES {
            y[i] = self.mantissas[usize::from(low[i])];
        }
        for i in 0..LANES {
            let power = f32::from_bits((u32::from(high[i] & 0x7f) + 63) << 23);
            let visible = high[i] < 0x80 && (high[i] | low[i]) != 0;
            y[i] = if visible { y[i] * power * factor } else { 0.0 };
            let u = (f64::from(u[i]) + 0.5) * (1.0 / UV_SCALE);
            let v = (f64::from(v[i]) + 0.5) * (1.0 / UV_SCALE);
            (xz[0][i], xz[1][i]) = over_y(u, v);
        }
        for i in 0..LANES {
            out[3 * i] = (xz[0][i] * f64::from(y[i])) as f32;
            out[3 * i + 1] = y[i];
            out[3 * i + 2] = (xz[1][i] * f64::from(y[i])) as f32;
        }
    }
}
