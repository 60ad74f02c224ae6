//! Where light connections go: what a light's spectrum makes of a path's throughput.

use crate::Result;
use crate::render::lanes::{Diagonal, Lanes, Throughput};
use crate::spectral::{Observer, Sampling, Spectrum};
use crate::units::K_M;

/// Turns connections into a pixel's components.
pub trait Film<T: Throughput>: Send + Sync {
    /// A pixel's sum.
    type Pixel: Clone + Send;

    /// Components of a pixel.
    fn components(&self) -> usize;

    /// A pixel without light.
    fn black(&self) -> Self::Pixel;

    /// Adds `weight` times what light number `light` sends along `path`.
    fn connect(&self, pixel: &mut Self::Pixel, light: usize, weight: f32, path: &T);

    /// Adds one pixel to another.
    fn merge(&self, pixel: &mut Self::Pixel, other: &Self::Pixel);

    /// The components, each times `factor`.
    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]);
}

/// Spectral radiance, a component a bin or wavelength: W/sr/m2/nm.
pub struct Bands<const G: usize> {
    emission: Vec<Lanes<G>>,
    count: usize,
}

impl<const G: usize> Bands<G> {
    /// Each light's radiance sampled as the picture is.
    pub fn new(lights: &[&Spectrum], sampling: &Sampling) -> Self {
        let emission = lights.iter().map(|l| Lanes::from_values(&sampling.sample(l))).collect();
        Bands { emission, count: sampling.count() }
    }
}

impl<const G: usize> Film<Diagonal<G>> for Bands<G> {
    type Pixel = [[f64; 8]; G];

    fn components(&self) -> usize {
        self.count
    }

    fn black(&self) -> Self::Pixel {
        [[0.0; 8]; G]
    }

    #[inline(always)]
    fn connect(&self, pixel: &mut Self::Pixel, light: usize, weight: f32, path: &Diagonal<G>) {
        let emission = &self.emission[light];
        for (g, sums) in pixel.iter_mut().enumerate() {
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum += f64::from(weight * (path.0.0[g][i] * emission.0[g][i]));
            }
        }
    }

    fn merge(&self, pixel: &mut Self::Pixel, other: &Self::Pixel) {
        pixel.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(a, b)| *a += b);
    }

    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]) {
        out.iter_mut().zip(pixel.as_flattened()).for_each(|(o, p)| *o = (p * factor) as f32);
    }
}

/// XYZ in cd/m2 by one 3 x K matrix a light, the light's spectrum at its finest table folded into it: a spiky lamp needs no
/// more wavelengths than daylight, only reflectances are sampled.
pub struct Tristimulus<const G: usize> {
    weights: Vec<[Lanes<G>; 3]>,
}

impl<const G: usize> Tristimulus<G> {
    /// Weights for each light over `range_nm`.
    pub fn new(lights: &[&Spectrum], sampling: &Sampling, range_nm: (f64, f64), observer: &Observer) -> Result<Self> {
        let each = |light: &&Spectrum| {
            let rows = light_weights(light, sampling, range_nm, observer)?;
            Ok(rows.each_ref().map(|r| Lanes::from_values(r)))
        };
        Ok(Tristimulus { weights: lights.iter().map(each).collect::<Result<_>>()? })
    }
}

/// Rows X, Y, Z of the matrix that gives the XYZ (cd/m2) of `light` seen by way of a reflectance with these samples.
///
/// The integrand light x CMF is taken as linear between the points of either table. A bin's reflectance stands for the
/// whole bin; a point's for its hat, the outermost points for all beyond them.
pub fn light_weights(
    light: &Spectrum,
    sampling: &Sampling,
    (from_nm, to_nm): (f64, f64),
    observer: &Observer,
) -> Result<[Vec<f64>; 3]> {
    let mut rows = Vec::new();
    for cmf in &observer.cmf {
        let mut grid: Vec<f64> = Vec::new();
        for s in [light, cmf] {
            if let Spectrum::Table(points) = s {
                grid.extend(points.iter().map(|p| p.0));
            }
        }
        grid.extend([from_nm, to_nm]);
        grid.retain(|nm| (from_nm..=to_nm).contains(nm));
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        let product: Vec<(f64, f64)> = grid.iter().map(|nm| (*nm, K_M * light.at(*nm) * cmf.at(*nm))).collect();
        rows.push(match sampling {
            Sampling::Bins { .. } => {
                let product = Spectrum::from_points(product)?;
                (0..sampling.count())
                    .map(|i| {
                        let (a, b) = sampling.edges(i);
                        product.integral(a, b)
                    })
                    .collect()
            }
            Sampling::Points(nm) => hat_weights(&product, nm),
        });
    }
    let [x, y, z] = <[Vec<f64>; 3]>::try_from(rows).unwrap_or_default();
    Ok([x, y, z])
}

