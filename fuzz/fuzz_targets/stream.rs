//! The stream's own forms: floats, doubles, RGBE, XYZE, hyperspectral Radiance.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { luxpipe_fuzz::read(None, bytes) });
