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

/// Rates of a medium.
const RATES: usize = GROUP + 2;
/// Share of lots of each extreme.
const EXTREME: f32 = 0.04;

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
}

impl Rates {
    /// Of each medium, in a picture whose spectra have this outline.
    pub fn of(media: &Media, outline: &Outline) -> Vec<Rates> {
        media.list.iter().map(|m| Rates::new(m, outline)).collect()
    }

    fn new(medium: &Medium, outline: &Outline) -> Rates {
        let lanes = outline.one(medium.extinction).0.as_flattened();
        let [low, high] = medium.extremes;
        let mut sigma = [0f32; RATES];
        sigma[..GROUP].copy_from_slice(lanes);
        (sigma[GROUP], sigma[GROUP + 1]) = (low, high);
        let known = outline.lanes();
        let (least, most) = lanes[..known].iter().fold((f32::MAX, 0f32), |(a, b), s| (a.min(*s), b.max(*s)));
        let beyond = low < 0.9 * least || high > 1.1 * most;
        Rates { sigma, extreme: if beyond { EXTREME } else { 0.0 }, most: high, grey: high - low <= 1e-6 * high }
    }

    /// All of them.
    pub fn sigma(&self) -> &[f32] {
        &self.sigma
    }

    /// With the lots of a path that carries so much of each eighth.
    pub fn flight(&self, outline: &Outline, carried: &Lanes<1>) -> Flight<'_> {
        let mut shares = [self.extreme; RATES];
        let eighths = outline.shared(carried);
        for (share, lane) in shares.iter_mut().zip(eighths.0.as_flattened()) {
            *share = lane * (1.0 - 2.0 * self.extreme);
        }
        Flight { rates: self, shares }
    }
}

impl Flight<'_> {
    /// Sum over the rates of their share times a function of them.
    #[inline(always)]
    fn mean(&self, f: impl Fn(f32) -> f32) -> f32 {
        if self.rates.grey {
            return f(self.rates.most);
        }
        let mut sum = 0.0;
        for i in 0..RATES {
            sum += self.shares[i] * f(self.rates.sigma[i]);
        }
        sum
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
        if sigma > 0.0 { -(-u[1]).ln_1p() / sigma } else { f32::INFINITY }
    }

    /// Density with which a column is drawn, 1/m.
    pub fn density(&self, column: f32) -> f32 {
        simd::wide(
            #[inline(always)]
            || self.mean(|s| s * simd::exp(-s * column)),
        )
    }

    /// Chance that it is longer than that.
    pub fn survival(&self, column: f32) -> f32 {
        simd::wide(
            #[inline(always)]
            || self.mean(|s| simd::exp(-s * column)),
        )
    }

    /// A column below `all`.
    pub fn within(&self, all: f32, u: [f32; 2]) -> f32 {
        let sigma = self.choose(u[0]);
        let depth = sigma * all;
        // So thin that all places are alike.
        let column = if depth < 1e-4 { u[1] * all } else { -(u[1] * (-depth).exp_m1()).ln_1p() / sigma };
        column.min(all)
    }

    /// Density with which that is drawn, 1/m.
    pub fn density_within(&self, column: f32, all: f32) -> f32 {
        simd::wide(
            #[inline(always)]
            || {
                self.mean(|s| {
                    let depth = s * all;
                    if depth < 1e-4 { 1.0 / all } else { s * simd::exp(-s * column) / (1.0 - simd::exp(-depth)) }
                })
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
        self.rates.sigma.iter().copied().zip(self.shares.iter().copied())
    }
}

/// Places along a way as evenly as they are seen from a point beside it, `length` of it from its start [Kulla 2012]: what falls off as
/// the square of the distance is even among them.
#[derive(Clone, Copy, Debug)]
pub struct Equiangular {
    /// Where the way is nearest, and how near.
    foot: f32,
    height: f32,
    /// Angles to its ends from there.
    from: f32,
    to: f32,
}

impl Equiangular {
    /// As seen from a point so far along the way, and beside it. `None` where it lies on the way itself.
    pub fn new(foot: f32, height: f32, length: f32) -> Option<Equiangular> {
        let (from, to) = (
            (-foot).atan2(height),
            if length.is_finite() { (length - foot).atan2(height) } else { std::f32::consts::FRAC_PI_2 },
        );
        (height > 0.0 && to > from).then_some(Equiangular { foot, height, from, to })
    }

    /// The place that a number in 0..1 draws.
    pub fn place(&self, u: f32) -> f32 {
        self.foot + self.height * (self.from + (self.to - self.from) * u).tan()
    }

    /// Density of a place.
    pub fn density(&self, t: f32) -> f32 {
        let off = t - self.foot;
        self.height / ((self.to - self.from) * (self.height * self.height + off * off))
    }
}
