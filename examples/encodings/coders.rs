//! The encodings, each by the library's own coder: components in, stored, and out again.

use half::f16;
use luxpipe::codec::logluv::cells::Cells;
use luxpipe::codec::logluv::rows::{encode_24, encode_32};
use luxpipe::codec::logluv::{self, Coding, word_24};
use luxpipe::codec::noise::offset;
use luxpipe::codec::pixarlog;
use luxpipe::color::{Mat3, Primaries};
use luxpipe::stream::rgbe;
use luxpipe::stream::rle::{self, Planes};

/// Pixels coded as one scanline.
const WIDTH: usize = 1024;

/// How components become bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coder {
    /// Three mantissas and an exponent.
    SharedExponent,
    /// 24-bit LogLuv.
    LogLuv24 {
        /// With noise of a step's width.
        dithered: bool,
    },
    /// 32-bit LogLuv.
    LogLuv32,
    /// Companded components.
    PixarLog,
    /// The same, with the codes that libtiff's encoder chooses.
    PixarLogOfLibtiff,
    /// Halves.
    Half,
    /// Floats.
    Float,
}

/// A row of the tables.
#[derive(Clone, Copy, Debug)]
pub struct Encoding {
    /// What it is called here.
    pub name: &'static str,
    /// The command that writes it.
    pub command: &'static str,
    /// Bits a pixel before any compression.
    pub bits: u32,
    /// How components are stored.
    pub coder: Coder,
    /// Whose components: XYZ's where there are no primaries.
    pub primaries: Option<Primaries>,
}

const fn encoding(name: &'static str, command: &'static str, bits: u32, coder: Coder) -> Encoding {
    Encoding { name, command, bits, coder, primaries: None }
}

const fn of(primaries: Primaries, encoding: Encoding) -> Encoding {
    Encoding { primaries: Some(primaries), ..encoding }
}

/// All rows.
pub const ENCODINGS: [Encoding; 11] = [
    of(Primaries::RADIANCE, encoding("RGBE", "ra_rgbe", 32, Coder::SharedExponent)),
    of(Primaries::BT709, encoding("RGBE BT.709", "ra_rgbe --to BT.709", 32, Coder::SharedExponent)),
    of(Primaries::BT2020, encoding("RGBE BT.2020", "ra_rgbe --to BT.2020", 32, Coder::SharedExponent)),
    encoding("XYZE", "ra_rgbe --xyze", 32, Coder::SharedExponent),
    encoding("LogLuv24", "ra_loglv --bits24", 24, Coder::LogLuv24 { dithered: false }),
    encoding("LogLuv24 dithered", "ra_loglv --bits24 --dither", 24, Coder::LogLuv24 { dithered: true }),
    encoding("LogLuv32", "ra_loglv", 32, Coder::LogLuv32),
    of(Primaries::BT709, encoding("Pixar log BT.709", "ra_pixlog", 33, Coder::PixarLog)),
    of(Primaries::BT709, encoding("EXR half BT.709", "ra_exr", 48, Coder::Half)),
    encoding("EXR half XYZ", "ra_exr --to XYZ", 48, Coder::Half),
    encoding("EXR float XYZ", "ra_exr --float --to XYZ", 96, Coder::Float),
];

/// Pixar log as libtiff writes it, to compare with.
pub const LIBTIFF_PIXAR: Encoding =
    of(Primaries::BT709, encoding("Pixar log of libtiff", "tiffcp", 33, Coder::PixarLogOfLibtiff));

/// One of [`ENCODINGS`].
pub fn named(name: &str) -> Encoding {
    *ENCODINGS.iter().find(|e| e.name == name).expect("an encoding of the list")
}

/// What came back, and of how many pixels the coder said that it had no place for their chromaticity.
pub struct Trip {
    /// Three components a pixel.
    pub components: Vec<f32>,
    /// Pixels outside the encoding's gamut.
    pub outside: u64,
}

impl Encoding {
    /// XYZ as the components that are stored.
    pub fn components(&self, xyz: &[[f64; 3]]) -> Vec<f32> {
        let m = self.primaries.map_or(Mat3::IDENTITY, |p| p.from_xyz().expect("a gamut"));
        xyz.iter().flat_map(|c| m.apply(*c)).map(|x| x as f32).collect()
    }

    /// Components as XYZ.
    pub fn xyz(&self, components: &[f32]) -> Vec<[f64; 3]> {
        let m = self.primaries.map_or(Mat3::IDENTITY, |p| p.to_xyz().expect("a gamut"));
        components.chunks_exact(3).map(|c| m.apply([0, 1, 2].map(|i| f64::from(c[i])))).collect()
    }

