//! Reading: blocks as the table of offsets names them, some rows at a time, unpacked side by side.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use rayon::prelude::*;

use super::chroma::{self, Chroma};
use super::coder::{Area, Coder};
use super::head::{self, Head, Sample};
use super::spectral;
use crate::codec::Reading;
use crate::color::Primaries;
use crate::error::printable;
use crate::notes::Notes;
use crate::parallel;
use crate::stream::annotation::Annotation;
use crate::stream::picture::{block_rows, scale};
use crate::stream::reader::Input;
use crate::stream::source::Source;
use crate::stream::{Block, Components, Header, Picture, Resolution, Units};
use crate::{Error, Result, invalid};

/// Which channels make a pixel, and what they are.
struct Plan {
    components: Components,
    /// The channel of each component.
    channels: Vec<usize>,
    sampling: Option<crate::spectral::Sampling>,
    primaries: Option<Primaries>,
    chroma: Option<Chroma>,
}

/// Rows being read.
struct Reader {
    source: Source,
    header: Header,
    head: Head,
    coder: Coder,
    plan: Plan,
    /// What the values are multiplied by, a factor a component; empty for 1.
    factors: Vec<f32>,
    /// The next row to read.
    row: usize,
    /// Where the last block so far ends.
    end: u64,
    notes: Notes,
    /// Rows read already whose neighbours above wait for their colour.
    ahead: Option<Block>,
}

/// A block as it lies in the file.
struct Packed {
    bytes: Vec<u8>,
    area: Area,
    left: usize,
    unpacked: usize,
}

/// Opens a file.
pub(super) fn open(input: Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let mut source = Source::new(input, reading.limits, reading.notes)?;
    let head = head::read(&mut source)?;
    let annotation = Annotation::parse(&head.comments)?;
    let plan = plan(&head, &annotation, reading)?;
    let coder = Coder::new(head.compression, &head.channels)?;
    remark(&head, &plan, reading, &source.name);
    let (header, factors) = settle(&head, &plan, annotation, reading, &source.name)?;
    let notes = reading.notes.clone();
    let reader = Reader { source, header, head, coder, plan, factors, row: 0, end: 0, notes, ahead: None };
    let (rows, across) = reader.unit();
    let entries = (reader.head.window.height.div_ceil(rows) as u64).saturating_mul(across as u64);
    if entries.saturating_mul(8) > reader.source.len() - reader.head.table {
        return Err(reader.ends_at(0));
    }
    Ok(Box::new(reader))
}

/// Finds the channels that make a picture.
fn plan(head: &Head, annotation: &Annotation, reading: &Reading) -> Result<Plan> {
    let find = |name: &str| head.channels.iter().position(|c| c.name == name);
    let all = |names: &[&str]| names.iter().map(|n| find(n)).collect::<Option<Vec<usize>>>();
    let of = |components, channels| Plan { components, channels, sampling: None, primaries: None, chroma: None };
    let names = head.channels.iter().map(|c| c.name.as_str());
    let mut plan = if let Some(found) = spectral::find(names, |count| annotation.sampling(count))? {
        Plan { sampling: Some(found.sampling), ..of(found.components, found.channels) }
    } else if let Some(rgb) = all(&["R", "G", "B"]) {
        let primaries = primaries(head, annotation, reading)?;
        let components = if primaries.is_xyz() { Components::Xyz } else { Components::Rgb };
        Plan { primaries: Some(primaries).filter(|p| !p.is_xyz()), ..of(components, rgb) }
    } else if let Some(xyz) = all(&["X", "Y", "Z"]) {
        of(Components::Xyz, xyz)
    } else if let Some(yc) = all(&["Y", "RY", "BY"]) {
        let primaries = primaries(head, annotation, reading)?;
        let every = |i: usize| head.channels[i].every;
        let chroma = Chroma::new(&primaries, every(yc[1]))?;
        if every(yc[0]) != [1, 1] || every(yc[1]) != every(yc[2]) {
            return Err(Error::Unsupported("RY and BY sampled unlike each other, or Y subsampled".into()));
        }
        Plan { primaries: Some(primaries), chroma: Some(chroma), ..of(Components::Rgb, yc) }
    } else if let Some(y) = find("Y") {
        of(Components::Y, vec![y])
    } else {
        return Err(unknown(head));
    };
    if plan.chroma.is_none()
        && let Some(k) = plan.channels.iter().find(|k| head.channels[**k].every != [1, 1])
    {
        let name = printable(head.channels[*k].name.as_bytes());
        return Err(Error::Unsupported(format!("channel {name} is subsampled; only RY and BY are read so")));
    }
    plan.channels.shrink_to_fit();
    Ok(plan)
}

