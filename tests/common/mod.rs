//! What the tests share: reading .npy, running a scene in this process, running the real programs.
#![allow(dead_code)] // each test file uses its part

use std::path::{Path, PathBuf};

use luxpipe::parallel;
use luxpipe::render::picture::{Job, render};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;
use luxpipe::stream::{Block, Picture};

/// The folder of the package.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A scene of the repository.
pub fn scene(name: &str) -> Scene {
    load::load(&root().join("scenes").join(name)).unwrap()
}

/// XYZ from `bands` equal bins over 380 to 780 nm.
pub fn job(scene: &Scene, bands: usize, samples: u32, seed: u32) -> Job {
    Job {
        sampling: Sampling::bins(380.0, 780.0, bands).unwrap(),
        range_nm: (380.0, 780.0),
        spectrum: false,
        samples,
        seed,
        max_bounces: scene.max_bounces.unwrap_or(u32::MAX),
        rows: (0, scene.camera.height),
        progress: false,
    }
}

/// All pixels of a picture.
pub fn pixels(mut picture: Box<dyn Picture>) -> Vec<f32> {
    let (mut block, mut all) = (Block::default(), Vec::new());
    while picture.next(&mut block).unwrap() {
        all.extend_from_slice(&block.data);
    }
    all
}

/// Renders on all processors.
pub fn rendered(scene: Scene, job: &Job) -> Vec<f32> {
    parallel::set_threads(0);
    pixels(render(scene, job, b"test".to_vec()).unwrap())
}

/// A float32 array in numpy's format, version 1.
pub fn npy(path: &Path) -> Vec<f32> {
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(&bytes[..6], b"\x93NUMPY");
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let text = std::str::from_utf8(&bytes[10..10 + header]).unwrap();
    assert!(text.contains("'<f4'") && text.contains("'fortran_order': False"), "{text}");
    bytes[10 + header..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}
