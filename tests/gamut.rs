//! The gamut methods and intents through the real `xyz2rgb`, held to their laws: what fits is untouched, luminance, hue or
//! saturation kept by those that promise it, finite whatever comes. Expected values are closed forms worked here.

mod common;
#[path = "../examples/gamut/mod.rs"]
mod gamut;

use common::{floats, page_is_printed, run, split, stdout_of, stream};
use gamut::{blue, sets};

/// BT.709 as IEC 61966-2-1 and SMPTE RP 177 have it, from the primaries and D65 in seven digits.
const TO_XYZ: [[f64; 3]; 3] =
    [[0.4123908, 0.3575843, 0.1804808], [0.2126390, 0.7151687, 0.0721923], [0.0193308, 0.1191948, 0.9505322]];
const WHITE: [f64; 3] = [0.3127 / 0.3290, 1.0, 0.3583 / 0.3290];
/// u'v' of BT.709's red, green and blue, from their x and y.
const CORNERS: [[f64; 2]; 3] = [[0.450704, 0.522887], [0.125000, 0.562500], [0.175439, 0.157895]];

const DISPLAY: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=display\nDISPLAY= 1 100\nWHITE= 0.3127 0.3290";
const CD_M2: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.3290";

type Xyz = [f64; 3];

/// All ways to treat what lies outside in a display-referred picture.
const METHODS: [&str; 14] = [
    "--gamut clip",
    "--gamut desaturate",
    "--gamut shrink",
    "--gamut shrink --reach visible",
    "--gamut shrink --hue oklab",
    "--gamut shrink --hue oklab --reach visible",
    "--gamut compress",
    "--gamut compress --hue oklab",
    "--gamut compress --knee 1",
    "--gamut compress --knee 1 --hue oklab",
    "--gamut compress --knee 0 --reach visible",
    "--intent perceptual",
    "--intent perceptual --hue oklab",
    "--intent saturation",
];

