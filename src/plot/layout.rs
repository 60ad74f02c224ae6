//! From a chart to a sheet: margins, axes, ticks, curves.

use crate::plot::font::Font;
use crate::plot::legend::{Legend, Sign};
use crate::plot::scale::{Ruler, Tick, aired, rounded, widened};
use crate::plot::sheet::{Anchor, Colour, Frame, Point, Shape, Sheet};
use crate::plot::{Axis, Bar, Chart, Scale, Series};
use crate::{Result, invalid, usage};

/// Words and axes.
pub const INK: Colour = [34, 34, 34];
/// Bars.
pub const BARS: Colour = [214, 214, 214];
/// The legend's frame.
pub const EDGE: Colour = [200, 200, 200];
const GRID: Colour = [232, 232, 232];

/// Colours of [Okabe 2008] without yellow, which white paper swallows.
const COLOURS: [Colour; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [0, 0, 0], [230, 159, 0], [86, 180, 233]];
/// Dashes, parts of a line's width.
const DASHES: [&[f64]; 5] = [&[], &[5.0, 2.2], &[1.3, 1.5], &[7.0, 2.0, 1.5, 2.0], &[11.0, 3.0]];

/// The size at which the lengths below are pixels.
const BASE: (f64, f64) = (720.0, 480.0);
const FONT: f64 = 14.0;
const TITLE: f64 = 16.0;

/// How curves are drawn.
pub struct Pens {
    width: f64,
}

impl Pens {
    /// A line of the curve with this place in the list.
    pub fn line(&self, place: usize, points: Vec<Point>) -> Shape {
        let dash = DASHES[place % DASHES.len()].iter().map(|d| d * self.width).collect();
        Shape::Line { points, colour: COLOURS[place % COLOURS.len()], width: self.width, dash }
    }

    /// A mark of that curve.
    pub fn mark(&self, place: usize, at: Point) -> Shape {
        Shape::Disc { at, radius: 1.8 * self.width, colour: COLOURS[place % COLOURS.len()] }
    }
}

/// What all parts share.
struct Layout<'a> {
    chart: &'a Chart,
    font: Font,
    /// Pixels of a length at [`BASE`].
    s: f64,
    size: (f64, f64),
}

/// Axes in their places.
struct Axes {
    frame: Frame,
    x: Ruler,
    y: Ruler,
    second: Option<Ruler>,
}

/// Lays out a chart that has something to draw.
pub fn lay_out(chart: &Chart, width: u32, height: u32) -> Result<Sheet> {
    let size = (f64::from(width), f64::from(height));
    let s = (size.0 / BASE.0).min(size.1 / BASE.1);
    let layout = Layout { chart, font: Font::new(), s, size };
    let pens = Pens { width: (2.0 * s).max(1.0) };
    let mut sheet = Sheet::new(width, height, chart.title.as_deref().unwrap_or(""));
    let mut axes = layout.axes(0.0)?;
    layout.check_seen(&axes)?;
    let legend = layout.legend(&axes.frame);
    let place = legend.place(&axes.frame, &layout.obstacles(&axes));
    let strip = if place.is_none() { legend.strip_height(axes.frame.width()) } else { 0.0 };
    if strip > 0.5 * axes.frame.height() {
        return usage!("the chart is too small for the names of {} curves; give --height", chart.series.len());
    }
    if strip > 0.0 {
        axes = layout.axes(strip)?;
    }
    layout.draw_data(&mut sheet, &axes, &pens);
    layout.draw_axes(&mut sheet, &axes);
    match place {
        Some(frame) => legend.stack(&mut sheet, &frame, &pens),
        None => legend.strip(&mut sheet, &axes.frame, &pens),
    }
    Ok(sheet)
}

