//! What the parts share: the programs, running them, what was found, the machine.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Stdio};
use std::time::Duration;

/// What the command line asks for.
pub struct Choice {
    /// Part of the bench.
    pub part: String,
    /// Damaged files a program.
    pub count: usize,
    /// Where random numbers begin.
    pub seed: u64,
    /// Load: a 64th of everything.
    pub small: bool,
    /// Load: only this one.
    pub only: Option<String>,
}

impl Choice {
    /// Reads words; those that cargo itself adds are passed over.
    pub fn parse(words: impl Iterator<Item = String>) -> Result<Choice, String> {
        let mut choice = Choice { part: String::new(), count: 2000, seed: 1, small: false, only: None };
        let mut words = words.filter(|w| w != "--bench");
        while let Some(word) = words.next() {
            let number = |words: &mut dyn Iterator<Item = String>, name: &str| {
                let text = words.next().ok_or(format!("{name} needs a number"))?;
                text.parse::<u64>().map_err(|e| format!("{name} {text}: {e}"))
            };
            match word.as_str() {
                "--count" => choice.count = number(&mut words, "--count")? as usize,
                "--seed" => choice.seed = number(&mut words, "--seed")?,
                "--small" => choice.small = true,
                "--only" => choice.only = words.next(),
                part if !part.starts_with('-') && choice.part.is_empty() => choice.part = part.to_string(),
                other => return Err(format!("what is '{other}'?")),
            }
        }
        Ok(choice)
    }
}

/// The folder of the package.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of the programs.
pub fn programs() -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_luxpipe")).with_file_name("")
}

/// A program that cargo built.
pub fn program(name: &str) -> PathBuf {
    programs().join(name)
}

/// Where files are kept that break a demand; TRUST_FOUND, or beside the builds.
pub fn found() -> PathBuf {
    std::env::var_os("TRUST_FOUND").map_or_else(|| root().join("target/trust"), PathBuf::from)
}

/// How a run ended.
#[derive(Clone)]
pub struct Ended {
    /// Exit status; 128 and the signal's number where one ended it, as shells have it.
    pub status: i32,
    /// What it wrote.
    pub stdout: Vec<u8>,
    /// What it said.
    pub stderr: String,
}

/// As a shell counts it.
pub fn status(status: ExitStatus) -> i32 {
    status.code().unwrap_or_else(|| 128 + status.signal().unwrap_or(0))
}

/// Runs a command with bytes on standard input.
pub fn run(command: &mut Command, input: &[u8]) -> std::io::Result<Ended> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let stdin = child.stdin.take();
    let output = std::thread::scope(|s| {
        // A program may stop reading early: then nothing more is to be written.
        s.spawn(move || stdin.map(|mut to| to.write_all(input)));
        child.wait_with_output()
    })?;
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    Ok(Ended { status: status(output.status), stdout: output.stdout, stderr })
}

/// One of our programs with words, in a folder, nothing on standard input.
pub fn filter(name: &str, words: &[String], folder: &Path) -> Command {
    let mut command = Command::new(program(name));
    command.args(words).current_dir(folder);
    command
}

/// A shell's script in a folder; `$PATH` begins with our programs.
pub fn shell(script: &str, folder: &Path) -> std::io::Result<Ended> {
    run(Command::new("sh").args(["-c", script]).env("PATH", path()).current_dir(folder), b"")
}

/// `PATH`, our programs first.
pub fn path() -> String {
    format!("{}:{}", programs().display(), std::env::var("PATH").unwrap_or_default())
}

