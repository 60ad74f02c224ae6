//! Variables of a pipeline file: `[set]` gives them values, `--set` others, `[foreach]` one after the other; `${name}` in any string of
//! a stage stands for the value.
//!
//! A string that is nothing but `${name}` becomes the value itself, a number say; inside a longer string it becomes text. Of a file
//! name `${name.stem}`, `.name`, `.folder` and `.suffix` are parts. `$${` is a plain `${`. Values under `[set]` may refer to each other.

use std::collections::BTreeMap;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::printable;
use crate::keys::located;
use crate::{Result, usage};

/// Values by name.
#[derive(Clone, Default)]
pub struct Variables {
    values: BTreeMap<String, Value>,
}

/// A value that outlives the text it was read from.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A string.
    Text(String),
    /// A number, `true` or `false`, a time or a list, as TOML writes it.
    Toml(String),
}

impl Value {
    /// That of the file.
    pub fn of(value: &DeValue) -> Value {
        match value {
            DeValue::String(s) => Value::Text(s.to_string()),
            other => Value::Toml(source(other)),
        }
    }

    /// As it stands in a longer text.
    pub fn shown(&self) -> &str {
        match self {
            Value::Text(text) | Value::Toml(text) => text,
        }
    }

    fn read(&self) -> Result<DeValue<'_>, Wrong> {
        match self {
            Value::Text(text) => Ok(DeValue::String(text.as_str().into())),
            Value::Toml(text) => DeValue::parse(text).map(Spanned::into_inner).map_err(|e| e.message().to_string()),
        }
    }

    fn is_list(&self) -> bool {
        matches!(self, Value::Toml(text) if text.starts_with(['[', '{']))
    }
}

/// As TOML writes it.
fn source(value: &DeValue) -> String {
    match value {
        DeValue::String(s) => toml::Value::String(s.to_string()).to_string(),
        DeValue::Integer(n) => n.to_string(),
        DeValue::Float(x) => x.to_string(),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(d) => d.to_string(),
        DeValue::Array(list) => {
            format!("[{}]", list.iter().map(|v| source(v.get_ref())).collect::<Vec<_>>().join(", "))
        }
        DeValue::Table(table) => {
            let one = |(k, v): (&Spanned<_>, &Spanned<DeValue>)| -> String {
                let k: &std::borrow::Cow<str> = k.get_ref();
                format!("{} = {}", toml::Value::String(k.to_string()), source(v.get_ref()))
            };
            format!("{{{}}}", table.iter().map(one).collect::<Vec<_>>().join(", "))
        }
    }
}

/// What a message says of a place in the file.
type Wrong = String;

impl Variables {
    /// Those of `[set]`, with `over` in their place where it has them.
    pub fn read(text: &str, set: Option<&Spanned<DeValue>>, over: &Variables) -> Result<Variables> {
        let mut all = over.clone();
        let Some(set) = set else { return Ok(all) };
        let DeValue::Table(table) = set.get_ref() else {
            return Err(located(text, Some(set.span()), "set must be a table, [set]"));
        };
        for name in table.keys() {
            check_name(text, name)?;
        }
        for name in table.keys() {
            all.settle(text, table, name.get_ref(), &mut Vec::new())?;
        }
        Ok(all)
    }

    /// Those of `[set]` that can be told before `[foreach]` is: the others are left out.
    pub fn read_known(text: &str, set: Option<&Spanned<DeValue>>, over: &Variables) -> Variables {
        let mut all = over.clone();
        let Some(DeValue::Table(table)) = set.map(|s| s.get_ref()) else { return all };
        for name in table.keys() {
            let _ = all.settle(text, table, name.get_ref(), &mut Vec::new());
        }
        all
    }

    /// Gives a variable of the file its value, and those before it that it refers to.
    fn settle(&mut self, text: &str, table: &DeTable, name: &str, on_the_way: &mut Vec<String>) -> Result<()> {
        if self.values.contains_key(name) {
            return Ok(());
        }
        let Some(given) = table.get(name) else { return Ok(()) };
        let at = |message: &str| located(text, Some(given.span()), message);
        if on_the_way.iter().any(|n| n == name) {
            return Err(at(&format!("the variables {} refer to each other in a circle", on_the_way.join(", "))));
        }
        on_the_way.push(name.to_string());
        for other in referred(given.get_ref()) {
            self.settle(text, table, &other, on_the_way)?;
        }
        on_the_way.pop();
        let value = {
            let mut value = given.clone();
            self.fill(text, &mut value)?;
            Value::of(value.get_ref())
        };
        self.values.insert(name.to_string(), value);
        Ok(())
    }

