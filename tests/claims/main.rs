//! Every claim of [Ward 2001], as docs/claims.csv lists them: the table's form, each number of ours computed anew, and the verdict
//! that follows from it. Where a value was computed a second way (numpy, closed forms, tests/ref), its function says how.

#[path = "../../examples/colour/mod.rs"]
mod colour;
#[path = "../common/mod.rs"]
mod common;
#[path = "../../examples/encodings/mod.rs"]
mod encodings;
#[path = "../../examples/gamut/mod.rs"]
mod gamut;

mod arithmetic;
mod colours;
mod curves;
mod images;
mod records;
mod solving;
mod srgb;
mod techniques;

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

use arithmetic::*;
use colours::*;
use curves::*;
use images::*;
use records::*;
use solving::*;
use srgb::*;
use techniques::*;

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
        ["cargo", "test", "--test", name, ..] => {
            let places = [format!("tests/{name}.rs"), format!("tests/{name}/main.rs")];
            places.iter().any(|place| root().join(place).is_file())
        }
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
