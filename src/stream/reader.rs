//! Opening any picture that the filters read.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::os::fd::AsFd;
use std::path::Path;

use crate::notes::Notes;
use crate::stream::meaning::{self, Coding, Meaning, Overrides};
use crate::stream::{Block, Header, Picture, header, picture, rgbe, scanlines};
use crate::{Error, Result, invalid};

/// Floats are read at most this many at a time, so that memory grows with what arrives and not with what a header claims.
const STEP: usize = 1 << 20;
/// Buffer for headers and run-length codes; raw floats pass by it.
const BUFFER: usize = 64 << 10;

/// Where bytes come from.
pub struct Input {
    /// For messages: the file's name, or `standard input`.
    pub name: String,
    /// The bytes.
    pub bytes: Bytes,
    /// A regular file: can be read again from `start`.
    pub(super) seekable: bool,
}

/// Buffered bytes, some of which may have been read and given back.
pub struct Bytes {
    given_back: Vec<u8>,
    at: usize,
    inner: BufReader<File>,
}

impl Bytes {
    fn left(&self) -> usize {
        self.given_back.len() - self.at
    }

    /// Puts bytes that were read in front of what is left.
    fn give_back(&mut self, mut bytes: Vec<u8>) {
        bytes.extend_from_slice(&self.given_back[self.at..]);
        self.given_back = bytes;
        self.at = 0;
    }

    pub(super) fn position(&mut self) -> std::io::Result<u64> {
        Ok(self.inner.stream_position()? - self.left() as u64)
    }

    /// The file beneath, wherever it stands.
    pub(super) fn into_file(self) -> File {
        self.inner.into_inner()
    }

    fn seek_to(&mut self, position: u64) -> std::io::Result<()> {
        self.at = self.given_back.len();
        self.inner.seek(SeekFrom::Start(position)).map(drop)
    }
}

impl Read for Bytes {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.left() == 0 {
            return self.inner.read(out);
        }
        let n = (&self.given_back[self.at..]).read(out)?;
        self.at += n;
        Ok(n)
    }
}

impl BufRead for Bytes {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.left() > 0 { Ok(&self.given_back[self.at..]) } else { self.inner.fill_buf() }
    }

    fn consume(&mut self, n: usize) {
        if self.left() > 0 { self.at += n } else { self.inner.consume(n) }
    }
}

impl Input {
    /// Opens a file, or standard input for `None` and `-`.
    pub fn open(path: Option<&Path>) -> Result<Input> {
        let path = path.filter(|p| *p != Path::new("-"));
        let name =
            path.map_or("standard input".to_string(), |p| crate::error::printable(p.as_os_str().as_encoded_bytes()));
        let failed = |e| Error::io(name.clone(), e);
        let file = match path {
            Some(p) => crate::files::open(p).map_err(failed)?,
            None => File::from(std::io::stdin().as_fd().try_clone_to_owned().map_err(failed)?),
        };
        Input::of_file(file, &name)
    }

    /// An open file, read from where it stands; `name` is for messages.
    pub fn of_file(file: File, name: &str) -> Result<Input> {
        let name = name.to_string();
        let kind = file.metadata().map_err(|e| Error::io(name.clone(), e))?.file_type();
        if kind.is_dir() {
            return invalid!("{name}: is a folder; expected a picture");
        }
        enlarge_pipe(&file);
        let bytes = Bytes { given_back: Vec::new(), at: 0, inner: BufReader::with_capacity(BUFFER, file) };
        Ok(Input { name, bytes, seekable: kind.is_file() })
    }

    /// Where it stands, for a regular file, so that it can be read again from there.
    pub fn mark(&mut self) -> Result<Option<u64>> {
        if !self.seekable {
            return Ok(None);
        }
        self.bytes.position().map(Some).map_err(|e| Error::io(self.name.clone(), e))
    }

    /// Back to a mark.
    pub fn back_to(&mut self, mark: u64) -> Result<()> {
        self.bytes.seek_to(mark).map_err(|e| Error::io(self.name.clone(), e))
    }

    /// Back to a position, if it is a regular file; false if not.
    pub(super) fn restart(&mut self, position: u64) -> Result<bool> {
        if self.seekable {
            self.back_to(position)?;
        }
        Ok(self.seekable)
    }

    /// True while bytes are left.
    pub(super) fn has_rest(&mut self) -> bool {
        self.bytes.fill_buf().is_ok_and(|rest| !rest.is_empty())
    }

    /// Up to `count` bytes that come next; they stay to be read.
    pub fn peek(&mut self, count: usize) -> Result<Vec<u8>> {
        let mut first = Vec::new();
        (&mut self.bytes).take(count as u64).read_to_end(&mut first).map_err(|e| Error::io(self.name.clone(), e))?;
        self.bytes.give_back(first.clone());
        Ok(first)
    }
}

/// A pipe of 64 KiB makes its two ends take turns; 1 MiB lets them run side by side. Refused quietly on other files.
pub fn enlarge_pipe(file: &impl AsFd) {
    #[cfg(target_os = "linux")]
    let _ = rustix::pipe::fcntl_setpipe_size(file, 1 << 20);
    #[cfg(not(target_os = "linux"))]
    let _ = file;
}

