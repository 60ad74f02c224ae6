//! Sums of a kernel over cells all around, for each of them, by a tree.

use std::ops::Range;

use super::Kernel;
use crate::{parallel, simd};

/// A node is taken as one when it is this much smaller than its distance.
const OPENING: f32 = 0.35;
/// What a node sees is told from a grid over it when it is this much smaller than the distance.
const SMOOTH: f32 = 0.4;
/// The largest node, radians, that may lie across the horizon of a cell.
const HORIZON: f32 = 0.1;
/// The largest node, radians, that a grid lies over.
const FLAT: f32 = 0.5;
/// Cells a leaf, and points of a grid: worked on side by side.
const LEAF: usize = 16;
/// Points of a grid along a side.
const SIDE: usize = 4;
/// Up to so many cells are summed one by one.
const FEW: usize = 1024;
/// Cells that are gone through together, by one thread.
const TOGETHER: usize = 512;

#[derive(Clone, Copy)]
struct Cell<const N: usize> {
    direction: [f32; 3],
    weight: f32,
    /// Light times weight.
    light: [f32; N],
    index: usize,
}

/// Mean direction of a group of cells (a little shorter than 1), and their mean squares about it: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy)]
struct Moments {
    mean: [f32; 3],
    spread: [f32; 6],
}

impl Moments {
    /// Of directions with masses; of no mass at all, the first direction.
    fn of(members: impl Iterator<Item = ([f32; 3], f32)> + Clone) -> Moments {
        let members = members.map(|(d, m)| (d.map(f64::from), f64::from(m)));
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (d, m) in members.clone() {
            (0..3).for_each(|k| sum[k] += m * d[k]);
            total += m;
        }
        let first = members.clone().next().map_or([0.0; 3], |m| m.0);
        let mean = if total > 0.0 { sum.map(|x| x / total) } else { first };
        let mut spread = [0.0; 6];
        for (d, m) in members.filter(|_| total > 0.0) {
            let [x, y, z] = [0, 1, 2].map(|k| d[k] - mean[k]);
            for (s, q) in spread.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *s += m / total * q;
            }
        }
        Moments { mean: mean.map(|x| x as f32), spread: spread.map(|x| x as f32) }
    }
}

struct Node<const N: usize> {
    /// Cells that it holds, and the node after its last child.
    cells: Range<usize>,
    next: usize,
    /// By light and by weight.
    bright: Moments,
    middle: Moments,
    /// Largest distance from the middle to a cell.
    radius: f32,
    /// Light times weight, and weight.
    light: [f32; N],
    weight: f32,
}

pub struct Tree<const N: usize> {
    cells: Vec<Cell<N>>,
    /// Parents before children, first child next.
    nodes: Vec<Node<N>>,
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// A value for each cell of a leaf or point of a grid.
type Lanes = [f32; LEAF];

/// Sums of light and of weight.
#[derive(Clone, Copy)]
struct Sums<const N: usize> {
    light: [Lanes; N],
    weight: Lanes,
}

/// A grid over a node: Chebyshev's points of the box that holds its cells, seen from their middle. What comes from afar is
/// smooth there, so that all the node's cells have it by a cubic between a few points.
struct Frame {
    /// Right, up and ahead.
    axes: [[f32; 3]; 3],
    /// Middle and half width of the box, to the right and up.
    middle: [f32; 2],
    half: [f32; 2],
}

/// Chebyshev's points on -1..1.
const POINTS: [f32; SIDE] = [-0.923_879_5, -0.382_683_43, 0.382_683_43, 0.923_879_5];

impl Frame {
    fn over<const N: usize>(middle: [f32; 3], cells: &[Cell<N>]) -> Frame {
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let unit = |v: [f32; 3]| v.map(|x| x / dot(v, v).sqrt().max(f32::MIN_POSITIVE));
        let ahead = unit(middle);
        let right = unit(cross(if ahead[1].abs() < 0.7 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] }, ahead));
        let axes = [right, cross(ahead, right), ahead];
        let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
        for cell in cells {
            for k in 0..2 {
                let x = dot(cell.direction, axes[k]);
                (low[k], high[k]) = (low[k].min(x), high[k].max(x));
            }
        }
        // Cells in a line have a box, too.
        let half = [0, 1].map(|k| (0.5 * (high[k] - low[k])).max(1e-4));
        Frame { axes, middle: [0, 1].map(|k| 0.5 * (high[k] + low[k])), half }
    }

    /// Directions of the grid's points, row by row.
    fn grid(&self) -> [Lanes; 3] {
        let mut at = [[0f32; LEAF]; 3];
        for j in 0..LEAF {
            let x = self.middle[0] + self.half[0] * POINTS[j % SIDE];
            let y = self.middle[1] + self.half[1] * POINTS[j / SIDE];
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            for (k, plane) in at.iter_mut().enumerate() {
                plane[j] = x * self.axes[0][k] + y * self.axes[1][k] + z * self.axes[2][k];
            }
        }
        at
    }

    /// Lagrange's weights of the points along a side for directions.
    #[inline(always)]
    fn shares(&self, side: usize, at: &[Lanes; 3]) -> [Lanes; SIDE] {
        let axis = self.axes[side];
        let mut shares = [[1f32; LEAF]; SIDE];
        for j in 0..LEAF {
            let x = axis[0] * at[0][j] + axis[1] * at[1][j] + axis[2] * at[2][j];
            let x = (x - self.middle[side]) / self.half[side];
            for (i, share) in shares.iter_mut().enumerate() {
                for k in (0..SIDE).filter(|k| *k != i) {
                    share[j] *= (x - POINTS[k]) * (1.0 / (POINTS[i] - POINTS[k]));
                }
            }
        }
        shares
    }

    /// Sums at directions from those at the grid's points.
    #[inline(always)]
    fn between<const N: usize>(&self, grid: &Sums<N>, at: &[Lanes; 3]) -> Sums<N> {
        let (across, up) = (self.shares(0, at), self.shares(1, at));
        let mut sums = Sums::NOTHING;
        for p in 0..LEAF {
            let (x, y) = (&across[p % SIDE], &up[p / SIDE]);
            for j in 0..LEAF {
                sums.weight[j] += x[j] * y[j] * grid.weight[p];
            }
            for (sum, light) in sums.light.iter_mut().zip(&grid.light) {
                for j in 0..LEAF {
                    sum[j] += x[j] * y[j] * light[p];
                }
            }
        }
        sums
    }
}

