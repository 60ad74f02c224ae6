//! Meshes, PLY.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxpipe::scene::mesh;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = mesh::ply::parse(bytes) {
        luxpipe_fuzz::use_mesh(mesh);
    }
});
