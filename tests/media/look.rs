//! Rays and points of scenes given as text.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3A};
use luxpipe::notes::Notes;
use luxpipe::render::estimate::{Effort, Estimate, Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;
use rayon::prelude::*;

pub const PATH: Choice = Choice::Path(path::Options { max_bounces: u32::MAX, split: 1, pool: false });

/// A scene with a method.
pub struct Look {
    pub scene: Arc<Scene>,
    pub estimate: Arc<dyn Estimate>,
}

/// Where and how.
#[derive(Clone, Copy)]
pub enum At {
    Ray(DVec3, DVec3),
    Point(DVec3, DVec3),
}

impl Look {
    /// Spectral radiance (or Stokes vectors) at these wavelengths.
    pub fn new(text: &str, method: &Choice, nm: &[f64], what: What) -> Look {
        luxpipe::parallel::set_threads(0);
        let scene =
            load::parse(text, Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_or_else(|e| panic!("{e} in\n{text}"));
        let scene = Arc::new(scene);
        let sampling = Sampling::points(nm.to_vec()).unwrap();
        let quantity = Quantity { sampling, range_nm: (380.0, 780.0), what, seed: 1, few: None };
        let estimate = estimator(scene.clone(), &quantity, method).unwrap();
        Look { scene, estimate }
    }

    /// One estimate from so many paths.
    pub fn once(&self, at: At, paths: u32, number: u64) -> Vec<f64> {
        let place = |p: DVec3| self.scene.frame.place(p).as_vec3a();
        let unit = |d: DVec3| -> Vec3A { d.normalize().as_vec3a() };
        let probe = match at {
            At::Ray(o, d) => Probe::Ray { origin: place(o), direction: unit(d), number },
            At::Point(p, n) => Probe::Irradiance { point: place(p), normal: unit(n), number },
        };
        let mut out = vec![0.0; self.estimate.components()];
        self.estimate.measure(&[probe], Effort::Paths(paths), &mut out);
        out.into_iter().map(f64::from).collect()
    }

    /// Mean of sixteen estimates of so many paths each, and its standard error.
    pub fn mean(&self, at: At, paths: u32) -> Vec<(f64, f64)> {
        const R: u64 = 16;
        let all: Vec<Vec<f64>> = (0..R).into_par_iter().map(|r| self.once(at, paths, r * 7919 + 1)).collect();
        (0..all[0].len())
            .map(|i| {
                let mean = all.iter().map(|a| a[i]).sum::<f64>() / R as f64;
                let squares = all.iter().map(|a| (a[i] - mean).powi(2)).sum::<f64>();
                (mean, (squares / (R - 1) as f64 / R as f64).sqrt())
            })
            .collect()
    }

    /// What it says at the end.
    pub fn said(&self) -> String {
        let notes = Notes::default();
        self.estimate.report(&notes);
        notes.take().join("\n")
    }
}

/// A value lies within 4.5 standard errors and a share of what is expected, and the error is small enough to tell.
#[track_caller]
pub fn close((value, error): (f64, f64), want: f64, share: f64, what: &str) {
    assert!(error <= 0.02 * want.abs() + 1e-12, "{what}: {value} +- {error} says nothing of {want}");
    assert!((value - want).abs() <= 4.5 * error + share * want.abs(), "{what}: {value} +- {error} for {want}");
}

/// A slab of 1 m below z = 0 with a medium of these keys.
pub fn slab(medium: &str) -> String {
    format!(
        "[media.m]\n{medium}\n[materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"box\"\nmin = [-50, -50, -1]\nmax = [50, 50, 0]\nmaterial = \"b\"\n"
    )
}

/// Light of 1 from everywhere, or from above.
pub fn sky(upper_half: bool) -> String {
    format!("[environment]\ntype = \"uniform\"\nspectrum = 1\nradiance = 1\nupper_half = {upper_half}\n")
}
