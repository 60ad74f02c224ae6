//! The colours of a picture by luminance: a few of each, for rules that must know what the medium's primaries can make of them.

use crate::color::Mat3;
use crate::statistics::scrambled;

/// Colours kept of each step.
const KEPT: usize = 32;
/// Steps an octave, by the float's leading bits.
const STEPS_LOG2: u32 = 3;
const MANTISSA: u32 = 23;

/// Colours of one step of luminance.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Pixels in all.
    pub count: u64,
    /// Some of them, each as likely to be here as any other: world luminance in cd/m2, XYZ of unit luminance.
    pub colours: Vec<(f32, [f32; 3])>,
}

/// Colours of all steps of luminance, darkest first.
#[derive(Clone, Debug)]
pub struct Palette {
    steps: Vec<Step>,
}

impl Default for Palette {
    fn default() -> Palette {
        Palette { steps: vec![Step::default(); 256 << STEPS_LOG2] }
    }
}

impl Palette {
    /// Counts a pixel: world luminance in cd/m2, and XYZ as it will be shown.
    pub fn add(&mut self, luminance_cd_m2: f32, xyz: [f32; 3]) {
        if !(luminance_cd_m2 > f32::MIN_POSITIVE && luminance_cd_m2.is_finite() && xyz[1] > 0.0) {
            return;
        }
        let step = &mut self.steps[(luminance_cd_m2.to_bits() >> (MANTISSA - STEPS_LOG2)) as usize];
        let n = step.count;
        step.count += 1;
        // The n-th takes the place of one of those kept with probability KEPT / n [Vitter 1985], drawn from n itself.
        let place = if (n as usize) < KEPT { n } else { scrambled(n) % (n + 1) };
        if (place as usize) < KEPT {
            let colour = (luminance_cd_m2, xyz.map(|x| x / xyz[1]));
            if colour.1.iter().all(|x| x.is_finite()) {
                match step.colours.get_mut(place as usize) {
                    Some(old) => *old = colour,
                    None => step.colours.push(colour),
                }
            }
        }
    }

    /// Steps in which there are pixels, darkest first.
    pub fn steps(&self) -> impl DoubleEndedIterator<Item = &Step> {
        self.steps.iter().filter(|s| !s.colours.is_empty())
    }

    /// The luminance under which a share of the pixels lies, cd/m2; of the picture's colours the nearest.
    pub fn quantile_cd_m2(&self, share: f64) -> Option<f64> {
        let total: u64 = self.steps().map(|s| s.count).sum();
        let mut below = 0;
        for step in self.steps() {
            below += step.count;
            if below as f64 >= share * total as f64 {
                return step.colours.iter().map(|c| f64::from(c.0)).reduce(f64::max);
            }
        }
        None
    }
}

/// Largest share of white's luminance at which primaries make a colour, given as XYZ of unit luminance: 1 for white. What they
/// can make at no luminance counts by its largest component.
pub fn brightest_share(from_xyz: &Mat3, colour: [f32; 3]) -> f64 {
    let rgb = from_xyz.apply(colour.map(f64::from));
    1.0 / rgb.iter().fold(1.0, |m: f64, x| m.max(*x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Primaries;

    #[test]
    fn every_pixel_is_as_likely_kept() {
        let mut palette = Palette::default();
        (0..100_000).for_each(|i| palette.add(1.0, [0.0, 1.0, i as f32]));
        let step = palette.steps().next().unwrap();
        assert_eq!((step.count, step.colours.len()), (100_000, KEPT));
        let mean = step.colours.iter().map(|c| f64::from(c.1[2])).sum::<f64>() / KEPT as f64;
        assert!((mean / 50_000.0 - 1.0).abs() < 0.4, "{mean}"); // 4 standard errors of 32 draws
    }

    #[test]
    fn white_goes_to_the_top_and_blue_does_not() {
        let m = Primaries::BT709.from_xyz().unwrap();
        let blue = [0.1805f32, 0.0722, 0.9505].map(|x| x / 0.0722);
        assert!((brightest_share(&m, [0.9505, 1.0, 1.089]) - 1.0).abs() < 1e-3);
        assert!((brightest_share(&m, blue) - 0.0722).abs() < 1e-3);
    }
}
