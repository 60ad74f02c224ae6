//! The program `luxpipe`: runs a TOML pipeline with its stages in one process, or prints it as a shell command.

use std::io::Write;
use std::process::ExitCode;

use clap::{ArgMatches, FromArgMatches};
use luxpipe::notes::Notes;
use luxpipe::pipeline::{self, Luxpipe, Pipeline};
use luxpipe::{Error, Result, cli, filter};

fn main() -> ExitCode {
    let parsed = pipeline::command().try_get_matches().and_then(|m: ArgMatches| Luxpipe::from_arg_matches(&m));
    let args = match parsed {
        Ok(args) => args,
        Err(e) => return cli::clap_exit("luxpipe", &e),
    };
    filter::prepare(&args.run);
    let notes = Notes::default();
    cli::exit("luxpipe", run(&args, &notes), &notes, args.run.quiet)
}

fn run(args: &Luxpipe, notes: &Notes) -> Result<()> {
    let pipeline = match args.intent {
        Some(intent) => Pipeline::of_intent(intent, &args.pipeline, args.output.clone(), &args.display)?,
        None => Pipeline::load(&args.pipeline)?,
    };
    if args.shell {
        let line = pipeline.shell()? + "\n";
        return std::io::stdout().write_all(line.as_bytes()).map_err(|e| Error::io("standard output", e));
    }
    pipeline.run(notes).map_err(|e| e.in_file(&args.pipeline))
}
