//! Writing a picture as a stream: raw floats, or Radiance's RGBE and XYZE.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::color::Primaries;
use crate::color::gamut::{self, Limit};
use crate::color::matrix;
use crate::notes::Notes;
use crate::parallel;
use crate::simd;
use crate::spectral::Sampling;
use crate::stream::output::Output;
use crate::stream::picture;
use crate::stream::rgbe::{self, Losses};
use crate::stream::rle::{self, Planes};
use crate::stream::{Block, Components, Header, Picture, Units};
use crate::units::{RADIANCE_BAND, RADIANCE_EFFICACY};
use crate::{Error, Result, invalid};

/// How a picture filter writes its result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Format {
    /// Raw 32-bit floats, what the filters pass to each other
    #[default]
    Float,
    /// Radiance RGBE, for Radiance's own tools
    Rgbe,
    /// Radiance XYZE
    Xyze,
}

/// Writes a picture to its end in the given format. Does not finish the output.
pub fn write(mut picture: Box<dyn Picture>, format: Format, out: &mut Output, notes: &Notes) -> Result<()> {
    match format {
        Format::Float => {
            let mut block = Block::default();
            // Rows first: a stream whose first row is damaged leaves nothing behind.
            let mut more = picture.next(&mut block)?;
            out.write_all(&picture.header().to_bytes("float", &[])).map_err(|e| out.error(e))?;
            while more {
                out.write_all(bytemuck::cast_slice(&block.data)).map_err(|e| out.error(e))?;
                more = picture.next(&mut block)?;
            }
            Ok(())
        }
        Format::Rgbe => {
            let (picture, bad) = bounded(picture);
            write_shared_exponent(to_rgb(picture, Primaries::RADIANCE)?, bad, "32-bit_rle_rgbe", false, out, notes)
        }
        Format::Xyze => {
            let (picture, bad) = bounded(picture);
            write_shared_exponent(to_xyz(picture)?, bad, "32-bit_rle_xyze", false, out, notes)
        }
    }
}

/// Components beyond this are brought to it before a matrix: no sum of three such products overflows.
const LARGEST: f32 = 1e37;

/// Counts of what [`bounded`] replaced.
pub type Replaced = Arc<[AtomicU64; 2]>;

/// The picture with NaN as 0 and what is infinite or over 1e37 as 1e37, before a matrix could turn infinities into NaN; the
/// pixels concerned are counted, NaN first.
pub fn bounded(picture: Box<dyn Picture>) -> (Box<dyn Picture>, Replaced) {
    let replaced = Replaced::default();
    let count = replaced.clone();
    let header = picture.header().clone();
    let n = header.ncomp;
    let bound = move |pixels: &mut [f32]| {
        if simd::all_within(pixels, LARGEST) {
            return;
        }
        for pixel in pixels.chunks_exact_mut(n) {
            count[0].fetch_add(u64::from(pixel.iter().any(|x| x.is_nan())), Ordering::Relaxed);
            count[1].fetch_add(u64::from(pixel.iter().any(|x| x.abs() > LARGEST)), Ordering::Relaxed);
            pixel.iter_mut().for_each(|x| *x = if x.is_nan() { 0.0 } else { x.clamp(-LARGEST, LARGEST) });
        }
    };
    (picture::map(picture, header, bound), replaced)
}

/// The counts after a whole pass, untouched by another: a picture looked at before it is written is read again or not.
pub fn settled(replaced: &Replaced) -> Replaced {
    Arc::new(counts(replaced).map(AtomicU64::new))
}

/// The counts: NaN, infinite.
pub fn counts(replaced: &Replaced) -> [u64; 2] {
    replaced.each_ref().map(|n| n.load(Ordering::Relaxed))
}

/// Number of pixels.
pub fn pixels(header: &Header) -> u64 {
    header.resolution.width as u64 * header.resolution.height as u64
}

/// One line for all that an encoding could not hold: how many pixels, and what became of them; `hint` names one that could.
pub fn note_losses(parts: &[(u64, String)], total: u64, hint: &str, notes: &Notes) {
    let parts: Vec<String> = parts.iter().filter(|p| p.0 > 0).map(|(n, what)| format!("{n} {what}")).collect();
    if !parts.is_empty() {
        notes.add(format!("of {total} pixels {}; {hint}", parts.join(", ")));
    }
}

/// The picture as RGB: untouched if it is that, by the matrix of `primaries` from XYZ.
pub fn to_rgb(picture: Box<dyn Picture>, primaries: Primaries) -> Result<Box<dyn Picture>> {
    match picture.header().components {
        Components::Rgb => Ok(picture),
        Components::Xyz => {
            let m = primaries.from_xyz().ok_or_else(|| Error::Invalid("primaries span no area".into()))?.to_f32();
            let mut header = picture.header().clone();
            header.become_tristimulus(Components::Rgb, header.units);
            header.primaries = Some(primaries);
            Ok(picture::map(picture, header, move |pixels| matrix::multiply_rows(&m, pixels)))
        }
        other => invalid!("RGBE holds RGB, not {other}; run spec2xyz first"),
    }
}

