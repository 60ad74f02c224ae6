//! The information header: history and unknown lines pass untouched, the variables that say what the numbers are live in
//! fields and are restated by the writer.

use std::fmt::Write as _;
use std::io::BufRead;

use crate::color::{Primaries, Xy};
use crate::error::printable;
use crate::spectral::Sampling;
use crate::stream::Resolution;
use crate::{Error, Result, invalid};

/// A line may have this many bytes.
pub(super) const LONGEST_LINE: usize = 64 << 10;
/// A header may have this many bytes.
pub(super) const LONGEST_HEADER: usize = 1 << 20;

/// What the components of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// Luminance alone, or one number of another kind.
    Y,
    /// CIE 1931 tristimulus values.
    Xyz,
    /// Linear RGB of the header's primaries.
    Rgb,
    /// Spectral radiance, one component a bin or wavelength.
    Spectrum,
    /// Stokes vectors I, Q, U, V of the first wavelength, then of the next.
    Stokes,
    /// Spectral radiance weighted by responses, one component a response.
    Response,
    /// How much of each light arrives, a component a wavelength, the lights one after the other.
    Layers,
}

impl Components {
    /// As the COMPONENTS line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Components::Y => "Y",
            Components::Xyz => "XYZ",
            Components::Rgb => "RGB",
            Components::Spectrum => "SPECTRUM",
            Components::Stokes => "STOKES",
            Components::Response => "RESPONSE",
            Components::Layers => "LAYERS",
        }
    }
}

impl std::str::FromStr for Components {
    type Err = Error;
    fn from_str(s: &str) -> Result<Self> {
        use Components::*;
        [Y, Xyz, Rgb, Spectrum, Stokes, Response, Layers]
            .into_iter()
            .find(|c| c.name().eq_ignore_ascii_case(s))
            .ok_or_else(|| {
                Error::Invalid(format!(
                    "components '{}': expected Y, XYZ, RGB, SPECTRUM, STOKES, RESPONSE or LAYERS",
                    printable(s.as_bytes())
                ))
            })
    }
}

impl std::fmt::Display for Components {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
crate::string_serde!(Components);

/// What the numbers count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// W/sr/m2/nm
    SpectralRadiance,
    /// cd/m2; for RGB the luminance is the Y row of the primaries times the components.
    CdM2,
    /// Linear, 0 the display's black and 1 its white.
    Display,
    /// Linear, 1 the luminance of a perfect diffuser.
    Relative,
    /// W/sr/m2, or that times the factor a response was given.
    Weighted,
    /// Pure numbers, such as colour differences; only with [`Components::Y`].
    Number,
}

impl Units {
    /// As the UNITS line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Units::SpectralRadiance => "W/sr/m2/nm",
            Units::CdM2 => "cd/m2",
            Units::Display => "display",
            Units::Relative => "relative",
            Units::Weighted => "W/sr/m2",
            Units::Number => "none",
        }
    }
}

impl std::str::FromStr for Units {
    type Err = Error;
    fn from_str(s: &str) -> Result<Self> {
        use Units::*;
        [SpectralRadiance, CdM2, Display, Relative, Weighted, Number].into_iter().find(|u| u.name() == s).ok_or_else(
            || {
                Error::Invalid(format!(
                    "units '{}': expected W/sr/m2/nm, W/sr/m2, cd/m2, relative, display or none",
                    printable(s.as_bytes())
                ))
            },
        )
    }
}

impl std::fmt::Display for Units {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
crate::string_serde!(Units);

/// What `vonkries` did, so that a later stage can undo it.
#[derive(Clone, Debug, PartialEq)]
pub struct Adapted {
    /// White before.
    pub from: Xy,
    /// White after.
    pub to: Xy,
    /// Name of the matrix.
    pub cat: String,
    /// Degree of adaptation.
    pub degree: f64,
}

/// A picture's header with its meaning settled.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// History, views and unknown lines, in order, without newlines.
    pub lines: Vec<Vec<u8>>,
    /// Size and scan order.
    pub resolution: Resolution,
    /// Components a pixel.
    pub ncomp: usize,
    /// What they are.
    pub components: Components,
    /// What they count.
    pub units: Units,
    /// How a spectrum or Stokes picture samples wavelength.
    pub sampling: Option<Sampling>,
    /// For a spectrum: rows of weights that give XYZ, in place of the observer's.
    pub xyz_matrix: Option<[Vec<f64>; 3]>,
    /// Primaries of RGB.
    pub primaries: Option<Primaries>,
    /// Chromaticity of the scene's adopted white.
    pub white: Option<Xy>,
    /// The last adaptation.
    pub adapted: Option<Adapted>,
    /// Black and white luminance of the display, cd/m2, for display-referred pictures.
    pub display: Option<[f64; 2]>,
}

