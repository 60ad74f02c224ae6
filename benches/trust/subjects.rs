//! A working command of every program: `{in}` stands for its input, `{out}` for its output.

use std::fs;
use std::path::Path;

use crate::corpus::made;
use crate::run::{program, quote, root};

/// A command that works.
pub struct Subject {
    /// The program.
    pub program: &'static str,
    /// Its words.
    pub words: Vec<String>,
    /// The good input, in the folder of [`prepare`].
    pub input: &'static str,
    /// A pipeline that names both, its file the only word.
    pub pipeline: bool,
    /// Can it write to standard output?
    pub streams: bool,
}

/// Pixels across and down of pictures that take longer than a pipe.
pub const SIDE: usize = 256;

impl Subject {
    /// The same with the least work.
    pub fn small(mut self) -> Subject {
        self.words.iter_mut().for_each(|w| *w = w.replace("128", "8").replace("64", "16"));
        self
    }

    /// As a shell takes it; a pipeline is written beside. `-` as output is standard output.
    pub fn command(&self, input: &str, out: &str, folder: &Path) -> std::io::Result<String> {
        let mut words: Vec<String> =
            self.words.iter().map(|w| w.replace("{in}", input).replace("{out}", out)).collect();
        if self.pipeline {
            let name = format!("pipe-{:08x}.toml", hash(&format!("{input}{out}")));
            fs::write(folder.join(&name), pipeline(input, out))?;
            words = vec![name];
        }
        let words: Vec<String> = words.iter().map(|w| quote(w)).collect();
        Ok(format!("{} {}", quote(&program(self.program).display().to_string()), words.join(" ")))
    }
}

fn hash(text: &str) -> u32 {
    text.bytes().fold(2_166_136_261, |h, b| (h ^ u32::from(b)).wrapping_mul(16_777_619))
}

/// A text as TOML has it.
pub fn toml_text(text: &str) -> String {
    let escaped = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04x}", c as u32),
        c => c.to_string(),
    };
    format!("\"{}\"", text.chars().map(escaped).collect::<String>())
}

/// Three stages over a picture.
pub fn pipeline(input: &str, out: &str) -> String {
    let output = if out == "-" { String::new() } else { format!("output = {}\n", toml_text(out)) };
    format!(
        "[[stage]]\nrun = \"vonkries\"\nto = \"D50\"\ninput = {}\n[[stage]]\nrun = \"pcond\"\n[[stage]]\nrun = \"xyz2rgb\"\n[[stage]]\nrun = \"ra_png\"\n{output}",
        toml_text(input)
    )
}

/// Float pixels of noise.
pub fn noise(lines: &str, side: usize, top: f32) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{lines}\nFORMAT=float\n\n-Y {side} +X {side}\n").into_bytes();
    for i in 0..3 * side * side {
        let value = ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / 16_777_216.0;
        bytes.extend((top * (0.05 + value)).to_le_bytes());
    }
    bytes
}

/// Header of XYZ.
pub const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329\nVIEW= -vtv -vh 40 -vv 40";
/// Header of what a display shows.
pub const SHOWN: &str =
    "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nDISPLAY= 1 100\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";

/// Writes the inputs of all subjects.
pub fn prepare(folder: &Path, side: usize) -> std::io::Result<()> {
    fs::write(folder.join("xyz.lux"), noise(XYZ, side, 200.0))?;
    fs::write(folder.join("shown.lux"), noise(SHOWN, side, 0.9))?;
    let layers = ["--per-light", "--width=128", "--samples=1", "--bands=8", "--quiet", "scenes/cornell.toml"];
    fs::write(folder.join("layers.lux"), made("spectrace", &layers, b"")?)?;
    let copies = [
        ("scenes/cornell.toml", "scene.toml"),
        ("scenes/materials.toml", "materials.toml"),
        ("palettes/office.toml", "office.toml"),
        ("tests/data/display_readings.csv", "readings.csv"),
        ("tests/data/capture/a.jpg", "shot.jpg"),
        ("tests/data/rad/sky.rad", "sky.rad"),
    ];
    copies.iter().try_for_each(|(from, to)| fs::copy(root().join(from), folder.join(to)).map(drop))
}

/// One of every program.
pub fn all() -> Vec<Subject> {
    let subject = |program: &'static str, words: &str, input: &'static str| {
        let words = words.split_whitespace().map(|w| w.replace('~', " ")).collect();
        Subject { program, words, input, pipeline: program == "luxpipe", streams: program != "tradeoff" }
    };
    let render = "--width 128 --samples 4 --bands 8 {in} {out}";
    let trade =
        "{in} --width 8 --samples 1 --methods local --plans none --seconds 0.01 --reference-seconds 0.01 -o {out}";
    vec![
        subject("expmerge", "--times 1/60 --aperture 8 --iso 100 --curve srgb {in} -o {out}", "shot.jpg"),
        subject("falsecolor", "{in} {out}", "xyz.lux"),
        subject("luxpipe", "", "xyz.lux"),
        subject("pcompare", "xyz.lux {in} {out}", "xyz.lux"),
        subject("pcond", "{in} {out}", "xyz.lux"),
        subject("pdisplay", "{in} {out}", "readings.csv"),
        subject("pglare", "--view -vta~-vh~180~-vv~180 {in} {out}", "xyz.lux"),
        subject("picinfo", "{in} {out}", "xyz.lux"),
        subject("pjoin", "{in} -o {out}", "xyz.lux"),
        subject("plocal", "{in} {out}", "xyz.lux"),
        subject("pmix", "--weight 0.5 --add 0.5:xyz.lux {in} {out}", "xyz.lux"),
        subject("pplot", "--histogram {in} --kind png {out}", "xyz.lux"),
        subject("ra_exr", "{in} {out}", "xyz.lux"),
        subject("ra_loglv", "{in} {out}", "xyz.lux"),
        subject("ra_pfm", "{in} {out}", "xyz.lux"),
        subject("ra_pixlog", "{in} {out}", "xyz.lux"),
        subject("ra_png", "{in} {out}", "shown.lux"),
        subject("ra_rgbe", "{in} {out}", "xyz.lux"),
        subject("rad2scene", "{in} -o {out}", "sky.rad"),
        subject("relight", "scene.toml {in} {out}", "layers.lux"),
        subject("spec2xyz", "{in} {out}", "xyz.lux"),
        subject("specmat", "{in} {out}", "office.toml"),
        subject("specplan", "--pilot 64 {in} {out}", "scene.toml"),
        subject("specprobe", "--material gold {in} {out}", "materials.toml"),
        subject("spectrace", render, "scene.toml"),
        subject("tradeoff", trade, "scene.toml"),
        subject("vonkries", "--from A {in} {out}", "xyz.lux"),
        subject("xyz2rgb", "--gamut compress {in} {out}", "xyz.lux"),
    ]
}
