//! pjoin: put bands of rows together, as `spectrace --rows` makes them: the bytes are those of the picture rendered in one go.
//!
//! A band says in its header, `ROWS= first end height`, which rows of which picture it has; the order of the files does not matter. A
//! single picture without that line passes as it is, so that `--format` can change its coding.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::codec::{self, Reading};
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::stream::meaning::Overrides;
use crate::stream::reader::Input;
use crate::stream::{Block, Header, Picture};
use crate::{Error, Result, clap_defaults, invalid};

/// The key of a band's rows.
const ROWS: &str = "ROWS";

/// Options of `pjoin`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pjoin {
    /// Bands of one picture, in any order, or one picture; '-' is standard input
    #[arg(value_name = "BAND", value_hint = ValueHint::FilePath, required = true)]
    pub bands: Vec<PathBuf>,
}
clap_defaults!(Pjoin);

impl Filter for Pjoin {
    const NAME: &'static str = "pjoin";
    const ABOUT: &'static str = "Put bands of rows of one picture together";
    const EXAMPLE: &'static str = "spectrace --rows 0:40 --width 80 scenes/cornell.toml - > top.lux && spectrace --rows 40:80 --width 80 scenes/cornell.toml - > rest.lux && pjoin top.lux rest.lux > cornell.lux";
    const READS: bool = false;
    const MANY: bool = true;
    const SIGNS: bool = false;

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        if let [one] = &self.bands[..] {
            let picture = open(one, run)?;
            return match picture.header().variable(ROWS) {
                None => Ok(Product::Picture(picture)),
                Some(_) => joined(vec![Band::of(one, picture.header())?], Some(picture), run),
            };
        }
        if let Some(file) = self.bands.iter().enumerate().find_map(|(i, b)| self.bands[..i].contains(b).then_some(b)) {
            return invalid!("{} is named twice", shown(file));
        }
        let band = |path: &PathBuf| Band::of(path, open(path, run)?.header());
        joined(self.bands.iter().map(band).collect::<Result<_>>()?, None, run)
    }
}

/// A band that has been looked at.
struct Band {
    path: PathBuf,
    /// First row, row after the last, rows of the whole.
    rows: [usize; 3],
    /// Its header as that of the whole.
    header: Header,
}

impl Band {
    fn of(path: &Path, header: &Header) -> Result<Band> {
        let name = shown(path);
        let Some(value) = header.variable(ROWS) else {
            return invalid!(
                "{name}: has no ROWS line, so it is a whole picture; expected what spectrace --rows makes"
            );
        };
        let numbers: Vec<usize> =
            String::from_utf8_lossy(value).split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let [first, end, height] = match numbers[..] {
            [a, b, h] if a < b && b <= h && h <= i32::MAX as usize => [a, b, h],
            _ => return invalid!("{name}: ROWS= {}: expected first row, row after the last, height", printable(value)),
        };
        if header.resolution.scanlines() != end - first {
            let has = header.resolution.scanlines();
            return invalid!("{name}: has {has} rows, and its ROWS line says {first} to {end}");
        }
        let mut whole = header.clone();
        whole.lines.retain(|l| !l.starts_with(b"ROWS="));
        whole.resolution = whole.resolution.with_scanlines(height);
        Ok(Band { path: path.to_path_buf(), rows: [first, end, height], header: whole })
    }
}

fn shown(path: &Path) -> String {
    if path == Path::new("-") { "standard input".into() } else { printable(path.as_os_str().as_encoded_bytes()) }
}

fn open(path: &Path, run: &Run) -> Result<Box<dyn Picture>> {
    let (overrides, limits) = (Overrides::default(), run.options.limits());
    codec::open(Input::open(Some(path))?, &Reading { overrides: &overrides, limits: &limits, notes: &run.notes })
}

/// The whole picture; `opened` is that of the only band, if it is at hand.
fn joined(mut bands: Vec<Band>, opened: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
    bands.sort_by_key(|b| b.rows);
    let Some(first) = bands.first() else { return Err(Error::Usage("expected a BAND".into())) };
    let (header, height) = (first.header.clone(), first.rows[2]);
    let bytes = header.to_bytes("float", &[]);
    let mut next = 0;
    for band in &bands {
        let ([from, end, of], name) = (band.rows, shown(&band.path));
        if of != height || band.header.to_bytes("float", &[]) != bytes {
            return invalid!("{name}: is of another picture than {}: their headers differ", shown(&first.path));
        }
        if from > next {
            return invalid!("rows {next} to {from} of {height} are missing; no band has them");
        }
        if from < next {
            return invalid!("{name}: begins with row {from}, and a band before it ends with row {}", next - 1);
        }
        next = end;
    }
    if next < height {
        return invalid!("rows {next} to {height} of {height} are missing; no band has them");
    }
    let mut rest: Vec<Band> = bands;
    rest.reverse();
    if opened.is_some() {
        rest.pop();
    }
    Ok(Product::Picture(Box::new(Joined { header, rest, current: opened, run: run.clone() })))
}

/// Bands one after the other.
struct Joined {
    header: Header,
    /// Those to come, the next one last.
    rest: Vec<Band>,
    current: Option<Box<dyn Picture>>,
    run: Run,
}

impl Picture for Joined {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        loop {
            if let Some(current) = &mut self.current
                && current.next(block)?
            {
                return Ok(true);
            }
            let Some(band) = self.rest.pop() else {
                self.current = None;
                block.rows = 0;
                block.data.clear();
                return Ok(false);
            };
            let picture = open(&band.path, &self.run)?;
            let again = Band::of(&band.path, picture.header())?;
            if again.rows != band.rows || again.header.ncomp != self.header.ncomp {
                return invalid!("{}: has changed while it was read", shown(&band.path));
            }
            self.current = Some(picture);
        }
    }
}
