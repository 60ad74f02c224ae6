//! A display's description from readings of patches: black, primaries and white by least squares on additive light, and the
//! simplest curve that explains the readings. `docs/displays.md` is the manual.

use super::readings::{Reading, Readings};
use super::{Display, Transfer};
use crate::color::{Mat3, Primaries, Xy, difference};
use crate::{Error, Result, invalid};

/// A simpler curve is taken while its mean Delta E 2000 is within this of the best one's.
pub const MEAN_TOLERANCE: f64 = 0.1;
/// And its largest within this.
pub const MAX_TOLERANCE: f64 = 1.0;
/// Readings of one code that differ by more Delta E 2000 are contradictory.
const REPEATABLE: f64 = 5.0;
/// Light may fall by this share of white while codes rise before that is contradictory: a meter's noise.
const FALL: f64 = 0.02;
/// Contrast written for a black that was read as no light, since a description needs one above 0.
const DARKEST: f64 = 1e-6;
/// Noise may take X, Y or Z of a primary below 0 by this share of their sum: laser red has no Z.
const IMPOSSIBLE: f64 = 0.02;
/// Least number of steps of a written table, and the most.
const STEPS: (usize, usize) = (32, 255);

/// Mean and largest Delta E 2000 of predicted against read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean over all readings.
    pub mean: f64,
    /// The largest.
    pub max: f64,
    /// Line of the largest.
    pub line: usize,
}

/// A fitted display and how well it explains what was read.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The display; its ambient light is within black.
    pub display: Display,
    /// Of this display.
    pub errors: Errors,
    /// Every curve that gave a display, the simplest first, with its errors.
    pub tried: Vec<(Transfer, Errors)>,
    /// (white - black) / (R + G + B - 3 black) - 1 in luminance, as read.
    pub additivity: f64,
    /// Largest move in x or y of each primary from full to a lower level; `None` without readings of such.
    pub drift: [Option<f64>; 3],
    /// There were readings between black and full: the curve is measured.
    pub curve_is_measured: bool,
    /// Black was read as no light at all.
    pub black_is_zero: bool,
}

/// Delta E 2000 of what `display` predicts against each reading, under the display's white.
pub fn compare(display: &Display, readings: &[Reading]) -> Vec<f64> {
    let white = display.light([1.0; 3]);
    readings.iter().map(|r| difference::delta_e_2000(display.light(r.code), r.xyz, white)).collect()
}

/// Their mean and largest.
pub fn errors(display: &Display, readings: &[Reading]) -> Errors {
    let all = compare(display, readings);
    let (mut max, mut line) = (0.0, 0);
    for (d, r) in all.iter().zip(readings) {
        if *d >= max {
            (max, line) = (*d, r.line);
        }
    }
    Errors { mean: all.iter().sum::<f64>() / all.len().max(1) as f64, max, line }
}

/// Light above black, columns R, G, B, at code 1.
struct Additive {
    black: [f64; 3],
    columns: Mat3,
}

/// Fits a display to readings.
pub fn fit(name: &str, readings: &Readings, bits: u8) -> Result<Fit> {
    let all = &readings.list;
    let corner = |code: [f64; 3]| readings.mean(code);
    let need = |code: [f64; 3], what: &str| {
        let code_text = code.map(|c| (c * readings.full).to_string()).join(",");
        corner(code).ok_or_else(|| Error::Invalid(format!("{what}, code {code_text}, was not read; a fit needs it")))
    };
    let black = need([0.0; 3], "black")?;
    let white = need([1.0; 3], "white")?;
    let primaries = [need([1.0, 0.0, 0.0], "red")?, need([0.0, 1.0, 0.0], "green")?, need([0.0, 0.0, 1.0], "blue")?];
    check(all, black, white, primaries)?;
    let over = |xyz: [f64; 3]| [0, 1, 2].map(|i| xyz[i] - black[i]);
    let sum: f64 = primaries.iter().map(|p| over(*p)[1]).sum();

    let mut tried = vec![(Transfer::Srgb, Additive::fit(all, black, &Transfer::Srgb)?)];
    let curve_is_measured = all.iter().any(|r| r.code.iter().any(|c| *c > 0.0 && *c < 1.0));
    if curve_is_measured {
        let gamma = Transfer::Gamma(best_gamma(all, black)?);
        tried.push((gamma.clone(), Additive::fit(all, black, &gamma)?));
        if let Some(table) = table(all, black, Mat3([0, 1, 2].map(|i| primaries.map(|p| over(p)[i]))))? {
            tried.push((table.clone(), Additive::fit(all, black, &table)?));
        }
    }
    // A curve that is far from the display's gives impossible primaries; it is out of the race.
    let (mut displays, mut fault) = (Vec::new(), None);
    for (transfer, additive) in tried {
        match additive.display(name, transfer, bits) {
            Ok(display) => displays.push((errors(&display, all), display)),
            Err(e) => fault = Some(e),
        }
    }
    let best = displays.iter().fold((f64::INFINITY, f64::INFINITY), |b, (e, _)| (b.0.min(e.mean), b.1.min(e.max)));
    let near = |e: &Errors| e.mean <= best.0 + MEAN_TOLERANCE && e.max <= best.1 + MAX_TOLERANCE;
    let least = |a: &&(Errors, Display), b: &&(Errors, Display)| a.0.mean.total_cmp(&b.0.mean);
    let chosen = displays.iter().find(|d| near(&d.0)).or_else(|| displays.iter().min_by(least));
    let Some((errors, display)) = chosen.cloned() else {
        return Err(fault.unwrap_or_else(|| Error::Invalid("no curve fits".into())));
    };
    Ok(Fit {
        display,
        errors,
        tried: displays.into_iter().map(|(e, d)| (d.transfer, e)).collect(),
        additivity: over(white)[1] / sum - 1.0,
        drift: [0, 1, 2].map(|c| drift(all, black, c)),
        curve_is_measured,
        black_is_zero: black[1] <= 0.0,
    })
}

