//! Curves from codes to linear light: known ones, and tables as `expmerge --response` prints them.
//!
//! A table holds g, the natural logarithm of light, at evenly spaced codes for red, green and blue; between codes g is linear. g is 0 at
//! the middle code there; here its light is made sRGB's for that code, 0.216, so that every curve, recovered or known, has one
//! scale: brackets of several sets agree, and the nominal scale of [`super::exposure`] holds.

use std::fmt;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::str::FromStr;

use super::response::middle;
use crate::display::transfer::srgb_decode;
use crate::error::printable;
use crate::{Error, Result, files, invalid, string_serde};

/// A file of a curve is no longer than this, bytes.
const LONGEST: usize = 16 << 20;
/// Codes that a table may have.
const MOST_NODES: usize = 65536;

/// A curve that the user names.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// IEC 61966-2-1, what most converters from raw files write.
    Srgb,
    /// Codes are light.
    Linear,
    /// A power.
    Gamma(f64),
    /// A table.
    File(PathBuf),
}

impl FromStr for Choice {
    type Err = Error;
    fn from_str(s: &str) -> Result<Choice> {
        Ok(match s {
            "srgb" => Choice::Srgb,
            "linear" => Choice::Linear,
            _ => match s.strip_prefix("gamma") {
                Some(g) if g.parse::<f64>().is_ok() => match g.parse::<f64>() {
                    Ok(g) if (0.2..=10.0).contains(&g) => Choice::Gamma(g),
                    _ => return invalid!("'{s}': a gamma lies in 0.2 to 10"),
                },
                _ if s.is_empty() => {
                    return invalid!("expected srgb, linear, gamma2.2 or a file of expmerge --response");
                }
                _ => Choice::File(s.into()),
            },
        })
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Choice::Srgb => f.write_str("srgb"),
            Choice::Linear => f.write_str("linear"),
            Choice::Gamma(g) => write!(f, "gamma{g}"),
            Choice::File(path) => write!(f, "{}", path.display()),
        }
    }
}
string_serde!(Choice);

/// Light of codes, a curve a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Curves {
    /// The same closed form for all.
    Known(Choice),
    /// ln of light at evenly spaced codes 0 to 1.
    Table([Vec<f64>; 3]),
}

impl Curves {
    /// The curve of that name, or of that file.
    pub fn of(choice: &Choice) -> Result<Curves> {
        let Choice::File(path) = choice else { return Ok(Curves::Known(choice.clone())) };
        let text = files::read(path).map_err(|e| Error::io(path.display().to_string(), e))?;
        let text = if text.len() > LONGEST { Vec::new() } else { text };
        let text = String::from_utf8(text).unwrap_or_default();
        Curves::parse(&text).map_err(|e| e.in_file(path))
    }

    /// From recovered g, 0 at the middle code.
    pub fn recovered(mut g: [Vec<f64>; 3]) -> Curves {
        let scale = srgb_decode(128.0 / 255.0).ln();
        for channel in &mut g {
            let zero = channel[middle(channel.len())];
            channel.iter_mut().for_each(|x| *x += scale - zero);
        }
        Curves::Table(g)
    }

    /// Light of a code 0 to 1 of a channel: 1 at white for known curves, finite for every code.
    pub fn light(&self, channel: usize, code: f64) -> f64 {
        match self {
            Curves::Known(Choice::Srgb) => srgb_decode(code),
            Curves::Known(Choice::Gamma(g)) => code.powf(*g),
            Curves::Known(_) => code,
            Curves::Table(g) => {
                let g = &g[channel];
                let at = code.clamp(0.0, 1.0) * (g.len() - 1) as f64;
                let node = (at as usize).min(g.len() - 2);
                let next = at - node as f64;
                // A code between nodes that are equal to it takes no arithmetic: 8-bit codes hit theirs.
                if next == 0.0 { g[node].exp() } else { (g[node] * (1.0 - next) + g[node + 1] * next).exp() }
            }
        }
    }

