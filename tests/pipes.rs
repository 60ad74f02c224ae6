//! The real programs, through pipes and files.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{fails, floats, program, root, run, split, stdout_of, stream};
use luxpipe::filters;

fn data(name: &str) -> Vec<u8> {
    fs::read(root().join("tests/data").join(name)).unwrap()
}

const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.4476 0.4074\nPRIMARIES= 1 0 0 1 0 0 .333 .333";

/// Filters that read a picture, with options under which they accept XYZ in cd/m2.
fn readers() -> Vec<(&'static str, Vec<&'static str>)> {
    let options = |name: &str| match name {
        "vonkries" => vec!["--from", "A"],
        "pcompare" => vec!["tests/data/small_xyz.lux"],
        "relight" => vec!["scenes/cornell.toml"],
        "pglare" => vec!["--view", "-vta -vh 180 -vv 180"],
        _ => vec![],
    };
    let reads = |f: &&&dyn luxpipe::filter::Any| f.command().get_arguments().any(|a| a.get_id() == "input");
    filters::ALL.iter().filter(reads).map(|f| (f.name(), options(f.name()))).collect()
}

#[test]
fn every_program_explains_itself_and_refuses_nonsense() {
    let names: Vec<&str> = filters::ALL.iter().map(|f| f.name()).chain(["luxpipe", "tradeoff"]).collect();
    for name in names {
        let help = String::from_utf8(stdout_of(name, &["--help"], b"")).unwrap();
        assert!(help.contains("Example:") && help.contains("--threads"), "{name}: {help}");
        assert!(String::from_utf8(stdout_of(name, &["--version"], b"")).unwrap().contains(env!("CARGO_PKG_VERSION")));
        fails(name, &["--no-such-option"], b"", 2, "--no-such-option");
        let many = filters::named(name).is_some_and(|f| f.command().get_positionals().count() == 1);
        if !many {
            fails(name, &["a", "b", "c", "d"], b"", 2, "");
        }
        fails(name, &["--threads", "many"], b"", 2, "many");
    }
}

#[test]
fn damaged_pictures_are_refused_in_one_line_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> = fs::read_dir(root().join("tests/bad")).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 40);
    for file in &files {
        let bytes = fs::read(file).unwrap();
        for (name, options) in readers() {
            let target = folder.path().join("out");
            let paths = [file.to_str().unwrap(), target.to_str().unwrap()];
            for (args, input) in
                [([&options[..], &paths].concat(), &[][..]), ([&options[..], &["-", paths[1]]].concat(), &bytes)]
            {
                let output = run(name, &args, input);
                let message = String::from_utf8_lossy(&output.stderr);
                assert_eq!(output.status.code(), Some(1), "{name} {args:?}: {message}");
                assert_eq!(message.lines().count(), 1, "{name} {args:?}: {message}");
            }
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{name} {} left a file", file.display());
        }
    }
}

#[test]
fn a_failure_names_the_row() {
    let whole = data("small_xyz.lux");
    fails("vonkries", &[], &whole[..whole.len() - 5], 1, "picture ends at row 3 of 3");
    fails("vonkries", &[], &whole[..whole.len() - 100], 1, "picture ends at row 1 of 3");
    let rle = fs::read(root().join("tests/bad/rle_cut.hdr")).unwrap();
    fails("pcond", &[], &rle, 1, "row 2 of 2");
}

