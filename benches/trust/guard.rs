//! What damage a file can show by itself: the bytes of its pixels, and whether they carry a checksum. A flipped bit of a raw float
//! or of an unprotected run is another number, which no reader can know; a file that is cut, prolonged or shifted has another length,
//! which every reader can (run lengths that fall into step again excepted); deflated pixels (PNG, ZIP in OpenEXR, Pixar log) carry a sum besides.

use std::ops::Range;

/// What must not pass unseen.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    /// Where pixels lie, if that is known.
    pub pixels: Vec<Range<usize>>,
    /// Do they carry a sum?
    pub summed: bool,
    /// Pixels across and down of run lengths of four bytes a pixel.
    pub runs: Option<[usize; 2]>,
}

impl Guard {
    /// Of a whole file, by its first bytes; nothing is guarded in what is not a picture.
    pub fn of(bytes: &[u8]) -> Guard {
        let found = match bytes {
            [b'#', b'?', ..] => stream(bytes),
            [b'P', b'F' | b'f', b'\n', ..] => pfm(bytes),
            [0x89, b'P', b'N', b'G', ..] => png(bytes),
            [0x76, 0x2f, 0x31, 0x01, ..] => exr(bytes),
            [b'I', b'I', 42, 0, ..] => tiff(bytes),
            _ => None,
        };
        found.unwrap_or_default()
    }

    /// Is a damaged file whole again, by chance? Run lengths that lost or gained bytes can fall into step, and end where the file
    /// does: then nothing tells them from others.
    pub fn explains(&self, bytes: &[u8]) -> bool {
        let (Some([width, height]), Some(pixels)) = (self.runs, self.pixels.first()) else { return false };
        let mut rest = bytes.get(pixels.start..).unwrap_or_default();
        let scanlines = (0..height).all(|_| scanline(&mut rest, width).is_some());
        scanlines && rest.is_empty()
    }

    /// Does a place lie among pixels?
    pub fn holds(&self, at: usize) -> bool {
        self.pixels.iter().any(|r| r.contains(&at))
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
}

fn short(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at + 2).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))
}

fn one(range: Range<usize>) -> Option<Guard> {
    Some(Guard { pixels: vec![range], ..Guard::default() })
}

/// Takes a row of run lengths, one component after the other, as Radiance writes it since 1991.
fn scanline(rest: &mut &[u8], width: usize) -> Option<()> {
    let (begin, after) = rest.split_first_chunk::<4>()?;
    if begin[..2] != [2, 2] || usize::from(u16::from_be_bytes([begin[2], begin[3]])) != width {
        return None;
    }
    *rest = after;
    for _ in 0..4 {
        let mut done = 0;
        while done < width {
            let (code, after) = rest.split_first()?;
            let (count, bytes) =
                if *code > 128 { (usize::from(code & 127), 1) } else { (usize::from(*code), usize::from(*code)) };
            *rest = after.get(bytes..)?;
            done += if count > 0 { count } else { return None };
        }
        if done > width {
            return None;
        }
    }
    Some(())
}

fn stream(bytes: &[u8]) -> Option<Guard> {
    let end = bytes.windows(2).position(|w| w == b"\n\n")? + 2;
    let line = bytes[end..].iter().position(|b| *b == b'\n')? + 1;
    // Where sizes stand among the variables there is no line, and pixels begin at once.
    let sized = matches!(bytes.get(end), Some(b'-' | b'+'));
    let pixels = end + if sized { line } else { 0 }..bytes.len();
    let words: Vec<&str> = std::str::from_utf8(bytes.get(end..pixels.start)?).ok()?.split_whitespace().collect();
    let runs = match words[..] {
        [_, height, _, width] if bytes.get(pixels.start..pixels.start + 2) == Some(&[2, 2]) => {
            width.parse().ok().zip(height.parse().ok()).map(|(w, h)| [w, h])
        }
        _ => None,
    };
    Some(Guard { pixels: vec![pixels], runs, ..Guard::default() })
}

fn pfm(bytes: &[u8]) -> Option<Guard> {
    let lines = bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i);
    one(lines.take(3).last()? + 1..bytes.len())
}

fn png(bytes: &[u8]) -> Option<Guard> {
    let (mut at, mut pixels) = (8, Vec::new());
    while at + 12 <= bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().ok()?) as usize;
        if bytes.get(at + 4..at + 8)? == b"IDAT" {
            pixels.push(at + 8..at + 12 + length);
        }
        at += 12 + length;
    }
    Some(Guard { pixels, summed: true, ..Guard::default() })
}

/// One part of scan lines; others are not guarded.
fn exr(bytes: &[u8]) -> Option<Guard> {
    let text = |at: usize| bytes[at..].iter().position(|b| *b == 0).map(|n| (at..at + n, at + n + 1));
    if word(bytes, 4)? & 0x1a00 != 0 {
        return None;
    }
    let (mut at, mut compression) = (8, 0);
    while *bytes.get(at)? != 0 {
        let (name, next) = text(at)?;
        let (_, next) = text(next)?;
        if &bytes[name] == b"compression" {
            compression = *bytes.get(next + 4)?;
        }
        at = next + 4 + word(bytes, next)?;
    }
    let (mut chunk, mut pixels) = (word(bytes, at + 1)?, Vec::new());
    while chunk + 8 < bytes.len() {
        let size = word(bytes, chunk + 4)?;
        pixels.push(chunk + 8..chunk + 8 + size);
        chunk += 8 + size;
    }
    // Only ZIPS and ZIP carry a sum, PXR24 too; a chunk that did not become smaller is kept as it is.
    let deflated = |r: &Range<usize>| bytes.get(r.start) == Some(&0x78) || bytes.get(r.start) == Some(&0x08);
    let summed = [2, 3].contains(&compression) && pixels.iter().all(deflated);
    Some(Guard { pixels, summed, ..Guard::default() })
}

fn tiff(bytes: &[u8]) -> Option<Guard> {
    let directory = word(bytes, 4)?;
    let entries = short(bytes, directory)?;
    let find = |tag: usize| (0..entries).map(|i| directory + 2 + 12 * i).find(|at| short(bytes, *at) == Some(tag));
    let list = |tag: usize| -> Option<Vec<usize>> {
        let entry = find(tag)?;
        let (wide, count) = (short(bytes, entry + 2)? == 4, word(bytes, entry + 4)?);
        let size = if wide { 4 } else { 2 };
        let first = if count * size <= 4 { entry + 8 } else { word(bytes, entry + 8)? };
        let value = |i: usize| if wide { word(bytes, first + 4 * i) } else { short(bytes, first + 2 * i) };
        (0..count).map(value).collect()
    };
    let pixels = list(273)?.into_iter().zip(list(279)?).map(|(at, n)| at..at + n).collect();
    let pixar = list(259)? == [32909];
    Some(Guard { pixels, summed: pixar, ..Guard::default() })
}
