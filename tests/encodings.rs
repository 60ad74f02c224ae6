//! What the encodings keep, against figures that other programs computed (tests/ref/encodings.csv), and a LogLuv master on its
//! way to a display it was not made for, through the real programs.

mod common;
#[path = "../examples/encodings/mod.rs"]
mod encodings;

use std::collections::HashMap;

use common::{floats, page_is_printed, root, split, stdout_of, stream};
use encodings::coders::{Coder, ENCODINGS, Encoding, LIBTIFF_PIXAR, named};
use encodings::visible::{Errors, Report, colours, in_cells};
use encodings::{RANGES, grey};
use luxpipe::color::difference::uv;
use luxpipe::color::{Mat3, Primaries};

/// Colours of the reference's sample, and how many of them share each chromaticity.
const SAMPLE: f64 = 347_088.0;
const SHARING: f64 = 16.0;

type Xyz = [f64; 3];

/// Encoding, group and quantity, value.
fn reference() -> Vec<(String, [String; 2], f64)> {
    let text = std::fs::read_to_string(root().join("tests/ref/encodings.csv")).unwrap();
    let row = |line: &str| {
        let t: Vec<&str> = line.split(',').collect();
        (t[0].to_string(), [t[1].to_string(), t[2].to_string()], t[3].parse().unwrap())
    };
    text.lines().filter(|l| !l.starts_with(['#', 'e'])).map(row).collect()
}

/// The encoding that a row of the reference means: Pixar log's rows are of libtiff's encoder, ours takes nearer codes.
fn meant(name: &str) -> Encoding {
    if name == "Pixar log BT.709" { LIBTIFF_PIXAR } else { named(name) }
}

fn near(got: f64, want: f64, share: f64) -> bool {
    (got / want - 1.0).abs() <= share
}

/// How far apart two samples of the same colours may be. A mean, or what 95 or 99 % stay below: 1 to 3 %. A share: three times
/// its standard error, where sixteen colours of one chromaticity fare alike. The largest of a sample depends on which colour
/// happens to lie in the worst corner of a cell or of the locus: the reference's two samples differ by up to 12 % themselves.
fn tolerance(encoding: &Encoding, group: &str, quantity: &str, want: f64) -> f64 {
    // Four colours in a hundred pass Pixar log's ceiling there and carry the mean: three standard errors.
    let few = encoding.coder == Coder::PixarLogOfLibtiff && group == "0.02..10";
    match quantity {
        "in709_mean" | "Yerr_in709_mean" if few => 0.045,
        "e00_mean" | "outside" => 0.01,
        "in709_mean" | "Yerr_in709_mean" => 0.02,
        "e00_p95" => 0.02,
        "e00_p99" => 0.03,
        // Seventy chromaticities of the reference's grid lie beyond: plain grids, one half a step from the other, differ as much.
        "in709_p99" => 0.05,
        "share_gt1" | "share_gt5" => 3.0 * (SHARING * (1.0 - want) / (want * SAMPLE)).sqrt(),
        // The few violets whose RGB nearly cancel in luminance.
        "e00_max" if encoding.coder == Coder::Half => 0.25,
        "e00_max" => 0.06,
        // Three codes' noise at once.
        "in709_max" if encoding.coder == (Coder::LogLuv24 { dithered: true }) => 0.25,
        "in709_max" => 0.15,
        "Yerr_in709_max" => 0.25,
        other => panic!("{other}"),
    }
}

fn quantity(report: &Report, name: &str) -> f64 {
    let (all, inside) = (report.all, report.in_709);
    match name {
        "e00_mean" => all.mean,
        "e00_p95" => all.p95,
        "e00_p99" => all.p99,
        "e00_max" => all.max,
        "share_gt1" => all.over_1,
        "share_gt5" => all.over_5,
        "in709_mean" => inside.mean,
        "in709_p99" => inside.p99,
        "in709_max" => inside.max,
        "Yerr_in709_mean" => inside.luminance[0],
        "Yerr_in709_max" => inside.luminance[1],
        "outside" => report.outside,
        other => panic!("{other}"),
    }
}