impl Header {
    /// A header without history.
    pub fn new(resolution: Resolution, components: Components, ncomp: usize, units: Units) -> Header {
        Header {
            lines: Vec::new(),
            resolution,
            ncomp,
            components,
            units,
            sampling: None,
            xyz_matrix: None,
            primaries: None,
            white: None,
            adapted: None,
            display: None,
        }
    }

    /// Floats a scanline.
    pub fn scanline_floats(&self) -> usize {
        self.resolution.scanline_len() * self.ncomp
    }

    /// The last pass-through line `KEY=...`, its value trimmed.
    pub fn variable(&self, key: &str) -> Option<&[u8]> {
        self.lines.iter().rev().find_map(|l| l.strip_prefix(key.as_bytes())?.strip_prefix(b"=")).map(<[u8]>::trim_ascii)
    }

    /// Turns the picture into three components of another kind in the units given, dropping what no longer applies.
    pub fn become_tristimulus(&mut self, components: Components, units: Units) {
        self.components = components;
        self.ncomp = 3;
        self.units = units;
        self.sampling = None;
        self.xyz_matrix = None;
        self.primaries = None;
    }

    /// The header's text up to and including the resolution line, with `FORMAT` padded so that the first pixel byte lies
    /// at a multiple of four. `extra` lines (EXPOSURE) come before FORMAT.
    pub fn to_bytes(&self, format: &str, extra: &[String]) -> Vec<u8> {
        let mut out = b"#?RADIANCE\n".to_vec();
        for line in &self.lines {
            out.extend_from_slice(line);
            out.push(b'\n');
        }
        let mut text = String::new();
        self.restate(&mut text, format);
        for line in extra {
            text += line;
            text.push('\n');
        }
        text += "FORMAT=";
        text += format;
        let tail = format!("\n\n{}\n", self.resolution);
        if format == "float" {
            let end = out.len() + text.len() + tail.len();
            text += &" ".repeat(end.next_multiple_of(4) - end);
        }
        out.extend_from_slice(text.as_bytes());
        out.extend_from_slice(tail.as_bytes());
        out
    }

    /// Every variable that is set, a line each. Writing to a string cannot fail.
    fn restate(&self, text: &mut String, format: &str) {
        let float = format == "float";
        if float || format == "Radiance_spectra" || self.ncomp != 3 {
            let _ = writeln!(text, "NCOMP={}", self.ncomp);
        }
        if float {
            self.state_meaning(text);
        } else if self.units == Units::Display {
            let _ = writeln!(text, "UNITS=display");
        }
        self.state_sampling_and_colour(text);
        if float {
            let _ = writeln!(text, "BigEndian={}", u8::from(cfg!(target_endian = "big")));
        }
    }

    /// The lines that say what the numbers mean, whatever their coding.
    pub(super) fn variables(&self) -> String {
        let mut text = String::new();
        self.state_meaning(&mut text);
        self.state_sampling_and_colour(&mut text);
        text
    }

    fn state_meaning(&self, text: &mut String) {
        let _ = writeln!(text, "COMPONENTS={}", self.components);
        let _ = writeln!(text, "UNITS={}", self.units);
    }

    fn state_sampling_and_colour(&self, text: &mut String) {
        match &self.sampling {
            Some(Sampling::Bins { long_nm, short_nm, .. }) => {
                // The two middle numbers tell Radiance where red, green and blue part; its own defaults where they lie inside.
                let inside = |nm: f64, share: f64| {
                    if nm < *long_nm && nm > *short_nm { nm } else { long_nm + (short_nm - long_nm) * share }
                };
                let (red_green, green_blue) = (inside(588.0, 1.0 / 3.0), inside(480.0, 2.0 / 3.0));
                let _ = writeln!(text, "WAVELENGTH_SPLITS= {long_nm} {red_green} {green_blue} {short_nm}");
            }
            Some(Sampling::Points(nm)) => line_of_numbers(text, "WAVELENGTHS", nm),
            None => {}
        }
        if let Some(rows) = &self.xyz_matrix {
            for (key, row) in ["XYZ_MATRIX_X", "XYZ_MATRIX_Y", "XYZ_MATRIX_Z"].iter().zip(rows) {
                line_of_numbers(text, key, row);
            }
        }
        if let Some(w) = self.white {
            line_of_numbers(text, "WHITE", &[w.x, w.y]);
        }
        if let Some(a) = &self.adapted {
            let _ = writeln!(text, "ADAPTED= {} {} {} {} {} {}", a.from.x, a.from.y, a.to.x, a.to.y, a.cat, a.degree);
        }
        if let Some(d) = self.display {
            line_of_numbers(text, "DISPLAY", &d);
        }
        match (self.components, self.primaries) {
            (Components::Xyz, _) => text.push_str("PRIMARIES= 1 0 0 1 0 0 .333 .333\n"),
            (_, Some(p)) => line_of_numbers(text, "PRIMARIES", &p.numbers()),
            _ => {}
        }
    }
}

