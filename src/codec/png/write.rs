//! Writing: light to codes, rows to chunks.

use std::io::Write;

use crate::codec::png::pack::{self, Adler, Filters, chunk};
use crate::codec::png::{KEYWORD, cicp, icc};
use crate::color::Primaries;
use crate::display::transfer::{Coder8, Coder16, Transfer};
use crate::parallel;
use crate::simd::bound;
use crate::stream::output::Output;
use crate::stream::{Block, Header, Picture, Units, annotation};
use crate::{Error, Result, invalid};

/// Components this far outside 0..1 are rounding, not colour.
const ROUNDING: f32 = 1e-4;
/// Codes of a piece of rows that is deflated by itself: large enough to lose little, small enough to be many.
const PIECE: usize = 384 << 10;
/// A value this close to a code is that code, the rest being what floats lose.
const EXACT: f64 = 0.01;

/// What did not fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clipped {
    /// Pixels with a component under 0, over 1 or not a number.
    pub pixels: u64,
    /// The smallest and largest component.
    pub range: (f32, f32),
    /// Pixels of colours brighter than HLG has at this white.
    pub beyond_hlg: u64,
}

/// How the codes are made.
#[derive(Clone, Debug)]
pub struct Coding {
    /// The picture's values times this are 1 at white.
    pub factor: f32,
    /// 8 or 16.
    pub bits: u8,
    /// The curve.
    pub transfer: Transfer,
    /// Luminance of black and white, cd/m2, for curves that are absolute.
    pub range_cd_m2: [f64; 2],
    /// Round up or down by a pattern, so that areas keep their mean.
    pub dither: bool,
}

/// Writes an upright picture of linear RGB.
pub fn write(picture: Box<dyn Picture>, coding: &Coding, out: &mut Output) -> Result<Clipped> {
    let mut clipped = Clipped::default();
    out.attempt(|out| encode(picture, coding, out).map(|c| clipped = c))?;
    Ok(clipped)
}

/// Rows on their way to a chunk.
#[derive(Default)]
struct Piece {
    /// Row number of the first.
    first: usize,
    /// The row above the first, none for the picture's first, then the rows.
    light: Vec<f32>,
    last: bool,
    above: Vec<u8>,
    row: Vec<u8>,
    filters: Filters,
    filtered: Vec<u8>,
    packed: Vec<u8>,
    adler: Option<Adler>,
    clipped: Clipped,
}

fn encode(mut picture: Box<dyn Picture>, coding: &Coding, out: &mut Output) -> Result<Clipped> {
    let header = picture.header().clone();
    let (width, height) = (header.resolution.width, header.resolution.height);
    let primaries = header.primaries.unwrap_or(Primaries::BT709);
    let head = head(&header, &primaries, coding)?;
    let coder = Coder::new(coding, &primaries);
    let floats = 3 * width;
    let rows = (PIECE / floats).clamp(1, height);
    let (mut block, mut taken, mut next, mut above) = (Block::default(), 0, 0, Vec::new());
    let fill = |piece: &mut Piece| {
        if next == height {
            return Ok(false);
        }
        let end = (next + rows).min(height);
        piece.first = next;
        piece.light.clear();
        piece.light.extend_from_slice(&above);
        while next < end {
            if taken == block.rows {
                taken = 0;
                if !picture.next(&mut block)? {
                    return invalid!("picture ends at row {} of {height}", next + 1);
                }
            }
            let some = (block.rows - taken).min(end - next);
            piece.light.extend_from_slice(&block.data[taken * floats..(taken + some) * floats]);
            (taken, next) = (taken + some, next + some);
        }
        above.clear();
        above.extend_from_slice(&piece.light[piece.light.len() - floats..]);
        piece.last = next == height;
        Ok(true)
    };
    let work = |piece: &mut Piece| {
        piece.make(&coder, floats);
        Ok(())
    };
    let (mut adler, mut clipped, mut begun) = (Adler::NONE, Clipped::default(), false);
    let drain = |piece: &mut Piece| {
        let failed = |e| Error::io("", e);
        if !std::mem::replace(&mut begun, true) {
            out.write_all(&head).map_err(failed)?; // after the first rows: damage there leaves nothing behind
        }
        adler = piece.adler.map_or(adler, |a| adler.then(a));
        clipped.add(&piece.clipped);
        if piece.last {
            piece.packed.extend(adler.0.to_be_bytes());
        }
        out.write_all(&chunk(b"IDAT", &piece.packed)).map_err(failed)
    };
    parallel::in_order(fill, work, drain)?;
    out.write_all(&chunk(b"IEND", &[])).map_err(|e| Error::io("", e))?;
    Ok(clipped)
}