    /// Once into the encoding and back.
    pub fn trip(&self, components: &[f32]) -> Trip {
        let (components, outside) = match self.coder {
            Coder::SharedExponent => shared_exponent(components),
            Coder::LogLuv24 { dithered } => logluv_24(components, dithered),
            Coder::LogLuv32 => logluv_32(components),
            Coder::PixarLog => companded(components, pixarlog::code),
            Coder::PixarLogOfLibtiff => companded(components, libtiff_codes()),
            Coder::Half => (components.iter().map(|x| f16::from_f32(*x).to_f32()).collect(), 0),
            Coder::Float => (components.to_vec(), 0),
        };
        Trip { components, outside }
    }

    /// XYZ that come back for XYZ.
    pub fn seen(&self, xyz: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.xyz(&self.trip(&self.components(xyz)).components)
    }
}

fn companded(components: &[f32], code: impl Fn(f32) -> u16) -> (Vec<f32>, u64) {
    let outside = components.chunks_exact(3).filter(|c| c.iter().any(|x| *x < 0.0)).count();
    (components.iter().map(|x| pixarlog::values()[usize::from(code(*x))]).collect(), outside as u64)
}

/// The codes of libtiff's `tif_pixarlog.c`: a value under 2 is cut to a step of the linear part, and that step has the code from
/// whose lower neighbour it is farther, by ratio.
fn libtiff_codes() -> impl Fn(f32) -> u16 {
    let values = pixarlog::values();
    let step = f64::from(values[1]);
    let count = (2.0 / step) as usize + 1;
    let mut last = 0usize;
    let codes: Vec<u16> = (0..count)
        .map(|i| {
            let value = i as f64 * step;
            last += usize::from(value * value > f64::from(values[last]) * f64::from(values[last + 1]));
            last as u16
        })
        .collect();
    move |x| match x {
        _ if x < 2.0 => codes.get((x.max(0.0) * (count / 2) as f32) as usize).map_or(0, |c| *c),
        _ if x > 24.2 => 2047,
        _ => (250.0 * (f64::from(x).ln() + 5.0) + 0.5) as u16,
    }
}

/// RGBE or XYZE, run lengths included.
fn shared_exponent(components: &[f32]) -> (Vec<f32>, u64) {
    let (mut planes, mut losses, mut bytes) = (Planes::default(), rgbe::Losses::default(), Vec::new());
    let (mut decoder, mut out) = (rle::Decoder::default(), vec![0.0; components.len()]);
    for (row, out) in components.chunks(3 * WIDTH).zip(out.chunks_mut(3 * WIDTH)) {
        bytes.clear();
        rgbe::encode_pixels(row, 1.0, &mut planes, &mut losses);
        rle::encode(&planes, &mut bytes);
        planes.iter_mut().for_each(Vec::clear);
        decoder.scanline(&mut &bytes[..], row.len() / 3, &mut planes, 0).expect("its own bytes");
        rgbe::decode_pixels(&planes, [1.0; 3], out);
    }
    (out, losses.negative)
}

fn logluv_24(components: &[f32], dithered: bool) -> (Vec<f32>, u64) {
    let (cells, decoder) = (Cells::get(), logluv::Decoder::new(Coding::Log24));
    let (mut losses, mut words) = (logluv::Losses::default(), Vec::with_capacity(components.len()));
    if dithered {
        for (i, c) in components.chunks_exact(3).enumerate() {
            let noise = [0, 1, 2].map(|channel| offset(i % WIDTH, i / WIDTH, channel));
            let word = word_24([c[0], c[1], c[2]], noise, cells, &mut losses);
            words.extend_from_slice(&word.to_be_bytes()[1..]);
        }
    } else {
        encode_24(components, 1.0, cells, &mut words, &mut losses);
    }
    let colour = |w: &[u8]| decoder.colour_24(u32::from_be_bytes([0, w[0], w[1], w[2]]));
    (words.chunks_exact(3).flat_map(colour).collect(), losses.chroma)
}

fn logluv_32(components: &[f32]) -> (Vec<f32>, u64) {
    let (mut planes, mut losses) = (Planes::default(), logluv::Losses::default());
    encode_32(components, 1.0, &mut planes, &mut losses);
    let mut out = vec![0.0; components.len()];
    logluv::Decoder::new(Coding::Log32).decode_32(&planes, 1.0, &mut out);
    (out, losses.chroma)
}
