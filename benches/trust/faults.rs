//! Faults of the system, each by each program: what it exits with, what it says, and what lies in the output's folder afterwards.
//! No partial file under the final name, ever; a file that was there keeps its bytes.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run::{Demands, Ended, machine, quote, shell};
use crate::subjects::{self, Subject};
use crate::sudden;

/// How a fault ended.
pub struct Cell {
    /// As a shell counts it; none where the fault does not apply.
    pub status: Option<i32>,
    /// A word on what is left, if that is not nothing.
    pub left: String,
}

/// Where the faults happen.
pub struct Place {
    /// Inputs.
    pub folder: PathBuf,
    /// A full file system, if one could be mounted.
    pub full: Option<PathBuf>,
    /// One that is read only.
    pub read_only: Option<PathBuf>,
    /// Can commands be run as nobody?
    pub nobody: bool,
}

/// A fault: its name, and what does it.
type Fault = (&'static str, fn(&Subject, &Place, &mut Demands) -> std::io::Result<Cell>);

const FAULTS: [Fault; 16] = [
    ("/dev/full", dev_full),
    ("full disk", full_disk),
    ("full --tmp", full_spool),
    ("read-only folder", read_only),
    ("no right to write", no_right_to_write),
    ("no right to read", no_right_to_read),
    ("no input", no_input),
    ("closed pipe", closed_pipe),
    ("stopped reader", stopped_reader),
    ("closed stdout", closed_stdout),
    ("little memory", little_memory),
    ("SIGTERM", |s, p, d| sudden::signalled(s, p, "TERM", d)),
    ("SIGINT", |s, p, d| sudden::signalled(s, p, "INT", d)),
    ("SIGKILL", |s, p, d| sudden::signalled(s, p, "KILL", d)),
    ("SIGKILL at any time", sudden::killed_at_any_time),
    ("input shrinks", sudden::shrinks),
];

/// Runs all of it and prints a table.
pub fn section(demands: &mut Demands) -> std::io::Result<()> {
    let holder = tempfile::tempdir()?;
    let place = Place::prepare(holder.path())?;
    println!("## Faults\n\n{}\n", machine());
    for (word, there) in
        [("full disk", place.full.is_some()), ("read-only folder", place.read_only.is_some()), ("rights", place.nobody)]
    {
        if !there {
            println!("Skipped, for want of the right to mount or to be another user: {word}.\n");
        }
    }
    println!("| program | {} |", FAULTS.map(|f| f.0).join(" | "));
    println!("|---|{}", "---|".repeat(FAULTS.len()));
    let mut done = Ok(());
    for subject in subjects::all() {
        let cells: std::io::Result<Vec<Cell>> = FAULTS.iter().map(|f| f.1(&subject, &place, demands)).collect();
        match cells {
            Ok(cells) => {
                println!("| {} | {} |", subject.program, cells.iter().map(Cell::shown).collect::<Vec<_>>().join(" | "))
            }
            Err(e) => done = Err(std::io::Error::other(format!("{}: {e}", subject.program))),
        }
    }
    place.leave();
    println!(
        "\nStatus by fault; 128 and a signal's number where one ended the program. What is left is nothing unless a cell says so."
    );
    done
}

impl Cell {
    /// The fault does not apply.
    pub const NONE: Cell = Cell { status: None, left: String::new() };

    fn shown(&self) -> String {
        let status = self.status.map_or("-".to_string(), |s| s.to_string());
        if self.left.is_empty() { status } else { format!("{status}, {}", self.left) }
    }
}

impl Place {
    fn prepare(folder: &Path) -> std::io::Result<Place> {
        subjects::prepare(folder, subjects::SIDE)?;
        let (full, ro) = (folder.join("full"), folder.join("read-only"));
        fs::create_dir_all(&full)?;
        fs::create_dir_all(&ro)?;
        let mount = |at: &Path, options: &str| {
            let script = format!("mount -t tmpfs -o {options} tmpfs {}", quote(&at.display().to_string()));
            shell(&script, folder).is_ok_and(|e| e.status == 0)
        };
        let full = mount(&full, "size=64k").then_some(full);
        let ro = mount(&ro, "size=64k,ro").then_some(ro);
        // So that nobody finds the inputs, and may not write beside them.
        shell(
            "chmod 755 . && chmod 644 *.lux *.toml *.csv && mkdir closed && cp *.lux *.toml *.csv closed && chmod 000 closed/*",
            folder,
        )?;
        let nobody =
            shell("setpriv --reuid 65534 --regid 65534 --clear-groups true", folder).is_ok_and(|e| e.status == 0);
        Ok(Place { folder: folder.to_path_buf(), full, read_only: ro, nobody })
    }

    fn leave(&self) {
        for at in self.full.iter().chain(&self.read_only) {
            let _ = shell(&format!("umount {}", quote(&at.display().to_string())), &self.folder);
        }
    }

    /// An empty folder for outputs.
    pub fn empty(&self) -> std::io::Result<PathBuf> {
        let out = self.folder.join("out");
        let _ = fs::remove_dir_all(&out);
        fs::create_dir_all(&out)?;
        Ok(out)
    }
}

/// What lies in a folder beside what is known.
pub fn left(folder: &Path, known: &[&str]) -> Vec<String> {
    let names =
        fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.file_name().to_string_lossy().into_owned());
    names.filter(|n| !known.contains(&n.as_str())).collect()
}

