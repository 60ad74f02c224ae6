//! Equal input, equal bytes: whatever the threads, from run to run, from a pipe as from a file, in bands of rows, in one process or many,
//! on any instruction set, of any build.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run::{Demands, machine, program, programs, quote, root, row, shell};
use crate::subjects::{self, toml_text};

/// Runs all of it and prints a table.
pub fn section(demands: &mut Demands) -> std::io::Result<()> {
    println!("## Determinism\n\n{}\n\n| what | compared | differ |\n|---|---|---|", machine());
    let folder = tempfile::tempdir()?;
    subjects::prepare(folder.path(), 100)?;
    row("every program on 1, 2, 3 and 7 threads, and again", demands, |d| threads(folder.path(), d))?;
    row("every picture filter from a pipe, and kept in a file", demands, |d| piped(folder.path(), d))?;
    row("every method of rendering on 1, 2 and 3 threads", demands, |d| methods(folder.path(), d))?;
    row("bands of rows, joined", demands, |d| bands(folder.path(), d))?;
    row("pipelines: in one process, by the shell, by make, in four parts", demands, |d| fused(folder.path(), d))?;
    let here = String::from_utf8_lossy(&shell("luxpipe doctor", folder.path())?.stdout).into_owned();
    let here =
        here.lines().find_map(|l| l.strip_prefix("processors").map(|l| l.trim().to_string())).unwrap_or_default();
    let what = format!("every program and method without AVX, with AVX2, with all there is ({here})");
    row(&what, demands, |d| widths(folder.path(), d))?;
    let what = format!("the same with a C library without AVX2 and FMA, within {ROUNDING}");
    row(&what, demands, |d| libraries(folder.path(), d))?;
    match other_build() {
        Some(debug) => row("every filter of a debug build", demands, |d| builds(folder.path(), &debug, d)),
        None => {
            println!("| every filter of a debug build | skipped: `cargo build` makes one | |");
            Ok(())
        }
    }
}

/// Runs commands that each leave the file `result`; all are equal to the first.
fn equal(what: &str, commands: &[String], folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut first: Option<Vec<u8>> = None;
    for command in commands {
        let _ = fs::remove_file(folder.join("result"));
        let ended = shell(command, folder)?;
        let bytes = fs::read(folder.join("result")).unwrap_or_default();
        if ended.status != 0 || bytes.is_empty() {
            demands.broken(&format!("{what}: status {}: {}", ended.status, ended.stderr.trim()), command);
        } else if first.as_ref().is_some_and(|f| *f != bytes) {
            demands.broken(&format!("{what}: other bytes"), &format!("{command}\nunlike\n{}", commands[0]));
        }
        first.get_or_insert(bytes);
    }
    Ok(commands.len().saturating_sub(1))
}

fn threads(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut compared = 0;
    for s in subjects::all().iter().filter(|s| s.streams) {
        let work = s.command(s.input, "result", folder)?;
        let commands: Vec<String> = [1, 2, 3, 7, 2].iter().map(|n| format!("{work} --quiet --threads {n}")).collect();
        compared += equal(s.program, &commands, folder, demands)?;
    }
    Ok(compared)
}

fn piped(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut compared = 0;
    for s in subjects::all().iter().filter(|s| s.input.ends_with(".lux") && !s.pipeline) {
        let input = if s.program == "pplot" { "/dev/stdin" } else { "-" };
        let (file, pipe) = (s.command(s.input, "result", folder)?, s.command(input, "result", folder)?);
        let stdout = s.command(s.input, "-", folder)?;
        let commands = [
            format!("{file} --quiet"),
            format!("cat {} | {pipe} --quiet", s.input),
            format!("cat {} | {pipe} --quiet --memory 1k", s.input),
            format!("{stdout} --quiet > result"),
        ];
        // What is held as a whole is refused beyond --memory by those that say so.
        let held = ["falsecolor", "plocal", "pglare"].contains(&s.program);
        let commands: Vec<String> = commands.into_iter().filter(|c| !held || !c.contains("--memory")).collect();
        compared += equal(&format!("{} from a pipe", s.program), &commands, folder, demands)?;
    }
    Ok(compared)
}

/// Options of each way to render, small.
const METHODS: [&str; 10] = [
    "--method path",
    "--method path --error 0.1",
    "--method local",
    "--method radiosity --divide 2",
    "--method radiosity --divide 2 --show gather",
    "--method photon --photons 5000",
    "--method photon --photons 5000 --show gather",
    "--tolerance 1",
    "--quantity spectrum",
    "--per-light",
];

