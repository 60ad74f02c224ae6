//! How far light flies through a medium before it scatters, drawn for all wavelengths at once.
//!
//! Wavelengths have coefficients of their own: a flight drawn by one of them says little of one that is a hundred times as dense. Ten
//! rates stand for all, those of the eighths of the wavelengths and the extremes; one is chosen by lot, by what the path still carries
//! of each, and the flight is weighed by the density with which any of them would have drawn it (the balance heuristic over
//! wavelengths, "spectral MIS" [Wilkie 2014; Miller 2019]). No weight is larger than the extremes' share of lots allows.
//!
//! Lengths are columns in metres: the integral of the density along a way.

use crate::medium::{Media, Medium};
use crate::render::inks::Outline;
use crate::render::lanes::{self, GROUP, Lanes};
use crate::simd;

/// Rates of a medium: the eighths', the extremes', and as many more of no share as make whole registers.
const RATES: usize = 2 * GROUP;
/// Those that count.
const COUNTED: usize = GROUP + 2;
/// Share of lots of each extreme.
const EXTREME: f32 = 0.04;
/// Optical depth up to which looks at the lamps are about as dense everywhere; beyond it they thin out, but never end: where the
/// lamp's leg gets shorter, light falls off along a way slower than flights do.
const DEEP: f32 = 8.0;
/// Optical depth from which nothing is seen of light that comes from a way's end.
const OPAQUE: f32 = 64.0;

/// Extinction coefficients that stand for all wavelengths, 1/m.
#[derive(Clone, Debug)]
pub struct Rates {
    sigma: [f32; RATES],
    /// The extremes count only where they differ from what the eighths have.
    extreme: f32,
    /// The largest of all wavelengths.
    pub most: f32,
    /// All are the same.
    grey: bool,
}

/// Rates with the lots that each has on a path.
pub struct Flight<'a> {
    rates: &'a Rates,
    shares: [f32; RATES],
    /// Column of the whole way, m, and what each rate leaves at its end.
    all: f32,
    left: [f32; RATES],
}

impl Rates {
    /// Of each medium, in a picture whose spectra have this outline.
    pub fn of(media: &Media, outline: &Outline) -> Vec<Rates> {
        media.list.iter().map(|m| Rates::new(m, outline)).collect()
    }

    fn new(medium: &Medium, outline: &Outline) -> Rates {
        let lanes = outline.one(medium.extinction).0.as_flattened();
        let [low, high] = medium.extremes;
        let mut sigma = [high; RATES];
        sigma[..GROUP].copy_from_slice(lanes);
        (sigma[GROUP], sigma[GROUP + 1]) = (low, high);
        let known = outline.lanes();
        let (least, most) = lanes[..known].iter().fold((f32::MAX, 0f32), |(a, b), s| (a.min(*s), b.max(*s)));
        let beyond = low < 0.9 * least || high > 1.1 * most;
        Rates { sigma, extreme: if beyond { EXTREME } else { 0.0 }, most: high, grey: high - low <= 1e-6 * high }
    }

    /// All of them.
    pub fn sigma(&self) -> &[f32] {
        &self.sigma[..COUNTED]
    }

    /// Along a way of this column, m, with the lots of a path that carries so much of each eighth.
    pub fn flight(&self, outline: &Outline, carried: &Lanes<1>, all: f32) -> Flight<'_> {
        let mut shares = [0f32; RATES];
        shares[GROUP..COUNTED].fill(self.extreme);
        let eighths = outline.shared(carried);
        for (share, lane) in shares.iter_mut().zip(eighths.0.as_flattened()) {
            *share = lane * (1.0 - 2.0 * self.extreme);
        }
        let mut left = [0f32; RATES];
        simd::wide(
            #[inline(always)]
            || {
                for (left, sigma) in left.iter_mut().zip(&self.sigma) {
                    *left = simd::exp(-sigma * all);
                }
            },
        );
        Flight { rates: self, shares, all, left }
    }
}

