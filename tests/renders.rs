//! Furnaces: scenes whose radiance is known in closed form. The Cornell box and the chart are in tests/reference.rs.

mod common;

use common::{job, rendered, scene};
use luxpipe::render::estimate::What;
use luxpipe::spectral::{Observer, Spectrum};
use luxpipe::units::K_M;

const SIZE: usize = 48;
const SEEDS: u32 = 4;

/// Image means of `SEEDS` renders of a scene.
fn means(name: &str, bands: usize, samples: u32, spectrum: bool) -> Vec<Vec<f64>> {
    (0..SEEDS)
        .map(|seed| {
            let mut scene = scene(name);
            scene.camera = scene.camera.map(|c| c.resized(Some(SIZE), None).unwrap());
            let mut job = job(&scene, bands, samples, seed);
            job.quantity.what = if spectrum { What::Spectrum } else { What::Xyz };
            let n = if spectrum { bands } else { 3 };
            let picture = rendered(scene, job);
            let mean = |c: usize| picture.iter().skip(c).step_by(n).map(|x| f64::from(*x)).sum::<f64>();
            (0..n).map(|c| mean(c) / (SIZE * SIZE) as f64).collect()
        })
        .collect()
}

/// Mean over the seeds and its standard error.
fn over_seeds(all: &[Vec<f64>], c: usize) -> (f64, f64) {
    let n = all.len() as f64;
    let mean = all.iter().map(|m| m[c]).sum::<f64>() / n;
    let squares: f64 = all.iter().map(|m| (m[c] - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// A closed room that shines and reflects half: twice its own radiance everywhere, whichever way light is looked for.
#[test]
fn a_grey_furnace_is_twice_its_walls() {
    let observer = Observer::cie1931().unwrap();
    let all = means("furnace.toml", 16, 64, false);
    for c in 0..3 {
        let (mean, se) = over_seeds(&all, c);
        let want = 2.0 * K_M * observer.cmf[c].integral(380.0, 780.0);
        println!("component {c}: off by {:.1e} +- {:.1e}", mean / want - 1.0, se / want);
        assert!((mean - want).abs() < 5e-4 * want, "component {c}: {mean} for {want}");
    }
}

/// The same in colour: 1 / (1 - reflectance) at every wavelength, roulette or not.
#[test]
fn a_coloured_furnace_is_bright_where_it_reflects() {
    let bands = 20;
    let ramp = Spectrum::from_points(vec![(360.0, 0.2), (830.0, 0.8)]).unwrap();
    let all = means("furnace-ramp.toml", bands, 64, true);
    for band in 0..bands {
        let centre = 780.0 - 20.0 * (band as f64 + 0.5);
        let (mean, se) = over_seeds(&all, band);
        let want = 1.0 / (1.0 - ramp.at(centre));
        println!("{centre} nm: off by {:.1e} +- {:.1e}", mean / want - 1.0, se / want);
        assert!((mean - want).abs() < 1e-3 * want, "{centre} nm: {mean} for {want}");
    }
}
