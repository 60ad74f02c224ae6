//! Rays and points as lines, as Radiance's `rtrace` has them: six numbers a line (origin and direction, or point and
//! normal), one line of results each, in order. Text separated by blanks, or raw f32 both ways.

use std::io::{BufRead, BufReader, Read, Write};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::printable;
use crate::render::estimate::{Effort, Estimate, NEIGHBOURS, Probe, Quality};
use crate::scene::Scene;
use crate::{Error, Result, invalid, parallel};

/// Lines answered at a time.
const BATCH: usize = 64 * NEIGHBOURS;
/// Longest line that is read.
const LONGEST_LINE: u64 = 4096;

/// How lines are read, measured and written.
pub struct Lines {
    /// What is there.
    pub scene: Arc<Scene>,
    /// Measures.
    pub estimate: Arc<dyn Estimate>,
    /// Work a line.
    pub effort: Effort,
    /// A line is a point and its normal, and what falls on it is measured.
    pub irradiance: bool,
    /// Raw f32 in native order both ways, in place of text.
    pub float: bool,
    /// Adds two columns: the standard error of the luminance, and the number of paths.
    pub with_error: bool,
}

/// Six numbers and the line they stand in.
type Line = (u64, [f64; 6]);

impl Lines {
    /// Answers all lines of `input`.
    pub fn run(
        &self,
        input: &mut dyn Read,
        out: &mut dyn Write,
        finish: &(dyn Fn(&[f32]) -> Vec<f64> + Sync),
    ) -> Result<()> {
        let mut input = BufReader::new(input);
        let mut number = 0;
        loop {
            let batch = if self.float { floats(&mut input, &mut number)? } else { texts(&mut input, &mut number)? };
            if batch.is_empty() {
                return Ok(());
            }
            let probes = batch.iter().map(|l| self.probe(l)).collect::<Result<Vec<_>>>()?;
            for (values, quality) in self.measure(&probes) {
                let mut row = finish(&values);
                if self.with_error {
                    row.extend([quality.standard_error, quality.paths as f64]);
                }
                self.write(out, &row)?;
            }
            out.flush().map_err(|e| Error::io("standard output", e))?;
        }
    }

    fn probe(&self, (number, n): &Line) -> Result<Probe> {
        let frame = &self.scene.frame;
        let place = DVec3::new(n[0], n[1], n[2]) * self.scene.unit_m;
        let direction = DVec3::new(n[3], n[4], n[5]);
        let unit = direction.normalize_or_zero();
        let what = if self.irradiance { "normal" } else { "direction" };
        if unit == DVec3::ZERO || !n.iter().all(|x| x.is_finite()) {
            let which = if self.float { "record" } else { "line" };
            return invalid!("standard input: {which} {number}: expected a point and a {what} with a length");
        }
        let (place, unit) = (frame.place(place).as_vec3a(), unit.as_vec3a());
        Ok(match self.irradiance {
            false => Probe::Ray { origin: place, direction: unit, number: *number },
            // Users put points onto surfaces: what they see starts just above.
            true => Probe::Irradiance { point: self.scene.lifted(place, unit), normal: unit, number: *number },
        })
    }

    fn measure(&self, probes: &[Probe]) -> Vec<(Vec<f32>, Quality)> {
        let n = self.estimate.components();
        let some = |probes: &[Probe]| {
            let mut out = vec![0.0; n * probes.len()];
            let quality = self.estimate.measure(probes, self.effort, &mut out);
            out.chunks(n).map(<[f32]>::to_vec).zip(quality).collect::<Vec<_>>()
        };
        // Lines need not be neighbours: each is judged by itself.
        if parallel::pool() {
            probes.par_chunks(1).flat_map_iter(some).collect()
        } else {
            probes.chunks(1).flat_map(some).collect()
        }
    }

    fn write(&self, out: &mut dyn Write, row: &[f64]) -> Result<()> {
        let written = if self.float {
            let floats: Vec<f32> = row.iter().map(|v| *v as f32).collect();
            out.write_all(bytemuck::cast_slice(&floats))
        } else {
            let words: Vec<String> = row.iter().map(|v| format!("{v:.6e}")).collect();
            writeln!(out, "{}", words.join("\t"))
        };
        written.map_err(|e| Error::io("standard output", e))
    }
}

/// Reads up to a batch of text lines; blank lines and comments from `#` are passed over.
fn texts(input: &mut impl BufRead, number: &mut u64) -> Result<Vec<Line>> {
    let mut batch = Vec::new();
    let mut line = Vec::new();
    while batch.len() < BATCH {
        line.clear();
        let got = input.take(LONGEST_LINE).read_until(b'\n', &mut line);
        if got.map_err(|e| Error::io("standard input", e))? == 0 {
            break;
        }
        *number += 1;
        let text = String::from_utf8_lossy(&line);
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let words: Vec<Option<f64>> = text.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
        let Ok(numbers) = <[Option<f64>; 6]>::try_from(words) else { return wrong(*number, text) };
        if numbers.iter().any(Option::is_none) {
            return wrong(*number, text);
        }
        batch.push((*number, numbers.map(Option::unwrap_or_default)));
    }
    Ok(batch)
}

fn wrong<T>(number: u64, text: &str) -> Result<T> {
    let shown: String = printable(text.as_bytes()).chars().take(60).collect();
    invalid!("standard input: line {number}: expected six numbers, got '{shown}'")
}

/// Reads up to a batch of six f32.
fn floats(input: &mut impl Read, number: &mut u64) -> Result<Vec<Line>> {
    let mut bytes = Vec::new();
    input.take(24 * BATCH as u64).read_to_end(&mut bytes).map_err(|e| Error::io("standard input", e))?;
    if bytes.len() % 24 != 0 {
        return invalid!("standard input: record {}: cut off, expected six f32", *number + bytes.len() as u64 / 24 + 1);
    }
    let mut batch = Vec::new();
    for record in bytes.chunks_exact(24) {
        *number += 1;
        batch.push((
            *number,
            std::array::from_fn(|i| f64::from(bytemuck::pod_read_unaligned::<f32>(&record[4 * i..4 * i + 4]))),
        ));
    }
    Ok(batch)
}
