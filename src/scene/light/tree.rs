//! Which light to look at: a tree over all lights with a place [Conty 2018], walked from the root by how much each half
//! could give at most where one stands; those beyond the scene share what is left with the tree as a whole.

use glam::Vec3A;

use crate::scene::light::Lamp;

/// Least chance of either half of a node that can give anything.
const LEAST: f32 = 0.02;

/// What is known of the lights below a node.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
    axis: Vec3A,
    /// Half angle of the cone that holds all normals, as cosine and sine.
    spread: [f32; 2],
    /// Shines beyond its normals by a quarter turn (a surface), or all round (a point).
    all_round: bool,
    power: f32,
}

/// A node; children lie in pairs.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    parent: u32,
    /// First child, or the lamp.
    next: u32,
    leaf: bool,
}

/// The tree.
pub struct LightTree {
    nodes: Vec<Node>,
    /// Leaf of each lamp; those beyond the scene have none.
    leaves: Vec<u32>,
    distant: Vec<u32>,
    /// Chance to look beyond the scene.
    chance_distant: f32,
}

/// cos(a - b), or 1 where b is the larger angle.
fn cos_between(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    if cos_a >= cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

fn sin(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

impl Bounds {
    fn of(lamp: &Lamp, power: f32) -> Option<Bounds> {
        match lamp {
            Lamp::Area(e) => {
                let ([low, high], axis, cos) = e.bounds();
                let cos = cos as f32;
                let (low, high, axis) = (low.as_vec3a(), high.as_vec3a(), axis.as_vec3a());
                Some(Bounds { low, high, axis, spread: [cos, sin(cos)], all_round: false, power })
            }
            Lamp::Point(p) => {
                let (low, high) = (p.place, p.place);
                Some(Bounds { low, high, axis: Vec3A::Z, spread: [-1.0, 0.0], all_round: true, power })
            }
            Lamp::Sun(_) | Lamp::Environment(_) => None,
        }
    }

    fn with(&self, o: &Bounds) -> Bounds {
        let between = self.axis.dot(o.axis).clamp(-1.0, 1.0).acos();
        let angle = |b: &Bounds| b.spread[0].clamp(-1.0, 1.0).acos();
        let (wide, narrow) = if angle(self) >= angle(o) { (self, o) } else { (o, self) };
        let (a, b) = (angle(wide), angle(narrow));
        let (axis, half) = if between + b <= a {
            (wide.axis, a)
        } else {
            let half = 0.5 * (a + b + between);
            let turn = wide.axis.cross(narrow.axis);
            if half >= std::f32::consts::PI || turn.length_squared() < 1e-12 {
                (wide.axis, std::f32::consts::PI)
            } else {
                let turn = glam::Quat::from_axis_angle(turn.normalize().into(), half - a);
                ((turn * wide.axis).normalize(), half)
            }
        };
        // A little wider than the arithmetic says: what is left out is never looked at.
        let half = (half + 1e-4).min(std::f32::consts::PI);
        Bounds {
            low: self.low.min(o.low),
            high: self.high.max(o.high),
            axis,
            spread: [half.cos(), half.sin()],
            all_round: self.all_round || o.all_round,
            power: self.power + o.power,
        }
    }

    /// About the most that it could give at a place on a surface with this normal (facing the light's side), up to a factor
    /// common to all; 0 only where it gives nothing.
    fn importance(&self, from: Vec3A, normal: Option<Vec3A>) -> f32 {
        let middle = (self.low + self.high) * 0.5;
        let radius2 = (self.high - self.low).length_squared() * 0.25;
        let to = middle - from;
        let distance2 = to.length_squared();
        let near = distance2 <= radius2 * 1.0001;
        let direction = if distance2 > 0.0 { to / distance2.sqrt() } else { Vec3A::Z };
        // The cone in which the box is seen.
        let (cos_b, sin_b) =
            if near { (-1.0, 0.0) } else { ((1.0 - radius2 / distance2).sqrt(), (radius2 / distance2).sqrt()) };
        let mut all = self.power / distance2.max(radius2).max(f32::MIN_POSITIVE);
        if !self.all_round && !near {
            let cos = -direction.dot(self.axis);
            let cos_x = cos_between(cos, sin(cos), self.spread[0], self.spread[1]);
            let cos_p = cos_between(cos_x, sin(cos_x), cos_b, sin_b);
            if cos_p <= 0.0 {
                return 0.0;
            }
            all *= cos_p;
        }
        if let Some(normal) = normal.filter(|_| !near) {
            let cos = direction.dot(normal);
            let cos_n = cos_between(cos, sin(cos), cos_b, sin_b);
            if cos_n <= 0.0 {
                return 0.0;
            }
            all *= cos_n;
        }
        all
    }
}

impl LightTree {
    /// Over all lamps, each with its power in one unit, above 0.
    pub fn new(lamps: &[Lamp], power: &[f64]) -> LightTree {
        let total: f64 = power.iter().sum();
        let bounded = |i: usize| Bounds::of(&lamps[i], (power[i] / total) as f32).map(|b| (i as u32, b));
        let mut near: Vec<(u32, Bounds)> = (0..lamps.len()).filter_map(bounded).collect();
        let distant: Vec<u32> = (0..lamps.len()).filter(|i| lamps[*i].is_distant()).map(|i| i as u32).collect();
        let mut tree =
            LightTree { nodes: Vec::new(), leaves: vec![u32::MAX; lamps.len()], distant, chance_distant: 0.0 };
        if !tree.distant.is_empty() {
            let n = tree.distant.len() as f32;
            tree.chance_distant = if near.is_empty() { 1.0 } else { n / (n + 1.0) };
        }
        if !near.is_empty() {
            tree.nodes.reserve(2 * near.len());
            let root = Node { bounds: near[0].1, parent: u32::MAX, next: 0, leaf: true };
            tree.nodes.push(root);
            tree.build(0, &mut near);
        }
        tree
    }

    fn build(&mut self, at: usize, near: &mut [(u32, Bounds)]) {
        if let [(lamp, bounds)] = near {
            self.nodes[at] = Node { bounds: *bounds, next: *lamp, leaf: true, ..self.nodes[at] };
            self.leaves[*lamp as usize] = at as u32;
            return;
        }
        let middle = |b: &Bounds| b.low + b.high;
        let low = near.iter().fold(Vec3A::INFINITY, |a, b| a.min(middle(&b.1)));
        let high = near.iter().fold(Vec3A::NEG_INFINITY, |a, b| a.max(middle(&b.1)));
        let size = (high - low).to_array();
        let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let half = near.len() / 2;
        near.select_nth_unstable_by(half, |a, b| middle(&a.1)[axis].total_cmp(&middle(&b.1)[axis]));
        let first = self.nodes.len();
        let child = Node { bounds: near[0].1, parent: at as u32, next: 0, leaf: true };
        self.nodes.extend([child, child]);
        let (left, right) = near.split_at_mut(half);
        self.build(first, left);
        self.build(first + 1, right);
        let bounds = self.nodes[first].bounds.with(&self.nodes[first + 1].bounds);
        self.nodes[at] = Node { bounds, next: first as u32, leaf: false, ..self.nodes[at] };
    }

    /// The lamps beyond the scene.
    pub fn distant(&self) -> impl Iterator<Item = usize> + '_ {
        self.distant.iter().map(|i| *i as usize)
    }

    /// Nothing shines.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Chance of the first of a pair of children.
    fn share(&self, first: usize, from: Vec3A, normal: Option<Vec3A>) -> Option<f32> {
        let [a, b] = [first, first + 1].map(|i| self.nodes[i].bounds.importance(from, normal));
        (a + b > 0.0).then(|| {
            let share = a / (a + b);
            // What promises most may be hidden: the other is looked at as well, unless it can give nothing at all.
            if a > 0.0 && b > 0.0 { share.clamp(LEAST, 1.0 - LEAST) } else { share }
        })
    }

    /// Chooses a lamp with a number in 0..1, which comes back stretched to 0..1 for further use, and its chance; `None`
    /// where no lamp can give anything. `normal` is that of the side that looks.
    pub fn choose(&self, from: Vec3A, normal: Option<Vec3A>, u: &mut f32) -> Option<(usize, f32)> {
        const BELOW_1: f32 = 1.0 - f32::EPSILON / 2.0;
        let mut chance = 1.0;
        let mut take = |u: &mut f32, p: f32| {
            let first = *u < p;
            *u = if first { *u / p } else { (*u - p) / (1.0 - p) }.clamp(0.0, BELOW_1);
            chance *= if first { p } else { 1.0 - p };
            first
        };
        if self.chance_distant > 0.0 && take(u, self.chance_distant) {
            let n = self.distant.len();
            let i = ((*u * n as f32) as usize).min(n - 1);
            *u = (*u * n as f32 - i as f32).clamp(0.0, BELOW_1);
            return Some((self.distant[i] as usize, self.chance_distant / n as f32));
        }
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if node.leaf {
                return Some((node.next as usize, chance));
            }
            let first = node.next as usize;
            let share = self.share(first, from, normal)?;
            at = if take(u, share) { first } else { first + 1 };
        }
        None
    }

    /// Chance with which [`LightTree::choose`] finds a lamp.
    pub fn chance(&self, lamp: usize, from: Vec3A, normal: Option<Vec3A>) -> f32 {
        let mut at = self.leaves[lamp];
        if at == u32::MAX {
            return self.chance_distant / self.distant.len() as f32;
        }
        let mut chance = 1.0 - self.chance_distant;
        while at != 0 {
            let parent = self.nodes[at as usize].parent as usize;
            let first = self.nodes[parent].next;
            let Some(share) = self.share(first as usize, from, normal) else { return 0.0 };
            chance *= if at == first { share } else { 1.0 - share };
            at = parent as u32;
        }
        chance
    }
}
