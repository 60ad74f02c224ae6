//! A pipeline as the shell command that it stands for. Where several stages read a picture, `tee` hands it on by way of descriptor 3,
//! and what goes to standard output leaves by descriptor 9, so that any POSIX shell waits for all of it.

use std::path::Path;

use super::tree::{Node, Work};
use crate::filters;
use crate::options::{installed, quote};
use crate::stream::writer::Format;

/// The command of a tree.
pub fn command(tree: &Node) -> String {
    let input = tree.work.input().map(|p| p.display().to_string());
    let Text { line, .. } = stages(tree, &words(tree, input.as_deref()));
    if tree.all().iter().any(|n| n.branches.len() > 1) { format!("{{ {line}; }} 9>&1") } else { line }
}

/// Words for a shell, programs of ours under the names that they are installed by.
pub fn line(words: &[String]) -> String {
    let mut words = words.to_vec();
    words[0] = installed(&words[0]);
    words.iter().map(|w| quote(w)).collect::<Vec<_>>().join(" ")
}

/// A stage's words; the output is its own.
fn words(node: &Node, input: Option<&str>) -> String {
    match &node.work {
        Work::Filter(stage) => {
            let output = stage.output.as_ref().map(|p| p.display().to_string());
            let words = stage.command_words(input, output.as_deref());
            line(&words)
        }
        Work::Exec(exec) => exec.shell(input.map(Path::new), exec.output.as_deref()),
    }
}

/// How an option calls it; floats are what there is without one.
fn named(format: Format) -> Option<&'static str> {
    match format {
        Format::Float => None,
        Format::Rgbe => Some("rgbe"),
        Format::Xyze => Some("xyze"),
    }
}

/// A pipe.
struct Text {
    line: String,
    /// Its last command writes to standard output.
    writes: bool,
}

/// The first stage by these words, and what follows it.
fn stages(node: &Node, first: &str) -> Text {
    let Some((main, others)) = node.branches.split_last() else {
        return Text { line: first.to_string(), writes: node.writes_stdout() };
    };
    let mut all = follow(main);
    for other in others.iter().rev() {
        // Descriptor 1 of the group feeds the other.
        let out = if all.writes { " >&9" } else { "" };
        let Text { line, writes } = follow(other);
        all = Text { line: format!("{{ tee /dev/fd/3 | {}{out}; }} 3>&1 | {line}", all.line), writes };
    }
    Text { line: format!("{first} | {}", all.line), ..all }
}

/// A stage that reads the picture of the one before it.
fn follow(branch: &Node) -> Text {
    let own = stages(branch, &words(branch, None));
    let format = match &branch.work {
        Work::Exec(exec) => exec.format.and_then(named),
        Work::Filter(_) => None,
    };
    // Somebody else changes the format, so that the picture's history is the same.
    match format {
        Some(format) => {
            Text { line: format!("{} --format {format} - | {}", installed(filters::PASSES), own.line), ..own }
        }
        None => own,
    }
}
