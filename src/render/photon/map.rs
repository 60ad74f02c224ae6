//! Photons on their way, and where they are kept: on every surface that is no mirror, once they have been reflected, bent or
//! scattered. (Lamps themselves are looked at.)
//!
//! What becomes of a photon's spectrum is a product of tints. Photons that met the same ones share a row of it: a room of five
//! paints has a few hundred rows, however many photons.

use std::collections::HashMap;

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::{Base, Kernel, Tint};
use crate::render::comb::Comb;
use crate::render::inks::Outline;
use crate::render::lanes::Lanes;
use crate::render::meeting::Meeting;
use crate::render::photon::emit::{self, Lamps, Start};
use crate::render::photon::tree::{self, Photon};
use crate::render::sampler::Sampler;
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::light::Emission;
use crate::scene::{Hit, Scene};
use crate::{Result, invalid};

/// A photon that has not ended by now never will.
const MOST_BOUNCES: u32 = 2048;
/// A disk's size needs fewer photons than its light.
pub const THINNED: usize = 8;
/// Photons from which it is learned where others are worth sending.
const LEARNERS: (u32, u32) = (1 << 14, 1 << 18);
/// Photons traced together.
const TOGETHER: u32 = 1024;
/// Pairs of a sampler's numbers a bounce.
const PAIRS: u32 = 2;
/// The pair that says which wavelengths a photon keeps where they go apart.
const WAVELENGTHS: u32 = 0x4000_0000;

/// What is asked for.
pub struct Plan<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What photons are worth, for their ends by lot.
    pub outline: &'a Outline,
    /// Wavelengths of the picture, for those that go apart.
    pub comb: &'a Comb,
    /// What rows hold.
    pub wavelengths: &'a dyn Wavelengths,
    /// Photons given off for each map.
    pub photons: u32,
    /// Maps.
    pub passes: u32,
    /// Another seed, another noise.
    pub seed: u32,
    /// Bytes at most.
    pub memory: usize,
}

/// All maps, and the rows that their photons refer to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Photons in the order of a tree.
    pub passes: Vec<Vec<Photon>>,
    /// Every [`THINNED`]th of the first map's, for the size of disks.
    pub pilot: Vec<Photon>,
    /// Products of tints.
    pub stored: Stored,
    /// Paths that were cut.
    pub endless: u64,
}

/// Where a photon arrived.
struct Arrival {
    place: Vec3A,
    normal: Vec3A,
    flux: f32,
    light: u32,
    /// How many of its path's tints it met.
    tints: usize,
}

/// The way of one photon.
#[derive(Default)]
struct Way {
    arrivals: Vec<Arrival>,
    tints: Vec<Tint>,
    endless: bool,
}

