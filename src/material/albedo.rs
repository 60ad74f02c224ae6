//! The share of light that a kernel passes on, as a table over the cosine of one direction.

use glam::Vec3A;

use crate::material::kernel::Kernel;

/// Nodes are even in the square root of the cosine, since grazing directions change most.
const NODES: usize = 65;
/// Directions a node, a Hammersley set.
const POINTS: u32 = 4096;

/// Albedo by cosine: E(cos) = integral of f |cos inc| over inc.
#[derive(Clone, Debug)]
pub struct Albedo {
    table: Vec<f32>,
    mean: f32,
}

impl Albedo {
    /// Of an isotropic kernel, by its own samples.
    pub fn of(kernel: &dyn Kernel) -> Albedo {
        Albedo::of_all(&[(kernel, 1.0)])
    }

    /// Of several, each times a factor.
    pub fn of_all(kernels: &[(&dyn Kernel, f32)]) -> Albedo {
        let node = |i: usize| {
            let root = (i as f32 / (NODES - 1) as f32).max(1e-2);
            let cos = root * root;
            let out = Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
            let weight = |i: u32| {
                let u = [(i as f32 + 0.5) / POINTS as f32, (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32];
                let one =
                    |(k, factor): &(&dyn Kernel, f32)| k.sample(out, u).map_or(0.0, |t| f64::from(t.weight * factor));
                kernels.iter().map(one).sum::<f64>()
            };
            ((0..POINTS).map(weight).sum::<f64>() / f64::from(POINTS)) as f32
        };
        Albedo::from_table((0..NODES).map(node).collect())
    }

    /// From values at cosines (i / (n - 1))^2, linear in the root between them.
    fn from_table(table: Vec<f32>) -> Albedo {
        // Mean 2 x integral of E c over c = 4 x integral of E r^3 over r = sqrt c, of the very lines that `at` gives: of a
        // nearly smooth surface all that is lost is lost at grazing angles, and must come back in full.
        let step = 1.0 / (table.len() - 1) as f64;
        let cell = |(i, pair): (usize, &[f32])| {
            let (r0, r1) = (i as f64 * step, (i + 1) as f64 * step);
            let (e0, slope) = (f64::from(pair[0]), f64::from(pair[1] - pair[0]) / step);
            (e0 - slope * r0) * (r1.powi(4) - r0.powi(4)) + slope * 0.8 * (r1.powi(5) - r0.powi(5))
        };
        let mean: f64 = table.windows(2).enumerate().map(cell).sum();
        Albedo { table, mean: mean as f32 }
    }

    /// For one direction, by its cosine.
    #[inline]
    pub fn at(&self, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0).sqrt() * (self.table.len() - 1) as f32;
        let i = (x as usize).min(self.table.len() - 2);
        let f = x - i as f32;
        self.table[i] * (1.0 - f) + self.table[i + 1] * f
    }

    /// For light from everywhere.
    pub fn mean(&self) -> f32 {
        self.mean
    }

    /// From a function of the cosine, such as a smooth surface's Fresnel reflectance.
    pub fn from_fn(f: impl Fn(f32) -> f32) -> Albedo {
        Albedo::from_table((0..NODES).map(|i| f((i as f32 / (NODES - 1) as f32).powi(2))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::kernel::ggx::Ggx;
    use crate::material::kernel::lambert::Lambert;
    use crate::optics::fresnel;

    #[test]
    fn known_albedos() {
        let white = Albedo::of(&Lambert { through: false });
        assert!((white.at(0.3) - 1.0).abs() < 1e-6 && (white.mean() - 1.0).abs() < 1e-5);
        let glass = Albedo::from_fn(|c| fresnel::dielectric(c, 1.5).0);
        assert!((f64::from(glass.mean()) - fresnel::diffuse(1.5)).abs() < 2e-4);
        // A smooth GGX surface loses nothing.
        let smooth = Albedo::of(&Ggx { alpha: 0.01, eta: None });
        assert!((smooth.at(0.5) - 1.0).abs() < 1e-3);
    }
}
