//! Pixar log: RGB in 11 bits a component, companded, differenced and deflated, in TIFF [libtiff `tif_pixarlog.c`].
//!
//! Codes 0 to 249 are linear in steps of 7.3263e-5, from 250 (0.0183) on each is 0.4 % over the one before; 1250 is 1.0 and
//! 2047, the ceiling, 24.24. Only positive RGB: what is negative becomes 0, what is above the ceiling the ceiling; both are
//! counted. A component gets the code whose value is nearest. StoNits (37439) is cd/m2 of the value 1, as LogLuv has it; the
//! primaries are in tags 319 and 270. Differences run along each row, channel by channel, modulo 2048; words have the file's
//! byte order; each strip is one zlib stream.

use std::io::{Cursor, Read, Write};
use std::sync::OnceLock;

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use crate::codec::Reading;
use crate::codec::tiff::directory::{Directory, tag};
use crate::codec::tiff::read::{self, Coder, Rows};
use crate::codec::tiff::remarks::Remarks;
use crate::codec::tiff::write::{self, Layout, Strip};
use crate::color::Primaries;
use crate::notes::Notes;
use crate::stream::output::Output;
use crate::stream::source::Source;
use crate::stream::spool::Limits;
use crate::stream::{Components, Header, Picture, Units};
use crate::{Error, Result, invalid};

/// The number of this compression.
pub const COMPRESSION: u64 = 32909;
/// Codes.
const CODES: usize = 2048;
/// Codes that are linear.
const LINEAR: usize = 250;
/// The code of 1.0.
const ONE: f64 = 1250.0;
/// Where the linear codes end.
pub const BOTTOM: f64 = 0.018_315_639;
/// The largest value.
pub const CEILING: f64 = 24.236_48;
/// Deflate makes no less of a byte than this share.
const DEFLATE_MOST: u64 = 1032;
/// A zlib stream's head and check; less than this holds nothing.
const LEAST: u64 = 6;

/// Values of the codes: step k up to 250, then e^(k/250 - 5), which the linear part meets with the same slope.
///
/// ```
/// let values = luxpipe::codec::pixarlog::values();
/// assert_eq!((values[0], values[1], values[1250]), (0.0, 7.326_255_6e-5, 1.0));
/// ```
pub fn values() -> &'static [f32; CODES] {
    static VALUES: OnceLock<[f32; CODES]> = OnceLock::new();
    VALUES.get_or_init(|| {
        let c = 1.0 / LINEAR as f64;
        let b = (-c * ONE).exp();
        let step = b * c * 1f64.exp();
        std::array::from_fn(|k| if k < LINEAR { (k as f64 * step) as f32 } else { (b * (c * k as f64).exp()) as f32 })
    })
}

/// What the encoding could not hold, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// A component was negative.
    pub negative: u64,
    /// A component was above the ceiling.
    pub over: u64,
    /// No component came up to the first code, and one was above 0.
    pub under: u64,
}

/// Values to the nearest code: the leading bits of the float give a first guess, thresholds the answer.
struct Companding {
    /// From this value on code k holds.
    thresholds: [f32; CODES + 1],
    guesses: Vec<u16>,
}

/// Bits of the float that index the guess: exponent and six of mantissa.
const SHIFT: u32 = 23 - 6;

impl Companding {
    fn get() -> &'static Companding {
        static COMPANDING: OnceLock<Companding> = OnceLock::new();
        COMPANDING.get_or_init(|| {
            let v = values();
            let middle = |k: usize| (0.5 * (f64::from(v[k - 1]) + f64::from(v[k]))) as f32;
            let thresholds = std::array::from_fn(|k| match k {
                0 => f32::NEG_INFINITY,
                CODES => f32::INFINITY,
                k => middle(k),
            });
            let last = v[CODES - 1].to_bits() >> SHIFT;
            let guess = |i: u32| {
                let low = f32::from_bits(i << SHIFT);
                (thresholds[1..CODES].partition_point(|t| *t <= low)) as u16
            };
            Companding { thresholds, guesses: (0..=last).map(guess).collect() }
        })
    }

    #[inline]
    fn code(&self, value: f32) -> u16 {
        let value = crate::simd::bound(value, 0.0, values()[CODES - 1]);
        let mut code = self.guesses[(value.to_bits() >> SHIFT) as usize];
        while value >= self.thresholds[usize::from(code) + 1] {
            code += 1;
        }
        code
    }
}

/// The code of a value: the nearest, 0 for negatives and NaN, 2047 above the ceiling.
///
/// ```
/// assert_eq!([-1.0, 0.0, 1.0, 100.0].map(luxpipe::codec::pixarlog::code), [0, 0, 1250, 2047]);
/// ```
pub fn code(value: f32) -> u16 {
    Companding::get().code(value)
}

