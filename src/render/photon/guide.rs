//! Photons are sent where they get anywhere: through a lamp's four numbers, two of its places and two of its directions, divided
//! into cells, more of them through cells from which others have arrived [Jensen's projection maps, for any scene].

/// Cells along each of the four.
const N: usize = 8;
/// All of them.
pub const CELLS: usize = N * N * N * N;
/// Share of photons that are spread evenly, whatever was learned: what was missed still gets some.
const EVEN: f64 = 0.2;
/// A largest cell below this many times the mean is not worth a guide.
const WORTH: f64 = 3.0;

/// Chances of cells.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Chance of this cell and all before it.
    sums: Vec<f64>,
}

/// The cell of four numbers in 0..1.
pub fn cell(place: [f32; 2], turn: [f32; 2]) -> usize {
    let index = |x: f32| ((x * N as f32) as usize).min(N - 1);
    ((index(place[0]) * N + index(place[1])) * N + index(turn[0])) * N + index(turn[1])
}

impl Guide {
    /// From the photons that set out in each cell, and those of them that arrived; `None` where all get about as far.
    pub fn new(sent: &[u32], arrived: &[u32]) -> Option<Guide> {
        let rate = |(s, a): (&u32, &u32)| if *s > 0 { f64::from(*a) / f64::from(*s) } else { 0.0 };
        let mut rates: Vec<f64> = sent.iter().zip(arrived).map(rate).collect();
        // What arrives from a cell may arrive from its neighbours.
        for stride in [1, N, N * N, N * N * N] {
            let old = rates.clone();
            for (i, rate) in rates.iter_mut().enumerate() {
                let at = i / stride % N;
                let low = if at > 0 { old[i - stride] } else { old[i] };
                let high = if at + 1 < N { old[i + stride] } else { old[i] };
                *rate = 0.25 * low + 0.5 * old[i] + 0.25 * high;
            }
        }
        let total: f64 = rates.iter().sum();
        let most = rates.iter().fold(0.0, |a: f64, b| a.max(*b));
        if total <= 0.0 || most * (CELLS as f64) < WORTH * total {
            return None;
        }
        let mut sum = 0.0;
        let chance = |r: &f64| {
            sum += EVEN / CELLS as f64 + (1.0 - EVEN) * r / total;
            sum
        };
        Some(Guide { sums: rates.iter().map(chance).collect() })
    }

    /// Moves four numbers into a cell chosen by lot; returns them and the density with which they are chosen now.
    pub fn place(&self, lot: f64, place: [f32; 2], turn: [f32; 2]) -> ([f32; 2], [f32; 2], f32) {
        let i = self.sums.partition_point(|s| *s <= lot).min(CELLS - 1);
        let chance = self.sums[i] - if i > 0 { self.sums[i - 1] } else { 0.0 };
        let within = |stride: usize, x: f32| ((i / stride % N) as f32 + x) / N as f32;
        let place = [within(N * N * N, place[0]), within(N * N, place[1])];
        (place, [within(N, turn[0]), within(1, turn[1])], (chance * CELLS as f64) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sampler::Sampler;

    /// The mean of any function stays what it is, however it is sampled.
    #[test]
    fn a_guide_does_not_bend_means() {
        let mut arrived = vec![0; CELLS];
        arrived[cell([0.3, 0.6], [0.1, 0.9])] = 7;
        let guide = Guide::new(&vec![8; CELLS], &arrived).unwrap();
        let (mut mean, mut inside) = (0.0, 0.0);
        let n = 1 << 16;
        for i in 0..n {
            let s = Sampler::new(1, 2, i, 3);
            let (place, turn, density) = guide.place(s.pair(0)[0].into(), s.pair(1), s.pair(2));
            assert!(place.iter().chain(&turn).all(|x| (0.0..1.0).contains(x)));
            let weight = f64::from(1.0 / density) / f64::from(n);
            mean += weight * f64::from(place[0] * turn[1]);
            inside += if cell(place, turn) == cell([0.3, 0.6], [0.1, 0.9]) { 1.0 / f64::from(n) } else { 0.0 };
        }
        assert!((mean - 0.25).abs() < 0.01, "{mean}");
        assert!(inside > 100.0 / CELLS as f64, "{inside}");
        assert!(Guide::new(&vec![8; CELLS], &vec![5; CELLS]).is_none());
    }
}
