//! pcond beside Radiance's in the same run: CPU seconds of one thread on a 4096 x 2048 picture and on a 180-degree fisheye of
//! 1024 x 1024, and memory at two heights.
//!
//! The peer is `pcond` in the folder RADIANCE_BIN (pip's pyradiance has it in pyradiance/bin); it needs `pfilt` beside it.

mod beside;
mod peak;
mod picture;

use std::process::Command;

use beside::{Row, Shell, compare, processor};

const WIDTH: usize = 4096;
const HEIGHT: usize = 2048;
const FISHEYE: usize = 1024;
const RUNS: usize = 7;

fn main() -> std::io::Result<()> {
    // `cargo test --benches` runs this too; one run then shows that it works.
    let runs = if std::env::args().any(|a| a == "--bench") { RUNS } else { 1 };
    let shell = Shell::new()?;
    let (dir, bin) = (shell.folder.path(), &shell.bin);
    // By its whole path: ours has the same name.
    let radiance = std::env::var("RADIANCE_BIN").unwrap_or_default();
    picture::write(&dir.join("big.lux"), WIDTH, HEIGHT)?;
    picture::write(&dir.join("tall.lux"), WIDTH, 4 * HEIGHT)?;
    picture::write(&dir.join("square.lux"), FISHEYE, FISHEYE)?;
    for command in [
        "xyz2rgb --quiet --to Radiance big.lux rgb.lux",
        "ra_rgbe --quiet rgb.lux big.hdr",
        "xyz2rgb --quiet --to Radiance square.lux rgb.lux",
        "ra_rgbe --quiet rgb.lux square.hdr",
        "{ printf '#?RADIANCE\\nVIEW= -vta -vh 180 -vv 180\\n'; tail -n +2 square.hdr; } > fisheye.hdr",
    ] {
        let done = Command::new("bash").args(["-c", command]).current_dir(dir).env("PATH", &shell.path).status()?;
        assert!(done.success(), "{command}");
    }
    println!("one thread, medians of {runs}; {}", processor());
    println!("{:<18} {:>8} {:>8} {:>9} {:>7} {:>6}  peer", "", "CPU s", "Mpix/s", "peer CPU", "ratio", "bound");
    let rows = [
        ("pcond", "", "big.hdr", 10.0),
        ("pcond -s", "-s", "big.hdr", 10.0),
        ("pcond -l", "-l", "big.hdr", f64::NAN),
        ("pcond -h", "-h", "big.hdr", 10.0),
        ("fisheye -v", "-v", "fisheye.hdr", 50.0),
    ];
    for (what, options, file, bound) in rows {
        let pixels = if file == "big.hdr" { WIDTH * HEIGHT } else { FISHEYE * FISHEYE } as f64;
        let ours = format!("pcond --threads 1 --quiet {options} {file}");
        let peer = if radiance.is_empty() { String::new() } else { format!("{}/pcond {options} {file}", radiance) };
        let runs = if what.starts_with("fish") { runs.min(3) } else { runs };
        compare(&shell, &Row { what, ours, peer, bound, pixels }, runs);
    }
    for (what, options) in
        [("--print", "--print"), ("--goal colour", "--goal colour"), ("--goal visibility", "--goal visibility")]
    {
        let ours = format!("pcond --threads 1 --quiet {options} big.hdr");
        let row = Row { what, ours, peer: String::new(), bound: f64::NAN, pixels: (WIDTH * HEIGHT) as f64 };
        compare(&shell, &row, runs);
    }
    for method in ["base-detail", "retinex"] {
        let ours = format!("plocal --threads 1 --quiet --method {method} big.lux");
        let what = if method == "retinex" { "plocal retinex" } else { "plocal" };
        compare(
            &shell,
            &Row { what, ours, peer: String::new(), bound: f64::NAN, pixels: (WIDTH * HEIGHT) as f64 },
            runs,
        );
    }
    println!("\n{:<40} {:>10} {:>10}", "peak memory, MB", "2048 rows", "8192 rows");
    for options in ["", "-h"] {
        let peak = |input: &str| {
            let mut program = Command::new(bin.join("pcond"));
            let words = options.split_ascii_whitespace();
            peak::peak_mb(program.arg("--quiet").args(words).args([input, "out"]).current_dir(dir))
        };
        println!("pcond {options:<34} {:>10.1} {:>10.1}", peak("big.lux")?, peak("tall.lux")?);
    }
    Ok(())
}