fn unknown(head: &Head) -> Error {
    let names: Vec<&str> = head.channels.iter().map(|c| c.name.as_str()).collect();
    let names = printable(names.join(" ").as_bytes());
    let reflects = |n: &str| n.starts_with("T.") || n.starts_with('M');
    if head.channels.iter().any(|c| reflects(&c.name) && c.name.ends_with("nm")) {
        return Error::Unsupported(format!("channels {names} hold reflectances, not light"));
    }
    Error::Unsupported(format!("channels {names}: expected R G B, X Y Z, Y, Y RY BY or S0.550,000000nm and the like"))
}

/// Of the file, to the digits of its floats those of its text; BT.709 where nothing says it.
fn primaries(head: &Head, annotation: &Annotation, reading: &Reading) -> Result<Primaries> {
    let stated = annotation.primaries();
    let Some(numbers) = head.chromaticities else {
        return Ok(stated.or(reading.overrides.primaries).unwrap_or(Primaries::BT709));
    };
    let own = Primaries::from_numbers(&numbers.map(spectral::plain)).or(reading.overrides.primaries);
    let Some(own) = own else {
        return invalid!("its chromaticities span no area; say what they are with --primaries");
    };
    Ok(stated.filter(|p| p.distance(&own) < 1e-6).unwrap_or(own))
}

/// What is passed over in silence nowhere.
fn remark(head: &Head, plan: &Plan, reading: &Reading, name: &str) {
    let note = |text: String| reading.notes.add(format!("{name}: {text}"));
    if head.parts > 1 {
        note(format!("reading the first of {} parts", head.parts));
    }
    let window = head.window;
    if let Some(display) = head.display.filter(|d| *d != window) {
        note(format!(
            "reading the data window, {} x {} from ({}, {}); the display window is {} x {} from ({}, {})",
            window.width,
            window.height,
            window.left,
            window.top,
            display.width,
            display.height,
            display.left,
            display.top
        ));
    }
    let mut others = head.channels.len() - plan.channels.len();
    if head.channels.iter().any(|c| c.name == "A") {
        others -= 1;
        note("alpha is ignored".into());
    }
    if others > 0 {
        note(format!("{others} other channels are left out"));
    }
    if head.texts_left_out {
        note("a text of more than 1 MiB is left out".into());
    }
    if plan.sampling.is_some() && !head.comments.starts_with(b"#?") {
        let units = head.emissive_units.as_deref().map_or("nothing".into(), printable);
        note(format!("taking its spectra for W/sr/m2/nm (emissiveUnits says {units})"));
    }
}

/// The picture's header, and what its values are multiplied by.
fn settle(
    head: &Head,
    plan: &Plan,
    annotation: Annotation,
    reading: &Reading,
    name: &str,
) -> Result<(Header, Vec<f32>)> {
    let window = head.window;
    let resolution = Resolution::upright(window.width, window.height);
    let ncomp = plan.channels.len();
    let luminance = head.white_luminance.filter(|l| *l > 0.0 && *l < f32::MAX);
    let mut factors = Vec::new();
    let units = if plan.sampling.is_some() {
        let left = head.handedness.as_deref().is_some_and(|h| h.eq_ignore_ascii_case(b"left"));
        if plan.components == Components::Stokes && left {
            factors = [1.0, 1.0, 1.0, -1.0].repeat(ncomp / 4);
        }
        Units::SpectralRadiance
    } else if let Some(luminance) = luminance {
        if reading.overrides.units.is_none_or(|u| u == Units::CdM2) && luminance != 1.0 {
            factors = vec![luminance; ncomp];
        }
        Units::CdM2
    } else {
        let fits = |u: &Units| match u {
            Units::CdM2 | Units::Relative | Units::Display => true,
            Units::Number => plan.components == Components::Y,
            Units::SpectralRadiance | Units::Weighted => false,
        };
        let stated = annotation.units().filter(fits);
        if stated.is_none() && reading.overrides.units.is_none() {
            reading.notes.add(format!("{name}: EXR without whiteLuminance: taking its numbers for cd/m2"));
        }
        stated.unwrap_or(Units::CdM2)
    };
    let mut own = Header::new(resolution, plan.components, ncomp, units);
    own.sampling = plan.sampling.clone();
    own.primaries = plan.primaries;
    // The text has all digits of what the attribute rounds.
    let stated = annotation.white();
    let same = |w: &crate::color::Xy| stated.is_some_and(|s| s.distance(*w) < 1e-6);
    own.white = head.neutral.and_then(spectral::xy).filter(|w| !same(w));
    let mut header = annotation.settle(own, reading.overrides)?;
    let aspect = f64::from(head.aspect);
    if header.variable("PIXASPECT").is_none() && aspect != 1.0 && (1e-3..1e3).contains(&aspect) {
        header.lines.push(format!("PIXASPECT={}", spectral::plain((1.0 / aspect) as f32)).into_bytes());
    }
    Ok((header, factors))
}

