//! Ways to render with few numbers, against full spectra: light that one, two or three patches reflected in turn.
//!
//! Every approach is a handful of factors for each patch and three rows of weights: bounces multiply factor by factor, and
//! the weights make XYZ under D65 of the product.

use luxpipe::color::{Cat, Mat3, Primaries, Xy};

use super::blueflower::c709;
use super::{Chart, Light, differences, head, row, statistics, to_d65};

pub const LIGHTS: [&str; 9] = ["A", "B", "C", "D50", "D65", "FL2", "FL11", "LED-B3", "LED-RGB1"];

pub struct Approach {
    pub name: String,
    /// For each patch.
    factors: Vec<Vec<f64>>,
    to_xyz: [Vec<f64>; 3],
}

impl Approach {
    /// Triples: `rgb` of each patch's XYZ, and the matrix from products of them to XYZ.
    fn triples(name: &str, patches: &[[f64; 3]], rgb: &Mat3, to_xyz: Mat3) -> Approach {
        let factors = patches.iter().map(|v| rgb.apply(*v).to_vec()).collect();
        Approach { name: name.into(), factors, to_xyz: to_xyz.0.map(|r| r.to_vec()) }
    }

    /// Full spectra, then a matrix.
    fn spectral(name: &str, chart: &Chart, light: &Light, then: &Mat3) -> Approach {
        let weight = |r: [f64; 3], i: usize| (0..3).map(|c| r[c] * chart.cmf[c][i] * light.power[i]).sum();
        let to_xyz = then.0.map(|r| (0..light.power.len()).map(|i| weight(r, i)).collect());
        Approach { name: name.into(), factors: chart.patches.clone(), to_xyz }
    }

    /// N bands of 400-700 nm, the outer two open to 380 and 780; reflectances are means weighted by source x CMF.
    fn bands(n: usize, chart: &Chart, light: &Light, then: &Mat3) -> Approach {
        let band = |i: usize| ((i as f64 - 20.0) / (300.0 / n as f64)).floor().clamp(0.0, n as f64 - 1.0) as usize;
        let gather = |f: &dyn Fn(usize) -> f64| {
            let mut sums = vec![0.0; n];
            (0..light.power.len()).for_each(|i| sums[band(i)] += f(i));
            sums
        };
        let weight = |i: usize| light.power[i] * (0..3).map(|c| chart.cmf[c][i]).sum::<f64>();
        let total = gather(&weight);
        let mean = |r: &Vec<f64>| gather(&|i| r[i] * weight(i)).iter().zip(&total).map(|(a, b)| a / b).collect();
        let xyz = chart.cmf.each_ref().map(|c| gather(&|i| c[i] * light.power[i]));
        let to_xyz = then.0.map(|r| (0..n).map(|b| r[0] * xyz[0][b] + r[1] * xyz[1][b] + r[2] * xyz[2][b]).collect());
        Approach { name: format!("{n} bands"), factors: chart.patches.iter().map(mean).collect(), to_xyz }
    }

    /// XYZ after these patches, in any order.
    fn seen(&self, patches: &[usize]) -> [f64; 3] {
        let n = self.to_xyz[0].len();
        let product: Vec<f64> = (0..n).map(|b| patches.iter().map(|p| self.factors[*p][b]).product()).collect();
        self.to_xyz.each_ref().map(|w| w.iter().zip(&product).map(|(a, b)| a * b).sum())
    }
}