impl<const N: usize> Sums<N> {
    const NOTHING: Sums<N> = Sums { light: [[0.0; LEAF]; N], weight: [0.0; LEAF] };
}

/// What a node sees, by number.
#[derive(Default)]
struct Lists {
    /// Nodes far enough to be taken as one.
    far: Vec<usize>,
    /// Of a leaf: leaves to be taken apart.
    near: Vec<usize>,
    /// Nodes that are left to the node's children.
    rest: Vec<usize>,
}

/// A cell's index, the kernel's sums over all others of light, and of weight.
pub type Sum<const N: usize> = (usize, [f32; N], f32);

impl<const N: usize> Tree<N> {
    /// Over unit directions (`None`: no cell) with weights and light, of which `luminance` counts most.
    pub fn new(directions: &[Option<[f64; 3]>], weights: &[f64], light: &[[f64; N]], luminance: usize) -> Tree<N> {
        let cell = |i: usize| {
            let direction = directions[i]?.map(|x| x as f32);
            let finite = light[i].map(|x| if x.is_finite() { (x.max(0.0) * weights[i]) as f32 } else { 0.0 });
            Some(Cell { direction, weight: weights[i] as f32, light: finite, index: i })
        };
        let cells: Vec<Cell<N>> = (0..directions.len()).filter_map(cell).filter(|c| c.weight > 0.0).collect();
        let mut tree = Tree { nodes: Vec::new(), cells };
        if !tree.cells.is_empty() {
            tree.build(0..tree.cells.len(), luminance);
        }
        tree
    }

    fn build(&mut self, range: Range<usize>, luminance: usize) {
        let cells = &self.cells[range.clone()];
        let middle = Moments::of(cells.iter().map(|c| (c.direction, c.weight)));
        let bright = Moments::of(cells.iter().map(|c| (c.direction, c.light[luminance])));
        let radius = cells.iter().map(|c| apart(c.direction, middle.mean)).fold(0.0, f32::max);
        let (mut light, mut weight) = ([0.0; N], 0.0);
        let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
        for c in cells {
            for k in 0..3 {
                low[k] = low[k].min(c.direction[k]);
                high[k] = high[k].max(c.direction[k]);
            }
            light.iter_mut().zip(c.light).for_each(|(a, b)| *a += b);
            weight += c.weight;
        }
        let here = self.nodes.len();
        self.nodes.push(Node { cells: range.clone(), next: 0, bright, middle, radius, light, weight });
        let longest = (0..3).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or(0);
        if range.len() > LEAF {
            let half = range.len() / 2;
            self.cells[range.clone()]
                .select_nth_unstable_by(half, |a, b| a.direction[longest].total_cmp(&b.direction[longest]));
            self.build(range.start..range.start + half, luminance);
            self.build(range.start + half..range.end, luminance);
        }
        self.nodes[here].next = self.nodes.len();
    }

    fn is_leaf(&self, node: usize) -> bool {
        self.nodes[node].next == node + 1
    }

    /// For each cell sums by the kernel over all others.
    pub fn sums(&self, kernel: impl Kernel) -> Vec<Sum<N>> {
        let mut work: Vec<(usize, Vec<Sum<N>>)> = Vec::new();
        let mut i = 0;
        while i < self.nodes.len() {
            let whole = self.nodes[i].cells.len() <= TOGETHER;
            if whole {
                work.push((i, Vec::with_capacity(self.nodes[i].cells.len())));
            }
            i = if whole { self.nodes[i].next } else { i + 1 };
        }
        parallel::for_pieces(&mut work, 1, |_, piece| {
            for (node, out) in piece {
                self.descend(kernel, *node, &[0], None, out);
            }
        });
        work.into_iter().flat_map(|(_, sums)| sums).collect()
    }

