//! PNG, its profiles and texts.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { luxpipe_fuzz::read(Some("PNG"), bytes) });
