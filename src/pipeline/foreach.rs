//! `[foreach]`: variables that take one value after the other, a job for each. A list gives the values; a text is a pattern of file
//! names (`shots/*.exr`), sorted; a table `{ from = 1, to = 240, step = 2, digits = 4 }` counts. Several variables take every
//! combination, the last the fastest.

use std::ops::Range;
use std::path::PathBuf;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::variables::{Value, Variables, check_name};
use crate::Result;
use crate::error::printable;
use crate::keys::{self, located};

/// Values of one variable.
type Each = (String, Vec<Value>);

/// Jobs at most: a slip of the pen must not fill a disk.
const MOST_JOBS: usize = 1_000_000;

/// The variables of every job, those of `given` fixed.
pub fn jobs(
    text: &str,
    table: Option<&Spanned<DeValue>>,
    set: &Variables,
    given: &Variables,
) -> Result<Vec<Vec<(String, Value)>>> {
    let Some(table) = table else { return Ok(vec![Vec::new()]) };
    let at = |message: &str| located(text, Some(table.span()), message);
    let DeValue::Table(names) = table.get_ref() else { return Err(at("foreach must be a table, [foreach]")) };
    // As they stand in the file.
    let mut entries: Vec<_> = names.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let mut all: Vec<Vec<(String, Value)>> = vec![Vec::new()];
    for (name, values) in entries {
        check_name(text, name)?;
        let (name, values) = match given.get(name.get_ref()) {
            Some(one) => (name.get_ref().to_string(), vec![one.clone()]),
            None => each(text, name, values, set)?,
        };
        if all.len().saturating_mul(values.len()) > MOST_JOBS {
            return Err(at(&format!("more than {MOST_JOBS} jobs")));
        }
        let with = |job: &Vec<(String, Value)>, value: &Value| [&job[..], &[(name.clone(), value.clone())]].concat();
        all = all.iter().flat_map(|job| values.iter().map(|v| with(job, v)).collect::<Vec<_>>()).collect();
    }
    Ok(all)
}

fn each(text: &str, name: &Spanned<std::borrow::Cow<str>>, values: &Spanned<DeValue>, set: &Variables) -> Result<Each> {
    let span = values.span();
    let at = |message: &str| located(text, Some(span.clone()), message);
    let mut values = values.clone();
    set.fill(text, &mut values)?;
    let shown = printable(name.get_ref().as_bytes());
    let list = match values.into_inner() {
        DeValue::Array(list) => list.iter().map(|v| Value::of(v.get_ref())).collect(),
        DeValue::String(pattern) => files(&pattern).map_err(|e| at(&format!("{shown}: {e}")))?,
        DeValue::Table(table) => counted(text, table, span.clone())?,
        other => {
            let kind = other.type_str();
            let message =
                format!("{shown}: a list, a pattern of file names, or {{ from, to }}; this is of type {kind}");
            return Err(at(&message));
        }
    };
    if list.is_empty() {
        return Err(at(&format!("{shown}: the list is empty")));
    }
    Ok((name.get_ref().to_string(), list))
}

/// Files by a pattern.
fn files(pattern: &str) -> Result<Vec<Value>, String> {
    let shown = printable(pattern.as_bytes());
    let found = glob::glob(pattern).map_err(|e| format!("'{shown}' is no pattern of file names: {}", e.msg))?;
    let paths =
        found.collect::<Result<Vec<PathBuf>, _>>().map_err(|e| format!("{}: {}", e.path().display(), e.error()))?;
    let name = |p: &PathBuf| {
        p.to_str().map(|s| Value::Text(s.into())).ok_or(format!("{}: a file name must be UTF-8", p.display()))
    };
    match paths.is_empty() {
        true => Err(format!("no file matches '{shown}'")),
        false => paths.iter().map(name).collect(),
    }
}

/// Numbers from one to another.
fn counted(text: &str, table: DeTable, span: Range<usize>) -> Result<Vec<Value>> {
    let mut keys = keys::of_table(text, "foreach", span, table);
    let (from, to): (i64, i64) = (keys.need("from")?, keys.need("to")?);
    let step = keys.get::<i64>("step")?.unwrap_or(1);
    let digits = keys.get::<u8>("digits")?;
    let count = to.checked_sub(from).and_then(|d| d.checked_div(step));
    let Some(count) = count.filter(|n| (0..MOST_JOBS as i64).contains(n)) else {
        return Err(
            keys.wrong(&format!("steps of {step} from {from} do not lead to {to}, or are more than {MOST_JOBS}"))
        );
    };
    keys.finish()?;
    let number = |i: i64| {
        let n = from + i * step;
        match digits {
            Some(digits) => Value::Text(format!("{n:0width$}", width = digits.into())),
            None => Value::Toml(n.to_string()),
        }
    };
    Ok((0..=count).map(number).collect())
}
