//! What arrives of each light by wavelength, whatever the light is: layers that can be summed under other lamps.
//!
//! A component is the share of a light's radiance that a pixel gets of it (of a lamp seen directly 1), mean over its bin or at its
//! wavelength; the light's components stand together, lights in the scene's order.

use crate::render::beam::Beam;
use crate::render::film::Film;
use crate::render::lanes::GROUP;

/// A film of layers.
pub struct Layers<const G: usize> {
    /// [light][wavelength]: what they weigh in luminance.
    luminance: Vec<Vec<f64>>,
    count: usize,
}

impl<const G: usize> Layers<G> {
    /// For lights whose wavelengths weigh so much in luminance, cd/m2.
    pub fn new(luminance: Vec<Vec<f64>>, count: usize) -> Self {
        Layers { luminance, count }
    }
}

impl<const G: usize> Film<G> for Layers<G> {
    type Pixel = Vec<[[f64; GROUP]; G]>;

    fn components(&self) -> usize {
        self.luminance.len() * self.count
    }

    fn black(&self) -> Self::Pixel {
        vec![[[0.0; GROUP]; G]; self.luminance.len()]
    }

    #[inline(always)]
    fn expose<B: Beam<G>>(&self, pixel: &mut Self::Pixel, light: u32, beam: &B) {
        for (sums, factors) in pixel[light as usize].iter_mut().zip(&beam.intensity().0) {
            for i in 0..GROUP {
                sums[i] += f64::from(factors[i]);
            }
        }
    }

    fn luminance(&self, pixel: &Self::Pixel) -> f64 {
        let of =
            |(p, w): (&[[f64; GROUP]; G], &Vec<f64>)| p.as_flattened().iter().zip(w).map(|(p, w)| p * w).sum::<f64>();
        pixel.iter().zip(&self.luminance).map(of).sum()
    }

    fn add(&self, pixel: &mut Self::Pixel, other: &Self::Pixel) {
        let both = pixel.iter_mut().zip(other);
        both.for_each(|(a, b)| a.as_flattened_mut().iter_mut().zip(b.as_flattened()).for_each(|(a, b)| *a += b));
    }

    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]) {
        for (out, sums) in out.chunks_exact_mut(self.count).zip(pixel) {
            out.iter_mut().zip(sums.as_flattened()).for_each(|(o, s)| *o = (s * factor) as f32);
        }
    }
}
