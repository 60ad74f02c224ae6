//! What becomes of light that meets several surfaces in turn, and how far a rule is off.
//!
//! Every pixel is a mixture of products of a light with reflectances, none counted negative, and a rule is linear: its error in XYZ is
//! the same mixture of the products' errors. A bound on the worst product bounds the picture where the measure of error is convex.
//! CIEDE2000 is not, and light meets more than four surfaces, so that the worst product is taken [`SAFETY`] times: tested, not proved.

use crate::color::difference::delta_e_2000;
use crate::compare::Viewing;
use crate::plan::survey::{BINS, Survey};
use crate::spectral::Rule;

/// Of the worst product. It held in 1820 of 1821 random scenes when it was chosen, and for each of those that the tests render.
pub const SAFETY: f64 = 1.5;
/// Surfaces in turn.
pub const BOUNCES: usize = 4;
/// Surfaces in turn of the worst that are followed further, and how many of those.
const DEEPEST: usize = 10;
const FOLLOWED: usize = 48;
/// Rounds in which worse products are sought near the worst.
const CLIMBS: usize = 6;
/// Products that are all looked at; of more, a part, from which the worst are sought.
const MOST: usize = 20_475;

/// Numbers of the shares that light has met, in ascending order.
pub type Met = Vec<u8>;

/// Products with their colours.
#[derive(Clone, Debug, Default)]
pub struct Products {
    /// What has been met.
    pub met: Vec<Met>,
    /// [product x light]: XYZ, the light itself Y = 100.
    pub xyz: Vec<[f64; 3]>,
}

/// How products are looked at: the lights' mean is white.
pub fn viewing(survey: &Survey, gain: f64) -> Viewing {
    let mut white = [0.0; 3];
    for light in &survey.lights {
        white.iter_mut().zip(light.xyz()).for_each(|(sum, w)| *sum += w / survey.lights.len() as f64);
    }
    Viewing { white, gain, shown: None }
}

/// Delta E 2000 of a colour, both lifted as a viewer may lift them.
pub fn error(viewing: &Viewing, got: [f64; 3], want: [f64; 3]) -> f64 {
    let lift = viewing.lift(want[1]);
    delta_e_2000(got.map(|x| x * lift), want.map(|x| x * lift), viewing.white)
}

impl Products {
    /// All of up to [`BOUNCES`] surfaces where they are few enough: `true`; else those of one and two, and as many of the others as fill
    /// the rest, spread evenly.
    pub fn of(survey: &Survey) -> (Products, bool) {
        let n = survey.shares.len();
        let mut products = Products::default();
        let all = (0..=survey.surfaces).map(|k| choices(n, k)).sum::<usize>();
        products.add(survey, vec![Met::new()]);
        for k in 1..=survey.surfaces {
            let count = choices(n, k);
            let room = MOST.saturating_sub(products.met.len()) / (survey.surfaces + 1 - k);
            let step = if all <= MOST || k <= 2 { 1 } else { count.div_ceil(room.max(1)) };
            products.add(survey, (0..count).step_by(step).map(|i| multiset(i, k)).collect());
        }
        (products, all <= MOST)
    }

    /// What more surfaces make of the worst of these, whose errors are known: the worst by one more spectrum each, the worst of those by
    /// another, up to [`DEEPEST`], with their errors. What comes that far is dark, and seen where mirrors face each other.
    pub fn deeper(
        &self,
        survey: &Survey,
        nodes: &[usize],
        rule: &Rule,
        view: &Viewing,
        errors: &[f64],
    ) -> (Products, Vec<f64>) {
        let mut front: Vec<Met> = worst(errors, FOLLOWED).into_iter().map(|i| self.met[i].clone()).collect();
        let (mut found, mut found_errors) = (Products::default(), Vec::new());
        let deepest = if survey.surfaces < BOUNCES { BOUNCES } else { DEEPEST };
        for _ in BOUNCES..deepest {
            let by = |m: &Met| (0..survey.shares.len() as u8).map(|i| [&m[..], &[i]].concat()).collect::<Vec<_>>();
            let mut more: Vec<Met> = front.iter().flat_map(by).collect();
            more.iter_mut().for_each(|m| m.sort_unstable());
            more.sort_unstable();
            more.dedup();
            let mut next = Products::default();
            next.add(survey, more);
            let errors = next.errors(survey, nodes, rule, view);
            front = worst(&errors, FOLLOWED).into_iter().map(|i| next.met[i].clone()).collect();
            found.append(&mut next);
            found_errors.extend(errors);
        }
        (found, found_errors)
    }

