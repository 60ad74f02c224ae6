//! Radiance's RGB as spectra.
//!
//! Three reflectances, one for each of Radiance's default primaries, that sum to 1. Each is flat over three stretches of wavelength with
//! short ramps between, and mixed so that under equal-energy light it has exactly the primary's chromaticity and its share of
//! luminance, 0.265, 0.670 and 0.065. So a surface or a lamp of one bounce has the colour that Radiance gives it. The ramps lie where each
//! reflectance is nearly 0 or 1: the product of two spectra is nearly the spectrum of the product of their RGB, and colours
//! bleed nearly as they do in Radiance: the luminance of light from two coloured surfaces is within 4 % of its.

use crate::color::{Mat3, Primaries};
use crate::spectral::{Observer, Spectrum};
use crate::{Result, invalid};

/// Wavelengths in nm: the ends of the observer's tables, and of the ramps between the three stretches. Among ramps of 10 to 30 nm these
/// are the ones whose mixtures are nearest to the stretches themselves and nowhere negative.
const NODES_NM: [f64; 6] = [360.0, 482.0, 502.0, 581.0, 591.0, 830.0];

/// Radiance's RGB to spectra.
#[derive(Clone, Debug)]
pub struct Colours {
    /// Height of each stretch, long waves first, for each primary.
    heights: [[f64; 3]; 3],
    /// Luminance of each primary.
    luminance: [f64; 3],
}

impl Colours {
    /// From the observer's tables and the primaries.
    pub fn new() -> Result<Colours> {
        let observer = Observer::cie1931()?;
        let stretch = |i: usize| {
            // 0 for the long waves.
            let height = |nm: f64| {
                let at = NODES_NM.iter().position(|n| *n == nm).unwrap_or_default();
                f64::from(at / 2 == 2 - i)
            };
            Spectrum::from_points(NODES_NM.map(|nm| (nm, height(nm))).to_vec())
        };
        let white = observer.integrate(&Spectrum::Constant(1.0));
        let mut columns = [[0.0; 3]; 3];
        for (i, column) in columns.iter_mut().enumerate() {
            let xyz = observer.integrate(&stretch(i)?);
            *column = [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]];
        }
        let stretches = Mat3([0, 1, 2].map(|row| columns.map(|c| c[row])));
        let (Some(primaries), Some(inverse)) = (Primaries::RADIANCE.to_xyz(), stretches.inverse()) else {
            return invalid!("the primaries span no area"); // they do
        };
        let mixed = inverse.times(&primaries).0;
        Ok(Colours { heights: [0, 1, 2].map(|p| [0, 1, 2].map(|s| mixed[s][p].max(0.0))), luminance: primaries.0[1] })
    }

    /// Luminance of RGB where white has 1.
    pub fn luminance(&self, rgb: [f64; 3]) -> f64 {
        rgb.iter().zip(self.luminance).map(|(c, y)| c * y).sum()
    }

    /// A spectrum of these RGB under equal-energy light; constant where they are equal.
    ///
    /// ```
    /// use luxpipe::radiance::colour::Colours;
    /// use luxpipe::spectral::Spectrum;
    /// let colours = Colours::new().unwrap();
    /// assert_eq!(colours.spectrum([0.5; 3]), Spectrum::Constant(0.5));
    /// assert!((colours.luminance([1.0, 0.0, 0.0]) - 0.2651).abs() < 1e-4);
    /// ```
    pub fn spectrum(&self, rgb: [f64; 3]) -> Spectrum {
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Spectrum::Constant(rgb[0]);
        }
        let height = |s: usize| self.heights.iter().zip(rgb).map(|(h, c)| h[s] * c).sum::<f64>();
        let heights = [height(2), height(2), height(1), height(1), height(0), height(0)];
        Spectrum::Table(NODES_NM.into_iter().zip(heights).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xy;

    #[test]
    fn primaries_have_their_colours() {
        let (colours, observer) = (Colours::new().unwrap(), Observer::cie1931().unwrap());
        let want = [(0.64, 0.33), (0.29, 0.60), (0.15, 0.06)];
        for (i, (x, y)) in want.into_iter().enumerate() {
            let mut rgb = [0.0; 3];
            rgb[i] = 1.0;
            let s = colours.spectrum(rgb);
            let (low, high) = s.range();
            assert!(low >= 0.0 && high <= 1.0, "{low} {high}");
            let xyz = observer.integrate(&s);
            let xy = Xy::of(xyz).unwrap();
            // The white of the tables is 1e-4 off 1/3.
            assert!((xy.x - x).abs() < 2e-4 && (xy.y - y).abs() < 2e-4, "{i}: {xy:?}");
            let share = xyz[1] / observer.integrate(&Spectrum::Constant(1.0))[1];
            assert!((share - [0.265, 0.670, 0.065][i]).abs() < 3e-4, "{share}"); // Radiance's color.h
        }
    }

    #[test]
    fn products_are_nearly_products() {
        let (colours, observer) = (Colours::new().unwrap(), Observer::cie1931().unwrap());
        let white = observer.integrate(&Spectrum::Constant(1.0))[1];
        for (a, b) in
            [([0.7, 0.3, 0.2], [0.6, 0.4, 0.3]), ([0.1, 0.5, 0.2], [0.2, 0.6, 0.3]), ([0.2, 0.3, 0.7], [0.3, 0.3, 0.6])]
        {
            let product = colours.spectrum(a).combined(&colours.spectrum(b), |x, y| x * y);
            let got = observer.integrate(&product)[1] / white;
            let want = colours.luminance([0, 1, 2].map(|i| a[i] * b[i]));
            assert!((got / want - 1.0).abs() < 0.04, "{a:?} {b:?}: {got} for {want}");
        }
    }
}
