//! `pglare` beside evalglare 3.06 and beside closed forms; its fisheyes are made here, from formulas.

mod common;

use std::f64::consts::PI;

use common::{fails, run, stdout_of, stream};
use luxpipe::view::View;

/// A picture of Y with its view.
struct Eye {
    view: String,
    n: usize,
    values: Vec<f32>,
}

/// Luminances that RGBE holds exactly, so that evalglare saw the same numbers: 179 (m + 1/2) / 256 2^e.
fn coded(luminance: f64) -> f32 {
    let v = luminance / 179.0;
    let e = v.log2().floor() as i32 + 1;
    let m = (v / 2f64.powi(e) * 256.0).floor();
    ((m + 0.5) / 256.0 * 2f64.powi(e) * 179.0) as f32
}

/// A number from 0 to 1 for each pixel: SplitMix64.
fn noise(index: usize, seed: u64) -> f64 {
    let mut z = (index as u64 + seed).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^= z >> 31;
    (z >> 40) as f64 / 16_777_216.0
}

impl Eye {
    fn new(kind: char, n: usize, background: f64) -> Eye {
        Eye { view: format!("-vt{kind} -vh 180 -vv 180"), n, values: vec![coded(background); n * n] }
    }

    /// Luminances by pixel, azimuth to the right and elevation in degrees, where `f` has one.
    fn paint(mut self, f: impl Fn(usize, f64, f64) -> Option<f64>) -> Eye {
        let view = View::parse(&self.view).unwrap();
        for i in 0..self.n * self.n {
            let (u, v) =
                (((i % self.n) as f64 + 0.5) / self.n as f64, 1.0 - ((i / self.n) as f64 + 0.5) / self.n as f64);
            let Some([x, y, z]) = view.direction(u, v) else { continue };
            if let Some(l) = f(i, x.atan2(z).to_degrees(), y.clamp(-1.0, 1.0).asin().to_degrees()) {
                self.values[i] = coded(l);
            }
        }
        self
    }

    /// A disk: azimuth, elevation, radius in degrees, luminance.
    fn disk(self, azimuth: f64, elevation: f64, radius: f64, luminance: f64) -> Eye {
        let unit = |a: f64, e: f64| {
            let (a, e) = (a.to_radians(), e.to_radians());
            [a.sin() * e.cos(), e.sin(), a.cos() * e.cos()]
        };
        let centre = unit(azimuth, elevation);
        let near = radius.to_radians().cos();
        self.paint(|_, a, e| {
            let dot: f64 = unit(a, e).iter().zip(centre).map(|(p, q)| p * q).sum();
            (dot >= near).then_some(luminance)
        })
    }

    fn stream(&self) -> Vec<u8> {
        let header = format!("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2\nVIEW= {}", self.view);
        stream(&header, &format!("-Y {} +X {}", self.n, self.n), &self.values)
    }

    fn report(&self, options: &[&str]) -> toml::Table {
        report(&self.stream(), options)
    }
}

/// `--json` as a table: JSON's objects and numbers in TOML's spelling.
fn report(stream: &[u8], options: &[&str]) -> toml::Table {
    let text = String::from_utf8(stdout_of("pglare", &[&["--json", "--quiet"], options].concat(), stream)).unwrap();
    assert!(!text.contains("inf") && !text.contains("NaN"), "{text}");
    let text = text.trim().replace("\":", "\"=").replace("null", "\"null\"");
    toml::from_str::<toml::Table>(&format!("all = {text}")).unwrap()["all"].as_table().unwrap().clone()
}

fn number(table: &toml::Table, key: &str) -> f64 {
    table[key].as_float().unwrap_or_else(|| panic!("{key} is {}", table[key]))
}

fn sources(table: &toml::Table) -> Vec<&toml::Table> {
    table["sources"].as_array().unwrap().iter().map(|s| s.as_table().unwrap()).collect()
}

fn close(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance * want.abs(), "{what}: {got}, expected {want} within {tolerance}");
}

