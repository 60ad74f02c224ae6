//! Run-length codes: of byte planes, in the two dialects that Greg Ward gave Radiance and LogLuv TIFF, and of Radiance's
//! scanlines of four-byte pixels [Radiance `color.c`; libtiff `tif_luv.c`].
//!
//! A plane is a row of codes, each followed by its bytes: codes from [`Runs::first_run`] on are a run of the next byte, smaller
//! ones that many literal bytes. A scanline in Radiance's new code is `2 2 hi lo` with the width, then four planes. Old code: pixels one by one, `1 1 1 n` repeats the last pixel n times (n << 8 for a second
//! such pixel in a row, and so on).

use std::io::Read;

use crate::simd;
use crate::{Error, Result, invalid};

/// Widths that the new run-length code is written for.
const NEW_RLE: std::ops::RangeInclusive<usize> = 17..=32767;
/// Shortest run worth writing.
const SHORTEST_RUN: usize = 4;
/// A dialect.
#[derive(Clone, Copy, Debug)]
pub struct Runs {
    /// The smallest code that is a run.
    first_run: usize,
    /// Length of a run is its code less this.
    offset: usize,
}

impl Runs {
    /// Radiance: runs of 1 to 127, literals up to 128.
    pub const RADIANCE: Runs = Runs { first_run: 129, offset: 128 };
    /// LogLuv TIFF: runs of 2 to 129, literals up to 127.
    pub const LOGLUV: Runs = Runs { first_run: 128, offset: 126 };

    const fn longest_run(self) -> usize {
        255 - self.offset
    }

    const fn longest_literal(self) -> usize {
        self.first_run - 1
    }

    /// Fewest bytes that can hold a plane of that length.
    pub fn fewest_bytes(self, plane: usize) -> usize {
        2 * plane.div_ceil(self.longest_run())
    }
}

/// Bytes asked for at a time.
const CHUNK: usize = 64 << 10;

/// A scanline as planes: three mantissas and the exponents.
pub type Planes = [Vec<u8>; 4];

/// Decodes scanlines, reading ahead.
#[derive(Default)]
pub struct Decoder {
    /// Bytes read lie from `at` to `end`; what follows is room for more.
    ahead: Vec<u8>,
    at: usize,
    end: usize,
    /// Scanlines of run lengths have come, and others.
    kinds: [bool; 2],
}

/// What is decoded does not end in the bytes at hand.
#[derive(Debug)]
pub struct Short;

impl Decoder {
    /// Forgets what was read ahead.
    pub fn clear(&mut self) {
        (self.at, self.end) = (0, 0);
        self.kinds = [false; 2];
    }

    /// True when some scanlines were run lengths and some were not, which no program writes.
    pub fn is_mixed(&self) -> bool {
        self.kinds == [true; 2]
    }

    /// True while bytes that were read ahead are left.
    pub fn has_rest(&self) -> bool {
        self.at < self.end
    }

    /// The next scanline of `width` pixels, into the planes from `to` on. Memory grows with what arrives, not with what `width`
    /// claims.
    pub fn scanline(&mut self, input: &mut dyn Read, width: usize, planes: &mut Planes, to: usize) -> Result<()> {
        loop {
            match decode(&self.ahead[self.at..self.end], width, planes, to)? {
                Ok(taken) => {
                    self.kinds[usize::from(has_run_lengths(&self.ahead[self.at..]))] = true;
                    self.at += taken;
                    return Ok(());
                }
                Err(Short) => self.refill(input)?,
            }
        }
    }

