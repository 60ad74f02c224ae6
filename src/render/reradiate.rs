//! A fluorescent surface in lanes: all that it gives off for what each lane takes in.
//!
//! Light that has changed its wavelength is no longer a factor of its lamp's spectrum: it is radiance of its own, light number
//! `lights.len()`, of a spectrum that is 1. A path carries all wavelengths at once, so that the whole matrix is applied and no
//! colour is left to chance.

use std::ops::Range;

use crate::optics::reradiation::Reradiation;
use crate::render::lanes::{GROUP, Lanes};
use crate::spectral::Sampling;

/// Of one surface.
pub struct Dye<const G: usize> {
    /// What keeps its wavelength.
    pub reflectance: Lanes<G>,
    /// For each lane that takes light in, the groups of lanes in which it comes out, and how much.
    columns: Vec<(usize, Range<usize>, Lanes<G>)>,
}

impl<const G: usize> Dye<G> {
    /// Sampled.
    pub fn new(reflectance: Lanes<G>, dye: &Reradiation, sampling: &Sampling) -> Dye<G> {
        let matrix = dye.matrix(sampling);
        let column = |inc: usize| {
            let lanes = Lanes::<G>::from_values(&matrix.iter().map(|row| row[inc]).collect::<Vec<_>>());
            let any = |g: &[f32; GROUP]| g.iter().any(|x| *x > 0.0);
            let groups = lanes.0.iter().position(any)?..lanes.0.iter().rposition(any)? + 1;
            Some((inc, groups, lanes))
        };
        Dye { reflectance, columns: (0..matrix.len()).filter_map(column).collect() }
    }

    /// What it gives off for so much light, W/sr/m2/nm both.
    #[inline(always)]
    pub fn reradiated(&self, light: &Lanes<G>) -> Lanes<G> {
        let mut out = Lanes::splat(0.0);
        for (inc, groups, column) in &self.columns {
            let k = light.0[inc / GROUP][inc % GROUP];
            if k == 0.0 {
                continue;
            }
            for (sums, more) in out.0[groups.clone()].iter_mut().zip(&column.0[groups.clone()]) {
                for i in 0..GROUP {
                    sums[i] += k * more[i];
                }
            }
        }
        out
    }
}