impl Reader {
    /// Rows that blocks side by side cover, and how many blocks lie so.
    fn unit(&self) -> (usize, usize) {
        match self.head.tiles {
            Some([width, height]) => (height, self.head.window.width.div_ceil(width)),
            None => (self.coder.rows(), 1),
        }
    }

    fn ends_at(&self, row: usize) -> Error {
        Error::Invalid(format!("picture ends at row {} of {}", row + 1, self.head.window.height))
    }

    /// The blocks side by side that begin with this row.
    fn fetch(&mut self, top: usize) -> Result<Vec<Packed>> {
        let (rows, across) = self.unit();
        let mut offsets = Vec::new();
        let entry = (top / rows * across) as u64;
        self.source.read_at(self.head.table + 8 * entry, 8 * across as u64, &mut offsets)?;
        let height = rows.min(self.head.window.height - top);
        let mut packed = Vec::new();
        for (x, offset) in offsets.chunks_exact(8).enumerate() {
            let mut offset_bytes = [0; 8];
            offset_bytes.copy_from_slice(offset);
            let (left, width) = match self.head.tiles {
                Some([width, _]) => (x * width, width.min(self.head.window.width - x * width)),
                None => (0, self.head.window.width),
            };
            let area = Area { top, width, height };
            packed.push(self.block(u64::from_le_bytes(offset_bytes), area, left)?);
        }
        Ok(packed)
    }

    /// One block, its place checked.
    fn block(&mut self, offset: u64, area: Area, left: usize) -> Result<Packed> {
        let numbers = usize::from(self.head.multipart) + if self.head.tiles.is_some() { 5 } else { 2 };
        let mut bytes = Vec::new();
        let start = offset.checked_add(4 * numbers as u64).filter(|end| *end <= self.source.len() && offset > 0);
        let start = start.ok_or_else(|| self.ends_at(area.top))?;
        self.source.read_at(offset, 4 * numbers as u64, &mut bytes)?;
        let mut words = bytes.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let mut next = || words.next().unwrap_or(0);
        let part = if self.head.multipart { next() } else { 0 };
        let place = match self.head.tiles {
            Some([width, height]) => {
                let place = [next(), next(), next(), next()];
                place == [(left / width) as i32, (area.top / height) as i32, 0, 0]
            }
            None => i64::from(next()) == i64::from(self.head.window.top) + area.top as i64,
        };
        let size = u64::try_from(next()).unwrap_or(u64::MAX);
        if part != 0 || !place {
            return invalid!("row {}: the table of offsets points to something else", area.top + 1);
        }
        if size > self.source.len() - start {
            return Err(self.ends_at(area.top));
        }
        let at_row = |e: Error| e.within(&format!("row {}", area.top + 1));
        let unpacked = self.coder.justified(area, size).map_err(at_row)?;
        self.source.read_at(start, size, &mut bytes)?;
        self.end = self.end.max(start + size);
        Ok(Packed { bytes, area, left, unpacked })
    }

