//! Options as data: one struct gives the command line, the TOML keys, the history line and the shell line.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Args, Command, ValueHint};
use serde::{Deserialize, Serialize};

use crate::color::{Primaries, White};
use crate::stream::meaning::Overrides;
use crate::stream::spool::Limits;
use crate::stream::writer::Format;
use crate::stream::{Components, Units};
use crate::{Error, Result, string_serde, usage};

/// The value of a type whose fields all have a default on the command line: defaults live there, and only there.
pub fn defaults<T: Args>() -> T {
    let command = T::augment_args(Command::new("defaults").no_binary_name(true)).mut_args(|a| a.required(false));
    let matches = command.try_get_matches_from(std::iter::empty::<&OsStr>());
    // Cannot fail on any input: there is none. A wrong default in the source fails the first test that runs.
    matches.and_then(|m| T::from_arg_matches(&m)).expect("every option has a valid default")
}

/// `impl Default` by [`defaults`].
#[macro_export]
macro_rules! clap_defaults {
    ($($type:ty),*) => { $(
        impl Default for $type {
            fn default() -> Self {
                $crate::options::defaults()
            }
        }
    )* };
}

/// How to run: none of this changes a pixel.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[command(next_help_heading = "Running")]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RunOptions {
    /// Threads to use; 0 means all processors
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// No notes and no progress on standard error
    #[arg(long)]
    pub quiet: bool,
    /// Memory that a picture which must be held may take, such as 512M or 2G; the rest goes to --tmp
    #[arg(long, value_name = "SIZE", default_value = "1G")]
    pub memory: Size,
    /// Folder for what does not fit in memory
    #[arg(long, value_name = "DIR", default_value = "/var/tmp", value_hint = ValueHint::DirPath)]
    pub tmp: PathBuf,
}

impl RunOptions {
    /// What a picture that must be kept may take, and where.
    pub fn limits(&self) -> Limits {
        Limits { memory: self.memory.0, folder: self.tmp.clone() }
    }
}

/// What to read, and what to take it for.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[command(next_help_heading = "Reading")]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct ReadOptions {
    /// Picture to read: a float stream, Radiance, LogLuv, Pixar log, OpenEXR, PFM or PNG; standard input if absent or '-'
    #[arg(value_name = "INPUT", value_hint = ValueHint::FilePath)]
    pub input: Option<PathBuf>,
    /// Take the components for Y, XYZ, RGB, SPECTRUM or STOKES, whatever the header says
    #[arg(long, value_name = "KIND")]
    pub components: Option<Components>,
    /// Take the values as W/sr/m2/nm, cd/m2, display or none
    #[arg(long, value_name = "UNIT")]
    pub units: Option<Units>,
    /// Take this as the scene's white: x,y, an illuminant's name, or a temperature such as 2856K
    #[arg(long, value_name = "WHITE")]
    pub white: Option<White>,
    /// Take these as the primaries of RGB: a name or eight numbers
    #[arg(long, value_name = "PRIMARIES")]
    pub primaries: Option<Primaries>,
}

impl ReadOptions {
    /// What stands in place of header lines.
    pub fn overrides(&self) -> Overrides {
        let white = self.white.as_ref().and_then(White::xy);
        Overrides { components: self.components, units: self.units, white, primaries: self.primaries }
    }

    /// Refuses a white that a picture would have to be asked for.
    pub fn check(&self) -> Result<()> {
        match &self.white {
            Some(white) if white.xy().is_none() => {
                usage!("--white {white}: expected x,y, an illuminant or a temperature")
            }
            _ => Ok(()),
        }
    }
}

/// Where to write.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[command(next_help_heading = "Writing")]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct OutputOptions {
    /// File to write, whole or not at all; standard output if absent or '-'
    #[arg(value_name = "OUTPUT", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
}

/// How to write a picture.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[command(next_help_heading = "Writing")]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct FormatOptions {
    /// Coding of the pixels
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "float")]
    pub format: Format,
}

clap_defaults!(RunOptions, ReadOptions, OutputOptions, FormatOptions);

/// A number of bytes: 1048576, 512k, 64M, 2G.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub u64);

