//! The program `tradeoff`: see luxpipe's src/tradeoff.

use std::process::ExitCode;

use clap::FromArgMatches;
use luxpipe::notes::Notes;
use luxpipe::tradeoff::{Tradeoff, command};
use luxpipe::{cli, filter};

fn main() -> ExitCode {
    let parsed = command().try_get_matches().and_then(|m| Tradeoff::from_arg_matches(&m));
    let args = match parsed {
        Ok(args) => args,
        Err(e) => return cli::clap_exit("tradeoff", &e),
    };
    cli::exit("tradeoff", filter::prepare(&args.run).and_then(|()| args.run()), &Notes::default(), args.run.quiet)
}
