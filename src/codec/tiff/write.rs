//! Strips into TIFF, by way of the `tiff` crate.

use std::io::{BufWriter, Seek, Write};

use tiff::Directory;
use tiff::encoder::{Rational, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard};
use tiff::tags::{Tag, Type};

use super::directory::tag;
use crate::color::{Primaries, Xy};
use crate::parallel;
use crate::stream::output::Output;
use crate::stream::picture::block_rows;
use crate::stream::spool::Limits;
use crate::stream::{Block, Header, Picture, annotation};
use crate::{Error, Result};

/// What the directory says of the pixels.
pub struct Layout {
    /// Bits of each sample.
    pub bits: Vec<u16>,
    /// 1 unsigned, 2 signed.
    pub sample_format: u16,
    /// Compression.
    pub compression: u16,
    /// What the samples are.
    pub photometric: u16,
    /// cd/m2 of a stored luminance of 1.
    pub stonits: Option<f64>,
    /// Lines for the ImageDescription that are the format's own.
    pub remarks: Vec<String>,
}

/// A strip on its way to bytes.
#[derive(Default)]
pub struct Strip<L> {
    /// Its rows.
    pub block: Block,
    /// The first of them.
    pub first_row: usize,
    /// What becomes of them.
    pub bytes: Vec<u8>,
    /// What was lost.
    pub losses: L,
}

/// Writes an upright picture: `encode` turns a strip's rows into its bytes, `lost` adds up what was lost.
pub fn write<L: Default + Send>(
    picture: Box<dyn Picture>,
    layout: &Layout,
    out: &mut Output,
    limits: &Limits,
    notes: &crate::notes::Notes,
    encode: impl Fn(&mut Strip<L>) -> Result<()> + Sync,
    lost: impl FnMut(L) + Send,
) -> Result<()> {
    let r = picture.header().resolution;
    let stored = layout.bits.len() as u64 * 2;
    // No coding here makes pixels much larger than their samples; the directory needs little more.
    let most = (r.width as u64 * r.height as u64).saturating_mul(stored + 1).saturating_add(1 << 24);
    let mut file = BufWriter::with_capacity(64 << 10, out.in_any_order(limits)?);
    if most < u64::from(u32::MAX) {
        write_kind::<_, TiffKindStandard, L>(picture, layout, &mut file, encode, lost)?;
    } else {
        write_kind::<_, TiffKindBig, L>(picture, layout, &mut file, encode, lost)?;
    }
    file.into_inner().map_err(|e| Error::io("", e.into_error()))?.finish(notes)
}