fn times(m: [[f64; 3]; 3], v: Xyz) -> Xyz {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

fn uv(c: Xyz) -> [f64; 2] {
    let sum = c[0] + 15.0 * c[1] + 3.0 * c[2];
    [4.0 * c[0] / sum, 9.0 * c[1] / sum]
}

/// Distance and direction from the white in u'v'.
fn from_white(c: Xyz) -> (f64, f64) {
    let (a, w) = (uv(c), uv(WHITE));
    ((a[0] - w[0]).hypot(a[1] - w[1]), (a[1] - w[1]).atan2(a[0] - w[0]))
}

/// Hue in Oklab, from the matrices as published.
fn oklab_hue(c: Xyz) -> f64 {
    let m1 = [
        [0.8189330101, 0.3618667424, -0.1288597137],
        [0.0329845436, 0.9293118715, 0.0361456387],
        [0.0482003018, 0.2643662691, 0.6338517070],
    ];
    let m2 = [[0.0; 3], [1.9779984951, -2.4285922050, 0.4505937099], [0.0259040371, 0.7827717662, -0.8086757660]];
    let lab = times(m2, times(m1, c).map(f64::cbrt));
    lab[2].atan2(lab[1])
}

/// Smallest angle between two directions.
fn angle(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(std::f64::consts::TAU);
    d.min(std::f64::consts::TAU - d)
}

fn triples(bytes: &[u8]) -> Vec<Xyz> {
    floats(split(bytes).2).chunks_exact(3).map(|p| [0, 1, 2].map(|i| f64::from(p[i]))).collect()
}

fn picture(lines: &str, colours: &[Xyz]) -> Vec<u8> {
    let values: Vec<f32> = colours.iter().flatten().map(|x| *x as f32).collect();
    stream(lines, &format!("-Y 1 +X {}", colours.len()), &values)
}

/// RGB that `xyz2rgb` makes of colours.
fn rgb(options: &str, lines: &str, colours: &[Xyz]) -> Vec<Xyz> {
    let args: Vec<&str> = ["--quiet"].into_iter().chain(options.split_whitespace()).collect();
    triples(&stdout_of("xyz2rgb", &args, &picture(lines, colours)))
}

/// RGB spread evenly over the cube by three irrational steps, the same at every run.
fn cube(count: usize) -> Vec<Xyz> {
    let steps = [0.8191725134, 0.6710436067, 0.5497004779];
    (1..=count).map(|i| steps.map(|s| (s * i as f64).fract())).collect()
}

/// The locus and Pointer's colours, at a luminance where every in-gamut chromaticity of BT.709 fits: blue's is 0.0722.
fn outside() -> Vec<Xyz> {
    let all = sets::locus().colours.into_iter().chain(sets::pointer().colours);
    all.map(|c| c.map(|x| x * 0.02 / c[1])).collect()
}

#[test]
fn colours_inside_are_untouched() {
    let inside = cube(2000);
    let xyz: Vec<Xyz> = inside.iter().map(|c| times(TO_XYZ, *c)).collect();
    for options in ["--gamut clip", "--gamut desaturate", "--gamut compress --knee 1", "--intent saturation"] {
        for (got, want) in rgb(options, DISPLAY, &xyz).iter().zip(&inside) {
            assert!((0..3).all(|i| (got[i] - want[i]).abs() < 2e-6), "{options}: {got:?} for {want:?}");
        }
    }
}

/// A colour below the knee is at most four fifths of the way to the edge: it fits after a quarter more saturation.
#[test]
fn colours_below_the_knee_are_untouched() {
    let more = |xyz: Xyz, by: f64| {
        let (a, w) = (uv(xyz), uv(WHITE));
        let [u, v] = [0, 1].map(|i| w[i] + (a[i] - w[i]) * by);
        [2.25 * u / v, 1.0, (3.0 - 0.75 * u - 5.0 * v) / v].map(|x| x * xyz[1])
    };
    let inverse = luxpipe::color::Mat3(TO_XYZ).inverse().unwrap();
    let pale = |c: &Xyz| inverse.apply(more(times(TO_XYZ, *c), 1.26)).iter().all(|x| *x > 0.0);
    let inside: Vec<Xyz> = cube(4000).into_iter().filter(pale).collect();
    assert!(inside.len() > 500, "{}", inside.len());
    let mut xyz: Vec<Xyz> = inside.iter().map(|c| times(TO_XYZ, *c)).collect();
    xyz.push(sets::mixed(520.0, 0.0, 0.1)); // something to bend for
    for options in ["--gamut compress", "--intent perceptual"] {
        for (got, want) in rgb(options, DISPLAY, &xyz).iter().zip(&inside) {
            assert!((0..3).all(|i| (got[i] - want[i]).abs() < 2e-6), "{options}: {got:?} for {want:?}");
        }
    }
}

/// sRGB's reference display: 80 cd/m2 and 0.2 cd/m2 by themselves, 64 lux on a face that reflects 1 % add 0.64/pi.
#[test]
fn colorimetric_shows_the_stimulus() {
    let veil = 64.0 * 0.01 / std::f64::consts::PI;
    let (black, white) = (0.2 + veil, 80.0 + veil);
    let light: Vec<Xyz> = cube(2000)
        .iter()
        .map(|c| times(TO_XYZ, *c))
        .map(|c| [0, 1, 2].map(|i| (white - black) * c[i] + black * WHITE[i]))
        .collect();
    let values = rgb("--intent colorimetric --display srgb", CD_M2, &light);
    for (got, want) in values.iter().zip(&light) {
        let shown = times(TO_XYZ, got.map(|x| x * (white - black) + black));
        assert!((0..3).all(|i| (shown[i] / want[i] - 1.0).abs() < 1e-5), "{shown:?} for {want:?}");
    }
}

#[test]
fn saturation_is_kept_where_the_gamut_has_it() {
    let most = CORNERS.map(|c| (c[0] - uv(WHITE)[0]).hypot(c[1] - uv(WHITE)[1])).iter().fold(0.0f64, |m, r| m.max(*r));
    let colours: Vec<Xyz> =
        [sets::locus().colours, sets::pointer().colours].concat().into_iter().filter(|c| c[1] > 0.0).collect();
    let mut held = 0;
    for (got, want) in rgb("--intent saturation", DISPLAY, &colours).iter().zip(&colours) {
        assert!(got.iter().all(|x| (0.0..=1.0).contains(x)), "{got:?}");
        let (radius, shown) = (from_white(*want).0, from_white(times(TO_XYZ, *got)).0);
        if radius < most && radius > 1e-3 {
            assert!((shown / radius - 1.0).abs() < 0.01, "{shown} for {radius}: {want:?} {got:?}");
            held += 1;
        }
    }
    assert!(held > 700, "{held}");
}

#[test]
fn luminance_is_kept() {
    for (options, low) in [("clip", 0.5), ("desaturate", 1e-5), ("shrink", 1e-5), ("compress", 1e-5)] {
        let all = ["", "--hue oklab", "--reach visible", "--knee 1"];
        let of_its_own = match options {
            "compress" => &all[..],
            "shrink" => &all[..3],
            _ => &all[..1],
        };
        for rest in of_its_own {
            let colours: Vec<Xyz> = [outside(), sets::pointer().colours, sets::locus().colours].concat();
            let got = rgb(&format!("--gamut {options} {rest}"), DISPLAY, &colours);
            let worst = got
                .iter()
                .zip(&colours)
                .filter(|(_, c)| (1e-6..=1.0).contains(&c[1]))
                .map(|(g, c)| (times(TO_XYZ, *g)[1] / c[1] - 1.0).abs())
                .fold(0.0, f64::max);
            // Clipping is the one that does not.
            assert!(if options == "clip" { worst > low } else { worst < low }, "{options} {rest}: {worst}");
        }
    }
}

#[test]
fn everything_fits() {
    let colours = [outside(), sets::pointer().colours, sets::locus().colours].concat();
    for options in METHODS {
        let got = rgb(options, DISPLAY, &colours);
        assert!(got.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)), "{options}");
    }
}

