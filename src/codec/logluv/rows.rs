//! Rows of pixels to LogLuv words: many side by side in single precision, and by [`word_32`] or [`word_24`] wherever its
//! roundings could change a code.

use std::f64::consts::LN_2;

use super::cells::{self, Cells};
use super::{BLACK_24, BLACK_32, Losses, TOP_24, TOP_32, UV_SCALE, word_24, word_32};
use crate::simd::{self, GROUP, padded};
use crate::stream::groups;
use crate::stream::rle::Planes;

/// Closer to a whole number than this, a code is found by itself in double precision: what many have in single precision is
/// good to 8e-5 (five roundings of numbers up to 256, and the logarithm).
const NEAR: f32 = 1e-4;
/// A float this large has no fraction: adding it rounds, and its last bits then count.
const ROUND: f32 = 12_582_912.0;
/// What black pixels are while they are coded: of neutral chromaticity, which black has, and at the edge of no code.
const GREY: f32 = 1.5;

/// A number cut to a whole one in the last bits of [`ROUND`], and the bits of its distance from the middle between two: near 1/2
/// the cut is not sure. Of a number over 4e6, or of NaN, anything, but out of the range of every code.
#[inline(always)]
fn cut(x: f32) -> (u32, u32) {
    let centred = x - 0.5;
    let rounded = centred + ROUND;
    let distance = (centred - (rounded - ROUND)).abs();
    (rounded.to_bits(), distance.to_bits())
}

/// The distance from which on a cut is not sure.
const UNSURE: u32 = (0.5 - NEAR).to_bits();

/// Coefficient of the n-th power in steps x log2 of (1 + t) / (1 - t).
const fn term(steps: i32, n: i32) -> f32 {
    (steps as f64 * 2.0 / LN_2 / n as f64) as f32
}

/// `STEPS` log2 y cut to a whole number, and its distance as [`cut`] has it.
#[inline(always)]
fn log_code<const STEPS: i32>(y: f32) -> (i32, u32) {
    // y = 2^e m, m from sqrt(1/2) to sqrt(2); log2 m = 2 / ln 2 atanh((m - 1) / (m + 1)), whose ninth power is 1e-5 at most.
    const ROOT: i32 = 0x3f35_04f3; // sqrt(1/2)
    let above = (y.to_bits() as i32).wrapping_sub(ROOT);
    let m = f32::from_bits(((above & 0x007f_ffff) + ROOT) as u32);
    let t = (m - 1.0) / (m + 1.0);
    let t2 = t * t;
    let [a, b, c, d] = const { [term(STEPS, 1), term(STEPS, 3), term(STEPS, 5), term(STEPS, 7)] };
    let (code, distance) = cut(t * (a + t2 * (b + t2 * (c + t2 * d))));
    (code as i32 - ROUND.to_bits() as i32 + (above >> 23) * STEPS, distance)
}

/// Luminances: up to the first all is black; from the second to under the third they are coded side by side, others, negative
/// ones and NaN by themselves.
#[derive(Clone, Copy)]
struct Bounds {
    black: u32,
    bottom: u32,
    top: u32,
}

impl Bounds {
    const LOG_32: Bounds = Bounds::new([BLACK_32 as f32, 5.5e-20, TOP_32 as f32]);
    const LOG_24: Bounds = Bounds::new([BLACK_24 as f32, 2.5e-4, TOP_24 as f32]);

    const fn new([black, bottom, top]: [f32; 3]) -> Bounds {
        Bounds { black: black.to_bits(), bottom: bottom.to_bits(), top: top.to_bits() }
    }

    /// Positive floats compare as their bits do, and negative ones and NaN have larger bits than all.
    #[inline(always)]
    fn is_black(self, y: f32) -> bool {
        y.to_bits() <= self.black
    }

    #[inline(always)]
    fn is_outside(self, y: f32) -> bool {
        y.to_bits().wrapping_sub(self.bottom) >= self.top - self.bottom
    }
}

/// Some pixels as planes.
type Group = [[f32; GROUP]; 3];

/// Pixels times `factor` as planes.
#[inline(always)]
fn planes(triples: &[f32; 3 * GROUP], factor: f32) -> Group {
    let mut group = [[0f32; GROUP]; 3];
    let [x, y, z] = &mut group;
    for i in 0..GROUP {
        x[i] = triples[3 * i] * factor;
        y[i] = triples[3 * i + 1] * factor;
        z[i] = triples[3 * i + 2] * factor;
    }
    group
}

/// Pixels up to the bound that are not 0.
#[cold]
fn count_under(y: &[f32; GROUP], bounds: Bounds) -> u64 {
    y.iter().filter(|y| bounds.is_black(**y) && **y != 0.0).count() as u64
}

/// Which pixels of a group must be looked at by themselves.
#[inline(always)]
fn doubtful(doubts: &[u32; GROUP]) -> impl Iterator<Item = usize> {
    let any = doubts.iter().fold(0, |any, doubt| any | doubt);
    (0..if any == 0 { 0 } else { GROUP }).filter(|i| doubts[*i] != 0)
}

