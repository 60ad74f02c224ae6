//! `make bench-media`: the four solvers of Eq. (2) against each other, error beside time, in one run; the march's error by its step;
//! the dipole's against transport. docs/media.csv, docs/media-steps.csv, docs/media-dipole.csv and their charts come from here.
//!
//! Three parts, each alone by its name (`cargo bench --bench media -- fog`): `fog`, scenes/fogbox.toml at 64 x 64 pixels, errors of Y
//! against path tracing with 2048 paths a pixel; `steps`, single scattering in a slab under a sun against its closed form; `dipole`,
//! half spaces of the measured media of spectra/.

#[allow(dead_code)]
mod beside;
#[path = "beside/probes.rs"]
mod probes;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use luxpipe::optics::dipole::Dipole;
use luxpipe::optics::slab::{self, Slab};
use luxpipe::parallel;
use luxpipe::render::estimate::{Effort, Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::{march, path, photon};
use luxpipe::scene::load;
use luxpipe::spectral::{Sampling, builtin};

use beside::processor;
use probes::luminances;

/// Pixels of a side.
const SIZE: usize = 64;
/// Wavelengths.
const BANDS: usize = 16;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn by_path() -> Choice {
    Choice::Path(path::Options { max_bounces: u32::MAX, split: 4, pool: false })
}

fn by_march(step: f32, zones: Option<(u32, u32)>) -> Choice {
    let zonal = zones.map(|(along, rays)| march::solve::Options { along, rays, memory: 4 << 30 });
    Choice::March(march::Options { step, zonal })
}

fn by_photon(photons: u32, passes: u32, count: u32) -> Choice {
    let (gather_once, memory) = (false, 4 << 30);
    Choice::Photon(photon::Options { photons, passes, count, gather_once, step: 0.1, seed: 1, memory, solution: None })
}

/// Y of all pixels of the fog box, and the seconds that they took.
fn fog(choice: &Choice, paths: u32, seed: u32) -> (Vec<f64>, f64) {
    let mut scene = load::load(&root().join("scenes/fogbox.toml")).unwrap_or_else(|e| panic!("{e}"));
    let camera = scene.camera.take().expect("a camera");
    scene.camera = Some(camera.resized(Some(SIZE), Some(SIZE)).expect("a size"));
    let start = Instant::now();
    let sampling = Sampling::bins(380.0, 780.0, BANDS).expect("bins");
    let quantity = Quantity { sampling, range_nm: (380.0, 780.0), what: What::Xyz, seed, few: None };
    let estimate = estimator(Arc::new(scene), &quantity, choice).unwrap_or_else(|e| panic!("{e}"));
    let probe = |i: usize| Probe::Pixel { x: (i % SIZE) as u32, y: (i / SIZE) as u32 };
    let y = luminances(&*estimate, SIZE * SIZE, probe, paths);
    (y, start.elapsed().as_secs_f64())
}

/// Means over 8 x 8 pixels.
fn blocks(y: &[f64]) -> Vec<f64> {
    const EDGE: usize = 8;
    let n = SIZE / EDGE;
    let mut sums = vec![0.0; n * n];
    for (i, y) in y.iter().enumerate() {
        sums[i / SIZE / EDGE * n + i % SIZE / EDGE] += y / (EDGE * EDGE) as f64;
    }
    sums
}

/// Mean of the absolute differences over the mean.
fn error(got: &[f64], truth: &[f64]) -> f64 {
    got.iter().zip(truth).map(|(g, t)| (g - t).abs()).sum::<f64>() / truth.iter().sum::<f64>()
}

fn in_the_fog() -> std::io::Result<()> {
    let (truth, seconds) = fog(&by_path(), 2048, 99);
    println!("\nfog: {SIZE} x {SIZE} pixels, {BANDS} wavelengths; reference {seconds:.0} s");
    println!(
        "{:<8} {:<34} {:>10} {:>10} {:>10} {:>10}",
        "method", "setting", "seconds", "pixels %", "blocks %", "mean %"
    );
    let mut page = String::from("method,setting,seconds,error_percent,blocks_percent,mean_percent\n");
    let mut run = |method: &str, setting: String, choice: Choice, paths: u32| {
        let (y, seconds) = fog(&choice, paths, 1);
        let [pixels, wide] = [error(&y, &truth), error(&blocks(&y), &blocks(&truth))].map(|e| 100.0 * e);
        let mean = 100.0 * (y.iter().sum::<f64>() / truth.iter().sum::<f64>() - 1.0);
        println!("{method:<8} {setting:<34} {seconds:>10.3} {pixels:>10.3} {wide:>10.3} {mean:>+10.3}");
        let _ = writeln!(page, "{method},{setting},{seconds:.4},{pixels:.4},{wide:.4},{mean:.4}");
    };
    for paths in [1, 4, 16, 64, 256] {
        run("path", format!("{paths} paths a pixel"), by_path(), paths);
    }
    for step in [1.0, 0.3, 0.1] {
        run("march", format!("step {step}"), by_march(step, None), 8);
    }
    for (along, rays) in [(3, 512), (5, 1024), (8, 1024), (8, 4096), (12, 2048)] {
        run("zonal", format!("{along} zones {rays} rays"), by_march(0.2, Some((along, rays))), 8);
    }
    for (photons, passes) in [(20_000, 4), (100_000, 8), (500_000, 8), (2_000_000, 16)] {
        run("photon", format!("{photons} photons {passes} maps"), by_photon(photons, passes, 200), passes.max(8));
    }
    std::fs::write(root().join("docs/media.csv"), page)
}

/// Radiance of single scattering that a slab under a sun sends back, and on: [`by_march`] with a step, over the closed form.
fn in_a_slab() -> std::io::Result<()> {
    println!("\nsteps: single scattering in a slab, depth 1, albedo 0.1; error of the march in %");
    let mut page = String::from("case,step,error_percent\n");
    for (mu0, mu) in [(1.0f64, 1.0f64), (0.5, 1.0), (0.5, 0.25)] {
        let sin = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let text = format!(
            "[media.m]\nextinction = 1\nalbedo = 0.1\n[materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"box\"\nmin = [-50, -50, -1]\nmax = [50, 50, 0]\nmaterial = \"b\"\n\
             [lights.s]\ntype = \"sun\"\nspectrum = [[400, 1], [700, 1]]\nlux = 1\ndirection = [{}, 0, {mu0}]\ndiameter_deg = 0.001\n",
            sin(mu0)
        );
        let back = 0.1 / (4.0 * std::f64::consts::PI) * mu0 / (mu + mu0) * (1.0 - (-(1.0 / mu + 1.0 / mu0)).exp());
        for step in [3.0f32, 1.0, 0.3, 0.1, 0.03, 0.01] {
            let scene = Arc::new(load::parse(&text, Path::new(".")).unwrap_or_else(|e| panic!("{e}")));
            let sampling = Sampling::bins(380.0, 780.0, 4).expect("bins");
            let quantity = Quantity { sampling, range_nm: (380.0, 780.0), what: What::Xyz, seed: 1, few: None };
            let estimate = estimator(scene.clone(), &quantity, &by_march(step, None)).unwrap_or_else(|e| panic!("{e}"));
            let direction = DVec3::new(0.0, sin(mu), -mu);
            let origin = scene.frame.place(-direction * 0.1).as_vec3a();
            let probe = Probe::Ray { origin, direction: direction.as_vec3a(), number: 1 };
            let mut out = [0f32; 3];
            estimate.measure(&[probe], Effort::Paths(64), &mut out);
            let off = 100.0 * (f64::from(out[1]) / back - 1.0).abs();
            println!("cosines {mu0} and {mu}, step {step:<5} {off:>10.4}");
            let _ = writeln!(page, "sun {mu0} eye {mu},{step},{:.6}", off.max(1e-4));
        }
    }
    std::fs::write(root().join("docs/media-steps.csv"), page)
}

/// Measured media, and some between them: the dipole's whole reflectance and transport's, of light that has gone in.
fn of_the_dipole() -> std::io::Result<()> {
    println!("\ndipole: diffuse reflectance of half spaces, of light that has gone in at normal incidence");
    println!("{:<12} {:>6} {:>10} {:>10} {:>10} {:>10}", "medium", "nm", "albedo'", "dipole", "transport", "off %");
    let mut page = String::from("medium,nm,reduced_albedo,dipole,transport,error_percent\n");
    let names = ["apple", "chicken1", "ketchup", "marble", "potato", "skimmilk", "skin1", "skin2", "wholemilk"];
    let mut rows = Vec::new();
    for name in names {
        let table = |what: &str| builtin::spectrum(&format!("medium_{name}_{what}")).unwrap_or_else(|e| panic!("{e}"));
        let (scattering, absorption) = (table("scattering"), table("absorption"));
        let eta = if name == "marble" { 1.5 } else { 1.3 };
        for nm in [610.0, 540.0, 460.0] {
            rows.push((name.to_string(), nm, scattering.at(nm), absorption.at(nm), eta));
        }
    }
    for (name, nm, s, a, eta) in rows {
        let body = Slab { optical_depth: f64::INFINITY, albedo: s / (s + a), eta };
        let shares = slab::measure(&body, &|_| 1.0, &[1.0]).0[0];
        let transport = (shares.reflectance - shares.specular) / (1.0 - shares.specular);
        let dipole = Dipole::new(s, a, eta).total();
        let off = 100.0 * (dipole / transport - 1.0);
        println!("{name:<12} {nm:>6} {:>10.5} {dipole:>10.5} {transport:>10.5} {off:>+10.2}", s / (s + a));
        let _ = writeln!(page, "{name},{nm},{:.6},{dipole:.6},{transport:.6},{off:.4}", s / (s + a));
    }
    std::fs::write(root().join("docs/media-dipole.csv"), page)
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|a| a == "--bench") {
        println!("the media's bench takes minutes: make bench-media");
        return Ok(());
    }
    let parts: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with('-')).collect();
    let wanted = |part: &str| parts.is_empty() || parts.contains(&part);
    parallel::set_threads(0);
    println!("{}", processor());
    if wanted("fog") {
        in_the_fog()?;
    }
    if wanted("steps") {
        in_a_slab()?;
    }
    if wanted("dipole") {
        of_the_dipole()?;
    }
    Ok(())
}
