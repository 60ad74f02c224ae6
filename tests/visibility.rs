//! The promise of `pcond -h`: what an observer sees in the world shows on the display, and nothing else does.
//!
//! Kept visibility is the share of differences over the world's threshold that are over the display's; false visibility the
//! share of those under it that show. `cargo test --test visibility -- --nocapture` prints both over luminance.

mod common;

use std::sync::Arc;

use common::*;
use luxpipe::stream::{Components, Header, Resolution, Units};
use luxpipe::tone::fovea::{Cells, Field, Means};
use luxpipe::tone::threshold::threshold_cd_m2;
use luxpipe::tone::veil::{self, Scatter};
use luxpipe::tone::{Display, Histogram, adjust, visible};

const DISPLAY: Display = Display { max_cd_m2: 100.0, min_cd_m2: 1.0 };
/// Thresholds of the differences shown.
const UNDER: [f64; 2] = [0.5, 0.8];
const OVER: [f64; 2] = [1.25, 2.0];

const WIDTH: usize = 160;
const HEIGHT: usize = 80;
const VIEW: &str = "-vta -vh 80 -vv 40";

/// Two fields side by side with a square of 8 degrees in the middle of each.
fn picture(fields: [f64; 2], targets: [f64; 2]) -> Vec<f32> {
    let mut y = vec![0f32; WIDTH * HEIGHT];
    for (i, y) in y.iter_mut().enumerate() {
        let (x, row) = (i % WIDTH, i / WIDTH);
        let side = 2 * x / WIDTH;
        let inside = (x % 80).abs_diff(40) < 8 && row.abs_diff(40) < 8;
        *y = (fields[side] + if inside { targets[side] } else { 0.0 }) as f32;
    }
    y
}

/// Luminance of every pixel on the retina.
fn retina_all(y: &[f32]) -> Vec<f64> {
    let mut header = Header::new(Resolution::upright(WIDTH, HEIGHT), Components::Xyz, 3, Units::CdM2);
    header.lines.push(format!("VIEW={VIEW}").into_bytes());
    let (cells, _): (Arc<Cells>, bool) = Cells::of(&header);
    let mut means = Means::<1>::new(&cells);
    means.add(y, 1);
    let veil = veil::over(Scatter::Ward, &cells, &means.means(), 0);
    let values = (0..cells.count()).map(|i| [veil.light[i][0] as f32, veil.lost[i] as f32]).collect();
    let field = Field::new(cells, values);
    let mut all = Vec::with_capacity(y.len());
    for (row, line) in y.chunks(WIDTH).enumerate() {
        let values = field.scanline(row);
        for stretch in field.along(&values) {
            for (x, share) in stretch.pixels.clone().zip(stretch.shares) {
                let [added, lost] = [0, 1].map(|k| f64::from(stretch.start[k] + share * stretch.step[k]));
                all.push(f64::from(line[x]) * (1.0 - lost) + added);
            }
        }
    }
    all
}

/// In the middle of both targets, and in the fields above them.
fn retina(y: &[f32]) -> [[f64; 2]; 2] {
    let all = retina_all(y);
    [0, 80].map(|x| [all[40 * WIDTH + x + 40], all[12 * WIDTH + x + 40]])
}

/// Display luminances at the same places after `pcond -h`.
fn shown(y: &[f32]) -> [[f64; 2]; 2] {
    let pixels: Vec<f32> = y.iter().flat_map(|y| [*y; 3]).collect();
    let header = format!("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nVIEW={VIEW}");
    let out = stdout_of("pcond", &["-h"], &stream(&header, &format!("-Y {HEIGHT} +X {WIDTH}"), &pixels));
    let share = floats(split(&out).2);
    let at = |x: usize, row: usize| {
        DISPLAY.min_cd_m2 + f64::from(share[3 * (row * WIDTH + x) + 1]) * (DISPLAY.max_cd_m2 - DISPLAY.min_cd_m2)
    };
    [0, 80].map(|x| [at(x + 40, 40), at(x + 40, 12)])
}

/// Whether differences of `k` thresholds on the retina show on the display, in both fields.
fn shows(fields: [f64; 2], k: f64) -> [bool; 2] {
    // The retina's difference grows with the target's, all but straight: two secant steps find the target for k.
    let mut targets = fields.map(|l| k * threshold_cd_m2(l));
    for _ in 0..4 {
        let seen = retina(&picture(fields, targets));
        for side in 0..2 {
            let [target, field] = seen[side];
            targets[side] *= k * threshold_cd_m2(field) / (target - field);
        }
    }
    shown(&picture(fields, targets)).map(|[target, field]| target - field >= threshold_cd_m2(field))
}