    /// The next rows as they are stored, one number a channel and pixel.
    fn stored(&mut self, block: &mut Block) -> Result<bool> {
        block.rows = 0;
        block.data.clear();
        let (height, ncomp) = (self.head.window.height, self.header.ncomp);
        if self.row >= height {
            return Ok(false);
        }
        let (rows, _) = self.unit();
        // Whole units, one for each thread, and for the colour of subsampled rows an even number of rows.
        let wanted = block_rows(&self.header, height - self.row).max(2).div_ceil(rows);
        let units = wanted.max(parallel::threads()).next_multiple_of(if rows == 1 { 2 } else { 1 });
        let mut work: Vec<Vec<Packed>> = Vec::new();
        for _ in 0..units {
            if self.row >= height {
                break;
            }
            work.push(self.fetch(self.row)?);
            let here = rows.min(height - self.row);
            self.row += here;
            block.rows += here;
        }
        self.check_end();
        let row = self.header.scanline_floats();
        block.data.resize(block.rows * row, 0.0);
        let place = |(packed, out): (Vec<Packed>, &mut [f32])| {
            packed.into_iter().try_for_each(|p| {
                let at = p.area.top + 1;
                self.unpack(p, out, ncomp).map_err(|e| e.within(&format!("row {at}")))
            })
        };
        let done: Vec<Result<()>> = if work.len() > 1 && parallel::pool() {
            work.into_par_iter().zip(block.data.par_chunks_mut(rows * row)).map(place).collect()
        } else {
            work.into_iter().zip(block.data.chunks_mut(rows * row)).map(place).collect()
        };
        done.into_iter().collect::<Result<()>>().map(|()| true)
    }

    /// After the last row: anything left is worth a word, unless other parts or smaller copies follow.
    fn check_end(&self) {
        let rest = self.source.len() - self.end;
        if self.row == self.head.window.height && rest > 0 && self.head.parts == 1 && !self.head.levels {
            self.notes.add(format!("{}: {rest} bytes after the last block are ignored", self.source.name));
        }
    }

    /// Puts a block's samples where they belong among the rows of its unit.
    fn unpack(&self, packed: Packed, out: &mut [f32], ncomp: usize) -> Result<()> {
        let Packed { bytes, area, left, unpacked } = packed;
        let samples = self.coder.unpack(bytes, area, unpacked)?;
        let mut component: Vec<Option<usize>> = vec![None; self.head.channels.len()];
        for (k, channel) in self.plan.channels.iter().enumerate() {
            component[*channel] = Some(k);
        }
        let width = self.head.window.width;
        let (mut rest, mut halves, mut floats) = (&samples[..], Vec::new(), Vec::new());
        for (y, line) in out.chunks_exact_mut(width * ncomp).take(area.height).enumerate() {
            let line = &mut line[left * ncomp..(left + area.width) * ncomp];
            for (channel, k) in self.head.channels.iter().zip(&component) {
                if !(area.top + y).is_multiple_of(channel.every[1]) {
                    continue;
                }
                let count = area.width / channel.every[0];
                let Some((here, after)) = rest.split_at_checked(count * channel.sample.bytes()) else {
                    return invalid!("a block is damaged");
                };
                rest = after;
                if let Some(k) = k {
                    to_floats(here, channel.sample, &mut halves, &mut floats);
                    let slots = line[*k..].iter_mut().step_by(ncomp * channel.every[0]);
                    slots.zip(&floats).for_each(|(slot, x)| *slot = *x);
                }
            }
        }
        Ok(())
    }
}

/// Samples in the machine's byte order as floats.
fn to_floats(bytes: &[u8], sample: Sample, halves: &mut Vec<u16>, floats: &mut Vec<f32>) {
    let count = bytes.len() / sample.bytes();
    floats.resize(count, 0.0);
    match sample {
        Sample::Half => {
            halves.resize(count, 0);
            bytemuck::cast_slice_mut(halves).copy_from_slice(bytes);
            halves.reinterpret_cast::<f16>().convert_to_f32_slice(floats);
        }
        Sample::Float => bytemuck::cast_slice_mut(floats).copy_from_slice(bytes),
        Sample::Uint => {
            let whole = bytes.chunks_exact(4).map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
            floats.iter_mut().zip(whole).for_each(|(x, n)| *x = n as f32);
        }
    }
}

impl Picture for Reader {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let named = |e: Error, source: &Source| e.within(&source.name);
        let more = match self.ahead.take() {
            Some(ahead) => {
                *block = ahead;
                block.rows > 0
            }
            None => self.stored(block).map_err(|e| named(e, &self.source))?,
        };
        if let Some(chroma) = self.plan.chroma.filter(|_| more) {
            let mut ahead = Block::default();
            self.stored(&mut ahead).map_err(|e| named(e, &self.source))?;
            chroma::to_rgb(&chroma, self.head.window.width, &mut block.data, &ahead.data);
            self.ahead = Some(ahead);
        }
        if !self.factors.is_empty() {
            scale(&mut block.data, &self.factors);
        }
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.row = 0;
        self.ahead = None;
        Ok(true)
    }
}
