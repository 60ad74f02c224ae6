//! What is handed on: the legend, and beside it the map with its marks.

use crate::chart::canvas::{Canvas, text_width};
use crate::chart::{BLACK, Colour, Map, WHITE, font, scale};
use crate::color::Primaries;
use crate::notes::Notes;
use crate::parallel;
use crate::statistics::Distribution;
use crate::stream::spool::{self, Limits};
use crate::stream::{Block, Components, Header, Picture, Resolution, Units, picture, tristimulus, writer};
use crate::{Result, invalid};

/// Rows of picture for each pixel of a letter's points.
const ROWS_A_POINT: usize = 400;
/// Share of a ground's pixels that may be brighter than white.
const WHITE_PERCENTILE: f64 = 98.0;

/// Size of a letter's points for a picture of that height.
pub fn point_size(height: usize) -> usize {
    ((height + ROWS_A_POINT / 2) / ROWS_A_POINT).clamp(1, 16)
}

/// A picture as linear RGB for a display, upright as it is: its brightest two hundredths white, unless it is display-referred.
pub fn shown_linearly(input: Box<dyn Picture>, limits: &Limits, notes: &Notes) -> Result<Box<dyn Picture>> {
    let grey = input.header().components == Components::Y;
    let input = if grey { input } else { tristimulus(input)? };
    let mut spread = Distribution::default();
    let n = input.header().ncomp;
    let input = spool::twice(input, limits, notes, |_, block| {
        let luminances = block.data.chunks_exact(n).map(|p| f64::from(p[usize::from(n == 3)]));
        luminances.filter(|y| *y >= 0.0 && y.is_finite()).for_each(|y| spread.add(y));
    })?;
    let display = input.header().units == Units::Display;
    let white = spread.percentile(WHITE_PERCENTILE).filter(|w| *w > 0.0).or(spread.max()).filter(|w| *w > 0.0);
    let factor = if display { 1.0 } else { white.map_or(1.0, |w| (1.0 / w) as f32) };
    let show = move |x: f32| if x.is_finite() { (x * factor).clamp(0.0, 1.0) } else { 0.0 };
    let mut header = input.header().clone();
    header.become_tristimulus(Components::Rgb, Units::Display);
    if grey {
        return Ok(picture::map_across(input, header, move |from, to| {
            to.chunks_exact_mut(3).zip(from).for_each(|(rgb, y)| rgb.fill(show(*y)));
        }));
    }
    let rgb = writer::to_rgb(input, Primaries::BT709)?;
    Ok(picture::map(rgb, header, move |pixels| pixels.iter_mut().for_each(|x| *x = show(*x))))
}

/// A drawing laid over the map, its upper left corner at (x, y).
struct Mark {
    x: i64,
    y: i64,
    canvas: Canvas,
}

impl Mark {
    /// A cross at a pixel and its value beside it, inside of a picture of that size.
    fn new((value, x, y): (f64, usize, usize), size: usize, width: usize, height: usize) -> Vec<Mark> {
        let (arm, thick) = (4 * size as i64, size as i64);
        let side = 2 * arm + 1 + 2 * thick;
        let mut cross = Canvas::new(side as usize, side as usize);
        let middle = side / 2;
        for (rim, colour) in [(thick, BLACK), (0, WHITE)] {
            let (long, wide) = (2 * arm + 1 + 2 * rim, thick + 2 * rim);
            cross.fill(middle - long / 2, middle - wide / 2, long, wide, colour);
            cross.fill(middle - wide / 2, middle - long / 2, wide, long, colour);
        }
        let text = scale::label(value);
        let rim = (thick + 1) / 2;
        let across = text_width(&text, size) as i64 + 2 * rim;
        let down = (font::CAPITAL * size) as i64 + 2 * rim;
        let mut number = Canvas::new(across as usize, down as usize);
        number.rimmed_text(rim, rim, size, &text, WHITE, BLACK);
        let (x, y) = (x as i64, y as i64);
        // To the right of the cross, or to the left where there is no room.
        let right = x + arm + 2 * thick;
        let left = if right + across <= width as i64 { right } else { (x - arm - 2 * thick - across).max(0) };
        let top = (y - down / 2).min(height as i64 - down).max(0);
        vec![Mark { x: x - middle, y: y - middle, canvas: cross }, Mark { x: left, y: top, canvas: number }]
    }

