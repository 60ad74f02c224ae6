//! Files, one within the other: primitives go to where they belong, `!xform` lines open other files, and nothing is run.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::printable;
use crate::radiance::lex::{Lexer, Next, shell_words};
use crate::radiance::object::Object;
use crate::radiance::xform::{Copy, Motion, Xform};
use crate::radiance::{Place, Scene, shown};
use crate::{Error, Result};

/// Most files within each other.
const DEEPEST: usize = 64;

/// What lines around a primitive do to it.
#[derive(Clone, Debug)]
pub struct Around {
    /// Where it goes.
    pub motion: Motion,
    /// What its name begins with.
    pub prefix: Option<String>,
    /// What modifies surfaces instead of their own modifier.
    pub modifier: Option<String>,
    /// Surfaces are inside out.
    pub inverted: bool,
}

impl Around {
    /// A primitive by itself.
    const NOTHING: Around = Around { motion: Motion::NONE, prefix: None, modifier: None, inverted: false };

    /// What a copy within does, and then this.
    fn over(&self, copy: &Copy) -> Around {
        let prefix = match (&self.prefix, &copy.prefix) {
            (Some(outer), Some(inner)) => Some(format!("{outer}.{inner}")),
            (outer, inner) => outer.clone().or(inner.clone()),
        };
        Around {
            motion: copy.motion.then(&self.motion),
            prefix,
            // The outer xform comes last, and replaces what the inner one wrote.
            modifier: self.modifier.clone().or(copy.modifier.clone()),
            inverted: self.inverted != copy.inverted,
        }
    }

    /// A name as `-n` has it.
    pub fn name(&self, name: &str) -> String {
        self.prefix.as_ref().map_or(name.to_string(), |p| format!("{p}.{name}"))
    }
}

/// Reads a file of the command line.
pub fn file(path: &Path, scene: &mut Scene) -> Result<()> {
    let name = shown(path);
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| Error::io("standard input", e))?;
        return Reader { scene, open: Vec::new() }.text(&bytes, &name, Path::new("."), &Around::NOTHING);
    }
    let bytes = crate::files::read(path).map_err(|e| Error::io(name.clone(), e))?;
    let full = std::fs::canonicalize(path).map_err(|e| Error::io(name.clone(), e))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    Reader { scene, open: vec![full] }.text(&bytes, &name, folder, &Around::NOTHING)
}

struct Reader<'s> {
    scene: &'s mut Scene,
    /// Files that are being read, the outermost first.
    open: Vec<PathBuf>,
}

impl Reader<'_> {
    fn text(&mut self, bytes: &[u8], name: &str, folder: &Path, around: &Around) -> Result<()> {
        let file: Rc<str> = name.into();
        let mut lex = Lexer::new(bytes);
        loop {
            match lex.next() {
                Next::End => return Ok(()),
                Next::Primitive => {
                    let object = Object::read(&mut lex, &file)?;
                    self.scene.add(object, around, folder)?;
                }
                Next::Command(text, line) => {
                    self.command(&text, &Place { file: file.clone(), line }, folder, around)?
                }
            }
        }
    }

    /// A line from `!` on: `xform` is done here, no other program is run.
    fn command(&mut self, text: &str, place: &Place, folder: &Path, around: &Around) -> Result<()> {
        let shown = printable(text.trim().as_bytes());
        let words = shell_words(text);
        let (Ok(words), true) = (&words, text.trim_start().starts_with("xform")) else {
            let message = format!(
                "'!{shown}' is a command, and none is run; expected !xform ARGUMENTS FILE, or what the command prints"
            );
            return self.scene.refuse(place, "command", &message);
        };
        if words.first().is_none_or(|w| w != "xform") {
            return self.scene.refuse(place, "command", &format!("'!{shown}' is a command, and none is run"));
        }
        let open =
            |path: &Path| crate::files::read(beside(folder, path)).map_err(|e| format!("-f {}: {e}", path.display()));
        let xform = Xform::parse(&words[1..], &open).map_err(|e| place.wrong(format!("xform: {e}")))?;
        for copy in &xform.copies {
            for name in &xform.files {
                self.include(Path::new(name), place, folder, &around.over(copy))?;
            }
        }
        Ok(())
    }

    fn include(&mut self, path: &Path, place: &Place, folder: &Path, around: &Around) -> Result<()> {
        let found = beside(folder, path);
        let name = printable(found.as_os_str().as_encoded_bytes());
        let no = |e: std::io::Error| place.wrong(format!("xform: cannot read '{name}': {e}"));
        let full = std::fs::canonicalize(&found).map_err(no)?;
        if self.open.contains(&full) {
            return Err(place.wrong(format!("xform: '{name}' is being read already; a file cannot hold itself")));
        }
        if self.open.len() >= DEEPEST {
            return Err(place.wrong(format!("xform: more than {DEEPEST} files within each other")));
        }
        let bytes = crate::files::read(&found).map_err(no)?;
        self.open.push(full);
        let folder = found.parent().unwrap_or(Path::new(".")).to_path_buf();
        self.text(&bytes, &name, &folder, around)?;
        self.open.pop();
        Ok(())
    }
}

/// A file that another names: beside that, else where the program was started.
pub fn beside(folder: &Path, name: &Path) -> PathBuf {
    let near = folder.join(name);
    if near.exists() || !name.exists() { near } else { name.to_path_buf() }
}