    /// Light of every whole code up to `largest`.
    pub fn table(&self, channel: usize, largest: usize) -> Vec<f32> {
        (0..=largest).map(|z| self.light(channel, z as f64 / largest as f64) as f32).collect()
    }

    /// The text that [`Curves::parse`] reads: code and g of the three channels, g 0 at the middle code.
    pub fn to_text(&self, nodes: usize) -> String {
        let at = |channel, node: usize| self.light(channel, node as f64 / (nodes - 1) as f64).ln();
        let zero = [0, 1, 2].map(|c| at(c, middle(nodes)));
        let mut text = String::new();
        for node in 0..nodes {
            let g = [0, 1, 2].map(|c| (at(c, node) - zero[c]).max(-99.0));
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{node}\t{:.6}\t{:.6}\t{:.6}", g[0], g[1], g[2]);
        }
        text
    }

    /// Reads lines of a code and g of one channel or three; codes are 0, 1, 2 ... and the last is white. Lines that begin with '#'
    /// are passed over. g must rise.
    pub fn parse(text: &str) -> Result<Curves> {
        let mut g: [Vec<f64>; 3] = Default::default();
        for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')) {
            let words = line.split([' ', '\t', ',']).filter(|w| !w.is_empty());
            let numbers: Option<Vec<f64>> = words.map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect();
            let (code, values) = match numbers.as_deref() {
                Some([code, v]) => (*code, [*v; 3]),
                Some([code, r, g, b]) => (*code, [*r, *g, *b]),
                _ => {
                    return invalid!(
                        "line {}: '{}': expected a code and g of one channel or three",
                        i + 1,
                        shown(line)
                    );
                }
            };
            let next = g[0].len();
            if code != next as f64 || next >= MOST_NODES {
                return invalid!(
                    "line {}: code {code}: expected {next}; codes are 0, 1, 2 ... and the last is white",
                    i + 1
                );
            }
            for (channel, v) in g.iter_mut().zip(values) {
                if channel.last().is_some_and(|last| *last > v) {
                    return invalid!("line {}: g falls to {v}; expected a curve that rises", i + 1);
                }
                channel.push(v);
            }
        }
        if g[0].len() < 16 {
            return invalid!(
                "has {} codes; expected 16 or more lines of code and g, as expmerge --response prints",
                g[0].len()
            );
        }
        Ok(Curves::recovered(g))
    }
}

fn shown(line: &str) -> String {
    printable(line.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_is_read_again() {
        for curves in [Curves::Known(Choice::Srgb), Curves::Known(Choice::Gamma(2.2))] {
            let again = Curves::parse(&curves.to_text(256)).unwrap();
            let factor = again.light(1, 128.0 / 255.0) / curves.light(1, 128.0 / 255.0);
            assert!((again.light(0, 128.0 / 255.0) - srgb_decode(128.0 / 255.0)).abs() < 1e-9);
            for z in 1..=255 {
                let code = f64::from(z) / 255.0;
                assert!((again.light(2, code) / curves.light(2, code) / factor - 1.0).abs() < 2e-6, "{z}");
            }
        }
    }

    #[test]
    fn names_and_files() {
        for (text, want) in [("srgb", Choice::Srgb), ("gamma2.2", Choice::Gamma(2.2)), ("linear", Choice::Linear)] {
            assert_eq!(text.parse::<Choice>().unwrap(), want);
            assert_eq!(want.to_string(), text);
        }
        assert_eq!("gammaray.txt".parse::<Choice>().unwrap(), Choice::File("gammaray.txt".into()));
        assert!("gamma0".parse::<Choice>().is_err());
        let rising = |n: usize| (0..n).map(|i| format!("{i} {i}\n")).collect::<String>();
        assert!(Curves::parse(&rising(16)).is_ok() && Curves::parse(&rising(15)).is_err());
        for (text, word) in
            [("0 1 2\n", "line 1"), ("0 1\n1 0\n", "falls"), ("1 0\n", "expected 0"), ("0 x\n", "'0 x'")]
        {
            let message = Curves::parse(text).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