fn hue_is_kept(hue: &str, direction: fn(Xyz) -> f64, tolerance: f64) {
    let colours = outside();
    for method in ["shrink", "shrink --reach visible", "compress", "compress --knee 1", "compress --knee 0"] {
        let options = format!("--gamut {method} --hue {hue}");
        let mut compared = 0;
        for (got, want) in rgb(&options, DISPLAY, &colours).iter().zip(&colours) {
            let shown = times(TO_XYZ, *got);
            if from_white(shown).0 > 0.01 {
                let off = angle(direction(shown), direction(*want));
                assert!(off < tolerance, "{options}: {off} at {want:?}, {got:?}");
                compared += 1;
            }
        }
        assert!(compared > 600, "{options}: {compared}");
    }
}

#[test]
fn hue_is_kept_in_its_space() {
    hue_is_kept("uv", |c| from_white(c).1, 1e-4);
    hue_is_kept("oklab", oklab_hue, 1e-3);
}

/// Negative, tiny, huge, imaginary, and all of these at once.
#[test]
fn finite_colours_stay_finite() {
    let values = [0.0, 1e-45, 1e-38, 1e-6, 0.5, 1.0, 1e6, 1e38, 3.4e38];
    let signed: Vec<f64> = values.iter().flat_map(|x| [*x, -x]).collect();
    let mut colours = Vec::new();
    for x in &signed {
        for y in &signed {
            colours.extend(signed.iter().map(|z| [*x, *y, *z]));
        }
    }
    // Without a WHITE line no primaries are wrong.
    let [display, scene] = [DISPLAY, CD_M2].map(|lines| lines.rsplit_once('\n').unwrap().0);
    for to in ["BT.709", "BT.2020", "AP0"] {
        for options in METHODS {
            let got = rgb(&format!("{options} --to {to}"), display, &colours);
            let bad = got.iter().zip(&colours).find(|(g, _)| !g.iter().all(|x| (0.0..=1.0).contains(x)));
            assert!(bad.is_none(), "{options} {to}: {bad:?}");
            if options.starts_with("--gamut") {
                let got = rgb(&format!("{options} --to {to}"), scene, &colours);
                let bad = got.iter().zip(&colours).find(|(g, _)| !g.iter().all(|x| x.is_finite() && *x >= 0.0));
                assert!(bad.is_none(), "{options} {to} cd/m2: {bad:?}");
            }
        }
        let plain = rgb(&format!("--to {to}"), display, &colours);
        let bad = plain.iter().zip(&colours).find(|(g, _)| g.iter().any(|x| x.is_nan()));
        assert!(bad.is_none(), "none {to}: {bad:?}");
    }
    for options in ["--intent colorimetric --display srgb", "--intent colorimetric --display p3 --relative"] {
        let got = rgb(options, scene, &colours);
        assert!(got.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)), "{options}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let off = DISPLAY.replace("0.3127 0.3290", "0.3160 0.3290");
    let near = DISPLAY.replace("0.3127 0.3290", "0.3150 0.3290");
    let refused = [
        ("--intent perceptual", CD_M2, "run vonkries and pcond first"),
        ("--intent saturation", CD_M2, "run vonkries and pcond first"),
        ("--intent perceptual", &off, "vonkries adapts, xyz2rgb does not"),
        ("--intent saturation", &off, "vonkries adapts, xyz2rgb does not"),
        ("--intent colorimetric", DISPLAY, "the colorimetric intent shows cd/m2"),
        ("--intent perceptual --display srgb", DISPLAY, "the picture was mapped for 1 to 100 cd/m2"),
        ("--gamut clip --display p3", DISPLAY, "the picture was mapped for 1 to 100 cd/m2"),
        ("--gamut compress --knee 1.5", DISPLAY, "--knee 1.5 lies outside 0 to 1"),
    ];
    for (options, lines, message) in refused {
        let args: Vec<&str> = options.split_whitespace().collect();
        let output = run("xyz2rgb", &args, &picture(lines, &[WHITE]));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && output.stdout.is_empty(), "{options}: {text}");
        assert!(text.contains(message) && text.lines().count() == 1, "{options}: {text}");
    }
    for lines in [near.as_str(), &off] {
        let output = run("xyz2rgb", &["--gamut", "clip"], &picture(lines, &[WHITE]));
        let warned = String::from_utf8_lossy(&output.stderr).contains("vonkries adapts");
        assert!(output.status.success() && warned == (lines == off), "{lines}");
    }
    rgb("--intent perceptual", &near, &[WHITE]);
    rgb("--intent colorimetric", &CD_M2.replace("0.3127 0.3290", "0.4476 0.4074"), &[WHITE]);
}

