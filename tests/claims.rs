//! Every claim of [Ward 2001], as docs/claims.csv lists them: the table's form, each number of ours computed anew, and the verdict
//! that follows from it. Where a value was computed a second way (numpy, closed forms, tests/ref), its function says how.

#[path = "../examples/colour/mod.rs"]
mod colour;
mod common;
#[path = "../examples/encodings/mod.rs"]
mod encodings;
#[path = "../examples/gamut/mod.rs"]
mod gamut;

use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

use colour::{Chart, approaches, blueflower};
use common::{floats, npy, root, split, stdout_of, stream};
use encodings::coders::{Encoding, LIBTIFF_PIXAR, named};
use encodings::visible::{self, Errors};
use encodings::{RANGES, grey};
use luxpipe::codec::logluv::{Losses, rows::encode_32};
use luxpipe::codec::pixarlog;
use luxpipe::color::difference::{uv, uv_to_xyz};
use luxpipe::color::intent::Gamut;
use luxpipe::color::{Cat, Primaries, Xy};
use luxpipe::display::Display;
use luxpipe::display::transfer::{srgb_decode, srgb_encode};
use luxpipe::photometry::cct::Locus;
use luxpipe::spectral::Observer;
use luxpipe::stream::rle::Planes;
use luxpipe::tone::acuity::cycles_a_degree;
use luxpipe::tone::threshold::threshold_cd_m2;

type Xyz = [f64; 3];

const COLUMNS: &str = "id,section,claim,paper,ours,unit,verdict,command";
const VERDICTS: [&str; 5] = ["holds", "holds-roughly", "differs", "wrong", "not-testable"];
const CD_M2: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.3290";
const DISPLAY: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=display\nDISPLAY= 1 100\nWHITE= 0.3127 0.3290";

/// Eq. (6) and (7) as the paper prints them.
const PRINTED_CAT: [[f64; 3]; 3] = [[0.7982, 0.3389, -0.1371], [-0.5918, 1.5512, 0.0406], [0.0008, 0.0239, 0.9753]];
const PRINTED_D65: [f64; 3] = [0.9478, 1.0334, 1.0850];