#[test]
fn a_failure_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("kept");
    fs::write(&target, "old").unwrap();
    let whole = data("small_xyz.lux");
    fails("ra_rgbe", &["-", target.to_str().unwrap()], &whole[..whole.len() - 5], 1, "row 3");
    assert_eq!(fs::read(&target).unwrap(), b"old");
    stdout_of("ra_rgbe", &["-", target.to_str().unwrap()], &whole);
    assert!(fs::read(&target).unwrap().starts_with(b"#?RADIANCE"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn unknown_lines_and_history_are_carried() {
    let header = format!(
        "{XYZ}\nrpict -vp 0 0 0\nVIEW= -vtv -vh 40 -vv 30\nNOBODY_KNOWS= this\n\tCOMPONENTS=RGB\nPIXASPECT=1.5"
    );
    let input = stream(&header, "-Y 1 +X 1", &[1.0, 2.0, 3.0]);
    let out = stdout_of("vonkries", &["--to", "D50"], &input);
    let out = stdout_of("xyz2rgb", &["--gamut", "clip", "--threads", "1", "--quiet"], &out);
    let (lines, _, _) = split(&out);
    for line in
        ["rpict -vp 0 0 0", "VIEW= -vtv -vh 40 -vv 30", "NOBODY_KNOWS= this", "\tCOMPONENTS=RGB", "PIXASPECT=1.5"]
    {
        assert!(lines.iter().any(|l| l == line), "{line} not in {lines:?}");
    }
    let at = |line: &str| lines.iter().position(|l| l == line).unwrap_or_else(|| panic!("{line} not in {lines:?}"));
    assert!(at("rpict -vp 0 0 0") < at("vonkries --to D50") && at("vonkries --to D50") < at("xyz2rgb --gamut clip"));
    assert!(lines.iter().any(|l| l.starts_with("ADAPTED= 0.4476 0.4074 0.34567 0.3585 cmccat2000 1")), "{lines:?}");
    assert_eq!(lines.iter().filter(|l| l.starts_with("NCOMP=")).count(), 1);
}

#[test]
fn pixels_begin_at_a_multiple_of_four() {
    for width in [1, 9, 10, 100, 1000] {
        let input = stream(XYZ, &format!("-Y 1 +X {width}"), &vec![1.0; 3 * width]);
        let out = stdout_of("vonkries", &[], &input);
        let (_, _, pixels) = split(&out);
        assert_eq!((out.len() - pixels.len()) % 4, 0);
    }
}

#[test]
fn float_forms_agree() {
    let values: Vec<f32> = (0..12).map(|i| 0.5 + i as f32 * 3.7).collect();
    let want = stdout_of("vonkries", &[], &stream(XYZ, "-Y 2 +X 2", &values));
    let mut big = format!("#?RADIANCE\n{XYZ}\nBigEndian=1\nFORMAT=float\n\n-Y 2 +X 2\n").into_bytes();
    values.iter().for_each(|v| big.extend(v.to_be_bytes()));
    let mut double = format!("#?RADIANCE\n{XYZ}\nFORMAT=double\n\n-Y 2 +X 2\n").into_bytes();
    values.iter().for_each(|v| double.extend(f64::from(*v).to_le_bytes()));
    let mut matrix = format!("#?RADIANCE\n{XYZ}\nNROWS=2\nNCOLS=2\nFORMAT=float\n\n").into_bytes();
    values.iter().for_each(|v| matrix.extend(v.to_le_bytes()));
    let mut both = format!("#?RADIANCE\n{XYZ}\nNROWS=2\nNCOLS=2\nFORMAT=float\n\n-Y 2 +X 2\n").into_bytes();
    values.iter().for_each(|v| both.extend(v.to_le_bytes()));
    let mut crlf =
        format!("#?RADIANCE\r\n{}\r\nFORMAT=float\r\n\r\n-Y 2 +X 2\n", XYZ.replace('\n', "\r\n")).into_bytes();
    values.iter().for_each(|v| crlf.extend(v.to_le_bytes()));
    let unmarked = stream(XYZ, "-Y 2 +X 2", &values)[11..].to_vec();
    for (name, form) in
        [("big", big), ("double", double), ("matrix", matrix), ("both", both), ("crlf", crlf), ("no magic", unmarked)]
    {
        assert_eq!(stdout_of("vonkries", &[], &form), want, "{name}");
    }
}

/// A grey of 100 cd/m2 is 100 in every form: float XYZ, float RGB, RGBE, XYZE and Radiance's spectra.
#[test]
fn a_hundred_candelas_are_a_hundred_in_every_form() {
    let grey = stream(&XYZ.replace("0.4476 0.4074", "0.3333333 0.3333333"), "-Y 1 +X 1", &[100.0, 100.0, 100.0]);
    let luminance = |stream: &[u8]| {
        let xyz = stdout_of("spec2xyz", &[], stream);
        floats(split(&xyz).2)[1]
    };
    assert_eq!(luminance(&grey), 100.0);
    let rgbe = stdout_of("ra_rgbe", &[], &grey);
    let xyze = stdout_of("ra_rgbe", &["--xyze"], &grey);
    assert!((luminance(&rgbe) / 100.0 - 1.0).abs() < 0.005, "{}", luminance(&rgbe));
    assert!((luminance(&xyze) / 100.0 - 1.0).abs() < 0.005, "{}", luminance(&xyze));
    assert!(split(&xyze).0.iter().any(|l| l == "EXPOSURE=5.5866e-03"));
    // Unnamed floats are Radiance's: RGB in W/sr/m2 with its primaries.
    let radiance = stream("NCOMP=3", "-Y 1 +X 1", &[100.0 / 179.0; 3]);
    assert!((luminance(&radiance) / 100.0 - 1.0).abs() < 1e-4, "{}", luminance(&radiance));
    // An equal spectrum of Radiance's band values c has the luminance 179 c.
    let bands = stream("NCOMP=20\nWAVELENGTH_SPLITS= 830 588 480 360", "-Y 1 +X 1", &[100.0 / 179.0; 20]);
    assert!((luminance(&bands) / 100.0 - 1.0).abs() < 1e-4, "{}", luminance(&bands));
    let mut hsr =
        b"#?RADIANCE\nNCOMP=20\nWAVELENGTH_SPLITS= 830 588 480 360\nFORMAT=Radiance_spectra\n\n-Y 1 +X 1\n".to_vec();
    hsr.extend([143; 20]); // 100 / 179 = 143.02 / 256
    hsr.push(128);
    assert!((luminance(&hsr) / 100.0 - 1.0).abs() < 0.005, "{}", luminance(&hsr));
}

/// `--observer radiance` agrees with rcomb to 0.2 %; the exact integrals differ from it by more, since Radiance's table lies
/// 1.5 nm off.
#[test]
fn radiance_spectra_integrate_as_rcomb_integrates_them() {
    let text = fs::read_to_string(root().join("tests/ref/radiance_observer.csv")).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with(['#', 'X']));
    let want: Vec<f32> = rows.flat_map(|l| l.split(',').map(|n| n.parse().unwrap()).collect::<Vec<f32>>()).collect();
    let eye: Vec<f32> = (0..18 * 18).map(|i| if i % 19 == 0 { 1.0 } else { 0.0 }).collect();
    let input = stream("NCOMP=18\nWAVELENGTH_SPLITS= 780 588 480 380", "-Y 1 +X 18", &eye);
    let error = |args: &[&str]| {
        let got = floats(split(&stdout_of("spec2xyz", args, &input)).2);
        let off = |c: usize| {
            let peak = want.iter().skip(c).step_by(3).fold(0f32, |m, x| m.max(*x));
            let pairs = got.iter().zip(&want).skip(c).step_by(3);
            pairs.fold(0f32, |m, (a, b)| m.max((a - b).abs() / peak))
        };
        (0..3).map(off).fold(0f32, f32::max)
    };
    assert!(error(&["--observer", "radiance"]) < 0.002, "{}", error(&["--observer", "radiance"]));
    assert!(error(&[]) > 0.02);
}

/// pvalue -df -o of Radiance 6.0a gave these for the first pixels of the office; ours are 179 times as large.
#[test]
fn radiance_pictures_decode_as_radiance_decodes_them() {
    let picture = data("radiance_office.hdr");
    let decoded = stdout_of("ra_rgbe", &["-r"], &picture);
    let again = stdout_of("ra_rgbe", &[], &decoded);
    let (lines, resolution, pixels) = split(&again);
    assert_eq!(resolution, "-Y      157 +X      213");
    assert!(lines.iter().any(|l| l.starts_with("rpict ")), "{lines:?}");
    assert_eq!(pixels, split(&picture).2, "the run-length coded bytes are not Radiance's own");
}

#[test]
fn all_eight_orientations_show_the_same_picture() {
    let (w, h) = (3, 2);
    let value = |x: usize, y: usize| [0.1 * (x + 1) as f32, 0.2 * (y + 1) as f32, 0.05];
    let header = "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nDISPLAY= 1 100\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";
    let mut pictures = Vec::new();
    for (ys, xs, by_rows) in [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (["-Y", "+Y"][i & 1], ["+X", "-X"][i >> 1 & 1], i < 4)) {
        let xx: Vec<usize> = if xs == "+X" { (0..w).collect() } else { (0..w).rev().collect() };
        let yy: Vec<usize> = if ys == "-Y" { (0..h).collect() } else { (0..h).rev().collect() };
        let mut values = Vec::new();
        if by_rows {
            yy.iter().for_each(|y| xx.iter().for_each(|x| values.extend(value(*x, *y))));
        } else {
            xx.iter().for_each(|x| yy.iter().for_each(|y| values.extend(value(*x, *y))));
        }
        let line = if by_rows { format!("{ys} {h} {xs} {w}") } else { format!("{xs} {w} {ys} {h}") };
        let input = stream(header, &line, &values);
        pictures.push(stdout_of("ra_png", &[], &input));
        // Row-wise filters keep the order as it is.
        let passed = stdout_of("xyz2rgb", &["-r"], &input);
        assert_eq!(split(&passed).1.split_whitespace().collect::<Vec<_>>().join(" "), line);
    }
    assert!(pictures.iter().all(|p| *p == pictures[0]));
}

#[test]
fn a_reader_that_goes_away_ends_the_writer_quietly() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("big.lux");
    fs::write(&file, stream(XYZ, "-Y 1000 +X 1000", &vec![1.0; 3_000_000])).unwrap();
    // Noise for the display, so that the PNG is larger than a pipe.
    let noise: Vec<f32> =
        (0..3_000_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / 16_777_216.0).collect();
    let shown = folder.path().join("shown.lux");
    let header = "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";
    fs::write(&shown, stream(header, "-Y 1000 +X 1000", &noise)).unwrap();
    for name in ["vonkries", "pcond", "xyz2rgb", "ra_rgbe", "ra_png"] {
        let input = if name == "ra_png" { &shown } else { &file };
        let mut child =
            Command::new(program(name)).arg(input).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut some = [0; 100];
        std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut some).unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{name}");
        assert!(output.stderr.is_empty(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_full_disk_is_an_error() {
    let input = data("small_xyz.lux");
    for (name, options) in readers() {
        if ["ra_png", "relight"].contains(&name) {
            continue; // take display pictures, and layers; below
        }
        fails(name, &[&options[..], &["-", "/dev/full"]].concat(), &input, 1, "No space left");
    }
    let shown = stdout_of("pcond", &["--quiet"], &input);
    let shown = stdout_of("xyz2rgb", &[], &shown);
    fails("ra_png", &["-", "/dev/full"], &shown, 1, "No space left");
    let small = ["scenes/cornell.toml", "--width=4", "--samples=1", "--per-light"];
    let layers = stdout_of("spectrace", &small, b"");
    fails("relight", &["scenes/cornell.toml", "-", "/dev/full"], &layers, 1, "No space left");
    fails("vonkries", &["-", "/nowhere/at/all"], &input, 1, "No such file");
    fails("vonkries", &["/nowhere/at/all"], b"", 1, "No such file");
    fails("vonkries", &["/tmp"], b"", 1, "folder");
}

#[test]
fn pcond_reads_a_pipe_as_it_reads_a_file() {
    let file = root().join("tests/data/radiance_office.hdr");
    let from_file = stdout_of("pcond", &[file.to_str().unwrap()], b"");
    let picture = data("radiance_office.hdr");
    assert_eq!(stdout_of("pcond", &[], &picture), from_file);
    let spooled = run("pcond", &["--memory", "1k"], &picture);
    assert_eq!(spooled.stdout, from_file);
    assert!(String::from_utf8_lossy(&spooled.stderr).contains("spooled"));
    assert_eq!(stdout_of("pcond", &["--threads", "1"], &picture), from_file);
}

/// Sizes beside a resolution line, the line cut by a buffer's end: it is a line all the same, and pixels that look like the
/// beginning of one are pixels.
#[test]
fn a_resolution_line_may_straddle_a_buffer() {
    let values = [1.0f32, 2.0, 3.0];
    for pad in 65_480..65_545 {
        let long = format!("{XYZ}\nPAD={}\nPAD={}\nNROWS=1\nNCOLS=1", "x".repeat(40_000), "x".repeat(pad - 40_200));
        let out = stdout_of("vonkries", &[], &stream(&long, "-Y 1 +X 1", &values));
        assert_eq!(floats(split(&out).2).len(), 3);
        assert_eq!(split(&out).1, "-Y        1 +X        1");
    }
    let tricky = f32::from_le_bytes(*b"+X 1");
    let mut bare = format!("#?RADIANCE\n{XYZ}\nNROWS=1\nNCOLS=1\nFORMAT=float\n\n").into_bytes();
    [tricky, 2.0, 3.0].iter().for_each(|v| bare.extend(v.to_le_bytes()));
    let xyz = stream(XYZ, "-Y 1 +X 1", &[tricky, 2.0, 3.0]);
    assert_eq!(stdout_of("vonkries", &[], &bare), stdout_of("vonkries", &[], &xyz));
}

/// A file's own `UNITS=display` holds until another program adds its line; an indented line is nobody's.
#[test]
fn display_units_of_an_rgbe_file_go_stale() {
    let file = |lines: &str| format!("#?RADIANCE\n{lines}\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n").into_bytes();
    let units = |lines: &str| {
        let bytes = [file(lines), vec![128, 128, 128, 129]].concat();
        let text = String::from_utf8(stdout_of("picinfo", &["--quiet"], &bytes)).unwrap();
        text.lines().find(|l| l.starts_with("components")).unwrap().to_string()
    };
    assert!(units("xyz2rgb\nUNITS=display").contains("display"));
    assert!(units("xyz2rgb\nUNITS=display\npcomb -s 100 d.hdr").contains("cd/m2"));
    assert!(units("xyz2rgb\nUNITS=display\npcomb -s 100 d.hdr\n\tx").contains("cd/m2"));
    assert!(units("COMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm").contains("cd/m2"));
}

/// Infinities stay the brightest there is, whatever matrix lies between, and are counted.
#[test]
fn infinite_light_does_not_turn_black() {
    let xyz =
        stream(XYZ, "-Y 1 +X 3", &[f32::INFINITY, f32::INFINITY, f32::INFINITY, 3e38, 3e38, 3e38, f32::NAN, 1.0, 1.0]);
    for args in [&[][..], &["--gamut", "desaturate"], &["--xyze"]] {
        let output = run("ra_rgbe", args, &xyz);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains("1 had NaN") && message.contains("2 had a component infinite"), "{args:?} {message}");
        let pixels = split(&output.stdout).2;
        assert!(pixels[3] > 240 && pixels[7] > 240, "{args:?}: {pixels:?}");
    }
}

/// One factor for all pixels, and the header tells which.
#[test]
fn linear_maps_are_linear() {
    let input = stream(XYZ, "-Y 1 +X 4", &[0.01, 0.01, 0.01, 1.0, 1.0, 1.0, 90.0, 100.0, 110.0, 2e4, 2e4, 2e4]);
    let out = stdout_of("pcond", &["-l", "--quiet"], &input);
    let (lines, _, pixels) = split(&out);
    let exposure = lines.iter().find_map(|l| l.strip_prefix("MAPPED_EXPOSURE=")).unwrap();
    let factor = exposure.parse::<f32>().unwrap() / 179.0;
    for (got, lum) in floats(pixels).chunks(3).map(|p| p[1]).zip([0.01, 1.0, 100.0, 2e4]) {
        assert!((got / (lum * factor) - 1.0).abs() < 1e-3, "{got} for {lum} x {factor}");
    }
    assert_eq!(split(&stdout_of("pcond", &["-e", exposure], &input)).2.len(), pixels.len());
}

#[test]
fn refusals_name_the_way_out() {
    let input = data("small_xyz.lux");
    let no_white = stream(&XYZ.replace("WHITE= 0.4476 0.4074\n", ""), "-Y 1 +X 1", &[1.0; 3]);
    fails("vonkries", &[], &no_white, 1, "--from");
    fails("ra_png", &[], &input, 1, "xyz2rgb");
    let rgb = stdout_of("xyz2rgb", &[], &input);
    fails("ra_png", &[], &rgb, 1, "pcond");
    let shown = stdout_of("pcond", &["--quiet"], &input);
    fails("pcond", &[], &shown, 1, "display-referred");
    fails("ra_rgbe", &[], &shown, 1, "--force");
    stdout_of("ra_rgbe", &["--force"], &shown);
    fails("vonkries", &["--to", "D64"], &input, 2, "D64");
    fails("vonkries", &["--from", "0.17,0.005"], &input, 1, "sensor");
    fails("vonkries", &["--degree", "2"], &input, 2, "degree");
    fails("xyz2rgb", &["--to", "0,0,0,0,0,0,0,0"], &input, 2, "area");
    fails("xyz2rgb", &["--gamut", "desaturat"], &input, 2, "desaturate");
    fails("xyz2rgb", &["--knee", "0.5"], &input, 2, "--gamut compress");
    fails("xyz2rgb", &["--hue", "oklab"], &input, 2, "shrink");
    fails("xyz2rgb", &["--relative"], &input, 2, "colorimetric");
    fails("vonkries", &["--la", "5"], &input, 2, "--degree auto");
    fails("vonkries", &["--degree", "-1"], &input, 2, "0 to 1");
    fails("spec2xyz", &["--factor", "5"], &input, 2, "--response");
    let impossible = stream(&XYZ.replace("WHITE= 0.4476 0.4074\n", ""), "-Y 1 +X 1", &[-5.0, 900.0, 5.0]);
    fails("vonkries", &["--from", "auto"], &impossible, 1, "no white can be guessed");
    fails("pcond", &["-u", "0"], &input, 2, "ldmax");
    fails("pcond", &["-e", "bright"], &input, 2, "bright");
    fails("pcond", &["-e", "1", "-x", "map.txt"], &input, 2, "--map");
    fails("pcond", &["-x", "-"], &input, 2, "file");
    fails("pcond", &["-l", "-e", "1"], &input, 2, "cannot be used");
    let spectrum = stream("NCOMP=5", "-Y 1 +X 1", &[1.0; 5]);
    fails("vonkries", &["--from", "A"], &spectrum, 1, "--components");
}

#[test]
fn overrides_stand_in_for_a_header() {
    let bare = stream("NCOMP=3", "-Y 1 +X 1", &[95.0, 100.0, 108.0]);
    let named = stream(&XYZ.replace("0.4476 0.4074", "0.31 0.33"), "-Y 1 +X 1", &[95.0, 100.0, 108.0]);
    let out = stdout_of("vonkries", &["--components", "XYZ", "--units", "cd/m2", "--white", "0.31,0.33"], &bare);
    assert_eq!(split(&out).2, split(&stdout_of("vonkries", &[], &named)).2);
    let noted = run("xyz2rgb", &[], &bare);
    assert!(String::from_utf8_lossy(&noted.stderr).contains("no COMPONENTS line"));
    assert!(run("xyz2rgb", &["--quiet"], &bare).stderr.is_empty());
}

#[test]
fn xyz_to_rgb_and_back_returns_every_colour() {
    let values: Vec<f32> = (0..300).map(|i| ((i * 7919 % 1000) as f32 + 1.0) / 7.0).collect();
    let input = stream(XYZ, "-Y 10 +X 10", &values);
    for to in ["BT.709", "P3", "BT.2020", "Adobe", "AP0", "AP1", "Radiance"] {
        let rgb = stdout_of("xyz2rgb", &["--quiet", "--to", to], &input);
        let back = stdout_of("xyz2rgb", &["-r"], &rgb);
        for (pixel, want) in floats(split(&back).2).chunks(3).zip(values.chunks(3)) {
            let top = want.iter().fold(0f32, |m, x| m.max(*x));
            assert!(pixel.iter().zip(want).all(|(a, b)| (a - b).abs() < 2e-6 * top * 3.0), "{to}: {pixel:?} {want:?}");
        }
    }
}

/// Eq. (7) of the paper, every printed digit.
#[test]
fn vonkries_prints_the_matrices_of_equation_7() {
    let c_b = [[3.1273, -1.6836, -0.4867], [-0.9806, 1.9476, 0.0282], [0.0605, -0.2036, 1.3404]];
    let c_a = [[2.9355, -2.0416, -0.5116], [-1.0247, 2.1431, -0.0500], [0.0732, -0.1798, 3.0895]];
    for (from, want) in [("0.3484,0.3516", c_b), ("0.4475,0.4075", c_a)] {
        let text = String::from_utf8(stdout_of("vonkries", &["--print", "--rgb", "--from", from], b"")).unwrap();
        let rows: Vec<Vec<f64>> = text.lines().map(|l| l.split(' ').map(|n| n.parse().unwrap()).collect()).collect();
        assert_eq!((rows.len(), rows[0].len()), (3, 3));
        for (row, want) in rows.iter().zip(want) {
            assert!(row.iter().zip(want).all(|(a, b)| (a - b).abs() <= 5e-5), "{row:?} {want:?}");
        }
    }
}

#[test]
fn renders_do_not_depend_on_threads_or_rows() {
    let small = ["--width", "40", "--samples", "4", "--quiet", "scenes/cornell.toml"];
    let whole = stdout_of("spectrace", &small, b"");
    let (lines, _, pixels) = split(&whole);
    assert!(lines.iter().any(|l| l == "spectrace cornell.toml --samples 4 --width 40"), "{lines:?}");
    assert!(lines.iter().any(|l| l.starts_with("VIEW= -vtv ") && l.contains("-vh 39.307648")), "{lines:?}");
    assert_eq!(stdout_of("spectrace", &[&["--threads", "1"], &small[..]].concat(), b""), whole);
    let mut bands = Vec::new();
    for rows in ["0:7", "7:8", "8:40"] {
        let band = stdout_of("spectrace", &[&["--rows", rows], &small[..]].concat(), b"");
        assert!(split(&band).0.iter().any(|l| *l == format!("ROWS= {} 40", rows.replace(':', " "))));
        bands.extend_from_slice(split(&band).2);
    }
    assert_eq!(bands, pixels);
    let spectrum = stdout_of("spectrace", &[&["--output", "spectrum", "--bands", "18"], &small[..]].concat(), b"");
    assert!(split(&spectrum).0.iter().any(|l| l == "WAVELENGTH_SPLITS= 780 588 480 380"));
    // The two roads to XYZ share their paths; they differ by how the lamp is sampled.
    let integrated = floats(split(&stdout_of("spec2xyz", &[], &spectrum)).2);
    let direct = stdout_of("spectrace", &[&["--bands", "18"], &small[..]].concat(), b"");
    let direct = floats(split(&direct).2);
    let (sum, sum_direct): (f32, f32) = (integrated.iter().sum(), direct.iter().sum());
    assert!((sum / sum_direct - 1.0).abs() < 0.01, "{sum} {sum_direct}");
}

#[test]
fn scene_errors_name_line_and_key() {
    let good = fs::read_to_string(root().join("scenes/cornell.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    let cases = [
        ("reflectance = \"cornell_white\"", "reflectanse = \"cornell_white\"", "reflectance"),
        ("reflectance = \"cornell_white\"", "reflectance = \"cornel_white\"", "did you mean 'cornell_white'"),
        ("reflectance = \"cornell_white\"", "reflectance = \"missing.csv\"", "missing.csv"),
        ("reflectance = \"cornell_white\"", "reflectance = 1.5", "0 to 1"),
        ("reflectance = \"cornell_white\"", "reflectance = nan", "finite"),
        ("reflectance = \"cornell_white\"", "reflectance = [[500, 0.5], [400, 0.5]]", "ascend"),
        ("luminance = 10000", "luminance = -5", "above 0"),
        ("luminance = 10000", "", "one of radiance, luminance"),
        ("luminance = 10000", "luminance = 10000\nwatts = 3", "one of radiance, luminance"),
        ("spectrum = \"cornell_light\"", "spectrum = [[300, 1], [310, 1]]", "no visible light"),
        ("fov_deg = 39.30764811610662", "fov_deg = 180", "fov_deg"),
        ("width = 512", "width = 0", "width"),
        ("unit = \"mm\"", "unit = \"yard\"", "mm, in or ft"),
        ("unit = \"mm\"", "unti = \"mm\"", "unti"),
        ("unit = \"mm\"", "unit = ", "line 5"),
        ("up = [0, 1, 0]", "up = [0, 0, 1]", "up"),
        ("type = \"quad\"", "type = \"quid\"", "quad, triangle, polygon, box, sphere, disk, cylinder, cone, mesh"),
        ("material = \"white\"", "material = \"whit\"", "no material 'whit'"),
        ("[552.8, 0, 0]", "[0, 0, 0]", "one line"),
        ("points = [[552.8, 0, 0], [0, 0, 0]", "points = [[0, 0, 0], [552.8, 0, 0]", "convex"),
        ("[552.8, 0, 0]", "[inf, 0, 0]", "finite"),
        ("light = \"lamp\"", "", "no shape has it"),
    ];
    for (from, to, word) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let path = file.to_str().unwrap();
        fails("spectrace", &[path], b"", 1, word);
        let message = run("spectrace", &[path], b"").stderr;
        let message = String::from_utf8_lossy(&message).into_owned();
        assert!(message.contains(": line ") && message.contains("scene.toml"), "{message}");
    }
    fails("spectrace", &[], b"", 2, "SCENE");
    fails("spectrace", &["scenes/none.toml"], b"", 1, "none.toml");
    fails("spectrace", &["scenes/cornell.toml", "--rows", "0:9999"], b"", 2, "rows");
    fails("spectrace", &["scenes/cornell.toml", "--bands", "0"], b"", 2, "bands");
    fails("spectrace", &["scenes/cornell.toml", "--wavelengths", "500,400,450"], b"", 2, "wavelengths");
}

/// The pipelines of the repository with few, small samples, their outputs in `folder`.
fn quick_pipelines(folder: &Path) -> Vec<(String, PathBuf)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(root().join("pipelines")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let text = fs::read_to_string(&path).unwrap();
        let text = text.replace("\"out/", &format!("\"{}/", folder.display()));
        let lines = text.lines().map(|l| if l.starts_with("samples = ") { "samples = 2\nwidth = 48" } else { l });
        let file = folder.join(format!("{name}.toml"));
        fs::write(&file, lines.collect::<Vec<_>>().join("\n")).unwrap();
        all.push((name, file));
    }
    all.sort();
    all
}

fn take_outputs(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut outputs = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e != "toml") {
            outputs.push((path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()));
            fs::remove_file(path).unwrap();
        }
    }
    outputs.sort();
    outputs
}

