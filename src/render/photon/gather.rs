//! How dense photons lie around a place.
//!
//! Photons that arrived around a place on the same surface are counted over the part of a disk where they could have arrived: a
//! polygon whose corners lie as far off in each direction as the surface goes on and can be seen from the place. So it ends at
//! edges, in corners, at what stands on the surface and at partitions. Over it a plane is fitted (local linear regression [Wand and
//! Jones 1995]), whose value at the place neither the missing part nor a slope can bend: of photons at offsets `(x, y)` of flux
//! `w` it is `sum w (a + b x + c y)`, where `(a, b, c)` solve the equations of the polygon's moments.

use std::f32::consts::TAU;

use glam::Vec3A;

use crate::render::photon::tree::{Photon, within};
use crate::scene::{Scene, ray};

/// Corners of the polygon.
const CORNERS: usize = 16;
/// Halvings that find an edge.
const HALVINGS: usize = 7;
/// Normals of one surface differ by less, as a cosine; and places of it lie so near to the plane, in distances from the place.
const SAME: f32 = 0.7;
const NEAR: f32 = 0.3;
/// Height at which neighbours are looked at, in radii.
const HEIGHT: f32 = 0.1;

/// A place that photons are counted at.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Where.
    pub place: Vec3A,
    /// Unit normal of the side that is asked.
    pub normal: Vec3A,
    /// See [`crate::scene::Hit::reach`].
    pub reach: f32,
}

impl Spot {
    /// Offset along the surface, if the photon lies on the same one.
    fn offset(&self, photon: &Photon) -> Option<Vec3A> {
        let d = Vec3A::from_array(photon.place) - self.place;
        let off = d.dot(self.normal);
        let on = off.abs() <= NEAR * d.length() + 4.0 * self.reach * f32::EPSILON;
        (on && Vec3A::from_array(photon.normal).dot(self.normal) > SAME).then_some(d)
    }

    /// Squared distance of the `count`-th nearest photon of the surface, at most `most`.
    pub fn radius2(&self, photons: &[Photon], count: usize, most: f32) -> f32 {
        // The largest of the nearest is the first.
        let mut nearest: Vec<f32> = Vec::with_capacity(count + 1);
        let mut squared = most;
        within(photons, self.place, &mut squared, &mut |photon, away| {
            let full = |n: &[f32]| if n.len() < count { most } else { n[0] };
            if self.offset(photon).is_none() {
                return full(&nearest);
            }
            if nearest.len() < count {
                nearest.push(away);
                if nearest.len() == count {
                    nearest.sort_unstable_by(|a, b| b.total_cmp(a));
                }
            } else {
                sift(&mut nearest, away);
            }
            full(&nearest)
        });
        if nearest.len() < count { most } else { nearest[0] }
    }
}

/// Puts a smaller number in place of the first of a heap whose first is the largest.
fn sift(heap: &mut [f32], value: f32) {
    let (mut i, n) = (0, heap.len());
    loop {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let child = if b < n && heap[b] > heap[a] { b } else { a };
        if child >= n || heap[child] <= value {
            break;
        }
        heap[i] = heap[child];
        i = child;
    }
    heap[i] = value;
}

/// The part of the disk around a spot where photons can arrive, and the plane's equations over it.
struct Domain {
    axes: (Vec3A, Vec3A),
    /// Of the first corner, as a share of a turn.
    turn: f32,
    corners: [[f32; 2]; CORNERS],
    /// `a, b, c` of the plane.
    plane: [f32; 3],
    /// `a` of a constant.
    level: f32,
}

impl Domain {
    fn new(scene: &Scene, spot: &Spot, radius: f32, turn: f32) -> Domain {
        let axes = ray::frame(spot.normal);
        let near = ray::offset(spot.place, spot.normal, spot.reach);
        // Not through what lies close above.
        let above = scene.geometry.closest(near, spot.normal).map_or(f32::MAX, |h| h.t);
        let height = (HEIGHT * radius).min(0.5 * above);
        let from = near + spot.normal * height;
        let mut domain = Domain { axes, turn, corners: [[0.0; 2]; CORNERS], plane: [0.0; 3], level: 0.0 };
        for (i, corner) in domain.corners.iter_mut().enumerate() {
            let (sin, cos) = (TAU * (turn + i as f32 / CORNERS as f32)).sin_cos();
            let r = goes_on(scene, spot, from, axes.0 * cos + axes.1 * sin, height, radius);
            *corner = [r * cos, r * sin];
        }
        domain.solve();
        domain
    }