/// The luminances on the retina as a histogram, and what the best map could keep of them.
fn possible(fields: [f64; 2]) -> f64 {
    let mut histogram = Histogram::default();
    let y = picture(fields, [0.0; 2]);
    let all = retina_all(&y);
    all.iter().for_each(|l| histogram.add(*l as f32, 1.0));
    let (scene, display) = adjust::lengths(&histogram, DISPLAY, &visible::scale(0.0));
    if scene <= display {
        return 1.0;
    }
    // Of the two places that are asked the better and the worse count alike, so the pixels of both fields do.
    let mut weights: Vec<(f64, f64)> = histogram.weights().map(|(ln, w)| (ln.exp(), w)).collect();
    weights.sort_by(|a, b| a.0.total_cmp(&b.0));
    best_share(&weights, display)
}

/// One field, and pairs: rooms and windows, night streets. Where the display has steps for all of it (one field always), all
/// is to be kept; of the other pairs what the best map keeps.
#[test]
fn differences_show_when_they_are_seen() {
    let mut scenes: Vec<[f64; 2]> = (-8..=8).map(|i| [10f64.powf(f64::from(i) / 2.0); 2]).collect();
    scenes.extend([[0.01, 1.0], [1.0, 20.0], [3.0, 300.0], [20.0, 2000.0], [50.0, 9000.0], [1e-4, 1e4], [0.1, 1000.0]]);
    println!("  cd/m2 (both fields)      0.5   0.8   1     1.25  2    of the threshold");
    let (mut under, mut wrong) = (0, 0);
    // Where everything fits, and elsewhere: differences over the threshold, those kept, those that could be.
    let mut tally = [[0.0f64; 3]; 2];
    for fields in &scenes {
        let row: Vec<[bool; 2]> = [0.5, 0.8, 1.0, 1.25, 2.0].iter().map(|k| shows(*fields, *k)).collect();
        let word = |s: &[bool; 2]| s.map(|b| if b { 'x' } else { '.' }).iter().collect::<String>();
        println!(
            "  {:9.4} {:9.1}      {}",
            fields[0],
            fields[1],
            row.iter().map(|s| format!("{:6}", word(s))).collect::<String>()
        );
        for side in 0..2 {
            under += UNDER.len();
            wrong += row[..2].iter().filter(|s| s[side]).count();
            let best = possible(*fields);
            let row = [OVER.len() as f64, row[3..].iter().filter(|s| s[side]).count() as f64, best * OVER.len() as f64];
            tally[usize::from(best < 1.0)].iter_mut().zip(row).for_each(|(t, x)| *t += x);
        }
    }
    println!("  false visibility {wrong} of {under}");
    for (what, [over, kept, best]) in ["where all fits", "elsewhere"].iter().zip(tally) {
        println!("  kept visibility {what}: {kept} of {over}, the best map at most {best:.1}");
        assert!(kept >= 0.95 * best, "{what}: {kept} of {best}");
    }
    assert!(wrong as f64 <= 0.01 * under as f64, "{wrong} of {under}");
    assert!(tally[0][0] >= 68.0, "too few scenes fit");
}

/// Steps from one whole threshold to the next at a luminance, and how many a difference of k thresholds is.
fn whole_steps(l: f64, k: f64) -> f64 {
    let d = (threshold_cd_m2(l * 1.001) - threshold_cd_m2(l / 1.001)) / (l * (1.001 - 1.0 / 1.001));
    if d > 1e-6 { (k * d).ln_1p() / d.ln_1p() } else { k }
}

