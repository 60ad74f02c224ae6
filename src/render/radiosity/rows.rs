//! Form factors by casting rays: the share of the directions of an element, by cosine and area, in which it sees each other one
//! [Maxwell 1986].
//!
//! A row holds the elements that its rays meet, and how many. As many rows are kept as memory allows; those of the other elements
//! are traced again each time, by the same rays.

use rayon::prelude::*;

use crate::render::lanes::GROUP;
use crate::render::radiosity::mesh::Mesh;
use crate::render::sampler::Sampler;
use crate::scene::{Geometry, ray};
use crate::simd;

/// Elements whose rows are traced together.
const TOGETHER: usize = 64;
/// Most rays of an element: counts have 16 bits.
pub const MOST_RAYS: u32 = 65_535;
/// Bytes of an entry.
const ENTRY: usize = size_of::<Entry>();

/// An element that was met, and the rays that met it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, packed(2))]
pub struct Entry {
    element: u32,
    count: u16,
}

/// The rows of a mesh.
pub struct Rows<'a> {
    geometry: &'a Geometry,
    mesh: &'a Mesh,
    rays: u32,
    seed: u32,
    /// Runs of rows: entries, and where each row of the run ends. Those beyond are not kept.
    kept: Vec<(Vec<Entry>, Vec<u32>)>,
}

impl<'a> Rows<'a> {
    /// Traces `rays` from each element; keeps the rows that `most_bytes` have room for.
    pub fn trace(geometry: &'a Geometry, mesh: &'a Mesh, rays: u32, seed: u32, most_bytes: usize) -> Rows<'a> {
        let mut rows = Rows { geometry, mesh, rays: rays.min(MOST_RAYS), seed, kept: Vec::new() };
        let runs = mesh.len().div_ceil(TOGETHER);
        let mut bytes = 0;
        // Some at a time, so that what is thrown away in the end is little.
        const AT_A_TIME: usize = 256;
        for first in (0..runs).step_by(AT_A_TIME) {
            let some: Vec<_> =
                (first..(first + AT_A_TIME).min(runs)).into_par_iter().map(|run| rows.run(run)).collect();
            for (entries, ends) in some {
                bytes += entries.len() * ENTRY + ends.len() * size_of::<u32>();
                if bytes > most_bytes {
                    return rows;
                }
                rows.kept.push((entries, ends));
            }
        }
        rows
    }

    /// Rows that are kept.
    pub fn kept(&self) -> usize {
        (self.kept.len() * TOGETHER).min(self.mesh.len())
    }

    /// Of all rows.
    pub fn bytes(&self) -> usize {
        self.kept.iter().map(|(e, ends)| e.len() * ENTRY + ends.len() * size_of::<u32>()).sum()
    }

    fn run(&self, run: usize) -> (Vec<Entry>, Vec<u32>) {
        let (mut entries, mut ends, mut met) = (Vec::new(), Vec::new(), Vec::new());
        for element in run * TOGETHER..((run + 1) * TOGETHER).min(self.mesh.len()) {
            self.row(element as u32, &mut met, &mut entries);
            ends.push(entries.len() as u32);
        }
        entries.shrink_to_fit();
        (entries, ends)
    }

    /// Adds the row of one element.
    fn row(&self, element: u32, met: &mut Vec<u32>, entries: &mut Vec<Entry>) {
        met.clear();
        look_around(self.geometry, self.mesh, element, self.rays, self.seed, |e| met.push(e));
        met.sort_unstable();
        for same in met.chunk_by(|a, b| a == b) {
            entries.push(Entry { element: same[0], count: same.len() as u16 });
        }
    }

    /// For each element the mean of what it sees: `lanes` numbers an element in `from` and `to`.
    pub fn apply(&self, from: &[f32], to: &mut [f32], lanes: usize) {
        let scale = 1.0 / self.rays as f32;
        to.par_chunks_mut(TOGETHER * lanes).enumerate().for_each(|(run, to)| {
            let traced;
            let (entries, ends) = match self.kept.get(run) {
                Some(kept) => kept,
                None => {
                    traced = self.run(run);
                    &traced
                }
            };
            let mut start = 0;
            for (sums, end) in to.chunks_exact_mut(lanes).zip(ends) {
                sum_up(&entries[start..*end as usize], from, sums, scale);
                start = *end as usize;
            }
        });
    }
}

fn sum_up(entries: &[Entry], from: &[f32], sums: &mut [f32], scale: f32) {
    let lanes = sums.len();
    simd::wide(
        #[inline(always)]
        || {
            sums.fill(0.0);
            for entry in entries {
                let k = f32::from(entry.count) * scale;
                let row = &from[entry.element as usize * lanes..][..lanes];
                for (sums, row) in sums.chunks_exact_mut(GROUP).zip(row.chunks_exact(GROUP)) {
                    for i in 0..GROUP {
                        sums[i] += k * row[i];
                    }
                }
            }
        },
    );
}

/// The elements that rays from all over an element meet.
pub fn look_around(geometry: &Geometry, mesh: &Mesh, element: u32, rays: u32, seed: u32, mut meet: impl FnMut(u32)) {
    let (_, from) = mesh.element(element);
    let reach = from.tile.patch.reach();
    for i in 0..rays {
        let sampler = Sampler::new(element, 0x51ed_270b, i, seed);
        let (point, front) = from.tile.patch.place(from.square(sampler.pair(0)));
        let normal = if from.front { front } else { -front };
        let direction = ray::cosine_direction(normal, sampler.pair(1));
        let Some(hit) = geometry.closest(ray::offset(point, normal, reach), direction) else { continue };
        if let Some(met) = mesh.met(&hit, hit.normal.dot(direction) < 0.0) {
            meet(met);
        }
    }
}
