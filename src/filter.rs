//! What a filter is: options, and a picture in, a picture or bytes out. The command line, the TOML stage, the man page, the
//! history line and the shell line all come from the options' definition.

use std::borrow::Cow;
use std::ffi::OsString;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeTable;

use crate::codec::Reading;
use crate::notes::Notes;
use crate::options::{FormatOptions, OutputOptions, ReadOptions, RunOptions, files, quote, words};
use crate::stream::output::Output;
use crate::stream::writer::{self, Format};
use crate::stream::{Block, Header, Picture, header, meaning, picture, reader};
use crate::{Result, codec, parallel, simd};

/// One filter.
pub trait Filter: Args + Serialize + DeserializeOwned + Default + Clone + Send + 'static {
    /// Name of the program.
    const NAME: &'static str;
    /// One line: what it does.
    const ABOUT: &'static str;
    /// Shown below the help: one or more commands that work when pasted.
    const EXAMPLE: &'static str;
    /// Has options for reading a picture (a renderer has not).
    const READS: bool = true;
    /// Takes any number of files, so that the output is named by `--output` instead of coming second.
    const MANY: bool = false;
    /// Its picture may be written with `--format`.
    const FORMATS: bool = true;
    /// Leaves its line in the picture's history.
    const SIGNS: bool = true;
    /// Suffixes of the files it records pictures in, without a dot.
    const SUFFIXES: &'static [&'static str] = &[];

    /// The options that record a picture in a file of that suffix.
    fn for_suffix(_suffix: &str) -> Self {
        Self::default()
    }

    /// Turns an older command line into today's, before it is parsed.
    fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
        Ok(args)
    }

    /// Reads a picture with these options.
    fn reads(&self) -> bool {
        Self::READS
    }

    /// Learns how it is placed: what it will read, and where it will write.
    fn placed(&mut self, _read: &ReadOptions, _output: Option<&Path>) -> Result<()> {
        Ok(())
    }

    /// Opens what the work depends on beside the files that options name, so that [`crate::files`] notes it; the number of rows, where the
    /// work can be done in parts by `--rows`.
    fn look_ahead(&self) -> Result<Option<usize>> {
        Ok(None)
    }

    /// Begins the work. `input` is there exactly when [`Filter::reads`] is true.
    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product>;
}

/// What a filter makes.
pub enum Product {
    /// A picture, to be written as a stream or handed to the next stage.
    Picture(Box<dyn Picture>),
    /// Bytes of a kind of its own.
    Bytes {
        /// Not for a terminal.
        binary: bool,
        /// Writes them all.
        write: Writer,
    },
}

/// Work that ends in bytes.
pub type Writer = Box<dyn FnOnce(&mut Output) -> Result<()> + Send>;

/// What surrounds the work.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// How to run.
    pub options: RunOptions,
    /// Remarks for standard error.
    pub notes: Notes,
    /// The filter's line for the history.
    pub history: Vec<u8>,
    /// The end of that line: how it reads and writes.
    ending: Vec<u8>,
}

impl Run {
    /// The line that the filter would leave with these options instead.
    pub fn history_of<F: Filter>(&self, own: &F) -> Vec<u8> {
        line(F::NAME, &words(own, true), &self.ending)
    }
}

/// A line of the history: control bytes as \xNN keep it one line.
fn line(name: &str, words: &[String], ending: &[u8]) -> Vec<u8> {
    let mut line = name.as_bytes().to_vec();
    for word in words {
        line.push(b' ');
        line.extend(escape(&quote(word)));
    }
    line.extend(ending);
    line
}

/// Begins the work of a stage, as [`Filter::start`] does.
pub type Start = Box<dyn FnOnce(Option<Box<dyn Picture>>, &Run) -> Result<Product> + Send>;

/// A filter with its options settled, its type forgotten.
pub struct Stage {
    /// Name of the filter, or of another program.
    pub name: Cow<'static, str>,
    /// What to read.
    pub read: ReadOptions,
    /// Where to write.
    pub output: Option<PathBuf>,
    /// How to write a picture.
    pub format: Format,
    /// How to run.
    pub run: RunOptions,
    /// Needs a picture.
    pub reads: bool,
    /// Files that it writes beside its output.
    pub writes: Vec<PathBuf>,
    /// Files that its options name.
    pub needs: Vec<PathBuf>,
    /// Opens whatever else it depends on, as [`Filter::look_ahead`] does.
    pub look_ahead: Box<dyn Fn() -> Result<Option<usize>> + Send>,
    positional: bool,
    many: bool,
    signs: bool,
    history: Vec<u8>,
    ending: Vec<u8>,
    words: Vec<String>,
    placed: Result<()>,
    start: Start,
}

/// The command line of a filter.
pub fn command<F: Filter>() -> Command {
    let mut c = F::augment_args(Command::new(F::NAME));
    if F::READS {
        c = ReadOptions::augment_args(c);
    }
    c = OutputOptions::augment_args(c);
    if F::MANY {
        c = c.mut_arg("output", |a| a.short('o').long("output"));
    }
    if F::FORMATS {
        c = FormatOptions::augment_args(c);
    }
    dress(RunOptions::augment_args(c), F::ABOUT, F::EXAMPLE)
}

