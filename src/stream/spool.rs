//! Reading a picture twice: a seekable file is read again, anything else is kept, in memory up to a bound and from there in
//! an unlinked file.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

use crate::notes::Notes;
use crate::stream::{Block, Header, Picture, picture};
use crate::{Error, Result};

/// Where and how much to keep.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Bytes kept in memory.
    pub memory: u64,
    /// Folder for the rest.
    pub folder: PathBuf,
}

/// A kept picture that can be rewound.
struct Spooled {
    header: Header,
    kept: Kept,
    row: usize,
}

enum Kept {
    Memory(Vec<f32>),
    File(File, PathBuf),
}

/// Hands the whole picture to `look`, block by block, and returns it ready to be read again.
pub fn twice(
    mut input: Box<dyn Picture>,
    limits: &Limits,
    notes: &Notes,
    mut look: impl FnMut(&Header, &Block),
) -> Result<Box<dyn Picture>> {
    let header = input.header().clone();
    let mut block = Block::default();
    if input.rewind()? {
        while input.next(&mut block)? {
            look(&header, &block);
        }
        input.rewind()?;
        return Ok(input);
    }
    let bytes = 4 * header.scanline_floats() as u64 * header.resolution.scanlines() as u64;
    let failed = |e| Error::io(limits.folder.display().to_string(), e);
    let mut kept = if bytes <= limits.memory {
        Kept::Memory(Vec::new())
    } else {
        notes.add(format!("spooled {} MB in {}", bytes >> 20, limits.folder.display()));
        Kept::File(tempfile::tempfile_in(&limits.folder).map_err(failed)?, limits.folder.clone())
    };
    while input.next(&mut block)? {
        look(&header, &block);
        match &mut kept {
            Kept::Memory(data) => data.extend_from_slice(&block.data),
            Kept::File(file, _) => file.write_all(bytemuck::cast_slice(&block.data)).map_err(failed)?,
        }
    }
    let mut spooled = Spooled { header, kept, row: 0 };
    spooled.rewind()?;
    Ok(Box::new(spooled))
}

impl Spooled {
    fn rows(&mut self, first: usize, rows: usize, data: &mut Vec<f32>) -> Result<()> {
        let per_row = self.header.scanline_floats();
        match &mut self.kept {
            Kept::Memory(all) => {
                data.clear();
                data.extend_from_slice(&all[first * per_row..(first + rows) * per_row]);
            }
            Kept::File(file, folder) => {
                data.resize(rows * per_row, 0.0);
                let read = file.read_exact(bytemuck::cast_slice_mut(data));
                read.map_err(|e| Error::io(folder.display().to_string(), e))?;
            }
        }
        Ok(())
    }
}

impl Picture for Spooled {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let left = self.header.resolution.scanlines() - self.row;
        if left == 0 {
            block.rows = 0;
            block.data.clear();
            return Ok(false);
        }
        let rows = picture::block_rows(&self.header, left);
        self.rows(self.row, rows, &mut block.data)?;
        block.rows = rows;
        self.row += rows;
        Ok(true)
    }

    fn rewind(&mut self) -> Result<bool> {
        if let Kept::File(file, folder) = &mut self.kept {
            file.seek(SeekFrom::Start(0)).map_err(|e| Error::io(folder.display().to_string(), e))?;
        }
        self.row = 0;
        Ok(true)
    }
}
