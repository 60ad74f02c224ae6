//! Random rooms rendered by their plans and in 80 bands on the same paths: how often the tolerance holds, how many wavelengths it took,
//! what the plans cost.
//!
//! `make bench-plan` (a few minutes), or `cargo bench --bench plan -- 300` for as many rooms of each class.

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
    let rooms = arguments.iter().find_map(|a| a.parse().ok()).unwrap_or(ROOMS);
    println!(
        "| class | tolerance | rooms | within | K = 4 | 8 | 12 | 16 | bands | worst / tolerance | median of it | worst / bound | plan, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
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
    let at = |i: usize| ratios.get(i).copied().unwrap_or(0.0);
    println!(
        "| {class} | {tolerance} | {} | {within} | {} | {} | {} | {} | {} | {:.2} | {:.2} | {over:.2} | {seconds:.2} |",
        all.len(),
        of(Some(4)),
        of(Some(8)),
        of(Some(12)),
        of(Some(16)),
        of(None),
        at(ratios.len().saturating_sub(1)),
        at(ratios.len() / 2),
    );
}
