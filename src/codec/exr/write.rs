//! Writing: blocks of rows, packed side by side, in order of rows; the table of offsets last.

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::sync::atomic::Ordering;

use clap::ValueEnum;
use half::f16;
use half::slice::HalfFloatSliceExt;
use serde::{Deserialize, Serialize};

use super::coder::{Area, Coder};
use super::head::{self, Attributes, Channel, Sample};
use super::spectral;
use crate::color::Primaries;
use crate::notes::Notes;
use crate::parallel;
use crate::stream::annotation;
use crate::stream::output::Output;
use crate::stream::spool::{self, Limits};
use crate::stream::writer::{Replaced, settled};
use crate::stream::{Block, Components, Header, Picture, Units};
use crate::{Error, Result, invalid};

/// Bytes of pixels that a thread takes at a time.
const RUN_BYTES: usize = 512 << 10;
/// The largest half.
const HALF_MOST: f32 = 65504.0;
/// Below this a half has fewer than 11 bits.
const HALF_NORMAL: f32 = 6.103_515_6e-5;
/// In half, what is beyond this once was an infinity, or no light.
const HALF_ENDLESS: f32 = 1e30;
/// Rows or columns beyond which a file would not be read again.
const LONGEST_SIDE: usize = 1 << 29;

/// How blocks are compressed; every way is lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Compression {
    /// Not at all
    None,
    /// Deflate over 16 rows
    #[default]
    Zip,
    /// Wavelets over 32 rows, smaller for grainy pictures
    Piz,
}

/// Bits of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 16: up to 65504, to 1 in 2048.
    Half,
    /// 32: as the stream has them.
    Float,
}

/// How a picture is written.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Bits of a sample.
    pub depth: Depth,
    /// How blocks are compressed.
    pub compression: Compression,
    /// Values are divided by this, in cd/m2.
    pub white_luminance: Option<f32>,
}

/// What the file cannot hold, in pixels.
#[derive(Clone, Copy, Default)]
struct Losses {
    nan: u64,
    infinite: u64,
    faint: u64,
}

/// What a thread works on.
#[derive(Default)]
struct Run {
    first: usize,
    rows: usize,
    pixels: Vec<f32>,
    blocks: Vec<Vec<u8>>,
    losses: Losses,
}

/// What every thread needs to know.
struct Job {
    header: Header,
    coder: Coder,
    sample: Sample,
    /// The component that each channel of the file holds.
    components: Vec<usize>,
    divisor: f32,
}

/// Writes an upright picture of Y, XYZ, RGB, a spectrum or Stokes vectors. `replaced` counts what was bounded before a
/// matrix.
pub fn write(
    picture: Box<dyn Picture>,
    replaced: Option<Replaced>,
    options: Options,
    out: &mut Output,
    limits: &Limits,
    notes: &Notes,
) -> Result<()> {
    let header = picture.header().clone();
    let (width, height) = (header.resolution.width, header.resolution.height);
    if width > LONGEST_SIDE || height > LONGEST_SIDE {
        return invalid!("a picture of {width} x {height} pixels is too large for OpenEXR");
    }
    if options.white_luminance.is_some() && header.units != Units::CdM2 {
        return Err(Error::Usage(format!(
            "--white-luminance is for pictures in cd/m2; this one is in {}",
            header.units
        )));
    }
    let half = options.depth == Depth::Half;
    let looked = half && options.white_luminance.is_none();
    let (mut picture, found) = match options.white_luminance {
        None if half => scale_for_half(picture, limits, notes)?,
        given => (picture, given.unwrap_or(1.0)),
    };
    let replaced = if looked { replaced.map(|r| settled(&r)) } else { replaced };
    let (names, components) = layout(&header)?;
    let sample = if half { Sample::Half } else { Sample::Float };
    let channel = |name: &String| Channel { name: name.clone(), sample, linear: false, every: [1, 1] };
    let channels: Vec<Channel> = names.iter().map(channel).collect();
    let compression = match options.compression {
        Compression::None => ::exr::compression::Compression::Uncompressed,
        Compression::Zip => ::exr::compression::Compression::ZIP16,
        Compression::Piz => ::exr::compression::Compression::PIZ,
    };
    let coder = Coder::new(compression, &channels)?;
    let rows = coder.rows().min(height);
    if coder.bytes(Area { top: 0, width, height: rows }).is_none() {
        return invalid!("blocks of {rows} rows would be too large; --compression none makes them one row each");
    }
    let mut attributes = attributes(&header, found);
    attributes.add("channels", "chlist", head::channel_bytes(&names, sample));
    attributes.add("compression", "compression", [head::compression_code(compression)]);
    let job = Job { header, coder, sample, components, divisor: found };
    let mut first = Block::default();
    picture.next(&mut first)?;
    let losses = job.write(picture, first, attributes.into_bytes(), out, limits, notes)?;
    report(losses, replaced, half, &job.header, notes);
    Ok(())
}