    /// Reads what there is, at least one byte, and as much as lies here already, so that retries stay few.
    fn refill(&mut self, input: &mut dyn Read) -> Result<()> {
        self.ahead.copy_within(self.at..self.end, 0);
        (self.at, self.end) = (0, self.end - self.at);
        let wanted = self.end + CHUNK.max(self.end);
        if self.ahead.len() < wanted {
            self.ahead.resize(wanted, 0);
        }
        let got = loop {
            match input.read(&mut self.ahead[self.end..wanted]) {
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        match got {
            Ok(0) => Err(Error::io("", std::io::ErrorKind::UnexpectedEof.into())),
            Ok(count) => {
                self.end += count;
                Ok(())
            }
            Err(e) => Err(Error::io("", e)),
        }
    }
}

/// Whether a scanline begins as those of run lengths do.
fn has_run_lengths(bytes: &[u8]) -> bool {
    matches!(bytes, [2, 2, 0..128, ..])
}

/// Decodes one scanline at the head of `bytes`, into the planes from `to` on; gives the number of bytes it took.
fn decode(bytes: &[u8], width: usize, planes: &mut Planes, to: usize) -> Result<Result<usize, Short>> {
    let Some(&[_, _, high, low]) = bytes.first_chunk() else { return Ok(Err(Short)) };
    if !has_run_lengths(bytes) {
        return decode_old(bytes, width, planes, to);
    }
    let stated = usize::from(high) << 8 | usize::from(low);
    if stated != width {
        return invalid!("a run-length coded scanline says it is {stated} pixels wide, the picture is {width}");
    }
    let mut at = 4;
    for plane in planes {
        plane.resize(plane.len().max(to + width), 0);
        match Runs::RADIANCE.decode(&bytes[at..], &mut plane[to..to + width])? {
            Ok(taken) => at += taken,
            Err(Short) => return Ok(Err(Short)),
        }
    }
    Ok(Ok(at))
}

/// Copies this long are one register wide, whatever part of them counts.
const SHORT_COPY: usize = 16;

impl Runs {
    /// Fills a plane from the head of `bytes`; gives the number of bytes it took.
    pub fn decode(self, bytes: &[u8], plane: &mut [u8]) -> Result<Result<usize, Short>> {
        let (mut from, mut to) = (0, 0);
        while to < plane.len() {
            let Some(&code) = bytes.get(from) else { return Ok(Err(Short)) };
            let code = usize::from(code);
            let run = code >= self.first_run;
            let count = if run { code - self.offset } else { code };
            let left = plane.len() - to;
            if count == 0 || count > left {
                return invalid!("run-length code {code} does not fit the {left} pixels left of the scanline");
            }
            from += 1;
            let taken = if run { 1 } else { count };
            let Some(source) = bytes.get(from..from + taken) else { return Ok(Err(Short)) };
            match plane[to..].first_chunk_mut::<SHORT_COPY>() {
                Some(target) if run && count <= SHORT_COPY => *target = [source[0]; SHORT_COPY],
                _ if run => plane[to..to + count].fill(source[0]),
                Some(target) if count <= SHORT_COPY => match bytes[from..].first_chunk::<SHORT_COPY>() {
                    Some(wide) => *target = *wide,
                    None => target[..count].copy_from_slice(source),
                },
                _ => plane[to..to + count].copy_from_slice(source),
            }
            from += taken;
            to += count;
        }
        Ok(Ok(from))
    }
}

/// Flat pixels with old-style repeats.
fn decode_old(bytes: &[u8], width: usize, planes: &mut Planes, to: usize) -> Result<Result<usize, Short>> {
    planes.iter_mut().for_each(|plane| plane.truncate(to));
    let (mut at, mut shift) = (0, 0);
    while planes[0].len() < to + width {
        let Some(&pixel) = bytes[at..].first_chunk::<4>() else { return Ok(Err(Short)) };
        at += 4;
        if pixel[..3] != [1, 1, 1] {
            planes.iter_mut().zip(pixel).for_each(|(plane, byte)| plane.push(byte));
            shift = 0;
            continue;
        }
        let count = usize::from(pixel[3]) << shift;
        let done = planes[0].len();
        if done == to {
            return invalid!("a scanline begins with a repeat count");
        }
        if count > to + width - done {
            return invalid!("a repeat of {count} pixels runs past the end of the scanline");
        }
        for plane in planes.iter_mut() {
            plane.resize(done + count, plane[done - 1]);
        }
        shift = (shift + 8).min(24);
    }
    Ok(Ok(at))
}

/// Appends one scanline: new run-length code for widths 17 to 32767, flat otherwise, as Radiance writes them.
pub fn encode(planes: &Planes, out: &mut Vec<u8>) {
    let width = planes[0].len();
    if !NEW_RLE.contains(&width) {
        for i in 0..width {
            out.extend(planes.each_ref().map(|plane| plane[i]));
        }
        return;
    }
    out.extend([2, 2, (width >> 8) as u8, width as u8]);
    Runs::RADIANCE.encode_planes(planes, out);
}

impl Runs {
    /// Appends planes, one after the other.
    pub fn encode_planes(self, planes: &[Vec<u8>], out: &mut Vec<u8>) {
        simd::wide(
            #[inline(always)]
            || {
                for plane in planes {
                    self.encode(plane, out);
                }
            },
        );
    }

    /// Appends a plane. The choice of runs is Radiance's and libtiff's own, so that equal planes give equal bytes: runs of at
    /// least four; two or three equal bytes before such a run go out as a short run when they are all that precedes it.
    #[inline(always)]
    pub fn encode(self, plane: &[u8], out: &mut Vec<u8>) {
        let mut at = 0;
        while at < plane.len() {
            let begin = next_run(plane, at);
            let before = begin - at;
            if before > 1 && before < SHORTEST_RUN && plane[at..begin].iter().all(|b| *b == plane[at]) {
                out.extend([(self.offset + before) as u8, plane[at]]);
                at = begin;
            }
            while at < begin {
                let count = (begin - at).min(self.longest_literal());
                out.push(count as u8);
                out.extend_from_slice(&plane[at..at + count]);
                at += count;
            }
            if begin < plane.len() {
                let run = run_length(&plane[begin..], self.longest_run());
                out.extend([(self.offset + run) as u8, plane[begin]]);
                at += run;
            }
        }
    }
}

/// Bytes looked at together in search of a run.
const WINDOW: usize = 64;
/// Bytes after the first that a run needs.
const REACH: usize = SHORTEST_RUN - 1;

/// Where the next [`SHORTEST_RUN`] equal bytes begin, from `at` on; the plane's length where there are none.
#[inline(always)]
pub fn next_run(plane: &[u8], mut at: usize) -> usize {
    // The next run is often near: eight bytes first.
    match run_in_eight(plane, at) {
        Some(Some(found)) => return found,
        Some(None) => at += 8,
        None => {}
    }
    while let Some(window) = plane[at..].first_chunk::<{ WINDOW + REACH }>() {
        let mut equal = [0u8; WINDOW];
        for (i, e) in equal.iter_mut().enumerate() {
            let [a, b, c, d] = [window[i], window[i + 1], window[i + 2], window[i + 3]];
            *e = (a ^ b) | (b ^ c) | (c ^ d);
        }
        // A minimum of all is found a register at a time; the first zero only where there is one.
        if equal.iter().fold(255, |least: u8, e| least.min(*e)) == 0 {
            let eights = equal.as_chunks::<8>().0.iter().map(|eight| first_zero(u64::from_le_bytes(*eight)));
            let found = eights.enumerate().find_map(|(i, zero)| zero.map(|z| 8 * i + z));
            return at + found.unwrap_or(0);
        }
        at += WINDOW;
    }
    let rest = &plane[at..];
    rest.windows(SHORTEST_RUN).position(|w| w.iter().all(|b| *b == w[0])).map_or(plane.len(), |i| at + i)
}

/// Where a run begins among eight bytes, if one does; nothing known near the plane's end.
#[inline(always)]
fn run_in_eight(plane: &[u8], at: usize) -> Option<Option<usize>> {
    let bytes = plane[at..].first_chunk::<{ 8 + REACH }>()?;
    let eight = |i: usize| bytes[i..].first_chunk().map_or(0, |eight| u64::from_le_bytes(*eight));
    let [a, b, c, d] = [eight(0), eight(1), eight(2), eight(3)];
    Some(first_zero((a ^ b) | (b ^ c) | (c ^ d)).map(|i| at + i))
}

/// Index of the lowest byte that is 0.
#[inline(always)]
fn first_zero(eight: u64) -> Option<usize> {
    const LOW: u64 = 0x0101_0101_0101_0101;
    // A borrow reaches past a byte only from a 0 below it, so the lowest mark is right.
    let marks = eight.wrapping_sub(LOW) & !eight & (LOW << 7);
    (marks != 0).then(|| marks.trailing_zeros() as usize / 8)
}

/// Number of bytes equal to the first, at most `most`.
#[inline(always)]
pub fn run_length(bytes: &[u8], most: usize) -> usize {
    let bytes = &bytes[..bytes.len().min(most)];
    let same = u64::from_ne_bytes([bytes[0]; 8]);
    let mut n = 0;
    while let Some(eight) = bytes[n..].first_chunk() {
        let differ = u64::from_le_bytes(*eight) ^ same;
        if differ != 0 {
            return n + differ.trailing_zeros() as usize / 8;
        }
        n += 8;
    }
    n + bytes[n..].iter().take_while(|b| **b == bytes[0]).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decoded(bytes: &[u8], width: usize) -> Result<Planes> {
        let mut planes = Planes::default();
        Decoder::default().scanline(&mut &*bytes, width, &mut planes, 0).map(|()| planes)
    }

    #[test]
    fn the_measured_bytes_of_a_20_pixel_row() {
        // Radiance 6.0 wrote `02 02 00 14 | 94 80 | 94 40 | 94 20 | 94 81` for twenty pixels (128, 64, 32, 129).
        let mut out = Vec::new();
        encode(&[128, 64, 32, 129].map(|b| vec![b; 20]), &mut out);
        assert_eq!(out, [2, 2, 0, 20, 0x94, 0x80, 0x94, 0x40, 0x94, 0x20, 0x94, 0x81]);
    }

    #[test]
    fn old_runs_of_two_markers() {
        // A pixel, then 43 + 1 x 256 repeats of it: 300 pixels.
        let planes = decoded(&[128, 64, 32, 129, 1, 1, 1, 43, 1, 1, 1, 1], 300).unwrap();
        assert_eq!(planes, [128, 64, 32, 129].map(|b| vec![b; 300]));
    }

    proptest! {
        /// Planes with runs of all lengths come back, in both dialects; so they do when bytes arrive a few at a time.
        #[test]
        fn planes_come_back(runs in prop::collection::vec((any::<u8>(), 1usize..140), 1..60), step in 1usize..40) {
            let bytes: Vec<u8> = runs.iter().flat_map(|(byte, n)| vec![*byte; *n]).collect();
            let width = bytes.len().div_ceil(4);
            let planes: Planes = std::array::from_fn(|i| (0..width).map(|x| bytes[(4 * x + i) % bytes.len()]).collect());
            for runs in [Runs::RADIANCE, Runs::LOGLUV] {
                let (mut coded, mut got) = (Vec::new(), vec![0; bytes.len()]);
                runs.encode(&bytes, &mut coded);
                prop_assert_eq!(runs.decode(&coded, &mut got).unwrap().unwrap(), coded.len());
                prop_assert_eq!(&got, &bytes);
                prop_assert!(runs.fewest_bytes(bytes.len()) <= coded.len());
            }
            let mut coded = Vec::new();
            encode(&planes, &mut coded);
            if NEW_RLE.contains(&width) || !coded.chunks(4).any(|p| p[..3] == [1, 1, 1] || p[..2] == [2, 2]) {
                prop_assert_eq!(&decoded(&coded, width).unwrap(), &planes);
                let mut pieces: Box<dyn Read> = Box::new(std::io::empty());
                for piece in coded.chunks(step) {
                    pieces = Box::new(pieces.chain(piece));
                }
                let mut got = Planes::default();
                Decoder::default().scanline(&mut pieces, width, &mut got, 0).unwrap();
                prop_assert_eq!(&got, &planes);
            }
        }

        /// The windowed search finds what a plain one finds.
        #[test]
        fn runs_are_found(runs in prop::collection::vec((0u8..3, 1usize..9), 1..80), at in 0usize..50) {
            let plane: Vec<u8> = runs.iter().flat_map(|(byte, n)| vec![*byte; *n]).collect();
            let at = at.min(plane.len());
            let plain = (at..plane.len()).find(|i| plane[*i..].len() >= 4 && plane[*i..*i + 4].iter().all(|b| *b == plane[*i]));
            prop_assert_eq!(next_run(&plane, at), plain.unwrap_or(plane.len()));
            if at < plane.len() {
                let plain = plane[at..].iter().take(127).take_while(|b| **b == plane[at]).count();
                prop_assert_eq!(run_length(&plane[at..], 127), plain);
            }
        }
    }
}