#[test]
fn a_pipeline_in_one_process_gives_the_bytes_of_the_shell_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let pipelines = quick_pipelines(folder.path());
    assert!(pipelines.len() >= 3);
    for (name, file) in pipelines {
        let file = file.to_str().unwrap();
        stdout_of("luxpipe", &[file], b"");
        let fused = take_outputs(folder.path());
        assert!(fused.iter().any(|(n, bytes)| n.ends_with(".png") && bytes.len() > 500), "{name}");
        let line = String::from_utf8(stdout_of("luxpipe", &["--shell", file], b"")).unwrap();
        let path = format!("{}:{}", program("luxpipe").parent().unwrap().display(), std::env::var("PATH").unwrap());
        let shell = Command::new("sh").args(["-c", &line]).env("PATH", path).current_dir(root()).output().unwrap();
        assert!(shell.status.success(), "{line}: {}", String::from_utf8_lossy(&shell.stderr));
        let piped = take_outputs(folder.path());
        assert_eq!(fused.iter().map(|o| &o.0).collect::<Vec<_>>(), piped.iter().map(|o| &o.0).collect::<Vec<_>>());
        for ((file, a), (_, b)) in fused.iter().zip(&piped) {
            assert!(a == b, "{name}: {file} differs between one process and {line}");
        }
    }
}

