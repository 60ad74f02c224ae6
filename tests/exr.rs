//! OpenEXR through the real programs, files of other programs, and files that are damaged.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::{data_path, fails, floats, root, run, split, stdout_of, stream};
use luxpipe::codec::{self, Reading};
use luxpipe::notes::Notes;
use luxpipe::stream::Block;
use luxpipe::stream::meaning::Overrides;
use luxpipe::stream::reader::Input;
use luxpipe::stream::spool::Limits;

const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.4476 0.4074\nPRIMARIES= 1 0 0 1 0 0 .333 .333";
const RGB: &str = "rpict -vp 0 0 0\nVIEW= -vtv -vh 40 -vv 30\nNCOMP=3\nCOMPONENTS=RGB\nUNITS=cd/m2\n\
                   WHITE= 0.31270001 0.329\n\
                   ADAPTED= 0.4476 0.4074 0.3127 0.329 cmccat2000 1\n\
                   PRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329";

/// The picture as `ra_exr` with these options writes it.
fn written(options: &[&str], input: &[u8]) -> Vec<u8> {
    stdout_of("ra_exr", options, input)
}

fn read(exr: &[u8]) -> Vec<u8> {
    stdout_of("ra_exr", &["-r"], exr)
}

/// A resolution line without its padding.
fn size_of(stream: &[u8]) -> String {
    split(stream).1.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What stands on standard error.
fn notes(options: &[&str], input: &[u8]) -> String {
    let output = run("ra_exr", options, input);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stderr).unwrap()
}

fn values(stream: &[u8]) -> Vec<f32> {
    floats(split(stream).2)
}

fn line<'a>(lines: &'a [String], key: &str) -> Option<&'a str> {
    lines.iter().find_map(|l| l.strip_prefix(key)).map(str::trim)
}

/// A value of each magnitude from 2^-10 to 2^14, negatives among them.
fn ramp(count: usize) -> Vec<f32> {
    let value = |i: usize| {
        let x = (i as f32 * 0.37).sin() * 7.0;
        (2f32).powf(x + 2.0) * (1.0 + (i % 13) as f32 / 17.0) * if i % 11 == 3 { -1.0 } else { 1.0 }
    };
    (0..count).map(value).collect()
}

/// The bytes of an attribute's value.
fn attribute(exr: &[u8], name: &str, kind: &str) -> Option<Vec<u8>> {
    let key = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat();
    let at = exr.windows(key.len()).position(|w| w == key)? + key.len();
    let size = u32::from_le_bytes(exr[at..at + 4].try_into().unwrap()) as usize;
    Some(exr[at + 4..at + 4 + size].to_vec())
}

#[test]
fn floats_come_back_bit_for_bit_with_every_line() {
    let input = stream(RGB, "-Y 17 +X 33", &ramp(3 * 17 * 33));
    let back = read(&written(&["--float"], &input));
    let ((lines, _, pixels), want) = (split(&back), split(&input));
    assert_eq!(size_of(&back), "-Y 17 +X 33");
    assert!(pixels == want.2);
    for l in RGB.lines().filter(|l| !l.starts_with("NCOMP")) {
        assert!(lines.iter().any(|k| k == l), "{l} not in {lines:?}");
    }
    let steps: Vec<_> = lines.iter().filter(|l| l.starts_with("ra_exr")).collect();
    assert_eq!(steps, ["ra_exr --float", "ra_exr --reverse"]);
    // XYZ, relative, display and luminance keep what they are.
    for (head, options) in [
        (XYZ.to_string(), vec!["--float", "--to", "XYZ"]),
        (RGB.replace("cd/m2", "relative"), vec!["--float"]),
        (format!("{}\nDISPLAY= 0.2 100", RGB.replace("cd/m2", "display")), vec!["--float"]),
        ("NCOMP=1\nCOMPONENTS=Y\nUNITS=none".to_string(), vec!["--float"]),
        ("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2".to_string(), vec!["--float"]),
    ] {
        let count = if head.contains("NCOMP=1") { 1 } else { 3 };
        let input = stream(&head, "-Y 2 +X 5", &ramp(count * 10));
        let exr = written(&options, &input);
        let back = read(&exr);
        let ((lines, _, pixels), want) = (split(&back), split(&input));
        assert!(pixels == want.2, "{head}");
        for l in head.lines() {
            assert!(lines.iter().any(|k| k == l), "{l} not in {lines:?}");
        }
        assert_eq!(attribute(&exr, "whiteLuminance", "float").is_some(), head.contains("cd/m2"), "{head}");
    }
}

