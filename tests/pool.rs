//! Paths that pixels pool: the same light as without, in parts as in the whole, with less noise.

mod common;

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::fs;

use common::{job, rendered, scene};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::scene::{Scene, load};

const SIZE: usize = 40;
const SEEDS: u32 = 10;
const SAMPLES: u32 = 16;

/// A coarse ball of smooth normals, which turn away from much that sees its faces, on a floor half of which is black.
fn ball() -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (rings, sides) = (5, 7);
    let mut obj = String::new();
    for (i, k) in (0..=rings).flat_map(|i| (0..sides).map(move |k| (i, k))) {
        let (polar, azimuth) = (i as f64 / rings as f64 * PI, k as f64 / sides as f64 * TAU);
        let [x, y, z] = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
        writeln!(obj, "v {x} {y} {z}\nvn {x} {y} {z}").unwrap();
    }
    for (i, k) in (0..rings).flat_map(|i| (0..sides).map(move |k| (i, k))) {
        let at = |i: usize, k: usize| i * sides + k % sides + 1;
        let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
        // At the poles two corners are one.
        if i + 1 < rings {
            writeln!(obj, "f {a}//{a} {b}//{b} {c}//{c}").unwrap();
        }
        if i > 0 {
            writeln!(obj, "f {a}//{a} {c}//{c} {d}//{d}").unwrap();
        }
    }
    fs::write(folder.path().join("ball.obj"), obj).unwrap();
    let file = folder.path().join("scene.toml");
    fs::write(&file, BALL).unwrap();
    load::load(&file).unwrap()
}

const BALL: &str = r#"
[camera]
origin = [0, -6, 2]
target = [0, 0, 0]
up = [0, 0, 1]
fov_deg = 40
[materials.checker]
texture = { type = "checker", values = [0, 0.8], size = 0.2, space = "place" }
[materials.white]
reflectance = 0.8
[materials.lamp]
reflectance = 0
[lights.lamp]
spectrum = "D65"
luminance = 1000
[[shape]]
type = "quad"
material = "checker"
points = [[-3, -3, -1.05], [3, -3, -1.05], [3, 3, -1.05], [-3, 3, -1.05]]
[[shape]]
type = "quad"
material = "white"
points = [[-3, 2, -1.05], [3, 2, -1.05], [3, 2, 3], [-3, 2, 3]]
[[shape]]
type = "quad"
material = "lamp"
light = "lamp"
points = [[-1, -1, 3], [-1, 1, 3], [1, 1, 3], [1, -1, 3]]
[[shape]]
type = "mesh"
material = "white"
file = "ball.obj"
"#;

fn small(name: &str) -> Scene {
    let mut scene = if name == "ball" { ball() } else { scene(name) };
    scene.camera = scene.camera.map(|c| c.resized(Some(SIZE), None).unwrap());
    scene
}

/// XYZ with pools or without, four paths from the first surface.
fn render(name: &str, samples: u32, seed: u32, pool: bool, rows: Option<(usize, usize)>) -> Vec<f32> {
    let scene = small(name);
    let mut job = job(&scene, 16, samples, seed);
    job.method = Choice::Path(path::Options { max_bounces: scene.max_bounces.unwrap_or(u32::MAX), split: 4, pool });
    job.rows = rows.unwrap_or(job.rows);
    rendered(scene, job)
}

/// Mean and variance of each block of 5 x 4 pixels over the seeds, and the sum of the relative variances of pixels: of Y.
struct Blocks {
    mean: Vec<f64>,
    variance: Vec<f64>,
    noise: f64,
}

fn blocks(name: &str, first: u32, pool: bool) -> Blocks {
    let all: Vec<Vec<f64>> = (0..SEEDS)
        .map(|seed| render(name, SAMPLES, first + seed, pool, None).chunks_exact(3).map(|p| f64::from(p[1])).collect())
        .collect();
    let n = f64::from(SEEDS);
    let spread = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / n;
        (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
    };
    let (mut mean, mut variance) = (Vec::new(), Vec::new());
    let rows = all[0].len() / SIZE;
    for (y, x) in (0..rows / 4).flat_map(|y| (0..SIZE / 5).map(move |x| (4 * y, 5 * x))) {
        let of = |picture: &Vec<f64>| (0..20).map(|i| picture[(y + i / 5) * SIZE + x + i % 5]).sum::<f64>() / 20.0;
        let (m, v) = spread(&all.iter().map(of).collect::<Vec<_>>());
        mean.push(m);
        variance.push(v / n);
    }
    // Relative: the few pixels that see a lamp's edge would be all of it.
    let relative = |i: usize| {
        let (mean, variance) = spread(&all.iter().map(|p| p[i]).collect::<Vec<_>>());
        if mean > 0.0 { variance / (mean * mean) } else { 0.0 }
    };
    let noise = (0..all[0].len()).map(relative).sum();
    Blocks { mean, variance, noise }
}

/// Matt rooms, gloss, panes and the sky, smooth normals: each block's mean is that of paths alone within what their noise allows, and no block
/// lies far off. A z of few seeds is wider than a normal one (Student's t, 18 degrees of freedom). In matt rooms pools leave less
/// noise, which is what they are for.
#[test]
fn pooled_light_is_the_light_of_paths_alone() {
    let most = [("cornell.toml", 0.75), ("room-c.toml", 0.4), ("glossy.toml", 2.0), ("tower.toml", 2.0), ("ball", 2.0)];
    for (name, most) in most {
        let (alone, pooled) = (blocks(name, 0, false), blocks(name, 1000, true));
        let (mut squares, mut count, mut worst) = (0.0, 0.0, 0f64);
        for i in 0..alone.mean.len() {
            let variance = alone.variance[i] + pooled.variance[i];
            if variance > 0.0 {
                let z2 = (alone.mean[i] - pooled.mean[i]).powi(2) / variance;
                (squares, count, worst) = (squares + z2, count + 1.0, worst.max(z2.sqrt()));
            }
        }
        let (z2, noise) = (squares / count, pooled.noise / alone.noise);
        let sums = [&alone, &pooled].map(|b| b.mean.iter().sum::<f64>());
        let off = sums[1] / sums[0] - 1.0;
        println!("{name}: mean z2 {z2:.2}, worst z {worst:.1}, mean off by {off:.1e}, variance of a pixel {noise:.2}");
        assert!(z2 < 1.6 && worst < 6.0, "{name}: mean z2 {z2}, worst z {worst}");
        assert!(noise < most, "{name}: {noise} of the variance");
    }
}

/// Rows that cut through tiles are those of the whole picture.
#[test]
fn rows_of_pools_are_those_of_the_whole() {
    let whole = render("cornell.toml", 4, 1, true, None);
    for (from, to) in [(0, 1), (3, 6), (6, 7), (13, 40)] {
        let part = render("cornell.toml", 4, 1, true, Some((from, to)));
        assert_eq!(part, whole[3 * SIZE * from..3 * SIZE * to], "rows {from} to {to}");
    }
}