    /// Adds what a node sees of some others, and what is seen from the grid above, to the sums of its cells.
    fn descend(
        &self,
        kernel: impl Kernel,
        target: usize,
        others: &[usize],
        above: Option<(&Frame, &Sums<N>)>,
        out: &mut Vec<Sum<N>>,
    ) {
        let lists = self.lists(target, others);
        let cells = &self.cells[self.nodes[target].cells.clone()];
        let frame = (!self.is_leaf(target)).then(|| Frame::over(self.nodes[target].middle.mean, cells));
        let at = match &frame {
            Some(frame) => frame.grid(),
            None => std::array::from_fn(|k| std::array::from_fn(|j| cells.get(j).map_or(0.0, |c| c.direction[k]))),
        };
        let mut sums = Sums::NOTHING;
        simd::wide(
            #[inline(always)]
            || {
                if let Some((frame, grid)) = above {
                    sums = frame.between(grid, &at);
                }
                self.add_far(kernel, &lists.far, &at, &mut sums);
                self.add_near(kernel, &lists.near, &at, &mut sums);
            },
        );
        match frame {
            Some(frame) => {
                for child in [target + 1, self.nodes[target + 1].next] {
                    self.descend(kernel, child, &lists.rest, Some((&frame, &sums)), out);
                }
            }
            None => {
                let sum = |(j, c): (usize, &Cell<N>)| (c.index, sums.light.map(|s| s[j]), sums.weight[j]);
                out.extend(cells.iter().enumerate().map(sum));
            }
        }
    }

    /// How a node sees others.
    fn lists(&self, target: usize, others: &[usize]) -> Lists {
        let (here, leaf) = (&self.nodes[target], self.is_leaf(target));
        let (at, many) = (here.middle.mean, self.cells.len() > FEW);
        let mut lists = Lists::default();
        for other in others {
            let (mut i, end) = (*other, self.nodes[*other].next);
            while i < end {
                let node = &self.nodes[i];
                let size = node.radius + here.radius;
                let cos = dot(at, node.middle.mean);
                // Where the kernel ends, at 90 degrees, its mean over a node is not that of its middle.
                let largest = if leaf { node.radius } else { node.radius.max(here.radius) };
                let cut = cos.abs() < size && largest > HORIZON;
                let distance = apart(at, node.middle.mean);
                let smooth = leaf || (here.radius < SMOOTH * (distance - node.radius) && here.radius < FLAT);
                let whole = many && !cut && smooth && node.radius < OPENING * (distance - here.radius);
                if cos < -size {
                    i = node.next;
                } else if whole {
                    lists.far.push(i);
                    i = node.next;
                } else if !leaf && (self.is_leaf(i) || node.radius <= here.radius) {
                    lists.rest.push(i);
                    i = node.next;
                } else {
                    if self.is_leaf(i) {
                        lists.near.push(i);
                    }
                    i += 1;
                }
            }
        }
        lists
    }

    /// Adds nodes taken as one.
    #[inline(always)]
    fn add_far(&self, kernel: impl Kernel, far: &[usize], at: &[Lanes; 3], sums: &mut Sums<N>) {
        for i in far {
            let node = &self.nodes[*i];
            let (mut by_light, mut by_weight) = ([0f32; LEAF], [0f32; LEAF]);
            for (moments, k) in [(&node.bright, &mut by_light), (&node.middle, &mut by_weight)] {
                let ([mx, my, mz], [xx, yy, zz, xy, xz, yz]) = (moments.mean, moments.spread);
                for j in 0..LEAF {
                    let (x, y, z) = (at[0][j] - mx, at[1][j] - my, at[2][j] - mz);
                    let q = x * x + y * y + z * z;
                    let along = xx * x * x + yy * y * y + zz * z * z + 2.0 * (x * (xy * y + xz * z) + yz * y * z);
                    k[j] = kernel.mean(q, along, xx + yy + zz);
                }
            }
            sums.weight.iter_mut().zip(by_weight).for_each(|(sum, k)| *sum += k * node.weight);
            for (sum, light) in sums.light.iter_mut().zip(node.light) {
                sum.iter_mut().zip(by_light).for_each(|(sum, k)| *sum += k * light);
            }
        }
    }

    /// Adds the cells of leaves one by one.
    #[inline(always)]
    fn add_near(&self, kernel: impl Kernel, near: &[usize], at: &[Lanes; 3], sums: &mut Sums<N>) {
        for c in near.iter().flat_map(|i| &self.cells[self.nodes[*i].cells.clone()]) {
            let mut k = [0f32; LEAF];
            for j in 0..LEAF {
                let (x, y, z) = (at[0][j] - c.direction[0], at[1][j] - c.direction[1], at[2][j] - c.direction[2]);
                k[j] = kernel.at(x * x + y * y + z * z);
                sums.weight[j] += k[j] * c.weight;
            }
            for (sum, light) in sums.light.iter_mut().zip(c.light) {
                for j in 0..LEAF {
                    sum[j] += k[j] * light;
                }
            }
        }
    }
}
