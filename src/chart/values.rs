//! The values of a picture, all of them at once.

use crate::stream::{Block, Header, Picture};
use crate::view::{Kind, View};
use crate::{Error, Result};

/// All values of a picture.
pub struct Values {
    width: usize,
    height: usize,
    factor: f32,
    all: Vec<f32>,
    view: Option<View>,
}

impl Values {
    /// None yet, of a picture with this header; an error if they will take more than `memory` bytes.
    pub fn new(header: &Header, factor: f64, memory: u64) -> Result<Values> {
        let (width, height) = (header.resolution.width, header.resolution.height);
        let bytes = 4 * width as u64 * height as u64;
        if bytes > memory {
            let needed = bytes.div_ceil(1 << 20);
            return Err(Error::Unsupported(format!("the picture takes {needed} MB; allow it with --memory")));
        }
        Ok(Values { width, height, factor: factor as f32, all: Vec::new(), view: View::of(header) })
    }

    /// The next pixels: Y, or XYZ.
    pub fn add(&mut self, pixels: &[f32], ncomp: usize) {
        self.all.extend(pixels.chunks_exact(ncomp).map(|p| p[usize::from(ncomp == 3)] * self.factor));
    }

    /// All of a picture of Y.
    pub fn add_all(&mut self, mut picture: Box<dyn Picture>) -> Result<()> {
        let mut block = Block::default();
        while picture.next(&mut block)? {
            self.add(&block.data, 1);
        }
        Ok(())
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Width and values.
    pub fn take(self) -> (usize, Vec<f32>) {
        (self.width, self.all)
    }

    /// The largest finite value.
    pub fn largest(&self) -> Option<f64> {
        self.all.iter().copied().filter(|x| x.is_finite()).max_by(f32::total_cmp).map(f64::from)
    }

    /// How many have no place on a scale that begins at `min`.
    pub fn without_value(&self, min: f64) -> usize {
        self.all.iter().filter(|x| !x.is_finite() || (**x < 0.0 && min >= 0.0)).count()
    }

    /// Smallest and largest finite value with their places, the first of each; those of a fisheye's circle.
    pub fn extremes(&self) -> Vec<(f64, usize, usize)> {
        let circle = self.view.filter(|v| matches!(v.kind, Kind::Hemispherical | Kind::Angular | Kind::Planispheric));
        let seen = |i: &usize| {
            let (x, y) = ((i % self.width) as f64 + 0.5, (i / self.width) as f64 + 0.5);
            let (u, v) = (x / self.width as f64, 1.0 - y / self.height as f64);
            let within = |view: View| {
                let least = (0.5 * view.horizontal_deg.max(view.vertical_deg)).to_radians().cos();
                view.direction(u, v).is_some_and(|d| d[2] >= least)
            };
            self.all[*i].is_finite() && circle.is_none_or(within)
        };
        let by = |a: &usize, b: &usize| self.all[*a].total_cmp(&self.all[*b]);
        let places = || (0..self.all.len()).filter(seen);
        let first_of_max = places().max_by(|a, b| by(a, b).then(b.cmp(a)));
        let ends = [places().min_by(by), first_of_max];
        ends.into_iter().flatten().map(|i| (f64::from(self.all[i]), i % self.width, i / self.width)).collect()
    }
}
