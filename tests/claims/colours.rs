//! Correct colour rendering, the conventional calculation, relative colours.

use super::*;

pub fn eq7(light: &str, row: usize, column: usize) -> f64 {
    blueflower::eq7(light).0[row][column]
}

/// How far the matrix that `vonkries` prints is from ours.
pub fn eq7_of_the_program() -> f64 {
    let text = stdout_of("vonkries", &["--from", "0.4475,0.4075", "--to", "D65", "--print", "--rgb"], b"");
    let numbers: Vec<f64> = String::from_utf8(text).unwrap().split_whitespace().map(|n| n.parse().unwrap()).collect();
    apart(&numbers, blueflower::eq7("A").0.as_flattened())
}

/// A difference that the paper states, of one chart: tests/paper.rs holds them to numpy.
pub fn delta_e(key: &str, set: usize) -> f64 {
    blueflower::claims().into_iter().find(|c| c.key == key).unwrap().ours[set]
}

/// Correlated colour temperature.
pub fn kelvin(white: Xy) -> f64 {
    Locus::new().unwrap().nearest(white).kelvin
}

// Relative colours.

/// CIEDE2000 over 24 patches, nine lights and a number of bounces: mean, 95 % or largest.
pub fn approach(name: &str, bounces: usize, which: usize) -> f64 {
    type Results = Vec<(String, [[f64; 3]; 3])>;
    static RESULTS: LazyLock<Results> = LazyLock::new(|| approaches::results(&Chart::ohta()));
    RESULTS.iter().find(|r| r.0 == name).unwrap_or_else(|| panic!("no approach '{name}'")).1[bounces - 1][which]
}

/// Mean CIEDE2000 that `specmat --format errors` prints for a light.
pub fn specmat(list: &str, options: &[&str], light: &str, bounces: u32) -> f64 {
    let args = [&["--quiet", "--format", "errors", list][..], options].concat();
    let text = String::from_utf8(stdout_of("specmat", &args, b"")).unwrap();
    let mut lines = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>());
    let row = lines.find(|w| w.len() == 6 && w[0] == light && w[1] == bounces.to_string()).unwrap();
    row[3].parse().unwrap()
}

/// Root mean square of CIEDE2000 after five bounces in a rendered room, as `make paper-relative` measured it.
pub fn five_bounces(kinds: &str, model: &str) -> f64 {
    let text = std::fs::read_to_string(root().join(format!("docs/paper-relative-{kinds}.csv"))).unwrap();
    let line = text.lines().find(|l| l.starts_with(&format!("5,{model},"))).unwrap();
    line.split(',').nth(3).unwrap().parse().unwrap()
}
