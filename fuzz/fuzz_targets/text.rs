//! What people write: pipelines, scenes, displays, meshes.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxpipe::pipeline::Pipeline;
use luxpipe::scene::{load, mesh};

fuzz_target!(|bytes: &[u8]| {
    let _ = (mesh::obj::parse(bytes), mesh::ply::parse(bytes), mesh::gltf::parse_beside(bytes, Path::new("/nowhere")));
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Pipeline::parse(text);
        let _ = load::parse(text, Path::new("/nowhere"));
    }
});
