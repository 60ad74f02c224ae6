//! Adaptation matrices compared: how near each brings the patches under a light to the patches under D65.

use clap::ValueEnum;
use luxpipe::color::{Cat, Mat3, Xy};

use super::{Chart, differences, head, row, statistics};

pub const LIGHTS: [&str; 8] = ["A", "B", "C", "D50", "FL2", "FL11", "LED-B3", "LED-RGB1"];

/// The rows: none, XYZ scaling, and the six sensor matrices.
pub fn names() -> Vec<String> {
    let cats = Cat::value_variants().iter().filter_map(|c| c.to_possible_value());
    ["none", "XYZ scaling"].map(String::from).into_iter().chain(cats.map(|v| v.get_name().to_string())).collect()
}

fn sensors(name: &str) -> Mat3 {
    Cat::from_str(name, true).map_or(Mat3::IDENTITY, Cat::matrix)
}

/// CIEDE2000 of the 24 patches under a light, adapted to the white of the D65 spectrum, against the patches under D65.
pub fn errors(name: &str, light: &str, chart: &Chart) -> Vec<f64> {
    let (seen, d65) = (chart.light(light), chart.light("D65"));
    let m = sensors(name);
    let (from, to) = (m.apply(seen.white), m.apply(d65.white));
    let gain = Mat3::diagonal(if name == "none" { [1.0; 3] } else { [0, 1, 2].map(|i| to[i] / from[i]) });
    let adapt = m.inverse().expect("regular").times(&gain).times(&m);
    let adapted: Vec<[f64; 3]> = seen.patches.iter().map(|v| adapt.apply(*v)).collect();
    differences(&d65.patches, &adapted, Xy::D65.xyz())
}

pub fn page(chart: &Chart) -> String {
    let mut text = String::from(
        "## Adaptation to D65\n\nCIEDE2000, mean / largest of 24 patches (Ohta), to the patches under D65. It measures the constancy of these surfaces, not what observers see.\n\n",
    );
    text += &head("sensors|A|B|FL2|FL11|D50|all eight");
    for name in names() {
        let shown = |v: Vec<f64>| {
            let [mean, _, max] = statistics(v);
            format!("{mean:.2} / {max:.2}")
        };
        let some = ["A", "B", "FL2", "FL11", "D50"].map(|l| shown(errors(&name, l, chart)));
        let all = shown(LIGHTS.iter().flat_map(|l| errors(&name, l, chart)).collect());
        text += &row([name].into_iter().chain(some).chain([all]));
    }
    text
}
