//! Relative colours for renderers of three channels: the dominant source is white, materials and other sources are what
//! they are beside it, and the picture gets the source's colour back at the end [Ward 2001, "Relative Color
//! Approximation"].
//!
//! The paper gives materials their absolute RGB under a source "modeled as pure white". A second bounce then multiplies
//! by the source's tint once more. Here materials are divided by the source's white, so a white surface is (1,1,1)
//! however often light meets it; the paper's wording stays as [`Relative::literal`]. Direct light from the dominant source
//! is exact either way.

use super::{Cat, Mat3, Primaries, Xy, adapt, difference};
use crate::spectral::{Observer, Spectrum};
use crate::{Error, Result, invalid};

/// Components of the dominant source below this make its quotients noise (its Y is 1).
const SMALLEST_WHITE: f64 = 1e-3;

/// Spectra on the observer's 1 nm grid: products of reflectances are products of vectors.
pub struct Grid {
    nm: Vec<f64>,
    cmf: [Vec<f64>; 3],
}

impl Grid {
    /// The grid of the CIE 1931 observer.
    pub fn cie1931() -> Result<Grid> {
        let observer = Observer::cie1931()?;
        let Spectrum::Table(points) = &observer.cmf[1] else { return invalid!("the observer is not a table") };
        let nm: Vec<f64> = points.iter().map(|p| p.0).collect();
        let cmf = observer.cmf.each_ref().map(|c| nm.iter().map(|l| c.at(*l)).collect());
        Ok(Grid { nm, cmf })
    }

    /// The values of a spectrum on the grid.
    pub fn sample(&self, s: &Spectrum) -> Vec<f64> {
        self.nm.iter().map(|l| s.at(*l)).collect()
    }

    /// Eq. (3) and (4): XYZ of light that met these reflectances one after the other, in the unit in which the source on
    /// a perfect diffuser has Y = 1. None means the source itself.
    pub fn xyz(&self, source: &[f64], reflectances: &[&[f64]]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        let mut white = 0.0;
        for (i, s) in source.iter().enumerate() {
            let light = reflectances.iter().fold(*s, |light, r| light * r[i]);
            for (sum, cmf) in sums.iter_mut().zip(&self.cmf) {
                *sum += cmf[i] * light;
            }
            white += self.cmf[1][i] * s;
        }
        sums.map(|sum| sum / white)
    }
}

/// A working space with the colour of its dominant source.
#[derive(Clone, Copy, Debug)]
pub struct Relative {
    from_xyz: Mat3,
    to_xyz: Mat3,
    /// (Rw, Gw, Bw): the dominant source in the working space, Y = 1.
    pub white: [f64; 3],
    /// Materials keep their absolute RGB, and the picture is not multiplied: the paper's wording.
    pub literal: bool,
}

impl Relative {
    /// A working space for a dominant source of these XYZ. Errors: primaries without area, a source that they can hardly
    /// make.
    ///
    /// ```
    /// use luxpipe::color::{Primaries, Xy, relative::Relative};
    /// let a = Xy { x: 0.4476, y: 0.4074 }.xyz();
    /// let r = Relative::new(&Primaries::BT709, a, false).unwrap();
    /// assert!(r.material(a).iter().all(|c| (c - 1.0).abs() < 1e-12));
    /// ```
    pub fn new(space: &Primaries, dominant: [f64; 3], literal: bool) -> Result<Relative> {
        let spans = |m: Option<Mat3>| m.ok_or_else(|| Error::Usage("--space: these primaries span no area".into()));
        let (from_xyz, to_xyz) = (spans(space.from_xyz())?, spans(space.to_xyz())?);
        let white = from_xyz.apply(dominant);
        if let Some(small) = white.iter().find(|c| c.is_nan() || **c < SMALLEST_WHITE) {
            return invalid!(
                "the dominant source has a component of {small:.4} in {space}; relative colours need it above 0.001, choose a wider --space"
            );
        }
        Ok(Relative { from_xyz, to_xyz, white, literal })
    }

