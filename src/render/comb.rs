//! Wavelengths that go their own ways: a path splits into a comb of parts, each with the wavelengths that an eye would not tell
//! from its own.
//!
//! Parts lie evenly over the wavelengths, their place by one number that a pixel's paths share well: together they hit every
//! wavelength as often as any other, and colour has next to no noise of its own.

use crate::material::tint::Window;
use crate::spectral::Sampling;

/// Directions that differ by less than an arc minute are one to a good eye.
pub const SEEN_RAD: f32 = 2.9e-4;
/// Parts at most.
const MOST_PARTS: u32 = 8;

/// The wavelengths of a picture.
pub struct Comb {
    /// From and to, nm, in the order of the lanes: of bins the long end first.
    edges: Vec<(f32, f32)>,
}

/// Parts of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// How many.
    pub count: u32,
    width: f32,
    place: f32,
}

impl Comb {
    /// Of a sampling.
    pub fn new(sampling: &Sampling) -> Comb {
        let edges = |i| {
            let (a, b) = sampling.edges(i);
            (b as f32, a as f32)
        };
        Comb { edges: (0..sampling.count()).map(edges).collect() }
    }

    /// The wavelength of all, where there is one only.
    pub fn single(&self) -> Option<f32> {
        if let [(a, b)] = self.edges[..] { Some(0.5 * (a + b)) } else { None }
    }

    /// Into which parts a path splits whose ends go apart by an angle, rad; `None` where nobody would see it. `lot` in 0..1.
    pub fn parts(&self, spread: f32, lot: f32) -> Option<Parts> {
        let n = self.edges.len() as f32;
        let angles = spread / SEEN_RAD;
        if angles <= 1.0 || self.edges.len() < 2 {
            return None;
        }
        let count = (angles.ceil() as u32).min(MOST_PARTS).min(self.edges.len() as u32);
        // No wider than to the next, and never less than one wavelength.
        let width = (n / angles).clamp(1.0, n / count as f32);
        Some(Parts { count, width, place: lot })
    }

    /// Part number `k`: its wavelengths, and the one that says where it goes, nm.
    pub fn part(&self, parts: &Parts, k: u32) -> (Window, f32) {
        let count = self.edges.len() as f32;
        let each = count / parts.count as f32;
        let middle = ((k as f32 + parts.place) * each).min(count * (1.0 - f32::EPSILON));
        (Window { middle, width: parts.width, each, count }, self.at(middle))
    }

    /// The wavelength at a place 0..count.
    fn at(&self, place: f32) -> f32 {
        let i = (place as usize).min(self.edges.len() - 1);
        let (a, b) = self.edges[i];
        a + (b - a) * (place - i as f32)
    }

    /// The middle of a wavelength by lot, all alike.
    pub fn any(&self, lot: f32) -> f32 {
        let (a, b) = self.edges[((lot * self.edges.len() as f32) as usize).min(self.edges.len() - 1)];
        0.5 * (a + b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the spread, all parts of all lots hold each wavelength once in the mean.
    #[test]
    fn no_wavelength_is_favoured() {
        for n in [2, 7, 80] {
            let comb = Comb::new(&Sampling::bins(380.0, 780.0, n).unwrap());
            for angles in [1.5, 3.0, 7.9, 20.0, 300.0] {
                let mut sums = vec![0.0; n];
                let lots = 4096;
                for i in 0..lots {
                    let lot = (i as f32 + 0.5) / lots as f32;
                    let parts = comb.parts(angles * SEEN_RAD, lot).unwrap();
                    for k in 0..parts.count {
                        let (window, nm) = comb.part(&parts, k);
                        let own = ((780.0 - nm) / 400.0 * n as f32) as usize;
                        assert!(window.share(own.min(n - 1)) > 0.0, "{n} {angles} {nm}");
                        sums.iter_mut().enumerate().for_each(|(i, s)| *s += window.share(i) / lots as f32);
                    }
                }
                assert!(sums.iter().all(|s| (s - 1.0).abs() < 5e-3), "{n} {angles}: {sums:?}");
            }
        }
        assert!(Comb::new(&Sampling::bins(380.0, 780.0, 8).unwrap()).parts(0.9 * SEEN_RAD, 0.5).is_none());
    }
}
