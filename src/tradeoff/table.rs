//! Rows of what was measured, and as CSV.

use std::fmt::Write as _;

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What all is compared with; its errors are its own standard errors.
    Reference,
    /// A method against the reference, noise and all.
    Method,
    /// What paths carry, against full bands on the same paths.
    Plan,
}

impl Kind {
    /// As the table has it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Reference => "reference",
            Kind::Method => "method",
            Kind::Plan => "plan",
        }
    }
}

/// A run.
#[derive(Clone, Debug)]
pub struct Row {
    /// The scene file's name without suffix.
    pub scene: String,
    /// What it is about.
    pub kind: Kind,
    /// Method or plan.
    pub name: String,
    /// Options, or the paths a pixel.
    pub setting: String,
    /// Wall clock, planning included.
    pub seconds: f64,
    /// Of them, planning.
    pub planning_s: f64,
    /// Root of the relative mean square error of Y.
    pub relative_rmse: f64,
    /// Root of the mean square of Delta E 2000, and what 95 % of pixels stay below.
    pub delta_e: [f64; 2],
    /// Largest resident size.
    pub peak_mb: Option<f64>,
    /// What the program said, or why there is nothing.
    pub note: String,
    /// Picture and error map, as PNG.
    pub shown: Option<[Vec<u8>; 2]>,
}

impl Row {
    /// There is a picture with errors.
    pub fn is_measured(&self) -> bool {
        self.seconds.is_finite()
    }
}

/// The columns of [`csv`].
pub const COLUMNS: &str =
    "scene,kind,name,setting,seconds,planning_s,relative_rmse_y_percent,delta_e_rms,delta_e_95,peak_mb,note";

/// All rows.
pub fn csv(rows: &[Row]) -> String {
    let mut text = format!("{COLUMNS}\n");
    for r in rows {
        let number = |x: f64| if x.is_finite() { format!("{x:.5}") } else { String::new() };
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{}",
            plain(&r.scene),
            r.kind.name(),
            plain(&r.name),
            plain(&r.setting),
            number(r.seconds),
            number(r.planning_s),
            number(100.0 * r.relative_rmse),
            number(r.delta_e[0]),
            number(r.delta_e[1]),
            r.peak_mb.map_or(String::new(), |m| format!("{m:.1}")),
            plain(&r.note)
        );
    }
    text
}

/// Text without what parts columns and lines.
fn plain(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c == ',' {
                ';'
            } else if c.is_control() || c == '"' {
                ' '
            } else {
                c
            }
        })
        .collect()
}