/// No rising map can keep more than this share of the differences [`OVER`] the threshold at the pixels' luminances: each
/// slope that keeps one is spent where it keeps most pixels (a fractional knapsack, which forgives every constraint but the
/// display's length).
fn best_share(weights: &[(f64, f64)], display_steps: f64) -> f64 {
    let mut offers: Vec<(f64, f64)> = Vec::new(); // steps of the display that it costs, share kept
    let total: f64 = weights.iter().map(|w| w.1).sum();
    for pair in weights.windows(2) {
        let (l, next) = (pair[0].0, pair[1].0);
        let width = ((next - l) / threshold_cd_m2((l * next).sqrt())).max(0.0);
        let d = (threshold_cd_m2(next) - threshold_cd_m2(l)) / (next - l);
        let width = if d > 1e-6 { width * d / d.ln_1p() } else { width };
        let [one, two] = OVER.map(|k| 1.0 / whole_steps(l, k));
        // Both kept at once is the better bargain when 0.5 for the one costs over half of what both cost.
        let share = pair[0].1 / total;
        if two < 0.5 * one {
            offers.push((two * width, 0.5 * share));
            offers.push(((one - two) * width, 0.5 * share));
        } else {
            offers.push((one * width, share));
        }
    }
    offers.sort_by(|a, b| (b.1 / b.0).total_cmp(&(a.1 / a.0)));
    let (mut left, mut kept) = (display_steps, 0.0);
    for (cost, share) in offers {
        let part = (left / cost).clamp(0.0, 1.0);
        kept += part * share;
        left -= part * cost;
    }
    kept
}

/// Scenes with more steps than the display: at least 95 % of what the best map keeps.
#[test]
fn most_of_what_can_be_kept_is_kept() {
    let bell = |l: f64, at: f64, width: f64| (-((l - at) / width).powi(2)).exp();
    type Weight<'a> = (&'a str, f64, f64, Box<dyn Fn(f64) -> f64>);
    let scenes: Vec<Weight> = vec![
        ("even, 6 decades", -2.0, 4.0, Box::new(|_| 1.0)),
        ("even, 8 decades", -4.0, 4.0, Box::new(|_| 1.0)),
        ("even, 4.5 decades", -0.5, 4.0, Box::new(|_| 1.0)),
        ("room and window", -1.0, 4.5, Box::new(move |l| bell(l, 1.0, 0.6) + 0.4 * bell(l, 3.6, 0.3))),
        (
            "three places",
            -3.0,
            5.0,
            Box::new(move |l| bell(l, -1.0, 0.5) + bell(l, 1.5, 0.4) + 0.7 * bell(l, 4.0, 0.5)),
        ),
        ("rising", -1.0, 4.0, Box::new(|l| 10f64.powf(0.4 * l))),
        ("falling", -1.0, 4.0, Box::new(|l| 10f64.powf(-0.4 * l))),
        ("dark with lamps", -2.0, 6.0, Box::new(move |l| bell(l, 0.0, 0.8) + 0.02 + 0.05 * bell(l, 5.0, 0.3))),
        ("spike over a floor", -1.0, 4.0, Box::new(move |l| 1.0 + 40.0 * bell(l, 2.0, 0.05))),
    ];
    let scale = visible::scale(0.0);
    println!("  {:20} kept    best possible  ratio  false", "scene");
    for (name, from, to, weight) in &scenes {
        let n = 2000;
        let at = |i: usize| from + (to - from) * (i as f64 + 0.5) / n as f64;
        let weights: Vec<(f64, f64)> = (0..n).map(|i| (10f64.powf(at(i)), weight(at(i)))).collect();
        let mut histogram = Histogram::default();
        weights.iter().for_each(|(l, w)| histogram.add(*l as f32, *w));
        let (scene, display) = adjust::lengths(&histogram, DISPLAY, &scale);
        assert!(scene > display, "{name} fits");
        let curve = visible::visible(&histogram, DISPLAY, &scale);
        let seen = |l: f64, k: f64| curve.at(l + k * threshold_cd_m2(l)) - curve.at(l) >= threshold_cd_m2(curve.at(l));
        let share = |ks: [f64; 2]| {
            let sum: f64 = weights.iter().map(|(l, w)| ks.iter().filter(|k| seen(*l, **k)).count() as f64 * w).sum();
            sum / (2.0 * weights.iter().map(|w| w.1).sum::<f64>())
        };
        let (kept, wrong, best) = (share(OVER), share(UNDER), best_share(&weights, display));
        println!(
            "  {name:20} {:5.1} %   {:5.1} %       {:.3}  {:.2} %",
            100.0 * kept,
            100.0 * best,
            kept / best,
            100.0 * wrong
        );
        assert!(wrong <= 0.01, "{name}: {wrong}");
        assert!(kept >= 0.95 * best, "{name}: {kept} of {best}");
    }
}
