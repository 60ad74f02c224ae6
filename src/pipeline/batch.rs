//! Runs the jobs of a pipeline: one after the other or several at a time, all of them or what is missing, up to the first failure or to
//! the end.

use std::collections::VecDeque;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::recipe::Job;
use super::run;
use crate::notes::Notes;
use crate::{Error, Result, invalid, usage};

/// How.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Jobs at a time.
    pub at_a_time: usize,
    /// Go on after a failure.
    pub keep_going: bool,
    /// Leave out what is done.
    pub resume: bool,
    /// Show how far it is.
    pub progress: bool,
}

/// What is left to do, and what came of the rest.
struct Books {
    left: VecDeque<Job>,
    done: usize,
    there: usize,
    failed: Vec<(String, Error)>,
}

/// Runs all jobs.
pub fn all(jobs: Vec<Job>, pipeline: &Path, choice: Choice, notes: &Notes) -> Result<()> {
    let count = jobs.len();
    let stdout = |job: &Job| job.tree.all().iter().any(|node| node.writes_stdout());
    if choice.at_a_time > 1 && count > 1 && jobs.iter().any(stdout) {
        return usage!("--jobs {}: jobs write standard output; name an output, or run one at a time", choice.at_a_time);
    }
    let target = if choice.progress && count > 1 && std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(count as u64), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} job {pos} of {len}, {eta} left{msg}") {
        bar.set_style(style);
    }
    let books = Mutex::new(Books { left: jobs.into(), done: 0, there: 0, failed: Vec::new() });
    let lock = || books.lock().unwrap_or_else(PoisonError::into_inner);
    let worker = || {
        loop {
            let job = {
                let mut books = lock();
                if !choice.keep_going && !books.failed.is_empty() {
                    return;
                }
                books.left.pop_front()
            };
            let Some(job) = job else { return };
            let name = job.name();
            let own = if count > 1 { notes.of(&name) } else { notes.clone() };
            let result = one(job, pipeline, choice, &own);
            let mut books = lock();
            match result {
                Ok(true) => books.done += 1,
                Ok(false) => books.there += 1,
                Err(e) => books.failed.push((name, e)),
            }
            drop(books);
            bar.inc(1);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..choice.at_a_time.min(count) {
            scope.spawn(worker);
        }
        worker();
    });
    bar.finish_and_clear();
    let Books { done, there, failed, .. } = books.into_inner().unwrap_or_else(PoisonError::into_inner);
    if there > 0 {
        notes.add(format!("{there} of {count} jobs were done already"));
    }
    let of = failed.len();
    match failed.into_iter().next() {
        None => Ok(()),
        Some((_, e)) if count == 1 => Err(e),
        Some((name, e)) if of == 1 && !choice.keep_going => Err(e.within(&name)),
        Some((name, e)) => {
            invalid!("{of} of {count} jobs failed, {} are done; the first: {}", done + there, e.within(&name))
        }
    }
}

/// Runs a job; false where it is done already.
fn one(job: Job, pipeline: &Path, choice: Choice, notes: &Notes) -> Result<bool> {
    if choice.resume && job.is_done(pipeline)? {
        return Ok(false);
    }
    run::make_folders(&job.targets())?;
    run::run(job.tree, true, None, notes).map(|()| true)
}
