//! ICC profiles of displays: three colorants and their curves, written as version 4 and read as version 2 or 4
//! [ICC.1:2010].
//!
//! A profile speaks of D50: colorants are adapted by Bradford's matrix, which the `chad` tag holds, and read back
//! through it. A table in `curv` has 16 bits of light, too few for dark codes: a private tag `lxtc` repeats it in
//! doubles.

use crate::color::adapt::von_kries;
use crate::color::rgb::NAMED;
use crate::color::{Cat, Mat3, Primaries, Xy};
use crate::display::Transfer;
use crate::display::transfer::srgb_decode;

/// White of the profile connection space.
const D50: [f64; 3] = [0.9642, 1.0, 0.8249];
/// Steps of a s15Fixed16Number.
const FIXED: f64 = 65536.0;
/// The sRGB curve as a parametric curve of kind 3: g, a, b, c, d.
const SRGB: [f64; 5] = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.040_45];
/// Chromaticities this close are the same but for rounding.
pub const SAME: f64 = 1e-3;

/// What a profile says.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Primaries and media white.
    pub primaries: Primaries,
    /// Codes to light, red, green and blue.
    pub curves: [Curve; 3],
}

/// One channel's way from code to light, both 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// IEC 61966-2-1.
    Srgb,
    /// A plain power.
    Gamma(f64),
    /// ICC's parametric kinds 1 to 4, brought to the form of 4: (a x + b)^g + e from d, c x + f below.
    Parametric([f64; 7]),
    /// Light at evenly spaced codes.
    Table(Vec<f64>),
}

impl Curve {
    /// The light of a code.
    pub fn light(&self, code: f64) -> f64 {
        match self {
            Curve::Srgb => srgb_decode(code),
            Curve::Gamma(g) => code.powf(*g),
            Curve::Parametric([g, a, b, c, d, e, f]) => {
                if code >= *d {
                    (a * code + b).max(0.0).powf(*g) + e
                } else {
                    c * code + f
                }
            }
            Curve::Table(light) => {
                let at = code * (light.len() - 1) as f64;
                let below = (at as usize).min(light.len() - 2);
                light[below] + (light[below + 1] - light[below]) * (at - below as f64)
            }
        }
    }
}

/// The profile of a display; `None` for PQ and HLG, and for colours that cannot be adapted to D50.
pub fn profile(primaries: &Primaries, transfer: &Transfer) -> Option<Vec<u8>> {
    let (curve, exact) = curve_tags(transfer)?;
    let adapt = von_kries(Cat::Bradford, primaries.white, Xy::of(D50)?, 1.0).ok()?;
    let colorants = adapt.times(&primaries.to_xyz()?);
    let column = |i: usize| [0, 1, 2].map(|row| fixed(colorants.0[row][i]));
    let (red, blue, white) = (column(0), column(2), D50.map(fixed));
    let green = [0, 1, 2].map(|i| white[i] - red[i] - blue[i]); // so that white is white to the last bit
    if red.iter().chain(&green).chain(&blue).any(|x| x.unsigned_abs() > 16 << 16) {
        return None; // imaginary primaries near a line
    }
    let xyz = |v: [i32; 3]| numbers(b"XYZ ", &v);
    let curve_name = match transfer {
        Transfer::Srgb => "sRGB curve".to_string(),
        Transfer::Gamma(g) => format!("gamma {g}"),
        _ => "table".to_string(),
    };
    let mut tags = vec![
        (b"desc", text(&format!("{primaries}, {curve_name}"))),
        (b"cprt", text("No copyright, use freely")),
        (b"wtpt", xyz(white)),
        (b"chad", numbers(b"sf32", &adapt.0.as_flattened().iter().map(|x| fixed(*x)).collect::<Vec<_>>())),
        (b"rXYZ", xyz(red)),
        (b"gXYZ", xyz(green)),
        (b"bXYZ", xyz(blue)),
        (b"rTRC", curve.clone()),
        (b"gTRC", curve.clone()),
        (b"bTRC", curve),
    ];
    tags.extend(exact.map(|e| (b"lxtc", e)));
    Some(assemble(&tags))
}