/// The sums of both halves.
#[inline(always)]
fn halved<const N: usize, const H: usize>(x: &[f32; N]) -> [f32; H] {
    let mut sums = [0f32; H];
    for i in 0..H {
        sums[i] = x[i] + x[i + H];
    }
    sums
}

impl Flight<'_> {
    /// Sum over the rates of their share times a function of them, and of what they leave at the way's end.
    #[inline(always)]
    fn mean(&self, f: impl Fn(f32, f32) -> f32) -> f32 {
        if self.rates.grey {
            return f(self.rates.most, simd::exp(-self.rates.most * self.all));
        }
        let (sigma, left, shares) = (self.rates.sigma, self.left, self.shares);
        let mut sums = [0f32; RATES];
        for i in 0..RATES {
            sums[i] = shares[i] * f(sigma[i], left[i]);
        }
        // By halves, as registers are added.
        let eight: [f32; 8] = halved(&sums);
        let four: [f32; 4] = halved(&eight);
        let [a, b] = halved(&four);
        a + b
    }

    /// The rate that a number in 0..1 chooses.
    pub fn choose(&self, lot: f32) -> f32 {
        if self.rates.grey {
            return self.rates.most;
        }
        self.rates.sigma[lanes::chosen(&self.shares, lot)]
    }

    /// The column after which light scatters; it may be infinite.
    pub fn column(&self, u: [f32; 2]) -> f32 {
        let sigma = self.choose(u[0]);
        // 1 - u is exact.
        if sigma > 0.0 { -(1.0 - u[1]).ln() / sigma } else { f32::INFINITY }
    }

    /// Density with which a column is drawn, 1/m.
    pub fn density(&self, column: f32) -> f32 {
        simd::wide(
            #[inline(always)]
            || self.mean(|s, _| s * simd::exp(-s * column)),
        )
    }

    /// Chance that it is longer than the way's.
    pub fn survival(&self) -> f32 {
        simd::wide(
            #[inline(always)]
            || self.mean(|_, left| left),
        )
    }

    /// A column below the way's.
    pub fn within(&self, u: [f32; 2]) -> f32 {
        let (sigma, all) = (self.choose(u[0]), self.all);
        let depth = sigma * all;
        let column = if depth < 1e-4 {
            // So thin that all places are alike.
            u[1] * all
        } else if depth < 0.25 {
            -(u[1] * (-depth).exp_m1()).ln_1p() / sigma
        } else {
            -(1.0 - u[1] * (1.0 - simd::exp(-depth))).ln() / sigma
        };
        column.min(all)
    }

    /// Density with which that is drawn, 1/m.
    pub fn density_within(&self, column: f32) -> f32 {
        let all = self.all;
        simd::wide(
            #[inline(always)]
            || {
                self.mean(
                    #[inline(always)]
                    |s, left| {
                        // Without a branch; of a rate of nothing too it is 1 / all.
                        let s = s.max(1e-34);
                        let (depth, part) = (s * all, s * simd::exp(-s * column));
                        part / if depth < 1e-3 { depth * (1.0 - 0.5 * depth) } else { 1.0 - left }
                    },
                )
            },
        )
    }

    /// The smallest rate that counts, 1/m; above 0.
    pub fn least(&self) -> f32 {
        let counts = self.each().filter(|(_, share)| *share > 0.02);
        counts.fold(self.rates.most, |a, (s, _)| a.min(s)).max(1e-30)
    }

    /// The rates, one by one, with their shares.
    pub fn each(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        self.rates.sigma().iter().copied().zip(self.shares)
    }
}

/// Columns of a way of `all` metres, c, with the density (1 + a / all) a / (a + c)^2: evenly on a way that is short beside `a`, without
/// an end on one that has none; half of them, on a way that has `ends`, as far from its end as light flies. From beyond the scene light
/// may be strongest there.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    all: f32,
    a: f32,
    ends: bool,
}