#[test]
fn an_intent_is_a_whole_chain() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shown.png");
    let office = "tests/data/radiance_office.hdr";
    for display in ["srgb", "p3", "hdr10", "crt", "print"] {
        for intent in ["perceptual", "saturation", "colorimetric"] {
            let args = ["--intent", intent, "--display", display, office, file.to_str().unwrap()];
            stdout_of("luxpipe", &args, b"");
            let fused = fs::read(&file).unwrap();
            let decoder = png::Decoder::new(std::io::Cursor::new(&fused)).read_info().unwrap();
            let deep = decoder.info().bit_depth == png::BitDepth::Sixteen;
            assert_eq!(deep, display == "hdr10", "{display}");
            let line = String::from_utf8(stdout_of("luxpipe", &[&["--shell"], &args[..]].concat(), b"")).unwrap();
            let path = format!("{}:{}", program("luxpipe").parent().unwrap().display(), std::env::var("PATH").unwrap());
            let shell = Command::new("sh").args(["-c", &line]).env("PATH", path).current_dir(root()).output().unwrap();
            assert!(shell.status.success(), "{line}: {}", String::from_utf8_lossy(&shell.stderr));
            assert!(fs::read(&file).unwrap() == fused, "{intent} {display}: {line}");
        }
    }
    fails("luxpipe", &["--intent", "perceptual", office, "out.hdr"], b"", 2, ".png");
    fails("luxpipe", &["--intent", "relative", office], b"", 2, "relative");
    fails("luxpipe", &[office, "out.png"], b"", 2, "--intent");
}

