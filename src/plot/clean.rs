//! What of a chart's data can be drawn.

use crate::error::printable;
use crate::plot::{Bar, Chart, Scale};
use crate::{Result, invalid};

/// The chart with what can be drawn, and remarks on the rest. A chart with nothing left is an error.
pub fn clean(chart: &Chart) -> Result<(Chart, Vec<String>)> {
    let mut chart = chart.clone();
    let mut remarks = Vec::new();
    let (x, y) = (chart.x.scale, chart.y.scale);
    for s in &mut chart.series {
        let fits = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let (before, name) = (s.points.len(), printable(s.name.as_bytes()));
        s.points.retain(fits);
        remark(&mut remarks, before - s.points.len(), &name, "that are not finite");
        let before = s.points.len();
        s.points.retain(|p| x.takes(p.0) && y.takes(p.1));
        remark(&mut remarks, before - s.points.len(), &name, "that the axes cannot show");
    }
    chart.series.retain(|s| !s.points.is_empty());
    if let Some(bars) = &mut chart.bars {
        let before = bars.list.len();
        let height = chart.second.as_ref().map_or(y, |a| a.scale);
        if height == Scale::Log {
            return invalid!("bars stand on zero, which a logarithmic axis does not have");
        }
        let fits = |b: &Bar| {
            [b.0, b.1, b.2].iter().all(|v| v.is_finite()) && b.0 < b.1 && b.2 >= 0.0 && Scale::Linear.takes(b.2)
        };
        bars.list.retain(|b| fits(b) && x.takes(b.0) && x.takes(b.1));
        remark(&mut remarks, before - bars.list.len(), &printable(bars.name.as_bytes()), "that cannot be bars");
    }
    let empty = chart.bars.as_ref().is_none_or(|b| b.list.is_empty());
    if chart.series.is_empty() && empty {
        let why = if remarks.is_empty() { String::new() } else { format!(": {}", remarks.join("; ")) };
        return invalid!("nothing to draw{why}");
    }
    Ok((chart, remarks))
}

fn remark(remarks: &mut Vec<String>, count: usize, name: &str, what: &str) {
    if count > 0 {
        let of = if name.is_empty() { String::new() } else { format!("{name}: ") };
        remarks.push(format!("{of}left out {count} points {what}"));
    }
}