#[test]
fn visible_colours_fare_as_other_programs_have_it() {
    let sets = RANGES.map(colours);
    let mut reports: HashMap<(String, String), Report> = HashMap::new();
    let (mut seen, mut off) = (0, Vec::new());
    for (name, [group, what], want) in reference().into_iter().filter(|r| r.1[0] != "grey") {
        let (encoding, set) = (meant(&name), &sets[usize::from(group == "0.02..10")]);
        let report = reports.entry((name.clone(), group.clone())).or_insert_with(|| {
            // The reference's grid has no colour beyond LogLuv24's cells, whose edge is tested below.
            let inside = matches!(encoding.coder, Coder::LogLuv24 { .. });
            if inside { Report::of(&encoding, &in_cells(set)) } else { Report::of(&encoding, set) }
        });
        let got = quantity(report, &what);
        if want == 0.0 {
            assert_eq!(got, 0.0, "{name} {group} {what}");
        } else {
            let share = tolerance(&encoding, &group, &what, want);
            // libtiff's dither moves colours of its own accord to the edge, ours does not.
            let least = if name == "LogLuv24 dithered" && what == "e00_max" { 0.5 } else { 1.0 - share };
            if !(got <= want * (1.0 + share) && got >= want * least) {
                off.push(format!("{name} {group} {what}: {got} for {want}"));
            }
        }
        seen += 1;
    }
    assert!(off.is_empty(), "{off:#?}");
    assert_eq!(seen, 200);
}

#[test]
fn greys_fare_as_other_programs_have_it() {
    let mut seen = 0;
    for (name, [_, what], want) in reference().into_iter().filter(|r| r.1[0] == "grey") {
        let encoding = meant(&name);
        let range = |tolerance| grey::range(&encoding, tolerance);
        let steps = || grey::steps_between(&encoding, [0.5, 2.0], 5e-6);
        // The reference's greys lie 0.12 % apart.
        let (got, share) = match what.as_str() {
            "range1_bottom" => (range(0.01)[0], 1.2e-3),
            "range1_top" => (range(0.01)[1], 1.2e-3),
            "range5_bottom" => (range(0.05)[0], 1.2e-3),
            "range5_top" => (range(0.05)[1], 1.2e-3),
            "step_max" => (steps().largest, 1e-4),
            // Half a step and what libtiff cuts, the more the darker; around which luminance is not said, 1 lies in between.
            "err_max" if encoding.coder == Coder::PixarLogOfLibtiff => {
                let [darker, brighter] =
                    [[0.5, 1.0], [1.0, 2.0]].map(|ends| grey::steps_between(&encoding, ends, 5e-6).error);
                assert!(brighter < want && want < darker, "{brighter} {want} {darker}");
                (want, 0.0)
            }
            "err_max" => (steps().error, 1e-3),
            other => panic!("{other}"),
        };
        assert!(near(got, want, share), "{name} {what}: {got} for {want}");
        seen += 1;
    }
    assert_eq!(seen, 40);
}

/// Bytes of 255 and 255 decode to 255.5/256 x 2^127; a half of 65520 and more is infinite, and Z of D65 is 1.089 times Y.
#[test]
fn the_largest_luminances_are_closed_forms() {
    let largest = 255.5 / 256.0 * 2f64.powi(127);
    for tolerance in [0.01, 0.05] {
        for name in ["RGBE BT.709", "RGBE BT.2020", "XYZE"] {
            let top = grey::range(&named(name), tolerance)[1];
            assert!(near(top, largest / (1.0 - tolerance), 1.2e-3), "{name}: {top}");
        }
        let top = grey::range(&named("EXR half XYZ"), tolerance)[1];
        assert!(near(top, 65520.0 * 0.3290 / 0.3583, 1.2e-3), "{top}");
    }
}

