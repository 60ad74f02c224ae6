//! Luminance and chroma: RY = (R - Y) / Y and BY = (B - Y) / Y beside Y, the two often for every second column and row.
//!
//! What lies between samples is taken linearly; beyond the last sample it is repeated. OpenEXR's own reader filters
//! over 27 samples, so edges in colour, not in luminance, differ slightly from its.

use crate::color::Primaries;
use crate::{Error, Result};

/// How colour is stored.
#[derive(Clone, Copy)]
pub(super) struct Chroma {
    /// Luminance of red, green, blue.
    weights: [f64; 3],
    /// A sample each so many columns and rows.
    every: [usize; 2],
}

impl Chroma {
    pub fn new(primaries: &Primaries, every: [usize; 2]) -> Result<Chroma> {
        let weights = primaries.to_xyz().map(|m| m.0[1]).filter(|w| w[1].abs() > 1e-6);
        let weights = weights.ok_or_else(|| Error::Invalid("its chromaticities give green no luminance".into()))?;
        if every.iter().any(|n| *n > 2) {
            return Err(Error::Unsupported("RY and BY every third sample or fewer are not read".into()));
        }
        Ok(Chroma { weights, every })
    }
}

/// Turns rows of Y, RY, BY, of which the first has samples of all three, into RGB. `after` holds the rows that follow,
/// or none at the end.
pub(super) fn to_rgb(chroma: &Chroma, width: usize, rows: &mut [f32], after: &[f32]) {
    let [across, down] = chroma.every;
    let row = 3 * width;
    if across == 2 {
        for line in rows.chunks_exact_mut(row).step_by(down) {
            between_columns(line);
        }
    }
    if down == 2 {
        let mut below = after.get(..row).map(<[f32]>::to_vec);
        if let Some(line) = below.as_deref_mut().filter(|_| across == 2) {
            between_columns(line);
        }
        let count = rows.len() / row;
        for y in (1..count).step_by(2) {
            let (above, rest) = rows.split_at_mut(y * row);
            let above = &above[(y - 1) * row..];
            let (line, rest) = rest.split_at_mut(row);
            let under = rest.get(..row).or(below.as_deref()).unwrap_or(above);
            for ((x, a), b) in line.chunks_exact_mut(3).zip(above.chunks_exact(3)).zip(under.chunks_exact(3)) {
                x[1] = 0.5 * (a[1] + b[1]);
                x[2] = 0.5 * (a[2] + b[2]);
            }
        }
    }
    let w = chroma.weights;
    for pixel in rows.chunks_exact_mut(3) {
        let [y, ry, by] = [pixel[0], pixel[1], pixel[2]].map(f64::from);
        let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
        let g = (y - r * w[0] - b * w[2]) / w[1];
        pixel.copy_from_slice(&[r as f32, g as f32, b as f32]);
    }
}

/// The chroma of odd columns from that of their neighbours.
fn between_columns(line: &mut [f32]) {
    for at in (3..line.len()).step_by(6) {
        for c in [1, 2] {
            let left = line[at - 3 + c];
            let right = line.get(at + 3 + c).copied().unwrap_or(left);
            line[at + c] = 0.5 * (left + right);
        }
    }
}
