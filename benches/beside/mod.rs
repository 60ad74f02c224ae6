//! Commands beside a peer's in one run: CPU seconds, medians of neighbouring runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One comparison: our command, a peer's, how many times faster ours must be.
pub struct Row {
    /// What both do.
    pub what: &'static str,
    /// Our command.
    pub ours: String,
    /// The peer's.
    pub peer: String,
    /// Wanted ratio.
    pub bound: f64,
    /// Pixels of the picture.
    pub pixels: f64,
}

/// Where commands run, and where programs are found: ours first, then those of the folder RADIANCE_BIN.
pub struct Shell {
    /// Folder the commands run in, in memory where there is such.
    pub folder: tempfile::TempDir,
    /// Folder of our programs.
    pub bin: PathBuf,
    /// Search path.
    pub path: String,
}

impl Shell {
    /// In an empty folder.
    pub fn new() -> std::io::Result<Shell> {
        let ram = Path::new("/dev/shm");
        let folder = if ram.is_dir() { tempfile::tempdir_in(ram)? } else { tempfile::tempdir()? };
        let bin = Path::new(env!("CARGO_BIN_EXE_luxpipe")).parent().expect("a program lies in a folder").to_path_buf();
        let radiance = std::env::var("RADIANCE_BIN").unwrap_or_default();
        let path = format!("{}:{radiance}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
        Ok(Shell { folder, bin, path })
    }

    /// CPU and wall seconds of a command; `None` where it is not there or fails.
    pub fn run(&self, command: &str) -> Option<(f64, f64)> {
        let line = format!("TIMEFORMAT='%3U %3S %3R'; time {command} 2>/dev/null >/dev/null");
        let mut bash = Command::new("bash");
        let output = bash.args(["-c", &line]).current_dir(self.folder.path()).env("PATH", &self.path).output().ok()?;
        let text = String::from_utf8(output.stderr).ok().filter(|_| output.status.success())?;
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
        match numbers.as_deref() {
            Some([user, system, wall]) => Some((user + system, *wall)),
            _ => None,
        }
    }
}

/// Runs alternate, so that a machine whose speed drifts slows both.
pub fn compare(shell: &Shell, row: &Row, runs: usize) {
    let peer_there = !row.peer.is_empty() && shell.run(&row.peer).is_some();
    let (mut ours, mut peers) = (Vec::new(), Vec::new());
    for _ in 0..runs {
        ours.extend(shell.run(&row.ours).map(|t| t.0));
        if peer_there {
            peers.extend(shell.run(&row.peer).map(|t| t.0));
        }
    }
    let time = median(ours.iter().copied());
    let speed = row.pixels / 1e6 / time;
    let name = row.peer.split(' ').next().unwrap_or_default();
    print!("{:<18} {time:>8.3} {speed:>8.1} ", row.what);
    if peers.is_empty() {
        let why = if name.is_empty() { "none offers it".to_string() } else { format!("skipped: {name} is not there") };
        println!("{:>9} {:>7} {:>6}  {why}", "-", "-", shown(row.bound));
    } else {
        let (peer, ratio) = (median(peers.iter().copied()), ratio(&peers, &ours));
        println!("{peer:>9.3} {ratio:>7.2} {:>6}  {}", shown(row.bound), row.peer);
    }
}

/// The median of what neighbouring runs give: a processor's pace changes from second to second.
pub fn ratio(slow: &[f64], fast: &[f64]) -> f64 {
    median(slow.iter().zip(fast).map(|(s, f)| s / f))
}

fn shown(bound: f64) -> String {
    if bound.is_nan() { "-".into() } else { bound.to_string() }
}

/// The middle one.
pub fn median(times: impl IntoIterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.into_iter().collect();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The processor's name.
pub fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("unknown processor");
    name.trim_start_matches([' ', '\t', ':']).to_string()
}
