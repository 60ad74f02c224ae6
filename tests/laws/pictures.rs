//! Random pictures through the real filters.

use luxpipe::color::Primaries;

use crate::chance::{Chance, holds};
use crate::common::{encodings, floats, run, split, stdout_of, stream};

const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329";

/// Light of any colour that there is, over decades.
fn any(c: &mut Chance, low: f64, high: f64) -> Vec<u8> {
    let (width, height) = (c.whole(1, 9), c.whole(1, 5));
    let pixels: Vec<f32> = (0..width * height)
        .flat_map(|_| {
            let light = c.decades(low, high);
            // Mixtures of three lights keep to colours that any of the encodings holds.
            let rgb = [c.between(0.2, 1.0), c.between(0.2, 1.0), c.between(0.2, 1.0)];
            Primaries::BT709.to_xyz().unwrap().apply(rgb).map(|v| (v * light) as f32)
        })
        .collect();
    stream(XYZ, &format!("-Y {height} +X {width}"), &pixels)
}

/// Largest difference of two pictures' numbers, in parts of the largest number.
fn off(a: &[u8], b: &[u8]) -> f32 {
    let (a, b) = (floats(split(a).2), floats(split(b).2));
    assert_eq!(a.len(), b.len());
    let most = a.iter().fold(1e-30f32, |m, x| m.max(x.abs()));
    a.iter().zip(&b).fold(0f32, |m, (a, b)| m.max((a - b).abs())) / most
}

/// Filters that are linear maps of a pixel: exposure may come before or after.
const LINEAR: [&[&str]; 8] = [
    &["xyz2rgb"],
    &["xyz2rgb", "--to", "BT.2020"],
    &["vonkries", "--to", "A"],
    &["vonkries", "--to", "D50", "--cat", "bradford", "--degree", "0.7"],
    &["pcond", "-e", "0.001"],
    &["pmix", "--weight", "0.7"],
    &["ra_pfm"],
    &["ra_exr", "--float"],
];

#[test]
fn exposure_commutes_with_linear_filters() {
    holds(6, |c| {
        let picture = any(c, 1e-3, 1e3);
        // A power of two changes no digit, so that nothing may differ; any other number rounds.
        let (exact, any) = (2f64.powi(c.whole(0, 20) as i32 - 10), c.decades(1e-3, 1e3));
        for (factor, tolerance) in [(exact, 0.0), (any, 4e-7)] {
            let factor = factor.to_string();
            let expose = |x: &[u8]| stdout_of("pmix", &["--weight", &factor, "--quiet"], x);
            for filter in LINEAR {
                let through = |x: &[u8]| {
                    let out = stdout_of(filter[0], &[&filter[1..], &["--quiet"]].concat(), x);
                    if filter[0].starts_with("ra_") { stdout_of(filter[0], &["-r", "--quiet"], &out) } else { out }
                };
                let (before, after) = (through(&expose(&picture)), expose(&through(&picture)));
                assert!(off(&after, &before) <= tolerance, "{filter:?}, exposed by {factor}: {}", off(&after, &before));
            }
        }
    });
}

/// There and back by a matrix is where it was.
#[test]
fn colours_come_back() {
    holds(12, |c| {
        let picture = any(c, 1e-3, 1e4);
        let back = |there: &[&str], back: &[&str]| {
            let out = stdout_of(there[0], &there[1..], &picture);
            off(&picture, &stdout_of(back[0], &back[1..], &out))
        };
        let white = |c: &mut Chance| format!("{:.4},{:.4}", c.between(0.25, 0.45), c.between(0.25, 0.42));
        let (from, to) = (white(c), white(c));
        let cat = *c.of(&["cmccat2000", "vonkries", "bradford", "sharp", "cat02", "cat16"]);
        let far = ["vonkries", "--from", &from, "--to", &to, "--cat", cat];
        let home = ["vonkries", "--from", &to, "--to", &from, "--cat", cat];
        assert!(back(&far, &home) < 3e-6, "{from} to {to} by {cat}: {}", back(&far, &home));
        let primaries = *c.of(&["BT.709", "P3", "BT.2020", "Adobe", "Radiance", "AP0", "AP1"]);
        let error = back(&["xyz2rgb", "--to", primaries], &["xyz2rgb", "-r"]);
        assert!(error < 3e-6, "{primaries}: {error}");
    });
}

