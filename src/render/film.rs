//! Where light arrives: what a pixel makes of a light's spectrum and what the way left of it.

use crate::render::beam::Beam;
use crate::render::lanes::{GROUP, Lanes};
use crate::spectral::spectrum::{breaks, gauss};
use crate::spectral::{Observer, Sampling, Spectrum};

/// Turns light into a pixel's components.
pub trait Film<const G: usize>: Send + Sync {
    /// A pixel's sum.
    type Pixel: Clone + Send;

    /// Components of a pixel.
    fn components(&self) -> usize;

    /// A pixel without light.
    fn black(&self) -> Self::Pixel;

    /// Adds the spectrum of light number `light` times a factor a wavelength.
    fn expose<B: Beam<G>>(&self, pixel: &mut Self::Pixel, light: u32, beam: &B);

    /// Luminance of a sum, for its error: cd/m2, or, of bands without visible light, any positive sum of them.
    fn luminance(&self, pixel: &Self::Pixel) -> f64;

    /// Adds another sum.
    fn add(&self, pixel: &mut Self::Pixel, other: &Self::Pixel);

    /// The components, each times `factor`.
    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]);
}

/// Spectral radiance, a component a bin or wavelength: W/sr/m2/nm.
pub struct Bands<const G: usize> {
    emission: Vec<Lanes<G>>,
    count: usize,
    luminance: Vec<f64>,
}

impl<const G: usize> Bands<G> {
    /// Each light's radiance sampled as the picture is.
    pub fn new(lights: &[&Spectrum], sampling: &Sampling, observer: &Observer) -> Self {
        let emission = lights.iter().map(|l| Lanes::from_values(&sampling.sample(l))).collect();
        let [_, y, _] = sampling.xyz_weights(observer);
        // Beyond the visible every band counts alike.
        let visible = y.iter().any(|w| *w > 0.0);
        let luminance = y.iter().map(|w| if visible { w.max(0.0) } else { 1.0 }).collect();
        Bands { emission, count: sampling.count(), luminance }
    }
}

impl<const G: usize> Film<G> for Bands<G> {
    type Pixel = [[f64; GROUP]; G];

    fn components(&self) -> usize {
        self.count
    }

    fn black(&self) -> Self::Pixel {
        [[0.0; GROUP]; G]
    }

    #[inline(always)]
    fn expose<B: Beam<G>>(&self, pixel: &mut Self::Pixel, light: u32, beam: &B) {
        add(pixel, beam.intensity(), &self.emission[light as usize]);
    }

    fn luminance(&self, pixel: &Self::Pixel) -> f64 {
        self.luminance.iter().zip(pixel.as_flattened()).map(|(w, p)| w * p).sum()
    }

    fn add(&self, pixel: &mut Self::Pixel, other: &Self::Pixel) {
        pixel.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(a, b)| *a += b);
    }

    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]) {
        out.iter_mut().zip(pixel.as_flattened()).for_each(|(o, p)| *o = (p * factor) as f32);
    }
}

#[inline(always)]
fn add<const G: usize>(sums: &mut [[f64; GROUP]; G], factors: &Lanes<G>, light: &Lanes<G>) {
    for ((sums, factors), light) in sums.iter_mut().zip(&factors.0).zip(&light.0) {
        for i in 0..GROUP {
            sums[i] += f64::from(factors[i] * light[i]);
        }
    }
}

/// Stokes vectors of spectral radiance: I, Q, U and V of the first wavelength, then of the second.
pub struct StokesBands<const G: usize>(pub Bands<G>);

impl<const G: usize> Film<G> for StokesBands<G> {
    type Pixel = [[[f64; GROUP]; G]; 4];

    fn components(&self) -> usize {
        4 * self.0.count
    }

    fn black(&self) -> Self::Pixel {
        [[[0.0; GROUP]; G]; 4]
    }

    #[inline(always)]
    fn expose<B: Beam<G>>(&self, pixel: &mut Self::Pixel, light: u32, beam: &B) {
        let light = &self.0.emission[light as usize];
        match beam.stokes() {
            Some(vector) => pixel.iter_mut().zip(vector).for_each(|(sums, lanes)| add(sums, lanes, light)),
            None => add(&mut pixel[0], beam.intensity(), light),
        }
    }

    fn luminance(&self, pixel: &Self::Pixel) -> f64 {
        self.0.luminance(&pixel[0])
    }

    fn add(&self, pixel: &mut Self::Pixel, other: &Self::Pixel) {
        pixel.iter_mut().zip(other).for_each(|(a, b)| self.0.add(a, b));
    }

    fn develop(&self, pixel: &Self::Pixel, factor: f64, out: &mut [f32]) {
        for (i, out) in out.chunks_exact_mut(4).enumerate() {
            out.iter_mut().zip(pixel).for_each(|(o, p)| *o = (p.as_flattened()[i] * factor) as f32);
        }
    }
}

/// R responses, such as XYZ in cd/m2, by one R x K matrix a light, the light's spectrum at its finest table folded into it: a
/// spiky lamp needs no more wavelengths than daylight, only reflectances are sampled. The second response is the luminance.
pub struct Responses<const G: usize, const R: usize> {
    weights: Vec<[Lanes<G>; R]>,
}