/// A word as a shell takes it.
pub fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+%".contains(c);
    let safe = !word.is_empty() && word.chars().all(plain);
    if safe { word.to_string() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// What is demanded and was broken. Alike findings are shown once, with their number.
pub struct Demands {
    part: String,
    broken: BTreeMap<String, (usize, String)>,
}

impl Demands {
    /// None yet.
    pub fn new(part: &str) -> Demands {
        Demands { part: part.to_string(), broken: BTreeMap::new() }
    }

    /// A demand is broken: what, and the command that shows it.
    pub fn broken(&mut self, what: &str, command: &str) {
        self.broken.entry(what.to_string()).or_insert((0, command.to_string())).0 += 1;
    }

    /// How many so far.
    pub fn total(&self) -> usize {
        self.broken.values().map(|b| b.0).sum()
    }

    /// Was this kind seen already?
    pub fn knows(&self, what: &str) -> bool {
        self.broken.contains_key(what)
    }

    /// Prints what was broken; status 1 if anything was.
    pub fn verdict(&self) -> ExitCode {
        let total = self.total();
        println!("\n{}: {} broken demands of {} kinds.\n", self.part, total, self.broken.len());
        for (what, (times, command)) in &self.broken {
            println!("- {what} ({times} x)\n\n        {}\n", command.replace('\n', "\n        "));
        }
        if self.broken.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

/// Keeps a file that breaks a demand; where.
pub fn keep(name: &str, bytes: &[u8]) -> std::io::Result<PathBuf> {
    fs::create_dir_all(found())?;
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    let path = found().join(plain);
    fs::write(&path, bytes)?;
    Ok(path)
}

/// Day, processor and system, for the head of a section.
pub fn machine() -> String {
    let day = run(Command::new("date").args(["-u", "+%F"]), b"").map(|e| e.stdout).unwrap_or_default();
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = cpu.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("an unknown processor");
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (day, name) = (String::from_utf8_lossy(&day).trim().to_string(), name.trim_start_matches([' ', '\t', ':']));
    format!("{day}, {name}, {threads} threads, Linux {}", kernel.trim())
}

/// The largest resident size of a process that the kernel recorded, MiB; none once it has ended.
pub fn high_water(pid: u32) -> Option<f64> {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse::<f64>().ok().map(|kb| kb / 1024.0)
}

/// Processes that descend from one, itself among them.
pub fn family(pid: u32) -> Vec<u32> {
    let mut all = vec![pid];
    let mut next = 0;
    while next < all.len() {
        let tasks = fs::read_dir(format!("/proc/{}/task", all[next])).into_iter().flatten().flatten();
        for task in tasks {
            let text = fs::read_to_string(task.path().join("children")).unwrap_or_default();
            all.extend(text.split_whitespace().filter_map(|p| p.parse::<u32>().ok()));
        }
        next += 1;
    }
    all
}

/// Peaks of all processes of a command by name, MiB, and how long it took. Standard output is thrown away.
pub struct Peaks {
    /// Of each process: its name and peak.
    pub each: Vec<(String, f64)>,
    /// How it ended.
    pub ended: Ended,
    /// How long it took.
    pub seconds: f64,
}

impl Peaks {
    /// Sum of the peaks: more than was ever held at a time.
    pub fn sum(&self) -> f64 {
        self.each.iter().map(|e| e.1).sum()
    }

    /// Runs a shell's script and looks at its processes every 20 ms, and at `watch`.
    pub fn of(script: &str, folder: &Path, mut watch: impl FnMut(u32)) -> std::io::Result<Peaks> {
        let begin = std::time::Instant::now();
        let mut command = Command::new("sh");
        command.args(["-c", script]).env("PATH", path()).current_dir(folder);
        let errors = tempfile::NamedTempFile::new()?;
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors.reopen()?);
        let mut child = child.spawn()?;
        let mut peaks: BTreeMap<u32, (String, f64)> = BTreeMap::new();
        let ended = loop {
            if let Some(ended) = child.try_wait()? {
                break ended;
            }
            for pid in family(child.id()) {
                let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default().trim().to_string();
                if let Some(peak) = high_water(pid).filter(|_| name != "sh") {
                    peaks.insert(pid, (name, peak));
                }
            }
            watch(child.id());
            std::thread::sleep(Duration::from_millis(20));
        };
        let stderr = String::from_utf8_lossy(&fs::read(errors.path())?).into_owned();
        let ended = Ended { status: status(ended), stdout: Vec::new(), stderr };
        Ok(Peaks { each: peaks.into_values().collect(), ended, seconds: begin.elapsed().as_secs_f64() })
    }
}

/// Splitmix64 [Steele 2014]: equal seeds, equal files.
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// One of `n`, 0 where there is none.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n.max(1)
    }
}

/// One row: what was tried and how often a demand was broken.
pub fn row(
    what: &str,
    demands: &mut Demands,
    work: impl FnOnce(&mut Demands) -> std::io::Result<usize>,
) -> std::io::Result<()> {
    let before = demands.total();
    let tried = work(demands)?;
    println!("| {what} | {tried} | {} |", demands.total() - before);
    Ok(())
}
