//! pcompare and `picinfo --json` through the real programs.

mod common;

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use common::run;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn stdout_of(name: &str, args: &[&str], input: &[u8]) -> String {
    text(&common::stdout_of(name, args, input))
}

fn fails(args: &[&str], input: &[u8], status: i32, word: &str) {
    common::fails("pcompare", args, input, status, word);
}

const D65: &str = "0.3127 0.3290";

/// A stream of XYZ in the unit and under the white given.
fn xyz_in(units: &str, white: &str, resolution: &str, values: &[f32]) -> Vec<u8> {
    let mut bytes = format!(
        "#?RADIANCE\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS={units}\nWHITE= {white}\nBigEndian=0\nFORMAT=float\n\n{resolution}\n"
    )
    .into_bytes();
    values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

/// One row of XYZ in cd/m2 under D65.
fn xyz(values: &[f32]) -> Vec<u8> {
    xyz_in("cd/m2", D65, &format!("-Y 1 +X {}", values.len() / 3), values)
}

/// Greys of the white's own chromaticity.
fn greys(luminances: &[f32]) -> Vec<u8> {
    let (x, z) = (0.3127 / 0.3290, (1.0 - 0.3127 - 0.3290) / 0.3290);
    xyz(&luminances.iter().flat_map(|y| [x * y, *y, z * y]).collect::<Vec<_>>())
}

/// The stream with another text in its header.
fn replaced(stream: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = stream.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    [&stream[..at], to.as_bytes(), &stream[at + from.len()..]].concat()
}

/// A folder with the reference in it.
struct Reference(tempfile::TempDir);

impl Reference {
    fn new(bytes: &[u8]) -> Reference {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("reference.lux"), bytes).unwrap();
        Reference(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_string()
    }

    fn json(&self, options: &[&str], input: &[u8]) -> HashMap<String, Value> {
        let path = self.path("reference.lux");
        parse(&stdout_of("pcompare", &[options, &["--json", &path]].concat(), input))
    }

    fn fails(&self, options: &[&str], input: &[u8], status: i32, word: &str) {
        fails(&[options, &[&self.path("reference.lux")]].concat(), input, status, word);
    }
}

/// A JSON value that is no container.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Null,
    Number(f64),
    Text(String),
}

impl Value {
    fn number(&self) -> f64 {
        let Value::Number(x) = self else { panic!("{self:?} is no number") };
        *x
    }
}

/// All values of a JSON text by path, such as `a.b.0`; panics where RFC 8259 has a fault to find.
fn parse(json: &str) -> HashMap<String, Value> {
    let mut found = HashMap::new();
    let rest = value(json, "", &mut found);
    assert_eq!(rest.trim_start(), "", "after the value");
    found
}

fn value<'a>(s: &'a str, path: &str, found: &mut HashMap<String, Value>) -> &'a str {
    let s = s.trim_start();
    let join = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    if let Some(mut rest) = s.strip_prefix(['{', '[']) {
        let (object, end) = (s.starts_with('{'), if s.starts_with('{') { '}' } else { ']' });
        for i in 0.. {
            if let Some(rest) = rest.trim_start().strip_prefix(end) {
                return rest;
            }
            if i > 0 {
                rest = rest.trim_start().strip_prefix(',').expect("a comma");
            }
            let mut key = i.to_string();
            if object {
                let (name, after) = string(rest.trim_start());
                rest = after.trim_start().strip_prefix(':').expect("a colon");
                key = name;
            }
            rest = value(rest, &join(&key), found);
        }
    }
    let (v, rest) = if s.starts_with('"') {
        let (t, rest) = string(s);
        (Value::Text(t), rest)
    } else if let Some(rest) = s.strip_prefix("null") {
        (Value::Null, rest)
    } else {
        let end = s.find(|c: char| !"+-.0123456789eE".contains(c)).unwrap_or(s.len());
        (Value::Number(s[..end].parse().unwrap()), &s[end..])
    };
    assert!(found.insert(path.to_string(), v).is_none(), "{path} twice");
    rest
}

fn string(s: &str) -> (String, &str) {
    let mut out = String::new();
    let mut chars = s.strip_prefix('"').expect("a quote").char_indices();
    while let Some((i, c)) = chars.next() {
        match c {
            '"' => return (out, &s[i + 2..]),
            '\\' => match chars.next().unwrap().1 {
                'n' => out.push('\n'),
                't' => out.push('\t'),
                'u' => {
                    let hex: String = (0..4).map(|_| chars.next().unwrap().1).collect();
                    out.push(char::from_u32(u32::from_str_radix(&hex, 16).unwrap()).unwrap());
                }
                c => {
                    assert!("\"\\/".contains(c));
                    out.push(c);
                }
            },
            c => {
                assert!(c >= ' ', "a bare control character");
                out.push(c);
            }
        }
    }
    panic!("a text without end");
}

