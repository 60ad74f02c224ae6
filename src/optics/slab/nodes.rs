//! Quadrature over the directions inside a slab, and moments of phase functions.

use std::f64::consts::PI;

/// Smallest cosine a beam is followed at.
const GRAZING: f64 = 1e-9;

/// One direction inside the slab.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// Cosine inside, in (0, 1].
    pub(super) mu: f64,
    /// Weight of dmu inside; 0 for a wanted direction.
    pub(super) weight: f64,
    /// Weight of 2 mu dmu outside; 0 where the light cannot leave.
    pub(super) outside: f64,
    /// Fresnel reflectance of a surface, and its complement.
    pub(super) reflect: f64,
    pub(super) transmit: f64,
}

impl Node {
    /// The direction that has the cosines `inside` and `outside` on the two sides of a surface.
    pub(super) fn crossing(eta: f64, inside: f64, outside: f64) -> Self {
        let (reflect, transmit) = fresnel(eta, inside, outside);
        Node { mu: inside, weight: 0.0, outside: 0.0, reflect, transmit }
    }

    /// A beam from outside, which does not enter beyond the critical angle of a rarer inside.
    pub(super) fn beam(eta: f64, cosine: f64) -> Self {
        let outside = cosine.clamp(GRAZING, 1.0);
        let square = ((eta - 1.0) * (eta + 1.0) + outside * outside) / (eta * eta);
        if square <= 0.0 {
            return Node { mu: 1.0, weight: 0.0, outside: 0.0, reflect: 1.0, transmit: 0.0 };
        }
        Node::crossing(eta, square.sqrt().min(1.0), outside)
    }
}

/// The directions of a calculation: the quadrature first, then one per wanted cosine.
pub(super) struct Grid {
    pub(super) nodes: Vec<Node>,
    /// Quadrature nodes among them.
    pub(super) core: usize,
    /// Legendre degree that is truncated: the largest the quadrature integrates well.
    pub(super) degree: usize,
}

impl Grid {
    /// Gauss nodes over (0, 1) inside. With eta > 1 they are divided at the critical angle, in proportion to the
    /// angle on each side of it, and those that can leave are Gauss nodes in the cosine OUTSIDE, since the Fresnel
    /// terms are smooth in that one only. Such a rule is not exact for polynomials in the cosine inside, and a degree
    /// above 1.5 per node was found to be unstable with it.
    pub(super) fn new(eta: f64, order: usize, cosines: &[f64]) -> Self {
        let mut nodes = Vec::with_capacity(order + cosines.len());
        if eta > 1.0 {
            let critical = (((eta - 1.0) * (eta + 1.0)).sqrt() / eta).min(1.0);
            let trapped = (order as f64 * (critical.asin() / (0.5 * PI)).clamp(0.125, 0.75)).round() as usize;
            nodes.extend(gauss(trapped).into_iter().map(|(x, weight)| Node {
                mu: critical * x,
                weight: critical * weight,
                outside: 0.0,
                reflect: 1.0,
                transmit: 0.0,
            }));
            nodes.extend(gauss(order - trapped).into_iter().map(|(x, weight)| {
                // A nearly matched index has its surface effects at cosines of the critical one's size: go there.
                let (outside, weight) = if critical < 0.1 { (x * x, 2.0 * x * weight) } else { (x, weight) };
                let node = Node::beam(eta, outside);
                Node { weight: weight * outside / (eta * eta * node.mu), outside: 2.0 * outside * weight, ..node }
            }));
        } else {
            nodes.extend(gauss(order).into_iter().map(|(mu, weight)| {
                let outside = ((1.0 - eta) * (1.0 + eta) + eta * eta * mu * mu).sqrt();
                Node { weight, outside: 2.0 * eta * eta * mu * weight, ..Node::crossing(eta, mu, outside) }
            }));
        }
        nodes.extend(cosines.iter().map(|&cosine| Node::beam(eta, cosine)));
        Grid { nodes, core: order, degree: if eta > 1.0 { 3 * order / 2 } else { 2 * order } }
    }
}

/// Unpolarised Fresnel reflectance and transmittance of a surface for the cosines on its two sides; `eta` is the
/// index inside over outside. The transmittance is not formed as a difference, so it keeps its digits near 0.
pub(super) fn fresnel(eta: f64, inside: f64, outside: f64) -> (f64, f64) {
    let polarised = |a: f64, b: f64| ((a - b) * (a - b), 4.0 * a * b, (a + b) * (a + b));
    let (rs, ts, s) = polarised(outside, eta * inside);
    let (rp, tp, p) = polarised(eta * outside, inside);
    (0.5 * (rs / s + rp / p), 0.5 * (ts / s + tp / p))
}

/// Gauss-Legendre nodes and weights over (0, 1), in falling order of the nodes.
pub(super) fn gauss(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    (0..order)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            // Newton from Tricomi's estimate is at rounding error after four steps.
            for _ in 0..6 {
                let (mut before, mut value) = (1.0, x);
                for k in 1..order {
                    let k = k as f64;
                    (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
                }
                slope = n * (before - x * value) / (1.0 - x * x);
                x -= value / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Legendre polynomials P_0 to P_degree at `x`.
pub(super) fn legendre(x: f64, degree: usize) -> Vec<f64> {
    let mut values = Vec::with_capacity(degree + 1);
    let (mut value, mut next) = (1.0, x);
    for l in 0..=degree {
        values.push(value);
        let l = l as f64;
        (value, next) = (next, ((2.0 * l + 3.0) * x * next - (l + 1.0) * value) / (l + 2.0));
    }
    values
}

/// Moments chi_l = 1/2 integral phase P_l dcos, l = 0 to `degree`, divided by chi_0. The panels halve towards both
/// poles, down to 2e-10 in 1 - |cos|, which resolves peaks far narrower than Henyey-Greenstein's at g = 0.9999.
pub(super) fn legendre_moments(phase: &dyn Fn(f64) -> f64, degree: usize) -> Vec<f64> {
    const PANELS: i32 = 32;
    let rule = gauss(degree / 2 + 8);
    let mut moments = vec![0.0; degree + 1];
    for panel in 0..=PANELS {
        let top = 0.5_f64.powi(panel);
        let width = if panel == PANELS { top } else { 0.5 * top };
        for &(x, weight) in &rule {
            let cos = 1.0 - (top - width * x);
            let (ahead, back) = (phase(cos), phase(-cos));
            for (l, (moment, value)) in moments.iter_mut().zip(legendre(cos, degree)).enumerate() {
                let both = if l % 2 == 0 { ahead + back } else { ahead - back };
                *moment += 0.5 * width * weight * value * both;
            }
        }
    }
    let total = moments[0];
    moments.iter_mut().for_each(|moment| *moment /= total);
    moments
}
