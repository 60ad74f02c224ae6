//! Pictures against values that other programs and closed forms gave (tests/ref/README.md).

mod common;

use common::{job, npy, rendered, root, scene};
use luxpipe::render::estimate::What;
use luxpipe::render::picture::Job;
use luxpipe::spectral::{Observer, Sampling, Spectrum, builtin};
use luxpipe::units::K_M;

/// Reference pictures are divided by this, so that times 683 they are cd/m2.
const REFERENCE_SCALE: f64 = 106.750_259_4;

/// Mean and standard error of 8 x 8 blocks over independent renders, [block][channel].
struct Blocks {
    mean: Vec<[f64; 3]>,
    se: Vec<[f64; 3]>,
}

/// 8 x 8 block means of a 128 x 128 picture.
fn blocks(picture: &[f32]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; 256];
    for (i, p) in picture.chunks_exact(3).enumerate() {
        let block = (i / 128 / 8) * 16 + i % 128 / 8;
        (0..3).for_each(|c| sums[block][c] += f64::from(p[c]) / 64.0);
    }
    sums
}

fn cornell(runs: u32, samples: u32) -> Blocks {
    let mut all = Vec::new();
    for seed in 0..runs {
        let mut scene = scene("cornell.toml");
        scene.camera = scene.camera.map(|c| c.resized(Some(128), None).unwrap());
        let job = job(&scene, 80, samples, seed);
        all.push(blocks(&rendered(scene, job)));
    }
    let n = f64::from(runs);
    let over = |f: &dyn Fn(usize, usize) -> f64| (0..256).map(|b| [0, 1, 2].map(|c| f(b, c))).collect::<Vec<_>>();
    let mean = over(&|b, c| all.iter().map(|r| r[b][c]).sum::<f64>() / n);
    let se = over(&|b, c| {
        let squares: f64 = all.iter().map(|r| (r[b][c] - mean[b][c]).powi(2)).sum();
        (squares / (n - 1.0) / n).sqrt()
    });
    Blocks { mean, se }
}

/// The check of the whole renderer: the measured Cornell box with 80 bands, image means within 3e-3 and every block
/// that does not see the lamp within 4.5 combined standard errors.
#[test]
fn the_cornell_box_is_the_converged_reference() {
    let reference = npy(&root().join("tests/ref/a_cornell_xyz.npy"));
    let se = npy(&root().join("tests/ref/a_cornell_xyz_se.npy"));
    // The reference's lamp has the published radiance, ours 10,000 cd/m2.
    let observer = Observer::cie1931().unwrap();
    let lamp = K_M * observer.integrate(&builtin::spectrum("cornell_light").unwrap())[1];
    let to_ours = K_M * REFERENCE_SCALE * 10_000.0 / lamp;
    let want = blocks(&reference);
    let want_se: Vec<[f64; 3]> =
        blocks(&se.iter().map(|x| x * x).collect::<Vec<f32>>()).iter().map(|v| v.map(|v| (v / 64.0).sqrt())).collect();
    let got = cornell(32, 8);
    let brightest = reference.chunks_exact(3).fold(0f32, |m, p| m.max(p[1]));
    let sees_lamp = |block: usize| {
        (0..64).any(|i| {
            let (x, y) = (block % 16 * 8 + i % 8, block / 16 * 8 + i / 8);
            reference[(y * 128 + x) * 3 + 1] > 0.5 * brightest
        })
    };
    let (mut worst, mut sum, mut count) = (0f64, 0.0, 0.0);
    let (mut total, mut total_want) = ([0.0; 3], [0.0; 3]);
    for b in 0..256 {
        for c in 0..3 {
            total[c] += got.mean[b][c];
            total_want[c] += want[b][c] * to_ours;
            let spread = got.se[b][c].hypot(want_se[b][c] * to_ours);
            if sees_lamp(b) || spread == 0.0 {
                continue;
            }
            let z = (got.mean[b][c] - want[b][c] * to_ours) / spread;
            worst = worst.max(z.abs());
            sum += z.abs();
            count += 1.0;
        }
    }
    let means: Vec<f64> = (0..3).map(|c| total[c] / total_want[c] - 1.0).collect();
    println!("image means off by {means:?}, worst |z| {worst:.2}, mean |z| {:.3} over {count} values", sum / count);
    assert!(means.iter().all(|m| m.abs() < 3e-3), "{means:?}");
    assert!(worst < 4.5, "worst |z| {worst}");
    assert!(sum / count < 1.2, "mean |z| {}", sum / count);
}

/// Patch centres: x, y on the chart, E_geom, XYZ.
fn centres() -> Vec<[f64; 6]> {
    let text = std::fs::read_to_string(root().join("tests/ref/colorchecker_A_centres.csv")).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with(['#', 'x']));
    rows.map(|l| l.split(',').map(|n| n.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()).collect()
}

