//! Reading: chunks to colours, codes to light.

use std::io::{self, BufRead, ErrorKind, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

use png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Info, Transformations};

use crate::codec::Reading;
use crate::codec::png::KEYWORD;
use crate::codec::png::colours::{Colours, Curves, colours};
use crate::codec::png::icc::{self, Curve};
use crate::display::transfer::{PQ_PEAK_CD_M2, Transfer, hlg_decode, pq_decode};
use crate::error::printable;
use crate::notes::Notes;
use crate::stream::annotation::Annotation;
use crate::stream::picture::block_rows;
use crate::stream::reader::Input;
use crate::stream::{Block, Components, Header, Picture, Resolution, Units};
use crate::{Error, Result, invalid};

/// Pixels of a row; a row of more is refused before anything is allocated.
const WIDEST: u32 = 1 << 24;
/// Bytes of all metadata.
const METADATA: usize = 32 << 20;
/// Bytes of our text.
const TEXT: usize = 1 << 20;
/// White of HLG where nothing says it, cd/m2.
const HLG_WHITE: f64 = 1000.0;

/// The input on loan to the decoder, which keeps what it reads from: on its end the input comes home.
struct Lent {
    input: Option<Input>,
    home: Home,
}

type Home = Arc<Mutex<Option<Input>>>;

impl Drop for Lent {
    fn drop(&mut self) {
        *self.home.lock().unwrap_or_else(PoisonError::into_inner) = self.input.take();
    }
}

impl Lent {
    fn bytes(&mut self) -> io::Result<&mut dyn BufRead> {
        self.input.as_mut().map(|i| &mut i.bytes as &mut dyn BufRead).ok_or(ErrorKind::NotConnected.into())
    }
}

impl Read for Lent {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.bytes()?.read(out)
    }
}

impl BufRead for Lent {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let bytes = self.bytes()?;
        while let Some(kind) = bytes.fill_buf().err().map(|e| e.kind()) {
            if kind != ErrorKind::Interrupted {
                break; // comes again below, whole
            }
        }
        self.bytes()?.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        if let Some(input) = &mut self.input {
            input.bytes.consume(n);
        }
    }
}

/// The decoder asks for it and never calls it.
impl Seek for Lent {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(ErrorKind::Unsupported.into())
    }
}

/// Codes to light.
enum Light {
    /// Channels alone: the light of every code.
    Alone([Arc<Vec<f32>>; 3]),
    /// HLG: scene light of every code; the display's gamma comes after.
    Hlg { scene: Vec<f64>, white: f64, y: [f64; 3] },
}

/// A picture being read.
struct Reader {
    /// None once the last row has been read.
    decoder: Option<png::Reader<Lent>>,
    home: Home,
    name: String,
    start: Option<u64>,
    memory: u64,
    header: Header,
    light: Light,
    row: usize,
    /// The whole picture, where it is interlaced.
    whole: Vec<u8>,
    transparent: bool,
    notes: Notes,
}

pub fn open(mut input: Input, reading: &Reading) -> Result<Box<dyn Picture>> {
    let (start, name, home) = (input.mark()?, input.name.clone(), Home::default());
    let decoder = decoder(Lent { input: Some(input), home: home.clone() })?;
    let info = decoder.info();
    let (width, height) = (info.width as usize, info.height as usize);
    let text = text(info)?;
    let notes = reading.notes;
    let note = |what: &str| notes.add(format!("{name}: {what}"));
    if info.animation_control.is_some() {
        note("is animated: its first picture alone is read");
    }
    let stated = Annotation::parse(text.as_deref().unwrap_or_default())?;
    let mut colours = colours(info, reading.overrides, &note)?;
    if let Some(exact) = stated.primaries().filter(|p| p.distance(&colours.primaries) < icc::SAME) {
        colours.primaries = exact; // the chunks round
    }
    let mut own = Header::new(Resolution::upright(width, height), Components::Rgb, 3, Units::Display);
    own.primaries = Some(colours.primaries);
    let mut header = stated.settle(own, reading.overrides)?;
    let deep = decoder.output_color_type().1 == BitDepth::Sixteen;
    let light = light(&colours, deep, &mut header, &note);
    Ok(Box::new(Reader {
        decoder: Some(decoder),
        home,
        name: name.clone(),
        start,
        memory: reading.limits.memory,
        header,
        light,
        row: 0,
        whole: Vec::new(),
        transparent: false,
        notes: notes.clone(),
    }))
}

