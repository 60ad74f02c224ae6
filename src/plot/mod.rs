//! Charts: series of points and bars over two axes, linear or logarithmic, as SVG or PNG.
//!
//! A [`Chart`] says what to draw, in the data's own units; [`Chart::draw`] lays it out on a [`Sheet`] of lines and words in
//! pixels, which [`Sheet::svg`] and [`Sheet::png`] write. Series differ in colour ([Okabe 2008], safe for the colour-blind)
//! and in dash, so that they are told apart in grey too.

mod clean;
pub mod data;
mod font;
mod layout;
mod legend;
mod raster;
mod scale;
mod sheet;
mod svg;

pub use scale::Scale;
pub use sheet::Sheet;

use crate::{Result, usage};

/// Smallest and largest side of a chart, pixels.
pub const SIDES: std::ops::RangeInclusive<u32> = 200..=8192;

/// What to draw.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Above the chart.
    pub title: Option<String>,
    /// Across.
    pub x: Axis,
    /// Up, at the left.
    pub y: Axis,
    /// Up, at the right: the bars'.
    pub second: Option<Axis>,
    /// In the order of the legend.
    pub series: Vec<Series>,
    /// Behind the series; on the second axis if there is one.
    pub bars: Option<Bars>,
}

/// An axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// First and last value shown, ascending; what the data span otherwise.
    pub range: Option<(f64, f64)>,
}

/// A curve.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// (x, y), joined in this order.
    pub points: Vec<(f64, f64)>,
    /// A mark on each point: for few, measured ones.
    pub marks: bool,
}

/// Left end, right end (in x) and height (in the unit of its axis) of a bar.
pub type Bar = (f64, f64, f64);

/// Bars that stand on zero.
#[derive(Clone, Debug, Default)]
pub struct Bars {
    /// For the legend.
    pub name: String,
    /// Ascending.
    pub list: Vec<Bar>,
}

impl Chart {
    /// Lays the chart out on a sheet of `width` x `height` pixels. Returns also remarks on what could not be drawn: numbers
    /// that are not finite or beyond 1e100, and what is not positive on a logarithmic axis.
    ///
    /// ```
    /// use luxpipe::plot::{Chart, Series};
    /// let line = Series { name: "a < b".into(), points: vec![(0.0, 0.0), (1.0, 2.0)], marks: false };
    /// let (sheet, remarks) = Chart { series: vec![line], ..Chart::default() }.draw(640, 400).unwrap();
    /// assert!(sheet.svg().contains("<polyline") && remarks.is_empty());
    /// ```
    pub fn draw(&self, width: u32, height: u32) -> Result<(Sheet, Vec<String>)> {
        for (side, what) in [(width, "wide"), (height, "high")] {
            if !SIDES.contains(&side) {
                return usage!("a chart is {} to {} pixels {what}, not {side}", SIDES.start(), SIDES.end());
            }
        }
        let (chart, remarks) = clean::clean(self)?;
        Ok((layout::lay_out(&chart, width, height)?, remarks))
    }
}
