//! `density = { grid = { file = "smoke.vol" } }`: values at the middles of the voxels of a box, linear between them, nothing outside.
//! The box is the file's, in the scene's lengths, or from `low` to `high`; `scale` times the values (1). `tracking = "null"` follows
//! ways by null collisions in place of cell by cell (`"regular"`): noisier, but quicker where cells are many and thin.
//!
//! Blocks of 8 x 8 x 8 voxels that are empty take no room and are stepped over. Along a way the density is a cubic in each cell: its
//! integral is exact.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::keys::Keys;
use crate::medium::density::vol::{self, Volume};
use crate::medium::density::{Candidate, Density, Way};

/// Voxels, and cells, along each side of a block.
const BLOCK: usize = 8;
/// Of an empty block.
const EMPTY: u32 = u32::MAX;

/// Voxels that are not all there.
#[derive(Debug)]
struct Voxels {
    size: [usize; 3],
    blocks: [usize; 3],
    /// Where in the data each block begins, in blocks.
    index: Vec<u32>,
    data: Vec<f32>,
    /// The densest of what the cells of each block lie between. Cells lie between the middles of voxels: cell (0, 0, 0) ends at that of
    /// the first, and there is one more than voxels along each axis.
    most: Vec<f32>,
    cell_blocks: [usize; 3],
}

/// A box of voxels.
#[derive(Clone, Debug)]
pub struct Grid {
    voxels: Arc<Voxels>,
    low: DVec3,
    high: DVec3,
    null: bool,
    // Cells = offset + place x cells a unit.
    cells: Vec3A,
    offset: Vec3A,
}

impl Voxels {
    fn new(volume: &Volume, scale: f32) -> Voxels {
        let size = volume.size;
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        let cell_blocks = size.map(|n| (n + 1).div_ceil(BLOCK));
        let count = |b: [usize; 3]| b[0] * b[1] * b[2];
        let mut voxels = Voxels {
            size,
            blocks,
            index: vec![EMPTY; count(blocks)],
            data: Vec::new(),
            most: vec![0.0; count(cell_blocks)],
            cell_blocks,
        };
        let mut values = volume.values.iter();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for (x, value) in (0..size[0]).zip(&mut values) {
                    if *value > 0.0 {
                        voxels.put([x, y, z], value * scale);
                    }
                }
            }
        }
        voxels
    }

    fn put(&mut self, at: [usize; 3], value: f32) {
        let block = linear(at.map(|i| i / BLOCK), self.blocks);
        if self.index[block] == EMPTY {
            self.index[block] = (self.data.len() / BLOCK.pow(3)) as u32;
            self.data.resize(self.data.len() + BLOCK.pow(3), 0.0);
        }
        let within = linear(at.map(|i| i % BLOCK), [BLOCK; 3]);
        self.data[self.index[block] as usize * BLOCK.pow(3) + within] = value;
        // It is a corner of cells number i and i + 1 along each axis.
        for corner in 0..8 {
            let cell = [0, 1, 2].map(|a| at[a] + (corner >> a & 1));
            let most = &mut self.most[linear(cell.map(|i| i / BLOCK), self.cell_blocks)];
            *most = most.max(value);
        }
    }

    fn get(&self, at: [usize; 3]) -> f32 {
        match self.index[linear(at.map(|i| i / BLOCK), self.blocks)] {
            EMPTY => 0.0,
            start => self.data[start as usize * BLOCK.pow(3) + linear(at.map(|i| i % BLOCK), [BLOCK; 3])],
        }
    }

    /// The eight corners of a cell, x first.
    fn corners(&self, cell: [usize; 3]) -> [f32; 8] {
        let voxel = |a: usize, far: usize| (cell[a] + far).saturating_sub(1).min(self.size[a] - 1);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c| self.get([voxel(0, c & 1), voxel(1, c >> 1 & 1), voxel(2, c >> 2)]))
    }
}

fn linear([x, y, z]: [usize; 3], [nx, ny, _]: [usize; 3]) -> usize {
    (z * ny + y) * nx + x
}

/// Between eight corners.
fn between(c: &[f32; 8], place: Vec3A) -> f32 {
    let mix = |a: f32, b: f32, x: f32| a + (b - a) * x;
    let [x, y, z] = place.to_array();
    let face = |i: usize| mix(mix(c[i], c[i + 1], x), mix(c[i + 2], c[i + 3], x), y);
    mix(face(0), face(4), z)
}

/// The cells of a lattice that a way meets, one after the other: which, and from where to where.
struct Walk {
    cell: [i32; 3],
    step: [i32; 3],
    next: [f32; 3],
    each: [f32; 3],
    t: f32,
    end: f32,
}