/// A decoder that stands before the first row.
fn decoder(input: Lent) -> Result<png::Reader<Lent>> {
    let explain = |e| explain(e, "PNG ends before its first row", "PNG");
    let mut options = DecodeOptions::default();
    options.set_ignore_checksums(false);
    options.set_skip_ancillary_crc_failures(false);
    let mut decoder = Decoder::new_with_options(input, options);
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_limits(png::Limits { bytes: METADATA });
    let info = decoder.read_header_info().map_err(explain)?;
    let (width, height) = info.size();
    if width > i32::MAX as u32 || height > i32::MAX as u32 {
        return invalid!("PNG of size {width} x {height}: expected at most {} each way", i32::MAX);
    }
    if width > WIDEST {
        return invalid!("PNG with rows of {width} pixels: expected at most {WIDEST}");
    }
    decoder.set_limits(png::Limits { bytes: METADATA + 8 * width as usize });
    let decoder = decoder.read_info().map_err(explain)?;
    // The crate (0.18.1) copies whole entries and would fail on a part of one.
    match decoder.info().palette.as_deref().map_or(0, <[u8]>::len) {
        len if len.is_multiple_of(3) && len <= 768 => Ok(decoder),
        len => invalid!("PNG with a palette of {len} bytes: expected 3 for each of at most 256 colours"),
    }
}

/// A decoder's word in ours; `end` says what an early end of input means, `place` where it was.
fn explain(error: DecodingError, end: &str, place: &str) -> Error {
    match error {
        DecodingError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => Error::Invalid(end.into()),
        DecodingError::IoError(e) => Error::io("", e),
        DecodingError::LimitsExceeded => {
            Error::Unsupported(format!("{place}: metadata of more than {} MB", METADATA >> 20))
        }
        other => Error::Invalid(format!("{place}: {}", printable(other.to_string().trim_end_matches('.').as_bytes()))),
    }
}

/// The header's text, if there is one.
fn text(info: &Info) -> Result<Option<Vec<u8>>> {
    let latin = |text: &str| text.chars().map(|c| c as u8).collect();
    let long = |e| explain(e, "its text ends early", "its text of keyword luxpipe");
    if let Some(chunk) = info.utf8_text.iter().find(|t| t.keyword == KEYWORD) {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(TEXT).map_err(long)?;
        return Ok(Some(chunk.get_text().map_err(long)?.into_bytes()));
    }
    if let Some(chunk) = info.uncompressed_latin1_text.iter().find(|t| t.keyword == KEYWORD) {
        return Ok(Some(latin(&chunk.text)));
    }
    if let Some(chunk) = info.compressed_latin1_text.iter().find(|t| t.keyword == KEYWORD) {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(TEXT).map_err(long)?;
        return Ok(Some(latin(&chunk.get_text().map_err(long)?)));
    }
    Ok(None)
}

/// Tables for the curve; what absolute curves need is in the header or assumed there.
fn light(colours: &Colours, deep: bool, header: &mut Header, note: &dyn Fn(&str)) -> Light {
    let top = if deep { 65535 } else { 255 };
    let codes = || (0..=top).map(|i| f64::from(i) / f64::from(top));
    let table = |f: &dyn Fn(f64) -> f64| Arc::new(codes().map(|c| f(c) as f32).collect::<Vec<f32>>());
    match &colours.curves {
        Curves::Alone(curves) => {
            let [r, g, b] = curves;
            let first = table(&|c| r.light(c));
            let other = |curve: &Curve| if curve == r { first.clone() } else { table(&|c| curve.light(c)) };
            Light::Alone([first.clone(), other(g), other(b)])
        }
        Curves::Pq => {
            let [black, white] = *header.display.get_or_insert_with(|| {
                note("PQ without a DISPLAY line: 1 stands for 10000 cd/m2");
                [0.0, PQ_PEAK_CD_M2]
            });
            let all = table(&|c| (pq_decode(c) - black) / (white - black));
            Light::Alone([all.clone(), all.clone(), all])
        }
        Curves::Hlg => {
            let [_, white] = *header.display.get_or_insert_with(|| {
                note("HLG without a DISPLAY line: taking it for a display of 1000 cd/m2");
                [0.0, HLG_WHITE]
            });
            let y = colours.primaries.to_xyz().map_or([0.0; 3], |m| m.0[1]);
            Light::Hlg { scene: codes().map(hlg_decode).collect(), white, y }
        }
    }
}

impl Light {
    /// Appends the light of a row of pixels of `channels` samples of one or two bytes; true when some were transparent.
    fn row(&self, row: &[u8], channels: usize, deep: bool, out: &mut Vec<f32>) -> bool {
        if deep {
            self.samples(row.as_chunks().0, channels, |b: &[u8; 2]| usize::from(u16::from_be_bytes(*b)), 65535, out)
        } else {
            self.samples(row, channels, |b: &u8| usize::from(*b), 255, out)
        }
    }

