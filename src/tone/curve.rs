//! A tone curve: display luminance as a function of world luminance, and its application to pixels.

use crate::tone::Display;

/// Table steps an octave for pixels: the interpolation error of the factor stays under 1e-5.
const STEPS_LOG2: u32 = 7;

/// A rising curve from world to display luminance. Between its points ln Ld is linear in ln Lw; beyond them it goes on at
/// slope 1 until it meets the display's black or white.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// (ln Lw, ln Ld), both in cd/m2, ascending; at least one.
    points: Vec<(f64, f64)>,
    display: Display,
    /// Exponent on the share of the display's range.
    contrast: f64,
}

impl Curve {
    /// From points that ascend in both coordinates.
    pub fn new(points: Vec<(f64, f64)>, display: Display) -> Curve {
        Curve { points, display, contrast: 1.0 }
    }

    /// Ld = factor x Lw.
    pub fn linear(factor: f64, display: Display) -> Curve {
        Curve { points: vec![(0.0, factor.ln())], display, contrast: 1.0 }
    }

    /// The same with the share of the display's range raised to a power: for a dim or dark surround, in which a picture loses
    /// contrast [Bartleson and Breneman 1967].
    pub fn with_contrast(self, exponent: f64) -> Curve {
        Curve { contrast: exponent, ..self }
    }

    /// The points (ln Lw, ln Ld) of this curve, each brought within `most` of `previous` in ln Ld, at the places of both.
    /// The median of rising curves rises, and is nowhere steeper than the steepest.
    pub fn limited(&self, previous: &Curve, most: f64) -> Curve {
        let mut places: Vec<f64> = self.points.iter().chain(&previous.points).map(|p| p.0).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        // The clamped curve bends where the two come to differ by `most`: between places, too.
        let fine: Vec<f64> =
            places.windows(2).flat_map(|w| (0..4).map(|k| w[0] + (w[1] - w[0]) * k as f64 / 4.0)).collect();
        let all = fine.into_iter().chain(places.last().copied());
        let limit = |x: f64| {
            let before = previous.shown_ln(x);
            (x, self.ln_at(x).clamp(before - most, before + most))
        };
        Curve { points: all.map(limit).collect(), ..self.clone() }
    }

    /// ln Ld at ln Lw, before the surround's contrast.
    pub fn ln_at(&self, ln_world: f64) -> f64 {
        let p = &self.points;
        let above = p.partition_point(|q| q.0 < ln_world);
        let y = match (above.checked_sub(1).map(|i| p[i]), p.get(above)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (ln_world - a.0) / (b.0 - a.0),
            (None, Some(b)) => b.1 + (ln_world - b.0),
            (Some(a), None) => a.1 + (ln_world - a.0),
            (None, None) => ln_world,
        };
        let (min, max) = self.display.ln();
        y.clamp(min, max)
    }

    /// ln Ld as shown.
    fn shown_ln(&self, ln_world: f64) -> f64 {
        if self.contrast == 1.0 { self.ln_at(ln_world) } else { self.at(ln_world.exp()).ln() }
    }

    /// Display luminance in cd/m2 for a world luminance in cd/m2, between the display's black and white.
    pub fn at(&self, luminance_cd_m2: f64) -> f64 {
        let Display { max_cd_m2, min_cd_m2 } = self.display;
        min_cd_m2 + self.share(luminance_cd_m2) * (max_cd_m2 - min_cd_m2)
    }

    /// Share of the display's range, 0 black to 1 white, for a world luminance.
    pub fn share(&self, luminance_cd_m2: f64) -> f64 {
        if luminance_cd_m2.is_nan() || luminance_cd_m2 <= 0.0 {
            return 0.0;
        }
        let Display { max_cd_m2, min_cd_m2 } = self.display;
        let shown = self.ln_at(luminance_cd_m2.ln()).exp();
        let share = ((shown - min_cd_m2) / (max_cd_m2 - min_cd_m2)).clamp(0.0, 1.0);
        if self.contrast == 1.0 { share } else { share.powf(self.contrast) }
    }

    /// The curve as a table for pixels.
    pub fn table(&self) -> Table {
        let steps = 1usize << STEPS_LOG2;
        let factor = |bits: u32| {
            let l = f64::from(f32::from_bits(bits));
            (self.share(l) / l) as f32
        };
        let mut entries = Vec::with_capacity(254 * steps);
        for i in 0..254 * steps as u32 {
            let bits = (1 << 23) + (i << (23 - STEPS_LOG2));
            let (a, b) = (factor(bits), factor(bits + (1 << (23 - STEPS_LOG2)) - 1));
            entries.push([a, b - a]);
        }
        entries.push([0.0; 2]);
        Table { entries }
    }
}

/// Factors from world to display values, indexed by the leading bits of the luminance; the last one is that of none.
pub struct Table {
    entries: Vec<[f32; 2]>,
}

impl Table {
    /// The factor that takes a pixel of this luminance to the display's 0..1; 0 where the luminance is not positive.
    #[inline(always)]
    pub fn factor(&self, luminance_cd_m2: f32) -> f32 {
        self.factors(&[luminance_cd_m2])[0]
    }

    /// The same for many.
    #[inline(always)]
    pub fn factors<const M: usize>(&self, luminances_cd_m2: &[f32; M]) -> [f32; M] {
        const FRACTION: u32 = 23 - STEPS_LOG2;
        let last = self.entries.len() - 1;
        let (mut at, mut low) = ([0u32; M], [0f32; M]);
        for i in 0..M {
            let bits = luminances_cd_m2[i].to_bits();
            // Subnormal, negative, infinite and NaN luminances all fall outside.
            at[i] = (bits >> FRACTION).wrapping_sub(1 << STEPS_LOG2).min(last as u32);
            low[i] = (bits & ((1 << FRACTION) - 1)) as i32 as f32 * (1.0 / (1u32 << FRACTION) as f32);
        }
        let (mut factors, mut slopes) = ([0f32; M], [0f32; M]);
        for i in 0..M {
            [factors[i], slopes[i]] = self.entries[at[i] as usize];
        }
        for i in 0..M {
            factors[i] += slopes[i] * low[i];
        }
        factors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_agrees_with_the_curve() {
        let display = Display { max_cd_m2: 100.0, min_cd_m2: 1.0 };
        let points = (0..=20).map(|i| (f64::from(i) - 5.0, 0.23 * f64::from(i))).collect();
        let curve = Curve::new(points, display);
        let table = curve.table();
        let mut l = 1e-2f32;
        while l < 1e6 {
            let want = curve.share(f64::from(l));
            let got = f64::from(table.factor(l) * l);
            assert!((got - want).abs() < 2e-4 * want + 1e-6, "{l}: {got} {want}");
            l *= 1.013;
        }
        for l in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-40] {
            assert_eq!(table.factor(l), 0.0);
        }
    }
}
