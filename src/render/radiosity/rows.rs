//! Form factors by casting rays: the share of the directions of an element, by cosine and area, in which it sees each other one
//! [Maxwell 1986].
//!
//! A row holds the elements that its rays meet, and how many. Where memory has no room for all rows they are of fewer rays; where
//! it has room for hardly any, those of the other elements are traced again each time, by the same rays.

use rayon::prelude::*;

use crate::render::lanes::GROUP;
use crate::render::radiosity::cover::Ground;
use crate::render::sampler::Sampler;
use crate::scene::ray;
use crate::simd;

/// Elements whose rows are traced together.
const TOGETHER: usize = 64;
/// Most rays of an element: counts have 16 bits.
pub const MOST_RAYS: u32 = 65_535;

/// Bytes of a row for each of its rays, at most.
pub const BYTES_A_RAY: usize = size_of::<Entry>();
/// Rather than by fewer rays rows are traced again.
const FEWEST: u32 = 64;
/// Fewer rays meet elements more than once less often.
const SLACK: f64 = 0.9;

/// An element that was met, and the rays that met it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, packed(2))]
pub struct Entry {
    element: u32,
    count: u16,
}

/// Rows of elements side by side.
#[derive(Default)]
struct Run {
    entries: Vec<Entry>,
    /// Where each row ends, and how many rays it is of.
    ends: Vec<(u32, u32)>,
}

impl Run {
    fn bytes(&self) -> usize {
        self.entries.len() * size_of::<Entry>() + size_of_val(&self.ends[..])
    }
}

/// The rows of a mesh.
pub struct Rows<'a> {
    ground: Ground<'a>,
    rays: u32,
    seed: u32,
    /// Runs of rows; those beyond are not kept.
    kept: Vec<Run>,
}

impl<'a> Rows<'a> {
    /// Traces `rays` from each element; where `most_bytes` have no room for their rows, fewer, and where that would be hardly
    /// any it keeps the rows that there is room for.
    pub fn trace(ground: Ground<'a>, rays: u32, seed: u32, most_bytes: usize) -> Rows<'a> {
        let mut rows = Rows { ground, rays: rays.min(MOST_RAYS), seed, kept: Vec::new() };
        while let Err(share) = rows.keep(most_bytes) {
            let fewer = (f64::from(rows.rays) * SLACK * share) as u32;
            if fewer < FEWEST {
                break;
            }
            rows.rays = fewer;
        }
        rows
    }

    /// Traces rows as long as there is room; otherwise the share of all that there was room for.
    fn keep(&mut self, most_bytes: usize) -> std::result::Result<(), f64> {
        // Some at a time, so that what is thrown away in the end is little.
        const AT_A_TIME: usize = 256;
        self.kept.clear();
        let runs = self.ground.mesh.len().div_ceil(TOGETHER);
        let mut bytes = 0;
        for first in (0..runs).step_by(AT_A_TIME) {
            let some: Vec<_> =
                (first..(first + AT_A_TIME).min(runs)).into_par_iter().map(|run| self.run(run)).collect();
            for run in some {
                bytes += run.bytes();
                if bytes > most_bytes {
                    return Err(self.kept.len() as f64 / runs as f64);
                }
                self.kept.push(run);
            }
        }
        Ok(())
    }

    /// Rays from each element.
    pub fn rays(&self) -> u32 {
        self.rays
    }

    /// Rows that are kept.
    pub fn kept(&self) -> usize {
        (self.kept.len() * TOGETHER).min(self.ground.mesh.len())
    }

    /// Of all rows.
    pub fn bytes(&self) -> usize {
        self.kept.iter().map(Run::bytes).sum()
    }

    fn run(&self, run: usize) -> Run {
        let (mut found, mut met) = (Run::default(), Vec::new());
        for element in run * TOGETHER..((run + 1) * TOGETHER).min(self.ground.mesh.len()) {
            let rays = self.row(element as u32, &mut met, &mut found.entries);
            found.ends.push((found.entries.len() as u32, rays));
        }
        found.entries.shrink_to_fit();
        found
    }

    /// Adds the row of one element; returns how many rays it is of.
    fn row(&self, element: u32, met: &mut Vec<u32>, entries: &mut Vec<Entry>) -> u32 {
        met.clear();
        let rays = look_around(self.ground, element, self.rays, self.seed, |e| met.push(e));
        met.sort_unstable();
        for same in met.chunk_by(|a, b| a == b) {
            entries.push(Entry { element: same[0], count: same.len() as u16 });
        }
        rays
    }

    /// For each element the mean of what it sees: `lanes` numbers an element in `from` and `to`.
    pub fn apply(&self, from: &[f32], to: &mut [f32], lanes: usize) {
        to.par_chunks_mut(TOGETHER * lanes).enumerate().for_each(|(run, to)| {
            let traced;
            let rows = match self.kept.get(run) {
                Some(kept) => kept,
                None => {
                    traced = self.run(run);
                    &traced
                }
            };
            let mut start = 0;
            for (sums, (end, rays)) in to.chunks_exact_mut(lanes).zip(&rows.ends) {
                sum_up(&rows.entries[start..*end as usize], from, sums, 1.0 / (*rays).max(1) as f32);
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

/// Evenly spread points of the unit hypercube, for directions and places together: multiples of powers of the root of
/// `x^5 = x + 1`, as the golden ratio's are even on a line [Roberts 2018, The unreasonable effectiveness of quasirandom
/// sequences], moved from where they begin. Two scrambled nets, one for directions and one for places, are each more even
/// but not together.
#[derive(Clone, Copy)]
struct Spread {
    start: [u32; 4],
}

impl Spread {
    /// Powers -1 to -4 of the root 1.167304, in units of 2^-32.
    const STEPS: [u32; 4] = [3_679_390_609, 3_152_041_523, 2_700_274_806, 2_313_257_605];

    fn of(number: u32, seed: u32) -> Spread {
        let sampler = Sampler::new(number, 0x51ed_270b, 0, seed);
        let [[a, b], [c, d]] = [sampler.pair(0), sampler.pair(1)];
        Spread { start: [a, b, c, d].map(|x| (f64::from(x) * 4_294_967_296.0) as u32) }
    }

    fn point(self, i: u32) -> [f32; 4] {
        std::array::from_fn(|k| {
            let fixed = self.start[k].wrapping_add(i.wrapping_mul(Self::STEPS[k]));
            (fixed >> 8) as f32 / 16_777_216.0
        })
    }
}

/// The elements that rays from all over an element meet; returns how many rays there were. None start where the element is
/// covered.
fn look_around(ground: Ground, number: u32, rays: u32, seed: u32, mut meet: impl FnMut(u32)) -> u32 {
    let (_, element) = ground.mesh.element(number);
    let (reach, is_open) = (element.tile.patch.reach(), ground.opening(number));
    let spread = Spread::of(number, seed);
    let mut started = 0;
    for i in 0..rays {
        let [a, b, u, v] = spread.point(i);
        let (point, normal) = element.place([u, v]);
        let origin = ray::offset(point, normal, reach);
        if !is_open(origin, normal) {
            continue;
        }
        started += 1;
        let direction = ray::cosine_direction(normal, [a, b]);
        let Some(hit) = ground.geometry.closest(origin, direction) else { continue };
        if let Some(met) = ground.mesh.met(&hit, hit.normal.dot(direction) < 0.0) {
            meet(met);
        }
    }
    started
}
