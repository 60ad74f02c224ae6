//! Fluorescence: light of one wavelength absorbed, and part of it given off again at longer ones [Donaldson 1954; Hullin 2010].
//!
//! B(out) = R(out) E(out) + integral of F(out, in) E(in) over in, spectral quantities all. What comes out has no longer the
//! direction, the wavelength or the polarization of what went in. Two forms: a measured matrix in bands, or a dye by the share
//! that it absorbs, the photons that it gives off and its quantum yield. No photon gains energy, and no more come out than went
//! in: a matrix with F above the diagonal, or with a photon sum above 1, is refused.

use crate::spectral::{Sampling, Spectrum};
use crate::{Result, invalid};

/// F by wavelength in nm, 1/nm.
#[derive(Clone, Debug, PartialEq)]
pub enum Reradiation {
    /// Equal bands `from_nm`, `step_nm`; `shares[out][in]` is the share of the power of a band that comes out in another.
    Bands {
        /// Lower edge of the first.
        from_nm: f64,
        /// Width of each.
        step_nm: f64,
        /// Without its diagonal, which is reflectance.
        shares: Vec<Vec<f64>>,
    },
    /// A dye.
    Dye {
        /// Share of light absorbed by it times its quantum yield.
        absorbed: Spectrum,
        /// Photons that it gives off, any unit, 1/nm.
        emission: Spectrum,
    },
}

/// Steps in nm by which a dye is integrated.
const STEP_NM: f64 = 1.0;

impl Reradiation {
    /// A measured matrix as text: a line `nm, in1, in2, ...` of the bands' middles, then a line a band out, its middle first;
    /// `#` begins a comment. Returns the reflectance on its diagonal as well.
    ///
    /// ```
    /// use luxpipe::optics::reradiation::Reradiation;
    /// let text = "nm,400,500\n400,0.2,0\n500,0.5,0.6\n";
    /// let (reflectance, dye) = Reradiation::from_csv(text).unwrap();
    /// assert_eq!(reflectance.at(500.0), 0.6);
    /// // 0.5 of the power that comes in the first band leaves in the second.
    /// assert!((dye.between((450.0, 550.0), (350.0, 450.0)) - 0.5).abs() < 1e-12);
    /// assert!(Reradiation::from_csv("nm,400,500\n400,0.2,0\n500,0.7,0.6\n").unwrap_err().to_string().contains("photons"));
    /// ```
    pub fn from_csv(text: &str) -> Result<(Spectrum, Reradiation)> {
        let lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
        let mut lines = lines.filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
        let numbers =
            |line: &str| line.split(',').skip(1).map(|w| w.trim().parse::<f64>()).collect::<Result<Vec<_>, _>>();
        let Some((line, head)) = lines.next() else { return invalid!("no numbers in it") };
        let Ok(middles) = numbers(head) else {
            return invalid!("line {line}: expected 'nm' and the bands' middles in nm");
        };
        let n = middles.len();
        let step_nm = if n > 1 { (middles[n - 1] - middles[0]) / (n - 1) as f64 } else { 0.0 };
        let even = |w: &[f64]| (w[1] - w[0] - step_nm).abs() <= 1e-6 * step_nm;
        if !(step_nm > 0.0 && step_nm.is_finite() && middles[0] - step_nm / 2.0 > 0.0 && middles.windows(2).all(even)) {
            return invalid!("line {line}: expected two or more wavelengths in equal steps upwards");
        }
        let mut shares = Vec::new();
        for (line, row) in lines {
            let first = row.split(',').next().and_then(|w| w.trim().parse::<f64>().ok());
            let Some(values) = numbers(row).ok().filter(|v| v.len() == n) else {
                return invalid!("line {line}: expected a wavelength and {n} numbers");
            };
            let want = middles.get(shares.len());
            if want.is_none_or(|w| first.is_none_or(|f| (f - w).abs() > 1e-6 * w)) {
                return invalid!("line {line}: rows must have the wavelengths of the first line, in the same order");
            }
            shares.push(values);
        }
        if shares.len() != n {
            return invalid!("{} rows for {n} bands", shares.len());
        }
        Reradiation::from_bands(middles[0] - step_nm / 2.0, step_nm, shares)
    }

