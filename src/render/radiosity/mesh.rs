//! Surfaces divided into elements: a grid of cells over the square of each [`Patch`], for each of its sides that light reaches.
//!
//! What a surface shows at a place comes from the cells around it: linear between their middles and beyond them to the edge, or,
//! where that would leave the neighbourhood of what the cells have, no further than their middles.

use glam::Vec3A;

use crate::scene::geometry::Patch;
use crate::scene::{Geometry, Hit};

/// A side without elements.
const ASLEEP: u32 = u32::MAX;

/// One surface with its grid.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The surface.
    pub patch: Patch,
    /// Cells along both sides of the square; of a triangle the same number twice. 0 for a surface without area.
    pub cells: [u32; 2],
    /// Area of the surface, in the scene's units.
    pub area: f64,
    /// First element of front and back.
    first: [u32; 2],
}

/// All of them.
pub struct Mesh {
    tiles: Vec<Tile>,
    /// Where the surfaces of each placement begin.
    bases: Vec<u32>,
    /// Tile and side of runs of elements, by first element.
    runs: Vec<(u32, u32, bool)>,
    count: u32,
}

/// One side of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    /// Its surface.
    pub tile: &'a Tile,
    /// On the front.
    pub front: bool,
    cell: u32,
}

/// An element and its share in what a place shows.
pub type Share = (u32, f32);

impl Tile {
    fn count(&self) -> u32 {
        let [n, m] = self.cells;
        if self.patch.is_triangle() { n * (n + 1) / 2 } else { n * m }
    }

    /// Number of the cell in column i of row j. A triangle's rows grow shorter.
    fn number(&self, i: u32, j: u32) -> u32 {
        let [n, _] = self.cells;
        if self.patch.is_triangle() { j * n - j * j.saturating_sub(1) / 2 + i } else { j * n + i }
    }

    /// Column and row of a cell.
    fn column_row(&self, cell: u32) -> (u32, u32) {
        let [n, _] = self.cells;
        if !self.patch.is_triangle() {
            return (cell % n, cell / n);
        }
        let (mut left, mut j) = (cell, 0);
        while left >= n - j {
            left -= n - j;
            j += 1;
        }
        (left, j)
    }

    /// The cell that a point of the square lies in.
    fn cell(&self, [s, t]: [f32; 2]) -> u32 {
        let [n, m] = self.cells;
        let j = ((t * m as f32) as u32).min(m - 1);
        let most = if self.patch.is_triangle() { n - 1 - j } else { n - 1 };
        self.number(((s * n as f32) as u32).min(most), j)
    }
}

impl Element<'_> {
    /// A place spread evenly over the element by two numbers in 0..1, and the normal of its side.
    pub fn place(&self, u: [f32; 2]) -> (Vec3A, Vec3A) {
        let (point, front) = self.tile.patch.place(self.square(u));
        (point, if self.front { front } else { -front })
    }

    /// About how long it is.
    pub fn size(&self) -> f32 {
        (self.tile.area / f64::from(self.tile.count().max(1))).sqrt() as f32
    }

    /// A point of the square, spread evenly over the cell by two numbers in 0..1.
    pub fn square(&self, [mut u, mut v]: [f32; 2]) -> [f32; 2] {
        let [n, m] = self.tile.cells;
        let (i, j) = self.tile.column_row(self.cell);
        if self.tile.patch.is_triangle() && i + j == n - 1 && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        [(i as f32 + u) / n as f32, (j as f32 + v) / m as f32]
    }
}

impl Mesh {
    /// An element each side of each surface, all sides awake.
    pub fn new(geometry: &Geometry) -> Mesh {
        let mut bases = Vec::new();
        let mut tiles: Vec<Tile> = Vec::new();
        for patch in geometry.patches() {
            if let Some(p) = patch.placement.filter(|p| *p as usize >= bases.len()) {
                bases.resize(p as usize + 1, tiles.len() as u32);
            }
            let area = patch.area();
            tiles.push(Tile { patch, cells: [u32::from(area > 0.0); 2], area, first: [0, 0] });
        }
        let mut mesh = Mesh { tiles, bases, runs: Vec::new(), count: 0 };
        mesh.number();
        mesh
    }

    /// Gives all surfaces grids of as many cells along their sides as `cells` says.
    pub fn grid(&mut self, cells: impl Fn(&Tile) -> [u32; 2]) {
        for tile in self.tiles.iter_mut().filter(|t| t.area > 0.0) {
            tile.cells = cells(tile);
        }
        self.number();
    }

