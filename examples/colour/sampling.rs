//! What a coarse sampling of wavelengths costs in CIEDE2000: 24 patches, white errors included.

use luxpipe::spectral::{Observer, Sampling};

use super::{Chart, Light, differences, head, row, spectrum, statistics};

pub const LIGHTS: [&str; 8] = ["A", "C", "D50", "D65", "FL2", "FL11", "LED-B3", "LED-RGB1"];

/// Where the weights of Eq. (4) come from.
#[derive(Clone, Copy, PartialEq)]
pub enum Weights {
    /// The CMF at each point: a rectangle sum.
    AtPoints,
    /// [`Sampling::xyz_weights`]: what `spec2xyz` does. Source and reflectance are both sampled.
    Own,
    /// The same of source x CMF at 1 nm: only the reflectance is sampled.
    WithSource,
}

/// A way of carrying light and patches as N numbers.
pub struct Method {
    pub name: String,
    pub sampling: Sampling,
    pub weights: Weights,
}

impl Method {
    /// Points from 380 nm on, both ends included.
    pub fn points(step_nm: usize, weights: Weights) -> Method {
        let nm = (380..=780).step_by(step_nm).map(|nm| nm as f64).collect();
        Method::new(format!("points {step_nm} nm"), Sampling::points(nm), weights)
    }

    /// Equal bins.
    pub fn bins(step_nm: usize, weights: Weights) -> Method {
        Method::new(format!("bins {step_nm} nm"), Sampling::bins(380.0, 780.0, 400 / step_nm), weights)
    }

    fn new(name: String, sampling: luxpipe::Result<Sampling>, weights: Weights) -> Method {
        let suffix = match weights {
            Weights::AtPoints => "",
            Weights::Own if name.starts_with("bins") => "",
            Weights::Own => " linear between",
            Weights::WithSource => " source in weights",
        };
        Method { name: name + suffix, sampling: sampling.expect("valid"), weights }
    }

    /// CIEDE2000 of each patch against its 1 nm sum.
    pub fn errors(&self, chart: &Chart, light: &Light) -> Vec<f64> {
        let observer = |f: &dyn Fn(usize) -> f64| Observer {
            cmf: chart.cmf.each_ref().map(|c| spectrum(&(0..c.len()).map(|i| c[i] * f(i)).collect::<Vec<_>>())),
        };
        let plain = observer(&|_| 1.0);
        let sampled = || self.sampling.sample(&spectrum(&light.power));
        let (weights, power) = match self.weights {
            Weights::AtPoints => (plain.cmf.each_ref().map(|c| self.sampling.sample(c)), sampled()),
            Weights::Own => (self.sampling.xyz_weights(&plain), sampled()),
            Weights::WithSource => {
                (self.sampling.xyz_weights(&observer(&|i| light.power[i])), vec![1.0; self.sampling.count()])
            }
        };
        let xyz = |r: &[f64]| weights.each_ref().map(|w| (0..r.len()).map(|i| w[i] * power[i] * r[i]).sum::<f64>());
        let y = xyz(&vec![1.0; power.len()])[1];
        let seen: Vec<[f64; 3]> =
            chart.patches.iter().map(|r| xyz(&self.sampling.sample(&spectrum(r))).map(|v| v / y)).collect();
        differences(&light.patches, &seen, light.white)
    }
}

/// The methods of the page's first table.
pub fn methods() -> Vec<Method> {
    let steps = [5, 10, 20];
    let all = |f: fn(usize, Weights) -> Method, w| steps.map(|s| f(s, w));
    [
        all(Method::points, Weights::AtPoints),
        all(Method::points, Weights::Own),
        all(Method::bins, Weights::Own),
        all(Method::bins, Weights::WithSource),
        all(Method::points, Weights::WithSource),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Largest and mean over all lights, largest over A C D50 D65, then over FL2, FL11, LED-B3, LED-RGB1.
pub fn summary(method: &Method, chart: &Chart, lights: &[Light]) -> [f64; 7] {
    let each: Vec<Vec<f64>> = lights.iter().map(|l| method.errors(chart, l)).collect();
    let [mean, _, max] = statistics(each.concat());
    let worst = |from: usize, to: usize| statistics(each[from..to].concat())[2];
    [max, mean, worst(0, 4), worst(4, 5), worst(5, 6), worst(6, 7), worst(7, 8)]
}

/// Largest error under FL11 for N points in the middles of N equal parts, N bins, N bins with the source in the weights.
pub fn fl11(n: usize, chart: &Chart, light: &Light) -> [f64; 3] {
    let middles = (0..n).map(|i| 380.0 + (i as f64 + 0.5) * 400.0 / n as f64).collect();
    let bins = || Sampling::bins(380.0, 780.0, n);
    [
        Method::new("points".into(), Sampling::points(middles), Weights::AtPoints),
        Method::new("bins".into(), bins(), Weights::Own),
        Method::new("bins".into(), bins(), Weights::WithSource),
    ]
    .map(|m| statistics(m.errors(chart, light))[2])
}

pub fn page(chart: &Chart) -> String {
    let lights: Vec<Light> = LIGHTS.iter().map(|l| chart.light(l)).collect();
    let mut text = String::from(
        "## Sampling wavelengths\n\n24 patches (Ohta), CIEDE2000 to 1 nm sums with the true white. *Points* weigh by the CMF at the point; *linear between* is what a stream with WAVELENGTHS means; *bins* are exact means, what WAVELENGTH_SPLITS means. *Source in weights* keeps the source at its finest table, multiplied into the CMF (XYZ_MATRIX lines), and samples only reflectances. FL tables are 5 nm averages: a real lamp is harder.\n\n",
    );
    text += &head("method|largest|mean|A C D50 D65|FL2|FL11|LED-B3|LED-RGB1");
    for m in methods() {
        let cells = summary(&m, chart, &lights).map(|v| format!("{v:.3}"));
        text += &row([m.name].into_iter().chain(cells));
    }
    text += "\nMore samples are not always better: largest error under FL11 for N over 380-780 nm.\n\n";
    text += &head("N|points|bins|bins, source in weights");
    let light = &lights[5];
    for n in (3..=20).chain((24..=40).step_by(4)) {
        text += &row([n.to_string()].into_iter().chain(fl11(n, chart, light).map(|v| format!("{v:.2}"))));
    }
    text
}