/// Encodes triples, each times `factor`, to the four byte planes of 32-bit words.
pub fn encode_32(triples: &[f32], factor: f32, out: &mut Planes, losses: &mut Losses) {
    groups::encode(
        triples,
        out,
        #[inline(always)]
        |group, bytes| group_32(&planes(group, factor), bytes, losses),
    );
}

/// The bytes of a group.
#[inline(always)]
fn group_32(group: &Group, [high, low, us, vs]: [&mut [u8; GROUP]; 4], losses: &mut Losses) {
    const BOUNDS: Bounds = Bounds::LOG_32;
    let ([x, y, z], mut doubts, mut dark) = (group, [0; GROUP], 0);
    for i in 0..GROUP {
        let (black, outside) = (BOUNDS.is_black(y[i]), BOUNDS.is_outside(y[i]));
        dark |= if black { y[i].to_bits() } else { 0 };
        let [x, y, z] = [x[i], y[i], z[i]].map(|c| if black { GREY } else { c });
        let scale = (4.0 * UV_SCALE) as f32 / (x + 15.0 * y + 3.0 * z);
        let ((u, near_u), (v, near_v)) = (cut(x * scale), cut(2.25 * y * scale));
        let (l, near) = log_code::<256>(y);
        let l = if black { 0 } else { l + 256 * 64 };
        high[i] = (l >> 8) as u8;
        low[i] = l as u8;
        us[i] = u as u8;
        vs[i] = v as u8;
        // What is not finite gives a code out of range, or one that is not sure.
        let beyond = (u | v) & !255 != ROUND.to_bits();
        let doubt = outside & !black | beyond | (near.max(near_u).max(near_v) > UNSURE);
        doubts[i] = if doubt { u32::MAX } else { 0 };
    }
    if dark != 0 {
        losses.under += count_under(y, BOUNDS);
    }
    for i in doubtful(&doubts) {
        let word = word_32([x[i], y[i], z[i]], [0.0; 3], losses);
        [high[i], low[i], us[i], vs[i]] = word.to_be_bytes();
    }
}

/// Encodes triples, each times `factor`, to 24-bit words, appended with the most significant byte first.
pub fn encode_24(triples: &[f32], factor: f32, cells: &Cells, out: &mut Vec<u8>, losses: &mut Losses) {
    simd::wide(
        #[inline(always)]
        || {
            let (groups, rest) = triples.as_chunks();
            let mut bytes = [0; 3 * GROUP + 1];
            for group in groups {
                group_24(&planes(group, factor), cells, &mut bytes, losses);
                out.extend_from_slice(&bytes[..3 * GROUP]);
            }
            if !rest.is_empty() {
                group_24(&planes(&padded(rest), factor), cells, &mut bytes, losses);
                out.extend_from_slice(&bytes[..rest.len()]);
            }
        },
    );
}

/// The words of a group, three bytes each, and a byte to spare.
#[inline(always)]
fn group_24(group: &Group, cells: &Cells, bytes: &mut [u8; 3 * GROUP + 1], losses: &mut Losses) {
    const BOUNDS: Bounds = Bounds::LOG_24;
    let ([x, y, z], mut words, mut doubts, mut dark) = (group, [0; GROUP], [0; GROUP], 0);
    let (mut us, mut rows) = ([0f32; GROUP], [0u8; GROUP]);
    let (mut starts, mut extents) = ([0f32; GROUP], [0; GROUP]);
    for i in 0..GROUP {
        let (black, outside) = (BOUNDS.is_black(y[i]), BOUNDS.is_outside(y[i]));
        dark |= if black { y[i].to_bits() } else { 0 };
        let [x, y, z] = [x[i], y[i], z[i]].map(|c| if black { GREY } else { c });
        let scale = 4.0 / (x + 15.0 * y + 3.0 * z);
        us[i] = x * scale;
        let (row, near_row) = cut((2.25 * y * scale - cells::V_START as f32) * (1.0 / cells::SIDE) as f32);
        rows[i] = row as u8;
        let (l, near) = log_code::<64>(y);
        words[i] = if black { 0 } else { ((l + 64 * 12) as u32) << 14 };
        let doubt = outside & !black | (row & !255 != ROUND.to_bits()) | (near.max(near_row) > UNSURE);
        doubts[i] = if doubt { u32::MAX } else { 0 };
    }
    for i in 0..GROUP {
        (starts[i], extents[i]) = cells.row(rows[i]);
    }
    for i in 0..GROUP {
        let (cell, near) = cut((us[i] - starts[i]) * (1.0 / cells::SIDE) as f32);
        let cell = cell.wrapping_sub(ROUND.to_bits());
        doubts[i] |= if (near > UNSURE) | (cell >= extents[i] >> 16) { u32::MAX } else { 0 };
        words[i] |= (extents[i] & 0xffff).wrapping_add(cell);
    }
    if dark != 0 {
        losses.under += count_under(y, BOUNDS);
    }
    for i in doubtful(&doubts) {
        words[i] = word_24([x[i], y[i], z[i]], [0.0; 3], cells, losses);
    }
    for (i, word) in words.iter().enumerate() {
        // Four bytes at once, the last of which the next word's first replaces.
        bytes[3 * i..3 * i + 4].copy_from_slice(&(word << 8).to_be_bytes());
    }
}