fn line_of_numbers(text: &mut String, key: &str, numbers: &[f64]) {
    let _ = write!(text, "{key}=");
    for n in numbers {
        let _ = write!(text, " {n}");
    }
    text.push('\n');
}

/// The raw lines of a header and its resolution line, as read.
#[derive(Debug)]
pub struct RawHeader {
    /// Line number from 1 and the line without its newline; the magic line is left out.
    pub lines: Vec<(usize, Vec<u8>)>,
    /// The line after the empty one; `None` when the header gave NROWS and NCOLS and the pixels follow at once.
    pub resolution: Option<Resolution>,
    /// Bytes read in search of a resolution line that turned out to be pixels.
    pub ahead: Vec<u8>,
}

/// Reads up to the first pixel byte.
pub fn read_raw(input: &mut dyn BufRead) -> Result<RawHeader> {
    let mut lines: Vec<(usize, Vec<u8>)> = Vec::new();
    let (mut total, mut number) = (0, 0);
    let first = input.fill_buf().map_err(|e| Error::io("", e))?;
    match first.first() {
        None => return invalid!("empty input; expected a Radiance header"),
        Some(b) if !(b' '..=b'~').contains(b) => {
            return invalid!("the first byte is 0x{b:02x}; expected a Radiance header such as '#?RADIANCE'");
        }
        Some(_) => {}
    }
    loop {
        number += 1;
        let Some(mut line) = read_line(input, number)? else {
            return invalid!("header ends after {} lines without the empty line that closes it", number - 1);
        };
        total += line.len() + 1;
        if line.ends_with(b"\r") {
            line.pop();
        }
        if line.is_empty() {
            break;
        }
        if total > LONGEST_HEADER {
            return invalid!("header is longer than {LONGEST_HEADER} bytes");
        }
        if !(number == 1 && line.starts_with(b"#?")) {
            lines.push((number, line));
        }
    }
    let states = |key: &[u8]| lines.iter().any(|(_, l)| l.starts_with(key));
    let sized = states(b"NROWS=") && states(b"NCOLS=");
    if sized {
        return Ok(match peek_resolution(input)? {
            Ok(resolution) => RawHeader { lines, resolution: Some(resolution), ahead: Vec::new() },
            Err(ahead) => RawHeader { lines, resolution: None, ahead },
        });
    }
    match read_line(input, number + 1)? {
        Some(line) => {
            let resolution = Some(Resolution::parse(line.strip_suffix(b"\r").unwrap_or(&line))?);
            Ok(RawHeader { lines, resolution, ahead: Vec::new() })
        }
        None => invalid!("input ends after the header; expected a resolution line such as '-Y 480 +X 640'"),
    }
}

/// With NROWS and NCOLS given a resolution line may still follow. Bytes are taken as long as they could be one; pixels that
/// were taken so come back.
fn peek_resolution(input: &mut dyn BufRead) -> Result<Result<Resolution, Vec<u8>>> {
    let mut taken = Vec::new();
    loop {
        let Some(byte) = input.fill_buf().map_err(|e| Error::io("", e))?.first().copied() else {
            return Ok(Err(taken));
        };
        if byte == b'\n' {
            return Ok(match Resolution::parse(&taken) {
                Ok(resolution) => {
                    input.consume(1);
                    Ok(resolution)
                }
                Err(_) => Err(taken),
            });
        }
        let fits = match taken.len() {
            0 => b"+-".contains(&byte),
            1 => b"XY".contains(&byte),
            2..=63 => byte == b' ' || byte.is_ascii_digit() || b"+-XY\r".contains(&byte),
            _ => false,
        };
        if !fits {
            return Ok(Err(taken));
        }
        taken.push(byte);
        input.consume(1);
    }
}

/// A line without its newline; `None` at the end of input before one.
fn read_line(input: &mut dyn BufRead, number: usize) -> Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    loop {
        let buffer = input.fill_buf().map_err(|e| Error::io("", e))?;
        if buffer.is_empty() {
            return Ok(None);
        }
        let end = buffer.iter().position(|b| *b == b'\n');
        let take = end.unwrap_or(buffer.len());
        if line.len() + take > LONGEST_LINE {
            return invalid!("header line {number} is longer than {LONGEST_LINE} bytes");
        }
        line.extend_from_slice(&buffer[..take]);
        input.consume(take + usize::from(end.is_some()));
        if end.is_some() {
            return Ok(Some(line));
        }
    }
}
