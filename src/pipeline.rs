//! Pipelines: a TOML file of stages, run in one process or printed as the shell command it stands for.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use clap::{Args, ValueHint};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::display::Display;
use crate::filter::{self, Product, Stage};
use crate::filters::{self, Intent};
use crate::keys::located;
use crate::notes::Notes;
use crate::options::{ReadOptions, RunOptions, quote};
use crate::stream::writer::Format;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, invalid, usage};

/// Command line of `luxpipe`.
#[derive(Args, Clone, Debug)]
pub struct Luxpipe {
    /// Pipeline to run; with --intent, the picture or scene (.toml) to show
    #[arg(value_name = "PIPELINE", value_hint = ValueHint::FilePath)]
    pub pipeline: PathBuf,
    /// With --intent: PNG to write; standard output if absent or '-'
    #[arg(value_name = "OUTPUT", value_hint = ValueHint::FilePath, requires = "intent")]
    pub output: Option<PathBuf>,
    /// In place of a pipeline file, the whole chain for a rendering intent, from PIPELINE to OUTPUT
    #[arg(long, value_enum, value_name = "INTENT")]
    pub intent: Option<Intent>,
    /// With --intent: display to show it on, by name or file
    #[arg(long, value_name = "DISPLAY", default_value = "srgb", value_hint = ValueHint::FilePath)]
    pub display: Display,
    /// Print the same work as a shell command, and do nothing
    #[arg(long)]
    pub shell: bool,
    /// How to run.
    #[command(flatten)]
    pub run: RunOptions,
}

/// The command line of `luxpipe`.
pub fn command() -> clap::Command {
    let about = "Run a TOML pipeline: its stages in one process, the bytes those of the shell pipe";
    let example = "luxpipe pipelines/cornell.toml\nluxpipe --shell pipelines/cornell.toml | sh\nluxpipe --intent perceptual --display p3 office.hdr office.png";
    filter::dress(Luxpipe::augment_args(clap::Command::new("luxpipe")), about, example)
}

/// The last file descriptor that a POSIX shell lets a saved stage use; 9 carries the picture out.
const LAST_DESCRIPTOR: usize = 8;

/// A pipeline read from its file.
pub struct Pipeline {
    stages: Vec<Step>,
}

struct Step {
    stage: Stage,
    save: Option<PathBuf>,
}

impl Pipeline {
    /// Reads and checks a pipeline; nothing is opened yet.
    pub fn load(path: &Path) -> Result<Pipeline> {
        let text = fs::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
        Pipeline::parse(&text).map_err(|e| e.in_file(path))
    }

    /// Reads and checks a pipeline's text.
    pub fn parse(text: &str) -> Result<Pipeline> {
        let at = |e: toml::de::Error| located(text, e.span(), e.message());
        let root = DeTable::parse(text).map_err(at)?;
        let mut steps = Vec::new();
        for (key, value) in root.into_inner() {
            let span = key.span();
            match (key.get_ref().as_ref(), value.into_inner()) {
                ("name", DeValue::String(_)) => {}
                ("name", _) => return Err(located(text, Some(span), "name must be a string")),
                ("stage", DeValue::Array(stages)) => {
                    for stage in stages {
                        steps.push(step(text, stage)?);
                    }
                }
                ("stage", _) => return Err(located(text, Some(span), "stages are written [[stage]]")),
                (other, _) => {
                    let other = crate::error::printable(other.as_bytes());
                    return Err(located(
                        text,
                        Some(span),
                        &format!("unknown key '{other}', expected name or [[stage]]"),
                    ));
                }
            }
        }
        check(&steps)?;
        Ok(Pipeline { stages: steps })
    }

    /// The chain that an intent means. Perceptual and saturation: adaptation, histogram adjustment, the gamut rule, PNG;
    /// colorimetric: the stimulus itself, PNG. A scene is rendered first.
    pub fn of_intent(intent: Intent, input: &Path, output: Option<PathBuf>, display: &Display) -> Result<Pipeline> {
        let png = |p: &PathBuf| p.as_os_str() == "-" || p.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if let Some(other) = output.as_ref().filter(|p| !png(p)) {
            return usage!("{}: --intent writes PNG; name a .png file", other.display());
        }
        let display = || Some(display.clone());
        let mut chain = Chain { stages: Vec::new(), input: Some(input.to_path_buf()) };
        if input.extension().is_some_and(|e| e == "toml") {
            chain.input = None;
            chain.add(filters::Spectrace { scene: Some(input.to_path_buf()), ..Default::default() });
        }
        if intent != Intent::Colorimetric {
            chain.add(filters::Vonkries { display: display(), ..Default::default() });
            chain.add(filters::Pcond { display: display(), ..Default::default() });
        }
        chain.add(filters::Xyz2rgb { display: display(), intent: Some(intent), ..Default::default() });
        chain.add(filters::RaPng { display: display(), ..Default::default() });
        if let Some(last) = chain.stages.last_mut() {
            last.stage.output = output;
        }
        Ok(Pipeline { stages: chain.stages })
    }

