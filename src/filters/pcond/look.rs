//! The first look at a picture: means of its cells, its luminances, its colours, and the veil that lies over them.

use std::sync::Arc;

use crate::Result;
use crate::simd;
use crate::stream::{Block, Picture};
use crate::tone::Histogram;
use crate::tone::fovea::{Attention, Cells, Field, Means, Samples};
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
    light: Light,
    pixels: Histogram,
    palette: Palette,
    /// Colours are asked for.
    colours: bool,
    /// Pixels whose luminance is not finite.
    pub lost: u64,
    row: Vec<f32>,
}

/// Light of the cells: all of it where it is to be scattered.
enum Light {
    Luminance(Means<1>),
    Xyz(Means<3>, Scattered),
    WithRods(Means<4>, Scattered),
}

/// How light is to scatter, and the pixels that are to be seen under it.
struct Scattered {
    scatter: Scatter,
    samples: Samples,
}

impl First {
    /// Nothing seen yet.
    pub fn new(ncomp: usize, cells: &Arc<Cells>, veil: Option<Scatter>, colours: bool) -> First {
        let scattered = veil.map(|scatter| Scattered { scatter, samples: Samples::new(cells) });
        let light = match (scattered, ncomp) {
            (None, _) => Light::Luminance(Means::new(cells)),
            (Some(s), 3) => Light::Xyz(Means::new(cells), s),
            (Some(s), _) => Light::WithRods(Means::new(cells), s),
        };
        First {
            ncomp,
            cells: cells.clone(),
            light,
            pixels: Histogram::default(),
            palette: Palette::default(),
            colours,
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
        let scattered = match &mut self.light {
            Light::Luminance(means) => {
                means.add(&self.row, 1);
                None
            }
            Light::Xyz(means, s) => {
                means.add(data, 3);
                Some(s)
            }
            Light::WithRods(means, s) => {
                means.add(data, self.ncomp);
                Some(s)
            }
        };
        if let Some(s) = scattered {
            s.samples.add(data, self.ncomp, &self.row);
            // The veil of Radiance's pcond lies over the cells' half of the histogram alone.
            if s.scatter != Scatter::Classic {
                return;
            }
        }
        self.pixels.add_all(&self.row);
        if self.colours {
            for pixel in data.chunks_exact(self.ncomp) {
                let (luminance, shown) = eye.sees(pixel);
                self.palette.add(luminance, shown);
            }
        }
    }

    /// What was seen, under the veil that the cells cast over each other where light scatters.
    pub fn seen(self, picture: Box<dyn Picture>, eye: &Eye) -> Seen {
        let mut palette = self.palette;
        let (means, veil, Scattered { scatter, samples }) = match self.light {
            Light::Luminance(means) => {
                let cells_cd_m2 = means.means().iter().map(|m| m[0].max(0.0)).collect();
                return Seen { picture, cells_cd_m2, pixels: self.pixels, palette };
            }
            Light::Xyz(means, s) => {
                let means = means.means();
                let veil = veil::over(s.scatter, &self.cells, &means, 1);
                let four = |v: &[[f64; 3]]| v.iter().map(|v| [v[0], v[1], v[2], 0.0]).collect::<Vec<[f64; 4]>>();
                (four(&means), Veil { light: four(&veil.light), lost: veil.lost }, s)
            }
            Light::WithRods(means, s) => {
                let means = means.means();
                let veil = veil::over(s.scatter, &self.cells, &means, 1);
                (means, veil, s)
            }
        };
        let under = |cell: usize, own: [f64; 4]| -> [f32; 4] {
            std::array::from_fn(|k| (own[k] * (1.0 - veil.lost[cell]) + veil.light[cell][k]) as f32)
        };
        let luminance = |cell: usize, own: [f64; 4]| eye.luminance_cd_m2(&under(cell, own));
        let cells_cd_m2 = (0..means.len()).map(|i| f64::from(luminance(i, means[i])).max(0.0)).collect();
        let mut pixels = Histogram::default();
        for (cell, own) in samples.picked() {
            let seen = under(*cell as usize, own.map(f64::from));
            pixels.add(eye.luminance_cd_m2(&seen), 1.0);
            if self.colours {
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
        let pixels = if scatter == Scatter::Classic { self.pixels } else { pixels };
        Seen { picture: pixels::veiled(picture, field), cells_cd_m2, pixels, palette }
    }
}

/// The histogram that pcond would take of a picture that nothing but its header is known of.
pub fn histogram(picture: Box<dyn Picture>) -> Result<Histogram> {
    let (eye, mut picture, _) = Eye::of(picture, None, false)?;
    let (cells, _) = Cells::of(picture.header());
    let mut first = First::new(picture.header().ncomp, &cells, None, false);
    let mut block = Block::default();
    while picture.next(&mut block)? {
        first.add(&block.data, &eye);
    }
    let seen = first.seen(picture, &eye);
    Ok(Attention::default().histogram(&cells, &seen.cells_cd_m2, &seen.pixels))
}