/// Steps by definition: LogLuv 256 and 64 codes an octave, halves of 11 bits, floats of 24, mantissas of 128 to 255 halves up.
#[test]
fn steps_are_closed_forms() {
    let wanted = [
        ("LogLuv32", (1f64 / 256.0).exp2() - 1.0),
        ("LogLuv24", (1f64 / 64.0).exp2() - 1.0),
        ("Pixar log BT.709", (1f64 / 250.0).exp() - 1.0),
        ("EXR half BT.709", 2f64.powi(-10)),
        ("EXR float XYZ", 2f64.powi(-23)),
        ("RGBE BT.709", 1.0 / 128.5),
        ("XYZE", 1.0 / 118.5),
    ];
    for (name, want) in wanted {
        let got = grey::steps(&named(name)).largest;
        assert!(near(got, want, 1e-4), "{name}: {got} for {want}");
    }
}

/// A code nearest to each value cannot do worse than libtiff's, nor than half a step over the tolerance in the linear part.
#[test]
fn pixar_log_is_finer_than_libtiffs() {
    let ours = named("Pixar log BT.709");
    let set = colours(RANGES[0]);
    let [got, theirs] = [ours, LIBTIFF_PIXAR].map(|e| Report::of(&e, &set));
    assert!(got.in_709.mean < 0.9 * theirs.in_709.mean && got.in_709.max < theirs.in_709.max);
    let bottom = grey::range(&ours, 0.01)[0];
    assert!(near(bottom, 7.326_255_6e-5 / 2.0 / 0.01, 0.02), "{bottom}"); // codes lie 2 % apart there
}

/// The edge of LogLuv24: what lies in a cell is off by no more than the reference has it, a few in ten thousand lie beyond.
#[test]
fn logluv24_leaves_out_only_an_edge() {
    let all = colours(RANGES[0]);
    let inside = in_cells(&all);
    let encoding = named("LogLuv24");
    let report = Report::of(&encoding, &all);
    assert!(inside.len() < all.len() && report.outside < 5e-4, "{}", report.outside);
    assert!(Errors::of(&inside, &encoding.seen(&inside)).max < 1.9);
}

#[test]
fn five_trips_change_no_more_than_one() {
    let set = colours(RANGES[0]);
    for encoding in ENCODINGS {
        let report = Report::of(&encoding, &set);
        let most = match encoding.coder {
            // A half near 0 beside large ones: by way of XYZ it takes their rounding.
            Coder::Half if encoding.primaries.is_some() => [0.0, 1e-3],
            _ => [0.0; 2],
        };
        let drifted = report.drifted;
        assert!((0..2).all(|i| drifted[i] <= most[i]), "{}: {drifted:?}", encoding.name);
        assert_eq!((report.five.mean, report.five.max), (report.all.mean, report.all.max), "{}", encoding.name);
    }
}

/// The same through the programs, on a rendered scene.
#[test]
fn five_trips_through_the_programs() {
    let scene = stdout_of("spectrace", &["scenes/cornell.toml", "--samples", "4", "--width", "48", "--quiet"], &[]);
    for encoding in &ENCODINGS {
        let words: Vec<&str> = encoding.command.split(' ').collect();
        let write: Vec<&str> = words[1..].iter().copied().chain(["--quiet"]).collect();
        let trip = |input: &[u8]| stdout_of(words[0], &["-r", "--quiet"], &stdout_of(words[0], &write, input));
        let once = trip(&scene);
        let last = (1..5).fold(once.clone(), |picture, _| trip(&picture));
        assert!(!split(&once).2.is_empty() && split(&once).2 == split(&last).2, "{}", encoding.name);
    }
}

/// The colours of a float stream.
fn triples(bytes: &[u8]) -> Vec<Xyz> {
    floats(split(bytes).2).chunks_exact(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))).collect()
}

/// A stream recorded as LogLuv of 32 bits, and read again.
fn mastered(scene: &[u8]) -> Vec<u8> {
    stdout_of("ra_loglv", &["-r", "--quiet"], &stdout_of("ra_loglv", &["--quiet"], scene))
}

