//! `--make`: a pipeline's jobs as Makefile rules with all files that each depends on, scenes' meshes and spectra too.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::parts::{Step, in_folders};
use super::shell;
use crate::error::printable;
use crate::options::installed;

/// The rules; `arguments` are the words of the command that would write them again.
pub fn rules(pipeline: &Path, arguments: &str, jobs: &[Vec<Step>]) -> String {
    let mut text = format!("# Written by: {} {}\n", installed("luxpipe"), arguments);
    let goal = goal(pipeline);
    let last = jobs.iter().filter_map(|steps| steps.last());
    let all: Vec<String> = last.flat_map(|s| s.targets.iter().map(|p| name(p))).collect();
    let _ = writeln!(text, "# All jobs of {} by the goal {goal}", printable(pipeline.as_os_str().as_encoded_bytes()));
    let _ = writeln!(text, ".PHONY: {goal}\n{goal}: {}", all.join(" "));
    for step in jobs.iter().flatten() {
        let list = |paths: &[PathBuf]| paths.iter().map(|p| name(p)).collect::<Vec<_>>().join(" ");
        // Grouped targets, where one command makes several files: GNU make 4.3.
        let colon = if step.targets.len() > 1 { " &:" } else { ":" };
        let command = in_folders(&step.targets, shell::line(&step.words)).replace('$', "$$");
        let _ = writeln!(text, "\n{}{colon} {}\n\t{command}", list(&step.targets), list(&step.needs));
    }
    text
}

/// The goal that stands for all jobs: the pipeline's own name.
fn goal(pipeline: &Path) -> String {
    let stem = pipeline.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' }).collect()
}

/// A file's name as make needs it.
fn name(path: &Path) -> String {
    let mut out = String::new();
    for c in path.to_string_lossy().chars() {
        match c {
            ' ' | '#' | ':' | '\\' | '%' => out.extend(['\\', c]),
            '$' => out.push_str("$$"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_make_needs_them() {
        assert_eq!(name(Path::new("out/a b#1:$x.png")), r"out/a\ b\#1\:$$x.png");
        assert_eq!(goal(Path::new("pipelines/all shots.toml")), "all_shots");
    }
}
