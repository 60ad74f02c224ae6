//! How much each exposure let in: from EXIF, from lists of numbers, or from pfstools' list of a bracket.
//!
//! A shot of t seconds at the f-number N and speed S gathers q = t S / N^2. By the standard output sensitivity [ISO 12232] the code for
//! 18 % grey, sRGB's 118, stands for an exposure of 10 / S lx s at the sensor, which is 0.65 L t / N^2 of a luminance L, so a
//! linear value x (1 for white) stands for L = K x / q with K = 10 / (0.65 x 0.18) = 85.5 cd/m2: nominal, and within a stop or so of
//! what a meter reads. Without N and S, q = t.
//!
//! The reader of EXIF is our own: three tags of two directories, from bytes in memory, with nothing trusted; a crate would bring
//! a parser of every tag there is.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::error::printable;
use crate::{Error, Result, invalid, string_serde};

/// cd/m2 of a linear value of 1 for t S / N^2 = 1 [ISO 12232].
pub const NOMINAL_CD_M2: f64 = 10.0 / (0.65 * 0.18);

/// What a camera, or a list, says of a shot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Exposure time, s.
    pub seconds: Option<f64>,
    /// Focal length over the diameter of the pupil.
    pub f_number: Option<f64>,
    /// ISO speed, arithmetic.
    pub iso: Option<f64>,
    /// Optical density of a neutral filter.
    pub density: f64,
    /// How to turn it upright, TIFF's 1 to 8; 0 is not stated.
    pub orientation: u8,
}

/// Numbers above 0, fractions allowed: `1/30,1/8,0.5,2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Amounts(pub Vec<f64>);

impl FromStr for Amounts {
    type Err = Error;
    fn from_str(s: &str) -> Result<Amounts> {
        let number = |t: &str| match t.trim().split_once('/') {
            Some((a, b)) => Some(a.parse::<f64>().ok()? / b.parse::<f64>().ok()?),
            None => t.trim().parse().ok(),
        };
        let all: Option<Vec<f64>> =
            s.split(',').map(|t| number(t).filter(|x| *x > 0.0 && (1e-9..1e9).contains(x))).collect();
        all.map(Amounts).ok_or_else(|| {
            Error::Invalid(format!(
                "'{}' is no list; give numbers above 0 with commas, such as 1/250,1/60,1/15",
                printable(s.as_bytes())
            ))
        })
    }
}

impl fmt::Display for Amounts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // As people write it, where that is the same number.
        let part = |x: &f64| Some(x.recip().round()).filter(|n| *n > 1.0 && 1.0 / n == *x);
        let words = self.0.iter().map(|x| part(x).map_or(x.to_string(), |n| format!("1/{n}")));
        f.write_str(&words.collect::<Vec<_>>().join(","))
    }
}
string_serde!(Amounts);

/// Puts numbers of a list into the shots: one for each, or one for all where `one_for_all`.
pub fn state(
    list: Option<&Amounts>,
    option: &str,
    one_for_all: bool,
    all: &mut [Settings],
    set: impl Fn(&mut Settings, f64),
) -> Result<()> {
    let Some(Amounts(numbers)) = list else { return Ok(()) };
    let (given, shots) = (numbers.len(), all.len());
    if given != shots && !(one_for_all && given == 1) {
        return Err(Error::Usage(format!("{option} has {given} numbers for {shots} exposures; expected one for each")));
    }
    all.iter_mut().enumerate().for_each(|(i, s)| set(s, numbers[i.min(given - 1)]));
    Ok(())
}

/// What was let in by each shot, and whether values over it are nominal cd/m2.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposures {
    /// Linear values divided by these are proportional to luminance.
    pub amounts: Vec<f64>,
    /// f-numbers and speeds are known, so that value / amount is nominally in cd/m2.
    pub nominal: bool,
}

/// Amounts of exposure of shots by name. Fails on a shot without a time, and where some have an f-number or a speed and others not.
pub fn exposures(shots: &[(&str, Settings)]) -> Result<Exposures> {
    for (name, s) in shots {
        if s.seconds.is_none() {
            return invalid!(
                "{name}: no exposure time in its EXIF; expected one, or --times with one for each exposure"
            );
        }
    }
    let known = |what: &str, option: &str, get: fn(&Settings) -> Option<f64>| {
        let with = shots.iter().find(|(_, s)| get(s).is_some());
        match (with, shots.iter().find(|(_, s)| get(s).is_none())) {
            (Some((a, _)), Some((b, _))) => {
                invalid!("{b}: no {what} in its EXIF, and {a} has one; expected all or none, or {option}")
            }
            (with, _) => Ok(with.is_some()),
        }
    };
    let stop = known("f-number", "--aperture", |s| s.f_number)?;
    let iso = known("ISO speed", "--iso", |s| s.iso)?;
    let nominal = stop && iso;
    let amount = |s: &Settings| {
        let light = s.seconds.unwrap_or(1.0) / s.f_number.unwrap_or(1.0).powi(2) * 10f64.powf(-s.density);
        // What all share is left out where it does not lead to cd/m2.
        if nominal { light * s.iso.unwrap_or(100.0) / NOMINAL_CD_M2 } else { light * s.iso.unwrap_or(100.0) / 100.0 }
    };
    Ok(Exposures { amounts: shots.iter().map(|(_, s)| amount(s)).collect(), nominal })
}