/// Reads the picture for its largest magnitude; what it must be divided by to fit, a power of two.
fn scale_for_half(picture: Box<dyn Picture>, limits: &Limits, notes: &Notes) -> Result<(Box<dyn Picture>, f32)> {
    let units = picture.header().units;
    let mut most = 0f32;
    let picture = spool::twice(picture, limits, notes, |_, block| {
        let larger = |m: f32, x: &f32| if x.abs() > m && x.abs() <= HALF_ENDLESS { x.abs() } else { m };
        most = block.data.iter().fold(most, larger);
    })?;
    if most <= HALF_MOST {
        return Ok((picture, 1.0));
    }
    if units != Units::CdM2 {
        return invalid!("a value of {most} in {units} is beyond the largest half, {HALF_MOST}; write it with --float");
    }
    let mut divisor = 1f32;
    while most / divisor > HALF_MOST {
        divisor *= 2.0;
    }
    notes.add(format!(
        "the largest value, {most} cd/m2, is beyond the largest half, {HALF_MOST}: values are divided by {divisor}, \
         and whiteLuminance={divisor} says so; --float needs no scale"
    ));
    Ok((picture, divisor))
}

/// The channels' names in the order of the file, and the component that each holds.
fn layout(header: &Header) -> Result<(Vec<String>, Vec<usize>)> {
    let names: Vec<String> = match header.components {
        Components::Y => vec!["Y".into()],
        Components::Xyz | Components::Rgb => ["R", "G", "B"].map(String::from).to_vec(),
        Components::Spectrum | Components::Stokes => spectral::names(header)?,
        Components::Response | Components::Layers => {
            return invalid!("OpenEXR has no place for a picture of {}", header.components);
        }
    };
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|a, b| names[*a].cmp(&names[*b]));
    Ok((order.iter().map(|k| names[*k].clone()).collect(), order))
}

/// All attributes but those of the coding.
fn attributes(header: &Header, white_luminance: f32) -> Attributes {
    let window = head::window_bytes(header.resolution.width, header.resolution.height);
    let mut list = Attributes::default();
    list.add("dataWindow", "box2i", window.clone());
    list.add("displayWindow", "box2i", window);
    list.add("lineOrder", "lineOrder", [0]);
    list.floats("screenWindowCenter", "v2f", &[0.0; 2]);
    list.floats("screenWindowWidth", "float", &[1.0]);
    list.add("comments", "string", annotation::text(header));
    // Radiance counts height by width, several lines as their product.
    let lines = header.lines.iter().filter_map(|l| std::str::from_utf8(l.strip_prefix(b"PIXASPECT=")?).ok());
    let aspect: f64 = lines.filter_map(|t| t.trim().parse::<f64>().ok()).product();
    let aspect = if (1e-3..1e3).contains(&aspect) { (1.0 / aspect) as f32 } else { 1.0 };
    list.floats("pixelAspectRatio", "float", &[aspect]);
    if let Some(white) = header.white {
        list.floats("adoptedNeutral", "v2f", &[white.x as f32, white.y as f32]);
    }
    if header.units == Units::CdM2 {
        list.floats("whiteLuminance", "float", &[white_luminance]);
    }
    match header.components {
        Components::Xyz => {
            let third = 1.0 / 3.0;
            list.floats("chromaticities", "chromaticities", &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0, third, third]);
        }
        Components::Rgb => {
            let numbers = header.primaries.unwrap_or(Primaries::BT709).numbers().map(|x| x as f32);
            list.floats("chromaticities", "chromaticities", &numbers);
        }
        Components::Spectrum | Components::Stokes => {
            list.add("spectralLayoutVersion", "string", "1.0");
            list.add("emissiveUnits", "string", "W.m^-2.sr^-1");
            if header.components == Components::Stokes {
                list.add("polarisationHandedness", "string", "right");
            }
        }
        Components::Y | Components::Response | Components::Layers => {}
    }
    list
}

