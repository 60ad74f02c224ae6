//! Pipelines, up to where their stages would run.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxpipe::pipeline;

fuzz_target!(|text: &str| {
    let _ = pipeline::check(text);
});
