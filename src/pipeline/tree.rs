//! Stages as a tree: each reads what the one before it makes, or the one that `after` names; what several read is handed to all of
//! them. `save` is a stage of its own that records the picture.

use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::exec::Exec;
use super::variables::Variables;
use crate::error::printable;
use crate::filter::Stage;
use crate::filters;
use crate::keys::located;
use crate::stream::writer::Format;
use crate::{Error, Result, invalid};

/// What a stage does.
pub enum Work {
    /// A filter's work.
    Filter(Box<Stage>),
    /// Other programs'.
    Exec(Exec),
}

/// A stage with all that follows it.
pub struct Node {
    /// Its number in the file, from 1.
    pub nth: usize,
    /// What it does.
    pub work: Work,
    /// What reads its picture: first the recorders of `save`, then other stages.
    pub branches: Vec<Node>,
    /// It records what it reads for a `save`, and has no number of its own.
    pub recorder: bool,
}

/// A stage by itself.
struct Step {
    work: Work,
    saves: Vec<PathBuf>,
    id: Option<String>,
    after: Option<(String, Range<usize>)>,
    span: Range<usize>,
}

impl Work {
    /// The name of the filter or program.
    pub fn name(&self) -> String {
        match self {
            Work::Filter(stage) => stage.name.to_string(),
            Work::Exec(exec) => exec.name(),
        }
    }

    /// The file it writes; `-` is standard output.
    pub fn output(&self) -> Option<&PathBuf> {
        match self {
            Work::Filter(stage) => stage.output.as_ref(),
            Work::Exec(exec) => exec.output.as_ref(),
        }
    }

    /// Every file it writes: the output, and those of its options.
    fn files_written(&self) -> impl Iterator<Item = &PathBuf> {
        let beside = match self {
            Work::Filter(stage) => &stage.writes[..],
            Work::Exec(_) => &[],
        };
        self.output().into_iter().chain(beside).filter(|p| *p != Path::new("-"))
    }

    /// The picture it names.
    pub fn input(&self) -> Option<&PathBuf> {
        match self {
            Work::Filter(stage) => stage.read.input.as_ref(),
            Work::Exec(exec) => exec.input.as_ref(),
        }
    }
}

impl Node {
    /// This stage and all that follow.
    pub fn all(&self) -> Vec<&Node> {
        let mut list = vec![self];
        self.branches.iter().for_each(|b| list.extend(b.all()));
        list
    }

    /// Writes to standard output.
    pub fn writes_stdout(&self) -> bool {
        self.branches.is_empty() && self.work.output().is_none_or(|p| p == Path::new("-"))
    }

    /// Every file that the tree writes.
    pub fn files_written(&self) -> Vec<PathBuf> {
        self.all().into_iter().flat_map(|node| node.work.files_written()).cloned().collect()
    }
}

/// Reads all stages of a file.
pub fn read(text: &str, stages: Vec<Spanned<DeValue>>, prepare: &Prepare) -> Result<Node> {
    let steps = stages.into_iter().map(|stage| step(text, stage, prepare)).collect::<Result<Vec<_>>>()?;
    let parents = parents(text, &steps)?;
    let tree = grow(steps, &parents)?;
    check(&tree)?;
    Ok(tree)
}

/// What happens to a stage's keys before they are read.
pub struct Prepare<'a> {
    /// Values of `${name}`.
    pub variables: &'a Variables,
    /// Renders keep finished rows here.
    pub checkpoint: Option<&'a str>,
}

fn step<'a>(text: &str, stage: Spanned<DeValue<'a>>, prepare: &'a Prepare) -> Result<Step> {
    let mut stage = stage;
    let span = stage.span();
    prepare.variables.fill(text, &mut stage)?;
    let DeValue::Table(mut table) = stage.into_inner() else {
        return Err(located(text, Some(span), "a stage is a table"));
    };
    let at = |span: Range<usize>, message: &str| located(text, Some(span), message);
    let word = |table: &mut DeTable, key: &str| match table.remove(key) {
        None => Ok(None),
        Some(v) => match v.get_ref().as_str() {
            Some(s) if !s.is_empty() => Ok(Some((s.to_string(), v.span()))),
            _ => Err(at(v.span(), &format!("{key} must be a name"))),
        },
    };
    let (id, after) = (word(&mut table, "id")?.map(|n| n.0), word(&mut table, "after")?);
    let saves = saves(text, table.remove("save"))?;
    let work = match (table.remove("run"), table.remove("exec")) {
        (Some(run), None) => Work::Filter(Box::new(filter(text, &run, table, span.clone(), prepare.checkpoint)?)),
        (None, Some(exec)) => Work::Exec(external(text, exec, table)?),
        (Some(run), Some(_)) => return Err(at(run.span(), "a stage has either run or exec")),
        (None, None) => return Err(at(span, "a stage needs run = \"FILTER\", or exec = [\"PROGRAM\", ...]")),
    };
    Ok(Step { work, saves, id, after, span })
}