    /// Runs all stages in this process. The bytes are those of the shell command.
    pub fn run(self, notes: &Notes) -> Result<()> {
        let mut picture: Option<Box<dyn Picture>> = None;
        let last = self.stages.len() - 1;
        for (i, step) in self.stages.into_iter().enumerate() {
            let name = step.stage.name;
            let (output, format) = (step.stage.output.clone(), step.stage.format);
            let notes = &notes.of(name);
            let product = step.stage.start(picture.take(), notes).map_err(|e| e.within(name))?;
            let product = match (product, step.save) {
                (product, None) => product,
                (Product::Picture(p), Some(path)) => Product::Picture(Tee::start(p, &path, notes)?),
                (Product::Bytes { .. }, Some(_)) => return invalid!("{name} makes no picture that could be saved"),
            };
            match product {
                product if i == last => return filter::finish(product, output, format, notes),
                Product::Picture(p) => picture = Some(p),
                Product::Bytes { .. } => {
                    return invalid!("{name} makes no picture; only the last stage may end the stream");
                }
            }
        }
        Ok(())
    }

    /// The shell command for the same work. A saved stage is a `tee` to a descriptor that another filter reads, so that
    /// any POSIX shell waits for all of it.
    pub fn shell(&self) -> Result<String> {
        let mut command = Vec::new();
        let mut savers = Vec::new();
        let last = self.stages.len() - 1;
        for (i, step) in self.stages.iter().enumerate() {
            let name = |p: &Option<PathBuf>| p.as_ref().map(|p| p.display().to_string());
            let input = if i == 0 { name(&step.stage.read.input) } else { None };
            let output = if i == last { name(&step.stage.output) } else { None };
            let mut words = step.stage.command_words(input.as_deref(), output.as_deref());
            if step.stage.format != Format::Float && i < last {
                return invalid!("format goes with the last stage");
            }
            words.iter_mut().for_each(|w| *w = quote(w));
            command.push(words.join(" "));
            match step.save.as_deref().map(saver).transpose()? {
                None => {}
                Some(save) => {
                    let descriptor = savers.len() + 3;
                    if descriptor > LAST_DESCRIPTOR {
                        return invalid!(
                            "a shell command can save {} stages, this pipeline saves more",
                            LAST_DESCRIPTOR - 2
                        );
                    }
                    command.push(format!("tee /dev/fd/{descriptor}"));
                    savers.push((descriptor, save.command_words(None, name(&save.output).as_deref())));
                }
            }
        }
        let mut line = command.join(" | ");
        if savers.is_empty() {
            return Ok(line);
        }
        // The picture itself leaves by descriptor 9 while descriptor 1 of each group feeds a saver.
        line += " >&9";
        for (descriptor, words) in savers {
            let words: Vec<String> = words.iter().map(|w| quote(w)).collect();
            line = format!("{{ {line}; }} {descriptor}>&1 | {}", words.join(" "));
        }
        Ok(format!("{{ {line}; }} 9>&1"))
    }
}

/// Stages one after the other; the first that reads gets the input.
struct Chain {
    stages: Vec<Step>,
    input: Option<PathBuf>,
}

impl Chain {
    fn add<F: filter::Filter>(&mut self, own: F) {
        let read =
            if F::READS { ReadOptions { input: self.input.take(), ..Default::default() } } else { Default::default() };
        let stage = Stage::new(own, read, None, Default::default(), Default::default());
        self.stages.push(Step { stage, save: None });
    }
}