impl FromStr for Size {
    type Err = Error;
    fn from_str(s: &str) -> Result<Size> {
        let (digits, shift) = match s.as_bytes().last() {
            Some(b'k' | b'K') => (&s[..s.len() - 1], 10),
            Some(b'm' | b'M') => (&s[..s.len() - 1], 20),
            Some(b'g' | b'G') => (&s[..s.len() - 1], 30),
            _ => (s, 0),
        };
        let bytes = digits.parse::<u64>().ok().and_then(|n| n.checked_mul(1 << shift));
        bytes.map(Size).ok_or_else(|| Error::Invalid(format!("'{s}' is no size; give for instance 512M or 2G")))
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (value, suffix) = match self.0 {
            n if n > 0 && n % (1 << 30) == 0 => (n >> 30, "G"),
            n if n > 0 && n % (1 << 20) == 0 => (n >> 20, "M"),
            n if n > 0 && n % (1 << 10) == 0 => (n >> 10, "k"),
            n => (n, ""),
        };
        write!(f, "{value}{suffix}")
    }
}
string_serde!(Size);

/// What a string-like option may be in TOML.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum Scalar {
    /// `"D65"`
    Text(String),
    /// `6`
    Integer(i64),
    /// `0.5`
    Float(f64),
    /// `[0.3127, 0.329]`
    List(Vec<Scalar>),
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Scalar::Text(s) => f.write_str(s),
            Scalar::Integer(n) => write!(f, "{n}"),
            Scalar::Float(x) => write!(f, "{x}"),
            Scalar::List(items) => {
                for (i, item) in items.iter().enumerate() {
                    write!(f, "{}{item}", if i > 0 { "," } else { "" })?;
                }
                Ok(())
            }
        }
    }
}

/// Numbers separated by commas.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers(pub Vec<f64>);

impl FromStr for Numbers {
    type Err = Error;
    fn from_str(s: &str) -> Result<Numbers> {
        let numbers: Option<Vec<f64>> =
            s.split(',').map(|t| t.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        numbers.map(Numbers).ok_or_else(|| Error::Invalid("expected numbers separated by commas".into()))
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let words: Vec<String> = self.0.iter().map(f64::to_string).collect();
        f.write_str(&words.join(","))
    }
}
string_serde!(Numbers);

/// Two numbers a:b, such as a range of rows or wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range(pub f64, pub f64);

impl FromStr for Range {
    type Err = Error;
    fn from_str(s: &str) -> Result<Range> {
        let pair = s.split_once(':').and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
        match pair {
            Some((a, b)) if f64::is_finite(a) && f64::is_finite(b) && a < b => Ok(Range(a, b)),
            _ => Err(Error::Invalid(format!("'{s}' is no range; give a:b with a below b, such as 380:780"))),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}", self.0, self.1)
    }
}
string_serde!(Range);

/// Two sizes WxH, such as a legend's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair(pub usize, pub usize);

impl FromStr for Pair {
    type Err = Error;
    fn from_str(s: &str) -> Result<Pair> {
        let size = |t: &str| t.trim().parse().ok().filter(|n: &usize| *n <= 1 << 16);
        let pair = s.split_once('x').and_then(|(w, h)| Some(Pair(size(w)?, size(h)?)));
        pair.ok_or_else(|| Error::Invalid(format!("'{s}' is no size; give width x height in pixels, such as 100x200")))
    }
}

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}x{}", self.0, self.1)
    }
}
string_serde!(Pair);

/// Serialises a path that may not be Unicode, for history lines and shell lines.
pub fn lossy<S: serde::Serializer>(path: &Option<PathBuf>, s: S) -> Result<S::Ok, S::Error> {
    path.as_ref().map(|p| p.to_string_lossy().into_owned()).serialize(s)
}

/// The same for a path that is always there.
pub fn lossy_path<S: serde::Serializer>(path: &Path, s: S) -> Result<S::Ok, S::Error> {
    path.to_string_lossy().serialize(s)
}

/// The words that give `options` on a command line, in the order of their definition, defaults left out. `history` also
/// leaves out everything that changes no pixel and keeps of files their last path part.
pub fn words<T: Args + Serialize + Default>(options: &T, history: bool) -> Vec<String> {
    let table = |t: &T| toml::Table::try_from(t).unwrap_or_default();
    let (given, default) = (table(options), table(&T::default()));
    let command = T::augment_args(Command::new("words"));
    let mut words = Vec::new();
    for arg in command.get_arguments() {
        let key = arg.get_id().as_str().replace('_', "-");
        let Some(value) = given.get(&key).filter(|v| default.get(&key) != Some(*v)) else { continue };
        if history && arg.get_help_heading().is_some_and(|h| h.starts_with("Running")) {
            continue;
        }
        push_words(arg, value, history, &mut words);
    }
    words
}

/// What an option's file is for: one that is read has [`ValueHint::FilePath`], one that is written [`ValueHint::AnyPath`], one that is kept
/// for the next time [`ValueHint::Other`].
fn is_file(arg: &Arg) -> bool {
    matches!(arg.get_value_hint(), ValueHint::FilePath | ValueHint::AnyPath | ValueHint::Other)
}