/// A bracket as `jpeg2hdrgen` of pfstools lists it: a line a shot of file, 1 / seconds, f-number, ISO speed and density of a neutral
/// filter, the last three optional. Files are named relative to `folder`.
pub fn hdrgen_list(text: &str, folder: &Path) -> Result<Vec<(PathBuf, Settings)>> {
    let mut shots = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')) {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        let numbers: Option<Vec<f64>> = words.map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let numbers = numbers.unwrap_or_default();
        if !(1..=4).contains(&numbers.len()) || numbers[0] <= 0.0 || numbers.iter().any(|x| *x < 0.0) {
            return invalid!(
                "line {}: expected a file, 1 / seconds, and if you like f-number, ISO speed and density",
                i + 1
            );
        }
        let above = |k: usize| numbers.get(k).copied().filter(|x| *x > 0.0);
        let settings = Settings {
            seconds: Some(1.0 / numbers[0]),
            f_number: above(1),
            iso: above(2),
            density: above(3).unwrap_or(0.0),
            orientation: 0,
        };
        shots.push((folder.join(name), settings));
    }
    if shots.is_empty() {
        return invalid!("names no exposures; expected a line a shot, as jpeg2hdrgen prints");
    }
    Ok(shots)
}

/// Reads what EXIF says, `bytes` beginning with its TIFF header. What is damaged or absent is not stated.
pub fn exif(bytes: &[u8]) -> Settings {
    let mut settings = Settings::default();
    let Some(tiff) = Tiff::of(bytes) else { return settings };
    let Some(first) = tiff.number(4, 4) else { return settings };
    let mut camera = None;
    tiff.each(first, |tag, entry| match tag {
        0x0112 => settings.orientation = tiff.whole(entry).filter(|n| (1..=8).contains(n)).unwrap_or(0) as u8,
        0x8769 => camera = tiff.whole(entry),
        _ => {}
    });
    let Some(camera) = camera else { return settings };
    let (mut shutter, mut aperture, mut speed) = (None, None, None);
    tiff.each(camera, |tag, entry| match tag {
        0x829A => settings.seconds = tiff.fraction(entry),
        0x829D => settings.f_number = tiff.fraction(entry),
        0x8827 => settings.iso = tiff.whole(entry).map(f64::from),
        // APEX values: powers of two of the time and of the f-number.
        0x9201 => shutter = tiff.fraction(entry).map(|v| (-v).exp2()),
        0x9202 => aperture = tiff.fraction(entry).map(|v| (0.5 * v).exp2()),
        0x8833 => speed = tiff.whole(entry).map(f64::from),
        _ => {}
    });
    let sound = |x: Option<f64>| x.filter(|x| x.is_finite() && (1e-9..1e9).contains(x));
    // 65535 stands for a speed that does not fit, which the newer tag has.
    settings.iso = sound(settings.iso.filter(|s| *s < 65535.0)).or(sound(speed));
    settings.seconds = sound(settings.seconds).or(sound(shutter));
    settings.f_number = sound(settings.f_number).or(sound(aperture));
    settings
}