/// A failure: status 1, one line, nothing left.
fn refusal(
    subject: &Subject,
    fault: &str,
    command: &str,
    ended: &Ended,
    left: &[String],
    demands: &mut Demands,
) -> Cell {
    let complain =
        |what: String, demands: &mut Demands| demands.broken(&format!("{}, {fault}: {what}", subject.program), command);
    if ended.status != 1 {
        complain(format!("status {}: {}", ended.status, ended.stderr.trim()), demands);
    } else if ended.stderr.lines().count() != 1 {
        complain(format!("not one line: {}", ended.stderr.trim()), demands);
    }
    if !left.is_empty() {
        complain(format!("leaves {left:?}"), demands);
    }
    Cell { status: Some(ended.status), left: left.join(" ") }
}

fn dev_full(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if !s.streams {
        return Ok(Cell::NONE);
    }
    let command = format!("{} > /dev/full", s.command(s.input, "-", &p.folder)?);
    let ended = shell(&command, &p.folder)?;
    Ok(refusal(s, "/dev/full", &command, &ended, &[], demands))
}

/// The old file keeps its bytes.
fn full_disk(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let Some(full) = &p.full else { return Ok(Cell::NONE) };
    shell("rm -rf full/* ; echo old > full/result; cat /dev/zero > full/filler", &p.folder)?;
    let command = s.command(s.input, "full/result", &p.folder)?;
    let ended = shell(&command, &p.folder)?;
    let mut left = left(full, &["result", "filler"]);
    if fs::read(full.join("result")).unwrap_or_default() != b"old\n" {
        left.push("the old file changed".into());
    }
    Ok(refusal(s, "full disk", &command, &ended, &left, demands))
}

/// Where a pipe must be kept: those that need no second look succeed.
fn full_spool(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if p.full.is_none() || !s.input.ends_with(".lux") || s.pipeline {
        return Ok(Cell::NONE);
    }
    let out = p.empty()?;
    let input = if s.program == "pplot" || s.program == "pjoin" { "/dev/stdin" } else { "-" };
    let command = format!("cat {} | {} --memory 1k --tmp full", s.input, s.command(input, "out/result", &p.folder)?);
    let ended = shell(&command, &p.folder)?;
    let rest = left(&out, &["result"]);
    if ended.status == 0 && rest.is_empty() {
        return Ok(Cell { status: Some(0), left: "needs none".into() });
    }
    Ok(refusal(s, "full --tmp", &command, &ended, &left(&out, &[]), demands))
}

fn read_only(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let Some(at) = &p.read_only else { return Ok(Cell::NONE) };
    let command = s.command(s.input, "read-only/result", &p.folder)?;
    let ended = shell(&command, &p.folder)?;
    Ok(refusal(s, "read-only folder", &command, &ended, &left(at, &[]), demands))
}

const NOBODY: &str = "setpriv --reuid 65534 --regid 65534 --clear-groups";

fn no_right_to_write(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let out = p.empty()?;
    let command = format!("{NOBODY} {}", s.command(s.input, "out/result", &p.folder)?);
    if !p.nobody {
        return Ok(Cell::NONE);
    }
    let ended = shell(&command, &p.folder)?;
    Ok(refusal(s, "no right to write", &command, &ended, &left(&out, &[]), demands))
}