fn write_kind<W: Write + Seek + Send, K: TiffKind<OffsetType: Send> + Send, L: Default + Send>(
    mut picture: Box<dyn Picture>,
    layout: &Layout,
    file: &mut W,
    encode: impl Fn(&mut Strip<L>) -> Result<()> + Sync,
    mut lost: impl FnMut(L) + Send,
) -> Result<()> {
    let header = picture.header().clone();
    let rows = block_rows(&header, header.resolution.height);
    let failed = |e: tiff::TiffError| match e {
        tiff::TiffError::IoError(e) => Error::io("", e),
        other => Error::Unsupported(other.to_string()),
    };
    let mut encoder = TiffEncoder::<_, K>::new_generic(file).map_err(failed)?;
    let mut directory = encoder.image_directory().map_err(failed)?;
    let (mut offsets, mut counts) = (Vec::new(), Vec::new());
    let mut taken = 0;
    let mut rest = Block::default();
    parallel::in_order(
        |strip: &mut Strip<L>| {
            strip.first_row = taken;
            fill(&mut *picture, rows, &mut rest, &mut strip.block)?;
            taken += strip.block.rows;
            Ok(strip.block.rows > 0)
        },
        |strip| {
            strip.bytes.clear();
            encode(strip)
        },
        |strip| {
            let offset = directory.write_data(&strip.bytes[..]).map_err(failed)?;
            offsets.push(K::convert_offset(offset).map_err(failed)?);
            counts.push(K::convert_offset(strip.bytes.len() as u64).map_err(failed)?);
            lost(std::mem::take(&mut strip.losses));
            Ok(())
        },
    )?;
    let mut tags = || -> tiff::TiffResult<()> {
        directory.write_tag(Tag::StripOffsets, K::convert_slice(&offsets))?;
        directory.write_tag(Tag::StripByteCounts, K::convert_slice(&counts))?;
        directory.write_tag(Tag::ImageWidth, header.resolution.width as u32)?;
        directory.write_tag(Tag::ImageLength, header.resolution.height as u32)?;
        directory.write_tag(Tag::RowsPerStrip, rows as u32)?;
        directory.write_tag(Tag::BitsPerSample, &layout.bits[..])?;
        directory.write_tag(Tag::SamplesPerPixel, layout.bits.len() as u16)?;
        directory.write_tag(Tag::SampleFormat, &vec![layout.sample_format; layout.bits.len()][..])?;
        directory.write_tag(Tag::Compression, layout.compression)?;
        directory.write_tag(Tag::PhotometricInterpretation, layout.photometric)?;
        directory.write_tag(Tag::PlanarConfiguration, 1u16)?;
        directory.write_tag(Tag::Orientation, 1u16)?;
        // As bytes: the crate's own texts are ASCII, and a history may name files in other letters.
        let text = directory.write_entry_bytes(Type::ASCII, &description(&header, layout))?;
        let mut texts = Directory::empty();
        texts.extend([(Tag::ImageDescription, text)]);
        directory.extend_from(&texts);
        directory.write_tag(Tag::Software, concat!("luxpipe ", env!("CARGO_PKG_VERSION")))?;
        if let Some(stonits) = layout.stonits {
            directory.write_tag(Tag::Unknown(tag::STONITS), stonits)?;
        }
        if let Some(white) = header.white {
            directory.write_tag(Tag::Unknown(tag::WHITE_POINT), &fractions(&[white])[..])?;
        }
        if let Some(Primaries { rgb, .. }) = header.primaries {
            directory.write_tag(Tag::Unknown(tag::PRIMARIES), &fractions(&rgb)[..])?;
        }
        Ok(())
    };
    tags().map_err(failed)?;
    directory.finish().map_err(failed)
}

/// Fills `block` with `rows` rows, or those that are left; `rest` keeps what came beyond.
fn fill(picture: &mut dyn Picture, rows: usize, rest: &mut Block, block: &mut Block) -> Result<()> {
    let floats = picture.header().scanline_floats();
    block.rows = 0;
    if rest.rows > 0 {
        block.data.clear();
    }
    while block.rows < rows {
        if rest.rows == 0 {
            if block.rows == 0 {
                // The usual case: blocks of the right size, handed on as they are.
                let more = picture.next(block)?;
                if !more || block.rows <= rows {
                    if !more || block.rows == rows {
                        return Ok(());
                    }
                    continue;
                }
                rest.rows = block.rows - rows;
                rest.data.clear();
                rest.data.extend_from_slice(&block.data[rows * floats..]);
                block.data.truncate(rows * floats);
                block.rows = rows;
                return Ok(());
            }
            if !picture.next(rest)? {
                return Ok(());
            }
        }
        let take = rest.rows.min(rows - block.rows);
        block.data.extend(rest.data.drain(..take * floats));
        block.rows += take;
        rest.rows -= take;
    }
    Ok(())
}

/// The header's lines and the format's own, the latter once, closed by a zero.
fn description(header: &Header, layout: &Layout) -> Vec<u8> {
    let key = |line: &[u8]| line.split(|b| *b == b'=').next().unwrap_or_default().to_vec();
    let own: Vec<Vec<u8>> = layout.remarks.iter().map(|r| key(r.as_bytes())).collect();
    let mut header = header.clone();
    header.lines.retain(|line| !(line.contains(&b'=') && own.contains(&key(line))));
    header.lines.extend(layout.remarks.iter().map(|r| r.clone().into_bytes()));
    let mut text: Vec<u8> = annotation::text(&header).iter().map(|b| if *b == 0 { b' ' } else { *b }).collect();
    text.push(0);
    text
}

fn fractions(points: &[Xy]) -> Vec<Rational> {
    const UNIT: u32 = 1_000_000_000;
    let fraction =
        |x: f64| Rational { n: (x * f64::from(UNIT)).round().clamp(0.0, f64::from(u32::MAX)) as u32, d: UNIT };
    points.iter().flat_map(|p| [fraction(p.x), fraction(p.y)]).collect()
}
