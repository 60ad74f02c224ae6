//! A picture as reflectance: any file that the filters read, as linear sRGB.
//!
//! Numbers are taken as they stand: 1 reflects everything. PNG is decoded by the curve it states, sRGB where it states none;
//! of RGBE what Radiance reads counts (EXPOSURE undone), of floats the numbers themselves, whatever their unit. Other
//! primaries are turned into sRGB's, their white into its white by the Bradford matrix, so that what is white stays so.
//! Luminance alone is grey. Values outside 0 to 1 are refused, their pixel named.
//!
//! Between the middles of pixels values are interpolated along u and v.

use std::path::Path;

use serde::Deserialize;

use crate::codec::{self, FORMATS, Reading};
use crate::color::adapt::von_kries;
use crate::color::{Cat, Mat3, Primaries, Xy};
use crate::keys::Keys;
use crate::notes::Notes;
use crate::stream::meaning::Overrides;
use crate::stream::reader::Input;
use crate::stream::spool::Limits;
use crate::stream::upright::upright;
use crate::stream::{Block, Components, Header, Units};
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, invalid};

/// Pixels of a texture, 12 bytes each.
const MOST_PIXELS: usize = 1 << 26;
/// Values this far outside 0 to 1 are rounding.
const ROUNDING: f32 = 1e-4;
/// Bytes in which a Radiance header says its format.
const HEADER: usize = 64 << 10;

/// What lies beyond the picture's edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrap {
    /// The same again.
    #[default]
    Repeat,
    /// Its outermost pixels.
    Clamp,
    /// The same, every other time mirrored.
    Mirror,
}

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    /// Linear sRGB, 0..1, rows from the top.
    pixels: Vec<[f32; 3]>,
    /// What lies beyond.
    pub wrap: Wrap,
}

impl Picture {
    /// Takes `file` and `wrap`.
    pub(super) fn read(k: &mut Keys, folder: &Path) -> Result<Picture> {
        let Some((file, span)) = k.get_spanned::<String>("file")? else {
            return Err(k.wrong("key 'file' is missing"));
        };
        let wrap = k.get::<Wrap>("wrap")?.unwrap_or_default();
        Picture::load(&folder.join(file), wrap, k.notes()).map_err(|e| k.wrong_key("file", span, &e.to_string()))
    }

    /// Reads a file.
    pub fn load(path: &Path, wrap: Wrap, notes: &Notes) -> Result<Picture> {
        let mut input = Input::open(Some(path))?;
        let name = input.name.clone();
        let first = input.peek(HEADER)?;
        let factor = if is_rgbe(&first) { (1.0 / RADIANCE_EFFICACY) as f32 } else { 1.0 };
        let overrides = Overrides { units: Some(Units::Relative), ..Overrides::default() };
        let limits = Limits { memory: 24 * MOST_PIXELS as u64, folder: std::env::temp_dir() };
        let picture = codec::open(input, &Reading { overrides: &overrides, limits: &limits, notes })?;
        let header = picture.header();
        let (width, height) = (header.resolution.width, header.resolution.height);
        if width.saturating_mul(height) > MOST_PIXELS {
            return invalid!("{name}: {width} x {height} pixels; a texture has at most {MOST_PIXELS}");
        }
        let matrix = to_srgb(header).map_err(|e| e.within(&name))?;
        let ncomp = header.ncomp;
        let mut picture = upright(picture, &limits)?;
        let mut pixels = Vec::new();
        let mut block = Block::default();
        while picture.next(&mut block)? {
            for pixel in block.data.chunks_exact(ncomp) {
                let rgb = [pixel[0], pixel[ncomp / 2], pixel[ncomp - 1]].map(|x| x * factor);
                let rgb = match &matrix {
                    Some(m) => m.apply(rgb.map(f64::from)).map(|x| x as f32),
                    None => rgb,
                };
                if !rgb.iter().all(|x| (-ROUNDING..=1.0 + ROUNDING).contains(x)) {
                    let (x, y) = (pixels.len() % width + 1, pixels.len() / width + 1);
                    let [r, g, b] = rgb;
                    return invalid!("{name}: pixel {x} of row {y} is {r} {g} {b} in sRGB; it must lie in 0 to 1");
                }
                pixels.push(rgb.map(|x| x.clamp(0.0, 1.0)));
            }
        }
        Ok(Picture { width, height, pixels, wrap })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The value at texture coordinates.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f32; 3] {
        let (x, y) = (self.taps(u, self.width), self.taps(1.0 - v, self.height));
        let row = |y: usize| -> [f32; 3] {
            let (a, b) = (self.pixels[y * self.width + x.0], self.pixels[y * self.width + x.1]);
            [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * x.2)
        };
        let (a, b) = (row(y.0), row(y.1));
        [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * y.2)
    }

