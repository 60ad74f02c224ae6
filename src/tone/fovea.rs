//! What the fovea sees at once: a picture in cells of about one degree of the view [Ward 1997].

use std::ops::Range;
use std::sync::Arc;

use crate::simd;
use crate::statistics::scrambled;
use crate::stream::{Header, Resolution};
use crate::tone::Histogram;
use crate::view::View;

/// How a picture lies in cells of about a degree, columns left to right, rows bottom to top, whatever its scan order.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Cells across.
    pub columns: usize,
    /// Cells from bottom to top.
    pub rows: usize,
    /// How the picture was seen.
    pub view: View,
    resolution: Resolution,
}

impl Cells {
    /// For the view a header states, or the one Radiance assumes; the second value says that it was assumed.
    pub fn of(header: &Header) -> (Arc<Cells>, bool) {
        let r = header.resolution;
        let stated = View::of(header);
        let view = stated.unwrap_or_else(|| View::assumed(r.width, r.height));
        let (width, height) = view.extent();
        let whole = |radians: f64, pixels: usize| {
            ((radians / 1f64.to_radians() + 0.5) as usize).clamp(2, pixels.max(2)).min(pixels)
        };
        let cells = Cells { columns: whole(width, r.width), rows: whole(height, r.height), view, resolution: r };
        (Arc::new(cells), stated.is_none())
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Middle of a cell in the picture, u and v from 0 to 1.
    pub fn middle(&self, cell: usize) -> (f64, f64) {
        let (column, row) = (cell % self.columns, cell / self.columns);
        ((column as f64 + 0.5) / self.columns as f64, (row as f64 + 0.5) / self.rows as f64)
    }

    /// Unit direction of a cell's middle; `None` outside a fisheye's circle.
    pub fn direction(&self, cell: usize) -> Option<[f64; 3]> {
        let (u, v) = self.middle(cell);
        self.view.direction(u, v)
    }

    /// Solid angle of a cell, sr.
    pub fn solid_angle_sr(&self, cell: usize) -> f64 {
        let (u, v) = self.middle(cell);
        self.view.solid_angle_sr(u, v, 1.0 / self.columns as f64, 1.0 / self.rows as f64)
    }

    /// The cell of a pixel of the upright picture that counts from the lower left.
    pub fn at(&self, x: usize, y: usize) -> usize {
        let r = self.resolution;
        let part = |i: usize, n: usize, of: usize| (i * n / of).min(n - 1);
        part(y, self.rows, r.height) * self.columns + part(x, self.columns, r.width)
    }

    /// Pixels a degree at a cell.
    pub fn pixels_a_degree(&self, cell: usize) -> f64 {
        let r = self.resolution;
        let (u, v) = self.middle(cell);
        let pixel_sr = self.view.solid_angle_sr(u, v, 1.0 / r.width as f64, 1.0 / r.height as f64);
        if pixel_sr > 0.0 { 1f64.to_radians() / pixel_sr.sqrt() } else { 0.0 }
    }

    /// Middle, in pixels from the lower left along one axis, of the i-th pixel or scanline as stored.
    fn place(&self, i: usize, along_x: bool) -> usize {
        let r = self.resolution;
        match along_x {
            true if r.from_right => r.width - 1 - i,
            true => i,
            false if r.from_bottom => i,
            false => r.height - 1 - i,
        }
    }

    /// For each pixel of a scanline the step from the scanline's first cell, and the step from one scanline of cells to the next.
    fn along(&self) -> Vec<u32> {
        let r = self.resolution;
        let cell = |i: usize| {
            let p = self.place(i, r.by_rows);
            if r.by_rows { p * self.columns / r.width } else { p * self.rows / r.height * self.columns }
        };
        (0..r.scanline_len()).map(|i| cell(i) as u32).collect()
    }

    /// First cell of a scanline.
    fn first(&self, scanline: usize) -> usize {
        let r = self.resolution;
        let p = self.place(scanline, !r.by_rows);
        if r.by_rows { p * self.rows / r.height * self.columns } else { p * self.columns / r.width }
    }
}

/// Pixels of a scanline that lie in one cell, or between the middles of the same two, and the step to the (first) cell.
pub type Run = (Range<usize>, usize);

/// The runs of like cells.
fn runs(cells: impl Iterator<Item = u32>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (i, cell) in cells.map(|c| c as usize).enumerate() {
        match runs.last_mut() {
            Some(run) if run.1 == cell => run.0.end = i + 1,
            _ => runs.push((i..i + 1, cell)),
        }
    }
    runs
}

/// Values at the middles of cells, and between them.
#[derive(Clone, Debug)]
pub struct Field<const N: usize> {
    cells: Arc<Cells>,
    values: Vec<[f32; N]>,
    /// Pixels of a scanline between the same two cells, and each one's share of the way from the first to the second.
    runs: Vec<Run>,
    shares: Vec<f32>,
}

/// Index and fraction between the middles of n cells of the pixel p of `of`.
fn between(p: usize, n: usize, of: usize) -> (u32, f32) {
    let x = ((p as f64 + 0.5) * n as f64 / of as f64 - 0.5).clamp(0.0, n as f64 - 1.0);
    let i = (x as usize).min(n.saturating_sub(2));
    (i as u32, (x - i as f64) as f32)
}

impl<const N: usize> Field<N> {
    /// From a value a cell.
    pub fn new(cells: Arc<Cells>, values: Vec<[f32; N]>) -> Field<N> {
        let r = cells.resolution;
        let (n, of) = if r.by_rows { (cells.columns, r.width) } else { (cells.rows, r.height) };
        let places = (0..r.scanline_len()).map(|i| between(cells.place(i, r.by_rows), n, of));
        let (runs, shares) = (runs(places.clone().map(|p| p.0)), places.map(|p| p.1).collect());
        Field { cells, values, runs, shares }
    }

