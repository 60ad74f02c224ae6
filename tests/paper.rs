//! The numbers of [Ward 2001], each test named after the equation, table or sentence that it holds, and the inputs on which
//! its methods fail. Expected values come from the paper, from the literature, or from tests/ref (numpy, not luxpipe).

#[path = "../examples/colour/mod.rs"]
mod colour;
mod common;

use std::collections::HashMap;
use std::fs;

use clap::ValueEnum;
use colour::{Chart, approaches, blueflower, cats, sampling, statistics};
use common::{floats, page_is_printed, root, run, split, stdout_of, stream};
use luxpipe::color::difference::uv;
use luxpipe::color::{Cat, Xy};
use luxpipe::spectral::{Observer, Sampling, builtin};

/// Rows of a table in tests/ref: the first `keys` cells joined by a comma, and the numbers behind them.
fn reference(name: &str, keys: usize) -> HashMap<String, Vec<f64>> {
    let text = fs::read_to_string(root().join("tests/ref").join(name)).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[..keys].join(","), cells[keys..].iter().map(|c| c.parse().unwrap()).collect())
    });
    rows.collect()
}

fn near(got: &[f64], want: &[f64], tolerance: f64) -> bool {
    got.len() == want.len() && got.iter().zip(want).all(|(a, b)| (a - b).abs() <= tolerance)
}

/// Within a tenth of the reference, or 0.01.
fn like(got: f64, want: f64) -> bool {
    (got - want).abs() <= (0.1 * want).max(0.01)
}

/// Erratum: the paper prints (0.9478, 1.0334, 1.0850), which needs a white of (0.3127, 0.3293); Eq. (7) needs 0.3290.
#[test]
fn eq6_d65_cone_primaries() {
    let ours = blueflower::d65_cone_primaries();
    let printed = [0.9478, 1.0334, 1.0850];
    assert!(near(&ours, &[0.9482, 1.0329, 1.0868], 5e-5), "{ours:?}");
    assert!(near(&ours, &printed, 2e-3) && !near(&ours, &printed, 2e-4), "{ours:?}");
    let other = Cat::Cmccat2000.matrix().apply(Xy { x: 0.3127, y: 0.3293 }.xyz());
    assert!(near(&other, &printed, 5e-5), "{other:?}");
}

#[test]
fn eq7_matrices() {
    let c_b = [[3.1273, -1.6836, -0.4867], [-0.9806, 1.9476, 0.0282], [0.0605, -0.2036, 1.3404]];
    let c_a = [[2.9355, -2.0416, -0.5116], [-1.0247, 2.1431, -0.0500], [0.0732, -0.1798, 3.0895]];
    for (light, want) in [("B", c_b), ("A", c_a)] {
        let got = blueflower::eq7(light).0;
        assert!(near(got.as_flattened(), want.as_flattened(), 5e-5), "C_{light}: {got:?}");
    }
}

#[test]
fn conventional_rgb() {
    let rgb = blueflower::c709().apply(blueflower::published());
    assert!(near(&rgb, &[0.246, 0.217, 0.495], 5e-4), "{rgb:?}");
}

#[test]
fn table1_blueflower() {
    let want = reference("blueflower.csv", 2);
    for (set, table, _) in blueflower::SETS {
        for light in blueflower::LIGHTS {
            let xyz = blueflower::xyz(table, light);
            let rows = [
                ("XYZ", xyz),
                ("rgb_abs", blueflower::c709().apply(xyz)),
                ("rgb_adj", blueflower::eq7(light).apply(xyz)),
            ];
            for (what, got) in rows {
                let key = format!("{set},{what} {light}");
                assert!(near(&got, &want[&key], 5e-4), "{key}: {got:?} for {:?}", want[&key]);
            }
        }
    }
}

