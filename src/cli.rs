//! Command lines: parsing, the one place that prints messages, exit status.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::error::ErrorKind;

use crate::error::harmless;
use crate::filter::{self, Filter, Stage};
use crate::notes::Notes;
use crate::options::one_line;
use crate::{Error, Result};

/// A filter's whole program.
pub fn main<F: Filter>() -> ExitCode {
    let notes = Notes::default();
    let args: Vec<OsString> = std::env::args_os().collect();
    let stage = F::rewrite(args)
        .map(|args| filter::command::<F>().try_get_matches_from(args).and_then(|m| Stage::from_matches::<F>(&m)));
    let stage = match stage {
        Ok(Ok(stage)) => stage,
        Ok(Err(e)) => return clap_exit(F::NAME, &e),
        Err(e) => return exit(F::NAME, Err(e), &notes, false),
    };
    let quiet = stage.run.quiet;
    let result = filter::prepare(&stage.run).and_then(|()| stage.run(None, &notes));
    exit(F::NAME, result, &notes, quiet)
}

/// Prints notes or the error and gives the exit status: 0 done (or the reader went away), 1 data and I/O, 2 usage.
pub fn exit(name: &str, result: Result<()>, notes: &Notes, quiet: bool) -> ExitCode {
    match result {
        Ok(()) => {
            for note in notes.take().into_iter().filter(|_| !quiet) {
                say(name, &note, NOTE);
            }
            ExitCode::SUCCESS
        }
        Err(e) if e.is_closed_pipe() => ExitCode::SUCCESS,
        Err(e) => {
            say(name, &e.to_string(), FAILURE);
            ExitCode::from(e.exit_status())
        }
    }
}

/// Colours of the name in front of a remark and of a failure, as a terminal takes them.
const NOTE: &str = "\x1b[36m";
const FAILURE: &str = "\x1b[1;31m";

/// One line on standard error; a closed standard error is nobody's loss. On a terminal the name in front is coloured, unless NO_COLOR
/// is set.
fn say(name: &str, message: &str, colour: &str) {
    use std::io::{IsTerminal, Write};
    let line = harmless(message, ' ');
    let coloured = std::io::stderr().is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
        && std::env::var_os("TERM").is_none_or(|t| t != "dumb");
    let (begin, end) = if coloured { (colour, "\x1b[0m") } else { ("", "") };
    let _ = writeln!(std::io::stderr(), "{begin}{name}:{end} {line}");
}

/// Help and version go to standard output; anything else is one line and status 2.
pub fn clap_exit(name: &str, e: &clap::Error) -> ExitCode {
    if matches!(e.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        let _ = e.print();
        return ExitCode::SUCCESS;
    }
    exit(name, Err(Error::Usage(one_line(e))), &Notes::default(), false)
}