/// The scenes that evalglare was asked about.
fn eye(name: &str, kind: char, n: usize) -> Eye {
    let plain = |l| Eye::new(kind, n, l);
    match name {
        "uniform" => plain(100.0),
        "disk30" => plain(100.0).disk(30.0, 0.0, 3.0, 20000.0),
        "two_near" => plain(100.0).disk(-10.0, 20.0, 2.0, 2e4).disk(-3.0, 20.0, 1.0, 4e4),
        "two_far" => plain(100.0).disk(-10.0, 20.0, 2.0, 2e4).disk(40.0, 5.0, 3.0, 1e4),
        "dim" => plain(2.0).disk(10.0, 20.0, 1.0, 5000.0),
        "high" => plain(100.0).disk(0.0, 70.0, 6.0, 3e4),
        "below" => plain(100.0).disk(15.0, -25.0, 4.0, 15000.0),
        "factor" => plain(100.0).disk(30.0, 10.0, 5.0, 900.0),
        "peaks" => plain(100.0).disk(20.0, 10.0, 8.0, 2e4).disk(17.0, 10.0, 1.0, 2e5).disk(26.0, 10.0, 1.0, 2e5),
        // A noisy room, a window from 15 to 45 degrees, the sun in it.
        "window" => plain(100.0)
            .paint(|i, a, e| {
                let window = a > 15.0 && a < 45.0 && e > -5.0 && e < 25.0;
                let (low, high, seed) = if window { (2500.0, 8000.0, 3) } else { (50.0, 300.0, 9) };
                Some(low * f64::powf(high / low, noise(i, seed)))
            })
            .disk(35.0, 18.0, 0.8, 1e6),
        other => panic!("{other}"),
    }
}

struct Reference {
    name: &'static str,
    kind: char,
    n: usize,
    options: &'static [&'static str],
    /// Ev, background, DGP, DGI, UGR.
    values: [f64; 5],
    /// Solid angle, luminance, position index of each source, those that give most light first.
    sources: &'static [[f64; 3]],
}