fn no_right_to_read(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let out = p.empty()?;
    shell("chmod 777 out", &p.folder)?;
    let command = format!("{NOBODY} {}", s.command(&format!("closed/{}", s.input), "out/result", &p.folder)?);
    if !p.nobody {
        return Ok(Cell::NONE);
    }
    let ended = shell(&command, &p.folder)?;
    Ok(refusal(s, "no right to read", &command, &ended, &left(&out, &[]), demands))
}

fn no_input(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let out = p.empty()?;
    let command = s.command("nowhere.toml", "out/result", &p.folder)?;
    let ended = shell(&command, &p.folder)?;
    Ok(refusal(s, "no input", &command, &ended, &left(&out, &[]), demands))
}

/// Bytes that a reader takes before it goes away.
const TAKEN: [usize; 13] = [0, 1, 2, 3, 7, 10, 50, 100, 500, 4096, 10_000, 65_536, 200_000];

/// A reader that goes away is no failure and nothing to talk of.
fn closed_pipe(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if !s.streams {
        return Ok(Cell::NONE);
    }
    let work = s.command(s.input, "-", &p.folder)?;
    for n in TAKEN {
        let command = format!(
            "{{ {work} --quiet 2> said; echo $? > status; }} | head -c {n} > /dev/null; cat said >&2; exit $(cat status)"
        );
        let ended = shell(&command, &p.folder)?;
        if ended.status != 0 || !ended.stderr.is_empty() {
            let what = format!("{}, closed pipe: status {}, {}", s.program, ended.status, ended.stderr.trim());
            demands.broken(&what, &command);
            return Ok(Cell { status: Some(ended.status), left: format!("after {n} bytes") });
        }
    }
    Ok(Cell { status: Some(0), left: String::new() })
}

/// It gets all of it when it goes on.
fn stopped_reader(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if !s.streams {
        return Ok(Cell::NONE);
    }
    let work = s.command(s.input, "-", &p.folder)?;
    let command = format!("{work} --quiet > whole; {work} --quiet | {{ head -c 1000; sleep 0.3; cat; }} | cmp - whole");
    let ended = shell(&command, &p.folder)?;
    if ended.status != 0 {
        demands.broken(&format!("{}, stopped reader: {}", s.program, ended.stderr.trim()), &command);
    }
    Ok(Cell { status: Some(ended.status), left: String::new() })
}

/// Rust opens /dev/null in place of a descriptor that is closed: what is written there is lost, and nobody knows. Counted, not demanded.
fn closed_stdout(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    if !s.streams {
        return Ok(Cell::NONE);
    }
    let command = format!("{} >&-", s.command(s.input, "-", &p.folder)?);
    let ended = shell(&command, &p.folder)?;
    if ended.status > 1 {
        demands.broken(&format!("{}, closed stdout: status {}", s.program, ended.status), &command);
    }
    Ok(Cell { status: Some(ended.status), left: String::new() })
}

/// From too little to load the program to enough. A file is whole or not there.
fn little_memory(s: &Subject, p: &Place, demands: &mut Demands) -> std::io::Result<Cell> {
    let out = p.empty()?;
    let work = s.command(s.input, "out/whole", &p.folder)?;
    shell(&work, &p.folder)?;
    let whole = fs::read(out.join("whole")).unwrap_or_default();
    let mut statuses: Vec<i32> = Vec::new();
    for megabytes in [4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 64, 96, 128] {
        let work = s.command(s.input, "out/result", &p.folder)?;
        let command = format!("ulimit -v {}; {work} --threads 1", megabytes << 10);
        let ended = shell(&command, &p.folder)?;
        let result = fs::read(out.join("result")).ok();
        let partial = result.as_ref().is_some_and(|r| *r != whole && s.program != "tradeoff");
        let rest = left(&out, &["whole", "result"]);
        if partial || (result.is_some() && ended.status != 0) || !rest.is_empty() {
            demands.broken(&format!("{}, little memory: a file is left, {rest:?}", s.program), &command);
        }
        if ended.stderr.contains("panicked") {
            demands.broken(
                &format!("{}, little memory: panics: {}", s.program, ended.stderr.lines().next().unwrap_or("")),
                &command,
            );
        }
        if !statuses.contains(&ended.status) {
            statuses.push(ended.status);
        }
        let path = out.join("result");
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    let words: Vec<String> = statuses.iter().map(i32::to_string).collect();
    Ok(Cell {
        status: statuses.last().copied(),
        left: if words.len() > 1 { words.join(" then ") } else { String::new() },
    })
}