/// Refuses readings that no additive display gives.
fn check(all: &[Reading], black: [f64; 3], white: [f64; 3], primaries: [[f64; 3]; 3]) -> Result<()> {
    for (name, p) in ["red", "green", "blue"].iter().zip(primaries).chain([(&"white", white)]) {
        if p[1] <= black[1] {
            return invalid!("{name} has {} cd/m2, no more than black's {}; are they exchanged?", p[1], black[1]);
        }
        if p[1] > white[1] {
            return invalid!("{name} has {} cd/m2, more than white's {}; are they exchanged?", p[1], white[1]);
        }
    }
    for (i, r) in all.iter().enumerate() {
        if r.xyz[1] < 0.9 * black[1] - 1e-4 * white[1] {
            return invalid!("line {}: {} cd/m2 is below black's {}; no code is darker", r.line, r.xyz[1], black[1]);
        }
        if let Some(other) = all[..i].iter().find(|o| o.code == r.code)
            && difference::delta_e_2000(other.xyz, r.xyz, white) > REPEATABLE
        {
            let (a, b) = (other.xyz[1], r.xyz[1]);
            return invalid!("line {}: {b} cd/m2 contradicts line {}, the same code with {a}", r.line, other.line);
        }
    }
    for r in all {
        let lower = |o: &&Reading| (0..3).all(|c| o.code[c] <= r.code[c]) && o.xyz[1] > r.xyz[1] + FALL * white[1];
        if let Some(other) = all.iter().find(lower) {
            let (a, b) = (other.xyz[1], r.xyz[1]);
            return invalid!(
                "line {}: light falls to {b} cd/m2 from {a} in line {}, whose codes are lower",
                r.line,
                other.line
            );
        }
    }
    Ok(())
}

/// Readings weigh by the inverse of their light, as a meter's error does, down to 2 % of the brightest.
fn weights(all: &[Reading]) -> Vec<f64> {
    let top = all.iter().fold(0f64, |m, r| m.max(r.xyz[1]));
    all.iter().map(|r| (r.xyz[1] + 0.02 * top).powi(-2)).collect()
}

impl Additive {
    /// Least squares of light above black on the codes' shares.
    fn fit(all: &[Reading], black: [f64; 3], transfer: &Transfer) -> Result<Additive> {
        let (mut tt, mut xt) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for (r, w) in all.iter().zip(weights(all)) {
            let t = transfer.shares(r.code);
            for i in 0..3 {
                for j in 0..3 {
                    tt[i][j] += w * t[i] * t[j];
                    xt[i][j] += w * (r.xyz[i] - black[i]) * t[j];
                }
            }
        }
        // Scaled to entries near 1, since brightness is squared within.
        let size = 1.0 / tt[0][0].max(f64::MIN_POSITIVE);
        let inverse = Mat3(tt).scaled(size).inverse().map(|m| m.scaled(size));
        let inverse =
            inverse.ok_or_else(|| Error::Invalid("the codes do not tell red, green and blue apart".into()))?;
        Ok(Additive { black, columns: Mat3(xt).times(&inverse) })
    }