/// Printed by evalglare 3.06 for these pictures as RGBE (tests/ref/README.md).
#[rustfmt::skip]
const EVALGLARE: &[Reference] = &[
    Reference { name: "uniform", kind: 'a', n: 600, options: &[], values: [315.221259, 100.338042, 0.177503, 0.0, 0.0], sources: &[] },
    Reference { name: "uniform", kind: 'h', n: 600, options: &[], values: [314.014775, 99.954006, 0.177433, 0.0, 0.0], sources: &[] },
    Reference { name: "disk30", kind: 'a', n: 600, options: &[], values: [463.09543, 100.100746, 0.300791, 22.821152, 28.821136], sources: &[[0.0085850075, 20003.25, 1.463529]] },
    Reference { name: "disk30", kind: 'h', n: 600, options: &[], values: [462.181541, 99.71624, 0.300895, 22.827707, 28.83626], sources: &[[0.0086022762, 20003.25, 1.464631]] },
    Reference { name: "disk30", kind: 'a', n: 1024, options: &[], values: [464.101691, 100.099029, 0.300783, 22.820721, 28.829178], sources: &[[0.0086443179, 20003.25, 1.466889]] },
    Reference { name: "disk30", kind: 'h', n: 1024, options: &[], values: [463.175514, 99.875287, 0.300863, 22.826197, 28.836327], sources: &[[0.0086311068, 20003.25, 1.4659]] },
    Reference { name: "two_near", kind: 'a', n: 600, options: &[], values: [423.774673, 100.192967, 0.271954, 19.974331, 25.731682], sources: &[[0.0048957045, 23952.909315, 2.063418]] },
    Reference { name: "two_near", kind: 'h', n: 600, options: &[], values: [420.032054, 99.812411, 0.27123, 19.901722, 25.637909], sources: &[[0.004778548, 23968.91789, 2.071595]] },
    Reference { name: "two_far", kind: 'a', n: 600, options: &[], values: [453.050506, 100.010721, 0.264352, 20.915615, 25.246471], sources: &[[0.0039290434, 20003.25, 2.064701], [0.0086718146, 10001.625, 2.062613]] },
    Reference { name: "two_far", kind: 'h', n: 600, options: &[], values: [449.57867, 99.63107, 0.263747, 20.857199, 25.169146], sources: &[[0.0038311953, 20003.25, 2.075717], [0.0086117607, 10001.625, 2.064286]] },
    Reference { name: "dim", kind: 'a', n: 600, options: &[], values: [10.25463, 2.004289, 0.326781, 15.523046, 22.375187], sources: &[[0.0008553475, 5000.8125, 2.063728]] },
    Reference { name: "dim", kind: 'h', n: 600, options: &[], values: [10.661999, 1.996561, 0.327591, 15.659515, 22.711138], sources: &[[0.0009485916, 5000.8125, 2.074736]] },
    Reference { name: "high", kind: 'a', n: 600, options: &[], values: [666.650919, 99.962428, 0.217753, 10.558722, 19.847458], sources: &[[0.0344614366, 29982.5, 16.0]] },
    Reference { name: "high", kind: 'h', n: 600, options: &[], values: [662.685479, 99.581341, 0.217589, 10.550362, 19.837357], sources: &[[0.0342303806, 29982.5, 16.0]] },
    Reference { name: "below", kind: 'a', n: 600, options: &[], values: [513.824364, 99.912071, 0.293754, 22.571558, 28.572094], sources: &[[0.0152546698, 14991.25, 1.516856]] },
    Reference { name: "below", kind: 'h', n: 600, options: &[], values: [512.726577, 99.527802, 0.293814, 22.576143, 28.583326], sources: &[[0.0152613452, 14991.25, 1.517659]] },
    Reference { name: "window", kind: 'a', n: 600, options: &[], values: [1934.916915, 129.796268, 0.436533, 28.47337, 41.644878], sources: &[[0.2661678045, 4739.143998, 1.872189], [0.0006088198, 999536.0, 2.729392]] },
    Reference { name: "window", kind: 'h', n: 600, options: &[], values: [1932.692939, 129.191123, 0.436195, 28.461321, 41.635239], sources: &[[0.2663372789, 4722.274546, 1.846103], [0.0006133181, 999536.0, 2.750524]] },
    Reference { name: "window", kind: 'a', n: 1024, options: &[], values: [1931.072824, 129.678279, 0.43608, 28.439569, 41.614998], sources: &[[0.2664597223, 4718.73704, 1.875956], [0.000609569, 999536.0, 2.74403]] },
    Reference { name: "window", kind: 'h', n: 1024, options: &[], values: [1932.268924, 129.317987, 0.436369, 28.470486, 41.648045], sources: &[[0.2663862968, 4720.416295, 1.853936], [0.0006120509, 999536.0, 2.740874]] },
    Reference { name: "factor", kind: 'a', n: 600, options: &["-b", "5"], values: [331.428448, 99.688938, 0.18238, 6.21958, 9.009825], sources: &[[0.0238779397, 897.796875, 1.899805]] },
    Reference { name: "factor", kind: 'h', n: 600, options: &["-b", "5"], values: [330.309596, 99.301392, 0.182382, 6.273966, 9.063351], sources: &[[0.0240038053, 897.796875, 1.893874]] },
    Reference { name: "peaks", kind: 'a', n: 600, options: &[], values: [1748.177356, 98.535819, 0.40223, 31.366774, 39.866543], sources: &[[0.0593830568, 20003.25, 1.585657], [0.0009752205, 199764.0, 1.749635], [0.0009139445, 199764.0, 1.520959]] },
    Reference { name: "peaks", kind: 'h', n: 600, options: &[], values: [1748.578865, 98.15515, 0.402604, 31.379463, 39.912861], sources: &[[0.059249792, 20003.25, 1.582986], [0.0009673987, 199764.0, 1.519832], [0.0009415832, 199764.0, 1.761039]] },
];

