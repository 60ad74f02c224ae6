//! The tree: eight children a node, leaves of one kind.
//!
//! obvhs builds a binary tree; a dynamic program picks the cut of it into eight-wide nodes and leaves of up to eight surfaces
//! that is the cheapest by the surface area heuristic (Ylitie, Karras and Laine 2017, section 3.1).

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use super::Primitive;
use super::block::{Quads, Triangles};
use super::round::Round;

/// Kind (3 bits), number less one (3 bits) and index (26 bits) of what a node's child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link(pub u32);

impl Link {
    /// Another node.
    pub const NODE: u32 = 0;
    /// A block of triangles.
    pub const TRIANGLES: u32 = 1;
    /// A block of parallelograms.
    pub const QUADS: u32 = 2;
    /// Some round surfaces.
    pub const ROUNDS: u32 = 3;
    /// Some placements.
    pub const PLACEMENTS: u32 = 4;
    /// Nothing.
    pub const NONE: Link = Link(7 << 29);
    /// Indices are below this.
    pub const MOST: usize = 1 << 26;

    /// `count` is 1 to 8.
    pub fn new(kind: u32, index: usize, count: usize) -> Link {
        Link((kind << 29) | ((count as u32 - 1) << 26) | index as u32)
    }

    /// One of the constants.
    #[inline(always)]
    pub fn kind(self) -> u32 {
        self.0 >> 29
    }

    /// Of kind NODE.
    #[inline(always)]
    pub fn is_node(self) -> bool {
        self.0 < 1 << 29
    }

    /// Place in the list of its kind.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & 0x03ff_ffff) as usize
    }

    /// How many, from the index on.
    #[inline(always)]
    pub fn count(self) -> usize {
        (self.0 >> 26 & 7) as usize + 1
    }
}

/// Boxes of eight children, `bounds[axis][0 = low, 1 = high]`, and what they are. Unused ones are empty boxes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Node {
    /// Boxes.
    pub bounds: [[[f32; 8]; 2]; 3],
    /// Children.
    pub links: [Link; 8],
}

impl Node {
    const EMPTY: Node = Node { bounds: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3], links: [Link::NONE; 8] };
}

/// The tree and what hangs on it.
pub struct Tree {
    /// Where to start; none where everything hangs in a few leaves that are all tested.
    pub root: Link,
    /// Inner nodes.
    pub nodes: Vec<Node>,
    /// Blocks of triangles.
    pub triangles: Vec<Triangles>,
    /// Blocks of parallelograms.
    pub quads: Vec<Quads>,
    /// Spheres, disks and cylinders, each with the index of its primitive.
    pub rounds: Vec<(Round, u32)>,
    /// Indices of placements.
    pub placements: Vec<u32>,
    /// Lower corner of everything.
    pub low: Vec3A,
    /// Upper corner of everything.
    pub high: Vec3A,
    /// Most entries that a traversal stacks.
    pub stacked: usize,
}

/// No tree stacks more: deeper ones are built anew, halved at each step.
pub const DEEPEST: usize = 256;

/// Cost of a node, in blocks of eight triangles.
const NODE_COST: f32 = 1.0;

/// Cost of a leaf with so many items of a kind.
fn leaf_cost(kind: u32, count: u32) -> f32 {
    match kind {
        Link::TRIANGLES => 1.0,
        Link::QUADS => 1.3,
        Link::ROUNDS => 0.5 * count as f32,
        _ => 10.0 * count as f32,
    }
}

/// What the subtree of a binary node may become.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Least cost as a forest of at most 1 to 7 nodes and leaves.
    cost: [f32; 7],
    /// As a leaf; infinite where it holds too much or several kinds.
    leaf: f32,
    /// Items below.
    count: u32,
    /// Kinds below, a bit each.
    kinds: u32,
}

/// What leaves hold: primitives, and after them placements by their boxes.
#[derive(Clone, Copy)]
pub struct Items<'a> {
    /// Shapes, all finite.
    pub primitives: &'a [Primitive],
    /// Boxes of placements.
    pub placed: &'a [(Vec3A, Vec3A)],
}