fn step(text: &str, stage: Spanned<DeValue>) -> Result<Step> {
    let span = stage.span();
    let DeValue::Table(mut table) = stage.into_inner() else {
        return Err(located(text, Some(span), "a stage is a table"));
    };
    let at = |span: Range<usize>, message: &str| located(text, Some(span), message);
    let Some(run) = table.remove("run") else { return Err(at(span, "a stage needs run = \"FILTER\"")) };
    let Some(name) = run.get_ref().as_str() else { return Err(at(run.span(), "run must be a filter's name")) };
    let Some(entry) = filters::named(name) else {
        let names: Vec<&str> = filters::ALL.iter().map(|f| f.name()).collect();
        let name = crate::error::printable(name.as_bytes());
        return Err(at(run.span(), &format!("no filter '{name}'; there are {}", names.join(", "))));
    };
    let save = match table.remove("save") {
        None => None,
        Some(save) => {
            let path = save.get_ref().as_str().map(PathBuf::from);
            let path = path.ok_or_else(|| at(save.span(), "save must be a file name"))?;
            saver(&path).map_err(|e| at(save.span(), &e.to_string()))?;
            Some(path)
        }
    };
    let place = span.clone();
    let stage =
        entry.stage(Spanned::new(span, table)).map_err(|e| located(text, e.span().or(Some(place)), e.message()))?;
    Ok(Step { stage, save })
}

/// Checks what concerns more than one stage.
fn check(steps: &[Step]) -> Result<()> {
    let Some(last) = steps.len().checked_sub(1) else { return invalid!("a pipeline needs at least one [[stage]]") };
    let mut written: Vec<&Path> = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let name = step.stage.name;
        let nth = i + 1;
        if i > 0 && !step.stage.reads {
            return invalid!("stage {nth}, {name}: reads no picture and so must be the first");
        }
        if i > 0 && step.stage.read.input.is_some() {
            return invalid!("stage {nth}, {name}: input goes with the first stage");
        }
        if i < last && step.stage.output.is_some() {
            return invalid!("stage {nth}, {name}: output goes with the last stage; save records a picture in between");
        }
        if i < last && step.stage.format != Format::Float {
            return invalid!("stage {nth}, {name}: format goes with the last stage");
        }
        for path in step.stage.output.iter().chain(&step.save) {
            if written.contains(&path.as_path()) {
                return invalid!("stage {nth}, {name}: two stages write {}", path.display());
            }
            written.push(path);
        }
    }
    Ok(())
}

/// The stage that records a picture under this name, by suffix.
fn saver(path: &Path) -> Result<Stage> {
    let suffix = path.extension().and_then(|s| s.to_str()).unwrap_or("").to_ascii_lowercase();
    match filters::ALL.iter().find(|f| f.suffixes().contains(&suffix.as_str())) {
        Some(filter) => Ok(filter.saver(&suffix, path.to_path_buf())),
        None => {
            let known: Vec<String> =
                filters::ALL.iter().flat_map(|f| f.suffixes()).map(|suffix| format!(".{suffix}")).collect();
            invalid!("cannot save '{}': known suffixes are {}", path.display(), known.join(", "))
        }
    }
}

/// Passes a picture on and records it on the way, on a thread of its own.
struct Tee {
    input: Box<dyn Picture>,
    header: Header,
    sender: Option<SyncSender<Block>>,
    recorder: Option<JoinHandle<Result<()>>>,
}

impl Tee {
    fn start(input: Box<dyn Picture>, path: &Path, notes: &Notes) -> Result<Box<dyn Picture>> {
        let header = input.header().clone();
        let (sender, receiver) = sync_channel(2);
        let copy = Box::new(Copy { header: header.clone(), receiver, rows: 0 });
        let (name, saver) = (format!("save {}", path.display()), saver(path)?);
        let notes = notes.of(&name);
        let recorder = std::thread::spawn(move || saver.run(Some(copy), &notes).map_err(|e| e.within(&name)));
        Ok(Box::new(Tee { input, header, sender: Some(sender), recorder: Some(recorder) }))
    }

    /// Waits for the recorder and passes on its failure.
    fn join(&mut self) -> Result<()> {
        self.sender = None;
        match self.recorder.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
        }
    }
}

impl Picture for Tee {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        if !more {
            return self.join().map(|()| false);
        }
        if self.sender.as_ref().is_some_and(|s| s.send(block.clone()).is_err()) {
            self.join()?;
            return invalid!("the recorder of a saved picture stopped early");
        }
        Ok(true)
    }
}

impl Drop for Tee {
    /// A stream that broke off leaves no file; one that was read to its end is whole already.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = self.join();
        }
    }
}

/// The recorder's end of a [`Tee`].
struct Copy {
    header: Header,
    receiver: Receiver<Block>,
    rows: usize,
}

impl Picture for Copy {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        if let Ok(received) = self.receiver.recv() {
            self.rows += received.rows;
            *block = received;
            return Ok(true);
        }
        let total = self.header.resolution.scanlines();
        if self.rows < total {
            return invalid!("the picture broke off at row {} of {total}", self.rows + 1);
        }
        block.rows = 0;
        block.data.clear();
        Ok(false)
    }
}