    /// Numbers the elements of all sides that are awake anew.
    pub fn number(&mut self) {
        (self.runs, self.count) = (Vec::new(), 0);
        for (i, tile) in self.tiles.iter_mut().enumerate() {
            let count = tile.count();
            for (side, first) in tile.first.iter_mut().enumerate() {
                if *first == ASLEEP || count == 0 {
                    *first = ASLEEP;
                    continue;
                }
                *first = self.count;
                self.runs.push((self.count, i as u32, side == 0));
                // Beyond this no memory is granted.
                self.count = self.count.saturating_add(count);
            }
        }
    }

    /// Elements in all.
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// Surfaces that have elements.
    pub fn surfaces(&self) -> usize {
        self.tiles.iter().filter(|t| t.first != [ASLEEP; 2]).count()
    }

    /// The surfaces.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Gives a surface another grid; [`Mesh::number`] comes after.
    pub fn divide(&mut self, tile: usize, cells: [u32; 2]) {
        self.tiles[tile].cells = cells;
    }

    /// A side that no light reaches, or that does again; [`Mesh::number`] comes after.
    pub fn wake(&mut self, tile: usize, front: bool, awake: bool) {
        self.tiles[tile].first[usize::from(!front)] = if awake { 0 } else { ASLEEP };
    }

    /// A side has elements.
    pub fn is_awake(&self, tile: usize, front: bool) -> bool {
        self.tiles[tile].first[usize::from(!front)] != ASLEEP
    }

    /// The elements of a side.
    pub fn elements(&self, tile: usize, front: bool) -> std::ops::Range<u32> {
        match self.tiles[tile].first[usize::from(!front)] {
            ASLEEP => 0..0,
            first => first..first + self.tiles[tile].count(),
        }
    }

    /// The tile of an element, and the element.
    pub fn element(&self, number: u32) -> (usize, Element<'_>) {
        let run = self.runs.partition_point(|r| r.0 <= number) - 1;
        let (first, tile, front) = self.runs[run];
        (tile as usize, Element { tile: &self.tiles[tile as usize], front, cell: number - first })
    }

    /// The tile that was met.
    pub fn tile(&self, hit: &Hit) -> usize {
        (hit.placement.map_or(0, |p| self.bases[p as usize]) + hit.primitive) as usize
    }

    /// The element that was met, if that side has any.
    pub fn met(&self, hit: &Hit, front: bool) -> Option<u32> {
        let tile = &self.tiles[self.tile(hit)];
        let first = tile.first[usize::from(!front)];
        (first != ASLEEP).then(|| first + tile.cell(tile.patch.square(hit.bary)))
    }

    /// The elements that a place shows and their shares, which add up to 1; none where the side has no elements. Those whose
    /// brightness is negative are covered, and show nothing but to a place that has no others.
    pub fn around(&self, hit: &Hit, front: bool, brightness: &[f32]) -> ([Share; 4], usize) {
        let tile = &self.tiles[self.tile(hit)];
        let (mut shares, first) = ([(0, 0.0); 4], tile.first[usize::from(!front)]);
        if first == ASLEEP {
            return (shares, 0);
        }
        let [s, t] = tile.patch.square(hit.bary);
        let bright = |shares: &[Share]| -> f32 { shares.iter().map(|(e, k)| k * brightness[*e as usize]).sum() };
        for beyond in [0.5, 0.0] {
            let count = tile.blend([s, t], beyond, &mut shares);
            shares[..count].iter_mut().for_each(|s| s.0 += first);
            let covered = |s: &Share| brightness[s.0 as usize] < 0.0;
            if shares[..count].iter().any(covered) {
                return uncovered(tile.blend([s, t], 0.0, &mut shares), first, shares, covered);
            }
            let among = shares[..count].iter().map(|(e, _)| brightness[*e as usize]);
            let (low, high) = among.fold((f32::MAX, 0f32), |(l, h), b| (l.min(b), h.max(b)));
            let value = bright(&shares[..count]);
            // To the edge at most half or twice what the cells have: steeper, and it is a shadow that ends there.
            if beyond == 0.0 || (value >= 0.5 * low && value <= 2.0 * high) {
                return (shares, count);
            }
        }
        (shares, 0)
    }
}

impl Tile {
    /// Mean error of what is linear between these cells' values, relative to them or to `dark`, whichever is more: an eighth of
    /// the second differences along both sides, the noise of values among them.
    pub fn error(&self, values: &[f32], dark: f32) -> f64 {
        let [n, m] = self.cells;
        let value = |i: i64, j: i64| -> Option<f32> {
            let inside = (0..i64::from(n)).contains(&i) && (0..i64::from(m)).contains(&j);
            let there = inside && !(self.patch.is_triangle() && i + j >= i64::from(n));
            let value = || values[self.number(i as u32, j as u32) as usize];
            there.then(value).filter(|v| *v >= 0.0)
        };
        let around = |i: i64| if self.patch.is_round() && n > 2 { i.rem_euclid(i64::from(n)) } else { i };
        let mut sum = 0.0;
        for cell in 0..self.count() {
            let (i, j) = self.column_row(cell);
            let (i, j) = (i64::from(i), i64::from(j));
            let here = values[cell as usize];
            if here < 0.0 {
                continue;
            }
            let bend = |a: Option<f32>, b: Option<f32>| match (a, b) {
                (Some(a), Some(b)) => (a + b - 2.0 * here).abs() / 8.0,
                _ => 0.0,
            };
            let across = bend(value(around(i - 1), j), value(around(i + 1), j));
            let error = across + bend(value(i, j - 1), value(i, j + 1));
            sum += f64::from(error / here.max(dark).max(f32::MIN_POSITIVE));
        }
        sum / f64::from(self.count().max(1))
    }

