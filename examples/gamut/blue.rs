//! Blues that pale: along straight lines in u'v', in Oklab, and as the Munsell system has it.

use luxpipe::color::compress::{Compressor, Curve, Hue};
use luxpipe::color::difference::{lab, oklab, uv};
use luxpipe::color::{Cat, Mat3, Primaries, Xy, adapt};

use super::errors::{polar, turn};
use super::methods::shown;
use super::sets::{mixed, white};

/// A blue and what becomes of it in BT.709 by each hue.
#[derive(Clone)]
pub struct Blue {
    pub name: String,
    pub xyz: [f64; 3],
    pub by_uv: [f64; 3],
    pub by_oklab: [f64; 3],
}

/// Hue in degrees, 0 to 360.
pub fn hue(lab: [f64; 3]) -> f64 {
    polar(lab).0.rem_euclid(360.0)
}

/// 450 to 470 nm with a quarter of the luminance white, and the blue of BT.2020, at a twentieth of the white's luminance.
pub fn blues() -> Vec<Blue> {
    let y = 0.05;
    let primary = Primaries::BT2020.rgb[2].xyz().map(|x| x * y);
    let pale = (450..=470).step_by(5).map(|nm| (format!("{nm} nm + 25 % white"), mixed(f64::from(nm), 0.25, y)));
    let all: Vec<(String, [f64; 3])> = pale.chain([("blue of BT.2020".to_string(), primary)]).collect();
    let colours: Vec<[f64; 3]> = all.iter().map(|b| b.1).collect();
    let [by_uv, by_oklab] =
        ["uv", "oklab"].map(|hue| shown(&format!("--gamut compress --knee 1 --hue {hue}"), Primaries::BT709, &colours));
    let blue =
        |(i, (name, xyz)): (usize, (String, [f64; 3]))| Blue { name, xyz, by_uv: by_uv[i], by_oklab: by_oklab[i] };
    all.into_iter().enumerate().map(blue).collect()
}

/// The blue of BT.709 with three quarters, half and a quarter of its saturation.
pub fn paled() -> Vec<Blue> {
    let xyz = Primaries::BT709.rgb[2].xyz().map(|x| x * 0.05);
    let pale = |hue: Hue, share: f64| {
        let mut shrink = Compressor::new(Primaries::BT709, hue, Curve::Shrink).expect("a gamut");
        shrink.reach = 1.0 / share;
        shrink.apply(xyz)
    };
    let blue = |share: f64| Blue {
        name: format!("blue of BT.709, {:.0} %", 100.0 * share),
        xyz,
        by_uv: pale(Hue::Uv, share),
        by_oklab: pale(Hue::Oklab, share),
    };
    [0.75, 0.5, 0.25].map(blue).to_vec()
}

/// Red as a share of blue in BT.709: how purple it is.
pub fn red(xyz: [f64; 3]) -> f64 {
    let rgb = Primaries::BT709.from_xyz().unwrap_or(Mat3::IDENTITY).apply(xyz);
    100.0 * rgb[0] / rgb[2]
}

fn row(b: &Blue) -> String {
    let w = white();
    let all = [b.xyz, b.by_uv, b.by_oklab];
    let hues = |f: &dyn Fn([f64; 3]) -> f64| all.map(|c| format!("{:.1}", f(c))).join(" | ");
    let reds = format!("{:.0} | {:.0}", red(b.by_uv), red(b.by_oklab));
    format!("| {} | {} | {} | {reds} |\n", b.name, hues(&|c| hue(oklab(c))), hues(&|c| hue(lab(c, w))))
}

/// One Munsell hue: name, largest chroma, and how far the hue turns from there to chroma 4 in u'v', CIELAB and Oklab.
pub struct MunsellLine {
    pub name: String,
    pub chroma: f64,
    pub turns: [f64; 3],
}

