//! `--make`: a pipeline's jobs as Makefile rules with all files that each depends on, scenes' meshes and spectra too.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::parts::{Step, in_folders};
use super::shell;
use crate::error::{is_deceptive, printable};
use crate::options::installed;
use crate::{Result, invalid};

/// The rules; `arguments` are the words of the command that would write them again.
///
/// # Errors
/// A name or a word that make would take for something else.
pub fn rules(pipeline: &Path, arguments: &str, jobs: &[Vec<Step>]) -> Result<String> {
    let mut text = format!("# Written by: {} {}\n", installed("luxpipe"), arguments);
    let goal = goal(pipeline);
    let last = jobs.iter().filter_map(|steps| steps.last());
    let all = names(last.flat_map(|s| &s.targets))?;
    let _ = writeln!(text, "# All jobs of {} by the goal {goal}", printable(pipeline.as_os_str().as_encoded_bytes()));
    let _ = writeln!(text, ".PHONY: {goal}\n{goal}: {}", all);
    for step in jobs.iter().flatten() {
        // A line of a recipe ends where its line does.
        if let Some(word) = step.words.iter().find(|w| w.contains(['\n', '\r'])) {
            return invalid!("'{}': make cannot hold a line break", printable(word.as_bytes()));
        }
        // Grouped targets, where one command makes several files: GNU make 4.3.
        let colon = if step.targets.len() > 1 { " &:" } else { ":" };
        let command = in_folders(&step.targets, shell::line(&step.words)).replace('$', "$$");
        let _ = writeln!(text, "\n{}{colon} {}\n\t{command}", names(&step.targets)?, names(&step.needs)?);
    }
    Ok(text)
}

fn names<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<String> {
    Ok(paths.into_iter().map(|p| name(p)).collect::<Result<Vec<_>>>()?.join(" "))
}

/// The goal that stands for all jobs: the pipeline's own name.
fn goal(pipeline: &Path) -> String {
    let stem = pipeline.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' }).collect()
}

/// A file's name as make needs it.
///
/// # Errors
/// Names that make has no way to hold: it would take them for patterns, lists or commands.
fn name(path: &Path) -> Result<String> {
    let mut out = String::new();
    for c in path.to_string_lossy().chars() {
        match c {
            ' ' | '#' | ':' => out.extend(['\\', c]),
            '$' => out.push_str("$$"),
            '%' | '\\' | ';' | '|' | '=' | '*' | '?' | '[' | ']' | '~' | '&' | '(' | ')' | '<' | '>' => {
                return invalid!("{}: make cannot hold a file name with '{c}'; give it another", shown(path));
            }
            c if is_deceptive(c) => return invalid!("{}: make cannot hold such a file name", shown(path)),
            c => out.push(c),
        }
    }
    Ok(out)
}

fn shown(path: &Path) -> String {
    printable(path.as_os_str().as_encoded_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_make_needs_them() {
        assert_eq!(name(Path::new("out/a b#1:$x.png")).unwrap(), r"out/a\ b\#1\:$$x.png");
        for bad in ["a;touch b", "a\n\tb", "a|b", "a=b", "a%", "~a", "a*", "a[1]", "a\\b", "a&b", "$(a)", "a\u{202e}b"]
        {
            assert!(name(Path::new(bad)).is_err(), "{bad}");
        }
        assert_eq!(goal(Path::new("pipelines/all shots.toml")), "all_shots");
    }
}
