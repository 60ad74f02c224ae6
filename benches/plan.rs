//! Random rooms rendered by their plans and in 80 bands on the same paths: how often the tolerance holds, how many wavelengths it took,
//! what the plans cost.
//!
//! `make bench-plan` (some minutes), or `cargo bench --bench plan -- 300` for as many rooms of each class alone; `-- speed` for what
//! `spectrace --tolerance 1` takes, plan and pilot included, beside three bands and 81 at equal samples.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/plan/judge.rs"]
mod judge;
#[path = "../tests/plan/scenes.rs"]
mod scenes;

use judge::{Verdict, judge};

/// Rooms of each class, unless told.
const ROOMS: u64 = 70;
/// Pixels of the pilot: the rooms have as many, nearly.
const PILOT: usize = 400;
const TOLERANCES: [f64; 3] = [2.0, 1.0, 0.5];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|a| a == "--bench") {
        println!("the planner's bench takes minutes: make bench-plan");
        return;
    }
    luxpipe::parallel::set_threads(0);
    let asked: Option<u64> = arguments.iter().find_map(|a| a.parse().ok());
    if asked.is_none() {
        speed();
    }
    if !arguments.iter().any(|a| a == "speed") {
        quality(asked.unwrap_or(ROOMS));
    }
}

/// Scenes, their samples for ten seconds and more on two processors, and what is allowed over three bands and over 81.
const TIMED: [(&str, u32, [f64; 2]); 4] = [
    ("scenes/cornell.toml", 16, [1.15, 1.0]),
    ("scenes/mesh.toml", 12, [1.15, 1.0]),
    ("benches/plan/metals.toml", 12, [f64::INFINITY, 0.5]),
    ("scenes/fogbox.toml", 6, [f64::INFINITY, 0.5]),
];
const TIMES: usize = 3;

fn speed() {
    println!(
        "| scene | samples | 3 bands, s | --tolerance 1, s | 81 bands, s | over 3 bands | allowed | over 81 | allowed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (scene, samples, allowed) in TIMED {
        let samples_word = format!("--samples={samples}");
        let mut seconds = [const { Vec::new() }; 3];
        // In turn, so that a slow minute is everybody's.
        for _ in 0..TIMES {
            for (seconds, option) in seconds.iter_mut().zip(["--bands=3", "--tolerance=1", "--bands=81"]) {
                let begin = std::time::Instant::now();
                let done = common::run("spectrace", &[scene, option, &samples_word], b"");
                assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
                seconds.push(begin.elapsed().as_secs_f64());
            }
        }
        let [three, plan, bands] = seconds.map(|mut s| {
            s.sort_by(f64::total_cmp);
            s[TIMES / 2]
        });
        println!(
            "| {scene} | {samples} | {three:.2} | {plan:.2} | {bands:.2} | {:.3} | {} | {:.3} | {} |",
            plan / three,
            allowed[0],
            plan / bands,
            allowed[1]
        );
    }
}

fn quality(rooms: u64) {
    println!(
        "| class | tolerance | rooms | within | relative | K = 4 | 8 | 12 | 16 | bands | worst / tolerance | median of it | worst / bound | paths ended by the plan | plan, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for class in scenes::CLASSES {
        for (t, tolerance) in TOLERANCES.into_iter().enumerate() {
            let seeds = (0..rooms).filter(|i| i % 3 == t as u64);
            let seeds: Vec<u64> = seeds.collect();
            for (pilot, what) in [(0, "certificate"), (PILOT, "and pilot")] {
                let one = |i: &u64| judge(&scenes::room(1000 + i, class), tolerance, pilot, 64);
                let all: Vec<Verdict> = seeds.iter().map(one).collect();
                row(&format!("{class:?}, {what}"), tolerance, &all);
            }
        }
    }
}

fn row(class: &str, tolerance: f64, all: &[Verdict]) {
    let few: Vec<&Verdict> = all.iter().filter(|v| v.wavelengths.is_some()).collect();
    let of = |k: Option<usize>| all.iter().filter(|v| v.wavelengths == k).count();
    let within = all.iter().filter(|v| v.worst <= tolerance).count();
    let mut ratios: Vec<f64> = few.iter().map(|v| v.worst / tolerance).collect();
    ratios.sort_by(f64::total_cmp);
    let over = few.iter().map(|v| v.worst / v.bound).fold(0.0, f64::max);
    let seconds = all.iter().map(|v| v.seconds).fold(0.0, f64::max);
    let ended = all.iter().filter(|v| v.depth.is_some()).count();
    let at = |i: usize| ratios.get(i).copied().unwrap_or(0.0);
    println!(
        "| {class} | {tolerance} | {} | {within} | {} | {} | {} | {} | {} | {} | {:.2} | {:.2} | {over:.2} | {ended} | {seconds:.2} |",
        all.len(),
        of(Some(3)),
        of(Some(4)),
        of(Some(8)),
        of(Some(12)),
        of(Some(16)),
        of(None),
        at(ratios.len().saturating_sub(1)),
        at(ratios.len() / 2),
    );
}
