//! The response of a camera from a bracket [Debevec 1997].
//!
//! Code z of pixel i in exposure j follows E_i t_j through an unknown monotone curve; with g = ln of its inverse,
//!
//! g(z_ij) = ln E_i + ln t_j
//!
//! and g and ln E minimise Eq. (3) of the paper, each term by its own mean so that lambda means the same for any number of pixels:
//!
//! sum w(z_ij)^2 [g(z_ij) - ln E_i - ln t_j]^2 / sum w(z_ij)^2  +  (lambda / 16)^2 sum [w(z) (g - s)''(z)]^2,   g(middle) = 0
//!
//! w is the paper's hat, 0 at both ends of the codes. Smoothness is asked of what g differs by from s, sRGB's own: any camera's g bends like
//! a logarithm toward black, and the paper's g'' would straighten that where few pixels are. Given g the best ln E_i is the weighted mean of g - ln t, so every ln E_i goes out
//! exactly (a Schur complement) and one symmetric system of as many unknowns as g has nodes is left, which Cholesky solves. 8-bit codes
//! have a node each; of deeper ones g is linear between 512 nodes.
//!
//! What moved between exposures fits no curve: rounds of reweighting by 1 / (1 + (r / 4s)^2)^2 [Geman 1985], s the residuals' spread in codes, let it
//! count little. Nothing is aligned here.

use crate::display::transfer::srgb_decode;
use crate::{Result, invalid};

/// Spreads below this many codes are rounding.
const ROUNDING_CODES: f64 = 0.3;
/// Residuals of so many spreads count a quarter.
const DOUBTFUL: f64 = 4.0;
/// Solutions, each with weights from the one before.
const ROUNDS: usize = 8;
/// An observation counts for coverage from this weight on.
const SEEN: f64 = 0.05;
/// Parts of the codes in which coverage is counted.
pub const PARTS: usize = 16;
/// Fewer pixels than this that two exposures see say nothing.
const FEWEST: usize = 8;

/// Codes of pixels in every exposure, of one channel.
pub struct Samples<'a> {
    /// Nodes of g, evenly over the codes 0 to 1.
    pub nodes: usize,
    /// ln of each exposure's amount.
    pub ln_exposures: &'a [f64],
    /// Codes 0 to 1, the exposures of a pixel side by side.
    pub codes: &'a [f32],
}

/// A recovered curve.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// g at the nodes, 0 at the middle one, rising.
    pub g: Vec<f64>,
    /// Weighted rms of g - ln E - ln t.
    pub rms: f64,
    /// Of [`PARTS`] equal parts of the codes those that pixels have shown; in the others g is smoothness alone.
    pub seen: usize,
    /// Nodes at which g had to be made to rise.
    pub mended: usize,
}

/// The paper's hat over codes 0 to 1.
fn hat(code: f64) -> f64 {
    (2.0 * code.min(1.0 - code)).max(0.0)
}

/// A code between two nodes.
#[derive(Clone, Copy)]
struct Place {
    node: usize,
    /// Share of the next node.
    next: f64,
    /// The hat, squared.
    weight: f64,
}

impl Place {
    fn of(code: f32, nodes: usize) -> Place {
        let at = f64::from(code).clamp(0.0, 1.0) * (nodes - 1) as f64;
        let node = (at as usize).min(nodes - 2);
        Place { node, next: at - node as f64, weight: hat(f64::from(code)).powi(2) }
    }

    fn value(&self, g: &[f64]) -> f64 {
        g[self.node] * (1.0 - self.next) + g[self.node + 1] * self.next
    }

    fn parts(&self) -> [(usize, f64); 2] {
        [(self.node, 1.0 - self.next), (self.node + 1, self.next)]
    }
}

/// The node that g is 0 at: code 128 of 255.
pub fn middle(nodes: usize) -> usize {
    (128.0 / 255.0 * (nodes - 1) as f64).round() as usize
}