/// What every program's command line has: an example, `--help` and `--version` (no `-h`, which is `pcond`'s).
pub fn dress(command: Command, about: &'static str, example: &str) -> Command {
    let flag = |name, help, action| Arg::new(name).long(name).help(help).action(action).help_heading("Running");
    command
        .about(about)
        .version(env!("CARGO_PKG_VERSION"))
        .after_help(format!("Example:\n  {}", example.replace('\n', "\n  ")))
        .allow_negative_numbers(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .arg(flag("help", "Print this help", ArgAction::Help))
        .arg(flag("version", "Print the version", ArgAction::Version))
}

impl Stage {
    /// From a parsed command line.
    pub fn from_matches<F: Filter>(m: &ArgMatches) -> Result<Stage, clap::Error> {
        let read = if F::READS { ReadOptions::from_arg_matches(m)? } else { ReadOptions::default() };
        let format = if F::FORMATS { FormatOptions::from_arg_matches(m)? } else { FormatOptions::default() };
        let output = OutputOptions::from_arg_matches(m)?.output;
        Ok(Stage::new(F::from_arg_matches(m)?, read, output, format, RunOptions::from_arg_matches(m)?))
    }

    /// From options.
    pub fn new<F: Filter>(
        mut own: F,
        read: ReadOptions,
        output: Option<PathBuf>,
        format: FormatOptions,
        run: RunOptions,
    ) -> Stage {
        let placed = read.check().and_then(|()| own.placed(&read, output.as_deref()));
        let reading = ReadOptions { input: None, ..read.clone() };
        let around = |history| {
            let mut list = if F::READS { words(&reading, history) } else { Vec::new() };
            list.extend(words(&format, history));
            list
        };
        let ending = line("", &around(true), b"");
        let history = line(F::NAME, &words(&own, true), &ending);
        let words = [words(&own, false), around(false), words(&run, false)].concat();
        let (needs, writes) = ([files(&own, false), files(&read, false)].concat(), files(&own, true));
        let twin = own.clone();
        Stage {
            name: F::NAME.into(),
            read,
            output,
            format: format.format,
            run,
            reads: own.reads(),
            writes,
            needs,
            look_ahead: Box::new(move || twin.look_ahead()),
            positional: F::READS,
            many: F::MANY,
            signs: F::SIGNS,
            history,
            ending,
            words,
            placed,
            start: Box::new(move |input, run| own.start(input, run)),
        }
    }

    /// A program that is none of ours: it reads and writes as `start` has it.
    pub fn external(name: String, reads: bool, input: Option<PathBuf>, output: Option<PathBuf>, start: Start) -> Stage {
        Stage {
            name: name.into(),
            needs: input.clone().into_iter().collect(),
            read: ReadOptions { input, ..Default::default() },
            output,
            format: Format::default(),
            run: RunOptions::default(),
            reads,
            writes: Vec::new(),
            look_ahead: Box::new(|| Ok(None)),
            positional: false,
            many: false,
            signs: false,
            history: Vec::new(),
            ending: Vec::new(),
            words: Vec::new(),
            placed: Ok(()),
            start,
        }
    }

    /// Rows `from` to `to` of the work alone, by `--rows`, as words; the output last.
    pub fn part_words(&self, (from, to): (usize, usize), output: &str) -> Vec<String> {
        let mut list = self.command_words(None, None);
        list.extend(["--rows".to_string(), format!("{from}:{to}")]);
        list.push(plain_name(output));
        list
    }

    /// The command as a list of words; positionals last. `input` and `output` stand in place of the stage's own.
    pub fn command_words(&self, input: Option<&str>, output: Option<&str>) -> Vec<String> {
        let mut list = vec![self.name.to_string()];
        list.extend(self.words.clone());
        let read = input.or(if self.positional && output.is_some() { Some("-") } else { None });
        list.extend(read.map(plain_name));
        list.extend(output.filter(|_| self.many).map(|_| "--output".into()));
        list.extend(output.map(plain_name));
        list
    }

    /// Begins the work on `input`, or on what the stage itself names.
    pub fn start(self, input: Option<Box<dyn Picture>>, notes: &Notes) -> Result<Product> {
        self.placed?;
        let run = Run { options: self.run, notes: notes.clone(), history: self.history, ending: self.ending };
        let input = match input {
            _ if !self.reads => None,
            Some(picture) => Some(Reheaded::passed_on(picture, &self.read)?),
            None => {
                let input = reader::Input::open(self.read.input.as_deref())?;
                let (overrides, limits) = (self.read.overrides(), run.options.limits());
                Some(codec::open(input, &Reading { overrides: &overrides, limits: &limits, notes })?)
            }
        };
        let signed = |picture: Box<dyn Picture>| -> Box<dyn Picture> {
            let mut header = picture.header().clone();
            header.lines.push(run.history.clone());
            Box::new(Reheaded { header, factors: None, input: picture })
        };
        let input = if self.signs { input.map(signed) } else { input };
        (self.start)(input, &run)
    }

    /// Does the whole work.
    pub fn run(self, input: Option<Box<dyn Picture>>, notes: &Notes) -> Result<()> {
        let (output, format) = (self.output.clone(), self.format);
        finish(self.start(input, notes)?, output, format, notes)
    }
}

/// A file whose name begins with a dash is an option to nobody.
fn plain_name(name: &str) -> String {
    if name.starts_with('-') && name != "-" { format!("./{name}") } else { name.to_string() }
}

/// Writes what a filter made where it belongs.
pub fn finish(product: Product, output: Option<PathBuf>, format: Format, notes: &Notes) -> Result<()> {
    match product {
        Product::Picture(picture) => {
            let mut out = Output::create(output.as_deref(), true)?;
            writer::write(picture, format, &mut out, notes)?;
            out.finish()
        }
        Product::Bytes { binary, write } => {
            let mut out = Output::create(output.as_deref(), binary)?;
            write(&mut out)?;
            out.finish()
        }
    }
}

/// Control bytes as \xNN.
fn escape(text: &str) -> Vec<u8> {
    text.chars()
        .flat_map(|c| if c.is_control() { format!("\\x{:02x}", c as u32) } else { c.to_string() }.into_bytes())
        .collect()
}

/// A picture under another header.
struct Reheaded {
    header: Header,
    factors: Option<Vec<f32>>,
    input: Box<dyn Picture>,
}

impl Reheaded {
    /// What the next stage would see through a pipe: the header is written and read again, so that a fused chain and a
    /// shell pipe cannot differ.
    fn passed_on(picture: Box<dyn Picture>, read: &ReadOptions) -> Result<Box<dyn Picture>> {
        let bytes = picture.header().to_bytes("float", &[]);
        let settled = meaning::settle(header::read_raw(&mut bytes.as_slice())?, &read.overrides())?;
        Ok(Box::new(Reheaded { header: settled.header, factors: settled.factors, input: picture }))
    }
}

impl Picture for Reheaded {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        if let Some(factors) = &self.factors {
            picture::scale(&mut block.data, factors);
        }
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.input.rewind()
    }
}