/// Each data set to 0.05 of its independent value, and both inside a band around the paper's figure. No chart measured
/// since gives all the paper's figures; where the band misses the figure (more than 5), the page says "not held".
#[test]
fn claims() {
    let want = reference("blueflower.csv", 2);
    let bands = HashMap::from([
        ("conventional_vs_D65", (8.5, 10.5)),
        ("white_C_vs_D65", (10.0, 10.8)),
        ("adapted_B", (0.7, 1.3)),
        ("adapted_A", (4.0, 5.5)),
        ("unadapted_B", (20.0, 22.5)),
        ("unadapted_A", (75.0, 80.5)),
        ("rgb_product_reflD65_B_adapted", (0.5, 1.5)),
        ("rgb_product_reflD65_A_adapted", (7.5, 8.7)),
        ("rgb_product_reflC_vonKries_to_D65_B_adapted", (0.5, 1.5)),
        ("rgb_product_reflC_vonKries_to_D65_A_adapted", (7.5, 8.7)),
    ]);
    let all = blueflower::claims();
    assert_eq!(all.len(), bands.len());
    for claim in all {
        let (low, high) = bands[claim.key];
        for ((set, ..), got) in blueflower::SETS.iter().zip(claim.ours) {
            let want = want[&format!("{set},{}", claim.key)][0];
            assert!((got - want).abs() < 0.05, "{set} {}: {got} for {want}", claim.key);
            assert!((low..=high).contains(&got), "{set} {}: {got} outside {low} to {high}", claim.key);
        }
        let not_held = ["conventional_vs_D65", "adapted_A", "unadapted_B", "unadapted_A"].contains(&claim.key);
        assert_eq!(claim.verdict().starts_with("not"), not_held, "{}: {}", claim.key, claim.verdict());
    }
}

#[test]
fn sampling_errors() {
    let chart = Chart::ohta();
    let lights = sampling::LIGHTS.map(|l| chart.light(l));
    let mut want = reference("sampling_errors.csv", 1);
    want.extend(reference("bins_exact.csv", 1));
    let mut compared = 0;
    for method in sampling::methods() {
        let got = sampling::summary(&method, &chart, &lights);
        if let Some(want) = want.get(&method.name) {
            assert!(got.iter().zip(want).all(|(a, b)| like(*a, *b)), "{}: {got:?} for {want:?}", method.name);
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
}

#[test]
fn adaptation_matrices() {
    let chart = Chart::ohta();
    let want = reference("cats.csv", 2);
    for name in cats::names() {
        for light in cats::LIGHTS {
            let [mean, _, max] = statistics(cats::errors(&name, light, &chart));
            let want = &want[&format!("{name},{light}")];
            assert!(like(mean, want[0]) && like(max, want[1]), "{name} {light}: {mean} {max} for {want:?}");
        }
    }
}

/// "The error is zero by construction for direct reflection" holds; "negligible" for more does not hold as worded.
#[test]
fn relative_color_approximation() {
    let want = reference("approaches.csv", 2);
    let results = approaches::results(&Chart::ohta());
    assert_eq!(3 * results.len(), want.len());
    for (name, bounces) in &results {
        for (k, [mean, _, max]) in bounces.iter().enumerate() {
            let want = &want[&format!("{name},{}", k + 1)];
            assert!(like(*mean, want[0]) && like(*max, want[1]), "{name} {}: {mean} {max} for {want:?}", k + 1);
        }
        assert!(!name.starts_with("relative") || bounces[0][2] < 1e-9, "{name}");
    }
    let mean = |name: &str| results.iter().find(|r| r.0 == name).unwrap().1[1][0];
    assert!(mean("relative: absolute RGB") > 7.0 && mean("relative: over white in BT.2020") < 1.1);
}

#[test]
fn the_page_is_up_to_date() {
    page_is_printed("docs/paper-colour.md", &colour::page());
}

/// A table of spectra/, read without luxpipe, at every nm: linear between rows, zero outside.
fn plain_table(name: &str) -> Vec<f64> {
    let text = fs::read_to_string(root().join("spectra").join(format!("{name}.csv"))).unwrap();
    let rows: Vec<(f64, f64)> = text
        .lines()
        .filter_map(|l| l.split_once(','))
        .filter_map(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)))
        .collect();
    let mut values = vec![0.0; 401];
    for pair in rows.windows(2) {
        for (i, value) in values.iter_mut().enumerate() {
            let nm = 380.0 + i as f64;
            if (pair[0].0..=pair[1].0).contains(&nm) {
                let t = (nm - pair[0].0) / (pair[1].0 - pair[0].0);
                *value = pair[0].1 * (1.0 - t) + pair[1].1 * t;
            }
        }
    }
    values
}