fn close(found: &HashMap<String, Value>, wanted: &[(&str, f64)], tolerance: f64) {
    for (key, want) in wanted {
        let got = found[*key].number();
        assert!((got - want).abs() <= tolerance * want.abs().max(1.0), "{key}: {got}, not {want}");
    }
}

#[test]
fn equal_pictures_differ_by_nothing() {
    let file = "tests/data/small_xyz.lux";
    let found = parse(&stdout_of("pcompare", &["--json", file, file], b""));
    for key in ["delta_e_uv", "delta_e_ab", "delta_e_2000"] {
        close(&found, &[(&format!("{key}.mean"), 0.0), (&format!("{key}.max"), 0.0)], 0.0);
    }
    close(&found, &[("relative_y.max_absolute", 0.0), ("relative_mse_y", 0.0), ("left_out", 0.0), ("gain", 10.0)], 0.0);
    assert_eq!((&found["psnr_y_db"], &found["psnr_pu21_db"]), (&Value::Null, &Value::Null));
    let report = stdout_of("pcompare", &["--fail-above", "0", file, file], b"");
    assert!(report.contains("inf dB") && report.contains("Delta E 2000"), "{report}");
}

/// A grey of the white's chromaticity, 1 % brighter: every number has a closed form.
#[test]
fn one_per_cent_is_one_per_cent() {
    let reference = Reference::new(&greys(&[100.0; 7]));
    let found = reference.json(&[], &greys(&[101.0; 7]));
    let step = 116.0 * (1.01f64.cbrt() - 1.0);
    close(&found, &[("delta_e_uv.mean", step), ("delta_e_ab.p95", step), ("delta_e_ab.max", step)], 1e-5);
    close(
        &found,
        &[
            ("white_luminance", 100.0),
            ("relative_y.mean_signed", 0.01),
            ("relative_y.mean_absolute", 0.01),
            ("relative_y.p95_absolute", 0.01),
            ("relative_mse_y", 1.0 / 10001.0),
            ("psnr_y_db", 40.0),
            ("peak_y", 100.0),
            ("pu21_clamped", 0.0),
        ],
        1e-9,
    );
    // PU21 of 100 and 101 cd/m2 by the published parameters, in Python.
    close(&found, &[("psnr_pu21_db", 20.0 * (256.0f64 / (257.0304717427257 - 256.3838973127039)).log10())], 1e-9);
    close(&reference.json(&[], &greys(&[99.0; 7])), &[("relative_y.mean_signed", -0.01)], 1e-9);
}

/// Made with colour-science 0.4.7 (XYZ_to_Lab, XYZ_to_Luv, delta_E CIE 2000) after multiplying each pair by
/// min(10, max(1, 50 / Y)), white D65 at 100 cd/m2; errors of luminance with numpy.
#[test]
fn pairs_have_the_differences_of_colour_science() {
    let reference = [20., 30., 10., 4., 3., 2., 150., 160., 120., 0.2, 0.3, 0.4, 60., 80., 30.];
    let picture = [22., 31., 12., 4.4, 3.2, 2.5, 140., 150., 100., 0.25, 0.28, 0.35, 60., 80., 30.];
    let reference = Reference::new(&xyz(&reference));
    let found = reference.json(&["--white-luminance", "100"], &xyz(&picture));
    close(
        &found,
        &[
            ("delta_e_uv.mean", 8.296146),
            ("delta_e_uv.max", 12.245505),
            ("delta_e_ab.mean", 7.704326),
            ("delta_e_ab.max", 14.291823),
            ("delta_e_2000.mean", 4.618881),
            ("delta_e_2000.max", 12.550721),
            ("relative_y.mean_signed", -0.00583333677716),
            ("relative_y.mean_absolute", 0.045833343135),
            ("relative_y.max_absolute", 0.0666666997804),
            ("relative_mse_y", 0.00187659002144),
            ("psnr_y_db", 31.0271491272),
            ("psnr_pu21_db", 40.498740145),
        ],
        1e-6,
    );
}

