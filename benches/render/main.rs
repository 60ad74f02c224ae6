//! spectrace beside Mitsuba 3 in one run, on two threads each, at 128 x 128 pixels: errors at equal time, noise of 80 bands at
//! equal time, and what more bands cost.
//!
//! `make bench-render`, or one part: `cargo bench --bench render -- cornell` (or mesh, fog, bands, cost, pools). The peer is the Mitsuba of the
//! Python that MITSUBA_PYTHON names; docs/performance.md says how to get one that works. Time is CPU seconds of all threads, so
//! that what else runs on the machine counts for neither: ten seconds on two processors are 20. Ours are counted whole,
//! Mitsuba's without loading the scene and compiling its kernels. The long renders that errors are measured against stay
//! in out/bench-render until the scene's file changes.

#[allow(dead_code)]
#[path = "../beside/mod.rs"]
mod beside;
mod programs;
mod score;
#[path = "../../examples/mesh/shapes.rs"]
mod shapes;

use std::fs;
use std::path::Path;

use beside::{median, processor, ratio};
use programs::{Made, Programs, SIZE, THREADS};
use score::{Errors, Reference, Renders, noise, relative_noise};

/// Seconds on all threads that errors are compared at.
const SECONDS: f64 = 10.0;
/// Independent parts of a reference.
const PARTS: u32 = 8;
/// Samples a pixel of each.
const SAMPLES: u32 = 256;
/// Paths a pixel in one of Mitsuba's chunks, by sampler: stratified ones gain from large chunks.
const SAMPLERS: [(&str, &str); 2] =
    [("independent", "--sampler independent --spp 32"), ("multijitter", "--sampler multijitter --spp 144")];
/// The same in fog, where the scalar variant is the faster one.
const IN_FOG: [(&str, &str); 3] = [
    ("independent", "--sampler independent --spp 16"),
    ("multijitter", "--sampler multijitter --spp 16"),
    ("scalar", "--variant scalar_spectral --sampler independent --spp 4"),
];

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|a| a == "--bench") {
        println!("the renderer's bench takes minutes: make bench-render");
        return Ok(());
    }
    let parts: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with('-')).collect();
    let wanted = |part: &str| parts.is_empty() || parts.contains(&part);
    let programs = Programs::new()?;
    println!("{SIZE} x {SIZE} pixels, {THREADS} threads; {}", processor());
    if !programs.has_peer() {
        println!("without Mitsuba: MITSUBA_PYTHON names no Python that has it");
    }
    println!("\n{:<58} {:>10} {:>10}", "", "value", "wanted");
    if wanted("mesh") || wanted("pools") {
        shapes::write(&shapes::meshes(&programs.root.join("scenes/mesh"))?, &programs.root.join("out/mesh"))?;
    }
    if wanted("cornell") {
        at_equal_time(&programs, "cornell")?;
    }
    if wanted("mesh") {
        at_equal_time(&programs, "mesh")?;
    }
    if wanted("fog") {
        at_equal_time(&programs, "fogbox")?;
    }
    if wanted("bands") {
        bands(&programs)?;
    }
    if wanted("cost") {
        cost(&programs);
    }
    if wanted("pools") {
        pools(&programs);
    }
    Ok(())
}

/// A line of the table; `wanted` is a bound above, or below where `at_least`.
fn row(what: &str, value: f64, wanted: Option<f64>, at_least: bool) {
    let (bound, verdict) = match wanted {
        None => (String::new(), ""),
        Some(w) if (value >= w) == at_least || value == w => {
            (format!("{}{w}", if at_least { ">= " } else { "<= " }), "ok")
        }
        Some(w) => (format!("{}{w}", if at_least { ">= " } else { "<= " }), "NOT"),
    };
    println!("{what:<58} {value:>10.4} {bound:>10} {verdict}");
}

