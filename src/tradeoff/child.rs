//! A program run for its output, its time and its memory.

use std::ffi::OsStr;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::options::installed;
use crate::{Error, Result, invalid};

/// What came of it.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Wall clock.
    pub seconds: f64,
    /// Largest resident size; `None` where the system does not say.
    pub peak_mb: Option<f64>,
    /// What it said on standard error.
    pub said: String,
}

/// Programs beside this one.
pub struct Programs {
    folder: PathBuf,
    threads: usize,
}

/// Between looks at a program that runs.
const PAUSE: Duration = Duration::from_millis(1);

impl Programs {
    /// Those in this program's folder, with so many threads each; 0 for all.
    pub fn beside(threads: usize) -> Result<Programs> {
        let own = std::env::current_exe().map_err(|e| Error::io("tradeoff", e))?;
        let folder = own.parent().unwrap_or(Path::new(".")).to_path_buf();
        for name in ["spectrace", "specplan"] {
            if !folder.join(installed(name)).is_file() {
                return invalid!("there is no {name} beside tradeoff in {}", folder.display());
            }
        }
        Ok(Programs { folder, threads })
    }

    /// Runs a program with standard output to a file. `Err` of the inner result is what a program said that failed.
    ///
    /// # Errors
    /// Programs that cannot be started, files that cannot be made.
    pub fn run<A: AsRef<OsStr>>(
        &self,
        name: &str,
        arguments: &[A],
        output: &Path,
    ) -> Result<std::result::Result<Ran, String>> {
        let io = |e| Error::io(name, e);
        let said_path = output.with_extension("said");
        let said = File::create(&said_path).map_err(|e| Error::io(said_path.display().to_string(), e))?;
        let out = File::create(output).map_err(|e| Error::io(output.display().to_string(), e))?;
        let begin = Instant::now();
        let mut child = Command::new(self.folder.join(installed(name)))
            .args(arguments)
            .arg(format!("--threads={}", self.threads))
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(said)
            .spawn()
            .map_err(io)?;
        let mut peak_mb: Option<f64> = None;
        let status = loop {
            peak_mb = resident_mb(child.id()).or(peak_mb);
            match child.try_wait().map_err(io)? {
                Some(status) => break status,
                None => std::thread::sleep(PAUSE),
            }
        };
        let seconds = begin.elapsed().as_secs_f64();
        let said = std::fs::read_to_string(&said_path).unwrap_or_default().trim().to_string();
        let _ = std::fs::remove_file(&said_path);
        Ok(if status.success() { Ok(Ran { seconds, peak_mb, said }) } else { Err(said) })
    }
}

/// A file as an argument: a name that begins with a dash is an option to nobody.
pub fn file_word(path: &Path) -> String {
    let name = path.display().to_string();
    if name.starts_with('-') { format!("./{name}") } else { name }
}

/// The largest resident size so far, as Linux records it.
fn resident_mb(process: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches(" kB").parse::<f64>().ok().map(|kb| kb / 1024.0)
}
