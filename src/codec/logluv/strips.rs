//! LogLuv in TIFF's strips: as planes of bytes in runs (32 bit and LogL), or words one after the other (24 bit).

use std::sync::Arc;

use super::{Coding, Decoder, Losses, rows};
use crate::codec::Reading;
use crate::codec::logluv::cells::Cells;
use crate::codec::noise::offset;
use crate::codec::tiff::directory::{Directory, tag};
use crate::codec::tiff::read::{self, Coder, Rows};
use crate::codec::tiff::remarks::Remarks;
use crate::codec::tiff::write::{Layout, Strip};
use crate::stream::output::Output;
use crate::stream::rle::{Planes, Runs};
use crate::stream::source::Source;
use crate::stream::spool::Limits;
use crate::stream::{Components, Header, Picture, Units};
use crate::{Result, invalid};

/// SGILOG: 32-bit colour, or 16-bit luminance.
pub const COMPRESSION_32: u64 = 34676;
/// SGILOG24.
pub const COMPRESSION_24: u64 = 34677;
/// Photometric interpretation of luminance alone.
const LOG_L: u64 = 32844;
/// Photometric interpretation of colour.
const LOG_LUV: u64 = 32845;

/// Opens a file whose compression is one of LogLuv's.
pub fn open(mut source: Source, directory: Directory, reading: &Reading) -> Result<Box<dyn Picture>> {
    let small = directory.number(tag::COMPRESSION) == Some(COMPRESSION_24);
    let coding = match directory.number(tag::PHOTOMETRIC) {
        Some(LOG_LUV) => {
            if small {
                Coding::Log24
            } else {
                Coding::Log32
            }
        }
        Some(LOG_L) if !small => Coding::LogL16,
        Some(other) => return invalid!("photometric {other} does not go with LogLuv: expected {LOG_L} or {LOG_LUV}"),
        None => return invalid!("the TIFF states no photometric interpretation"),
    };
    let ncomp = if coding == Coding::LogL16 { 1 } else { 3 };
    directory.expect(tag::SAMPLES_PER_PIXEL, "samples per pixel", &[ncomp as u64], 1)?;
    directory.expect(tag::PLANAR, "planar configuration", &[1], 1)?;
    let Remarks { annotation, white, stonits, .. } = Remarks::read(&directory, &mut source, reading)?;
    let components = if ncomp == 1 { Components::Y } else { Components::Xyz };
    let stated = annotation.units().filter(|u| matches!(u, Units::Display | Units::Relative) && stonits.is_none());
    let mut own = Header::new(directory.resolution()?, components, ncomp, stated.unwrap_or(Units::CdM2));
    own.white = white;
    if stonits.is_none() && stated.is_none() && reading.overrides.units.is_none() {
        reading.notes.add(format!("{}: no StoNits: taking a stored luminance of 1 as 1 cd/m2", source.name));
    }
    let header = annotation.settle(own, reading.overrides)?;
    let coder = LogLuv { coding, tables: Arc::new(Decoder::new(coding)), factor: stonits.unwrap_or(1.0) as f32 };
    read::open(source, &directory, header, coder, reading.notes)
}

struct LogLuv {
    coding: Coding,
    tables: Arc<Decoder>,
    factor: f32,
}

impl Coder for LogLuv {
    fn begin(&self, bytes: Vec<u8>, width: usize) -> Box<dyn Rows> {
        let (coding, tables, factor) = (self.coding, self.tables.clone(), self.factor);
        Box::new(Words { coding, tables, factor, bytes, at: 0, width, planes: Planes::default() })
    }

    fn fewest_bytes(&self, width: usize, rows: usize) -> u64 {
        let row = match self.coding {
            Coding::Log32 => 4 * Runs::LOGLUV.fewest_bytes(width),
            Coding::LogL16 => 2 * Runs::LOGLUV.fewest_bytes(width),
            Coding::Log24 => 3 * width,
        };
        (row as u64).saturating_mul(rows as u64)
    }
}

/// A strip being decoded.
struct Words {
    coding: Coding,
    tables: Arc<Decoder>,
    factor: f32,
    bytes: Vec<u8>,
    at: usize,
    width: usize,
    planes: Planes,
}

impl Words {
    /// Reads the row's first `count` planes.
    fn read_planes(&mut self, count: usize) -> Result<()> {
        for plane in &mut self.planes[..count] {
            plane.resize(self.width, 0);
            match Runs::LOGLUV.decode(&self.bytes[self.at..], plane)? {
                Ok(taken) => self.at += taken,
                Err(_) => return invalid!("its bytes end early"),
            }
        }
        Ok(())
    }
}

