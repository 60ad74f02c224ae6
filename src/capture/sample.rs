//! Which pixels tell the response: spread over all brightnesses, and where nothing changes nearby.
//!
//! An edge that a hand or the wind has moved by a pixel is two codes in two exposures; a wall is not. So of the pixels of like
//! brightness those are taken whose neighbours, one to each side, differ least in any exposure.

use super::read::Shot;

/// Candidates for each pixel that is wanted.
const CANDIDATES: usize = 40;
/// Kept of each step of brightness; the rest of the number wanted is filled up evenly from what is left.
const EACH_STEP: usize = 2;

/// A pixel that may be taken.
struct Candidate {
    pixel: usize,
    /// Sum of its codes over exposures and channels: rises with its light.
    brightness: usize,
    /// Largest difference to a neighbour in any exposure and channel.
    edge: usize,
}

/// About `count` pixels, by their number, of shots of one size.
pub fn choose(shots: &[Shot], count: usize) -> Vec<usize> {
    let Some(Shot { width, height, .. }) = shots.first() else { return Vec::new() };
    let pixels = width * height;
    // A stride prime to the width wanders over all columns.
    let mut stride = (pixels / (CANDIDATES * count)).max(1);
    while stride > 1 && common_divisor(stride, *width) > 1 {
        stride += 1;
    }
    let mut all: Vec<Candidate> = (0..pixels).step_by(stride).map(|i| look(shots, i, *width, *height)).collect();
    let low = all.iter().map(|c| c.brightness).min().unwrap_or(0);
    let high = all.iter().map(|c| c.brightness).max().unwrap_or(0);
    let steps = (count / EACH_STEP).max(1);
    let step = |c: &Candidate| (c.brightness - low) * (steps - 1) / (high - low).max(1);
    all.sort_by_key(|c| (step(c), c.edge, c.pixel));
    let (mut taken, mut left) = (Vec::new(), Vec::new());
    for of_one_step in all.chunk_by(|a, b| step(a) == step(b)) {
        let (first, rest) = of_one_step.split_at(EACH_STEP.min(of_one_step.len()));
        taken.extend(first.iter().map(|c| c.pixel));
        left.extend(rest.iter().map(|c| c.pixel));
    }
    let missing = count.saturating_sub(taken.len()).min(left.len());
    taken.extend((0..missing).map(|i| left[i * left.len() / missing]));
    taken
}

fn common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

fn look(shots: &[Shot], pixel: usize, width: usize, height: usize) -> Candidate {
    let (x, y) = (pixel % width, pixel / width);
    let beside = [
        pixel - usize::from(x > 0),
        pixel + usize::from(x + 1 < width),
        if y > 0 { pixel - width } else { pixel },
        if y + 1 < height { pixel + width } else { pixel },
    ];
    let (mut brightness, mut edge) = (0, 0);
    for shot in shots {
        let own = shot.codes.pixel(pixel);
        brightness += own.iter().sum::<usize>();
        for other in beside.map(|i| shot.codes.pixel(i)) {
            edge = own.iter().zip(other).fold(edge, |m, (a, b)| m.max(a.abs_diff(b)));
        }
    }
    Candidate { pixel, brightness, edge }
}

#[cfg(test)]
mod tests {
    use super::super::exposure::Settings;
    use super::super::read::Codes;
    use super::*;

    /// A ramp with a checkered half: all brightnesses are there, and nothing of the checks.
    #[test]
    fn spread_and_flat() {
        let (width, height) = (256, 64);
        let code = |i: usize| {
            let (x, y) = (i % width, i / width);
            if y < 32 { x as u8 } else { ((x + y) % 2 * 255) as u8 }
        };
        let codes = Codes::Eight((0..width * height).flat_map(|i| [code(i); 3]).collect());
        let shot = Shot { name: String::new(), width, height, codes, settings: Settings::default() };
        let taken = choose(&[shot], 400);
        assert_eq!(taken.len(), 400);
        let mut seen: Vec<u8> = taken[..256].iter().map(|i| code(*i)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert!(seen.len() > 120, "{}", seen.len());
        assert!(taken[2..256].iter().filter(|i| **i / width >= 32).count() < 6);
    }
}
