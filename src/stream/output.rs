//! Where a filter writes: standard output, or a file that appears whole or not at all.

use std::fs::File;
use std::io::{self, IsTerminal, Read, Seek, SeekFrom, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, SpooledTempFile};

use crate::notes::Notes;
use crate::stream::reader::enlarge_pipe;
use crate::stream::spool::Limits;
use crate::{Error, Result, usage};

/// A destination for bytes. Nothing is under a file's final name until [`Output::finish`].
pub struct Output {
    name: String,
    target: Target,
    /// The last refusal of the system and where: libraries in between may lose it.
    failure: Option<(String, io::ErrorKind, Option<i32>)>,
}

enum Target {
    /// Standard output, or an existing pipe or device.
    Stream(File),
    /// A regular file, written beside its final name.
    File(Beside, PathBuf),
}

/// A file in the folder of one that it will take the place of.
enum Beside {
    /// Without a name, so that whatever ends the process takes it away too.
    Unnamed(File),
    /// With a name that begins with `.luxpipe-`, where the system has no files without.
    Named(Box<NamedTempFile>),
}

/// A new file beside the final one, which has a name until then.
fn named_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    builder.tempfile_in(folder)
}

/// The same bytes under a name.
#[cfg(target_os = "linux")]
fn copied(mut from: &File, folder: &Path) -> io::Result<NamedTempFile> {
    let mut to = named_in(folder)?;
    from.seek(SeekFrom::Start(0))?;
    io::copy(&mut from, &mut to)?;
    Ok(to)
}

impl Beside {
    fn create(folder: &Path) -> io::Result<Beside> {
        #[cfg(target_os = "linux")]
        {
            use rustix::fs::{Mode, OFlags};
            let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
            // Its name comes by way of /proc.
            if Path::new("/proc/self/fd").exists()
                && let Ok(file) = rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666))
            {
                return Ok(Beside::Unnamed(File::from(file)));
            }
        }
        named_in(folder).map(Box::new).map(Beside::Named)
    }

    fn file(&self) -> &File {
        match self {
            Beside::Unnamed(file) => file,
            Beside::Named(file) => file.as_file(),
        }
    }

    /// Takes the place of `path`.
    fn persist(self, path: &Path) -> io::Result<()> {
        match self {
            Beside::Named(file) => file.persist(path).map(drop).map_err(|e| e.error),
            #[cfg(target_os = "linux")]
            Beside::Unnamed(file) => {
                use rustix::fs::{AtFlags, CWD};
                use std::os::fd::AsRawFd;
                let own = format!("/proc/self/fd/{}", file.as_raw_fd());
                let link = |name: &Path| rustix::fs::linkat(CWD, &own, CWD, name, AtFlags::SYMLINK_FOLLOW);
                if link(path).is_ok() {
                    return Ok(());
                }
                // A link cannot replace a file; renaming one can.
                let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
                let mut builder = tempfile::Builder::new();
                builder.prefix(PREFIX);
                match builder.make_in(folder, |name| link(name).map_err(io::Error::from)) {
                    Ok(named) => named.persist(path).map_err(|e| e.error),
                    // Where links are not to be had either.
                    Err(_) => copied(&file, folder)?.persist(path).map(drop).map_err(|e| e.error),
                }
            }
            #[cfg(not(target_os = "linux"))]
            Beside::Unnamed(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

/// Names of files that are not whole yet begin so.
const PREFIX: &str = ".luxpipe-";

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
        let file = Beside::create(folder).map_err(|e| failed(plain(e)))?;
        Ok(Output { name, target: Target::File(file, path), failure: None })
    }

    /// An open pipe; `name` is for messages.
    pub fn of_pipe(file: File, name: &str) -> Output {
        enlarge_pipe(&file);
        Output { name: name.to_string(), target: Target::Stream(file), failure: None }
    }

    /// The last act of a filter: everything is written, checked, and the file gets its name. Once is enough; a filter whose
    /// verdict is a failure does it before it says so.
    pub fn finish(&mut self) -> Result<()> {
        self.flush().map_err(|e| self.error(e))?;
        if let Target::File(file, _) = &self.target {
            let written = Target::Stream(file.file().try_clone().map_err(|e| self.error(e))?);
            if let Target::File(file, path) = std::mem::replace(&mut self.target, written) {
                file.persist(&path).map_err(|e| self.error(e))?;
            }
        }
        Ok(())
    }

    /// Suffix of the file's name in small letters, without its dot; none of a stream, or of a name without one.
    pub fn suffix(&self) -> Option<String> {
        match &self.target {
            Target::File(_, path) => path.extension().map(|s| s.to_string_lossy().to_lowercase()),
            Target::Stream(_) => None,
        }
    }

    /// What the system last refused here, if it did.
    pub fn failure(&self) -> Option<Error> {
        let (name, kind, code) = self.failure.clone()?;
        Some(Error::io(name, code.map_or(kind.into(), io::Error::from_raw_os_error)))
    }

    /// Writes by way of a library: what the system refused here, if it did, counts more than what the library makes of it.
    pub fn attempt(&mut self, write: impl FnOnce(&mut Output) -> Result<()>) -> Result<()> {
        write(self).map_err(|e| self.failure().unwrap_or(e))
    }

    /// Keeps the system's word; the result as it was.
    fn noted<T>(&mut self, result: io::Result<T>, name: Option<String>) -> io::Result<T> {
        if let Err(e) = &result {
            self.failure = Some((name.unwrap_or_else(|| self.name.clone()), e.kind(), e.raw_os_error()));
        }
        result
    }

    /// An error of this destination.
    pub fn error(&self, e: io::Error) -> Error {
        Error::io(self.name.clone(), e)
    }
}

/// A destination that can be written in any order. A regular file is written as it lies; what goes to a pipe is kept first, in
/// memory up to a bound and from there in an unlinked file.
pub struct AnyOrder<'a> {
    out: &'a mut Output,
    /// For what cannot seek.
    kept: Option<(Box<SpooledTempFile>, PathBuf)>,
    /// Where the output stood.
    base: u64,
}

