//! pmix: weighted sums and differences of pictures, pixel by pixel.
//!
//! Light adds up, so a thing that was rendered can be put into a photographed place with its shadows and reflections: render the place as
//! it was modelled, with and without the thing, and add the difference to the photograph: plate + with - without (differential
//! rendering [Debevec 1998]). Sums are taken in double precision and rounded once, so that what is alike in both renders cancels.
//!
//! Pictures must have one size and one unit. Where their components differ (RGB and XYZ, say) the sum is XYZ. The header is the input's;
//! those of the others stand below it, indented, as in Radiance's `pcomb`.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::codec::{self, Reading};
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::notes::Notes;
use crate::stream::meaning::Overrides;
use crate::stream::picture::Side;
use crate::stream::reader::Input;
use crate::stream::{Block, Header, Picture, tristimulus};
use crate::{Error, Result, clap_defaults, files, invalid, string_serde, usage};

/// Whites farther apart than this in xy are worth a word.
const ONE_WHITE: f64 = 0.003;

/// A picture and how much of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Factor.
    pub weight: f64,
    /// Its file.
    pub path: PathBuf,
}

impl FromStr for Term {
    type Err = Error;
    fn from_str(s: &str) -> Result<Term> {
        let weighted = s.split_once(':').and_then(|(w, path)| Some((w.parse::<f64>().ok()?, path)));
        let (weight, path) = weighted.unwrap_or((1.0, s));
        // What begins with a dash is an option that was meant.
        if !weight.is_finite() || path.is_empty() || path.starts_with('-') {
            return invalid!(
                "'{}' is no picture; give FILE, or WEIGHT:FILE such as 0.5:b.lux",
                printable(s.as_bytes())
            );
        }
        Ok(Term { weight, path: path.into() })
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.weight {
            1.0 => write!(f, "{}", self.path.display()),
            weight => write!(f, "{weight}:{}", self.path.display()),
        }
    }
}
string_serde!(Term);

/// Options of `pmix`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pmix {
    /// Factor of the input
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub weight: f64,
    /// Add a picture, or so much of it; once for each
    #[arg(long, value_name = "[WEIGHT:]FILE", value_hint = ValueHint::Other, allow_hyphen_values = true)]
    pub add: Vec<Term>,
    /// Take a picture away, or so much of it; once for each
    #[arg(long, value_name = "[WEIGHT:]FILE", value_hint = ValueHint::Other, allow_hyphen_values = true)]
    pub subtract: Vec<Term>,
}
clap_defaults!(Pmix);

impl Filter for Pmix {
    const NAME: &'static str = "pmix";
    const ABOUT: &'static str = "Add and subtract pictures, each with a weight: plate + with - without";
    const EXAMPLE: &'static str = "pmix plate.hdr --add with.lux --subtract without.lux > mixed.lux\npmix --weight 0.5 left.lux --add 0.5:right.lux > mean.lux";

    fn look_ahead(&self) -> Result<Option<usize>> {
        for term in self.add.iter().chain(&self.subtract) {
            files::open(&term.path).map_err(|e| Error::io(term.path.display().to_string(), e))?;
        }
        Ok(None)
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if !self.weight.is_finite() {
            return usage!("--weight {} is no factor", self.weight);
        }
        let negative = self.subtract.iter().map(|t| Term { weight: -t.weight, ..t.clone() });
        let terms: Vec<Term> = self.add.iter().cloned().chain(negative).collect();
        let (overrides, limits) = (Overrides::default(), run.options.limits());
        let reading = Reading { overrides: &overrides, limits: &limits, notes: &run.notes };
        let open = |t: &Term| codec::open(Input::open(Some(&t.path))?, &reading);
        let mut pictures = vec![input];
        for term in &terms {
            pictures.push(open(term)?);
        }
        let unlike = |b: &Header| {
            let a = pictures[0].header();
            a.components != b.components || a.ncomp != b.ncomp || a.sampling != b.sampling || a.primaries != b.primaries
        };
        if pictures.iter().any(|p| unlike(p.header())) {
            pictures = pictures.into_iter().map(tristimulus).collect::<Result<_>>()?;
        }
        let mut header = pictures[0].header().clone();
        for (picture, term) in pictures[1..].iter().zip(&terms) {
            check(&header, picture.header(), &term.path, &run.notes)?;
        }
        for (picture, term) in pictures[1..].iter().zip(&terms) {
            header.lines.push(format!("\t{}:", shown(&term.path)).into_bytes());
            header.lines.extend(picture.header().lines.iter().map(|l| [b"\t", &l[..]].concat()));
        }
        let weights = [self.weight].into_iter().chain(terms.iter().map(|t| t.weight)).collect();
        let sides = pictures.into_iter().map(Side::new).collect();
        Ok(Product::Picture(Box::new(Sum {
            header,
            sides,
            weights,
            sum: Vec::new(),
            below: 0,
            notes: run.notes.clone(),
        })))
    }
}

/// The last part of a file's name: what the history keeps.
fn shown(path: &Path) -> String {
    printable(path.file_name().unwrap_or(path.as_os_str()).as_encoded_bytes())
}

/// Refuses what cannot be added.
fn check(own: &Header, other: &Header, path: &Path, notes: &Notes) -> Result<()> {
    let name = shown(path);
    if own.resolution != other.resolution {
        let (a, b) = (own.resolution, other.resolution);
        return invalid!("{name}: is '{b}', the input '{a}'; pictures of one size and orientation can be added");
    }
    if own.units != other.units || own.display != other.display {
        let of = |h: &Header| {
            h.display.map_or(h.units.to_string(), |d| format!("{} for {} to {} cd/m2", h.units, d[0], d[1]))
        };
        return invalid!("{name}: is in {}, the input in {}; only like can be added", of(other), of(own));
    }
    if let (Some(a), Some(b)) = (own.white, other.white)
        && a.distance(b) > ONE_WHITE
    {
        notes.add(format!("{name} has the white {b}, the input {a}, which is kept"));
    }
    Ok(())
}

/// Pictures being added.
struct Sum {
    header: Header,
    sides: Vec<Side>,
    weights: Vec<f64>,
    sum: Vec<f64>,
    /// Pixels with a component below 0.
    below: u64,
    notes: Notes,
}

impl Picture for Sum {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let per_row = self.header.scanline_floats();
        let mut floats = usize::MAX;
        for side in &mut self.sides {
            // All end together: they have one size.
            if !side.fill()? {
                if self.below > 0 {
                    let n = std::mem::take(&mut self.below);
                    self.notes.add(format!("{n} pixels of the sum are below 0 somewhere; they are kept as they are"));
                }
                block.rows = 0;
                block.data.clear();
                return Ok(false);
            }
            floats = floats.min(side.rest().len());
        }
        // Blocks are whole rows.
        self.sum.clear();
        self.sum.resize(floats, 0.0);
        for (side, weight) in self.sides.iter_mut().zip(&self.weights) {
            self.sum.iter_mut().zip(side.rest()).for_each(|(s, x)| *s += weight * f64::from(*x));
            side.take(floats);
        }
        block.rows = floats / per_row;
        block.data.clear();
        block.data.extend(self.sum.iter().map(|s| *s as f32));
        self.below += block.data.chunks_exact(self.header.ncomp).filter(|p| p.iter().any(|x| *x < 0.0)).count() as u64;
        Ok(true)
    }
}