    /// The two pixels on either side of a coordinate, of `n` in 0 to 1, and the share of the second.
    fn taps(&self, t: f64, n: usize) -> (usize, usize, f32) {
        let t = match self.wrap {
            Wrap::Repeat => t.rem_euclid(1.0),
            Wrap::Clamp => t.clamp(0.0, 1.0),
            Wrap::Mirror => t.rem_euclid(2.0),
        };
        let x = t * n as f64 - 0.5;
        let low = x.floor();
        let index = |i: i64| {
            let n = n as i64;
            let i = match self.wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::Clamp => i.clamp(0, n - 1),
                Wrap::Mirror => {
                    let i = i.rem_euclid(2 * n);
                    i.min(2 * n - 1 - i)
                }
            };
            i as usize
        };
        (index(low as i64), index(low as i64 + 1), (x - low) as f32)
    }
}

/// True for Radiance's RGBE, whose numbers come as 179 lm/W.
fn is_rgbe(first: &[u8]) -> bool {
    let header = first.windows(2).position(|w| w == b"\n\n").map_or(first, |end| &first[..end]);
    let lines = || header.split(|b| *b == b'\n');
    let format = lines().rev().find_map(|l| l.strip_prefix(b"FORMAT=")).map(<[u8]>::trim_ascii);
    !FORMATS.iter().any(|f| (f.is)(first)) && format == Some(b"32-bit_rle_rgbe")
}