impl Walk {
    /// `origin + direction t` in the lattice's cells, from `t` to `end`, which is finite; cells from `low` to `high`.
    fn new(origin: Vec3A, direction: Vec3A, (t, end): (f32, f32), (low, high): ([i32; 3], [i32; 3])) -> Walk {
        let start = origin + direction * t;
        let cell = [0, 1, 2].map(|a| (start[a].floor() as i32).clamp(low[a], high[a]));
        let step = [0, 1, 2].map(|a| if direction[a] < 0.0 { -1 } else { 1 });
        let each = [0, 1, 2].map(|a| if direction[a] == 0.0 { f32::INFINITY } else { (1.0 / direction[a]).abs() });
        let next = [0, 1, 2].map(|a| {
            let wall = cell[a] + i32::from(step[a] > 0);
            if direction[a] == 0.0 { f32::INFINITY } else { (wall as f32 - origin[a]) / direction[a] }
        });
        Walk { cell, step, next, each, t, end }
    }
}

impl Iterator for Walk {
    type Item = ([i32; 3], f32, f32);

    fn next(&mut self) -> Option<Self::Item> {
        if self.t >= self.end {
            return None;
        }
        let [x, y, z] = self.next;
        let axis = if x <= y && x <= z { 0 } else { 1 + usize::from(z < y) };
        let (cell, from) = (self.cell, self.t);
        let to = self.next[axis].min(self.end).max(from);
        self.cell[axis] += self.step[axis];
        self.next[axis] += self.each[axis];
        self.t = to;
        // Rounding may have it leave by a corner that it does not come to.
        if self.next[axis].is_nan() { None } else { Some((cell, from, to)) }
    }
}

/// A part of a way on which the density is one cubic.
struct Piece {
    corners: [f32; 8],
    /// Place in the cell at the start of the way, and its change in a unit.
    start: Vec3A,
    direction: Vec3A,
    from: f32,
    to: f32,
}

impl Piece {
    fn at(&self, t: f32) -> f32 {
        between(&self.corners, self.start + self.direction * t)
    }

    /// Up to a place of it: Simpson's rule is exact for a cubic.
    fn up_to(&self, t: f32) -> f32 {
        let middle = 0.5 * (self.from + t);
        ((t - self.from) / 6.0 * (self.at(self.from) + 4.0 * self.at(middle) + self.at(t))).max(0.0)
    }

    /// Where the integral is `column`, which is no more than all of it: Newton's way, kept within brackets.
    fn reach(&self, column: f32) -> f32 {
        let (mut low, mut high) = (self.from, self.to);
        let mut t = 0.5 * (low + high);
        for _ in 0..24 {
            let off = self.up_to(t) - column;
            if off > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - off / self.at(t);
            t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        t
    }
}

impl Grid {
    /// `low` and `high` are corners in metres, `high` beyond `low` along each axis; `scale` times all values.
    pub fn new(volume: &Volume, low: DVec3, high: DVec3, scale: f32, null: bool) -> Grid {
        let voxels = Arc::new(Voxels::new(volume, scale));
        Grid { voxels, low, high, null, cells: Vec3A::ONE, offset: Vec3A::ZERO }.placed(low, high)
    }

    fn placed(&self, low: DVec3, high: DVec3) -> Grid {
        let size = self.voxels.size.map(|n| n as f64);
        let cells = DVec3::from(size) / (high - low);
        let offset = (DVec3::splat(0.5) - low * cells).as_vec3a();
        Grid { voxels: self.voxels.clone(), low, high, cells: cells.as_vec3a(), offset, null: self.null }
    }

    /// The part of a way in the box.
    fn inside(&self, way: &Way, from: f32) -> Option<(f32, f32)> {
        let inverse = way.direction.recip();
        let (a, b) = ((self.low.as_vec3a() - way.origin) * inverse, (self.high.as_vec3a() - way.origin) * inverse);
        // A way along a wall that it lies in is 0 / 0 of it, which min and max pass over.
        let near = [0, 1, 2].iter().fold(from, |t, i| t.max(a[*i].min(b[*i])));
        let far = [0, 1, 2].iter().fold(way.length, |t, i| t.min(a[*i].max(b[*i])));
        (near < far && far.is_finite()).then_some((near, far))
    }

