//! A sheet as SVG: real text, no script, no style sheet.

use std::fmt::Write as _;

use crate::plot::sheet::{Anchor, Colour, Point, Shape, Sheet};

impl Sheet {
    /// The sheet as an SVG file's text.
    pub fn svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"DejaVu Sans, Verdana, sans-serif\">\n"
        );
        if !self.title.is_empty() {
            let _ = writeln!(text, "<title>{}</title>", escape(&self.title));
        }
        let _ = writeln!(text, "<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
        for (class, shape) in &self.shapes {
            let _ = writeln!(text, "{}", element(class, shape));
        }
        text + "</svg>\n"
    }
}

fn element(class: &str, shape: &Shape) -> String {
    match shape {
        Shape::Line { points, colour, width, dash } => {
            let list: Vec<String> = dash.iter().map(|d| short(*d)).collect();
            let dashes =
                if list.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{}\"", list.join(" ")) };
            format!(
                "<polyline class=\"{class}\" points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dashes}/>",
                places(points),
                hex(*colour),
                short(*width)
            )
        }
        Shape::Area { points, colour } => {
            format!("<polygon class=\"{class}\" points=\"{}\" fill=\"{}\"/>", places(points), hex(*colour))
        }
        Shape::Disc { at, radius, colour } => format!(
            "<circle class=\"{class}\" cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>",
            short(at.0),
            short(at.1),
            short(*radius),
            hex(*colour)
        ),
        Shape::Text { at, anchor, size, upward, colour, text } => {
            let (x, y) = (short(at.0), short(at.1));
            let turn = if *upward { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            format!(
                "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{turn}>{}</text>",
                short(*size),
                hex(*colour),
                escape(text)
            )
        }
    }
}

fn places(points: &[Point]) -> String {
    points.iter().map(|p| format!("{},{}", short(p.0), short(p.1))).collect::<Vec<_>>().join(" ")
}

/// Hundredths of a pixel, without zeros at the end.
fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn hex(colour: Colour) -> String {
    let [r, g, b] = colour;
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text as XML has it; characters that XML does not have become U+FFFD.
fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