/// A claim by its id, and what finds our number.
type Check = (&'static str, fn() -> f64);

/// How each row's number is computed.
const CHECKS: &[Check] = &[
    ("acuity-arc-minute", || 60.0 / (2.0 * cycles_a_degree(100.0))),
    ("srgb-range-codes", || code_range(0.05)),
    ("srgb-range-crt", || contrast("crt")),
    ("srgb-range-reference", || contrast("srgb")),
    ("srgb-under-two-orders", || code_range(0.05).log10()),
    ("srgb-step-at-90", || step_below(90.0)),
    ("srgb-gamma", best_exponent),
    ("srgb-half-uv", || share_of_locus(in_uv)),
    ("srgb-half-xy", || share_of_locus(in_xy)),
    ("srgb-half-surfaces", || surfaces_inside(Primaries::BT709)),
    ("srgb-blue-greens", || reach(500.0)),
    ("srgb-violets", || reach(420.0)),
    ("float-bits", || bits_a_pixel("ra_pfm", &[])),
    ("float-lossless", primaries_lose),
    ("any-colour-32-bits", || outside("LogLuv32")),
    ("any-colour-32-bits-mean", || errors("LogLuv32").mean),
    ("any-colour-32-bits-largest", || errors("LogLuv32").max),
    ("any-colour-bits", logluv_32_bits),
    ("local-least-accurate", || {
        room_error(&["--method", "local", "--samples", "256"]) / room_error(&["--method", "radiosity"])
    }),
    ("ray-tracing-materials", radiosity_behind_glass),
    ("radiosity-diffuse", || bench_methods("path,16 paths") / bench_methods("radiosity,mesh error 0.01 512 rays")),
    ("colorimetric-srgb", colorimetric_moves),
    ("colorimetric-wide", || 100.0 - surfaces_inside(Primaries::BT2020)),
    ("technique-a", || largest(&kept("--gamut shrink")) / smallest(&kept("--gamut shrink"))),
    ("technique-b", || largest(&kept("--gamut compress")) / smallest(&kept("--gamut compress"))),
    ("technique-b-clipping", knee_1_is_clipping),
    ("technique-c", || shown_100([1.0, 1e3]) / shown_100([10.0, 1e4])),
    ("technique-d", || two_surrounds(&["plocal", "--method", "retinex"])),
    ("technique-d-not-c", || two_surrounds(&["pcond"])),
    ("cmccat-matrix", || apart(Cat::Cmccat2000.matrix().0.as_flattened(), PRINTED_CAT.as_flattened())),
    ("eq6-red", || blueflower::d65_cone_primaries()[0]),
    ("eq6-green", || blueflower::d65_cone_primaries()[1]),
    ("eq6-blue", || blueflower::d65_cone_primaries()[2]),
    ("eq6-printed-white", || apart(&Cat::Cmccat2000.matrix().apply(Xy { x: 0.3127, y: 0.3293 }.xyz()), &PRINTED_D65)),
    ("eq7-cb-11", || eq7("B", 0, 0)),
    ("eq7-cb-12", || eq7("B", 0, 1)),
    ("eq7-cb-13", || eq7("B", 0, 2)),
    ("eq7-cb-21", || eq7("B", 1, 0)),
    ("eq7-cb-22", || eq7("B", 1, 1)),
    ("eq7-cb-23", || eq7("B", 1, 2)),
    ("eq7-cb-31", || eq7("B", 2, 0)),
    ("eq7-cb-32", || eq7("B", 2, 1)),
    ("eq7-cb-33", || eq7("B", 2, 2)),
    ("eq7-ca-11", || eq7("A", 0, 0)),
    ("eq7-ca-12", || eq7("A", 0, 1)),
    ("eq7-ca-13", || eq7("A", 0, 2)),
    ("eq7-ca-21", || eq7("A", 1, 0)),
    ("eq7-ca-22", || eq7("A", 1, 1)),
    ("eq7-ca-23", || eq7("A", 1, 2)),
    ("eq7-ca-31", || eq7("A", 2, 0)),
    ("eq7-ca-32", || eq7("A", 2, 1)),
    ("eq7-ca-33", || eq7("A", 2, 2)),
    ("eq7-program", eq7_of_the_program),
    ("blueflower-x", || Xy::of(blueflower::xyz(blueflower::SETS[0].1, "C")).unwrap().x),
    ("blueflower-y", || Xy::of(blueflower::xyz(blueflower::SETS[0].1, "C")).unwrap().y),
    ("blueflower-reflectance", || 100.0 * blueflower::xyz(blueflower::SETS[0].1, "C")[1]),
    ("conventional-red", || blueflower::c709().apply(blueflower::published())[0]),
    ("conventional-green", || blueflower::c709().apply(blueflower::published())[1]),
    ("conventional-blue", || blueflower::c709().apply(blueflower::published())[2]),
    ("conventional-delta-ohta", || delta_e("conventional_vs_D65", 0)),
    ("conventional-delta-babel", || delta_e("conventional_vs_D65", 1)),
    ("white-c-delta", || delta_e("white_C_vs_D65", 0)),
    ("white-c-bluer", || kelvin(blueflower::printed_white("C")) / kelvin(Xy::D65)),
    ("adapted-b-ohta", || delta_e("adapted_B", 0)),
    ("adapted-b-babel", || delta_e("adapted_B", 1)),
    ("adapted-a-ohta", || delta_e("adapted_A", 0)),
    ("adapted-a-babel", || delta_e("adapted_A", 1)),
    ("adapted-a-visible", || delta_e("adapted_A", 0)),
    ("unadapted-b-ohta", || delta_e("unadapted_B", 0)),
    ("unadapted-b-babel", || delta_e("unadapted_B", 1)),
    ("unadapted-a-ohta", || delta_e("unadapted_A", 0)),
    ("unadapted-a-babel", || delta_e("unadapted_A", 1)),
    ("product-b-ohta", || delta_e("rgb_product_reflD65_B_adapted", 0)),
    ("product-b-babel", || delta_e("rgb_product_reflD65_B_adapted", 1)),
    ("product-a-ohta", || delta_e("rgb_product_reflD65_A_adapted", 0)),
    ("product-a-babel", || delta_e("rgb_product_reflD65_A_adapted", 1)),
    ("product-from-c-b-ohta", || delta_e("rgb_product_reflC_vonKries_to_D65_B_adapted", 0)),
    ("product-from-c-b-babel", || delta_e("rgb_product_reflC_vonKries_to_D65_B_adapted", 1)),
    ("product-from-c-a-ohta", || delta_e("rgb_product_reflC_vonKries_to_D65_A_adapted", 0)),
    ("product-from-c-a-babel", || delta_e("rgb_product_reflC_vonKries_to_D65_A_adapted", 1)),
    ("product-no-benefit-b", || delta_e("rgb_product_reflD65_B_adapted", 0) / delta_e("adapted_B", 0)),
    ("product-no-benefit-a", || delta_e("rgb_product_reflD65_A_adapted", 0) / delta_e("adapted_A", 0)),
    ("product-no-benefit-all", || {
        approach("RGB source x RGB from D65", 1, 0) / approach("white sources with RGB from D65", 1, 0)
    }),
    ("relative-direct", || approach("relative: absolute RGB", 1, 2)),
    ("relative-adjusted-direct", || approach("relative: adjusted RGB", 1, 2)),
    ("relative-two-bounces-literal", || approach("relative: absolute RGB", 2, 0)),
    ("relative-three-bounces-literal", || approach("relative: absolute RGB", 3, 0)),
    ("relative-two-bounces-adjusted", || approach("relative: adjusted RGB", 2, 0)),
    ("relative-three-bounces-adjusted", || approach("relative: adjusted RGB", 3, 0)),
    ("relative-two-bounces-wide", || approach("relative: over white in BT.2020", 2, 0)),
    ("relative-three-bounces-wide", || approach("relative: over white in BT.2020", 3, 0)),
    ("relative-two-bounces-literal-a", || {
        specmat("palettes/colorchecker.csv", &["--source", "A", "--literal"], "A", 2)
    }),
    ("relative-two-bounces-wide-a", || specmat("palettes/colorchecker.csv", &["--source", "A"], "A", 2)),
    ("relative-other-source", || specmat("palettes/office.toml", &[], "desk_lamp", 1)),
    ("relative-rendered-one", || five_bounces("one", "relative over white")),
    ("relative-rendered-two", || five_bounces("two", "relative over white")),
    ("relative-rendered-literal", || five_bounces("one", "relative literal")),
    ("relative-improves", || five_bounces("one", "white lights") / five_bounces("one", "relative over white")),
    ("real-scenes-range", || (largest(&tower().luminance) / smallest(&tower().luminance)).log10()),
    ("rgbe-bits", || bits_a_pixel("ra_rgbe", &[])),
    ("rgbe-orders", || orders(&named("RGBE"))),
    ("rgbe-gamut", || outside("RGBE")),
    ("pixar-bits", || 3.0 * (pixarlog::values().len() as f64).log2()),
    ("pixar-gamut", || outside("Pixar log BT.709")),
    ("pixar-orders", || orders(&named("Pixar log BT.709"))),
    ("pixar-orders-libtiff", || orders(&LIBTIFF_PIXAR)),
    ("pixar-marginal", || orders(&named("Pixar log BT.709"))),
    ("logluv24-bits", || bits_a_pixel("ra_loglv", &["--bits24"])),
    ("logluv24-orders", || orders(&named("LogLuv24"))),
    ("logluv24-gamut", || 100.0 - outside("LogLuv24")),
    ("logluv32-orders", || orders(&named("LogLuv32"))),
    ("logluv32-gamut", || 100.0 - outside("LogLuv32")),
    ("logluv32-smaller", || cornell_bytes(&["ra_loglv"]) / cornell_bytes(&["ra_loglv", "--bits24"])),
    ("logluv32-smaller-than-rgbe", || cornell_bytes(&["ra_loglv"]) / cornell_bytes(&["ra_rgbe"])),
    ("step-logluv32", || step(&named("LogLuv32"))),
    ("step-logluv24", || step(&named("LogLuv24"))),
    ("step-rgbe", || step(&named("RGBE"))),
    ("step-pixar", || step(&named("Pixar log BT.709"))),
    ("only-logluv", formats_that_hold_all),
    ("xyze-mean", || errors("XYZE").mean),
    ("xyze-largest", || errors("XYZE").max),
    ("xyze-over-1", || 100.0 * errors("XYZE").over_1),
    ("visible-is-shown", || seen([0.0, 1.3])[1]),
    ("invisible-is-hidden", || seen([0.0, 1.3])[0]),
    ("visible-is-shown-long", || seen([-2.0, 4.0])[1]),
    ("invisible-is-hidden-long", || seen([-2.0, 4.0])[0]),
    ("clamping-loses", || over_white("-l")),
    ("visibility-preserves", || over_white("-h")),
    ("glare-contrast", || contrast_beside_glare(&["-l", "--veil"]) / contrast_beside_glare(&["-l"])),
    ("print-contrast", || mean_slope("--print") / mean_slope("-l")),
    ("print-darkens", || print_mean(red()) / print_mean(Xy::D65.xyz())),
    ("compression-print", || slope_over_white("--print")),
    ("compression-visibility", || slope_over_white("-h")),
    ("black-slope-print", || slope_near_black("--print", 0.0)),
    ("black-slope-visibility", || slope_near_black("-s", 0.0)),
    ("peaks-have-contrast", || peaks_and_slopes("--print")),
    ("print-low-end", || slope_near_black("--print", GLOSS_CD_M2)),
];

// The table.

/// A line of docs/claims.csv.
struct Row {
    id: String,
    claim: String,
    paper: String,
    ours: String,
    verdict: String,
    command: String,
}

/// Cells of a line; quotes hold commas, and two of them stand for one.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut last, mut quoted) = (Vec::new(), String::new(), false);
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        if c == '"' && quoted && chars.peek() == Some(&'"') {
            chars.next();
            last.push('"');
        } else if c == '"' {
            quoted = !quoted;
        } else if c == ',' && !quoted {
            cells.push(std::mem::take(&mut last));
        } else {
            last.push(c);
        }
    }
    assert!(!quoted, "a quote is open: {line}");
    cells.push(last);
    cells
}