    /// The values along a scanline as stored, one for each column (or row) of cells.
    pub fn scanline(&self, scanline: usize) -> Vec<[f32; N]> {
        let (c, r) = (&self.cells, self.cells.resolution);
        let (n, of, len) = if r.by_rows { (c.rows, r.height, c.columns) } else { (c.columns, r.width, c.rows) };
        let (i, t) = between(c.place(scanline, !r.by_rows), n, of);
        let cell = |line: usize, k: usize| if r.by_rows { line * c.columns + k } else { k * c.columns + line };
        let next = (i as usize + 1).min(n - 1);
        let mix = |k: usize| {
            let (a, b) = (&self.values[cell(i as usize, k)], &self.values[cell(next, k)]);
            std::array::from_fn(|j| a[j] + t * (b[j] - a[j]))
        };
        (0..len).map(mix).collect()
    }

    /// The runs of pixels along a scanline between two of the values that [`Field::scanline`] gave, with the first of these, how
    /// far the second is from it, and the pixels' shares of the way.
    #[inline(always)]
    pub fn along<'a>(&'a self, line: &'a [[f32; N]]) -> impl Iterator<Item = Stretch<'a, N>> {
        self.runs.iter().map(move |(pixels, i)| {
            let (a, b) = (line[*i], line[(i + 1).min(line.len() - 1)]);
            let step = std::array::from_fn(|j| b[j] - a[j]);
            Stretch { pixels: pixels.clone(), start: a, step, shares: &self.shares[pixels.clone()] }
        })
    }
}

/// Pixels of a scanline over which a [`Field`] is linear: at each `start` and its share of `step`.
pub struct Stretch<'a, const N: usize> {
    /// Their places in the scanline.
    pub pixels: Range<usize>,
    /// The value at a share of 0.
    pub start: [f32; N],
    /// What a share of 1 adds.
    pub step: [f32; N],
    /// A share for each pixel.
    pub shares: &'a [f32],
}

/// Means over the cells of a picture of N components; infinities and NaN count as 0.
#[derive(Clone, Debug)]
pub struct Means<const N: usize> {
    cells: Arc<Cells>,
    runs: Vec<Run>,
    sums: Vec<[f64; N]>,
    counts: Vec<u32>,
    row: usize,
}

