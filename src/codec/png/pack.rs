//! Rows of codes as PNG stores them: filtered, deflated in pieces side by side, framed in chunks.

use flate2::{Compress, Compression, Crc, FlushCompress, Status};

use crate::simd;

/// zlib's own header: deflate, 32 KiB window, default level.
pub const ZLIB: [u8; 2] = [0x78, 0x9c];
/// Effort for 8 bits: a rendered picture is 3 % larger than at zlib's usual 6, in a third of the time.
pub const EFFORT_8: u32 = 3;
/// Effort for 16 bits, whose low bytes are noise: more gains 0.1 % in three times the time.
pub const EFFORT_16: u32 = 1;

/// A chunk with its length and checksum.
pub fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = Crc::new();
    crc.update(name);
    crc.update(data);
    let mut out = (data.len() as u32).to_be_bytes().to_vec();
    out.extend(name);
    out.extend(data);
    out.extend(crc.sum().to_be_bytes());
    out
}

/// A whole zlib stream.
pub fn zlib(data: &[u8]) -> Vec<u8> {
    let mut out = ZLIB.to_vec();
    deflate(data, 9, true, &mut out);
    out.extend(Adler::of(data).0.to_be_bytes());
    out
}

/// Appends `data` deflated, ending at a whole byte; the `last` piece closes the stream. It cannot fail: there is no
/// dictionary.
pub fn deflate(data: &[u8], effort: u32, last: bool, out: &mut Vec<u8>) {
    let flush = if last { FlushCompress::Finish } else { FlushCompress::Sync };
    let mut deflater = Compress::new(Compression::new(effort), false);
    loop {
        out.reserve(data.len() / 2 + 4096);
        let rest = &data[deflater.total_in() as usize..];
        let status = deflater.compress_vec(rest, out, flush);
        let room = out.len() < out.capacity();
        // Without room there may be more to come; with room everything has come.
        if status.is_err() || matches!(status, Ok(Status::StreamEnd)) || (room && !last) {
            return;
        }
    }
}

/// zlib's checksum of some bytes, and their number.
#[derive(Clone, Copy, Debug)]
pub struct Adler(pub u32, u64);

const ADLER: u64 = 65521;

impl Adler {
    /// Of nothing.
    pub const NONE: Adler = Adler(1, 0);

    /// Of these bytes.
    pub fn of(data: &[u8]) -> Adler {
        let (mut a, mut b) = (1u32, 0u32);
        // So many bytes do not overflow the sums.
        for part in data.chunks(5552) {
            for byte in part {
                a += u32::from(*byte);
                b += a;
            }
            (a, b) = (a % ADLER as u32, b % ADLER as u32);
        }
        Adler(b << 16 | a, data.len() as u64)
    }

    /// Of these bytes and then those.
    pub fn then(self, next: Adler) -> Adler {
        let (a1, b1) = (u64::from(self.0 & 0xffff), u64::from(self.0 >> 16));
        let (a2, b2) = (u64::from(next.0 & 0xffff), u64::from(next.0 >> 16));
        let a = (a1 + a2 + ADLER - 1) % ADLER;
        let b = (b1 + b2 + next.1 % ADLER * ((a1 + ADLER - 1) % ADLER)) % ADLER;
        Adler((b << 16 | a) as u32, self.1 + next.1)
    }
}

/// Filters rows, each by the filter that leaves the smallest sum of absolute differences.
#[derive(Default)]
pub struct Filters {
    best: Vec<u8>,
    trial: Vec<u8>,
}

impl Filters {
    /// Appends a row with its filter's number in front. `above` is the row above it, zeros for the first; pixels have
    /// `step` bytes.
    pub fn row(&mut self, row: &[u8], above: &[u8], step: usize, out: &mut Vec<u8>) {
        self.best.clear();
        self.best.extend_from_slice(row);
        let (mut least, mut kind) = (sum(row), 0);
        for filter in 1..=4 {
            self.trial.resize(row.len(), 0);
            let trial = &mut self.trial[..];
            apply(filter, row, above, step, trial);
            let total = sum(trial);
            if total < least {
                (least, kind) = (total, filter);
                std::mem::swap(&mut self.best, &mut self.trial);
            }
        }
        out.push(kind);
        out.extend_from_slice(&self.best);
    }
}

/// Sum of the bytes as signed magnitudes.
fn sum(row: &[u8]) -> u64 {
    simd::wide(
        #[inline(always)]
        || {
            let parts =
                row.chunks(1 << 16).map(|p| p.iter().map(|b| u32::from((*b as i8).unsigned_abs())).sum::<u32>());
            parts.map(u64::from).sum()
        },
    )
}

fn apply(filter: u8, row: &[u8], above: &[u8], step: usize, out: &mut [u8]) {
    let n = row.len();
    let step = step.min(n);
    // The first pixel has nothing to its left.
    for i in 0..step {
        let predicted = match filter {
            1 => 0,
            3 => above[i] / 2,
            _ => above[i],
        };
        out[i] = row[i].wrapping_sub(predicted);
    }
    let (here, left, up, corner) = (&row[step..], &row[..n - step], &above[step..], &above[..n - step]);
    let out = &mut out[step..];
    simd::wide(
        #[inline(always)]
        || {
            let each =
                out.iter_mut().zip(here).zip(left).zip(up).zip(corner).map(|((((o, h), l), u), c)| (o, h, l, u, c));
            match filter {
                1 => each.for_each(|(o, h, l, _, _)| *o = h.wrapping_sub(*l)),
                2 => each.for_each(|(o, h, _, u, _)| *o = h.wrapping_sub(*u)),
                3 => each.for_each(|(o, h, l, u, _)| *o = h.wrapping_sub(((u16::from(*l) + u16::from(*u)) / 2) as u8)),
                _ => each.for_each(|(o, h, l, u, c)| *o = h.wrapping_sub(paeth(*l, *u, *c))),
            }
        },
    );
}

#[inline(always)]
fn paeth(left: u8, up: u8, corner: u8) -> u8 {
    let (l, u, c) = (i16::from(left), i16::from(up), i16::from(corner));
    let (to_l, to_u, to_c) = ((u - c).abs(), (l - c).abs(), (l + u - 2 * c).abs());
    let of_two = if to_u <= to_c { up } else { corner };
    if to_l <= to_u && to_l <= to_c { left } else { of_two }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces of any length make one stream that another inflater reads, checksum included.
    #[test]
    fn pieces_make_one_stream() {
        let data: Vec<u8> = (0..200_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> (20 + i % 9)) as u8).collect();
        for piece in [1, 1000, 65_536, 199_999, 200_000] {
            let data = &data[..if piece == 1 { 300 } else { data.len() }];
            let (mut out, mut adler) = (ZLIB.to_vec(), Adler::NONE);
            let count = data.len().div_ceil(piece);
            for (i, part) in data.chunks(piece).enumerate() {
                deflate(part, 3, i + 1 == count, &mut out);
                adler = adler.then(Adler::of(part));
            }
            assert_eq!(adler.0, Adler::of(data).0);
            out.extend(adler.0.to_be_bytes());
            let mut back = Vec::new();
            std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&out[..]), &mut back).unwrap();
            assert!(back == data, "{piece}");
        }
        assert_eq!(Adler::of(b"Wikipedia").0, 0x11e6_0398); // the article on Adler-32
    }
}
