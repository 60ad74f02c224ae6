//! The cases of tests/ref/validation.toml as scenes: what to measure, what must come out, how closely. Shared by the test,
//! which takes a second or two a case, and by `make accuracy`, which takes each to its tolerance.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3A};
use luxpipe::parallel;
use luxpipe::render::estimate::{Effort, Estimate, Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::sampler::Sampler;
use luxpipe::render::{local, path, photon, radiosity};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;
use rayon::prelude::*;

/// Where light is measured.
pub enum Place {
    /// Luminance along a ray.
    Ray(DVec3, DVec3),
    /// Illuminance of a point with a normal.
    Point(DVec3, DVec3),
    /// Mean illuminance of a parallelogram (corner, two sides); its front is that of their cross product.
    Area(DVec3, DVec3, DVec3),
    /// Mean illuminance of a disk (centre, normal, radius).
    Disk(DVec3, DVec3, f64),
}

/// One number of a case.
pub struct Value {
    /// What it is.
    pub label: String,
    /// Index of the scene.
    pub scene: usize,
    /// Where it is measured.
    pub place: Place,
    /// Measured x factor + offset is compared.
    pub factor: f64,
    /// See `factor`.
    pub offset: f64,
    /// Expected.
    pub want: f64,
    /// Tolerance.
    pub tolerance: f64,
}

/// A case.
pub struct Case {
    /// Its name in the table.
    pub id: String,
    /// Scene files and most bounces.
    pub scenes: Vec<(String, u32)>,
    /// What is measured.
    pub values: Vec<Value>,
}

/// What came out.
pub struct Got {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The table of expected values.
pub fn table() -> toml::Table {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ref/validation.toml");
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

/// A list of numbers of a case.
pub fn list(table: &toml::Table, id: &str, key: &str) -> Vec<f64> {
    let value = &table[id][key];
    match value.as_array() {
        Some(items) => items.iter().map(number).collect(),
        None => vec![number(value)],
    }
}

/// Rows of numbers of a case.
pub fn rows(table: &toml::Table, id: &str, key: &str) -> Vec<Vec<f64>> {
    let rows = table[id][key].as_array().unwrap();
    rows.iter().map(|r| r.as_array().unwrap().iter().map(number).collect()).collect()
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64)
}

const R: u32 = 16;
/// Solutions that tell a solver's error.
const SOLUTIONS: u32 = 8;

/// How Eq. (1) is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// Path tracing, which claims every case.
    Path,
    /// Local illumination.
    Local,
    /// Radiosity.
    Radiosity,
    /// Photon map.
    Photon,
}

impl How {
    /// All of them.
    const ALL: [How; 4] = [How::Path, How::Local, How::Radiosity, How::Photon];

    /// The method says that it solves a case.
    fn claims(self, id: &str) -> bool {
        let direct = id.starts_with("cie5.2") || id.starts_with("cie5.3") || id.starts_with("direct-");
        let direct = direct || id.starts_with("ff-") || id == "close-light-4x4" || id == "grey-furnace-convex";
        // One constant is right in a closed sphere, and there only.
        let sphere = id == "cie5.8-sphere-indirect";
        let room = id == "radiosity-cube-A" || id == "radiosity-room-C";
        match self {
            How::Path => true,
            How::Local => direct || sphere,
            // Not where one surface cuts through another, as a port through its sphere: elements there see both sides.
            How::Radiosity => direct || sphere || room,
            How::Photon => direct || sphere || room || id == "sphere-port-spot" || id == "parallel-plates-infinite",
        }
    }

    /// With more or less work: `effort` is 32 and more.
    fn choice(self, max_bounces: u32, effort: u32, seed: u32) -> Choice {
        match self {
            How::Path => Choice::Path(path::Options { max_bounces, split: 1, pool: false }),
            How::Local => {
                Choice::Local(local::Options { ambient: local::Term::Balance, shadows: true, reflections: true })
            }
            How::Radiosity => Choice::Radiosity(radiosity::Options {
                divide: None,
                tolerance: 0.01 * (32.0 / f64::from(effort)).sqrt(),
                rays: (8 * effort).min(radiosity::MOST_RAYS),
                show: radiosity::Show::Direct,
                memory: 1 << 30,
                solution: None,
                seed,
            }),
            How::Photon => Choice::Photon(photon::Options {
                photons: 500 * effort,
                passes: 8,
                // Disks that shrink while they hold more: both errors fall.
                count: (100.0 * (f64::from(effort) / 32.0).powf(2.0 / 3.0)) as u32,
                gather_once: false,
                step: 0.1,
                seed,
                memory: 1 << 30,
                solution: None,
            }),
        }
    }
}

impl Case {
    /// Measures all values by a method, until their standard errors are `share` of the tolerances or the time is up.
    pub fn by(&self, how: How, share: f64, time: Duration) -> Vec<Got> {
        if how == How::Path { self.measure(share, time) } else { self.solve(how, share, time) }
    }

    /// The methods that claim it.
    pub fn methods(&self) -> impl Iterator<Item = How> {
        How::ALL.into_iter().filter(|how| how.claims(&self.id))
    }

    /// Measures all values by a method that solves the scene before it looks: eight times anew, with more and more work
    /// until the standard errors are `share` of the tolerances, or the next round would not end in time.
    fn solve(&self, how: How, share: f64, time: Duration) -> Vec<Got> {
        parallel::set_threads(0);
        let start = Instant::now();
        let mut effort = 32;
        loop {
            let begun = start.elapsed();
            let runs: Vec<Vec<f64>> = (0..SOLUTIONS).map(|seed| self.solved(how, effort, seed)).collect();
            let n = f64::from(SOLUTIONS);
            let got: Vec<Got> = (0..self.values.len())
                .map(|i| {
                    let mean = runs.iter().map(|r| r[i]).sum::<f64>() / n;
                    let squares = runs.iter().map(|r| (r[i] - mean).powi(2)).sum::<f64>();
                    Got { value: mean, standard_error: (squares / (n - 1.0) / n).sqrt() }
                })
                .collect();
            let known = got.iter().zip(&self.values).all(|(g, v)| g.standard_error <= share * v.tolerance);
            let took = start.elapsed() - begun;
            if known || start.elapsed() + 4 * took > time {
                return got;
            }
            effort *= 4;
        }
    }

    /// All values by one solution of each scene.
    fn solved(&self, how: How, effort: u32, seed: u32) -> Vec<f64> {
        let scenes: Vec<_> = (self.scenes.iter())
            .map(|(text, bounces)| estimator_of(text, &how.choice(*bounces, effort, seed + 1)))
            .collect();
        // Where nothing but looks at lamps differs they are cheap.
        let paths = effort * if self.id.starts_with("ff-") { 128 } else { 8 };
        let one = |(i, v): (usize, &Value)| {
            let (scene, estimate) = &scenes[v.scene];
            v.place.mean(&**estimate, scene, seed * 7919 + i as u32, paths) * v.factor + v.offset
        };
        self.values.par_iter().enumerate().map(|(i, v)| one((i, v))).collect()
    }

    /// Measures all values: each until its standard error is `share` of its tolerance, or the time is up.
    fn measure(&self, share: f64, time: Duration) -> Vec<Got> {
        parallel::set_threads(0);
        let start = Instant::now();
        let scenes: Vec<(Arc<Scene>, Arc<dyn Estimate>)> = (self.scenes.par_iter())
            .map(|(text, bounces)| estimator_of(text, &How::Path.choice(*bounces, 32, 1)))
            .collect();
        let mut got = Vec::new();
        for (i, v) in self.values.iter().enumerate() {
            // Scenes take their time too, and what one value leaves goes to the next.
            let left = (start + time).saturating_duration_since(Instant::now());
            let until = Instant::now() + left / (self.values.len() - i) as u32;
            let wanted = share * v.tolerance / v.factor;
            let (scene, estimate) = &scenes[v.scene];
            let (mean, error) = replicates(wanted, until, |replicate, paths| {
                v.place.mean(&**estimate, scene, replicate * 7919 + i as u32, paths)
            });
            got.push(Got { value: mean * v.factor + v.offset, standard_error: error * v.factor });
        }
        got
    }
}

fn scene(text: &str) -> Scene {
    load::parse(text, std::path::Path::new(".")).unwrap_or_else(|e| panic!("{e} in\n{text}"))
}

fn estimator_of(text: &str, choice: &Choice) -> (Arc<Scene>, Arc<dyn Estimate>) {
    // All spectra are flat: four wavelengths are as good as eighty.
    let sampling = Sampling::bins(380.0, 780.0, 4).unwrap();
    let quantity = Quantity { sampling, range_nm: (380.0, 780.0), what: What::Xyz, seed: 1, few: None };
    let scene = Arc::new(scene(text));
    let estimate = estimator(scene.clone(), &quantity, choice).unwrap();
    (scene, estimate)
}

/// Mean of sixteen independent estimates and its standard error, their paths doubled until it is small enough.
fn replicates(wanted: f64, until: Instant, one: impl Fn(u32, u32) -> f64 + Sync) -> (f64, f64) {
    let mut paths = 32;
    loop {
        let begin = Instant::now();
        let means: Vec<f64> = (0..R).into_par_iter().map(|r| one(r, paths)).collect();
        let n = f64::from(R);
        let mean = means.iter().sum::<f64>() / n;
        let error = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        // Nothing found yet says nothing of the error.
        let known = error <= wanted && (mean != 0.0 || paths > 60_000);
        // A round that would not end in time would take it from the values after this one.
        let (took, left) = (begin.elapsed(), until.saturating_duration_since(Instant::now()));
        if known || 2 * took > left {
            return (mean, error);
        }
        paths *= if error > 3.0 * wanted && 4 * took <= left { 4 } else { 2 };
    }
}

impl Place {
    /// One estimate from so many paths.
    fn mean(&self, estimate: &dyn Estimate, scene: &Scene, replicate: u32, paths: u32) -> f64 {
        let at = |p: DVec3| scene.frame.place(p).as_vec3a();
        let unit = |d: DVec3| d.normalize().as_vec3a();
        let y = |probe: Probe, paths| {
            let mut out = [0.0; 3];
            estimate.measure(&[probe], Effort::Paths(paths), &mut out)[0].luminance
        };
        let lifted = |p: Vec3A, n: Vec3A| scene.lifted(p, n);
        let number = u64::from(replicate);
        // A point on a surface for each path, drawn from a net of its own.
        let over = |place: &dyn Fn([f64; 2]) -> (DVec3, DVec3)| {
            let one = |i: u32| {
                let (p, n) = place(Sampler::new(replicate, 77, i, 5).pair(0).map(f64::from));
                let (p, n) = (at(p), unit(n));
                let number = (u64::from(replicate) << 32) + u64::from(i);
                y(Probe::Irradiance { point: lifted(p, n), normal: n, number }, 1)
            };
            (0..paths).map(one).sum::<f64>() / f64::from(paths)
        };
        match self {
            Place::Ray(o, d) => y(Probe::Ray { origin: at(*o), direction: unit(*d), number }, paths),
            Place::Point(p, n) => {
                y(Probe::Irradiance { point: lifted(at(*p), unit(*n)), normal: unit(*n), number }, paths)
            }
            Place::Area(corner, u, v) => over(&|s| (*corner + *u * s[0] + *v * s[1], u.cross(*v))),
            Place::Disk(centre, normal, radius) => over(&|s| {
                let (x, y) = normal.any_orthonormal_pair();
                let (r, phi) = (radius * s[0].sqrt(), std::f64::consts::TAU * s[1]);
                (*centre + x * (r * phi.cos()) + y * (r * phi.sin()), *normal)
            }),
        }
    }
}