impl Rows for Words {
    fn row(&mut self, out: &mut [f32]) -> Result<()> {
        match self.coding {
            Coding::Log32 => {
                self.read_planes(4)?;
                self.tables.decode_32(&self.planes, self.factor, out);
            }
            Coding::LogL16 => {
                self.read_planes(2)?;
                for ((y, high), low) in out.iter_mut().zip(&self.planes[0]).zip(&self.planes[1]) {
                    *y = super::luminance_of(u16::from_be_bytes([*high, *low])) * self.factor;
                }
            }
            Coding::Log24 => {
                let Some(words) = self.bytes.get(self.at..self.at + 3 * self.width) else {
                    return invalid!("its bytes end early");
                };
                self.at += 3 * self.width;
                for (pixel, word) in out.chunks_exact_mut(3).zip(words.chunks_exact(3)) {
                    let colour = self.tables.colour_24(u32::from_be_bytes([0, word[0], word[1], word[2]]));
                    pixel.copy_from_slice(&colour.map(|x| x * self.factor));
                }
            }
        }
        Ok(())
    }
}

/// How to write.
#[derive(Clone, Copy, Debug)]
pub struct Writing {
    /// The words.
    pub coding: Coding,
    /// cd/m2 of a stored 1; `None` for what is not in cd/m2.
    pub stonits: Option<f64>,
    /// Codes are spread by noise of a step's width.
    pub dither: bool,
}

/// Writes an upright picture of XYZ, or of Y for LogL.
pub fn write(
    picture: Box<dyn Picture>,
    writing: Writing,
    out: &mut Output,
    limits: &Limits,
    notes: &crate::notes::Notes,
) -> Result<Losses> {
    let Writing { coding, stonits, dither } = writing;
    let (samples, compression, photometric) = match coding {
        Coding::Log32 => (3, COMPRESSION_32, LOG_LUV),
        Coding::Log24 => (3, COMPRESSION_24, LOG_LUV),
        Coding::LogL16 => (1, COMPRESSION_32, LOG_L),
    };
    let layout = Layout {
        bits: vec![16; samples],
        sample_format: 2,
        compression: compression as u16,
        photometric: photometric as u16,
        stonits,
        remarks: vec![format!("DITHER= {}", if dither { "noise" } else { "none" })],
    };
    let factor = (1.0 / stonits.unwrap_or(1.0)) as f32;
    let width = picture.header().resolution.width;
    let encode = |strip: &mut Strip<Losses>| -> Result<()> {
        let Strip { block, first_row, bytes, losses } = strip;
        let mut planes = Planes::default();
        for (i, row) in block.data.chunks_exact(width * samples).enumerate() {
            match coding {
                _ if dither => dithered(coding, row, factor, *first_row + i, &mut planes, bytes, losses),
                Coding::Log32 => rows::encode_32(row, factor, &mut planes, losses),
                Coding::Log24 => rows::encode_24(row, factor, Cells::get(), bytes, losses),
                Coding::LogL16 => luminances(row, factor, |_| 0.0, &mut planes, losses),
            }
            match coding {
                Coding::Log32 => Runs::LOGLUV.encode_planes(&planes, bytes),
                Coding::LogL16 => Runs::LOGLUV.encode_planes(&planes[..2], bytes),
                Coding::Log24 => {}
            }
        }
        Ok(())
    };
    let mut losses = Losses::default();
    crate::codec::tiff::write::write(picture, &layout, out, limits, notes, encode, |l| losses.add(l))?;
    Ok(losses)
}

/// A row with noise, word by word.
fn dithered(
    coding: Coding,
    row: &[f32],
    factor: f32,
    y: usize,
    planes: &mut Planes,
    bytes: &mut Vec<u8>,
    losses: &mut Losses,
) {
    if coding == Coding::LogL16 {
        return luminances(row, factor, |x| offset(x, y, 0), planes, losses);
    }
    planes.iter_mut().for_each(|plane| plane.resize(row.len() / 3, 0));
    for (x, c) in row.chunks_exact(3).enumerate() {
        let (colour, noise) = ([c[0], c[1], c[2]].map(|c| c * factor), [0, 1, 2].map(|c| offset(x, y, c)));
        if coding == Coding::Log24 {
            bytes.extend_from_slice(&super::word_24(colour, noise, Cells::get(), losses).to_be_bytes()[1..]);
        } else {
            let word = super::word_32(colour, noise, losses).to_be_bytes();
            planes.iter_mut().zip(word).for_each(|(plane, byte)| plane[x] = byte);
        }
    }
}

fn luminances(row: &[f32], factor: f32, noise: impl Fn(usize) -> f64, planes: &mut Planes, losses: &mut Losses) {
    planes[..2].iter_mut().for_each(|plane| plane.resize(row.len(), 0));
    for (x, y) in row.iter().enumerate() {
        let code = super::luminance_16(*y * factor, noise(x), losses).to_be_bytes();
        (planes[0][x], planes[1][x]) = (code[0], code[1]);
    }
}
