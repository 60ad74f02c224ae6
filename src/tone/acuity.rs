//! How fine an eye sees: dark places are blurred to what it resolves there.
//!
//! Highest visible frequency at a luminance La [Shaler 1937, as fitted by Ward 1997]:
//!
//! ```text
//! R = 17.25 atan(1.4 log10 La + 0.35) + 25.72 cycles a degree
//! ```
//!
//! A picture of p pixels a degree shows p / 2; where the eye sees less, it is averaged over p / (2 R) pixels. Means over
//! squares of 1, 2, 4 ... pixels are kept as a pyramid, and each pixel is taken between the two levels that its blur lies
//! between: none at level 0, so that nothing jumps where the blur sets in. A window of the pyramid goes down the picture with
//! the rows; it holds as many rows as twice the widest blur.

use std::collections::VecDeque;

use crate::stream::{Block, Header, Picture, picture};
use crate::tone::fovea::Field;
use crate::{Result, parallel, simd};

/// Luminance under which acuity is that at it: the fit falls to nothing soon after.
const DARKEST_CD_M2: f64 = 1e-7;

/// Cycles a degree that an eye adapted to a luminance in cd/m2 resolves.
///
/// ```
/// use luxpipe::tone::acuity::cycles_a_degree;
/// assert!((cycles_a_degree(1.0) - 31.5276).abs() < 1e-3 && (cycles_a_degree(1e-4) - 1.87058).abs() < 1e-3);
/// ```
pub fn cycles_a_degree(adaptation_cd_m2: f64) -> f64 {
    17.25 * (1.4 * adaptation_cd_m2.max(DARKEST_CD_M2).log10() + 0.35).atan() + 25.72
}

/// Pyramid level of the blur at a place: log2 of its width in pixels, 0 for none.
pub fn level(adaptation_cd_m2: f64, pixels_a_degree: f64) -> f64 {
    (pixels_a_degree / (2.0 * cycles_a_degree(adaptation_cd_m2))).log2().max(0.0)
}

/// A picture as an eye resolves it.
pub struct Blurred {
    input: Box<dyn Picture>,
    header: Header,
    levels: Field<1>,
    pyramid: Pyramid,
    read: usize,
    given: usize,
    block: Block,
}

/// Blurs each pixel by the level its cell has.
pub fn blurred(input: Box<dyn Picture>, levels: Field<1>, highest: f64) -> Box<dyn Picture> {
    let header = input.header().clone();
    let r = header.resolution;
    let pyramid = Pyramid::new(header.ncomp, r.scanline_len(), r.scanlines(), highest.ceil() as usize);
    Box::new(Blurred { input, header, levels, pyramid, read: 0, given: 0, block: Block::default() })
}

impl Picture for Blurred {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let all = self.header.resolution.scanlines();
        let left = all - self.given;
        block.rows = if left == 0 { 0 } else { picture::block_rows(&self.header, left) };
        let floats = self.header.scanline_floats();
        block.data.resize(block.rows * floats, 0.0);
        if left == 0 {
            return Ok(false);
        }
        let (first, last) = (self.given, self.given + block.rows - 1);
        while self.read < all && !self.pyramid.reaches(last) {
            self.input.next(&mut self.block)?;
            for row in self.block.data.chunks_exact(floats) {
                self.pyramid.push(0, row.to_vec());
            }
            self.read += self.block.rows;
        }
        let (levels, pyramid) = (&self.levels, &self.pyramid);
        parallel::for_pieces(&mut block.data, floats, |row, piece| {
            for (i, out) in piece.chunks_exact_mut(floats).enumerate() {
                pyramid.row(first + row + i, levels, out);
            }
        });
        self.given += block.rows;
        self.pyramid.forget(self.given);
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        let r = self.header.resolution;
        self.pyramid = Pyramid::new(self.header.ncomp, r.scanline_len(), r.scanlines(), self.pyramid.levels.len() - 1);
        (self.read, self.given) = (0, 0);
        self.input.rewind()
    }
}

struct Level {
    width: usize,
    height: usize,
    rows: VecDeque<Vec<f32>>,
    /// Index of the first row held.
    first: usize,
}

impl Level {
    /// The row, or the nearest there is.
    fn row(&self, y: usize) -> &[f32] {
        &self.rows[y.clamp(self.first, self.first + self.rows.len() - 1) - self.first]
    }
}

