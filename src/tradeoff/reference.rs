//! What methods are compared with: the mean of independent renders by path tracing, kept and used again while the scene's text is the same.
//!
//! The spread of the renders tells the standard error of their mean. Meshes and spectra that a scene names by file are not looked at: take
//! the kept picture away when those change.

use std::path::{Path, PathBuf};

use crate::statistics::fnv1a;
use crate::stream::output::Output;
use crate::stream::spool::Limits;
use crate::tradeoff::child::{Programs, file_word};
use crate::tradeoff::judge::Seen;
use crate::{Error, Result, invalid};

/// Independent renders.
const RUNS: usize = 4;
/// Lines of its header.
const KEY: &str = "TRADEOFF_SCENE";
const NOISE: &str = "TRADEOFF_STANDARD_ERROR";

/// A converged picture.
pub struct Reference {
    /// The mean.
    pub seen: Seen,
    /// Standard error: relative root mean square of Y, and of Delta E 2000.
    pub noise: [f64; 2],
    /// Y of the white.
    pub white_y: f64,
    /// Made now, and not taken from its file.
    pub fresh: bool,
}

/// How one is made.
pub struct Making<'a> {
    /// The programs.
    pub programs: &'a Programs,
    /// Memory for pictures.
    pub limits: &'a Limits,
    /// Pixels across.
    pub width: Option<usize>,
    /// Seconds for all renders.
    pub seconds: f64,
    /// Where it is kept.
    pub kept: &'a Path,
    /// For pictures on the way.
    pub folder: &'a Path,
    /// Dark pixels are looked at up to so many times brighter.
    pub gain: f64,
}

impl Making<'_> {
    /// The reference of a scene, from its file if that is of the same text and size.
    pub fn of(&self, scene: &Path, name: &str) -> Result<Reference> {
        let text = std::fs::read(scene).map_err(|e| Error::io(scene.display().to_string(), e))?;
        let file = self.kept_file(name);
        let key = format!("{:016x}", fnv1a(&text));
        let lamps = self.render(scene, "lamps", &["--samples=1", "--max-bounces=0"])?;
        match self.known(&file, &key)? {
            Some((seen, noise)) => {
                let white_y = seen.white_y(&lamps.xyz)?;
                Ok(Reference { seen, noise, white_y, fresh: false })
            }
            None => self.made(scene, &file, &key, &lamps),
        }
    }

    /// Where the reference of a scene of this name is kept.
    pub fn kept_file(&self, name: &str) -> PathBuf {
        let width = self.width.map_or("own".into(), |w| w.to_string());
        self.kept.join(format!("{name}-{width}.lux"))
    }

    fn known(&self, file: &Path, key: &str) -> Result<Option<(Seen, [f64; 2])>> {
        if !file.is_file() {
            return Ok(None);
        }
        // A damaged one is made again.
        let Ok(seen) = Seen::read(file, self.limits) else { return Ok(None) };
        let numbers = seen.header.variable(NOISE).map(|v| String::from_utf8_lossy(v).into_owned()).unwrap_or_default();
        let numbers: Vec<f64> = numbers.split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let same = seen.header.variable(KEY) == Some(key.as_bytes());
        // With the seconds that it took, and the gain by which its colours were compared.
        Ok(match numbers[..] {
            [y, rms, seconds, gain] if same && seconds >= self.seconds && gain == self.gain => Some((seen, [y, rms])),
            _ => None,
        })
    }

    fn render(&self, scene: &Path, name: &str, options: &[&str]) -> Result<Seen> {
        let picture = self.folder.join(format!("{name}.lux"));
        let mut words: Vec<String> = options.iter().map(|o| o.to_string()).collect();
        words.extend(self.width.map(|w| format!("--width={w}")));
        words.push(file_word(scene));
        match self.programs.run("spectrace", &words, &picture)? {
            Ok(_) => Seen::read(&picture, self.limits),
            Err(said) => invalid!("{said}"),
        }
    }

    fn made(&self, scene: &Path, file: &Path, key: &str, lamps: &Seen) -> Result<Reference> {
        let seconds = format!("--time={}", self.seconds / RUNS as f64);
        let run = |i: usize| self.render(scene, "reference", &[&seconds, &format!("--seed={}", 1001 + i)]);
        let runs = (0..RUNS).map(run).collect::<Result<Vec<Seen>>>()?;
        let mut seen = runs[0].clone();
        for (i, mean) in seen.xyz.iter_mut().enumerate() {
            *mean = (runs.iter().map(|r| f64::from(r.xyz[i])).sum::<f64>() / RUNS as f64) as f32;
        }
        let white_y = seen.white_y(&lamps.xyz)?;
        // A run lies off the mean of n by the root of (n - 1) / n of its error, the mean of n by the root of 1 / n.
        let share = 1.0 / ((RUNS * (RUNS - 1)) as f64).sqrt();
        let mut squares = [0.0; 2];
        for run in &runs {
            let errors = seen.errors_of(run, white_y, self.gain)?;
            squares[0] += errors.relative_rmse.powi(2);
            squares[1] += errors.rms.powi(2);
        }
        let noise = squares.map(|s| s.sqrt() * share);
        seen.header.lines.push(format!("{KEY}= {key}").into_bytes());
        seen.header
            .lines
            .push(format!("{NOISE}= {:.6} {:.6} {} {}", noise[0], noise[1], self.seconds, self.gain).into_bytes());
        std::fs::create_dir_all(self.kept).map_err(|e| Error::io(self.kept.display().to_string(), e))?;
        keep(&seen, file.to_path_buf())?;
        Ok(Reference { seen, noise, white_y, fresh: true })
    }
}

fn keep(seen: &Seen, file: PathBuf) -> Result<()> {
    use std::io::Write as _;
    let mut out = Output::create(Some(&file), true)?;
    let bytes = seen.header.to_bytes("float", &[]);
    out.write_all(&bytes).and_then(|()| out.write_all(bytemuck::cast_slice(&seen.xyz))).map_err(|e| out.error(e))?;
    out.finish()
}
