//! The balance of light between elements, `x = b + F (rho x)`: for all wavelengths of one light at once by the stabilised
//! bi-conjugate gradient method [van der Vorst 1992], which takes a dozen steps where the mere sum over bounces takes hundreds.

use rayon::prelude::*;

use crate::render::lanes::GROUP;

/// Steps at most.
const MOST_STEPS: usize = 200;
/// Elements whose products are summed in one go; sums are then added in order, whatever the threads.
const TOGETHER: usize = 512;

/// How well it was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solved {
    /// Largest of all wavelengths' residuals, over that of no light between surfaces at all.
    pub residual: f64,
    /// Steps taken.
    pub steps: usize,
}

impl Solved {
    /// The worse of two.
    pub fn worse(self, o: Solved) -> Solved {
        Solved { residual: self.residual.max(o.residual), steps: self.steps.max(o.steps) }
    }
}

/// Reflectances, a row of lanes an element, and what elements see.
pub struct System<'a, F: Fn(&[f32], &mut [f32]) + Sync> {
    /// Numbers an element, a multiple of 8.
    pub lanes: usize,
    /// Reflectance of each element.
    pub reflectance: &'a [f32],
    /// Mean of the radiance that each element sees, from that of each element.
    pub sees: F,
}

impl<F: Fn(&[f32], &mut [f32]) + Sync> System<'_, F> {
    /// What elements see of light that falls on them and is sent on once.
    pub fn once(&self, light: &[f32], scratch: &mut [f32], out: &mut [f32]) {
        self.each(scratch, |at, row| {
            let (light, rho) = (&light[at..], &self.reflectance[at..]);
            for i in 0..row.len() {
                row[i] = light[i] * rho[i];
            }
        });
        (self.sees)(scratch, out);
    }

    /// Light on elements that comes from others, given what comes straight from the lamps; stops at a residual of `tolerance`.
    pub fn solve(&self, direct: &[f32], tolerance: f64) -> (Vec<f32>, Solved) {
        let n = direct.len();
        let new = || vec![0f32; n];
        let (mut x, mut r, mut p, mut v, mut t, mut scratch) = (new(), new(), new(), new(), new(), new());
        self.once(direct, &mut scratch, &mut r);
        let size = self.dot(&r, &r);
        let shadow = r.clone();
        let mut rho = size.clone();
        p.copy_from_slice(&r);
        let residual = |r: &[f32]| -> f64 {
            let now = self.dot(r, r);
            let of = |(r, b): (&f64, &f64)| if *b > 0.0 { (r / b).sqrt() } else { 0.0 };
            now.iter().zip(&size).map(of).fold(0.0, f64::max)
        };
        let mut solved = Solved { residual: residual(&r), steps: 0 };
        while solved.residual > tolerance && solved.steps < MOST_STEPS {
            // v = (1 - F rho) p
            self.once(&p, &mut scratch, &mut v);
            self.each(&mut v, |at, row| combine(row, &p[at..], |v, p| p - v));
            let alpha = ratio(&rho, &self.dot(&shadow, &v));
            self.each(&mut x, |at, row| self.step(row, &p[at..], &alpha));
            self.each(&mut r, |at, row| self.step(row, &v[at..], &negative(&alpha)));
            // t = (1 - F rho) r
            self.once(&r, &mut scratch, &mut t);
            self.each(&mut t, |at, row| combine(row, &r[at..], |t, r| r - t));
            let omega = ratio(&self.dot(&t, &r), &self.dot(&t, &t));
            self.each(&mut x, |at, row| self.step(row, &r[at..], &omega));
            self.each(&mut r, |at, row| self.step(row, &t[at..], &negative(&omega)));
            let next = self.dot(&shadow, &r);
            let beta: Vec<f32> = ratio(&next, &rho).iter().zip(ratio32(&alpha, &omega)).map(|(a, b)| a * b).collect();
            self.each(&mut p, |at, row| self.turn(row, &r[at..], &v[at..], &beta, &omega));
            rho = next;
            solved.residual = residual(&r);
            solved.steps += 1;
            if !solved.residual.is_finite() {
                break;
            }
        }
        // The residual carried along drifts from the true one.
        self.once(direct, &mut scratch, &mut r);
        self.once(&x, &mut scratch, &mut t);
        self.each(&mut r, |at, row| {
            let (x, t) = (&x[at..], &t[at..]);
            for i in 0..row.len() {
                row[i] += t[i] - x[i];
            }
        });
        solved.residual = residual(&r);
        (x, solved)
    }

    /// Pieces of whole elements, all threads.
    fn each(&self, out: &mut [f32], f: impl Fn(usize, &mut [f32]) + Sync) {
        let piece = TOGETHER * self.lanes;
        out.par_chunks_mut(piece).enumerate().for_each(|(i, row)| f(i * piece, row));
    }

    /// row += k more, a factor a lane.
    fn step(&self, row: &mut [f32], more: &[f32], k: &[f32]) {
        for (row, more) in row.chunks_exact_mut(self.lanes).zip(more.chunks_exact(self.lanes)) {
            for i in 0..self.lanes {
                row[i] += k[i] * more[i];
            }
        }
    }

    /// p = r + beta (p - omega v)
    fn turn(&self, p: &mut [f32], r: &[f32], v: &[f32], beta: &[f32], omega: &[f32]) {
        let n = self.lanes;
        for ((p, r), v) in p.chunks_exact_mut(n).zip(r.chunks_exact(n)).zip(v.chunks_exact(n)) {
            for i in 0..n {
                p[i] = r[i] + beta[i] * (p[i] - omega[i] * v[i]);
            }
        }
    }

    /// Sum of products, a lane each.
    fn dot(&self, a: &[f32], b: &[f32]) -> Vec<f64> {
        let piece = TOGETHER * self.lanes;
        let parts: Vec<Vec<f64>> = a
            .par_chunks(piece)
            .zip(b.par_chunks(piece))
            .map(|(a, b)| {
                let mut sums = vec![0f64; self.lanes];
                for (a, b) in a.chunks_exact(self.lanes).zip(b.chunks_exact(self.lanes)) {
                    for (k, sums) in sums.chunks_exact_mut(GROUP).enumerate() {
                        let (a, b) = (&a[k * GROUP..], &b[k * GROUP..]);
                        for i in 0..GROUP {
                            sums[i] += f64::from(a[i]) * f64::from(b[i]);
                        }
                    }
                }
                sums
            })
            .collect();
        let mut all = vec![0f64; self.lanes];
        parts.iter().for_each(|p| all.iter_mut().zip(p).for_each(|(a, p)| *a += p));
        all
    }
}

