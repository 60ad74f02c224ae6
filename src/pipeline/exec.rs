//! `exec = ["pfilt", "-1", "-x", "/2"]`: another program as a stage. It reads a picture on standard input and writes one, or whatever it
//! likes where nothing follows, on standard output; no shell comes in between. It is given floats, or what `format` says: `rgbe` for
//! most of Radiance's. Programs next to each other are joined by the system's own pipe, as a shell would.

use std::fs::File;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use crate::codec::{self, Reading};
use crate::error::printable;
use crate::filter::{Product, Run, Stage};
use crate::options::quote;
use crate::stream::output::Output;
use crate::stream::reader::{Input, enlarge_pipe};
use crate::stream::writer::{self, Format};
use crate::stream::{Block, Header, Picture, meaning};
use crate::{Error, Result, files, invalid};

/// Programs joined by pipes.
#[derive(Clone, Debug)]
pub struct Exec {
    /// Each with its arguments; at least one, and each has a name.
    pub commands: Vec<Vec<String>>,
    /// What the first is given, if it was said.
    pub format: Option<Format>,
    /// File that the first reads as it is.
    pub input: Option<PathBuf>,
    /// File that the last writes.
    pub output: Option<PathBuf>,
}

impl Exec {
    /// What messages call it.
    pub fn name(&self) -> String {
        let name = self.commands.last().and_then(|c| c.first()).map_or("", String::as_str);
        printable(Path::new(name).file_name().unwrap_or(name.as_ref()).as_encoded_bytes())
    }

    /// Does it stand at the head of a pipeline, with a file of its own or none?
    pub fn stage(self, first: bool, last: bool) -> Stage {
        let (name, input, output) = (self.name(), self.input.clone(), self.output.clone());
        let start = Box::new(move |picture, run: &Run| self.start(picture, last, run));
        Stage::external(name, !first, input, output, start)
    }

    /// As a shell would run it.
    pub fn shell(&self, input: Option<&Path>, output: Option<&Path>) -> String {
        let words = |c: &Vec<String>| c.iter().map(|w| quote(w)).collect::<Vec<_>>().join(" ");
        let mut commands: Vec<String> = self.commands.iter().map(words).collect();
        if let (Some(path), Some(first)) = (input, commands.first_mut()) {
            *first += &format!(" < {}", quote(&path.display().to_string()));
        }
        let line = commands.join(" | ");
        output.map_or(line.clone(), |path| format!("{line} > {}", quote(&path.display().to_string())))
    }

    fn start(self, picture: Option<Box<dyn Picture>>, last: bool, run: &Run) -> Result<Product> {
        let name = self.name();
        let (running, stdout) = self.spawn(picture, run)?;
        if last {
            let write = Box::new(move |out: &mut Output| match copy(stdout, &name, out) {
                Ok(()) => running.wait(),
                Err(e) => Err(running.blame(e)),
            });
            return Ok(Product::Bytes { binary: true, write });
        }
        let overrides = meaning::Overrides::default();
        let reading = Reading { overrides: &overrides, limits: &run.options.limits(), notes: &run.notes };
        match Input::of_file(stdout, &format!("output of {name}")).and_then(|input| codec::open(input, &reading)) {
            Ok(picture) => Ok(Product::Picture(Box::new(Made { picture, running: Some(running) }))),
            Err(e) => Err(running.blame(e)),
        }
    }

