//! PNG for displays: 8 or 16 bits a component, the display's curve, the colour space written in the file.
//!
//! sRGB gets an `sRGB` chunk; BT.709, Display P3 and BT.2020 with the sRGB, PQ or HLG curve a `cICP` chunk (ITU-T H.273);
//! others `cHRM`, and `gAMA` where the curve is a power.

use std::io::Write;

use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::color::Primaries;
use crate::display::transfer::{Coder8, Transfer};
use crate::simd::bound;
use crate::stream::output::Output;
use crate::stream::{Block, Picture};
use crate::{Error, Result};

/// Components this far outside 0..1 are rounding, not colour.
const ROUNDING: f32 = 1e-4;

/// What did not fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clipped {
    /// Pixels with a component under 0, over 1 or not a number.
    pub pixels: u64,
    /// The smallest and largest component.
    pub range: (f32, f32),
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
}

/// Writes an upright picture of linear RGB.
pub fn write(picture: Box<dyn Picture>, coding: &Coding, out: &mut Output) -> Result<Clipped> {
    encode(picture, coding, out).map_err(|e| out.failure().unwrap_or(e))
}

fn encode(mut picture: Box<dyn Picture>, coding: &Coding, out: &mut Output) -> Result<Clipped> {
    let header = picture.header().clone();
    let mut block = Block::default();
    let mut more = picture.next(&mut block)?;
    let size = |n: usize| u32::try_from(n).map_err(|_| Error::Unsupported("too large for PNG".into()));
    let mut encoder = Encoder::new(&mut *out, size(header.resolution.width)?, size(header.resolution.height)?);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(if coding.bits == 16 { BitDepth::Sixteen } else { BitDepth::Eight });
    let primaries = header.primaries.unwrap_or(Primaries::BT709);
    let cicp = describe(&mut encoder, primaries, &coding.transfer);
    let failed = |e: png::EncodingError| match e {
        png::EncodingError::IoError(e) => Error::io("", e),
        other => Error::Unsupported(other.to_string()),
    };
    let mut writer = encoder.write_header().map_err(failed)?;
    if let Some(code) = cicp {
        writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &code).map_err(failed)?;
    }
    let mut rows = writer.stream_writer().map_err(failed)?;
    let y = primaries.to_xyz().map_or([0.0; 3], |m| m.0[1]);
    let coder = Coder8::new(&coding.transfer).filter(|_| coding.bits == 8);
    let mut clipped = Clipped::default();
    let mut bytes = Vec::new();
    while more {
        bytes.clear();
        for pixel in block.data.chunks_exact(3) {
            let p = [pixel[0] * coding.factor, pixel[1] * coding.factor, pixel[2] * coding.factor];
            clipped.count(p);
            if let Some(coder) = &coder {
                bytes.extend(p.map(|x| coder.code(x)));
                continue;
            }
            let light = p.map(|x| f64::from(bound(x, 0.0, 1.0)));
            let [black, white] = coding.range_cd_m2;
            for code in coding.transfer.encode(light, (black, white), y) {
                if coding.bits == 16 {
                    bytes.extend(((code * 65535.0).round() as u16).to_be_bytes());
                } else {
                    bytes.push((code * 255.0).round() as u8);
                }
            }
        }
        rows.write_all(&bytes).map_err(|e| Error::io("", e))?;
        more = picture.next(&mut block)?;
    }
    rows.finish().map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(clipped)
}

/// Says which colours the numbers are; what `png` cannot write itself is returned as a cICP code.
fn describe(encoder: &mut Encoder<&mut Output>, primaries: Primaries, transfer: &Transfer) -> Option<[u8; 4]> {
    let is = |name: &str| name.parse().is_ok_and(|p: Primaries| p.distance(&primaries) < 1e-3);
    if is("BT.709") && *transfer == Transfer::Srgb {
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        return None;
    }
    let code = [("BT.709", 1), ("P3", 12), ("BT.2020", 9)].iter().find(|(name, _)| is(name)).map(|c| c.1);
    if let (Some(primaries), Some(transfer)) = (code, transfer.cicp()) {
        return Some([primaries, transfer, 0, 1]);
    }
    let scaled = |x: f64| png::ScaledFloat::new(x as f32);
    let pair = |p: crate::color::Xy| (scaled(p.x), scaled(p.y));
    encoder.set_source_chromaticities(png::SourceChromaticities {
        white: pair(primaries.white),
        red: pair(primaries.rgb[0]),
        green: pair(primaries.rgb[1]),
        blue: pair(primaries.rgb[2]),
    });
    if let Transfer::Gamma(g) = transfer {
        encoder.set_source_gamma(scaled(1.0 / g));
    }
    None
}

impl Clipped {
    fn count(&mut self, pixel: [f32; 3]) {
        let outside = pixel.iter().any(|x| !(-ROUNDING..=1.0 + ROUNDING).contains(x)); // NaN is in no range
        self.pixels += u64::from(outside);
        for x in pixel {
            self.range = (self.range.0.min(x), self.range.1.max(x));
        }
    }
}
