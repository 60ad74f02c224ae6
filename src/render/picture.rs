//! A scene rendered as a picture: rows on demand, pixels on all threads, each the same whatever the order.

use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use crate::error::printable;
use crate::notes::Notes;
use crate::render::checkpoint::Checkpoint;
use crate::render::estimate::{Effort, Estimate, NEIGHBOURS, Probe, Quality, Quantity, What, estimator};
use crate::render::method::Choice;
use crate::render::sampler::shared_well;
use crate::render::tile::{Grid, Tile};
use crate::scene::Scene;
use crate::stream::meaning::{LAYER, LAYERS_OF, MOST_COMPONENTS};
use crate::stream::{Block, Components, Header, Picture, Resolution, Units};
use crate::{Result, invalid, parallel};

/// What to render.
pub struct Job {
    /// What a pixel holds.
    pub quantity: Quantity,
    /// How Eq. (1) is solved.
    pub method: Choice,
    /// Work a pixel.
    pub effort: Work,
    /// Rows from and to (not included).
    pub rows: (usize, usize),
    /// Progress on standard error.
    pub progress: bool,
    /// Rows that were rendered before, and where further ones are kept.
    pub checkpoint: Option<Checkpoint>,
    /// For what is to be said at the end.
    pub notes: Notes,
}

/// How much work a picture is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Work {
    /// The same for each pixel.
    Each(Effort),
    /// As many paths a pixel as fit into this time, found by a trial.
    Time(Duration),
}

/// Pixels rendered at a time, so many times the rows of a tile: enough that all threads stay busy.
const PIXELS_A_BLOCK: usize = 8192;
/// The same where rows are kept: a kill loses no more than these, or one row of tiles.
const PIXELS_KEPT: usize = 512;
/// Numbers rendered at a time at most, but for a row of tiles.
const MOST_VALUES: usize = 1 << 22;

/// A render in progress.
struct Rendering {
    header: Header,
    width: usize,
    grid: Grid,
    row: usize,
    end: usize,
    first: usize,
    estimate: Arc<dyn Estimate>,
    effort: Effort,
    bar: ProgressBar,
    checkpoint: Option<Checkpoint>,
    notes: Notes,
    tally: Tally,
}

/// What the pixels came to so far.
#[derive(Clone, Copy, Default)]
struct Tally {
    pixels: u64,
    paths: u64,
    short: u64,
    worst: f64,
    error2: f64,
}

impl Tally {
    fn of(quality: &[Quality]) -> Tally {
        quality.iter().fold(Tally::default(), |t, q| {
            let error = if q.luminance > 0.0 { q.standard_error / q.luminance } else { 0.0 };
            t.with(&Tally { pixels: 1, paths: q.paths, short: u64::from(q.short), worst: error, error2: error * error })
        })
    }

    fn with(&self, o: &Tally) -> Tally {
        Tally {
            pixels: self.pixels + o.pixels,
            paths: self.paths + o.paths,
            short: self.short + o.short,
            worst: self.worst.max(o.worst),
            error2: self.error2 + o.error2,
        }
    }

    /// Root of the mean squared relative error.
    fn error(&self) -> f64 {
        (self.error2 / self.pixels.max(1) as f64).sqrt()
    }
}

