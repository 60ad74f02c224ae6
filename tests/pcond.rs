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
    let lines = format!("{line}\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2");
    stream(&lines, &format!("-Y {height} +X {width}"), floats)
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
    type Case<'a> = (&'a str, (f64, f64), Histogram, &'a Scale, [f64; 11], bool);
    let cases: [Case; 6] = [
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

/// Degenerate pictures give finite pictures on the display, and say what was replaced.
#[test]
fn degenerate_pictures() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let cases: [(&str, usize, usize, Vec<f32>, bool); 9] = [
        ("constant", 8, 8, vec![42.0; 192], false),
        ("black", 8, 8, vec![0.0; 192], true),
        ("one pixel", 1, 1, vec![3.0, 2.0, 1.0], false),
        ("not a number", 2, 1, vec![nan, nan, nan, 1.0, 1.0, 1.0], true),
        ("infinite", 2, 1, vec![inf, inf, inf, 1.0, 1.0, 1.0], true),
        ("all infinite", 1, 1, vec![inf; 3], true),
        ("negative", 2, 2, vec![-1.0, -2.0, -3.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 1.0, -1.0, 1.0], false),
        ("far apart", 2, 1, vec![1e-6, 1e-6, 1e-6, 1e8, 1e8, 1e8], false),
        ("no X", 2, 1, vec![0.0, 0.1, 0.1, 1.0, 1.0, 1.0], false),
    ];
    let options: [&[&str]; 9] = [
        &[],
        &["-h"],
        &["-s"],
        &["-l"],
        &["--classic", "-h"],
        &["--print"],
        &["--goal", "colour"],
        &["-h", "--glare", "cie", "--age", "70"],
        &["--surround", "dark", "--goal", "visibility"],
    ];
    for (name, width, height, pixels, noted) in &cases {
        let input = xyz(*width, *height, VIEW, pixels);
        for args in options {
            let out = run("pcond", args, &input);
            let said = String::from_utf8_lossy(&out.stderr).into_owned();
            if args.contains(&"colour") && out.status.code() == Some(1) {
                assert!(["black", "all infinite"].contains(name) || said.contains("no pixel"), "{name}: {said}");
                continue;
            }
            assert!(out.status.success(), "{name} {args:?}: {said}");
            let all = floats(split(&out.stdout).2);
            let luminances = all.iter().skip(1).step_by(3);
            assert!(all.iter().all(|x| x.is_finite()), "{name} {args:?}: {all:?}");
            if !args.contains(&"-l") {
                assert!(luminances.clone().all(|y| (..=1.0001).contains(y)), "{name} {args:?}: {all:?}");
            }
            assert!(!noted || !said.is_empty(), "{name} {args:?} says nothing");
        }
    }
}

/// The sun's disc is mapped, and darker things keep their order.
#[test]
fn the_sun_is_on_the_display() {
    for args in [&[][..], &["-h"], &["-s"], &["--goal", "visibility"]] {
        let (all, _) = pcond(args, &scene("sun"));
        let ours = map(args, &scene("sun"));
        assert!(ours[99].0 > 1.5e9f64.ln() - 0.2 && ours[99].1 <= 100f64.ln() + 1e-6, "{args:?} {:?}", ours[99]);
        assert!(ours.windows(2).all(|p| p[0].1 <= p[1].1 + 1e-9));
        assert!(all.iter().all(|x| *x <= 1.0001));
    }
}

/// After `vonkries` rods still see the light that was there: the same picture as when pcond changes the white itself.
#[test]
fn rods_see_the_light_before_adaptation() {
    // Paints under A, from 0.003 to 20 cd/m2.
    let pixels: Vec<f32> = (0..80 * 40)
        .flat_map(|i| {
            let y = 10f32.powf(-2.5 + 3.8 * (i % 80) as f32 / 80.0);
            let tint = [[1.0985, 0.35585], [1.4, 0.1], [0.8, 0.6], [0.9, 0.2]][(i / 80) % 4];
            [tint[0] * y, y, tint[1] * y]
        })
        .collect();
    let input = xyz(80, 40, VIEW, &pixels);
    let adapted = stdout_of("vonkries", &["--from", "A", "--to", "D65"], &input);
    for args in [&["-h"][..], &["-c"], &["-s", "-c", "--goal", "contrast"]] {
        let (one, _) = pcond(args, &adapted);
        let (two, _) = pcond(&[args, &["--white", "A"]].concat(), &input);
        let worst = one.chunks(3).zip(two.chunks(3)).map(|(a, b)| {
            let size = b[1].max(1e-3);
            a.iter().zip(b).map(|(x, y)| (x - y).abs() / size).fold(0.0, f32::max)
        });
        let worst = worst.fold(0.0, f32::max);
        println!("{args:?}: largest difference {worst:.5} of Y");
        assert!(worst < 0.01, "{args:?}: {worst}");
    }
    // Under 0.00562 cd/m2 all is grey of the display's white.
    let (night, _) = pcond(&["-c", "-e", "+8", "--white", "A"], &xyz(1, 1, VIEW, &[2e-3, 1e-3, 1e-4]));
    assert!((night[0] / night[1] - 0.9505).abs() < 2e-3 && (night[2] / night[1] - 1.0891).abs() < 2e-3, "{night:?}");
}

