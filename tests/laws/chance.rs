//! Random numbers in order of their use, so that a case that fails can be made smaller.

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// Numbers from 0 to 1, taken one after the other; after the last it begins again.
pub struct Chance {
    numbers: Vec<f64>,
    next: usize,
}

impl Chance {
    /// The next number.
    pub fn share(&mut self) -> f64 {
        self.next += 1;
        self.numbers[(self.next - 1) % self.numbers.len()]
    }

    /// Between two bounds, evenly.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Between two bounds above 0, evenly on a logarithmic scale.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A whole number from `low` to `high`.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + (self.share() * (high - low + 1) as f64) as usize
    }

    /// One of several.
    pub fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.whole(0, all.len() - 1)]
    }

    /// A direction, evenly over the sphere.
    pub fn direction(&mut self) -> glam::DVec3 {
        let z = self.between(-1.0, 1.0);
        let (s, c) = self.between(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        glam::DVec3::new(r * c, r * s, z)
    }

    /// A spectrum within bounds, as a scene has it.
    pub fn spectrum(&mut self, low: f64, high: f64) -> String {
        let values = [380.0, 500.0, 600.0, 780.0].map(|nm| format!("[{nm}, {}]", self.between(low, high)));
        format!("[{}]", values.join(", "))
    }
}

/// Tries a law on `cases` random cases, always the same.
pub fn holds(cases: u32, law: impl Fn(&mut Chance)) {
    let config = Config { cases, failure_persistence: None, max_shrink_iters: 256, ..Config::default() };
    let mut runner =
        TestRunner::new_with_rng(config, proptest::test_runner::TestRng::deterministic_rng(Default::default()));
    let numbers = prop::collection::vec(0f64..1.0, 509);
    let tried = runner.run(&numbers, |numbers| {
        law(&mut Chance { numbers, next: 0 });
        Ok(())
    });
    tried.unwrap_or_else(|e| panic!("{e}"));
}