/// 1 nm spectra of one row through the real spec2xyz, as XYZ in cd/m2.
fn spec2xyz(spectra: &[Vec<f64>], lines: &str) -> Vec<[f64; 3]> {
    let values: Vec<f32> = spectra.iter().flatten().map(|v| *v as f32).collect();
    let size = format!("-Y 1 +X {}", spectra.len());
    let out = stdout_of(
        "spec2xyz",
        &[],
        &stream(&format!("NCOMP={}\nUNITS=W/sr/m2/nm\n{lines}", spectra[0].len()), &size, &values),
    );
    floats(split(&out).2).chunks_exact(3).map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect()
}

fn every_nm_line() -> String {
    let nm: Vec<String> = (380..=780).map(|nm| nm.to_string()).collect();
    format!("WAVELENGTHS= {}", nm.join(" "))
}

/// Eq. (4) for 24 patches under each of 29 illuminants against a sum in double precision.
#[test]
fn patches_under_every_illuminant() {
    let cmf = ["cie1931_x", "cie1931_y", "cie1931_z"].map(plain_table);
    let named = |prefix: &str| builtin::names().filter(|n| n.starts_with(prefix)).map(plain_table).collect::<Vec<_>>();
    let (patches, lights) = (named("cc_ohta_"), named("illuminant_"));
    assert_eq!((patches.len(), lights.len()), (24, 29));
    let mut worst = 0f64;
    for light in &lights {
        let radiance: Vec<Vec<f64>> =
            patches.iter().map(|r| r.iter().zip(light).map(|(a, b)| a * b).collect()).collect();
        for (got, l) in spec2xyz(&radiance, &every_nm_line()).iter().zip(&radiance) {
            for c in 0..3 {
                let want: f64 = 683.0 * (0..401).map(|i| cmf[c][i] * l[i]).sum::<f64>();
                worst = worst.max((got[c] / want - 1.0).abs());
            }
        }
    }
    println!("largest relative difference {worst:.1e}");
    assert!(worst < 1e-5, "{worst}");
}

/// Under a lamp with lines the error is not monotone in N: 8.8 at 9 points, 49 at 10; 24 at 16, 34 at 17. A stability test
/// sweeps N.
#[test]
fn fl11_is_not_monotone_in_n() {
    let chart = Chart::ohta();
    let light = chart.light("FL11");
    let want = reference("fl11_sweep.csv", 1);
    let got: Vec<[f64; 3]> = (3..=40).map(|n| sampling::fl11(n, &chart, &light)).collect();
    for (n, got) in (3..).zip(&got) {
        let want = &want[&n.to_string()];
        assert!(got.iter().zip(want).all(|(a, b)| like(*a, *b)), "N = {n}: {got:?} for {want:?}");
    }
    let points = |n: usize| got[n - 3][0];
    assert!(points(10) > 5.0 * points(9) && points(17) > 1.3 * points(16));
    assert!(got.windows(2).filter(|w| w[1][0] > w[0][0]).count() >= 10);
    // With the source in the weights 20 bins do what 40 points cannot.
    assert!(got[20 - 3][2] < 0.2 * points(40));
}

