//! The paper's Figures 7 and 8 on a small control tower: how tone curves begin at black, and how they follow the histogram.

mod common;

use common::*;

/// The tower, small, adapted to the display, as a file.
fn tower() -> std::path::PathBuf {
    let scene = root().join("scenes/tower.toml").display().to_string();
    let light = stdout_of("spectrace", &["--width", "96", "--samples", "256", "--bands", "20", &scene], b"");
    let path = std::env::temp_dir().join(format!("luxpipe-tower-{}.lux", std::process::id()));
    std::fs::write(&path, stdout_of("vonkries", &["--to", "D65"], &light)).unwrap();
    path
}

fn pairs(text: &str) -> Vec<(f64, f64)> {
    let number = |w: Option<&str>| w.unwrap().parse::<f64>().unwrap();
    let line = |l: &str| {
        let mut words = l.split_ascii_whitespace();
        (number(words.next()), number(words.next()))
    };
    text.lines().map(line).collect()
}

/// Ranks, equals sharing their mean.
fn ranks(values: &[f64]) -> Vec<f64> {
    let less = |x: f64| values.iter().filter(|y| **y < x - 1e-9).count() as f64;
    let same = |x: f64| values.iter().filter(|y| (**y - x).abs() <= 1e-9).count() as f64;
    values.iter().map(|x| less(*x) + 0.5 * same(*x)).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product =
        |x: &[f64], mx: f64, y: &[f64], my: f64| -> f64 { x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum() };
    product(a, ma, b, mb) / (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt()
}

#[test]
fn curves_follow_the_histogram_and_begin_as_the_linear_one() {
    let picture = tower();
    let name = picture.to_str().unwrap();
    let histogram = pairs(&String::from_utf8(stdout_of("picinfo", &["--histogram", name], b"")).unwrap());
    let total: f64 = histogram.iter().map(|h| h.1).sum();
    for operator in ["--print", "--goal=contrast"] {
        let file = picture.with_extension("map");
        stdout_of("pcond", &[operator, "-x", file.to_str().unwrap(), name], b"");
        let map: Vec<(f64, f64)> =
            pairs(&std::fs::read_to_string(&file).unwrap()).iter().map(|(w, d)| (w.log10(), d.log10())).collect();
        let _ = std::fs::remove_file(&file);
        let at = |x: f64| {
            let i = map.partition_point(|p| p.0 < x).clamp(1, map.len() - 1);
            let ((x0, y0), (x1, y1)) = (map[i - 1], map[i]);
            y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        };
        let step = histogram[1].0 - histogram[0].0;
        let slopes: Vec<f64> =
            histogram.iter().map(|(x, _)| (at(x + 0.5 * step) - at(x - 0.5 * step)) / step).collect();
        // Figure 8. A curve has as much contrast as the world at most: counts over the ceiling's are equals.
        let ceiling =
            slopes.iter().zip(&histogram).filter(|(s, _)| **s > 0.99).map(|(_, h)| h.1).fold(f64::MAX, f64::min);
        let counts: Vec<f64> = histogram.iter().map(|h| h.1.min(ceiling)).collect();
        let plain: Vec<f64> = histogram.iter().map(|h| h.1).collect();
        let (rank, raw) = (correlation(&ranks(&counts), &ranks(&slopes)), correlation(&ranks(&plain), &ranks(&slopes)));
        println!("{operator}: rank correlation of histogram and slope {raw:.3}, {rank:.3} with counts to the ceiling");
        assert!(raw > 0.8, "{operator}: {raw}");
        // Figure 7. The darkest fifth of the pixels, but for the darkest few: the slope they see is a linear map's, 1.
        let (mut below, mut sum, mut weight) = (0.0, 0.0, 0.0);
        for ((_, count), slope) in histogram.iter().zip(&slopes) {
            below += count / total;
            if (0.03..0.2).contains(&below) {
                (sum, weight) = (sum + count * slope, weight + count);
            }
        }
        println!("{operator}: slope near black {:.3}", sum / weight);
        assert!((sum / weight - 1.0).abs() < 0.05, "{operator}: {}", sum / weight);
    }
    let _ = std::fs::remove_file(&picture);
}
