//! Meshes, glTF and GLB; what they name lies nowhere.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxpipe::scene::mesh;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = mesh::gltf::parse_beside(bytes, Path::new("/nowhere")) {
        luxpipe_fuzz::use_mesh(mesh);
    }
});
