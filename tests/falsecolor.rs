//! `falsecolor`: colours by the palettes' formulas, contours of pictures whose levels are circles, the legend beside them.

mod common;

use std::fs;

use common::{fails, floats, run, split, stdout_of, stream};
use luxpipe::chart::{NO_VALUE, WHITE};
use luxpipe::display::transfer::srgb_decode;

const Y: &str = "NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2";
const BARE: [&str; 2] = ["--legend", "0x0"];

/// A picture of Y by column and row.
fn picture(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Vec<u8> {
    let values: Vec<f32> = (0..width * height).map(|i| f(i % width, i / width)).collect();
    stream(Y, &format!("-Y {height} +X {width}"), &values)
}

/// Width, height and pixels of what it makes.
fn made(options: &[&str], input: &[u8]) -> (usize, usize, Vec<[f32; 3]>) {
    let out = stdout_of("falsecolor", options, input);
    let (lines, resolution, bytes) = split(&out);
    for line in ["COMPONENTS=RGB", "UNITS=display"] {
        assert!(lines.iter().any(|l| l == line), "{lines:?}");
    }
    let words: Vec<&str> = resolution.split_whitespace().collect();
    let pixels = floats(bytes).chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    (words[3].parse().unwrap(), words[1].parse().unwrap(), pixels)
}

fn near(a: [f32; 3], b: [f64; 3], tolerance: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (f64::from(*a) - b).abs() <= tolerance)
}

#[test]
fn values_have_their_colours() {
    let ramp = picture(101, 1, |x, _| x as f32);
    let (w, h, grey) = made(&[&BARE[..], &["-s", "100", "--palette", "grey"]].concat(), &ramp);
    assert_eq!((w, h), (101, 1));
    for (x, pixel) in grey.iter().enumerate() {
        assert!(near(*pixel, [srgb_decode(x as f64 / 100.0); 3], 1e-3), "{x}: {pixel:?}");
    }
    // Radiance's formulas: blue at 0, 1.6 v - 0.6 and 1.6 - 1.6 v at 0.75, red at 1.
    let (_, _, spec) = made(&[&BARE[..], &["-s", "100"]].concat(), &ramp);
    for (x, want) in [(0, [0.0, 0.0, 1.0]), (75, [0.6, 0.4, 0.0]), (100, [1.0, 0.0, 0.0])] {
        assert!(near(spec[x], want, 2e-3), "{x}: {:?}", spec[x]);
    }
    // Four decades below 1000: 10 cd/m2 half way, 0 and 0.05 at the bottom.
    let steps = picture(4, 1, |x, _| [0.0, 0.05, 10.0, 1000.0][x]);
    let (_, _, log) = made(&[&BARE[..], &["--log", "4", "--palette", "grey"]].concat(), &steps);
    assert!(near(log[2], [srgb_decode(0.5); 3], 1e-3) && log[0] == log[1] && near(log[3], [1.0; 3], 1e-6), "{log:?}");
    // Four bands of 25: each its middle's grey.
    let (_, _, bands) = made(&[&BARE[..], &["-s", "100", "-n", "4", "--bands", "--palette", "grey"]].concat(), &ramp);
    for (x, pixel) in bands.iter().enumerate() {
        let middle = ((x / 25).min(3) as f64 + 0.5) / 4.0;
        assert!(near(*pixel, [srgb_decode(middle); 3], 1e-3), "{x}: {pixel:?}");
    }
    // viridis' published ends, and ever lighter between.
    let (_, _, viridis) = made(&[&BARE[..], &["-s", "100", "--palette", "viridis"]].concat(), &ramp);
    for (x, want) in [(0, [68.0, 1.0, 84.0]), (100, [253.0, 231.0, 37.0])] {
        assert!(near(viridis[x], want.map(|c: f64| srgb_decode(c / 255.0)), 4e-3), "{:?}", viridis[x]);
    }
    let light = |p: &[f32; 3]| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
    assert!(viridis.windows(2).all(|p| light(&p[0]) < light(&p[1])));
}