#[test]
fn half_keeps_eleven_bits_and_changes_nothing_twice() {
    let input = stream(RGB, "-Y 33 +X 17", &ramp(3 * 17 * 33));
    let once = read(&written(&[], &input));
    let twice = read(&written(&[], &once));
    for (a, b) in values(&input).iter().zip(values(&once)) {
        assert!((a - b).abs() <= a.abs() / 2048.0, "{a} {b}");
    }
    assert_eq!(values(&once), values(&twice));
    assert_eq!(written(&["--half"], &once)[..8], [0x76, 0x2f, 0x31, 1, 2, 0, 0, 0]);
}

#[test]
fn attributes_say_what_the_format_can_say() {
    let exr = written(&["--to", "XYZ", "--half"], &stream(XYZ, "-Y 1 +X 1", &[1.0, 2.0, 3.0]));
    let numbers = |name, kind| floats(&attribute(&exr, name, kind).unwrap());
    assert_eq!(numbers("chromaticities", "chromaticities"), [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0]);
    assert_eq!(numbers("adoptedNeutral", "v2f"), [0.4476, 0.4074]);
    assert_eq!(numbers("whiteLuminance", "float"), [1.0]);
    assert_eq!(attribute(&exr, "channels", "chlist").unwrap()[..2], *b"B\0");
    // XYZ becomes BT.709 unless asked otherwise; RGB keeps its primaries.
    let exr = written(&[], &stream(XYZ, "-Y 1 +X 1", &[95.047, 100.0, 108.883]));
    let rgb = values(&read(&exr));
    assert!(rgb.iter().all(|x| (x - 100.0).abs() < 0.1), "{rgb:?}");
    let primaries = floats(&attribute(&exr, "chromaticities", "chromaticities").unwrap());
    assert_eq!(primaries, [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]);
    let exr = written(&[], &stream(RGB, "-Y 1 +X 1", &[1.0; 3]));
    let primaries = floats(&attribute(&exr, "chromaticities", "chromaticities").unwrap());
    assert_eq!(primaries, [0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329]);
    let exr = written(&["--to", "P3"], &stream(&format!("{RGB}\nPIXASPECT=0.5"), "-Y 1 +X 1", &[1.0; 3]));
    assert_eq!(floats(&attribute(&exr, "chromaticities", "chromaticities").unwrap())[0], 0.68);
    assert_eq!(floats(&attribute(&exr, "pixelAspectRatio", "float").unwrap()), [2.0]);
}

#[test]
fn what_half_cannot_reach_is_scaled_by_a_power_of_two() {
    let input = stream(RGB, "-Y 1 +X 2", &[65504.0, 1.0, 0.5, 3.0, 2.0, 1.0]);
    assert_eq!((notes(&[], &input).as_str(), values(&read(&written(&[], &input)))), ("", values(&input)));
    // The sun.
    let sun = stream(RGB, "-Y 1 +X 2", &[1.6e9, 1.5e9, 1.2e9, 1024.0, 2048.0, 512.0]);
    let exr = written(&[], &sun);
    assert_eq!(floats(&attribute(&exr, "whiteLuminance", "float").unwrap()), [32768.0]); // 1.6e9 / 65504 = 24426
    let note = notes(&[], &sun);
    assert!(note.lines().count() == 1 && note.contains("32768") && note.contains("--float"), "{note}");
    let back = values(&read(&exr));
    for (a, b) in values(&sun).iter().zip(&back) {
        assert!((a - b).abs() <= a / 2048.0, "{a} {b}");
    }
    assert_eq!(back[3..], [1024.0, 2048.0, 512.0]);
    assert_eq!(values(&read(&written(&["--float"], &sun))), values(&sun));
    // A file is read twice, a pipe kept: the same bytes.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sun.lux");
    fs::write(&path, &sun).unwrap();
    assert_eq!(stdout_of("ra_exr", &[path.to_str().unwrap()], b""), exr);
    // Numbers without a luminance cannot be scaled.
    let relative = stream(&RGB.replace("cd/m2", "relative"), "-Y 1 +X 1", &[70000.0, 0.0, 0.0]);
    fails("ra_exr", &[], &relative, 1, "--float");
}