/// A TIFF file in memory.
struct Tiff<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl<'a> Tiff<'a> {
    fn of(bytes: &'a [u8]) -> Option<Tiff<'a>> {
        match bytes.get(..4)? {
            b"II*\0" => Some(Tiff { bytes, big_endian: false }),
            b"MM\0*" => Some(Tiff { bytes, big_endian: true }),
            _ => None,
        }
    }

    /// An unsigned number of 2 or 4 bytes.
    fn number(&self, at: u32, size: usize) -> Option<u32> {
        let at = at as usize;
        let bytes = self.bytes.get(at..at.checked_add(size)?)?;
        let join = |n: u32, b: &u8| n << 8 | u32::from(*b);
        Some(if self.big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) })
    }

    /// Calls `f` with tag and place of each entry of a directory, as far as there are bytes.
    fn each(&self, directory: u32, mut f: impl FnMut(u32, u32)) {
        let Some(count) = self.number(directory, 2) else { return };
        for i in 0..count {
            let Some(entry) = directory.checked_add(2 + 12 * i) else { return };
            let Some(tag) = self.number(entry, 2) else { return };
            f(tag, entry);
        }
    }

    /// The first value of a SHORT or LONG that stands in its entry.
    fn whole(&self, entry: u32) -> Option<u32> {
        match self.number(entry.checked_add(2)?, 2)? {
            3 => self.number(entry.checked_add(8)?, 2),
            4 => self.number(entry.checked_add(8)?, 4),
            _ => None,
        }
    }

    /// The first value of a RATIONAL or SRATIONAL.
    fn fraction(&self, entry: u32) -> Option<f64> {
        let signed = match self.number(entry.checked_add(2)?, 2)? {
            5 => false,
            10 => true,
            _ => return None,
        };
        let at = self.number(entry.checked_add(8)?, 4)?;
        let (a, b) = (self.number(at, 4)?, self.number(at.checked_add(4)?, 4)?);
        let real = |n: u32| if signed { f64::from(n as i32) } else { f64::from(n) };
        (b != 0).then(|| real(a) / real(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header, one directory with the orientation and the way to EXIF, and there 1/60 s, f/2.8, ISO 200.
    fn sample(big_endian: bool) -> Vec<u8> {
        let mut out = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        let mut put = |n: u32, size: usize| {
            let bytes = n.to_be_bytes()[4 - size..].to_vec();
            out.extend(if big_endian { bytes } else { bytes.into_iter().rev().collect() });
        };
        let entry = |tag, kind, value, short| [(tag, 2), (kind, 2), (1, 4), (value, if short { 2 } else { 4 }), (0, 2)];
        put(8, 4);
        put(2, 2);
        for e in [entry(0x0112, 3, 6, true), entry(0x8769, 4, 38, false)] {
            e[..if e[3].1 == 2 { 5 } else { 4 }].iter().for_each(|(n, size)| put(*n, *size));
        }
        put(0, 4);
        put(3, 2);
        for e in [entry(0x829A, 5, 80, false), entry(0x829D, 5, 88, false), entry(0x8827, 3, 200, true)] {
            e[..if e[3].1 == 2 { 5 } else { 4 }].iter().for_each(|(n, size)| put(*n, *size));
        }
        put(0, 4);
        [1, 60, 28, 10].iter().for_each(|n| put(*n, 4));
        out
    }

    #[test]
    fn exif_of_both_byte_orders_and_any_cut() {
        for big_endian in [false, true] {
            let bytes = sample(big_endian);
            let got = exif(&bytes);
            assert_eq!(
                got,
                Settings {
                    seconds: Some(1.0 / 60.0),
                    f_number: Some(2.8),
                    iso: Some(200.0),
                    density: 0.0,
                    orientation: 6
                }
            );
            for n in 0..bytes.len() {
                exif(&bytes[..n]);
            }
            for i in 0..bytes.len() {
                let mut bent = bytes.clone();
                bent[i] ^= 0xff;
                exif(&bent);
            }
        }
    }

    #[test]
    fn amounts_are_time_speed_and_aperture() {
        let shot = |seconds, f_number, iso| Settings { seconds, f_number, iso, ..Default::default() };
        let all = [("a", shot(Some(0.5), Some(2.0), Some(100.0))), ("b", shot(Some(0.25), Some(4.0), Some(400.0)))];
        let Exposures { amounts, nominal } = exposures(&all).unwrap();
        assert!(nominal && (amounts[0] / amounts[1] - 2.0).abs() < 1e-12);
        // A linear value of 1 for t S / N^2 = 12.5.
        assert!((12.5 / amounts[0] - 85.47).abs() < 0.01);
        let bare = exposures(&[("a", shot(Some(0.5), None, None))]).unwrap();
        assert_eq!(bare, Exposures { amounts: vec![0.5], nominal: false });
        let none = exposures(&[("a.png", shot(None, None, None))]).unwrap_err().to_string();
        assert!(none.contains("a.png: no exposure time"), "{none}");
        let half = [("a", shot(Some(1.0), Some(2.0), None)), ("b.jpg", shot(Some(1.0), None, None))];
        assert!(exposures(&half).unwrap_err().to_string().starts_with("b.jpg: no f-number"));
    }

    #[test]
    fn lists_take_fractions() {
        assert_eq!("1/4, 2,0.5".parse::<Amounts>().unwrap().0, [0.25, 2.0, 0.5]);
        assert_eq!("1/60,0.3,2,1/8000".parse::<Amounts>().unwrap().to_string(), "1/60,0.3,2,1/8000");
        for wrong in ["", "1/0", "0", "-1", "1/x", "1,,2", "nan", "1e99"] {
            assert!(wrong.parse::<Amounts>().is_err(), "{wrong}");
        }
        let shots = hdrgen_list("a.jpg 60 8.0 100 0\nb.jpg 15 8 100 0.3\n", Path::new("x")).unwrap();
        assert_eq!(shots[1].0, Path::new("x/b.jpg"));
        assert_eq!((shots[0].1.seconds, shots[1].1.density), (Some(1.0 / 60.0), 0.3));
        assert!(hdrgen_list("a.jpg\n", Path::new("")).is_err() && hdrgen_list("", Path::new("")).is_err());
    }
}