    fn samples<T>(
        &self,
        row: &[T],
        channels: usize,
        code: impl Fn(&T) -> usize,
        top: usize,
        out: &mut Vec<f32>,
    ) -> bool {
        let mut transparent = false;
        let grey = channels < 3;
        for pixel in row.chunks_exact(channels) {
            transparent |= channels.is_multiple_of(2) && code(&pixel[channels - 1]) < top;
            let codes = if grey { [code(&pixel[0]); 3] } else { [0, 1, 2].map(|i| code(&pixel[i])) };
            match self {
                Light::Alone([r, g, b]) => out.extend([r[codes[0]], g[codes[1]], b[codes[2]]]),
                Light::Hlg { scene, white, y } => {
                    let light = Transfer::hlg_display(codes.map(|c| scene[c]), *white, *y);
                    out.extend(light.map(|x| x as f32));
                }
            }
        }
        transparent
    }
}

impl Reader {
    /// The pixels' form.
    fn layout(decoder: &png::Reader<Lent>) -> (usize, bool) {
        let (kind, depth) = decoder.output_color_type();
        let channels = match kind {
            ColorType::Grayscale | ColorType::Indexed => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb => 3,
            ColorType::Rgba => 4,
        };
        (channels, depth == BitDepth::Sixteen)
    }

    fn read(&mut self, rows: usize, out: &mut Vec<f32>) -> Result<()> {
        let height = self.header.resolution.height;
        let Some(decoder) = &mut self.decoder else { return invalid!("was read to its end") };
        let (channels, deep) = Reader::layout(decoder);
        if !decoder.info().interlaced {
            for row in self.row..self.row + rows {
                let (end, place) = (format!("picture ends at row {} of {height}", row + 1), format!("row {}", row + 1));
                let line = decoder.next_row().map_err(|e| explain(e, &end, &place))?;
                let Some(line) = line else { return Err(Error::Invalid(end)) };
                self.transparent |= self.light.row(line.data(), channels, deep, out);
            }
            return Ok(());
        }
        let line = (channels * self.header.resolution.width) << u32::from(deep);
        if self.row == 0 {
            let bytes = decoder.output_buffer_size().unwrap_or(usize::MAX);
            if bytes as u64 > self.memory {
                let size = bytes.div_ceil(1 << 20);
                return Err(Error::Unsupported(format!(
                    "an interlaced PNG is held whole, which takes {size} MB here; allow it with --memory"
                )));
            }
            self.whole = vec![0; bytes];
            let end = format!("interlaced picture ends before row 1 of {height} is whole");
            decoder.next_frame(&mut self.whole).map_err(|e| explain(e, &end, "interlaced rows"))?;
        }
        for row in self.whole[self.row * line..(self.row + rows) * line].chunks_exact(line) {
            self.transparent |= self.light.row(row, channels, deep, out);
        }
        Ok(())
    }

    /// After the last row: the rest must be a PNG's, and nothing should follow it.
    fn finish(&mut self) -> Result<()> {
        let height = self.header.resolution.height;
        if let Some(mut decoder) = self.decoder.take() {
            let end = format!("picture ends after row {height} of {height} without its IEND chunk");
            decoder.finish().map_err(|e| explain(e, &end, "after the last row"))?;
        }
        self.whole = Vec::new();
        let mut home = self.home.lock().unwrap_or_else(PoisonError::into_inner);
        if home.as_mut().is_some_and(|i| i.bytes.fill_buf().is_ok_and(|rest| !rest.is_empty())) {
            self.notes.add(format!("{}: bytes after the IEND chunk are ignored", self.name));
        }
        if self.transparent {
            self.notes.add(format!("{}: transparency is ignored", self.name));
        }
        Ok(())
    }
}

impl Picture for Reader {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let height = self.header.resolution.height;
        block.data.clear();
        block.rows = 0;
        if self.row == height {
            return Ok(false);
        }
        let rows = block_rows(&self.header, height - self.row);
        let mut read = self.read(rows, &mut block.data);
        if read.is_ok() && self.row + rows == height {
            read = self.finish();
        }
        read.map_err(|e| e.within(&self.name))?;
        block.rows = rows;
        self.row += rows;
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        let Some(start) = self.start else { return Ok(false) };
        self.decoder = None;
        let input = self.home.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(mut input) = input else { return invalid!("{}: cannot be read again", self.name) };
        input.back_to(start)?;
        let again = decoder(Lent { input: Some(input), home: self.home.clone() }).map_err(|e| e.within(&self.name))?;
        if (again.info().width as usize, again.info().height as usize)
            != (self.header.resolution.width, self.header.resolution.height)
        {
            return invalid!("{}: changed while it was read", self.name);
        }
        self.decoder = Some(again);
        (self.row, self.whole) = (0, Vec::new());
        Ok(true)
    }
}
