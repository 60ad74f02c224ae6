//! Exposures from JPEG, PNG and TIFF files, as the codes they hold: nothing is decoded to light here, no profile looked at.
//!
//! A file is read whole, its pixels in memory as 3 codes of 8 or 16 bits; grey becomes three alike, alpha is left out, orientations are
//! turned upright. JPEG is decoded strictly: a cut file is an error, not a grey field.

use std::io::Cursor;
use std::path::Path;

use png::{ColorType, Transformations};
use tiff::ColorType as TiffColor;
use tiff::decoder::DecodingResult;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::exposure::{Settings, exif};
use crate::{Error, Result, files, invalid};

/// No exposure has more pixels.
const MOST_PIXELS: usize = 1 << 28;

/// Codes, pixel-interleaved RGB.
#[derive(Clone, Debug, PartialEq)]
pub enum Codes {
    /// 0 to 255.
    Eight(Vec<u8>),
    /// 0 to 65535.
    Sixteen(Vec<u16>),
}

impl Codes {
    /// The largest there can be.
    pub fn largest(&self) -> usize {
        match self {
            Codes::Eight(_) => 255,
            Codes::Sixteen(_) => 65535,
        }
    }

    /// The codes of a pixel.
    #[inline(always)]
    pub fn pixel(&self, i: usize) -> [usize; 3] {
        match self {
            Codes::Eight(c) => [c[3 * i], c[3 * i + 1], c[3 * i + 2]].map(usize::from),
            Codes::Sixteen(c) => [c[3 * i], c[3 * i + 1], c[3 * i + 2]].map(usize::from),
        }
    }
}

/// One exposure.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The file's name, for messages.
    pub name: String,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Its pixels, rows from the top.
    pub codes: Codes,
    /// What its EXIF says.
    pub settings: Settings,
}

/// Reads an exposure. Errors name the file.
pub fn read(path: &Path) -> Result<Shot> {
    let name = crate::error::printable(path.as_os_str().as_encoded_bytes());
    if path.is_dir() {
        return invalid!("{name}: is a folder; expected a JPEG, PNG or TIFF picture");
    }
    let bytes = files::read(path).map_err(|e| Error::io(name.clone(), e))?;
    let shot = match bytes.get(..4) {
        Some(b"\x89PNG") => of_png(&bytes),
        Some([0xff, 0xd8, 0xff, _]) => of_jpeg(bytes),
        Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+") => of_tiff(&bytes),
        _ => invalid!("is no JPEG, PNG or TIFF file; expected one of these, 8 or 16 bits"),
    };
    let shot = shot.map_err(|e| e.within(&name))?;
    Ok(upright(Shot { name, ..shot }))
}

/// A size that can be.
fn checked(width: usize, height: usize) -> Result<(usize, usize)> {
    match width.checked_mul(height) {
        Some(n) if n > 0 && n <= MOST_PIXELS => Ok((width, height)),
        _ => invalid!("{width} x {height} pixels; expected 1 to {MOST_PIXELS} in all"),
    }
}

/// Three codes a pixel of `channels`: grey thrice, alpha left out.
fn three<T: Copy>(data: Vec<T>, channels: usize) -> Vec<T> {
    match channels {
        3 => data,
        1 | 2 => data.chunks_exact(channels).flat_map(|p| [p[0]; 3]).collect(),
        _ => data.chunks_exact(channels).flat_map(|p| [p[0], p[1], p[2]]).collect(),
    }
}

fn of_png(bytes: &[u8]) -> Result<Shot> {
    let wrong = |e: png::DecodingError| {
        Error::Invalid(format!("PNG: {}; the file is cut or damaged", one_line(&e.to_string())))
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: 1 << 30 });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = checked(reader.info().width as usize, reader.info().height as usize)?;
    let settings = reader.info().exif_metadata.as_ref().map_or_else(Settings::default, |e| exif(e));
    let size = reader.output_buffer_size().ok_or_else(|| Error::Invalid("PNG: too large".into()))?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(wrong)?;
    data.truncate(frame.buffer_size());
    let channels = match frame.color_type {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgba => 4,
        _ => 3,
    };
    let codes = if frame.bit_depth == png::BitDepth::Sixteen {
        let words = data.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b)).collect();
        Codes::Sixteen(three(words, channels))
    } else {
        Codes::Eight(three(data, channels))
    };
    complete(Shot { name: String::new(), width, height, codes, settings })
}

fn of_jpeg(bytes: Vec<u8>) -> Result<Shot> {
    let wrong = |e: zune_jpeg::errors::DecodeErrors| {
        Error::Invalid(format!("JPEG: {}; the file is cut or damaged", one_line(&format!("{e:?}"))))
    };
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(wrong)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    let (width, height) = checked(width, height)?;
    let settings = decoder.exif().map_or_else(Settings::default, |e| exif(e));
    let codes = Codes::Eight(decoder.decode().map_err(wrong)?);
    complete(Shot { name: String::new(), width, height, codes, settings })
}