#[test]
fn evalglare_agrees_within_two_percent() {
    println!(
        "{:9} {:3} {:>5} {:>8} {:>8} {:>8} {:>8} {:>8}   worst source",
        "scene", "", "", "Ev", "Lb", "DGP", "DGI", "UGR"
    );
    for r in EVALGLARE {
        let report = eye(r.name, r.kind, r.n).report(r.options);
        let what = format!("{} -vt{} {}", r.name, r.kind, r.n);
        let keys = ["illuminance_lux", "background_cd_m2", "dgp", "dgi", "ugr"];
        let mut errors = Vec::new();
        for (key, want) in keys.iter().zip(r.values) {
            let got = number(&report, key);
            close(&format!("{what} {key}"), got, want, 0.02);
            errors.push(if want == 0.0 { "0".into() } else { format!("{:+.2} %", 100.0 * (got / want - 1.0)) });
        }
        let found = sources(&report);
        assert_eq!(found.len(), r.sources.len(), "{what}");
        let mut worst: f64 = 0.0;
        for (source, [sr, cd_m2, index]) in found.iter().zip(r.sources) {
            for (key, want) in [("solid_angle_sr", sr), ("luminance_cd_m2", cd_m2)] {
                close(&format!("{what} {key}"), number(source, key), *want, 0.02);
            }
            // evalglare takes the index of the pixel that holds the centre, up to a pixel away.
            close(&format!("{what} position index"), number(source, "position_index"), *index, 0.04);
            worst = worst.max((number(source, "solid_angle_sr") / sr - 1.0).abs());
        }
        let e = errors;
        println!(
            "{:9} -vt{} {:>4} {:>8} {:>8} {:>8} {:>8} {:>8}   {:.3} % sr",
            r.name,
            r.kind,
            r.n,
            e[0],
            e[1],
            e[2],
            e[3],
            e[4],
            100.0 * worst
        );
    }
}

#[test]
fn one_luminance_everywhere_gives_pi_times_as_much() {
    for (kind, n, tolerance) in [('a', 300, 1e-4), ('h', 300, 1e-2), ('h', 1024, 5e-3)] {
        let eye = Eye::new(kind, n, 500.0);
        let l = f64::from(eye.values[0]);
        let r = eye.report(&[]);
        close("Ev", number(&r, "illuminance_lux"), PI * l, tolerance);
        close("average", number(&r, "average_cd_m2"), l, 1e-6);
        close("hemisphere", number(&r, "solid_angle_sr"), 2.0 * PI, tolerance);
        close("DGP", number(&r, "dgp"), 5.87e-5 * PI * l + 0.16, tolerance);
        assert_eq!((number(&r, "ugr"), number(&r, "veiling_cd_m2"), sources(&r).len()), (0.0, 0.0, 0));
    }
    // A cone of 30 degrees seen whole: pi L sin^2 30, and the corners of the square.
    let mut eye = Eye::new('a', 400, 100.0);
    eye.view = "-vta -vh 60 -vv 60".into();
    let l = f64::from(eye.values[0]);
    let round: Vec<f32> = (0..160_000usize)
        .map(|i| ((i % 400) as f64 - 199.5).hypot((i / 400) as f64 - 199.5))
        .map(|r| if r < 200.0 { l as f32 } else { 0.0 })
        .collect();
    eye.values = round;
    close("cone", number(&eye.report(&[]), "illuminance_lux"), PI * l / 4.0, 2e-3);
}