impl<const N: usize> Means<N> {
    /// Nothing yet.
    pub fn new(cells: &Arc<Cells>) -> Means<N> {
        let n = cells.count();
        Means {
            cells: cells.clone(),
            runs: runs(cells.along().into_iter()),
            sums: vec![[0.0; N]; n],
            counts: vec![0; n],
            row: 0,
        }
    }

    /// Takes in scanlines of `stride` components, of which the first N count.
    pub fn add(&mut self, data: &[f32], stride: usize) {
        let scanline = stride * self.cells.resolution.scanline_len();
        for line in data.chunks_exact(scanline) {
            let start = self.cells.first(self.row);
            simd::wide(
                #[inline(always)]
                || {
                    // Runs of pixels in one cell are summed in registers.
                    for (pixels, along) in &self.runs {
                        let sum: [f64; N] = sum_of(&line[pixels.start * stride..pixels.end * stride], stride);
                        let cell = start + along;
                        self.sums[cell].iter_mut().zip(sum).for_each(|(a, b)| *a += b);
                        self.counts[cell] += pixels.len() as u32;
                    }
                },
            );
            self.row += 1;
        }
    }

    /// The means, 0 where no pixel lies.
    pub fn means(&self) -> Vec<[f64; N]> {
        let mean = |(sum, count): (&[f64; N], &u32)| sum.map(|s| if *count > 0 { s / f64::from(*count) } else { 0.0 });
        self.sums.iter().zip(&self.counts).map(mean).collect()
    }
}

/// Smallest and largest luminance of each cell, and a share of all pixels picked at random places: what a picture's luminances
/// are told from once a veil lies over its cells.
#[derive(Clone, Debug)]
pub struct Samples {
    cells: Arc<Cells>,
    along: Vec<u32>,
    runs: Vec<Run>,
    /// Smallest above 0 and largest.
    ranges: Vec<(f32, f32)>,
    /// Cell and components of the pixels picked.
    picked: Vec<(u32, [f32; 4])>,
    every: u64,
    row: usize,
}

/// Pixels picked of a large picture.
const PICKED: u64 = 1 << 18;

impl Samples {
    /// Nothing yet.
    pub fn new(cells: &Arc<Cells>) -> Samples {
        let r = cells.resolution;
        let every = (r.width as u64 * r.height as u64).div_ceil(PICKED);
        let ranges = vec![(f32::MAX, 0.0); cells.count()];
        let along = cells.along();
        let runs = runs(along.iter().copied());
        Samples { cells: cells.clone(), along, runs, ranges, picked: Vec::new(), every, row: 0 }
    }

    /// Takes in scanlines of `stride` components, and their luminances in cd/m2.
    pub fn add(&mut self, data: &[f32], stride: usize, luminances_cd_m2: &[f32]) {
        let len = self.along.len();
        for (line, ys) in data.chunks_exact(stride * len).zip(luminances_cd_m2.chunks_exact(len)) {
            let start = self.cells.first(self.row);
            simd::wide(
                #[inline(always)]
                || {
                    for (pixels, along) in &self.runs {
                        let range = &mut self.ranges[start + along];
                        let (low, high) = range_of(&ys[pixels.clone()]);
                        *range = (range.0.min(low), range.1.max(high));
                    }
                },
            );
            // One of each `every` pixels of the scanline, at a place that the scanline's number and its own draw.
            for first in (0..len as u64).step_by(self.every as usize) {
                let x = (first + scrambled(self.row as u64 * len as u64 + first) % self.every) as usize;
                if x < len {
                    let pixel = &line[x * stride..(x + 1) * stride];
                    let values = std::array::from_fn(|c| pixel.get(c).copied().unwrap_or(0.0));
                    self.picked.push(((start + self.along[x] as usize) as u32, values));
                }
            }
            self.row += 1;
        }
    }

    /// The pixels picked: cell, components.
    pub fn picked(&self) -> &[(u32, [f32; 4])] {
        &self.picked
    }

