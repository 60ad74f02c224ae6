//! A few wavelengths that stand for all: XYZ of a light's way by one matrix a light.

use crate::{Result, invalid};

/// K wavelengths and, for each light, what the share of it that is left at each of them weighs in X, Y and Z: the light's spectrum and
/// the observer are folded in, so that a spiky lamp needs no more of them than daylight.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Ascending, nm.
    pub nodes_nm: Vec<f64>,
    /// [light][X, Y, Z][wavelength], cd/m2; none is negative.
    pub weights: Vec<[Vec<f64>; 3]>,
}

impl Rule {
    /// Checked: as many weights as wavelengths, all finite and not negative.
    pub fn new(nodes_nm: Vec<f64>, weights: Vec<[Vec<f64>; 3]>) -> Result<Rule> {
        if nodes_nm.is_empty() || !nodes_nm.windows(2).all(|w| w[0] < w[1]) {
            return invalid!("the wavelengths of a rule must ascend");
        }
        for (i, row) in weights.iter().flatten().enumerate() {
            if row.len() != nodes_nm.len() || !row.iter().all(|w| (0.0..=1e30).contains(w)) {
                let name = ["X", "Y", "Z"][i % 3];
                return invalid!(
                    "weights of {name} of light {}: {} numbers of 0 or more, one a wavelength, are right",
                    i / 3 + 1,
                    nodes_nm.len()
                );
            }
        }
        Ok(Rule { nodes_nm, weights })
    }

    /// XYZ of a light of which this much is left at each wavelength.
    pub fn xyz(&self, light: usize, left: &[f64]) -> [f64; 3] {
        self.weights[light].each_ref().map(|w| w.iter().zip(left).map(|(w, l)| w * l).sum())
    }
}
