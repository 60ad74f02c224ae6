//! How a spectrum travels as N numbers: equal bins, or points.

use super::{Observer, Spectrum};
use crate::units::K_M;
use crate::{Result, invalid};

/// The meaning of a spectral picture's components.
#[derive(Clone, Debug, PartialEq)]
pub enum Sampling {
    /// `count` equal bins from the long end to the short end, in nm; each component is its bin's mean (Radiance's order).
    Bins {
        /// Long end.
        long_nm: f64,
        /// Short end.
        short_nm: f64,
        /// How many.
        count: usize,
    },
    /// Values at these wavelengths, strictly monotone; between them the spectrum is linear, outside it is zero.
    Points(Vec<f64>),
}

impl Sampling {
    /// Checked equal bins; `from_nm` and `to_nm` in either order.
    pub fn bins(from_nm: f64, to_nm: f64, count: usize) -> Result<Sampling> {
        let (short_nm, long_nm) = (from_nm.min(to_nm), from_nm.max(to_nm));
        if !(short_nm >= 1.0 && long_nm <= 1e5 && long_nm > short_nm) || count == 0 {
            return invalid!("{count} bins over {from_nm}:{to_nm} nm make no spectrum");
        }
        Ok(Sampling::Bins { long_nm, short_nm, count })
    }

    /// Checked points.
    pub fn points(nm: Vec<f64>) -> Result<Sampling> {
        let order = |f: fn(&f64, &f64) -> bool| nm.windows(2).all(|w| f(&w[0], &w[1]));
        let monotone = order(|a, b| a < b) || order(|a, b| a > b);
        if nm.is_empty() || !monotone || !nm.iter().all(|x| (1.0..=1e5).contains(x)) {
            return invalid!("wavelengths must be positive, in nm, and strictly ascending or descending");
        }
        Ok(Sampling::Points(nm))
    }

    /// Number of components.
    pub fn count(&self) -> usize {
        match self {
            Sampling::Bins { count, .. } => *count,
            Sampling::Points(nm) => nm.len(),
        }
    }

    /// The bin's ends, short then long, or twice the point's wavelength.
    pub fn edges(&self, i: usize) -> (f64, f64) {
        match self {
            Sampling::Bins { long_nm, short_nm, count } => {
                let at = |k: usize| long_nm + (short_nm - long_nm) * k as f64 / *count as f64;
                (at(i + 1), at(i))
            }
            Sampling::Points(nm) => (nm[i], nm[i]),
        }
    }

    /// Middle of component i, nm.
    pub fn centre_nm(&self, i: usize) -> f64 {
        let (a, b) = self.edges(i);
        0.5 * (a + b)
    }

    /// The components that stand for `s`.
    ///
    /// ```
    /// use luxpipe::spectral::{Sampling, Spectrum};
    /// let ramp = Spectrum::from_points(vec![(400.0, 0.0), (700.0, 3.0)]).unwrap();
    /// let values = Sampling::bins(400.0, 700.0, 3).unwrap().sample(&ramp);
    /// assert!(values.iter().zip([2.5, 1.5, 0.5]).all(|(a, b)| (a - b).abs() < 1e-12));
    /// ```
    pub fn sample(&self, s: &Spectrum) -> Vec<f64> {
        (0..self.count())
            .map(|i| match self.edges(i) {
                (a, b) if a == b => s.at(a),
                (a, b) => s.mean(a, b),
            })
            .collect()
    }

    /// Eq. (4) as three rows of weights: XYZ in cd/m2 = weights x radiance components in W/sr/m2/nm.
    pub fn xyz_weights(&self, observer: &Observer) -> [Vec<f64>; 3] {
        observer.cmf.each_ref().map(|cmf| self.response_weights(cmf).into_iter().map(|w| K_M * w).collect())
    }

    /// Weights that integrate components against a response.
    ///
    /// A bin's weight is the response's integral over it; a point's is the response summed on the 1 nm grid under the hat
    /// function that linear interpolation gives it.
    pub fn response_weights(&self, response: &Spectrum) -> Vec<f64> {
        match self {
            Sampling::Bins { count, .. } => (0..*count)
                .map(|i| {
                    let (a, b) = self.edges(i);
                    response.integral(a, b)
                })
                .collect(),
            Sampling::Points(nm) => point_weights(nm, response),
        }
    }
}

fn point_weights(nm: &[f64], response: &Spectrum) -> Vec<f64> {
    let mut weights = vec![0.0; nm.len()];
    let mut order: Vec<usize> = (0..nm.len()).collect();
    order.sort_by(|a, b| nm[*a].total_cmp(&nm[*b]));
    let (low, high) = (nm[order[0]].ceil(), nm[order[order.len() - 1]].floor());
    for step in 0..=(high - low).max(-1.0) as usize {
        let lambda = low + step as f64;
        let value = response.at(lambda);
        let above = order.partition_point(|i| nm[*i] < lambda);
        let Some(&b) = order.get(above) else { continue };
        if nm[b] == lambda {
            weights[b] += value;
        } else if above > 0 {
            let a = order[above - 1];
            let f = (lambda - nm[a]) / (nm[b] - nm[a]);
            weights[a] += value * (1.0 - f);
            weights[b] += value * f;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_equal_spectrum_has_683_times_106_857_cd_m2_however_it_is_sampled() {
        let observer = Observer::cie1931().unwrap();
        let fine = Sampling::points((360..=830).map(f64::from).collect()).unwrap();
        let descending = Sampling::points((360..=830).rev().map(f64::from).collect()).unwrap();
        let bins = Sampling::bins(360.0, 830.0, 94).unwrap();
        for sampling in [fine, descending, bins] {
            let y: f64 = sampling.xyz_weights(&observer)[1].iter().sum();
            assert!((y / K_M - 106.857).abs() < 2e-3, "{y}");
        }
    }
}
