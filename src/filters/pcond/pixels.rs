//! From the light of the world to the light of the display, pixel by pixel, and to what a device is sent.

use crate::color::gamut::{self, Limit};
use crate::color::{Cat, Mat3, Primaries, Xy, adapt, matrix};
use crate::display::macbeth::Correction;
use crate::simd::{self, GROUP};
use crate::stream::{Block, Components, Header, Picture, picture};
use crate::tone::curve::Table;
use crate::tone::fovea::{Field, Stretch};
use crate::{Error, Result, invalid, parallel};

use super::eye::Eye;

/// What turns a luminance into a factor for the pixel's components.
pub enum Factor {
    /// The same for all.
    Fixed(f32),
    /// By luminance.
    Table(Table),
}

impl Factor {
    #[inline(always)]
    fn of<const M: usize>(&self, luminances_cd_m2: &[f32; M]) -> [f32; M] {
        match self {
            Factor::Fixed(f) => [*f; M],
            Factor::Table(t) => t.factors(luminances_cd_m2),
        }
    }
}

/// Maps every pixel; with `fits` those whose colour the medium cannot make at its luminance are darkened until it can.
pub fn mapped(
    input: Box<dyn Picture>,
    header: Header,
    eye: Eye,
    factor: Factor,
    fits: Option<Mat3>,
) -> Box<dyn Picture> {
    if input.header().ncomp == 3 && eye.is_plain() && fits.is_none() {
        return picture::map_on_all_threads(input, header, move |pixels| {
            matrix::for_planes(
                pixels,
                #[inline(always)]
                |p| {
                    let factors = factor.of(&p[1]);
                    for plane in p.iter_mut() {
                        for i in 0..GROUP {
                            // A colour without light, or one that is not a number, is black.
                            plane[i] = if plane[i].abs() < f32::INFINITY { plane[i] * factors[i] } else { 0.0 };
                        }
                    }
                },
            );
        });
    }
    let ncomp = input.header().ncomp;
    let fits = fits.map(|m| m.to_f32());
    if ncomp == 3 {
        return picture::map_on_all_threads(input, header, move |pixels| {
            matrix::for_planes(
                pixels,
                #[inline(always)]
                |p| map_group(p, &eye, &factor, fits.as_ref()),
            );
        });
    }
    picture::map_across(input, header, move |from, to| {
        for (pixel, out) in from.chunks_exact(ncomp).zip(to.chunks_exact_mut(3)) {
            let (luminance, shown) = eye.sees(pixel);
            let [mut factor] = factor.of(&[luminance]);
            if let Some(m) = &fits {
                let largest = matrix::multiply(m, shown).into_iter().fold(0f32, f32::max);
                factor = if largest * factor > 1.0 { 1.0 / largest } else { factor };
            }
            let all = shown.map(|x| x * factor);
            out.copy_from_slice(&if all.iter().all(|x| x.is_finite()) { all } else { [0.0; 3] });
        }
    })
}

/// Maps a group of XYZ, as [`mapped`].
#[inline(always)]
fn map_group(p: &mut [[f32; GROUP]; 3], eye: &Eye, factor: &Factor, fits: Option<&[[f32; 3]; 3]>) {
    let (luminances, shown) = eye.sees_group(p);
    let mut factors = factor.of(&luminances);
    if let Some(m) = fits {
        let rgb = matrix::multiply_planes(m, &shown);
        for i in 0..GROUP {
            let largest = rgb[0][i].max(0.0).max(rgb[1][i]).max(rgb[2][i]);
            factors[i] = if largest * factors[i] > 1.0 { 1.0 / largest } else { factors[i] };
        }
    }
    for i in 0..GROUP {
        let all = [shown[0][i] * factors[i], shown[1][i] * factors[i], shown[2][i] * factors[i]];
        let finite = all[0].abs() < f32::INFINITY && all[1].abs() < f32::INFINITY && all[2].abs() < f32::INFINITY;
        (0..3).for_each(|k| p[k][i] = if finite { all[k] } else { 0.0 });
    }
}

/// Light scattered in the eye, over a picture of XYZ, or XYZ and scotopic luminance.
pub struct Veiled {
    input: Box<dyn Picture>,
    header: Header,
    /// X, Y, Z, V added, and the share lost.
    veil: Field<5>,
    row: usize,
}

/// A picture under a veil.
pub fn veiled(input: Box<dyn Picture>, veil: Field<5>) -> Box<dyn Picture> {
    let header = input.header().clone();
    Box::new(Veiled { input, header, veil, row: 0 })
}

impl Picture for Veiled {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        let (first, veil, n) = (self.row, &self.veil, self.header.ncomp);
        let floats = self.header.scanline_floats();
        parallel::for_pieces(&mut block.data, floats, |row, piece| {
            for (i, line) in piece.chunks_exact_mut(floats).enumerate() {
                let values = veil.scanline(first + row + i);
                simd::wide(
                    #[inline(always)]
                    || match n {
                        3 => add_veil::<3>(veil, &values, line),
                        4 => add_veil::<4>(veil, &values, line),
                        _ => {}
                    },
                );
            }
        });
        self.row += block.rows;
        Ok(more)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.row = 0;
        self.input.rewind()
    }
}

/// Puts the veil over a scanline.
#[inline(always)]
fn add_veil<const N: usize>(veil: &Field<5>, values: &[[f32; 5]], line: &mut [f32]) {
    let line = line.as_chunks_mut::<N>().0;
    for Stretch { pixels, start, step, shares } in veil.along(values) {
        for (pixel, t) in line[pixels].iter_mut().zip(shares) {
            let lost = start[4] + t * step[4];
            for c in 0..N {
                pixel[c] += start[c] + t * step[c] - lost * pixel[c];
            }
        }
    }
}

/// RGB of a device's primaries: the white changed by sharpened sensors as Radiance does, and what they cannot make moved toward
/// the grey of equal luminance.
pub fn device(input: Box<dyn Picture>, to: Primaries) -> Result<Box<dyn Picture>> {
    let span = || Error::Usage("-p: these primaries span no area".into());
    let white = input.header().white.unwrap_or(Xy::E);
    let change = adapt::von_kries(Cat::Sharp, white, to.white, 1.0)?;
    let m = to.from_xyz().ok_or_else(span)?.times(&change).to_f32();
    let y = to.to_xyz().ok_or_else(span)?.0[1].map(|x| x as f32);
    let mut header = input.header().clone();
    header.become_tristimulus(Components::Rgb, header.units);
    header.primaries = Some(to);
    header.white = Some(to.white);
    Ok(picture::map_on_all_threads(input, header, move |pixels| {
        matrix::for_planes(
            pixels,
            #[inline(always)]
            |p| {
                *p = matrix::multiply_planes(&m, p);
                gamut::desaturate(p, &y, Limit::Unit);
            },
        );
    }))
}

/// Picture values by a correction of `macbethcal -c`.
pub fn corrected(input: Box<dyn Picture>, by: Correction) -> Result<Box<dyn Picture>> {
    if !by.printed {
        return invalid!("-f: a correction for a device comes from macbethcal -c; this one corrects scans");
    }
    let input = device(input, Primaries::RADIANCE)?;
    let header = input.header().clone();
    Ok(picture::map_on_all_threads(input, header, move |pixels| {
        for p in pixels.chunks_exact_mut(3) {
            let sent = by.sent([p[0], p[1], p[2]].map(f64::from));
            p.iter_mut().zip(sent).for_each(|(x, s)| *x = s as f32);
        }
    }))
}