impl Plan<'_> {
    /// Sends photons out, for all maps.
    pub fn trace(&self) -> Result<Maps> {
        let mut lamps = Lamps::new(self.scene, self.wavelengths);
        let learners = (self.photons.saturating_mul(self.passes) / 8).clamp(LEARNERS.0, LEARNERS.1);
        lamps.learn(learners, self.seed, |start, sampler| !self.way(start, sampler).arrivals.is_empty());
        let mut maps = Maps::default();
        maps.stored.lanes = self.wavelengths.lanes();
        let mut rows = HashMap::new();
        for pass in 0..self.passes {
            let mut photons = Vec::new();
            // Some at a time: ways take much more room than photons do.
            for first in (0..self.photons).step_by(64 * TOGETHER as usize) {
                let end = (first + 64 * TOGETHER).min(self.photons);
                let ways: Vec<Vec<Way>> = (first..end)
                    .step_by(TOGETHER as usize)
                    .collect::<Vec<_>>()
                    .into_par_iter()
                    .map(|from| (from..(from + TOGETHER).min(end)).map(|i| self.sent(&lamps, pass, i)).collect())
                    .collect();
                for way in ways.iter().flatten() {
                    maps.endless += u64::from(way.endless);
                    for a in &way.arrivals {
                        let row = self.row(&mut maps.stored, &mut rows, a.light, &way.tints[..a.tints])?;
                        photons.push(Photon::new(a.place, a.normal, a.flux / self.photons as f32, row));
                    }
                }
                self.afford(&maps, photons.len())?;
            }
            if pass == 0 {
                maps.pilot = photons.iter().step_by(THINNED).copied().collect();
                tree::build(&mut maps.pilot);
            }
            tree::build(&mut photons);
            maps.passes.push(photons);
        }
        Ok(maps)
    }

    fn afford(&self, maps: &Maps, more: usize) -> Result<()> {
        let photons = more + maps.passes.iter().map(Vec::len).sum::<usize>();
        let bytes = photons * size_of::<Photon>() + size_of_val(&maps.stored.data[..]);
        if bytes > self.memory {
            return invalid!(
                "{photons} photons on surfaces and {} spectra of what became of them take more than --solver-memory; fewer \
                 --photons or --bands take less",
                maps.stored.lights.len()
            );
        }
        Ok(())
    }

    /// The row of a product of tints.
    fn row(
        &self,
        stored: &mut Stored,
        rows: &mut HashMap<(u32, Vec<u32>), u32>,
        light: u32,
        tints: &[Tint],
    ) -> Result<u32> {
        // Of plain inks the order does not matter; others hardly ever come again.
        let ink = |t: &Tint| if let Tint::Base(Base::Ink(i)) = t { Some(*i) } else { None };
        let mut inks: Option<Vec<u32>> = tints.iter().map(ink).collect();
        if let Some(inks) = &mut inks {
            inks.sort_unstable();
        }
        if let Some(row) = inks.as_ref().and_then(|inks| rows.get(&(light, inks.clone()))) {
            return Ok(*row);
        }
        let mut trail = Trail::default();
        tints.iter().for_each(|tint| trail.tint(tint));
        trail.light(&Emission::one(0, 1.0), 1.0, 0);
        let mut sums = vec![0f32; stored.lanes];
        self.wavelengths.gather(&trail, &Stored::default(), 1.0, &mut sums);
        let row = stored.lights.len() as u32;
        stored.lights.push(light);
        stored.data.extend_from_slice(&sums);
        if let Some(inks) = inks {
            rows.insert((light, inks), row);
        }
        Ok(row)
    }

    /// Sends one photon out.
    fn sent(&self, lamps: &Lamps, pass: u32, number: u32) -> Way {
        let sampler = Sampler::new(pass, 0x3c6e_f372, number, self.seed);
        lamps.start(&sampler).map_or_else(Way::default, |start| self.way(start, &sampler))
    }

    /// Where wavelengths go apart a photon keeps those about one of them, by lot, and has the flux of all.
    fn apart(&self, spread: f32, sampler: &Sampler, way: &mut Way, flux: &mut f32) -> Option<f32> {
        let [place, lot] = sampler.pair(WAVELENGTHS);
        let parts = self.comb.parts(spread, place)?;
        let (window, nm) = self.comb.part(&parts, ((lot * parts.count as f32) as u32).min(parts.count - 1));
        way.tints.push(Tint::Window(window));
        *flux *= parts.count as f32;
        Some(nm)
    }

    /// A body that is met from behind has absorbed on the way.
    fn absorb(&self, hit: &Hit, direction: Vec3A, outline: &mut Lanes<1>, way: &mut Way) {
        let interior = self.scene.materials[hit.surface.material as usize].interior();
        let Some(medium) = interior.filter(|_| hit.normal.dot(direction) > 0.0) else { return };
        let depth = self.scene.media.list[medium as usize].extinction;
        let tint = Tint::Inside { depth, metres: self.scene.frame.length_m(hit.t) };
        self.outline.tint(outline, &tint);
        way.tints.push(tint);
    }

    /// Follows a photon to its end.
    fn way(&self, Start { mut origin, mut direction, light, mut flux }: Start, sampler: &Sampler) -> Way {
        let mut way = Way::default();
        let mut outline = Lanes::<1>::splat(1.0);
        let mut straight = true;
        // The wavelength that says where it goes, once they have gone apart.
        let mut nm = None;
        for bounce in 0..=MOST_BOUNCES {
            let Some(hit) = self.scene.geometry.closest(origin, direction) else { return way };
            let (at, lobes) = Meeting::with_lobes(self.scene, &hit, direction);
            if self.scene.effects.fills {
                self.absorb(&hit, direction, &mut outline, &mut way);
            }
            if !straight && lobes.iter().any(|l| !l.kernel.is_specular()) {
                way.arrivals.push(Arrival { place: hit.point, normal: at.side, flux, light, tints: way.tints.len() });
            }
            let pair = emit::PAIRS + PAIRS * bounce;
            let [lot, end] = sampler.pair(pair);
            let Some(lobe) = lobes.choose(lot) else { return way };
            if nm.is_none() && self.scene.effects.disperses {
                nm = self.apart(lobe.kernel.spread(at.out), sampler, &mut way, &mut flux);
            }
            let single = nm.and_then(|nm| lobe.kernel.at(nm));
            let kernel: &dyn Kernel = single.as_ref().map_or(lobe.kernel, |s| s);
            let Some(turn) = kernel.sample(at.out, sampler.pair(pair + 1)) else { return way };
            let tint = lobe.tint.turned(at.out, turn.inc);
            let before = self.outline.value(&outline);
            self.outline.tint(&mut outline, &tint);
            match tint {
                Tint::None => {}
                Tint::Base(Base::Grey(r)) => flux *= r,
                tint => way.tints.push(tint),
            }
            let factor = lobe.factor * turn.weight;
            flux *= factor;
            // It ends by lot, so that those that go on carry about as much as before.
            let odds = factor * self.outline.value(&outline) / before.max(f32::MIN_POSITIVE);
            // All go on from the first surface: dark ones would leave few that arrive anywhere.
            if odds < 1.0 && !straight {
                if end >= odds {
                    return way;
                }
                flux /= odds;
            }
            straight &= lobe.kernel.is_straight();
            if !lobe.kernel.is_straight() {
                direction = at.world(turn.inc).normalize();
            }
            let (from, side) = at.start(lobe.kernel.transmits());
            if direction.dot(side) <= 0.0 {
                return way;
            }
            origin = from;
        }
        way.endless = true;
        way
    }
}
