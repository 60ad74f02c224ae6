//! A single ray down a tree of eight children a node.

use super::block::{Block, Crossed};
use super::eight::Eight;
use super::ray::Ray;
use super::tree::{Link, Node, Tree};

/// What a ray met first in a tree.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Distance in units of the direction.
    pub t: f32,
    /// Kind and place of the primitive.
    pub link: Link,
    /// Lane of its block.
    pub lane: u32,
    /// Placement it was met in; `u32::MAX` for none.
    pub placement: u32,
}

impl Found {
    /// Nothing nearer than `limit`.
    pub fn nothing(limit: f32) -> Found {
        Found { t: limit, link: Link::NONE, lane: 0, placement: u32::MAX }
    }
}

/// Nodes still to be visited: the distance's bits above the link, so that they sort as whole numbers.
struct Stack<const N: usize> {
    entries: [u64; N],
    len: usize,
}

impl<const N: usize> Stack<N> {
    #[inline(always)]
    fn new() -> Self {
        Stack { entries: [0; N], len: 0 }
    }

    /// N is a power of two and the tree was built for it: the mask is for the compiler.
    #[inline(always)]
    fn push(&mut self, entry: u64) {
        self.entries[self.len & (N - 1)] = entry;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<u64> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len & (N - 1)])
    }

    /// Puts the entries from `start` on in order, the nearest on top.
    #[inline(always)]
    fn sort(&mut self, start: usize) {
        for i in start + 1..self.len {
            let entry = self.entries[i & (N - 1)];
            let mut j = i;
            while j > start && self.entries[(j - 1) & (N - 1)] < entry {
                self.entries[j & (N - 1)] = self.entries[(j - 1) & (N - 1)];
                j -= 1;
            }
            self.entries[j & (N - 1)] = entry;
        }
    }
}

#[inline(always)]
fn entry(t: f32, link: Link) -> u64 {
    (u64::from(t.to_bits()) << 32) | u64::from(link.0)
}

/// The ray's constants in all lanes.
struct Slabs<S: Eight> {
    near: [S::F; 3],
    far: [S::F; 3],
    inverse: [S::F; 3],
    sign: [usize; 3],
}

impl<S: Eight> Slabs<S> {
    #[inline(always)]
    fn new(s: S, ray: &Ray) -> Self {
        Slabs {
            near: [s.splat(ray.near[0]), s.splat(ray.near[1]), s.splat(ray.near[2])],
            far: [s.splat(ray.far[0]), s.splat(ray.far[1]), s.splat(ray.far[2])],
            inverse: [s.splat(ray.inverse[0]), s.splat(ray.inverse[1]), s.splat(ray.inverse[2])],
            sign: ray.sign,
        }
    }

    #[inline(always)]
    fn near(&self, s: S, node: &Node, k: usize) -> S::F {
        let planes = s.load(&node.bounds[k][self.sign[k] & 1]);
        s.mul(s.sub(planes, self.near[k]), self.inverse[k])
    }

    #[inline(always)]
    fn far(&self, s: S, node: &Node, k: usize) -> S::F {
        let planes = s.load(&node.bounds[k][(self.sign[k] & 1) ^ 1]);
        s.mul(s.sub(planes, self.far[k]), self.inverse[k])
    }

    /// Children whose boxes the ray enters before `limit`, and where.
    #[inline(always)]
    fn enter(&self, s: S, node: &Node, limit: f32) -> (u32, S::F) {
        let near = (self.near(s, node, 0), self.near(s, node, 1), self.near(s, node, 2));
        let far = (self.far(s, node, 0), self.far(s, node, 1), self.far(s, node, 2));
        let enter = s.max(s.max(near.0, near.1), s.max(near.2, s.splat(0.0)));
        let leave = s.min(s.min(far.0, far.1), s.min(far.2, s.splat(limit)));
        (s.le(enter, leave), enter)
    }
}

