//! Index of refraction by formula: Sellmeier's and Cauchy's, wavelengths in micrometres as glass makers' data sheets have them.

use crate::spectral::Spectrum;
use crate::{Result, invalid};

/// Wavelengths that a formula is tabulated over, nm: a table every nanometre is within 1e-7 of it.
const RANGE_NM: (u32, u32) = (250, 2500);

/// n^2 - 1 = sum of B l^2 / (l^2 - C), with B1 B2 B3 and C1 C2 C3 in um^2 [Sellmeier 1871].
///
/// ```
/// use luxpipe::spectral::glass::sellmeier;
/// // Schott N-BK7 at the d line: 1.5168.
/// let bk7 = sellmeier(&[1.03961212, 0.231792344, 1.01046945, 0.00600069867, 0.0200179144, 103.560653]).unwrap();
/// assert!((bk7.at(587.5618) - 1.5168).abs() < 5e-6);
/// ```
pub fn sellmeier(c: &[f64]) -> Result<Spectrum> {
    let [b1, b2, b3, c1, c2, c3] = c else {
        return invalid!("sellmeier: expected six numbers, B1 B2 B3 and C1 C2 C3 in um^2, got {}", c.len());
    };
    table("sellmeier", |um2| {
        let term = |b: &f64, c: &f64| b * um2 / (um2 - c);
        (1.0 + term(b1, c1) + term(b2, c2) + term(b3, c3)).sqrt()
    })
}

/// n = A + B / l^2 + C / l^4, B in um^2 and C in um^4; two or three numbers [Cauchy 1836].
///
/// ```
/// let n = luxpipe::spectral::glass::cauchy(&[1.5, 0.004]).unwrap();
/// assert!((n.at(500.0) - 1.516).abs() < 1e-6);
/// ```
pub fn cauchy(c: &[f64]) -> Result<Spectrum> {
    let (a, b, c) = match c {
        [a, b] => (a, b, &0.0),
        [a, b, c] => (a, b, c),
        _ => return invalid!("cauchy: expected two or three numbers, A, B in um^2, C in um^4, got {}", c.len()),
    };
    table("cauchy", |um2| a + b / um2 + c / (um2 * um2))
}

fn table(name: &str, n: impl Fn(f64) -> f64) -> Result<Spectrum> {
    let point = |nm: u32| {
        let um = f64::from(nm) / 1000.0;
        (f64::from(nm), n(um * um))
    };
    let points: Vec<(f64, f64)> = (RANGE_NM.0..=RANGE_NM.1).map(point).collect();
    // A resonance within the visible, or a slip of the units.
    let visible = points.iter().filter(|p| (380.0..=780.0).contains(&p.0));
    if visible.clone().any(|(_, n)| !(0.25..=8.0).contains(n)) {
        return invalid!("{name}: gives no index from 0.25 to 8 over 380 to 780 nm; lengths are in um");
    }
    // Beyond its resonances a formula means nothing; the index goes on as it ended.
    let mut points: Vec<_> = points.into_iter().filter(|(_, n)| (0.25..=8.0).contains(n)).collect();
    points.dedup_by_key(|p| p.0);
    Ok(Spectrum::from_points(points)?.extended())
}