/// What turns a picture's numbers into linear sRGB; `None` where they are that, or grey.
fn to_srgb(header: &Header) -> Result<Option<Mat3>> {
    let target = Primaries::BT709;
    let (to_xyz, white) = match header.components {
        Components::Y => return Ok(None),
        Components::Rgb => {
            let primaries = header.primaries.unwrap_or(target);
            if primaries.distance(&target) < 1e-4 {
                return Ok(None);
            }
            (primaries.to_xyz(), primaries.white)
        }
        Components::Xyz => (Some(Mat3::IDENTITY), header.white.unwrap_or(Xy::D65)),
        other => return Err(Error::Unsupported(format!("a texture of {other}; expected RGB, XYZ or Y"))),
    };
    let adapted = von_kries(Cat::Bradford, white, target.white, 1.0)?;
    let matrix = target.from_xyz().zip(to_xyz).map(|(from, to)| from.times(&adapted).times(&to));
    matrix.map(Some).ok_or_else(|| Error::Invalid("its primaries span no colours".into()))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;

    fn picture(width: usize, values: &[f32], wrap: Wrap) -> Picture {
        let pixels: Vec<[f32; 3]> = values.iter().map(|x| [*x; 3]).collect();
        Picture { width, height: pixels.len() / width, pixels, wrap }
    }

    #[test]
    fn middles_edges_and_what_lies_beyond() {
        // Rows from the top: 0.1 0.2 / 0.3 0.4.
        let of = |wrap| picture(2, &[0.1, 0.2, 0.3, 0.4], wrap);
        let check = |wrap, uv: [f64; 2], value: f32| {
            let got = of(wrap).at(uv)[0];
            assert!((got - value).abs() < 1e-6, "{wrap:?} {uv:?}: {got}, not {value}");
        };
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            check(wrap, [0.25, 0.75], 0.1);
            check(wrap, [0.75, 0.75], 0.2);
            check(wrap, [0.25, 0.25], 0.3);
            check(wrap, [0.5, 0.5], 0.25);
            check(wrap, [0.375, 0.25], 0.325);
        }
        check(Wrap::Repeat, [0.0, 0.25], 0.35);
        check(Wrap::Repeat, [-3.75, 7.25], 0.3);
        check(Wrap::Clamp, [0.0, 0.25], 0.3);
        check(Wrap::Clamp, [9.0, -9.0], 0.4);
        check(Wrap::Mirror, [1.25, 0.25], 0.4);
        check(Wrap::Mirror, [1.0, 0.25], 0.4);
        check(Wrap::Mirror, [-0.25, 0.25], 0.3);
        check(Wrap::Mirror, [2.25, 0.75], 0.1);
        for wild in [1e300, -1e300, f64::NAN, f64::INFINITY, -1e-300] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                of(wrap).at([wild, wild]);
            }
        }
    }

    fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn png(width: u32, kind: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, width, 1);
        encoder.set_color(kind);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        out
    }

    fn pixels(name: &str, bytes: &[u8]) -> Result<Vec<[f32; 3]>> {
        let (_folder, path) = written(name, bytes);
        Picture::load(&path, Wrap::Repeat, &Notes::default()).map(|p| p.pixels)
    }

    fn near(got: &[[f32; 3]], wanted: &[[f32; 3]], by: f32) {
        assert_eq!(got.len(), wanted.len());
        for (g, w) in got.iter().zip(wanted) {
            assert!((0..3).all(|k| (g[k] - w[k]).abs() <= by), "{g:?}, not {w:?}");
        }
    }

    /// IEC 61966-2-1 by hand: code 128 of 255 is 0.215861, 10 is 10 / 255 / 12.92 = 0.003035, half of 16 bits is 0.214046.
    #[test]
    fn png_codes_become_light() {
        use png::{BitDepth, ColorType};
        let rgb = png(2, ColorType::Rgb, BitDepth::Eight, &[255, 128, 0, 10, 10, 10]);
        near(&pixels("a.png", &rgb).unwrap(), &[[1.0, 0.215_861, 0.0], [0.003_035; 3]], 1e-6);
        let rgba = png(1, ColorType::Rgba, BitDepth::Eight, &[128, 0, 255, 7]);
        near(&pixels("a.png", &rgba).unwrap(), &[[0.215_861, 0.0, 1.0]], 1e-6);
        let grey = png(2, ColorType::Grayscale, BitDepth::Sixteen, &[0x80, 0, 0xff, 0xff]);
        near(&pixels("a.png", &grey).unwrap(), &[[0.214_046; 3], [1.0; 3]], 1e-5);
    }

    #[test]
    fn floats_and_rgbe_are_taken_as_they_stand() {
        let floats = |v: &[f32]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        // PFM's rows begin at the bottom.
        let rgb = [b"PF\n1 2\n-1\n".to_vec(), floats(&[0.25, 0.5, 1.0, 0.0, 0.125, 0.75])].concat();
        near(&pixels("a.pfm", &rgb).unwrap(), &[[0.0, 0.125, 0.75], [0.25, 0.5, 1.0]], 0.0);
        let grey = [b"Pf\n2 1\n-1\n".to_vec(), floats(&[0.25, 1.0])].concat();
        near(&pixels("a.pfm", &grey).unwrap(), &[[0.25; 3], [1.0; 3]], 0.0);
        // Mantissas of Radiance stand for (m + 0.5) / 256 x 2^(e - 128); its white, of equal energy, stays white.
        let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        let rgbe = [head, vec![128, 128, 128, 128, 128, 128, 128, 127]].concat();
        near(&pixels("a.hdr", &rgbe).unwrap(), &[[0.501_953; 3], [0.250_977; 3]], 1e-5);
        let xyz = b"#?RADIANCE\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nFORMAT=float\n\n-Y 1 +X 1\n".to_vec();
        let stream = [xyz, floats(&[0.5 * 0.950_456, 0.5, 0.5 * 1.089_058])].concat();
        near(&pixels("a.lux", &stream).unwrap(), &[[0.5; 3]], 1e-5);
    }

    #[test]
    fn what_no_surface_reflects_is_refused_with_its_pixel() {
        let floats = |v: [f32; 6]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        for wrong in [1.5, -0.2, f32::NAN, f32::INFINITY] {
            let file = [b"PF\n2 1\n-1\n".to_vec(), floats([0.0, 0.0, 0.0, 0.5, wrong, 0.5])].concat();
            let message = pixels("a.pfm", &file).unwrap_err().to_string();
            assert!(message.contains("pixel 2 of row 1 is 0.5") && message.contains("0 to 1"), "{message}");
        }
        let whole = png(1, png::ColorType::Rgb, png::BitDepth::Eight, &[1, 2, 3]);
        for cut in 0..whole.len() - 12 {
            assert!(pixels("a.png", &whole[..cut]).is_err(), "cut at {cut}");
        }
        let spectrum = b"#?RADIANCE\nNCOMP=4\nCOMPONENTS=SPECTRUM\nWAVELENGTH_SPLITS= 780 588 480 380\nUNITS=W/sr/m2/nm\nFORMAT=float\n\n-Y 1 +X 1\n".to_vec();
        assert!(pixels("a.lux", &[spectrum, vec![0; 16]].concat()).is_err());
        let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n";
        assert!(pixels("a.hdr", huge).unwrap_err().to_string().contains("at most"));
    }
}
