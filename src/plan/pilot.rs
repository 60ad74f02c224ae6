//! A plan tried on a few pixels: the same paths in full beside it, so that their noise cancels and what is left is the plan's own error.

use std::sync::Arc;

use rayon::prelude::*;

use crate::compare::Viewing;
use crate::parallel;
use crate::plan::products::error;
use crate::render::estimate::{Effort, Estimate, NEIGHBOURS, Probe, Quantity, What, estimator};
use crate::render::few::{Few, RANGE_NM};
use crate::render::method::Choice;
use crate::render::path;
use crate::scene::Scene;
use crate::spectral::Sampling;
use crate::{Result, invalid};

/// Bands of the reference, as wide everywhere; from where something fluoresces.
const BAND_NM: f64 = 5.0;
const EXCITING_NM: f64 = 300.0;
/// Share of pixels under the pilot's worst with 99 % confidence is what 0.01 is the n-th power of.
const CONFIDENCE: f64 = 0.99;
/// Of the pilot's worst: other pixels may be worse.
const MARGIN: f64 = 1.25;
const SEED: u32 = 0x9107;

/// Pixels of a scene, seen in full.
pub struct Pilot {
    probes: Vec<Probe>,
    paths: u32,
    max_bounces: u32,
    want: Vec<[f64; 3]>,
    /// Those that lamps are not seen in.
    seen: Vec<usize>,
    viewing: Viewing,
}

/// What a trial found.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Pixels, evenly over the picture, that lamps are not seen in.
    pub pixels: usize,
    /// Paths each.
    pub paths: u32,
    /// Largest Delta E 2000.
    pub worst: f64,
    /// Y that counts as white, the 99th percentile, cd/m2.
    pub white_y: f64,
}

impl Flight {
    /// With 99 % confidence at least this share of pixels is no worse than the worst that was seen.
    ///
    /// ```
    /// # use luxpipe::plan::pilot::Flight;
    /// let flight = Flight { pixels: 4603, paths: 4, worst: 0.1, white_y: 100.0 };
    /// assert!((flight.share() - 0.999).abs() < 1e-5);
    /// ```
    pub fn share(&self) -> f64 {
        (1.0 - CONFIDENCE).powf(1.0 / self.pixels.max(1) as f64)
    }

    /// What the picture is expected to stay below.
    pub fn bound(&self) -> f64 {
        MARGIN * self.worst
    }
}

impl Pilot {
    /// So many pixels of the scene's camera by so many paths each and no more bounces than these. `white` is what the lights are in the
    /// mean, of any luminance; dark pixels are lifted by up to `gain`.
    ///
    /// # Errors
    /// A scene without a camera, or whose pixels see no light.
    pub fn new(
        scene: &Arc<Scene>,
        (white, gain): ([f64; 3], f64),
        (pixels, paths): (usize, u32),
        max_bounces: u32,
    ) -> Result<Pilot> {
        let viewing = Viewing { white, gain, shown: None };
        let probes = spread(scene, pixels)?;
        let mut pilot = Pilot { probes, paths, max_bounces, want: Vec::new(), seen: Vec::new(), viewing };
        pilot.want = pilot.colours(scene, None, paths, max_bounces)?;
        let lamps = pilot.colours(scene, None, 1, 0)?;
        let want = &pilot.want;
        pilot.seen = (0..want.len()).filter(|i| lamps[*i][1] == 0.0 && want[*i][1] > 0.0).collect();
        let mut y: Vec<f64> = pilot.seen.iter().map(|i| want[*i][1]).collect();
        y.sort_by(f64::total_cmp);
        let Some(white_y) = y.get(y.len() * 99 / 100).copied() else {
            return invalid!("no pixel of the pilot sees light");
        };
        pilot.viewing.white = white.map(|w| w / white[1] * white_y);
        Ok(pilot)
    }

    /// Pixels that count.
    pub fn pixels(&self) -> usize {
        self.seen.len()
    }

    /// Tries the scene, or the same without some effects, in full bands or few wavelengths, with fewer bounces or all.
    pub fn fly(&self, scene: &Arc<Scene>, few: Option<&Arc<Few>>, max_bounces: Option<u32>) -> Result<Flight> {
        let got = self.colours(scene, few, self.paths, max_bounces.unwrap_or(self.max_bounces))?;
        let of = |i: &usize| error(&self.viewing, got[*i], self.want[*i]);
        let worst = self.seen.iter().map(of).fold(0.0, f64::max);
        Ok(Flight { pixels: self.seen.len(), paths: self.paths, worst, white_y: self.viewing.white[1] })
    }

    /// XYZ of the pixels, by so many paths each.
    fn colours(
        &self,
        scene: &Arc<Scene>,
        few: Option<&Arc<Few>>,
        paths: u32,
        max_bounces: u32,
    ) -> Result<Vec<[f64; 3]>> {
        let estimate = self.estimate(scene, few, path::Options { max_bounces, split: 1, pool: false })?;
        parallel::ready();
        let some = |probes: &[Probe]| {
            let mut out = vec![0f32; 3 * probes.len()];
            estimate.measure(probes, Effort::Paths(paths), &mut out);
            out.chunks_exact(3).map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect::<Vec<_>>()
        };
        Ok(self.probes.par_chunks(NEIGHBOURS).flat_map_iter(some).collect())
    }

    /// Path tracing as the plan has it so far.
    pub fn estimate(
        &self,
        scene: &Arc<Scene>,
        few: Option<&Arc<Few>>,
        options: path::Options,
    ) -> Result<Arc<dyn Estimate>> {
        let quantity = match few {
            Some(few) => few.clone().quantity(SEED)?,
            None => {
                let from = if scene.fluoresces() { EXCITING_NM } else { RANGE_NM.0 };
                let range_nm = (from, RANGE_NM.1);
                let sampling = Sampling::bins(from, RANGE_NM.1, ((RANGE_NM.1 - from) / BAND_NM).round() as usize)?;
                Quantity { sampling, range_nm, what: What::Xyz, seed: SEED, few: None }
            }
        };
        estimator(scene.clone(), &quantity, &Choice::Path(options))
    }
}

/// Pixels as evenly over the picture as their number allows: the golden ratio's lattice.
fn spread(scene: &Scene, count: usize) -> Result<Vec<Probe>> {
    let Some(camera) = &scene.camera else { return invalid!("the scene has no [camera]") };
    let (width, height) = (camera.width as f64, camera.height as f64);
    let place = |i: usize| {
        let across = (i as f64 * 0.618_033_988_749_894_9).fract();
        let down = (i as f64 + 0.5) / count as f64;
        Probe::Pixel { x: (across * width) as u32, y: (down * height) as u32 }
    };
    Ok((0..count).map(place).collect())
}