    /// From a square matrix in bands, the diagonal is reflectance.
    pub fn from_bands(from_nm: f64, step_nm: f64, mut shares: Vec<Vec<f64>>) -> Result<(Spectrum, Reradiation)> {
        let n = shares.len();
        let middle = |i: usize| from_nm + step_nm * (i as f64 + 0.5);
        let pairs = |inc: usize| (0..n).map(move |out| (out, inc));
        for (out, inc) in (0..n).flat_map(pairs) {
            let share = shares[out][inc];
            if !(0.0..=1.0).contains(&share) {
                return invalid!("{share} from {} to {} nm: shares lie in 0 to 1", middle(inc), middle(out));
            }
            if out < inc && share > 1e-9 {
                return invalid!(
                    "{share} from {} to {} nm: no photon gains energy; rows are where light comes out",
                    middle(inc),
                    middle(out)
                );
            }
        }
        for inc in 0..n {
            let photons: f64 = shares.iter().enumerate().map(|(out, row)| row[inc] * middle(out) / middle(inc)).sum();
            if photons > 1.0 + 1e-9 {
                return invalid!("{photons:.6} photons come out for each one at {} nm; at most 1 can", middle(inc));
            }
        }
        // Linear between the middles, level beyond them as far as the bands reach.
        let mut points = vec![(middle(0) - step_nm / 2.0, shares[0][0])];
        points.extend((0..n).map(|i| (middle(i), shares[i][i])));
        points.push((middle(n - 1) + step_nm / 2.0, shares[n - 1][n - 1]));
        (0..n).for_each(|i| shares[i][i] = 0.0);
        Ok((Spectrum::from_points(points)?, Reradiation::Bands { from_nm, step_nm, shares }))
    }

    /// A dye that absorbs and gives off again, beside a reflectance; 0..1 all but the emission.
    pub fn dye(
        reflectance: &Spectrum,
        absorption: &Spectrum,
        emission: &Spectrum,
        quantum_yield: &Spectrum,
    ) -> Result<Reradiation> {
        for (name, s) in [("absorption", absorption), ("quantum_yield", quantum_yield)] {
            let (low, high) = s.range();
            if low < 0.0 || high > 1.0 {
                return invalid!("{name} runs from {low} to {high}; it must lie in 0 to 1");
            }
        }
        if !matches!(emission, Spectrum::Table(_)) || emission.range().0 < 0.0 || emission.range().1 <= 0.0 {
            return invalid!("emission: expected a table of photons, none below 0");
        }
        let grid = || (250..2500).map(f64::from);
        if let Some(nm) = grid().find(|nm| reflectance.at(*nm) + absorption.at(*nm) > 1.0 + 1e-9) {
            return invalid!("reflectance and absorption sum to more than 1 at {nm} nm");
        }
        let first = grid().find(|nm| absorption.at(*nm) > 0.0).unwrap_or(f64::INFINITY);
        if first.is_finite() && !grid().any(|nm| nm >= first && emission.at(nm) > 0.0) {
            return invalid!("emission ends below {first} nm, where absorption begins: no photon gains energy");
        }
        let yielded = |nm: f64| (nm, absorption.at(nm) * quantum_yield.at(nm));
        let absorbed = Spectrum::from_points(grid().map(yielded).collect())?;
        Ok(Reradiation::Dye { absorbed, emission: emission.clone() })
    }

    /// Share of the power that it takes in at each wavelength and gives off again; of a dye at most.
    pub fn given(&self) -> Spectrum {
        match self {
            Reradiation::Dye { absorbed, .. } => absorbed.clone(),
            Reradiation::Bands { from_nm, step_nm, shares } => {
                let sum = |inc: usize| shares.iter().map(|row| row[inc]).sum::<f64>();
                let middle = |inc: usize| (from_nm + step_nm * (inc as f64 + 0.5), sum(inc));
                Spectrum::Table((0..shares.len()).map(middle).collect())
            }
        }
    }

    /// Mean over the wavelengths `out` of the integral of F over `inc`: spectral power that comes out in a bin for 1 W/nm in all of
    /// another.
    pub fn between(&self, out: (f64, f64), inc: (f64, f64)) -> f64 {
        match self {
            Reradiation::Bands { from_nm, step_nm, shares } => {
                let overlap = |(a, b): (f64, f64), i: usize| {
                    let low = from_nm + step_nm * i as f64;
                    (b.min(low + step_nm) - a.max(low)).max(0.0) / step_nm
                };
                let width = (out.1 - out.0) / step_nm;
                let row = |(o, row): (usize, &Vec<f64>)| {
                    let over = overlap(out, o) / width;
                    if over <= 0.0 {
                        0.0
                    } else {
                        over * row.iter().enumerate().map(|(i, s)| s * overlap(inc, i)).sum::<f64>()
                    }
                };
                shares.iter().enumerate().map(row).sum()
            }
            Reradiation::Dye { absorbed, emission } => {
                let mut sum = 0.0;
                let (inner, outer) = (steps(inc), steps(out));
                for (nm_in, d_in) in &inner {
                    let takes = absorbed.at(*nm_in);
                    let all = if takes > 0.0 { emission.integral(*nm_in, f64::INFINITY) } else { 0.0 };
                    if all <= 0.0 {
                        continue;
                    }
                    for (nm_out, d_out) in outer.iter().filter(|o| o.0 > *nm_in) {
                        sum += takes * emission.at(*nm_out) / all * nm_in / nm_out * d_in * d_out;
                    }
                }
                sum / (out.1 - out.0)
            }
        }
    }