    /// What a material of these XYZ under the dominant source (Y = 1 for the perfect diffuser) is to the renderer.
    pub fn material(&self, xyz: [f64; 3]) -> [f64; 3] {
        if self.literal { self.from_xyz.apply(xyz) } else { self.source(xyz) }
    }

    /// What a source is to the renderer: (Rs/Rw, Gs/Gw, Bs/Bw).
    pub fn source(&self, xyz: [f64; 3]) -> [f64; 3] {
        let rgb = self.from_xyz.apply(xyz);
        [0, 1, 2].map(|i| rgb[i] / self.white[i])
    }

    /// From the rendered picture to XYZ: times (Rw, Gw, Bw), then by the primaries.
    pub fn finish(&self) -> Mat3 {
        if self.literal { self.to_xyz } else { self.to_xyz.times(&Mat3::diagonal(self.white)) }
    }
}

/// How far colours are from those of a full spectral calculation, Delta E 2000.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// How many colours.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// What 95 % stay below.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// The error of relative colours over all products of `bounces` materials (each set of them once, repetition allowed) lit
/// by `source`, rendered in the relative colours of `dominant`; both pictures adapted from `white` to `to`, seen against
/// `to` at the luminance of the perfect diffuser. `None` without materials.
pub fn spread(
    grid: &Grid,
    relative: &Relative,
    [source, dominant]: [&[f64]; 2],
    materials: &[Vec<f64>],
    bounces: usize,
    (cat, white, to): (Cat, Xy, Xy),
) -> Result<Option<Spread>> {
    let adapt = adapt::von_kries(cat, white, to, 1.0)?;
    let finish = relative.finish();
    let light = relative.source(grid.xyz(source, &[]));
    let colours: Vec<[f64; 3]> = materials.iter().map(|m| relative.material(grid.xyz(dominant, &[m]))).collect();
    let mut errors = Vec::new();
    let mut chosen = vec![0; bounces];
    while let Some(top) = chosen.first().copied().filter(|i| *i < materials.len()) {
        let reflectances: Vec<&[f64]> = chosen.iter().map(|i| &materials[*i][..]).collect();
        let truth = adapt.apply(grid.xyz(source, &reflectances));
        let rgb = chosen.iter().fold(light, |rgb, i| [0, 1, 2].map(|c| rgb[c] * colours[*i][c]));
        let got = adapt.apply(finish.apply(rgb));
        errors.push(difference::delta_e_2000(truth, got, to.xyz()));
        // The next multiset: indices never rise from left to right.
        let at = (1..bounces).rev().find(|k| chosen[*k] < chosen[*k - 1]);
        match at {
            Some(k) => {
                chosen[k] += 1;
                chosen[k + 1..].fill(0);
            }
            None => {
                chosen.fill(0);
                chosen[0] = top + 1;
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let Some(max) = errors.last().copied() else { return Ok(None) };
    let count = errors.len();
    let p95 = errors[((count - 1) as f64 * 0.95).round() as usize];
    Ok(Some(Spread { count, mean: errors.iter().sum::<f64>() / count as f64, p95, max }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n + k - 1 over k products: 4, 10, 20 for four materials; white surfaces never err.
    #[test]
    fn every_product_once_and_white_is_exact() {
        let grid = Grid::cie1931().unwrap();
        let lamp = grid.sample(&crate::spectral::builtin::spectrum("A").unwrap());
        let white = vec![vec![1.0; lamp.len()]; 4];
        let xy = Xy::of(grid.xyz(&lamp, &[])).unwrap();
        let relative = Relative::new(&Primaries::BT709, grid.xyz(&lamp, &[]), false).unwrap();
        for (bounces, count) in [(1, 4), (2, 10), (3, 20)] {
            let views = (Cat::Cmccat2000, xy, Xy::D65);
            let s = spread(&grid, &relative, [&lamp, &lamp], &white, bounces, views).unwrap().unwrap();
            assert_eq!(s.count, count);
            assert!(s.max < 1e-9, "{s:?}");
        }
    }
}
