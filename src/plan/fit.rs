//! A rule of K wavelengths for a scene's products: which wavelengths, by greedy selection and exchange on the sum of squared errors
//! of all lights and channels, in a measure near CIELAB; what they weigh, by least squares without negative weights, whose rows then
//! count for more where the error is large [Lawson 1961], so that the worst becomes small.

use crate::color::difference::lab;
use crate::compare::Viewing;
use crate::plan::least::{factor, forth, nonnegative};
use crate::plan::products::{Products, at_nodes, error};
use crate::plan::survey::Survey;
use crate::spectral::Rule;

/// Products that a rule is fitted to; of more, as many, evenly.
const ROWS: usize = 700;
/// Rounds of exchange, and of weighting.
const EXCHANGES: usize = 4;
const ROUNDS: usize = 12;

/// What a rule is fitted to: sums over products, by light and channel.
pub struct Fit<'a> {
    survey: &'a Survey,
    viewing: Viewing,
    products: Products,
    /// [product][candidate].
    left: Vec<Vec<f64>>,
    /// [light x channel]: how much a unit of error counts, by product.
    counts: Vec<Vec<f64>>,
    /// [light x channel]: sums over products of what is left at two candidates, and of it and the colour.
    grams: Vec<(Vec<f64>, Vec<f64>)>,
}