/// The curve as ICC has it, and in doubles where that is too coarse.
fn curve_tags(transfer: &Transfer) -> Option<(Vec<u8>, Option<Vec<u8>>)> {
    let parametric = |kind: u8, p: &[f64]| {
        let mut tag = b"para\0\0\0\0\0".to_vec();
        tag.extend([kind, 0, 0]);
        tag.extend(p.iter().flat_map(|x| fixed(*x).to_be_bytes()));
        tag
    };
    match transfer {
        Transfer::Srgb => Some((parametric(3, &SRGB), None)),
        Transfer::Gamma(g) => Some((parametric(0, &[*g]), None)),
        Transfer::Table(light) => {
            let mut tag = b"curv\0\0\0\0".to_vec();
            tag.extend(u32::try_from(light.len()).ok()?.to_be_bytes());
            tag.extend(light.iter().flat_map(|x| ((x * 65535.0).round() as u16).to_be_bytes()));
            let mut exact = b"fl64\0\0\0\0".to_vec();
            exact.extend(light.iter().flat_map(|x| x.to_be_bytes()));
            Some((tag, Some(exact)))
        }
        Transfer::Pq | Transfer::Hlg => None,
    }
}

fn fixed(x: f64) -> i32 {
    (x * FIXED).round() as i32
}

fn numbers(kind: &[u8; 4], values: &[i32]) -> Vec<u8> {
    let mut tag = kind.to_vec();
    tag.extend([0; 4]);
    tag.extend(values.iter().flat_map(|x| x.to_be_bytes()));
    tag
}

/// A multiLocalizedUnicodeType of one language.
fn text(s: &str) -> Vec<u8> {
    let utf16: Vec<u8> = s.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mut tag = b"mluc\0\0\0\0\0\0\0\x01\0\0\0\x0cenUS".to_vec();
    tag.extend((utf16.len() as u32).to_be_bytes());
    tag.extend(28u32.to_be_bytes());
    tag.extend(utf16);
    tag
}

/// Header, tag table and tags; equal tags are stored once.
fn assemble(tags: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut data: Vec<u8> = Vec::new();
    let mut table = (tags.len() as u32).to_be_bytes().to_vec();
    let first = 128 + 4 + 12 * tags.len();
    let mut stored: Vec<(&[u8], usize)> = Vec::new();
    for (name, tag) in tags {
        let at = stored.iter().find(|s| s.0 == tag).map_or(data.len(), |s| s.1);
        if at == data.len() {
            stored.push((tag, at));
            data.extend(tag);
            data.resize(data.len().next_multiple_of(4), 0);
        }
        table.extend(*name);
        table.extend(((first + at) as u32).to_be_bytes());
        table.extend((tag.len() as u32).to_be_bytes());
    }
    let mut out = ((first + data.len()) as u32).to_be_bytes().to_vec();
    out.extend(b"\0\0\0\0\x04\x30\0\0mntrRGB XYZ ");
    out.extend([2001u16, 11, 6, 0, 0, 0].iter().flat_map(|x| x.to_be_bytes())); // no clock: equal work, equal bytes
    out.extend(b"acsp");
    out.resize(64, 0);
    out.extend([0, 0, 0, 1]); // relative colorimetric
    out.extend(D50.iter().flat_map(|x| fixed(*x).to_be_bytes()));
    out.resize(128, 0);
    out.extend(table);
    out.extend(data);
    out
}

/// Reads a profile of three colorants and curves; the error says what it is instead.
pub fn read(bytes: &[u8]) -> Result<Profile, &'static str> {
    if bytes.get(36..40) != Some(b"acsp") {
        return Err("is none");
    }
    if bytes.get(16..24) != Some(b"RGB XYZ ") {
        return Err("is not of RGB light");
    }
    let colorant = |name| xyz(tag(bytes, name)?);
    let (Some(r), Some(g), Some(b)) = (colorant(b"rXYZ"), colorant(b"gXYZ"), colorant(b"bXYZ")) else {
        return Err("has no colorants");
    };
    let from_d50 = unadapt(bytes).ok_or("has an impossible white")?;
    // Not `Xy::of`: the blue of ACES AP0 has a luminance below 0.
    let xy = |v| {
        let [x, y, z] = from_d50.apply(v);
        let sum = x + y + z;
        (sum > 0.0).then(|| Xy { x: x / sum, y: y / sum })
    };
    let white = [0, 1, 2].map(|i| r[i] + g[i] + b[i]);
    let all: Option<Vec<Xy>> = [r, g, b, white].into_iter().map(xy).collect();
    let primaries = all.and_then(|p| Primaries::from_numbers(&p.iter().flat_map(|p| [p.x, p.y]).collect::<Vec<_>>()));
    let primaries = primaries.ok_or("has impossible colorants")?;
    let named = NAMED.iter().map(|n| n.1).find(|n| n.distance(&primaries) < SAME);
    let curve = |name| curve(tag(bytes, name)?);
    let (Some(r), Some(g), Some(b)) = (curve(b"rTRC"), curve(b"gTRC"), curve(b"bTRC")) else {
        return Err("has no plain curves");
    };
    let exact = tag(bytes, b"lxtc").and_then(|t| t.strip_prefix(b"fl64\0\0\0\0")).map(doubles);
    let curves = [r, g, b].map(|c| exact.as_ref().filter(|e| rounds_to(e, &c)).map_or(c, |e| Curve::Table(e.clone())));
    let sane = |c: &Curve| (0..=256).all(|i| (-0.5..=1.5).contains(&c.light(f64::from(i) / 256.0)));
    if !curves.iter().all(sane) {
        return Err("has curves beyond 0 to 1");
    }
    Ok(Profile { primaries: named.unwrap_or(primaries), curves })
}