impl Piece {
    /// Codes, filters, deflates.
    fn make(&mut self, coder: &Coder, floats: usize) {
        let step = 3 * usize::from(coder.bits / 8);
        self.filtered.clear();
        self.packed.clear();
        self.clipped = Clipped::default();
        let mut lines = self.light.chunks_exact(floats);
        self.above.clear();
        match lines.next().filter(|_| self.first > 0) {
            Some(above) => coder.row(above, self.first - 1, &mut self.above, &mut Clipped::default()),
            None => {
                self.above.resize(floats * step / 3, 0);
                self.packed.extend(pack::ZLIB);
                lines = self.light.chunks_exact(floats);
            }
        }
        for (i, line) in lines.enumerate() {
            self.row.clear();
            coder.row(line, self.first + i, &mut self.row, &mut self.clipped);
            self.filters.row(&self.row, &self.above, step, &mut self.filtered);
            std::mem::swap(&mut self.row, &mut self.above);
        }
        self.adler = Some(Adler::of(&self.filtered));
        let effort = if coder.bits == 16 { pack::EFFORT_16 } else { pack::EFFORT_8 };
        pack::deflate(&self.filtered, effort, self.last, &mut self.packed);
    }
}

/// Everything before the rows: which size, which colours, what was done.
fn head(header: &Header, primaries: &Primaries, coding: &Coding) -> Result<Vec<u8>> {
    let r = header.resolution;
    let mut size = Vec::new();
    for n in [r.width, r.height] {
        let n = i32::try_from(n).map_err(|_| Error::Unsupported("too large for PNG".into()))?;
        size.extend(n.to_be_bytes());
    }
    size.extend([coding.bits, 2, 0, 0, 0]); // RGB
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    out.extend(chunk(b"IHDR", &size));
    for (name, data) in colours(primaries, coding) {
        out.extend(chunk(name, &data));
    }
    let mut described = header.clone();
    described.units = Units::Display;
    let text = annotation::text(&described);
    let text: Vec<u8> = text.iter().map(|b| if *b == 0 { b' ' } else { *b }).collect(); // a NUL would end it
    let mut data = KEYWORD.as_bytes().to_vec();
    let name = if std::str::from_utf8(&text).is_ok() {
        data.extend([0; 5]); // not compressed, no language, no other keyword
        b"iTXt"
    } else {
        data.push(0);
        b"tEXt"
    };
    data.extend(text);
    out.extend(chunk(name, &data));
    Ok(out)
}

/// The chunks that say which colours the numbers are.
fn colours(primaries: &Primaries, coding: &Coding) -> Vec<(&'static [u8; 4], Vec<u8>)> {
    let transfer = &coding.transfer;
    let mut chunks: Vec<(&'static [u8; 4], Vec<u8>)> = Vec::new();
    let code = cicp(primaries, transfer);
    let srgb = code == Some([1, 13, 0, 1]);
    if srgb {
        chunks.push((b"sRGB", vec![1])); // relative colorimetric
    } else {
        chunks.extend(code.map(|c| (b"cICP", c.to_vec())));
        chunks.extend(icc::profile(primaries, transfer).map(|p| {
            let mut data = format!("{KEYWORD}\0\0").into_bytes();
            data.extend(pack::zlib(&p));
            (b"iCCP", data)
        }));
    }
    let gamma = match transfer {
        Transfer::Srgb => Some(45455), // what the PNG specification wants for it
        Transfer::Gamma(g) => Some((1e5 / g).round() as u32),
        Transfer::Pq | Transfer::Hlg | Transfer::Table(_) => None,
    };
    chunks.extend(gamma.map(|g| (b"gAMA", g.to_be_bytes().to_vec())));
    let [xr, yr, xg, yg, xb, yb, xw, yw] = primaries.numbers();
    let (whole, from_white) = ([xr, yr, xg, yg, xb, yb, xw, yw], [xw, yw, xr, yr, xg, yg, xb, yb]);
    // Imaginary primaries can lie below 0, which these chunks cannot say.
    if whole.iter().all(|x| (0.0..1.3).contains(x)) {
        let scaled = |x: &f64| ((x * 1e5).round() as u32).to_be_bytes();
        chunks.push((b"cHRM", from_white.iter().flat_map(scaled).collect()));
        if matches!(transfer, Transfer::Pq | Transfer::Hlg) {
            let mut data: Vec<u8> = whole.iter().flat_map(|x| ((x * 5e4).round() as u16).to_be_bytes()).collect();
            let [black, white] = coding.range_cd_m2.map(|l| ((l * 1e4).round() as u32).to_be_bytes());
            data.extend([white, black].as_flattened());
            chunks.push((b"mDCV", data));
        }
    }
    chunks
}

/// Light to codes.
struct Coder<'a> {
    coding: &'a Coding,
    bits: u8,
    /// Luminance row of the primaries.
    y: [f64; 3],
    table: Table,
}

