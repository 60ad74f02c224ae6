//! What stands before the pixels: a version, attributes by name, one list a part. Read with every size checked, since
//! what follows is allocated by them; written in alphabetical order, so that equal work gives equal bytes.

use ::exr::compression::Compression;

use crate::error::printable;
use crate::stream::source::Source;
use crate::{Error, Result, invalid};

/// First bytes of every such file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Names and types have at most this many bytes.
const LONGEST_NAME: usize = 255;
/// Attributes of a file; no program comes near.
const MOST_ATTRIBUTES: usize = 1 << 14;
/// A channel list or text of more bytes is refused or left out.
const LONGEST_VALUE: u64 = 1 << 20;
/// Beyond this, positions no longer fit the arithmetic of OpenEXR itself.
const LONGEST_SIDE: i64 = 1 << 29;

/// How a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    /// A whole number of 32 bits.
    Uint,
    /// A float of 16 bits.
    Half,
    /// A float of 32 bits.
    Float,
}

impl Sample {
    pub fn bytes(self) -> usize {
        if self == Sample::Half { 2 } else { 4 }
    }
}

/// One channel.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    pub name: String,
    pub sample: Sample,
    /// For lossy compression: perceived linearly.
    pub linear: bool,
    /// One sample each so many columns and rows.
    pub every: [usize; 2],
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub left: i32,
    pub top: i32,
    pub width: usize,
    pub height: usize,
}

/// What the attributes of the first part say.
pub(super) struct Head {
    /// Sorted by name, as the samples lie.
    pub channels: Vec<Channel>,
    pub compression: Compression,
    pub window: Window,
    pub display: Option<Window>,
    /// Width and height of tiles.
    pub tiles: Option<[usize; 2]>,
    /// Smaller copies of the picture follow it.
    pub levels: bool,
    pub parts: usize,
    /// Chunks begin with the number of their part.
    pub multipart: bool,
    pub aspect: f32,
    pub chromaticities: Option<[f32; 8]>,
    pub white_luminance: Option<f32>,
    pub neutral: Option<[f32; 2]>,
    pub comments: Vec<u8>,
    pub texts_left_out: bool,
    pub handedness: Option<Vec<u8>>,
    pub emissive_units: Option<Vec<u8>>,
    /// Where the table of offsets begins.
    pub table: u64,
}

/// Attributes as they come.
#[derive(Default)]
struct Found {
    channels: Option<Vec<Channel>>,
    compression: Option<Compression>,
    window: Option<Window>,
    display: Option<Window>,
    tiles: Option<[usize; 2]>,
    levels: bool,
    kind: Option<Vec<u8>>,
    aspect: Option<f32>,
    chromaticities: Option<[f32; 8]>,
    white_luminance: Option<f32>,
    neutral: Option<[f32; 2]>,
    comments: Vec<u8>,
    texts_left_out: bool,
    handedness: Option<Vec<u8>>,
    emissive_units: Option<Vec<u8>>,
}

/// Reads the head.
pub(super) fn read(source: &mut Source) -> Result<Head> {
    let fixed: [u8; 8] = source.array_at(0).map_err(|_| ended())?;
    let version = u32::from_le_bytes([fixed[4], fixed[5], fixed[6], fixed[7]]);
    if version & 0xff != 2 || version >> 13 != 0 {
        return invalid!("OpenEXR version field {version:#x}: expected version 2");
    }
    let flag = |bit: u32| version & (1 << bit) != 0;
    let (tiled, deep, multipart) = (flag(9), flag(11), flag(12));
    let (mut at, mut parts, mut attributes, mut first) = (8u64, 0, 0, None);
    loop {
        let (found, count) = part(source, &mut at, &mut attributes)?;
        if multipart && count == 0 {
            break;
        }
        parts += 1;
        first.get_or_insert(found);
        if !multipart {
            break;
        }
    }
    let found = first.ok_or_else(|| Error::Invalid("no header in it".into()))?;
    let kind = found.kind.clone().unwrap_or_default();
    if (deep && !multipart) || kind.starts_with(b"deep") {
        return Err(Error::Unsupported(
            "deep pictures, with several samples a pixel, are not read; flatten it first".into(),
        ));
    }
    let tiled = if multipart { kind == b"tiledimage" } else { tiled };
    settle(found, tiled, multipart, parts, at)
}

fn ended() -> Error {
    Error::Invalid("file ends within its header".into())
}