fn text() -> String {
    std::fs::read_to_string(root().join("docs/claims.csv")).unwrap()
}

fn rows() -> Vec<Row> {
    let text = text();
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    assert_eq!(lines.next(), Some(COLUMNS));
    let row = |line: &str| {
        let all: [String; 8] = cells(line).try_into().unwrap_or_else(|_| panic!("not eight cells: {line}"));
        let [id, _, claim, paper, ours, _, verdict, command] = all;
        Row { id, claim, paper, ours, verdict, command }
    };
    lines.map(row).collect()
}

/// Half a unit of a number's last digit.
fn half_unit(number: &str) -> f64 {
    let decimals = number.split_once('.').map_or(0, |n| n.1.len());
    0.5 * 10f64.powi(-(decimals as i32))
}

/// Our number is what the row says, to its last digit.
fn is_written(ours: f64, written: &str) -> bool {
    (ours - written.parse::<f64>().unwrap()).abs() <= 1.0001 * half_unit(written) + 1e-12
}

/// What a number of ours says of the paper's: as `holds`, as `holds-roughly`, or not.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Judgement {
    Holds,
    Roughly,
    Not,
}

/// The paper's number, alone or in brackets behind its words: plain, to be met within 5 %; after `=` to its last digit; after `<`,
/// `<=`, `>` or `>=` a bound. What misses by a quarter at most holds roughly, unless digits were asked for, and so does what is a
/// plain number when rounded to its digits: the paper's 1 is not meant to 5 %.
fn judged(paper: &str, ours: f64) -> Judgement {
    let test = paper.split_once('(').map_or(paper, |p| p.1.trim_end_matches(')'));
    let number = test.trim_start_matches(['<', '>', '=', ' ']);
    let sign = test[..test.len() - number.len()].trim();
    let bound: f64 = number.parse().unwrap_or_else(|_| panic!("no number in '{paper}'"));
    let same_digits = (ours - bound).abs() <= 1.0001 * half_unit(number);
    let share = (ours - bound).abs() / bound.abs();
    let holds = match sign {
        "" => share <= 0.05,
        "=" => same_digits,
        "<" => ours < bound,
        "<=" => ours <= bound,
        ">" => ours > bound,
        ">=" => ours >= bound,
        other => panic!("'{other}' in '{paper}'"),
    };
    match holds {
        true => Judgement::Holds,
        false if sign != "=" && share <= 0.25 || sign.is_empty() && same_digits => Judgement::Roughly,
        false => Judgement::Not,
    }
}

/// A command of the repository: a target of the Makefile, a test, or a filter.
fn exists(command: &str) -> bool {
    let words: Vec<&str> = command.split_whitespace().collect();
    match words.as_slice() {
        ["make", target] => {
            let makefile = std::fs::read_to_string(root().join("Makefile")).unwrap();
            makefile.lines().any(|l| l.starts_with(&format!("{target}:")))
        }
        ["cargo", "test", "--test", name, ..] => root().join(format!("tests/{name}.rs")).is_file(),
        [name, ..] => root().join(format!("src/bin/{name}.rs")).is_file(),
        [] => false,
    }
}

/// All of ours, computed once.
fn values() -> &'static HashMap<&'static str, f64> {
    static VALUES: LazyLock<HashMap<&'static str, f64>> =
        LazyLock::new(|| CHECKS.iter().map(|(id, check)| (*id, check())).collect());
    &VALUES
}

