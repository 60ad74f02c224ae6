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
        Components::Spectrum | Components::Stokes => {
            let weights = weights(input.header(), &Observer::cie1931()?)?;
            let mut header = input.header().clone();
            header.become_tristimulus(Components::Xyz, Units::CdM2);
            integrated(input, header, &weights)
        }
        other => invalid!("a picture of {other} has no colour; expected XYZ, RGB or a spectrum"),
    }
}

/// XYZ weights for each wavelength: the header's own matrix, or the observer's.
pub fn weights(header: &Header, observer: &Observer) -> Result<[Vec<f64>; 3]> {
    let sampling = |s: &Sampling| s.xyz_weights(observer);
    let own = header.xyz_matrix.clone().or_else(|| header.sampling.as_ref().map(sampling));
    own.ok_or_else(|| Error::Invalid("the picture lists no wavelengths".into()))
}

/// Weighted sums of each pixel's wavelengths, a row of weights a component of the result: Eq. (4) with the observer's
/// weights. Of Stokes vectors I counts. `header` is the result's, its `ncomp` set here.
pub fn integrated<W: AsRef<[f64]>>(
    input: Box<dyn Picture>,
    mut header: Header,
    weights: &[W],
) -> Result<Box<dyn Picture>> {
    let stride = if input.header().components == Components::Stokes { 4 } else { 1 };
    header.ncomp = weights.len();
    let row = |w: &W| w.as_ref().iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let rows: Vec<Vec<f32>> = weights.iter().map(row).collect();
    if rows.iter().flatten().any(|w| !w.is_finite()) {
        return invalid!("a weight of the spectrum's sum is too large for a float");
    }
    if let [x, y, z] = &rows[..] {
        let w: Vec<[f32; 3]> = (0..x.len()).map(|k| [x[k], y[k], z[k]]).collect();
        return Ok(picture::map_across(input, header, move |from, to| sum_weighted(&w, stride, from, to)));
    }
    Ok(picture::map_across(input, header, move |from, to| {
        for (pixel, out) in from.chunks_exact(rows[0].len() * stride).zip(to.chunks_exact_mut(rows.len())) {
            for (value, row) in out.iter_mut().zip(&rows) {
                *value = row.iter().zip(pixel.iter().step_by(stride)).map(|(w, x)| w * x).sum();
            }
        }
    }))
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
