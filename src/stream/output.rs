//! Where a filter writes: standard output, or a file that appears whole or not at all.

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::stream::reader::enlarge_pipe;
use crate::{Error, Result, usage};

/// A destination for bytes. Nothing is under a file's final name until [`Output::finish`].
pub struct Output {
    name: String,
    target: Target,
    /// The last refusal of the system: libraries in between may lose it.
    failure: Option<(io::ErrorKind, Option<i32>)>,
}

enum Target {
    /// Standard output, or an existing pipe or device.
    Stream(File),
    /// A regular file, written beside its final name.
    File(Box<NamedTempFile>, PathBuf),
}

impl Output {
    /// Opens a file, or standard output for `None` and `-`. Floats are not shown to a terminal: `binary` asks for the check.
    pub fn create(path: Option<&Path>, binary: bool) -> Result<Output> {
        let Some(path) = path.filter(|p| *p != Path::new("-")) else {
            if binary && io::stdout().is_terminal() {
                return usage!("standard output is a terminal; redirect it or name an output file");
            }
            let name = "standard output".to_string();
            let file = io::stdout().as_fd().try_clone_to_owned().map_err(|e| Error::io(name.clone(), e))?;
            let file = File::from(file);
            enlarge_pipe(&file);
            return Ok(Output { name, target: Target::Stream(file), failure: None });
        };
        let name = crate::error::printable(path.as_os_str().as_encoded_bytes());
        let failed = |e| Error::io(name.clone(), e);
        // A link is written through: what it points to is replaced, not the link.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if path.metadata().is_ok_and(|m| !m.is_file()) {
            let file = File::options().write(true).open(&path).map_err(failed)?;
            return Ok(Output { name, target: Target::Stream(file), failure: None });
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".luxpipe-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
        }
        let file = builder.tempfile_in(folder).map_err(|e| failed(plain(e)))?;
        Ok(Output { name, target: Target::File(Box::new(file), path), failure: None })
    }

    /// The last act of a filter: everything is written, checked, and the file gets its name. Once is enough; a filter whose
    /// verdict is a failure does it before it says so.
    pub fn finish(&mut self) -> Result<()> {
        self.flush().map_err(|e| self.error(e))?;
        if let Target::File(file, _) = &self.target {
            let written = Target::Stream(file.as_file().try_clone().map_err(|e| self.error(e))?);
            if let Target::File(file, path) = std::mem::replace(&mut self.target, written) {
                file.persist(path).map_err(|e| self.error(e.error))?;
            }
        }
        Ok(())
    }

    /// What the system last refused here, if it did.
    pub fn failure(&self) -> Option<Error> {
        let (kind, code) = self.failure?;
        Some(self.error(code.map_or(kind.into(), io::Error::from_raw_os_error)))
    }

    /// An error of this destination.
    pub fn error(&self, e: io::Error) -> Error {
        Error::io(self.name.clone(), e)
    }
}

/// The system's word without the temporary file's name, which tells a user nothing.
fn plain(e: io::Error) -> io::Error {
    let inner = e.get_ref().and_then(|c| c.source()).and_then(|c| c.downcast_ref::<io::Error>());
    inner.and_then(io::Error::raw_os_error).map_or(e, io::Error::from_raw_os_error)
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.target {
            Target::Stream(file) => file.write(bytes),
            Target::File(file, _) => file.as_file_mut().write(bytes),
        };
        if let Err(e) = &written {
            self.failure = Some((e.kind(), e.raw_os_error()));
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.target {
            Target::Stream(file) => file.flush(),
            Target::File(file, _) => file.as_file_mut().flush(),
        }
    }
}
