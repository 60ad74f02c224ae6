//! A picture of the surroundings: any that the filters read, longitude across and latitude down, as [`crate::scene::camera`]'s
//! panorama. Each pixel shines equally over its whole angle.
//!
//! Its XYZ become spectra by way of linear sRGB: three basis spectra [Mallett 2019] under D65, which give the picture's colours
//! back exactly. Colours beyond sRGB need a negative part of one of them.

use std::path::Path;

use glam::DVec3;

use crate::codec::{self, Reading};
use crate::color::Primaries;
use crate::notes::Notes;
use crate::photometry::environment::{Environment as Directions, Region};
use crate::scene::light::MOST_PARTS;
use crate::scene::light::environment::Surround;
use crate::scene::light::sky::{Axes, Drawn};
use crate::stream::meaning::Overrides;
use crate::stream::reader::Input;
use crate::stream::spool::Limits;
use crate::stream::tristimulus::tristimulus;
use crate::stream::{Block, upright};
use crate::{Error, Result, invalid};

/// Most pixels: 12 bytes each.
const MOST_PIXELS: usize = 1 << 28;
/// Rows of the grid that directions are drawn by, at most; columns are twice as many.
const MOST_ROWS: usize = 1024;
const EVERYWHERE: f64 = 0.02;

/// A panorama that shines.
pub struct Panorama {
    width: usize,
    height: usize,
    /// Factors of the three spectra.
    pixels: Vec<[f32; 3]>,
    drawn: Drawn,
    integrals: [f64; 3],
}

impl Panorama {
    /// From a file, in axes whose second is the middle of the picture and whose third is up; radiances times `factor`.
    pub fn open(path: &Path, axes: Axes, factor: f64, notes: &Notes) -> Result<Panorama> {
        let (width, height, mut pixels) = read(path, notes)?;
        let luminance = pixels.iter().map(|p| factor as f32 * p[1]).collect::<Vec<_>>();
        let back = Primaries::BT709.to_xyz().and_then(|m| m.inverse());
        let back = back.ok_or_else(|| Error::Invalid("sRGB has no inverse".into()))?;
        for p in &mut pixels {
            *p = back.apply(p.map(|v| f64::from(v) * factor)).map(|v| v as f32);
        }
        let rows = height.min(MOST_ROWS);
        let place = |d: [f64; 3]| place(d, width, height);
        let directions =
            Directions::new(Region::Sphere, [rows, 2 * rows], EVERYWHERE, |d| f64::from(luminance[place(d)].max(0.0)))?;
        let mut integrals = [0.0; 3];
        for (i, sum) in integrals.iter_mut().enumerate() {
            let part = |d| f64::from(pixels[place(d)][i].max(0.0));
            *sum = Directions::new(Region::Sphere, [rows, 2 * rows], 0.0, part)?.integral();
        }
        Ok(Panorama { width, height, pixels, drawn: Drawn::new(axes, directions), integrals })
    }
}

/// The pixel of a direction in the picture's axes.
fn place([x, y, z]: [f64; 3], width: usize, height: usize) -> usize {
    use std::f64::consts::PI;
    let across = (0.5 + x.atan2(y) / (2.0 * PI)) * width as f64;
    let down = z.clamp(-1.0, 1.0).acos() / PI * height as f64;
    (down as usize).min(height - 1) * width + (across as usize).min(width - 1)
}

/// Width, height and XYZ in cd/m2.
fn read(path: &Path, notes: &Notes) -> Result<(usize, usize, Vec<[f32; 3]>)> {
    let limits = Limits { memory: 1 << 30, folder: std::env::temp_dir() };
    let reading = Reading { overrides: &Overrides::default(), limits: &limits, notes };
    let picture = codec::open(Input::open(Some(path))?, &reading)?;
    let mut picture = tristimulus(upright::upright(picture, &limits)?)?;
    let (width, height) = (picture.header().resolution.width, picture.header().resolution.height);
    if width == 0 || height == 0 || width.saturating_mul(height) > MOST_PIXELS {
        return invalid!("{width} x {height} pixels; expected 1 to {MOST_PIXELS} in all");
    }
    let mut pixels = Vec::with_capacity(width * height);
    let mut block = Block::default();
    while picture.next(&mut block)? {
        pixels.extend(block.data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
    }
    if let Some(i) = pixels.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return invalid!("pixel {}, {}: is not finite", i % width, i / width);
    }
    Ok((width, height, pixels))
}

impl Surround for Panorama {
    fn parts(&self) -> usize {
        3
    }

    fn factors(&self, direction: DVec3) -> [f32; MOST_PARTS] {
        let [a, b, c] = self.pixels[place(self.drawn.inward(direction), self.width, self.height)];
        [a, b, c, 0.0, 0.0, 0.0]
    }

    fn choose(&self, u: [f64; 2]) -> (DVec3, f64) {
        self.drawn.choose(u)
    }

    fn density(&self, direction: DVec3) -> f64 {
        self.drawn.density(direction)
    }

    fn integrals_sr(&self) -> [f64; MOST_PARTS] {
        let [a, b, c] = self.integrals;
        [a, b, c, 0.0, 0.0, 0.0]
    }
}