/// A laser 10 nm wide: spec2xyz is exact on the 1 nm grid, 20 nm bins keep its luminance within 9 % and shift its colour by
/// up to 0.018 in u'v', points 20 nm apart lose it or weigh it double.
#[test]
fn lasers_ten_nanometres_wide() {
    let want = reference("lasers.csv", 1);
    for centre in [450i32, 532, 640] {
        let want: Vec<[f64; 3]> = want[&centre.to_string()].chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        let laser: Vec<f64> = (380..=780).map(|nm| f64::from(u8::from((nm - centre).abs() <= 5))).collect();
        let table = colour::spectrum(&laser);
        let bins = Sampling::bins(380.0, 780.0, 20).unwrap().sample(&table);
        let points: Vec<f64> = (0..21).map(|i| table.at(380.0 + 20.0 * f64::from(i))).collect();
        let nm: Vec<f64> = (0..21).map(|i| 380.0 + 20.0 * f64::from(i)).collect();
        let cmf = Observer::cie1931().unwrap().cmf;
        let got = [
            spec2xyz(&[laser], &every_nm_line())[0],
            spec2xyz(&[bins], "WAVELENGTH_SPLITS= 780 588 480 380")[0],
            cmf.each_ref().map(|c| 683.0 * 20.0 * nm.iter().zip(&points).map(|(x, p)| c.at(*x) * p).sum::<f64>()),
        ];
        for (got, want) in got.iter().zip(&want) {
            let want = want.map(|v| 683.0 * v);
            assert!(
                (0..3).all(|c| (got[c] - want[c]).abs() <= 1e-5 * want[c].max(want[1])),
                "{centre}: {got:?} {want:?}"
            );
        }
        let (a, b) = (uv(got[0]).unwrap(), uv(got[1]).unwrap());
        let shift = (a[0] - b[0]).hypot(a[1] - b[1]);
        println!(
            "{centre} nm: bins {:.3}, shift {shift:.4}; points {:.3}",
            got[1][1] / got[0][1],
            got[2][1] / got[0][1]
        );
        assert!((got[1][1] / got[0][1] - 1.0).abs() < 0.09 && (1e-4..0.03).contains(&shift), "{shift}");
        assert!(got[2][1] == 0.0 || got[2][1] > 1.8 * got[0][1], "{got:?}");
    }
}

const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nPRIMARIES= 1 0 0 1 0 0 .333 .333";

/// A violet white at the edge of the locus: no sensor set can move it to D65 sensibly. Responses by numpy.
#[test]
fn whites_at_the_edge_of_the_locus_are_refused() {
    for (cat, message) in [
        ("cmccat2000", "white 0.17,0.005 has a green sensor response of -11.87"),
        ("vonkries", "multiplies the blue sensor by 0.0066"),
        ("bradford", "white 0.17,0.005 has a green sensor response of -17.73"),
        ("sharp", "white 0.17,0.005 has a green sensor response of -20.74"),
        ("cat02", "white 0.17,0.005 has a red sensor response of -1.45"),
        ("cat16", "multiplies the blue sensor by 0.0069"),
    ] {
        let input = stream(XYZ, "-Y 1 +X 1", &[1.0; 3]);
        for (args, input) in [(["--print"].as_slice(), &[][..]), (&[], &input)] {
            let output = run("vonkries", &[args, &["--from", "0.17,0.005", "--cat", cat]].concat(), input);
            let text = String::from_utf8_lossy(&output.stderr);
            assert_eq!((output.status.code(), text.lines().count()), (Some(1), 1), "{cat}: {text}");
            assert!(text.contains(message) && output.stdout.is_empty(), "{cat}: {text}");
        }
        // Deep red, 700 nm: CAT16 alone takes it, with a gain of 25 on its blue sensor.
        let red = run("vonkries", &["--print", "--from", "0.7346,0.2654", "--cat", cat], b"");
        assert_eq!(red.status.code(), Some(i32::from(cat != "cat16")), "{cat}");
    }
}

#[test]
fn dark_black_and_negative_colours_stay_finite() {
    let values: Vec<f32> = [
        [0.0, 0.0, 0.0],
        [1e-40, 1e-40, 1e-40], // denormal
        [1e-30, 1e-30, 1e-30],
        [1e30, 1e30, 1e30],
        [-0.1, 0.2, 0.3],
        [0.2, -0.1, 0.3],
        [-1.0, -1.0, -1.0],
        [0.3, 0.0, 1.5], // no luminance, much colour
    ]
    .concat();
    let input = stream(&format!("{XYZ}\nWHITE= 0.4475 0.4075"), "-Y 1 +X 8", &values);
    for cat in Cat::value_variants().iter().filter_map(|c| c.to_possible_value()) {
        let adapted = stdout_of("vonkries", &["--cat", cat.get_name()], &input);
        for gamut in ["none", "clip", "desaturate"] {
            let rgb = floats(split(&stdout_of("xyz2rgb", &["--quiet", "--gamut", gamut], &adapted)).2);
            assert!(rgb.iter().all(|v| v.is_finite()), "{} {gamut}: {rgb:?}", cat.get_name());
            assert!(rgb[..3].iter().all(|v| *v == 0.0), "black is {:?}", &rgb[..3]);
            assert!(gamut == "none" || rgb.iter().all(|v| *v >= 0.0), "{gamut}: {rgb:?}");
        }
    }
}

