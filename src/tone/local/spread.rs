//! How values of ln L are spread, and where they go on a display.
//!
//! A picture's range is where all but a thousandth of its pixels at each end lie: a lamp's filament does not darken the room.
//! Where the display has room left, the range grows toward the extremes, both ends alike, until it is used up; a picture that
//! fits has all of it in its range. Counts are whole numbers and sums are of fixed point, so that no order of adding, and no
//! number of threads, changes a bit.

use std::ops::Range;

/// Share of the pixels at each end that may leave the display where it has no room for all.
const OUTLIERS: f64 = 1e-3;
/// Values collected: ln L over the least of the picture, and what detail adds to it. Beyond lie only extremes.
const VALUES: Range<f32> = -16.0..112.0;
/// Bins a unit of ln L.
const STEPS: f32 = 128.0;
/// Fixed point: 2^31 pixels of a value of 100 keep within 64 bits.
const UNIT: f64 = (1u64 << 24) as f64;

/// Counts of values.
#[derive(Clone, Debug)]
pub struct Spread {
    bins: Vec<u64>,
    count: u64,
    sum: i64,
    least: f32,
    most: f32,
}

impl Default for Spread {
    fn default() -> Spread {
        let bins = ((VALUES.end - VALUES.start) * STEPS) as usize;
        Spread { bins: vec![0; bins], count: 0, sum: 0, least: f32::MAX, most: f32::MIN }
    }
}

impl Spread {
    /// Counts one value.
    #[inline(always)]
    pub fn add(&mut self, value: f32) {
        let bin = ((value - VALUES.start) * STEPS) as usize; // what is under the range saturates to 0
        let bin = bin.min(self.bins.len() - 1);
        self.bins[bin] += 1;
        self.count += 1;
        self.sum += (f64::from(value) * UNIT) as i64;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    /// Adds all of `other`.
    pub fn merge(&mut self, other: &Spread) {
        self.bins.iter_mut().zip(&other.bins).for_each(|(a, b)| *a += b);
        self.count += other.count;
        self.sum += other.sum;
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
    }

    /// The mean.
    fn mean(&self) -> f64 {
        self.sum as f64 / UNIT / self.count as f64
    }

    /// The value under which this share of the counts lies, to a part of a bin.
    fn quantile(&self, share: f64) -> f64 {
        let (least, most) = (f64::from(self.least), f64::from(self.most));
        let mut left = share * self.count as f64;
        for (i, n) in self.bins.iter().enumerate().filter(|(_, n)| **n > 0) {
            if left <= *n as f64 {
                let within = (i as f64 + left / *n as f64) / f64::from(STEPS) + f64::from(VALUES.start);
                return within.clamp(least, most);
            }
            left -= *n as f64;
        }
        most
    }

    /// Both ends of the range, for a display of `room` in ln L.
    pub fn ends(&self, room: f64) -> (f64, f64) {
        let (low, high) = (self.quantile(OUTLIERS), self.quantile(1.0 - OUTLIERS));
        let (below, above) = (low - f64::from(self.least), f64::from(self.most) - high);
        let spare = (room - (high - low)).max(0.0);
        let share = if below + above > spare { spare / (below + above) } else { 1.0 };
        (low - share * below, high + share * above)
    }

    /// Width of the range.
    pub fn width(&self, room: f64) -> f64 {
        let (low, high) = self.ends(room);
        high - low
    }

    /// What is to be added to each value: the mean comes to the middle of `black` to `white`, and from there as little is moved
    /// as shows all of a range that fits, or fills the display with one that does not.
    pub fn shift(&self, black: f64, white: f64) -> f64 {
        let (low, high) = self.ends(white - black);
        let (a, b) = (black - low, white - high);
        ((black + white) / 2.0 - self.mean()).clamp(a.min(b), a.max(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(values: impl IntoIterator<Item = f32>) -> Spread {
        let mut s = Spread::default();
        values.into_iter().for_each(|v| s.add(v));
        s
    }

    #[test]
    fn an_even_spread_has_known_ends() {
        let s = spread((0..=100_000).map(|i| i as f32 / 10_000.0));
        let (low, high) = s.ends(4.0);
        assert!((low - 0.01).abs() < 0.01 && (high - 9.99).abs() < 0.01, "{low} {high}");
        assert!((s.mean() - 5.0).abs() < 1e-6);
        // Room for half of what lies outside, and for all.
        let (low, high) = s.ends(9.99);
        assert!((low - 0.005).abs() < 0.005 && (high - 9.995).abs() < 0.005 && high - low < 9.991, "{low} {high}");
        assert_eq!(s.ends(11.0), (0.0, 10.0));
    }

    #[test]
    fn what_fits_is_shown_whole_near_the_middle() {
        let s = spread([0.0, 1.0, 1.0, 1.0]);
        assert!((s.shift(0.0, 4.0) - 1.25).abs() < 1e-6); // mean 0.75 to 2
        let s = spread([0.0, 3.0, 3.0, 3.0]);
        assert!((s.shift(0.0, 4.0) - 0.0).abs() < 1e-6); // mean 2.25 to 2 would hide the least
        let s = spread([0.0, 8.0]);
        assert!((s.shift(0.0, 4.0) + 2.0).abs() < 0.01); // does not fit: the mean in the middle
    }
}
