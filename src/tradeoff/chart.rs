//! Charts of error against time.

use crate::Result;
use crate::plot::{Axis, Chart, Scale, Series, Sheet};
use crate::tradeoff::table::{Kind, Row};

/// Of a row, what goes up.
type Error = fn(&Row) -> f64;

/// Charts of a scene: name for its file, words above it, what goes up.
pub const CHARTS: [(&str, Kind, &str, Error); 3] = [
    ("luminance", Kind::Method, "relative error of Y, root mean square (%)", |r| 100.0 * r.relative_rmse),
    ("colour", Kind::Method, "Delta E 2000, root mean square", |r| r.delta_e[0]),
    ("plans", Kind::Plan, "Delta E 2000 against full bands on the same paths, root mean square", |r| r.delta_e[0]),
];

/// Names and points in the order of the rows.
fn series(rows: &[&Row], error: Error) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for row in rows {
        let point = (row.seconds, error(row));
        match all.iter_mut().find(|s| s.name == row.name) {
            Some(own) => own.points.push(point),
            None => all.push(Series { name: row.name.clone(), points: vec![point], marks: true }),
        }
    }
    all
}

/// Those that nothing beats in both time and error, from the fastest on.
///
/// ```
/// use luxpipe::tradeoff::frontier;
/// assert_eq!(frontier(&[(1.0, 5.0), (2.0, 6.0), (3.0, 1.0)]), [(1.0, 5.0), (3.0, 1.0)]);
/// ```
pub fn frontier(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0 > 0.0 && p.1 > 0.0).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    sorted.retain(|p| {
        let better = p.1 < best;
        best = best.min(p.1);
        better
    });
    sorted
}

/// One of [`CHARTS`]; `None` where there is nothing to draw.
pub fn draw(rows: &[Row], title: &str, (_, kind, label, error): (&str, Kind, &str, Error)) -> Result<Option<Sheet>> {
    let own: Vec<&Row> = rows.iter().filter(|r| r.kind == kind && r.is_measured() && error(r) > 0.0).collect();
    let mut series = series(&own, error);
    let points: Vec<(f64, f64)> = own.iter().map(|r| (r.seconds, error(r))).collect();
    if points.is_empty() {
        return Ok(None);
    }
    series.push(Series { name: "frontier".into(), points: frontier(&points), marks: false });
    if let Some(reference) = rows.iter().find(|r| r.kind == Kind::Reference && kind == Kind::Method) {
        // Nothing below it can be told.
        let ends = points.iter().fold((f64::INFINITY, 0f64), |e, p| (e.0.min(p.0), e.1.max(p.0)));
        let level = error(reference);
        let name = "standard error of the reference".into();
        series.push(Series { name, points: vec![(ends.0, level), (ends.1, level)], marks: false });
    }
    let axis = |label: &str| Axis { label: label.into(), scale: Scale::Log, range: None };
    let chart = Chart { title: Some(title.into()), x: axis("seconds"), y: axis(label), series, ..Chart::default() };
    chart.draw(760, 560).map(|drawn| Some(drawn.0))
}
