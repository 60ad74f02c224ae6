//! Local tone mapping: technique D of [Ward 2001], in the retinex tradition. Shadows and lights far apart are brought together,
//! while neighbours keep their contrast.
//!
//! With u = ln L (the papers write log10; a logarithm's base cancels), a method splits u = b + d into a base b that varies
//! slowly and detail d, and the display luminance is
//!
//! ln Ld = p b + q d + shift
//!
//! - **base-detail** [Durand 2002]: b is edge-preserving (here the guided filter, see `guided`; theirs was bilateral). The base is
//!   compressed, p = c, and the detail multiplied by a number k, q = k (1 keeps it). With W the range of b and R = ln(white / black)
//!   the display's, c0 = min(1, R / W). What c0 b + k d has more than R is the detail's, and the base yields:
//!   c = c0 - excess / W, at least c0 / 2. A scene that fits is left linear.
//! - **retinex** [Jobson 1997]: b is the mean of ln of Gaussian surrounds (see `retinex`) and goes altogether, p = 0;
//!   q = k min(1, R / range of k d), which is their gain fitted to the display, never an amplification.
//!
//! A strength s takes both factors on the straight way from 1 (the world's contrast) to the method's, p = 1 - s + s c, and
//! likewise q, so that 0 is the linear map and no step of s makes a jump. Ranges and the shift are those of `spread`.
//!
//! Halos, measured at a step of 1 : 1000 on a display of 1 : 100 with scale 0.02 for both (`cargo test --test plocal halo --
//! --nocapture`: how far ln Ld leaves its level of the far field, near the edge): base-detail 0.023, retinex 4.1 of the
//! display's 4.6; the test holds base-detail under 0.05. Both show equal luminances unequal by intent, so the display's
//! luminances cannot be taken back to the world's.

pub mod cells;
pub mod guided;
pub mod retinex;
pub mod spread;

use std::sync::{Mutex, PoisonError};

use crate::parallel;
use crate::tone::Display;
use cells::Plane;
use guided::Guided;
use retinex::Surround;
use spread::Spread;

/// What no eye sees counts as black: 2^-24 = 6e-8 cd/m2.
const DARKEST_CD_M2: f32 = 1.0 / (1 << 24) as f32;
/// Where black lies under the least luminance, in ln L: near enough that a black frame does not decide the base.
const BLACK: f32 = -1.0;

/// How u is split, lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Guided filter; a step of ln L = `edge` is neither all detail nor all edge.
    BaseDetail {
        /// Radius of a window.
        radius: usize,
        /// The square root of the penalty, in ln L.
        edge: f64,
    },
    /// Gaussian surrounds.
    Retinex {
        /// Standard deviation of the middle one.
        scale: f64,
    },
}

impl Method {
    /// Pixels along a cell's side.
    fn side(&self) -> usize {
        match self {
            Method::BaseDetail { radius, .. } => guided::side(*radius),
            Method::Retinex { scale } => retinex::side(scale * retinex::SIGMAS[0]),
        }
    }

    /// Bytes that mapping `pixels` of them holds at most: ln L, and planes of cells while these are made.
    pub fn bytes(&self, pixels: u64) -> u64 {
        4 * pixels + 6 * 4 * pixels.div_ceil((self.side() as u64).pow(2))
    }
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amount {
    /// 0 the linear map, 1 all of the method.
    pub strength: f64,
    /// Factor of the detail's contrast; 1 keeps it.
    pub detail: f64,
}

/// ln of a picture's luminances in the order of its scanlines, as they come in.
#[derive(Clone, Debug)]
pub struct Luminances {
    ln: Vec<f32>,
    width: usize,
}

impl Luminances {
    /// None yet, for scanlines of `width` pixels, `pixels` in all.
    pub fn new(width: usize, pixels: usize) -> Luminances {
        let mut ln = Vec::new();
        let _ = ln.try_reserve_exact(pixels); // a hint: a damaged size ends with the data
        Luminances { ln, width }
    }

    /// Takes in scanlines of XYZ in cd/m2. What is black, negative or not finite has no logarithm.
    pub fn add(&mut self, xyz: &[f32]) {
        let first = self.ln.len();
        self.ln.resize(first + xyz.len() / 3, f32::NEG_INFINITY);
        parallel::for_pieces(&mut self.ln[first..], 1, |at, piece| {
            for (ln, pixel) in piece.iter_mut().zip(xyz[3 * at..].chunks_exact(3)) {
                let seen = pixel[1] >= DARKEST_CD_M2 && pixel.iter().all(|x| x.is_finite());
                *ln = if seen { pixel[1].ln() } else { f32::NEG_INFINITY };
            }
        });
    }

