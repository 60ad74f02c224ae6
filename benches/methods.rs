//! `make bench-methods`: the ways to solve Eq. (1) against each other, error beside time, in one run; docs/methods.csv and the chart
//! docs/methods.svg come from here.
//!
//! Four parts, each alone by its name (`cargo bench --bench methods -- room`): `room`, the sizes of errors in a closed room
//! (tests/ref/validation.toml, method-error-sizes) and the time to 1 %; `cornell`, the same time in the Cornell box; `caustic`, a
//! lamp through a glass sphere; `local`, what the cheapest costs. Seconds are wall clock on all threads, the solution of a method
//! and what it shows together.

#[allow(dead_code)]
mod beside;
#[path = "beside/probes.rs"]
mod probes;

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3A};
use luxpipe::parallel;
use luxpipe::render::estimate::{Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::{local, path, photon, radiosity};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;

use beside::processor;
use probes::luminances;

/// Mean irradiances of the closed room: floor, wall, ceiling; case method-error-sizes.
const ROOM_LX: [f64; 3] = [44.3248, 39.2844, 18.7139];
/// Points along each side of a surface.
const GRID: usize = 24;

/// A scene and where it is measured.
struct Subject {
    scene: Arc<Scene>,
    bands: usize,
    points: Vec<(Vec3A, Vec3A)>,
}

/// Irradiances, and the seconds that they took.
struct Got {
    lux: Vec<f64>,
    seconds: f64,
}

impl Subject {
    fn new(text: &str, folder: &str, bands: usize) -> Subject {
        let scene = load::parse(text, Path::new(folder)).unwrap_or_else(|e| panic!("{e}"));
        Subject { scene: Arc::new(scene), bands, points: Vec::new() }
    }

    fn measure(&self, choice: &Choice, paths: u32, seed: u32) -> Got {
        let start = Instant::now();
        let sampling = Sampling::bins(380.0, 780.0, self.bands).unwrap();
        let quantity = Quantity { sampling, range_nm: (380.0, 780.0), what: What::Xyz, seed, few: None };
        let estimate = estimator(self.scene.clone(), &quantity, choice).unwrap();
        let probe = |i: usize| {
            let (point, normal) = self.points[i];
            Probe::Irradiance { point, normal, number: i as u64 }
        };
        let lux = luminances(&*estimate, self.points.len(), probe, paths);
        Got { lux, seconds: start.elapsed().as_secs_f64() }
    }
}

/// Mean of the absolute errors over the mean.
fn error(got: &[f64], truth: &[f64]) -> f64 {
    let sum: f64 = truth.iter().sum();
    got.iter().zip(truth).map(|(g, t)| (g - t).abs()).sum::<f64>() / sum
}

fn by_path() -> Choice {
    Choice::Path(path::Options { max_bounces: u32::MAX, split: 1, pool: false })
}

fn by_local(ambient: local::Term) -> Choice {
    Choice::Local(local::Options { ambient, shadows: true, reflections: true })
}

fn by_radiosity(divide: Option<u32>, tolerance: f64, rays: u32, show: radiosity::Show) -> Choice {
    Choice::Radiosity(radiosity::Options { divide, tolerance, rays, show, memory: 4 << 30, solution: None, seed: 1 })
}

fn by_photon(photons: u32, passes: u32, count: u32) -> Choice {
    let (gather_once, memory) = (false, 4 << 30);
    Choice::Photon(photon::Options { photons, passes, count, gather_once, step: 0.1, seed: 1, memory, solution: None })
}

/// The closed room of 4 x 4 x 3 m whose ceiling shines.
fn room() -> Subject {
    let mut text = String::from("[lights.l]\nspectrum = \"E\"\nluminance = 31.830988618379067\n");
    for (name, reflectance) in [("wall", 0.5), ("floor", 0.2), ("ceiling", 0.7)] {
        let _ = writeln!(text, "[materials.{name}]\nreflectance = {reflectance}");
    }
    let (x, y, z) = (DVec3::X * 4.0, DVec3::Y * 4.0, DVec3::Z * 3.0);
    let o = DVec3::ZERO;
    let sides = [("floor", o, x, y), ("wall", o, y, z), ("wall", x, z, y), ("wall", o, z, x), ("wall", y, x, z)];
    let sides = sides.into_iter().chain([("ceiling", z, y, x)]);
    let mut places = Vec::new();
    for (material, o, u, v) in sides {
        let light = if material == "ceiling" { "light = \"l\"\n" } else { "" };
        let corner = |p: DVec3| format!("[{}, {}, {}]", p.x, p.y, p.z);
        let points = [o, o + u, o + u + v, o + v].map(corner).join(", ");
        let _ = writeln!(text, "[[shape]]\ntype = \"quad\"\npoints = [{points}]\nmaterial = \"{material}\"\n{light}");
        let at = |i: usize| (i as f64 + 0.5) / GRID as f64;
        places.extend((0..GRID * GRID).map(|i| (o + u * at(i % GRID) + v * at(i / GRID), u.cross(v).normalize())));
    }
    let mut subject = Subject::new(&text, ".", 4);
    let scene = subject.scene.clone();
    let place = |(p, n): &(DVec3, DVec3)| {
        let normal = n.as_vec3a();
        (scene.lifted(scene.frame.place(*p).as_vec3a(), normal), normal)
    };
    subject.points = places.iter().map(place).collect();
    subject
}

/// A table's line, and a row of the chart.
fn line(page: &mut String, method: &str, setting: &str, got: &Got, error: f64, errors: &str) {
    println!("{method:<14} {setting:<34} {:>8.3} s {:>8.3} %  {errors}", got.seconds, 100.0 * error);
    let _ = writeln!(page, "{method},{setting},{:.4},{:.4}", got.seconds, 100.0 * error);
}

/// Irradiance of the room by all methods.
fn in_the_room() -> std::io::Result<()> {
    let subject = room();
    let truth = subject.measure(&by_path(), 16384, 77).lux;
    let means = |lux: &[f64]| {
        let part = |a: usize, b: usize| {
            lux[a * GRID * GRID..b * GRID * GRID].iter().sum::<f64>() / ((b - a) * GRID * GRID) as f64
        };
        [part(0, 1), part(1, 5), part(5, 6)]
    };
    let off = |lux: &[f64]| {
        let m = means(lux);
        [0, 1, 2].map(|i| 100.0 * (m[i] / ROOM_LX[i] - 1.0))
    };
    let shown = |lux: &[f64]| {
        let [f, w, c] = off(lux);
        format!("floor {f:+.2} %, walls {w:+.2} %, ceiling {c:+.2} %")
    };
    println!("\nroom: irradiance of {} points; mean absolute error over the mean, and means of surfaces", truth.len());
    println!("reference  16384 paths a point: {}", shown(&truth));
    let mut page = String::from("method,setting,seconds,error_percent\n");
    let mut run = |method: &str, setting: &str, choice: Choice, paths: u32| {
        // Solutions of milliseconds: the middle of three.
        let mut all: Vec<Got> = (0..3).map(|_| subject.measure(&choice, paths, 1)).collect();
        all.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let got = all.swap_remove(1);
        let e = error(&got.lux, &truth);
        line(&mut page, method, setting, &got, e, &shown(&got.lux));
        (got.seconds, e)
    };
    run("local", "direct light only", by_local(local::Term::Luminance(0.0)), 16);
    run("local", "best ambient term", by_local(local::Term::Balance), 16);
    let mut reached = None;
    for n in [1, 2, 4, 8] {
        let choice = by_radiosity(Some(n), 0.01, 4096, radiosity::Show::Mesh);
        run("even radiosity", &format!("{} elements a wall", n * n), choice, 1);
    }
    for (tolerance, rays) in [(0.02, 256), (0.01, 512), (0.005, 1024), (0.0025, 4096)] {
        let setting = format!("mesh error {tolerance} {rays} rays");
        let (seconds, e) = run("radiosity", &setting, by_radiosity(None, tolerance, rays, radiosity::Show::Mesh), 1);
        reached = reached.or((e <= 0.01).then_some(seconds));
    }
    for count in [50, 100, 500, 2000] {
        run("photon", &format!("200000 photons {count} a disk"), by_photon(200_000, 8, count), 8);
    }
    run("photon", "2000000 photons 200 a disk", by_photon(2_000_000, 32, 200), 32);
    let mut path_to_1 = f64::NAN;
    for m in (0..=12).step_by(2) {
        let (seconds, e) = run("path", &format!("{} paths", 1 << m), by_path(), 1 << m);
        // Errors fall as the root of time; the last one above 1 % tells.
        if e > 0.01 {
            path_to_1 = seconds * (e / 0.01).powi(2);
        }
    }
    verdict("room: path's time to 1 % over radiosity's", path_to_1 / reached.unwrap_or(f64::NAN), 10.0);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    std::fs::write(folder.join("methods.csv"), page)
}

fn verdict(what: &str, value: f64, wanted: f64) {
    if value.is_nan() {
        return println!("{what}: not reached [>= {wanted}] NOT");
    }
    println!("{what}: {value:.1} [>= {wanted}] {}", if value >= wanted { "ok" } else { "NOT" });
}

/// Points that a camera's pixels see, a grid of N x N over the picture.
fn seen(scene: &Scene, n: usize) -> Vec<(Vec3A, Vec3A)> {
    let camera = scene.camera.as_ref().expect("a camera");
    let mut points = Vec::new();
    for i in 0..n * n {
        let at = |k: usize, size: usize| (k as f64 + 0.5) / n as f64 * size as f64;
        let Some((o, d)) = camera.ray(at(i % n, camera.width), at(i / n, camera.height), [0.5; 2]) else { continue };
        let Some(hit) = scene.geometry.closest(o, d).filter(|h| h.surface.emitter.is_none()) else { continue };
        let normal = if hit.normal.dot(d) < 0.0 { hit.normal } else { -hit.normal };
        points.push((luxpipe::scene::ray::offset(hit.point, normal, hit.reach), normal));
    }
    points
}

fn in_the_box() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let text = std::fs::read_to_string(folder.join("cornell.toml")).expect("scenes/cornell.toml");
    let mut subject = Subject::new(&text, &folder.display().to_string(), 16);
    subject.points = seen(&subject.scene, 64);
    let truth = subject.measure(&by_path(), 32768, 77).lux;
    println!("\ncornell: irradiance of {} points that the camera sees, 16 wavelengths", truth.len());
    let mut page = String::new();
    let mut reached = None;
    use radiosity::Show::{Direct, Gather};
    let tries = [
        (0.05, 128, Direct, 16),
        (0.03, 512, Direct, 32),
        (0.02, 768, Direct, 32),
        (0.02, 640, Direct, 32),
        (0.02, 1024, Direct, 32),
        (0.01, 1024, Direct, 64),
        (0.05, 128, Gather, 32),
        (0.05, 128, Gather, 128),
    ];
    for (tolerance, rays, show, paths) in tries {
        let got = subject.measure(&by_radiosity(None, tolerance, rays, show), paths, 1);
        let e = error(&got.lux, &truth);
        line(&mut page, "radiosity", &format!("{show:?}, mesh {tolerance}, {rays} rays, {paths} looks"), &got, e, "");
        if e <= 0.01 && reached.is_none_or(|r| got.seconds < r) {
            reached = Some(got.seconds);
        }
    }
    let got = subject.measure(&by_path(), 64, 1);
    let e = error(&got.lux, &truth);
    line(&mut page, "path", "64 paths", &got, e, "");
    let got = subject.measure(&by_path(), 512, 1);
    let e = error(&got.lux, &truth);
    line(&mut page, "path", "512 paths", &got, e, "");
    verdict(
        "cornell: path's time to 1 % over radiosity's",
        got.seconds * (e / 0.01).powi(2) / reached.unwrap_or(f64::NAN),
        10.0,
    );
}

