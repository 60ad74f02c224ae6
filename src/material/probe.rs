//! One material by itself: how much of the light it sends back and lets through, and its scattering function.

use glam::Vec3A;

use crate::material::{Ink, Lobes, Material, Site};
use crate::spectral::Spectrum;

/// Directions that a rough lobe is averaged over, a Hammersley set.
const POINTS: u32 = 16384;

/// A material with the spectra that it refers to.
#[derive(Clone, Copy)]
pub struct Sample<'a> {
    /// The material.
    pub material: &'a dyn Material,
    /// The scene's spectra.
    pub inks: &'a [Ink],
    /// Basis of RGB colours.
    pub srgb: &'a [Spectrum; 3],
    /// Where it is asked.
    pub site: Site,
}

/// A direction at an angle with the normal, in the plane of x and z.
pub fn at_angle(degrees: f64) -> Vec3A {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3A::new(sin as f32, 0.0, (cos as f32).max(1e-6))
}

impl Sample<'_> {
    /// Directional-hemispherical reflectance and transmittance at each wavelength (nm) for light that leaves along `out`; by
    /// reciprocity those of light that comes from there, save for radiance beyond a boundary (factor n^2).
    pub fn totals(&self, out: Vec3A, wavelengths_nm: &[f64]) -> Vec<[f64; 2]> {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let mut totals = vec![[0.0; 2]; wavelengths_nm.len()];
        for lobe in lobes.iter() {
            let points = if lobe.kernel.is_specular() { 1 } else { POINTS };
            let side = usize::from(lobe.kernel.transmits());
            for i in 0..points {
                let u = [(i as f32 + 0.5) / points as f32, (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32];
                let Some(turn) = lobe.kernel.sample(out, u) else { continue };
                let weight = f64::from(lobe.factor * turn.weight) / f64::from(points);
                let tint = lobe.tint.turned(out, turn.inc);
                for (nm, total) in wavelengths_nm.iter().zip(&mut totals) {
                    total[side] += weight * f64::from(tint.at(*nm, self.inks, self.srgb));
                }
            }
        }
        totals
    }

    /// The scattering function f(out, inc) in 1/sr at each wavelength; mirrors and straight ways are not part of it.
    pub fn scattering(&self, out: Vec3A, inc: Vec3A, wavelengths_nm: &[f64]) -> Vec<f64> {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let mut values = vec![0.0; wavelengths_nm.len()];
        for lobe in lobes.iter().filter(|l| l.kernel.transmits() == (inc.z < 0.0)) {
            let f = f64::from(lobe.factor * lobe.kernel.evaluate(out, inc).f_cos) / f64::from(inc.z.abs().max(1e-9));
            let tint = lobe.tint.turned(out, inc);
            for (nm, value) in wavelengths_nm.iter().zip(&mut values) {
                *value += f * f64::from(tint.at(*nm, self.inks, self.srgb));
            }
        }
        values
    }
}