fn of_tiff(bytes: &[u8]) -> Result<Shot> {
    let wrong = |e: tiff::TiffError| match e {
        tiff::TiffError::UnsupportedError(e) => {
            Error::Unsupported(format!("TIFF: {}; expected grey or RGB of 8 or 16 bits", one_line(&e.to_string())))
        }
        e => Error::Invalid(format!("TIFF: {}; the file is cut or damaged", one_line(&e.to_string()))),
    };
    let mut decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).map_err(wrong)?;
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = 8 * MOST_PIXELS;
    limits.intermediate_buffer_size = 1 << 30;
    decoder = decoder.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(wrong)?;
    let (width, height) = checked(width as usize, height as usize)?;
    let channels = match decoder.colortype().map_err(wrong)? {
        TiffColor::Gray(8 | 16) => 1,
        TiffColor::GrayA(8 | 16) => 2,
        TiffColor::RGB(8 | 16) => 3,
        TiffColor::RGBA(8 | 16) => 4,
        other => return invalid!("TIFF of {other:?}; expected grey or RGB of 8 or 16 bits"),
    };
    let codes = match decoder.read_image().map_err(wrong)? {
        DecodingResult::U8(data) => Codes::Eight(three(data, channels)),
        DecodingResult::U16(data) => Codes::Sixteen(three(data, channels)),
        _ => return invalid!("TIFF of floats or signed numbers; expected codes of 8 or 16 bits"),
    };
    complete(Shot { name: String::new(), width, height, codes, settings: exif(bytes) })
}

/// Refuses what has not all its pixels.
fn complete(shot: Shot) -> Result<Shot> {
    let has = match &shot.codes {
        Codes::Eight(c) => c.len(),
        Codes::Sixteen(c) => c.len(),
    };
    let wants = 3 * shot.width * shot.height;
    if has == wants { Ok(shot) } else { invalid!("holds {has} codes; expected {wants} for its size") }
}

fn one_line(text: &str) -> String {
    crate::error::printable(text.lines().map(str::trim).collect::<Vec<_>>().join(" ").as_bytes())
}

/// The shot as a viewer shows it.
fn upright(shot: Shot) -> Shot {
    let orientation = shot.settings.orientation;
    if orientation < 2 {
        return shot;
    }
    let (w, h) = (shot.width, shot.height);
    let (width, height) = if orientation < 5 { (w, h) } else { (h, w) };
    // The stored pixel that belongs at (x, y), by TIFF's table of rows and columns.
    let from = |x: usize, y: usize| match orientation {
        2 => (w - 1 - x, y),
        3 => (w - 1 - x, h - 1 - y),
        4 => (x, h - 1 - y),
        5 => (y, x),
        6 => (y, h - 1 - x),
        7 => (w - 1 - y, h - 1 - x),
        _ => (w - 1 - y, x),
    };
    let order = (0..width * height).map(|i| {
        let (x, y) = from(i % width, i / width);
        3 * (y * w + x)
    });
    let codes = match &shot.codes {
        Codes::Eight(c) => Codes::Eight(order.flat_map(|i| [c[i], c[i + 1], c[i + 2]]).collect()),
        Codes::Sixteen(c) => Codes::Sixteen(order.flat_map(|i| [c[i], c[i + 1], c[i + 2]]).collect()),
    };
    Shot { width, height, codes, ..shot }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row 0 and column 0 of what is stored are where TIFF 6.0 says: 6 is row 0 at the right, column 0 at the top.
    #[test]
    fn orientations() {
        let stored = Codes::Eight((0..6u8).flat_map(|i| [i; 3]).collect());
        let turned = |orientation| {
            let settings = Settings { orientation, ..Default::default() };
            let shot = Shot { name: String::new(), width: 3, height: 2, codes: stored.clone(), settings };
            let Shot { width, height, codes, .. } = upright(shot);
            let all: Vec<usize> = (0..6).map(|i| codes.pixel(i)[0]).collect();
            (width, height, all)
        };
        assert_eq!(turned(1), (3, 2, vec![0, 1, 2, 3, 4, 5]));
        assert_eq!(turned(2), (3, 2, vec![2, 1, 0, 5, 4, 3]));
        assert_eq!(turned(3), (3, 2, vec![5, 4, 3, 2, 1, 0]));
        assert_eq!(turned(4), (3, 2, vec![3, 4, 5, 0, 1, 2]));
        assert_eq!(turned(5), (2, 3, vec![0, 3, 1, 4, 2, 5]));
        assert_eq!(turned(6), (2, 3, vec![3, 0, 4, 1, 5, 2]));
        assert_eq!(turned(7), (2, 3, vec![5, 2, 4, 1, 3, 0]));
        assert_eq!(turned(8), (2, 3, vec![2, 5, 1, 4, 0, 3]));
    }
}
