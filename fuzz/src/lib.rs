//! What the targets share: bytes as a file, read by the library as a filter reads it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::RefCell;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};

use libfuzzer_sys::Corpus;
use luxpipe::codec::{self, Reading};
use luxpipe::notes::Notes;
use luxpipe::parallel;
use luxpipe::scene::mesh::{Degenerate, Mesh};
use luxpipe::stream::Block;
use luxpipe::stream::meaning::Overrides;
use luxpipe::stream::reader::Input;
use luxpipe::stream::spool::Limits;

/// The system's, with an end: libFuzzer's own `-malloc_limit_mb` needs a sanitizer.
struct Bounded;

/// No 64 KiB of input justify more at once: a row of 2^24 pixels of a deflated PNG comes nearest.
const LARGEST: usize = 256 << 20;

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

fn check(size: usize) {
    if size > LARGEST {
        eprintln!("ERROR: {size} bytes at once");
        std::process::abort();
    }
}

// SAFETY: every call is the system allocator's own.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        check(size);
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        unsafe { System.dealloc(old, layout) }
    }
}

thread_local! {
    static FILE: RefCell<File> = RefCell::new(tempfile::tempfile().expect("a temporary file"));
}

/// Opens bytes of that format (`None`: the stream's own) and reads every row, twice where that is possible. Bytes of another
/// format are another target's.
pub fn read(format: Option<&str>, bytes: &[u8]) -> Corpus {
    let magic = &bytes[..bytes.len().min(codec::MAGIC)];
    if codec::FORMATS.iter().find(|f| (f.is)(magic)).map(|f| f.name) != format {
        return Corpus::Reject;
    }
    parallel::set_threads(1);
    let file = FILE.with_borrow_mut(|file| {
        file.set_len(0)?;
        file.seek(SeekFrom::Start(0))?;
        file.write_all(bytes)?;
        file.seek(SeekFrom::Start(0))?;
        file.try_clone()
    });
    let input = Input::of_file(file.expect("room for a temporary file"), "input").expect("a regular file");
    let (overrides, notes) = (Overrides::default(), Notes::default());
    let limits = Limits { memory: 64 << 20, folder: std::env::temp_dir() };
    let reading = Reading { overrides: &overrides, limits: &limits, notes: &notes };
    let read = codec::open(input, &reading).and_then(|mut picture| {
        let (rows, mut block) = (picture.header().resolution.scanlines(), Block::default());
        for pass in 0..2 {
            let mut seen = 0;
            while picture.next(&mut block)? {
                assert!(block.rows > 0 && block.data.len() == block.rows * picture.header().scanline_floats());
                seen += block.rows;
            }
            assert_eq!(seen, rows, "a picture of fewer rows than it says");
            if pass == 1 || !picture.rewind()? {
                break;
            }
        }
        Ok(())
    });
    let lines = read.err().map(|e| e.to_string()).into_iter().chain(notes.take());
    lines.for_each(|line| assert!(!line.is_empty() && !line.contains('\n'), "a message of many lines: {line:?}"));
    Corpus::Keep
}

/// What loading a scene does with a mesh that was read.
pub fn use_mesh(mut mesh: Mesh) {
    if mesh.check(Degenerate::Skip).is_ok() {
        mesh.turn_normals();
        mesh.smooth(30.0);
    }
}
