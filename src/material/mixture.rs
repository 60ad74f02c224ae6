//! `type = "mixture"`: parts of other materials side by side, finer than can be seen. `of = ["rust", "steel"]`, `shares =
//! [0.3, 0.7]`; shares that sum to less than 1 leave holes that are black.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::material::read::{Reader, named};
use crate::material::{Effects, Lobes, MOST_LOBES, Material, Site};

/// A weighted sum of materials.
pub struct Mixture(pub Vec<(f32, Arc<dyn Material>)>);

impl Material for Mixture {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        for (share, part) in &self.0 {
            let from = lobes.len();
            part.lobes(site, out, lobes);
            lobes.scale(from, *share);
        }
    }

    fn is_clear(&self) -> bool {
        self.0.iter().any(|(_, m)| m.is_clear())
    }

    fn effects(&self) -> Effects {
        self.0.iter().fold(Effects::default(), |e, (_, m)| e.or(m.effects()))
    }

    fn interior(&self) -> Option<u32> {
        self.0.iter().find_map(|(_, m)| m.interior())
    }

    fn axis(&self, site: &Site) -> Option<DVec3> {
        self.0.iter().find_map(|(_, m)| m.axis(site))
    }

    fn looks_at_site(&self) -> bool {
        self.0.iter().any(|(_, m)| m.looks_at_site())
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let names: Vec<String> = r.keys.need("of")?;
    let shares: Vec<f64> = r.keys.need("shares")?;
    let fits = shares.iter().all(|s| (0.0..=1.0).contains(s)) && shares.iter().sum::<f64>() <= 1.0 + 1e-6;
    if names.len() != shares.len() || names.is_empty() || names.len() > 3 || !fits {
        return Err(r.keys.wrong("of and shares: one to three of each, shares from 0 that sum to at most 1"));
    }
    let part = |(name, share): (&String, &f64)| Ok((*share as f32, named(r, name)?));
    let parts: Vec<(f32, Arc<dyn Material>)> = names.iter().zip(&shares).map(part).collect::<Result<_>>()?;
    if parts.iter().map(|(_, m)| ways(&**m)).sum::<usize>() > MOST_LOBES {
        return Err(r.keys.wrong("of: more ways for light than one surface can have; mix fewer gratings"));
    }
    Ok(Arc::new(Mixture(parts)))
}

/// Most lobes that a material has from either side.
fn ways(material: &dyn Material) -> usize {
    let seen = |i: u16| {
        let site = Site { front: i.is_multiple_of(2), ..Site::default() };
        let cos = (f32::from(i / 2) + 0.5) / 8.0;
        let mut lobes = Lobes::default();
        material.lobes(&site, Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos), &mut lobes);
        lobes.len()
    };
    (0..16).map(seen).max().unwrap_or(0)
}
