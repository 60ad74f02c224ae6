//! Files that the work depends on. They are read here, so that whoever asks ([`noted`]) learns which they were: a scene names spectra,
//! meshes and pictures that a Makefile must know.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// What has been read since somebody asked.
static NOTED: Mutex<Option<Vec<PathBuf>>> = Mutex::new(None);
/// One asks at a time.
static ASKING: Mutex<()> = Mutex::new(());

/// Opens a file.
pub fn open(path: impl AsRef<Path>) -> io::Result<File> {
    let file = File::open(&path)?;
    if let Some(list) = NOTED.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
        list.push(path.as_ref().to_path_buf());
    }
    Ok(file)
}

/// All of a file.
pub fn read(path: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut open(path)?, &mut bytes)?;
    Ok(bytes)
}

/// All of a text file.
pub fn read_to_string(path: impl AsRef<Path>) -> io::Result<String> {
    io::read_to_string(open(path)?)
}

/// Does some work and tells which files it has read, each once, in the order of their names.
///
/// ```
/// let (text, files) = luxpipe::files::noted(|| luxpipe::files::read_to_string("Cargo.toml"));
/// assert!(text.unwrap().contains("luxpipe"));
/// assert_eq!(files, [std::path::Path::new("Cargo.toml")]);
/// ```
pub fn noted<T>(work: impl FnOnce() -> T) -> (T, Vec<PathBuf>) {
    let _alone = ASKING.lock().unwrap_or_else(PoisonError::into_inner);
    *NOTED.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
    let done = work();
    let mut files = NOTED.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default();
    files.sort();
    files.dedup();
    (done, files)
}
