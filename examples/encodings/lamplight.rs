//! A picture in lamp light, adapted to daylight: before it is recorded, or after.

use luxpipe::color::{Cat, Mat3, Primaries, Xy, adapt};

use super::visible::{self, Errors};
use super::{Measured, RANGES, head, row, short};

/// CIE illuminant A.
const LAMP: Xy = Xy { x: 0.447_58, y: 0.407_45 };

/// Colours that BT.709 has under D65.
fn daylit() -> Vec<[f64; 3]> {
    let to_709 = Primaries::BT709.from_xyz().unwrap_or(Mat3::IDENTITY);
    let all = visible::colours(RANGES[0]).into_iter();
    all.filter(|c| to_709.apply(*c).iter().all(|x| *x >= 0.0)).collect()
}

/// Errors under D65 of colours that were recorded as they look under A, and adapted when read.
fn later(m: &Measured, daylit: &[[f64; 3]], lit: &[[f64; 3]], to_daylight: &Mat3) -> Errors {
    let seen: Vec<[f64; 3]> = m.encoding.seen(lit).iter().map(|c| to_daylight.apply(*c)).collect();
    Errors::of(daylit, &seen)
}

/// The section of the page.
pub fn page(all: &[Measured]) -> String {
    let to_daylight = adapt::von_kries(Cat::Cmccat2000, LAMP, Xy::D65, 1.0).expect("two whites");
    let to_lamplight = to_daylight.inverse().expect("a matrix of full rank");
    let daylit = daylit();
    let lit: Vec<[f64; 3]> = daylit.iter().map(|c| to_lamplight.apply(*c)).collect();
    let line = |m: &Measured| {
        let (first, later) = (m.reports[0].in_709, later(m, &daylit, &lit, &to_daylight));
        let cells = [first.mean, first.p95, first.max, later.mean, later.p95, later.max].map(short);
        row([m.encoding.name.to_string()].into_iter().chain(cells))
    };
    let rows: String = all.iter().map(line).collect();
    format!("{TEXT}{}{rows}", head("encoding|adapted first: mean|95 %|max|recorded first: mean|95 %|max"))
}

const TEXT: &str = "\
## Lamp light

Adaptation to daylight multiplies the little blue there is under a lamp, and with it the errors of what was recorded. Delta E 2000 of \
the colours that BT.709 has under D65, lit by A and adapted to D65 (`vonkries`, CMCCAT2000): before they are recorded, or when the \
record is read. Positive RGB loses what lies outside its primaries in \
that light; of what holds it all, LogLuv's cells in u' and v' feel it most. Adapted before, or in half EXR, it stays finer.

";