#[test]
fn the_table_is_well_formed() {
    assert!(!text().contains('\u{2014}'));
    let rows = rows();
    let checks: HashSet<&str> = CHECKS.iter().map(|c| c.0).collect();
    assert_eq!(checks.len(), CHECKS.len(), "an id has two checks");
    let mut ids = HashSet::new();
    for row in &rows {
        let id = row.id.as_str();
        let kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(!id.is_empty() && id.chars().all(kebab), "'{id}'");
        assert!(ids.insert(id), "'{id}' twice");
        assert!(VERDICTS.contains(&row.verdict.as_str()), "{id}: {}", row.verdict);
        assert!(row.claim.ends_with('.') && !row.paper.is_empty(), "{id}");
        if row.verdict == "not-testable" {
            assert!(row.ours.is_empty() && !checks.contains(id), "{id} has a number");
            assert!(row.claim.contains("Not testable: "), "{id} gives no reason");
            assert!(row.command.is_empty() || exists(&row.command), "{id}: {}", row.command);
        } else {
            assert!(row.ours.parse::<f64>().is_ok() && checks.contains(id), "{id} has no number or no check");
            assert!(exists(&row.command), "{id}: {}", row.command);
        }
    }
    let orphans: Vec<&&str> = checks.iter().filter(|id| !ids.contains(**id)).collect();
    assert!(orphans.is_empty(), "checks without a row: {orphans:?}");
}

#[test]
fn ours_are_computed_anew() {
    let values = values();
    let tested = rows().into_iter().filter(|r| r.verdict != "not-testable");
    let off: Vec<String> = tested
        .filter(|r| !is_written(values[r.id.as_str()], &r.ours))
        .map(|r| format!("{}: {} for {}", r.id, values[r.id.as_str()], r.ours))
        .collect();
    assert!(off.is_empty(), "{off:#?}");
}

#[test]
fn verdicts_follow_from_the_numbers() {
    let values = values();
    let mut off = Vec::new();
    for row in rows().iter().filter(|r| r.verdict != "not-testable") {
        let ours = values[row.id.as_str()];
        let judgement = judged(&row.paper, ours);
        let fits = match judgement {
            Judgement::Holds => row.verdict == "holds",
            Judgement::Roughly => row.verdict == "holds-roughly",
            Judgement::Not => row.verdict == "differs" || row.verdict == "wrong",
        };
        if !fits {
            off.push(format!("{}: {ours} beside '{}' is {judgement:?}, not {}", row.id, row.paper, row.verdict));
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

/// The judge and the splitter themselves.
#[test]
fn what_is_off_is_found() {
    use Judgement::{Holds, Not, Roughly};
    for (paper, ours, want) in [
        ("22", 20.95, Holds),
        ("22", 20.5, Roughly),
        ("22", 16.0, Not),
        ("1", 1.04, Holds),
        ("1", 1.49, Roughly),
        ("1", 1.51, Not),
        ("= 3.1273", 3.12734, Holds),
        ("= 3.1273", 3.12736, Not),
        ("= -0.4867", -0.4868, Not),
        ("= 0.000", 1e-5, Holds),
        ("> 5", 5.01, Holds),
        ("> 5", 4.59, Roughly),
        ("> 5", 3.0, Not),
        ("negligible (< 1)", 0.99, Holds),
        ("negligible (< 1)", 1.2, Roughly),
        ("negligible (< 1)", 7.4, Not),
        ("as large (>= 1)", 1.0, Holds),
    ] {
        assert_eq!(judged(paper, ours), want, "{paper} {ours}");
    }
    assert!(is_written(1.849, "1.8") && !is_written(1.851, "1.8") && is_written(24.4, "24") && !is_written(24.6, "24"));
    assert_eq!(cells("a,\"b, \"\"c\"\"\",,d"), ["a", "b, \"c\"", "", "d"]);
}

// Arithmetic and pictures.

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x))
}

fn smallest(values: &[f64]) -> f64 {
    values.iter().fold(f64::INFINITY, |m, x| m.min(*x))
}

/// The largest difference of numbers in the same places.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    largest(&a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>())
}

fn neutral(luminance: f64) -> Xyz {
    Xy::D65.xyz().map(|x| x * luminance)
}

/// `count` luminances from the first to the last, evenly in their logarithm.
fn evenly([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}

fn picture(lines: &str, columns: usize, colours: &[Xyz]) -> Vec<u8> {
    let values: Vec<f32> = colours.iter().flatten().map(|x| *x as f32).collect();
    stream(lines, &format!("-Y {} +X {columns}", colours.len() / columns), &values)
}

fn triples(bytes: &[u8]) -> Vec<Xyz> {
    floats(split(bytes).2).chunks_exact(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))).collect()
}

/// What a filter without remarks makes of a picture.
fn through(command: &[&str], input: &[u8]) -> Vec<Xyz> {
    triples(&stdout_of(command[0], &[&command[1..], &["--quiet"]].concat(), input))
}

/// pcond's own display: cd/m2 of what it writes.
fn cd_m2(share: f64) -> f64 {
    1.0 + 99.0 * share
}

// Introduction: sRGB.

/// White over black of a shipped display, light of the room included.
fn contrast(name: &str) -> f64 {
    let display: Display = name.parse().unwrap();
    display.white_cd_m2 / display.black_cd_m2
}

fn code_light(code: u32) -> f64 {
    srgb_decode(f64::from(code) / 255.0)
}

/// White over the darkest 8-bit code from which no code is further from the next than a step.
fn code_range(step: f64) -> f64 {
    let coarse = (1..255u32).rev().find(|k| code_light(k + 1) / code_light(*k) - 1.0 > step).unwrap();
    1.0 / code_light(coarse + 1)
}

/// Percent from the code at this range below white to the next.
fn step_below(range: f64) -> f64 {
    let code = (1..255u32).rev().find(|k| code_light(*k) <= 1.0 / range).unwrap();
    100.0 * (code_light(code + 1) / code_light(code) - 1.0)
}