impl<'a> Fit<'a> {
    /// To these products, all or some.
    pub fn new(survey: &'a Survey, all: &Products, viewing: Viewing) -> Fit<'a> {
        let counts = vec![Vec::new(); 3 * survey.lights.len()];
        let (products, left, grams) = Default::default();
        let mut fit = Fit { survey, viewing, products, left, counts, grams };
        let step = all.met.len().div_ceil(ROWS).max(1);
        let some = (0..all.met.len()).filter(|i| i % step == 0 || all.met[*i].len() <= 1);
        fit.learn(all, &some.collect::<Vec<_>>());
        let every: Vec<usize> = (0..survey.candidates_nm.len()).collect();
        fit.grams = (0..fit.counts.len()).map(|i| fit.gram(i, &every, &fit.counts[i])).collect();
        fit
    }

    /// More products to weigh by; which wavelengths they are weighed at stays.
    pub fn learn(&mut self, all: &Products, which: &[usize]) {
        let lights = self.survey.lights.len();
        let every: Vec<usize> = (0..self.survey.candidates_nm.len()).collect();
        for i in which {
            let colours = &all.xyz[i * lights..][..lights];
            self.left.push(at_nodes(self.survey, &all.met[*i], &every));
            self.products.met.push(all.met[*i].clone());
            self.products.xyz.extend_from_slice(colours);
            for (l, xyz) in colours.iter().enumerate() {
                for (c, count) in slopes(&self.viewing, *xyz).into_iter().enumerate() {
                    self.counts[3 * l + c].push(count * count);
                }
            }
        }
    }

    /// Sums for one light and channel over some candidates.
    fn gram(&self, which: usize, nodes: &[usize], counts: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (n, lights) = (nodes.len(), self.survey.lights.len());
        let (mut gram, mut b) = (vec![0.0; n * n], vec![0.0; n]);
        for (row, (left, count)) in self.left.iter().zip(counts).enumerate() {
            let own: Vec<f64> = nodes.iter().map(|k| left[*k]).collect();
            let want = self.products.xyz[row * lights + which / 3][which % 3];
            for i in 0..n {
                let k = count * own[i];
                b[i] += k * want;
                // The lower triangle; the rest is its mirror.
                gram[i * n..=i * n + i].iter_mut().zip(&own).for_each(|(g, x)| *g += k * x);
            }
        }
        for i in 0..n {
            for j in i + 1..n {
                gram[i * n + j] = gram[j * n + i];
            }
        }
        (gram, b)
    }

    /// Takes wavelengths in until there are K, each the one that leaves least, then exchanges each for a better one while there is any.
    pub fn choose(&self, nodes: &mut Vec<usize>, k: usize) {
        while nodes.len() < k {
            let Some(best) = self.best(nodes) else { break };
            nodes.push(best);
        }
        for _ in 0..EXCHANGES {
            let before = nodes.clone();
            for i in 0..nodes.len() {
                let old = nodes.remove(i);
                let new = self.best(nodes).unwrap_or(old);
                nodes.insert(i, new);
            }
            if *nodes == before {
                break;
            }
        }
        nodes.sort_unstable();
    }

    /// The candidate that takes most of the error beside these, if any takes some: greys need one.
    fn best(&self, nodes: &[usize]) -> Option<usize> {
        let n = self.survey.candidates_nm.len();
        let mut gains = vec![0.0; n];
        for (gram, b) in &self.grams {
            let root = factor(gram, n, nodes)?;
            let y = forth(&root, nodes.iter().map(|i| b[*i]).collect());
            for j in (0..n).filter(|j| !nodes.contains(j)) {
                // What the others do not have of it.
                let z = forth(&root, nodes.iter().map(|i| gram[i * n + j]).collect());
                let rest = gram[j * n + j] - z.iter().map(|z| z * z).sum::<f64>();
                if rest > 1e-9 * gram[j * n + j] {
                    gains[j] += (b[j] - z.iter().zip(&y).map(|(z, y)| z * y).sum::<f64>()).powi(2) / rest;
                }
            }
        }
        (0..n).filter(|j| gains[*j] > 0.0).max_by(|a, b| gains[*a].total_cmp(&gains[*b]))
    }

    /// The weights of these wavelengths, for lights of Y = 100.
    pub fn weigh(&self, nodes: &[usize]) -> Rule {
        let lights = self.survey.lights.len();
        let nodes_nm: Vec<f64> = nodes.iter().map(|i| self.survey.candidates_nm[*i]).collect();
        let mut more = vec![1.0; self.products.met.len() * lights];
        let mut best: Option<(Rule, f64)> = None;
        for _ in 0..ROUNDS {
            let of = |which: usize| {
                let counts: Vec<f64> =
                    self.counts[which].iter().enumerate().map(|(row, c)| c * more[row * lights + which / 3]).collect();
                let (gram, b) = self.gram(which, nodes, &counts);
                nonnegative(&gram, &b)
            };
            let weights = (0..lights).map(|l| [0, 1, 2].map(|c| of(3 * l + c))).collect();
            let rule = Rule { nodes_nm: nodes_nm.clone(), weights };
            let (mut worst, mut sum) = (0f64, 0.0);
            let mut errors = Vec::with_capacity(more.len());
            for (left, colours) in self.left.iter().zip(self.products.xyz.chunks_exact(lights)) {
                let own: Vec<f64> = nodes.iter().map(|k| left[*k]).collect();
                for (l, want) in colours.iter().enumerate() {
                    let e = error(&self.viewing, rule.xyz(l, &own), *want);
                    worst = worst.max(e);
                    sum += e;
                    errors.push(e);
                }
            }
            if best.as_ref().is_none_or(|b| worst < b.1) {
                best = Some((rule, worst));
            }
            let mean = (sum / errors.len() as f64).max(1e-12);
            more.iter_mut().zip(&errors).for_each(|(m, e)| *m *= (e / mean).max(0.1));
            let all = more.iter().sum::<f64>() / more.len() as f64;
            more.iter_mut().for_each(|m| *m /= all);
        }
        best.map_or(Rule { nodes_nm, weights: Vec::new() }, |b| b.0)
    }
}

/// How fast CIELAB changes with X, Y and Z at a lifted colour, less where it is saturated, as CIEDE2000 has it.
fn slopes(viewing: &Viewing, xyz: [f64; 3]) -> [f64; 3] {
    let lift = viewing.lift(xyz[1]);
    let [_, a, b] = lab(xyz.map(|x| x * lift), viewing.white);
    let muted = lift / (1.0 + 0.045 * a.hypot(b));
    let slope = |i: usize, factor: f64| {
        let t = xyz[i] * lift / viewing.white[i];
        let root = if t > 0.008856 { t.powf(-2.0 / 3.0) / 3.0 } else { 7.787 };
        factor * muted * root / viewing.white[i]
    };
    // L* = 116 y - 16, a* = 500 (x - y), b* = 200 (y - z).
    [slope(0, 500.0), slope(1, (116f64 * 116.0 + 500.0 * 500.0 + 200.0 * 200.0).sqrt()), slope(2, 200.0)]
}