impl Items<'_> {
    /// Of what a link to it would be.
    pub fn kind(&self, i: usize) -> u32 {
        match self.primitives.get(i) {
            Some(Primitive::Triangle(_)) => Link::TRIANGLES,
            Some(Primitive::Parallelogram { .. }) => Link::QUADS,
            Some(_) => Link::ROUNDS,
            None => Link::PLACEMENTS,
        }
    }

    /// A box for each.
    pub fn bounds(&self) -> Vec<Aabb> {
        let placed = self.placed.iter().map(|(low, high)| Aabb::new(*low, *high));
        let mut bounds: Vec<Aabb> = self.primitives.par_iter().map(Primitive::bounds).collect();
        bounds.extend(placed);
        bounds
    }
}

impl Primitive {
    /// Smallest box around it.
    fn bounds(&self) -> Aabb {
        match self {
            Primitive::Triangle(corners) => Aabb::from_points(corners),
            Primitive::Parallelogram { corner, u, v } => Aabb::from_points(&Quads::corners(*corner, *u, *v)),
            other => Round::of(other).map_or(Aabb::INVALID, |r| {
                let (low, high) = r.bounds();
                Aabb::new(low, high)
            }),
        }
    }
}

impl Tree {
    /// Without anything.
    pub fn bare(low: Vec3A, high: Vec3A) -> Tree {
        Tree {
            root: Link::NONE,
            nodes: Vec::new(),
            triangles: Vec::new(),
            quads: Vec::new(),
            rounds: Vec::new(),
            placements: Vec::new(),
            low,
            high,
            stacked: 1,
        }
    }

    /// Over at least one item, fewer than [`Link::MOST`] of each kind.
    pub fn build(items: Items) -> Tree {
        crate::parallel::ready();
        if let Some(few) = Tree::few(items) {
            return few;
        }
        let boxes = items.bounds();
        let tree = Cut::new(Binary::clustered(&boxes), items).finish();
        if tree.stacked <= DEEPEST { tree } else { Tree::halved(items) }
    }

    /// The shallowest, for where the fastest stacks more than [`DEEPEST`].
    pub fn halved(items: Items) -> Tree {
        crate::parallel::ready();
        Cut::new(Binary::halved(&items.bounds()), items).finish()
    }

    /// Makes a leaf of one to eight items of a kind.
    pub fn hang(&mut self, items: Items, ids: &[u32]) -> Link {
        let kind = items.kind(ids[0] as usize);
        let index = match kind {
            Link::TRIANGLES => self.triangles.len(),
            Link::QUADS => self.quads.len(),
            Link::ROUNDS => self.rounds.len(),
            _ => self.placements.len(),
        };
        let (mut triangles, mut quads) = (Triangles::empty(), Quads::empty());
        for (lane, id) in ids.iter().enumerate() {
            match items.primitives.get(*id as usize) {
                Some(Primitive::Triangle(corners)) => triangles.set(lane, *corners, *id),
                Some(Primitive::Parallelogram { corner, u, v }) => {
                    quads.set(lane, Quads::corners(*corner, *u, *v), *id)
                }
                Some(other) => self.rounds.extend(Round::of(other).map(|r| (r, *id))),
                None => self.placements.push(*id - items.primitives.len() as u32),
            }
        }
        match kind {
            Link::TRIANGLES => self.triangles.push(triangles),
            Link::QUADS => self.quads.push(quads),
            _ => {}
        }
        Link::new(kind, index, ids.len())
    }

    /// Bytes on the heap.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.quads[..])
            + size_of_val(&self.rounds[..])
            + size_of_val(&self.placements[..])
    }
}

/// A binary tree: one item a leaf, children side by side, the root first.
struct Binary {
    nodes: Vec<Bvh2Node>,
    /// Items by leaves' `first_index`.
    items: Vec<u32>,
}