enum Table {
    Eight(Box<Coder8>),
    Sixteen(Coder16),
    /// Where channels depend on each other, or a code is not enough.
    None,
}

impl<'a> Coder<'a> {
    fn new(coding: &'a Coding, primaries: &Primaries) -> Coder<'a> {
        let [black, white] = coding.range_cd_m2;
        let table = match coding.bits {
            _ if coding.dither => None,
            16 => Coder16::new(&coding.transfer, (black, white)).map(Table::Sixteen),
            _ => Coder8::new(&coding.transfer).map(|t| Table::Eight(Box::new(t))),
        };
        let table = table.unwrap_or(Table::None);
        let y = primaries.to_xyz().map_or([0.0; 3], |m| m.0[1]);
        Coder { coding, bits: coding.bits, y, table }
    }

    /// Appends the codes of a row.
    fn row(&self, light: &[f32], row: usize, out: &mut Vec<u8>, clipped: &mut Clipped) {
        for (x, pixel) in light.as_chunks().0.iter().enumerate() {
            let p: [f32; 3] = pixel.map(|v| v * self.coding.factor);
            clipped.count(p);
            match &self.table {
                Table::Eight(t) => out.extend(p.map(|v| t.code(v))),
                Table::Sixteen(t) => out.extend(p.map(|v| t.code(v).to_be_bytes()).as_flattened()),
                Table::None => self.pixel(p, x, row, out, clipped),
            }
        }
    }

    fn pixel(&self, p: [f32; 3], x: usize, row: usize, out: &mut Vec<u8>, clipped: &mut Clipped) {
        let Coding { transfer, range_cd_m2: [black, white], dither, .. } = self.coding;
        let light = p.map(|v| f64::from(bound(v, 0.0, 1.0)));
        let codes = transfer.encode(light, (*black, *white), self.y);
        if *transfer == Transfer::Hlg && codes.iter().any(|c| *c > 1.0 - 1e-6) {
            let back = transfer.light(codes, (*black, *white), self.y);
            let lost = light.iter().zip(back).any(|(a, b)| (a - b).abs() > f64::from(ROUNDING));
            clipped.beyond_hlg += u64::from(lost);
        }
        let top = if self.bits == 16 { 65535.0 } else { 255.0 };
        for (channel, code) in codes.iter().enumerate() {
            let value = code * top;
            let nearest = value.round();
            let whole = if !dither || (value - nearest).abs() < EXACT {
                nearest
            } else {
                (value + threshold(x, row, channel)).floor()
            };
            if self.bits == 16 {
                out.extend((whole as u16).to_be_bytes());
            } else {
                out.push(whole as u8);
            }
        }
    }
}

/// A number from 0 to 1 for each place, spread evenly over every small area: the additive sequence of the plastic
/// number (Roberts 2018, R2) over columns and rows, shifted for each channel. Nothing but the place counts, so neither
/// threads nor blocks show.
fn threshold(x: usize, y: usize, channel: usize) -> f64 {
    const STEP: [u32; 2] = [0xc13f_a9a9, 0x91e1_0da5]; // 2^32 times 1/p and 1/p^2, p^3 = p + 1
    let place = (x as u32).wrapping_mul(STEP[0]).wrapping_add((y as u32).wrapping_mul(STEP[1]));
    let shifted = place.wrapping_add((channel as u32).wrapping_mul(0x5555_5555));
    f64::from(shifted) / 4_294_967_296.0
}

impl Clipped {
    fn count(&mut self, pixel: [f32; 3]) {
        let outside = pixel.iter().any(|x| !(-ROUNDING..=1.0 + ROUNDING).contains(x)); // NaN is in no range
        self.pixels += u64::from(outside);
        for x in pixel {
            self.range = (self.range.0.min(x), self.range.1.max(x));
        }
    }

    fn add(&mut self, other: &Clipped) {
        self.pixels += other.pixels;
        self.beyond_hlg += other.beyond_hlg;
        self.range = (self.range.0.min(other.range.0), self.range.1.max(other.range.1));
    }
}