fn filter(
    text: &str,
    run: &Spanned<DeValue>,
    table: DeTable,
    span: Range<usize>,
    checkpoint: Option<&str>,
) -> Result<Stage> {
    let mut table = table;
    let Some(name) = run.get_ref().as_str() else {
        return Err(located(text, Some(run.span()), "run must be a filter's name"));
    };
    let Some(entry) = filters::named(name) else {
        let names: Vec<&str> = filters::ALL.iter().map(|f| f.name()).collect();
        let name = printable(name.as_bytes());
        let message = format!("no filter '{name}'; there are {} (exec runs other programs)", names.join(", "));
        return Err(located(text, Some(run.span()), &message));
    };
    // A time's rows are not the same twice, so that none are kept.
    let keeps = entry.command().get_arguments().any(|a| a.get_id() == "checkpoint");
    if let Some(path) = checkpoint.filter(|_| keeps && !table.contains_key("checkpoint") && !table.contains_key("time"))
    {
        let value = DeValue::String(path.to_string().into());
        table.insert(Spanned::new(span.clone(), "checkpoint".into()), Spanned::new(span.clone(), value));
    }
    let place = span.clone();
    entry.stage(Spanned::new(span, table)).map_err(|e| located(text, e.span().or(Some(place)), e.message()))
}

fn external(text: &str, exec: Spanned<DeValue>, table: DeTable) -> Result<Exec> {
    let at = |span: Range<usize>, message: &str| located(text, Some(span), message);
    let wrong = || at(exec.span(), "exec must be a list of a program and its arguments, such as [\"pfilt\", \"-1\"]");
    let list = exec.get_ref().as_array().ok_or_else(wrong)?;
    let word = |v: &Spanned<DeValue>| match v.get_ref() {
        DeValue::String(s) => Ok(s.to_string()),
        DeValue::Integer(n) => Ok(n.to_string()),
        DeValue::Float(x) => Ok(x.to_string()),
        _ => Err(at(v.span(), "a word of exec must be a text or a number")),
    };
    let words = list.iter().map(word).collect::<Result<Vec<_>>>()?;
    if words.first().is_none_or(String::is_empty) {
        return Err(wrong());
    }
    let mut own = Exec { commands: vec![words], format: None, input: None, output: None };
    for (key, value) in table {
        let file = || match value.get_ref().as_str() {
            Some(s) if !s.is_empty() => Ok(Some(PathBuf::from(s))),
            _ => Err(at(value.span(), &format!("{} must be a file name", key.get_ref()))),
        };
        match key.get_ref().as_ref() {
            "input" => own.input = file()?,
            "output" => own.output = file()?,
            "format" => {
                let format =
                    value.get_ref().as_str().and_then(|s| <Format as clap::ValueEnum>::from_str(s, false).ok());
                own.format = Some(format.ok_or_else(|| at(value.span(), "format must be float, rgbe or xyze"))?);
            }
            other => {
                let other = printable(other.as_bytes());
                let message = format!("unknown key '{other}', expected one of id, after, save, format, input, output");
                return Err(at(key.span(), &message));
            }
        }
    }
    Ok(own)
}

/// Files of `save`: one or a list.
fn saves(text: &str, value: Option<Spanned<DeValue>>) -> Result<Vec<PathBuf>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let one = |v: &Spanned<DeValue>| {
        let at = |message: &str| located(text, Some(v.span()), message);
        let path =
            v.get_ref().as_str().map(PathBuf::from).ok_or_else(|| at("save must be a file name, or a list of them"))?;
        recorder(&path).map_err(|e| at(&e.to_string()))?;
        Ok(path)
    };
    match value.get_ref() {
        DeValue::Array(list) => list.iter().map(one).collect(),
        _ => one(&value).map(|p| vec![p]),
    }
}

/// The stage that records a picture under this name, by suffix.
fn recorder(path: &Path) -> Result<Stage> {
    let suffix = path.extension().and_then(|s| s.to_str()).unwrap_or("").to_ascii_lowercase();
    match filters::ALL.iter().find(|f| f.suffixes().contains(&suffix.as_str())) {
        Some(filter) => Ok(filter.saver(&suffix, path.to_path_buf())),
        None => {
            let known: Vec<String> =
                filters::ALL.iter().flat_map(|f| f.suffixes()).map(|suffix| format!(".{suffix}")).collect();
            invalid!("cannot save '{}': known suffixes are {}", path.display(), known.join(", "))
        }
    }
}

