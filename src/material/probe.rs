//! One material by itself: how much of the light it sends back and lets through, and its scattering function.

use glam::Vec3A;

use crate::material::{Ink, Kernel, Lobe, Lobes, Material, Site};
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
            let side = usize::from(lobe.kernel.transmits());
            if lobe.kernel.at(555.0).is_none() {
                self.add(lobe, lobe.kernel, out, wavelengths_nm, |i, share| totals[i][side] += share);
                continue;
            }
            for (i, nm) in wavelengths_nm.iter().enumerate() {
                let Some(single) = lobe.kernel.at(*nm as f32) else { continue };
                self.add(lobe, &single, out, &[*nm], |_, share| totals[i][side] += share);
            }
        }
        totals
    }

    /// What a lobe passes on of each wavelength, by a kernel that they share.
    fn add(&self, lobe: &Lobe, kernel: &dyn Kernel, out: Vec3A, nm: &[f64], mut add: impl FnMut(usize, f64)) {
        let points = if kernel.is_specular() { 1 } else { POINTS };
        for i in 0..points {
            let u = [(i as f32 + 0.5) / points as f32, (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32];
            let Some(turn) = kernel.sample(out, u) else { continue };
            let weight = f64::from(lobe.factor * turn.weight) / f64::from(points);
            let tint = lobe.tint.turned(out, turn.inc);
            for (i, nm) in nm.iter().enumerate() {
                add(i, weight * f64::from(tint.at(*nm, self.inks, self.srgb)));
            }
        }
    }

    /// Mueller matrices of the single directions that light comes from, back and through, for light that leaves along `out` at one
    /// wavelength; frames have x along out x normal (specular light only: rough lobes are no one direction).
    pub fn mueller(&self, out: Vec3A, nm: f64) -> [[[f64; 4]; 4]; 2] {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let mut sums = [[[0.0; 4]; 4]; 2];
        for lobe in lobes.iter().filter(|l| l.kernel.is_specular()) {
            let Some((_, share)) = self.way(lobe, out, nm) else { continue };
            let matrix = self.matrix(lobe, out.z, nm);
            let sum = &mut sums[usize::from(lobe.kernel.transmits())];
            sum.iter_mut().flatten().zip(matrix.iter().flatten()).for_each(|(s, m)| *s += share * m);
        }
        sums
    }

    /// The single directions that light comes from for light that leaves along `out` at one wavelength, and their shares of its
    /// radiance: mirrors, orders of gratings, straight and bent ways.
    pub fn ways(&self, out: Vec3A, nm: f64) -> Vec<(Vec3A, f64)> {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let single = lobes.iter().filter(|l| l.kernel.is_specular());
        single.filter_map(|lobe| self.way(lobe, out, nm)).collect()
    }

    /// The way of a lobe that has one only, and its share.
    fn way(&self, lobe: &Lobe, out: Vec3A, nm: f64) -> Option<(Vec3A, f64)> {
        let single = lobe.kernel.at(nm as f32);
        let kernel: &dyn Kernel = single.as_ref().map_or(lobe.kernel, |s| s);
        let turn = kernel.sample(out, [0.5; 2])?;
        let tint = lobe.tint.turned(out, turn.inc).at(nm, self.inks, self.srgb);
        Some((turn.inc, f64::from(lobe.factor * turn.weight * tint)))
    }

    /// Mueller matrix of a rough lobe's scattering, in 1/sr, between two directions: x along out x inc, before and after.
    pub fn scattering_mueller(&self, out: Vec3A, inc: Vec3A, nm: f64) -> [[f64; 4]; 4] {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let mut sum = [[0.0; 4]; 4];
        for lobe in lobes.iter() {
            let share = self.value(lobe, out, inc, &[nm])[0];
            let cos = (0.5 * (1.0 + out.dot(inc))).max(0.0).sqrt();
            let matrix = self.matrix(lobe, if inc.z > 0.0 { cos } else { out.z }, nm);
            sum.iter_mut().flatten().zip(matrix.iter().flatten()).for_each(|(s, m)| *s += share * m);
        }
        sum
    }

    /// A lobe's matrix over its first number.
    fn matrix(&self, lobe: &Lobe, cos: f32, nm: f64) -> [[f64; 4]; 4] {
        let mut matrix = [[0.0; 4]; 4];
        matrix[0][0] = 1.0;
        if let Some(polar) = lobe.polar {
            let response = polar.at(nm, cos, self.inks);
            let mean = response.mean();
            if mean > 0.0 {
                matrix = response.scaled(1.0 / mean).mueller();
            }
        }
        matrix
    }

    /// The scattering function f(out, inc) in 1/sr at each wavelength; mirrors and straight ways are not part of it.
    pub fn scattering(&self, out: Vec3A, inc: Vec3A, wavelengths_nm: &[f64]) -> Vec<f64> {
        let mut lobes = Lobes::default();
        self.material.lobes(&self.site, out, &mut lobes);
        let mut values = vec![0.0; wavelengths_nm.len()];
        for lobe in lobes.iter() {
            values.iter_mut().zip(self.value(lobe, out, inc, wavelengths_nm)).for_each(|(v, more)| *v += more);
        }
        values
    }

    /// What a lobe's function is at each wavelength.
    fn value(&self, lobe: &Lobe, out: Vec3A, inc: Vec3A, nm: &[f64]) -> Vec<f64> {
        let tint = lobe.tint.turned(out, inc);
        let one = |nm: &f64| {
            if lobe.kernel.transmits() != (inc.z < 0.0) {
                return 0.0;
            }
            let single = lobe.kernel.at(*nm as f32);
            let kernel: &dyn Kernel = single.as_ref().map_or(lobe.kernel, |s| s);
            let f = f64::from(lobe.factor * kernel.evaluate(out, inc).f_cos) / f64::from(inc.z.abs().max(1e-9));
            f * f64::from(tint.at(*nm, self.inks, self.srgb))
        };
        nm.iter().map(one).collect()
    }
}