/// The nearest crossing before `found.t`, if any, into `found`. `deeper` traces the placements.
#[inline(always)]
pub fn closest<S: Eight, const N: usize>(
    s: S,
    tree: &Tree,
    ray: &Ray,
    found: &mut Found,
    mut deeper: impl FnMut(u32, &mut Found),
) {
    let slabs = Slabs::new(s, ray);
    let mut stack = Stack::<N>::new();
    let mut link = tree.root;
    loop {
        while link.is_node() {
            let node = &tree.nodes[link.index()];
            let (mut mask, enter) = slabs.enter(s, node, found.t);
            if mask == 0 {
                break;
            }
            let enter = s.store(enter);
            let first = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            if mask == 0 {
                link = node.links[first];
                continue;
            }
            let second = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let a = entry(enter[first], node.links[first]);
            let b = entry(enter[second], node.links[second]);
            let (a, b) = (a.min(b), a.max(b));
            if mask == 0 {
                stack.push(b);
                link = Link(a as u32);
                continue;
            }
            let start = stack.len;
            stack.push(b);
            stack.push(a);
            while mask != 0 {
                let i = mask.trailing_zeros() as usize & 7;
                mask &= mask - 1;
                stack.push(entry(enter[i], node.links[i]));
            }
            stack.sort(start);
            stack.len -= 1;
            link = Link(stack.entries[stack.len & (N - 1)] as u32);
        }
        leaf(s, tree, link, ray, found, &mut deeper);
        loop {
            let Some(next) = stack.pop() else { return };
            if f32::from_bits((next >> 32) as u32) < found.t {
                link = Link(next as u32);
                break;
            }
        }
    }
}

/// Nearest lane of a block, if any is nearer.
#[inline(always)]
fn nearest<S: Eight, const N: usize>(s: S, block: &Block<N>, link: Link, ray: &Ray, found: &mut Found)
where
    Block<N>: Crossed,
{
    let (mut mask, t) = block.cross(s, ray, found.t);
    if mask == 0 {
        return;
    }
    let t = s.store(t);
    while mask != 0 {
        let i = mask.trailing_zeros() & 7;
        mask &= mask - 1;
        if t[i as usize] < found.t {
            *found = Found { t: t[i as usize], link, lane: i, placement: u32::MAX };
        }
    }
}

#[inline(always)]
fn leaf<S: Eight>(
    s: S,
    tree: &Tree,
    link: Link,
    ray: &Ray,
    found: &mut Found,
    deeper: &mut impl FnMut(u32, &mut Found),
) {
    match link.kind() {
        Link::TRIANGLES => nearest(s, &tree.triangles[link.index()], link, ray, found),
        Link::QUADS => nearest(s, &tree.quads[link.index()], link, ray, found),
        Link::ROUNDS => {
            for i in link.index()..link.index() + link.count() {
                let t = tree.rounds[i].0.intersect(ray.origin, ray.direction, found.t);
                if t < found.t {
                    *found = Found { t, link: Link::new(Link::ROUNDS, i, 1), lane: 0, placement: u32::MAX };
                }
            }
        }
        Link::PLACEMENTS => {
            for i in link.index()..link.index() + link.count() {
                deeper(tree.placements[i], found);
            }
        }
        _ => {}
    }
}

/// Whether anything is crossed at 0 < t < `limit`.
#[inline(always)]
pub fn any<S: Eight, const N: usize>(
    s: S,
    tree: &Tree,
    ray: &Ray,
    limit: f32,
    mut deeper: impl FnMut(u32) -> bool,
) -> bool {
    let slabs = Slabs::new(s, ray);
    let mut stack = Stack::<N>::new();
    stack.push(u64::from(tree.root.0));
    while let Some(next) = stack.pop() {
        let mut link = Link(next as u32);
        while link.is_node() {
            let node = &tree.nodes[link.index()];
            let (mut mask, _) = slabs.enter(s, node, limit);
            if mask == 0 {
                break;
            }
            loop {
                let i = mask.trailing_zeros() as usize & 7;
                mask &= mask - 1;
                link = node.links[i];
                if mask == 0 {
                    break;
                }
                stack.push(u64::from(link.0));
            }
        }
        let met = match link.kind() {
            Link::TRIANGLES => tree.triangles[link.index()].cross(s, ray, limit).0 != 0,
            Link::QUADS => tree.quads[link.index()].cross(s, ray, limit).0 != 0,
            Link::ROUNDS => tree.rounds[link.index()..link.index() + link.count()]
                .iter()
                .any(|r| r.0.intersect(ray.origin, ray.direction, limit) < limit),
            Link::PLACEMENTS => tree.placements[link.index()..link.index() + link.count()].iter().any(|p| deeper(*p)),
            _ => false,
        };
        if met {
            return true;
        }
    }
    false
}