/// What an encoding has read it writes again, bit by bit, and the picture has its size.
#[test]
fn encodings_are_stable() {
    let all: Vec<_> = encodings().into_iter().filter(|e| !e.options.iter().any(|o| o == "--spectra")).collect();
    assert!(all.len() > 8);
    holds(3, |c| {
        let light = any(c, 1.0, 100.0);
        let shown = stdout_of("xyz2rgb", &[], &stdout_of("pcond", &["--quiet"], &light));
        let shown = stdout_of("xyz2rgb", &["--gamut", "clip", "--quiet"], &stdout_of("xyz2rgb", &["-r"], &shown));
        for e in &all {
            let first = e.read(&e.write(if e.filter == "ra_png" { &shown } else { &light }));
            let size = |x: &[u8]| split(x).1.split_whitespace().map(String::from).collect::<Vec<_>>();
            assert_eq!(size(&first), size(&light), "{e}");
            let second = e.read(&e.write(&first));
            assert!(split(&first).2 == split(&second).2, "{e}: the second pass differs from the first");
        }
    });
}

/// Rules of tone that look at a pixel's luminance alone.
const RULES: [&[&str]; 10] = [
    &[],
    &["-l"],
    &["-s"],
    &["--classic"],
    &["--classic", "-s"],
    &["--goal", "visibility"],
    &["--goal", "colour"],
    &["--print"],
    &["--surround", "dark"],
    &["-s", "--adapted", "1000"],
];

/// What is brighter in the world is never darker on the display, of any scene and any display.
#[test]
fn tone_maps_are_monotone() {
    holds(8, |c| {
        let (low, high) = (c.decades(1e-6, 1.0), c.decades(10.0, 1e7));
        let mut greys: Vec<f64> =
            (0..200).map(|_| low * (high / low).powf(c.share().powi(1 + c.whole(0, 2) as i32))).collect();
        greys.sort_by(f64::total_cmp);
        let pixels: Vec<f32> = greys.iter().flat_map(|g| [0.9505 * g, *g, 1.0891 * g]).map(|v| v as f32).collect();
        let picture = stream(XYZ, "-Y 1 +X 200", &pixels);
        let (white, contrast) = (c.decades(5.0, 1e4).to_string(), c.decades(3.0, 1e6).to_string());
        let folder = tempfile::tempdir().unwrap();
        let map = folder.path().join("map.txt");
        for rule in RULES {
            let args = [rule, &["-u", &white, "-d", &contrast, "-x", map.to_str().unwrap(), "--quiet"]].concat();
            let output = run("pcond", &args, &picture);
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{args:?}: {message}");
            let shown: Vec<f32> = floats(split(&output.stdout).2).chunks(3).map(|p| p[1]).collect();
            let white: f32 = shown.iter().fold(0.0, |m, x| m.max(*x));
            for (pair, world) in shown.windows(2).zip(greys.windows(2)) {
                let falls = pair[0] - pair[1];
                // Pixels' factors are straight over a 128th of an octave, which 1 / l leaves by (1 / 128)^2 / 4.
                assert!(falls <= 1.6e-5 * white, "{args:?}: {world:?} cd/m2 became {pair:?}");
            }
            let text = std::fs::read_to_string(&map).unwrap();
            let rows: Vec<Vec<f64>> = text
                .lines()
                .filter(|l| !l.starts_with('#'))
                .map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect())
                .collect();
            assert!(rows.len() >= 2, "{args:?}: {text}");
            for pair in rows.windows(2) {
                assert!(pair[0][0] <= pair[1][0] && pair[0][1] <= pair[1][1], "{args:?}: {pair:?}");
            }
        }
    });
}
