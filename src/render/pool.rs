//! Paths of several pixels pooled [Bekaert, Sbert and Halton 2002]: what one of them finds beyond its first surface lights the first
//! surfaces of the others too, where they see it.
//!
//! A member of a pool has a head, the matt surface that its eye ray meets, and sends paths from there. Where one of them arrives
//! at a matt surface, the light that leaves that place x is the same towards all heads: a tail. Each head m might have found
//! it, with a density over its area of
//!
//! ```text
//! p_m(x) = cos_m cos_x / (pi r_m^2)
//! ```
//!
//! where it sees x, and by the balance heuristic takes p_m / sum p_j of it [Veach 1997]: never more than its own path alone would give
//! it. A tail costs several rays and its spectra; a connection one ray that is asked only whether it is open.
//!
//! Heads from which x is much less likely than from another have no part in it: neither do they take of it, nor do they count in
//! the sum. One that finds such a place all the same keeps it for itself.

use glam::Vec3A;

use crate::render::meeting::Meeting;
use crate::render::trail::Trail;
use crate::scene::Geometry;
use crate::simd;

/// Most members of a pool.
pub const MEMBERS: usize = 16;

/// Each member's number of something.
type Each = [f32; MEMBERS];

/// Below this share of the largest density a head has no part in a tail.
const LEAST: f32 = 0.02;

/// First surfaces, side by side in the processor; those of no member face nowhere.
#[derive(Clone, Copy)]
struct Heads {
    point: [Each; 3],
    /// Geometric and shading normal, to the eye's side.
    side: [Each; 3],
    normal: [Each; 3],
    /// Of each path that a head sends.
    share: Each,
    start: [Vec3A; MEMBERS],
}

const NOBODY: Heads = Heads {
    point: [[0.0; MEMBERS]; 3],
    side: [[0.0; MEMBERS]; 3],
    normal: [[0.0; MEMBERS]; 3],
    share: [0.0; MEMBERS],
    start: [Vec3A::ZERO; MEMBERS],
};

/// Where a path arrived from its head, and what came of it.
pub struct Tail {
    owner: usize,
    point: Vec3A,
    /// The same, moved off its surface.
    start: Vec3A,
    /// Geometric and shading normal, to where the path came from.
    side: Vec3A,
    normal: Vec3A,
    /// How much of the light that leaves there each member has from its head, but for the head's tints.
    pub weights: [f32; MEMBERS],
    /// The way of that light.
    pub trail: Trail,
}

/// Members and what they have found; used again and again.
pub struct Pool {
    heads: Heads,
    members: usize,
    tails: Vec<Tail>,
    count: usize,
}

impl Default for Pool {
    fn default() -> Pool {
        Pool { heads: NOBODY, members: 0, tails: Vec::new(), count: 0 }
    }
}

impl Pool {
    /// Empties it.
    pub fn clear(&mut self) {
        (self.heads, self.members, self.count) = (NOBODY, 0, 0);
    }

    /// The next member joins, of at most [`MEMBERS`]: from here on heads and tails are its.
    pub fn enter(&mut self) {
        self.members += 1;
    }

    /// The head of the member that entered last: a matt surface of which each path carries `share`.
    pub fn head(&mut self, meeting: &Meeting, share: f32) {
        let (heads, m) = (&mut self.heads, self.members - 1);
        for i in 0..3 {
            heads.point[i][m] = meeting.point[i];
            heads.side[i][m] = meeting.side[i];
            heads.normal[i][m] = meeting.axes[2][i];
        }
        heads.share[m] = share;
        heads.start[m] = meeting.start(false).0;
    }

    /// A path of that member has arrived at a surface that looks the same to all. Returns the trail for the light that leaves there.
    pub fn tail(&mut self, meeting: &Meeting) -> &mut Trail {
        let trail = self.tails.get_mut(self.count).map(|old| std::mem::take(&mut old.trail)).unwrap_or_default();
        let mut tail = Tail {
            owner: self.members - 1,
            point: meeting.point,
            start: meeting.start(false).0,
            side: meeting.side,
            normal: meeting.axes[2],
            weights: [0.0; MEMBERS],
            trail,
        };
        tail.trail.clear();
        match self.tails.get_mut(self.count) {
            Some(old) => *old = tail,
            None => self.tails.push(tail),
        }
        self.count += 1;
        &mut self.tails[self.count - 1].trail
    }

    /// All tails.
    pub fn tails(&self) -> &[Tail] {
        &self.tails[..self.count]
    }

    /// Weighs all tails for all members.
    pub fn connect(&mut self, geometry: &Geometry) {
        for tail in self.tails[..self.count].iter_mut().filter(|t| t.trail.is_lit()) {
            tail.weigh(&self.heads, geometry);
        }
    }
}

impl Tail {
    fn weigh(&mut self, heads: &Heads, geometry: &Geometry) {
        let mut density = simd::wide(
            #[inline(always)]
            || self.densities(heads),
        );
        let owner = self.owner;
        let least = LEAST * density.iter().fold(0f32, |a, b| a.max(*b));
        if density[owner] <= least {
            self.weights[owner] = heads.share[owner];
            return;
        }
        let mut sum = 0.0;
        for (m, density) in density.iter_mut().enumerate() {
            if *density <= least || !(m == owner || geometry.visible(heads.start[m], self.start)) {
                *density = 0.0;
            }
            sum += *density;
        }
        for (m, density) in density.iter().enumerate() {
            self.weights[m] = heads.share[m] * density / sum;
        }
    }

