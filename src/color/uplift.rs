//! Spectra for RGB numbers: three reflectances, one for each sRGB (BT.709) primary, mixed as the numbers say [Mallett 2019].
//!
//! The three sum to 1 (to 1e-5) and lie within 0 to 1, so linear RGB within 0 to 1 is a reflectance within 0 to 1 that has
//! that colour under D65: every mixture within 0.1 Delta E 2000, of which most is the tables' 5 nm step. Of the many spectra
//! of a colour it is one; under another light it may look different from the surface that was meant. From 380 to 780 nm;
//! zero outside.

use crate::spectral::{Observer, Spectrum, builtin};
use crate::units::K_M;
use crate::{Result, invalid};

/// The three spectra of the primaries, as reflectances and as lights.
#[derive(Clone, Debug)]
pub struct Uplift {
    basis: [Spectrum; 3],
    lights: [Spectrum; 3],
}

impl Uplift {
    /// From the tables of spectra/.
    pub fn new() -> Result<Uplift> {
        let [red, green, blue] = ["red", "green", "blue"].map(|c| builtin::spectrum(&format!("srgb_basis_{c}")));
        let basis = [red?, green?, blue?];
        let d65 = builtin::spectrum("illuminant_D65")?;
        let observer = Observer::cie1931()?;
        let under_d65 = |s: &Spectrum| {
            Spectrum::from_points((380..=780).map(f64::from).map(|nm| (nm, s.at(nm) * d65.at(nm))).collect())
        };
        let [red, green, blue] = basis.each_ref().map(under_d65);
        let lights = [red?, green?, blue?];
        let white: f64 = lights.iter().map(|s| K_M * observer.integrate(s)[1]).sum();
        let lights = lights.map(|s| s.scaled(1.0 / white));
        Ok(Uplift { basis, lights })
    }

    /// The reflectances of the primaries.
    pub fn basis(&self) -> &[Spectrum; 3] {
        &self.basis
    }

    /// The same under D65, W/sr/m2/nm: RGB times them is light of that chromaticity, and of the luminance in cd/m2 that RGB
    /// has where white (1, 1, 1) is 1 cd/m2.
    pub fn lights(&self) -> &[Spectrum; 3] {
        &self.lights
    }

    /// The reflectance of linear RGB within 0 to 1.
    ///
    /// ```
    /// let grey = luxpipe::color::Uplift::new().unwrap().reflectance([0.5; 3]).unwrap();
    /// assert!((grey.at(555.0) - 0.5).abs() < 1e-5 && grey.at(800.0) == 0.0);
    /// ```
    pub fn reflectance(&self, rgb: [f64; 3]) -> Result<Spectrum> {
        if !rgb.iter().all(|c| (0.0..=1.0).contains(c)) {
            return invalid!("the RGB of a surface must be 0 to 1, got {rgb:?}");
        }
        let at = |nm: f64| self.basis.iter().zip(rgb).map(|(s, c)| c * s.at(nm)).sum::<f64>().min(1.0);
        Spectrum::from_points((0..=80).map(|i| f64::from(380 + 5 * i)).map(|nm| (nm, at(nm))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::difference::delta_e_2000;
    use crate::color::{Primaries, Xy};

    fn colours() -> impl Iterator<Item = [f64; 3]> {
        (0..125).map(|i| [i % 5, i / 5 % 5, i / 25].map(|c| f64::from(c) / 4.0))
    }

    #[test]
    fn the_basis_is_one_of_reflectances() {
        let uplift = Uplift::new().unwrap();
        for nm in (380..=780).map(f64::from) {
            let values = uplift.basis().each_ref().map(|s| s.at(nm));
            assert!(values.iter().all(|v| *v > 0.0 && *v < 1.0));
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1.1e-5, "{nm}: {values:?}");
        }
    }

    /// Surfaces under D65 and lights by themselves have the colour that BT.709's matrix says, under its white.
    #[test]
    fn colours_come_back() {
        let uplift = Uplift::new().unwrap();
        let observer = Observer::cie1931().unwrap();
        let d65 = builtin::spectrum("D65").unwrap();
        let white_y = observer.integrate(&d65)[1];
        let matrix = Primaries::BT709.to_xyz().unwrap();
        let lights = uplift.lights().each_ref().map(|s| observer.integrate(s).map(|v| K_M * v));
        for rgb in colours() {
            let want = matrix.apply(rgb);
            let s = uplift.reflectance(rgb).unwrap();
            let lit = (380..=780).map(f64::from).map(|nm| (nm, s.at(nm) * d65.at(nm))).collect();
            let surface = observer.integrate(&Spectrum::from_points(lit).unwrap()).map(|v| v / white_y);
            let light: [f64; 3] = std::array::from_fn(|k| (0..3).map(|i| rgb[i] * lights[i][k]).sum());
            for got in [surface, light] {
                let off = delta_e_2000(got, want, Xy::D65.xyz());
                assert!(off < 0.1, "{rgb:?}: {off}");
            }
            assert!(s.range().0 >= 0.0 && s.range().1 <= 1.0);
        }
    }

    #[test]
    fn other_numbers_are_refused() {
        let uplift = Uplift::new().unwrap();
        for rgb in [[-0.1, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, f64::NAN]] {
            assert!(uplift.reflectance(rgb).is_err());
        }
    }
}
