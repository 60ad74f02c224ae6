//! The first look at a picture: means of its cells, its luminances, its colours, and the veil that lies over them.

use std::sync::Arc;

use crate::simd;
use crate::stream::Picture;
use crate::tone::Histogram;
use crate::tone::fovea::{Cells, Field, Means, Samples};
use crate::tone::palette::Palette;
use crate::tone::veil::{self, Scatter, Veil};

use super::eye::Eye;
use super::pixels;

/// What was seen.
pub struct Seen {
    /// The picture as it falls on the retina, to be read again.
    pub picture: Box<dyn Picture>,
    /// Mean luminance of each cell, cd/m2.
    pub cells_cd_m2: Vec<f64>,
    /// All luminances.
    pub pixels: Histogram,
    /// Colours, where they were asked for.
    pub palette: Palette,
}

impl Seen {
    /// A picture that was not looked at.
    pub fn nothing(picture: Box<dyn Picture>) -> Seen {
        Seen { picture, cells_cd_m2: Vec::new(), pixels: Histogram::default(), palette: Palette::default() }
    }
}

/// The look itself, block by block.
pub struct First {
    ncomp: usize,
    cells: Arc<Cells>,
    luminance: Means<1>,
    /// Of pictures to be veiled: light of the cells, and pixels to be veiled.
    light: Option<(Light, Samples)>,
    pixels: Histogram,
    palette: Option<Palette>,
    /// As Radiance's pcond, whose veil lies over the cells' half of the histogram alone.
    bare: bool,
    /// Pixels whose luminance is not finite.
    pub lost: u64,
    row: Vec<f32>,
}

enum Light {
    Xyz(Means<3>),
    WithRods(Means<4>),
}

impl First {
    /// Nothing seen yet.
    pub fn new(ncomp: usize, cells: &Arc<Cells>, veil: Option<Scatter>, colours: bool) -> First {
        let light = || match ncomp {
            3 => Light::Xyz(Means::new(cells)),
            _ => Light::WithRods(Means::new(cells)),
        };
        First {
            ncomp,
            cells: cells.clone(),
            luminance: Means::new(cells),
            light: veil.map(|_| (light(), Samples::new(cells))),
            bare: veil == Some(Scatter::Classic),
            pixels: Histogram::default(),
            palette: colours.then(Palette::default),
            lost: 0,
            row: Vec::new(),
        }
    }

    /// Takes in whole scanlines.
    pub fn add(&mut self, data: &[f32], eye: &Eye) {
        self.row.clear();
        eye.luminances_cd_m2(data, self.ncomp, &mut self.row);
        if !simd::all_within(&self.row, f32::MAX) {
            self.lost += self.row.iter().map(|y| u64::from(!y.is_finite())).sum::<u64>();
        }
        if let Some((light, samples)) = &mut self.light {
            match light {
                Light::Xyz(means) => means.add(data, 3),
                Light::WithRods(means) => means.add(data, self.ncomp),
            }
            samples.add(data, self.ncomp, &self.row);
            if self.bare {
                self.pixels.add_all(&self.row);
            }
            return;
        }
        self.luminance.add(&self.row, 1);
        self.pixels.add_all(&self.row);
        if let Some(palette) = &mut self.palette {
            for pixel in data.chunks_exact(self.ncomp) {
                let (luminance, shown) = eye.sees(pixel);
                palette.add(luminance, shown);
            }
        }
    }

    /// What was seen, without a veil.
    pub fn plain(self, picture: Box<dyn Picture>) -> Seen {
        Seen {
            picture,
            cells_cd_m2: self.luminance.means().iter().map(|m| m[0].max(0.0)).collect(),
            pixels: self.pixels,
            palette: self.palette.unwrap_or_default(),
        }
    }

    /// What was seen under the veil that the cells cast over each other.
    pub fn veiled(self, picture: Box<dyn Picture>, eye: &Eye, scatter: Scatter) -> Seen {
        let Some((light, samples)) = &self.light else { return self.plain(picture) };
        let (means, veil) = match light {
            Light::Xyz(means) => {
                let means = means.means();
                let veil = veil::over(scatter, &self.cells, &means, 1);
                let four = |v: &[[f64; 3]]| v.iter().map(|v| [v[0], v[1], v[2], 0.0]).collect::<Vec<[f64; 4]>>();
                (four(&means), Veil { light: four(&veil.light), lost: veil.lost })
            }
            Light::WithRods(means) => {
                let means = means.means();
                let veil = veil::over(scatter, &self.cells, &means, 1);
                (means, veil)
            }
        };
        let under = |cell: usize, own: [f64; 4]| -> [f32; 4] {
            std::array::from_fn(|k| (own[k] * (1.0 - veil.lost[cell]) + veil.light[cell][k]) as f32)
        };
        let luminance = |cell: usize, own: [f64; 4]| eye.luminance_cd_m2(&under(cell, own));
        let cells_cd_m2 = (0..means.len()).map(|i| f64::from(luminance(i, means[i])).max(0.0)).collect();
        let mut palette = self.palette;
        let mut pixels = Histogram::default();
        for (cell, own) in samples.picked() {
            let seen = under(*cell as usize, own.map(f64::from));
            pixels.add(eye.luminance_cd_m2(&seen), 1.0);
            if let Some(palette) = &mut palette {
                let (luminance, shown) = eye.sees(&seen[..self.ncomp]);
                palette.add(luminance, shown);
            }
        }
        // The darkest and the brightest pixel may not be among those picked.
        let veil_cd_m2 = |cell: usize| f64::from(eye.luminance_cd_m2(&veil.light[cell].map(|x| x as f32)));
        let (mut low, mut high) = (f64::MAX, 0f64);
        for (cell, (darkest, brightest)) in samples.ranges() {
            let seen = |y: f32| f64::from(y) * (1.0 - veil.lost[cell]) + veil_cd_m2(cell);
            (low, high) = (low.min(seen(darkest)), high.max(seen(brightest)));
        }
        if high > 0.0 {
            pixels.add(low as f32, 1.0);
            pixels.add(high as f32, 1.0);
        }
        let added = |i: usize| {
            let l = veil.light[i];
            [l[0], l[1], l[2], l[3], veil.lost[i]].map(|x| x as f32)
        };
        let field = Field::new(self.cells.clone(), (0..means.len()).map(added).collect());
        let pixels = if self.bare { self.pixels } else { pixels };
        Seen { picture: pixels::veiled(picture, field), cells_cd_m2, pixels, palette: palette.unwrap_or_default() }
    }
}