    /// With which each head would have found the place, times pi, if nothing stands between.
    #[inline(always)]
    fn densities(&self, heads: &Heads) -> Each {
        let (p, side, normal) = (self.point, self.side, self.normal);
        let mut out = [0.0; MEMBERS];
        // Written out: closures would be compiled for the baseline.
        for (m, density) in out.iter_mut().enumerate() {
            let (x, y, z) = (p.x - heads.point[0][m], p.y - heads.point[1][m], p.z - heads.point[2][m]);
            let squared = x * x + y * y + z * z;
            let before = x * heads.side[0][m] + y * heads.side[1][m] + z * heads.side[2][m];
            let head = x * heads.normal[0][m] + y * heads.normal[1][m] + z * heads.normal[2][m];
            let tail = -(x * side.x + y * side.y + z * side.z);
            let shading = -(x * normal.x + y * normal.y + z * normal.z);
            // A shading normal that turns away from the head would be another one for it ([`Meeting::new`]).
            let sees =
                (before > 0.0) & (head > 0.0) & (tail > 0.0) & (shading > 0.0) & (shading * shading >= 1e-8 * squared);
            *density = if sees { head * tail / (squared * squared) } else { 0.0 };
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::kernel::lambert::cosine;
    use crate::render::sampler::Sampler;
    use crate::scene::geometry::{Primitive, Surface};
    use crate::scene::light::Emission;
    use glam::vec3a;

    /// Form factor of a rectangle at height 1 over places from `low` to `high`, seen from a place on the ground below it
    /// [Howell, configuration B-3, by corners].
    fn form_factor(from: Vec3A, low: [f32; 2], high: [f32; 2]) -> f64 {
        let corner = |a: f64, b: f64| {
            let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
            (a / p * (b / p).atan() + b / q * (a / q).atan()) / std::f64::consts::TAU
        };
        let [x0, y0] = [low[0] - from.x, low[1] - from.y].map(f64::from);
        let [x1, y1] = [high[0] - from.x, high[1] - from.y].map(f64::from);
        corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
    }

    /// What heads have of a shining ceiling is its form factor, whoever found it: where all see it, where a board hides half of it
    /// from one, and where one is so near to a corner that others have no part in what it finds there. One more has no head.
    #[test]
    fn heads_take_what_they_see() {
        let ceiling = |corner, u, v| Primitive::Parallelogram { corner, u, v };
        let whole = ceiling(vec3a(0.0, 0.0, 1.0), vec3a(0.0, 1.0, 0.0), vec3a(1.0, 0.0, 0.0));
        // Under x < 0.5 of the ceiling, wide enough to hide that half from the place below x = 0.5 and all of it from none.
        let board = ceiling(vec3a(0.0, 0.2, 0.25), vec3a(0.0, 0.6, 0.0), vec3a(0.5, 0.0, 0.0));
        let places = [vec3a(0.5, 0.5, 0.0), vec3a(0.1, 2.0, 0.0), vec3a(3.0, 3.0, 0.0), vec3a(0.9, 0.9, 0.0)];
        for (primitives, hides) in [(vec![whole], false), (vec![whole, board], true)] {
            let surfaces = vec![Surface { material: 0, emitter: None }; primitives.len()];
            let geometry = Geometry::build(primitives, surfaces).unwrap();
            let n = 1 << 14;
            let (mut sums, mut pool) = ([0f64; 4], Pool::default());
            for index in 0..n {
                pool.clear();
                pool.enter();
                for (m, place) in places.iter().enumerate() {
                    let head = Meeting::facing(*place, Vec3A::Z);
                    pool.enter();
                    pool.head(&head, 1.0);
                    let way = head.world(cosine(Sampler::new(m as u32, 0, index, 1).pair(0)));
                    let Some(hit) = geometry.closest(head.start(false).0, way) else { continue };
                    let front = hit.normal.dot(way) < 0.0;
                    if hit.point.z > 0.9 {
                        let meeting = Meeting::new(&hit, front, hit.normal, way);
                        pool.tail(&meeting).light(&Emission::one(0, 1.0), 1.0, 0);
                    }
                }
                pool.connect(&geometry);
                for tail in pool.tails() {
                    sums.iter_mut().zip(&tail.weights[1..]).for_each(|(s, w)| *s += f64::from(*w));
                }
            }
            let mut want = places.map(|p| form_factor(p, [0.0; 2], [1.0; 2]));
            if hides {
                // Projected from a place on the ground onto the ceiling the board is four times as wide.
                for (want, p) in want.iter_mut().zip(places) {
                    let onto =
                        |x: f32, y: f32| [p.x + 4.0 * (x - p.x), p.y + 4.0 * (y - p.y)].map(|c| c.clamp(0.0, 1.0));
                    *want -= form_factor(p, onto(0.0, 0.2), onto(0.5, 0.8));
                }
            }
            for (m, want) in want.iter().enumerate() {
                let got = sums[m] / f64::from(n);
                assert!((got - want).abs() < 2e-3 * want + 2e-4, "head {m}, board {hides}: {got} for {want}");
            }
        }
    }
}