impl Layout<'_> {
    /// Axes with margins as wide as their words need, `strip` pixels left above the chart.
    fn axes(&self, strip: f64) -> Result<Axes> {
        let (s, chart) = (self.s, self.chart);
        let line = FONT * s;
        let title = if chart.title.is_some() { (TITLE + 16.0) * s } else { 12.0 * s };
        let whole = |v: f64| v.round() + 0.5;
        let top = whole(title + strip);
        let bottom = whole(self.size.1 - (if chart.x.label.is_empty() { 1.9 } else { 3.6 }) * line);
        let x_range = self.x_range();
        let mut x = Ruler::new(chart.x.scale, settled(&chart.x, "x", x_range)?);
        let up = ((bottom - top) / (42.0 * s)).max(2.0) as usize;
        let (heights, second) = self.y_ranges(x.range, up);
        let mut y = Ruler::new(chart.y.scale, settled(&chart.y, "y", heights)?);
        y.pixels = (bottom, top);
        let second = match (&chart.second, second) {
            (Some(axis), Some(range)) => {
                let mut ruler = Ruler::new(axis.scale, settled(axis, "second y", range)?);
                ruler.pixels = (bottom, top);
                Some(ruler)
            }
            _ => None,
        };
        let room = |ruler: &Ruler, axis: &Axis| {
            let words = ruler.ticks(up).into_iter().filter_map(|t| t.label);
            let widest = words.map(|w| self.font.width(&w, line)).fold(0.0, f64::max);
            widest + 10.0 * s + if axis.label.is_empty() { 0.0 } else { 1.9 * line }
        };
        let left = whole(room(&y, &chart.y) + 6.0 * s);
        let beside = chart.second.as_ref().zip(second.as_ref()).map(|(axis, r)| room(r, axis));
        let right = whole(self.size.0 - beside.unwrap_or(0.0).max(1.6 * line) - 6.0 * s);
        x.pixels = (left, right);
        let frame = Frame { left, top, right, bottom };
        if frame.width() < 60.0 || frame.height() < 40.0 {
            return usage!("the chart is too small for its words; give a larger --width and --height");
        }
        Ok(Axes { frame, x, y, second })
    }

    /// Something lies within the axes.
    fn check_seen(&self, axes: &Axes) -> Result<()> {
        let shows = |line: Vec<Point>| line.iter().any(|p| axes.frame.holds(*p)) || !axes.frame.parts(&line).is_empty();
        if self.chart.series.iter().any(|s| shows(placed(s, axes))) || !self.bar_shapes(axes).is_empty() {
            return Ok(());
        }
        let x = span(self.chart.series.iter().flat_map(|s| s.points.iter().map(|p| p.0)));
        let (a, b) = axes.x.range;
        invalid!("nothing to draw within the axes: they show {a} to {b} across, the curves lie at {} to {}", x.0, x.1)
    }

    /// What the data span across.
    fn x_range(&self) -> (f64, f64) {
        let points = self.chart.series.iter().flat_map(|s| s.points.iter().map(|p| p.0));
        let bars = self.chart.bars.iter().flat_map(|b| b.list.iter().flat_map(|b| [b.0, b.1]));
        let (scale, marks) = (self.chart.x.scale, self.chart.series.iter().any(|s| s.marks));
        let range = widened(scale, span(points.chain(bars)));
        match scale {
            Scale::Log if marks => aired(scale, rounded(scale, range, 6), range),
            Scale::Log => rounded(scale, range, 6),
            Scale::Linear if marks => aired(scale, rounded(scale, with_zero(range), 6), range),
            Scale::Linear => range,
        }
    }

    /// What the curves and the bars span upward where they are seen; bars without an axis of their own count as curves.
    fn y_ranges(&self, x: (f64, f64), count: usize) -> ((f64, f64), Option<(f64, f64)>) {
        let (chart, scale) = (self.chart, self.chart.y.scale);
        let mut curves: Vec<f64> = chart.series.iter().flat_map(|s| heights_seen(s, x)).collect();
        let tops = chart.bars.iter().flat_map(|b| b.list.iter().filter(|b| b.1 > x.0 && b.0 < x.1).map(|b| b.2));
        let bars = (0.0, tops.fold(0.0, f64::max));
        if chart.second.is_none() && chart.bars.is_some() {
            curves.extend([bars.0, bars.1]);
        }
        if curves.is_empty() {
            curves = if scale == Scale::Log { vec![0.1, 1.0] } else { vec![0.0, 1.0] };
        }
        let range = widened(scale, span(curves.into_iter()));
        let whole = if scale == Scale::Linear { with_zero(range) } else { range };
        let shown = aired(scale, rounded(scale, whole, count), range);
        // Room above the bars, so that a curve is seen over them.
        let bars = (0.0, if bars.1 > 0.0 { bars.1 * 1.05 } else { 1.0 });
        (shown, chart.second.as_ref().map(|_| rounded(Scale::Linear, bars, count)))
    }

    fn legend(&self, frame: &Frame) -> Legend {
        let curves = self.chart.series.iter().enumerate().map(|(i, s)| (s.name.clone(), Sign::Curve(i, s.marks)));
        let bars = self.chart.bars.iter().map(|b| (b.name.clone(), Sign::Bars));
        Legend::new(curves.chain(bars).collect(), &self.font, 0.93 * FONT * self.s, 0.9 * frame.width())
    }

    /// What a legend must not cover.
    fn obstacles(&self, axes: &Axes) -> Vec<Vec<Point>> {
        let curves = self.chart.series.iter().map(|s| placed(s, axes));
        curves.chain(self.bar_shapes(axes)).collect()
    }

    /// The corners of each bar within the frame, from the lower left one upward and round.
    fn bar_shapes(&self, axes: &Axes) -> Vec<Vec<Point>> {
        let (f, ruler) = (axes.frame, axes.second.as_ref().unwrap_or(&axes.y));
        let shape = |(from, to, height): &Bar| {
            let across = |v: f64| axes.x.place(v).clamp(f.left, f.right);
            let up = |v: f64| ruler.place(v).clamp(f.top, f.bottom);
            let (left, right, top, bottom) = (across(*from), across(*to), up(*height), up(0.0));
            let seen = right > left && bottom > top;
            seen.then(|| vec![(left, bottom), (left, top), (right, top), (right, bottom)])
        };
        self.chart.bars.iter().flat_map(|b| b.list.iter().filter_map(shape)).collect()
    }

    fn draw_data(&self, sheet: &mut Sheet, axes: &Axes, pens: &Pens) {
        let f = axes.frame;
        for points in joined(self.bar_shapes(axes)) {
            sheet.add("bars", Shape::Area { points, colour: BARS });
        }
        for tick in axes.x.ticks(self.across(axes)).iter().filter(|t| t.label.is_some()) {
            let x = axes.x.place(tick.value);
            sheet.line("grid", (x, f.top), (x, f.bottom), GRID, self.s.max(1.0) * 0.8);
        }
        for tick in axes.y.ticks(self.up(axes)).iter().filter(|t| t.label.is_some()) {
            let y = axes.y.place(tick.value);
            sheet.line("grid", (f.left, y), (f.right, y), GRID, self.s.max(1.0) * 0.8);
        }
        for (i, series) in self.chart.series.iter().enumerate() {
            let line = placed(series, axes);
            for part in f.parts(&line) {
                sheet.add("series", pens.line(i, part));
            }
            if series.marks || line.len() == 1 {
                for at in line.into_iter().filter(|p| f.holds(*p)) {
                    sheet.add("series", pens.mark(i, at));
                }
            }
        }
    }

    fn up(&self, axes: &Axes) -> usize {
        (axes.frame.height() / (42.0 * self.s)).max(2.0) as usize
    }

    /// As many numbers across as have room beside one another.
    fn across(&self, axes: &Axes) -> usize {
        let size = FONT * self.s;
        let most = (axes.frame.width() / (48.0 * self.s)).max(2.0) as usize;
        let fits = |count: &usize| {
            let mut end = f64::NEG_INFINITY;
            axes.x.ticks(*count).iter().filter_map(|t| t.label.as_ref().map(|l| (t.value, l))).all(|(value, label)| {
                let (middle, half) = (axes.x.place(value), 0.5 * self.font.width(label, size));
                let free = middle - half > end;
                end = middle + half + 0.8 * size;
                free
            })
        };
        (2..=most).rev().find(fits).unwrap_or(2)
    }

    fn draw_axes(&self, sheet: &mut Sheet, axes: &Axes) {
        let (f, s) = (axes.frame, self.s);
        let (size, thin) = (FONT * s, s.max(1.0));
        let corners = vec![(f.left, f.top), (f.right, f.top), (f.right, f.bottom), (f.left, f.bottom), (f.left, f.top)];
        let x_ticks = axes.x.ticks(self.across(axes));
        for tick in &x_ticks {
            let (x, long) = (axes.x.place(tick.value), tick_length(tick, s));
            sheet.line("axis", (x, f.bottom), (x, f.bottom - long), INK, thin);
            self.word(sheet, "x-tick", (x, f.bottom + 1.25 * size), Anchor::Middle, tick.label.as_deref());
        }
        for (ruler, edge, inward, anchor, class) in [
            (Some(&axes.y), f.left, 1.0, Anchor::End, "y-tick"),
            (axes.second.as_ref(), f.right, -1.0, Anchor::Start, "second-tick"),
        ] {
            for tick in ruler.iter().flat_map(|r| r.ticks(self.up(axes))) {
                let (y, long) = (ruler.map_or(0.0, |r| r.place(tick.value)), tick_length(&tick, s));
                sheet.line("axis", (edge, y), (edge + inward * long, y), INK, thin);
                let at = (edge - inward * 7.0 * s, y + 0.36 * size);
                self.word(sheet, class, at, anchor, tick.label.as_deref());
            }
        }
        sheet.add("axis", Shape::Line { points: corners, colour: INK, width: thin, dash: Vec::new() });
        let (middle, centre) = ((f.left + f.right) / 2.0, (f.top + f.bottom) / 2.0);
        let label = self.font.shortened(&self.chart.x.label, size, self.size.0 * 0.96);
        self.word(sheet, "label", (middle, self.size.1 - 0.75 * size), Anchor::Middle, Some(&label));
        let mut beside = |x: f64, text: &str| {
            let text = self.font.shortened(text, size, self.size.1 * 0.96);
            let half = 0.5 * self.font.width(&text, size);
            let at = (x, centre.clamp(half + 2.0, (self.size.1 - half - 2.0).max(half + 2.0)));
            sheet.add("label", Shape::Text { at, anchor: Anchor::Middle, size, upward: true, colour: INK, text });
        };
        beside(1.25 * size, &self.chart.y.label);
        if let Some(axis) = &self.chart.second {
            beside(self.size.0 - 0.6 * size, &axis.label);
        }
        if let Some(title) = &self.chart.title {
            let size = TITLE * s;
            let text = self.font.shortened(title, size, self.size.0 * 0.96);
            let half = 0.5 * self.font.width(&text, size);
            let x = middle.min(self.size.0 - half - 4.0 * s).max(half + 4.0 * s);
            let at = (x, 1.35 * size);
            sheet.add("title", Shape::Text { at, anchor: Anchor::Middle, size, upward: false, colour: INK, text });
        }
    }

    fn word(&self, sheet: &mut Sheet, class: &'static str, at: Point, anchor: Anchor, text: Option<&str>) {
        if let Some(text) = text.filter(|t| !t.is_empty()) {
            let (size, text) = (FONT * self.s, text.to_string());
            sheet.add(class, Shape::Text { at, anchor, size, upward: false, colour: INK, text });
        }
    }
}

