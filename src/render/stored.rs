//! Light that a method has worked out before the eye looks: rows of factors, a wavelength each, of one light's radiance each.

use crate::render::lanes::{GROUP, Lanes};

/// Rows that trails refer to by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored {
    /// Lights of rows 0, 1, ... and again from the first.
    pub lights: Vec<u32>,
    /// Numbers a row, a multiple of 8.
    pub lanes: usize,
    /// Rows one after the other.
    pub data: Vec<f32>,
}

/// No light.
pub static NOTHING: Stored = Stored { lights: Vec::new(), lanes: 0, data: Vec::new() };

impl Stored {
    /// The light of a row.
    #[inline(always)]
    pub fn light(&self, row: u32) -> u32 {
        self.lights[row as usize % self.lights.len()]
    }

    /// A row.
    #[inline(always)]
    pub fn row(&self, row: u32) -> &[f32] {
        &self.data[row as usize * self.lanes..][..self.lanes]
    }

    /// Adds a row times `k`.
    #[inline(always)]
    pub fn add<const G: usize>(&self, lanes: &mut Lanes<G>, row: u32, k: f32) {
        for (sums, more) in lanes.0.iter_mut().zip(self.row(row).chunks_exact(GROUP)) {
            for i in 0..GROUP {
                sums[i] += k * more[i];
            }
        }
    }
}