#[test]
fn white_luminance_divides_and_refuses_what_is_beyond() {
    let input = stream(RGB, "-Y 2 +X 1", &[100.0, 50.0, 25.0, 200.0, 400.0, 800.0]);
    let exr = written(&["--white-luminance", "100", "--compression", "none", "--half"], &input);
    assert_eq!(floats(&attribute(&exr, "whiteLuminance", "float").unwrap()), [100.0]);
    assert_eq!(exr[exr.len() - 6..], [0x00, 0x48, 0x00, 0x44, 0x00, 0x40]); // 8, 4, 2 in B, G, R
    assert_eq!(values(&read(&exr)), values(&input));
    fails("ra_exr", &["--white-luminance", "0.01"], &input, 1, "row 2");
    for bad in ["0", "-1", "nan", "1e40"] {
        fails("ra_exr", &["--white-luminance", bad], &input, 2, "white-luminance");
    }
    let display = stream(&RGB.replace("cd/m2", "display"), "-Y 1 +X 1", &[1.0; 3]);
    fails("ra_exr", &["--white-luminance", "80"], &display, 2, "white-luminance");
    fails("ra_exr", &["--half", "--float"], &input, 2, "--float");
}

#[test]
fn no_infinity_and_no_nan_is_written() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let input = stream(RGB, "-Y 1 +X 4", &[nan, 1.0, 2.0, inf, -inf, 2.0, 1e-6, 0.0, 3.0, 1.0, 1.0, 1.0]);
    assert_eq!(values(&read(&written(&["--float"], &input)))[..6], [0.0, 1.0, 2.0, f32::MAX, f32::MIN, 2.0]);
    let half = values(&read(&written(&[], &input)));
    assert_eq!(half[..6], [0.0, 1.0, 2.0, 65504.0, -65504.0, 2.0]);
    let note = notes(&[], &input);
    assert_eq!(note.lines().count(), 1, "{note}");
    for part in ["of 4 pixels 1 had NaN", "1 had a component infinite", "1 had a component under 6.1e-5", "--float"] {
        assert!(note.contains(part), "{part}: {note}");
    }
    // Through a matrix too.
    let input = stream(XYZ, "-Y 1 +X 3", &[inf, 1.0, 1.0, nan, 1.0, 1.0, 1.0, 1.0, 1.0]);
    for options in [&["--half"][..], &["--float"]] {
        let back = values(&read(&written(options, &input)));
        assert!(back.iter().all(|x| x.is_finite()), "{back:?}");
        let note = notes(options, &input);
        assert!(note.contains("of 3 pixels 1 had NaN") && note.contains("1 had a component infinite"), "{note}");
    }
}