#[test]
fn what_has_no_value_is_magenta_and_counted() {
    let odd = picture(5, 1, |x, _| [f32::NAN, -1.0, f32::INFINITY, 0.0, 5.0][x]);
    let (_, _, pixels) = made(&BARE, &odd);
    assert_eq!(pixels.iter().map(|p| *p == NO_VALUE).collect::<Vec<_>>(), [true, true, true, false, false]);
    let notes = String::from_utf8(run("falsecolor", &BARE, &odd).stderr).unwrap();
    assert!(notes.contains("3 pixels that are negative or not finite are magenta"), "{notes}");
    // On a scale that begins below 0 a negative number has its colour.
    let (_, _, pixels) = made(&[&BARE[..], &["--min", "-2"]].concat(), &odd);
    assert!(pixels[1] != NO_VALUE && pixels[0] == NO_VALUE);
}

/// Levels of the distance from the middle are circles: a pixel shines by how near it is to one.
#[test]
fn contours_of_a_cone_are_circles() {
    let r = |x: usize, y: usize| (x as f32 - 100.0).hypot(y as f32 - 100.0);
    let cone = picture(201, 201, r);
    let (_, _, pixels) =
        made(&[&BARE[..], &["--contours", "-s", "120", "-n", "4", "--palette", "hot"]].concat(), &cone);
    let mut lit = 0;
    for (i, pixel) in pixels.iter().enumerate() {
        let r = r(i % 201, i / 201);
        let off = [30.0, 60.0, 90.0, 120.0].map(|level: f32| (r - level).abs()).into_iter().fold(f32::MAX, f32::min);
        let dark = *pixel == [0.0; 3];
        assert!(if off < 0.7 { !dark } else { off < 1.8 || dark }, "{} {}: {off} {pixel:?}", i % 201, i / 201);
        lit += usize::from(!dark);
    }
    assert!(lit > 1500, "{lit}");
    // A step over many levels is one line, not a filled disk.
    let step = picture(60, 60, |x, y| if x.pow(2) + y.pow(2) < 900 { 1000.0 } else { 1.0 });
    let (_, _, pixels) = made(&[&BARE[..], &["--contours"]].concat(), &step);
    let lit = pixels.iter().filter(|p| **p != [0.0; 3]).count();
    assert!((45..200).contains(&lit), "{lit}");
}

#[test]
fn the_legend_stands_at_the_left_and_the_picture_beside_it() {
    let ramp = picture(300, 250, |x, y| (x + y) as f32);
    let (w, h, pixels) = made(&["-s", "600"], &ramp);
    let (_, _, bare) = made(&[&BARE[..], &["-s", "600"]].concat(), &ramp);
    assert!(w > 330 && w < 400 && h == 250, "{w} x {h}");
    for y in 0..h {
        assert_eq!(pixels[y * w + w - 300..][..300], bare[y * 300..][..300], "row {y}");
    }
    let legend: Vec<_> = (0..h).flat_map(|y| &pixels[y * w..][..w - 300]).collect();
    assert!(legend.iter().filter(|p| ***p == WHITE).count() > 200, "no text");
    for end in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
        assert!(legend.iter().any(|p| near(**p, end, 0.02)), "no bar");
    }
    let (w, h, _) = made(&["--legend", "100x200"], &picture(10, 10, |_, _| 1.0));
    assert_eq!((w, h), (110, 200));
    // A legend is as wide as its unit.
    let (w, _, _) = made(&["--label", "a rather long unit"], &ramp);
    assert!(w > 300 + 18 * 6, "{w}");
}

#[test]
fn extremes_are_marked() {
    let hill = picture(200, 200, |x, y| match (x, y) {
        (150, 60) => 900.0,
        (40, 120) => 0.5,
        _ => 300.0,
    });
    let (_, _, plain) = made(&BARE, &hill);
    let (_, _, marked) = made(&[&BARE[..], &["-e"]].concat(), &hill);
    for (x, y) in [(150usize, 60usize), (40, 120)] {
        assert_eq!(marked[y * 200 + x], WHITE);
        // Its value stands to the right.
        let beside = (y - 4..y + 5).flat_map(|row| &marked[row * 200 + x + 7..][..20]);
        assert!(beside.filter(|p| **p == WHITE).count() > 10);
    }
    let changed = plain.iter().zip(&marked).filter(|(a, b)| a != b).count();
    assert!(changed < 1200, "{changed}");
    // The corners of a fisheye's square are no darkest point.
    let eye = |x: usize, y: usize| if (x as f32 - 49.5).hypot(y as f32 - 49.5) > 50.0 { 0.0 } else { 5.0 };
    let values: Vec<f32> = (0..10_000).map(|i| if i == 5020 { 2.0 } else { eye(i % 100, i / 100) }).collect();
    let fisheye = stream(&format!("{Y}\nVIEW= -vta -vh 180 -vv 180"), "-Y 100 +X 100", &values);
    let (_, _, marked) = made(&[&BARE[..], &["-e"]].concat(), &fisheye);
    assert_eq!((marked[5020], marked[0] == WHITE), (WHITE, false));
}