/// Writes an upright picture of RGB, stored values being those over `stonits`.
pub fn write(
    picture: Box<dyn Picture>,
    stonits: Option<f64>,
    out: &mut Output,
    limits: &Limits,
    notes: &Notes,
) -> Result<Losses> {
    let layout = Layout {
        bits: vec![8; 3],
        sample_format: 1,
        compression: COMPRESSION as u16,
        photometric: 2,
        stonits,
        remarks: Vec::new(),
    };
    let factor = (1.0 / stonits.unwrap_or(1.0)) as f32;
    let row_floats = picture.header().scanline_floats();
    let encode = |strip: &mut Strip<Losses>| -> Result<()> {
        let companding = Companding::get();
        let top = companding.thresholds[CODES - 1] * 1.002;
        let mut packer = ZlibEncoder::new(std::mem::take(&mut strip.bytes), Compression::default());
        let mut words = Vec::with_capacity(2 * row_floats);
        for row in strip.block.data.chunks_exact(row_floats) {
            words.clear();
            let mut last = [0u16; 3];
            for pixel in row.chunks_exact(3) {
                let p = [pixel[0] * factor, pixel[1] * factor, pixel[2] * factor];
                let codes = p.map(|x| companding.code(x));
                strip.losses.negative += u64::from(p.iter().any(|x| *x < 0.0));
                strip.losses.over += u64::from(p.iter().any(|x| *x > top));
                strip.losses.under += u64::from(codes == [0; 3] && p.iter().any(|x| *x > 0.0));
                for (code, last) in codes.iter().zip(&mut last) {
                    words.extend((code.wrapping_sub(*last) & (CODES as u16 - 1)).to_ne_bytes());
                    *last = *code;
                }
            }
            packer.write_all(&words).map_err(|e| Error::io("", e))?;
        }
        strip.bytes = packer.finish().map_err(|e| Error::io("", e))?;
        Ok(())
    };
    let mut losses = Losses::default();
    write::write(picture, &layout, out, limits, notes, encode, |l: Losses| {
        losses.negative += l.negative;
        losses.over += l.over;
        losses.under += l.under;
    })?;
    Ok(losses)
}

/// Opens a file whose compression is Pixar's.
pub fn open(mut source: Source, directory: Directory, reading: &Reading) -> Result<Box<dyn Picture>> {
    directory.expect(tag::PHOTOMETRIC, "photometric", &[2], 2)?;
    directory.expect(tag::SAMPLES_PER_PIXEL, "samples per pixel", &[3], 1)?;
    directory.expect(tag::PLANAR, "planar configuration", &[1], 1)?;
    let Remarks { annotation, white, primaries, stonits } = Remarks::read(&directory, &mut source, reading)?;
    let stated = annotation.units().filter(|u| matches!(u, Units::Display | Units::Relative) && stonits.is_none());
    let mut own = Header::new(directory.resolution()?, Components::Rgb, 3, stated.unwrap_or(Units::CdM2));
    own.white = white;
    own.primaries = annotation.primaries().or(primaries);
    let mut assumed = Vec::new();
    if stonits.is_none() && stated.is_none() && reading.overrides.units.is_none() {
        assumed.push("no StoNits: taking a stored 1 as 1 cd/m2");
    }
    if own.primaries.is_none() {
        own.primaries = Some(Primaries::BT709);
        if reading.overrides.primaries.is_none() {
            assumed.push("no primaries: taking those of BT.709");
        }
    }
    if !assumed.is_empty() {
        reading.notes.add(format!("{}: {}", source.name, assumed.join("; ")));
    }
    let factor = stonits.unwrap_or(1.0) as f32;
    let header = annotation.settle(own, reading.overrides)?;
    let big_endian = directory.big_endian;
    read::open(source, &directory, header, PixarLog { big_endian, factor }, reading.notes)
}

struct PixarLog {
    big_endian: bool,
    factor: f32,
}

impl Coder for PixarLog {
    fn begin(&self, bytes: Vec<u8>, _width: usize) -> Box<dyn Rows> {
        let PixarLog { big_endian, factor } = *self;
        Box::new(Words { unpacker: ZlibDecoder::new(Cursor::new(bytes)), big_endian, factor, bytes: Vec::new() })
    }

    fn fewest_bytes(&self, width: usize, rows: usize) -> u64 {
        LEAST + (6 * width as u64).saturating_mul(rows as u64) / DEFLATE_MOST
    }
}

/// A strip being decoded.
struct Words {
    unpacker: ZlibDecoder<Cursor<Vec<u8>>>,
    big_endian: bool,
    factor: f32,
    bytes: Vec<u8>,
}

impl Rows for Words {
    fn row(&mut self, out: &mut [f32]) -> Result<()> {
        self.bytes.resize(2 * out.len(), 0);
        match self.unpacker.read_exact(&mut self.bytes) {
            Ok(()) => {}
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => return invalid!("its bytes end early"),
            Err(e) => return invalid!("its deflated bytes are damaged ({e})"),
        }
        let values = values();
        let mut codes = [0u16; 3];
        for (pixel, words) in out.chunks_exact_mut(3).zip(self.bytes.chunks_exact(6)) {
            for c in 0..3 {
                let word = [words[2 * c], words[2 * c + 1]];
                let word = if self.big_endian { u16::from_be_bytes(word) } else { u16::from_le_bytes(word) };
                codes[c] = codes[c].wrapping_add(word) & (CODES as u16 - 1);
                pixel[c] = values[usize::from(codes[c])] * self.factor;
            }
        }
        Ok(())
    }

    /// Reading to the end compares the sum that stands there.
    fn end(&mut self, values: usize) -> Result<()> {
        let most = 2 * values as u64;
        match std::io::copy(&mut (&mut self.unpacker).take(most + 1), &mut std::io::sink()) {
            Ok(n) if n <= most => Ok(()),
            Ok(_) => invalid!("its deflated bytes go on"),
            Err(e) => invalid!("its deflated bytes are damaged ({e})"),
        }
    }
}