/// The power nearest to the sRGB curve: least squares of its codes at 1001 even lights.
fn best_exponent() -> f64 {
    let light = |i: u32| f64::from(i) / 1000.0;
    let misfit =
        |gamma: f64| -> f64 { (0..=1000).map(|i| (srgb_encode(light(i)) - light(i).powf(1.0 / gamma)).powi(2)).sum() };
    (1800..=2800u32).map(light).min_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).unwrap()
}

fn cmf(nm: f64) -> Xyz {
    static OBSERVER: LazyLock<Observer> = LazyLock::new(|| Observer::cie1931().unwrap());
    OBSERVER.cmf.each_ref().map(|c| c.at(nm))
}

fn in_xy(c: Xyz) -> [f64; 2] {
    let sum = c[0] + c[1] + c[2];
    [c[0] / sum, c[1] / sum]
}

fn in_uv(c: Xyz) -> [f64; 2] {
    uv(c).unwrap()
}

/// Area of a polygon (the shoelace formula).
fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let twice: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    0.5 * twice.abs()
}

/// Percent of the area within the spectral locus (380 to 700 nm and the purples) that BT.709's triangle takes; numpy: 33.524 in xy,
/// 33.246 in u'v'.
fn share_of_locus(place: fn(Xyz) -> [f64; 2]) -> f64 {
    let triangle = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]].map(|[x, y]| place(Xy { x, y }.xyz()));
    let locus: Vec<[f64; 2]> = (380..=700u32).map(|nm| place(cmf(f64::from(nm)))).collect();
    100.0 * area(&triangle) / area(&locus)
}

/// Percent of the colours on Pointer's boundary that a display of these primaries shows.
fn surfaces_inside(primaries: Primaries) -> f64 {
    let display = Gamut::new(primaries).unwrap();
    let colours = gamut::sets::pointer().colours;
    100.0 * colours.iter().filter(|c| display.is_exact(**c)).count() as f64 / colours.len() as f64
}

/// Percent of the way in u'v' from D65 to light of one wavelength that BT.709 goes; numpy by crossing lines: 32.36 at 500 nm,
/// 53.62 at 420, 90.54 at 610.
fn reach(nm: f64) -> f64 {
    let (white, edge) = (in_uv(Xy::D65.xyz()), in_uv(cmf(nm)));
    let to_rgb = blueflower::c709();
    let fits = |t: f64| {
        let at = [0, 1].map(|i| white[i] + t * (edge[i] - white[i]));
        to_rgb.apply(uv_to_xyz(at, 1.0)).iter().all(|x| *x >= 0.0)
    };
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (inside + outside);
        if fits(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    100.0 * inside
}

// Introduction: records of light.

/// Bits by which a pixel lengthens a file; four across, too few for run lengths.
fn bits_a_pixel(name: &str, options: &[&str]) -> f64 {
    let size = |rows: usize| {
        let input = picture(CD_M2, 4, &vec![neutral(1.0); 4 * rows]);
        stdout_of(name, &[options, &["--quiet"]].concat(), &input).len()
    };
    8.0 * (size(90) - size(10)) as f64 / (4.0 * 80.0)
}

/// Largest error in percent of the largest component, of the locus and paler colours by way of BT.709 without any gamut mapping.
fn primaries_lose() -> f64 {
    let paler = |nm: i32| [0.0, 0.3, 0.7].map(|white| gamut::sets::mixed(f64::from(nm), white, 1.0));
    let colours: Vec<Xyz> = (400..=700).step_by(5).flat_map(paler).collect();
    let rgb = stdout_of("xyz2rgb", &["--quiet"], &picture(CD_M2, colours.len(), &colours));
    assert!(triples(&rgb).as_flattened().iter().any(|x| *x < 0.0), "nothing outside");
    let back = through(&["xyz2rgb", "-r"], &rgb);
    let error = |(a, b): (&Xyz, &Xyz)| 100.0 * apart(a, b) / largest(a);
    largest(&colours.iter().zip(&back).map(error).collect::<Vec<_>>())
}

/// The bytes of a pixel's four planes.
fn logluv_32_bits() -> f64 {
    let mut planes = Planes::default();
    encode_32(&[0.3, 0.4, 0.5], 1.0, &mut planes, &mut Losses::default());
    8.0 * planes.iter().map(Vec::len).sum::<usize>() as f64
}

// Solving the rendering equation.

/// Mean error of irradiance at the middles of a closed room's sides over their mean: (centre_B - exitance) / reflectance of
/// radiosity-room-C in tests/ref/validation.toml.
fn room_error(method: &[&str]) -> f64 {
    const POINTS: &[u8] = b"2 2 0 0 0 1\n0 2 1.5 1 0 0\n2 2 3 0 0 -1\n";
    let truth = [10.6497 / 0.2, 20.0279 / 0.5, (110.951 - 100.0) / 0.7];
    let sides = [1.0, 4.0, 1.0];
    let args = [&["scenes/room-c.toml", "--irradiance", "--quiet", "--bands", "4"][..], method].concat();
    let got = irradiances(&args, POINTS);
    assert_eq!(got.len(), 3);
    let error: f64 = (0..3).map(|i| sides[i] * (got[i] - truth[i]).abs()).sum();
    error / (0..3).map(|i| sides[i] * truth[i]).sum::<f64>()
}

fn irradiances(args: &[&str], points: &[u8]) -> Vec<f64> {
    let out = String::from_utf8(stdout_of("spectrace", args, points)).unwrap();
    out.lines().map(|l| l.split('\t').nth(1).unwrap().trim().parse().unwrap()).collect()
}

/// Percent of the light under a ball of clear glass that radiosity finds: the scene of tests/methods.rs, paths as truth.
fn radiosity_behind_glass() -> f64 {
    let scene = "[lights.l]\nspectrum = \"E\"\nluminance = 20000\n[materials.floor]\nreflectance = 0.7\n\
        [materials.glass]\ntype = \"dielectric\"\nindex = 1.5\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0.7]\nradius = 0.5\nmaterial = \"glass\"\n\
        [[shape]]\ntype = \"sphere\"\ncenter = [1.5, 0.5, 3]\nradius = 0.3\nmaterial = \"floor\"\nlight = \"l\"\n\
        [[shape]]\ntype = \"quad\"\npoints = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]]\nmaterial = \"floor\"\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.toml");
    std::fs::write(&file, scene).unwrap();
    let at = |i: i32| f64::from(i % 8) / 8.0 - 0.44;
    let points: String = (0..64).map(|i| format!("{} {} 0 0 0 1\n", -0.46 + at(i), -0.15 + at(i / 8))).collect();
    let sum = |method: &[&str]| -> f64 {
        let args = [&[file.to_str().unwrap(), "--irradiance", "--quiet", "--bands", "4"][..], method].concat();
        irradiances(&args, points.as_bytes()).iter().sum()
    };
    100.0 * sum(&["--method", "radiosity", "--samples", "64"]) / sum(&["--samples", "4096"])
}

