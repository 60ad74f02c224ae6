//! What people write: pipelines, scenes, displays, meshes, luminaire files.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxpipe::photometry::ies::Photometry;
use luxpipe::pipeline;
use luxpipe::scene::{load, mesh};

fuzz_target!(|bytes: &[u8]| {
    let nowhere = Path::new("/nowhere");
    let _ = (mesh::obj::parse(bytes), mesh::ply::parse(bytes), mesh::gltf::parse_beside(bytes, nowhere));
    let _ = Photometry::parse(bytes);
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = pipeline::check(text);
        let _ = load::parse(text, Path::new("/nowhere"));
    }
});
