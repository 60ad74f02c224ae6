//! Colour corrections of Radiance's `macbethcal` as displays [Radiance, src/px/macbethcal.c].
//!
//! Such a .cal file holds, for each channel, six points of a curve (`rxa` to `rya`), and a 3 x 3 matrix. Of `macbethcal -c`,
//! made for a printer or screen, the matrix takes the wanted colour to shares of the medium's channels and the curves those
//! to the picture values that must be sent: read backwards, it is a display. Of a scanned chart, curves and then matrix take
//! picture values to colour: read forwards. All colours are Radiance's RGB, relative to the chart's white.

use super::{Display, Transfer};
use crate::color::{Mat3, Primaries, Xy};
use crate::{Error, Result, invalid};

const POINTS: usize = 6;
/// Steps of the written table.
const STEPS: usize = 64;
/// Least black that is written, as a share of white.
const DARKEST: f64 = 1e-4;

/// What a .cal file says of the medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// Points of the curves of R, G and B: picture value, light.
    curves: [[(f64, f64); POINTS]; 3],
    /// Channels' light to Radiance's RGB.
    to_standard: Mat3,
    /// Made with `-c`.
    pub printed: bool,
}

impl Correction {
    /// From the text of a .cal file.
    pub fn parse(text: &str) -> Result<Correction> {
        let code = uncommented(text)?;
        let numbers = |name: &str| -> Result<[f64; POINTS]> {
            let found = code.iter().find_map(|(n, l)| Some((n, l.strip_prefix(&format!("{name}(i) : select(i,"))?)));
            let Some((n, rest)) = found else {
                return invalid!("'{name}(i) : select(i,...)' is missing; expected a .cal file of macbethcal");
            };
            let list: Option<Vec<f64>> = rest.trim_end_matches([';', ')', ' ']).split(',').map(finite).collect();
            let list =
                list.and_then(|l| l.try_into().ok()).filter(|l: &[f64; POINTS]| l.windows(2).all(|w| w[0] < w[1]));
            list.ok_or_else(|| Error::Invalid(format!("line {n}: {name} must be {POINTS} rising numbers")))
        };
        // Only with -c does the matrix come before the curves.
        let printed = code.iter().any(|(_, l)| l.starts_with("r = ") && l.contains("*r1"));
        let row = |left: &str, right: [&str; 3]| -> Result<[f64; 3]> {
            let Some((n, rest)) = code.iter().find_map(|(n, l)| Some((n, l.strip_prefix(left)?))) else {
                return invalid!("'{left}...' is missing; expected a .cal file of macbethcal");
            };
            let terms: Vec<&str> = rest.trim_end_matches([';', ' ']).split(" + ").collect();
            let term = |i: usize| finite(terms.get(i)?.strip_suffix(right[i])?.strip_suffix('*')?);
            match (terms.len(), term(0), term(1), term(2)) {
                (3, Some(a), Some(b), Some(c)) => Ok([a, b, c]),
                _ => invalid!("line {n}: expected a*{} + b*{} + c*{}", right[0], right[1], right[2]),
            }
        };
        let (left, right) = if printed {
            (["r = ", "g = ", "b = "], ["r1", "g1", "b1"])
        } else {
            (["ro = ", "go = ", "bo = "], ["rn", "gn", "bn"])
        };
        let m = Mat3([row(left[0], right)?, row(left[1], right)?, row(left[2], right)?]);
        let singular = || Error::Invalid("the colour matrix has no inverse".into());
        let to_standard = if printed { m.inverse().ok_or_else(singular)? } else { m };
        let mut curves = [[(0.0, 0.0); POINTS]; 3];
        for (curve, c) in curves.iter_mut().zip(["r", "g", "b"]) {
            let (x, y) = (numbers(&format!("{c}xa"))?, numbers(&format!("{c}ya"))?);
            *curve = std::array::from_fn(|i| if printed { (y[i], x[i]) } else { (x[i], y[i]) });
        }
        Ok(Correction { curves, to_standard, printed })
    }