/// Errors after ten seconds, ours and Mitsuba's; ours over its at equal time, errors falling as the root of time, and how many
/// times longer Mitsuba takes to reach ours.
fn at_equal_time(programs: &Programs, scene: &str) -> std::io::Result<()> {
    let reference = reference(programs, scene)?;
    let cpu = SECONDS * THREADS as f64;
    let samples = programs.samples_for(scene, cpu, "");
    let ours = programs.ours(scene, samples, 7, "");
    let errors = reference.errors(&ours.renders.mean());
    row(&format!("{scene}: ours, {samples} samples, CPU s"), ours.cpu, None, false);
    let most = (scene != "fogbox").then_some(1.0);
    row(&format!("{scene}: ours, mean Delta E 2000"), errors.delta_e, most, false);
    row(&format!("{scene}: ours, relative RMSE of Y"), errors.relative_rmse, None, false);
    let samplers: &[(&str, &str)] = if scene == "fogbox" { &IN_FOG } else { &SAMPLERS };
    for (sampler, options) in samplers {
        let Some(peer) = programs.peer(scene, cpu, options) else {
            println!("{scene}: Mitsuba {sampler} skipped");
            continue;
        };
        against(scene, sampler, &reference, (&ours, errors), &peer);
    }
    Ok(())
}

fn against(scene: &str, sampler: &str, reference: &Reference, (ours, errors): (&Made, Errors), peer: &Made) {
    let theirs = reference.errors(&peer.renders.mean());
    let name = format!("{scene}: Mitsuba {sampler},");
    row(&format!("{name} {} chunks, CPU s", peer.renders.pictures.len()), peer.cpu, None, false);
    row(&format!("{name} mean Delta E 2000"), theirs.delta_e, None, false);
    row(&format!("{name} relative RMSE of Y"), theirs.relative_rmse, None, false);
    let most_rmse = if scene == "mesh" { 0.7 } else { 0.5 };
    let mut theirs_rmse = theirs.relative_rmse;
    if scene == "fogbox" {
        // Its mean is not ours where a medium's coefficients depend on wavelength (docs/performance.md): its noise alone is compared.
        theirs_rmse = peer.renders.noise_of_mean();
        row(&format!("{name} noise of Y, from its chunks"), theirs_rmse, None, false);
    }
    for (what, a, b, most) in
        [("Delta E", errors.delta_e, theirs.delta_e, 0.5), ("RMSE", errors.relative_rmse, theirs_rmse, most_rmse)]
    {
        let at_equal_time = a / b * (ours.cpu / peer.cpu).sqrt();
        row(&format!("{name} our {what} / its at equal time"), at_equal_time, Some(most), false);
        row(&format!("{name} its time to our {what} / ours"), at_equal_time.powi(-2), None, false);
    }
    if peer.renders.pictures.len() >= 4 {
        let [means, worst, mean] = reference.agreement(&peer.renders, SIZE);
        let most = (scene != "fogbox").then_some(3e-3);
        row(&format!("{name} |mean Y / reference's - 1|"), (means - 1.0).abs(), most, false);
        // A few chunks estimate their own spread badly: wider than a normal distribution, so only the mean is judged.
        row(&format!("{name} worst |z| of 8 x 8 blocks"), worst, None, false);
        row(&format!("{name} mean |z| of 8 x 8 blocks"), mean, most.map(|_| 1.2), false);
    }
}

/// Which pixels see no lamp.
fn counting(programs: &Programs, scene: &str) -> (Vec<bool>, [f64; 3]) {
    let straight = programs.ours(scene, 64, 3, "--max-bounces 0");
    let lamp = straight.white.expect("the scene has a lamp").xyz();
    (straight.renders.pictures[0].chunks_exact(3).map(|p| p[1] == 0.0).collect(), lamp)
}

/// The long render of a scene, from out/bench-render where it is there and the scene's file is the same.
fn reference(programs: &Programs, scene: &str) -> std::io::Result<Reference> {
    let folder = programs.root.join("out/bench-render");
    fs::create_dir_all(&folder)?;
    let (file, text) =
        (folder.join(format!("{scene}-{PARTS}x{SAMPLES}.raw")), fs::read_to_string(programs.scene(scene))?);
    let beside = file.with_extension("toml");
    let each = SIZE * SIZE * 3;
    let mut pictures = kept(&file, &beside, &text, each);
    if pictures.len() != PARTS as usize {
        eprintln!("{scene}: {PARTS} x {SAMPLES} samples a pixel as a reference, once");
        pictures =
            (0..PARTS).flat_map(|part| programs.ours(scene, SAMPLES, 1000 + part, "").renders.pictures).collect();
        let bytes: Vec<u8> = pictures.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        fs::write(&file, bytes)?;
        fs::write(&beside, &text)?;
    }
    let (counts, lamp) = counting(programs, scene);
    Ok(Reference::new(Renders { channels: 3, pictures }, counts, lamp))
}

