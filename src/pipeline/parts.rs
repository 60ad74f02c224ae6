//! A job in steps that an engine can run by themselves, make or another: its picture's rows in parts where they are asked for and can be
//! had, and then all else. Every step is one command, reads files and writes files, whole or not at all.

use std::path::{Path, PathBuf};

use super::recipe::Job;
use super::run::folders;
use super::tree::{Node, Work};
use crate::filter::Stage;
use crate::options::{FormatOptions, quote};
use crate::render::tile::BAND;
use crate::{Result, filters, invalid};

/// One command.
#[derive(Debug)]
pub struct Step {
    /// What it is about, for people and for names of rules.
    pub name: String,
    /// Files that it writes; at least one.
    pub targets: Vec<PathBuf>,
    /// Files that it reads.
    pub needs: Vec<PathBuf>,
    /// The command's words.
    pub words: Vec<String>,
}

/// The steps of a job; `parts` of 0 and 1 leave it whole.
///
/// # Errors
/// A job that leaves no file, or parts of a first stage that has no rows of its own.
pub fn steps(job: &Job, pipeline: &Path, parts: usize) -> Result<Vec<Step>> {
    let targets = job.targets();
    let Some(first) = targets.first() else {
        return invalid!("a job without an output file cannot be a rule; name an output, or save a picture");
    };
    let needs = job.needs(pipeline)?;
    let name = first.display().to_string();
    if parts < 2 {
        return Ok(vec![Step { name, words: whole(job, pipeline, &[]), targets, needs: needs.files }]);
    }
    let Work::Filter(stage) = &job.tree.work else {
        return invalid!("--parts: the first stage has no rows to be divided");
    };
    let Some(rows) = needs.rows else {
        return invalid!("--parts: {} has no rows to be divided, or they are divided already", stage.name);
    };
    let parts = parts.min(rows);
    let folder = PathBuf::from(format!("{name}.parts"));
    let mut steps = Vec::new();
    // Cut between tiles of pools, where the parts are high enough: what is cut is rendered for both.
    let cut = |i: usize| match rows * i / parts {
        at if i < parts && rows / parts >= BAND => at - at % BAND,
        at => at,
    };
    for i in 0..parts {
        let (from, to) = (cut(i), cut(i + 1));
        let target = folder.join(format!("{from}-{to}.lux"));
        let words = stage.part_words((from, to), &target.display().to_string());
        let name = format!("{name}, rows {from} to {to}");
        steps.push(Step { name, targets: vec![target], needs: needs.files.clone(), words });
    }
    let bands: Vec<PathBuf> = steps.iter().map(|s| s.targets[0].clone()).collect();
    let words = whole(job, pipeline, &bands);
    steps.push(Step { name, words, targets, needs: [needs.files, bands].concat() });
    Ok(steps)
}

/// The whole job, its first picture put together from bands of rows where there are any.
fn whole(job: &Job, pipeline: &Path, bands: &[PathBuf]) -> Vec<String> {
    let mut words = vec!["luxpipe".to_string()];
    words.extend(job.set.iter().flat_map(|s| ["--set".to_string(), s.clone()]));
    words.extend(bands.iter().flat_map(|b| ["--band".to_string(), b.display().to_string()]));
    words.push(pipeline.display().to_string());
    words
}

/// The tree with bands of rows in place of its first stage's work.
pub fn from_bands(tree: Node, bands: &[PathBuf]) -> Result<Node> {
    let Work::Filter(stage) = tree.work else { return invalid!("--band: the first stage has no rows") };
    let join = filters::Pjoin { bands: bands.to_vec() };
    let joined = Stage::new(join, Default::default(), stage.output, FormatOptions { format: stage.format }, stage.run);
    Ok(Node { work: Work::Filter(Box::new(joined)), ..tree })
}

/// The command, in folders that are there.
pub fn in_folders(files: &[PathBuf], command: String) -> String {
    let mut folders: Vec<String> = folders(files).map(|f| quote(&f.display().to_string())).collect();
    folders.sort();
    folders.dedup();
    if folders.is_empty() { command } else { format!("mkdir -p {} && {command}", folders.join(" ")) }
}