impl Job {
    fn write(
        &self,
        mut picture: Box<dyn Picture>,
        mut block: Block,
        head: Vec<u8>,
        out: &mut Output,
        limits: &Limits,
        notes: &Notes,
    ) -> Result<Losses> {
        let failed = |e| Error::io("", e);
        let mut file = BufWriter::with_capacity(256 << 10, out.in_any_order(limits)?);
        let (row, height, rows) = (self.header.scanline_floats(), self.header.resolution.height, self.coder.rows());
        let mut offsets: Vec<u64> = Vec::new();
        let table = vec![0u8; 8 * height.div_ceil(rows)];
        file.write_all(&head).and_then(|()| file.write_all(&table)).map_err(failed)?;
        let mut end = (head.len() + table.len()) as u64;
        drop(table);
        let run_rows = (RUN_BYTES / (4 * row)).max(1).next_multiple_of(rows);
        let (mut next_row, mut used) = (0, 0);
        let fill = |run: &mut Run| {
            run.first = next_row;
            run.rows = run_rows.min(height - next_row);
            next_row += run.rows;
            run.pixels.clear();
            while run.pixels.len() < run.rows * row {
                if used == block.data.len() {
                    used = 0;
                    if !picture.next(&mut block)? {
                        return invalid!("picture ends at row {} of {height}", run.first + run.pixels.len() / row + 1);
                    }
                }
                let take = (run.rows * row - run.pixels.len()).min(block.data.len() - used);
                run.pixels.extend_from_slice(&block.data[used..used + take]);
                used += take;
            }
            Ok(run.rows > 0)
        };
        let mut losses = Losses::default();
        let drain = |run: &mut Run| {
            for (i, packed) in run.blocks.drain(..).enumerate() {
                offsets.push(end);
                let y = (run.first + i * rows) as i32;
                file.write_all(&y.to_le_bytes()).map_err(failed)?;
                file.write_all(&(packed.len() as i32).to_le_bytes()).map_err(failed)?;
                file.write_all(&packed).map_err(failed)?;
                end += 8 + packed.len() as u64;
            }
            let Losses { nan, infinite, faint } = run.losses;
            losses.nan += nan;
            losses.infinite += infinite;
            losses.faint += faint;
            Ok(())
        };
        parallel::in_order(fill, |run| self.pack(run), drain)?;
        file.seek(SeekFrom::Start(head.len() as u64)).map_err(failed)?;
        let table: Vec<u8> = offsets.iter().flat_map(|n| n.to_le_bytes()).collect();
        file.write_all(&table).map_err(failed)?;
        file.into_inner().map_err(|e| failed(e.into_error()))?.finish(notes)?;
        Ok(losses)
    }

