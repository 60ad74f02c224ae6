//! The encodings on one 4096 x 2048 picture: CPU seconds of one thread beside Radiance's and libtiff's programs in the same
//! run, where they are found; what two threads gain; peak memory at two heights.
//!
//! Peers: `ra_xyze` and `ra_tiff` on the path or in the folder RADIANCE_BIN (pip's pyradiance has them in pyradiance/bin), and
//! `tiffcp` of Debian's libtiff-tools (which only packs ready 16-bit words, without logarithms). `bash` takes the times.

mod beside;
mod peak;
mod picture;

use std::process::Command;

use beside::{Row, Shell, compare, median, processor, ratio};

const WIDTH: usize = 4096;
const HEIGHT: usize = 2048;
const RUNS: usize = 11;

fn main() -> std::io::Result<()> {
    // `cargo test --benches` runs this too; one run then shows that it works.
    let runs = if std::env::args().any(|a| a == "--bench") { RUNS } else { 1 };
    let shell = Shell::new()?;
    let (dir, bin) = (shell.folder.path(), &shell.bin);
    picture::write(&dir.join("big.lux"), WIDTH, HEIGHT)?;
    picture::write(&dir.join("tall.lux"), WIDTH, 4 * HEIGHT)?;
    for command in [
        "xyz2rgb --quiet --to Radiance big.lux rgb.lux",
        "ra_rgbe --quiet rgb.lux big.hdr",
        "ra_loglv big.lux big.tif",
        "ra_loglv --quiet --bits24 big.lux big24.tif",
    ] {
        assert!(shell.run(command).is_some(), "{command}");
    }
    println!("{WIDTH} x {HEIGHT}, one thread, medians of {runs}; {}", processor());
    println!("{:<18} {:>8} {:>8} {:>9} {:>7} {:>6}  peer", "", "CPU s", "Mpix/s", "peer CPU", "ratio", "bound");
    shell.run("tiffcp -c none big.tif plain.tif");
    for row in rows() {
        compare(&shell, &row, runs);
    }
    println!("\n{:<18} {:>8} {:>8} {:>9} {:>6}", "two threads", "1: s", "2: s", "gain", "bound");
    for (what, command) in [
        ("RGBE decode", "ra_rgbe -r big.hdr"),
        ("RGBE encode", "ra_rgbe --quiet rgb.lux"),
        ("LogLuv32 decode", "ra_loglv -r big.tif"),
        ("LogLuv32 encode", "ra_loglv big.lux out.tif"),
        ("LogLuv24 encode", "ra_loglv --quiet --bits24 --stonits 64 big.lux out.tif"),
        ("Pixar log encode", "ra_pixlog --quiet --stonits 64 big.lux out.tif"),
        ("EXR half encode", "ra_exr --quiet --half --white-luminance 1 big.lux out.exr"),
    ] {
        gain(&shell, what, command, runs);
    }
    println!("\n{:<40} {:>10} {:>10}", "peak memory, MB", "2048 rows", "8192 rows");
    for command in
        ["ra_rgbe", "ra_loglv", "ra_loglv --bits24 --stonits 64", "ra_pixlog --stonits 64", "ra_pfm", "ra_exr --float"]
    {
        let words: Vec<&str> = command.split(' ').collect();
        let peak = |input: &str| {
            let mut program = Command::new(bin.join(words[0]));
            peak::peak_mb(program.args(&words[1..]).args([input, "out"]).current_dir(dir))
        };
        println!("{command:<40} {:>10.1} {:>10.1}", peak("big.lux")?, peak("tall.lux")?);
    }
    Ok(())
}

fn rows() -> Vec<Row> {
    let row = |what, ours: &str, peer: &str, bound| Row {
        what,
        ours: ours.into(),
        peer: peer.into(),
        bound,
        pixels: (WIDTH * HEIGHT) as f64,
    };
    vec![
        row("RGBE decode", "ra_rgbe --threads 1 -r big.hdr", "ra_xyze big.hdr", 8.0),
        row("RGBE encode", "ra_rgbe --threads 1 --quiet rgb.lux", "ra_xyze big.hdr", 4.0),
        row("LogLuv32 encode", "ra_loglv --threads 1 big.lux out.tif", "ra_tiff -L big.hdr peer.tif", 5.0),
        row("LogLuv32 decode", "ra_loglv --threads 1 -r big.tif", "ra_tiff -r big.tif /dev/null", 5.0),
        row("LogLuv32 encode", "ra_loglv --threads 1 big.lux out.tif", "tiffcp -c sgilog plain.tif peer.tif", f64::NAN),
        row("LogLuv32 decode", "ra_loglv --threads 1 -r big.tif", "tiffcp -c none big.tif peer.tif", f64::NAN),
        row(
            "LogLuv24 encode",
            "ra_loglv --threads 1 --quiet --bits24 big.lux out.tif",
            "ra_tiff -l big.hdr peer.tif",
            4.0,
        ),
        row("LogLuv24 decode", "ra_loglv --threads 1 -r big24.tif", "ra_tiff -r big24.tif /dev/null", f64::NAN),
        row("Pixar log encode", "ra_pixlog --threads 1 --quiet --stonits 64 big.lux out.tif", "", f64::NAN),
        row("EXR half encode", "ra_exr --threads 1 --quiet --half --white-luminance 1 big.lux out.exr", "", f64::NAN),
    ]
}

fn gain(shell: &Shell, what: &str, command: &str, runs: usize) {
    let with = |threads: u32| {
        let (name, rest) = command.split_once(' ').unwrap_or((command, ""));
        shell.run(&format!("{name} --threads {threads} {rest}")).map(|t| t.1)
    };
    let (mut one, mut two) = (Vec::new(), Vec::new());
    for _ in 0..runs {
        one.extend(with(1));
        two.extend(with(2));
    }
    let gain = ratio(&one, &two);
    println!("{what:<18} {:>8.3} {:>8.3} {gain:>9.2} {:>6}", median(one), median(two), 1.7);
}
