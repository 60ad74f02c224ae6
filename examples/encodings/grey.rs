//! What an encoding does to greys: how far its luminances reach, and how far apart they lie.

use luxpipe::color::Xy;

use super::coders::{Coder, Encoding};

/// Greys a decade in the search for the ends of the range.
const PER_DECADE: i32 = 2000;
/// Decades searched: those that floats have.
const DECADES: [i32; 2] = [-45, 39];

/// Luminances that come back for D65 greys.
pub fn seen(encoding: &Encoding, luminances: &[f64]) -> Vec<f64> {
    let white = Xy::D65.xyz();
    let greys: Vec<[f64; 3]> = luminances.iter().map(|y| white.map(|x| x * y)).collect();
    encoding.seen(&greys).iter().map(|c| c[1]).collect()
}

/// The lowest and the highest luminance up to which every grey around 1 comes back with a smaller relative error.
pub fn range(encoding: &Encoding, tolerance: f64) -> [f64; 2] {
    let at = |k: i32| 10f64.powf(f64::from(k) / f64::from(PER_DECADE));
    let steps: Vec<f64> = (DECADES[0] * PER_DECADE..DECADES[1] * PER_DECADE).map(at).collect();
    let held: Vec<bool> =
        seen(encoding, &steps).iter().zip(&steps).map(|(a, b)| (a / b - 1.0).abs() <= tolerance).collect();
    let one = (-DECADES[0] * PER_DECADE) as usize;
    let below = held[..one].iter().rev().take_while(|h| **h).count();
    let above = held[one..].iter().take_while(|h| **h).count();
    [steps[one - below], steps[one + above - 1]]
}

/// Orders of magnitude between two luminances.
pub fn orders([bottom, top]: [f64; 2]) -> f64 {
    (top / bottom).log10()
}

/// Steps between the luminances that come back.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// The largest relative distance of neighbours.
    pub largest: f64,
    /// The largest relative error.
    pub error: f64,
}

/// The steps of greys from 0.02 to 10, or of floats around 1, where they are coarsest.
pub fn steps(encoding: &Encoding) -> Steps {
    if encoding.coder == Coder::Float {
        steps_between(encoding, [0.9999, 1.0001], 1e-8)
    } else {
        steps_between(encoding, [0.02, 10.0], 2e-5)
    }
}

/// The same between two luminances, by greys that lie apart by a ratio of 1 and this much more.
pub fn steps_between(encoding: &Encoding, [bottom, top]: [f64; 2], ratio: f64) -> Steps {
    let count = ((top / bottom).ln() / ratio) as usize;
    let greys: Vec<f64> = (0..=count).map(|i| bottom * (i as f64 * ratio).exp()).collect();
    let mut levels = seen(encoding, &greys);
    let error = levels.iter().zip(&greys).fold(0.0, |m: f64, (a, b)| m.max((a / b - 1.0).abs()));
    levels.sort_by(f64::total_cmp);
    let largest = levels.windows(2).fold(0.0, |m: f64, pair| m.max(pair[1] / pair[0] - 1.0));
    Steps { largest, error }
}