/// Means over squares of 2^k pixels, as far down as they have come.
struct Pyramid {
    ncomp: usize,
    levels: Vec<Level>,
}

impl Pyramid {
    fn new(ncomp: usize, width: usize, height: usize, highest: usize) -> Pyramid {
        let (mut w, mut h) = (width, height);
        let mut levels = Vec::new();
        for _ in 0..=highest {
            levels.push(Level { width: w, height: h, rows: VecDeque::new(), first: 0 });
            if w == 1 && h == 1 {
                break;
            }
            (w, h) = (w.div_ceil(2), h.div_ceil(2));
        }
        Pyramid { ncomp, levels }
    }

    /// Adds the next row of a level, and what it completes above.
    fn push(&mut self, k: usize, row: Vec<f32>) {
        let n = self.ncomp;
        let level = &mut self.levels[k];
        level.rows.push_back(row);
        let count = level.first + level.rows.len();
        if k + 1 == self.levels.len() || (count % 2 == 1 && count != self.levels[k].height) {
            return;
        }
        let (level, width) = (&self.levels[k], self.levels[k + 1].width);
        let lower = &level.rows[level.rows.len() - 1];
        let upper = if count.is_multiple_of(2) { &level.rows[level.rows.len() - 2] } else { lower };
        let mut mean = vec![0f32; width * n];
        simd::wide(
            #[inline(always)]
            || match n {
                3 => means::<3>(upper, lower, &mut mean),
                4 => means::<4>(upper, lower, &mut mean),
                _ => {}
            },
        );
        self.push(k + 1, mean);
    }

    /// Place of scanline (or pixel) y between the rows of level k: the one before and the share of the way to the next.
    #[inline(always)]
    fn between(k: usize, y: usize) -> (usize, f32) {
        let at = (y as f32 + 0.5) / (1u32 << k) as f32 - 0.5;
        let at = if at > 0.0 { at } else { 0.0 };
        let whole = at as u32;
        (whole as usize, at - whole as f32)
    }

    /// Whether all rows that scanline y needs are there.
    fn reaches(&self, y: usize) -> bool {
        self.levels.iter().enumerate().all(|(k, level)| {
            let needed = (Pyramid::between(k, y).0 + 1).min(level.height - 1);
            level.first + level.rows.len() > needed
        })
    }

    /// Drops what no scanline from y on needs.
    fn forget(&mut self, y: usize) {
        for (k, level) in self.levels.iter_mut().enumerate() {
            // A level's last two rows are still to make one above.
            while level.first < Pyramid::between(k, y).0 && level.rows.len() > 2 {
                level.rows.pop_front();
                level.first += 1;
            }
        }
    }

    /// Scanline y, blurred.
    fn row(&self, y: usize, levels: &Field<1>, out: &mut [f32]) {
        let n = self.ncomp;
        out.copy_from_slice(self.levels[0].row(y));
        let line = levels.scanline(y);
        if line.iter().all(|l| l[0] <= 0.0) || self.levels.len() < 2 {
            return;
        }
        let top = self.levels.len() - 1;
        let highest = line.iter().fold(0f32, |m, l| m.max(l[0])).min(top as f32).ceil() as usize;
        // The rows of the levels that this scanline lies between, blended.
        let blended: Vec<Vec<f32>> = (1..=highest).map(|k| self.blended(k, y)).collect();
        let lines: Vec<&[f32]> =
            std::iter::once(self.levels[0].row(y)).chain(blended.iter().map(Vec::as_slice)).collect();
        simd::wide(
            #[inline(always)]
            || match n {
                3 => between_levels::<3>(&lines, levels, &line, out),
                4 => between_levels::<4>(&lines, levels, &line, out),
                _ => {}
            },
        );
    }

    /// Level k at scanline y, with a copy of its last mean behind it.
    fn blended(&self, k: usize, y: usize) -> Vec<f32> {
        let level = &self.levels[k];
        let (j, t) = Pyramid::between(k, y);
        let (a, b) = (level.row(j.min(level.height - 1)), level.row((j + 1).min(level.height - 1)));
        let mut line: Vec<f32> = a.iter().zip(b).map(|(p, q)| p + t * (q - p)).collect();
        line.extend_from_within(line.len() - self.ncomp..);
        line
    }
}