/// What an option calls its value where that may be a name that luxpipe knows instead of a file.
const NAMES: [&str; 3] = ["DISPLAY", "ILLUMINANT", "RESPONSE"];

/// Files that options name, to read or (`written`) to write.
pub fn files<T: Args + Serialize>(options: &T, written: bool) -> Vec<PathBuf> {
    let table = toml::Table::try_from(options).unwrap_or_default();
    let command = T::augment_args(Command::new("files"));
    let hint = if written { ValueHint::AnyPath } else { ValueHint::FilePath };
    let mut files = Vec::new();
    for arg in command.get_arguments().filter(|a| a.get_value_hint() == hint) {
        let named =
            |p: &&str| arg.get_value_names().is_some_and(|v| NAMES.contains(&v[0].as_str())) && !Path::new(p).is_file();
        let value = table.get(&arg.get_id().as_str().replace('_', "-"));
        let list = match value {
            Some(toml::Value::Array(list)) => list.iter().filter_map(|v| v.as_str()).collect(),
            one => one.and_then(|v| v.as_str()).into_iter().collect::<Vec<_>>(),
        };
        files.extend(list.into_iter().filter(|p| *p != "-" && !named(p)).map(PathBuf::from));
    }
    files
}

fn push_words(arg: &Arg, value: &toml::Value, history: bool, words: &mut Vec<String>) {
    let text = |v: &toml::Value| match v {
        toml::Value::String(s) if history && is_file(arg) => {
            // A weight in front stays.
            let weighted = s.split_once(':').filter(|(weight, _)| weight.parse::<f64>().is_ok());
            let (weight, path) = weighted.map_or((String::new(), s.as_str()), |(w, p)| (format!("{w}:"), p));
            Path::new(path).file_name().map_or(s.clone(), |n| weight + &n.to_string_lossy())
        }
        toml::Value::String(s) => s.clone(),
        other => other.to_string().trim_end_matches(".0").to_string(),
    };
    let long = arg.get_long().map(|l| format!("--{l}"));
    let mut one = |v: &toml::Value| match (&long, v) {
        (Some(long), toml::Value::Boolean(true)) => words.push(long.clone()),
        // A switch that another option has turned on.
        (Some(long), toml::Value::Boolean(false)) => words.push(format!("{long}=false")),
        (None, toml::Value::Boolean(_)) => {}
        (Some(long), v) => {
            let value = text(v);
            // A value that begins with a dash would be read as an option.
            if value.starts_with('-') {
                words.push(format!("{long}={value}"));
            } else {
                words.extend([long.clone(), value]);
            }
        }
        (None, v) => words.push(text(v)),
    };
    match value {
        toml::Value::Array(items) => items.iter().for_each(&mut one),
        v => one(v),
    }
}

/// The name that a program of ours is installed by: with the prefix that the running one has (`make install PROGRAM_PREFIX=lux-`).
pub fn installed(name: &str) -> String {
    let own = std::env::args_os().next().map(PathBuf::from);
    let own = own.as_deref().and_then(Path::file_name).and_then(OsStr::to_str).unwrap_or_default();
    let prefix = ["luxpipe", "tradeoff"].iter().find_map(|program| own.strip_suffix(program));
    format!("{}{name}", prefix.unwrap_or_default())
}

/// A word as a shell would need it.
///
/// ```
/// assert_eq!(luxpipe::options::quote("it's"), r"'it'\''s'");
/// assert_eq!(luxpipe::options::quote("scenes/cornell.toml"), "scenes/cornell.toml");
/// ```
pub fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-+=./:,@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Clap's message without its usage block: what is wrong, and the hint if there is one.
pub fn one_line(e: &clap::Error) -> String {
    let rendered = e.to_string();
    let text: Vec<&str> =
        rendered.lines().take_while(|l| !l.starts_with("Usage:") && !l.is_empty()).map(str::trim).collect();
    let mut line = text.join(" ").trim_start_matches("error: ").to_string();
    for (kind, hint) in [(ContextKind::SuggestedArg, "did you mean"), (ContextKind::SuggestedValue, "did you mean")] {
        match e.get(kind) {
            Some(ContextValue::String(s)) => line += &format!("; {hint} '{s}'?"),
            Some(ContextValue::Strings(s)) if !s.is_empty() => line += &format!("; {hint} '{}'?", s.join("' or '")),
            _ => {}
        }
    }
    if matches!(e.kind(), ErrorKind::UnknownArgument | ErrorKind::MissingRequiredArgument) {
        line += "; see --help";
    }
    line
}
