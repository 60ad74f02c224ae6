//! Loads: a picture of a gigapixel through a pipe, 10,000 frames in one batch, 200 pipelines at once, 10 million triangles. Peaks are
//! VmHWM of each process, asked for every 20 ms; their sum is more than was ever held at a time.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use crate::run::{Choice, Demands, Peaks, machine, shell};
use crate::subjects;

/// Runs all of it, or one by `--only gigapixel`, `frames`, `at-once` or `triangles`; with `--small` a 64th, in seconds.
pub fn section(choice: &Choice, demands: &mut Demands) -> std::io::Result<()> {
    println!("## Load\n\n{}{}\n", machine(), if choice.small { "; a 64th of the load" } else { "" });
    println!("| load | seconds | memory | demanded | besides |\n|---|---|---|---|---|");
    let folder = tempfile::tempdir_in("/var/tmp")?;
    let part = if choice.small { 8 } else { 1 };
    let wanted = |name: &str| choice.only.as_deref().is_none_or(|only| only == name);
    if wanted("gigapixel") {
        gigapixel(32_768 / part, folder.path(), demands)?;
    }
    if wanted("frames") {
        frames(if choice.small { 1_000 } else { 10_000 }, folder.path(), demands)?;
    }
    if wanted("at-once") {
        at_once(if choice.small { 25 } else { 200 }, folder.path(), demands)?;
    }
    if wanted("triangles") {
        triangles(if choice.small { 280 } else { 2237 }, folder.path(), demands)?;
    }
    Ok(())
}

/// A square of RGBE in runs: by component where a scanline may be coded so, in Radiance's older way from 32768 pixels on.
fn write_rgbe(path: &Path, width: usize, height: usize) -> std::io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    write!(out, "#?RADIANCE\nWHITE= 0.4476 0.4074\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n")?;
    let mut line = Vec::new();
    for y in 0..height {
        line.clear();
        let coded = (8..=0x7fff).contains(&width);
        if coded {
            line.extend([2, 2, (width >> 8) as u8, width as u8]);
        }
        // Mantissas by the place, exponents over nine decades from the top to the bottom.
        let exponent = 113 + (30 * y / height) as u8;
        let value =
            |c: usize, x: usize| if c == 3 { exponent } else { 128 + ((x / 127 * (3 + c) + y / 64) % 120) as u8 };
        if coded {
            for c in 0..4 {
                for x in (0..width).step_by(127) {
                    line.extend([128 + (width - x).min(127) as u8, value(c, x)]);
                }
            }
        } else {
            for x in (0..width).step_by(127) {
                line.extend([0, 1, 2, 3].map(|c| value(c, x)));
                line.extend(
                    Some([1, 1, 1, ((width - x).min(127) - 1) as u8]).filter(|r| r[3] > 0).into_iter().flatten(),
                );
            }
        }
        out.write_all(&line)?;
    }
    out.flush()
}

/// `vonkries | pcond | xyz2rgb | ra_png`. The picture that pcond keeps is a file of /var/tmp without a name.
fn gigapixel(side: usize, folder: &Path, demands: &mut Demands) -> std::io::Result<()> {
    let input = folder.join("large.hdr");
    write_rgbe(&input, side, side)?;
    // So that a 64th is kept in a file too.
    let memory = side * side / 4;
    let pipe = format!(
        "vonkries {} | pcond --memory {memory} --tmp {} | xyz2rgb --gamut desaturate | ra_png - large.png",
        input.display(),
        folder.display()
    );
    let before = used(folder);
    let mut spool = 0f64;
    let peaks = Peaks::of(&pipe, folder, |_| spool = spool.max(used(folder) - before))?;
    let (stream, png) =
        (12.0 * (side * side) as f64 / 1e6, fs::metadata(folder.join("large.png")).map_or(0, |m| m.len()));
    let told = peaks.ended.stderr.lines().find(|l| l.contains("spooled")).unwrap_or("no spool announced").to_string();
    if peaks.ended.status != 0 || png == 0 {
        demands.broken(&format!("the pipe ended with status {}: {}", peaks.ended.status, peaks.ended.stderr), &pipe);
    }
    if peaks.sum() > 1536.0 {
        demands.broken(&format!("the pipe takes {:.0} MiB", peaks.sum()), &pipe);
    }
    let announced = told.split(' ').find_map(|w| w.parse::<f64>().ok()).unwrap_or(0.0) * 1.048_576;
    if announced == 0.0 || announced > stream + 2.0 {
        demands.broken(&format!("a stream of {stream:.0} MB: {told}"), &pipe);
    }
    let each: Vec<String> = peaks.each.iter().map(|(name, mb)| format!("{name} {mb:.0}")).collect();
    println!(
        "| {side} x {side} RGBE: `vonkries \\| pcond \\| xyz2rgb \\| ra_png` | {:.0} | {:.0} MiB: {} | 1536 MiB | {told}; the stream is {stream:.0} MB, disk taken {spool:.0} MB at most, PNG {:.0} MB |",
        peaks.seconds,
        peaks.sum(),
        each.join(", "),
        png as f64 / 1e6
    );
    fs::remove_file(input)?;
    let _ = fs::remove_file(folder.join("large.png"));
    Ok(())
}

/// Megabytes in use on the file system of a folder.
fn used(folder: &Path) -> f64 {
    let ended = shell("df -k . | awk 'NR == 2 { print $3 }'", folder);
    ended.ok().and_then(|e| String::from_utf8_lossy(&e.stdout).trim().parse::<f64>().ok()).unwrap_or(0.0) * 1024.0 / 1e6
}

