//! What can go wrong, and the exit status each kind ends with.
//!
//! A message is one line: the input it concerns, what is wrong, where, and what would be right. The filter's name is put
//! in front by [`crate::cli`], the only place that prints.

use std::io;
use std::path::Path;

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every failure of a filter.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The data are wrong: damaged, contradictory, non-physical.
    #[error("{0}")]
    Invalid(String),
    /// The data are right, but this program cannot do what they ask.
    #[error("{0}")]
    Unsupported(String),
    /// The command line or an option's value is wrong.
    #[error("{0}")]
    Usage(String),
    /// The system refused.
    #[error("{what}: {source}")]
    Io {
        /// The file or stream it happened on.
        what: String,
        /// The system's own word.
        source: io::Error,
    },
}

impl Error {
    /// An I/O error on `what`.
    pub fn io(what: impl Into<String>, source: io::Error) -> Self {
        Error::Io { what: what.into(), source }
    }

    /// The same error, its message beginning with `name`.
    pub fn within(self, name: &str) -> Self {
        match self {
            Error::Invalid(m) => Error::Invalid(format!("{name}: {m}")),
            Error::Unsupported(m) => Error::Unsupported(format!("{name}: {m}")),
            Error::Usage(m) => Error::Usage(format!("{name}: {m}")),
            Error::Io { what, source } if what.is_empty() => Error::io(name, source),
            io => io,
        }
    }

    /// The same error, its message beginning with the file's name.
    pub fn in_file(self, path: &Path) -> Self {
        self.within(&path.display().to_string())
    }

    /// Exit status: 2 for usage, 1 for the rest.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            _ => 1,
        }
    }

    /// True when the reader downstream went away: not a failure.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Error::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}

/// `invalid!("what {}", x)` is an `Err(Error::Invalid(..))`.
#[macro_export]
macro_rules! invalid {
    ($($t:tt)*) => { Err($crate::Error::Invalid(format!($($t)*))) };
}

/// `usage!("what {}", x)` is an `Err(Error::Usage(..))`.
#[macro_export]
macro_rules! usage {
    ($($t:tt)*) => { Err($crate::Error::Usage(format!($($t)*))) };
}

/// A character that changes what a terminal shows of others: a control character, or one that turns the direction of writing.
pub fn is_deceptive(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The whole text with such characters replaced.
pub fn harmless(text: &str, by: char) -> String {
    text.chars().map(|c| if is_deceptive(c) { by } else { c }).collect()
}

/// A text from outside, safe to print on one line of a terminal: control characters as `\xNN`, cut at 80 characters.
///
/// ```
/// assert_eq!(luxpipe::error::printable(b"a\x1b[31m\nb"), r"a\x1b[31m\x0ab");
/// ```
pub fn printable(text: &[u8]) -> String {
    let mut out = String::new();
    for (n, c) in String::from_utf8_lossy(text).chars().enumerate() {
        if n == 80 {
            out.push_str("...");
            break;
        }
        if is_deceptive(c) { out.push_str(&format!("\\x{:02x}", c as u32)) } else { out.push(c) }
    }
    out
}
