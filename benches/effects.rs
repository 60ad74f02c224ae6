//! What effects beyond Eq. (1) cost: the same scene with one and without it, in turns, CPU seconds; and what scenes without any cost
//! beside an earlier build.
//!
//! `make bench-effects`. With EFFECTS_BEFORE=PROGRAM, an earlier spectrace, scenes without effects are counted by both: by
//! instructions where valgrind is there, else by time.

#[allow(dead_code)]
#[path = "beside/mod.rs"]
mod beside;

use std::fs;
use std::path::Path;
use std::process::Command;

use beside::{Shell, median, processor};

/// Turns that ratios are medians of.
const TURNS: usize = 7;

fn main() -> std::io::Result<()> {
    if !std::env::args().any(|a| a == "--bench") {
        println!("the bench of effects takes minutes: make bench-effects");
        return Ok(());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shell = Shell::new()?;
    let folder = shell.folder.path();
    println!("{}\n\n{:<66} {:>8} {:>8}", processor(), "", "ratio", "wanted");
    let scene = |name: &str, change: &dyn Fn(String) -> String| -> std::io::Result<String> {
        let text = fs::read_to_string(root.join("scenes").join(name))?;
        let to = folder.join(format!("{}-{name}", fs::read_dir(folder)?.count()));
        fs::write(&to, change(text))?;
        Ok(to.display().to_string())
    };
    let row = |what: &str, bound: f64, with: (String, &str), without: (String, &str)| {
        let run = |(file, options): &(String, &str)| {
            shell.run(&format!("spectrace --quiet {options} {file}")).map_or(f64::NAN, |t| t.0)
        };
        let ratios: Vec<f64> = (0..TURNS).map(|_| run(&with) / run(&without)).collect();
        let ratio = median(ratios);
        let verdict = if ratio <= bound { "" } else { "  NOT" };
        println!("{what:<66} {ratio:>8.2} {bound:>8.2}{verdict}");
    };
    let polarised = |on: bool| move |text: String| format!("polarization = {on}\n{text}");
    for name in ["materials.toml", "brewster.toml"] {
        let (with, without) = (scene(name, &polarised(true))?, scene(name, &polarised(false))?);
        let what = format!("polarised over not: {name}, 80 bands");
        row(&what, 2.5, (with, "--samples 8"), (without, "--samples 8"));
    }
    // The Cornell box with white walls that fluoresce, over the same without a dye.
    let dye = "type = \"fluorescent\"\nreflectance = 0.7\nabsorption = [[300, 0.25], [450, 0.25], [480, 0]]\nemission = [[440, 0], [500, 1], [600, 0]]";
    let white = |with: &'static str| move |text: String| text.replace("reflectance = \"cornell_white\"", with);
    for (bands, bound) in [(40, 1.5), (96, f64::INFINITY)] {
        let options: &str = if bands == 40 {
            "--samples 16 --width 256 --bands 40 --range 300:780"
        } else {
            "--samples 16 --width 256 --bands 96 --range 300:780"
        };
        let (with, without) =
            (scene("cornell.toml", &white(dye))?, scene("cornell.toml", &white("reflectance = 0.7"))?);
        row(&format!("fluorescent over not: Cornell box, {bands} bands"), bound, (with, options), (without, options));
    }
    // Through a prism whose index is the same at all wavelengths.
    let same = |text: String| text.replace("index = \"glass_SF10_n\"", "index = 1.73");
    let (with, without) = (scene("prism.toml", &|t| t)?, scene("prism.toml", &same)?);
    row(
        "dispersive over not: scenes/prism.toml, 80 bands",
        f64::INFINITY,
        (with, "--samples 16"),
        (without, "--samples 16"),
    );
    before(root, &shell);
    Ok(())
}

/// Scenes without effects, by this build and an earlier one.
fn before(root: &Path, shell: &Shell) {
    let Ok(earlier) = std::env::var("EFFECTS_BEFORE") else {
        println!("scenes without effects: EFFECTS_BEFORE names no earlier spectrace");
        return;
    };
    let now = shell.bin.join("spectrace").display().to_string();
    for name in ["cornell.toml", "colorchecker.toml", "materials.toml"] {
        let command = |program: &str| {
            format!(
                "{program} --quiet --threads 1 --samples 16 --width 48 {}",
                root.join("scenes").join(name).display()
            )
        };
        let counted = |program: &str| instructions(&command(program));
        let (how, ratio) = match (counted(&now), counted(&earlier)) {
            (Some(a), Some(b)) => ("instructions", a / b),
            _ => {
                let time = |program: &str| shell.run(&command(program)).map_or(f64::NAN, |t| t.0);
                ("time", median((0..3 * TURNS).map(|_| time(&now) / time(&earlier))))
            }
        };
        let verdict = if ratio <= 1.02 { "" } else { "  NOT" };
        println!(
            "{:<66} {ratio:>8.3} {:>8.2}{verdict}",
            format!("no effects, this build over the earlier, {how}: {name}"),
            1.02
        );
    }
}

/// Instructions of a command by valgrind.
fn instructions(command: &str) -> Option<f64> {
    let line = format!("valgrind --tool=callgrind --callgrind-out-file=/dev/null {command} 2>&1 >/dev/null");
    let output = Command::new("bash").args(["-c", &line]).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let collected = text.lines().find_map(|l| l.split("Collected : ").nth(1))?;
    collected.trim().parse().ok()
}