    /// Products near the worst of these, whose errors are known: one spectrum exchanged for each other, the worst of those again, as long as
    /// that finds worse ones. Where only a part is looked at, this is where the worst of the others are.
    pub fn climbed(&self, survey: &Survey, nodes: &[usize], rule: &Rule, view: &Viewing, errors: &[f64]) -> Products {
        let mut known: std::collections::BTreeSet<Met> = self.met.iter().cloned().collect();
        let mut front: Vec<Met> = worst(errors, FOLLOWED).into_iter().map(|i| self.met[i].clone()).collect();
        let (mut found, mut most) = (Products::default(), errors.iter().copied().fold(0.0, f64::max));
        for _ in 0..CLIMBS {
            let mut next = Products::default();
            let exchanged = front.iter().flat_map(|m| exchanges(m, survey.shares.len() as u8));
            next.add(survey, exchanged.filter(|m| known.insert(m.clone())).collect());
            let errors = next.errors(survey, nodes, rule, view);
            front = worst(&errors, FOLLOWED).into_iter().map(|i| next.met[i].clone()).collect();
            let better = errors.iter().copied().fold(0.0, f64::max);
            found.append(&mut next);
            if better <= most {
                break;
            }
            most = better;
        }
        found
    }

    /// Takes in others.
    pub fn append(&mut self, others: &mut Products) {
        self.met.append(&mut others.met);
        self.xyz.append(&mut others.xyz);
    }

    /// Works out the colours of more.
    pub fn add(&mut self, survey: &Survey, more: Vec<Met>) {
        for met in more {
            let mut left = [1.0; BINS];
            for i in &met {
                left.iter_mut().zip(&survey.shares[usize::from(*i)].fine).for_each(|(l, s)| *l *= s);
            }
            for light in &survey.lights {
                self.xyz.push(light.weights.each_ref().map(|w| dot(w, &left)));
            }
            self.met.push(met);
        }
    }

    /// Of each product, the largest error of all lights, by a rule whose wavelengths are these candidates and whose weights are of lights
    /// of Y = 100.
    pub fn errors(&self, survey: &Survey, nodes: &[usize], rule: &Rule, viewing: &Viewing) -> Vec<f64> {
        let lights = survey.lights.len();
        let one = |(met, want): (&Met, &[[f64; 3]])| {
            let left = at_nodes(survey, met, nodes);
            want.iter().enumerate().map(|(l, want)| error(viewing, rule.xyz(l, &left), *want)).fold(0.0, f64::max)
        };
        self.met.iter().zip(self.xyz.chunks_exact(lights)).map(one).collect()
    }
}

/// A product with one spectrum exchanged for another, in all ways.
fn exchanges(met: &Met, spectra: u8) -> Vec<Met> {
    let one = |(at, to): (usize, u8)| {
        let mut new = met.clone();
        new[at] = to;
        new.sort_unstable();
        new
    };
    (0..met.len()).flat_map(|at| (0..spectra).map(move |to| (at, to))).map(one).collect()
}

/// Which are the largest, so many of them.
pub fn worst(errors: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..errors.len()).collect();
    order.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
    order.truncate(count);
    order
}

/// What is left at the nodes after these.
pub fn at_nodes(survey: &Survey, met: &[u8], nodes: &[usize]) -> Vec<f64> {
    nodes.iter().map(|k| met.iter().map(|i| survey.shares[usize::from(*i)].at[*k]).product()).collect()
}

fn dot(a: &[f64], b: &[f64; BINS]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum()
}

/// Multisets of k out of n.
fn choices(n: usize, k: usize) -> usize {
    (0..k).fold(1usize, |c, i| c.saturating_mul(n + i) / (i + 1))
}

/// Multiset number i of k, in the order of their largest members: the combinatorial number system.
fn multiset(mut i: usize, k: usize) -> Met {
    let mut met = vec![0u8; k];
    for size in (1..=k).rev() {
        // The largest member m such that `choices(m, size)` multisets have smaller ones only.
        let mut m = 0;
        while choices(m + 1, size) <= i {
            m += 1;
        }
        i -= choices(m, size);
        met[size - 1] = m as u8;
    }
    met
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_multiset_is_counted_once() {
        for (n, k) in [(1, 4), (3, 2), (5, 3), (7, 4)] {
            let all: Vec<Met> = (0..choices(n, k)).map(|i| multiset(i, k)).collect();
            assert!(all.iter().all(|m| m.windows(2).all(|w| w[0] <= w[1]) && m.iter().all(|x| usize::from(*x) < n)));
            let distinct: std::collections::BTreeSet<_> = all.iter().collect();
            assert_eq!(distinct.len(), all.len());
        }
        assert_eq!([choices(24, 4), choices(24, 3), choices(24, 2)], [17550, 2600, 300]);
    }
}