/// One part's attributes; how many there were.
fn part(source: &mut Source, at: &mut u64, attributes: &mut usize) -> Result<(Found, usize)> {
    let (mut found, mut count, mut bytes) = (Found::default(), 0, Vec::new());
    loop {
        let ahead = (2 * LONGEST_NAME as u64 + 6).min(source.len().saturating_sub(*at));
        source.read_at(*at, ahead, &mut bytes)?;
        if bytes.first().ok_or_else(ended)? == &0 {
            *at += 1;
            return Ok((found, count));
        }
        let (name, rest) = word(&bytes).ok_or_else(ended)?;
        let (kind, rest) = word(rest).ok_or_else(ended)?;
        let size = rest.first_chunk::<4>().ok_or_else(ended)?;
        let size = u64::from(u32::from_le_bytes(*size));
        let value = *at + (bytes.len() - rest.len() + 4) as u64;
        if size > i32::MAX as u64 || value + size > source.len() {
            return Err(ended());
        }
        *at = value + size;
        count += 1;
        *attributes += 1;
        if *attributes > MOST_ATTRIBUTES {
            return invalid!("more than {MOST_ATTRIBUTES} attributes in its header");
        }
        let key = (name.to_vec(), kind.to_vec());
        found.take(source, (&key.0, &key.1), value, size)?;
    }
}