/// A disk by hand: w = 2 pi (1 - cos a), P of 30 degrees beside the line of sight is 1.46814, UGR = 8 lg(0.25 / Lb L^2 w / P^2).
#[test]
fn a_disk_is_rated_as_by_hand() {
    let eye = Eye::new('a', 1200, 50.0).disk(30.0, 0.0, 4.0, 10_000.0);
    let (lb, l) = (f64::from(eye.values[0]), f64::from(coded(10_000.0)));
    let w = 2.0 * PI * (1.0 - 4f64.to_radians().cos());
    let r = eye.report(&["--age", "0"]);
    let s = sources(&r)[0];
    close("solid angle", number(s, "solid_angle_sr"), w, 3e-3);
    close("P", number(s, "position_index"), 1.46814, 1e-3);
    close("angle", number(s, "angle_deg"), 30.0, 1e-3);
    close("mean", number(s, "luminance_cd_m2"), l, 1e-6);
    // The disk's own illuminance is L w cos(30 degrees) (1 + cos a) / 2: a cap's projected area.
    let direct = l * PI * 4f64.to_radians().sin().powi(2) * 30f64.to_radians().cos();
    close("direct", number(&r, "direct_lux"), direct, 3e-3);
    let background = lb * (1.0 - 4f64.to_radians().sin().powi(2) * 30f64.to_radians().cos());
    close("background", number(&r, "background_cd_m2"), background, 1e-3);
    close("UGR", number(&r, "ugr"), 8.0 * (0.25 / background * l * l * w / 1.46814f64.powi(2)).log10(), 1e-3);
    // Stiles-Holladay over a disk of radius a about t: within (a/t)^2 of its centre.
    close("veil", number(&r, "veiling_cd_m2"), 10.0 * direct / 900.0, 0.02);
    let old = number(&eye.report(&["--age", "70"]), "veiling_cd_m2");
    close("age", old, 2.0 * number(&r, "veiling_cd_m2"), 1e-9);
    // CIE general at 30 degrees, age 0, p 0.5: 10/27000 + 5/900 + 0.05/30 + 0.00125 per lux.
    let general = 10.0 / 27000.0 + 5.0 / 900.0 + 0.05 / 30.0 + 0.00125;
    close("CIE", number(&eye.report(&["--age", "0", "--glare", "cie"]), "veiling_cd_m2"), general * direct, 0.02);
}

/// Sources join when no more than half the radius lies between them, and not otherwise.
#[test]
fn near_sources_are_one_and_far_ones_are_two() {
    let gap = |degrees: f64| Eye::new('a', 600, 100.0).disk(0.0, 0.0, 2.0, 1e4).disk(4.0 + degrees, 0.0, 2.0, 1e4);
    let count = |eye: &Eye, options: &[&str]| sources(&eye.report(options)).len();
    // 0.1 rad are 5.73 degrees.
    assert_eq!((count(&gap(5.0), &[]), count(&gap(6.5), &[])), (1, 2));
    assert_eq!((count(&gap(6.5), &["-r", "0.3"]), count(&gap(5.0), &["--search-radius", "0"])), (1, 2));
    // A chain is one, however long.
    let chain = (0..9).fold(Eye::new('h', 400, 100.0), |e, i| e.disk(-40.0 + 10.0 * f64::from(i), 0.0, 3.0, 1e4));
    assert_eq!(count(&chain, &[]), 1);
    let peak = Eye::new('a', 400, 100.0).disk(20.0, 0.0, 5.0, 1e4).disk(20.0, 0.0, 1.0, 6e4);
    assert_eq!((count(&peak, &[]), count(&peak, &["-x"]), count(&peak, &["-Y", "70000"])), (2, 1, 1));
}

#[test]
fn evalglares_words_are_understood() {
    let eye = Eye::new('a', 300, 100.0).disk(30.0, 10.0, 5.0, 900.0);
    let one = eye.report(&["-d", "-y", "-C", "l+", "-b", "5", "-q", "1", "-r", "0.2"]);
    assert_eq!(one, eye.report(&["--threshold", "5", "--background", "mean"]));
    // A task of 100 cd/m2 in a field of another mean.
    let task = eye.report(&["-b", "5", "-t", "150", "60", "0.2"]);
    close("threshold", number(&task, "threshold_cd_m2"), 5.0 * f64::from(eye.values[0]), 1e-6);
    let mut blind = eye.stream();
    let at = blind.windows(5).position(|w| w == b"VIEW=").unwrap();
    blind[at..at + 4].copy_from_slice(b"WEIV");
    fails("pglare", &[], &blind, 1, "--view");
    assert_eq!(report(&blind, &["-vta", "-vh", "180", "-vv", "180"]), eye.report(&[]));
    assert_eq!(report(&blind, &["--view", "-vta -vh 180 -vv 180"]), eye.report(&[]));
    fails("pglare", &["--view", "-vtl"], &blind, 2, "--view");
    fails("pglare", &["--task", "1,1,0.1"], &eye.stream(), 2, "factor");
    fails("pglare", &["-b", "5", "--task", "1,1,0.1"], &eye.stream(), 2, "outside");
    let measured = eye.report(&["-i", "5000"]);
    assert_eq!(number(&measured, "illuminance_lux"), 5000.0);
}