/// A lamp of 0.2 m that shines through a glass sphere onto the floor.
fn in_the_caustic() {
    let text = "[lights.l]\nspectrum = \"D65\"\nluminance = 80000\n[materials.floor]\nreflectance = 0.7\n\
        [materials.glass]\ntype = \"dielectric\"\nindex = 1.5\n\
        [[shape]]\ntype = \"quad\"\npoints = [[-4,-4,0],[4,-4,0],[4,4,0],[-4,4,0]]\nmaterial = \"floor\"\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [0,0,0.7]\nradius = 0.5\nmaterial = \"glass\"\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [1.5,0.5,3]\nradius = 0.1\nmaterial = \"floor\"\nlight = \"l\"\n";
    let mut subject = Subject::new(text, ".", 8);
    let scene = subject.scene.clone();
    // The shadow of the sphere and the light in it.
    let at = |i: usize| (i as f64 + 0.5) / 32.0 - 0.5;
    let place = |i: usize| {
        let p = DVec3::new(-0.46 + 1.4 * at(i % 32), -0.15 + 1.2 * at(i / 32), 0.0);
        (scene.lifted(scene.frame.place(p).as_vec3a(), Vec3A::Z), Vec3A::Z)
    };
    subject.points = (0..32 * 32).map(place).collect();
    let truth = subject.measure(&by_path(), 262_144, 77).lux;
    println!("\ncaustic: irradiance of {} points about the shadow of a glass sphere", truth.len());
    let mut page = String::new();
    let got = subject.measure(&by_path(), 1024, 1);
    let by_paths = error(&got.lux, &truth);
    line(&mut page, "path", "1024 paths", &got, by_paths, "");
    let mut soonest = f64::NAN;
    for (photons, passes, count) in
        [(20_000, 4, 16), (50_000, 4, 30), (200_000, 8, 60), (1_000_000, 8, 60), (4_000_000, 16, 60)]
    {
        let photon = subject.measure(&by_photon(photons, passes, count), passes, 1);
        let e = error(&photon.lux, &truth);
        line(&mut page, "photon", &format!("{photons} photons {count} a disk"), &photon, e, "");
        // Path's time to the same error, as the root of time.
        let gain = got.seconds * (by_paths / e).powi(2) / photon.seconds;
        soonest = gain.max(soonest);
    }
    verdict("caustic: path's time to photon's error over photon's, at best", soonest, 10.0);
}