impl Output {
    /// This destination, to be written in any order from where it stands.
    pub fn in_any_order(&mut self, limits: &Limits) -> Result<AnyOrder<'_>> {
        let base = match &mut self.target {
            Target::File(..) => Some(0),
            Target::Stream(file) if may_seek(file) => file.stream_position().ok(),
            Target::Stream(_) => None,
        };
        let memory = usize::try_from(limits.memory).unwrap_or(usize::MAX);
        let keep = || (Box::new(tempfile::spooled_tempfile_in(memory, &limits.folder)), limits.folder.clone());
        let kept = base.is_none().then(keep);
        Ok(AnyOrder { out: self, kept, base: base.unwrap_or(0) })
    }
}

/// A regular file that is not written at its end only.
fn may_seek(file: &File) -> bool {
    let regular = file.metadata().is_ok_and(|m| m.is_file());
    #[cfg(target_os = "linux")]
    {
        regular && rustix::fs::fcntl_getfl(file).is_ok_and(|f| !f.contains(rustix::fs::OFlags::APPEND))
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = regular;
        false
    }
}

impl AnyOrder<'_> {
    /// The last act: what was kept goes out.
    pub fn finish(self, notes: &Notes) -> Result<()> {
        let Some((mut kept, folder)) = self.kept else { return Ok(()) };
        let failed = |e| Error::io(folder.display().to_string(), e);
        let bytes = kept.seek(SeekFrom::End(0)).map_err(failed)?;
        if kept.is_rolled() {
            notes.add(format!("spooled {} MB in {}", bytes >> 20, folder.display()));
        }
        kept.rewind().map_err(failed)?;
        let mut buffer = vec![0; 256 << 10];
        loop {
            let n = kept.read(&mut buffer).map_err(failed)?;
            if n == 0 {
                return Ok(());
            }
            self.out.write_all(&buffer[..n]).map_err(|e| self.out.error(e))?;
        }
    }
}

impl Write for AnyOrder<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.kept {
            Some((kept, folder)) => {
                let written = kept.write(bytes);
                self.out.noted(written, Some(folder.display().to_string()))
            }
            None => self.out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for AnyOrder<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let Some((kept, _)) = &mut self.kept else {
            let to = match to {
                SeekFrom::Start(n) => SeekFrom::Start(self.base.saturating_add(n)),
                relative => relative,
            };
            let at = match &mut self.out.target {
                Target::Stream(file) => file.seek(to),
                Target::File(file, _) => file.file().seek(to),
            }?;
            return Ok(at.saturating_sub(self.base));
        };
        kept.seek(to)
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
            Target::File(file, _) => file.file().write(bytes),
        };
        self.noted(written, None)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.target {
            Target::Stream(file) => file.flush(),
            Target::File(file, _) => file.file().flush(),
        }
    }
}
