//! What an encoding does to the visible colours: Delta E 2000 over all of them, the same at every run.

use luxpipe::codec::logluv::cells::Cells;
use luxpipe::color::difference::{delta_e_2000, uv, uv_to_xyz};
use luxpipe::color::{Mat3, Primaries, Xy};
use luxpipe::spectral::Observer;

use super::coders::Encoding;

/// Step of the grid of colours in u' and v'.
const STEP: f64 = 0.003;
/// Colours in each square of the grid.
const PER_SQUARE: usize = 16;
/// Multiples of these fill the unit cube evenly wherever they are cut off: powers of the root of x^4 = x + 1, inverted.
const EVEN: [f64; 3] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];
/// Wavelengths of the locus, nm; the purples lie between its ends.
const LOCUS_NM: std::ops::RangeInclusive<u32> = 380..=700;
/// Luminance, white at 1, of L* = 50, to which colours are exposed before they are compared.
const HALF_LIGHTNESS: f64 = (66.0 / 116.0) * (66.0 / 116.0) * (66.0 / 116.0);

/// XYZ of colours inside the locus, sixteen in each square of the grid, luminances spread evenly in their logarithm from
/// `bottom` to `top`. Within a square they lie scattered: points of a plain grid would meet LogLuv's own cells always at the
/// same few places.
pub fn colours([bottom, top]: [f64; 2]) -> Vec<[f64; 3]> {
    let locus = locus();
    let columns = (0.63 / STEP) as usize;
    let squares = columns * (0.6 / STEP) as usize;
    let colour = |n: usize| {
        let [du, dv, share] = EVEN.map(|step| (n as f64 * step).fract());
        let (row, column) = (n / PER_SQUARE / columns, n / PER_SQUARE % columns);
        let at = [(column as f64 + du) * STEP, (row as f64 + dv) * STEP];
        inside(&locus, at).then(|| uv_to_xyz(at, bottom * (top / bottom).powf(share)))
    };
    (0..squares * PER_SQUARE).filter_map(colour).collect()
}

/// The spectral locus in u'v'.
fn locus() -> Vec<[f64; 2]> {
    let observer = Observer::cie1931().expect("built in");
    let at = |nm: u32| uv(observer.cmf.each_ref().map(|c| c.at(f64::from(nm)))).expect("a colour");
    LOCUS_NM.map(at).collect()
}

/// True inside a closed polygon: a ray from the point crosses it an odd number of times.
fn inside(polygon: &[[f64; 2]], [u, v]: [f64; 2]) -> bool {
    let last = polygon[polygon.len() - 1];
    let mut from = last;
    polygon.iter().fold(false, |odd, to| {
        let crosses =
            (from[1] > v) != (to[1] > v) && u < from[0] + (to[0] - from[0]) * (v - from[1]) / (to[1] - from[1]);
        from = *to;
        odd != crosses
    })
}

/// Errors of one set of colours.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Delta E 2000: mean.
    pub mean: f64,
    /// 95 % stay below.
    pub p95: f64,
    /// 99 % stay below.
    pub p99: f64,
    /// The largest.
    pub max: f64,
    /// Share of the colours off by more than 1.
    pub over_1: f64,
    /// Share of the colours off by more than 5.
    pub over_5: f64,
    /// Relative error of luminance: mean and largest.
    pub luminance: [f64; 2],
}

impl Errors {
    /// Of what is seen in place of colours; each exposed so that the colour has L* = 50 under D65.
    pub fn of(colours: &[[f64; 3]], seen: &[[f64; 3]]) -> Errors {
        let white = Xy::D65.xyz();
        let pairs = || colours.iter().zip(seen);
        let exposed = |(a, b): (&[f64; 3], &[f64; 3])| {
            let [a, b] = [a, b].map(|c| c.map(|x| x * HALF_LIGHTNESS / a[1]));
            delta_e_2000(a, b, white)
        };
        let mut all: Vec<f64> = pairs().map(exposed).collect();
        all.sort_by(f64::total_cmp);
        let count = all.len() as f64;
        let percentile = |percent: f64| {
            let rank = percent / 100.0 * (count - 1.0);
            let (low, high) = (all[rank as usize], all[(rank as usize + 1).min(all.len() - 1)]);
            low + (high - low) * rank.fract()
        };
        let over = |limit: f64| (all.len() - all.partition_point(|e| *e <= limit)) as f64 / count;
        let luminance: Vec<f64> = pairs().map(|(a, b)| (b[1] / a[1] - 1.0).abs()).collect();
        Errors {
            mean: all.iter().sum::<f64>() / count,
            p95: percentile(95.0),
            p99: percentile(99.0),
            max: percentile(100.0),
            over_1: over(1.0),
            over_5: over(5.0),
            luminance: [luminance.iter().sum::<f64>() / count, luminance.iter().fold(0.0, |m: f64, e| m.max(*e))],
        }
    }
}

/// What an encoding does to a set of colours.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// All colours.
    pub all: Errors,
    /// Those that BT.709 has too.
    pub in_709: Errors,
    /// Share whose chromaticity the encoding has no place for.
    pub outside: f64,
    /// The same as `all` after five trips.
    pub five: Errors,
    /// Share of the pixels that the second to fifth trip changed: the file's own components handed on, and by way of XYZ.
    pub drifted: [f64; 2],
}

impl Report {
    /// Of one encoding.
    pub fn of(encoding: &Encoding, colours: &[[f64; 3]]) -> Report {
        let once = encoding.trip(&encoding.components(colours));
        let seen = encoding.xyz(&once.components);
        let changed = |last: &[f32]| {
            let pairs = once.components.chunks_exact(3).zip(last.chunks_exact(3));
            pairs.filter(|(a, b)| a != b).count() as f64 / colours.len() as f64
        };
        let last = five_trips(encoding, once.components.clone(), |own| own);
        let by_xyz = five_trips(encoding, once.components.clone(), |own| {
            let floats = encoding.xyz(&own).into_iter().map(|c| c.map(|x| f64::from(x as f32)));
            encoding.components(&floats.collect::<Vec<_>>())
        });
        let to_709 = Primaries::BT709.from_xyz().unwrap_or(Mat3::IDENTITY);
        let holds = |c: &[f64; 3]| to_709.apply(*c).iter().all(|x| *x >= 0.0);
        let (inside, seen_inside): (Vec<[f64; 3]>, Vec<[f64; 3]>) =
            colours.iter().zip(&seen).filter(|(c, _)| holds(c)).unzip();
        let count = colours.len() as f64;
        Report {
            all: Errors::of(colours, &seen),
            in_709: Errors::of(&inside, &seen_inside),
            outside: once.outside as f64 / count,
            five: Errors::of(colours, &encoding.xyz(&last)),
            drifted: [changed(&last), changed(&by_xyz)],
        }
    }
}

/// The second to the fifth trip, with what happens to components between two.
fn five_trips(encoding: &Encoding, once: Vec<f32>, between: impl Fn(Vec<f32>) -> Vec<f32>) -> Vec<f32> {
    (1..5).fold(once, |last, _| encoding.trip(&between(last)).components)
}

/// The colours that one of LogLuv24's cells holds; the others go to the edge.
pub fn in_cells(colours: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let cells = Cells::get();
    let held = |c: &&[f64; 3]| uv(**c).is_some_and(|[u, v]| cells.inside(u, v).is_some());
    colours.iter().filter(held).copied().collect()
}