    /// Gives a variable a value.
    pub fn set(&mut self, name: &str, value: Value) {
        self.values.insert(name.to_string(), value);
    }

    /// The value of a variable.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    /// Puts values in place of `${name}` everywhere in a value of the file.
    pub fn fill<'a>(&'a self, text: &str, value: &mut Spanned<DeValue<'a>>) -> Result<()> {
        let span = value.span();
        match value.get_mut() {
            DeValue::String(s) if s.contains("${") => {
                let filled = self.expand(s).map_err(|e| located(text, Some(span), &e))?;
                *value.get_mut() = filled;
                Ok(())
            }
            DeValue::Array(list) => list.iter_mut().try_for_each(|v| self.fill(text, v)),
            DeValue::Table(table) => table.iter_mut().try_for_each(|(_, v)| self.fill(text, v)),
            _ => Ok(()),
        }
    }

    fn expand(&self, s: &str) -> Result<DeValue<'_>, Wrong> {
        let pieces = pieces(s)?;
        if let [Piece::Value(name, None)] = &pieces[..] {
            return self.values.get(*name).ok_or_else(|| self.unknown(name))?.read();
        }
        let mut out = String::new();
        for piece in pieces {
            match piece {
                Piece::Text(t) => out.push_str(t),
                Piece::Value(name, part) => {
                    let value = self.values.get(name).ok_or_else(|| self.unknown(name))?;
                    if value.is_list() {
                        return Err(format!("${{{name}}} is a list; it can stand alone, not in a longer text"));
                    }
                    out.push_str(&of_path(value.shown(), part)?);
                }
            }
        }
        Ok(DeValue::String(out.into()))
    }

    fn unknown(&self, name: &str) -> Wrong {
        let name = printable(name.as_bytes());
        let known = match self.values.is_empty() {
            true => "there are none".to_string(),
            false => format!("there are {}", self.values.keys().cloned().collect::<Vec<_>>().join(", ")),
        };
        format!("variable '{name}' has no value ({known}); give it one under [set], or with --set {name}=VALUE")
    }
}

/// A variable of the command line, `NAME=VALUE`: a number, `true` or `false`, a list or quoted string as in TOML, or else the text.
///
/// # Errors
/// Usage, where there is no `=` or the name is none.
pub fn given(word: &str) -> Result<(String, Value)> {
    let Some((name, value)) = word.split_once('=').filter(|(name, _)| is_name(name)) else {
        return usage!(
            "--set {}: expected NAME=VALUE, the name of letters, digits, _ and -",
            printable(word.as_bytes())
        );
    };
    let value = match DeValue::parse(value) {
        Ok(v) if !matches!(v.get_ref(), DeValue::Table(_) | DeValue::Datetime(_)) => Value::of(v.get_ref()),
        _ => Value::Text(value.to_string()),
    };
    Ok((name.to_string(), value))
}

/// Refuses a name that `${...}` could not hold.
pub fn check_name(text: &str, name: &Spanned<std::borrow::Cow<str>>) -> Result<()> {
    match is_name(name.get_ref()) {
        true => Ok(()),
        false => Err(located(text, Some(name.span()), "a variable's name has letters, digits, _ and - only")),
    }
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

enum Piece<'a> {
    Text(&'a str),
    Value(&'a str, Option<&'a str>),
}

/// The text's plain stretches and `${name.part}`.
fn pieces(s: &str) -> Result<Vec<Piece<'_>>, Wrong> {
    let mut all = Vec::new();
    let mut rest = s;
    while let Some(at) = rest.find("${") {
        if rest[..at].ends_with('$') {
            all.push(Piece::Text(&rest[..at - 1]));
            all.push(Piece::Text("${"));
            rest = &rest[at + 2..];
            continue;
        }
        all.push(Piece::Text(&rest[..at]));
        let start = at + 2;
        let length = rest[start..].find('}').ok_or("'${' without '}'; a plain one is written $${")?;
        let (end, inside) = (start + length, &rest[start..start + length]);
        let (name, part) = inside.split_once('.').map_or((inside, None), |(n, p)| (n, Some(p)));
        if !is_name(name) {
            return Err(format!("'${{{}}}' names no variable", printable(inside.as_bytes())));
        }
        all.push(Piece::Value(name, part));
        rest = &rest[end + 1..];
    }
    all.push(Piece::Text(rest));
    all.retain(|p| !matches!(p, Piece::Text("")));
    Ok(all)
}

