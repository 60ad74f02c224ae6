//! What an estimate makes of many probes at once.

use luxpipe::render::estimate::{Effort, Estimate, NEIGHBOURS, Probe};
use rayon::prelude::*;

/// Y of so many probes, by so many paths each, on all threads.
pub fn luminances(
    estimate: &dyn Estimate,
    count: usize,
    probe: impl Fn(usize) -> Probe + Sync,
    paths: u32,
) -> Vec<f64> {
    (0..count)
        .collect::<Vec<_>>()
        .par_chunks(NEIGHBOURS)
        .flat_map_iter(|run| {
            let probes: Vec<Probe> = run.iter().map(|i| probe(*i)).collect();
            let mut out = vec![0f32; 3 * probes.len()];
            estimate.measure(&probes, Effort::Paths(paths), &mut out);
            out.into_iter().skip(1).step_by(3).map(f64::from).collect::<Vec<_>>()
        })
        .collect()
}