/// The content of a tag.
fn tag<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let count = u32_at(bytes, 128)?.min(1000) as usize;
    let entry = bytes.get(132..)?.chunks_exact(12).take(count).find(|e| e.starts_with(name))?;
    let (at, size) = (u32_at(entry, 4)? as usize, u32_at(entry, 8)? as usize);
    bytes.get(at..at.checked_add(size)?)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn fixed_at(bytes: &[u8], at: usize) -> Option<f64> {
    u32_at(bytes, at).map(|x| f64::from(x as i32) / FIXED)
}

fn xyz(tag: &[u8]) -> Option<[f64; 3]> {
    tag.starts_with(b"XYZ ").then_some(())?;
    Some([fixed_at(tag, 8)?, fixed_at(tag, 12)?, fixed_at(tag, 16)?])
}

/// D50 to the media white: through `chad`, or by Bradford to the white that profiles of version 2 state.
fn unadapt(bytes: &[u8]) -> Option<Mat3> {
    if let Some(chad) = tag(bytes, b"chad").filter(|t| t.starts_with(b"sf32")) {
        let mut m = [[0.0; 3]; 3];
        for (i, x) in m.as_flattened_mut().iter_mut().enumerate() {
            *x = fixed_at(chad, 8 + 4 * i)?;
        }
        return Mat3(m).inverse();
    }
    let white = Xy::of(xyz(tag(bytes, b"wtpt")?)?)?;
    von_kries(Cat::Bradford, Xy::of(D50)?, white, 1.0).ok()
}

fn curve(tag: &[u8]) -> Option<Curve> {
    match tag.get(..4)? {
        b"curv" => {
            let count = u32_at(tag, 8)? as usize;
            let values = tag.get(12..12usize.checked_add(count.checked_mul(2)?)?)?;
            let values: Vec<f64> =
                values.chunks_exact(2).map(|b| f64::from(u16::from_be_bytes([b[0], b[1]]))).collect();
            Some(match values[..] {
                [] => Curve::Gamma(1.0),
                [g] => Curve::Gamma(g / 256.0),
                _ => Curve::Table(values.iter().map(|x| x / 65535.0).collect()),
            })
        }
        b"para" => {
            let kind = tag.get(8..10)?;
            let p = |i: usize| fixed_at(tag, 12 + 4 * i);
            let g = p(0)?;
            Some(match kind {
                [0, 0] => {
                    // What people write has few digits, which 1/65536 does not hold.
                    let written = (g * 1e4).round() / 1e4;
                    Curve::Gamma(if (g - written).abs() < 0.6 / FIXED { written } else { g })
                }
                [0, 1] => Curve::Parametric([g, p(1)?, p(2)?, 0.0, -p(2)? / p(1)?, 0.0, 0.0]),
                [0, 2] => Curve::Parametric([g, p(1)?, p(2)?, 0.0, -p(2)? / p(1)?, p(3)?, p(3)?]),
                [0, 3] => {
                    let all = [g, p(1)?, p(2)?, p(3)?, p(4)?];
                    let srgb = all.iter().zip(SRGB).all(|(a, b)| (a - b).abs() < 1e-4);
                    let [g, a, b, c, d] = all;
                    if srgb { Curve::Srgb } else { Curve::Parametric([g, a, b, c, d, 0.0, 0.0]) }
                }
                [0, 4] => Curve::Parametric([g, p(1)?, p(2)?, p(3)?, p(4)?, p(5)?, p(6)?]),
                _ => return None,
            })
        }
        _ => None,
    }
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks().0.iter().map(|b| f64::from_be_bytes(*b)).collect()
}