    /// The matrix of a sampling, `[out][in]`: spectral power out for 1 in, at the sampling's wavelengths.
    ///
    /// Points stand for the wavelengths half way to their neighbours.
    pub fn matrix(&self, sampling: &Sampling) -> Vec<Vec<f64>> {
        let cells = cells(sampling);
        cells.iter().map(|out| cells.iter().map(|inc| self.between(*out, *inc)).collect()).collect()
    }
}

/// Middles and widths of small steps over an interval.
fn steps((a, b): (f64, f64)) -> Vec<(f64, f64)> {
    let n = ((b - a) / STEP_NM).ceil().max(1.0) as usize;
    let d = (b - a) / n as f64;
    (0..n).map(|i| (a + d * (i as f64 + 0.5), d)).collect()
}

/// What each component stands for, nm.
fn cells(sampling: &Sampling) -> Vec<(f64, f64)> {
    let edges = |i| {
        let (a, b) = sampling.edges(i);
        (a.min(b), a.max(b))
    };
    let all: Vec<(f64, f64)> = (0..sampling.count()).map(edges).collect();
    if all.iter().any(|(a, b)| a != b) {
        return all;
    }
    let mut sorted: Vec<f64> = all.iter().map(|c| c.0).collect();
    sorted.sort_by(f64::total_cmp);
    let cell = |nm: f64| {
        let i = sorted.partition_point(|x| *x < nm);
        let near = |j: Option<usize>| j.and_then(|j| sorted.get(j)).map(|x| (x - nm).abs() / 2.0);
        let (below, above) = (near(i.checked_sub(1)), near(Some(i + 1)));
        let (below, above) = (below.or(above).unwrap_or(0.5), above.or(below).unwrap_or(0.5));
        (nm - below, nm + above)
    };
    all.iter().map(|c| cell(c.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of photons that a dye takes in, as many as its quantum yield says come out, however the bins lie.
    #[test]
    fn photons_are_counted() {
        let white = Spectrum::Constant(0.0);
        let takes = Spectrum::from_points(vec![(300.0, 0.9), (400.0, 0.9), (450.0, 0.0)]).unwrap();
        let gives = Spectrum::from_points(vec![(420.0, 0.0), (480.0, 1.0), (600.0, 0.0)]).unwrap();
        let dye = Reradiation::dye(&white, &takes, &gives, &Spectrum::Constant(0.8)).unwrap();
        for bins in [24, 48, 96] {
            let sampling = Sampling::bins(300.0, 780.0, bins).unwrap();
            let matrix = dye.matrix(&sampling);
            let middle = |i| {
                let (a, b) = sampling.edges(i);
                0.5 * (a + b)
            };
            let width = 480.0 / bins as f64;
            for inc in (0..bins).filter(|i| middle(*i) + width / 2.0 <= 400.0) {
                let photons: f64 = (0..bins).map(|out| matrix[out][inc] * middle(out) / middle(inc)).sum();
                let energy: f64 = (0..bins).map(|out| matrix[out][inc]).sum();
                assert!((photons - 0.72).abs() < 0.72 * 2e-3, "{bins} bins, {} nm: {photons}", middle(inc));
                assert!(energy < photons);
            }
        }
    }

    #[test]
    fn what_gains_is_refused() {
        let bands = |m: [[f64; 2]; 2]| Reradiation::from_bands(400.0, 100.0, m.map(Vec::from).to_vec());
        assert!(bands([[0.5, 0.0], [0.4, 0.9]]).is_ok());
        // 0.5 + 0.45 of the power, but more photons than came.
        assert!(bands([[0.5, 0.0], [0.45, 0.9]]).unwrap_err().to_string().contains("photons"));
        assert!(bands([[0.5, 0.1], [0.0, 0.5]]).unwrap_err().to_string().contains("gains energy"));
        assert!(bands([[-0.1, 0.0], [0.0, 0.5]]).is_err());
        assert!(bands([[f64::NAN, 0.0], [0.0, 0.5]]).is_err());
    }
}
