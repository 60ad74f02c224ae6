//! How light goes with the angle to an axis, or to the normal of the surface that gives it off: a power of the cosine, or a
//! table, linear in the angle.

use std::f64::consts::PI;

use glam::Vec3A;

use crate::scene::light::point::Distribution;

/// A factor by angle.
#[derive(Clone, Debug, PartialEq)]
pub enum Angular {
    /// cos^power, nothing behind.
    Cosine(f32),
    /// (angle in degrees, factor), angles ascending from 0; nothing beyond the last.
    Table(Vec<(f32, f32)>),
}

impl Angular {
    /// A table checked: two or more angles from 0 to at most 180, ascending, and factors from 0 of which one is above.
    pub fn table(points: &[[f64; 2]]) -> Option<Angular> {
        let fits = points.len() > 1
            && points[0][0] == 0.0
            && points.windows(2).all(|w| w[0][0] < w[1][0])
            && points.iter().all(|[deg, k]| *deg <= 180.0 && *k >= 0.0 && *k < 1e30)
            && points.iter().any(|p| p[1] > 0.0);
        fits.then(|| Angular::Table(points.iter().map(|[deg, k]| (*deg as f32, *k as f32)).collect()))
    }

    /// The factor at a cosine.
    ///
    /// ```
    /// use luxpipe::scene::light::angular::Angular;
    /// let beam = Angular::table(&[[0.0, 1.0], [30.0, 0.5], [40.0, 0.0]]).unwrap();
    /// assert!((beam.factor(15f32.to_radians().cos()) - 0.75).abs() < 1e-5 && beam.factor(0.0) == 0.0);
    /// ```
    pub fn factor(&self, cos: f32) -> f32 {
        match self {
            Angular::Cosine(_) if cos <= 0.0 => 0.0,
            Angular::Cosine(power) => cos.powf(*power),
            Angular::Table(points) => {
                let deg = cos.clamp(-1.0, 1.0).acos().to_degrees();
                let above = points.partition_point(|p| p.0 < deg);
                match (above.checked_sub(1).map(|i| points[i]), points.get(above)) {
                    (None, Some(first)) => first.1,
                    (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (deg - a.0) / (b.0 - a.0),
                    (_, None) => 0.0,
                }
            }
        }
    }

    /// Integral of the factor over the sphere, times the cosine over the front where a surface gives it off, sr.
    pub fn integral_sr(&self, surface: bool) -> f64 {
        if let Angular::Cosine(power) = self {
            return 2.0 * PI / (f64::from(*power) + if surface { 2.0 } else { 1.0 });
        }
        let last = if let Angular::Table(points) = self { points[points.len() - 1].0.into() } else { 180.0 };
        let end: f64 = f64::min(if surface { 90.0 } else { 180.0 }, last);
        // By Simpson's rule between the angles of the table and a step of half a degree.
        let mut nodes: Vec<f64> = (0..=(2.0 * end) as u32).map(|i| f64::from(i) / 2.0).chain([end]).collect();
        if let Angular::Table(points) = self {
            nodes.extend(points.iter().map(|p| f64::from(p.0)).filter(|deg| *deg < end));
        }
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let f = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            f64::from(self.factor(cos as f32)) * sin * if surface { cos } else { 1.0 }
        };
        let piece = |w: &[f64]| {
            let (a, b) = (w[0], w[1]);
            // Just within, where a table may end in a step.
            let inside = 1e-6 * (b - a);
            (f(a + inside) + 4.0 * f(0.5 * (a + b)) + f(b - inside)) * (b - a).to_radians() / 6.0
        };
        2.0 * PI * nodes.windows(2).map(piece).sum::<f64>()
    }
}

/// A point's light about an axis.
pub struct About {
    /// Unit axis.
    pub axis: Vec3A,
    /// By the angle to it.
    pub angular: Angular,
}

impl Distribution for About {
    fn factor(&self, direction: Vec3A) -> f32 {
        self.angular.factor(direction.dot(self.axis))
    }

    fn integral_sr(&self) -> f64 {
        self.angular.integral_sr(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_a_cosine_are_a_cosine() {
        for power in [0.0, 1.0, 5.0] {
            let cosine = Angular::Cosine(power);
            let points: Vec<[f64; 2]> = (0..=180)
                .map(|i| {
                    [f64::from(i) / 2.0, f64::from(i).to_radians().mul_add(0.5, 0.0).cos().max(0.0).powf(power.into())]
                })
                .collect();
            let table = Angular::table(&points).unwrap();
            for surface in [true, false] {
                let (a, b) = (cosine.integral_sr(surface), table.integral_sr(surface));
                assert!((a / b - 1.0).abs() < 1e-3, "{power} {surface}: {a} {b}");
            }
        }
        let sphere = Angular::table(&[[0.0, 1.0], [180.0, 1.0]]).unwrap();
        assert!((sphere.integral_sr(false) - 4.0 * PI).abs() < 1e-6);
        for wrong in
            [&[[0.0, 1.0]][..], &[[1.0, 1.0], [2.0, 1.0]], &[[0.0, 0.0], [90.0, 0.0]], &[[0.0, 1.0], [200.0, 1.0]]]
        {
            assert!(Angular::table(wrong).is_none());
        }
    }
}
