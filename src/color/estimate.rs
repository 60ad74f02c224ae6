//! Guessing the white of a picture from its pixels.

use super::Xy;

/// Steps an octave in which brightness is sorted.
const STEPS_LOG2: u32 = 3;
/// Share of the pixels that count as the brightest.
const BRIGHTEST: f64 = 0.01;

/// Sums of XYZ by brightness: one pass over a picture is enough for either guess.
pub struct WhiteEstimate {
    /// Count and sum of XYZ for each step of luminance.
    steps: Vec<(u64, [f64; 3])>,
}

impl Default for WhiteEstimate {
    fn default() -> Self {
        WhiteEstimate { steps: vec![(0, [0.0; 3]); 256 << STEPS_LOG2] }
    }
}

impl WhiteEstimate {
    /// Takes in pixels of XYZ; those without luminance, with a negative component or beyond 1e30 do not count.
    pub fn add(&mut self, pixels: &[f32]) {
        for p in pixels.chunks_exact(3) {
            if p[1] > 0.0 && p.iter().all(|x| (0.0..1e30).contains(x)) {
                let (count, sum) = &mut self.steps[(p[1].to_bits() >> (23 - STEPS_LOG2)) as usize];
                *count += 1;
                sum.iter_mut().zip(p).for_each(|(s, x)| *s += f64::from(*x));
            }
        }
    }

    /// The mean colour of the brightest hundredth of the pixels: a lamp, or what it lights most.
    pub fn brightest(&self) -> Option<Xy> {
        let total: u64 = self.steps.iter().map(|s| s.0).sum();
        let wanted = ((total as f64 * BRIGHTEST).ceil() as u64).max(1);
        let (mut count, mut sum) = (0, [0.0; 3]);
        for (n, xyz) in self.steps.iter().rev().filter(|s| s.0 > 0) {
            // Of the last step only as many as are wanted, each its step's mean.
            let part = (wanted - count).min(*n) as f64 / *n as f64;
            sum.iter_mut().zip(xyz).for_each(|(s, x)| *s += x * part);
            count += n;
            if count >= wanted {
                break;
            }
        }
        Xy::of(sum)
    }

    /// The mean colour of all pixels at equal luminance: the grey-world guess.
    pub fn grey(&self) -> Option<Xy> {
        let mut sum = [0.0; 3];
        for (n, xyz) in self.steps.iter().filter(|s| s.0 > 0 && s.1[1] > 0.0) {
            sum.iter_mut().zip(xyz).for_each(|(s, x)| *s += x / xyz[1] * *n as f64);
        }
        Xy::of(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamp_and_the_mean() {
        let (lamp, wall) = (Xy { x: 0.45, y: 0.41 }.xyz(), Xy { x: 0.3, y: 0.3 }.xyz());
        let mut e = WhiteEstimate::default();
        let pixel = |c: [f64; 3], l: f64| c.map(|x| (x * l) as f32);
        (0..990).for_each(|i| e.add(&pixel(wall, 1.0 + f64::from(i % 7))));
        (0..10).for_each(|_| e.add(&pixel(lamp, 1000.0)));
        e.add(&[f32::NAN, 1.0, 1.0, 1.0, -1.0, 1.0]);
        assert!(e.brightest().unwrap().distance(Xy { x: 0.45, y: 0.41 }) < 1e-6);
        assert!(e.grey().unwrap().distance(Xy { x: 0.3, y: 0.3 }) < 3e-3);
        assert!(WhiteEstimate::default().brightest().is_none());
    }
}