/// Means over squares of two rows.
#[inline(always)]
fn means<const N: usize>(upper: &[f32], lower: &[f32], out: &mut [f32]) {
    let (upper, lower, out) = (upper.as_chunks::<N>().0, lower.as_chunks::<N>().0, out.as_chunks_mut::<N>().0);
    let mean = |u: &[[f32; N]; 2], l: &[[f32; N]; 2]| -> [f32; N] {
        std::array::from_fn(|c| {
            let sum = u[0][c] + u[1][c] + l[0][c] + l[1][c];
            if sum.abs() < f32::INFINITY { 0.25 * sum } else { 0.0 }
        })
    };
    let ((uppers, one), (lowers, other)) = (upper.as_chunks::<2>(), lower.as_chunks::<2>());
    for ((u, l), value) in uppers.iter().zip(lowers).zip(out.iter_mut()) {
        *value = mean(u, l);
    }
    if let ([u], [l], Some(value)) = (one, other, out.last_mut()) {
        *value = mean(&[*u; 2], &[*l; 2]);
    }
}

/// Level k, from 1, as fine as the picture: pixels from `first` on between the means around them.
#[inline(always)]
fn spread<const N: usize>(line: &[[f32; N]], k: usize, first: usize, out: &mut [[f32; N]]) {
    let mix =
        |i: usize, s: f32| -> [f32; N] { std::array::from_fn(|c| line[i][c] + s * (line[i + 1][c] - line[i][c])) };
    let one = |x: usize| {
        let (i, s) = Pyramid::between(k, x);
        mix(i.min(line.len() - 2), s)
    };
    // Between the middles of two means lie 2^k pixels, but for those before the first.
    let (size, half) = (1usize << k, 1usize << (k - 1));
    let lead = if first < half { half - first } else { (first - half).wrapping_neg() % size }.min(out.len());
    let end = first + out.len();
    let (head, body) = out.split_at_mut(lead);
    head.iter_mut().enumerate().for_each(|(j, pixel)| *pixel = one(first + j));
    let start = first + lead;
    let mut blocks = body.chunks_exact_mut(size);
    for (block, pair) in (&mut blocks).zip(line[start.saturating_sub(half) >> k..].windows(2)) {
        let step: [f32; N] = std::array::from_fn(|c| pair[1][c] - pair[0][c]);
        for (j, pixel) in block.iter_mut().enumerate() {
            let s = (j as f32 + 0.5) / size as f32;
            (0..N).for_each(|c| pixel[c] = pair[0][c] + s * step[c]);
        }
    }
    let rest = blocks.into_remainder();
    let start = end - rest.len();
    rest.iter_mut().enumerate().for_each(|(j, pixel)| *pixel = one(start + j));
}

/// The same, for few pixels a mean by loops of known length.
#[inline(always)]
fn spread_any<const N: usize>(line: &[[f32; N]], k: usize, first: usize, out: &mut [[f32; N]]) {
    match k {
        1 => spread(line, 1, first, out),
        2 => spread(line, 2, first, out),
        _ => spread(line, k, first, out),
    }
}