impl Binary {
    /// Neighbours clustered bottom up (Meister and Bittner 2018), then some subtrees put where they cost less.
    fn clustered(boxes: &[Aabb]) -> Binary {
        // Of obvhs' distances and shares of reinserted nodes these give about the least cost of the eight-wide tree, 3 %
        // below the "medium" build in less time; a wider search makes better binary trees, not better wide ones.
        let all = (0..boxes.len() as u32).collect();
        let mut builder = PlocBuilder::with_capacity(boxes.len());
        let mut tree = builder.build(PlocSearchDistance::VeryLow, boxes, all, SortPrecision::U64, 0);
        drop(builder);
        ReinsertionOptimizer::default().run(&mut tree, 0.02, None);
        Binary { nodes: tree.nodes, items: tree.primitive_indices }
    }

    /// Halves by number along the longest axis: not the fastest to trace, but the shallowest.
    fn halved(boxes: &[Aabb]) -> Binary {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = vec![Bvh2Node::default()];
        let mut open = vec![(0, 0..boxes.len())];
        while let Some((place, range)) = open.pop() {
            let part = &mut items[range.clone()];
            let bounds = part.iter().fold(Aabb::INVALID, |b, i| b.union(&boxes[*i as usize]));
            if let [_] = part {
                nodes[place] = Bvh2Node::new(bounds, 1, range.start as u32);
                continue;
            }
            let size = bounds.diagonal();
            let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
            let middle = part.len() / 2;
            let key = |i: &u32| boxes[*i as usize].min[axis] + boxes[*i as usize].max[axis];
            part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
            let first = nodes.len();
            nodes[place] = Bvh2Node::new(bounds, 0, first as u32);
            nodes.extend([Bvh2Node::default(); 2]);
            let middle = range.start + middle;
            open.extend([(first, range.start..middle), (first + 1, middle..range.end)]);
        }
        Binary { nodes, items }
    }
}

/// The binary tree on its way to eight children a node. Nodes are numbered by levels, the root first.
struct Cut<'a> {
    binary: Binary,
    items: Items<'a>,
    /// For each node its place in `binary`, and the first child's number; the second follows it.
    nodes: Vec<(u32, u32)>,
    plans: Vec<Plan>,
    tree: Tree,
}

impl<'a> Cut<'a> {
    fn new(binary: Binary, items: Items<'a>) -> Self {
        let all = binary.nodes[0].aabb();
        let count = binary.nodes.len();
        let tree = Tree::bare(all.min, all.max);
        Cut { binary, items, nodes: Vec::with_capacity(count), plans: vec![Plan::default(); count], tree }
    }

    fn node(&self, n: usize) -> &Bvh2Node {
        &self.binary.nodes[self.nodes[n].0 as usize]
    }

    fn first(&self, n: usize) -> usize {
        self.nodes[n].1 as usize
    }

    fn item(&self, leaf: usize) -> u32 {
        self.binary.items[self.node(leaf).first_index as usize]
    }

    /// Numbers the nodes, then plans each level from those below it.
    fn plan(&mut self) {
        let mut levels = Vec::new();
        self.nodes.push((0, 0));
        let mut start = 0;
        while start < self.nodes.len() {
            let end = self.nodes.len();
            levels.push(start..end);
            for n in start..end {
                let node = *self.node(n);
                if node.prim_count == 0 {
                    self.nodes[n].1 = self.nodes.len() as u32;
                    self.nodes.extend([(node.first_index, 0), (node.first_index + 1, 0)]);
                }
            }
            start = end;
        }
        let mut plans = std::mem::take(&mut self.plans);
        for level in levels.into_iter().rev() {
            let (above, below) = plans.split_at_mut(level.end);
            let numbers = level.clone().into_par_iter().with_min_len(1024);
            above[level.clone()].par_iter_mut().with_min_len(1024).zip(numbers).for_each(|(plan, n)| {
                *plan = self.plan_of(n, below, level.end);
            });
        }
        self.plans = plans;
    }

