//! Peak memory of a program.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The largest resident size that the kernel recorded, asked for until the process ends.
pub fn peak_mb(command: &mut Command) -> std::io::Result<f64> {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    let status: PathBuf = format!("/proc/{}/status", child.id()).into();
    let mut peak = 0f64;
    while child.try_wait()?.is_none() {
        if let Ok(text) = fs::read_to_string(&status) {
            let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
            let kb = line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<f64>().ok());
            peak = peak.max(kb.unwrap_or(0.0) / 1024.0);
        }
        std::thread::sleep(std::time::Duration::from_micros(300));
    }
    Ok(peak)
}