/// A picture being read.
pub struct Reader {
    input: Input,
    header: Header,
    coding: Coding,
    factors: Option<Vec<f32>>,
    /// Byte position of the first pixel, for seekable input.
    start: u64,
    row: usize,
    notes: Notes,
}

/// Reads a header and settles what the pixels mean. `notes` collects what had to be assumed.
pub fn open(mut input: Input, overrides: &Overrides, notes: &Notes) -> Result<Box<dyn Picture>> {
    let name = input.name.clone();
    let settled = header::read_raw(&mut input.bytes).and_then(|mut raw| {
        input.bytes.give_back(std::mem::take(&mut raw.ahead));
        meaning::settle(raw, overrides)
    });
    let Meaning { header, coding, factors, notes: assumed } = settled.map_err(|e| e.within(&name))?;
    for note in assumed {
        notes.add(format!("{name}: {note}"));
    }
    let start = if input.seekable { input.bytes.position().map_err(|e| Error::io(name, e))? } else { 0 };
    let notes = notes.clone();
    if matches!(coding, Coding::Rgbe | Coding::Xyze) {
        let factors = factors.map_or([1.0; 3], |f| [f[0], f[1], f[2]]);
        return Ok(scanlines::open(input, start, header, factors, notes));
    }
    Ok(Box::new(Reader { input, header, coding, factors, start, row: 0, notes }))
}

impl Reader {
    /// Fills `data` with `rows` scanlines; on failure says how many were whole.
    fn read_rows(&mut self, rows: usize, data: &mut Vec<f32>) -> Result<(), (usize, Error)> {
        let per_row = self.header.scanline_floats();
        match self.coding {
            Coding::Float(swap) => {
                read_floats(&mut self.input.bytes, rows * per_row, data).map_err(|e| (data.len() / per_row, e))?;
                if swap {
                    data.iter_mut().for_each(|x| *x = f32::from_bits(x.to_bits().swap_bytes()));
                }
            }
            _ => {
                data.clear();
                for row in 0..rows {
                    self.read_coded_row(data).map_err(|e| (row, e))?;
                }
            }
        }
        if let Some(factors) =
            self.factors.as_ref().filter(|_| matches!(self.coding, Coding::Float(_) | Coding::Double(_)))
        {
            picture::scale(data, factors);
        }
        Ok(())
    }

    /// Appends one scanline.
    fn read_coded_row(&mut self, data: &mut Vec<f32>) -> Result<()> {
        let width = self.header.resolution.scanline_len();
        let factor = self.factors.as_ref().map_or(1.0, |f| f[0]);
        let input = &mut self.input.bytes;
        match self.coding {
            Coding::Spectra => rgbe::spectral_scanline(input, width, self.header.ncomp, factor, data),
            Coding::Double(swap) => read_doubles(input, width * self.header.ncomp, swap, data),
            Coding::Float(_) | Coding::Rgbe | Coding::Xyze => Ok(()), // the former is read in blocks, the others elsewhere
        }
    }

    /// After the last row: anything left is worth a word.
    fn check_end(&mut self) {
        if self.input.has_rest() {
            self.notes.add(format!("{}: bytes after the last row are ignored", self.input.name));
        }
    }
}

impl Picture for Reader {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let total = self.header.resolution.scanlines();
        let left = total - self.row;
        if left == 0 {
            block.rows = 0;
            block.data.clear();
            return Ok(false);
        }
        let rows = picture::block_rows(&self.header, left);
        if let Err((whole, error)) = self.read_rows(rows, &mut block.data) {
            return Err(explain(error, self.row + whole + 1, total).within(&self.input.name));
        }
        block.rows = rows;
        self.row += rows;
        if self.row == total {
            self.check_end();
        }
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.row = 0;
        self.input.restart(self.start)
    }
}

/// An early end is a fact about the picture, not about the system.
pub(super) fn explain(error: Error, row: usize, total: usize) -> Error {
    match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::Invalid(format!("picture ends at row {row} of {total}"))
        }
        Error::Invalid(m) => Error::Invalid(format!("row {row}: {m}")),
        other => other,
    }
}

/// Fills `data` with `floats` native floats; on an early end `data` holds what came.
fn read_floats(input: &mut Bytes, floats: usize, data: &mut Vec<f32>) -> Result<()> {
    if data.len() > floats {
        data.truncate(floats);
    }
    let mut done = 0;
    while done < floats {
        let end = (done + STEP).min(floats);
        if data.len() < end {
            data.resize(end, 0.0);
        }
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut data[done..end]);
        let mut filled = 0;
        while filled < bytes.len() {
            match input.read(&mut bytes[filled..]) {
                Ok(0) => {
                    data.truncate(done + filled / 4);
                    return Err(Error::io("", std::io::ErrorKind::UnexpectedEof.into()));
                }
                Ok(n) => filled += n,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Error::io("", e)),
            }
        }
        done = end;
    }
    Ok(())
}

fn read_doubles(input: &mut Bytes, floats: usize, swap: bool, data: &mut Vec<f32>) -> Result<()> {
    for _ in 0..floats {
        let mut bytes = [0; 8];
        input.read_exact(&mut bytes).map_err(|e| Error::io("", e))?;
        let value = f64::from_ne_bytes(bytes);
        data.push(if swap { f64::from_bits(value.to_bits().swap_bytes()) } else { value } as f32);
    }
    Ok(())
}
