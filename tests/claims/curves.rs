//! Gamut mapping and tone curves.

use super::*;

/// Percent of the differences of 0.5 and 0.8 thresholds that show after `pcond --goal visibility`, and of those of 1.25 and 2: 2000
/// luminances between two powers of ten, each beside itself with a difference on it.
pub fn seen([low, high]: [f64; 2]) -> [f64; 2] {
    const COUNT: usize = 2000;
    const DIFFERENCES: [f64; 5] = [0.0, 0.5, 0.8, 1.25, 2.0];
    let base = |i: usize| 10f64.powf(low + (high - low) * (i as f64 + 0.5) / COUNT as f64);
    let row = |l: f64| DIFFERENCES.map(|k| neutral(l + k * threshold_cd_m2(l)));
    let colours: Vec<Xyz> = (0..COUNT).flat_map(|i| row(base(i))).collect();
    let shown = through(&["pcond", "--goal", "visibility"], &picture(CD_M2, DIFFERENCES.len(), &colours));
    let mut counts = [0usize; 2];
    for row in shown.chunks(DIFFERENCES.len()) {
        let luminances: Vec<f64> = row.iter().map(|c| cd_m2(c[1])).collect();
        let threshold = threshold_cd_m2(luminances[0]);
        for (k, l) in luminances.iter().enumerate().skip(1) {
            counts[usize::from(k > 2)] += usize::from(l - luminances[0] >= threshold);
        }
    }
    counts.map(|n| 100.0 * n as f64 / (2 * COUNT) as f64)
}

/// Contrast on the display of a square of 40 cd/m2 on a field of 20 with 2000 cd/m2 beside it.
pub fn contrast_beside_glare(options: &[&str]) -> f64 {
    let inside = |x: usize, row: usize| (32..48).contains(&row) && (32..48).contains(&x);
    let luminance = |i: usize| match (i % 160, i / 160) {
        (x, row) if inside(x, row) => 40.0,
        (x, _) if x < 80 => 20.0,
        _ => 2000.0,
    };
    let colours: Vec<Xyz> = (0..160 * 80).map(|i| neutral(luminance(i))).collect();
    let lines = format!("{CD_M2}\nVIEW=-vta -vh 80 -vv 40");
    let shown = through(&[&["pcond"][..], options].concat(), &picture(&lines, 160, &colours));
    let [target, field] = [40 * 160 + 40, 12 * 160 + 40].map(|i| cd_m2(shown[i][1]));
    target / field - 1.0
}

/// The red of BT.709 at Y = 1.
pub fn red() -> Xyz {
    let c = Primaries::BT709.to_xyz().unwrap().apply([1.0, 0.0, 0.0]);
    c.map(|x| x / c[1])
}

/// Mean luminance, white at 1, of a print of one colour at 5 to 500 cd/m2.
pub fn print_mean(colour: Xyz) -> f64 {
    let colours: Vec<Xyz> = evenly([5.0, 500.0], 64 * 64).into_iter().map(|y| colour.map(|x| x * y)).collect();
    let shown = through(&["pcond", "--print"], &picture(CD_M2, 64, &colours));
    shown.iter().map(|c| c[1]).sum::<f64>() / shown.len() as f64
}

/// What the gloss of `pcond --print` reflects: 0.006 of 100 cd/m2.
pub const GLOSS_CD_M2: f64 = 0.6;

/// The operators of Figures 6 to 8, and histogram adjustment that counts in thresholds of the eye.
pub const OPERATORS: [&str; 4] = ["-l", "-h", "--print", "-s"];

/// The control tower at 96 pixels, as in tests/tower.rs, and what the operators make of it.
pub struct Tower {
    pub luminance: Vec<f64>,
    /// log10 of luminance, and pixels.
    pub histogram: Vec<(f64, f64)>,
    /// log10 of world and display luminance.
    pub maps: HashMap<&'static str, Vec<(f64, f64)>>,
    /// Luminances shown, white at 1.
    pub shown: HashMap<&'static str, Vec<f64>>,
}

pub fn pairs(text: &str) -> Vec<(f64, f64)> {
    let pair = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
        (numbers[0], numbers[1])
    };
    text.lines().map(pair).collect()
}

pub fn luminances(colours: &[Xyz]) -> Vec<f64> {
    colours.iter().map(|c| c[1]).collect()
}