#[test]
fn compressions_and_sizes_make_no_difference() {
    for (width, height) in [(1, 1), (1, 100), (100, 1), (33, 17), (64, 65)] {
        let size = format!("-Y {height} +X {width}");
        let input = stream(RGB, &size, &ramp(3 * width * height));
        for depth in ["--half", "--float"] {
            let of = |how: &str| read(&written(&[depth, "--compression", how], &input));
            let (none, zip, piz) = (of("none"), of("zip"), of("piz"));
            assert_eq!(size_of(&none), size);
            assert!(split(&none).2 == split(&zip).2 && split(&none).2 == split(&piz).2, "{width} x {height} {depth}");
        }
        let one = written(&["--threads", "1"], &input);
        assert!(one == written(&["--threads", "4"], &input), "{width} x {height}: threads");
        assert_eq!(read(&one), stdout_of("ra_exr", &["-r", "--threads", "3"], &one));
    }
    // Other orders of rows are turned.
    let turned = stream(RGB, "+Y 2 +X 1", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(values(&read(&written(&[], &turned))), [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
}

#[test]
fn spectra_stay_spectra() {
    let bins = "NCOMP=4\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTH_SPLITS= 780 588 480 380\nWHITE= 0.3 0.3";
    let points = "NCOMP=4\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 400.125 550 700 1010";
    let down = "NCOMP=4\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 1010 700 550 400.1234567";
    let stokes = "NCOMP=8\nCOMPONENTS=STOKES\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 450 600";
    for (head, count) in [(bins, 4), (points, 4), (down, 4), (stokes, 8)] {
        let input = stream(head, "-Y 3 +X 2", &ramp(6 * count));
        let exr = written(&[], &input);
        let back = read(&exr);
        let (lines, _, pixels) = split(&back);
        assert!(pixels == split(&input).2, "{head}");
        for l in head.lines() {
            assert!(lines.iter().any(|k| k == l), "{l} not in {lines:?}");
        }
        assert_eq!(attribute(&exr, "spectralLayoutVersion", "string").unwrap(), b"1.0");
        assert_eq!(attribute(&exr, "emissiveUnits", "string").unwrap(), b"W.m^-2.sr^-1");
        let handed = attribute(&exr, "polarisationHandedness", "string");
        assert_eq!(handed.as_deref(), (head == stokes).then_some(&b"right"[..]));
        assert!(attribute(&exr, "whiteLuminance", "float").is_none());
        let half = values(&read(&written(&["--half"], &input)));
        assert!(values(&input).iter().zip(&half).all(|(a, b)| (a - b).abs() <= a.abs() / 2048.0));
    }
    let names = |head: &str, n: usize| {
        let exr = written(&[], &stream(head, "-Y 1 +X 1", &vec![1.0; n]));
        String::from_utf8_lossy(&attribute(&exr, "channels", "chlist").unwrap()).into_owned()
    };
    assert!(names(bins, 4).starts_with("S0.430,000000nm\0"));
    assert!(names(points, 4).contains("S0.400,125000nm\0"));
    let found = names(stokes, 8);
    assert!(["S0.450,000000nm", "S3.600,000000nm"].iter().all(|n| found.contains(n)), "{found}");
    // Left-handed files turn V round.
    let exr = written(&["--compression", "none"], &stream(stokes, "-Y 1 +X 1", &ramp(8)));
    let at = exr.windows(9).position(|w| w == b"\x05\0\0\0right").unwrap();
    let left = [&exr[..at], b"\x04\0\0\0left", &exr[at + 9..]].concat();
    // Everything after it lies a byte further to the front: so do the blocks.
    let table = left.len() - (8 + 8 * 4) - 8;
    let offset = u64::from_le_bytes(left[table..table + 8].try_into().unwrap()) - 1;
    let left = [&left[..table], &offset.to_le_bytes(), &left[table + 8..]].concat();
    let mut want = ramp(8);
    (want[3], want[7]) = (-want[3], -want[7]);
    assert_eq!(values(&read(&left)), want);
    // With --to a spectrum becomes what spec2xyz makes of it.
    let input = stream(bins, "-Y 1 +X 2", &ramp(8));
    let xyz = values(&read(&written(&["--float", "--to", "XYZ"], &input)));
    assert_eq!(xyz, values(&stdout_of("spec2xyz", &[], &input)));
    let close = "NCOMP=2\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 500 500.0000001";
    fails("ra_exr", &[], &stream(close, "-Y 1 +X 1", &[1.0; 2]), 1, "share the name");
    fails("ra_exr", &[], &stream("NCOMP=2\nCOMPONENTS=RESPONSE", "-Y 1 +X 1", &[1.0; 2]), 1, "RESPONSE");
}

/// Files of two other programs, as the other of them reads them.
#[test]
fn files_of_other_programs_are_read() {
    let text = fs::read_to_string(root().join("tests/ref/exr_values.csv")).unwrap();
    type Pixels = Vec<(usize, usize, [f32; 3])>;
    let mut files: BTreeMap<&str, Pixels> = BTreeMap::new();
    for row in text.lines().filter(|l| !l.starts_with('#')) {
        let f: Vec<&str> = row.split(',').collect();
        let n = |i: usize| f[i].parse::<f32>().unwrap();
        files.entry(f[0]).or_default().push((n(1) as usize, n(2) as usize, [n(3), n(4), n(5)]));
    }
    assert_eq!(files.len(), fs::read_dir(root().join("tests/data/exr")).unwrap().count());
    for (name, pixels) in &files {
        let path = data_path(&format!("exr/{name}.exr"));
        let one = stdout_of("ra_exr", &["-r", &path], b"");
        let many = stdout_of("ra_exr", &["-r", "--threads", "3", "-"], &fs::read(&path).unwrap());
        assert!(one == many, "{name}: threads and pipes");
        let (lines, _, _) = split(&one);
        let width = if name.starts_with("chroma") { 18 } else { 17 };
        assert_eq!(size_of(&one), format!("-Y 40 +X {width}"));
        let scale = if *name == "half_zip" { 100.0 } else { 1.0 };
        let tolerance = if name.starts_with("chroma") { 3e-3 } else { 1e-6 };
        let got = values(&one);
        for (x, y, want) in pixels {
            let got = &got[3 * (y * width + x)..][..3];
            let largest = want.iter().fold(0f32, |m, v| m.max(v.abs()));
            for (a, b) in got.iter().zip(want) {
                assert!((a - b * scale).abs() <= tolerance * largest * scale, "{name} at {x}, {y}: {got:?} {want:?}");
            }
        }
        let components = match *name {
            "xyz" | "xyz_in_rgb" => "XYZ",
            "spectral" => "SPECTRUM",
            _ => "RGB",
        };
        assert_eq!(line(&lines, "COMPONENTS="), Some(components), "{name}");
        match *name {
            "xyz_in_rgb" => assert_eq!(line(&lines, "WHITE="), Some("0.4476 0.4074")),
            "float_piz" => {
                assert_eq!(line(&lines, "PRIMARIES="), Some("0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329"));
            }
            "spectral" => assert_eq!(line(&lines, "WAVELENGTHS="), Some("400 550 1000")),
            "half_zip" => assert_eq!(line(&lines, "PRIMARIES="), Some("0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329")),
            _ => {}
        }
    }
}

#[test]
fn what_a_file_does_not_say_is_said() {
    let note = |name: &str| notes(&["-r"], &fs::read(data_path(&format!("exr/{name}.exr"))).unwrap());
    assert!(note("alpha").contains("alpha is ignored") && note("alpha").contains("without whiteLuminance"));
    assert!(note("window").contains("the display window is 20 x 20"));
    assert!(note("parts").contains("the first of 2 parts"));
    assert!(note("spectral").contains("W/sr/m2/nm"));
    assert_eq!(note("half_zip"), "");
    let file = fs::read(data_path("exr/alpha.exr")).unwrap();
    let said = stdout_of("ra_exr", &["-r", "--units", "relative", "--components", "XYZ"], &file);
    let (lines, _, _) = split(&said);
    assert_eq!((line(&lines, "UNITS="), line(&lines, "COMPONENTS=")), (Some("relative"), Some("XYZ")));
    // Every filter reads it.
    let file = data_path("exr/half_zip.exr");
    assert!(String::from_utf8(stdout_of("picinfo", &[&file], b"")).unwrap().contains("17"));
}

/// Reads to the end within this process; the error, if any.
fn consumed(path: &Path) -> Result<(), String> {
    let (overrides, notes) = (Overrides::default(), Notes::default());
    let limits = Limits { memory: 1 << 20, folder: std::env::temp_dir() };
    let input = Input::open(Some(path)).map_err(|e| e.to_string())?;
    let reading = Reading { overrides: &overrides, limits: &limits, notes: &notes };
    let mut picture = codec::open(input, &reading).map_err(|e| e.to_string())?;
    let mut block = Block::default();
    while picture.next(&mut block).map_err(|e| e.to_string())? {}
    Ok(())
}

/// The files that damage is done to: of other programs, and our own.
fn whole_files() -> Vec<(String, Vec<u8>)> {
    let mut list: Vec<(String, Vec<u8>)> = fs::read_dir(root().join("tests/data/exr"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .map(|p| (p.file_stem().unwrap().to_string_lossy().into_owned(), fs::read(p).unwrap()))
        .collect();
    list.sort();
    let input = stream(&RGB[RGB.find("NCOMP").unwrap()..], "-Y 40 +X 3", &ramp(360));
    for options in [["--half", "zip"], ["--float", "piz"], ["--half", "none"]] {
        let exr = written(&[options[0], "--compression", options[1]], &input);
        list.push((format!("ours {}", options[1]), exr));
    }
    list
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.exr");
    for (name, bytes) in whole_files() {
        // Of the largest sizes alone nothing is missed when smaller ones are cut, of the first part when others are.
        let (small, parts) = (name == "sizes", name == "parts");
        let mut refused = 0;
        // Every byte of our own, every header, and steps through the pixels of others.
        let all = name.starts_with("ours") && bytes.len() < 3000;
        for end in (4..bytes.len()).filter(|n| all || *n < 500 || n % 61 == 0 || n + 3 > bytes.len()) {
            fs::write(&path, &bytes[..end]).unwrap();
            match consumed(&path) {
                Ok(()) if small || parts => {}
                Ok(()) => panic!("{name} cut at {end} of {} was read", bytes.len()),
                Err(e) => {
                    assert_eq!(e.lines().count(), 1, "{e}");
                    refused += 1;
                }
            }
        }
        assert!(refused > 300, "{name}");
        if name == "ours none" {
            fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
            assert!(consumed(&path).unwrap_err().contains("picture ends at row 40 of 40"));
        }
    }
    let whole = written(&[], &stream(RGB, "-Y 40 +X 5", &ramp(600)));
    fails("picinfo", &[], &whole[..whole.len() - 1], 1, "row 33 of 40");
}

#[test]
fn damaged_files_neither_panic_nor_allocate() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.exr");
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % n
    };
    let count: usize = std::env::var("MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(2000);
    let files = whole_files();
    for round in 0..count {
        let (name, bytes) = &files[round % files.len()];
        let mut bad = bytes.clone();
        for _ in 0..1 + random(4) {
            let at = random(bad.len() - 4) + 4;
            match random(4) {
                0 => bad[at] = random(256) as u8,
                1 => bad[at] ^= 1 << random(8),
                2 => bad[at] = [0, 255, 127, 128][random(4)],
                _ => {
                    let size = [0u32, 1, 0xffff_ffff, 0x7fff_ffff, 1 << 28][random(5)].to_le_bytes();
                    let end = (at + 4).min(bad.len());
                    bad[at..end].copy_from_slice(&size[..end - at]);
                }
            }
        }
        fs::write(&path, &bad).unwrap();
        let start = std::time::Instant::now();
        let result = consumed(&path);
        let took = start.elapsed().as_secs_f64();
        assert!(took < 5.0, "{name}, round {round}: {took} s, {result:?}");
        if let Err(e) = result {
            assert_eq!(e.lines().count(), 1, "{e}");
        }
    }
}

#[test]
fn what_is_not_read_says_so() {
    let whole = written(&["--compression", "none"], &stream(RGB, "-Y 2 +X 2", &ramp(12)));
    let with = |from: &[u8], to: &[u8]| {
        let at = whole.windows(from.len()).position(|w| w == from).unwrap();
        [&whole[..at], to, &whole[at + from.len()..]].concat()
    };
    let mut deep = whole.clone();
    deep[5] |= 8;
    fails("ra_exr", &["-r"], &deep, 1, "deep");
    let mut version = whole.clone();
    version[4] = 3;
    fails("ra_exr", &["-r"], &version, 1, "version");
    let compression = |code: u8| {
        with(
            b"compression\0compression\0\x01\0\0\0\0",
            &[b"compression\0compression\0\x01\0\0\0", &[code][..]].concat(),
        )
    };
    fails("ra_exr", &["-r"], &compression(10), 1, "HTJ2K");
    fails("ra_exr", &["-r"], &compression(77), 1, "77");
    fails("ra_exr", &["-r"], &with(b"B\0\x01\0\0\0", b"Q\0\x01\0\0\0"), 1, "expected R G B");
    // A window that no bytes bear out.
    let at = whole.windows(6).position(|w| w == b"box2i\0").unwrap() + 10;
    let mut huge = whole.clone();
    huge[at + 8..at + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x0f, 0xff, 0xff, 0xff, 0x0f]);
    fails("ra_exr", &["-r"], &huge, 1, "row");
}

#[test]
fn pipelines_save_it() {
    let folder = tempfile::tempdir().unwrap();
    let (pipeline, save) = (folder.path().join("p.toml"), folder.path().join("x.exr"));
    let text = format!(
        "[[stage]]\nrun = \"vonkries\"\ninput = \"{}\"\nto = \"D65\"\nfrom = \"A\"\n\
         save = \"{}\"\n[[stage]]\nrun = \"picinfo\"\n",
        data_path("small_xyz.lux"),
        save.display()
    );
    fs::write(&pipeline, text).unwrap();
    stdout_of("luxpipe", &[pipeline.to_str().unwrap()], b"");
    assert!(fs::read(&save).unwrap().starts_with(&[0x76, 0x2f, 0x31, 1]));
}
