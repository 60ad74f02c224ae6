//! pdisplay through the real program. Readings come from closed forms below: chromaticities by the matrix that makes (1,1,1)
//! white, curves as written.

mod common;

use std::fs;

use common::{data_path, run, stdout_of};
use luxpipe::color::{Mat3, Primaries};
use luxpipe::display::Display;

/// A display as its maker would state it.
struct Known {
    primaries: &'static str,
    lmax: f64,
    lmin: f64,
    curve: fn(f64) -> f64,
}

fn srgb(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Straight pieces between 17 points of an S, as a table has them.
fn table(v: f64) -> f64 {
    let point = |i: f64| (i / 16.0).powi(2) * (3.0 - 2.0 * i / 16.0) * 0.8 + 0.2 * i / 16.0;
    let i = (v * 16.0).floor().min(15.0);
    point(i) + (point(i + 1.0) - point(i)) * (v * 16.0 - i)
}

impl Known {
    /// x, y, Y of a code: black is grey.
    fn read(&self, code: [f64; 3], off: [f64; 3]) -> [f64; 3] {
        let primaries: Primaries = self.primaries.parse().unwrap();
        let m: Mat3 = primaries.to_xyz().unwrap();
        let white = primaries.white.xyz();
        let light = m.apply(code.map(self.curve));
        let xyz = [0, 1, 2].map(|i| (light[i] * (self.lmax - self.lmin) + white[i] * self.lmin) * off[i]);
        let sum: f64 = xyz.iter().sum();
        [xyz[0] / sum, xyz[1] / sum, xyz[1]]
    }

    /// Ramps of grey and each primary in `steps`, and mixtures; `noise` is the largest relative error of X, Y, Z.
    fn csv(&self, steps: u32, full: f64, noise: f64) -> String {
        let mut codes = vec![[0.0; 3]];
        for i in 1..=steps {
            let v = f64::from(i) / f64::from(steps);
            codes.extend([[v; 3], [v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]);
        }
        codes.extend([[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.8, 0.2, 0.4], [0.2, 0.4, 0.8]]);
        let mut text = String::from("# synthetic\nr,g,b,x,y,Y\n");
        for (i, code) in codes.iter().enumerate() {
            let off = [0, 1, 2].map(|k| 1.0 + noise * (f64::from(k) * 2.1 + 7.3 * i as f64).sin());
            let [x, y, luminance] = self.read(*code, off);
            let [r, g, b] = code.map(|c| c * full);
            text += &format!("{r},{g},{b},{x},{y},{luminance}\n");
        }
        text
    }
}

const SRGB: Known = Known { primaries: "BT.709", lmax: 120.0, lmin: 0.2, curve: srgb };
const CRT: Known =
    Known { primaries: "0.63,0.34,0.31,0.595,0.155,0.07,0.2831,0.2971", lmax: 90.0, lmin: 0.5, curve: |v| v.powf(2.2) };
const TABLE: Known = Known { primaries: "P3", lmax: 400.0, lmin: 0.05, curve: table };

fn fails(args: &[&str], input: &str, status: i32, word: &str) {
    let output = run("pdisplay", args, input.as_bytes());
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {message}");
    assert!(message.lines().count() == 1 && message.starts_with("pdisplay: "), "{message}");
    assert!(message.contains(word), "'{word}' not in: {message}");
    assert!(output.stdout.is_empty());
}

fn fitted(csv: &str) -> String {
    String::from_utf8(stdout_of("pdisplay", &["-"], csv.as_bytes())).unwrap()
}

fn key(text: &str, key: &str) -> toml::Value {
    text.parse::<toml::Table>().unwrap_or_else(|e| panic!("{e}: {text}"))[key].clone()
}

fn near(text: &str, known: &Known) {
    let primaries: Primaries = key(text, "primaries").as_str().unwrap().parse().unwrap();
    let want = known.primaries.parse().unwrap();
    assert!(primaries.distance(&want) < 1e-3, "{primaries} for {want}");
    let number = |k: &str| key(text, k).as_float().unwrap_or_else(|| key(text, k).as_integer().unwrap() as f64);
    assert!((number("lmax") / known.lmax - 1.0).abs() < 1e-3, "{text}");
    assert!((number("lmin") / known.lmin - 1.0).abs() < 1e-2, "{text}");
}

#[test]
fn a_known_display_comes_back() {
    for noise in [0.0, 0.001] {
        for (steps, full) in [(5, 255.0), (8, 1.0), (17, 255.0)] {
            let text = fitted(&SRGB.csv(steps, full, noise));
            near(&text, &SRGB);
            assert_eq!(key(&text, "transfer").as_str(), Some("srgb"), "{text}");

            let text = fitted(&CRT.csv(steps, full, noise));
            near(&text, &CRT);
            let gamma = key(&text, "transfer")["gamma"].as_float().unwrap();
            assert!((gamma - 2.2).abs() < 0.01, "{text}");
        }
        let text = fitted(&TABLE.csv(16, 1.0, noise));
        near(&text, &TABLE);
        let light = key(&text, "transfer")["table"].as_array().unwrap().clone();
        assert_eq!(light.len(), 33);
        for (i, l) in light.iter().enumerate().step_by(2) {
            let want = table(i as f64 / 32.0);
            let got = l.as_float().unwrap_or(if i == 0 { 0.0 } else { 1.0 });
            assert!((got - want).abs() < 1e-6 + 3.0 * noise * want, "{got} for {want}");
        }
    }
}

/// Hundredths of noise: nothing breaks, and the residuals say so.
#[test]
fn residuals_state_the_noise() {
    let residual = |noise| {
        let text = fitted(&CRT.csv(8, 1.0, noise));
        let line = text.lines().find(|l| l.contains("predicted against read")).unwrap().to_string();
        line.split("mean ").nth(1).unwrap().split(',').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(residual(0.0) < 0.002, "{}", residual(0.0));
    let (a, b) = (residual(0.005), residual(0.01));
    assert!(a > 0.05 && b > 1.5 * a && b < 3.0, "{a} {b}");
    let text = fitted(&CRT.csv(8, 1.0, 0.0));
    assert!(text.contains("white is +0.00 % off R + G + B") && text.contains("R 0.0000, G 0.0000, B 0.0000"), "{text}");
    // A white that is a fifth brighter than its parts is told.
    let csv = CRT.csv(8, 1.0, 0.0);
    let white = csv.lines().find(|l| l.starts_with("1,1,1,")).unwrap();
    let csv = csv.replace(white, "1,1,1,0.2831,0.2971,108");
    let output = run("pdisplay", &["-"], csv.as_bytes());
    let note = String::from_utf8(output.stderr).unwrap();
    assert!(note.contains("white is +20.1 % off R + G + B"), "{note}");
    assert!(String::from_utf8(output.stdout).unwrap().contains("# Additivity: white is +20.11 %"));
}

#[test]
fn a_fitted_display_carries_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("readings.csv"), folder.path().join("panel.toml"));
    for known in [SRGB, CRT, TABLE] {
        fs::write(&csv, known.csv(16, 1.0, 0.001)).unwrap();
        let (csv, toml) = (csv.to_str().unwrap(), toml.to_str().unwrap());
        let options = ["--name", "the panel", "--bits", "16"];
        assert!(stdout_of("pdisplay", &[&options[..], &[csv, toml]].concat(), b"").is_empty());
        let text = fs::read_to_string(toml).unwrap();
        assert!(
            text.starts_with("# the panel\n# Fitted by pdisplay") && text.contains("70 readings of readings.csv"),
            "{text}"
        );
        let display: Display = toml.parse().unwrap();
        assert_eq!(display.bits, 16);
        let shown = stdout_of("pcond", &["--quiet", "--display", toml, &data_path("small_xyz.lux")], b"");
        let rgb = stdout_of("xyz2rgb", &["--display", toml], &shown);
        let png = stdout_of("ra_png", &["--quiet", "--display", toml], &rgb);
        assert!(png.starts_with(b"\x89PNG") && png[24] == 16);
        let other = run("ra_png", &["--display", "hdr10"], &rgb);
        assert_eq!(other.status.code(), Some(1));
        let table = String::from_utf8(stdout_of("pdisplay", &["--check", toml, csv], b"")).unwrap();
        assert_eq!(table.lines().filter(|l| !l.starts_with('#')).count(), 70);
    }
}

#[test]
fn a_check_passes_and_fails() {
    let good = data_path("display_readings.csv");
    let text = String::from_utf8(stdout_of("pdisplay", &["--check", "srgb", &good], b"")).unwrap();
    let last = text.lines().last().unwrap();
    let mean: f64 = last.split("mean ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(mean > 0.05 && mean < 1.0, "{last}");
    let first = text.lines().find(|l| !l.starts_with('#')).unwrap();
    let cells: Vec<&str> = first.split_whitespace().collect();
    assert!(cells.len() == 11 && cells[..4] == ["3", "0.000", "0.000", "0.000"] && cells[7..9] == ["0.3127", "0.3290"]);
    let black: f64 = cells[9].parse().unwrap();
    assert!((black - (0.2 + 0.64 / std::f64::consts::PI)).abs() < 1e-4);

    // The table is written all the same.
    let output = run("pdisplay", &["--check", "p3", &good], b"");
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && message.lines().count() == 1, "{message}");
    assert!(message.contains("above 3 (--tolerance)"), "{message}");
    assert!(String::from_utf8(output.stdout).unwrap().lines().count() > 25);
    let loose = ["--check", "p3", "--tolerance", "100", &good];
    stdout_of("pdisplay", &loose, b"");
    assert_eq!(run("pdisplay", &["--check", "srgb", "--tolerance", "0.01", &good], b"").status.code(), Some(1));

    // The wide screen's PQ: code 0.508078 is 100 cd/m2 (ST 2084), its black within.
    let pq = "r,g,b,x,y,Y\n0.508078421517399,0.508078421517399,0.508078421517399,0.3127,0.3290,100\n";
    let text =
        String::from_utf8(stdout_of("pdisplay", &["--check", "hdr10", "--tolerance", "0.001", "-"], pq.as_bytes()));
    assert!(text.unwrap().contains("100.0000"));
}

#[test]
fn damaged_readings_are_one_line() {
    let good = SRGB.csv(5, 255.0, 0.0);
    let without = |code: &str| good.lines().filter(|l| !l.starts_with(code)).collect::<Vec<_>>().join("\n");
    let line = |code: &str| good.lines().find(|l| l.starts_with(code)).unwrap();
    let changed = |code: &str, by: &str| good.replace(line(code), &format!("{code}{by}"));
    let cases: Vec<(String, &str)> = vec![
        (String::new(), "no readings"),
        ("r,g,b,x,y,Y\n".into(), "no readings"),
        (good.replace("r,g,b,x,y,Y", "r,g,b,x,y,y"), "line 2: column 'y' is there twice"),
        (good.replace("r,g,b,x,y,Y", "r,g,b,x,y"), "line 2: column 'Y' is missing"),
        (good.replace("r,g,b,x,y,Y", "r,g,b,X,Y,Z"), "line 2: 'X' is no column"),
        (without("r,g"), "is no column"),
        (without("0,0,0,"), "black, code 0,0,0, was not read"),
        (without("255,255,255,"), "white, code 255,255,255, was not read"),
        (without("255,0,0,"), "red, code 255,0,0,"),
        (without("0,255,0,"), "green"),
        (without("0,0,255,"), "blue"),
        (changed("51,51,51,", "0.3,nan,5"), "line 4: y 'nan' is not a number"),
        (changed("51,51,51,", "0.3,0.3,inf"), "line 4: Y 'inf' is not a number"),
        (changed("51,51,51,", "0.3,0.3"), "line 4: 5 values, expected 6"),
        (changed("51,51,51,", "0.3,0.3,-1"), "line 4: Y -1 must be"),
        (changed("51,51,51,", "0.8,0.3,5"), "line 4: chromaticity 0.8,0.3"),
        (good.replace("51,51,51,", "51,51,-51,"), "line 4: code -51"),
        (good.replace("51,51,51,", "51,51,256,"), "line 4: code 256"),
        (changed("0,0,0,", "0.3127,0.329,5"), "is below black's 5"),
        (changed("0,0,0,", "0.3127,0.329,150"), "red has"),
        (changed("0,255,0,", "0.3,0.6,130"), "green has 130"),
        (format!("{good}255,0,0,0.64,0.33,60\n"), "contradicts line 21, the same code"),
        (changed("153,153,153,", "0.3127,0.329,2"), "light falls"),
    ];
    for (csv, word) in &cases {
        fails(&["-"], csv, 1, word);
    }
    let flat = "r,g,b,x,y,Y\n0,0,0,0.3,0.3,1\n1,0,0,0.6,0.3,31\n0,1,0,0.6,0.3,41\n0,0,1,0.6,0.3,11\n1,1,1,0.6,0.3,81\n";
    fails(&["-"], flat, 1, "lie on one line");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("readings.csv");
    fs::write(&path, &cases[6].0).unwrap();
    fails(&[path.to_str().unwrap(), folder.path().join("out.toml").to_str().unwrap()], "", 1, "readings.csv: black");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    fails(&[], "", 2, "READINGS");
    fails(&["none.csv"], "", 1, "none.csv");
    fails(&["-", "--bits", "10"], &good, 2, "--bits 10");
    fails(&["-", "--tolerance", "1"], &good, 2, "--check");
    fails(&["-", "--lmax", "0", "--macbethcal"], &good, 2, "--lmax 0");
    fails(&["-", "--check", "nosuch"], &good, 2, "nosuch");
    fails(&["-", "--macbethcal"], &good, 1, "macbethcal");
}

#[test]
fn without_levels_between_the_curve_is_not_measured() {
    let output =
        run("pdisplay", &["-"], CRT.csv(1, 255.0, 0.0).lines().take(7).collect::<Vec<_>>().join("\n").as_bytes());
    assert!(String::from_utf8(output.stderr).unwrap().contains("sRGB is assumed"));
    near(&String::from_utf8(output.stdout).unwrap(), &CRT);
}

/// tests/ref/macbeth_print.py made readings of a printer of P3 primaries and light 0.01 + 0.99 v^1.1, Radiance 6.0a's
/// macbethcal -c the file from them.
#[test]
fn a_file_of_macbethcal_gives_the_printer_back() {
    let file = data_path("macbeth_print.cal");
    let text = String::from_utf8(stdout_of("pdisplay", &["--macbethcal", "--lmax", "90", &file], b"")).unwrap();
    let primaries: Primaries = key(&text, "primaries").as_str().unwrap().parse().unwrap();
    let want: Primaries = "0.68,0.32,0.265,0.69,0.15,0.06,0.33333,0.33333".parse().unwrap();
    assert!(primaries.distance(&want) < 0.02, "{primaries}");
    assert_eq!(key(&text, "lmax").as_integer(), Some(90));
    let light = key(&text, "transfer")["table"].as_array().unwrap().clone();
    for (i, l) in light.iter().enumerate() {
        let want = (i as f64 / 64.0).powf(2.2 * 1.1);
        let got = l.as_float().unwrap_or_else(|| l.as_integer().unwrap() as f64);
        assert!((got - want).abs() < 0.02, "{i}: {got} for {want}");
    }
    let folder = tempfile::tempdir().unwrap();
    let toml = folder.path().join("print.toml");
    let white = ["--white", "0.3457,0.3585", "--gamma", "1.8", "--macbethcal"];
    stdout_of("pdisplay", &[&white[..], &[&file, toml.to_str().unwrap()]].concat(), b"");
    let paper: Display = toml.to_str().unwrap().parse().unwrap();
    let d50 = "0.68,0.32,0.265,0.69,0.15,0.06,0.3457,0.3585".parse::<Primaries>().unwrap().white;
    assert!(paper.primaries.white.distance(d50) < 0.01, "{}", paper.primaries);

    let good = fs::read_to_string(&file).unwrap();
    for (from, to, word) in [
        ("gxa(i)", "gxb(i)", "'gxa(i) : select(i,...)' is missing"),
        ("select(i,0.0323356,", "select(i,", "rxa must be 6 rising numbers"),
        ("0.0323356", "0.9323356", "rising"),
        ("0.0323356", "nan", "rising"),
        ("g = 0.0429054*r1", "g = 0.0429054*q1", "expected a*r1 + b*g1 + c*b1"),
        ("b = 0.0226704*r1", "c = 0.0226704*r1", "'b = ...' is missing"),
        ("}", "}}", "'}' without '{'"),
    ] {
        assert!(good.contains(from));
        fails(&["--macbethcal", "-"], &good.replacen(from, to, 1), 1, word);
    }
}

/// tests/ref/macbeth_scan.py drew the chart as a scanner of Radiance's primaries and light v^1.2 sees it, macbethcal made the
/// file from that picture.
#[test]
fn a_scanned_chart_describes_the_scanner() {
    let output = run("pdisplay", &["--macbethcal", &data_path("macbeth_scan.cal")], b"");
    assert!(String::from_utf8(output.stderr).unwrap().contains("scanner"));
    let text = String::from_utf8(output.stdout).unwrap();
    let primaries: Primaries = key(&text, "primaries").as_str().unwrap().parse().unwrap();
    assert!(primaries.distance(&Primaries::RADIANCE) < 5e-3, "{primaries}");
    for (i, l) in key(&text, "transfer")["table"].as_array().unwrap().iter().enumerate() {
        let want = (i as f64 / 64.0).powf(2.2 * 1.2);
        let got = l.as_float().unwrap_or_else(|| l.as_integer().unwrap() as f64);
        assert!((got - want).abs() < 0.02, "{i}: {got} for {want}");
    }
}
