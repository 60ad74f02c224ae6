//! Pictures in memory, and how far one lies from another, by the one Delta E of HDR pictures ([`crate::compare`]).

use std::path::Path;

use crate::codec::{self, Reading};
use crate::color::Xy;
use crate::compare::{Difference, Totals, Viewing};
use crate::notes::Notes;
use crate::statistics::Distribution;
use crate::stream::meaning::Overrides;
use crate::stream::reader::Input;
use crate::stream::upright::upright;
use crate::stream::{Block, Header, spool, tristimulus};
use crate::{Result, invalid};

/// A picture: XYZ in cd/m2.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Its header.
    pub header: Header,
    /// X, Y and Z of each pixel, rows top down.
    pub xyz: Vec<f32>,
}

/// How far one lies from the reference.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// Root of the relative mean square error of Y, as pcompare prints its square.
    pub relative_rmse: f64,
    /// Root of the mean square of Delta E 2000.
    pub rms: f64,
    /// What 95 % of pixels stay below.
    pub p95: f64,
    /// Delta E 2000 of each pixel.
    pub map: Vec<f32>,
}

impl Seen {
    /// Any picture file.
    pub fn read(path: &Path, limits: &spool::Limits) -> Result<Seen> {
        let (overrides, notes) = (Overrides::default(), Notes::default());
        let reading = Reading { overrides: &overrides, limits, notes: &notes };
        let picture = tristimulus(codec::open(Input::open(Some(path))?, &reading)?).map_err(|e| e.in_file(path))?;
        let mut picture = upright(picture, limits)?;
        let (mut xyz, mut block) = (Vec::new(), Block::default());
        while picture.next(&mut block)? {
            xyz.extend_from_slice(&block.data);
        }
        Ok(Seen { header: picture.header().clone(), xyz })
    }

    /// Chromaticity of its white.
    pub fn white(&self) -> Xy {
        self.header.white.unwrap_or(Xy::D65)
    }

    /// Y that counts as white: the 99th percentile, without the pixels that `lamps` lights.
    pub fn white_y(&self, lamps: &[f32]) -> Result<f64> {
        let mut all = Distribution::default();
        let y = self.xyz.chunks_exact(3).map(|p| p[1]).enumerate();
        let plain = |i: usize| lamps.get(3 * i + 1).is_none_or(|y| *y == 0.0);
        y.filter(|(i, y)| plain(*i) && y.is_finite()).for_each(|(_, y)| all.add(f64::from(y)));
        match all.percentile(99.0) {
            Some(y) if y > 0.0 => Ok(y),
            _ => invalid!("the picture is black"),
        }
    }

    /// Errors of another against this.
    pub fn errors_of(&self, other: &Seen, white_y: f64, gain: f64) -> Result<Errors> {
        if self.xyz.len() != other.xyz.len() {
            return invalid!("pictures of unlike sizes");
        }
        let viewing = Viewing { white: self.white().xyz().map(|x| x * white_y), gain, shown: None };
        let mut each: Vec<Difference> = Vec::new();
        viewing.differences(&other.xyz, &self.xyz, &mut each);
        let mut totals = Totals::default();
        totals.add(&each, &viewing);
        let squares: f64 = each.iter().map(|d| d.e2000 * d.e2000).sum();
        Ok(Errors {
            relative_rmse: totals.relative_mse().sqrt(),
            rms: (squares / totals.count().max(1) as f64).sqrt(),
            p95: totals.e2000.percentile(95.0).unwrap_or(f64::NAN),
            map: each.iter().map(|d| d.e2000 as f32).collect(),
        })
    }
}
