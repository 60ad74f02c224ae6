//! Scene files; what they name lies nowhere.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxpipe::scene::load;

fuzz_target!(|text: &str| {
    let _ = load::parse(text, Path::new("/nowhere"));
});