/// The 95th percentile of 1 % to 100 % errors, a hundred pixels; Yn is the 99th of the reference's Y.
#[test]
fn percentiles_are_nearest_ranks() {
    let ramp: Vec<f32> = (1..=100).map(|i| i as f32).collect();
    let reference = Reference::new(&greys(&ramp));
    let brighter: Vec<f32> = ramp.iter().map(|y| y * (1.0 + y / 100.0)).collect();
    let found = reference.json(&[], &greys(&brighter));
    close(&found, &[("white_luminance", 99.0), ("relative_y.p95_absolute", 0.95)], 1.0 / 1024.0);
    close(&found, &[("relative_y.max_absolute", 1.0), ("relative_y.mean_signed", 0.505)], 1e-6);
}

#[test]
fn the_map_holds_each_pixels_difference() {
    let folder = Reference::new(&greys(&[100.0, 100.0, 50.0]));
    let (map, kept) = (folder.path("map.lux"), folder.path("kept.lux"));
    let mut values = greys(&[100.0, 101.0, f32::NAN]);
    let options = ["--white-luminance", "100", "--map", &map];
    let found = folder.json(&options, &values);
    assert_eq!(found["left_out"].number(), 1.0);
    // CIEDE2000 of two greys: Delta L / S_L.
    let high = 116.0 * 1.01f64.cbrt() - 16.0;
    let off = ((high + 100.0) / 2.0 - 50.0).powi(2);
    let want = (high - 100.0) / (1.0 + 0.015 * off / (20.0 + off).sqrt());
    close(&found, &[("delta_e_2000.max", want), ("delta_e_2000.mean", want / 2.0)], 1e-5);
    let bytes = fs::read(&map).unwrap();
    let pixels: Vec<f32> =
        bytes[bytes.len() - 12..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(pixels[0] == 0.0 && (f64::from(pixels[1]) - want).abs() < 1e-5 && pixels[2].is_nan(), "{pixels:?}");
    let info = parse(&stdout_of("picinfo", &["--json", &map], b""));
    assert_eq!((&info["components"], &info["units"]), (&Value::Text("Y".into()), &Value::Text("none".into())));
    assert_eq!((&info["statistics.0.nan"], &info["luminance"]), (&Value::Number(1.0), &Value::Null));
    assert_eq!(info["lines.0"], Value::Text("pcompare reference.lux --white-luminance 100".into()));
    assert_eq!(run("ra_rgbe", &[&map], b"").status.code(), Some(1));
    // A damaged picture leaves no map.
    values.pop();
    folder.fails(&["--map", &kept], &values, 1, "picture ends at row 1 of 1");
    assert!(!Path::new(&kept).exists());
    folder.fails(&["--map", "/dev/full"], &greys(&[100.0, 101.0, 1.0]), 1, "No space left");
}

#[test]
fn a_verdict_comes_with_its_report() {
    let folder = Reference::new(&greys(&[100.0; 4]));
    let (path, map, report) = (folder.path("reference.lux"), folder.path("map.lux"), folder.path("report.txt"));
    let input = greys(&[120.0; 4]);
    let output = run("pcompare", &["--fail-above", "1", "--map", &map, &path, "-", &report], &input);
    let message = text(&output.stderr);
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.contains("mean Delta E 2000") && message.contains("above 1"), "{message}");
    assert!(fs::read_to_string(&report).unwrap().contains("PSNR PU21") && Path::new(&map).exists());
    let output = run("pcompare", &["--fail-above", "1", &path], &input);
    assert!(output.status.code() == Some(1) && text(&output.stdout).contains("PSNR PU21"));
    assert_eq!(run("pcompare", &["--fail-above", "9", &path], &input).status.code(), Some(0));
    assert_eq!(fs::read_dir(folder.0.path()).unwrap().count(), 3);
}