/// Recovers g; `smooth` is lambda, above 0. Fails where fewer than 8 pixels are seen by two exposures.
pub fn recover(samples: &Samples, smooth: f64) -> Result<Recovered> {
    let (n, shots) = (samples.nodes, samples.ln_exposures.len());
    let places: Vec<Place> = samples.codes.iter().map(|c| Place::of(*c, n)).collect();
    let twice = places.chunks_exact(shots).filter(|p| p.iter().filter(|q| q.weight > SEEN * SEEN).count() > 1).count();
    if twice < FEWEST {
        return invalid!(
            "only {twice} of {} sampled pixels are neither black nor white in two exposures; expected {FEWEST} or more, or a known --curve",
            places.len() / shots.max(1)
        );
    }
    let mut doubt = vec![1.0; places.len()];
    let mut g = Vec::new();
    for round in 0..ROUNDS {
        g = solve(samples, &places, &doubt, smooth)?;
        if round + 1 < ROUNDS {
            reweigh(samples, &places, &g, &mut doubt);
        }
    }
    let (square, total) = residuals(samples, &places, &g, &doubt)
        .zip(&places)
        .zip(&doubt)
        .map(|((r, p), d)| (p.weight * d * r * r, p.weight * d))
        .fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let mut parts = [false; PARTS];
    for (code, _) in samples.codes.iter().zip(&places).filter(|(_, p)| p.weight > 0.0) {
        parts[((f64::from(*code) * PARTS as f64) as usize).min(PARTS - 1)] = true;
    }
    let seen = parts.iter().filter(|p| **p).count();
    let mended = rise(&mut g);
    let zero = g[middle(n)];
    g.iter_mut().for_each(|x| *x -= zero);
    Ok(Recovered { g, rms: (square / total).sqrt(), seen, mended })
}

/// ln of the light of a node on sRGB's curve; black, which has none, lies half a step above.
fn usual(node: usize, nodes: usize) -> f64 {
    srgb_decode((node as f64).max(0.5) / (nodes - 1) as f64).ln()
}

/// The best g for these weights.
fn solve(samples: &Samples, places: &[Place], doubt: &[f64], smooth: f64) -> Result<Vec<f64>> {
    let (n, ln_t) = (samples.nodes, samples.ln_exposures);
    let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n]);
    let total: f64 = places.iter().zip(doubt).map(|(p, d)| p.weight * d).sum();
    let mut sums: Vec<(usize, f64)> = Vec::new();
    for (pixel, doubt) in places.chunks_exact(ln_t.len()).zip(doubt.chunks_exact(ln_t.len())) {
        let weight: f64 = pixel.iter().zip(doubt).map(|(p, d)| p.weight * d).sum();
        if weight <= 0.0 {
            continue;
        }
        let mean: f64 = pixel.iter().zip(doubt).zip(ln_t).map(|((p, d), t)| p.weight * d * t).sum::<f64>() / weight;
        sums.clear();
        for ((p, d), t) in pixel.iter().zip(doubt).zip(ln_t) {
            let w = p.weight * d / total;
            for (i, x) in p.parts() {
                // ln t less the pixel's mean: what is left of the right side when ln E has gone.
                b[i] += w * x * (t - mean);
                p.parts().iter().for_each(|(j, y)| a[i * n + j] += w * x * y);
                sums.push((i, w * x));
            }
        }
        for (i, x) in &sums {
            sums.iter().for_each(|(j, y)| a[i * n + j] -= x * y * total / weight);
        }
    }
    // Second differences for 256 nodes: those of n nodes are smaller by the square of the step, and there are more of them.
    let step = (n - 1) as f64 / 255.0;
    let factor = (smooth / 16.0).powi(2) * step.powi(3);
    for k in 1..n - 1 {
        // Never quite 0, or the ends would hang free.
        let w = hat(k as f64 / (n - 1) as f64).max(1e-3);
        let d = [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)];
        let bend = d.iter().map(|(i, x)| x * usual(*i, n)).sum::<f64>();
        for (i, x) in d {
            d.iter().for_each(|(j, y)| a[i * n + j] += factor * w * w * x * y);
            b[i] += factor * w * w * x * bend;
        }
    }
    // A constant costs nothing anywhere else, so whatever this weighs, g(middle) becomes 0 exactly.
    let m = middle(n);
    a[m * n + m] += 1.0 / n as f64;
    cholesky(&mut a, n)?;
    Ok(substitute(&a, n, b))
}

/// What each observation is off, pixel by pixel, at the best ln E.
fn residuals<'a>(samples: &Samples<'a>, places: &'a [Place], g: &[f64], doubt: &[f64]) -> impl Iterator<Item = f64> {
    let ln_t = samples.ln_exposures;
    let mut all = Vec::with_capacity(places.len());
    for (pixel, doubt) in places.chunks_exact(ln_t.len()).zip(doubt.chunks_exact(ln_t.len())) {
        let ln_e = |i: usize| pixel[i].value(g) - ln_t[i];
        let weight: f64 = (0..ln_t.len()).map(|i| pixel[i].weight * doubt[i]).sum();
        let mean = (0..ln_t.len()).map(|i| pixel[i].weight * doubt[i] * ln_e(i)).sum::<f64>() / weight.max(1e-300);
        all.extend((0..ln_t.len()).map(|i| ln_e(i) - mean));
    }
    all.into_iter()
}

