//! How many paths should go on from the first surface.
//!
//! Of the variance of a path from the eye a part B lies between places of the pixel, another W between paths that go on from
//! one place. With a price b of what leads to the place and w of each path from there, the error at a given price is least for
//! sqrt(W b / (B w)) paths [Kahn 1956, Arvo and Kirk 1990]. Both parts come from a trial on pixels spread over the picture; a
//! price is the number of rays. The trial depends on the scene and the seed alone, so the choice is the same for any number of
//! threads and any rows.

/// Pixels of the trial, paths in each and branches of each path.
pub const PIXELS: u32 = 192;
/// Paths a pixel.
pub const PATHS: u32 = 8;
/// Branches a path.
pub const BRANCHES: u32 = 4;
/// Most paths that go on; more would leave too few places of a pixel for its edges.
const MOST: u32 = 4;
/// Places of a pixel are spread so evenly that less than all of their variance is left in the mean.
const EVEN: f64 = 0.5;

/// Luminances of the branches of one path, and the surfaces that they met.
pub type Trial = ([f64; BRANCHES as usize], u32);

/// The number of paths, 1 to 4, from trials by pixel.
pub fn choose(pixels: &[Vec<Trial>]) -> u32 {
    let (mut between, mut within) = (Vec::new(), Vec::new());
    let (mut met, mut branches) = (0u64, 0u64);
    for trials in pixels {
        met += trials.iter().map(|t| u64::from(t.1)).sum::<u64>();
        branches += trials.iter().filter(|t| t.1 > 0).count() as u64 * u64::from(BRANCHES);
        let n = trials.len() as f64;
        let means: Vec<f64> = trials.iter().map(|t| mean(&t.0)).collect();
        let all = mean(&means);
        if all <= 0.0 {
            continue;
        }
        let inside = trials.iter().map(|t| variance(&t.0)).sum::<f64>() / n;
        // The variance of the means holds a share of what lies within.
        let outside = (variance(&means) - inside / f64::from(BRANCHES)).max(0.0);
        within.push(inside / (all * all));
        between.push(outside / (all * all));
    }
    if branches == 0 || within.is_empty() {
        return 1;
    }
    // Medians: a few pixels at edges or lamps must not decide for all.
    let (w, b) = (median(within), EVEN * median(between));
    // The way to the place is one ray; of each surface that follows one ray goes on and one to a lamp.
    let price = 2.0 * met as f64 / branches as f64;
    let best = if b > 0.0 { (w / (b * price)).sqrt() } else { f64::from(MOST) };
    (best.round() as u32).clamp(1, MOST)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let m = mean(values);
    values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance only after the first surface asks for many paths from there, variance only before it for one.
    #[test]
    fn variance_decides() {
        let pixel = |f: fn(u32, u32) -> f64| -> Vec<Vec<Trial>> {
            let trial = |i: u32| (std::array::from_fn(|k| f(i, k as u32)), 8);
            vec![(0..PATHS).map(trial).collect(); 3]
        };
        assert_eq!(choose(&pixel(|_, k| f64::from(1 + k))), MOST);
        assert_eq!(choose(&pixel(|i, _| f64::from(1 + i))), 1);
        assert_eq!(choose(&pixel(|_, _| 0.0)), 1);
    }
}