/// Begins a render; rows are computed as they are read. `history` is the line that it leaves, with the paths that the time
/// allows where it was given one.
pub fn render(
    scene: impl Into<Arc<Scene>>,
    job: Job,
    history: impl Fn(Option<u32>) -> Vec<u8>,
) -> Result<Box<dyn Picture>> {
    let scene = scene.into();
    let Some(camera) = &scene.camera else { return invalid!("the scene has no [camera]") };
    let (width, height) = (camera.width, camera.height);
    let count = job.quantity.sampling.count();
    let (components, ncomp) = match job.quantity.what {
        What::Spectrum => (Components::Spectrum, count),
        What::Stokes => (Components::Stokes, 4 * count),
        What::Layers => (Components::Layers, scene.lights.len() * count),
        What::Xyz | What::Lighting => (Components::Xyz, 3),
    };
    if ncomp > MOST_COMPONENTS {
        return invalid!("{ncomp} components a pixel; at most {MOST_COMPONENTS}: take fewer --bands");
    }
    let spectrum = components != Components::Xyz;
    let units = match components {
        Components::Layers => Units::Number,
        Components::Xyz => Units::CdM2,
        _ => Units::SpectralRadiance,
    };
    let (first, end) = job.rows;
    let mut header = Header::new(Resolution::upright(width, end - first), components, ncomp, units);
    header.white = scene.white()?;
    if header.white.is_none() && !spectrum && !scene.fluoresces() {
        return invalid!("no surface of the scene gives off visible light");
    }
    header.sampling = spectrum.then(|| job.quantity.sampling.clone());
    match camera.view() {
        Some(view) => header.lines.push(format!("VIEW= {view}").into_bytes()),
        None => header.lines.push(b"PROJECTION=latlong".to_vec()),
    }
    if (first, end) != (0, height) {
        header.lines.push(format!("ROWS= {first} {end} {height}").into_bytes());
    }
    if components == Components::Layers {
        header.lines.push(format!("{LAYERS_OF}= {:016x}", scene.fingerprint()).into_bytes());
    }
    for light in scene.lights.iter().filter(|_| components == Components::Layers) {
        header.lines.push([LAYER, b" ", printable(light.name.as_bytes()).as_bytes()].concat());
    }
    let estimate = estimator(scene.clone(), &job.quantity, &job.method)?;
    let (effort, paths) = match job.effort {
        Work::Each(effort) => (effort, None),
        Work::Time(time) => {
            let paths = paths_within(&*estimate, time, 0.05 * time.as_secs_f64(), (width, height), (first, end));
            job.notes.add(format!("{paths} paths a pixel; --samples {paths} gives the same picture"));
            (Effort::Paths(paths), Some(paths))
        }
    };
    header.lines.insert(0, history(paths));
    let target = if job.progress { ProgressDrawTarget::stderr_with_hz(4) } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some((end - first) as u64), target);
    if let Ok(style) = ProgressStyle::with_template("spectrace {wide_bar} row {pos} of {len}, {eta} left{msg}") {
        bar.set_style(style);
    }
    let (checkpoint, notes, tally) = (job.checkpoint, job.notes, Tally::default());
    let grid = grid(&*estimate, effort, (width, height), NEIGHBOURS);
    Ok(Box::new(Rendering {
        header,
        width,
        grid,
        row: first,
        end,
        first,
        estimate,
        effort,
        bar,
        checkpoint,
        notes,
        tally,
    }))
}

/// Renders a tile.
fn shade(estimate: &dyn Estimate, effort: Effort, tile: &Tile) -> (Vec<f32>, Tally) {
    let mut out = vec![0.0; tile.pixels() * estimate.components()];
    if let Some(paths) = pooled(estimate, effort) {
        estimate.tile(tile, paths, &mut out);
        let pixels = tile.pixels() as u64;
        return (out, Tally { pixels, paths: pixels * u64::from(paths), ..Tally::default() });
    }
    let (x, y) = tile.pixel(0);
    let mut probes = [Probe::Pixel { x, y }; NEIGHBOURS];
    for (i, p) in probes.iter_mut().enumerate() {
        *p = Probe::Pixel { x: x + i as u32, y };
    }
    let quality = estimate.measure(&probes[..tile.width], effort, &mut out);
    (out, Tally::of(&quality[..tile.width]))
}

/// Paths a pixel, where they are pooled: not where each pixel has as many as it needs.
fn pooled(estimate: &dyn Estimate, effort: Effort) -> Option<u32> {
    match effort {
        Effort::Paths(paths) if estimate.pools() => Some(paths),
        _ => None,
    }
}

/// How a picture is cut; where paths are not pooled into runs of at most so many pixels.
fn grid(estimate: &dyn Estimate, effort: Effort, (width, height): (usize, usize), most: usize) -> Grid {
    match pooled(estimate, effort) {
        Some(_) => Grid::of_pools(width, height),
        None => Grid::of_runs(width, height, most),
    }
}