#[test]
fn scan_orders_pipes_and_threads_do_not_matter() {
    let value = |x: usize, y: usize| [10.0 + x as f32, 20.0 + 3.0 * y as f32, 5.0 + (x * y) as f32];
    let (w, h) = (40, 30);
    let rows: Vec<f32> = (0..h).flat_map(|y| (0..w).flat_map(move |x| value(x, y))).collect();
    let columns: Vec<f32> = (0..w).rev().flat_map(|x| (0..h).flat_map(move |y| value(x, y))).collect();
    let upright = xyz_in("cd/m2", D65, "-Y 30 +X 40", &rows);
    let turned = xyz_in("cd/m2", D65, "-X 40 -Y 30", &columns);
    let folder = Reference::new(&turned);
    close(&folder.json(&[], &upright), &[("delta_e_ab.max", 0.0), ("relative_y.max_absolute", 0.0)], 0.0);
    let other: Vec<f32> = rows.iter().map(|v| v * 1.05 + 0.5).collect();
    let other = xyz_in("cd/m2", D65, "-Y 30 +X 40", &other);
    let want = folder.json(&[], &other);
    assert!(want["delta_e_ab.mean"].number() > 0.1);
    assert_eq!(folder.json(&["--threads", "1"], &other), want);
    fs::write(folder.path("other.lux"), &other).unwrap();
    let piped = stdout_of("pcompare", &["--json", "/dev/stdin", &folder.path("other.lux")], &turned);
    assert_eq!(parse(&piped), want);
}

#[test]
fn what_cannot_be_compared_is_refused_with_the_way_out() {
    let folder = Reference::new(&greys(&[100.0, 50.0]));
    let good = greys(&[100.0, 50.0]);
    folder.fails(&[], &greys(&[100.0]), 1, "1 x 1 pixels, REFERENCE 2 x 1");
    folder.fails(&["--units", "display"], &good, 1, "--relative");
    folder.fails(&["--white", "0.3158,0.3290"], &good, 1, "--ignore-white");
    folder.json(&["--white", "0.3155,0.3290"], &good);
    folder.json(&["--white", "0.4476,0.4074", "--ignore-white"], &good);
    folder.fails(&["--gain", "0.5"], &good, 2, "--gain");
    folder.fails(&["--white-luminance", "0"], &good, 2, "--white-luminance");
    folder.fails(&["--fail-above", "nan"], &good, 2, "--fail-above");
    folder.fails(&["--map", "-"], &good, 2, "--map");
    fails(&[], &good, 2, "REFERENCE");
    fails(&["-"], &good, 2, "REFERENCE");
    fails(&["/nowhere.lux"], &good, 1, "/nowhere.lux");
    let luminance = replaced(&good, "NCOMP=3\nCOMPONENTS=XYZ", "NCOMP=1\nCOMPONENTS=Y");
    folder.fails(&[], &luminance, 1, "INPUT: a picture of Y has no colour");
    let unit = replaced(&good, "UNITS=cd/m2", "UNITS=none");
    folder.fails(&[], &unit, 1, "UNITS=none does not go with COMPONENTS=XYZ");
    Reference::new(&greys(&[0.0, 0.0])).fails(&[], &good, 1, "--white-luminance");
    Reference::new(&greys(&[0.0, 0.0])).fails(&["--relative"], &good, 1, "REFERENCE has none");
    Reference::new(&greys(&[f32::NAN; 2])).fails(&["--white-luminance", "1"], &good, 1, "no pixel is finite");
    let mut cut = greys(&[100.0, 50.0]);
    cut.pop();
    Reference::new(&cut).fails(&[], &good, 1, "reference.lux: picture ends at row 1 of 1");
    let bare = |p: &[u8]| replaced(p, "WHITE= 0.3127 0.3290\n", "");
    let folder = Reference::new(&bare(&good));
    folder.fails(&[], &bare(&good), 1, "--white X,Y");
    let noted = run("pcompare", &[&folder.path("reference.lux")], &good);
    assert!(noted.status.success() && text(&noted.stderr).contains("taking that of INPUT"), "{noted:?}");
    let shown = |lmax: &str| replaced(&good, "UNITS=cd/m2", &format!("UNITS=display\nDISPLAY= 1 {lmax}"));
    Reference::new(&shown("100")).fails(&[], &shown("200"), 1, "--relative");
}

#[test]
fn relative_scales_and_says_so() {
    let folder = Reference::new(&greys(&[10.0, 30.0]));
    let display = |p: Vec<u8>| replaced(&p, "UNITS=cd/m2", "UNITS=display");
    let input = display(greys(&[0.125, 0.375]));
    let found = folder.json(&["--relative"], &input);
    close(&found, &[("scaled", 80.0)], 1e-9);
    close(&found, &[("delta_e_2000.max", 0.0), ("relative_y.max_absolute", 0.0)], 1e-5);
    let report = stdout_of("pcompare", &["--relative", &folder.path("reference.lux")], &input);
    assert!(report.contains("INPUT x 80.0000 (--relative)"), "{report}");
    // Shares of an unknown display have no PU21; of a known one they do.
    let unknown = Reference::new(&input).json(&[], &input);
    assert_eq!((&unknown["psnr_pu21_db"], &unknown["pu21_clamped"]), (&Value::Null, &Value::Null));
    let known = |values: &[f32]| replaced(&greys(values), "UNITS=cd/m2", "UNITS=display\nDISPLAY= 0 100");
    let found = Reference::new(&known(&[1.0, 1.0])).json(&[], &known(&[1.01, 1.01]));
    close(&found, &[("psnr_pu21_db", 20.0 * (256.0f64 / (257.0304717427257 - 256.3838973127039)).log10())], 1e-6);
}

