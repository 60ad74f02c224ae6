//! What [Ward 2001] says of the encodings beside what was measured, and what follows.

use super::Measured;
use super::coders::LIBTIFF_PIXAR;
use super::visible::{self, Errors};
use super::{RANGES, grey, head, percent, row, short};

/// The measurements of one encoding.
fn named<'a>(all: &'a [Measured], name: &str) -> &'a Measured {
    all.iter().find(|m| m.encoding.name == name).expect("an encoding of the list")
}

/// Largest Delta E 2000 of the colours that LogLuv24's cells hold.
fn in_cells(log24: &Measured) -> f64 {
    let colours = visible::in_cells(&visible::colours(RANGES[0]));
    Errors::of(&colours, &log24.encoding.seen(&colours)).max
}

fn orders(m: &Measured) -> String {
    format!("{:.1}", grey::orders(m.ranges[0]))
}

/// "a larger than b" or the other way.
fn compared(a: f64, b: f64) -> &'static str {
    if a < b { "smaller" } else { "larger" }
}

/// The paper's statements beside the measurements, and the conclusions.
pub fn page(all: &[Measured]) -> String {
    let [rgbe, xyze, log24, log32, pixar] =
        ["RGBE", "XYZE", "LogLuv24", "LogLuv32", "Pixar log BT.709"].map(|name| named(all, name));
    let held = |m: &Measured| {
        format!(
            "{} bits, {} orders, {} % of the visible outside",
            m.encoding.bits,
            orders(m),
            percent(m.reports[0].outside)
        )
    };
    let errors = |m: &Measured| {
        let e = m.reports[0].all;
        format!("Delta E mean {}, largest {}, {} % above 1", short(e.mean), short(e.max), percent(e.over_1))
    };
    let rows = [
        ["RGBE: 32 bits, \"a large dynamic range but is restricted to positive RGB values\"", &held(rgbe)],
        ["XYZE: \"the associated quantization errors make it a poor choice\"", &errors(xyze)],
        ["Pixar: 33 bits, \"restricted RGB gamut and only covers 3.8 orders of magnitude\"", &held(pixar)],
        ["LogLuv24: \"5 orders of magnitude and the full visible gamut in 24 bits\"", &held(log24)],
        ["LogLuv32: \"up to 38 orders of magnitude\"", &held(log32)],
        [
            "LogLuv32: \"often results in smaller files due to run-length encoding\"",
            &format!(
                "synthetic picture {:.2} bytes a pixel (LogLuv24 {:.2}, RGBE {:.2}), Cornell box {:.2} ({:.2}, {:.2})",
                log32.bytes_a_pixel[0],
                log24.bytes_a_pixel[0],
                rgbe.bytes_a_pixel[0],
                log32.bytes_a_pixel[1],
                log24.bytes_a_pixel[1],
                rgbe.bytes_a_pixel[1]
            ),
        ],
    ];
    let table: String = rows.iter().map(row).collect();
    format!("## The paper's argument\n\n{}{table}\n{}", head("the paper says|measured"), conclusions(all))
}

fn conclusions(all: &[Measured]) -> String {
    let [log24, log32, xyze, half] = ["LogLuv24", "LogLuv32", "XYZE", "EXR half BT.709"].map(|name| named(all, name));
    let [narrow, wide, pixar] = ["RGBE BT.709", "RGBE BT.2020", "Pixar log BT.709"].map(|name| named(all, name));
    let all_of = |m: &Measured| m.reports[0].all;
    let in_709 = |m: &Measured| m.reports[0].in_709;
    let bright = pixar.reports[1].in_709;
    [
        format!(
            "- Of what has 32 bits and less, LogLuv32 alone holds every visible colour and has no long tail: mean {}, largest {}, steps \
             of {} % over {} orders.",
            short(all_of(log32).mean), short(all_of(log32).max), percent(log32.steps.largest), orders(log32)
        ),
        format!(
            "- XYZE is as good as LogLuv24 on average ({} and {}), and in BT.709 its mean is even {} than LogLuv32's ({} and {}). Its tail makes \
             it the poor choice that the paper calls it: {} % of the visible colours are off by more than 1, violets by up to {}, with \
             luminance wrong by up to {} %.",
            short(all_of(xyze).mean),
            short(all_of(log24).mean),
            compared(in_709(xyze).mean, in_709(log32).mean),
            short(in_709(xyze).mean),
            short(in_709(log32).mean),
            percent(all_of(xyze).over_1),
            short(all_of(xyze).max),
            percent(all_of(xyze).luminance[1])
        ),
        format!(
            "- Positive RGB costs most, whatever the bits: {} % of the visible chromaticities lie outside BT.709, {} % outside BT.2020, and \
             come back {} and {} off on average.",
            percent(narrow.reports[0].outside),
            percent(wide.reports[0].outside),
            short(all_of(narrow).mean),
            short(all_of(wide).mean)
        ),
        format!(
            "- Inside BT.709 Pixar log is the finest of the paper's encodings ({} on average), until a component passes its ceiling: with \
             luminances up to 10 the largest error is {}. Its {} orders are the paper's 3.8 because the code nearest to a value is taken; \
             libtiff's encoder cuts values under 2 to steps of 7.3e-5 first, and keeps {:.1}.",
            short(in_709(pixar).mean), short(bright.max), orders(pixar),grey::orders(grey::range(&LIBTIFF_PIXAR, 0.01))
        ),
        format!(
            "- LogLuv24's cells are libtiff's, and leave {} % of the visible out at the very edge; such colours move to it, by up to {}. All others \
             are off by {} at most.",
            percent(log24.reports[0].outside), short(all_of(log24).max), short(in_cells(log24))
        ),
        format!(
            "- OpenEXR's half came after the paper. Its components have a sign, so every visible colour fits any primaries: mean {}, largest \
             {}, {} orders, at {} bits a pixel.\n",
            short(all_of(half).mean), short(all_of(half).max), orders(half), half.encoding.bits
        ),
    ]
    .join("\n")
}