    /// Starts the programs; the first is fed on a thread of its own. What the last writes.
    fn spawn(&self, picture: Option<Box<dyn Picture>>, run: &Run) -> Result<(Running, File)> {
        let mut running = Running { children: Vec::new(), feeder: None };
        let mut stdin = match (&picture, &self.input) {
            (Some(_), _) => Stdio::piped(),
            (None, Some(path)) => files::open(path).map_err(|e| Error::io(path.display().to_string(), e))?.into(),
            (None, None) => Stdio::inherit(),
        };
        let mut output = None;
        for command in &self.commands {
            let name = printable(command[0].as_bytes());
            let mut child = Command::new(&command[0]);
            let child = child.args(&command[1..]).stdin(stdin).stdout(Stdio::piped()).spawn();
            let mut child = child.map_err(|e| match e.kind() {
                std::io::ErrorKind::NotFound => {
                    Error::Invalid(format!("no program '{name}' is found; exec names one on PATH, or its file"))
                }
                _ => Error::io(name.clone(), e),
            })?;
            let stdout = child.stdout.take().map(OwnedFd::from).map(File::from);
            running.children.push((name.clone(), child));
            let Some(stdout) = stdout else { return invalid!("{name}: has no standard output") };
            enlarge_pipe(&stdout);
            // The next one's; of the last one, what is read here.
            stdin = Stdio::from(stdout.try_clone().map_err(|e| Error::io(name, e))?);
            output = Some(stdout);
        }
        drop(stdin);
        let stdin = running.children.first_mut().and_then(|c| c.1.stdin.take());
        if let (Some(picture), Some(stdin)) = (picture, stdin) {
            let (name, notes, format) =
                (self.commands[0][0].clone(), run.notes.clone(), self.format.unwrap_or_default());
            let feed = move || {
                let mut out = Output::of_pipe(File::from(OwnedFd::from(stdin)), &name);
                writer::write(picture, format, &mut out, &notes)
            };
            running.feeder = Some(std::thread::spawn(feed));
        }
        match output {
            Some(output) => Ok((running, output)),
            None => invalid!("exec needs a program"),
        }
    }
}

/// Passes bytes on.
fn copy(mut from: File, name: &str, out: &mut Output) -> Result<()> {
    use std::io::{Read, Write};
    let mut buffer = vec![0; 256 << 10];
    loop {
        match from.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(n) => out.write_all(&buffer[..n]).map_err(|e| out.error(e))?,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(Error::io(format!("output of {name}"), e)),
        }
    }
}

/// Programs at work, and who feeds them. They do not outlive it.
struct Running {
    children: Vec<(String, Child)>,
    feeder: Option<JoinHandle<Result<()>>>,
}

impl Running {
    /// Waits for all. The first failure counts: that of the picture they are fed, then of the first program.
    fn wait(mut self) -> Result<()> {
        let mut failed = None;
        for (name, child) in &mut self.children {
            let status = child.wait().map_err(|e| Error::io(name.clone(), e))?;
            if !status.success() {
                failed.get_or_insert(Error::Invalid(format!("{name}: ended with {status}")));
            }
        }
        self.fed()?;
        failed.map_or(Ok(()), Err)
    }

    /// What feeding them came to; that they did not read to the end is theirs to judge.
    fn fed(&mut self) -> Result<()> {
        match self.feeder.take().map(JoinHandle::join) {
            Some(Ok(Err(e))) if !e.is_closed_pipe() => Err(e),
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            _ => Ok(()),
        }
    }

    /// The reason behind a failure to read what they wrote: their own, if they had one.
    fn blame(mut self, e: Error) -> Error {
        // One that is done tells by itself; one that still writes what nobody can read is stopped.
        for (_, child) in &mut self.children {
            if let Ok(None) = child.try_wait() {
                std::thread::sleep(std::time::Duration::from_millis(20));
                if let Ok(None) = child.try_wait() {
                    let _ = child.kill();
                }
            }
        }
        if let Err(of_feeder) = self.fed() {
            return of_feeder;
        }
        for (name, child) in &mut self.children {
            if let Ok(status) = child.wait()
                && status.code().is_some_and(|c| c != 0)
            {
                return Error::Invalid(format!("{name}: ended with {status}"));
            }
        }
        e
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        for (_, child) in &mut self.children {
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = self.feeder.take().map(JoinHandle::join);
    }
}

/// A picture that programs make; its end is theirs.
struct Made {
    picture: Box<dyn Picture>,
    running: Option<Running>,
}

impl Picture for Made {
    fn header(&self) -> &Header {
        self.picture.header()
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        match self.picture.next(block) {
            Ok(true) => Ok(true),
            Ok(false) => self.running.take().map_or(Ok(()), Running::wait).map(|()| false),
            Err(e) => match self.running.take() {
                Some(running) => Err(running.blame(e)),
                None => Err(e),
            },
        }
    }
}
