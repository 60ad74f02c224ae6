//! Ends that come suddenly: signals while a program waits for the rest of its input or is at work, and input that shrinks under it.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::faults::{Cell, Place, left};
use crate::run::{Demands, path, shell, status};
use crate::subjects::{self, Subject};

/// One that runs a command without a shell in between, so that a signal meets the program itself.
fn direct(command: &str, folder: &Path) -> Command {
    let mut sh = Command::new("sh");
    sh.args(["-c", &format!("exec {command}")]).env("PATH", path()).current_dir(folder);
    sh
}

/// A signal while half of the input has come.
pub fn signalled(s: &Subject, p: &Place, signal: &str, demands: &mut Demands) -> std::io::Result<Cell> {
    let out = p.empty()?;
    let suffix = Path::new(s.input).extension().unwrap_or_default().to_string_lossy().into_owned();
    let fifo = format!("fifo.{suffix}");
    shell(&format!("rm -f {fifo}; mkfifo {fifo}"), &p.folder)?;
    // Open both ways: it does not wait for a reader, and the pipe has no end.
    let mut pipe = File::options().read(true).write(true).open(p.folder.join(&fifo))?;
    let bytes = fs::read(p.folder.join(s.input))?;
    pipe.write_all(&bytes[..(bytes.len() / 2).min(30_000)])?;
    let command = s.command(&fifo, "out/result", &p.folder)?;
    let mut child =
        direct(&command, &p.folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    std::thread::sleep(Duration::from_millis(80));
    shell(&format!("kill -{signal} {}", child.id()), &p.folder)?;
    let ended = status(child.wait()?);
    let rest = left(&out, &[]);
    // tradeoff's output is a folder that it makes first; what is in it is whole.
    let folder_only = s.program == "tradeoff" && rest == ["result"];
    if ended < 128 || (!rest.is_empty() && !folder_only) {
        demands.broken(&format!("{}, SIG{signal}: status {ended}, leaves {rest:?}", s.program), &command);
    }
    Ok(Cell { status: Some(ended), left: rest.join(" ") })
}

/// Twenty times at moments that spread over the work: the output is whole or not there.
pub fn killed_at_any_time(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if s.program == "tradeoff" {
        return Ok(Cell::NONE);
    }
    let out = p.empty()?;
    let begin = std::time::Instant::now();
    shell(&s.command(s.input, "out/whole", &p.folder)?, &p.folder)?;
    let (took, whole) = (begin.elapsed(), fs::read(out.join("whole"))?);
    let command = s.command(s.input, "out/result", &p.folder)?;
    let mut there = 0;
    for i in 0..20 {
        let mut child =
            direct(&command, &p.folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
        std::thread::sleep(took.mul_f64(f64::from(i) / 18.0));
        let _ = child.kill();
        child.wait()?;
        let result = fs::read(out.join("result")).ok();
        there += usize::from(result.is_some());
        let rest = left(&out, &["whole", "result"]);
        if result.is_some_and(|r| r != whole) || !rest.is_empty() {
            demands.broken(&format!("{}, SIGKILL at any time: a partial file, or {rest:?}", s.program), &command);
        }
        let _ = fs::remove_file(out.join("result"));
    }
    Ok(Cell { status: Some(137), left: format!("whole {there} of 20") })
}

/// Pixels across of pictures that shrink: more than any pipe holds.
const WIDE: usize = 1100;

/// The input loses its second half while the output waits for a reader: status 1 and a line, or all of it if it was read by then.
pub fn shrinks(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if !s.input.ends_with(".lux") || !s.streams || s.program == "relight" {
        return Ok(Cell::NONE);
    }
    let header = if s.input == "shown.lux" { subjects::SHOWN } else { subjects::XYZ };
    let base = p.folder.join(format!("wide-{}", s.input));
    if !base.exists() {
        fs::write(&base, subjects::noise(header, WIDE, 0.9))?;
    }
    let mut statuses = Vec::new();
    for form in forms(s, p, &base)? {
        let (name, bytes) = form;
        fs::write(p.folder.join(&name), &bytes)?;
        let reference =
            s.command(&name, "-", &p.folder)?.replace("xyz.lux", "wide-xyz.lux").replace("wide-wide-", "wide-");
        let whole = direct(&reference, &p.folder).stderr(Stdio::null()).output()?;
        let (ended, got, said) = shrunk(&reference, &p.folder, &p.folder.join(&name), bytes.len() as u64 / 2)?;
        let fine = (ended == 1 && said.lines().count() == 1) || (ended == 0 && got == whole.stdout);
        if !fine {
            demands
                .broken(&format!("{}, input shrinks ({name}): status {ended}: {}", s.program, said.trim()), &reference);
        }
        if !statuses.contains(&ended) {
            statuses.push(ended);
        }
    }
    let words: Vec<String> = statuses.iter().map(i32::to_string).collect();
    Ok(Cell {
        status: statuses.first().copied(),
        left: if words.len() > 1 { words.join(" or ") } else { String::new() },
    })
}

/// The picture as floats; for one reader in every coding too.
fn forms(s: &Subject, p: &Place, base: &Path) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut all = vec![(format!("shrinks-{}", s.input), fs::read(base)?)];
    if s.program == "vonkries" {
        for (name, command) in [
            ("shrinks.hdr", "ra_rgbe"),
            ("shrinks.tif", "ra_loglv"),
            ("shrinks-p.tif", "ra_pixlog"),
            ("shrinks.exr", "ra_exr --compression piz"),
            ("shrinks.pfm", "ra_pfm"),
        ] {
            shell(&format!("{command} {} {name} --quiet", base.display()), &p.folder)?;
            all.push((name.to_string(), fs::read(p.folder.join(name))?));
        }
    }
    Ok(all)
}

/// Runs a command whose output nobody reads until its input has shrunk.
fn shrunk(command: &str, folder: &Path, input: &Path, to: u64) -> std::io::Result<(i32, Vec<u8>, String)> {
    let mut child =
        direct(command, folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    std::thread::sleep(Duration::from_millis(40));
    File::options().write(true).open(input)?.set_len(to)?;
    let (mut got, mut said) = (Vec::new(), String::new());
    child.stdout.take().map(|mut o| o.read_to_end(&mut got)).transpose()?;
    child.stderr.take().map(|mut e| e.read_to_string(&mut said)).transpose()?;
    Ok((status(child.wait()?), got, said))
}
