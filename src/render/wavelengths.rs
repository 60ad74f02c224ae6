//! The wavelengths of an estimate, whatever their number, for methods that work light out before the eye looks.

use crate::Result;
use crate::render::film::light_weights;
use crate::render::inks::Inks;
use crate::render::lanes::{GROUP, Lanes};
use crate::render::stored::Stored;
use crate::render::trail::{Arrived, Trail};
use crate::scene::Scene;
use crate::simd;
use crate::spectral::{Observer, Sampling};
use crate::units::K_M;

/// Turns trails into numbers.
pub trait Wavelengths: Sync {
    /// Numbers a row: wavelengths, made up to a multiple of 8.
    fn lanes(&self) -> usize;

    /// Adds `k` times what a trail brings of light `i` to row `i` of `sums`.
    fn gather(&self, trail: &Trail, stored: &Stored, k: f32, sums: &mut [f32]);

    /// What the lanes of a light's factors weigh in luminance, cd/m2; in radiance where no light of the scene can be seen.
    fn brightness(&self, light: usize) -> &[f32];
}

/// Those that an estimate carries in 8 G lanes.
pub struct Carried<const G: usize> {
    inks: Inks<G>,
    brightness: Vec<Lanes<G>>,
}

impl<const G: usize> Carried<G> {
    /// Of a scene, of which wavelengths in `range_nm` count.
    pub fn new(scene: &Scene, sampling: &Sampling, range_nm: (f64, f64)) -> Result<Carried<G>> {
        let y = Observer::cie1931()?.cmf[1].scaled(K_M);
        let visible = |l: &crate::scene::Light| light_weights(&l.radiance, sampling, range_nm, &y);
        let mut brightness: Vec<Vec<f64>> = scene.lights.iter().map(visible).collect();
        if brightness.iter().flatten().sum::<f64>() <= 0.0 {
            brightness = scene.lights.iter().map(|l| sampling.sample(&l.radiance)).collect();
        }
        let inks = Inks::new(&scene.inks, &scene.srgb, sampling);
        Ok(Carried { inks, brightness: brightness.iter().map(|b| Lanes::from_values(b)).collect() })
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
}