/// True when the table of 16 bits is this one, rounded: whoever changed the one did not forget the other.
fn rounds_to(exact: &[f64], curve: &Curve) -> bool {
    let Curve::Table(coarse) = curve else { return false };
    coarse.len() == exact.len() && coarse.iter().zip(exact).all(|(c, e)| (c - e).abs() <= 0.6 / 65535.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colorants of Display P3 at D50: Apple's "Display P3" profile has them.
    #[test]
    fn colorants_are_those_of_a_published_profile() {
        let p3: Primaries = "P3".parse().unwrap();
        let bytes = profile(&p3, &Transfer::Srgb).unwrap();
        for (name, want) in [
            (b"rXYZ", [0.51512, 0.24120, -0.00105]),
            (b"gXYZ", [0.29198, 0.69225, 0.04189]),
            (b"bXYZ", [0.15710, 0.06657, 0.78407]),
        ] {
            let got = xyz(tag(&bytes, name).unwrap()).unwrap();
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1.2e-4), "{got:?} {want:?}");
        }
    }

    /// Lab at D50 of codes as LittleCMS 2.19 has them from profiles written here: what another reader sees is what we
    /// mean.
    #[test]
    fn another_reader_sees_these_colours() {
        let codes =
            [[255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128], [200, 50, 120], [1, 2, 3]];
        let crt = [
            [100.0, 0.0, 0.0],
            [54.205, 75.296, 70.088],
            [87.157, -73.861, 81.818],
            [32.928, 60.8, -106.769],
            [53.976, 0.0, 0.0],
            [47.458, 59.274, -3.303],
            [0.02, -0.004, -0.048],
        ];
        let print = [
            [100.0, 0.0, 0.0],
            [59.94, 77.06, 47.68],
            [83.05, -81.882, 47.665],
            [37.273, 31.413, -85.276],
            [53.585, 0.0, 0.0],
            [51.849, 57.47, 4.146],
            [0.498, -0.24, -0.381],
        ];
        let p3 = [
            [100.0, 0.0, 0.0],
            [56.207, 94.473, 98.897],
            [86.614, -106.542, 102.861],
            [31.014, 70.447, -115.586],
            [53.585, 0.0, 0.0],
            [48.747, 72.891, -1.168],
            [0.5, -0.232, -0.532],
        ];
        let f = |t: f64| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
        for (name, want) in [("crt", crt), ("print", print), ("p3", p3)] {
            let display: crate::display::Display = name.parse().unwrap();
            let bytes = profile(&display.primaries, &display.transfer).unwrap();
            let columns = [b"rXYZ", b"gXYZ", b"bXYZ"].map(|n| xyz(tag(&bytes, n).unwrap()).unwrap());
            let curve = &read(&bytes).unwrap().curves[0];
            for (code, want) in codes.iter().zip(want) {
                let light = code.map(|c| curve.light(f64::from(c) / 255.0));
                let [x, y, z] = [0, 1, 2].map(|i| f((0..3).map(|k| columns[k][i] * light[k]).sum::<f64>() / D50[i]));
                let lab = [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)];
                assert!(lab.iter().zip(want).all(|(a, b)| (a - b).abs() < 0.02), "{name} {code:?}: {lab:?} {want:?}");
            }
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let table = Transfer::Table((0..=64).map(|i| (f64::from(i) / 64.0).powf(2.6)).collect());
        let odd: Primaries = "0.60,0.33,0.28,0.55,0.17,0.12,0.3457,0.3585".parse().unwrap();
        for primaries in NAMED.iter().map(|n| n.1).filter(|p| !p.is_xyz()).chain([odd]) {
            for transfer in [Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(1.0), table.clone()] {
                let Some(bytes) = profile(&primaries, &transfer) else { panic!("{primaries}") };
                assert_eq!(bytes.len(), u32_at(&bytes, 0).unwrap() as usize);
                let back = read(&bytes).unwrap();
                assert!(back.primaries.distance(&primaries) < 3e-4, "{primaries}: {}", back.primaries);
                for i in 0..=1000 {
                    let x = f64::from(i) / 1000.0;
                    let want = transfer.light([x; 3], (0.0, 1.0), [0.0; 3])[0];
                    assert!((back.curves[1].light(x) - want).abs() < 5e-6, "{transfer:?} {x}");
                }
            }
        }
        assert!(profile(&odd, &Transfer::Pq).is_none());
    }

    #[test]
    fn no_bytes_panic() {
        let good = profile(&Primaries::BT709, &Transfer::Gamma(2.2)).unwrap();
        for end in 0..good.len() {
            let _ = read(&good[..end]);
        }
        for at in 0..good.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut bad = good.clone();
                bad[at] = value;
                let _ = read(&bad);
            }
        }
    }
}
