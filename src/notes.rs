//! Remarks for standard error: gathered while a filter works, printed only when it succeeds.

use std::sync::{Arc, Mutex, PoisonError};

/// A shared list of remarks, each one line, each kept once.
#[derive(Clone, Debug, Default)]
pub struct Notes {
    list: Arc<Mutex<Vec<String>>>,
    /// Who speaks, where several share the list.
    speaker: String,
}

impl Notes {
    /// The same list; remarks added here begin with `speaker`.
    pub fn of(&self, speaker: &str) -> Notes {
        Notes { list: self.list.clone(), speaker: format!("{speaker}: ") }
    }

    /// Adds a remark unless it is there already.
    pub fn add(&self, note: impl Into<String>) {
        let note = self.speaker.clone() + &note.into();
        let mut notes = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        if !notes.contains(&note) {
            notes.push(note);
        }
    }

    /// Adds several.
    pub fn extend(&self, notes: &[String]) {
        notes.iter().for_each(|n| self.add(n.as_str()));
    }

    /// Takes all remarks out.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut self.list.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
