//! Arithmetic and pictures that several claims need.

use super::*;

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x))
}

pub fn smallest(values: &[f64]) -> f64 {
    values.iter().fold(f64::INFINITY, |m, x| m.min(*x))
}

/// The largest difference of numbers in the same places.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    largest(&a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>())
}

pub fn neutral(luminance: f64) -> Xyz {
    Xy::D65.xyz().map(|x| x * luminance)
}

/// `count` luminances from the first to the last, evenly in their logarithm.
pub fn evenly([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}

pub fn picture(lines: &str, columns: usize, colours: &[Xyz]) -> Vec<u8> {
    let values: Vec<f32> = colours.iter().flatten().map(|x| *x as f32).collect();
    stream(lines, &format!("-Y {} +X {columns}", colours.len() / columns), &values)
}

pub fn triples(bytes: &[u8]) -> Vec<Xyz> {
    floats(split(bytes).2).chunks_exact(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))).collect()
}

/// What a filter without remarks makes of a picture.
pub fn through(command: &[&str], input: &[u8]) -> Vec<Xyz> {
    triples(&stdout_of(command[0], &[&command[1..], &["--quiet"]].concat(), input))
}

/// pcond's own display: cd/m2 of what it writes.
pub fn cd_m2(share: f64) -> f64 {
    1.0 + 99.0 * share
}
