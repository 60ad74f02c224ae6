//! pcond from outside: against Radiance's own maps, the published mappings, the promise of visibility, and its laws.

mod common;

use std::path::PathBuf;

use common::*;
use luxpipe::tone::threshold::Count;
use luxpipe::tone::{Curve, Display, Histogram, Scale, adjust, classic, visible};

const WIDTH: usize = 240;
const HEIGHT: usize = 120;
const VIEW: &str = "VIEW= -vtv -vh 60 -vv 32.2042";

/// The pictures of tests/ref/pcond_maps.csv: log10 of luminance by place, x and y from the upper left in shares.
fn luminance(scene: &str, x: f64, y: f64) -> f64 {
    let log = match scene {
        "ramp" => -2.0 + 6.0 * x,
        "two" if x < 0.6 => -0.5 + x / 0.6 + 0.2 * y,
        "two" => 2.6 + (x - 0.6) + 0.4 * y,
        "window" if (x > 0.55 && x < 0.85) && (y > 0.2 && y < 0.7) => 3.6 + 0.3 * y,
        "window" => 0.3 + 1.2 * x * y,
        "night" => -4.0 + 3.5 * x * x + 0.5 * y,
        "sun" if (x - 0.7).hypot((y - 0.3) / 2.0) < 0.01 => 9.2,
        "sun" => 1.0 + 2.5 * y,
        _ => unreachable!("{scene}"),
    };
    10f64.powf(log)
}

fn scene(name: &str) -> Vec<u8> {
    let place = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    grey(WIDTH, HEIGHT, VIEW, |x, y| luminance(name, place(x, WIDTH), place(y, HEIGHT)))
}

/// An XYZ stream of equal-energy greys.
fn grey(width: usize, height: usize, line: &str, y: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let floats: Vec<f32> =
        (0..height).flat_map(|r| (0..width).map(move |x| (x, r))).flat_map(|(x, r)| [y(x, r) as f32; 3]).collect();
    xyz(width, height, line, &floats)
}

fn xyz(width: usize, height: usize, line: &str, floats: &[f32]) -> Vec<u8> {
    let header = format!(
        "#?RADIANCE\n{line}\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nBigEndian=0\nFORMAT=float\n\n-Y {height} +X {width}\n"
    );
    let mut bytes = header.into_bytes();
    floats.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes
}

/// Runs pcond and returns what it wrote and said.
fn pcond(args: &[&str], input: &[u8]) -> (Vec<f32>, String) {
    let out = run("pcond", args, input);
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    (floats(split(&out.stdout).2), String::from_utf8_lossy(&out.stderr).into_owned())
}

/// The map that pcond writes, ln Lw and ln Ld.
fn map(args: &[&str], input: &[u8]) -> Vec<(f64, f64)> {
    let file = scratch("map");
    let mut all = args.to_vec();
    let path = file.to_str().unwrap().to_string();
    all.extend(["-x", &path]);
    pcond(&all, input);
    let text = std::fs::read_to_string(&file).unwrap();
    let _ = std::fs::remove_file(&file);
    let line = |l: &str| {
        let n: Vec<f64> = l.split(' ').map(|w| w.parse::<f64>().unwrap().ln()).collect();
        (n[0], n[1])
    };
    text.lines().map(line).collect()
}

fn scratch(what: &str) -> PathBuf {
    use std::sync::atomic::{AtomicU32, Ordering};
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let n = COUNT.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("luxpipe-pcond-{}-{n}-{what}", std::process::id()))
}

fn at(map: &[(f64, f64)], x: f64) -> f64 {
    let i = map.partition_point(|p| p.0 < x).clamp(1, map.len() - 1);
    let (a, b) = (map[i - 1], map[i]);
    a.1 + (b.1 - a.1) * ((x - a.0) / (b.0 - a.0)).clamp(0.0, 1.0)
}

