//! Absolute scale from luminances that were measured.

use std::fmt;
use std::str::FromStr;

use super::merge::{Colours, Merge, Seen};
use crate::error::printable;
use crate::{Error, Result, invalid, string_serde};

/// A measured spot: `x,y=cd_m2`, or `x,y,radius=cd_m2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Column and row of its middle, of the upright picture before the lens cuts.
    pub at: (usize, usize),
    /// Pixels nearer than this count too.
    pub radius: f64,
    /// What the meter read.
    pub cd_m2: f64,
}

impl FromStr for Spot {
    type Err = Error;
    fn from_str(s: &str) -> Result<Spot> {
        let parse = || {
            let (place, value) = s.split_once('=')?;
            let cd_m2 = value.trim().parse().ok().filter(|x: &f64| *x > 0.0 && *x < 1e12)?;
            let words: Vec<&str> = place.split(',').map(str::trim).collect();
            let (x, y, radius) = match words[..] {
                [x, y] => (x, y, 0.0),
                [x, y, r] => (x, y, r.parse().ok().filter(|r: &f64| (0.0..=1e4).contains(r))?),
                _ => return None,
            };
            Some(Spot { at: (x.parse().ok()?, y.parse().ok()?), radius, cd_m2 })
        };
        parse().ok_or_else(|| {
            Error::Invalid(format!(
                "'{}' is no spot; give x,y=cd/m2 in pixels from the top left, such as 820,413=1250, or x,y,radius=cd/m2",
                printable(s.as_bytes())
            ))
        })
    }
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ((x, y), r) = (self.at, self.radius);
        if r > 0.0 { write!(f, "{x},{y},{r}={}", self.cd_m2) } else { write!(f, "{x},{y}={}", self.cd_m2) }
    }
}
string_serde!(Spot);

/// Mean light of a rectangle, in the camera's channels. Fails where it reaches outside, or where part of it was not seen well.
pub fn mean_of(merge: &Merge, [left, top, width, height]: [usize; 4]) -> Result<[f64; 3]> {
    let (w, h) = merge.size();
    if left.saturating_add(width) > w || top.saturating_add(height) > h {
        return invalid!("{left},{top} with {width} x {height} pixels reaches beyond the picture of {w} x {h}");
    }
    mean(merge, (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))))
}

fn mean(merge: &Merge, pixels: impl Iterator<Item = (usize, usize)>) -> Result<[f64; 3]> {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for (x, y) in pixels {
        let Some(light) = merge.light(x, y) else { return invalid!("pixel {x},{y} lies outside the lens's circle") };
        match merge.seen(x, y) {
            Seen::Well => {}
            Seen::White => return invalid!("pixel {x},{y} is white in every exposure, so its light is not known"),
            Seen::Black => return invalid!("pixel {x},{y} is black in every exposure, so its light is not known"),
        }
        sum.iter_mut().zip(light).for_each(|(s, x)| *s += f64::from(x));
        count += 1.0;
    }
    Ok(sum.map(|s| s / count))
}

/// The factor that makes light cd/m2: the geometric mean of what the spots ask for, and the largest ratio of one to it.
pub fn factor(merge: &Merge, colours: &Colours, spots: &[Spot]) -> Result<(f64, f64)> {
    let (w, h) = merge.size();
    let mut logs = Vec::new();
    for spot in spots {
        let ((x, y), r) = (spot.at, spot.radius.ceil() as usize);
        if x >= w || y >= h {
            return invalid!("--spot {spot}: lies outside the picture of {w} x {h} pixels");
        }
        let near = |x2: usize, y2: usize| (x2.abs_diff(x) as f64).hypot(y2.abs_diff(y) as f64) <= spot.radius;
        let rows = y.saturating_sub(r)..=(y + r).min(h - 1);
        let columns = x.saturating_sub(r)..=(x + r).min(w - 1);
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y))).filter(|(x, y)| near(*x, *y));
        let light = mean(merge, pixels).map_err(|e| e.within(&format!("--spot {spot}")))?;
        let luminance: f64 = light.iter().zip(colours.luminance).map(|(a, b)| a * b).sum();
        if luminance.is_nan() || luminance <= 0.0 {
            return invalid!("--spot {spot}: has no luminance in the picture");
        }
        logs.push((spot.cd_m2 / luminance).ln());
    }
    let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
    let spread = logs.iter().fold(0.0, |m: f64, l| m.max((l - mean).abs()));
    Ok((mean.exp(), spread.exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_are_written_as_they_are_read() {
        for text in ["820,413=1250", "1,2,3.5=0.25"] {
            assert_eq!(text.parse::<Spot>().unwrap().to_string(), text);
        }
        for wrong in ["1,2", "1,2=0", "1,2=x", "-1,2=3", "1=3", "1,2,3,4=5", "1.5,2=3"] {
            assert!(wrong.parse::<Spot>().is_err(), "{wrong}");
        }
    }
}