/// As many paths a pixel as fit into the time and share a pixel well, from a trial of some seconds on pixels spread over the picture.
pub fn paths_within(
    estimate: &dyn Estimate,
    time: Duration,
    trial_s: f64,
    (width, height): (usize, usize),
    (first, end): (usize, usize),
) -> u32 {
    let start = Instant::now();
    // By itself a pixel is tried alone, so that many places of the picture are.
    let grid = grid(estimate, Effort::Paths(1), (width, height), 1);
    let tiles = if grid.tile_rows() > 1 { 2 * rayon::current_num_threads() } else { 64 };
    let pixels = width * (end - first);
    let mut done = 0u64;
    let mut paths = 1;
    let mut took = Duration::ZERO;
    // A golden-ratio walk comes by all parts of the picture.
    let mut at = 0.5f64;
    while start.elapsed().as_secs_f64() < trial_s || done == 0 {
        let batch: Vec<Tile> = (0..tiles)
            .map(|_| {
                at = (at + 0.618_033_988_749_894_9).fract();
                let i = ((at * pixels as f64) as usize).min(pixels - 1);
                grid.tile(i % width, first + i / width)
            })
            .collect();
        let one = |tile: &Tile| drop(shade(estimate, Effort::Paths(paths), tile));
        let begin = Instant::now();
        if parallel::pool() {
            batch.par_iter().for_each(one)
        } else {
            batch.iter().for_each(one)
        }
        took += begin.elapsed();
        done += batch.iter().map(Tile::pixels).sum::<usize>() as u64 * u64::from(paths);
        paths = (paths * 2).min(64);
    }
    let left = time.saturating_sub(start.elapsed()).as_secs_f64();
    let rate = done as f64 / took.as_secs_f64().max(1e-9);
    shared_well(((rate * left / grid.pixels(first, end) as f64) as u32).max(1))
}

impl Rendering {
    /// Renders rows into `data`.
    fn fill(&mut self, rows: usize, data: &mut [f32]) {
        let (estimate, effort) = (&*self.estimate, self.effort);
        let tiles = self.grid.cover(self.row, self.row + rows);
        let one = |tile: &Tile| shade(estimate, effort, tile);
        // Tallies are gathered in order, so that sums do not depend on the threads.
        let done: Vec<(Vec<f32>, Tally)> =
            if parallel::pool() { tiles.par_iter().map(one).collect() } else { tiles.iter().map(one).collect() };
        let n = self.header.ncomp;
        for (tile, (values, tally)) in tiles.iter().zip(&done) {
            for (y, line) in (tile.y..).zip(values.chunks_exact(tile.width * n)) {
                if (self.row..self.row + rows).contains(&y) {
                    let at = (y - self.row) * self.width + tile.x;
                    data[at * n..][..line.len()].copy_from_slice(line);
                }
            }
            self.tally = self.tally.with(tally);
        }
    }

    fn finish(&mut self) {
        self.bar.finish_and_clear();
        if let Effort::Error { target, most } = self.effort {
            let Tally { pixels, paths, short, .. } = self.tally;
            if short > 0 {
                self.notes.add(format!(
                    "{short} of {pixels} pixels missed --error {target} within {most} paths; the worst has {:.3}",
                    self.tally.worst
                ));
            } else if pixels > 0 {
                self.notes.add(format!("{:.1} paths a pixel", paths as f64 / pixels as f64));
            }
        }
        self.estimate.report(&self.notes);
    }
}

impl Picture for Rendering {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let runs = if self.checkpoint.is_some() { PIXELS_KEPT } else { PIXELS_A_BLOCK };
        // As many tiles as there would be runs.
        let pixels = (runs * self.grid.tile_rows()).min(MOST_VALUES / self.header.ncomp);
        // A tile is rendered once, if it is not cut by the rows that are asked for.
        let rows = self.grid.whole(self.row + pixels.div_ceil(self.width), self.end) - self.row;
        let n = self.header.ncomp;
        block.rows = rows;
        block.data.resize(rows * self.width * n, 0.0);
        let mut data = std::mem::take(&mut block.data);
        let known = match &mut self.checkpoint {
            Some(c) => c.recall(self.row - self.first, &mut data)?,
            None => false,
        };
        if !known {
            self.fill(rows, &mut data);
            if let Some(c) = &mut self.checkpoint {
                c.keep(self.row - self.first, &data)?;
            }
        }
        block.data = data;
        self.row += rows;
        if matches!(self.effort, Effort::Error { .. }) {
            self.bar.set_message(format!(", error {:.4}", self.tally.error()));
        }
        self.bar.set_position((self.row - self.first) as u64);
        if rows > 0 && self.row == self.end {
            // Not when more is asked for: who knows the height may never ask.
            self.finish();
        }
        if rows == 0
            && let Some(c) = self.checkpoint.take()
        {
            c.remove()?;
        }
        Ok(rows > 0)
    }
}