impl Tower {
    pub fn render() -> Tower {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
        let (picture, map) = (file("tower.lux"), file("tower.map"));
        let options = ["--quiet", "--width", "96", "--samples", "256", "--bands", "20", "scenes/tower.toml"];
        let adapted = stdout_of("vonkries", &["--quiet", "--to", "D65"], &stdout_of("spectrace", &options, b""));
        std::fs::write(&picture, &adapted).unwrap();
        let histogram = String::from_utf8(stdout_of("picinfo", &["--histogram", &picture], b"")).unwrap();
        let (mut maps, mut shown) = (HashMap::new(), HashMap::new());
        for operator in OPERATORS {
            let out = stdout_of("pcond", &["--quiet", operator, "-x", &map, &picture], b"");
            let points = pairs(&std::fs::read_to_string(&map).unwrap());
            maps.insert(operator, points.iter().map(|(w, d)| (w.log10(), d.log10())).collect());
            shown.insert(operator, luminances(&triples(&out)));
        }
        Tower { luminance: luminances(&triples(&adapted)), histogram: pairs(&histogram), maps, shown }
    }

    /// log10 of what is shown for log10 of a luminance, less a veil.
    fn level(&self, operator: &str, x: f64, veil_cd_m2: f64) -> f64 {
        let map = &self.maps[operator];
        let x = x.clamp(map[0].0, map[map.len() - 1].0);
        let i = map.partition_point(|p| p.0 < x).clamp(1, map.len() - 1);
        let ((x0, y0), (x1, y1)) = (map[i - 1], map[i]);
        let y = if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { y1 };
        (10f64.powf(y) - veil_cd_m2).log10()
    }

    /// Slope in the middle of each of the histogram's steps.
    fn slopes(&self, operator: &str, veil_cd_m2: f64) -> Vec<f64> {
        let step = self.histogram[1].0 - self.histogram[0].0;
        let at = |x: f64| self.level(operator, x, veil_cd_m2);
        self.histogram.iter().map(|(x, _)| (at(x + 0.5 * step) - at(x - 0.5 * step)) / step).collect()
    }
}

pub fn tower() -> &'static Tower {
    static TOWER: LazyLock<Tower> = LazyLock::new(Tower::render);
    &TOWER
}

/// Percent of the tower's pixels at the display's white or beyond.
pub fn over_white(operator: &str) -> f64 {
    let shown = &tower().shown[operator];
    100.0 * shown.iter().filter(|y| **y >= 0.9999).count() as f64 / shown.len() as f64
}

/// Mean slope in log over log, pixels counting alike.
pub fn mean_slope(operator: &str) -> f64 {
    let tower = tower();
    let total: f64 = tower.histogram.iter().map(|h| h.1).sum();
    tower.slopes(operator, 0.0).iter().zip(&tower.histogram).map(|(s, h)| s * h.1).sum::<f64>() / total
}

/// Slope over the luminances that the linear operator clamps.
pub fn slope_over_white(operator: &str) -> f64 {
    let tower = tower();
    let clamped = tower.luminance.iter().zip(&tower.shown["-l"]).filter(|(_, y)| **y > 1.0);
    let white = clamped.fold(f64::INFINITY, |m, (l, _)| m.min(*l)).log10();
    let most = largest(&tower.luminance).log10();
    (tower.level(operator, most, 0.0) - tower.level(operator, white, 0.0)) / (most - white)
}

/// Mean slope that the darkest fifth of the pixels see, but for the darkest few, as in tests/tower.rs. A linear map's is 1.
pub fn slope_near_black(operator: &str, veil_cd_m2: f64) -> f64 {
    let tower = tower();
    let total: f64 = tower.histogram.iter().map(|h| h.1).sum();
    let (mut below, mut sum, mut weight) = (0.0, 0.0, 0.0);
    for ((_, count), slope) in tower.histogram.iter().zip(tower.slopes(operator, veil_cd_m2)) {
        below += count / total;
        if (0.03..0.2).contains(&below) {
            (sum, weight) = (sum + count * slope, weight + count);
        }
    }
    sum / weight
}

/// Rank correlation of the histogram's counts and the slopes there.
pub fn peaks_and_slopes(operator: &str) -> f64 {
    let counts: Vec<f64> = tower().histogram.iter().map(|h| h.1).collect();
    correlation(&ranks(&counts), &ranks(&tower().slopes(operator, 0.0)))
}

/// Ranks, equals sharing their mean.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let less = |x: f64| values.iter().filter(|y| **y < x - 1e-9).count() as f64;
    let same = |x: f64| values.iter().filter(|y| (**y - x).abs() <= 1e-9).count() as f64;
    values.iter().map(|x| less(*x) + 0.5 * same(*x)).collect()
}

pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let centred = |v: &[f64]| -> Vec<f64> {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        v.iter().map(|x| x - mean).collect()
    };
    let (a, b) = (centred(a), centred(b));
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}