/// A stage refuses a picture that was made for another display.
#[test]
fn displays_must_agree() {
    let picture = data("radiance_office.hdr");
    let shown = stdout_of("pcond", &["--display", "p3"], &picture);
    fails("xyz2rgb", &["--display", "srgb"], &shown, 1, "pcond --display srgb");
    let rgb = stdout_of("xyz2rgb", &["--display", "p3", "--quiet"], &shown);
    fails("ra_png", &["--display", "srgb"], &rgb, 1, "display srgb shows");
    fails("ra_png", &["--display", "nowhere"], &rgb, 2, "srgb");
    stdout_of("ra_png", &["--display", "p3"], &rgb);
}

/// D = F (0.08 lg(La) + 0.76) for equal luminances; white guessed from the picture.
#[test]
fn vonkries_degree_and_guessed_white() {
    let mut values = [0.3f32, 1.0, 0.4].repeat(99);
    values.extend([110.0, 100.0, 35.0]);
    let input = stream(&XYZ.replace("WHITE= 0.4476 0.4074\n", ""), "-Y 10 +X 10", &values);
    let output = run("vonkries", &["--from", "auto"], &input);
    assert!(String::from_utf8_lossy(&output.stderr).contains("white 0.4490,0.4082 guessed"), "{output:?}");
    let lines = split(&output.stdout).0;
    assert!(lines.iter().any(|l| l.starts_with("ADAPTED= 0.4489")), "{lines:?}");
    let grey = run("vonkries", &["--from", "grey"], &input);
    assert!(String::from_utf8_lossy(&grey.stderr).contains("mean of all pixels"));
    let out = stdout_of("vonkries", &["--from", "A", "--degree", "auto", "--la", "100", "--ld", "100"], &input);
    let adapted = split(&out).0.into_iter().find(|l| l.starts_with("ADAPTED=")).unwrap();
    let degree: f64 = adapted.split(' ').next_back().unwrap().parse().unwrap();
    assert!((degree - 0.92).abs() < 1e-12, "{adapted}");
}

