//! Rows of a picture kept in a file while it is rendered, so that a killed render goes on where it was.
//!
//! The file is a line `luxpipe checkpoint 2 FINGERPRINT`, then blocks: number of the first row and number of values (u64,
//! little endian), a check sum (u64) and the values (f32). A block that was cut off or does not add up ends the file's use;
//! what follows is rendered again. The fingerprint stands for the scene, the options and the program: with another one the
//! file is refused.

use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::{Error, Result};

const MAGIC: &str = "luxpipe checkpoint 2";

/// An open checkpoint file.
pub struct Checkpoint {
    path: PathBuf,
    file: File,
    /// First row and place of the values of each whole block, in order.
    blocks: Vec<(u64, u64, u64)>,
    next: usize,
}

/// A number that stands for everything that a picture depends on.
pub fn fingerprint(parts: &[&[u8]]) -> u64 {
    let mut hasher = DefaultHasher::new();
    parts.hash(&mut hasher);
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    hasher.finish()
}

fn check_sum(values: &[f32]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytemuck::cast_slice::<f32, u8>(values).hash(&mut hasher);
    hasher.finish()
}

impl Checkpoint {
    /// Opens the file or begins it.
    pub fn open(path: &Path, fingerprint: u64) -> Result<Checkpoint> {
        let failed = |e| Error::io(path.display().to_string(), e);
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let mut checkpoint = Checkpoint { path: path.to_path_buf(), file, blocks: Vec::new(), next: 0 };
        let line = format!("{MAGIC} {fingerprint:016x}\n");
        let length = checkpoint.file.metadata().map_err(failed)?.len();
        if length == 0 {
            checkpoint.file.write_all(line.as_bytes()).map_err(failed)?;
            return Ok(checkpoint);
        }
        let mut begins = vec![0; line.len().min(length as usize)];
        checkpoint.file.read_exact(&mut begins).map_err(failed)?;
        if begins.len() < line.len() && line.as_bytes().starts_with(&begins) {
            // Killed while it wrote its first line.
            checkpoint.file.set_len(0).and_then(|()| checkpoint.file.rewind()).map_err(failed)?;
            checkpoint.file.write_all(line.as_bytes()).map_err(failed)?;
            return Ok(checkpoint);
        }
        if !begins.starts_with(MAGIC.as_bytes()) {
            let message = "is no checkpoint; name a new file, or one that an earlier run left".into();
            return Err(Error::Invalid(message).in_file(path));
        }
        if begins != line.as_bytes() {
            let message = "the checkpoint is of another scene or other options; take those, or remove it".into();
            return Err(Error::Invalid(message).in_file(path));
        }
        let end = checkpoint.scan(line.len() as u64, length).map_err(failed)?;
        checkpoint.file.set_len(end).map_err(failed)?;
        Ok(checkpoint)
    }

    /// Finds the whole blocks; returns where they end.
    fn scan(&mut self, mut at: u64, length: u64) -> std::io::Result<u64> {
        let mut reader = BufReader::new(&self.file);
        reader.seek(SeekFrom::Start(at))?;
        let mut blocks = Vec::new();
        let mut head = [0; 24];
        let mut values = Vec::new();
        while at + 24 <= length {
            reader.read_exact(&mut head)?;
            let word = |i: usize| u64::from_le_bytes(std::array::from_fn(|k| head[8 * i + k]));
            let (row, count, sum) = (word(0), word(1), word(2));
            let Some(end) = count.checked_mul(4).and_then(|b| b.checked_add(at + 24)).filter(|e| *e <= length) else {
                break;
            };
            values.resize(count as usize, 0f32);
            reader.read_exact(bytemuck::cast_slice_mut(&mut values))?;
            if check_sum(&values) != sum {
                break;
            }
            blocks.push((row, count, at + 24));
            at = end;
        }
        self.blocks = blocks;
        Ok(at)
    }

    /// Fills `data` with the block that begins at `row` if it is there.
    pub fn recall(&mut self, row: usize, data: &mut [f32]) -> Result<bool> {
        let Some((first, count, at)) = self.blocks.get(self.next).copied() else { return Ok(false) };
        if first != row as u64 || count != data.len() as u64 || data.is_empty() {
            return Ok(false);
        }
        let failed = |e| Error::io(self.path.display().to_string(), e);
        self.file.seek(SeekFrom::Start(at)).map_err(failed)?;
        self.file.read_exact(bytemuck::cast_slice_mut(data)).map_err(failed)?;
        self.next += 1;
        Ok(true)
    }

    /// Adds a block.
    pub fn keep(&mut self, row: usize, data: &[f32]) -> Result<()> {
        if data.is_empty() {
            return Ok(());
        }
        let failed = |e| Error::io(self.path.display().to_string(), e);
        let mut bytes = Vec::with_capacity(24 + 4 * data.len());
        for word in [row as u64, data.len() as u64, check_sum(data)] {
            bytes.extend_from_slice(&word.to_le_bytes());
        }
        bytes.extend_from_slice(bytemuck::cast_slice(data));
        self.file.seek(SeekFrom::End(0)).map_err(failed)?;
        self.file.write_all(&bytes).map_err(failed)
    }

    /// The picture is whole: the file has done its work.
    pub fn remove(self) -> Result<()> {
        std::fs::remove_file(&self.path).map_err(|e| Error::io(self.path.display().to_string(), e))
    }
}