    /// For each cell that has light its smallest and largest luminance.
    pub fn ranges(&self) -> impl Iterator<Item = (usize, (f32, f32))> {
        self.ranges.iter().copied().enumerate().filter(|(_, r)| r.1 > 0.0)
    }
}

/// Sums of the first N components, infinities and NaN left out. Four sums each, so that none waits for the last addition.
#[inline(always)]
fn sum_of<const N: usize>(pixels: &[f32], stride: usize) -> [f64; N] {
    let finite = |x: f32| f64::from(if x.abs() < f32::INFINITY { x } else { 0.0 });
    let mut sums = [[0f64; N]; 4];
    if stride == N {
        let (groups, rest) = pixels.as_chunks::<N>().0.as_chunks::<4>();
        for group in groups {
            for (pixel, sum) in group.iter().zip(&mut sums) {
                (0..N).for_each(|c| sum[c] += finite(pixel[c]));
            }
        }
        for (pixel, sum) in rest.iter().zip(&mut sums) {
            (0..N).for_each(|c| sum[c] += finite(pixel[c]));
        }
    } else {
        for group in pixels.chunks(4 * stride) {
            for (pixel, sum) in group.chunks_exact(stride).zip(&mut sums) {
                (0..N).for_each(|c| sum[c] += finite(pixel[c]));
            }
        }
    }
    std::array::from_fn(|c| sums.iter().map(|s| s[c]).sum())
}

/// Smallest and largest of the values that are above 0 and finite: those of [`Samples::ranges`] where there is none. Eight at a
/// time.
#[inline(always)]
fn range_of(values: &[f32]) -> (f32, f32) {
    let (mut low, mut high) = ([f32::MAX; 8], [0f32; 8]);
    let mut take = |k: usize, y: f32| {
        let counts = y > 0.0 && y < f32::INFINITY;
        let (l, h) = (if counts { y } else { f32::MAX }, if counts { y } else { 0.0 });
        low[k] = if l < low[k] { l } else { low[k] };
        high[k] = if h > high[k] { h } else { high[k] };
    };
    let (groups, rest) = values.as_chunks::<8>();
    for group in groups {
        (0..8).for_each(|k| take(k, group[k]));
    }
    rest.iter().for_each(|y| take(0, *y));
    (low.into_iter().fold(f32::MAX, f32::min), high.into_iter().fold(0.0, f32::max))
}

/// How the cells count among themselves.
#[derive(Clone, Debug, Default)]
pub struct Attention {
    /// More for what lies near the line of sight: max(0, 1 - (x / 90)^2 - (y / 90)^2), degrees.
    pub centre: bool,
    /// Pixels that are looked at, from the lower left corner.
    pub fixations: Vec<[usize; 2]>,
    /// Share of all weight that the cells around them have, 0 to 1.
    pub fixated: f64,
}

impl Attention {
    /// The histogram that decides on the map, from means of cells (cd/m2) and all pixels: half the weight to each, so that small
    /// bright and dark things count too (the original takes random pixels). Of fixations the 3 x 3 cells around each have their
    /// share, all else the rest.
    pub fn histogram(&self, cells: &Cells, means: &[f64], pixels: &Histogram) -> Histogram {
        let mut foveal = Histogram::default();
        for (cell, mean) in means.iter().enumerate().filter(|(i, _)| cells.direction(*i).is_some()) {
            foveal.add(*mean as f32, if self.centre { centre_weight(cells, cell) } else { 1.0 });
        }
        let mut all = Histogram::default();
        let rest = if self.fixations.is_empty() { 1.0 } else { 1.0 - self.fixated };
        for part in [&foveal, pixels].into_iter().filter(|p| p.total() > 0.0 && rest > 0.0) {
            all.merge(part, 0.5 * rest / part.total());
        }
        let mut looked_at = Histogram::default();
        for [x, y] in &self.fixations {
            let at = cells.at(*x, *y);
            let (column, row) = (at % cells.columns, at / cells.columns);
            for r in row.saturating_sub(1)..(row + 2).min(cells.rows) {
                for c in column.saturating_sub(1)..(column + 2).min(cells.columns) {
                    looked_at.add(means[r * cells.columns + c] as f32, 1.0);
                }
            }
        }
        if looked_at.total() > 0.0 && self.fixated > 0.0 {
            all.merge(&looked_at, self.fixated / looked_at.total());
        }
        all
    }
}