/// Renderings by every method, without the file that they write: options in front, what to render behind.
fn works() -> Vec<String> {
    let (fog, skin) = (root().join("scenes/fogbox.toml"), root().join("scenes/fluorescence.toml"));
    let mut works: Vec<String> = METHODS.iter().map(|m| format!("{m} --width 32 scene.toml")).collect();
    for method in ["path", "march", "zonal --zones 4", "photon --photons 3000"] {
        works.push(format!("--method {method} --width 24 {}", fog.display()));
    }
    works.push(format!("--width 24 {}", skin.display()));
    let whole = |work: String| {
        // A plan has wavelengths of its own, an error needs paths to be told from.
        let samples = if work.contains("--error") { 64 } else { 4 };
        let bands = if work.contains("--tolerance") { "" } else { "--bands 8 " };
        format!("spectrace --quiet --samples {samples} {bands}{work} result")
    };
    works.into_iter().map(whole).collect()
}

fn methods(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut compared = 0;
    for work in works() {
        let commands = [1, 2, 3].map(|n| format!("{work} --threads {n}"));
        compared += equal(&work, &commands, folder, demands)?;
    }
    Ok(compared)
}

/// A work of every method and every program.
fn everything(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut all = works();
    for s in subjects::all().iter().filter(|s| s.streams) {
        all.push(format!("{} --quiet", s.command(s.input, "result", folder)?));
    }
    Ok(all)
}

/// What each instruction set makes of the same work: see src/simd.rs.
fn widths(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut compared = 0;
    for work in everything(folder)? {
        let commands = ["widest", "avx2", "plain"].map(|set| format!("LUXPIPE_SIMD={set} {work}"));
        compared += equal(&work, &commands, folder, demands)?;
    }
    Ok(compared)
}

/// Part of a value that another C library may leave.
const ROUNDING: f32 = 1e-6;

/// What comes of it all where the C library, which chooses for itself by the processor, has no AVX2 and FMA: its exp and pow differ in
/// the last bit of a double.
fn libraries(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let all = everything(folder)?;
    for work in &all {
        let result = |variables: &str| -> std::io::Result<Vec<u8>> {
            let _ = fs::remove_file(folder.join("result"));
            shell(&format!("{variables} {work}"), folder)?;
            Ok(fs::read(folder.join("result")).unwrap_or_default())
        };
        let here = result("")?;
        let command = "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 LUXPIPE_SIMD=plain";
        let there = result(command)?;
        if here.is_empty() || !near(&here, &there) {
            demands.broken(&format!("{work}: beyond {ROUNDING} of other numbers"), &format!("{command} {work}"));
        }
    }
    Ok(all.len())
}

/// Equal bytes, or streams of floats with one header whose values lie within [`ROUNDING`] of each other.
fn near(a: &[u8], b: &[u8]) -> bool {
    let floats = |bytes: &[u8]| -> Option<(Vec<u8>, Vec<f32>)> {
        let head = bytes.windows(2).position(|w| w == b"\n\n")? + 2;
        let head = head + bytes[head..].iter().position(|c| *c == b'\n')? + 1;
        let values = bytes[head..].as_chunks::<4>().0.iter().map(|c| f32::from_le_bytes(*c)).collect();
        bytes[..head].windows(12).any(|w| w == b"FORMAT=float").then(|| (bytes[..head].to_vec(), values))
    };
    let within = |x: &f32, y: &f32| (x - y).abs() <= ROUNDING * x.abs();
    let alike = || {
        let ((head, values), (other, others)) = floats(a).zip(floats(b))?;
        Some(head == other && values.len() == others.len() && values.iter().zip(&others).all(|(x, y)| within(x, y)))
    };
    a == b || alike() == Some(true)
}

/// The folder of a debug build beside this one, if it is not older than the sources.
fn other_build() -> Option<PathBuf> {
    let folder = programs().parent()?.join("debug");
    let built = fs::metadata(folder.join("luxpipe")).ok()?.modified().ok()?;
    let all = glob::glob(&root().join("src/**/*.rs").display().to_string()).ok()?;
    let newer = |file: PathBuf| fs::metadata(file).and_then(|m| m.modified()).is_ok_and(|t| t > built);
    (!all.flatten().any(newer)).then_some(folder)
}