impl Spread {
    /// Of a way of this column, m.
    pub fn new(all: f32, flight: &Flight) -> Spread {
        let a = DEEP / flight.least();
        Spread { all, a, ends: all * flight.least() < OPAQUE }
    }

    /// Half of it lies at the end.
    pub fn ends(&self) -> bool {
        self.ends
    }

    /// Density with which a column is drawn, 1/m.
    pub fn density(&self, column: f32, flight: &Flight) -> f32 {
        let &Spread { all, a, ends } = self;
        let spread = (1.0 / a + 1.0 / all) / (1.0 + column / a).powi(2);
        if ends { 0.5 * (spread + flight.density_within(all - column)) } else { spread }
    }

    /// The column that two numbers in 0..1 draw: of the rate, and along it.
    pub fn column(&self, [choice, lot]: [f32; 2], flight: &Flight) -> f32 {
        let &Spread { all, a, ends } = self;
        if ends && lot >= 0.5 {
            return (all - flight.within([choice, 2.0 * lot - 1.0])).max(0.0);
        }
        let lot = if ends { 2.0 * lot } else { lot };
        let below = lot / (1.0 + a / all);
        (a * below / (1.0 - below)).min(all)
    }
}

/// Places along a way as evenly as they are seen from a point beside it, `length` of it from its start [Kulla 2012]: what falls off as
/// the square of the distance is even among them.
#[derive(Clone, Copy, Debug)]
pub struct Equiangular {
    /// Where the way is nearest, and how near.
    foot: f32,
    height: f32,
    /// The angle that the way fills.
    range: f32,
}

impl Equiangular {
    /// As seen from a point so far along the way, and beside it. `None` where it lies on the way itself.
    pub fn new(foot: f32, height: f32, length: f32) -> Option<Equiangular> {
        // That between the directions to both ends, whose cross and dot product these are.
        let range = if length.is_finite() {
            (height * length).atan2(height * height - foot * (length - foot))
        } else {
            height.atan2(-foot)
        };
        (height > 0.0 && range > 0.0).then_some(Equiangular { foot, height, range })
    }

    /// The place that a number in 0..1 draws: the direction to the start, turned by so much of the angle.
    pub fn place(&self, u: f32) -> f32 {
        let Equiangular { foot, height, range } = *self;
        let (sin, cos) = (range * u).sin_cos();
        foot + height * (height * sin - foot * cos) / (height * cos + foot * sin)
    }

    /// Density of a place.
    pub fn density(&self, t: f32) -> f32 {
        let off = t - self.foot;
        self.height / (self.range * (self.height * self.height + off * off))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of lots of their own, along a way of so much.
    fn flight(rates: &Rates, shares: [f32; RATES], all: f32) -> Flight<'_> {
        let left = rates.sigma.map(|s| simd::exp(-s * all));
        Flight { rates, shares, all, left }
    }

    fn rates(sigma: [f32; COUNTED]) -> (Rates, [f32; RATES]) {
        let (mut all, mut shares) = ([sigma[COUNTED - 1]; RATES], [0f32; RATES]);
        all[..COUNTED].copy_from_slice(&sigma);
        shares[..COUNTED].fill(1.0 / COUNTED as f32);
        (Rates { sigma: all, extreme: 1.0 / COUNTED as f32, most: sigma[COUNTED - 1], grey: false }, shares)
    }

