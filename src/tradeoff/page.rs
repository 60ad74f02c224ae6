//! One page of HTML with all charts, tables and pictures in it: it opens from disk and asks nothing of any server.

use std::fmt::Write as _;

use crate::base64;
use crate::tradeoff::filters::Table;
use crate::tradeoff::picture::MOST_DELTA_E;
use crate::tradeoff::table::{Kind, Row};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A scene on the page.
pub struct Section {
    /// Name of the scene.
    pub name: String,
    /// What its file says of it.
    pub about: String,
    /// Charts as SVG.
    pub charts: Vec<String>,
    /// All runs.
    pub rows: Vec<Row>,
}

/// The page's text. `head` says how it was made.
pub fn page(head: &str, sections: &[Section], tables: &[Table]) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Error against time</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>Error against time</h1>\n<p>{}</p>\n<nav>",
        escaped(head)
    );
    for section in sections {
        let name = escaped(&section.name);
        let _ = write!(text, "<a href=\"#{name}\">{name}</a> ");
    }
    if !tables.is_empty() {
        text += "<a href=\"#filters\">filters</a> ";
    }
    text += "<button id=\"toggle\" type=\"button\">Show error maps</button></nav>\n";
    let _ = writeln!(
        text,
        "<p>A method's error is against the mean of independent renders by path tracing, noise and all; below the level \
         that is that mean's own standard error nothing can be told. A plan's error is against full bands on the same paths, so that noise \
         cancels. Error maps run from black (0) over red to white ({MOST_DELTA_E} Delta E 2000 and more). Click a column's head to sort.</p>"
    );
    sections.iter().for_each(|s| section(&mut text, s));
    if !tables.is_empty() {
        text += "<h2 id=\"filters\">After the renderer</h2>\n";
    }
    for table in tables {
        let _ = write!(text, "<h3>{}</h3>\n<p>{}</p>\n", escaped(table.title), escaped(&table.about));
        grid(&mut text, table.columns, table.rows.iter().map(|r| r.iter().map(|c| escaped(c)).collect()));
    }
    let _ = write!(text, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    text
}

fn section(text: &mut String, s: &Section) {
    let name = escaped(&s.name);
    let _ = write!(text, "<h2 id=\"{name}\">{name}</h2>\n<p>{}</p>\n<div class=\"charts\">\n", escaped(&s.about));
    s.charts.iter().for_each(|c| text.push_str(c));
    text.push_str("</div>\n<div class=\"pictures\">\n");
    for row in &s.rows {
        let Some([plain, map]) = &row.shown else { continue };
        let label = match row.kind {
            Kind::Reference => "reference".to_string(),
            Kind::Method => format!("{}, {:.2} s", row.name, row.seconds),
            Kind::Plan => carried(&row.name),
        };
        let label = escaped(&label);
        let _ = write!(text, "<figure>");
        for (class, png) in [("plain", plain), ("map", map)] {
            let _ = write!(
                text,
                "<img class=\"{class}\" alt=\"{name} by {label}\" loading=\"lazy\" src=\"data:image/png;base64,{}\">",
                base64::encoded(png)
            );
        }
        let _ = writeln!(text, "<figcaption>{label}: Delta E {}</figcaption></figure>", short(row.delta_e[0]));
    }
    text.push_str("</div>\n");
    let columns = [
        "about",
        "name",
        "setting",
        "time, s",
        "of it planning",
        "Y rms, %",
        "Delta E rms",
        "95 %",
        "memory, MB",
        "note",
    ];
    let row = |r: &Row| {
        vec![
            r.kind.name().into(),
            escaped(&r.name),
            escaped(&r.setting),
            short(r.seconds),
            short(r.planning_s),
            short(100.0 * r.relative_rmse),
            short(r.delta_e[0]),
            short(r.delta_e[1]),
            r.peak_mb.map_or(String::new(), |m| format!("{m:.0}")),
            escaped(&r.note),
        ]
    };
    grid(text, &columns, s.rows.iter().map(row));
}

/// A table of cells that are HTML already.
fn grid(text: &mut String, columns: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let class = |cell: &str, column: &str| match column {
        "name" => " class=\"words\"",
        _ if cell.starts_with(|c: char| c.is_ascii_digit()) => "",
        _ => " class=\"words\"",
    };
    text.push_str("<div class=\"wide\"><table>\n<thead><tr>");
    columns.iter().for_each(|c| *text += &format!("<th>{}</th>", escaped(c)));
    text.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        text.push_str("<tr>");
        for (cell, column) in row.iter().zip(columns) {
            *text += &match *column {
                "note" => format!("<td class=\"words note\" title=\"{cell}\">{cell}</td>"),
                column => format!("<td{}>{cell}</td>", class(cell, column)),
            };
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table></div>\n");
}

/// What paths carry, in words.
fn carried(plan: &str) -> String {
    match (plan.parse::<usize>(), plan.strip_prefix("bands")) {
        (Ok(_), _) => format!("{plan} wavelengths"),
        (_, Some(count)) => format!("{count} bands"),
        _ if plan == "specplan" => "specplan's choice".into(),
        _ => format!("{plan} colours"),
    }
}

/// Three digits; nothing of what is no number.
fn short(x: f64) -> String {
    match x {
        x if !x.is_finite() => String::new(),
        x if x.abs() >= 100.0 => format!("{x:.0}"),
        x if x.abs() >= 1.0 => format!("{x:.2}"),
        0.0 => "0".into(),
        x => format!("{x:.4}"),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
