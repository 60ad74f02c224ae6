//! Plans of specplan, for a scene that they may or may not have been made for.
#![no_main]

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use luxpipe::plan::file;
use luxpipe::scene::{Scene, load};

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    load::parse(include_str!("../../scenes/cornell.toml"), Path::new("/nowhere")).expect("the Cornell box")
});
/// Its number, so that what stands below that line is reached.
static NUMBER: LazyLock<String> = LazyLock::new(|| format!("fingerprint = \"{:016x}\"", file::fingerprint(&SCENE)));

thread_local! {
    static FILE: std::cell::RefCell<tempfile::NamedTempFile> =
        std::cell::RefCell::new(tempfile::NamedTempFile::new().expect("a temporary file"));
}

fuzz_target!(|text: &str| {
    let of_this = |line: &str| if line.starts_with("fingerprint") { NUMBER.clone() } else { line.to_string() };
    let text: Vec<String> = text.split('\n').map(of_this).collect();
    FILE.with_borrow_mut(|file| {
        let written = file.as_file().set_len(0).and_then(|()| file.seek(SeekFrom::Start(0)));
        written.and_then(|_| file.write_all(text.join("\n").as_bytes())).expect("room for a temporary file");
        match file::read(file.path(), &SCENE) {
            Ok(orders) => drop(orders.wavelengths.few(&SCENE)),
            Err(e) => assert!(!e.to_string().contains('\n'), "a message of many lines: {e}"),
        }
    });
});
