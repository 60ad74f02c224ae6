//! Photographs: JPEG with EXIF, PNG and TIFF files as codes.
#![no_main]

use std::io::Write;

use libfuzzer_sys::fuzz_target;
use luxpipe::capture::read;

fuzz_target!(|bytes: &[u8]| {
    let Ok(mut file) = tempfile::NamedTempFile::new() else { return };
    if file.write_all(bytes).is_ok() {
        let _ = read::read(file.path());
    }
});
