//! The program `luxpipe`: runs a TOML pipeline with its stages in one process, or prints it as a shell command, Makefile or Snakefile.

use std::process::ExitCode;

use clap::{ArgMatches, FromArgMatches};
use luxpipe::notes::Notes;
use luxpipe::pipeline::{self, Luxpipe};
use luxpipe::{cli, filter};

fn main() -> ExitCode {
    let parsed = pipeline::command().try_get_matches().and_then(|m: ArgMatches| Luxpipe::from_arg_matches(&m));
    let args = match parsed {
        Ok(args) => args,
        Err(e) => return cli::clap_exit("luxpipe", &e),
    };
    let notes = Notes::default();
    cli::exit("luxpipe", filter::prepare(&args.run).and_then(|()| pipeline::run(&args, &notes)), &notes, args.run.quiet)
}