/// The picture as XYZ: untouched if it is that, by the matrix of its primaries from RGB.
pub fn to_xyz(picture: Box<dyn Picture>) -> Result<Box<dyn Picture>> {
    match picture.header().components {
        Components::Xyz => Ok(picture),
        Components::Rgb => {
            let mut header = picture.header().clone();
            let primaries = header.primaries.unwrap_or(Primaries::RADIANCE);
            let m = primaries.to_xyz().ok_or_else(|| Error::Invalid("primaries span no area".into()))?.to_f32();
            header.become_tristimulus(Components::Xyz, header.units);
            Ok(picture::map(picture, header, move |pixels| matrix::multiply_rows(&m, pixels)))
        }
        other => invalid!("expected XYZ or RGB, got {other}; run spec2xyz first"),
    }
}

/// Writes RGB as RGBE or XYZ as XYZE. `desaturate` moves colours with negative components to the grey of their luminance;
/// otherwise negatives become 0, as Radiance has it.
///
/// RGBE holds W/sr/m2, so cd/m2 are divided by 179; XYZE holds cd/m2 / 179 and says so with `EXPOSURE=5.5866e-03`.
pub fn write_shared_exponent(
    picture: Box<dyn Picture>,
    replaced: Replaced,
    format: &str,
    desaturate: bool,
    out: &mut Output,
    notes: &Notes,
) -> Result<()> {
    let header = picture.header().clone();
    let display = header.units == Units::Display;
    let factor = if display { 1.0 } else { (1.0 / RADIANCE_EFFICACY) as f32 };
    let exposure = (format.ends_with("xyze") && !display).then(|| "EXPOSURE=5.5866e-03".to_string());
    let y_row = luminance_row(&header);
    let width = header.resolution.scanline_len();
    let encode = |coded: &mut Coded| {
        if desaturate {
            matrix::for_planes(
                &mut coded.block.data,
                #[inline(always)]
                |p| gamut::desaturate(p, &y_row, Limit::Positive),
            );
        }
        for line in coded.block.data.chunks_exact(3 * width) {
            rgbe::encode_pixels(line, factor, &mut coded.planes, &mut coded.losses);
            rle::encode(&coded.planes, &mut coded.bytes);
        }
    };
    write_coded(picture, &header.to_bytes(format, exposure.as_slice()), encode, replaced, out, notes)
}

/// Writes a spectrum of equal bins as `Radiance_spectra`: Radiance's band values, NCOMP mantissas and one exponent a pixel,
/// flat.
pub fn write_spectra(picture: Box<dyn Picture>, replaced: Replaced, out: &mut Output, notes: &Notes) -> Result<()> {
    let header = picture.header().clone();
    let ncomp = header.ncomp;
    match &header.sampling {
        Some(Sampling::Bins { .. }) => {}
        _ => return invalid!("hyperspectral Radiance holds spectra of equal bins, and this picture's are none"),
    }
    let factor = (1.0 / RADIANCE_BAND) as f32;
    let encode = |coded: &mut Coded| {
        rgbe::encode_spectra(&coded.block.data, ncomp, factor, &mut coded.bytes, &mut coded.losses);
    };
    write_coded(picture, &header.to_bytes("Radiance_spectra", &[]), encode, replaced, out, notes)
}

/// A block on its way to bytes.
#[derive(Default)]
struct Coded {
    block: Block,
    planes: Planes,
    bytes: Vec<u8>,
    losses: Losses,
}

/// Writes a header and, block by block, what `encode` makes of the picture; says what was lost.
fn write_coded(
    mut picture: Box<dyn Picture>,
    head: &[u8],
    encode: impl Fn(&mut Coded) + Sync,
    replaced: Replaced,
    out: &mut Output,
    notes: &Notes,
) -> Result<()> {
    let header = picture.header().clone();
    let mut head = Some(head);
    let mut losses = Losses::default();
    parallel::in_order(
        |coded: &mut Coded| picture.next(&mut coded.block),
        |coded| {
            coded.bytes.clear();
            coded.losses = Losses::default();
            encode(coded);
            Ok(())
        },
        |coded| {
            // Rows first: a stream whose first row is damaged leaves nothing behind.
            out.write_all(head.take().unwrap_or_default()).map_err(|e| out.error(e))?;
            losses.add(coded.losses);
            out.write_all(&coded.bytes).map_err(|e| out.error(e))
        },
    )?;
    let [nan, overflow] = counts(&replaced);
    losses.add(Losses { negative: 0, nan, overflow });
    report(losses, &header, notes);
    Ok(())
}

/// Luminance of RGB components, or the Y of XYZ.
fn luminance_row(header: &Header) -> [f32; 3] {
    match (header.components, header.primaries.and_then(|p| p.to_xyz())) {
        (Components::Rgb, Some(m)) => m.0[1].map(|x| x as f32),
        _ => [0.0, 1.0, 0.0],
    }
}

/// One line for all that the encoding could not hold.
fn report(losses: Losses, header: &Header, notes: &Notes) {
    let Losses { negative, nan, overflow } = losses;
    let parts = [
        (negative, "had a negative component set to 0".to_string()),
        (nan, "had NaN set to 0".into()),
        (overflow, "had a component infinite or over 1e37 set to that".into()),
    ];
    let hint = match header.components {
        Components::Rgb if negative > 0 => "XYZE would hold every visible colour, a float stream all numbers",
        _ => "a float stream holds all numbers",
    };
    note_losses(&parts, pixels(header), hint, notes);
}