    /// A photon at an offset lies in the polygon.
    fn holds(&self, [x, y]: [f32; 2]) -> bool {
        let angle = (y.atan2(x) / TAU - self.turn).rem_euclid(1.0);
        let i = ((angle * CORNERS as f32) as usize).min(CORNERS - 1);
        let ([ax, ay], [bx, by]) = (self.corners[i], self.corners[(i + 1) % CORNERS]);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0
    }

    /// Moments of the triangles between the place and each side, and the plane's equations solved.
    fn solve(&mut self) {
        let mut m = [0f64; 6];
        for (i, a) in self.corners.iter().enumerate() {
            let ([ax, ay], [bx, by]) = (a.map(f64::from), self.corners[(i + 1) % CORNERS].map(f64::from));
            let area = 0.5 * (ax * by - ay * bx);
            let more = [
                1.0,
                (ax + bx) / 3.0,
                (ay + by) / 3.0,
                (ax * ax + ax * bx + bx * bx) / 6.0,
                (2.0 * ax * ay + 2.0 * bx * by + ax * by + bx * ay) / 12.0,
                (ay * ay + ay * by + by * by) / 6.0,
            ];
            m.iter_mut().zip(more).for_each(|(m, more)| *m += area * more);
        }
        let [area, x, y, xx, xy, yy] = m;
        if area <= 0.0 {
            return;
        }
        self.level = (1.0 / area) as f32;
        let minors = [xx * yy - xy * xy, -(x * yy - xy * y), x * xy - xx * y];
        let determinant = area * minors[0] + x * minors[1] + y * minors[2];
        // 1/144 of the fifth power of any rectangle's area, however thin, and about as much of other shapes'.
        self.plane = if determinant > 1e-6 * area.powi(5) {
            minors.map(|v| (v / determinant) as f32)
        } else {
            [self.level, 0.0, 0.0]
        };
    }
}

/// How far the surface goes on in a direction along it and can be seen from a height over the place; `most` at most.
fn goes_on(scene: &Scene, spot: &Spot, from: Vec3A, along: Vec3A, height: f32, most: f32) -> f32 {
    let there = |r: f32| {
        let hit = scene.geometry.closest(from + along * r, -spot.normal);
        hit.is_some_and(|hit| {
            (hit.t - height).abs() <= NEAR * r + 0.5 * height && hit.normal.dot(spot.normal).abs() > SAME
        })
    };
    // What stands there ends it; a step before it, not within it.
    let free = scene.geometry.closest(from, along).map_or(f32::MAX, |h| h.t * (1.0 - 1e-4)).min(most);
    if there(free) {
        return free;
    }
    let (mut on, mut off) = (0.0, free);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (on + off);
        if there(middle) { on = middle } else { off = middle }
    }
    on
}

/// Rows and their flux a unit of area around a spot; `turn` turns the polygon. Appends to `out`, a row once.
pub fn density(scene: &Scene, photons: &[Photon], spot: &Spot, radius2: f32, turn: f32, out: &mut Vec<(u32, f32)>) {
    let domain = Domain::new(scene, spot, radius2.sqrt(), turn);
    let mut found: Vec<(u32, f32, [f32; 2])> = Vec::new();
    let mut squared = radius2;
    within(photons, spot.place, &mut squared, &mut |photon, _| {
        if let Some(d) = spot.offset(photon) {
            let at = [d.dot(domain.axes.0), d.dot(domain.axes.1)];
            if domain.holds(at) {
                found.push((photon.row, photon.flux, at));
            }
        }
        radius2
    });
    let [a, b, c] = domain.plane;
    let plane: f32 = found.iter().map(|(_, w, [x, y])| w * (a + b * x + c * y)).sum();
    let level: f32 = found.iter().map(|(_, w, _)| w * domain.level).sum();
    // Where few photons make the plane dive, their mean will do.
    let [a, b, c] = if plane >= 0.25 * level && plane <= 4.0 * level { [a, b, c] } else { [domain.level, 0.0, 0.0] };
    let start = out.len();
    out.extend(found.iter().map(|(row, w, [x, y])| (*row, w * (a + b * x + c * y))));
    let new = &mut out[start..];
    new.sort_unstable_by_key(|f| f.0);
    let mut end = start;
    for i in start..out.len() {
        if end > start && out[end - 1].0 == out[i].0 {
            out[end - 1].1 += out[i].1;
        } else {
            out[end] = out[i];
            end += 1;
        }
    }
    out.truncate(end);
}
