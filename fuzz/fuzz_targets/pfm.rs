//! Portable float maps.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { luxpipe_fuzz::read(Some("PFM"), bytes) });
