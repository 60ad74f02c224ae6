//! Runs a tree of stages in this process, without pipes: a stage asks the one before it for rows. What several read is handed to all of
//! them, the last in the thread that asks, the others in threads of their own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::tree::{Node, Work};
use crate::filter::{self, Product};
use crate::notes::Notes;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, invalid};

/// Runs a stage on `input`, or on what it names itself, and all that follow.
pub fn run(node: Node, first: bool, input: Option<Box<dyn Picture>>, notes: &Notes) -> Result<()> {
    let mut branches = node.branches;
    let name = match (&node.work, node.recorder) {
        (work, true) => format!("save {}", work.output().map(|p| p.display().to_string()).unwrap_or_default()),
        (work, false) => work.name(),
    };
    let stage = match node.work {
        Work::Filter(stage) => *stage,
        Work::Exec(exec) => exec.stage(first, branches.is_empty()),
    };
    let (output, format) = (stage.output.clone(), stage.format);
    let (own, within) = (notes.of(&name), |e: Error| e.within(&name));
    let product = stage.start(input, &own).map_err(within)?;
    let Some(last) = branches.pop() else {
        let done = filter::finish(product, output, format, &own);
        return if node.recorder { done.map_err(within) } else { done };
    };
    match product {
        Product::Picture(picture) if branches.is_empty() => run(last, false, Some(picture), notes),
        Product::Picture(picture) => run(last, false, Some(Tee::start(picture, branches, notes)), notes),
        Product::Bytes { .. } => {
            invalid!("{name} makes no picture that could be saved or read; only the last stage may end the stream")
        }
    }
}

/// Passes a picture on and hands copies to other stages, each on a thread of its own.
struct Tee {
    input: Box<dyn Picture>,
    header: Header,
    readers: Vec<Reader>,
}

/// Somebody who reads along.
struct Reader {
    sender: Option<SyncSender<Block>>,
    work: Option<JoinHandle<Result<()>>>,
}

impl Tee {
    fn start(input: Box<dyn Picture>, branches: Vec<Node>, notes: &Notes) -> Box<dyn Picture> {
        let header = input.header().clone();
        let reader = |branch: Node| {
            let (sender, receiver) = sync_channel(2);
            let (copy, notes) = (Box::new(Copy { header: header.clone(), receiver, rows: 0 }), notes.clone());
            let work = std::thread::spawn(move || run(branch, false, Some(copy), &notes));
            Reader { sender: Some(sender), work: Some(work) }
        };
        let readers = branches.into_iter().map(reader).collect();
        Box::new(Tee { input, header, readers })
    }
}

impl Reader {
    /// Waits for the work and passes on its failure.
    fn join(&mut self) -> Result<()> {
        self.sender = None;
        match self.work.take().map(JoinHandle::join) {
            None => Ok(()),
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
        }
    }
}

impl Picture for Tee {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        if !more {
            return self.readers.iter_mut().try_for_each(Reader::join).map(|()| false);
        }
        for reader in &mut self.readers {
            if reader.sender.as_ref().is_some_and(|s| s.send(block.clone()).is_err()) {
                // It has all it wanted, or has failed.
                reader.join()?;
            }
        }
        Ok(true)
    }
}

impl Drop for Tee {
    /// A stream that broke off leaves no file; one that was read to its end is whole already.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.readers.iter_mut().for_each(|r| drop(r.join()));
        }
    }
}

/// A reader's end of a [`Tee`].
struct Copy {
    header: Header,
    receiver: Receiver<Block>,
    rows: usize,
}

impl Picture for Copy {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        if let Ok(received) = self.receiver.recv() {
            self.rows += received.rows;
            *block = received;
            return Ok(true);
        }
        let total = self.header.resolution.scanlines();
        if self.rows < total {
            return invalid!("the picture broke off at row {} of {total}", self.rows + 1);
        }
        block.rows = 0;
        block.data.clear();
        Ok(false)
    }
}

/// The folders that files lie in, as often as they do.
pub fn folders(files: &[PathBuf]) -> impl Iterator<Item = &Path> {
    files.iter().filter_map(|f| f.parent()).filter(|f| *f != Path::new(""))
}

/// Makes the folders that files lie in.
pub fn make_folders(files: &[PathBuf]) -> Result<()> {
    for folder in folders(files) {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder.display().to_string(), e))?;
    }
    Ok(())
}