    /// Maps them to a display; `None` when all are black.
    pub fn mapped(self, method: Method, amount: Amount, display: Display) -> Option<Mapped> {
        let Luminances { mut ln, width } = self;
        let least = ln.iter().fold(f32::MAX, |m, u| if *u > f32::NEG_INFINITY { m.min(*u) } else { m });
        if least == f32::MAX {
            return None;
        }
        // From here on u is over the least: the same world in other units gives the same numbers.
        let lift = |u: &mut f32| *u = if *u > f32::NEG_INFINITY { *u - least } else { BLACK };
        parallel::for_pieces(&mut ln, 1, |_, piece| piece.iter_mut().for_each(lift));
        let plane = Plane { values: &ln, width };
        let base = match method {
            Method::BaseDetail { radius, edge } => Base::Guided(Guided::new(plane, radius, (edge * edge) as f32)),
            Method::Retinex { scale } => Base::Surround(Surround::new(plane, scale)),
        };
        let mut split = Split { ln, width, base };
        let (black, white) = display.seen().ln();
        let full = split.fitted(method, amount.detail as f32, white - black);
        let toward = |x: f32| (1.0 + amount.strength * (f64::from(x) - 1.0)) as f32;
        let (p, q) = (toward(full.0), toward(full.1));
        let spread = split.each(true, |b, d| p * b + q * d);
        Some(Mapped { ln: split.ln, shift: spread.shift(black, white), display })
    }
}

enum Base {
    Guided(Guided),
    Surround(Surround),
}

/// u, and what splits it.
struct Split {
    ln: Vec<f32>,
    width: usize,
    base: Base,
}

impl Split {
    /// How f(base, detail) is spread over all pixels that have a luminance. With `store` it takes the place of u, and is minus
    /// infinity where there is none.
    fn each(&mut self, store: bool, f: impl Fn(f32, f32) -> f32 + Sync) -> Spread {
        let all = Mutex::new(Spread::default());
        let (width, base) = (self.width, &self.base);
        parallel::for_pieces(&mut self.ln, width, |first, piece| {
            let (mut seen, mut line) = (Spread::default(), Vec::new());
            for (y, row) in (first..).zip(piece.chunks_exact_mut(width)) {
                match base {
                    Base::Guided(g) => g.row(y, row, &mut line),
                    Base::Surround(s) => s.row(y, &mut line),
                }
                for (u, b) in row.iter_mut().zip(&line) {
                    let lit = *u > BLACK;
                    let v = f(*b, *u - b);
                    if lit {
                        seen.add(v);
                    }
                    if store {
                        *u = if lit { v } else { f32::NEG_INFINITY };
                    }
                }
            }
            all.lock().unwrap_or_else(PoisonError::into_inner).merge(&seen);
        });
        all.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// The factors p and q of the whole method, for a display of `room` in ln L.
    fn fitted(&mut self, method: Method, detail: f32, room: f64) -> (f32, f32) {
        if let Method::Retinex { .. } = method {
            let range = self.each(false, |_, d| detail * d).width(room);
            return (0.0, detail * (room / range).min(1.0) as f32);
        }
        let range = self.each(false, |b, _| b).width(room);
        let compressed = (room / range).min(1.0);
        let c = compressed as f32;
        let excess = (self.each(false, |b, d| c * b + detail * d).width(room) - room).max(0.0);
        // A constant picture has no range, and its quotient is not a number.
        let yielded = if excess > 0.0 { excess / range } else { 0.0 };
        ((compressed - yielded).max(compressed / 2.0) as f32, detail)
    }
}

/// Display luminances in the order of the scanlines.
pub struct Mapped {
    /// ln Ld without the shift; minus infinity where the world is black.
    ln: Vec<f32>,
    shift: f64,
    display: Display,
}

/// How many pixels of a piece had to be limited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// Over the display's white.
    pub white: u64,
    /// Under its black, though not black.
    pub black: u64,
}

impl Limited {
    /// Adds those of another piece.
    pub fn add(&mut self, other: Limited) {
        self.white += other.white;
        self.black += other.black;
    }
}

/// ln Ld that far beyond black or white is rounding.
const ROUNDING: f64 = 1e-4;

impl Mapped {
    /// Replaces `shares` by the display values of the pixels from `first` on, 0 black to 1 white, as many as there are.
    pub fn shares(&self, first: usize, shares: &mut [f32]) -> Limited {
        let Display { min_cd_m2, max_cd_m2 } = self.display;
        let (low, high) = ((min_cd_m2.ln() - ROUNDING) as f32, (max_cd_m2.ln() + ROUNDING) as f32);
        let (min, per_range, shift) = (min_cd_m2 as f32, 1.0 / (max_cd_m2 - min_cd_m2) as f32, self.shift as f32);
        let mut limited = Limited::default();
        for (share, v) in shares.iter_mut().zip(&self.ln[first..]) {
            let ln = v + shift;
            limited.white += u64::from(ln > high);
            limited.black += u64::from(ln < low && ln > f32::NEG_INFINITY);
            *share = ((ln.exp() - min) * per_range).clamp(0.0, 1.0);
        }
        limited
    }
}
