//! Scenes of a few lines, and what is measured in them.

use std::sync::Arc;

use glam::DVec3;
use luxpipe::render::estimate::{Effort, Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;

/// Path tracing to the end.
pub const PATH: Choice = Choice::Path(path::Options { max_bounces: u32::MAX, split: 4, pool: false });

/// A scene from its text.
pub fn scene(text: &str) -> Arc<Scene> {
    Arc::new(load::parse(text, std::path::Path::new(".")).unwrap_or_else(|e| panic!("{e}\n{text}")))
}

/// Probes' numbers by so many paths.
pub fn all_measured(
    scene: &Arc<Scene>,
    sampling: &Sampling,
    what: What,
    choice: &Choice,
    probes: &[Probe],
    paths: u32,
) -> Vec<Vec<f64>> {
    let quantity = Quantity { sampling: sampling.clone(), range_nm: (300.0, 780.0), what, seed: 1, few: None };
    let estimate = estimator(scene.clone(), &quantity, choice).unwrap_or_else(|e| panic!("{e}"));
    let one = |probe: &Probe| {
        let mut out = vec![0f32; estimate.components()];
        estimate.measure(std::slice::from_ref(probe), Effort::Paths(paths), &mut out);
        out.into_iter().map(f64::from).collect()
    };
    probes.iter().map(one).collect()
}

/// One probe's.
pub fn measured(
    scene: &Arc<Scene>,
    sampling: &Sampling,
    what: What,
    choice: &Choice,
    probe: &Probe,
    paths: u32,
) -> Vec<f64> {
    all_measured(scene, sampling, what, choice, std::slice::from_ref(probe), paths).remove(0)
}

/// A ray from a place in metres.
pub fn ray(scene: &Scene, from: DVec3, to: DVec3) -> Probe {
    Probe::Ray { origin: scene.frame.place(from).as_vec3a(), direction: to.normalize().as_vec3a(), number: 0 }
}

/// Radiance along a ray, a number a wavelength.
pub fn spectrum(text: &str, sampling: &Sampling, from: DVec3, to: DVec3, paths: u32) -> Vec<f64> {
    let scene = scene(text);
    measured(&scene, sampling, What::Spectrum, &PATH, &ray(&scene, from, to), paths)
}

/// Equal bins of the visible.
pub fn bins(n: usize) -> Sampling {
    Sampling::bins(380.0, 780.0, n).unwrap()
}

/// Radiance 1 from everywhere.
pub const AROUND: &str = "[environment]\nspectrum = 1\nradiance = 1\n";

/// A material that sends nothing back.
pub const BLACK: &str = "[materials.black]\nreflectance = 0\n";

/// A quadrangle.
pub fn quad(p: [[f64; 3]; 4], material: &str, rest: &str) -> String {
    format!("[[shape]]\ntype = \"quad\"\npoints = {p:?}\nmaterial = \"{material}\"\n{rest}\n")
}

/// A level square that faces up.
pub fn level(z: f64, material: &str) -> String {
    quad([[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]], material, "")
}

/// A square across a direction.
pub fn quad_across(at: DVec3, to: DVec3, half: f64, material: &str, rest: &str) -> String {
    let x = DVec3::Y * half;
    let y = to.cross(DVec3::Y).normalize() * half;
    let p = [at - x - y, at + x - y, at + x + y, at - x + y].map(|p| p.to_array());
    // Its front looks against the direction.
    let (a, b, c) = (DVec3::from(p[0]), DVec3::from(p[1]), DVec3::from(p[2]));
    let front = (b - a).cross(c - a).dot(to) < 0.0;
    quad(if front { p } else { [p[3], p[2], p[1], p[0]] }, material, rest)
}