impl<const G: usize, const R: usize> Responses<G, R> {
    /// Weights for each light over `range_nm`.
    pub fn new(lights: &[&Spectrum], sampling: &Sampling, range_nm: (f64, f64), responses: &[Spectrum; R]) -> Self {
        let each = |light: &&Spectrum| {
            responses.each_ref().map(|r| Lanes::from_values(&light_weights(light, sampling, range_nm, r)))
        };
        Responses { weights: lights.iter().map(each).collect() }
    }

    /// By weights that are known: [light][response][wavelength].
    pub fn of(weights: &[[Vec<f64>; R]]) -> Self {
        Responses { weights: weights.iter().map(|w| w.each_ref().map(|w| Lanes::from_values(w))).collect() }
    }
}

/// Weights that give the integral of `light` x `response` seen by way of a reflectance with these samples, over the
/// wavelengths that count.
///
/// A bin's reflectance stands for the whole bin; a point's for its hat, the outermost points for all beyond them. The
/// integrals of light x response x hat are exact.
pub fn light_weights(light: &Spectrum, sampling: &Sampling, range_nm: (f64, f64), response: &Spectrum) -> Vec<f64> {
    match sampling {
        Sampling::Bins { count, .. } => {
            let bin = |i| {
                let (a, b) = sampling.edges(i);
                light.product_integral(response, a.max(range_nm.0), b.min(range_nm.1))
            };
            (0..*count).map(bin).collect()
        }
        Sampling::Points(nm) => hat_weights(light, response, nm, range_nm),
    }
}

/// Integrals of light x response under the hat of each point.
fn hat_weights(light: &Spectrum, response: &Spectrum, nm: &[f64], range_nm: (f64, f64)) -> Vec<f64> {
    let mut order: Vec<usize> = (0..nm.len()).collect();
    order.sort_by(|a, b| nm[*a].total_cmp(&nm[*b]));
    // Between neighbouring nodes a and b the reflectance is (1 - f) of a and f of b; beyond the ends it is the end's.
    let product = |x: f64| light.at(x) * response.at(x);
    let all = breaks(&[light, response], range_nm.0, range_nm.1);
    let between = |from: f64, to: f64| {
        let mut part: Vec<f64> = all.iter().copied().filter(|x| *x > from && *x < to).collect();
        let (low, high) = (from.max(all.first().copied().unwrap_or(0.0)), to.min(all.last().copied().unwrap_or(0.0)));
        part.insert(0, low);
        part.push(high);
        if low < high { part } else { Vec::new() }
    };
    let mut weights = vec![0.0; nm.len()];
    let (first, last) = (order[0], order[order.len() - 1]);
    weights[first] += gauss(&between(0.0, nm[first]), product);
    weights[last] += gauss(&between(nm[last], f64::INFINITY), product);
    for pair in order.windows(2) {
        let (a, b) = (nm[pair[0]], nm[pair[1]]);
        let part = between(a, b);
        let upper = gauss(&part, |x| product(x) * (x - a) / (b - a));
        weights[pair[0]] += gauss(&part, product) - upper;
        weights[pair[1]] += upper;
    }
    weights
}

impl<const G: usize, const R: usize> Film<G> for Responses<G, R> {
    type Pixel = [f64; R];

    fn components(&self) -> usize {
        R
    }

    fn black(&self) -> [f64; R] {
        [0.0; R]
    }

    #[inline(always)]
    fn expose<B: Beam<G>>(&self, pixel: &mut [f64; R], light: u32, beam: &B) {
        for (sum, row) in pixel.iter_mut().zip(&self.weights[light as usize]) {
            *sum += f64::from(row.dot(beam.intensity()));
        }
    }

    fn luminance(&self, pixel: &[f64; R]) -> f64 {
        pixel[1]
    }

    fn add(&self, pixel: &mut [f64; R], other: &[f64; R]) {
        pixel.iter_mut().zip(other).for_each(|(a, b)| *a += b);
    }

    fn develop(&self, pixel: &[f64; R], factor: f64, out: &mut [f32]) {
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
        let tables = ["illuminant_A", "illuminant_D65", "illuminant_FL11"].map(|n| builtin::spectrum(n).unwrap());
        let narrow = [(550.5, 559.5), (555.0, 555.001), (555.2, 555.7)]
            .map(|(a, b)| Spectrum::from_points(vec![(a, 1.0), (b, 1.0)]).unwrap());
        for lamp in tables.iter().chain(&narrow) {
            let want = observer.integrate(lamp);
            for sampling in [
                Sampling::bins(360.0, 830.0, 16).unwrap(),
                Sampling::bins(360.0, 830.0, 80).unwrap(),
                Sampling::points(vec![450.0, 550.0, 650.0]).unwrap(),
                Sampling::points(vec![650.0, 550.0]).unwrap(),
            ] {
                for (cmf, want) in observer.cmf.iter().zip(want) {
                    let row = light_weights(lamp, &sampling, (360.0, 830.0), cmf);
                    let got: f64 = row.iter().sum::<f64>();
                    assert!((got / want - 1.0).abs() < 1e-9, "{sampling:?}: {got} for {want}");
                }
            }
        }
    }
}