/// A spectrum's rods are integrated: 1700 lm/W by V'(lambda).
#[test]
fn rods_of_a_spectrum_are_integrated() {
    // A line of 5 nm at 505 nm, where rods are most sensitive, dim enough for rods alone.
    let nm: Vec<String> = (0..81).map(|i| format!("{}", 380 + 5 * i)).collect();
    let mut values = vec![0f32; 81];
    values[25] = 1e-7; // W/sr/m2/nm at 505 nm, a hat of 5 nm
    let lines = format!("NCOMP=81\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= {}", nm.join(" "));
    let out = stdout_of("pcond", &["-c", "-e", "1"], &stream(&lines, "-Y 1 +X 1", &values));
    let got = f64::from(floats(split(&out).2)[1]) * 179.0;
    // V' is 0.998 at 505 nm and falls by about 2 % over 5 nm to each side.
    let want = 1700.0 * 0.998 * 1e-7 * 5.0 / 2.26;
    assert!((got / want - 1.0).abs() < 0.02, "{got} {want}");
}

/// Frames share a histogram, and a map follows the one before it.
#[test]
fn frames_share_a_map_and_change_slowly() {
    let (one, two) = (scratch("one.lux"), scratch("two.lux"));
    std::fs::write(&one, scene("ramp")).unwrap();
    std::fs::write(&two, scene("window")).unwrap();
    let (a, b) = (one.to_str().unwrap(), two.to_str().unwrap());
    let histogram = stdout_of("picinfo", &["--histogram", "--also", b, "--", a], b"");
    assert_eq!(String::from_utf8_lossy(&histogram).lines().count(), 100);
    let file = scratch("shared.txt");
    std::fs::write(&file, &histogram).unwrap();
    let shared = map(&["--histogram", file.to_str().unwrap(), a], b"");
    assert_eq!(shared, map(&["--histogram", file.to_str().unwrap(), b], b""));
    // -I reads it from standard input, as Radiance's does.
    let (piped, _) = pcond(&["-I", a], &histogram);
    let (named, _) = pcond(&["--histogram", file.to_str().unwrap(), a], b"");
    assert_eq!(piped, named);
    fails("pcond", &["-I"], &histogram, 2, "standard input");
    fails("picinfo", &["--histogram", a, b], b"", 2, "--also");
    // What vonkries did is undone for it, as pcond undoes it.
    let red = xyz(
        8,
        8,
        VIEW,
        &[2.0, 1.0, 0.1].repeat(64).iter().enumerate().map(|(i, x)| 1.013 * x * (1 + i / 3) as f32).collect::<Vec<_>>(),
    );
    let adapted = stdout_of("vonkries", &["--from", "A", "--to", "D65"], &red);
    let mean = |input: &[u8]| -> f64 {
        let text = String::from_utf8(stdout_of("picinfo", &["--histogram"], input)).unwrap();
        let rows = text.lines().map(|l| l.split_once(' ').unwrap());
        let rows = rows.map(|(l, n)| (l.parse::<f64>().unwrap(), n.parse::<f64>().unwrap()));
        let (sum, total) = rows.fold((0.0, 0.0), |s, (l, n)| (s.0 + l * n, s.1 + n));
        sum / total
    };
    assert!((mean(&red) - mean(&adapted)).abs() < 1e-3);
    // A tenth of a stop a frame, then a limit that does not bind.
    let before = scratch("before.map");
    let path = before.to_str().unwrap();
    pcond(&["-x", path], &scene("ramp"));
    let previous = map(&[], &scene("ramp"));
    let followed = map(&["--previous", path, "--rate", "0.1"], &scene("window"));
    let free = map(&["--previous", path, "--rate", "100"], &scene("window"));
    let alone = map(&[], &scene("window"));
    for (x, y) in &followed {
        if *x > previous[0].0 && *x < previous[99].0 {
            assert!((y - at(&previous, *x)).abs() <= 0.1 * std::f64::consts::LN_2 + 2e-3);
        }
    }
    assert!(followed.windows(2).all(|p| p[0].1 <= p[1].1 + 1e-9));
    assert!(free.iter().zip(&alone).all(|(a, b)| (a.1 - b.1).abs() < 1e-6));
    for f in [one, two, file, before] {
        let _ = std::fs::remove_file(f);
    }
}

