//! What each encoding of light keeps, and what it costs: shared by `make paper-encodings` and tests/encodings.rs.
#![allow(dead_code)] // the page and the tests each use their part

pub mod coders;
pub mod files;
pub mod grey;
pub mod lamplight;
pub mod limits;
pub mod paper;
pub mod visible;

use coders::{ENCODINGS, Encoding};
use grey::Steps;
use visible::Report;

/// Luminances of a display's range, and of one with highlights.
pub const RANGES: [[f64; 2]; 2] = [[0.01, 1.0], [0.02, 10.0]];

/// All that was measured of one encoding but speed.
pub struct Measured {
    /// Which.
    pub encoding: Encoding,
    /// Lowest and highest luminance held within 1 % and 5 %.
    pub ranges: [[f64; 2]; 2],
    /// Luminances around the middle.
    pub steps: Steps,
    /// Visible colours in each of [`RANGES`].
    pub reports: [Report; 2],
    /// Of the files of both pictures.
    pub bytes_a_pixel: [f64; 2],
}

impl Measured {
    /// True unless greys are off by more than 1 % everywhere, as dithered ones are.
    fn holds_1_percent(&self) -> bool {
        self.steps.error <= 0.01
    }

    /// Orders of magnitude held within 1 %, or within 5 % where 1 % asks too much.
    fn orders(&self) -> String {
        let [within_1, within_5] = self.ranges.map(grey::orders);
        if self.holds_1_percent() { format!("{within_1:.2}") } else { format!("{within_5:.2}, within 5 %") }
    }
}

/// Measures all encodings.
pub fn measure() -> Vec<Measured> {
    let colours = RANGES.map(visible::colours);
    let one = |(encoding, bytes_a_pixel): (Encoding, [f64; 2])| Measured {
        encoding,
        ranges: [0.01, 0.05].map(|tolerance| grey::range(&encoding, tolerance)),
        steps: grey::steps(&encoding),
        reports: colours.each_ref().map(|c| Report::of(&encoding, c)),
        bytes_a_pixel,
    };
    ENCODINGS.into_iter().zip(files::bytes_a_pixel()).map(one).collect()
}

/// A line of a Markdown table.
fn row<S: AsRef<str>>(cells: impl IntoIterator<Item = S>) -> String {
    cells.into_iter().fold("|".to_string(), |line, cell| line + " " + cell.as_ref() + " |") + "\n"
}

/// The head of a Markdown table, columns separated by `|`.
fn head(columns: &str) -> String {
    let names: Vec<&str> = columns.split('|').collect();
    row(&names) + &"|---".repeat(names.len()) + "|\n"
}

/// A number to three digits.
fn short(x: f64) -> String {
    match x {
        _ if x == 0.0 => "0".into(),
        _ if x < 0.001 => format!("{x:.1e}"),
        _ if x < 0.1 => format!("{x:.4}"),
        _ if x < 1.0 => format!("{x:.3}"),
        _ if x < 100.0 => format!("{x:.2}"),
        _ => format!("{x:.1}"),
    }
}

fn percent(share: f64) -> String {
    short(100.0 * share)
}

fn summary(all: &[Measured]) -> String {
    let line = |m: &Measured| {
        let [report, _] = m.reports;
        let e = report.all;
        row([
            m.encoding.name.to_string(),
            m.encoding.bits.to_string(),
            m.orders(),
            percent(m.steps.largest),
            percent(report.outside),
            short(e.mean),
            short(e.p95),
            short(e.max),
            percent(e.over_1),
            format!("{:.2}", m.bytes_a_pixel[0]),
            format!("{:.2}", m.bytes_a_pixel[1]),
        ])
    };
    let columns =
        "encoding|bits|orders|step %|outside %|Delta E mean|95 %|max|over 1 %|bytes, synthetic|bytes, Cornell";
    head(columns) + &all.iter().map(line).collect::<String>()
}