    fn at(&self, x: usize, y: usize) -> Option<Colour> {
        let (x, y) = (usize::try_from(x as i64 - self.x).ok()?, usize::try_from(y as i64 - self.y).ok()?);
        self.canvas.at(x, y)
    }
}

/// Where everything lies.
struct Layout {
    map: Map,
    legend: Option<Canvas>,
    marks: Vec<Mark>,
    /// Width and height of the map.
    size: (usize, usize),
}

/// Rows of the ground that have come, and the first of them.
#[derive(Default)]
struct Under {
    first: usize,
    rows: Vec<f32>,
}

/// The finished picture.
pub struct Sheet {
    header: Header,
    layout: Layout,
    ground: Option<Box<dyn Picture>>,
    under: Under,
    row: usize,
    block: Block,
}

impl Layout {
    fn colour(&self, x: usize, y: usize, under: &Under) -> Colour {
        let left = self.legend.as_ref().map_or(0, |l| l.width);
        if x < left {
            return self.legend.as_ref().and_then(|l| l.at(x, y)).unwrap_or(BLACK);
        }
        let x = x - left;
        if y >= self.size.1 {
            return BLACK;
        }
        if let Some(colour) = self.marks.iter().rev().find_map(|m| m.at(x, y)) {
            return colour;
        }
        let place = 3 * (y.saturating_sub(under.first) * self.size.0 + x);
        let ground = under.rows.get(place..place + 3).map(|p| [p[0], p[1], p[2]]);
        self.map.colour(x, y, ground)
    }
}

impl Sheet {
    /// `header` is the map's; it gets the legend's width. `marks` are values and places, `size` the points of letters.
    pub fn new(
        mut header: Header,
        map: Map,
        ground: Option<Box<dyn Picture>>,
        legend: Option<Canvas>,
        marks: &[(f64, usize, usize)],
        size: usize,
    ) -> Result<Sheet> {
        let (width, height) = (header.resolution.width, header.resolution.height);
        if let Some(r) =
            ground.as_ref().map(|g| g.header().resolution).filter(|r| (r.width, r.height) != (width, height))
        {
            return invalid!("the background has {} x {} pixels, the picture {width} x {height}", r.width, r.height);
        }
        let beside = legend.as_ref().map_or((0, 0), |l| (l.width, l.height));
        header.resolution = Resolution::upright(width + beside.0, height.max(beside.1));
        header.display = Some([0.0, 100.0]);
        header.white = None;
        header.adapted = None;
        if legend.is_some() {
            // Its angles are not those of the picture with a legend.
            header.lines.retain(|l| !l.starts_with(b"VIEW="));
        }
        let marks = marks.iter().flat_map(|m| Mark::new(*m, size, width, height)).collect();
        let layout = Layout { map, legend, marks, size: (width, height) };
        Ok(Sheet { header, layout, ground, under: Under::default(), row: 0, block: Block::default() })
    }

    /// Rows of the ground up to `end`, those before `first` forgotten.
    fn fetch(&mut self, first: usize, end: usize) -> Result<()> {
        let Some(ground) = &mut self.ground else { return Ok(()) };
        let (floats, under) = (3 * self.layout.size.0, &mut self.under);
        under.rows.drain(..((first - under.first) * floats).min(under.rows.len()));
        under.first = first;
        while under.rows.len() < (end - first) * floats && ground.next(&mut self.block)? {
            under.rows.extend_from_slice(&self.block.data);
        }
        Ok(())
    }
}

impl Picture for Sheet {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let r = self.header.resolution;
        let rows = picture::block_rows(&self.header, r.height - self.row).min(r.height - self.row);
        block.rows = rows;
        block.data.clear();
        if rows == 0 {
            return Ok(false);
        }
        let first = self.row;
        let end = self.layout.size.1;
        self.fetch(first.min(end), (first + rows).min(end))?;
        block.data.resize(3 * r.width * rows, 0.0);
        let (layout, under) = (&self.layout, &self.under);
        let work = |start: usize, piece: &mut [f32]| {
            for (i, pixel) in piece.chunks_exact_mut(3).enumerate() {
                let i = start + i;
                pixel.copy_from_slice(&layout.colour(i % r.width, first + i / r.width, under));
            }
        };
        parallel::for_pieces(&mut block.data, 3, work);
        self.row += rows;
        Ok(true)
    }
}
