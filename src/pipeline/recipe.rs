//! A pipeline file with its variables settled: one job, or as many as `[foreach]` asks for.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::foreach;
use super::tree::{self, Node, Prepare, Work};
use super::variables::{Value, Variables};
use crate::error::printable;
use crate::keys::located;
use crate::{Error, Result, files, invalid, usage};

/// A pipeline's file.
pub struct Recipe {
    /// Where it lies.
    pub path: PathBuf,
    text: String,
    given: Variables,
}

/// One run of the stages.
pub struct Job {
    /// Variables that the command line gives a value: `--set`, and those of `[foreach]`, as words.
    pub set: Vec<String>,
    /// The stages.
    pub tree: Node,
}

impl Recipe {
    /// Reads a file; `words` are the `NAME=VALUE` of `--set`.
    pub fn load(path: &Path, words: &[String]) -> Result<Recipe> {
        let text = files::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
        Recipe::of_text(path, text, words)
    }

    /// The same of a text that is said to lie there.
    pub fn of_text(path: &Path, text: String, words: &[String]) -> Result<Recipe> {
        let mut given = Variables::default();
        for word in words {
            let (name, value) = super::variables::given(word)?;
            given.set(&name, value);
        }
        let recipe = Recipe { path: path.to_path_buf(), text, given };
        let (set, each, _) = recipe.parse().map_err(|e| e.in_file(path))?;
        let names = |table: &Option<Spanned<DeValue>>| -> BTreeSet<String> {
            let keys = table.as_ref().and_then(|t| t.get_ref().as_table()).into_iter().flat_map(|t| t.keys());
            keys.map(|k| k.get_ref().to_string()).collect()
        };
        let known: BTreeSet<String> = names(&set).union(&names(&each)).cloned().collect();
        if let Some(unknown) = recipe.given.names().find(|n| !known.contains(*n)) {
            let list = if known.is_empty() {
                "it has none".into()
            } else {
                format!("it has {}", known.into_iter().collect::<Vec<_>>().join(", "))
            };
            return usage!("--set {unknown}: {} has no such variable; {list}", path.display());
        }
        Ok(recipe)
    }

    /// `[set]`, `[foreach]` and the stages.
    fn parse(&self) -> Result<Parts<'_>> {
        let text = &self.text;
        let root = DeTable::parse(text).map_err(|e| located(text, e.span(), e.message()))?;
        let (mut set, mut each, mut stages) = (None, None, Vec::new());
        for (key, value) in root.into_inner() {
            let at = |message: &str| located(text, Some(key.span()), message);
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("name", DeValue::String(_)) => {}
                ("name", _) => return Err(at("name must be a string")),
                ("set", _) => set = Some(value),
                ("foreach", _) => each = Some(value),
                ("stage", DeValue::Array(list)) => stages = list.to_vec(),
                ("stage", _) => return Err(at("stages are written [[stage]]")),
                (other, _) => {
                    let other = printable(other.as_bytes());
                    return Err(at(&format!("unknown key '{other}', expected name, [set], [foreach] or [[stage]]")));
                }
            }
        }
        Ok((set, each, stages))
    }

    /// All jobs, checked; nothing is opened yet but what options name. With `resumed` a render keeps its finished rows beside the first
    /// file that it leads to.
    pub fn jobs(&self, resumed: bool) -> Result<Vec<Job>> {
        self.all(resumed).map_err(|e| e.in_file(&self.path))
    }

    fn all(&self, resumed: bool) -> Result<Vec<Job>> {
        let (set, each, _) = self.parse()?;
        // Values that a list is made of may be those of [set]; others may refer to the list's.
        let early = Variables::read_known(&self.text, set.as_ref(), &self.given);
        let lists = foreach::jobs(&self.text, each.as_ref(), &early, &self.given)?;
        let several = lists.len() > 1;
        let jobs = lists.into_iter().map(|values| {
            let shown = values.iter().map(|(n, v)| format!("{n}={}", v.shown())).collect::<Vec<_>>().join(", ");
            self.job(&values, resumed).map_err(|e| if several { e.within(&shown) } else { e })
        });
        let jobs = jobs.collect::<Result<Vec<_>>>()?;
        let mut written = BTreeSet::new();
        for (job, path) in jobs.iter().flat_map(|j| j.tree.files_written().into_iter().map(move |p| (j, p))) {
            if !written.insert(path.clone()) {
                return invalid!("{}: two jobs write {}; put a variable into its name", job.name(), path.display());
            }
        }
        Ok(jobs)
    }

    fn job(&self, values: &[(String, Value)], resumed: bool) -> Result<Job> {
        let mut over = self.given.clone();
        values.iter().for_each(|(name, value)| over.set(name, value.clone()));
        let read = |checkpoint: Option<&str>| -> Result<Node> {
            let (set, _, stages) = self.parse()?;
            let variables = Variables::read(&self.text, set.as_ref(), &over)?;
            tree::read(&self.text, stages, &Prepare { variables: &variables, checkpoint })
        };
        let mut tree = read(None)?;
        if resumed && let Some(first) = tree.files_written().first() {
            tree = read(Some(&format!("{}.checkpoint", first.display())))?;
        }
        let set = over.names().filter_map(|n| Some(format!("{n}={}", over.get(n)?.shown()))).collect();
        Ok(Job { set, tree })
    }
}

