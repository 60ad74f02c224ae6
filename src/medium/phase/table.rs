//! `{ type = "table", angles = [[0, 90], [10, 20], [180, 1]] }`: degrees of scattering, ascending from 0 to 180, and how much light
//! goes there, in any unit: it is normalised. Between the angles it is linear in their cosine.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::Result;
use crate::keys::Keys;
use crate::medium::phase::Phase;

/// Piecewise linear in the versine.
#[derive(Clone, Debug)]
pub struct Table {
    /// Versine, density in 1/sr, and the share of light that scatters by less.
    nodes: Vec<[f32; 3]>,
    mean_cosine: f64,
}

impl Table {
    /// Of (degrees, amount), ascending from 0 to 180, amounts from 0, of which one is above; `None` of others.
    pub fn new(points: &[[f64; 2]]) -> Option<Table> {
        let fits = points.len() > 1
            && points[0][0] == 0.0
            && points[points.len() - 1][0] == 180.0
            && points.windows(2).all(|w| w[0][0] < w[1][0])
            && points.iter().all(|[_, k]| *k >= 0.0 && *k < 1e30);
        if !fits {
            return None;
        }
        let half = |deg: f64| (deg.to_radians() * 0.5).sin();
        let nodes: Vec<[f64; 2]> = points.iter().map(|[deg, k]| [2.0 * half(*deg).powi(2), *k]).collect();
        let piece = |w: &[[f64; 2]]| PI * (w[1][0] - w[0][0]) * (w[0][1] + w[1][1]);
        let total: f64 = nodes.windows(2).map(piece).sum();
        if total <= 0.0 {
            return None;
        }
        // Simpson's rule is exact for the square of what is linear.
        let turned = |w: &[[f64; 2]]| {
            let middle = 0.25 * (w[0][1] + w[1][1]) * (w[0][0] + w[1][0]);
            2.0 * PI * (w[1][0] - w[0][0]) * (w[0][0] * w[0][1] + 4.0 * middle + w[1][0] * w[1][1]) / 6.0
        };
        let mean_cosine = 1.0 - nodes.windows(2).map(turned).sum::<f64>() / total;
        let mut below = 0.0;
        let mut table = vec![[0.0, (nodes[0][1] / total) as f32, 0.0]];
        for w in nodes.windows(2) {
            below += piece(w) / total;
            table.push([w[1][0] as f32, (w[1][1] / total) as f32, below as f32]);
        }
        Some(Table { nodes: table, mean_cosine })
    }
}

impl Phase for Table {
    fn value(&self, versine: f32) -> f32 {
        let i = self.nodes.partition_point(|n| n[0] <= versine).clamp(1, self.nodes.len() - 1);
        let ([a, p, _], [b, q, _]) = (self.nodes[i - 1], self.nodes[i]);
        p + (q - p) * ((versine - a) / (b - a)).clamp(0.0, 1.0)
    }

    fn sample(&self, u: f32) -> f32 {
        let i = self.nodes.partition_point(|n| n[2] <= u).clamp(1, self.nodes.len() - 1);
        let ([a, p, below], [b, q, above]) = (self.nodes[i - 1], self.nodes[i]);
        if above <= below {
            return a;
        }
        // The share within a piece is p x + (q - p) x^2 / 2 of its end's (p + q) / 2.
        let share = ((u - below) / (above - below)).clamp(0.0, 1.0) * 0.5 * (p + q);
        let x = 2.0 * share / (p + (p * p + 2.0 * (q - p) * share).max(0.0).sqrt()).max(f32::MIN_POSITIVE);
        a + (b - a) * x.clamp(0.0, 1.0)
    }

    fn mean_cosine(&self) -> f64 {
        self.mean_cosine
    }
}

/// Reads one.
pub fn read(keys: &mut Keys) -> Result<Arc<dyn Phase>> {
    let Some((points, span)) = keys.get_spanned::<Vec<[f64; 2]>>("angles")? else {
        return Err(keys.wrong("key 'angles' is missing"));
    };
    let wrong = "expected [degrees, amount] ascending from 0 to 180, amounts from 0 and one above";
    let table = Table::new(&points).ok_or_else(|| keys.wrong_key("angles", span, wrong))?;
    Ok(Arc::new(table))
}
