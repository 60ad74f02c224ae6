//! What the tests share: reading .npy, running a scene in this process, running the real programs.
#![allow(dead_code)] // each test file uses its part

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use luxpipe::notes::Notes;
use luxpipe::parallel;
use luxpipe::render::estimate::{Effort, Quantity, What};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::render::picture::{Job, Work, render};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;
use luxpipe::stream::{Block, Picture};

/// The folder of the package.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A file of tests/data.
pub fn data_path(name: &str) -> String {
    root().join("tests/data").join(name).to_str().unwrap().to_string()
}

/// A scene of the repository.
pub fn scene(name: &str) -> Scene {
    load::load(&root().join("scenes").join(name)).unwrap()
}

/// XYZ from `bands` equal bins over 380 to 780 nm.
pub fn job(scene: &Scene, bands: usize, samples: u32, seed: u32) -> Job {
    let quantity = Quantity {
        sampling: Sampling::bins(380.0, 780.0, bands).unwrap(),
        range_nm: (380.0, 780.0),
        what: What::Xyz,
        seed,
        few: None,
    };
    Job {
        quantity,
        method: Choice::Path(path::Options {
            max_bounces: scene.max_bounces.unwrap_or(u32::MAX),
            split: 1,
            pool: false,
        }),
        effort: Work::Each(Effort::Paths(samples)),
        rows: (0, scene.camera.as_ref().unwrap().height),
        progress: false,
        checkpoint: None,
        notes: Notes::default(),
    }
}

/// All pixels of a picture.
pub fn pixels(mut picture: Box<dyn Picture>) -> Vec<f32> {
    let (mut block, mut all) = (Block::default(), Vec::new());
    while picture.next(&mut block).unwrap() {
        all.extend_from_slice(&block.data);
    }
    all
}

/// Renders on all processors.
pub fn rendered(scene: Scene, job: Job) -> Vec<f32> {
    parallel::set_threads(0);
    pixels(render(scene, job, |_| b"test".to_vec()).unwrap())
}