    /// Weighted squares that it leaves.
    fn residual(&self, all: &[Reading], transfer: &Transfer) -> f64 {
        let of = |(r, w): (&Reading, f64)| {
            let light = self.columns.apply(transfer.shares(r.code));
            w * (0..3).map(|i| (light[i] + self.black[i] - r.xyz[i]).powi(2)).sum::<f64>()
        };
        all.iter().zip(weights(all)).map(of).sum()
    }

    fn display(&self, name: &str, transfer: Transfer, bits: u8) -> Result<Display> {
        let m = &self.columns.0;
        let xy = |xyz: [f64; 3], what: &str| {
            let least = -IMPOSSIBLE * xyz.iter().sum::<f64>();
            let p = Xy::of(xyz).filter(|_| xyz.iter().all(|x| *x >= least));
            p.ok_or_else(|| Error::Invalid(format!("{what} less black is no colour: X, Y, Z {:.4?}", xyz)))
        };
        let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
        let rgb = [xy(column(0), "red")?, xy(column(1), "green")?, xy(column(2), "blue")?];
        let white = self.columns.apply([1.0; 3]);
        let primaries = Primaries { rgb, white: xy(white, "white")? };
        if Primaries::from_numbers(&primaries.numbers()).is_none() {
            return invalid!("red, green and blue lie on one line: {primaries}");
        }
        let white_cd_m2 = white[1] + self.black[1];
        let black_cd_m2 = self.black[1].max(DARKEST * white_cd_m2);
        Ok(Display { name: name.to_string(), primaries, white_cd_m2, black_cd_m2, transfer, bits })
    }
}

/// The gamma that leaves least: a coarse search, then golden sections.
fn best_gamma(all: &[Reading], black: [f64; 3]) -> Result<f64> {
    let cost = |g: f64| -> Result<f64> {
        let transfer = Transfer::Gamma(g);
        Ok(Additive::fit(all, black, &transfer)?.residual(all, &transfer))
    };
    let mut best = (f64::INFINITY, 1.0);
    for i in 0..=95 {
        let g = 0.25 + 0.05 * f64::from(i);
        let c = cost(g)?;
        if c < best.0 {
            best = (c, g);
        }
    }
    let (mut low, mut high) = (best.1 - 0.05, best.1 + 0.05);
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..40 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if cost(a)? < cost(b)? { high = b } else { low = a }
    }
    Ok((low + high) / 2.0)
}

/// A table from patches of one level: greys, and single channels. `None` with fewer than two levels between black and full.
fn table(all: &[Reading], black: [f64; 3], columns: Mat3) -> Result<Option<Transfer>> {
    let ramp: Vec<(f64, f64, &Reading)> = all.iter().filter_map(|r| share_of_ramp(r, black, &columns)).collect();
    let mut levels: Vec<f64> = ramp.iter().map(|r| r.0).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    if levels.len() < 2 {
        return Ok(None);
    }
    let (mut codes, mut light) = (vec![0.0], vec![0.0]);
    for level in levels {
        let of_level = |r: &&(f64, f64, &Reading)| r.0 == level;
        // The brightest patch of a level, grey if there is one, is the one that black disturbs least.
        let top = ramp.iter().filter(of_level).fold(0f64, |m, r| m.max(r.2.xyz[1]));
        let bright: Vec<f64> = ramp.iter().filter(of_level).filter(|r| r.2.xyz[1] > 0.99 * top).map(|r| r.1).collect();
        let share = bright.iter().sum::<f64>() / bright.len() as f64;
        let last = light[light.len() - 1];
        if share < last - FALL {
            return invalid!("light falls from {last:.3} to {share:.3} of white up to code {level}; a display's rises");
        }
        codes.push(level);
        light.push(share.clamp(last + 1e-6, 1.0));
    }
    codes.push(1.0);
    light.push(1.0);
    if light.windows(2).any(|w| w[0] >= w[1]) {
        return Ok(None); // full before the last code
    }
    let curve = Monotone::new(codes.clone(), light.iter().map(|x| x.powf(1.0 / 2.2)).collect());
    let steps = steps(&codes);
    let at = |i: usize| curve.at(i as f64 / steps as f64).powf(2.2);
    let mut table: Vec<f64> = (0..=steps).map(at).collect();
    (table[0], table[steps]) = (0.0, 1.0);
    Ok(table.windows(2).all(|w| w[0] < w[1]).then_some(Transfer::Table(table)))
}