/// Melanopic and relative quantities of an equal spectrum have closed forms.
#[test]
fn spec2xyz_knows_other_observers_and_responses() {
    let points = "NCOMP=2\nCOMPONENTS=SPECTRUM\nUNITS=W/sr/m2/nm\nWAVELENGTHS= 360 830";
    let equal = stream(points, "-Y 1 +X 1", &[1.0, 1.0]);
    let one = |args: &[&str]| floats(split(&stdout_of("spec2xyz", args, &equal)).2);
    let close = |a: f32, b: f64| assert!((f64::from(a) / b - 1.0).abs() < 1e-4, "{a} for {b}");
    close(one(&[])[1], 683.0 * 106.8569); // CIE 15: sum of ybar
    close(one(&["--observer", "1964"])[1], 683.0 * 116.6618); // CIE 15: sum of ybar10
    // The table of E holds 100: this spectrum is a hundredth of it.
    one(&["--relative-to", "E"]).iter().for_each(|x| assert!((100.0 * x - 1.0).abs() < 4e-4, "{x}"));
    // Both responses at once; the equal spectrum gives the sum of a table at every nanometre.
    let text = fs::read_to_string(root().join("spectra/scotopic_v.csv")).unwrap();
    let rows = text.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit()));
    let scotopic: f64 = rows.map(|l| l.split_once(',').unwrap().1.parse::<f64>().unwrap()).sum();
    let two = one(&["--response", "scotopic_v", "--response", "photopic_v", "--factor", "1700"]);
    close(two[0], 1700.0 * scotopic);
    close(two[1], 1700.0 * 106.857);
    let text = stdout_of("spec2xyz", &["--response", "scotopic_v"], &equal);
    assert!(split(&text).0.iter().any(|l| l == "COMPONENTS=RESPONSE"));
    fails("spec2xyz", &["--response", "scotopic_w"], &equal, 1, "scotopic_v");
    fails("spec2xyz", &["--observer", "1964"], &data("small_xyz.lux"), 1, "spectrum");
}

