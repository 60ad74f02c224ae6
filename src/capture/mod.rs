//! From a bracket of photographs to light.
//!
//! A camera's code is a curve of the light that came: z = f(E t), clipped at both ends. Exposures of several lengths t show every part of a
//! scene well in one of them, and together they tell f itself, up to a factor, from the pictures alone [Debevec 1997].
//!
//! 1. [`read`]: JPEG, PNG and TIFF files as the codes they hold, upright. Each is held whole, three codes a pixel; what comes out
//!    flows in blocks of rows.
//! 2. [`exposure`]: how much each let in, t S / N^2, from EXIF or as stated.
//! 3. [`sample`], [`response`]: g = ln f^-1 of each channel from some thousand pixels, or a curve that is known ([`curve`]).
//! 4. [`merge`]: light of each pixel as a mean over the exposures that saw it well, with one weight for the three channels.
//! 5. [`lens`]: light lost toward the edge, filters, the part that counts, the view. [`chart`]: from the camera's channels to XYZ.
//! 6. [`spot`]: a factor from luminances that were measured. Without one, a scale or an absolute chart, the result is relative.
//!
//! Not done: aligning the exposures, taking out what moved, subtracting flare or dark current. The curve is one for the whole picture, which
//! cameras that lighten shadows locally do not have.

pub mod chart;
pub mod curve;
pub mod exposure;
pub mod lens;
pub mod merge;
pub mod picture;
pub mod read;
pub mod response;
pub mod sample;
pub mod spot;

use std::path::PathBuf;

use crate::notes::Notes;
use crate::{Error, Result, invalid, parallel};
use curve::Curves;
use exposure::{Exposures, Settings};
use read::{Codes, Shot};
use response::{Recovered, Samples};

/// Nodes of g for codes of more than 8 bits.
const DEEP_NODES: usize = 512;
/// Parts of the codes, of [`response::PARTS`], that must have been seen of a curve, or a note says that the rest is a guess.
const COVERED: usize = 12;

/// Exposures of one scene, in the order of what they let in.
pub struct Bracket {
    /// Of one size and depth.
    pub shots: Vec<Shot>,
    /// Their amounts, rising.
    pub exposures: Exposures,
    /// Shortest and longest time, s.
    pub seconds: (f64, f64),
}

/// Reads files, on all threads.
pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Shot>> {
    let mut slots: Vec<(&PathBuf, Option<Result<Shot>>)> = paths.iter().map(|p| (p, None)).collect();
    parallel::for_pieces(&mut slots, 1, |_, piece| {
        piece.iter_mut().for_each(|(path, shot)| *shot = Some(read::read(path)))
    });
    slots.into_iter().filter_map(|(_, shot)| shot).collect()
}

