//! `--snakemake`: a pipeline's jobs as a Snakefile, for clusters and clouds by Snakemake's own executors. Every name stands as it is,
//! nothing is matched by patterns. A job has as many threads as `--config threads=N` says, 1 if it says nothing.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::parts::Step;
use super::shell;
use crate::error::harmless;
use crate::options::installed;
use crate::{Result, invalid};

/// The Snakefile; `arguments` are the words of the command that would write it again.
///
/// # Errors
/// A file name that Snakemake would take for a pattern.
pub fn snakefile(arguments: &str, jobs: &[Vec<Step>]) -> Result<String> {
    let mut text = format!("# Written by: {} {}\n", installed("luxpipe"), arguments);
    text += "\nTHREADS = int(config.get(\"threads\", 1))\n";
    let last = jobs.iter().filter_map(|steps| steps.last());
    let all: Vec<PathBuf> = last.flat_map(|s| s.targets.clone()).collect();
    let _ = writeln!(text, "\nrule all:\n    input:\n{}", list(&all)?);
    for (n, step) in jobs.iter().flatten().enumerate() {
        let comment = harmless(&step.name, ' ');
        let _ = writeln!(text, "\n# {comment}\nrule job_{}:", n + 1);
        let _ = writeln!(text, "    input:\n{}", list(&step.needs)?);
        let _ = writeln!(text, "    output:\n{}", list(&step.targets)?);
        // Braces are Snakemake's own, but for those of the threads.
        let command = shell::line(&step.words).replace('{', "{{").replace('}', "}}");
        let (program, rest) = command.split_once(' ').unwrap_or((&command, ""));
        let command = format!("{program} --threads {{threads}} {rest}");
        let _ = writeln!(text, "    threads: THREADS\n    shell:\n        {}", python(&command));
    }
    Ok(text)
}

fn list(paths: &[PathBuf]) -> Result<String> {
    let lines = paths.iter().map(|path| match is_pattern(path) {
        true => {
            invalid!("{}: Snakemake takes {{...}} in a file's name for a pattern; give it another name", path.display())
        }
        false => Ok(format!("        {},", python(&path.to_string_lossy()))),
    });
    Ok(lines.collect::<Result<Vec<_>>>()?.join("\n"))
}

/// Braces around a word, with or without more after a comma.
fn is_pattern(path: &Path) -> bool {
    let name = path.to_string_lossy();
    name.split('{').skip(1).any(|rest| {
        let inside = rest.split_once('}').map(|(inside, _)| inside.trim_start());
        inside.is_some_and(|i| i.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.'))
    })
}

/// A text as Python writes it.
fn python(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                let _ = write!(out, "\\x{:02x}", c as u32);
            }
            c => out.push(c),
        }
    }
    out + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_as_python_writes_them() {
        assert_eq!(python(r#"a "b" \ c"#), r#""a \"b\" \\ c""#);
        let pattern = |name: &str| is_pattern(Path::new(name));
        assert!(pattern("a{1}.png") && pattern("{ x }") && pattern("{a,b}") && pattern("}{{x}}"));
        assert!(!pattern("a{}.png") && !pattern("{-x}") && !pattern("{x") && !pattern("x}"));
    }
}
