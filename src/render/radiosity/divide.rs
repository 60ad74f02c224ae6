//! How far surfaces are divided: solutions by few rays tell where what is linear between elements errs.

use std::collections::HashMap;

use crate::render::radiosity::cover::Cover;
use crate::render::radiosity::mesh::{Mesh, Tile};
use crate::render::radiosity::prepare::Workshop;
use crate::render::radiosity::{Account, Show};

/// Rays that tell an error of 2 % where surfaces are to be divided.
const ROUGH: f64 = 64.0;
/// Length of elements at first, in the scene's own scale: about a tenth of a room.
const COARSE: f32 = 0.3;
/// Beyond this it makes no fewer.
const LONGEST: f32 = 1e4;
/// Elements that a scene begins with, or four a side and surface where these are more.
const MANY_AT_FIRST: usize = 8192;
/// Most elements along a side at first, and at last.
const MOST_AT_FIRST: u32 = 64;
const MOST_ALONG: u32 = 1024;
/// Times that surfaces are divided.
const MOST_LEVELS: usize = 8;
/// Dividing has to leave less than this of an error to be worth while: of what is smooth it leaves a quarter.
const WORTH: f64 = 0.75;
/// Sides with less than this of the mean error are not worth another trial.
const LITTLE: f64 = 0.25;
/// Darker places than this share of the mean need not be known better than it.
const DARK: f32 = 0.05;

/// A tile, and whether its front is meant.
type Side = (usize, bool);

/// A side, and how far what is linear between its elements errs.
struct Judged {
    side: Side,
    /// Relative to the light on it.
    error: f64,
    /// Part of the mean error of all sides, by area and light: the inside of a box does not count as its outside does.
    part: f64,
}

fn mean(judged: &[Judged]) -> f64 {
    judged.iter().map(|j| j.part).sum()
}

/// Elements that a scene begins with, `divide` along both sides of each surface or so many that a room has about ten along its.
pub fn at_first(mesh: &mut Mesh, divide: Option<u32>) {
    if let Some(n) = divide {
        return mesh.grid(|_| [n, n]);
    }
    let mut length = COARSE;
    mesh.grid(|t| coarse(t, length));
    // Wide grounds and far hills begin with longer ones, as long as that makes fewer.
    while mesh.len() > MANY_AT_FIRST.max(8 * mesh.tiles().len()) && length <= LONGEST {
        length *= 2.0;
        mesh.grid(|t| coarse(t, length));
    }
}

impl Workshop<'_> {
    /// Divides surfaces until the tolerance is met, no more is gained or memory ends. What of the last elements is open,
    /// where a trial has found it.
    pub fn divide(&self, mesh: &mut Mesh, account: &mut Account) -> Option<Cover> {
        let tolerance = self.options.tolerance;
        let rays = (ROUGH * (0.02 / tolerance).powi(2)).max(ROUGH).min(f64::from(self.options.rays));
        let mut before: HashMap<Side, f64> = HashMap::new();
        let mut gained = None;
        for _ in 0..MOST_LEVELS {
            let cover = self.cover(mesh);
            let judged = self.judge(mesh, self.trial(mesh, &cover, rays as u32));
            let error = mean(&judged);
            let gain: f64 = gained.map_or(0.0, |before| error / before);
            if error <= tolerance || gain > 1.0 {
                return Some(cover);
            }
            gained = Some(error);
            let worth = |j: &&Judged| j.error > tolerance && before.get(&j.side).is_none_or(|b| j.error < WORTH * b);
            let part: f64 = judged.iter().filter(worth).map(|j| j.part).sum();
            if part < LITTLE * error {
                return Some(cover);
            }
            let mut again: Vec<usize> = judged.iter().filter(worth).map(|j| j.side.0).collect();
            again.dedup();
            before.extend(judged.iter().map(|j| (j.side, j.error)));
            let (fits, finer) = self.divided(mesh, &again);
            account.out_of_memory |= !fits;
            if !finer {
                return Some(cover);
            }
            // What finer elements do not mend is the noise of these few rays: once more, and no further.
            if gain > WORTH {
                return None;
            }
        }
        None
    }

    /// Mean error of what is linear between elements, of all sides.
    pub fn error(&self, mesh: &Mesh, brightness: [Vec<f32>; 2]) -> f64 {
        mean(&self.judge(mesh, brightness))
    }

    /// How far what is linear between elements errs on each side.
    fn judge(&self, mesh: &Mesh, [all, between]: [Vec<f32>; 2]) -> Vec<Judged> {
        let shown = if self.options.show == Show::Mesh { all } else { between };
        let areas: Vec<f64> = mesh.tiles().iter().map(|t| t.area).collect();
        let sides: Vec<Side> = (0..areas.len())
            .flat_map(|i| [(i, true), (i, false)])
            .filter(|(i, front)| mesh.is_awake(*i, *front))
            .collect();
        let mean_of = |(i, front): &Side| -> f64 {
            let elements = mesh.elements(*i, *front);
            let count = elements.len().max(1) as f64;
            elements.map(|e| f64::from(shown[e as usize].max(0.0))).sum::<f64>() / count
        };
        let area: f64 = sides.iter().map(|s| areas[s.0]).sum();
        let mean = sides.iter().map(|s| areas[s.0] * mean_of(s)).sum::<f64>() / area.max(f64::MIN_POSITIVE);
        let light = |side: &Side| areas[side.0] * mean_of(side);
        let all = sides.iter().map(light).sum::<f64>().max(f64::MIN_POSITIVE);
        let one = |side: Side| {
            let elements = mesh.elements(side.0, side.1);
            let values = &shown[elements.start as usize..elements.end as usize];
            let error = mesh.tiles()[side.0].error(values, DARK * mean as f32);
            Judged { side, error, part: light(&side) * error / all }
        };
        sides.into_iter().map(one).collect()
    }

    /// Divides surfaces as far as memory allows; whether it did for all, and whether it did at all.
    fn divided(&self, mesh: &mut Mesh, tiles: &[usize]) -> (bool, bool) {
        let (mut fits, mut finer) = (true, false);
        let mut count = mesh.len();
        for tile in tiles {
            let sides = [true, false].iter().filter(|front| mesh.is_awake(*tile, **front)).count();
            let [n, m] = mesh.tiles()[*tile].cells;
            let more = 3 * sides * (n * m) as usize;
            if 2 * n.max(m) > MOST_ALONG {
                continue;
            }
            if !self.fits(count + more) {
                fits = false;
                continue;
            }
            count += more;
            mesh.divide(*tile, [2 * n, 2 * m]);
            finer = true;
        }
        mesh.number();
        (fits, finer)
    }
}

/// Elements that a surface is divided into at first.
fn coarse(tile: &Tile, length: f32) -> [u32; 2] {
    let patch = &tile.patch;
    let small = tile.area < f64::from(0.1 * length * length);
    let along = |side: f32| ((side / length).ceil() as u32).min(MOST_AT_FIRST);
    let [a, b] = patch.sides().map(along);
    match (patch.is_triangle(), patch.is_round()) {
        // Triangles are what meshes are made of.
        (true, _) => {
            let n = a.max(b).max(1);
            [n, n]
        }
        (_, true) => [a.max(if small { 4 } else { 8 }), b.max(if small { 2 } else { 4 })],
        (..) if small => [1, 1],
        _ => [a.max(3), b.max(3)],
    }
}