/// What a debug build makes of the same work; renderers are equal within a build only.
fn builds(folder: &Path, debug: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    const RENDERERS: [&str; 3] = ["spectrace", "specplan", "tradeoff"];
    let mut compared = 0;
    for s in subjects::all().iter().filter(|s| s.streams && !RENDERERS.contains(&s.program)) {
        let work = format!("{} --quiet", s.command(s.input, "result", folder)?);
        let there = work.replacen(
            &quote(&program(s.program).display().to_string()),
            &quote(&debug.join(s.program).display().to_string()),
            1,
        );
        compared += equal(&format!("{} of a debug build", s.program), &[work, there], folder, demands)?;
    }
    Ok(compared)
}

fn bands(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let mut compared = 0;
    for work in [
        "scene.toml",
        "--method photon --photons 2000 scene.toml",
        "--method radiosity --divide 2 scene.toml",
        "--per-light scene.toml",
        "--quantity spectrum scene.toml",
    ] {
        let render = format!("spectrace --quiet --width 30 --height 31 --samples 4 --bands 8 {work}");
        let split = |at: &[usize]| {
            let ends: Vec<usize> = [&[0], at, &[31]].concat();
            let parts: Vec<String> =
                ends.windows(2).map(|w| format!("{render} b{}.lux --rows {}:{}", w[0], w[0], w[1])).collect();
            let names: Vec<String> = ends[..ends.len() - 1].iter().map(|e| format!("b{e}.lux")).collect();
            format!("{} && pjoin {} -o result", parts.join(" && "), names.join(" "))
        };
        let commands = [format!("{render} result"), split(&[16]), split(&[1, 2, 30]), split(&[7, 13, 20, 29])];
        compared += equal(&format!("rows of {work}"), &commands, folder, demands)?;
    }
    Ok(compared)
}

fn fused(folder: &Path, demands: &mut Demands) -> std::io::Result<usize> {
    let render = |rest: &str| {
        format!("[[stage]]\nrun = \"spectrace\"\nscene = \"scene.toml\"\nwidth = 33\nsamples = 4\nbands = 8\n{rest}")
    };
    let stage = |name: &str, keys: &str| format!("[[stage]]\nrun = \"{name}\"\n{keys}");
    let result = format!("output = {}\n", toml_text("result"));
    let read = "[[stage]]\nrun = \"vonkries\"\nfrom = \"A\"\ninput = \"xyz.lux\"\n";
    let files = [
        render("")
            + &stage("vonkries", "")
            + &stage("pcond", "")
            + &stage("xyz2rgb", "gamut = \"desaturate\"\n")
            + &stage("ra_png", &result),
        render("save = \"master.exr\"\n") + &stage("vonkries", "to = \"D50\"\n") + &stage("ra_loglv", &result),
        read.to_string()
            + &stage("pcond", "human = true\n")
            + &stage("xyz2rgb", "gamut = \"compress\"\n")
            + &stage("ra_png", &("bits = 16\n".to_string() + &result)),
        read.to_string()
            + &stage("plocal", "")
            + &stage("xyz2rgb", "")
            + &stage("ra_png", &("dither = true\n".to_string() + &result)),
        read.to_string() + &stage("ra_exr", &("compression = \"piz\"\n".to_string() + &result)),
        read.to_string() + &stage("falsecolor", "log = 3\n") + &stage("ra_png", &result),
        read.to_string() + &stage("spec2xyz", "") + &stage("ra_rgbe", &result),
        render("") + &stage("ra_pixlog", &result),
    ];
    let mut compared = 0;
    for (i, text) in files.iter().enumerate() {
        fs::write(folder.join("fused.toml"), text)?;
        let parts = if text.contains("spectrace") { "--parts 4" } else { "" };
        let commands = [
            "luxpipe --quiet fused.toml".to_string(),
            "luxpipe --quiet --threads 1 fused.toml".into(),
            "luxpipe --quiet --threads 3 fused.toml".into(),
            "luxpipe --shell fused.toml > line && sh -e line 2> /dev/null".into(),
            format!("luxpipe --make {parts} fused.toml > fused.mk && make -s -j2 -f fused.mk 2> /dev/null"),
        ];
        compared += equal(&format!("pipeline {i}"), &commands, folder, demands)?;
    }
    Ok(compared)
}