/// A float32 array in numpy's format, version 1.
pub fn npy(path: &Path) -> Vec<f32> {
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(&bytes[..6], b"\x93NUMPY");
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let text = std::str::from_utf8(&bytes[10..10 + header]).unwrap();
    assert!(text.contains("'<f4'") && text.contains("'fortran_order': False"), "{text}");
    bytes[10 + header..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// A filter that cargo built.
pub fn program(name: &str) -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_luxpipe")).with_file_name(name)
}

/// Runs a program in the package's folder with bytes on standard input.
pub fn run(name: &str, args: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(program(name))
        .args(args)
        .current_dir(root())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    let feeder = std::thread::spawn(move || drop(stdin.write_all(&input))); // a filter may stop reading early
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    output
}

/// What it writes; it must succeed.
pub fn stdout_of(name: &str, args: &[&str], input: &[u8]) -> Vec<u8> {
    let output = run(name, args, input);
    assert!(output.status.success(), "{name} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Header lines, resolution line and pixel bytes of a stream.
pub fn split(stream: &[u8]) -> (Vec<String>, String, &[u8]) {
    let end = stream.windows(2).position(|w| w == b"\n\n").unwrap();
    let lines = String::from_utf8(stream[..end].to_vec()).unwrap().lines().map(String::from).collect();
    let rest = &stream[end + 2..];
    let line = rest.iter().position(|b| *b == b'\n').unwrap();
    (lines, String::from_utf8(rest[..line].to_vec()).unwrap(), &rest[line + 1..])
}

/// Little-endian floats.
pub fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// A float stream with the given header lines and values.
pub fn stream(lines: &str, resolution: &str, values: &[f32]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{lines}\nFORMAT=float\n\n{resolution}\n").into_bytes();
    values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

/// A refusal: the status, one line that begins with the program's name and holds `word`, nothing on standard output.
pub fn fails(name: &str, args: &[&str], input: &[u8], status: i32, word: &str) {
    let output = run(name, args, input);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{name} {args:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{name} {args:?}: {message}");
    assert!(message.starts_with(&format!("{name}: ")), "{message}");
    assert!(message.contains(word), "{name} {args:?}: '{word}' not in: {message}");
    assert!(output.stdout.is_empty(), "{name} {args:?} wrote {} bytes", output.stdout.len());
}

/// A committed page is what the code prints: words alike, numbers to one unit of their last digit.
pub fn page_is_printed(path: &str, printed: &str) {
    let committed = std::fs::read_to_string(root().join(path)).unwrap();
    assert_eq!(committed.lines().count(), printed.lines().count(), "run: make {path}");
    for (old, new) in committed.lines().zip(printed.lines()) {
        let same = |(a, b): (&str, &str)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                let digits = a.split_once('.').map_or(0, |d| d.1.len());
                (x - y).abs() <= 1.01 * 10f64.powi(-(digits as i32))
            }
            _ => a == b,
        };
        let (a, b): (Vec<&str>, Vec<&str>) = (old.split_whitespace().collect(), new.split_whitespace().collect());
        assert!(a.len() == b.len() && a.into_iter().zip(b).all(same), "run: make {path}\n{old}\n{new}");
    }
}

/// A way to record pictures: a filter that goes both ways, and options.
#[derive(Clone, Debug)]
pub struct Encoding {
    /// The filter; `-r` reads what it writes.
    pub filter: &'static str,
    /// How it writes.
    pub options: Vec<String>,
}

impl Encoding {
    /// The bytes it makes of a stream; it may have remarks.
    pub fn write(&self, input: &[u8]) -> Vec<u8> {
        self.try_write(input).unwrap_or_else(|e| panic!("{self}: {e}"))
    }

    /// The bytes, or why there are none.
    pub fn try_write(&self, input: &[u8]) -> Result<Vec<u8>, String> {
        let options: Vec<&str> = self.options.iter().map(String::as_str).collect();
        let output = run(self.filter, &options, input);
        if output.status.success() { Ok(output.stdout) } else { Err(String::from_utf8_lossy(&output.stderr).into()) }
    }

    /// What it says of a stream it writes.
    pub fn remarks(&self, input: &[u8]) -> String {
        let options: Vec<&str> = self.options.iter().map(String::as_str).collect();
        let output = run(self.filter, &options, input);
        assert!(output.status.success(), "{self}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stderr).unwrap()
    }

    /// A float stream of what it wrote.
    pub fn read(&self, bytes: &[u8]) -> Vec<u8> {
        stdout_of(self.filter, &["-r", "--quiet"], bytes)
    }

    /// The command, as it is typed.
    pub fn is(&self, command: &str) -> bool {
        self.to_string() == command
    }
}

impl std::fmt::Display for Encoding {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}", self.filter)?;
        self.options.iter().try_for_each(|o| write!(f, " {o}"))
    }
}

/// Every filter that goes both ways, plainly, as each suffix has it, and with each of its options that choose another code. A new
/// filter is in the list by being one.
pub fn encodings() -> Vec<Encoding> {
    const CODES: [&str; 8] =
        ["--xyze", "--spectra", "--bits24", "--luminance", "--float", "--big-endian", "--bits 16", "--compression piz"];
    let mut all = Vec::new();
    for filter in luxpipe::filters::ALL {
        let command = filter.command();
        let has = |option: &str| command.get_arguments().any(|a| a.get_long() == Some(option));
        if !has("reverse") || !filter.name().starts_with("ra_") {
            continue;
        }
        let codes = CODES.iter().filter(|c| has(c.trim_start_matches("--").split(' ').next().unwrap()));
        let by_options = codes.map(|c| c.split(' ').map(String::from).collect());
        let by_suffix = filter.suffixes().iter().map(|s| {
            let words = filter.saver(s, "file".into()).command_words(Some("-"), None);
            words.into_iter().skip(1).filter(|w| w != "-").collect::<Vec<_>>()
        });
        for options in [Vec::new()].into_iter().chain(by_suffix).chain(by_options) {
            let known = |e: &Encoding| e.filter == filter.name() && e.options == options;
            if !options.contains(&"--reverse".to_string()) && !all.iter().any(known) {
                all.push(Encoding { filter: filter.name(), options });
            }
        }
    }
    all
}
