//! Phase functions, walking the list of kinds.

use std::f64::consts::PI;
use std::sync::Arc;

use luxpipe::keys;
use luxpipe::medium::phase::{self, KINDS, Phase};

/// Some of each kind.
fn some(kind: &str) -> Vec<String> {
    let keys: Vec<String> = match kind {
        "isotropic" | "rayleigh" => vec![String::new()],
        "henyey_greenstein" => [-0.95, -0.3, 0.0, 0.6, 0.9, 0.999].map(|g| format!(", g = {g}")).into(),
        "table" => ["[[0, 90], [5, 40], [40, 3], [180, 1]]", "[[0, 0], [90, 1], [180, 0]]", "[[0, 1], [180, 1]]"]
            .map(|t| format!(", angles = {t}"))
            .into(),
        new => panic!("a new kind of phase function, {new}: say here what some of it are"),
    };
    keys.into_iter().map(|k| format!("phase = {{ type = \"{kind}\"{k} }}")).collect()
}

fn read(text: &str) -> Arc<dyn Phase> {
    phase::read(&mut keys::parse(text).unwrap()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn walk(mut test: impl FnMut(&str, &dyn Phase)) {
    for (kind, _) in KINDS {
        some(kind).iter().for_each(|text| test(text, &*read(text)));
    }
}

/// Integral of f(versine) p over the sphere: fine where peaks are.
fn integral(phase: &dyn Phase, f: impl Fn(f64) -> f64) -> f64 {
    let n = 200_000;
    // Versine 2 x^4, and the same from the other end, so that both peaks are seen.
    let part = |x: f64, back: bool| {
        let v = x.powi(4);
        let v = if back { 2.0 - v } else { v };
        4.0 * x.powi(3) * f(v) * f64::from(phase.value(v as f32))
    };
    let sum: f64 = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).map(|x| part(x, false) + part(x, true)).sum();
    2.0 * PI * sum / f64::from(n)
}

/// The integral over the sphere is 1: P of Eq. (2) integrates to 4 pi.
#[test]
fn phase_functions_are_normalised() {
    walk(|text, phase| {
        let (all, cos) = (integral(phase, |_| 1.0), integral(phase, |v| 1.0 - v));
        assert!((all - 1.0).abs() < 2e-4, "{text}: {all}");
        assert!((cos - phase.mean_cosine()).abs() < 3e-4, "{text}: mean cosine {cos} for {}", phase.mean_cosine());
    });
}

/// Drawn as often as the values say: shares of twelve ranges of angle.
#[test]
fn angles_are_drawn_as_often_as_they_are_valued() {
    walk(|text, phase| {
        let n = 100_000;
        let drawn: Vec<f64> = (0..n).map(|i| phase.sample((i as f32 + 0.5) / n as f32).into()).collect();
        assert!(drawn.iter().all(|v| (0.0..=2.0).contains(v)), "{text}");
        let edges: Vec<f64> = (0..=12).map(|i| 2.0 * (f64::from(i) / 12.0).powi(4)).collect();
        for w in edges.windows(2) {
            let share = drawn.iter().filter(|v| w[0] <= **v && **v < w[1]).count() as f64 / f64::from(n);
            let want = integral(phase, |v| if w[0] <= v && v < w[1] { 1.0 } else { 0.0 });
            assert!((share - want).abs() < 1e-3, "{text}: versines {w:?}: {share} for {want}");
        }
    });
}

/// A direction that is turned has the versine that it says, and is a unit vector, also within a thousandth of a degree.
#[test]
fn directions_turn_by_their_versine() {
    use glam::Vec3A;
    walk(|text, phase| {
        for i in 0..1000 {
            let u = [(i as f32 + 0.5) / 1000.0, (i as f32 * 0.618).fract()];
            let from = Vec3A::new(0.3, -0.5, 0.8).normalize();
            let (to, versine) = phase.turned(from, u);
            assert!((to.length() - 1.0).abs() < 1e-6, "{text}");
            let got = 0.5 * (to - from).length_squared();
            assert!((got - versine).abs() < 1e-6 + 1e-3 * versine, "{text}: {got} for {versine}");
        }
    });
}