fn tick_length(tick: &Tick, s: f64) -> f64 {
    if tick.label.is_some() { 6.0 * s } else { 3.0 * s }
}

/// The range that was asked for, or the data's.
fn settled(axis: &Axis, name: &str, data: (f64, f64)) -> Result<(f64, f64)> {
    let range = axis.range.unwrap_or(data);
    let (a, b) = range;
    if axis.scale == Scale::Log && a.min(b) <= 0.0 {
        return usage!("the range {a}:{b} of the {name} axis must be above 0: it is logarithmic");
    }
    // What floats cannot divide has no ticks.
    if !(axis.scale.takes(a) && axis.scale.takes(b) && b - a > 1e-12 * a.abs().max(b.abs())) {
        return usage!("the range {a:e}:{b:e} of the {name} axis is too narrow, or beyond 1e100");
    }
    Ok(range)
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
}

/// The range from zero, where that does not flatten what is in it.
fn with_zero(range: (f64, f64)) -> (f64, f64) {
    let (a, b) = range;
    if a > 0.0 && a < 0.5 * b {
        (0.0, b)
    } else if b < 0.0 && b > 0.5 * a {
        (a, 0.0)
    } else {
        range
    }
}

/// Values of a curve between two ends of x, and at the ends where it goes on beyond them.
fn heights_seen(series: &Series, x: (f64, f64)) -> Vec<f64> {
    let within = |p: &&(f64, f64)| p.0 >= x.0 && p.0 <= x.1;
    let mut heights: Vec<f64> = series.points.iter().filter(within).map(|p| p.1).collect();
    for (a, b) in series.points.iter().zip(series.points.iter().skip(1)) {
        for end in [x.0, x.1].into_iter().filter(|e| (a.0 - e) * (b.0 - e) < 0.0) {
            heights.push(a.1 + (b.1 - a.1) * (end - a.0) / (b.0 - a.0));
        }
    }
    heights
}

fn placed(series: &Series, axes: &Axes) -> Vec<Point> {
    series.points.iter().map(|p| (axes.x.place(p.0), axes.y.place(p.1))).collect()
}

/// Bars that touch as one shape: no seams.
fn joined(bars: Vec<Vec<Point>>) -> Vec<Vec<Point>> {
    let mut all: Vec<Vec<Point>> = Vec::new();
    for bar in bars {
        match all.last_mut() {
            Some(last) if last.last().is_some_and(|p| (p.0 - bar[0].0).abs() < 0.01) => {
                last.pop();
                last.extend(&bar[1..]);
            }
            _ => all.push(bar),
        }
    }
    all
}
