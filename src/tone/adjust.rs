//! Histogram adjustment: technique C of the paper, the method of [Ward 1997].
//!
//! The cumulative distribution P of ln L gives ln Ld = ln Ldmin + P (ln Ldmax - ln Ldmin). Where a peak would give the display
//! more contrast than the world had, its counts are trimmed: with T the counts left, a bin of width db and count c makes
//! ln Ld rise by c (ln Ldmax - ln Ldmin) / T, and that rise has a ceiling. By ratios of luminance ([`Scale::Ratio`], the
//! *linear ceiling*) it is db; by visibility it is what the bin has in threshold steps, which makes
//! dLd / dLw <= dLt(Ld) / dLt(Lw).
//!
//! The original repeats the trimming until little is trimmed and gives up, with a jump to a linear map, when little is left
//! (see [`super::classic`]). Here T is the solution itself: the map is followed up from black, bin by bin, and T is that for
//! which it ends at white. The end falls as T grows, so there is one solution or none; none means that the occupied bins
//! need less than the display has.
//!
//! Where the share T / T0 of the counts that survive falls from 30 % to 2.5 %, the map glides into the one that keeps all
//! contrast and clips, [`exposure`], so that no small change of the picture makes a large one of the map.

use crate::tone::histogram::Histogram;
use crate::tone::{Curve, Display, Scale};

/// Bins of the adjusted histogram.
pub const BINS: usize = 100;
/// With this share of the counts surviving the trimming, or less, the map clips.
const CLIPPED_BELOW: f64 = 0.025;
/// With this share or more it is the adjusted histogram alone.
const ADJUSTED_ABOVE: f64 = 0.30;
/// How far, in lengths of what does not fit, an exposure may go beyond the display's ends.
const GIVE: f64 = 3.0;

/// The shift on `scale` of the map that keeps all contrast. The mean of ln L goes to the middle of what is seen of the display, or by
/// visibility as many steps over darkness as it has in the world when those are fewer, so that night stays dark. A scene that
/// fits the display is shifted until all of it shows; one that is too long by x may stick out by up to 3 x more than it must.
pub fn exposure(histogram: &Histogram, display: Display, scale: &Scale) -> f64 {
    let Some((low, high)) = histogram.range_cd_m2() else { return 0.0 };
    let mean = histogram.mean_ln();
    let middle = display.seen().middle_cd_m2().ln();
    let (ln_min, ln_max) = display.ln();
    let (here, there) = (scale.world(mean), scale.display(middle));
    let shift = match scale {
        Scale::Ratio => there - here,
        Scale::Visibility { .. } => there.min(here) - here,
    };
    let darkest = scale.display(ln_min) - scale.world(low.ln());
    let brightest = scale.display(ln_max) - scale.world(high.ln());
    let give = GIVE * (darkest - brightest).max(0.0);
    shift.clamp(darkest.min(brightest) - give, darkest.max(brightest) + give)
}

/// Length of the scene and of the display on the scale.
pub fn lengths(histogram: &Histogram, display: Display, scale: &Scale) -> (f64, f64) {
    let Some((low, high)) = histogram.range_cd_m2() else { return (0.0, 0.0) };
    let (ln_min, ln_max) = display.ln();
    (scale.world(high.ln()) - scale.world(low.ln()), scale.display(ln_max) - scale.display(ln_min))
}

/// The map that keeps all contrast on `scale`, black and white its ends.
pub fn exposed(histogram: &Histogram, display: Display, scale: &Scale) -> Curve {
    let shift = exposure(histogram, display, scale);
    match (scale, histogram.range_cd_m2()) {
        (Scale::Ratio, _) | (_, None) => Curve::linear(shift.exp(), display),
        (_, Some((low, high))) => {
            // Followed finely, on the display's side too, where it may be steep.
            let (a, b) = (scale.world(low.ln()), scale.world(high.ln()));
            let (ln_min, ln_max) = display.ln();
            let (from, to) = (scale.display(ln_min), scale.display(ln_max));
            let n = 4 * BINS;
            let at = |i: usize| a + (b - a) * i as f64 / n as f64;
            let point = |i: usize| (scale.world_ln(at(i)), scale.display_ln((at(i) + shift).clamp(from, to)));
            Curve::new((0..=n).map(point).collect(), display)
        }
    }
}

/// The adjusted map, and the share of the counts that survived trimming (1 for a scene that fits).
pub fn adjusted(histogram: &Histogram, display: Display, scale: &Scale) -> (Curve, f64) {
    let keeping = exposed(histogram, display, scale);
    let (scene, shown) = lengths(histogram, display, scale);
    if scene <= shown {
        return (keeping, 1.0);
    }
    let bins = Bins::new(histogram, display, scale);
    let (points, share) = bins.solve();
    let blend = smoothstep((share - CLIPPED_BELOW) / (ADJUSTED_ABOVE - CLIPPED_BELOW));
    let mixed = |(world, adjusted): (f64, f64)| {
        let kept = keeping.ln_at(world);
        (world, kept + blend * (adjusted - kept))
    };
    (Curve::new(points.into_iter().map(mixed).collect(), display), share)
}

/// What the march needs of each bin.
struct Bins<'a> {
    scale: &'a Scale,
    display: Display,
    /// ln Lw of the edges, one more than bins.
    edges: Vec<f64>,
    counts: Vec<f64>,
    total: f64,
}

impl Bins<'_> {
    fn new<'a>(histogram: &Histogram, display: Display, scale: &'a Scale) -> Bins<'a> {
        let even = histogram.even(BINS, |ln| ln);
        let edges = (0..=BINS).map(|i| even.low + even.width() * i as f64).collect();
        Bins { scale, display, edges, total: even.total(), counts: even.counts }
    }

    /// The map from black up when `left` counts are left: ln Ld at each edge. It may end above white.
    fn follow(&self, left: f64) -> Vec<f64> {
        let (ln_min, ln_max) = self.display.ln();
        let mut at = ln_min;
        let mut list = vec![at];
        for (count, edge) in self.counts.iter().zip(self.edges.windows(2)) {
            let rise = count * (ln_max - ln_min) / left;
            let ceiling = match self.scale {
                Scale::Ratio => edge[1] - edge[0],
                scale => {
                    let steps = scale.world(edge[1]) - scale.world(edge[0]);
                    scale.display_ln(scale.display(at) + steps) - at
                }
            };
            at += rise.min(ceiling);
            list.push(at);
        }
        list
    }

    /// The map (ln Lw, ln Ld) and the share of counts left.
    fn solve(&self) -> (Vec<(f64, f64)>, f64) {
        let (_, ln_max) = self.display.ln();
        let end = |share: f64| self.follow(share * self.total)[BINS];
        // ln of the share between nothing and all.
        let (mut low, mut high) = (-30.0f64, 0.0f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if end(middle.exp()) >= ln_max { low = middle } else { high = middle }
        }
        let share = low.exp();
        let map = self.follow(share * self.total).into_iter().map(|y| y.min(ln_max));
        let share = if low <= -29.0 { 0.0 } else { share };
        (self.edges.iter().copied().zip(map).collect(), share)
    }
}

/// 0 under 0, 1 over 1, and smooth between.
pub(super) fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