/// Error in percent of a row that `make bench-methods` measured.
fn bench_methods(row: &str) -> f64 {
    let text = std::fs::read_to_string(root().join("docs/methods.csv")).unwrap();
    let line = text.lines().find(|l| l.starts_with(&format!("{row},"))).unwrap_or_else(|| panic!("no row '{row}'"));
    line.rsplit(',').next().unwrap().parse().unwrap()
}

// Tone mapping: intents and techniques.

/// Percent of the pixels of a stage under coloured lamps that BT.709 cannot show as they are (docs/gamut.md).
fn colorimetric_moves() -> f64 {
    let wanted = gamut::sets::picture().colours;
    let shown = gamut::methods::shown("--intent colorimetric", Primaries::BT709, &wanted);
    gamut::errors::Errors::of(&wanted, &shown).moved
}

/// Light of 450 to 650 nm with 0, 50 and 90 % white, so dark that every chromaticity of BT.709 fits.
fn lamps() -> Vec<Xyz> {
    let paler = |nm: i32| [0.0, 0.5, 0.9].map(|white| gamut::sets::mixed(f64::from(nm), white, 0.02));
    (450..=650).step_by(10).flat_map(paler).collect()
}

fn lamps_as_rgb(options: &str) -> Vec<Xyz> {
    let command: Vec<&str> = ["xyz2rgb"].into_iter().chain(options.split(' ')).collect();
    through(&command, &picture(DISPLAY, lamps().len(), &lamps()))
}

/// Share of their saturation in u'v' that these colours keep.
fn kept(options: &str) -> Vec<f64> {
    let to_xyz = Primaries::BT709.to_xyz().unwrap();
    let white = in_uv(Xy::D65.xyz());
    let saturation = |c: Xyz| {
        let at = in_uv(c);
        (at[0] - white[0]).hypot(at[1] - white[1])
    };
    let share = |(rgb, wanted): (Xyz, Xyz)| saturation(to_xyz.apply(rgb)) / saturation(wanted);
    lamps_as_rgb(options).into_iter().zip(lamps()).map(share).collect()
}

/// Largest difference of RGB, white at 1, between technique B with its knee at the edge and clipping of saturation.
fn knee_1_is_clipping() -> f64 {
    let [bent, clipped] = ["--gamut compress --knee 1", "--gamut desaturate"].map(lamps_as_rgb);
    apart(bent.as_flattened(), clipped.as_flattened())
}

/// What pcond shows for 100 cd/m2 in a picture of other luminances.
fn shown_100(range: [f64; 2]) -> f64 {
    let others = evenly(range, 63 * 64).into_iter().map(neutral);
    let colours: Vec<Xyz> = std::iter::repeat_n(neutral(100.0), 64).chain(others).collect();
    through(&["pcond"], &picture(CD_M2, 64, &colours))[0][1]
}

/// What is shown for 100 cd/m2 within 10 cd/m2, over what is shown for the same within 1000 cd/m2 of the same picture.
fn two_surrounds(command: &[&str]) -> f64 {
    let inside = |x: usize, row: usize| (28..36).contains(&row) && (28..36).contains(&(x % 64));
    let luminance = |i: usize| match (i % 128, i / 128) {
        (x, row) if inside(x, row) => 100.0,
        (x, _) if x < 64 => 10.0,
        _ => 1000.0,
    };
    let colours: Vec<Xyz> = (0..128 * 64).map(|i| neutral(luminance(i))).collect();
    let shown = through(command, &picture(CD_M2, 128, &colours));
    shown[32 * 128 + 32][1] / shown[32 * 128 + 96][1]
}

// Correct colour rendering and the conventional calculation.

fn eq7(light: &str, row: usize, column: usize) -> f64 {
    blueflower::eq7(light).0[row][column]
}

/// How far the matrix that `vonkries` prints is from ours.
fn eq7_of_the_program() -> f64 {
    let text = stdout_of("vonkries", &["--from", "0.4475,0.4075", "--to", "D65", "--print", "--rgb"], b"");
    let numbers: Vec<f64> = String::from_utf8(text).unwrap().split_whitespace().map(|n| n.parse().unwrap()).collect();
    apart(&numbers, blueflower::eq7("A").0.as_flattened())
}

/// A difference that the paper states, of one chart: tests/paper.rs holds them to numpy.
fn delta_e(key: &str, set: usize) -> f64 {
    blueflower::claims().into_iter().find(|c| c.key == key).unwrap().ours[set]
}

/// Correlated colour temperature.
fn kelvin(white: Xy) -> f64 {
    Locus::new().unwrap().nearest(white).kelvin
}

// Relative colours.

/// CIEDE2000 over 24 patches, nine lights and a number of bounces: mean, 95 % or largest.
fn approach(name: &str, bounces: usize, which: usize) -> f64 {
    type Results = Vec<(String, [[f64; 3]; 3])>;
    static RESULTS: LazyLock<Results> = LazyLock::new(|| approaches::results(&Chart::ohta()));
    RESULTS.iter().find(|r| r.0 == name).unwrap_or_else(|| panic!("no approach '{name}'")).1[bounces - 1][which]
}