    /// The picture values that a medium must be sent to show a colour, RGB of Radiance's primaries relative to the chart's white;
    /// for a correction made with `-c`.
    pub fn sent(&self, rgb: [f64; 3]) -> [f64; 3] {
        let light = self.to_standard.inverse().unwrap_or(Mat3::IDENTITY).apply(rgb); // parsing saw that it has one
        [0, 1, 2].map(|i| interpolate(&self.curves[i].map(|(value, light)| (light, value)), light[i]).max(0.0))
    }

    /// The display that it stands for. The file knows neither luminance, nor the chart's white (to which its colours are
    /// relative), nor the `gamma` that lies between codes and picture values.
    pub fn display(&self, name: &str, lmax_cd_m2: f64, white: Xy, gamma: f64, bits: u8) -> Result<Display> {
        let radiance = Primaries::RADIANCE.to_xyz().unwrap_or(Mat3::IDENTITY); // these primaries span an area
        let from_xyz = radiance.inverse().unwrap_or(Mat3::IDENTITY);
        // macbethcal divided what was read by the RGB of the white.
        let colours = radiance.times(&Mat3::diagonal(from_xyz.apply(white.xyz()))).times(&self.to_standard);
        let light = |value: f64| [0, 1, 2].map(|i| interpolate(&self.curves[i], value));
        let (black, full) = (light(0.0), light(1.0));
        let span = [0, 1, 2].map(|i| full[i] - black[i].max(0.0));
        let columns = colours.times(&Mat3::diagonal(span)).0;
        let xy = |xyz: [f64; 3], what: &str| {
            let p = Xy::of(xyz).filter(|_| xyz[1] > 0.0);
            p.ok_or_else(|| Error::Invalid(format!("{what} comes out with no light: X, Y, Z {xyz:.4?}")))
        };
        let column = |j: usize| [columns[0][j], columns[1][j], columns[2][j]];
        let rgb = [xy(column(0), "red")?, xy(column(1), "green")?, xy(column(2), "blue")?];
        let whole = [0, 1, 2].map(|i| columns[i].iter().sum());
        let primaries = Primaries { rgb, white: xy(whole, "white")? };
        if Primaries::from_numbers(&primaries.numbers()).is_none() {
            return invalid!("the colours that come out span no area: {primaries}");
        }
        let dark = colours.apply(black.map(|b| b.max(0.0)))[1] / colours.apply(full)[1];
        let black_cd_m2 = lmax_cd_m2 * dark.max(DARKEST);
        // One curve for all channels: their mean by share of luminance.
        let y = columns[1].map(|c| c / whole[1]);
        let share = |value: f64| -> f64 {
            let l = light(value);
            (0..3).map(|i| y[i] * (l[i] - black[i].max(0.0)) / span[i]).sum()
        };
        let mut table = vec![0.0];
        for i in 1..STEPS {
            let x = share((i as f64 / STEPS as f64).powf(gamma));
            let last = table[i - 1];
            table.push(x.max(last + 1e-9));
        }
        table.push(1.0);
        if table.windows(2).any(|w| w[0] >= w[1]) {
            return invalid!("the curves are full before picture value 1");
        }
        let transfer = Transfer::Table(table);
        Ok(Display { name: name.to_string(), primaries, white_cd_m2: lmax_cd_m2, black_cd_m2, transfer, bits })
    }
}

/// Lines with their numbers, what stands in braces left out.
fn uncommented(text: &str) -> Result<Vec<(usize, String)>> {
    let mut depth = 0usize;
    let mut lines = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut kept = String::new();
        for c in line.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => return invalid!("line {}: '}}' without '{{'", i + 1),
                '}' => depth -= 1,
                c if depth == 0 => kept.push(c),
                _ => {}
            }
        }
        lines.push((i + 1, kept.trim().to_string()));
    }
    Ok(lines)
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// Straight lines between points, continued beyond them as macbethcal itself does, but to no light rather than below.
fn interpolate(points: &[(f64, f64); POINTS], x: f64) -> f64 {
    let ((x0, y0), (x1, y1)) = (points[0], points[1]);
    if x < x0 && y0 * x1 < y1 * x0 {
        return y0 * x / x0;
    }
    let above = points.partition_point(|p| p.0 < x).clamp(1, POINTS - 1);
    let ((x0, y0), (x1, y1)) = (points[above - 1], points[above]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}
