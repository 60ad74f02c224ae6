//! One primitive with its arguments: `modifier type name`, then three counts, each followed by so many arguments: words, whole numbers
//! (nothing uses them), numbers. An alias has one word in their place.

use std::rc::Rc;

use crate::Result;
use crate::error::printable;
use crate::radiance::Place;
use crate::radiance::lex::Lexer;

/// What modifies nothing.
pub const VOID: &str = "void";

/// Most arguments of a primitive that memory is taken for at once.
const MOST_AT_ONCE: usize = 1 << 16;

/// A primitive as written.
#[derive(Debug)]
pub struct Object {
    /// Name of what modifies it.
    pub modifier: String,
    /// Its type.
    pub kind: String,
    /// Its name.
    pub name: String,
    /// Words; of an alias, what it stands for.
    pub strings: Vec<String>,
    /// Numbers.
    pub reals: Vec<f64>,
    /// Where it begins.
    pub place: Place,
}

impl Object {
    /// Reads one where [`crate::radiance::lex::Next::Primitive`] was announced.
    pub fn read(lex: &mut Lexer, file: &Rc<str>) -> Result<Object> {
        let place = Place { file: file.clone(), line: lex.line() };
        let mut head = || {
            let word = lex.word().map(|w| w.0);
            word.ok_or_else(|| {
                place.wrong("the file ends within a primitive; expected modifier, type, name, arguments")
            })
        };
        let (modifier, kind, name) = (head()?, head()?, head()?);
        let mut object = Object { modifier, kind, name, strings: Vec::new(), reals: Vec::new(), place };
        if object.kind == "alias" {
            object.strings = object.arguments(lex, 1, "word", |w| Some(w.to_string()))?;
            return Ok(object);
        }
        let n = object.number_of(lex, "words")?;
        object.strings = object.arguments(lex, n, "word", |w| Some(w.to_string()))?;
        let n = object.number_of(lex, "whole numbers")?;
        object.arguments(lex, n, "whole number", |w| w.parse::<i64>().ok())?;
        let n = object.number_of(lex, "numbers")?;
        object.reals = object.arguments(lex, n, "number", |w| w.parse().ok().filter(|x: &f64| x.is_finite()))?;
        Ok(object)
    }

    /// Type and name, for messages.
    pub fn shown(&self) -> String {
        format!("{} '{}'", printable(self.kind.as_bytes()), printable(self.name.as_bytes()))
    }

    /// A complaint about it.
    pub fn wrong(&self, message: impl std::fmt::Display) -> crate::Error {
        self.place.wrong(format!("{}: {message}", self.shown()))
    }

    fn number_of(&self, lex: &mut Lexer, what: &str) -> Result<usize> {
        let Some((word, line)) = lex.word() else {
            return Err(self.wrong(format!("the file ends before the number of its {what}")));
        };
        word.parse().map_err(|_| {
            let here = Place { line, ..self.place.clone() };
            let (name, word) = (self.shown(), printable(word.as_bytes()));
            here.wrong(format!("{name}: '{word}' is no number of {what}; expected a whole number from 0"))
        })
    }

    fn arguments<T>(&self, lex: &mut Lexer, n: usize, what: &str, read: impl Fn(&str) -> Option<T>) -> Result<Vec<T>> {
        let mut list = Vec::with_capacity(n.min(MOST_AT_ONCE));
        for i in 0..n {
            let Some((word, line)) = lex.word() else {
                return Err(self.wrong(format!("the file ends after {i} of {n} arguments")));
            };
            list.push(read(&word).ok_or_else(|| {
                let here = Place { line, ..self.place.clone() };
                let (name, word) = (self.shown(), printable(word.as_bytes()));
                here.wrong(format!("{name}: argument {} of {n}, '{word}', is no {what}", i + 1))
            })?);
        }
        Ok(list)
    }

    /// Its numbers, exactly `N` of them and no words.
    pub fn exactly<const N: usize>(&self, what: &str) -> Result<[f64; N]> {
        if !self.strings.is_empty() {
            return Err(self.wrong(format!("has {} words; expected 0, then {what}", self.strings.len())));
        }
        self.reals
            .as_slice()
            .try_into()
            .map_err(|_| self.wrong(format!("has {} numbers; expected {N}: {what}", self.reals.len())))
    }
}