/// Each pixel between the two levels that its blur lies between.
#[inline(always)]
fn between_levels<const N: usize>(lines: &[&[f32]], levels: &Field<1>, line: &[[f32; 1]], out: &mut [f32]) {
    let (top, most) = ((lines.len() - 1) as f32, lines.len() - 2);
    let out = out.as_chunks_mut::<N>().0;
    let (mut lower, mut upper) = (vec![[0f32; N]; out.len()], vec![[0f32; N]; out.len()]);
    for stretch in levels.along(line) {
        let ([start], [step]) = (stretch.start, stretch.step);
        let at = |t: f32| {
            let l = start + t * step;
            if l < top { l } else { top }
        };
        // 0 where nothing is to be done, otherwise one more than the lower level.
        let kind = |t: f32| if at(t) > 0.0 { (at(t) as u32 as usize).min(most) + 1 } else { 0 };
        let shares = stretch.shares;
        let mut i = 0;
        while i < shares.len() {
            // Along a stretch the blur goes one way.
            let here = kind(shares[i]);
            let same = here == kind(shares[shares.len() - 1]);
            let until = if same { None } else { shares[i..].iter().position(|t| kind(*t) != here) };
            let end = until.map_or(shares.len(), |n| i + n);
            if here > 0 {
                let (k, first) = (here - 1, stretch.pixels.start + i);
                let (pixels, n) = (&mut out[first..first + end - i], end - i);
                let (lower, upper) = (&mut lower[..n], &mut upper[..n]);
                match k {
                    0 => lower.copy_from_slice(pixels),
                    _ => spread_any(lines[k].as_chunks::<N>().0, k, first, lower),
                }
                spread_any(lines[k + 1].as_chunks::<N>().0, k + 1, first, upper);
                for (((pixel, a), b), t) in pixels.iter_mut().zip(lower).zip(upper).zip(&shares[i..end]) {
                    let part = at(*t) - k as f32;
                    (0..N).for_each(|c| pixel[c] = a[c] + part * (b[c] - a[c]));
                }
            }
            i = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Components, Resolution, Units};
    use crate::tone::fovea::Cells;

    struct Given(Header, Vec<f32>, usize);
    impl Picture for Given {
        fn header(&self) -> &Header {
            &self.0
        }
        fn next(&mut self, block: &mut Block) -> Result<bool> {
            let (n, all) = (self.0.scanline_floats(), self.0.resolution.scanlines());
            block.rows = (all - self.2).min(3);
            block.data = self.1[self.2 * n..(self.2 + block.rows) * n].to_vec();
            self.2 += block.rows;
            Ok(block.rows > 0)
        }
    }

    fn run(width: usize, height: usize, data: Vec<f32>, level: f32) -> Vec<f32> {
        let header = Header::new(Resolution::upright(width, height), Components::Xyz, 3, Units::CdM2);
        let (cells, _) = Cells::of(&header);
        let levels = Field::new(cells.clone(), vec![[level]; cells.count()]);
        let mut picture = blurred(Box::new(Given(header, data, 0)), levels, f64::from(level));
        let (mut all, mut block) = (Vec::new(), Block::default());
        while picture.next(&mut block).unwrap() {
            all.extend_from_slice(&block.data);
        }
        all
    }

    #[test]
    fn the_fit_is_the_published_one() {
        // acuity-shaler, by an independent evaluation of the formula.
        let want = [1.87058, 3.00742, 5.30855, 11.7512, 31.5276, 43.861, 47.5136, 49.0844, 49.9439];
        for (i, want) in want.iter().enumerate() {
            assert!((cycles_a_degree(10f64.powi(i as i32 - 4)) - want).abs() < 1e-3);
        }
    }

    #[test]
    fn an_even_picture_stays_and_light_is_kept() {
        for (w, h) in [(1, 1), (7, 5), (64, 33), (1, 40)] {
            for level in [0.0, 0.3, 1.0, 2.5, 6.0] {
                assert!(
                    run(w, h, vec![2.0; 3 * w * h], level).iter().all(|x| (x - 2.0).abs() < 1e-5),
                    "{w} {h} {level}"
                );
            }
        }
        // A point away from the rim keeps its light to what sampling a bilinear surface at pixels loses.
        let mut point = vec![0.0; 3 * 64 * 64];
        point[3 * (30 * 64 + 29) + 1] = 1000.0;
        for level in [0.0f32, 0.4, 1.0, 1.7, 2.0, 3.0] {
            let out = run(64, 64, point.clone(), level);
            let sum: f32 = out.iter().sum();
            assert!((sum - 1000.0).abs() < 2.0, "{level}: {sum}");
            let rows = out.chunks(3 * 64).filter(|r| r.iter().any(|x| *x > 0.0)).count();
            assert!(rows as f32 <= 2.0 * 2f32.powf(level.ceil()) + 1.0, "{level} {rows}");
        }
    }

    #[test]
    fn blur_sets_in_without_a_step() {
        let data: Vec<f32> = (0..3 * 40 * 30).map(|i| (i * 7919 % 101) as f32).collect();
        let mut last = run(40, 30, data.clone(), 0.0);
        assert_eq!(last, data);
        for i in 1..=60 {
            let now = run(40, 30, data.clone(), i as f32 * 0.05);
            let step = now.iter().zip(&last).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(step < 6.0, "{i}: {step}"); // 101 x 0.05 and rounding
            last = now;
        }
    }
}
