//! Filters against `cat` on a 4096 x 2048 XYZ stream: wall time as a ratio in the same run, and peak memory.
//!
//! `cat file | cat > /dev/null` is the speed of the pipe itself. Pairs of runs alternate, so that a machine whose speed
//! drifts slows both; the median ratio counts.

mod peak;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const WIDTH: usize = 4096;
const HEIGHT: usize = 2048;
const PAIRS: usize = 15;

/// Five row-wise filters, as a pipe and as a pipeline.
const PIPE: &str = "vonkries FILE | xyz2rgb --gamut desaturate | xyz2rgb --reverse | vonkries --to D50 | ra_rgbe";
const CHAIN: &str = r#"
[[stage]]
run = "vonkries"
input = "FILE"
[[stage]]
run = "xyz2rgb"
gamut = "desaturate"
[[stage]]
run = "xyz2rgb"
reverse = true
[[stage]]
run = "vonkries"
to = "D50"
[[stage]]
run = "ra_rgbe"
"#;

fn main() -> std::io::Result<()> {
    // `cargo test --benches` runs this too; one pair then shows that it works.
    let pairs = if std::env::args().any(|a| a == "--bench") { PAIRS } else { 1 };
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("big.lux");
    write_stream(&file)?;
    let tall = folder.path().join("tall.lux");
    write_tall(&tall)?;
    let bin = Path::new(env!("CARGO_BIN_EXE_vonkries")).parent().expect("a program lies in a folder").to_path_buf();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    println!("{WIDTH} x {HEIGHT} float XYZ, {:.1} MB; {}, {threads} processors", megabytes(&file), processor());
    println!("{:<58} {:>8} {:>8} {:>8}", "command", "ms", "ratio", "bound");
    let big = file.display();
    let spectrum = folder.path().join("spectrum.lux");
    write_spectrum(&spectrum)?;
    let rows: [(String, f64); 11] = [
        (format!("vonkries {big}"), 2.0),
        (format!("xyz2rgb {big}"), 2.0),
        (format!("xyz2rgb --gamut desaturate {big}"), 2.0),
        (format!("vonkries --threads 1 {big}"), 2.0),
        (format!("xyz2rgb --threads 1 --gamut desaturate {big}"), 2.0),
        (format!("spec2xyz --threads 1 {}", spectrum.display()), 2.0),
        (format!("xyz2rgb --gamut compress --reach visible {big}"), f64::NAN),
        (format!("xyz2rgb --gamut shrink {big}"), f64::NAN),
        (format!("cat {big} | vonkries | cat"), 3.0),
        (format!("cat {big} | xyz2rgb --gamut desaturate | cat"), 3.0),
        (format!("pcond {big}"), f64::NAN),
    ];
    let base = format!("cat {big} | cat");
    for (command, bound) in rows {
        let spectral = command.contains("spectrum.lux");
        let base = if spectral { format!("cat {0} | cat", spectrum.display()) } else { base.clone() };
        let (time, ratio) = paired(&command, &base, if spectral { pairs.min(5) } else { pairs }, &path)?;
        let shown =
            command.replace(&format!("{big}"), "FILE").replace(&format!("{}", spectrum.display()), "20-BAND FILE");
        println!("{shown:<58} {:>8.1} {ratio:>8.2} {bound:>8}", time.as_secs_f64() * 1e3);
    }
    let chain = folder.path().join("chain.toml");
    fs::write(&chain, CHAIN.replace("FILE", &format!("{big}")))?;
    let chain = format!("luxpipe {}", chain.display());
    let (time, ratio) = paired(&chain, &PIPE.replace("FILE", &format!("{big}")), pairs, &path)?;
    println!(
        "{:<58} {:>8.1} {ratio:>8.2} {:>8}",
        "luxpipe, those five in one process (to the pipe)",
        time.as_secs_f64() * 1e3,
        0.6
    );
    println!("    {PIPE}");
    println!("{:<58} {:>8} {:>8}", "peak memory, MB", "all", "beyond");
    for name in ["vonkries", "xyz2rgb", "pcond"] {
        let program = bin.join(name);
        let alone = peak::peak_mb(Command::new(&program).arg("--version"))?;
        for (what, input) in [("2048 rows", &file), ("8192 rows", &tall)] {
            let all = peak::peak_mb(Command::new(&program).arg(input))?;
            println!("{:<58} {all:>8.1} {:>8.1}", format!("{name}, {what}"), all - alone);
        }
    }
    Ok(())
}

fn write_stream(path: &Path) -> std::io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(&header(HEIGHT))?;
    // A repeatable mixture of 7 decades of luminance and colours in and out of BT.709.
    let mut state = 1u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..WIDTH * HEIGHT {
        let y = (16.0 * random() - 7.0).exp();
        for value in [y * (0.6 + 0.8 * random()), y, y * 2.0 * random()] {
            out.write_all(&value.to_ne_bytes())?;
        }
    }
    out.flush()
}

/// 20 bands of the same size: 671 MB, a sparse file of zeros.
fn write_spectrum(path: &Path) -> std::io::Result<()> {
    let mut out = File::create(path)?;
    let lines = "#?RADIANCE\nNCOMP=20\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTH_SPLITS= 780 588 480 380\n\
        BigEndian=0\nFORMAT=float";
    let header = format!("{lines}\n\n-Y {HEIGHT:8} +X {WIDTH:8}\n");
    out.write_all(header.as_bytes())?;
    out.set_len((header.len() + HEIGHT * WIDTH * 20 * 4) as u64)
}

/// Four times the height, without taking the disk for it.
fn write_tall(path: &Path) -> std::io::Result<()> {
    let mut out = File::create(path)?;
    let header = header(4 * HEIGHT);
    out.write_all(&header)?;
    out.set_len((header.len() + 4 * HEIGHT * WIDTH * 12) as u64)
}

fn header(height: usize) -> Vec<u8> {
    let lines = "#?RADIANCE\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.4476 0.4074\nVIEW= -vtv -vh 60 -vv 32\n\
        PRIMARIES= 1 0 0 1 0 0 .333 .333\nBigEndian=0\nFORMAT=float";
    let tail = format!("\n\n-Y {height:8} +X {WIDTH:8}\n");
    let pad = (lines.len() + tail.len()).next_multiple_of(4) - lines.len() - tail.len();
    format!("{lines}{}{tail}", " ".repeat(pad)).into_bytes()
}

fn shell(command: &str, path: &str) -> std::io::Result<Duration> {
    let start = Instant::now();
    let line = format!("{command} > /dev/null");
    let status = Command::new("sh").args(["-c", &line]).env("PATH", path).stderr(Stdio::null()).status()?;
    assert!(status.success(), "{command}");
    Ok(start.elapsed())
}

/// Median time of `a`, and median of its ratio to `b`, run in turn.
fn paired(a: &str, b: &str, pairs: usize, path: &str) -> std::io::Result<(Duration, f64)> {
    shell(a, path)?;
    shell(b, path)?;
    let (mut times, mut ratios) = (Vec::new(), Vec::new());
    for _ in 0..pairs {
        let (ta, tb) = (shell(a, path)?, shell(b, path)?);
        times.push(ta);
        ratios.push(ta.as_secs_f64() / tb.as_secs_f64());
    }
    times.sort();
    ratios.sort_by(f64::total_cmp);
    Ok((times[pairs / 2], ratios[pairs / 2]))
}

fn megabytes(path: &Path) -> f64 {
    fs::metadata(path).map_or(0.0, |m| m.len() as f64 / 1e6)
}

fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("unknown processor");
    name.trim_start_matches([' ', '\t', ':']).to_string()
}