#[test]
fn pipeline_errors_name_line_and_key() {
    let good = fs::read_to_string(root().join("pipelines/office.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("office.png");
    let good = good.replace("out/office.png", out.to_str().unwrap());
    let file = folder.path().join("p.toml");
    let cases = [
        ("gamut =", "gamutt =", "gamutt"),
        ("gamut = \"desaturate\"", "gamut = \"desaturat\"", "desaturate"),
        ("run = \"pcond\"", "run = \"pkond\"", "no filter 'pkond'"),
        ("run = \"pcond\"", "", "needs run"),
        ("run = \"pcond\"", "run = \"pcond\"\nlinear = 3", "boolean"),
        ("run = \"pcond\"", "run = \"pcond\"\nlinear = true\nexposure = -1", "cannot be used"),
        ("run = \"vonkries\"", "run = \"vonkries\"\nrgb = \"P3\"", "required"),
        ("to = \"D65\"", "to = \"D64\"", "D64"),
        ("to = \"D65\"", "to = \"D65\"\nsave = \"x.jpg\"", ".xyze"),
        ("to = \"D65\"", "to = \"D65\"\noutput = \"x.lux\"", "last stage"),
        ("name = \"office\"", "nam = \"office\"", "nam"),
        ("[[stage]]\nrun = \"pcond\"", "[[stage]\nrun = \"pcond\"", "line"),
        ("run = \"pcond\"", "run = \"picinfo\"", "only the last stage"),
        ("tests/data/radiance_office.hdr", "tests/data/none.hdr", "none.hdr"),
        ("tests/data/radiance_office.hdr", "tests/bad/flat_cut.hdr", "row 2 of 2"),
        ("run = \"ra_png\"", "run = \"spectrace\"\nscene = \"s.toml\"", "must be the first"),
    ];
    for (from, to, word) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        fails("luxpipe", &[file.to_str().unwrap()], b"", 1, word);
        assert!(!out.exists(), "{to} left a picture");
    }
    fs::write(&file, "").unwrap();
    fails("luxpipe", &[file.to_str().unwrap()], b"", 1, "at least one");
    fails("luxpipe", &["none.toml"], b"", 1, "none.toml");
    fails("luxpipe", &[], b"", 2, "PIPELINE");
}

/// The pipe on the README's first screen, smaller.
#[test]
fn the_pipe_of_the_readme_makes_a_picture() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let line =
        "spectrace scenes/cornell.toml | vonkries --to D65 | pcond | xyz2rgb --gamut desaturate | ra_png > cornell.png";
    assert!(readme.lines().take(40).any(|l| l.contains(line)), "the first screen has another pipe");
    let mut picture = stdout_of("spectrace", &["scenes/cornell.toml", "--width", "32", "--samples", "64"], b"");
    for (name, args) in
        [("vonkries", &["--to", "D65"][..]), ("pcond", &[]), ("xyz2rgb", &["--gamut", "desaturate"]), ("ra_png", &[])]
    {
        let output = run(name, args, &picture);
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{name}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        picture = output.stdout;
    }
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let at = |x: usize, y: usize| &pixels[(y * 32 + x) * 3..][..3];
    assert!(at(16, 4).iter().all(|c| *c > 250), "the lamp is white: {:?}", at(16, 4));
    let (left, right) = (at(2, 16), at(29, 16));
    assert!(left[0] > 2 * left[1] && right[1] > 2 * right[0], "red wall {left:?}, green wall {right:?}");
}

/// Run lengths that lost bytes can fall into step again, some of their rows taken for pixels as they are: that is told.
#[test]
fn rows_of_two_kinds_are_told_of() {
    let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n".to_vec();
    let runs = [&[2, 2, 0, 8][..], &[0x88, 128, 0x88, 128, 0x88, 128, 0x88, 129]].concat();
    let flat = [128, 128, 128, 129].repeat(8);
    for (rows, told) in
        [([&runs, &runs], false), ([&flat, &flat], false), ([&runs, &flat], true), ([&flat, &runs], true)]
    {
        let output = run("picinfo", &[], &[&head, rows[0].as_slice(), rows[1]].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && said.contains("may be damaged") == told, "{said}");
    }
}
