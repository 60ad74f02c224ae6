//! PNG for displays: 8 or 16 bits a component, the sRGB curve, the colour space written in the file.
//!
//! BT.709 primaries get an `sRGB` chunk, Display P3 and BT.2020 a `cICP` chunk (ITU-T H.273), others `cHRM` and `gAMA`.

use std::io::Write;

use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::color::Primaries;
use crate::simd::bound;
use crate::stream::output::Output;
use crate::stream::{Block, Picture};
use crate::{Error, Result};

use super::srgb;

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

/// Writes an upright picture of linear RGB, 1 white after `factor`, with `bits` 8 or 16.
pub fn write(mut picture: Box<dyn Picture>, factor: f32, bits: u8, out: &mut Output) -> Result<Clipped> {
    let header = picture.header().clone();
    let mut block = Block::default();
    let mut more = picture.next(&mut block)?;
    let size = |n: usize| u32::try_from(n).map_err(|_| Error::Unsupported("too large for PNG".into()));
    let mut encoder = Encoder::new(&mut *out, size(header.resolution.width)?, size(header.resolution.height)?);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(if bits == 16 { BitDepth::Sixteen } else { BitDepth::Eight });
    let cicp = describe(&mut encoder, header.primaries.unwrap_or(Primaries::BT709));
    let failed = |e: png::EncodingError| match e {
        png::EncodingError::IoError(e) => Error::io("", e),
        other => Error::Unsupported(other.to_string()),
    };
    let mut writer = encoder.write_header().map_err(failed)?;
    if let Some(code) = cicp {
        writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &code).map_err(failed)?;
    }
    let mut rows = writer.stream_writer().map_err(failed)?;
    let coder = srgb::Coder8::default();
    let mut clipped = Clipped::default();
    let mut bytes = Vec::new();
    while more {
        bytes.clear();
        for pixel in block.data.chunks_exact(3) {
            let p = [pixel[0] * factor, pixel[1] * factor, pixel[2] * factor];
            clipped.count(p);
            for x in p {
                if bits == 16 {
                    let code = srgb::encode(f64::from(bound(x, 0.0, 1.0))) * 65535.0;
                    bytes.extend((code.round() as u16).to_be_bytes());
                } else {
                    bytes.push(coder.code(x));
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
fn describe(encoder: &mut Encoder<&mut Output>, primaries: Primaries) -> Option<[u8; 4]> {
    let is = |name: &str| name.parse().is_ok_and(|p: Primaries| p.distance(&primaries) < 1e-3);
    if is("BT.709") {
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        return None;
    }
    if is("P3") {
        return Some([12, 13, 0, 1]);
    }
    if is("BT.2020") {
        return Some([9, 13, 0, 1]);
    }
    let scaled = |x: f64| png::ScaledFloat::new(x as f32);
    let pair = |p: crate::color::Xy| (scaled(p.x), scaled(p.y));
    encoder.set_source_chromaticities(png::SourceChromaticities {
        white: pair(primaries.white),
        red: pair(primaries.rgb[0]),
        green: pair(primaries.rgb[1]),
        blue: pair(primaries.rgb[2]),
    });
    encoder.set_source_gamma(scaled(1.0 / 2.2));
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