type Parts<'a> = (Option<Spanned<DeValue<'a>>>, Option<Spanned<DeValue<'a>>>, Vec<Spanned<DeValue<'a>>>);

/// What a job depends on.
pub struct Needs {
    /// Files that it reads, of its own pipeline too.
    pub files: Vec<PathBuf>,
    /// Rows of its first stage, where that can be done in parts.
    pub rows: Option<usize>,
}

impl Job {
    /// What messages call it.
    pub fn name(&self) -> String {
        self.set.join(", ")
    }

    /// Files that the job leaves.
    pub fn targets(&self) -> Vec<PathBuf> {
        self.tree.files_written()
    }

    /// The files that the job reads; scenes are opened for what they name.
    pub fn needs(&self, pipeline: &Path) -> Result<Needs> {
        let (looked, opened) = files::noted(|| {
            let mut rows = None;
            for node in self.tree.all() {
                if let Work::Filter(stage) = &node.work {
                    let own = (stage.look_ahead)().map_err(|e| e.within(&node.work.name()))?;
                    if std::ptr::eq(node, &self.tree) {
                        rows = own;
                    }
                }
            }
            Ok::<_, Error>(rows)
        });
        let mut all: BTreeSet<PathBuf> = opened.into_iter().collect();
        all.insert(pipeline.to_path_buf());
        for node in self.tree.all() {
            match &node.work {
                Work::Filter(stage) => all.extend(stage.needs.iter().cloned()),
                Work::Exec(exec) => all.extend(exec.input.iter().cloned()),
            }
        }
        Ok(Needs { files: all.into_iter().filter(|p| p != Path::new("-")).collect(), rows: looked? })
    }

    /// True where all files that it leaves are there, and none is older than what it is made of.
    pub fn is_done(&self, pipeline: &Path) -> Result<bool> {
        // Without the first there is no need to look.
        Ok(self.made().is_some() && self.is_as_new_as(&self.needs(pipeline)?))
    }

    /// The same where it is known what it is made of.
    pub fn is_as_new_as(&self, needs: &Needs) -> bool {
        self.made().is_some_and(|made| needs.files.iter().all(|f| modified(f).is_some_and(|t| t <= made)))
    }

    /// When the oldest of its files was made; `None` where one is missing, or it leaves none.
    fn made(&self) -> Option<SystemTime> {
        let times = self.targets().iter().map(modified).collect::<Option<Vec<_>>>()?;
        times.into_iter().min()
    }
}

fn modified(path: &PathBuf) -> Option<SystemTime> {
    fs::metadata(path).and_then(|m| m.modified()).ok()
}