/// Names of the variables that a value refers to.
fn referred(value: &DeValue) -> Vec<String> {
    match value {
        DeValue::String(s) => {
            let of = |p: Piece| match p {
                Piece::Value(name, _) => Some(name.to_string()),
                Piece::Text(_) => None,
            };
            pieces(s).into_iter().flatten().filter_map(of).collect()
        }
        DeValue::Array(list) => list.iter().flat_map(|v| referred(v.get_ref())).collect(),
        _ => Vec::new(),
    }
}

/// A part of a file's name.
fn of_path(text: &str, part: Option<&str>) -> Result<String, Wrong> {
    let path = Path::new(text);
    let found = match part {
        None => return Ok(text.to_string()),
        Some("stem") => path.file_stem(),
        Some("name") => path.file_name(),
        Some("suffix") => path.extension(),
        Some("folder") => path.parent().map(|p| if p == Path::new("") { ".".as_ref() } else { p.as_os_str() }),
        Some(other) => {
            let other = printable(other.as_bytes());
            return Err(format!("'.{other}' is no part of a file name; there are .stem, .name, .suffix and .folder"));
        }
    };
    Ok(found.map(|f| f.to_string_lossy().into_owned()).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(set: &str, value: &str) -> Result<String, String> {
        let text = format!("[set]\n{set}\n[x]\nv = {value}");
        let root = DeTable::parse(&text).unwrap();
        let all =
            Variables::read(&text, root.get_ref().get("set"), &Variables::default()).map_err(|e| e.to_string())?;
        let mut v = root.get_ref()["x"].get_ref().get("v").unwrap().clone();
        all.fill(&text, &mut v).map_err(|e| e.to_string())?;
        Ok(format!("{}:{}", v.get_ref().type_str(), Value::of(v.get_ref()).shown()))
    }

    #[test]
    fn values_stand_where_they_are_named() {
        let set = "n = 12\nx = 0.5\nfile = 'shots/a b.exr'\nout = 'out/${file.stem}-${n}'\nlist = ['p', '${n}']";
        let ok = [
            ("'${n}'", "integer:12"),
            ("'${x}'", "float:0.5"),
            ("'a${n}b'", "string:a12b"),
            ("'${out}.png'", "string:out/a b-12.png"),
            ("'${file.folder}/${file.name}|${file.suffix}'", "string:shots/a b.exr|exr"),
            ("'{a} ${n} b}'", "string:{a} 12 b}"),
            ("'$${n} costs $5'", "string:${n} costs $5"),
            ("['${n}', 'x${n}']", "array:[12, \"x12\"]"),
            ("'${list}'", "array:[\"p\", 12]"),
        ];
        for (value, want) in ok {
            assert_eq!(filled(set, value).unwrap(), want, "{value}");
        }
        let bad = [
            ("'${m}'", "variable 'm' has no value (there are file, list, n, out, x)"),
            ("'${n'", "'${' without '}'"),
            ("'${}'", "names no variable"),
            ("'${file.end}'", "'.end' is no part"),
            ("'a${list}'", "is a list"),
        ];
        for (value, want) in bad {
            let message = filled(set, value).unwrap_err();
            assert!(message.contains(want) && message.contains("line 8, column 5"), "{message}");
        }
        assert!(filled("a = '${b}'\nb = '${c}'\nc = '${a}'", "1").unwrap_err().contains("circle"));
        assert!(filled("'a b' = 1", "1").unwrap_err().contains("line 2, column 1"));
    }

    #[test]
    fn a_word_of_the_command_line_is_a_number_where_it_can_be() {
        let of = given;
        let toml = |name: &str, text: &str| (name.to_string(), Value::Toml(text.into()));
        let text = |name: &str, text: &str| (name.to_string(), Value::Text(text.into()));
        assert_eq!(of("n=12").unwrap(), toml("n", "12"));
        assert_eq!(of("n=-1.5").unwrap(), toml("n", "-1.5"));
        assert_eq!(of("on=true").unwrap(), toml("on", "true"));
        assert_eq!(of("lamp=D65").unwrap(), text("lamp", "D65"));
        assert_eq!(of("lamp=").unwrap(), text("lamp", ""));
        assert_eq!(of("f=a=b.exr").unwrap(), text("f", "a=b.exr"));
        assert!(of("n").unwrap_err().to_string().contains("NAME=VALUE"));
        assert!(of("a b=1").is_err());
    }
}
