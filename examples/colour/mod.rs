//! The colour figures of [Ward 2001] and what stands behind them, computed from luxpipe's own tables and matrices: shared by
//! `make paper-colour` and tests/paper.rs. Wavelengths are 380 to 780 nm throughout, whites have Y = 1.
#![allow(dead_code)] // the page and the tests each use their part

pub mod approaches;
pub mod blueflower;
pub mod cats;
pub mod sampling;

use luxpipe::color::difference::delta_e_2000;
use luxpipe::color::{Cat, Mat3, Xy, adapt};
use luxpipe::spectral::{Observer, Spectrum, builtin};

/// Every nm.
pub fn grid() -> impl Iterator<Item = f64> {
    (380..=780).map(f64::from)
}

/// Sprague's fifth-order interpolation of an evenly spaced table [CIE15], at wavelengths inside it.
pub fn sprague(table: &Spectrum, at_nm: impl Iterator<Item = f64>) -> Vec<f64> {
    let Spectrum::Table(p) = table else { panic!("a constant needs no interpolation") };
    let y: Vec<f64> = p.iter().map(|q| q.1).collect();
    let n = y.len();
    let outer = |i: [f64; 6], v: [usize; 6]| (0..6).map(|k| i[k] * y[v[k]]).sum::<f64>() / 209.0;
    let far = [884.0, -1960.0, 3033.0, -2648.0, 1080.0, -180.0];
    let near = [508.0, -540.0, 488.0, -367.0, 144.0, -24.0];
    let (first, last) = ([0, 1, 2, 3, 4, 5], [n - 1, n - 2, n - 3, n - 4, n - 5, n - 6]);
    let r = [&[outer(far, first), outer(near, first)], &y[..], &[outer(near, last), outer(far, last)]].concat();
    let step = p[1].0 - p[0].0;
    let value = |nm: f64| {
        let at = (nm - p[0].0) / step;
        let i = (at as usize).min(n - 2);
        let t = at - i as f64;
        SPRAGUE.iter().rev().fold(0.0, |sum, row| sum * t + (0..6).map(|k| row[k] * r[i + k]).sum::<f64>() / 24.0)
    };
    at_nm.map(value).collect()
}

/// Coefficients of t^0 .. t^5, times 24, for the points i-2 .. i+3.
const SPRAGUE: [[f64; 6]; 6] = [
    [0.0, 0.0, 24.0, 0.0, 0.0, 0.0],
    [2.0, -16.0, 0.0, 16.0, -2.0, 0.0],
    [-1.0, 16.0, -30.0, 16.0, -1.0, 0.0],
    [-9.0, 39.0, -70.0, 66.0, -33.0, 7.0],
    [13.0, -64.0, 126.0, -124.0, 61.0, -12.0],
    [-5.0, 25.0, -50.0, 50.0, -25.0, 5.0],
];

/// A built-in table on the grid: linear for D illuminants and lamps with lines (FL), Sprague for the other 5 nm tables.
fn every_nm(name: &str) -> Vec<f64> {
    let table = builtin::spectrum(name).expect("a built-in table");
    let smooth = ["cc_", "illuminant_B", "illuminant_C", "illuminant_LED"].iter().any(|p| name.starts_with(p));
    if smooth { sprague(&table, grid()) } else { grid().map(|nm| table.at(nm)).collect() }
}

/// Values on the grid as a table.
pub fn spectrum(values: &[f64]) -> Spectrum {
    Spectrum::from_points(grid().zip(values.iter().copied()).collect()).expect("finite values")
}

/// The 24 patches of one chart and the observer, on the grid.
pub struct Chart {
    pub cmf: [Vec<f64>; 3],
    pub patches: Vec<Vec<f64>>,
}

/// An illuminant whose white has Y = 1, and what the chart looks like under it: 1 nm sums, the truth of all comparisons.
pub struct Light {
    pub power: Vec<f64>,
    pub white: [f64; 3],
    pub patches: Vec<[f64; 3]>,
}

impl Chart {
    /// The chart measured by Ohta.
    pub fn ohta() -> Chart {
        let observer = Observer::cie1931().expect("built in");
        Chart {
            cmf: observer.cmf.each_ref().map(|c| grid().map(|nm| c.at(nm)).collect()),
            patches: builtin::names().filter(|n| n.starts_with("cc_ohta_")).map(every_nm).collect(),
        }
    }

    /// Eq. (4) with weights already multiplied into the light.
    fn sum(&self, light: &[f64], reflectance: impl Fn(usize) -> f64) -> [f64; 3] {
        self.cmf.each_ref().map(|c| (0..c.len()).map(|i| c[i] * light[i] * reflectance(i)).sum())
    }

    pub fn light(&self, name: &str) -> Light {
        let power = every_nm(&format!("illuminant_{name}"));
        let y = self.sum(&power, |_| 1.0)[1];
        let power: Vec<f64> = power.iter().map(|p| p / y).collect();
        let white = self.sum(&power, |_| 1.0);
        let patches = self.patches.iter().map(|r| self.sum(&power, |i| r[i])).collect();
        Light { power, white, patches }
    }
}

/// Eq. (6) from a white to D65.
pub fn to_d65(cat: Cat, white: [f64; 3]) -> Mat3 {
    let from = Xy::of(white).expect("a white");
    adapt::von_kries(cat, from, Xy::D65, 1.0).expect("a sensible white")
}

/// CIEDE2000 of pairs under one white.
pub fn differences(a: &[[f64; 3]], b: &[[f64; 3]], white: [f64; 3]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| delta_e_2000(*a, *b, white)).collect()
}

/// Mean, 95th percentile (linear between ranks) and largest.
pub fn statistics(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let rank = 0.95 * (n - 1) as f64;
    let (low, high) = (values[rank as usize], values[(rank as usize + 1).min(n - 1)]);
    [values.iter().sum::<f64>() / n as f64, low + (high - low) * rank.fract(), values[n - 1]]
}

/// A line of a Markdown table.
pub fn row<S: AsRef<str>>(cells: impl IntoIterator<Item = S>) -> String {
    cells.into_iter().fold("|".to_string(), |line, cell| line + " " + cell.as_ref() + " |") + "\n"
}

/// The head of a Markdown table, columns separated by `|`.
pub fn head(columns: &str) -> String {
    let names: Vec<&str> = columns.split('|').collect();
    row(&names) + &"|---".repeat(names.len()) + "|\n"
}

/// All of docs/paper-colour.md.
pub fn page() -> String {
    let chart = Chart::ohta();
    [
        "# The paper's colour numbers\n\nGenerated: `make docs/paper-colour.md`; `make paper-colour` prints it. What each number is held to is in tests/paper.rs.\n".to_string(),
        blueflower::page(),
        sampling::page(&chart),
        cats::page(&chart),
        approaches::page(&chart),
    ]
    .join("\n")
}