/// Hues in u'v', CIELAB and Oklab of an x, y, Y under C.
fn hues_under_c(x: f64, y: f64, luminance: f64) -> [f64; 3] {
    let c = Xy { x: 0.31006, y: 0.31616 };
    let xyz = Xy { x, y }.xyz().map(|v| v * luminance);
    let (q, w) = (uv(xyz).expect("a colour"), uv(c.xyz()).expect("a white"));
    let to_d65 = adapt::von_kries(Cat::Bradford, c, Xy::D65, 1.0).expect("two whites");
    [[0.0, q[0] - w[0], q[1] - w[1]], lab(xyz, c.xyz()), oklab(to_d65.apply(xyz))].map(|l| polar(l).0)
}

/// The lines of tests/ref/munsell_blue.csv.
pub fn munsell() -> Vec<MunsellLine> {
    let text = include_str!("../../tests/ref/munsell_blue.csv");
    let mut lines: Vec<(String, Vec<[f64; 4]>)> = Vec::new();
    for row in text.lines().filter(|l| !l.starts_with(['#', 'h'])) {
        let (name, rest) = row.split_once(',').expect("a row");
        let n: Vec<f64> = rest.split(',').map(|n| n.parse().expect("a number")).collect();
        if lines.last().is_none_or(|l| l.0 != name) {
            lines.push((name.to_string(), Vec::new()));
        }
        if let Some(line) = lines.last_mut() {
            line.1.push([n[1], n[2], n[3], n[4] / 100.0]);
        }
    }
    let line = |(name, points): (String, Vec<[f64; 4]>)| {
        let most = points[points.len() - 1];
        let hues = |p: [f64; 4]| hues_under_c(p[1], p[2], p[3]);
        let pale = points.iter().find(|p| p[0] == 4.0).copied().expect("chroma 4");
        let (from, to) = (hues(most), hues(pale));
        MunsellLine { name, chroma: most[0], turns: [0, 1, 2].map(|i| turn(from[i], to[i])) }
    };
    lines.into_iter().map(line).collect()
}

fn munsell_row(l: &MunsellLine) -> String {
    format!("| {} | {:.0} | {} |\n", l.name, l.chroma, l.turns.map(|t| format!("{t:.1}")).join(" | "))
}

pub fn page() -> String {
    let rows: String = blues().iter().chain(&paled()).map(row).collect();
    let lines: String = munsell().iter().map(munsell_row).collect();
    format!("{TEXT}{rows}\n{MUNSELL}{lines}{VERDICT}")
}

const TEXT: &str = "\
## Blue to purple

Blues brought to the edge of BT.709 (`--gamut compress --knee 1`), and the blue of BT.709 itself with less saturation, by \
`--hue uv` and `--hue oklab`: hue in Oklab and in CIELAB before and after, and linear red as a share of blue in what is shown.

| blue | Oklab hue | by uv | by oklab | CIELAB hue | by uv | by oklab | red % by uv | by oklab |
|---|---|---|---|---|---|---|---|---|
";

const MUNSELL: &str = "\
Which is right? The Munsell renotation has lines that people saw as one hue. How far each turns (degrees, negative toward \
green) from its largest chroma to chroma 4, at value 4 (tests/ref/munsell_blue.csv); 0 where the space is straight:

| Munsell hue | from chroma | u'v' | CIELAB | Oklab |
|---|---|---|---|---|
";

const VERDICT: &str = "
So a blue that stays one Munsell hue while it pales does turn toward purple in Oklab, by 8 to 27 degrees from 5B to 5PB, much as \
straight lines in u'v' do; there `--hue uv` is nearer to what people saw. At 7.5PB, next to the blue of BT.709, both are as near, \
and at 10PB Oklab is nearer. CIELAB's lines, which neither option follows, are the ones that turn 7.5PB purple. (The renotation is \
extrapolated at its largest chromas.) `--hue oklab` keeps blues clean of red; `--hue uv`, the default, is Radiance's line.
";