/// evalglare -C l+ prints 0.00748 and 0.264079, -q 1 a background of 100.337891 and UGR 25.235125, -q 2 144.210453.
#[test]
fn low_light_and_backgrounds_are_evalglares() {
    close("dim", number(&eye("dim", 'a', 600).report(&[]), "dgp_low_light"), 0.00748, 0.02);
    let far = eye("two_far", 'a', 600);
    close("far", number(&far.report(&[]), "dgp_low_light"), 0.264079, 0.02);
    let mean = far.report(&["-q", "1"]);
    close("mean", number(&mean, "background_cd_m2"), 100.337891, 1e-4);
    close("UGR", number(&mean, "ugr"), 25.235125, 0.02);
    close("total", number(&far.report(&["-q", "2"]), "background_cd_m2"), 144.210453, 1e-4);
}

/// The same light in any scan order, unit and number of threads.
#[test]
fn orientation_exposure_and_threads_change_nothing() {
    let eye = eye("window", 'a', 200);
    let want = eye.report(&[]);
    assert_eq!(eye.report(&["--threads", "1"]), want);
    let header = format!("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2\nVIEW= {}", eye.view);
    let turned: Vec<f32> = eye.values.iter().rev().copied().collect();
    assert_eq!(report(&stream(&header, "+Y 200 -X 200", &turned), &[]), want);
    let columns: Vec<f32> = (0..40_000).map(|i| eye.values[(i % 200) * 200 + i / 200]).collect();
    assert_eq!(report(&stream(&header, "+X 200 -Y 200", &columns), &[]), want);
    // Radiance's floats: W/sr/m2 and an exposure of 4.
    let rgb: Vec<f32> = eye.values.iter().flat_map(|l| [l * 4.0 / 179.0; 3]).collect();
    let exposed = format!("NCOMP=3\nEXPOSURE=4\nVIEW= {}", eye.view);
    let got = report(&stream(&exposed, "-Y 200 +X 200", &rgb), &[]);
    for key in ["illuminance_lux", "dgp", "ugr", "veiling_cd_m2"] {
        close(key, number(&got, key), number(&want, key), 1e-4);
    }
}

#[test]
fn odd_pictures_give_finite_numbers() {
    let view = "VIEW= -vta -vh 180 -vv 180";
    let header = format!("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2\n{view}");
    let odd: [&[f32]; 6] = [
        &[0.0; 16],
        &[1e5; 16],
        &[f32::NAN; 16],
        &[f32::INFINITY, -1.0, f32::NAN, 1e4, 3.0, 0.0, 1e30, -0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0],
        &[3e38; 16],
        &[1e-38; 16],
    ];
    for values in odd {
        for options in [&[][..], &["-b", "5"], &["-q", "mean"], &["--glare", "cie"]] {
            report(&stream(&header, "-Y 4 +X 4", values), options);
        }
    }
    for l in [0.0, 10.0, 1e6] {
        report(&stream(&header, "-Y 1 +X 1", &[l]), &[]);
    }
    let output = run("pglare", &[], &stream(&header, "-Y 4 +X 4", odd[3]));
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && notes.contains("3 pixels that were negative or not finite"), "{notes}");
    let narrow = stream("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2\nVIEW= -vtv -vh 60 -vv 60", "-Y 4 +X 4", &[10.0; 16]);
    let notes = String::from_utf8(run("pglare", &[], &narrow).stderr).unwrap();
    assert!(notes.contains("% of the hemisphere"), "{notes}");
    let shown = stream(&format!("NCOMP=1\nCOMPONENTS=Y\nUNITS=display\n{view}"), "-Y 4 +X 4", &[0.5; 16]);
    fails("pglare", &[], &shown, 1, "display");
}