/// Integrals of `product` under the hat of each point, by two-point Gauss rules between all breaks.
fn hat_weights(product: &[(f64, f64)], nm: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..nm.len()).collect();
    order.sort_by(|a, b| nm[*a].total_cmp(&nm[*b]));
    let mut weights = vec![0.0; nm.len()];
    for pair in product.windows(2) {
        let ((a, va), (b, vb)) = (pair[0], pair[1]);
        let mut breaks = vec![a];
        breaks.extend(order.iter().map(|i| nm[*i]).filter(|x| *x > a && *x < b));
        breaks.push(b);
        for part in breaks.windows(2) {
            let (middle, half) = (0.5 * (part[0] + part[1]), 0.5 * (part[1] - part[0]));
            for x in [middle - half / 3f64.sqrt(), middle + half / 3f64.sqrt()] {
                let mass = half * (va + (vb - va) * (x - a) / (b - a));
                let above = order.partition_point(|i| nm[*i] < x);
                match (above.checked_sub(1).map(|k| order[k]), order.get(above)) {
                    (Some(i), Some(&j)) => {
                        let f = (x - nm[i]) / (nm[j] - nm[i]);
                        weights[i] += mass * (1.0 - f);
                        weights[j] += mass * f;
                    }
                    (Some(i), None) => weights[i] += mass,
                    (None, Some(&j)) => weights[j] += mass,
                    (None, None) => {}
                }
            }
        }
    }
    weights
}

impl<const G: usize> Film<Diagonal<G>> for Tristimulus<G> {
    type Pixel = [f64; 3];

    fn components(&self) -> usize {
        3
    }

    fn black(&self) -> [f64; 3] {
        [0.0; 3]
    }

    #[inline(always)]
    fn connect(&self, pixel: &mut [f64; 3], light: usize, weight: f32, path: &Diagonal<G>) {
        for (sum, row) in pixel.iter_mut().zip(&self.weights[light]) {
            *sum += f64::from(weight * row.dot(&path.0));
        }
    }

    fn merge(&self, pixel: &mut [f64; 3], other: &[f64; 3]) {
        pixel.iter_mut().zip(other).for_each(|(a, b)| *a += b);
    }

    fn develop(&self, pixel: &[f64; 3], factor: f64, out: &mut [f32]) {
        out.iter_mut().zip(pixel).for_each(|(o, p)| *o = (p * factor) as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::builtin;

    #[test]
    fn a_white_surface_shows_the_lamp_however_it_is_sampled() {
        let observer = Observer::cie1931().unwrap();
        for name in ["illuminant_A", "illuminant_D65", "illuminant_FL11"] {
            let lamp = builtin::spectrum(name).unwrap();
            let want = observer.integrate(&lamp).map(|v| v * K_M);
            for sampling in [
                Sampling::bins(360.0, 830.0, 16).unwrap(),
                Sampling::bins(360.0, 830.0, 80).unwrap(),
                Sampling::points(vec![450.0, 550.0, 650.0]).unwrap(),
                Sampling::points(vec![650.0, 550.0]).unwrap(),
            ] {
                let rows = light_weights(&lamp, &sampling, (360.0, 830.0), &observer).unwrap();
                for (row, want) in rows.iter().zip(want) {
                    let got: f64 = row.iter().sum();
                    assert!((got / want - 1.0).abs() < 2e-4, "{name} {sampling:?}: {got} for {want}");
                }
            }
        }
    }
}
