//! Rays and points on standard input, as text and as raw floats. What is measured is nothing: the lines are what is tried.
#![no_main]

use std::path::Path;
use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use luxpipe::notes::Notes;
use luxpipe::parallel;
use luxpipe::render::estimate::{Effort, Estimate, NEIGHBOURS, Probe, Quality};
use luxpipe::render::rays::Lines;
use luxpipe::scene::{Scene, load};

struct Nothing;

impl Estimate for Nothing {
    fn components(&self) -> usize {
        3
    }

    fn measure(&self, _: &[Probe], _: Effort, out: &mut [f32]) -> [Quality; NEIGHBOURS] {
        out.fill(0.0);
        [Quality::default(); NEIGHBOURS]
    }

    fn report(&self, _: &Notes) {}
}

static SCENE: LazyLock<Arc<Scene>> = LazyLock::new(|| {
    Arc::new(load::parse(include_str!("../../scenes/cornell.toml"), Path::new("/nowhere")).expect("the Cornell box"))
});

fuzz_target!(|bytes: &[u8]| {
    let Some((first, mut rest)) = bytes.split_first() else { return };
    parallel::set_threads(1);
    let lines = Lines {
        scene: SCENE.clone(),
        estimate: Arc::new(Nothing),
        effort: Effort::Paths(1),
        irradiance: first & 1 == 1,
        float: first & 2 == 2,
        with_error: first & 4 == 4,
    };
    let mut out = Vec::new();
    if let Err(e) = lines.run(&mut rest, &mut out, &|v| v.iter().map(|v| f64::from(*v)).collect()) {
        assert!(!e.to_string().contains('\n'), "a message of many lines: {e}");
    }
});