fn centre_weight(cells: &Cells, cell: usize) -> f64 {
    let (u, v) = cells.middle(cell);
    let (x, y) = ((u - 0.5) * cells.view.horizontal_deg, (v - 0.5) * cells.view.vertical_deg);
    (1.0 - (x / 90.0).powi(2) - (y / 90.0).powi(2)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Block, Components, Units};

    fn header(order: &str, view: &str) -> Header {
        let r = Resolution::parse(order.as_bytes()).unwrap();
        let mut h = Header::new(r, Components::Xyz, 3, Units::CdM2);
        h.lines.push(format!("VIEW={view}").into_bytes());
        h
    }

    /// In every scan order the same upright picture has the same means and the same values between cells.
    #[test]
    fn scan_orders_do_not_matter() {
        let value = |x: usize, y: usize| (1 + x + 100 * y) as f32;
        let (w, h) = (70, 40);
        let mut seen: Option<Vec<[f64; 1]>> = None;
        for order in ["-Y 40 +X 70", "+Y 40 +X 70", "-Y 40 -X 70", "+Y 40 -X 70", "+X 70 +Y 40", "-X 70 -Y 40"] {
            let head = header(order, "-vta -vh 35 -vv 20");
            let (cells, assumed) = Cells::of(&head);
            assert!(!assumed && (cells.columns, cells.rows) == (35, 20));
            let r = head.resolution;
            let mut block = Block { rows: r.scanlines(), data: Vec::new() };
            let mut upright = Vec::new();
            for s in 0..r.scanlines() {
                for i in 0..r.scanline_len() {
                    let (x, y) = if r.by_rows { (i, s) } else { (s, i) };
                    let (x, y) = (if r.from_right { w - 1 - x } else { x }, if r.from_bottom { y } else { h - 1 - y });
                    upright.push((x, y));
                    block.data.extend([0.0, value(x, y), 0.0]);
                }
            }
            let mut means = Means::<1>::new(&cells);
            means.add(&block.data.chunks(3).map(|p| p[1]).collect::<Vec<f32>>(), 1);
            let means = means.means();
            let field = Field::new(cells, means.iter().map(|m| [m[0] as f32]).collect());
            for s in 0..r.scanlines() {
                let line = field.scanline(s);
                let stretches = field.along(&line);
                let values = stretches.flat_map(|p| p.shares.iter().map(move |t| p.start[0] + t * p.step[0]));
                for (i, got) in values.enumerate() {
                    let (x, y) = upright[s * r.scanline_len() + i];
                    // Bilinear over means of a linear ramp is the ramp, away from the rim.
                    if (1..w - 1).contains(&x) && (1..h - 1).contains(&y) {
                        assert!((got - value(x, y)).abs() < 1e-2, "{order} {x} {y}");
                    }
                }
            }
            assert_eq!(*seen.get_or_insert(means.clone()), means, "{order}");
        }
    }

    #[test]
    fn fixations_have_their_share() {
        let head = header("-Y 40 +X 70", "-vta -vh 35 -vv 20");
        let (cells, _) = Cells::of(&head);
        let mut means = vec![1.0; cells.count()];
        means[cells.at(30, 10)] = 100.0;
        let mut pixels = Histogram::default();
        pixels.add(1.0, 1.0);
        let attention = Attention { centre: false, fixations: vec![[30, 10]], fixated: 0.9 };
        let h = attention.histogram(&cells, &means, &pixels);
        let bright: f64 = h.weights().filter(|(ln, _)| *ln > 3.0).map(|(_, w)| w).sum();
        assert!((h.total() - 1.0).abs() < 1e-12);
        assert!((bright - (0.1 + 0.05 / cells.count() as f64 - 0.0)).abs() < 1e-3, "{bright}");
    }
}