/// Bytes up to a zero, and what follows it.
fn word(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().take(LONGEST_NAME + 1).position(|b| *b == 0)?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

impl Found {
    fn take(&mut self, source: &mut Source, key: (&[u8], &[u8]), at: u64, size: u64) -> Result<()> {
        let wrong = || Error::Invalid(format!("attribute {} is damaged", printable(key.0)));
        let mut value = Vec::new();
        let text = matches!(key.1, b"string") && matches!(key.0, b"comments" | b"type");
        if size > LONGEST_VALUE {
            self.texts_left_out |= text;
            return if key.0 == b"channels" { Err(wrong()) } else { Ok(()) };
        }
        source.read_at(at, size, &mut value)?;
        match key {
            (b"channels", b"chlist") => self.channels = Some(channels(&value)?),
            (b"compression", b"compression") => {
                self.compression = Some(compression(*value.first().ok_or_else(wrong)?)?);
            }
            (b"dataWindow", b"box2i") => self.window = Some(window(&value).ok_or_else(wrong)?),
            (b"displayWindow", b"box2i") => self.display = window(&value),
            (b"tiles", b"tiledesc") => {
                let sides = value.first_chunk::<8>().ok_or_else(wrong)?;
                let side = |i: usize| u32::from_le_bytes([sides[i], sides[i + 1], sides[i + 2], sides[i + 3]]);
                let sides = [side(0), side(4)];
                if !sides.iter().all(|n| (1..=LONGEST_SIDE as u32).contains(n)) {
                    return invalid!("tiles of {} x {} pixels", sides[0], sides[1]);
                }
                self.tiles = Some(sides.map(|n| n as usize));
                self.levels = value.get(8).is_some_and(|mode| mode & 15 != 0);
            }
            (b"type", b"string") => self.kind = Some(value),
            (b"pixelAspectRatio", b"float") => self.aspect = floats::<1>(&value).map(|[a]| a),
            (b"chromaticities", b"chromaticities") => self.chromaticities = floats(&value),
            (b"whiteLuminance", b"float") => self.white_luminance = floats::<1>(&value).map(|[a]| a),
            (b"adoptedNeutral", b"v2f") => self.neutral = floats(&value),
            (b"comments", b"string") => self.comments = value,
            (b"polarisationHandedness", b"string") => self.handedness = Some(value),
            (b"emissiveUnits", b"string") => self.emissive_units = Some(value),
            _ => {}
        }
        Ok(())
    }
}

fn settle(found: Found, tiled: bool, multipart: bool, parts: usize, table: u64) -> Result<Head> {
    let missing = |name: &str| Error::Invalid(format!("attribute {name} is missing"));
    let head = Head {
        channels: found.channels.ok_or_else(|| missing("channels"))?,
        compression: found.compression.ok_or_else(|| missing("compression"))?,
        window: found.window.ok_or_else(|| missing("dataWindow"))?,
        display: found.display,
        tiles: if tiled { Some(found.tiles.ok_or_else(|| missing("tiles"))?) } else { None },
        levels: tiled && found.levels,
        parts,
        multipart,
        aspect: found.aspect.unwrap_or(1.0),
        chromaticities: found.chromaticities,
        white_luminance: found.white_luminance,
        neutral: found.neutral,
        comments: found.comments,
        texts_left_out: found.texts_left_out,
        handedness: found.handedness,
        emissive_units: found.emissive_units,
        table,
    };
    let window = head.window;
    for Channel { name, every: [x, y], .. } in &head.channels {
        let name = printable(name.as_bytes());
        if (*x, *y) == (1, 1) {
            continue;
        }
        if tiled {
            return invalid!("channel {name} is subsampled in a tiled picture");
        }
        let fits = window.width.is_multiple_of(*x) && window.height.is_multiple_of(*y);
        if !fits || window.left as i64 % *x as i64 != 0 || window.top as i64 % *y as i64 != 0 {
            return invalid!("channel {name}, sampled every {x} columns and {y} rows, does not fit the data window");
        }
    }
    Ok(head)
}

fn floats<const N: usize>(bytes: &[u8]) -> Option<[f32; N]> {
    if bytes.len() != 4 * N {
        return None;
    }
    let mut out = [0.0; N];
    for (x, b) in out.iter_mut().zip(bytes.chunks_exact(4)) {
        *x = f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    }
    out.iter().all(|x| x.is_finite()).then_some(out)
}

fn window(bytes: &[u8]) -> Option<Window> {
    let number = |i: usize| bytes.get(4 * i..4 * i + 4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let [left, top, right, bottom] = [number(0)?, number(1)?, number(2)?, number(3)?];
    let (width, height) = (i64::from(right) - i64::from(left) + 1, i64::from(bottom) - i64::from(top) + 1);
    let fits = |n: i64| (1..=LONGEST_SIDE).contains(&n);
    let near = |n: i32| i64::from(n).abs() <= LONGEST_SIDE;
    (fits(width) && fits(height) && near(left) && near(top)).then_some(Window {
        left,
        top,
        width: width as usize,
        height: height as usize,
    })
}

fn channels(mut bytes: &[u8]) -> Result<Vec<Channel>> {
    let wrong = || Error::Invalid("attribute channels is damaged".into());
    let mut list = Vec::new();
    while bytes.first().ok_or_else(wrong)? != &0 {
        let (name, rest) = word(bytes).ok_or_else(wrong)?;
        let (fixed, rest) = rest.split_first_chunk::<16>().ok_or_else(wrong)?;
        let number = |i: usize| i32::from_le_bytes([fixed[i], fixed[i + 1], fixed[i + 2], fixed[i + 3]]);
        let sample = match number(0) {
            0 => Sample::Uint,
            1 => Sample::Half,
            2 => Sample::Float,
            other => return invalid!("channel {} holds samples of unknown type {other}", printable(name)),
        };
        let [x, y] = [number(8), number(12)];
        if !(1..=256).contains(&x) || !(1..=256).contains(&y) {
            return invalid!("channel {} is sampled every {x} columns and {y} rows", printable(name));
        }
        let name = String::from_utf8(name.to_vec()).map_err(|_| wrong())?;
        list.push(Channel { name, sample, linear: fixed[4] != 0, every: [x as usize, y as usize] });
        bytes = rest;
    }
    list.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(pair) = list.windows(2).find(|w| w[0].name == w[1].name) {
        return invalid!("channel {} is there twice", printable(pair[0].name.as_bytes()));
    }
    if list.is_empty() { invalid!("no channels in it") } else { Ok(list) }
}

fn compression(code: u8) -> Result<Compression> {
    Ok(match code {
        0 => Compression::Uncompressed,
        1 => Compression::RLE,
        2 => Compression::ZIP1,
        3 => Compression::ZIP16,
        4 => Compression::PIZ,
        5 => Compression::PXR24,
        6 => Compression::B44,
        7 => Compression::B44A,
        8 => Compression::DWAA(None),
        9 => Compression::DWAB(None),
        10 | 11 => return Err(Error::Unsupported("HTJ2K compression is not read".into())),
        other => return Err(Error::Unsupported(format!("compression {other} is not known"))),
    })
}

/// The byte that stands for what [`super::write`] writes.
pub(super) fn compression_code(compression: Compression) -> u8 {
    match compression {
        Compression::ZIP16 => 3,
        Compression::PIZ => 4,
        _ => 0,
    }
}

/// A header being written: name, type, value.
#[derive(Default)]
pub(super) struct Attributes(Vec<(&'static str, &'static str, Vec<u8>)>);

impl Attributes {
    pub fn add(&mut self, name: &'static str, kind: &'static str, value: impl Into<Vec<u8>>) {
        self.0.push((name, kind, value.into()));
    }

    pub fn floats(&mut self, name: &'static str, kind: &'static str, values: &[f32]) {
        self.add(name, kind, values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    }

    /// The file up to its table of offsets.
    pub fn into_bytes(mut self) -> Vec<u8> {
        self.0.sort_by_key(|a| a.0);
        let mut out = MAGIC.to_vec();
        out.extend(2u32.to_le_bytes());
        for (name, kind, value) in &self.0 {
            for word in [name, kind] {
                out.extend_from_slice(word.as_bytes());
                out.push(0);
            }
            out.extend((value.len() as u32).to_le_bytes());
            out.extend_from_slice(value);
        }
        out.push(0);
        out
    }
}

/// A box2i from (0, 0).
pub(super) fn window_bytes(width: usize, height: usize) -> Vec<u8> {
    [0, 0, width as i32 - 1, height as i32 - 1].iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A chlist; the channels sorted by name.
pub(super) fn channel_bytes(names: &[String], sample: Sample) -> Vec<u8> {
    let mut out = Vec::new();
    for name in names {
        out.extend_from_slice(name.as_bytes());
        out.push(0);
        out.extend((if sample == Sample::Half { 1u32 } else { 2 }).to_le_bytes());
        out.extend([0; 4]);
        out.extend([1u32, 1].iter().flat_map(|n| n.to_le_bytes()));
    }
    out.push(0);
    out
}
