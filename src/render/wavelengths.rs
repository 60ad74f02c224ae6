//! The wavelengths of an estimate, whatever their number, for methods that work light out before the eye looks.

use crate::Result;
use crate::material::Ink;
use crate::render::film::light_weights;
use crate::render::inks::Inks;
use crate::render::lanes::{GROUP, Lanes};
use crate::render::stored::Stored;
use crate::render::trail::{Arrived, Trail};
use crate::scene::Scene;
use crate::simd;
use crate::spectral::{Observer, Sampling, Spectrum};
use crate::units::K_M;

/// Turns trails into numbers.
pub trait Wavelengths: Sync {
    /// Numbers a row: wavelengths, made up to a multiple of 8.
    fn lanes(&self) -> usize;

    /// Adds `k` times what a trail brings of light `i` to row `i` of `sums`.
    fn gather(&self, trail: &Trail, stored: &Stored, k: f32, sums: &mut [f32]);

    /// What the lanes of a light's factors weigh in luminance, cd/m2; in radiance where no light of the scene can be seen. After the
    /// scene's own lights comes that of fluorescent surfaces, whose factors are its radiance.
    fn brightness(&self, light: usize) -> &[f32];

    /// A scene's ink of one spectrum: a reflectance or a coefficient.
    fn ink(&self, number: u32) -> &[f32];

    /// What a fluorescent surface, by the number of its ink, gives off where these rows of lights fall on it.
    fn reradiated(&self, ink: u32, lights: &[u32], rows: &[f32], out: &mut [f32]);
}

/// Those that an estimate carries in 8 G lanes.
pub struct Carried<const G: usize> {
    inks: Inks<G>,
    brightness: Vec<Lanes<G>>,
    /// Radiance of each light.
    lights: Vec<Lanes<G>>,
}

impl<const G: usize> Carried<G> {
    /// Of a scene, its own spectra or others in their place, of which wavelengths in `range_nm` count.
    pub fn new(
        scene: &Scene,
        (inks, srgb): (&[Ink], &[Spectrum; 3]),
        sampling: &Sampling,
        range_nm: (f64, f64),
    ) -> Result<Carried<G>> {
        let y = Observer::cie1931()?.cmf[1].scaled(K_M);
        let own = Spectrum::Constant(1.0);
        let lights: Vec<&Spectrum> = scene.lights.iter().map(|l| &l.radiance).chain([&own]).collect();
        let mut brightness: Vec<Vec<f64>> = lights.iter().map(|l| light_weights(l, sampling, range_nm, &y)).collect();
        if brightness[..scene.lights.len()].iter().flatten().sum::<f64>() <= 0.0 {
            brightness = lights.iter().map(|l| sampling.sample(l)).collect();
        }
        let inks = Inks::new(inks, srgb, sampling);
        Ok(Carried {
            inks,
            brightness: brightness.iter().map(|b| Lanes::from_values(b)).collect(),
            lights: lights.iter().map(|l| Lanes::from_values(&sampling.sample(l))).collect(),
        })
    }
}

impl<const G: usize> Wavelengths for Carried<G> {
    fn lanes(&self) -> usize {
        GROUP * G
    }

    fn gather(&self, trail: &Trail, stored: &Stored, k: f32, sums: &mut [f32]) {
        let mut arrived = Arrived::<G>::default();
        simd::wide(
            #[inline(always)]
            || {
                for (light, lanes) in arrived.follow(trail, &self.inks, stored) {
                    let row = &mut sums[*light as usize * GROUP * G..][..GROUP * G];
                    for (sums, more) in row.chunks_exact_mut(GROUP).zip(&lanes.0) {
                        for i in 0..GROUP {
                            sums[i] += k * more[i];
                        }
                    }
                }
            },
        );
    }

    fn brightness(&self, light: usize) -> &[f32] {
        self.brightness[light].0.as_flattened()
    }

    fn ink(&self, number: u32) -> &[f32] {
        self.inks.one(number).0.as_flattened()
    }

    fn reradiated(&self, ink: u32, lights: &[u32], rows: &[f32], out: &mut [f32]) {
        let Some(dye) = self.inks.dye(ink) else { return };
        let mut sum = Lanes::<G>::splat(0.0);
        for (light, row) in lights.iter().zip(rows.chunks_exact(GROUP * G)) {
            let radiance = self.lights[*light as usize].0.as_flattened();
            let sums = sum.0.as_flattened_mut().iter_mut();
            sums.zip(row).zip(radiance).for_each(|((sum, x), l)| *sum += x * l);
        }
        out.copy_from_slice(dye.reradiated(&sum).0.as_flattened());
    }
}
