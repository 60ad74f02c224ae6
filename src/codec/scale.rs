//! The scale at which an encoding of limited range holds most of a picture.

/// How many values lie in each quarter of an octave.
pub struct Octaves {
    /// By the leading bits, of what does not count too, so that every value takes the same few steps: what is infinite, NaN or
    /// negative comes last. What lies in the first, up to 3e-39, is as good as 0.
    counts: Box<[[u64; SLOTS]; TURNS]>,
    /// The largest bits of a finite positive value.
    largest: u32,
}

/// Light beyond this, in cd/m2, is an error or infinite: no scale is chosen for it.
const MOST: f32 = 1e30;

/// A float's bits without the lowest: the quarter of an octave it lies in.
const SHIFT: u32 = 21;
/// Values are counted in turns here and there: neighbours are alike, and counting in one place waits for the count before.
const TURNS: usize = 4;
/// All there are.
const SLOTS: usize = 1 << (32 - SHIFT);

impl Default for Octaves {
    fn default() -> Self {
        Octaves { counts: Box::new([[0; SLOTS]; TURNS]), largest: 0 }
    }
}

impl Octaves {
    /// Counts values; only what is above 0 and finite matters.
    pub fn add(&mut self, values: impl IntoIterator<Item = f32>) {
        for (i, value) in values.into_iter().enumerate() {
            let bits = value.to_bits();
            self.counts[i % TURNS][(bits >> SHIFT) as usize] += 1;
            self.largest = self.largest.max(if bits < f32::INFINITY.to_bits() { bits } else { 0 });
        }
    }

    /// The largest value counted, 0 if there is none.
    pub fn largest(&self) -> f32 {
        f32::from_bits(self.largest)
    }

    /// A power of two s at which values v are stored as v / s, from `bottom` to `top`: at most one in a thousand lies above,
    /// since a viewer misses lost highlights more than lost shadows; as many as that allows lie above the bottom. Where all
    /// fit at several, the middle one; 1 where there is no value. Scales lie within 1e-30 and 1e30.
    ///
    /// ```
    /// let mut octaves = luxpipe::codec::scale::Octaves::default();
    /// octaves.add([100.0, 1600.0]);
    /// assert_eq!(octaves.best(0.01, 16.0), 1024.0); // 128, 256 and so on to 8192 would hold them too
    /// ```
    pub fn best(&self, bottom: f64, top: f64) -> f64 {
        let sensible = (MOST.to_bits() >> SHIFT) as usize;
        let edge = |i: usize| f64::from(f32::from_bits((i as u32) << SHIFT));
        let counts: Vec<u64> = (0..sensible).map(|i| self.counts.iter().map(|turn| turn[i]).sum()).collect();
        let filled = || counts.iter().enumerate().skip(1).filter(|(_, n)| **n > 0);
        let total: u64 = filled().map(|(_, n)| n).sum();
        let over = |s: f64| -> u64 {
            filled().filter(|(i, _)| edge(i + 1).min(f64::from(self.largest())) > top * s).map(|(_, n)| n).sum()
        };
        let mut scales = (-99..=99).map(|k| 2f64.powi(k)).skip_while(|s| over(*s) > total / 1000);
        let (Some(first), Some((lowest, _))) = (scales.next(), filled().next()) else { return 1.0 };
        let all = std::iter::once(first).chain(scales);
        let fitting: Vec<f64> = all.filter(|s| over(*s) == 0 && edge(lowest) >= bottom * s).collect();
        fitting.get(fitting.len() / 2).copied().unwrap_or(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn highlights_come_first_and_a_few_do_not_count() {
        let mut octaves = Octaves::default();
        octaves.add([1e-4; 9000]);
        octaves.add([100.0; 2000]);
        assert_eq!(octaves.best(0.001, 16.0), 8.0);
        octaves.add([1.6e9; 5]);
        assert_eq!(octaves.best(0.001, 16.0), 8.0);
        assert_eq!(Octaves::default().best(0.001, 16.0), 1.0);
        // Infinities, as they come bounded, are no highlights.
        let mut octaves = Octaves::default();
        octaves.add([1e37, 1e37, 10.0]);
        assert_eq!(octaves.best(0.001, 16.0), 128.0); // the middle of 1 to 8192
    }
}