#[test]
fn radiances_words_mean_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.lux");
    let ramp = picture(120, 90, |x, y| (x * y) as f32);
    fs::write(&file, &ramp).unwrap();
    let path = file.to_str().unwrap();
    for (old, new) in [
        (vec!["-i", path, "-cp", "-log", "2", "-pal", "hot"], vec!["--bands", "--log", "2", "--palette", "hot", path]),
        (vec!["-ip", path, "-cl", "-n", "5"], vec!["--contours", "--background", "input", "-n", "5", path]),
        (
            vec!["-cb", "-lw", "60", "-s", "500", "-i", path],
            vec!["--contour-bands", "--legend", "60x200", "-s", "500", path],
        ),
        (vec!["-m", "358", "-l", "Lux", "-e", path], vec!["--factor", "2", "--label", "Lux", "--extremes", path]),
        (vec!["-s", "auto", "-lh", "0", path], vec!["--legend", "100x0", path]),
    ] {
        assert_eq!(stdout_of("falsecolor", &old, b""), stdout_of("falsecolor", &new, b""), "{old:?}");
    }
    fails("falsecolor", &["-log"], b"", 2, "-log");
    fails("falsecolor", &["--palette", "rainbow"], &ramp, 2, "viridis");
    fails("falsecolor", &["--background", path], &ramp, 2, "--contours");
    fails("falsecolor", &["--contours", "-p", path], &picture(3, 3, |_, _| 1.0), 1, "120 x 90");
    fails("falsecolor", &["--min", "5", "-s", "2"], &ramp, 2, "--min");
    fails("falsecolor", &["--legend", "60000x60000"], &ramp, 2, "--memory");
    fails("falsecolor", &["-n", "0"], &ramp, 2, "--divisions");
}

#[test]
fn order_threads_and_pipes_change_nothing() {
    let f = |x: usize, y: usize| (x * x + 3 * y) as f32;
    let options = ["--contours", "-p", "input", "-e", "--threads"];
    let with = |n: &'static str, input: &[u8]| made(&[&options[..], &[n]].concat(), input).2;
    let want = with("1", &picture(70, 50, f));
    assert_eq!(with("2", &picture(70, 50, f)), want);
    let turned: Vec<f32> = (0..3500).rev().map(|i| f(i % 70, i / 70)).collect();
    assert_eq!(with("2", &stream(Y, "+Y 50 -X 70", &turned)), want);
    let xyz: Vec<f32> = (0..3500).flat_map(|i| [f(i % 70, i / 70); 3]).collect();
    let xyz = stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2", "-Y 50 +X 70", &xyz);
    assert_eq!(made(&["-n", "3"], &xyz), made(&["-n", "3"], &picture(70, 50, f)));
    let png = stdout_of("ra_png", &["--quiet"], &stdout_of("falsecolor", &["--contours", "-p", "input"], &xyz));
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn odd_pictures_make_finite_ones() {
    let values: [f32; 7] = [0.0, 1.0, -5.0, f32::NAN, f32::INFINITY, 3e38, 1e-42];
    for a in values {
        for b in values {
            let two = picture(2, 1, |x, _| [a, b][x]);
            let one = picture(1, 1, |_, _| a);
            for options in
                [&[][..], &["--log", "3"], &["--contours", "-p", "input", "-e"], &["--bands", "--min", "-10"]]
            {
                for input in [&two, &one] {
                    let (_, _, pixels) = made(&[options, &["--quiet"]].concat(), input);
                    assert!(pixels.iter().flatten().all(|x| (0.0..=1.0).contains(x)), "{a} {b} {options:?}");
                }
            }
        }
    }
}
