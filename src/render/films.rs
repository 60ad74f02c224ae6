//! Stacks of thin films in lanes: tables over the cosine, each lane the mean of its wavelengths.

use crate::optics::film::Stack;
use crate::optics::polarization::Response;
use crate::render::lanes::{GROUP, Lanes};

/// Nodes of a table at least and at most, and for each fringe that the cosine goes through.
const FEWEST: usize = 257;
const MOST: usize = 4097;
const A_FRINGE: f64 = 24.0;
/// Fringes within a band from which on there are none to see.
const GREY: f64 = 4.0;

/// Of one stack.
pub struct Films<const G: usize> {
    /// Nothing at all.
    pub black: Lanes<G>,
    /// Back and through: share, and the three numbers of its polarization.
    nodes: Vec<[[Lanes<G>; 4]; 2]>,
}

impl<const G: usize> Films<G> {
    /// For lanes that stand for these wavelengths, nm.
    pub fn new(stack: &Stack, edges: &[(f64, f64)]) -> Films<G> {
        let fringes = |(a, b): &(f64, f64)| {
            let within = stack.fringes(1.0, *a, *b);
            let across = stack.turns(0.5 * (a + b));
            if within > GREY { 0.0 } else { across }
        };
        let most = edges.iter().map(fringes).fold(0.0, f64::max);
        let count = (FEWEST + (A_FRINGE * most) as usize).min(MOST);
        let node = |i: usize| {
            let cos = (i as f64 / (count - 1) as f64).max(1e-6);
            let mut all = [[Lanes::splat(0.0); 4]; 2];
            for (k, (a, b)) in edges.iter().enumerate() {
                let shares = stack.mean(cos, *a, *b);
                for (lanes, response) in all.iter_mut().zip([shares.back, shares.through]) {
                    for (lanes, x) in lanes.iter_mut().zip(numbers(&response)) {
                        lanes.0[k / GROUP][k % GROUP] = x;
                    }
                }
            }
            all
        };
        Films { black: Lanes::splat(0.0), nodes: (0..count).map(node).collect() }
    }

    fn between(&self, cos: f32) -> (usize, f32) {
        let x = cos.clamp(0.0, 1.0) * (self.nodes.len() - 1) as f32;
        let i = (x as usize).min(self.nodes.len() - 2);
        (i, x - i as f32)
    }

    fn number(&self, cos: f32, through: bool, k: usize) -> Lanes<G> {
        let (i, f) = self.between(cos);
        let side = usize::from(through);
        self.nodes[i][side][k].map2(&self.nodes[i + 1][side][k], |a, b| a + f * (b - a))
    }

    /// Share that is sent back, or goes through.
    pub fn share(&self, cos: f32, through: bool) -> Lanes<G> {
        self.number(cos, through, 0)
    }

    /// What it does to polarization ([`crate::optics::polarization::Diattenuation`]).
    pub fn polar(&self, cos: f32, through: bool) -> [Lanes<G>; 3] {
        [1, 2, 3].map(|k| self.number(cos, through, k))
    }
}

fn numbers(r: &Response) -> [f32; 4] {
    let d = r.relative();
    [r.mean() as f32, d.a, d.b, d.c]
}