/// The maps of Radiance 6.0a's pcond, 11 places each.
#[test]
fn classic_maps_are_radiances() {
    let text = include_str!("ref/pcond_maps.csv");
    let mut rows: Vec<(String, String, f64, f64)> = Vec::new();
    for line in text.lines().skip(1).filter(|l| !l.starts_with('#')) {
        let w: Vec<&str> = line.split(',').collect();
        rows.push((w[0].into(), w[1].into(), w[2].parse().unwrap(), w[3].parse().unwrap()));
    }
    // Where it gives up and is linear, its -x counts 179 for white; the picture does not.
    let linear = [
        ("two", "-u 400 -d 1000"),
        ("window", ""),
        ("window", "-s"),
        ("window", "-u 400 -d 1000"),
        ("night", "-s"),
        ("night", "-h"),
        ("sun", "-u 400 -d 1000"),
    ];
    let mut cases: Vec<(String, String)> = rows.iter().map(|r| (r.0.clone(), r.1.clone())).collect();
    cases.dedup();
    assert_eq!(cases.len(), 25);
    for (name, options) in &cases {
        let mut args: Vec<&str> = options.split_ascii_whitespace().collect();
        args.push("--classic");
        let ours = map(&args, &scene(name));
        let (white, black): (f64, f64) = if options.contains("400") { (400.0, 0.4) } else { (100.0, 1.0) };
        let scale = if linear.contains(&(name, options)) { white / 179.0 } else { 1.0 };
        let mut worst = 0f64;
        for (_, _, world, shown) in rows.iter().filter(|r| r.0 == *name && r.1 == *options) {
            let (x, theirs) = (world.ln(), (shown * scale).clamp(black, white).ln());
            // Theirs is cut at black and white before it is scaled.
            let cut = *shown >= 0.999 * white || *shown <= 1.001 * black;
            if x < ours[0].0 || x > ours[99].0 || (scale != 1.0 && cut) {
                continue;
            }
            worst = worst.max((at(&ours, x) - theirs).abs());
        }
        println!("{name:8} pcond {options:16} largest difference of ln Ld {worst:.4}");
        assert!(worst < 0.08, "{name} {options}: {worst}");
    }
}

const SRGB: Display = Display { max_cd_m2: 100.0, min_cd_m2: 1.0 };

/// Where 30 % of the counts survive, the default is the original's map too.
#[test]
fn default_maps_are_radiances_where_counts_survive() {
    let text = include_str!("ref/pcond_maps.csv");
    let mut compared = 0;
    for (name, options, scale) in [
        ("ramp", "", Scale::Ratio),
        ("ramp", "-s", Scale::visibility(Count::Integral, 0.0)),
        ("two", "", Scale::Ratio),
        ("night", "", Scale::Ratio),
        ("sun", "", Scale::Ratio),
    ] {
        let mut h = Histogram::default();
        floats(split(&scene(name)).2).iter().step_by(3).for_each(|y| h.add(*y, 1.0));
        let (_, share) = adjust::adjusted(&h, SRGB, &scale);
        let ours = map(&options.split_ascii_whitespace().collect::<Vec<_>>(), &scene(name));
        let start = format!("{name},{options},");
        let rows = text.lines().filter_map(|l| l.strip_prefix(&start)?.split_once(','));
        let rows = rows.map(|(w, d)| (w.parse::<f64>().unwrap().ln(), d.parse::<f64>().unwrap().ln()));
        let worst = rows.map(|(w, d)| (at(&ours, w) - d).abs()).fold(0.0, f64::max);
        println!("{name} {options}: {:.0} % survive, largest difference {worst:.3}", 100.0 * share);
        if share >= 0.3 {
            assert!(worst < 0.08, "{name} {options}: {worst}");
            compared += 1;
        }
    }
    assert!(compared >= 3);
}