    /// Cells around a point of the square and their shares, `beyond` cells further than the outermost middles.
    fn blend(&self, [s, t]: [f32; 2], beyond: f32, out: &mut [Share; 4]) -> usize {
        let [n, m] = self.cells;
        if self.patch.is_triangle() {
            return self.blend_triangle([s, t], beyond, out);
        }
        let (columns, rows) = (along(s, n, beyond, self.patch.is_round()), along(t, m, beyond, false));
        let mut count = 0;
        for (j, h) in rows {
            for (i, w) in columns {
                if w * h != 0.0 {
                    out[count] = (self.number(i, j), w * h);
                    count += 1;
                }
            }
        }
        count
    }

    /// Four cells of a triangle, along its long side the plane over three.
    fn blend_triangle(&self, [s, t]: [f32; 2], beyond: f32, out: &mut [Share; 4]) -> usize {
        let n = self.cells[0];
        if n == 1 {
            out[0] = (0, 1.0);
            return 1;
        }
        // The middle of a cell on the long side, itself a triangle, is nearer to the corner.
        let [x, y] = [s, t].map(|x| x * n as f32 - 0.5);
        let [mut i, mut j] = [x, y].map(|x| (x.max(0.0) as u32).min(n - 2));
        while i + j > n - 2 {
            if x - i as f32 <= y - j as f32 && i > 0 || j == 0 { i -= 1 } else { j -= 1 }
        }
        let bound = |x: f32| x.clamp(-beyond, 1.0 + beyond);
        let (a, b) = (bound(x - i as f32), bound(y - j as f32));
        if i + j + 2 < n {
            let cells = [
                (i, j, (1.0 - a) * (1.0 - b)),
                (i + 1, j, a * (1.0 - b)),
                (i, j + 1, (1.0 - a) * b),
                (i + 1, j + 1, a * b),
            ];
            *out = cells.map(|(i, j, share)| (self.number(i, j), share));
            return 4;
        }
        // A triangle's own cells are whole at its corner only.
        let (a, b) = if beyond == 0.0 && a + b > 1.0 { (a / (a + b), b / (a + b)) } else { (a, b) };
        out[0] = (self.number(i, j), 1.0 - a - b);
        out[1] = (self.number(i + 1, j), a);
        out[2] = (self.number(i, j + 1), b);
        3
    }
}

/// The shares of elements that are not covered, made up to 1; all of them where all are.
fn uncovered(
    count: usize,
    first: u32,
    mut shares: [Share; 4],
    covered: impl Fn(&Share) -> bool,
) -> ([Share; 4], usize) {
    shares[..count].iter_mut().for_each(|s| s.0 += first);
    let open: f32 = shares[..count].iter().filter(|s| !covered(s)).map(|s| s.1).sum();
    if open > 1e-3 {
        for s in &mut shares[..count] {
            s.1 = if covered(s) { 0.0 } else { s.1 / open };
        }
    }
    (shares, count)
}