    /// Packs a run of rows.
    fn pack(&self, run: &mut Run) -> Result<()> {
        run.losses = Losses::default();
        run.blocks.clear();
        let (width, ncomp) = (self.header.resolution.width, self.header.ncomp);
        let (row, rows) = (width * ncomp, self.coder.rows());
        if self.divisor != 1.0 {
            run.pixels.iter_mut().for_each(|x| *x /= self.divisor);
        }
        for (y, line) in run.pixels.chunks_exact_mut(row).enumerate() {
            self.bound(line, run.first + y, &mut run.losses)?;
        }
        let mut plane = vec![0f32; width];
        let mut halves = vec![f16::ZERO; width];
        for (i, block) in run.pixels.chunks(rows * row).enumerate() {
            let height = block.len() / row;
            let mut samples: Vec<u8> = Vec::with_capacity(block.len() * self.sample.bytes());
            for line in block.chunks_exact(row) {
                for k in &self.components {
                    plane.iter_mut().zip(line[*k..].iter().step_by(ncomp)).for_each(|(p, x)| *p = *x);
                    if self.sample == Sample::Half {
                        halves.convert_from_f32_slice(&plane);
                        samples.extend(halves.iter().flat_map(|h| h.to_ne_bytes()));
                    } else {
                        samples.extend_from_slice(bytemuck::cast_slice(&plane));
                    }
                }
            }
            run.blocks.push(self.coder.pack(samples, Area { top: run.first + i * rows, width, height })?);
        }
        Ok(())
    }

    /// Makes every number one that the file holds, and counts the pixels that had others.
    fn bound(&self, line: &mut [f32], row: usize, losses: &mut Losses) -> Result<()> {
        let half = self.sample == Sample::Half;
        let (most, least) = if half { (HALF_MOST, HALF_NORMAL) } else { (f32::MAX, 0.0) };
        let plain = |x: &f32| (x.abs() <= most) & ((x.abs() >= least) | (*x == 0.0));
        if line.iter().fold(true, |all, x| all & plain(x)) {
            return Ok(());
        }
        let endless = if half { HALF_ENDLESS / self.divisor } else { f32::MAX };
        for pixel in line.chunks_exact_mut(self.header.ncomp) {
            let has = |f: &dyn Fn(&f32) -> bool| u64::from(pixel.iter().any(f));
            losses.nan += has(&|x| x.is_nan());
            losses.infinite += has(&|x| x.abs() > endless);
            losses.faint += has(&|x| *x != 0.0 && x.abs() < least);
            for x in pixel {
                if x.is_nan() {
                    *x = 0.0;
                } else if x.abs() > endless {
                    *x = most.copysign(*x);
                } else if x.abs() > most {
                    let (value, divisor) = (*x * self.divisor, self.divisor);
                    return invalid!(
                        "row {}: {value} / {divisor} is beyond the largest half, {most}; a larger --white-luminance or \
                         --float holds it",
                        row + 1
                    );
                }
            }
        }
        Ok(())
    }
}

/// One line for all that the file could not hold.
fn report(mut losses: Losses, replaced: Option<Replaced>, half: bool, header: &Header, notes: &Notes) {
    if let Some(replaced) = replaced {
        losses.nan += replaced[0].load(Ordering::Relaxed);
        // In half these came here as numbers beyond the bound, and were counted.
        losses.infinite += if half { 0 } else { replaced[1].load(Ordering::Relaxed) };
    }
    let Losses { nan, infinite, faint } = losses;
    let mut parts = Vec::new();
    if nan > 0 {
        parts.push(format!("{nan} had NaN set to 0"));
    }
    if infinite > 0 {
        let most = if half { "65504 as stored" } else { "the largest number" };
        parts.push(format!("{infinite} had a component infinite or beyond 1e30 set to {most}"));
    }
    if faint > 0 {
        parts.push(format!("{faint} had a component under 6.1e-5 as stored, where half has fewer than 11 bits"));
    }
    if !parts.is_empty() {
        let total = header.resolution.width as u64 * header.resolution.height as u64;
        let hint = if half { "--float holds all finite numbers" } else { "a float stream holds all numbers" };
        notes.add(format!("of {total} pixels {}; {hint}", parts.join(", ")));
    }
}