#[test]
fn there_and_back() {
    for to in ["BT.709", "P3", "BT.2020", "Adobe"] {
        let colours: Vec<Xyz> = cube(2000).iter().map(|c| times(TO_XYZ, *c)).collect();
        let there = stdout_of("xyz2rgb", &["--quiet", "--to", to], &picture(DISPLAY, &colours));
        for (got, want) in triples(&stdout_of("xyz2rgb", &["-r"], &there)).iter().zip(&colours) {
            let largest = want.iter().fold(0.0f64, |m, x| m.max(*x));
            assert!((0..3).all(|i| (got[i] - want[i]).abs() < 2e-6 * largest), "{to}: {got:?} for {want:?}");
        }
    }
}

/// Munsell's blues [Newhall 1943] turn in every space; which way, and where u'v' or Oklab is straighter, decides what
/// `--hue` to use. Angles by numpy and colour-science 0.4.7, chroma 4 less largest.
#[test]
fn munsell_blues() {
    let want = [
        ("5B", 14.0, [-9.7, -4.4, 8.2]),
        ("10B", 16.0, [-6.6, -5.7, 17.5]),
        ("2.5PB", 18.0, [-5.2, -8.4, 21.9]),
        ("5PB", 20.0, [-2.3, -8.5, 27.0]),
        ("7.5PB", 26.0, [-5.0, -16.0, 5.6]),
        ("10PB", 30.0, [-3.3, -13.5, -2.5]),
    ];
    let lines = blue::munsell();
    assert_eq!(lines.len(), want.len());
    for (got, (name, chroma, turns)) in lines.iter().zip(want) {
        assert_eq!((got.name.as_str(), got.chroma), (name, chroma));
        assert!((0..3).all(|i| (got.turns[i] - turns[i]).abs() < 0.11), "{name}: {:?} for {turns:?}", got.turns);
    }
}

/// Blues paled along u'v' turn toward purple in Oklab and hold more red than those paled along Oklab.
#[test]
fn blues_turn_toward_purple_in_uv() {
    for b in blue::blues().into_iter().chain(blue::paled()) {
        let turn = |c: Xyz| (oklab_hue(c) - oklab_hue(b.xyz)).to_degrees();
        assert!(turn(b.by_uv) > 4.0 && turn(b.by_oklab).abs() < 0.1, "{}: {}", b.name, turn(b.by_uv));
        assert!(blue::red(b.by_uv) >= blue::red(b.by_oklab) - 0.1, "{}", b.name);
    }
}

#[test]
fn the_page_is_up_to_date() {
    page_is_printed("docs/gamut.md", &gamut::page());
}
