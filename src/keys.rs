//! Reading TOML tables key by key, every complaint with its line, column and key.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::error::printable;
use crate::notes::Notes;
use crate::{Error, Result};

/// A message about a place in a TOML text.
pub fn located(text: &str, span: Option<Range<usize>>, message: &str) -> Error {
    let message = message.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let Some(span) = span else { return Error::Invalid(message) };
    let before = text.get(..span.start).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    Error::Invalid(format!("line {line}, column {column}: {message}"))
}

/// Parses a TOML text into its top table.
pub fn parse(text: &str) -> Result<Keys<'_>> {
    let root = DeTable::parse(text).map_err(|e| located(text, e.span(), e.message()))?;
    let span = root.span();
    let notes = Notes::default();
    Ok(Keys { text, what: String::new(), span, table: root.into_inner(), known: Vec::new(), notes })
}

/// A table inside a text, called `what` in messages.
pub fn of_table<'a>(text: &'a str, what: &str, span: Range<usize>, table: DeTable<'a>) -> Keys<'a> {
    Keys { text, what: what.into(), span, table, known: Vec::new(), notes: Notes::default() }
}

/// A table being read: what is taken is gone, what is left at the end is unknown.
pub struct Keys<'a> {
    text: &'a str,
    /// Where it stands, such as `materials.white`; empty for the top.
    pub what: String,
    span: Range<usize>,
    table: DeTable<'a>,
    known: Vec<&'static str>,
    notes: Notes,
}

/// A value with its place.
pub type Value<'a> = Spanned<DeValue<'a>>;

impl<'a> Keys<'a> {
    fn path(&self, key: &str) -> String {
        if self.what.is_empty() { key.to_string() } else { format!("{}.{key}", self.what) }
    }

    /// What is noticed while the text and the files it names are read: one list for all its tables.
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// A complaint about the table as a whole.
    pub fn wrong(&self, message: &str) -> Error {
        let what = if self.what.is_empty() { String::new() } else { format!("{}: ", self.what) };
        located(self.text, Some(self.span.clone()), &format!("{what}{message}"))
    }

    /// A complaint about one key.
    pub fn wrong_key(&self, key: &str, span: Range<usize>, message: &str) -> Error {
        located(self.text, Some(span), &format!("{}: {message}", self.path(key)))
    }

    /// Takes a value out.
    pub fn take(&mut self, key: &'static str) -> Option<Value<'a>> {
        self.known.push(key);
        self.table.remove(key)
    }

    /// A value of type `T` with its place, if the key is there.
    pub fn get_spanned<T: Deserialize<'a>>(&mut self, key: &'static str) -> Result<Option<(T, Range<usize>)>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let span = value.span();
        match T::deserialize(ValueDeserializer::from(value)) {
            Ok(v) => Ok(Some((v, span))),
            Err(e) => Err(self.wrong_key(key, e.span().unwrap_or(span), e.message())),
        }
    }

    /// A copy of a value of type `T`, if the key is there and holds one.
    pub fn peek<T: Deserialize<'a>>(&self, key: &str) -> Option<T> {
        let value = self.table.get(key)?;
        T::deserialize(ValueDeserializer::from(value.clone())).ok()
    }

    /// A value of type `T`, if the key is there.
    pub fn get<T: Deserialize<'a>>(&mut self, key: &'static str) -> Result<Option<T>> {
        Ok(self.get_spanned(key)?.map(|v| v.0))
    }

    /// A value of type `T` that must be there.
    pub fn need<T: Deserialize<'a>>(&mut self, key: &'static str) -> Result<T> {
        self.get(key)?.ok_or_else(|| self.wrong(&format!("key '{key}' is missing")))
    }

    /// A number that must be there and pass a test; `right` says what would.
    pub fn number(&mut self, key: &'static str, right: &str, test: impl Fn(f64) -> bool) -> Result<Option<f64>> {
        match self.get_spanned::<f64>(key)? {
            Some((x, _)) if test(x) => Ok(Some(x)),
            Some((x, span)) => Err(self.wrong_key(key, span, &format!("{x} {right}"))),
            None => Ok(None),
        }
    }

    /// A table inside.
    pub fn table(&mut self, key: &'static str) -> Result<Option<Keys<'a>>> {
        match self.take(key) {
            None => Ok(None),
            Some(value) => self.enter(&self.path(key), value).map(Some),
        }
    }

    /// The tables of a table, in the order of their names.
    pub fn tables(&mut self, key: &'static str) -> Result<Vec<(String, Keys<'a>)>> {
        let Some(inner) = self.table(key)? else { return Ok(Vec::new()) };
        let Keys { table, what, .. } = inner;
        let enter = |(name, value): (Spanned<_>, Value<'a>)| {
            let name: std::borrow::Cow<str> = name.into_inner();
            let keys = self.enter(&format!("{what}.{}", printable(name.as_bytes())), value)?;
            Ok((name.into_owned(), keys))
        };
        table.into_iter().map(enter).collect()
    }

    /// The tables of an array of tables.
    pub fn array(&mut self, key: &'static str) -> Result<Vec<Keys<'a>>> {
        let Some(value) = self.take(key) else { return Ok(Vec::new()) };
        let span = value.span();
        let DeValue::Array(items) = value.into_inner() else {
            return Err(self.wrong_key(key, span, &format!("is written [[{key}]]")));
        };
        items.into_iter().enumerate().map(|(i, v)| self.enter(&format!("{}[{}]", self.path(key), i + 1), v)).collect()
    }

    fn enter(&self, what: &str, value: Value<'a>) -> Result<Keys<'a>> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => {
                let (text, notes) = (self.text, self.notes.clone());
                Ok(Keys { text, what: what.to_string(), span, table, known: Vec::new(), notes })
            }
            other => {
                Err(located(self.text, Some(span), &format!("{what}: expected a table, got {}", other.type_str())))
            }
        }
    }

    /// Ends the reading: a key that nobody took is an error.
    pub fn finish(self) -> Result<()> {
        let Some((key, _)) = self.table.iter().next() else { return Ok(()) };
        let known = self.known.join(", ");
        let message = format!("unknown key; expected one of {known}");
        Err(self.wrong_key(&printable(key.get_ref().as_bytes()), key.span(), &message))
    }
}
