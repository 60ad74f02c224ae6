//! Pipelines: a TOML file of stages, run in one process, or printed as the shell command, Makefile or Snakefile that it stands for.
//!
//! ```toml
//! name = "proofs"
//!
//! [set]                               # variables, with their values; --set NAME=VALUE gives others
//! samples = 64
//! out = "out/${shot.stem}"
//!
//! [foreach]                           # a job for each
//! shot = "shots/*.toml"               # files, or a list, or { from = 1, to = 240, digits = 4 }
//!
//! [[stage]]
//! run = "spectrace"                   # a filter; keys are its long options, input and output its files
//! scene = "${shot}"
//! samples = "${samples}"
//! save = ["${out}.tif", "${out}.exr"] # records the picture as it is here; format by suffix
//!
//! [[stage]]
//! run = "vonkries"
//! to = "D65"
//! id = "adapted"                      # so that other stages can read it too
//!
//! [[stage]]
//! run = "pcond"
//!
//! [[stage]]
//! run = "xyz2rgb"
//!
//! [[stage]]
//! run = "ra_png"
//! output = "${out}.png"
//!
//! [[stage]]
//! exec = ["pfilt", "-1", "-x", "/2"]  # another program
//! after = "adapted"
//! format = "rgbe"                     # what it is given
//! output = "${out}-half.hdr"
//! ```

mod batch;
mod doctor;
mod exec;
mod foreach;
mod intent;
mod make;
mod parts;
mod recipe;
mod run;
mod shell;
mod snakemake;
mod tree;
mod variables;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};

use crate::display::Display;
use crate::error::{harmless, printable};
use crate::filter;
use crate::filters::Intent;
use crate::notes::Notes;
use crate::options::{RunOptions, quote};
use crate::{Error, Result, usage};

use recipe::{Job, Recipe};

/// Command line of `luxpipe`.
#[derive(Args, Clone, Debug)]
pub struct Luxpipe {
    /// Pipeline to run; with --intent, the picture or scene (.toml) to show; or the word doctor
    #[arg(value_name = "PIPELINE", value_hint = ValueHint::FilePath)]
    pub pipeline: PathBuf,
    /// With --intent: PNG to write; standard output if absent or '-'
    #[arg(value_name = "OUTPUT", value_hint = ValueHint::FilePath, requires = "intent")]
    pub output: Option<PathBuf>,
    /// Give a variable of the file a value, or fix one of [foreach]; once for each
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "intent")]
    pub set: Vec<String>,
    /// In place of a pipeline file, the whole chain for a rendering intent, from PIPELINE to OUTPUT
    #[arg(long, value_enum, value_name = "INTENT")]
    pub intent: Option<Intent>,
    /// With --intent: display to show it on, by name or file
    #[arg(long, value_name = "DISPLAY", default_value = "srgb", value_hint = ValueHint::FilePath)]
    pub display: Display,
    /// Jobs of [foreach] at a time
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Batches")]
    pub jobs: usize,
    /// Go on with the other jobs after a failure
    #[arg(long, help_heading = "Batches")]
    pub keep_going: bool,
    /// Leave out jobs whose files are there and newer than all that they are made of, and keep finished rows of renders, so that the
    /// same command goes on after a kill
    #[arg(long, help_heading = "Batches")]
    pub resume: bool,
    /// Say what would be done, and do nothing
    #[arg(long, group = "print", help_heading = "Printing")]
    pub dry_run: bool,
    /// Print the same work as a shell command, one line a job, and do nothing
    #[arg(long, group = "print", help_heading = "Printing")]
    pub shell: bool,
    /// Print Makefile rules with all files that the work depends on
    #[arg(long, group = "print", help_heading = "Printing")]
    pub make: bool,
    /// Print a Snakefile, for clusters
    #[arg(long, group = "print", help_heading = "Printing")]
    pub snakemake: bool,
    /// With --make and --snakemake: divide the rows of each render into so many steps of their own
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Printing")]
    pub parts: usize,
    /// Take the first stage's picture from a band of its rows, rendered before (--rows); once for each
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["intent", "parts", "resume"], help_heading = "Batches")]
    pub band: Vec<PathBuf>,
    /// How to run.
    #[command(flatten)]
    pub run: RunOptions,
}

/// The command line of `luxpipe`.
pub fn command() -> clap::Command {
    let about = "Run a TOML pipeline: its stages in one process, the bytes those of the shell pipe";
    let example = "luxpipe pipelines/cornell.toml\nluxpipe --shell pipelines/cornell.toml | sh\nluxpipe --jobs 2 --resume --set samples=16 pipelines/lamps.toml\nluxpipe --make pipelines/lamps.toml > lamps.mk && make -j2 -f lamps.mk lamps\nluxpipe --intent perceptual --display p3 office.hdr office.png\nluxpipe doctor";
    filter::dress(Luxpipe::augment_args(clap::Command::new("luxpipe")), about, example)
}