impl Bracket {
    /// Shots with the settings that hold for them. Fails, naming the file, on unlike sizes and depths and on missing times.
    pub fn new(shots: Vec<Shot>, settings: &[Settings]) -> Result<Bracket> {
        let Some(first) = shots.first() else { return Err(Error::Usage("expected EXPOSURES".into())) };
        for shot in &shots[1..] {
            if (shot.width, shot.height) != (first.width, first.height) {
                let (w, h, a, b) = (shot.width, shot.height, first.width, first.height);
                return invalid!("{}: is {w} x {h} pixels, {} is {a} x {b}; expected one size", shot.name, first.name);
            }
            if shot.codes.largest() != first.codes.largest() {
                let bits = |s: &Shot| if matches!(s.codes, Codes::Eight(_)) { 8 } else { 16 };
                let (a, b) = (bits(shot), bits(first));
                return invalid!("{}: has {a} bits a channel, {} has {b}; expected one depth", shot.name, first.name);
            }
        }
        let named: Vec<(&str, Settings)> = shots.iter().zip(settings).map(|(s, t)| (s.name.as_str(), *t)).collect();
        let Exposures { amounts, nominal } = exposure::exposures(&named)?;
        let times = settings.iter().filter_map(|s| s.seconds);
        let seconds = times.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), t| (a.min(t), b.max(t)));
        let mut order: Vec<usize> = (0..shots.len()).collect();
        order.sort_by(|a, b| amounts[*a].total_cmp(&amounts[*b]));
        let sorted = order.iter().map(|i| amounts[*i]).collect();
        let mut slots: Vec<Option<Shot>> = shots.into_iter().map(Some).collect();
        let shots = order.iter().filter_map(|i| slots[*i].take()).collect();
        Ok(Bracket { shots, exposures: Exposures { amounts: sorted, nominal }, seconds })
    }

    /// Refuses a set that is all black or all white; codes of `range`, shares of the largest, are neither.
    pub fn check_light(&self, range: (f64, f64)) -> Result<()> {
        let (Some(short), Some(long)) = (self.shots.first(), self.shots.last()) else { return Ok(()) };
        let pixels = short.width * short.height;
        let largest = short.codes.largest() as f64;
        let all = |shot: &Shot, test: &dyn Fn(f64) -> bool| {
            (0..pixels).all(|i| shot.codes.pixel(i).iter().all(|z| test(*z as f64 / largest)))
        };
        let (low, high) = range;
        if all(short, &|code| code >= high) {
            return invalid!(
                "{}: all white (codes of {high} and more), and it is the shortest exposure; expected shorter ones",
                short.name
            );
        }
        if all(long, &|code| code <= low) {
            return invalid!(
                "{}: all black (codes of {low} and less), and it is the longest exposure; expected longer ones",
                long.name
            );
        }
        Ok(())
    }

    /// Nodes that a recovered curve has.
    pub fn nodes(&self) -> usize {
        self.shots.first().map_or(256, |s| if s.codes.largest() == 255 { 256 } else { DEEP_NODES })
    }

    /// The response of each channel from about `count` pixels; `smooth` is lambda. The text tells how well it fits.
    pub fn recover(&self, count: usize, smooth: f64, notes: &Notes) -> Result<(Curves, String)> {
        let Some(first) = self.shots.first() else { return Err(Error::Usage("expected EXPOSURES".into())) };
        let name = &first.name;
        let amounts = &self.exposures.amounts;
        if amounts.windows(2).all(|w| w[1] / w[0] < 1.01) {
            return invalid!("{name}: all exposures let in the same, so they do not tell the response; give a --curve");
        }
        let ln_exposures: Vec<f64> = amounts.iter().map(|a| (a / amounts[0]).ln()).collect();
        let pixels = sample::choose(&self.shots, count);
        let largest = first.codes.largest() as f32;
        let mut channels: [(usize, Option<Result<Recovered>>); 3] = [(0, None), (1, None), (2, None)];
        parallel::for_pieces(&mut channels, 1, |_, piece| {
            for (c, found) in piece {
                let code = |i: usize, shot: &Shot| shot.codes.pixel(i)[*c] as f32 / largest;
                let codes: Vec<f32> = pixels.iter().flat_map(|i| self.shots.iter().map(|s| code(*i, s))).collect();
                let samples = Samples { nodes: self.nodes(), ln_exposures: &ln_exposures, codes: &codes };
                *found = Some(response::recover(&samples, smooth));
            }
        });
        let found =
            channels.into_iter().filter_map(|(_, r)| r).collect::<Result<Vec<_>>>().map_err(|e| e.within(name))?;
        let [r, g, b] = &found[..] else { return invalid!("{name}: has not three channels") };
        remark([r, g, b], notes);
        let rms = found.iter().map(|f| f.rms).fold(0.0, f64::max);
        let text = format!("recovered from {} pixels, rms {rms:.4} in ln E", pixels.len());
        Ok((Curves::recovered([r, g, b].map(|f| f.g.clone())), text))
    }
}

/// Notes on curves to be careful with.
fn remark(found: [&Recovered; 3], notes: &Notes) {
    for (channel, f) in ["red", "green", "blue"].iter().zip(found) {
        if f.mended > 0 {
            let n = f.mended;
            notes.add(format!(
                "the response of {channel} did not rise at {n} codes and was made to; try a larger --smooth"
            ));
        }
        if f.seen < COVERED {
            let (seen, parts) = (f.seen, response::PARTS);
            notes.add(format!(
                "the exposures show codes of {channel} in {seen} of {parts} parts of their range alone: the rest of its response is a guess"
            ));
        }
    }
}
