//! The chromaticities of 24-bit LogLuv: squares of 0.0035 in u'v' in rows that cover what is visible; a colour outside goes
//! to the square at the edge in the same direction from neutral [libtiff `tif_luv.c`, `uvcode.h`].

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::NEUTRAL;

/// Rows of cells: where each begins in u', and its cells (spectra/tables/README says whence).
const TABLE: &str = include_str!("../../../spectra/tables/logluv24_cells.csv");
/// Side of a cell. libtiff keeps these two and the rows' beginnings in single precision.
pub(super) const SIDE: f64 = 0.0035f32 as f64;
/// v' of the lowest row's lower edge.
pub(super) const V_START: f64 = 0.01694f32 as f64;
/// Directions in which the edge is known.
const DIRECTIONS: usize = 100;

/// One row.
struct Row {
    u_start: f64,
    cells: u32,
    first: u32,
}

/// The cells and their edge.
pub struct Cells {
    rows: Vec<Row>,
    edge: [u32; DIRECTIONS],
    // The rows again, for every byte one.
    starts: [f32; 256],
    extents: [u32; 256],
}

impl Cells {
    /// The one set there is.
    pub fn get() -> &'static Cells {
        static CELLS: OnceLock<Cells> = OnceLock::new();
        CELLS.get_or_init(|| {
            let mut rows: Vec<Row> = Vec::new();
            for line in TABLE.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())) {
                let (start, cells) = line.split_once(',').unwrap_or(("0", "0"));
                let first = rows.last().map_or(0, |r| r.first + r.cells);
                let u_start = f64::from(start.parse::<f32>().unwrap_or(0.0)); // the table is part of the source
                rows.push(Row { u_start, cells: cells.parse().unwrap_or(0), first });
            }
            let starts = std::array::from_fn(|i| rows.get(i).map_or(0.0, |r| r.u_start as f32));
            let extents = std::array::from_fn(|i| rows.get(i).map_or(0, |r| r.cells << 16 | r.first));
            let mut cells = Cells { rows, edge: [0; DIRECTIONS], starts, extents };
            cells.edge = cells.find_edge();
            cells
        })
    }

    /// Where a row begins in u'; its number of cells in the upper 16 bits, 0 where there is no such row, and the first one's
    /// code in the lower.
    #[inline(always)]
    pub(super) fn row(&self, row: u8) -> (f32, u32) {
        (self.starts[usize::from(row)], self.extents[usize::from(row)])
    }

    /// The cell that holds u', v'; `None` outside all.
    #[inline(always)]
    pub fn inside(&self, u: f64, v: f64) -> Option<u32> {
        self.dithered(u, v, [0.0; 2])
    }

    #[inline(always)]
    fn dithered(&self, u: f64, v: f64, dither: [f64; 2]) -> Option<u32> {
        if v < V_START {
            return None;
        }
        let row = self.rows.get(((v - V_START) * (1.0 / SIDE) + dither[1]) as usize)?;
        if u < row.u_start {
            return None;
        }
        let cell = ((u - row.u_start) * (1.0 / SIDE) + dither[0]) as u32;
        (cell < row.cells).then(|| row.first + cell)
    }

    /// The cell of u', v', or the one at the edge in that direction; false with the latter.
    pub fn code(&self, u: f64, v: f64, dither: [f64; 2]) -> (u32, bool) {
        match self.dithered(u, v, dither) {
            Some(code) => (code, true),
            // Dither alone must not move a colour to the edge.
            None => match self.inside(u, v) {
                Some(code) => (code, true),
                None => (self.edge[(direction(u, v) as usize).min(DIRECTIONS - 1)], false),
            },
        }
    }

    /// u' and v' of a cell's centre; `None` for codes that are no cell.
    pub fn centre(&self, code: u32) -> Option<(f64, f64)> {
        let at = self.rows.partition_point(|r| r.first <= code).checked_sub(1)?;
        let row = &self.rows[at];
        (code - row.first < row.cells)
            .then(|| (row.u_start + (f64::from(code - row.first) + 0.5) * SIDE, V_START + (at as f64 + 0.5) * SIDE))
    }

    /// For each direction the cell at the edge whose centre lies closest to it; directions that have none take that of
    /// their nearest neighbour.
    fn find_edge(&self) -> [u32; DIRECTIONS] {
        let mut edge = [0; DIRECTIONS];
        let mut off = [2.0; DIRECTIONS];
        let last = self.rows.len() - 1;
        for (at, row) in self.rows.iter().enumerate().rev() {
            // The first and the last row are all edge, the others at their two ends.
            let step = if at == 0 || at == last || row.cells < 2 { 1 } else { row.cells as usize - 1 };
            for cell in (0..row.cells).rev().step_by(step) {
                let (u, v) = (row.u_start + (f64::from(cell) + 0.5) * SIDE, V_START + (at as f64 + 0.5) * SIDE);
                let angle = direction(u, v);
                let i = (angle as usize).min(DIRECTIONS - 1);
                let distance = (angle - (i as f64 + 0.5)).abs();
                if distance < off[i] {
                    (edge[i], off[i]) = (row.first + cell, distance);
                }
            }
        }
        let known = |i: usize| off[i % DIRECTIONS] < 1.5;
        let nearest = |i: usize| {
            let up = (1..DIRECTIONS / 2).find(|d| known(i + d)).unwrap_or(DIRECTIONS / 2);
            let down = (1..DIRECTIONS / 2).find(|d| known(i + DIRECTIONS - d)).unwrap_or(DIRECTIONS / 2);
            (if up < down { i + up } else { i + DIRECTIONS - down }) % DIRECTIONS
        };
        // libtiff fills from the last direction down, and so may take what it has just filled; the nearest known is the same.
        std::array::from_fn(|i| if known(i) { edge[i] } else { edge[nearest(i)] })
    }
}

/// Direction from neutral, 0 to [`DIRECTIONS`].
fn direction(u: f64, v: f64) -> f64 {
    let turns = DIRECTIONS as f64 * 0.499_999_999 / PI;
    turns * (v - NEUTRAL.1).atan2(u - NEUTRAL.0) + 0.5 * DIRECTIONS as f64
}
