//! rad2scene: scenes written for Radiance as a scene of ours ([`crate::radiance`]).

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::filter::{Filter, Product, Run};
use crate::radiance::{self, view::View};
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults, usage};

/// Options of `rad2scene`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Rad2scene {
    /// Scene files, materials first, as oconv takes them; '-' is standard input
    #[arg(value_name = "SCENE.rad", value_hint = ValueHint::FilePath, required = true)]
    pub scenes: Vec<PathBuf>,
    /// Camera from a view file; of several lines the last counts. Without a view the scene has none. -vf does the same
    #[arg(long, value_name = "FILE.vf", value_hint = ValueHint::FilePath)]
    pub view: Option<PathBuf>,
    /// The same in rpict's words, after those of the file: -vtv, -vp 1 2 3, -vd 0 1 0 ... may also stand for themselves
    #[arg(long, value_name = "WORDS", allow_hyphen_values = true)]
    pub view_options: Option<String>,
    /// Most pixels across
    #[arg(long, value_name = "N", default_value_t = 512)]
    pub width: usize,
    /// Most pixels down; the view's angles shrink one of the two
    #[arg(long, value_name = "N", default_value_t = 512)]
    pub height: usize,
    /// What a length of 1 is: m, cm, mm, in or ft
    #[arg(long, value_name = "UNIT", default_value = "m")]
    pub unit: String,
    /// Leave out what cannot be read, one note a kind: patterns, textures, materials, commands
    #[arg(long)]
    pub skip_unknown: bool,
}
clap_defaults!(Rad2scene);

impl Filter for Rad2scene {
    const NAME: &'static str = "rad2scene";
    const ABOUT: &'static str = "Read scenes and views written for Radiance, write a scene for spectrace";
    const EXAMPLE: &'static str = "rad2scene -vf tests/data/rad/room.vf tests/data/rad/room.rad > room.toml && spectrace --width 64 --samples 16 room.toml - > room.lux
gensky 6 21 12 | rad2scene - tests/data/rad/sky.rad tests/data/rad/yard.rad > yard.toml";
    const READS: bool = false;
    const MANY: bool = true;
    const SIGNS: bool = false;
    const FORMATS: bool = false;

    /// Radiance's own view options become one of ours.
    fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
        let (mut rest, mut words): (Vec<OsString>, Vec<String>) = (Vec::new(), Vec::new());
        let mut args = args.into_iter().peekable();
        while let Some(arg) = args.next() {
            let numbers = match arg.to_str().unwrap_or_default() {
                "-vf" => {
                    rest.push("--view".into());
                    continue;
                }
                "-vp" | "-vd" | "-vu" => 3,
                "-vh" | "-vv" | "-vs" | "-vl" | "-vo" | "-va" => 1,
                kind if kind.len() == 4 && kind.starts_with("-vt") => 0,
                _ => {
                    rest.push(arg);
                    continue;
                }
            };
            words.push(arg.to_string_lossy().into_owned());
            // What is no number is not taken: it is missed later, with its option's name.
            for _ in 0..numbers {
                let number = args.next_if(|w| w.to_str().is_some_and(|w| w.parse::<f64>().is_ok()));
                words.extend(number.map(|w| w.to_string_lossy().into_owned()));
            }
        }
        if !words.is_empty() {
            rest.push(format!("--view-options={}", words.join(" ")).into());
        }
        Ok(rest)
    }

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        if !["m", "cm", "mm", "in", "ft"].contains(&self.unit.as_str()) {
            return usage!("--unit {}: expected m, cm, mm, in or ft", crate::error::printable(self.unit.as_bytes()));
        }
        if [self.width, self.height].iter().any(|n| !(1..=1_000_000).contains(n)) {
            return usage!("--width and --height: expected 1 to 1000000 pixels");
        }
        if self.scenes.iter().filter(|s| s.as_path() == Path::new("-")).count() > 1 {
            return usage!("standard input is named twice");
        }
        let view = self.camera()?;
        let options = radiance::Options { skip_unknown: self.skip_unknown };
        let size = (self.width, self.height);
        let text = radiance::convert(&self.scenes, view.as_ref(), size, &self.unit, &options, &run.notes)?;
        let write = move |out: &mut Output| std::io::Write::write_all(out, text.as_bytes()).map_err(|e| out.error(e));
        Ok(Product::Bytes { binary: false, write: Box::new(write) })
    }
}

impl Rad2scene {
    /// The view of the file and of the options; `None` without either.
    fn camera(&self) -> Result<Option<View>> {
        let mut view = None;
        if let Some(path) = &self.view {
            let text = crate::files::read(path).map_err(|e| Error::io(path.display().to_string(), e))?;
            let read = view.insert(View::default()).read(&String::from_utf8_lossy(&text));
            read.map_err(|e| e.in_file(path))?;
        }
        if let Some(words) = &self.view_options {
            let words: Vec<&str> = words.split_ascii_whitespace().collect();
            let read = view.get_or_insert_default().options(&words);
            read.map_err(|e| Error::Usage(format!("--view-options: {e}")))?;
        }
        Ok(view)
    }
}
