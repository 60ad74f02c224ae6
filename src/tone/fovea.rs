//! What the fovea sees at once: averages over one degree of the view [Ward 1997].

use crate::stream::{Block, Header};
use crate::tone::Histogram;

/// Radiance's assumption where a picture does not say how it was seen: 40 degrees on the long side.
const DEFAULT_DEGREES: f64 = 40.0;
/// Views up to this wide are taken as details, not as what an eye saw.
const NARROWEST_DEGREES: f64 = 5.0;

/// Foveal cells of a picture: about one degree each.
pub struct Fovea {
    columns: usize,
    rows: usize,
    sums: Vec<[f64; 2]>,
    every: Histogram,
    row: usize,
    /// For each place along a scanline the cell's column (or row), so that no pixel divides.
    along: Vec<u32>,
    scanlines: usize,
    by_rows: bool,
}

/// Number of cells along width and height.
///
/// `-vt` names the projection, `-vh` and `-vv` the angles in degrees; other options of the line do not matter here.
/// Returns also whether the view had to be assumed.
pub fn cells(header: &Header) -> (usize, usize, bool) {
    let (width, height) = (header.resolution.width as f64, header.resolution.height as f64);
    let view = header.variable("VIEW").and_then(|v| std::str::from_utf8(v).ok()).and_then(angular_size);
    let (across, down, assumed) = match view {
        Some((a, d)) => (a, d, false),
        None => {
            let long = 2.0 * (DEFAULT_DEGREES / 2.0).to_radians().tan() / 1f64.to_radians();
            (long * width / width.max(height), long * height / width.max(height), true)
        }
    };
    let whole = |n: f64, pixels: usize| ((n + 0.5) as usize).clamp(2, pixels.max(2)).min(pixels);
    (whole(across, header.resolution.width), whole(down, header.resolution.height), assumed)
}

/// Extent of a view's image plane in units of one degree at its centre; `None` for parallel and narrow views.
fn angular_size(view: &str) -> Option<(f64, f64)> {
    let words: Vec<&str> = view.split_ascii_whitespace().collect();
    let kind = words.iter().rev().find_map(|w| w.strip_prefix("-vt")).unwrap_or("v");
    let number = |key: &str| words.windows(2).rev().find(|w| w[0] == key).and_then(|w| w[1].parse::<f64>().ok());
    let (h, v) = (number("-vh").unwrap_or(45.0), number("-vv").unwrap_or(45.0));
    if !(h > NARROWEST_DEGREES && v > 0.0 && h <= 360.0 && v <= 360.0) {
        return None;
    }
    let tangent = |degrees: f64| (degrees < 180.0).then(|| 2.0 * (degrees / 2.0).to_radians().tan().to_degrees());
    let sine = |degrees: f64| (degrees <= 180.0).then(|| 2.0 * (degrees / 2.0).to_radians().sin().to_degrees());
    let stereographic = |degrees: f64| 4.0 * (degrees / 4.0).to_radians().tan().to_degrees();
    match kind {
        "v" => Some((tangent(h)?, tangent(v)?)),
        "c" => Some((h, tangent(v)?)),
        "a" => Some((h, v)),
        "h" => Some((sine(h)?, sine(v)?)),
        "s" if h < 360.0 && v < 360.0 => Some((stereographic(h), stereographic(v))),
        _ => None,
    }
}

impl Fovea {
    /// Empty cells for a picture.
    pub fn new(header: &Header) -> Fovea {
        let (columns, rows, _) = cells(header);
        let r = header.resolution;
        let (len, n) = if r.by_rows { (r.width, columns) } else { (r.height, rows) };
        Fovea {
            columns,
            rows,
            sums: vec![[0.0; 2]; columns * rows],
            every: Histogram::default(),
            row: 0,
            along: (0..len).map(|i| (i * n / len) as u32).collect(),
            scanlines: r.scanlines(),
            by_rows: r.by_rows,
        }
    }

    /// Takes in scanlines of XYZ. Mirrored orders give mirrored cells, which weigh the same.
    pub fn add(&mut self, block: &Block) {
        let len = self.along.len();
        for line in block.data.chunks_exact(3 * len) {
            let (step, start) = if self.by_rows {
                (1, self.row * self.rows / self.scanlines * self.columns)
            } else {
                (self.columns, self.row * self.columns / self.scanlines)
            };
            for (pixel, along) in line.chunks_exact(3).zip(&self.along) {
                let y = pixel[1];
                if y > 0.0 && y.is_finite() {
                    let cell = &mut self.sums[start + *along as usize * step];
                    cell[0] += f64::from(y);
                    self.every.add(y, 1.0);
                }
                self.sums[start + *along as usize * step][1] += 1.0;
            }
            self.row += 1;
        }
    }

    /// Half the weight to the foveal averages, half to the pixels themselves (the original takes random ones), so that small
    /// bright and dark things count too.
    pub fn histogram(&self) -> Histogram {
        let mut foveal = Histogram::default();
        for [sum, count] in &self.sums {
            if *count > 0.0 {
                foveal.add((sum / count) as f32, 1.0);
            }
        }
        let mut all = Histogram::default();
        for part in [&foveal, &self.every] {
            if part.total() > 0.0 {
                all.merge(part, 0.5 / part.total());
            }
        }
        all
    }
}