/// Reads a pipeline's text and checks it; how many jobs it has. Files of displays and lists are looked for, nothing else is.
///
/// # Errors
/// What is wrong with it, and where.
pub fn check(text: &str) -> Result<usize> {
    let recipe = Recipe::of_text(Path::new("pipeline"), text.to_string(), &[])?;
    recipe.jobs(false).map(|jobs| jobs.len())
}

/// Does what the command line asks for.
pub fn run(args: &Luxpipe, notes: &Notes) -> Result<()> {
    if args.pipeline == Path::new("doctor") && !args.pipeline.exists() {
        return print(&doctor::report());
    }
    let prints_rules = args.make || args.snakemake;
    if args.parts == 0 || args.parts > 10_000 || (args.parts > 1 && !prints_rules) {
        return usage!("--parts {}: 1 to 10000 steps a render, with --make or --snakemake", args.parts);
    }
    if args.jobs == 0 || args.jobs > 10_000 {
        return usage!("--jobs {}: 1 to 10000 at a time", args.jobs);
    }
    let jobs = match args.intent {
        Some(intent) => vec![Job {
            set: Vec::new(),
            tree: intent::chain(intent, &args.pipeline, args.output.clone(), &args.display)?,
        }],
        None => Recipe::load(&args.pipeline, &args.set)?.jobs(args.resume)?,
    };
    if args.intent.is_some() && (prints_rules || args.resume) {
        return usage!("--make, --snakemake and --resume go with a pipeline file");
    }
    let within = |e: Error| e.in_file(&args.pipeline);
    let jobs = match (&args.band[..], jobs.len()) {
        ([], _) => jobs,
        (bands, 1) => {
            let of_bands = |job: Job| Ok(Job { tree: parts::from_bands(job.tree, bands)?, ..job });
            jobs.into_iter().map(of_bands).collect::<Result<_>>().map_err(within)?
        }
        (_, n) => return usage!("--band: these are {n} jobs; choose one by --set"),
    };
    if args.shell {
        let line = |job: &Job| parts::in_folders(&job.targets(), shell::command(&job.tree)) + "\n";
        return print(&jobs.iter().map(line).collect::<String>());
    }
    if args.dry_run {
        let lines = jobs.iter().map(|job| described(job, args)).collect::<Result<Vec<_>>>().map_err(within)?;
        return print(&lines.concat());
    }
    if prints_rules {
        let steps = jobs.iter().map(|job| parts::steps(job, &args.pipeline, args.parts));
        let steps = steps.collect::<Result<Vec<_>>>().map_err(within)?;
        return print(&match args.make {
            true => make::rules(&args.pipeline, &arguments(), &steps).map_err(within)?,
            false => snakemake::snakefile(&arguments(), &steps).map_err(within)?,
        });
    }
    let choice = batch::Choice {
        at_a_time: args.jobs,
        keep_going: args.keep_going,
        resume: args.resume,
        progress: !args.run.quiet,
    };
    batch::all(jobs, &args.pipeline, choice, notes).map_err(within)
}

/// The words of this command, for the head of what it prints.
fn arguments() -> String {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    let plain = |w: &OsString| harmless(&quote(&w.to_string_lossy()), ' ');
    words.iter().map(plain).collect::<Vec<String>>().join(" ")
}

/// What a job would do.
fn described(job: &Job, args: &Luxpipe) -> Result<String> {
    let targets = job.targets();
    let shown = |paths: &[PathBuf]| {
        let list: Vec<String> = paths.iter().map(|p| printable(p.as_os_str().as_encoded_bytes())).collect();
        list.join(", ")
    };
    let needs = job.needs(&args.pipeline)?;
    let state = match (targets.is_empty(), job.is_as_new_as(&needs)) {
        (true, _) => "writes standard output".to_string(),
        (_, true) if args.resume => format!("is done: {}", shown(&targets)),
        (_, true) => format!("is done, and would be done again: {}", shown(&targets)),
        (_, false) => format!("would write {}", shown(&targets)),
    };
    let plain = |text: &str| harmless(text, '?');
    let name = if job.set.is_empty() { String::new() } else { format!("{}: ", plain(&job.name())) };
    Ok(format!("{name}{state}\n    from {}\n    by {}\n", shown(&needs.files), plain(&shell::command(&job.tree))))
}

fn print(text: &str) -> Result<()> {
    std::io::stdout().write_all(text.as_bytes()).map_err(|e| Error::io("standard output", e))
}