fn kept(file: &Path, beside: &Path, text: &str, each: usize) -> Vec<Vec<f32>> {
    if fs::read_to_string(beside).ok().as_deref() != Some(text) {
        return Vec::new();
    }
    let raw = fs::read(file).unwrap_or_default();
    let all: Vec<f32> = raw.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    all.chunks_exact(each).map(<[f32]>::to_vec).collect()
}

/// Noise a band of 80-band pictures of the Cornell box after the same time; Mitsuba's time to our noise over ours.
fn bands(programs: &Programs) -> std::io::Result<()> {
    let (counts, _) = counting(programs, "cornell");
    let (cpu, options) = (0.25 * SECONDS * THREADS as f64, "--output spectrum --bands 80");
    let samples = programs.samples_for("cornell", cpu, options);
    let parts: Vec<Made> = (0..4).map(|seed| programs.ours("cornell", samples, seed, options)).collect();
    let time: f64 = parts.iter().map(|p| p.cpu).sum();
    let ours = Renders { channels: 80, pictures: parts.into_iter().flat_map(|p| p.renders.pictures).collect() };
    let noise_ours = noise(&ours, &counts);
    row(&format!("80 bands: ours, 4 x {samples} samples, CPU s"), time, None, false);
    row("80 bands: ours, median noise of a band", noise_ours, None, false);
    // Several chunks in the time: their spread is the noise.
    for (sampler, spp) in [("independent", 16), ("multijitter", 16)] {
        let Some(peer) = programs.peer("cornell", time, &format!("--sampler {sampler} --spp {spp} --bands 80")) else {
            println!("80 bands: Mitsuba {sampler} skipped");
            continue;
        };
        let theirs = noise(&peer.renders, &counts);
        row(&format!("80 bands: Mitsuba {sampler}, CPU s"), peer.cpu, None, false);
        row(&format!("80 bands: Mitsuba {sampler}, median noise of a band"), theirs, None, false);
        let times = (theirs / noise_ours).powi(2) * peer.cpu / time;
        row(&format!("80 bands: Mitsuba {sampler}, time to our noise / ours"), times, Some(40.0), true);
    }
    Ok(())
}

/// Time to the same error with pooled paths over that of paths alone: of Y, and of Y relative to each pixel's own; errors fall as
/// the root of time.
fn pools(programs: &Programs) {
    let (parts, samples) = (6, 64);
    for scene in ["cornell", "mesh", "room-c", "glossy", "tower", "materials"] {
        let (counts, _) = counting(programs, scene);
        let mut both = [("", Vec::new()), ("--no-pool", Vec::new())];
        for seed in 0..parts {
            // Neighbouring runs.
            both.iter_mut().for_each(|(options, made)| made.push(programs.ours(scene, samples, seed, options)));
        }
        let [pooled, alone] = both.map(|(_, made)| {
            let cpu = median(made.iter().map(|m| m.cpu));
            let renders =
                Renders { channels: 3, pictures: made.into_iter().flat_map(|m| m.renders.pictures).collect() };
            (cpu, [noise(&renders, &counts), relative_noise(&renders, &counts)])
        });
        row(&format!("pools: {scene}, {samples} samples, CPU s / alone's"), pooled.0 / alone.0, None, false);
        for (what, i) in [("error of Y", 0), ("error relative to each pixel's Y", 1)] {
            let times = (pooled.1[i] / alone.1[i]).powi(2) * pooled.0 / alone.0;
            row(&format!("pools: {scene}, time to the same {what} / alone's"), times, None, false);
        }
    }
}

/// CPU seconds with 16 and 80 bands over those with 3, the same paths; medians of neighbouring runs.
fn cost(programs: &Programs) {
    let runs = 5;
    let variants =
        ["--bands 3", "--bands 16", "--bands 80", "--bands 80 --output spectrum"].map(|options| (options, Vec::new()));
    let mut variants = Vec::from(variants);
    for _ in 0..runs {
        for (options, times) in &mut variants {
            times.push(programs.trace("cornell", 64, 1, options));
        }
    }
    let base = variants[0].1.clone();
    row("--bands 3, 64 samples: CPU s", median(base.iter().copied()), None, false);
    for ((options, times), bound) in variants[1..].iter().zip([1.1, 1.5, 1.5]) {
        row(&format!("{options}: time / that of --bands 3"), ratio(times, &base), Some(bound), false);
    }
}