    /// Densities integrate to 1, over thin and thick ways and with wavelengths that meet nothing; the mean of what is drawn is that
    /// of the density.
    #[test]
    fn columns_are_drawn_by_their_density() {
        let spread = [0.0, 1e-6, 0.01, 0.1, 0.5, 1.0, 2.0, 5.0, 0.0, 20.0];
        for (sigma, all) in
            [(spread, 3.0f32), (spread, 1e-3), (spread, 1e-7), ([2.0; COUNTED], 1.5), ([0.0; COUNTED], 2.0)]
        {
            let (rates, shares) = rates(sigma);
            let flight = flight(&rates, shares, all);
            let n = 4000;
            let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let (mut sum, mut mean, mut drawn) = (0.0, 0.0, 0.0);
            for i in 0..n {
                let column = f64::from(all) * middle(i);
                let density = f64::from(flight.density_within(column as f32));
                sum += density * f64::from(all) / f64::from(n);
                mean += column * density * f64::from(all) / f64::from(n);
                // Every rate has its turn, and each the same numbers.
                let (lot, u) = (i % COUNTED as i32, i / COUNTED as i32);
                let pair = [(lot as f32 + 0.5) / COUNTED as f32, (u as f32 + 0.5) / (n / COUNTED as i32) as f32];
                drawn += f64::from(flight.within(pair)) / f64::from(n);
            }
            assert!((sum - 1.0).abs() < 1e-4, "{sigma:?} over {all}: {sum}");
            assert!((mean - drawn).abs() < 2e-4 * f64::from(all), "{sigma:?} over {all}: {mean} {drawn}");
            let survival: f32 = sigma.iter().map(|s| (-s * all).exp()).sum::<f32>() / COUNTED as f32;
            assert!((flight.survival() - survival).abs() < 1e-6);
        }
    }

    /// The share of places up to one is the number that drew it: on ways that are thin, thick, and too thick for their end to be looked
    /// at; and density there is that share's slope.
    #[test]
    fn spread_places_are_drawn_by_their_density() {
        let (rates, shares) = rates([1.0; COUNTED]);
        for all in [1e-4f32, 1.0, 20.0, 60.0, 1e3, 1e9] {
            let flight = flight(&rates, shares, all);
            let spread = Spread::new(all, &flight);
            let n = 20_000;
            let mut drawn: Vec<f64> =
                (0..n).map(|i| f64::from(spread.column([0.5, (i as f32 + 0.5) / n as f32], &flight))).collect();
            drawn.sort_by(f64::total_cmp);
            for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
                // By hundreds of steps, each as long as the last times a little more: from nothing to a long way.
                let end = drawn[(share * f64::from(n)) as usize];
                let steps = 4000;
                let edge = |i: i32| end * ((f64::from(i) / f64::from(steps) * 9.0).exp_m1() / 9f64.exp_m1());
                let part = |i: i32| {
                    let (a, b) = (edge(i), edge(i + 1));
                    f64::from(spread.density((0.5 * (a + b)) as f32, &flight)) * (b - a)
                };
                let sum: f64 = (0..steps).map(part).sum();
                assert!((sum - share).abs() < 2e-3, "{all}: {sum} for {share}");
            }
            assert_eq!(spread.ends(), all < OPAQUE);
        }
    }

    /// The angle up to a place is the number that drew it, and its slope the density; beside the way, before and beyond it.
    #[test]
    fn places_are_even_in_angle() {
        for (foot, height, length) in [(1.0, 0.5, 3.0), (-2.0, 0.1, 1.0), (5.0, 1e-3, 4.0), (0.3, 2.0, f32::INFINITY)] {
            let seen = Equiangular::new(foot, height, length).unwrap();
            let angle = |t: f32| f64::from(t - foot).atan2(f64::from(height));
            let end = if length.is_finite() { angle(length) } else { std::f64::consts::FRAC_PI_2 };
            for i in 0..100 {
                let u = (i as f32 + 0.5) / 100.0;
                let t = seen.place(u);
                let want = (angle(t) - angle(0.0)) / (end - angle(0.0));
                assert!((f64::from(u) - want).abs() < 2e-4, "{foot} {height} {length}: {u} draws {t}, at {want}");
                let slope =
                    f64::from(height) / (end - angle(0.0)) / f64::from(height * height + (t - foot) * (t - foot));
                assert!((f64::from(seen.density(t)) / slope - 1.0).abs() < 2e-4);
            }
        }
        assert!(Equiangular::new(1.0, 0.0, 2.0).is_none());
    }
}