/// Weights from residuals in codes of 255: what fits no curve counts little.
fn reweigh(samples: &Samples, places: &[Place], g: &[f64], doubt: &mut [f64]) {
    let per_code = 255.0 / (samples.nodes - 1) as f64;
    let in_codes = |(r, p): (f64, &Place)| {
        let slope = (g[p.node + 1] - g[p.node]).max(1e-4) / per_code;
        r.abs() / slope
    };
    let off: Vec<f64> = residuals(samples, places, g, doubt).zip(places).map(in_codes).collect();
    let mut counted: Vec<f64> =
        off.iter().zip(places).filter(|(_, p)| p.weight > SEEN * SEEN).map(|(r, _)| *r).collect();
    counted.sort_by(f64::total_cmp);
    let median = counted.get(counted.len() / 2).copied().unwrap_or(0.0);
    // 1.4826 makes of a median the deviation of a normal distribution.
    let spread = (1.4826 * median).max(ROUNDING_CODES);
    doubt.iter_mut().zip(&off).for_each(|(d, r)| *d = (1.0 + (r / (DOUBTFUL * spread)).powi(2)).powi(-2));
}

/// Makes g rise: values out of order become their mean (pool adjacent violators), and no step is smaller than a hundredth of the
/// mean one. Returns how many nodes were moved.
fn rise(g: &mut [f64]) -> usize {
    let before = g.to_vec();
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for x in &before {
        pools.push((*x, 1));
        while let [.., (a, m), (b, n)] = pools[..]
            && a > b
        {
            pools.truncate(pools.len() - 2);
            pools.push(((a * m as f64 + b * n as f64) / (m + n) as f64, m + n));
        }
    }
    let flat = pools.iter().flat_map(|(x, n)| std::iter::repeat_n(*x, *n));
    let least = 0.01 * (before[before.len() - 1] - before[0]).max(0.0) / before.len() as f64;
    let mut last = f64::NEG_INFINITY;
    for (x, y) in g.iter_mut().zip(flat) {
        *x = y.max(last + least);
        last = *x;
    }
    g.iter().zip(&before).filter(|(a, b)| (*a - *b).abs() > 1e-9).count()
}

/// Sum of products, on eight running sums so that it goes fast.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (left, right) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in left.zip(right) {
        (0..8).for_each(|i| sums[i] += x[i] * y[i]);
    }
    sums.iter().sum::<f64>() + rest
}

/// Replaces the lower triangle of a symmetric matrix, row by row, by its Cholesky factor.
fn cholesky(a: &mut [f64], n: usize) -> Result<()> {
    let largest = (0..n).map(|i| a[i * n + i]).fold(0.0, f64::max);
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        for j in 0..i {
            let other = &above[j * n..j * n + j + 1];
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let rest = row[i] - dot(&row[..i], &row[..i]);
        if rest.is_nan() || rest <= 1e-15 * largest {
            return invalid!("the exposures do not tell the response; expected some that differ, or a known --curve");
        }
        row[i] = rest.sqrt();
    }
    Ok(())
}