/// Noise of local illumination against that of paths, in a picture of the Cornell box.
fn cheaply() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let text = std::fs::read_to_string(folder.join("cornell.toml")).expect("scenes/cornell.toml");
    let mut subject = Subject::new(&text, &folder.display().to_string(), 16);
    subject.points = seen(&subject.scene, 96);
    let noise = |choice: &Choice, paths: u32| {
        let [a, b] = [1, 2].map(|seed| subject.measure(choice, paths, seed));
        let squares: f64 = a.lux.iter().zip(&b.lux).map(|(a, b)| (a - b).powi(2)).sum();
        (a.seconds.min(b.seconds), squares)
    };
    let (local_s, local_squares) = noise(&by_local(local::Term::Balance), 16);
    let (path_s, path_squares) = noise(&by_path(), 64);
    println!("\nlocal: 16 looks at {} points in {local_s:.3} s; 64 paths in {path_s:.3} s", subject.points.len());
    verdict("local: path's time to its noise over its time", path_s * path_squares / local_squares / local_s, 20.0);
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|a| a == "--bench") {
        println!("this takes minutes: make bench-methods");
        return Ok(());
    }
    parallel::set_threads(0);
    parallel::ready();
    println!("{} threads; {}", parallel::threads(), processor());
    let parts: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with('-')).collect();
    let wanted = |part: &str| parts.is_empty() || parts.contains(&part);
    if wanted("room") {
        in_the_room()?;
    }
    if wanted("cornell") {
        in_the_box();
    }
    if wanted("caustic") {
        in_the_caustic();
    }
    if wanted("local") {
        cheaply();
    }
    Ok(())
}