/// Pure light under A and D65 through the real vonkries. Sharpened sensors respond negatively to part of the locus, and
/// moving between A and D65 gives some violets and blues a negative luminance, as [Brill & Suesstrunk 2008, Color Res. Appl.
/// 33(5)] found of CIECAM02; only the cone sensors of Hunt, Pointer and Estevez do neither.
#[test]
fn sensors_break_down_for_pure_blues() {
    let text = fs::read_to_string(root().join("tests/ref/cat_breakdowns.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(2).map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 6);
    let cmf = ["cie1931_x", "cie1931_y", "cie1931_z"].map(plain_table);
    let locus: Vec<[f64; 3]> = (0..401).map(|i| [cmf[0][i], cmf[1][i], cmf[2][i]]).collect();
    let pixels: Vec<f32> = locus.as_flattened().iter().map(|v| *v as f32).collect();
    let span = |negative: Vec<usize>| match (negative.first(), negative.last()) {
        (Some(a), Some(b)) => format!("{}-{}:{}", a + 380, b + 380, negative.len()),
        _ => "-".to_string(),
    };
    let below = |values: &[[f64; 3]], c: usize| span((0..401).filter(|i| values[*i][c] < 0.0).collect());
    for row in rows {
        let cat = Cat::from_str(row[0], false).unwrap();
        let sensors: Vec<[f64; 3]> = locus.iter().map(|v| cat.matrix().apply(*v)).collect();
        assert_eq!([0, 1, 2].map(|c| below(&sensors, c)), row[1..4], "{} responses", row[0]);
        let adapt = |from: &str, to: &str| -> Vec<[f64; 3]> {
            let input = stream(XYZ, "-Y 1 +X 401", &pixels);
            let out = stdout_of("vonkries", &["--cat", row[0], "--from", from, "--to", to], &input);
            floats(split(&out).2).chunks_exact(3).map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect()
        };
        let (a, d65) = ("0.4475,0.4075", "0.3127,0.3290");
        let seen = adapt(a, d65);
        assert_eq!([below(&seen, 1), below(&adapt(d65, a), 1)], row[4..6], "{} luminances", row[0]);
        let gain = seen[70][1] / locus[70][1];
        assert!((gain / row[6].parse::<f64>().unwrap() - 1.0).abs() < 1e-4, "{} at 450 nm: {gain}", row[0]);
    }
}

/// A published breakdown: CAT02 for a purple lamp, white responses as S. A. Burns prints them (supplement to "Chromatic
/// adaptation transform by spectral reconstruction", Color Res. Appl. 44(5), 2019). A blue inside the locus, with no red
/// response and a tenth of the lamp's green and blue, has a negative X when moved to E.
#[test]
fn cat02_under_a_purple_lamp() {
    let lamp = [2.145, 1.0, 4.729];
    let responses = Cat::Cat02.matrix().apply(lamp);
    assert!(near(&responses, &[1.2338, 0.2168, 4.6700], 1e-3), "{responses:?}");
    let white = Xy::of(lamp).unwrap().to_string();
    // CAT02's published inverse times (0, 0.02168, 0.4670): chromaticity (0.133, 0.073), inside the locus.
    let blue = [
        -0.278869 * 0.02168 + 0.182745 * 0.4670,
        0.473533 * 0.02168 + 0.072098 * 0.4670,
        -0.005698 * 0.02168 + 1.015326 * 0.4670,
    ];
    let input = stream(XYZ, "-Y 1 +X 1", &blue.map(|v| v as f32));
    let adapted = floats(split(&stdout_of("vonkries", &["--cat", "cat02", "--from", &white, "--to", "E"], &input)).2);
    // The same inverse times (0, 0.1, 0.1).
    assert!(
        near(&adapted.iter().map(|v| f64::from(*v)).collect::<Vec<_>>(), &[-0.009612, 0.054563, 0.100963], 2e-4),
        "{adapted:?}"
    );
}
