//! How far what is shown lies from what was wanted.

use luxpipe::color::difference::{delta_e_2000, lab, oklab};

use super::sets::white;

/// CIELAB chroma under which a colour has no hue to speak of.
const HUELESS: f64 = 1.0;
/// Delta E 2000 from which a colour counts as moved.
const MOVED: f64 = 0.01;

/// Statistics over a set; pairs are mean and largest.
pub struct Errors {
    pub hue_lab: [f64; 2],
    pub hue_oklab: [f64; 2],
    pub chroma: f64,
    pub luminance: f64,
    pub delta_e: [f64; 2],
    pub moved: f64,
}

/// Hue in degrees and chroma of a Lab colour.
pub fn polar(lab: [f64; 3]) -> (f64, f64) {
    (lab[2].atan2(lab[1]).to_degrees(), lab[1].hypot(lab[2]))
}

/// Degrees from one hue to another, -180 to 180.
pub fn turn(from: f64, to: f64) -> f64 {
    (to - from + 180.0).rem_euclid(360.0) - 180.0
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn mean_and_most(values: &[f64]) -> [f64; 2] {
    [mean(values), values.iter().fold(0.0, |m: f64, x| m.max(*x))]
}

/// CIELAB and Oklab under D65.
fn labs(xyz: [f64; 3]) -> [[f64; 3]; 2] {
    [lab(xyz, white()), oklab(xyz)]
}

impl Errors {
    pub fn of(wanted: &[[f64; 3]], shown: &[[f64; 3]]) -> Errors {
        let pairs = || wanted.iter().zip(shown);
        let coloured: Vec<[[[f64; 3]; 2]; 2]> =
            pairs().map(|(a, b)| [labs(*a), labs(*b)]).filter(|p| p.iter().all(|c| polar(c[0]).1 >= HUELESS)).collect();
        let hue = |space: usize| -> Vec<f64> {
            coloured.iter().map(|[a, b]| turn(polar(a[space]).0, polar(b[space]).0).abs()).collect()
        };
        let chroma = |xyz: &[f64; 3]| polar(lab(*xyz, white())).1;
        let ratios: Vec<f64> =
            pairs().filter(|(a, _)| chroma(a) >= HUELESS).map(|(a, b)| chroma(b) / chroma(a)).collect();
        let luminance: Vec<f64> =
            pairs().filter(|(a, _)| a[1] > 0.0).map(|(a, b)| 100.0 * (b[1] / a[1] - 1.0).abs()).collect();
        let delta_e: Vec<f64> = pairs().map(|(a, b)| delta_e_2000(*a, *b, white())).collect();
        let moved: Vec<f64> = delta_e.iter().map(|e| f64::from(u8::from(*e > MOVED)) * 100.0).collect();
        Errors {
            hue_lab: mean_and_most(&hue(0)),
            hue_oklab: mean_and_most(&hue(1)),
            chroma: mean(&ratios),
            luminance: mean(&luminance),
            delta_e: mean_and_most(&delta_e),
            moved: mean(&moved),
        }
    }

    /// Cells of a row.
    pub fn cells(&self) -> [String; 9] {
        let one = |x: f64| format!("{x:.1}");
        let two = |x: f64| format!("{x:.2}");
        let (a, b, e) = (self.hue_lab, self.hue_oklab, self.delta_e);
        [
            one(a[0]),
            one(a[1]),
            one(b[0]),
            one(b[1]),
            two(self.chroma),
            one(self.luminance),
            two(e[0]),
            one(e[1]),
            one(self.moved),
        ]
    }
}