/// Nothing overflows, panics or is clamped without being counted.
#[test]
fn extreme_pixels_are_counted() {
    let (top, low) = (f32::MAX, f32::MIN_POSITIVE);
    let reference =
        Reference::new(&xyz(&[top, top, top, low, low, low, -1., -1., -1., 0., 0., 0., 1., 1., f32::INFINITY]));
    let input = xyz(&[-top, -top, top, top, top, top, 1., 1., 1., 1., 1., 1., 1., 1., 1.]);
    let found = reference.json(&["--white-luminance", "1e-38"], &input);
    close(&found, &[("left_out", 1.0), ("pu21_clamped", 4.0), ("relative_y.without_reference", 2.0)], 0.0);
    for key in ["delta_e_uv", "delta_e_ab", "delta_e_2000"] {
        assert!(found[&format!("{key}.max")].number() > 1.0, "{key}");
    }
}

#[test]
fn picinfo_prints_json() {
    let mut picture = b"#?RADIANCE\na \"quoted\" \\ back\x1b[31m\n\xff\xfe bytes\nVIEW= -vtv -vh 40\n".to_vec();
    picture.extend_from_slice(&xyz_in("cd/m2", D65, "+X 2 -Y 2", &[0.5, 5.0, 50.0, -1.0, 0.0, 7.0])[11..]);
    for v in [f32::NAN, 20.0, 1.0, f32::INFINITY, 500.0, 2.0] {
        picture.extend(v.to_le_bytes());
    }
    let found = parse(&stdout_of("picinfo", &["--json"], &picture));
    let text = |s: &str| Value::Text(s.into());
    for (key, want) in [
        ("order", text("+X -Y")),
        ("components", text("XYZ")),
        ("units", text("cd/m2")),
        ("lines.0", text("a \"quoted\" \\ back\u{1b}[31m")),
        ("lines.1", text("\u{fffd}\u{fffd} bytes")),
        ("lines.2", text("VIEW= -vtv -vh 40")),
        ("statistics.0.name", text("X")),
        ("primaries", Value::Null),
        ("adapted", Value::Null),
        ("display_cd_m2", Value::Null),
        ("wavelengths_nm", Value::Null),
    ] {
        assert_eq!(found[key], want, "{key}");
    }
    close(
        &found,
        &[
            ("width", 2.0),
            ("height", 2.0),
            ("ncomp", 3.0),
            ("white.1", 0.329),
            ("statistics.0.min", -1.0),
            ("statistics.0.max", 0.5),
            ("statistics.0.mean", -0.25),
            ("statistics.0.negative", 1.0),
            ("statistics.0.nan", 1.0),
            ("statistics.0.infinite", 1.0),
            ("luminance.max", 500.0),
            ("luminance.mean", 131.25),
            ("luminance_decades.0.decade", 0.0),
            ("luminance_decades.2.decade", 2.0),
            ("luminance_decades.2.pixels", 1.0),
            ("luminance_in_no_decade", 1.0),
        ],
        1e-12,
    );
    let found = parse(&stdout_of("picinfo", &["--json", "tests/data/radiance_office.hdr"], b""));
    close(&found, &[("width", 213.0), ("height", 157.0), ("primaries.0", 0.64)], 1e-12);
    let spectrum = b"#?RADIANCE\nNCOMP=2\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 500 600\nADAPTED= .3 .3 .4 .4 x 1\nFORMAT=float\n\n-Y 1 +X 1\n\0\0\0\0\0\0\x80\x3f";
    let found = parse(&stdout_of("picinfo", &["--json"], spectrum));
    close(&found, &[("wavelengths_nm.1", 600.0), ("adapted.to.0", 0.4), ("statistics.1.max", 1.0)], 1e-12);
    assert_eq!((&found["luminance"], &found["statistics.1.name"]), (&Value::Null, &Value::Text("600.0 nm".into())));
}