/// The truth first, then every approach, for one light.
pub fn approaches(chart: &Chart, name: &str) -> (Approach, Vec<Approach>) {
    let (light, c, d65) = (chart.light(name), chart.light("C"), chart.light("D65"));
    let adapt = to_d65(Cat::Cmccat2000, light.white);
    let (to709, from709) = (c709(), Primaries::BT709.to_xyz().expect("regular"));
    let source = Mat3::diagonal(to709.apply(light.white));
    let adjusted = to709.times(&adapt);
    let adapted = adapt.times(&from709);
    let triples = Approach::triples;
    let mut all = vec![
        Approach::spectral("full spectral not adapted", chart, &light, &Mat3::IDENTITY),
        triples("white sources with RGB from C", &c.patches, &to709, from709),
        triples("white sources with RGB from D65", &d65.patches, &to709, from709),
        triples("RGB source x RGB from D65", &d65.patches, &to709, adapted.times(&source)),
        triples("relative: absolute RGB", &light.patches, &to709, adapted),
        triples("relative: adjusted RGB", &light.patches, &adjusted, from709),
    ];
    let primaries = |name: &str| name.parse::<Primaries>().ok().and_then(|p| p.from_xyz()).expect("named");
    for (space, m) in [
        ("XYZ", Mat3::IDENTITY),
        ("BT.709", to709),
        ("BT.2020", primaries("BT.2020")),
        ("ACEScg", primaries("ACEScg")),
        ("CMCCAT2000", Cat::Cmccat2000.matrix()),
        ("Bradford", Cat::Bradford.matrix()),
        ("Sharp", Cat::Sharp.matrix()),
    ] {
        let white = m.apply(light.white);
        let over = Mat3::diagonal(white.map(|w| 1.0 / w)).times(&m);
        let back = adapt.times(&m.inverse().expect("regular")).times(&Mat3::diagonal(white));
        all.push(triples(&format!("relative: over white in {space}"), &light.patches, &over, back));
    }
    all.extend([3, 6, 9, 12, 20].map(|n| Approach::bands(n, chart, &light, &adapt)));
    (Approach::spectral("truth", chart, &light, &adapt), all)
}

/// All multisets of `k` of `n` things.
fn multisets(n: usize, k: usize) -> Vec<Vec<usize>> {
    if k == 0 {
        return vec![vec![]];
    }
    let shorter = multisets(n, k - 1);
    let extend =
        |s: &Vec<usize>| (s.last().copied().unwrap_or(0)..n).map(|i| [&s[..], &[i]].concat()).collect::<Vec<_>>();
    shorter.iter().flat_map(extend).collect()
}

/// Name and [mean, 95 %, largest] CIEDE2000 for 1, 2 and 3 bounces over all lights.
pub fn results(chart: &Chart) -> Vec<(String, [[f64; 3]; 3])> {
    let lights = LIGHTS.map(|l| approaches(chart, l));
    let mut out: Vec<_> = lights[0].1.iter().map(|a| (a.name.clone(), [[0.0; 3]; 3])).collect();
    for k in 1..=3 {
        let sets = multisets(24, k);
        let truths = lights.each_ref().map(|l| sets.iter().map(|s| l.0.seen(s)).collect::<Vec<_>>());
        for (i, (_, results)) in out.iter_mut().enumerate() {
            let errors = lights.iter().zip(&truths).flat_map(|((_, all), truth)| {
                let seen: Vec<[f64; 3]> = sets.iter().map(|s| all[i].seen(s)).collect();
                differences(truth, &seen, Xy::D65.xyz())
            });
            results[k - 1] = statistics(errors.collect());
        }
    }
    out
}

pub fn page(chart: &Chart) -> String {
    let mut text = String::from(
        "## Rendering approaches\n\nProducts of one, two and three patch reflectances (24, 300, 2600 multisets) under nine lights, against the spectral product adapted to D65 by CMCCAT2000. CIEDE2000, mean / 95 % / largest, white diffuser at Y = 1, negative RGB kept.\n\n",
    );
    text += &head("approach|one bounce|two|three");
    for (name, bounces) in results(chart) {
        let cells = bounces.map(|b| b.map(|v| format!("{v:.2}")).join(" / "));
        text += &row([name].into_iter().chain(cells));
    }
    text += "\nThe paper's relative approximation is exact for one bounce, as it says. For more, the error of the recipe as worded is\nnot negligible: absolute RGB applies the source's tint once a bounce. Divide by the white, in wide primaries.\n";
    text
}