/// Mean CIEDE2000 that `specmat --format errors` prints for a light.
fn specmat(list: &str, options: &[&str], light: &str, bounces: u32) -> f64 {
    let args = [&["--quiet", "--format", "errors", list][..], options].concat();
    let text = String::from_utf8(stdout_of("specmat", &args, b"")).unwrap();
    let mut lines = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>());
    let row = lines.find(|w| w.len() == 6 && w[0] == light && w[1] == bounces.to_string()).unwrap();
    row[3].parse().unwrap()
}

/// Root mean square of CIEDE2000 after five bounces in a rendered room, as `make paper-relative` measured it.
fn five_bounces(kinds: &str, model: &str) -> f64 {
    let text = std::fs::read_to_string(root().join(format!("docs/paper-relative-{kinds}.csv"))).unwrap();
    let line = text.lines().find(|l| l.starts_with(&format!("5,{model},"))).unwrap();
    line.split(',').nth(3).unwrap().parse().unwrap()
}

// High dynamic range images. tests/encodings.rs holds these to libtiff and numpy, steps to closed forms.

fn all_visible() -> &'static [Xyz] {
    static COLOURS: LazyLock<Vec<Xyz>> = LazyLock::new(|| visible::colours(RANGES[0]));
    &COLOURS
}

/// CIEDE2000 of all visible colours.
fn errors(name: &str) -> Errors {
    Errors::of(all_visible(), &named(name).seen(all_visible()))
}

/// Percent of the visible colours, by area in u'v', whose chromaticity the encoding has no place for.
fn outside(name: &str) -> f64 {
    let encoding = named(name);
    let trip = encoding.trip(&encoding.components(all_visible()));
    100.0 * trip.outside as f64 / all_visible().len() as f64
}

/// Orders of magnitude of D65 greys that come back within 1 %.
fn orders(encoding: &Encoding) -> f64 {
    grey::orders(grey::range(encoding, 0.01))
}

/// Percent between neighbouring luminances, at most.
fn step(encoding: &Encoding) -> f64 {
    100.0 * grey::steps(encoding).largest
}

/// Of the paper's four formats, those that keep 99.9 % of the visible chromaticities and four orders of magnitude.
fn formats_that_hold_all() -> f64 {
    let formats = ["RGBE", "Pixar log BT.709", "LogLuv24", "LogLuv32"].into_iter();
    formats.filter(|name| outside(name) < 0.1 && orders(&named(name)) > 4.0).count() as f64
}

/// Bytes of the Cornell box with a renderer's noise (tests/ref/README.md), its unit taken as 100 cd/m2.
fn cornell_bytes(command: &[&str]) -> f64 {
    let values: Vec<f32> = npy(&root().join("tests/ref/a_cornell_xyz.npy")).iter().map(|x| 100.0 * x).collect();
    let input = stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2", "-Y 128 +X 128", &values);
    stdout_of(command[0], &[&command[1..], &["--quiet"]].concat(), &input).len() as f64
}

// Gamut mapping and tone curves.

/// Percent of the differences of 0.5 and 0.8 thresholds that show after `pcond --goal visibility`, and of those of 1.25 and 2: 2000
/// luminances between two powers of ten, each beside itself with a difference on it.
fn seen([low, high]: [f64; 2]) -> [f64; 2] {
    const COUNT: usize = 2000;
    const DIFFERENCES: [f64; 5] = [0.0, 0.5, 0.8, 1.25, 2.0];
    let base = |i: usize| 10f64.powf(low + (high - low) * (i as f64 + 0.5) / COUNT as f64);
    let row = |l: f64| DIFFERENCES.map(|k| neutral(l + k * threshold_cd_m2(l)));
    let colours: Vec<Xyz> = (0..COUNT).flat_map(|i| row(base(i))).collect();
    let shown = through(&["pcond", "--goal", "visibility"], &picture(CD_M2, DIFFERENCES.len(), &colours));
    let mut counts = [0usize; 2];
    for row in shown.chunks(DIFFERENCES.len()) {
        let luminances: Vec<f64> = row.iter().map(|c| cd_m2(c[1])).collect();
        let threshold = threshold_cd_m2(luminances[0]);
        for (k, l) in luminances.iter().enumerate().skip(1) {
            counts[usize::from(k > 2)] += usize::from(l - luminances[0] >= threshold);
        }
    }
    counts.map(|n| 100.0 * n as f64 / (2 * COUNT) as f64)
}

/// Contrast on the display of a square of 40 cd/m2 on a field of 20 with 2000 cd/m2 beside it.
fn contrast_beside_glare(options: &[&str]) -> f64 {
    let inside = |x: usize, row: usize| (32..48).contains(&row) && (32..48).contains(&x);
    let luminance = |i: usize| match (i % 160, i / 160) {
        (x, row) if inside(x, row) => 40.0,
        (x, _) if x < 80 => 20.0,
        _ => 2000.0,
    };
    let colours: Vec<Xyz> = (0..160 * 80).map(|i| neutral(luminance(i))).collect();
    let lines = format!("{CD_M2}\nVIEW=-vta -vh 80 -vv 40");
    let shown = through(&[&["pcond"][..], options].concat(), &picture(&lines, 160, &colours));
    let [target, field] = [40 * 160 + 40, 12 * 160 + 40].map(|i| cd_m2(shown[i][1]));
    target / field - 1.0
}

/// The red of BT.709 at Y = 1.
fn red() -> Xyz {
    let c = Primaries::BT709.to_xyz().unwrap().apply([1.0, 0.0, 0.0]);
    c.map(|x| x / c[1])
}

/// Mean luminance, white at 1, of a print of one colour at 5 to 500 cd/m2.
fn print_mean(colour: Xyz) -> f64 {
    let colours: Vec<Xyz> = evenly([5.0, 500.0], 64 * 64).into_iter().map(|y| colour.map(|x| x * y)).collect();
    let shown = through(&["pcond", "--print"], &picture(CD_M2, 64, &colours));
    shown.iter().map(|c| c[1]).sum::<f64>() / shown.len() as f64
}

