//! The numbers of an IES file, one after the other, each with its line.

use std::ops::RangeInclusive;

use crate::error::printable;
use crate::{Result, invalid};

/// The rest of a file.
pub(super) struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// Line of the last word, from 1.
    line: usize,
}

impl<'a> Numbers<'a> {
    /// The words after line `skip` (from 0).
    pub(super) fn after(text: &'a str, skip: usize) -> Numbers<'a> {
        let lines = text.lines().enumerate().skip(skip + 1);
        let apart = |c: char| c.is_whitespace() || c == ',' || c == '\0';
        let words =
            lines.flat_map(move |(n, line)| line.split(apart).filter(|w| !w.is_empty()).map(move |w| (n + 1, w)));
        Numbers { words: Box::new(words.filter(|w| w.1 != "\u{1a}")), line: skip + 1 }
    }

    /// Line of the last number read, from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// An error at the last number's line.
    pub(super) fn refuse<T>(&self, what: &str) -> Result<T> {
        invalid!("line {}: {what}", self.line)
    }

    /// The next number, within bounds.
    pub(super) fn within(&mut self, what: &str, range: RangeInclusive<f64>) -> Result<f64> {
        let Some((line, word)) = self.words.next() else {
            return invalid!("the file ends after line {} before {what}", self.line);
        };
        self.line = line;
        match word.parse::<f64>() {
            Ok(x) if range.contains(&x) => Ok(x),
            Ok(x) => self.refuse(&format!("{what} is {x}; it must be {} to {}", range.start(), range.end())),
            Err(_) => self.refuse(&format!("{what} must be a number, got '{}'", printable(word.as_bytes()))),
        }
    }

    /// The next number, a whole one.
    pub(super) fn count(&mut self, what: &str, least: usize, most: usize) -> Result<usize> {
        let x = self.within(what, least as f64..=most as f64)?;
        if x.fract() == 0.0 { Ok(x as usize) } else { self.refuse(&format!("{what} must be a whole number, got {x}")) }
    }

    /// The next n numbers. Memory grows with what is there, not with n.
    pub(super) fn many(&mut self, what: &str, n: usize, range: RangeInclusive<f64>) -> Result<Vec<f64>> {
        (1..=n).map(|i| self.within(&format!("{what} {i} of {n}"), range.clone())).collect()
    }

    /// The next n angles, each above the last.
    pub(super) fn ascending(&mut self, what: &str, n: usize) -> Result<Vec<f64>> {
        let mut angles: Vec<f64> = Vec::new();
        for i in 1..=n {
            let angle = self.within(&format!("{what} {i} of {n}"), -360.0..=360.0)?;
            if let Some(last) = angles.last().filter(|last| angle <= **last) {
                return self.refuse(&format!("{what} {i} of {n} is {angle}; it must be above the last, {last}"));
            }
            angles.push(angle);
        }
        Ok(angles)
    }

    /// Nothing may follow.
    pub(super) fn end(&mut self) -> Result<()> {
        match self.words.next() {
            None => Ok(()),
            Some((line, word)) => {
                invalid!("line {line}: '{}' after the last intensity; do the counts fit?", printable(word.as_bytes()))
            }
        }
    }
}
