//! Rectangles that a picture is rendered in, and which of their pixels pool their paths ([`crate::render::pool`]).
//!
//! Where each pixel is by itself a tile is a run of neighbours. Pools gain most from pixels that are near each other in both
//! directions, which see surfaces near each other: there tiles are [`BAND`] rows high, counted from the top of the picture
//! whichever rows are rendered, so that its parts are those of the whole.
//!
//! Were the same pixels together in every sample, their noise would be the same too, and seen as blocks. So each sample moves the blocks
//! of pixels that may meet sideways, and deals the pixels of each anew.

use std::ops::Range;

use crate::render::pool::MEMBERS;
use crate::render::sampler::Sampler;

/// Rows of a tile whose pixels pool their paths.
pub const BAND: usize = 4;
/// Its columns, at most.
const COLUMNS: usize = 32;
/// Columns of a block, whose pixels may meet.
const BLOCK: usize = 8;

/// A rectangle of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Tile {
    /// Pixels in all.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Column and row in the picture of pixel number `i`, row by row.
    pub fn pixel(&self, i: usize) -> (u32, u32) {
        ((self.x + i % self.width) as u32, (self.y + i / self.width) as u32)
    }

    /// Deals the pixels' numbers to pools, by a sample's numbers.
    pub fn deal(&self, sampler: &Sampler, deal: &mut Deal) {
        let Deal { order, pools } = deal;
        order.clear();
        pools.clear();
        let mut to = 1 + (sampler.pair(0)[0] * BLOCK as f32) as usize;
        let mut from = 0;
        while from < self.width {
            to = to.min(self.width);
            let start = order.len();
            order.extend((0..self.height).flat_map(|y| (from..to).map(move |x| y * self.width + x)));
            let block = &mut order[start..];
            sampler.shuffle(from as u32, block);
            // All of about the same size.
            let each = block.len().div_ceil(block.len().div_ceil(MEMBERS));
            let end = order.len();
            pools.extend((start..end).step_by(each).map(|i| i..end.min(i + each)));
            (from, to) = (to, to + BLOCK);
        }
    }
}

/// Who meets whom in one sample; used again and again.
#[derive(Clone, Debug, Default)]
pub struct Deal {
    order: Vec<usize>,
    pools: Vec<Range<usize>>,
}

impl Deal {
    /// The pixels of each pool.
    pub fn pools(&self) -> impl Iterator<Item = &[usize]> {
        self.pools.iter().map(|p| &self.order[p.clone()])
    }
}

/// How a picture is cut into tiles.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Of the picture.
    width: usize,
    height: usize,
    /// Of a tile, but for those at the right and at the bottom.
    columns: usize,
    rows: usize,
}

impl Grid {
    /// Of runs of at most so many neighbours.
    pub fn of_runs(width: usize, height: usize, most: usize) -> Grid {
        Grid { width, height, columns: most, rows: 1 }
    }

    /// Of tiles whose pixels pool their paths.
    pub fn of_pools(width: usize, height: usize) -> Grid {
        // Whole blocks, and about as many in each tile.
        let blocks = width.div_ceil(BLOCK);
        let columns = BLOCK * blocks.div_ceil(width.div_ceil(COLUMNS));
        Grid { width, height, columns, rows: BAND }
    }

    /// Rows of a tile.
    pub fn tile_rows(&self) -> usize {
        self.rows
    }

    /// The tile of a pixel.
    pub fn tile(&self, x: usize, y: usize) -> Tile {
        let (x, y) = (x - x % self.columns, y - y % self.rows);
        Tile { x, y, width: self.columns.min(self.width - x), height: self.rows.min(self.height - y) }
    }

    /// Rows of the tiles that some rows have a part in.
    fn rows(&self, first: usize, end: usize) -> Range<usize> {
        if first < end { first - first % self.rows..self.whole(end, self.height) } else { first..first }
    }

    /// Pixels of the tiles that some rows have a part in.
    pub fn pixels(&self, first: usize, end: usize) -> usize {
        self.width * self.rows(first, end).len()
    }

    /// All tiles that some rows have a part in.
    pub fn cover(&self, first: usize, end: usize) -> Vec<Tile> {
        let row = |y: usize| (0..self.width).step_by(self.columns).map(move |x| self.tile(x, y));
        self.rows(first, end).step_by(self.rows).flat_map(row).collect()
    }

    /// Where the tiles of a row end at the earliest, but not after `end`.
    pub fn whole(&self, row: usize, end: usize) -> usize {
        row.next_multiple_of(self.rows).min(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pixel is in one tile and there in one pool, whatever the size; parts have the tiles of the whole.
    #[test]
    fn each_pixel_is_dealt_once() {
        for (width, height) in [(1, 1), (7, 3), (8, 4), (65, 9), (130, 6), (1000, 2)] {
            for grid in [Grid::of_runs(width, height, 16), Grid::of_pools(width, height)] {
                let mut times = vec![0; width * height];
                for tile in grid.cover(0, height) {
                    assert_eq!(grid.tile(tile.x, tile.y), tile);
                    let mut deal = Deal::default();
                    tile.deal(&Sampler::new(1, 2, 3, 4), &mut deal);
                    assert!(deal.pools().all(|p| (1..=MEMBERS).contains(&p.len())));
                    for (x, y) in deal.pools().flatten().map(|i| tile.pixel(*i)) {
                        times[y as usize * width + x as usize] += 1;
                    }
                }
                assert!(times.iter().all(|t| *t == 1), "{width} x {height}");
                let last = grid.cover(height - 1, height);
                assert!(grid.cover(0, height).ends_with(&last));
                assert_eq!(last.iter().map(Tile::pixels).sum::<usize>(), grid.pixels(height - 1, height));
                assert!(grid.cover(height, height).is_empty());
            }
        }
    }
}