    /// `below` are the plans from number `from` on.
    fn plan_of(&self, n: usize, below: &[Plan], from: usize) -> Plan {
        let node = self.node(n);
        let area = node.aabb().half_area();
        if node.prim_count > 0 {
            let kind = self.items.kind(self.item(n) as usize);
            let leaf = area * leaf_cost(kind, 1);
            return Plan { cost: [leaf; 7], leaf, count: 1, kinds: 1 << kind };
        }
        let first = self.first(n) - from;
        let (a, b) = (&below[first], &below[first + 1]);
        let (count, kinds) = (a.count + b.count, a.kinds | b.kinds);
        let one_kind = kinds.is_power_of_two() && count <= 8;
        let leaf = if one_kind { area * leaf_cost(kinds.trailing_zeros(), count) } else { f32::INFINITY };
        let mut cost = [0.0; 7];
        cost[0] = leaf.min(split(a, b, 8).0 + area * NODE_COST);
        for roots in 2..=7 {
            cost[roots - 1] = split(a, b, roots).0.min(cost[roots - 2]);
        }
        Plan { cost, leaf, count, kinds }
    }

    fn finish(mut self) -> Tree {
        self.plan();
        self.tree.root = self.link(0, 0);
        let Tree { nodes, triangles, quads, .. } = &mut self.tree;
        nodes.shrink_to_fit();
        triangles.shrink_to_fit();
        quads.shrink_to_fit();
        self.tree
    }

    /// Makes a binary node a leaf or a node.
    fn link(&mut self, n: usize, stacked: usize) -> Link {
        let plan = &self.plans[n];
        if plan.leaf <= plan.cost[0] {
            return self.leaf(n);
        }
        let place = self.tree.nodes.len();
        self.tree.nodes.push(Node::EMPTY);
        let (mut roots, mut count) = ([0; 8], 0);
        let first = self.first(n);
        let left = split(&self.plans[first], &self.plans[first + 1], 8).1;
        self.roots(first, left, &mut roots, &mut count);
        self.roots(first + 1, 8 - left, &mut roots, &mut count);
        let stacked = stacked + count - 1;
        self.tree.stacked = self.tree.stacked.max(stacked + 1);
        let mut node = Node::EMPTY;
        for (lane, root) in roots[..count].iter().enumerate() {
            let bounds = self.node(*root).aabb();
            for k in 0..3 {
                node.bounds[k][0][lane] = bounds.min[k];
                node.bounds[k][1][lane] = bounds.max[k];
            }
            node.links[lane] = self.link(*root, stacked);
        }
        self.tree.nodes[place] = node;
        Link::new(Link::NODE, place, 1)
    }

    /// The nodes that a subtree becomes when it may be as many as `most`.
    fn roots(&self, n: usize, most: usize, out: &mut [usize; 8], count: &mut usize) {
        let plan = &self.plans[n];
        let most = (1..=most).find(|i| plan.cost[i - 1] == plan.cost[most - 1]).unwrap_or(most);
        if most == 1 {
            out[*count] = n;
            *count += 1;
            return;
        }
        let first = self.first(n);
        let left = split(&self.plans[first], &self.plans[first + 1], most).1;
        self.roots(first, left, out, count);
        self.roots(first + 1, most - left, out, count);
    }

    fn leaf(&mut self, n: usize) -> Link {
        let (mut found, mut count) = ([0u32; 8], 0);
        // At most one open node for each of the eight items.
        let (mut open, mut left) = ([n; 9], 1);
        while left > 0 {
            left -= 1;
            let n = open[left];
            if self.node(n).prim_count > 0 {
                found[count] = self.item(n);
                count += 1;
            } else {
                open[left] = self.first(n) + 1;
                open[left + 1] = self.first(n);
                left += 2;
            }
        }
        self.tree.hang(self.items, &found[..count])
    }
}

/// Least cost of two subtrees as a forest of `most` roots, and how many of them the first gets.
fn split(a: &Plan, b: &Plan, most: usize) -> (f32, usize) {
    let mut best = (f32::INFINITY, 1);
    for left in 1..most {
        let cost = a.cost[left - 1] + b.cost[most - left - 1];
        if cost < best.0 {
            best = (cost, left);
        }
    }
    best
}
