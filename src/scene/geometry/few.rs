//! Few surfaces: all are tested, and no tree is walked. That takes no branch that a processor could guess wrong, which costs
//! a small scene more than the tests it would spare.

use obvhs::aabb::Aabb;

use super::block::{Block, Crossed};
use super::eight::Eight;
use super::ray::Ray;
use super::traverse::Found;
use super::tree::{Items, Link, Tree};

/// Most blocks of eight flat surfaces.
const BLOCKS: usize = 4;
/// Most round surfaces.
const ROUNDS: usize = 4;

impl Tree {
    /// All items in a few leaves; `None` where there are too many, or placements.
    pub fn few(items: Items) -> Option<Tree> {
        let count = items.primitives.len();
        if !items.placed.is_empty() || count > 8 * BLOCKS + ROUNDS {
            return None;
        }
        let of = |kind| (0..count as u32).filter(|i| items.kind(*i as usize) == kind).collect::<Vec<u32>>();
        let (flat, round) = ([of(Link::QUADS), of(Link::TRIANGLES)], of(Link::ROUNDS));
        if flat.iter().map(|ids| ids.len().div_ceil(8)).sum::<usize>() > BLOCKS || round.len() > ROUNDS {
            return None;
        }
        let all = items.bounds().iter().fold(Aabb::INVALID, |all, one| all.union(one));
        let mut tree = Tree::bare(all.min, all.max);
        for ids in flat.iter().chain([&round]).flat_map(|ids| ids.chunks(8)) {
            tree.hang(items, ids);
        }
        Some(tree)
    }

    /// True for a tree without root.
    #[inline(always)]
    pub fn is_few(&self) -> bool {
        self.root == Link::NONE
    }
}

/// The nearest crossing before `found.t`, if any, into `found`.
#[inline(always)]
pub fn closest<S: Eight>(s: S, tree: &Tree, ray: &Ray, found: &mut Found) {
    nearest(s, &tree.quads, Link::QUADS, ray, found);
    if !(tree.triangles.is_empty() && tree.rounds.is_empty()) {
        // Copies: what is only in registers without this call stays there.
        let (ray, mut before) = (*ray, *found);
        others(s, tree, &ray, &mut before);
        *found = before;
    }
}

/// Among triangles and round surfaces: apart, since code for all at once is a tenth slower for boxes.
#[inline(never)]
fn others<S: Eight>(s: S, tree: &Tree, ray: &Ray, found: &mut Found) {
    s.run(
        #[inline(always)]
        || nearest(s, &tree.triangles, Link::TRIANGLES, ray, found),
    );
    for (i, (round, _)) in tree.rounds.iter().enumerate() {
        let t = round.intersect(ray.origin, ray.direction, found.t);
        if t < found.t {
            *found = Found { t, link: Link::new(Link::ROUNDS, i, 1), lane: 0, placement: u32::MAX };
        }
    }
}

#[inline(always)]
fn nearest<S: Eight, const N: usize>(s: S, blocks: &[Block<N>], kind: u32, ray: &Ray, found: &mut Found)
where
    Block<N>: Crossed,
{
    let none = s.splat(f32::INFINITY);
    let (mut distances, mut nearest) = ([none; BLOCKS], none);
    for (t, block) in distances.iter_mut().zip(blocks) {
        *t = block.distances(s, ray);
        nearest = s.min(nearest, *t);
    }
    let t = s.least(nearest);
    if t < found.t {
        let mut met = 0;
        for (i, distances) in distances.iter().enumerate() {
            met |= s.le(*distances, s.splat(t)) << (8 * i);
        }
        let first = met.trailing_zeros();
        *found = Found { t, link: Link::new(kind, first as usize / 8, 1), lane: first % 8, placement: u32::MAX };
    }
}

/// Whether anything is crossed at 0 < t < `limit`.
#[inline(always)]
pub fn any<S: Eight>(s: S, tree: &Tree, ray: &Ray, limit: f32) -> bool {
    for block in &tree.quads {
        if block.cross(s, ray, limit).0 != 0 {
            return true;
        }
    }
    for block in &tree.triangles {
        if block.cross(s, ray, limit).0 != 0 {
            return true;
        }
    }
    for (round, _) in &tree.rounds {
        if round.intersect(ray.origin, ray.direction, limit) < limit {
            return true;
        }
    }
    false
}