/// Solves L L' x = b.
fn substitute(l: &[f64], n: usize, b: Vec<f64>) -> Vec<f64> {
    let mut x = b;
    for i in 0..n {
        x[i] = (x[i] - dot(&l[i * n..i * n + i], &x[..i])) / l[i * n + i];
    }
    for i in (0..n).rev() {
        x[i] /= l[i * n + i];
        let solved = x[i];
        (0..i).for_each(|j| x[j] -= l[i * n + j] * solved);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What expmerge takes.
    const LAMBDA: f64 = 10.0;

    /// The bracket of tests/ref/validation.toml, debevec-synthetic-bracket: 2000 pixels over 4.4 decades, seven exposures.
    fn bracket(f: impl Fn(f64) -> f64, levels: f64) -> (Vec<f64>, Vec<f32>, Vec<f64>) {
        let times = [1e-3, 1.0 / 250.0, 1.0 / 60.0, 1.0 / 15.0, 0.25, 1.0, 4.0];
        let e: Vec<f64> = (0..2000).map(|i| 10f64.powf(-2.2 + 4.4 * f64::from(i) / 1999.0)).collect();
        let code = |x: f64| ((levels * f(x.clamp(0.0, 1.0))).round() / levels) as f32;
        let codes = e.iter().flat_map(|e| times.map(|t| code(e * t))).collect();
        (times.map(f64::ln).to_vec(), codes, e)
    }

    fn srgb(x: f64) -> f64 {
        if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
    }

    /// An S as film has it: a toe and a shoulder over a gamma.
    fn film(x: f64) -> f64 {
        let y = x.powf(1.0 / 2.4);
        0.5 * y * y * (3.0 - 2.0 * y) + 0.5 * y
    }

    /// g by bisection of the curve itself.
    fn truth(f: &dyn Fn(f64) -> f64, code: f64) -> f64 {
        let (mut low, mut high) = (-30.0f64, 0.0f64);
        for _ in 0..80 {
            let mid = 0.5 * (low + high);
            if f(mid.exp()) < code { low = mid } else { high = mid }
        }
        low
    }

    fn worst(g: &[f64], f: &dyn Fn(f64) -> f64) -> f64 {
        let zero = truth(f, 128.0 / 255.0);
        let node = |z: usize| (z as f64 / 255.0 * (g.len() - 1) as f64).round() as usize;
        let at = |z: usize| truth(f, node(z) as f64 / (g.len() - 1) as f64) - zero;
        (8..=248).map(|z| (g[node(z)] - at(z)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn known_curves_come_back() {
        let curves: [(&str, &dyn Fn(f64) -> f64); 3] =
            [("gamma", &|x| x.powf(1.0 / 2.2)), ("srgb", &srgb), ("film", &film)];
        for (name, f) in curves {
            for (levels, nodes) in [(255.0, 256), (65535.0, 512)] {
                let (ln_exposures, codes, _) = bracket(f, levels);
                let samples = Samples { nodes, ln_exposures: &ln_exposures, codes: &codes };
                let found = recover(&samples, LAMBDA).unwrap();
                let off = worst(&found.g, f);
                eprintln!("{name} {levels}: {off:.4}, rms {:.5}, mended {}", found.rms, found.mended);
                // The case's own tolerance is 0.05.
                assert!(off < 0.03 && found.mended == 0, "{name} {levels}: {off}");
                assert_eq!(found.g[middle(nodes)], 0.0);
            }
        }
    }

    /// A fifth of the pixels hold something that moved: the curve stays.
    #[test]
    fn what_moved_counts_little() {
        let (ln_exposures, mut codes, _) = bracket(srgb, 255.0);
        for (i, pixel) in codes.chunks_exact_mut(7).enumerate().filter(|(i, _)| i % 5 == 0) {
            let j = i / 5 % 7;
            pixel[j] = (0.5 + 0.4 * (i as f32).sin()).clamp(0.0, 1.0);
        }
        let samples = Samples { nodes: 256, ln_exposures: &ln_exposures, codes: &codes };
        let off = worst(&recover(&samples, LAMBDA).unwrap().g, &srgb);
        eprintln!("moved: {off:.4}");
        assert!(off < 0.1, "{off}");
    }

    /// Three exposures three stops apart, 300 pixels, a code of noise: smoothness must carry the curve.
    #[test]
    fn wide_steps_lean_on_smoothness() {
        let curves: [(&str, &dyn Fn(f64) -> f64); 3] =
            [("gamma", &|x| x.powf(1.0 / 2.2)), ("srgb", &srgb), ("film", &film)];
        for (name, f) in curves {
            let times = [1.0 / 64.0, 0.125, 1.0];
            let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
            let code = |x: f64, i: u32| ((255.0 * f(x.clamp(0.0, 1.0)) + 2.0 * noise(i)).round() / 255.0) as f32;
            let light = (0..300).map(|i| 10f64.powf(-1.5 + 3.0 * (0.5 + noise(i))));
            let codes: Vec<f32> = light
                .enumerate()
                .flat_map(|(i, e)| [0, 1, 2].map(|j| code(e * times[j], 7 * i as u32 + j as u32 + 1)))
                .collect();
            let ln_exposures = times.map(f64::ln);
            let samples = Samples { nodes: 256, ln_exposures: &ln_exposures, codes: &codes };
            let off = worst(&recover(&samples, LAMBDA).unwrap().g, f);
            eprintln!("wide steps, {name}: {off:.4}");
            assert!(off < 0.12, "{name}: {off}");
        }
    }

    #[test]
    fn nothing_to_see_is_said() {
        let ln_exposures = [0.0, 1.0];
        for code in [0.0, 1.0] {
            let codes = vec![code; 200];
            let samples = Samples { nodes: 256, ln_exposures: &ln_exposures, codes: &codes };
            assert!(recover(&samples, LAMBDA).unwrap_err().to_string().contains("only 0 of 100"));
        }
    }

    #[test]
    fn out_of_order_becomes_level_or_rising() {
        let mut g = vec![0.0, 2.0, 1.0, 3.0, 3.0, 4.0];
        assert_eq!(rise(&mut g), 3);
        assert!(g.windows(2).all(|w| w[0] < w[1]), "{g:?}");
        let mut fine = vec![0.0, 1.0, 2.0];
        assert_eq!(rise(&mut fine), 0);
    }
}