/// The two of n cells around a point of 0..1, and their shares; going round, the last is before the first.
fn along(s: f32, n: u32, beyond: f32, around: bool) -> [(u32, f32); 2] {
    let x = s * n as f32 - 0.5;
    if n == 1 {
        return [(0, 1.0), (0, 0.0)];
    }
    if around {
        let low = x.floor();
        let (i, f) = ((low + n as f32) as u32 % n, x - low);
        return [(i, 1.0 - f), ((i + 1) % n, f)];
    }
    let i = (x.max(0.0) as u32).min(n - 2);
    let f = (x - i as f32).clamp(-beyond, 1.0 + beyond);
    [(i, 1.0 - f), (i + 1, f)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::geometry::{Primitive, Surface};

    fn mesh(geometry: &Geometry, cells: impl Fn(&Tile) -> [u32; 2]) -> Mesh {
        let mut mesh = Mesh::new(geometry);
        mesh.grid(cells);
        mesh
    }

    fn geometry() -> Geometry {
        let shapes = vec![
            Primitive::Parallelogram { corner: Vec3A::ZERO, u: Vec3A::X * 2.0, v: Vec3A::Y },
            Primitive::Triangle([Vec3A::Z, Vec3A::new(1.0, 0.0, 1.0), Vec3A::new(0.3, 1.0, 1.5)]),
            Primitive::Sphere { center: Vec3A::new(0.0, 0.0, 9.0), radius: 1.5, inward: false },
            Primitive::Disk {
                center: Vec3A::new(0.0, 5.0, 0.0),
                normal: Vec3A::new(1.0, 2.0, 3.0),
                radius: 2.0,
                inner_radius: 0.5,
            },
            Primitive::Cylinder { base: Vec3A::X * 9.0, axis: Vec3A::new(0.5, 0.0, 2.0), radius: 0.3, inward: true },
        ];
        let surfaces = vec![Surface { material: 0, emitter: None }; shapes.len()];
        Geometry::build(shapes, surfaces).unwrap()
    }

    /// A ray onto any point of any cell meets that cell, and all cells of a surface have the same area but for a triangle's
    /// long side.
    #[test]
    fn what_is_aimed_at_is_met() {
        let geometry = geometry();
        let mesh = mesh(&geometry, |t| if t.patch.is_triangle() { [5, 5] } else { [4, 3] });
        assert_eq!(mesh.len(), 2 * (4 * 12 + 15));
        for number in 0..mesh.len() as u32 {
            let (tile, element) = mesh.element(number);
            for u in [[0.5, 0.5], [0.1, 0.2], [0.9, 0.8]] {
                let square = element.square(u);
                let patch = &element.tile.patch;
                let again = patch.square(patch.bary(square));
                assert!((again[0] - square[0]).abs() + (again[1] - square[1]).abs() < 1e-5, "{square:?} {again:?}");
                let (point, front) = patch.place(square);
                let normal = if element.front { front } else { -front };
                let hit = geometry.closest(point + normal * 0.01, -normal).unwrap();
                assert_eq!((mesh.tile(&hit), mesh.met(&hit, element.front)), (tile, Some(number)));
            }
        }
    }

    /// What is linear over a surface is shown as it is, to its edges.
    #[test]
    fn linear_stays_linear() {
        let geometry = geometry();
        let mesh = mesh(&geometry, |_| [4, 4]);
        for tile in 0..2 {
            let value = |[s, t]: [f32; 2]| 10.0 + s - 2.0 * t;
            let mut cells = vec![0.0; mesh.len()];
            for e in mesh.elements(tile, true) {
                let (i, j) = mesh.tiles[tile].column_row(e - mesh.elements(tile, true).start);
                cells[e as usize] = value([(i as f32 + 0.5) / 4.0, (j as f32 + 0.5) / 4.0]);
            }
            for square in [[0.0, 0.0], [0.3, 0.6], [0.0, 1.0], [1.0, 0.0], [0.11, 0.12]] {
                let (point, normal) = mesh.tiles[tile].patch.place(square);
                let inward = (mesh.tiles[tile].patch.place([0.3, 0.3]).0 - point) * 1e-4;
                let hit = geometry.closest(point + inward + normal * 0.01, -normal).unwrap();
                let (shares, count) = mesh.around(&hit, true, &cells);
                let got: f32 = shares[..count].iter().map(|(e, k)| k * cells[*e as usize]).sum();
                assert!((got - value(hit.bary)).abs() < 1e-3, "tile {tile} {square:?}: {got}");
            }
        }
    }

    /// A triangle that is a line has no elements, and its neighbours keep theirs.
    #[test]
    fn what_has_no_area_has_no_elements() {
        let line = Primitive::Triangle([Vec3A::ZERO, Vec3A::X, Vec3A::X * 2.0]);
        let square = Primitive::Parallelogram { corner: Vec3A::Z, u: Vec3A::X, v: Vec3A::Y };
        let surface = Surface { material: 0, emitter: None };
        let geometry = Geometry::build(vec![line, square], vec![surface; 2]).unwrap();
        let mesh = mesh(&geometry, |_| [3, 3]);
        assert_eq!((mesh.len(), mesh.elements(0, true), mesh.elements(1, true)), (18, 0..0, 0..9));
        let hit = geometry.closest(Vec3A::new(0.5, 0.5, 2.0), -Vec3A::Z).unwrap();
        assert_eq!(mesh.met(&hit, true), Some(4));
    }

    #[test]
    fn areas_are_those_of_closed_forms() {
        let patches = geometry().patches();
        let want = [2.0, 0.5 * 1.118_034, 9.0 * std::f64::consts::PI, 3.75 * std::f64::consts::PI, 3.886_2];
        for (patch, want) in patches.iter().zip(want) {
            assert!((patch.area() / want - 1.0).abs() < 1e-4, "{} for {want}", patch.area());
        }
    }
}