fn combine(row: &mut [f32], other: &[f32], f: impl Fn(f32, f32) -> f32) {
    row.iter_mut().zip(other).for_each(|(a, b)| *a = f(*a, *b));
}

/// Lanes that are done stay where they are.
fn ratio(a: &[f64], b: &[f64]) -> Vec<f32> {
    a.iter().zip(b).map(|(a, b)| if *b != 0.0 && (a / b).is_finite() { (a / b) as f32 } else { 0.0 }).collect()
}

fn ratio32(a: &[f32], b: &[f32]) -> Vec<f32> {
    a.iter().zip(b).map(|(a, b)| if *b != 0.0 { a / b } else { 0.0 }).collect()
}

fn negative(a: &[f32]) -> Vec<f32> {
    a.iter().map(|a| -a).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two infinite plates that face each other: light that comes from the other is `r2 (1 + r1) / (1 - r1 r2)` of what falls on
    /// both alike; and a wall of reflectance 0.99 on all sides, where the sum over bounces takes a thousand steps.
    #[test]
    fn plates_and_white_rooms() {
        let plates = |from: &[f32], to: &mut [f32]| {
            to[..8].copy_from_slice(&from[8..]);
            to[8..].copy_from_slice(&from[..8]);
        };
        let reflectance: Vec<f32> = [[0.5f32; 8], [0.8; 8]].concat();
        let system = System { lanes: 8, reflectance: &reflectance, sees: plates };
        let (x, solved) = system.solve(&[1.0; 16], 1e-6);
        assert!(solved.residual < 1e-5, "{solved:?}");
        for (got, want) in x.iter().zip([[0.8 * 1.5 / 0.6; 8], [0.5 * 1.8 / 0.6; 8]].concat()) {
            assert!((got / want - 1.0f32).abs() < 1e-5, "{got} for {want}");
        }
        let n = 100;
        let room = |from: &[f32], to: &mut [f32]| {
            let mean: f32 = from.iter().step_by(8).sum::<f32>() / n as f32;
            to.fill(mean);
        };
        let reflectance = vec![0.99; 8 * n];
        let direct: Vec<f32> = (0..8 * n).map(|i| if i < 8 { n as f32 } else { 0.0 }).collect();
        let (x, solved) = System { lanes: 8, reflectance: &reflectance, sees: room }.solve(&direct, 1e-5);
        assert!(solved.steps < 8 && (x[0] / 99.0 - 1.0).abs() < 1e-3, "{solved:?}: {}", x[0]);
    }
}
