//! Any picture as absolute XYZ: spectra by the observer, RGB by its primaries. `spec2xyz` is this and nothing else, and
//! every filter that works on XYZ begins with it.

use crate::simd;
use crate::spectral::{Observer, Sampling};
use crate::stream::writer::to_xyz;
use crate::stream::{Components, Header, Picture, Units, picture};
use crate::{Error, Result, invalid};

/// The picture as XYZ in the units it has (cd/m2 from spectra).
pub fn tristimulus(input: Box<dyn Picture>) -> Result<Box<dyn Picture>> {
    match input.header().components {
        Components::Xyz | Components::Rgb => to_xyz(input),
        Components::Spectrum => {
            let weights = weights(input.header(), &Observer::cie1931()?)?;
            integrated(input, weights, 1)
        }
        Components::Stokes => {
            let weights = weights(input.header(), &Observer::cie1931()?)?;
            integrated(input, weights, 4)
        }
        Components::Y => invalid!("a picture of luminance alone has no colour; expected XYZ, RGB or a spectrum"),
    }
}

/// XYZ weights for each wavelength: the header's own matrix, or the observer's.
pub fn weights(header: &Header, observer: &Observer) -> Result<[Vec<f64>; 3]> {
    let sampling = |s: &Sampling| s.xyz_weights(observer);
    let own = header.xyz_matrix.clone().or_else(|| header.sampling.as_ref().map(sampling));
    own.ok_or_else(|| Error::Invalid("the picture lists no wavelengths".into()))
}

/// Eq. (4) for each pixel; every `stride`-th component counts (4 for Stokes vectors, whose I it is).
fn integrated(input: Box<dyn Picture>, weights: [Vec<f64>; 3], stride: usize) -> Result<Box<dyn Picture>> {
    let mut header = input.header().clone();
    header.become_tristimulus(Components::Xyz, Units::CdM2);
    let w: Vec<[f32; 3]> = (0..weights[0].len()).map(|k| weights.each_ref().map(|row| row[k] as f32)).collect();
    Ok(picture::map_across(input, header, move |from, to| sum_weighted(&w, stride, from, to)))
}

/// Pixels summed side by side.
const TILE: usize = 16;

/// One weighted sum a pixel and channel. Tiles of pixels keep their sums in registers, and each component is read once.
fn sum_weighted(w: &[[f32; 3]], stride: usize, from: &[f32], to: &mut [f32]) {
    let n = w.len() * stride;
    simd::wide(
        #[inline(always)]
        || {
            for (pixels, out) in from.chunks(n * TILE).zip(to.chunks_mut(3 * TILE)) {
                let mut sums = [[0f32; 3]; TILE];
                for (sum, pixel) in sums.iter_mut().zip(pixels.chunks_exact(n)) {
                    for (weight, value) in w.iter().zip(pixel.iter().step_by(stride)) {
                        for c in 0..3 {
                            sum[c] += weight[c] * value;
                        }
                    }
                }
                for (pixel, sum) in out.chunks_exact_mut(3).zip(&sums) {
                    pixel.copy_from_slice(sum);
                }
            }
        },
    )
}