/// tests/ref/README.md: the group tonemap, histograms of 100 even bins and what an independent program makes of them.
#[test]
fn published_mappings() {
    let even = |from: f64, to: f64, count: &dyn Fn(usize, f64) -> f64| -> Histogram {
        let step = (to - from) / 100.0;
        let mut text = String::new();
        for i in 0..100 {
            let l = from + (i as f64 + 0.5) * step;
            text += &format!("{l} {}\n", count(i, l));
        }
        Histogram::from_text(&text).unwrap()
    };
    let two = |_: usize, l: f64| {
        let bell = |x: f64| (-x * x / 0.18f64).exp();
        1.0 + 1000.0 * bell(l) + 400.0 * bell(l - 3.0)
    };
    let flat = |_: usize, _: f64| 100.0;
    let sun = |i: usize, _: f64| {
        if i < 28 {
            1000.0
        } else if i == 99 {
            1.0
        } else {
            0.0
        }
    };
    let third = [1.0, 1.58489, 2.51189, 3.98107, 6.30957, 10.0, 15.8489, 25.1189, 39.8107, 63.0957, 100.0];
    let bimodal = [1.0, 1.00437, 1.11992, 4.98745, 15.1966, 15.5317, 15.7085, 31.1203, 95.0758, 99.567, 100.0];
    let outlier = [1.0, 5.17917, 26.8238, 99.9836, 99.9836, 99.9836, 99.9836, 99.9836, 99.9836, 99.9836, 100.0];
    let human = Scale::visibility(Count::Integral, 0.0);
    let cases: [(&str, (f64, f64), Histogram, &Scale, [f64; 11], bool); 6] = [
        ("uniform, linear", (-2.0, 4.0), even(-2.0, 4.0, &flat), &Scale::Ratio, third, true),
        ("uniform, human", (-2.0, 4.0), even(-2.0, 4.0, &flat), &human, third, true),
        ("two peaks, linear", (-2.0, 5.0), even(-2.0, 5.0, &two), &Scale::Ratio, bimodal, true),
        // Beyond 1e7 cd/m2 the original's clamp would show.
        ("1e-6 to 1e8, linear", (-6.0, 8.0), even(-6.0, 8.0, &flat), &Scale::Ratio, third, false),
        ("sun, linear", (0.0, 9.0), even(0.0, 9.0, &sun), &Scale::Ratio, outlier, false),
        ("sun, human", (0.0, 9.0), even(0.0, 9.0, &sun), &human, outlier, false),
    ];
    for (name, (from, to), histogram, scale, want, with_classic) in cases {
        let (curve, share) = adjust::adjusted(&histogram, SRGB, scale);
        let old = classic::adjusted(&histogram, SRGB, scale != &Scale::Ratio);
        let differs = |c: &Curve, k: usize| {
            let lw = 10f64.powf(from + (to - from) * k as f64 / 10.0);
            (c.at(lw) / want[k]).ln().abs()
        };
        let worst = |c: &Curve| (0..11).map(|k| differs(c, k)).fold(0.0, f64::max);
        println!(
            "{name}: {:.0} % survive, default within {:.4}, classic {:.4}",
            100.0 * share,
            worst(&curve),
            worst(&old)
        );
        assert!(share < 0.3 || worst(&curve) < 0.08, "{name}: {}", worst(&curve));
        assert!(!with_classic || worst(&old) < 0.08, "{name}: {}", worst(&old));
    }
}

/// Moving 1e-4 of the weight between luminances moves ln Ld of none by more than 0.1: for all rules, over histograms of many
/// kinds, those at the original's cliff among them.
#[test]
fn no_map_has_a_cliff() {
    let mut state = 1u64;
    let mut random = move || {
        state = luxpipe::statistics::scrambled(state);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let scales = [Scale::Ratio, Scale::visibility(Count::Integral, 0.0), visible::scale(0.0)];
    let mut worst = [0f64; 3];
    for case in 0..240 {
        // 120 places over 1 to 14 decades, peaks and floors.
        let (low, decades) = (-6.0 + 6.0 * random(), 1.0 + 13.0 * random() * random());
        let mut weights: Vec<f64> = (0..120).map(|_| if case % 3 == 0 { 1.0 } else { random().powi(6) }).collect();
        for _ in 0..case % 4 {
            let (centre, width, height) = (120.0 * random(), 0.5 + 12.0 * random(), 10f64.powf(4.0 * random()));
            weights
                .iter_mut()
                .enumerate()
                .for_each(|(i, w)| *w += height * (-((i as f64 - centre) / width).powi(2)).exp());
        }
        if case % 5 == 0 {
            weights[(120.0 * random()) as usize] += 120.0 * 0.97 / (1.0 - 0.97) * (0.98 + 0.04 * random());
        }
        let total: f64 = weights.iter().sum();
        let place = |i: usize| 10f64.powf(low + decades * (i as f64 + 0.5) / 120.0);
        let histogram = |w: &[f64]| {
            let mut h = Histogram::default();
            w.iter().enumerate().filter(|(_, w)| **w > 0.0).for_each(|(i, w)| h.add(place(i) as f32, w / total));
            h
        };
        let mut moved = weights.clone();
        let (from, to) = (1 + (118.0 * random()) as usize, 1 + (118.0 * random()) as usize);
        let amount = (1e-4 * total).min(0.999 * moved[from]);
        moved[from] -= amount;
        moved[to] += amount;
        let (before, after) = (histogram(&weights), histogram(&moved));
        for (k, scale) in scales.iter().enumerate() {
            let map = |h: &Histogram| {
                if k == 2 { visible::visible(h, SRGB, scale) } else { adjust::adjusted(h, SRGB, scale).0 }
            };
            let (a, b) = (map(&before), map(&after));
            for i in 0..120 {
                let step = (a.at(place(i)) / b.at(place(i))).ln().abs();
                if step > worst[k] {
                    worst[k] = step;
                }
            }
        }
    }
    println!(
        "largest step of ln Ld for 1e-4 of the weight: contrast {:.3}, -s {:.3}, visibility {:.3}",
        worst[0], worst[1], worst[2]
    );
    assert!(worst.iter().all(|w| *w <= 0.1), "{worst:?}");
}
