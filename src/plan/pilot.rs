//! A plan tried on a few pixels: the same paths in full bands beside it, so that their noise cancels and what is left is the plan's own
//! error.

use std::sync::Arc;

use rayon::prelude::*;

use crate::compare::Viewing;
use crate::parallel;
use crate::plan::products::error;
use crate::plan::survey::RANGE_NM;
use crate::render::estimate::{Effort, NEIGHBOURS, Probe, Quantity, What, estimator};
use crate::render::method::Choice;
use crate::render::path;
use crate::scene::Scene;
use crate::spectral::{Rule, Sampling};
use crate::{Result, invalid};

/// Bands of the reference.
const BANDS: usize = 80;
/// Share of pixels under the pilot's worst with 99 % confidence is what 0.01 is the n-th power of.
const CONFIDENCE: f64 = 0.99;

/// What was asked, and found.
#[derive(Clone, Copy, Debug)]
pub struct Pilot {
    /// Pixels, evenly over the picture, that lamps are not seen in.
    pub pixels: usize,
    /// Paths each.
    pub paths: u32,
    /// Largest Delta E 2000.
    pub worst: f64,
    /// Y that counts as white, the 99th percentile, cd/m2.
    pub white_y: f64,
}

impl Pilot {
    /// With 99 % confidence at least this share of pixels is no worse than the worst that was seen.
    ///
    /// ```
    /// # use luxpipe::plan::pilot::Pilot;
    /// let pilot = Pilot { pixels: 4603, paths: 4, worst: 0.1, white_y: 100.0 };
    /// assert!((pilot.share() - 0.999).abs() < 1e-5);
    /// ```
    pub fn share(&self) -> f64 {
        (1.0 - CONFIDENCE).powf(1.0 / self.pixels.max(1) as f64)
    }

    /// Tries a rule on so many pixels of the scene's camera by path tracing. `white` is what the lights are in the mean, of any
    /// luminance; dark pixels are lifted by up to `gain`.
    ///
    /// # Errors
    /// A scene without a camera, or whose pixels see no light.
    pub fn fly(
        scene: &Arc<Scene>,
        rule: &Rule,
        white: [f64; 3],
        gain: f64,
        (pixels, paths): (usize, u32),
    ) -> Result<Pilot> {
        let probes = spread(scene, pixels)?;
        let of = |rule: Option<&Rule>, paths, max_bounces| colours(scene, rule, &probes, paths, max_bounces);
        let (want, got) = (of(None, paths, u32::MAX)?, of(Some(rule), paths, u32::MAX)?);
        let lamps = of(None, 1, 0)?;
        let seen: Vec<usize> = (0..want.len()).filter(|i| lamps[*i][1] == 0.0 && want[*i][1] > 0.0).collect();
        let mut y: Vec<f64> = seen.iter().map(|i| want[*i][1]).collect();
        y.sort_by(f64::total_cmp);
        let Some(white_y) = y.get(y.len() * 99 / 100).copied() else {
            return invalid!("no pixel of the pilot sees light");
        };
        let viewing = Viewing { white: white.map(|w| w / white[1] * white_y), gain, shown: None };
        let worst = seen.iter().map(|i| error(&viewing, got[*i], want[*i])).fold(0.0, f64::max);
        Ok(Pilot { pixels: seen.len(), paths, worst, white_y })
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

/// XYZ of pixels, by so many paths each.
fn colours(
    scene: &Arc<Scene>,
    rule: Option<&Rule>,
    probes: &[Probe],
    paths: u32,
    max_bounces: u32,
) -> Result<Vec<[f64; 3]>> {
    let sampling = match rule {
        Some(rule) => Sampling::points(rule.nodes_nm.clone())?,
        None => Sampling::bins(RANGE_NM.0, RANGE_NM.1, BANDS)?,
    };
    let rule = rule.map(|r| Arc::new(r.clone()));
    let quantity = Quantity { sampling, range_nm: RANGE_NM, what: What::Xyz, seed: 0x9107, rule };
    let max_bounces = max_bounces.min(scene.max_bounces.unwrap_or(u32::MAX));
    let estimate = estimator(scene.clone(), &quantity, &Choice::Path(path::Options { max_bounces, split: 1 }))?;
    parallel::ready();
    let some = |probes: &[Probe]| {
        let mut out = vec![0f32; 3 * probes.len()];
        estimate.measure(probes, Effort::Paths(paths), &mut out);
        out.chunks_exact(3).map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect::<Vec<_>>()
    };
    Ok(probes.par_chunks(NEIGHBOURS).flat_map_iter(some).collect())
}
