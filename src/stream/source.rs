//! Input that is read in any order: a regular file as it lies, anything else kept first, in memory up to a bound and from
//! there in an unlinked file.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use tempfile::SpooledTempFile;

use crate::notes::Notes;
use crate::stream::reader::Input;
use crate::stream::spool::Limits;
use crate::{Error, Result, invalid};

/// Bytes with a known length. Positions count from where the input stood when it was opened.
pub struct Source {
    /// For messages: the file's name, or `standard input`.
    pub name: String,
    data: Data,
    base: u64,
    len: u64,
}

enum Data {
    File(File),
    Kept(Box<SpooledTempFile>),
}

impl Source {
    /// Takes the whole input.
    pub fn new(input: Input, limits: &Limits, notes: &Notes) -> Result<Source> {
        let Input { name, mut bytes, seekable } = input;
        let failed = |e| Error::io(name.clone(), e);
        if seekable {
            let base = bytes.position().map_err(failed)?;
            let file = bytes.into_file();
            let len = file.metadata().map_err(failed)?.len().saturating_sub(base);
            return Ok(Source { data: Data::File(file), base, len, name });
        }
        let folder = limits.folder.display().to_string();
        let memory = usize::try_from(limits.memory).unwrap_or(usize::MAX);
        let mut kept = tempfile::spooled_tempfile_in(memory, &limits.folder);
        let mut buffer = vec![0; 64 << 10];
        loop {
            match bytes.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => io::Write::write_all(&mut kept, &buffer[..n]).map_err(|e| Error::io(folder.clone(), e))?,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(failed(e)),
            }
        }
        let len = kept.stream_position().map_err(|e| Error::io(folder.clone(), e))?;
        if kept.is_rolled() {
            notes.add(format!("spooled {} MB in {folder}", len >> 20));
        }
        Ok(Source { data: Data::Kept(Box::new(kept)), base: 0, len, name })
    }

    /// Number of bytes.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// True where there is nothing.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Refuses what lies beyond the end.
    pub fn check(&self, offset: u64, count: u64) -> Result<usize> {
        let end = offset.checked_add(count).filter(|end| *end <= self.len);
        match end.and_then(|_| usize::try_from(count).ok()) {
            Some(count) => Ok(count),
            None => {
                invalid!("bytes {offset} to {} lie beyond the end at {}", offset.saturating_add(count), self.len)
            }
        }
    }

    /// Replaces `out` by `count` bytes from `offset`. What lies beyond the end is refused before anything is allocated.
    pub fn read_at(&mut self, offset: u64, count: u64, out: &mut Vec<u8>) -> Result<()> {
        let count = self.check(offset, count)?;
        out.resize(count, 0);
        let read = self.seek(SeekFrom::Start(offset)).and_then(|_| self.read_exact(out));
        read.map_err(|e| Error::io("", e))
    }

    /// `N` bytes from `offset`.
    pub fn array_at<const N: usize>(&mut self, offset: u64) -> Result<[u8; N]> {
        let mut bytes = Vec::new();
        self.read_at(offset, N as u64, &mut bytes)?;
        Ok(bytes.try_into().unwrap_or([0; N])) // has N bytes
    }
}

impl Read for Source {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match &mut self.data {
            Data::File(file) => file.read(out),
            Data::Kept(kept) => kept.read(out),
        }
    }
}

impl Seek for Source {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let to = match to {
            SeekFrom::Start(n) => SeekFrom::Start(self.base.saturating_add(n)),
            relative => relative,
        };
        let at = match &mut self.data {
            Data::File(file) => file.seek(to),
            Data::Kept(kept) => kept.seek(to),
        }?;
        Ok(at.saturating_sub(self.base))
    }
}