/// A filter whose type does not matter, for lists.
pub trait Any: Sync {
    /// Name of the program.
    fn name(&self) -> &'static str;
    /// Its command line.
    fn command(&self) -> Command;
    /// Suffixes of the files it records pictures in.
    fn suffixes(&self) -> &'static [&'static str];
    /// The stage that records a picture under this name.
    fn saver(&self, suffix: &str, path: PathBuf) -> Stage;
    /// From the keys of a stage's table: the long options letter for letter, `input` and `output` the positionals.
    fn stage(&self, table: Spanned<DeTable<'_>>) -> Result<Stage, toml::de::Error>;
}

/// The [`Any`] of a filter.
pub struct Entry<F>(PhantomData<fn() -> F>);

impl<F> Entry<F> {
    /// The one value there is.
    pub const NEW: Self = Entry(PhantomData);
}

impl<F: Filter> Any for Entry<F> {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn command(&self) -> Command {
        command::<F>()
    }

    fn suffixes(&self) -> &'static [&'static str] {
        F::SUFFIXES
    }

    fn saver(&self, suffix: &str, path: PathBuf) -> Stage {
        Stage::new(F::for_suffix(suffix), Default::default(), Some(path), Default::default(), Default::default())
    }

    fn stage(&self, table: Spanned<DeTable<'_>>) -> Result<Stage, toml::de::Error> {
        let mut rest = table;
        let read = if F::READS { take::<ReadOptions>(&mut rest)? } else { ReadOptions::default() };
        let output = take::<OutputOptions>(&mut rest)?.output;
        let format = if F::FORMATS { take::<FormatOptions>(&mut rest)? } else { FormatOptions::default() };
        let run = take::<RunOptions>(&mut rest)?;
        let own = F::deserialize(toml::de::Deserializer::from(rest))?;
        let stage = Stage::new(own, read, output, format, run);
        // What options exclude or need each other is the command line's to say.
        let words = stage.command_words(None, None);
        match command::<F>().try_get_matches_from(words) {
            Ok(_) => Ok(stage),
            Err(e) => Err(serde::de::Error::custom(crate::options::one_line(&e))),
        }
    }
}

/// Takes the keys of `T` out of a table and makes a `T` of them.
fn take<T: Args + DeserializeOwned>(table: &mut Spanned<DeTable<'_>>) -> Result<T, toml::de::Error> {
    let command = T::augment_args(Command::new("keys"));
    let keys: Vec<String> = command.get_arguments().map(|a| a.get_id().as_str().replace('_', "-")).collect();
    let span = table.span();
    let mut part = DeTable::new();
    for key in &keys {
        if let Some((key, value)) = table.get_mut().remove_entry(key.as_str()) {
            part.insert(key, value);
        }
    }
    T::deserialize(toml::de::Deserializer::from(Spanned::new(span, part)))
}

/// Sets up what is global to the process. Call once.
///
/// # Errors
/// [`simd::check`].
pub fn prepare(run: &RunOptions) -> Result<()> {
    parallel::set_threads(run.threads);
    simd::check()
}
