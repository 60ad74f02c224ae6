//! Scenes written for Radiance, and its views.
#![no_main]

use std::io::Write;

use libfuzzer_sys::fuzz_target;
use luxpipe::notes::Notes;
use luxpipe::radiance::{self, view::View};

fuzz_target!(|bytes: &[u8]| {
    let Ok(mut file) = tempfile::NamedTempFile::new() else { return };
    if file.write_all(bytes).is_err() {
        return;
    }
    for skip_unknown in [false, true] {
        let options = radiance::Options { skip_unknown };
        let files = [file.path().to_path_buf()];
        let _ = radiance::convert(&files, None, (64, 64), "m", &options, &Notes::default());
    }
    let _ = View::default().read(&String::from_utf8_lossy(bytes));
});