    /// Has each block that is not empty visited, with where the way meets it and its densest, until an answer comes.
    fn blocks<T>(
        &self,
        way: &Way,
        from: f32,
        mut visit: impl FnMut([i32; 3], (f32, f32), f32) -> Option<T>,
    ) -> Option<T> {
        let v = &self.voxels;
        let (origin, direction) = (way.origin * self.cells + self.offset, way.direction * self.cells);
        let each = 1.0 / BLOCK as f32;
        let last = v.cell_blocks.map(|n| n as i32 - 1);
        let walk = Walk::new(origin * each, direction * each, self.inside(way, from)?, ([0; 3], last));
        for (block, a, b) in walk {
            if [0, 1, 2].iter().any(|i| block[*i] < 0 || block[*i] > last[*i]) {
                return None;
            }
            let most = v.most[linear(block.map(|i| i as usize), v.cell_blocks)];
            if most > 0.0
                && let Some(found) = visit(block, (a, b), most)
            {
                return Some(found);
            }
        }
        None
    }

    /// The same with each cell's part of the way.
    fn pieces<T>(&self, way: &Way, mut visit: impl FnMut(&Piece) -> Option<T>) -> Option<T> {
        let v = &self.voxels;
        let (origin, direction) = (way.origin * self.cells + self.offset, way.direction * self.cells);
        self.blocks(way, 0.0, |block, part, _| {
            let low = block.map(|i| i * BLOCK as i32);
            let high = [0, 1, 2].map(|a| (low[a] + BLOCK as i32 - 1).min(v.size[a] as i32));
            for (cell, from, to) in Walk::new(origin, direction, part, (low, high)) {
                let cell = [0, 1, 2].map(|a| cell[a].clamp(low[a], high[a]));
                let corner = Vec3A::from(cell.map(|i| i as f32));
                let corners = v.corners(cell.map(|i| i as usize));
                let piece = Piece { corners, start: origin - corner, direction, from, to };
                if let Some(found) = visit(&piece) {
                    return Some(found);
                }
            }
            None
        })
    }
}

impl Density for Grid {
    fn within(&self, centre: DVec3, scale: f64) -> Arc<dyn Density> {
        Arc::new(self.placed((self.low - centre) * scale, (self.high - centre) * scale))
    }

    fn at(&self, place: Vec3A) -> f32 {
        let q = place * self.cells + self.offset;
        let size = Vec3A::from(self.voxels.size.map(|n| n as f32));
        let inside = q.cmpge(Vec3A::splat(0.5)).all() && q.cmple(size + 0.5).all();
        if !inside {
            return 0.0;
        }
        let cell = q.floor().min(size);
        between(&self.voxels.corners(cell.to_array().map(|x| x as usize)), q - cell)
    }

    fn along(&self, way: &Way) -> f32 {
        let mut sum = 0.0;
        self.pieces(way, |piece| {
            sum += piece.up_to(piece.to);
            None::<()>
        });
        sum
    }

    fn reach(&self, way: &Way, column: f32) -> Option<f32> {
        let mut left = column;
        self.pieces(way, |piece| {
            let all = piece.up_to(piece.to);
            if all > left {
                return Some(piece.reach(left));
            }
            left -= all;
            None
        })
    }

    fn candidate(&self, way: &Way, from: f32, column: f32) -> Option<Candidate> {
        let mut left = column;
        self.blocks(way, from, |_, (a, b), most| {
            let all = most * (b - a);
            if all > left {
                let t = (a + left / most).min(b);
                return Some(Candidate { t, share: (self.at(way.at(t)) / most).clamp(0.0, 1.0), most });
            }
            left -= all;
            None
        })
    }

    fn by_null_collisions(&self) -> bool {
        self.null
    }
}

/// Reads one.
pub fn read(mut keys: Keys, metres: f64, folder: &Path) -> Result<Arc<dyn Density>> {
    let (file, span): (String, _) = match keys.get_spanned("file")? {
        Some(file) => file,
        None => return Err(keys.wrong("key 'file' is missing")),
    };
    let volume = vol::read(&folder.join(&file)).map_err(|e| keys.wrong_key("file", span, &e.to_string()))?;
    let low = DVec3::from(keys.get("low")?.unwrap_or(volume.low));
    let high = DVec3::from(keys.get("high")?.unwrap_or(volume.high));
    let fits = (high - low).min_element() > 0.0 && low.abs().max(high.abs()).max_element() < 1e12;
    if !(fits && low.is_finite() && high.is_finite()) {
        return Err(keys.wrong("low and high: high must lie beyond low along each axis"));
    }
    let scale = keys.number("scale", "must be 0 or more", |s| (0.0..1e30).contains(&s))?.unwrap_or(1.0);
    let null = match keys.get::<String>("tracking")?.as_deref() {
        None | Some("regular") => false,
        Some("null") => true,
        Some(_) => return Err(keys.wrong("tracking: expected regular or null")),
    };
    keys.finish()?;
    Ok(Arc::new(Grid::new(&volume, low * metres, high * metres, scale as f32, null)))
}
