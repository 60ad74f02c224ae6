//! Runs spectrace and Mitsuba, and reads what they made.

use std::fs;
use std::path::{Path, PathBuf};

use luxpipe::color::Xy;
use luxpipe::notes::Notes;
use luxpipe::render::sampler::shared_well;
use luxpipe::stream::Block;
use luxpipe::stream::meaning::Overrides;
use luxpipe::stream::reader::{self, Input};

use crate::beside::Shell;
use crate::score::Renders;

/// Pixels of a side.
pub const SIZE: usize = 128;
/// Threads of both.
pub const THREADS: usize = 2;

/// What a program made, and the CPU seconds it took.
pub struct Made {
    /// Its pictures, all of the same scene.
    pub renders: Renders,
    /// CPU seconds of all threads for all of them.
    pub cpu: f64,
    /// Chromaticity of the lamp, where the program says it.
    pub white: Option<Xy>,
}

/// Both programs.
pub struct Programs {
    /// Where commands run.
    pub shell: Shell,
    /// The package's folder.
    pub root: PathBuf,
    python: Option<String>,
}

impl Programs {
    /// Mitsuba by the Python of MITSUBA_PYTHON.
    pub fn new() -> std::io::Result<Programs> {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let mut programs = Programs { shell: Shell::new()?, root, python: std::env::var("MITSUBA_PYTHON").ok() };
        if let Some(python) = &programs.python
            && programs.shell.run(&format!("'{python}' -c 'import mitsuba, numpy'")).is_none()
        {
            println!("{python} cannot import mitsuba and numpy");
            programs.python = None;
        }
        Ok(programs)
    }

    /// True where Mitsuba is there.
    pub fn has_peer(&self) -> bool {
        self.python.is_some()
    }

    /// A scene of the package by name.
    pub fn scene(&self, name: &str) -> PathBuf {
        self.root.join("scenes").join(name).with_extension("toml")
    }

    /// CPU seconds of spectrace; its picture is left in `ours.lux`.
    pub fn trace(&self, scene: &str, samples: u32, seed: u32, options: &str) -> f64 {
        let path = self.scene(scene);
        let command = format!(
            "{{ spectrace --quiet --threads {THREADS} --width {SIZE} --height {SIZE} --samples {samples} --seed {seed} {options} '{}' > ours.lux; }}",
            path.display()
        );
        self.shell.run(&command).unwrap_or_else(|| panic!("this failed: {command}")).0
    }

    /// One render by spectrace.
    pub fn ours(&self, scene: &str, samples: u32, seed: u32, options: &str) -> Made {
        let cpu = self.trace(scene, samples, seed, options);
        let (pixels, channels, white) = read(&self.shell.folder.path().join("ours.lux"));
        Made { renders: Renders { channels, pictures: vec![pixels] }, cpu, white }
    }

    /// Samples a pixel that take at most `cpu` seconds and share it well, as `--time` chooses them: from a short run and a
    /// longer one.
    pub fn samples_for(&self, scene: &str, cpu: f64, options: &str) -> u32 {
        let (few, more) = (8, 40);
        let first = self.trace(scene, few, 1, options);
        let each = (self.trace(scene, more, 1, options) - first) / f64::from(more - few);
        shared_well(((cpu - (first - f64::from(few) * each).max(0.0)) / each).max(2.0) as u32)
    }

    /// Mitsuba's chunks until `cpu` seconds have passed; `None` where it is not there or fails.
    pub fn peer(&self, scene: &str, cpu: f64, options: &str) -> Option<Made> {
        let python = self.python.as_ref()?;
        let (script, path) = (self.root.join("benches/render/mitsuba_scene.py"), self.scene(scene));
        let command = format!(
            "{{ '{python}' '{}' '{}' peer.raw --size {SIZE} --threads {THREADS} --cpu {cpu} {options} > peer.txt 2> peer.log; }}",
            script.display(),
            path.display()
        );
        let folder = self.shell.folder.path();
        if self.shell.run(&command).is_none() {
            let log = fs::read_to_string(folder.join("peer.log")).unwrap_or_default();
            println!("Mitsuba failed (with LLVM 14 or 15 it does: docs/performance.md): {}", last_line(&log));
            return None;
        }
        let line = fs::read_to_string(folder.join("peer.txt")).ok()?;
        let words: Vec<f64> = last_line(&line).split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let &[chunks, channels, _, cpu] = words.as_slice() else { return None };
        let raw = fs::read(folder.join("peer.raw")).ok()?;
        let all: Vec<f32> = raw.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let each = SIZE * SIZE * channels as usize;
        let pictures: Vec<Vec<f32>> = all.chunks_exact(each).map(<[f32]>::to_vec).collect();
        (pictures.len() == chunks as usize).then_some(Made {
            renders: Renders { channels: channels as usize, pictures },
            cpu,
            white: None,
        })
    }
}

fn last_line(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}

/// All pixels of a stream, components a pixel, the white.
fn read(path: &Path) -> (Vec<f32>, usize, Option<Xy>) {
    let open = || reader::open(Input::open(Some(path))?, &Overrides::default(), &Notes::default());
    let mut picture = open().expect("spectrace writes streams");
    let (channels, white) = (picture.header().ncomp, picture.header().white);
    let (mut block, mut all) = (Block::default(), Vec::new());
    while picture.next(&mut block).expect("spectrace writes whole streams") {
        all.extend_from_slice(&block.data);
    }
    (all, channels, white)
}