/// Level, share of full light and reading of a patch whose lit channels are all at one level between black and full.
fn share_of_ramp<'a>(r: &'a Reading, black: [f64; 3], columns: &Mat3) -> Option<(f64, f64, &'a Reading)> {
    let level = r.code.iter().fold(0f64, |m, c| m.max(*c));
    let lit = r.code.map(|c| f64::from(u8::from(c > 0.0)));
    if level <= 0.0 || level >= 1.0 || r.code.iter().any(|c| *c > 0.0 && *c != level) {
        return None;
    }
    let full = columns.apply(lit);
    let (mut dot, mut size) = (0.0, 0.0);
    for i in 0..3 {
        dot += (r.xyz[i] - black[i]) * full[i];
        size += full[i] * full[i];
    }
    (size > 0.0).then(|| (level, dot / size, r))
}

/// Steps on which every level falls, if a byte's do.
fn steps(levels: &[f64]) -> usize {
    let on = |n: usize| levels.iter().all(|l| (l * n as f64 - (l * n as f64).round()).abs() < 1e-6);
    match (2..=STEPS.1).find(|n| on(*n)) {
        Some(n) => n * STEPS.0.div_ceil(n).min(STEPS.1 / n),
        None => STEPS.1,
    }
}

/// A monotone cubic through points [Fritsch and Butland 1984].
struct Monotone {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Monotone {
    fn new(x: Vec<f64>, y: Vec<f64>) -> Monotone {
        let secant: Vec<f64> = (1..x.len()).map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1])).collect();
        let inner = |i: usize| match (secant[i - 1], secant[i]) {
            (a, b) if a * b <= 0.0 => 0.0,
            (a, b) => {
                let part = (1.0 + (x[i + 1] - x[i]) / (x[i + 1] - x[i - 1])) / 3.0;
                a * b / (part * b + (1.0 - part) * a)
            }
        };
        let last = secant.len();
        let slope = (0..x.len()).map(|i| {
            if i == 0 {
                secant[0]
            } else if i == last {
                secant[last - 1]
            } else {
                inner(i)
            }
        });
        let slope = slope.collect();
        Monotone { x, y, slope }
    }

    fn at(&self, x: f64) -> f64 {
        let i = self.x.partition_point(|p| *p <= x).clamp(1, self.x.len() - 1) - 1;
        let h = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / h;
        let (a, b) = (1.0 + 2.0 * t, 3.0 - 2.0 * t);
        self.y[i] * a * (1.0 - t).powi(2)
            + self.slope[i] * h * t * (1.0 - t).powi(2)
            + self.y[i + 1] * b * t * t
            + self.slope[i + 1] * h * t * t * (t - 1.0)
    }
}

/// Where the light of lower levels is over 2 % of the primary's, so that black's own error does not show as drift.
fn drift(all: &[Reading], black: [f64; 3], channel: usize) -> Option<f64> {
    let over = |r: &Reading| [0, 1, 2].map(|i| r.xyz[i] - black[i]);
    let alone = |r: &&Reading| (0..3).all(|i| (r.code[i] > 0.0) == (i == channel));
    let full = all.iter().filter(alone).find(|r| r.code[channel] == 1.0)?;
    let own = Xy::of(over(full))?;
    let lower = all.iter().filter(alone).filter(|r| r.code[channel] < 1.0 && over(r)[1] > 0.02 * over(full)[1]);
    lower.filter_map(|r| Xy::of(over(r))).map(|p| p.distance(own)).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monotone_cubic_keeps_its_points_and_a_line() {
        let curve = Monotone::new(vec![0.0, 0.1, 0.5, 0.6, 1.0], vec![0.0, 0.01, 0.5, 0.5001, 1.0]);
        assert!((curve.at(0.5) - 0.5).abs() < 1e-12 && (curve.at(1.0) - 1.0).abs() < 1e-12);
        assert!((0..1000).all(|i| curve.at(f64::from(i) / 1000.0) <= curve.at(f64::from(i + 1) / 1000.0)));
        let line = Monotone::new(vec![0.0, 0.3, 1.0], vec![0.0, 0.3, 1.0]);
        assert!((line.at(0.77) - 0.77).abs() < 1e-12);
    }

    #[test]
    fn tables_have_the_levels_that_were_read() {
        assert_eq!(steps(&[0.0, 0.25, 0.5, 1.0]), 32);
        assert_eq!(steps(&[0.0, 51.0 / 255.0, 1.0]), 35);
        assert_eq!(steps(&[0.0, 32.0 / 255.0, 1.0]), 255);
        assert_eq!(steps(&[0.0, 0.1234567, 1.0]), 255);
    }
}