/// Whose picture each stage reads; the first stage's is `None`.
fn parents(text: &str, steps: &[Step]) -> Result<Vec<Option<usize>>> {
    if steps.is_empty() {
        return invalid!("a pipeline needs at least one [[stage]]");
    }
    let mut parents = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let twin = |id: &String| steps[..i].iter().any(|s| s.id.as_ref() == Some(id));
        if let Some(id) = step.id.as_ref().filter(|id| twin(id)) {
            let message = format!("two stages have the id '{}'", printable(id.as_bytes()));
            return Err(located(text, Some(step.span.clone()), &message));
        }
        parents.push(match &step.after {
            None => i.checked_sub(1),
            Some((id, span)) => match steps.iter().position(|s| s.id.as_ref() == Some(id)) {
                Some(parent) => Some(parent),
                None => {
                    let named: Vec<&str> = steps.iter().filter_map(|s| s.id.as_deref()).collect();
                    let known = if named.is_empty() {
                        "none has one".into()
                    } else {
                        format!("there are {}", named.join(", "))
                    };
                    let message = format!("after: no stage has the id '{}'; {known}", printable(id.as_bytes()));
                    return Err(located(text, Some(span.clone()), &message));
                }
            },
        });
    }
    for start in 0..steps.len() {
        let (mut at, mut way) = (start, vec![start]);
        while let Some(parent) = parents[at] {
            if let Some(begin) = way.iter().position(|i| *i == parent) {
                let round: Vec<String> =
                    way[begin..].iter().rev().map(|i| format!("{} ({})", i + 1, steps[*i].work.name())).collect();
                let message = format!("a cycle: stages {} read each other", round.join(", "));
                return Err(located(text, steps[parent].after.as_ref().map(|f| f.1.clone()), &message));
            }
            way.push(parent);
            at = parent;
        }
    }
    Ok(parents)
}

/// The tree of all stages; programs next to each other become one.
fn grow(steps: Vec<Step>, parents: &[Option<usize>]) -> Result<Node> {
    let mut nodes: Vec<Option<Node>> = Vec::new();
    for (i, step) in steps.into_iter().enumerate() {
        let save = |path: &PathBuf| {
            let work = Work::Filter(Box::new(recorder(path)?));
            Ok(Node { nth: i + 1, work, branches: Vec::new(), recorder: true })
        };
        let branches = step.saves.iter().map(save).collect::<Result<Vec<_>>>()?;
        nodes.push(Some(Node { nth: i + 1, work: step.work, branches, recorder: false }));
    }
    fn take(i: usize, nodes: &mut [Option<Node>], parents: &[Option<usize>]) -> Option<Node> {
        let mut node = nodes[i].take()?;
        for (child, _) in parents.iter().enumerate().filter(|(_, p)| **p == Some(i)) {
            node.branches.extend(take(child, nodes, parents));
        }
        join(&mut node);
        Some(node)
    }
    take(0, &mut nodes, parents).ok_or_else(|| Error::Invalid("a pipeline needs a first stage".into()))
}

/// Programs next to each other need nobody between them.
fn join(node: &mut Node) {
    let [only] = &mut node.branches[..] else { return };
    if let (Work::Exec(own), Work::Exec(next)) = (&mut node.work, &mut only.work)
        && next.format.is_none()
        && next.input.is_none()
        && own.output.is_none()
    {
        own.commands.append(&mut next.commands);
        (own.output, node.nth) = (next.output.take(), only.nth);
        node.branches = std::mem::take(&mut only.branches);
    }
}

/// Checks what concerns more than one stage.
fn check(tree: &Node) -> Result<()> {
    let mut written: Vec<PathBuf> = Vec::new();
    let mut to_stdout: Option<usize> = None;
    for node in tree.all() {
        let (nth, name) = (node.nth, node.work.name());
        let (first, last) = (std::ptr::eq(node, tree), node.branches.is_empty());
        if let Work::Filter(stage) = &node.work {
            if !first && !stage.reads {
                return invalid!("stage {nth}, {name}: reads no picture and so must be the first");
            }
            if !last && stage.format != Format::Float {
                return invalid!("stage {nth}, {name}: format goes with the last stage");
            }
        }
        if !first && node.work.input().is_some() {
            return invalid!("stage {nth}, {name}: input goes with the first stage");
        }
        if !last && node.work.output().is_some() {
            return invalid!("stage {nth}, {name}: output goes with the last stage; save records a picture in between");
        }
        if node.writes_stdout() {
            if let Some(other) = to_stdout {
                return invalid!("stage {nth}, {name}: stage {other} writes standard output already; name an output");
            }
            to_stdout = Some(nth);
        }
        for path in node.work.files_written() {
            if written.contains(path) {
                return invalid!("stage {nth}, {name}: two stages write {}", path.display());
            }
            written.push(path.clone());
        }
    }
    Ok(())
}