fn luminances(all: &[Measured]) -> String {
    let line = |m: &Measured| {
        let [within_1, within_5] = m.ranges;
        let ends = within_1.map(|y| if m.holds_1_percent() { format!("{y:.2e}") } else { "-".into() });
        row([
            m.encoding.name.to_string(),
            ends[0].clone(),
            ends[1].clone(),
            format!("{:.2}", grey::orders(within_5)),
            percent(m.steps.error),
            percent(m.reports[0].in_709.luminance[1]),
            percent(m.reports[0].all.luminance[1]),
        ])
    };
    let text = "## Luminance\n\nThe ends of the range within 1 %, its orders of magnitude within 5 %, and the largest error of \
                luminance in percent: of greys, of colours in BT.709, of all visible colours.\n\n";
    let columns = "encoding|from|to|orders, 5 %|greys|in BT.709|visible";
    text.to_string() + &head(columns) + &all.iter().map(line).collect::<String>()
}

fn colours(all: &[Measured]) -> String {
    let line = |m: &Measured| {
        let [display, bright] = m.reports;
        let [a, b, c] = [display.in_709, bright.all, bright.in_709];
        let cells = [a.mean, a.p95, a.max, b.mean, b.p95, b.max, c.mean, c.max].map(short);
        row([m.encoding.name.to_string()].into_iter().chain(cells))
    };
    let text = "## Colours within BT.709, and highlights\n\nDelta E 2000 as above, first of the colours that BT.709 has, then of \
                luminances from 0.02 to 10: where white is at 1, highlights. Pixar log's ceiling is a component of 24.\n\n";
    let columns = "encoding|in BT.709: mean|95 %|max|0.02 to 10: mean|95 %|max|and in BT.709: mean|max";
    text.to_string() + &head(columns) + &all.iter().map(line).collect::<String>()
}

fn trips(all: &[Measured]) -> String {
    let line = |m: &Measured| {
        let [r, _] = m.reports;
        let cells = [r.all.mean, r.five.mean, r.all.max, r.five.max].map(short);
        row([m.encoding.name.to_string()].into_iter().chain(cells).chain(r.drifted.map(percent)))
    };
    let text = "## Five round trips\n\nWritten and read five times, as `ra_x -r | ra_x` does, in the file's own components: Delta E 2000 \
                after the first and after the fifth, and the share of pixels that the second to fifth changed at all; the same \
                with a conversion to XYZ in floats and back between any two. By way of XYZ, a half near 0 \
                beside large ones takes their rounding.\n\n";
    let columns = "encoding|mean, once|five times|max, once|five times|changed %|by XYZ, changed %";
    text.to_string() + &head(columns) + &all.iter().map(line).collect::<String>()
}

/// All of docs/encodings.md but the speeds, which no two machines share.
pub fn page() -> String {
    let all = measure();
    let parts = [
        summary(&all),
        paper::page(&all),
        luminances(&all),
        colours(&all),
        lamplight::page(&all),
        trips(&all),
        limits::page(),
    ];
    format!("{}{}\n", include_str!("head.md"), parts.join("\n"))
}

/// The last section of docs/encodings.md.
pub fn speed() -> String {
    let line = |(e, speed): (Encoding, [f64; 2])| {
        row([e.name.to_string(), format!("`{}`", e.command)].into_iter().chain(speed.map(|s| format!("{s:.0}"))))
    };
    let rows: String = ENCODINGS.into_iter().zip(files::speeds()).map(line).collect();
    format!(
        "## Speed\n\nMegapixels a second on one thread of {}: the same picture of 2048 x 1024 pixels, from XYZ in memory to a file in \
         memory, and from the file to floats; medians of five runs. These differ by machine and from run to run. LogLuv24 and Pixar \
         log read the picture twice to choose a scale; Pixar log's and EXR's time is mostly Deflate's. `make bench` compares with Radiance and libtiff.\n\n{}{rows}",
        files::processor(),
        head("encoding|command|write|read"),
    )
}