/// One batch; the memory after the first hundred frames and at the end.
fn frames(count: usize, folder: &Path, demands: &mut Demands) -> std::io::Result<()> {
    fs::write(folder.join("frame.lux"), subjects::noise(subjects::XYZ, 16, 200.0))?;
    let stages = subjects::pipeline("frame.lux", "frames/${n}.png");
    let text = format!("[foreach]\nn = {{ from = 1, to = {count}, digits = 5 }}\n{stages}");
    fs::write(folder.join("frames.toml"), text)?;
    let (mut early, mut late) = (0f64, 0f64);
    let out = folder.join("frames");
    let peaks = Peaks::of("exec luxpipe --quiet frames.toml", folder, |pid| {
        let mb = crate::run::high_water(pid).unwrap_or(0.0);
        if early == 0.0 && out.join("00100.png").exists() {
            early = mb;
        }
        late = late.max(mb);
    })?;
    let written = fs::read_dir(&out).map_or(0, |d| d.count());
    if peaks.ended.status != 0 || written != count {
        demands.broken(
            &format!("a batch of {count}: status {}, {written} files: {}", peaks.ended.status, peaks.ended.stderr),
            "luxpipe frames.toml",
        );
    }
    if late > 1.05 * early + 2.0 {
        demands.broken(
            &format!("a batch grows from {early:.1} to {late:.1} MiB over {count} frames"),
            "luxpipe frames.toml",
        );
    }
    println!(
        "| {count} frames in one batch | {:.0} | {early:.1} MiB after 100, {late:.1} at the end | no growth | {written} files |",
        peaks.seconds
    );
    fs::remove_dir_all(out)
}

/// Pipelines side by side, each its own process; all bytes are those of one alone.
fn at_once(count: usize, folder: &Path, demands: &mut Demands) -> std::io::Result<()> {
    fs::write(folder.join("one.lux"), subjects::noise(subjects::XYZ, 128, 200.0))?;
    fs::create_dir_all(folder.join("side"))?;
    for i in 0..=count {
        fs::write(folder.join(format!("side/{i}.toml")), subjects::pipeline("one.lux", &format!("side/{i}.png")))?;
    }
    shell("luxpipe --quiet side/0.toml", folder)?;
    let begin = Instant::now();
    let script = format!(
        "i=1; while [ $i -le {count} ]; do {{ luxpipe --quiet side/$i.toml || echo $i; }} & i=$((i + 1)); done; wait"
    );
    let ended = shell(&script, folder)?;
    let seconds = begin.elapsed().as_secs_f64();
    let whole = fs::read(folder.join("side/0.png"))?;
    let right =
        (1..=count).filter(|i| fs::read(folder.join(format!("side/{i}.png"))).is_ok_and(|b| b == whole)).count();
    if right != count || !ended.stderr.is_empty() {
        demands.broken(
            &format!("{right} of {count} pipelines at once are right: {}", ended.stderr.lines().next().unwrap_or("")),
            &script,
        );
    }
    println!("| {count} pipelines at once | {seconds:.1} | | all right | {right} give the bytes of one alone |");
    fs::remove_dir_all(folder.join("side"))
}

/// A wavy sheet of 2 n^2 triangles as binary PLY.
fn write_sheet(path: &Path, n: usize) -> std::io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let place = "property float x\nproperty float y\nproperty float z";
    let face = format!("element face {}\nproperty list uchar int vertex_indices", 2 * n * n);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{place}\n{face}\nend_header\n",
        (n + 1) * (n + 1)
    )?;
    let step = 2.0 / n as f32;
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (i as f32 * step - 1.0, j as f32 * step - 1.0);
            for v in [x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.002 * ((i * 7 + j * 3) % 5) as f32] {
                out.write_all(&v.to_le_bytes())?;
            }
        }
    }
    for i in 0..n {
        for j in 0..n {
            let at = (i * (n + 1) + j) as i32;
            let (right, up) = (at + n as i32 + 1, at + 1);
            for corners in [[at, right, up], [right, right + 1, up]] {
                out.write_all(&[3])?;
                corners.iter().try_for_each(|c| out.write_all(&c.to_le_bytes()))?;
            }
        }
    }
    out.flush()
}

/// Loads, builds and renders at 64 x 64.
fn triangles(n: usize, folder: &Path, demands: &mut Demands) -> std::io::Result<()> {
    write_sheet(&folder.join("sheet.ply"), n)?;
    let scene = crate::corpus::scene_with("mesh").replace("{in}", "sheet.ply");
    fs::write(folder.join("sheet.toml"), scene)?;
    let command = "exec spectrace --width 64 --height 64 --samples 4 sheet.toml sheet.lux";
    let peaks = Peaks::of(command, folder, |_| ())?;
    let size = fs::metadata(folder.join("sheet.lux")).map_or(0, |m| m.len());
    if peaks.ended.status != 0 || size < 64 * 64 * 12 {
        demands.broken(
            &format!("{} triangles: status {}: {}", 2 * n * n, peaks.ended.status, peaks.ended.stderr),
            command,
        );
    }
    if peaks.sum() > 6144.0 {
        demands.broken(&format!("{} triangles take {:.0} MiB", 2 * n * n, peaks.sum()), command);
    }
    println!(
        "| {} triangles: read, built, rendered at 64 x 64 | {:.1} | {:.0} MiB | 6144 MiB | |",
        2 * n * n,
        peaks.seconds,
        peaks.sum()
    );
    fs::remove_file(folder.join("sheet.ply"))
}