/// What the eye and the device do changes the picture as it should.
#[test]
fn options_do_what_they_say() {
    let (plain, _) = pcond(&[], &scene("window"));
    // Surround: the share of white to the power 1.5, xy kept.
    let (dark, _) = pcond(&["--surround", "dark"], &scene("window"));
    for (p, d) in plain.iter().zip(&dark) {
        assert!((p.powf(1.5) - d).abs() < 1e-4 * (1.0 + p), "{p} {d}");
    }
    // Radiance's primaries are RGB of a white of its own.
    let (rgb, _) =
        pcond("-p .64 .33 .29 .60 .15 .06 .3333 .3333".split(' ').collect::<Vec<_>>().as_slice(), &scene("window"));
    assert!(plain.iter().zip(&rgb).all(|(a, b)| (a - b).abs() < 2e-3 * a.abs().max(0.01)), "greys of E stay");
    // A fixation on the window takes the map there.
    let file = scratch("look.txt");
    let input = scratch("window.lux");
    std::fs::write(&input, scene("window")).unwrap();
    std::fs::write(&file, format!("{}\t{}\n", WIDTH * 7 / 10, HEIGHT / 2)).unwrap();
    let (name, path) = (input.to_str().unwrap(), file.to_str().unwrap());
    let looked = map(&["-i", "0.9", "--fixations", path, name], b"");
    let slope = |m: &[(f64, f64)]| at(m, 8.9) - at(m, 8.5); // 4900 to 7300 cd/m2, the window
    assert!(slope(&looked) > slope(&map(&[], &scene("window"))) + 0.05, "{}", slope(&looked));
    let (piped, _) = pcond(&["-i", "0.9", name], &std::fs::read(&file).unwrap());
    let (named, _) = pcond(&["-i", "0.9", "--fixations", path, name], b"");
    assert_eq!(piped, named);
    fails("pcond", &["-i", "0.5", name], b"5 900\n", 1, "line 1");
    // Eyes that come from the sun see less of a room: fewer steps, a darker picture.
    let bright = map(&["-s", "--adapted", "10000"], &scene("ramp"));
    let rested = map(&["-s"], &scene("ramp"));
    assert!(at(&bright, 3.0) < at(&rested, 3.0) - 0.3);
    fails("pcond", &["--adapted", "100"], &scene("ramp"), 2, "-s");
    fails("pcond", &["-m", "x"], &scene("ramp"), 2, "-m");
    fails("pcond", &["--print", "--dmin", "3"], &scene("ramp"), 2, "--dmin");
    // The age of the eye: an old one scatters more into the dark beside the window.
    let dark_side = |args: &[&str]| pcond(args, &scene("window")).0[3 * (60 * WIDTH + 100) + 1];
    let (young, old) =
        (["-v", "-e", "1", "--glare", "cie", "--age", "20"], ["-v", "-e", "1", "--glare", "cie", "--age", "80"]);
    assert!(dark_side(&old) > 1.3 * dark_side(&young));
    // Threads do not matter.
    for args in [&["-h"][..], &["--print"], &["--goal", "colour"]] {
        let with = |n: &str| pcond(&[args, &["--threads", n]].concat(), &scene("window")).0;
        assert_eq!(with("1"), with("3"), "{args:?}");
    }
    for f in [file, input] {
        let _ = std::fs::remove_file(f);
    }
}

/// A pipe is kept, a file read again: the same picture, and a spool where memory does not suffice.
#[test]
fn pipes_files_and_spools_agree() {
    let file = scratch("two.lux");
    std::fs::write(&file, scene("two")).unwrap();
    for args in [&["-h"][..], &[], &["--print"]] {
        let (piped, _) = pcond(args, &scene("two"));
        let (read, _) = pcond(&[args, &[file.to_str().unwrap()]].concat(), b"");
        let (spooled, said) = pcond(&[args, &["--memory", "1k"]].concat(), &scene("two"));
        assert!(said.contains("spooled") && piped == read && piped == spooled, "{args:?}");
    }
    let _ = std::fs::remove_file(&file);
}