/// A rendered scene, and every visible colour at many luminances.
fn scenes() -> [Vec<u8>; 2] {
    let rendered = stdout_of("spectrace", &["scenes/cornell.toml", "--samples", "4", "--width", "64", "--quiet"], &[]);
    let colours: Vec<Xyz> = colours([1e-3, 1e4]).into_iter().step_by(37).collect();
    let values: Vec<f32> = colours.iter().flatten().map(|x| *x as f32).collect();
    let lines = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.4476 0.4074";
    [rendered, stream(lines, &format!("-Y 1 +X {}", colours.len()), &values)]
}

/// What is shown from the master is what is shown from the scene, but for half a step of LogLuv32's luminance, 0.1355 %, and
/// half of its cells of 1/410 in u' and v'; single precision in between adds a few millionths.
fn within_half_a_step(direct: &[Xyz], later: &[Xyz], what: &str) {
    let half_step = (1f64 / 512.0).exp2() - 1.0;
    assert_eq!(direct.len(), later.len());
    let (mut compared, mut largest) = (0, [0f64; 2]);
    for (a, b) in direct.iter().zip(later) {
        if a[1] == 0.0 {
            assert_eq!(b[1], 0.0);
            continue;
        }
        let [p, q] = [a, b].map(|c| uv(*c).unwrap());
        let (luminance, cell) = ((b[1] / a[1] - 1.0).abs(), (p[0] - q[0]).abs().max((p[1] - q[1]).abs()));
        assert!(luminance <= half_step + 5e-6, "{what}: {a:?} {b:?}");
        assert!(cell <= 1.0 / 820.0 + 5e-6, "{what}: {p:?} {q:?}");
        largest = [largest[0].max(luminance), largest[1].max(cell)];
        compared += 1;
    }
    // Pixels enough to meet the worst of a step and of a cell.
    assert!(
        compared > 3000 && largest[0] > 0.99 * half_step && largest[1] > 0.9 / 820.0,
        "{what}: {compared} {largest:?}"
    );
}

#[test]
fn a_master_serves_a_display_it_was_not_made_for() {
    for scene in scenes() {
        let master = mastered(&scene);
        for (name, primaries) in [("P3", "P3".parse::<Primaries>().unwrap()), ("BT.2020", Primaries::BT2020)] {
            let to_xyz = primaries.to_xyz().unwrap();
            let shown = |picture: &[u8]| -> Vec<Xyz> {
                let rgb = stdout_of("xyz2rgb", &["--quiet", "--to", name], picture);
                triples(&rgb).iter().map(|c| to_xyz.apply(*c)).collect()
            };
            within_half_a_step(&shown(&scene), &shown(&master), name);
            // Adapted on the way: the adaptation, one matrix, is undone to see the cells again.
            let adapt = |picture: &[u8]| shown(&stdout_of("vonkries", &["--quiet", "--to", "D65"], picture));
            let back = adaptation(&scene).inverse().unwrap();
            let unadapted = |picture: &[u8]| -> Vec<Xyz> { adapt(picture).iter().map(|c| back.apply(*c)).collect() };
            within_half_a_step(&unadapted(&scene), &unadapted(&master), &format!("adapted, {name}"));
        }
    }
}

/// The matrix that `vonkries --to D65` uses for a stream.
fn adaptation(scene: &[u8]) -> Mat3 {
    let (lines, ..) = split(scene);
    let white = lines.iter().find_map(|l| l.strip_prefix("WHITE= ")).unwrap().replace(' ', ",");
    let text = stdout_of("vonkries", &["--from", &white, "--to", "D65", "--print"], &[]);
    let numbers: Vec<f64> = String::from_utf8(text).unwrap().split_whitespace().map(|n| n.parse().unwrap()).collect();
    assert_eq!(numbers.len(), 9);
    Mat3([0, 1, 2].map(|r| [0, 1, 2].map(|c| numbers[3 * r + c])))
}

/// The measurements are as printed; speeds differ by machine, and are taken as they stand.
#[test]
fn the_page_is_up_to_date() {
    let committed = std::fs::read_to_string(root().join("docs/encodings.md")).unwrap();
    let speeds = &committed[committed.find("## Speed").expect("run: make docs/encodings.md")..];
    page_is_printed("docs/encodings.md", &(encodings::page() + speeds));
}