/// What the gloss of `pcond --print` reflects: 0.006 of 100 cd/m2.
const GLOSS_CD_M2: f64 = 0.6;

/// The operators of Figures 6 to 8, and histogram adjustment that counts in thresholds of the eye.
const OPERATORS: [&str; 4] = ["-l", "-h", "--print", "-s"];

/// The control tower at 96 pixels, as in tests/tower.rs, and what the operators make of it.
struct Tower {
    luminance: Vec<f64>,
    /// log10 of luminance, and pixels.
    histogram: Vec<(f64, f64)>,
    /// log10 of world and display luminance.
    maps: HashMap<&'static str, Vec<(f64, f64)>>,
    /// Luminances shown, white at 1.
    shown: HashMap<&'static str, Vec<f64>>,
}

fn pairs(text: &str) -> Vec<(f64, f64)> {
    let pair = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
        (numbers[0], numbers[1])
    };
    text.lines().map(pair).collect()
}

fn luminances(colours: &[Xyz]) -> Vec<f64> {
    colours.iter().map(|c| c[1]).collect()
}

impl Tower {
    fn render() -> Tower {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
        let (picture, map) = (file("tower.lux"), file("tower.map"));
        let options = ["--quiet", "--width", "96", "--samples", "256", "--bands", "20", "scenes/tower.toml"];
        let adapted = stdout_of("vonkries", &["--quiet", "--to", "D65"], &stdout_of("spectrace", &options, b""));
        std::fs::write(&picture, &adapted).unwrap();
        let histogram = String::from_utf8(stdout_of("picinfo", &["--histogram", &picture], b"")).unwrap();
        let (mut maps, mut shown) = (HashMap::new(), HashMap::new());
        for operator in OPERATORS {
            let out = stdout_of("pcond", &["--quiet", operator, "-x", &map, &picture], b"");
            let points = pairs(&std::fs::read_to_string(&map).unwrap());
            maps.insert(operator, points.iter().map(|(w, d)| (w.log10(), d.log10())).collect());
            shown.insert(operator, luminances(&triples(&out)));
        }
        Tower { luminance: luminances(&triples(&adapted)), histogram: pairs(&histogram), maps, shown }
    }

    /// log10 of what is shown for log10 of a luminance, less a veil.
    fn level(&self, operator: &str, x: f64, veil_cd_m2: f64) -> f64 {
        let map = &self.maps[operator];
        let x = x.clamp(map[0].0, map[map.len() - 1].0);
        let i = map.partition_point(|p| p.0 < x).clamp(1, map.len() - 1);
        let ((x0, y0), (x1, y1)) = (map[i - 1], map[i]);
        let y = if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { y1 };
        (10f64.powf(y) - veil_cd_m2).log10()
    }

    /// Slope in the middle of each of the histogram's steps.
    fn slopes(&self, operator: &str, veil_cd_m2: f64) -> Vec<f64> {
        let step = self.histogram[1].0 - self.histogram[0].0;
        let at = |x: f64| self.level(operator, x, veil_cd_m2);
        self.histogram.iter().map(|(x, _)| (at(x + 0.5 * step) - at(x - 0.5 * step)) / step).collect()
    }
}

fn tower() -> &'static Tower {
    static TOWER: LazyLock<Tower> = LazyLock::new(Tower::render);
    &TOWER
}

/// Percent of the tower's pixels at the display's white or beyond.
fn over_white(operator: &str) -> f64 {
    let shown = &tower().shown[operator];
    100.0 * shown.iter().filter(|y| **y >= 0.9999).count() as f64 / shown.len() as f64
}

/// Mean slope in log over log, pixels counting alike.
fn mean_slope(operator: &str) -> f64 {
    let tower = tower();
    let total: f64 = tower.histogram.iter().map(|h| h.1).sum();
    tower.slopes(operator, 0.0).iter().zip(&tower.histogram).map(|(s, h)| s * h.1).sum::<f64>() / total
}

/// Slope over the luminances that the linear operator clamps.
fn slope_over_white(operator: &str) -> f64 {
    let tower = tower();
    let clamped = tower.luminance.iter().zip(&tower.shown["-l"]).filter(|(_, y)| **y > 1.0);
    let white = clamped.fold(f64::INFINITY, |m, (l, _)| m.min(*l)).log10();
    let most = largest(&tower.luminance).log10();
    (tower.level(operator, most, 0.0) - tower.level(operator, white, 0.0)) / (most - white)
}

/// Mean slope that the darkest fifth of the pixels see, but for the darkest few, as in tests/tower.rs. A linear map's is 1.
fn slope_near_black(operator: &str, veil_cd_m2: f64) -> f64 {
    let tower = tower();
    let total: f64 = tower.histogram.iter().map(|h| h.1).sum();
    let (mut below, mut sum, mut weight) = (0.0, 0.0, 0.0);
    for ((_, count), slope) in tower.histogram.iter().zip(tower.slopes(operator, veil_cd_m2)) {
        below += count / total;
        if (0.03..0.2).contains(&below) {
            (sum, weight) = (sum + count * slope, weight + count);
        }
    }
    sum / weight
}

/// Rank correlation of the histogram's counts and the slopes there.
fn peaks_and_slopes(operator: &str) -> f64 {
    let counts: Vec<f64> = tower().histogram.iter().map(|h| h.1).collect();
    correlation(&ranks(&counts), &ranks(&tower().slopes(operator, 0.0)))
}

/// Ranks, equals sharing their mean.
fn ranks(values: &[f64]) -> Vec<f64> {
    let less = |x: f64| values.iter().filter(|y| **y < x - 1e-9).count() as f64;
    let same = |x: f64| values.iter().filter(|y| (**y - x).abs() <= 1e-9).count() as f64;
    values.iter().map(|x| less(*x) + 0.5 * same(*x)).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let centred = |v: &[f64]| -> Vec<f64> {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        v.iter().map(|x| x - mean).collect()
    };
    let (a, b) = (centred(a), centred(b));
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}