/// Pixels across the chart's 8 units: every patch centre (a multiple of 1/8) is a corner of four, and their mean differs
/// from the centre's value by under 1e-5.
const CHART_PIXELS: usize = 256;

/// Mean of the four pixels around each patch centre, [patch][component]: two rows of pixels for each row of patches.
fn chart_once(lamp: &Spectrum, change: &impl Fn(&mut Job), samples: u32, seed: u32) -> Vec<Vec<f64>> {
    let at = |u: f64| (u * CHART_PIXELS as f64 / 8.0) as usize;
    let mut patches = Vec::new();
    for row in centres().chunks(6) {
        let mut scene = scene("colorchecker.toml");
        scene.camera = scene.camera.map(|c| c.resized(Some(CHART_PIXELS), None).unwrap());
        scene.lights[0].radiance = lamp.clone();
        let mut job = job(&scene, 80, samples, seed);
        let y = at(4.0 - row[0][1]);
        job.rows = (y - 1, y + 1);
        change(&mut job);
        let n = if job.quantity.what == What::Spectrum { job.quantity.sampling.count() } else { 3 };
        let picture = rendered(scene, job);
        for centre in row {
            let x = at(centre[0] + 4.0);
            let four = [x - 1, x, CHART_PIXELS + x - 1, CHART_PIXELS + x];
            let mean = |c: usize| four.iter().map(|i| f64::from(picture[i * n + c])).sum::<f64>() / 4.0;
            patches.push((0..n).map(mean).collect());
        }
    }
    patches
}

/// Mean and standard error over `runs` seeds.
fn chart(lamp: Spectrum, change: impl Fn(&mut Job), runs: u32, samples: u32) -> Vec<Vec<(f64, f64)>> {
    let all: Vec<_> = (0..runs).map(|seed| chart_once(&lamp, &change, samples, seed)).collect();
    let n = f64::from(runs);
    let over = |p: usize, c: usize| {
        let mean = all.iter().map(|r| r[p][c]).sum::<f64>() / n;
        let squares: f64 = all.iter().map(|r| (r[p][c] - mean).powi(2)).sum();
        (mean, (squares / (n - 1.0) / n).sqrt())
    };
    (0..24).map(|p| (0..all[0][p].len()).map(|c| over(p, c)).collect()).collect()
}

#[test]
fn chart_patches_with_80_bands_are_the_analytic_values() {
    let a = builtin::spectrum("illuminant_A").unwrap();
    let got = chart(a.scaled(1.0 / a.at(560.0)), |_| {}, 8, 64);
    let mut worst = 0f64;
    for (centre, got) in centres().iter().zip(&got) {
        for c in 0..3 {
            let want = centre[3 + c] * K_M * REFERENCE_SCALE;
            let (mean, se) = got[c];
            worst = worst.max((mean / want - 1.0).abs());
            assert!((mean - want).abs() < 3e-3 * want + 4.5 * se, "{centre:?} channel {c}: {mean} +- {se} for {want}");
        }
    }
    println!("80 bands: largest relative difference {worst:.2e}");
}

/// Two Gauss nodes in each 5 nm step integrate a product of three piecewise linear tables exactly, and the reference's
/// lamp, patches and observer are such tables.
#[test]
fn chart_patches_on_gauss_nodes_are_the_analytic_values() {
    let nodes: Vec<f64> = (0..80)
        .flat_map(|i| {
            let middle = 382.5 + 5.0 * f64::from(i);
            [middle - 2.5 / 3f64.sqrt(), middle + 2.5 / 3f64.sqrt()]
        })
        .collect();
    let every_5_nm = |name: &str| {
        let fine = builtin::spectrum(name).unwrap();
        Spectrum::from_points((76..=156).map(|i| 5.0 * f64::from(i)).map(|nm| (nm, fine.at(nm))).collect()).unwrap()
    };
    let lamp = every_5_nm("illuminant_A");
    let lamp = lamp.scaled(1.0 / lamp.at(560.0));
    let cmf = ["cie1931_x", "cie1931_y", "cie1931_z"].map(every_5_nm);
    let got = chart(
        lamp,
        |job| {
            job.quantity.sampling = Sampling::points(nodes.clone()).unwrap();
            job.quantity.what = What::Spectrum;
        },
        4,
        256,
    );
    let mut worst = 0f64;
    for (centre, got) in centres().iter().zip(&got) {
        for c in 0..3 {
            let sum: f64 = nodes.iter().zip(got).map(|(nm, (l, _))| 2.5 * l * cmf[c].at(*nm)).sum();
            worst = worst.max((sum / REFERENCE_SCALE / centre[3 + c] - 1.0).abs());
        }
    }
    println!("Gauss nodes: largest relative difference {worst:.2e}");
    assert!(worst < 1e-4, "{worst}");
}
