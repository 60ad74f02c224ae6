//! Photons on their way, and where they are kept: on every surface that is no mirror, and where they scatter in media, once they have
//! been reflected, bent or scattered before. (Lamps themselves are looked at.)
//!
//! What becomes of a photon's spectrum is a product of tints. Photons that met the same ones share a row of it: a room of five
//! paints has a few hundred rows, however many photons.

use std::collections::HashMap;

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::{Base, Kernel, Lobe, Tint, Turn};
use crate::medium::{Inside, Medium};
use crate::render::comb::Comb;
use crate::render::flight::Rates;
use crate::render::inks::Outline;
use crate::render::lanes::Lanes;
use crate::render::media;
use crate::render::meeting::Meeting;
use crate::render::photon::emit::{self, Lamps, Start};
use crate::render::photon::tree::{self, Photon};
use crate::render::sampler::Sampler;
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::light::Emission;
use crate::scene::{Scene, ray};
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
/// Pairs that say how far photons fly.
const FLIGHTS: u32 = 0x2000_0000;
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
    /// Rates of each medium.
    pub rates: &'a [Rates],
}

/// All maps, and the rows that their photons refer to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Photons in the order of a tree.
    pub passes: Vec<Vec<Photon>>,
    /// Those of media.
    pub volumes: Vec<Vec<Photon>>,
    /// Every [`THINNED`]th of the first map's, for the size of disks.
    pub pilot: Vec<Photon>,
    /// Products of tints.
    pub stored: Stored,
    /// Paths that were cut.
    pub endless: u64,
}

/// Where a photon arrived.
struct Arrival {
    /// In a medium.
    scattered: bool,
    place: Vec3A,
    normal: Vec3A,
    flux: f32,
    light: u32,
    /// How many of its path's tints it met.
    tints: usize,
}

/// A photon on its way.
struct Flying {
    /// Where its ray begins, and where its way does: on the surface itself.
    origin: Vec3A,
    from: Vec3A,
    direction: Vec3A,
    inside: Inside,
    light: u32,
    flux: f32,
    /// What is left of each eighth of the wavelengths.
    outline: Lanes<1>,
    /// It comes straight from its lamp.
    straight: bool,
}

impl Flying {
    /// What it carries, for lots.
    fn worth(&self, outline: &Outline) -> f32 {
        self.flux.abs() * outline.value(&self.outline)
    }
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
            let (mut photons, mut volume) = (Vec::new(), Vec::new());
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
                        let kept = if a.scattered { &mut volume } else { &mut photons };
                        kept.push(Photon::new(a.place, a.normal, a.flux / self.photons as f32, row));
                    }
                }
                self.afford(&maps, photons.len() + volume.len())?;
            }
            if pass == 0 {
                maps.pilot = photons.iter().step_by(THINNED).copied().collect();
                tree::build(&mut maps.pilot);
            }
            tree::build(&mut photons);
            tree::build(&mut volume);
            maps.passes.push(photons);
            maps.volumes.push(volume);
        }
        Ok(maps)
    }

    fn afford(&self, maps: &Maps, more: usize) -> Result<()> {
        let photons = more + maps.passes.iter().chain(&maps.volumes).map(Vec::len).sum::<usize>();
        let bytes = photons * size_of::<Photon>() + size_of_val(&maps.stored.data[..]);
        if bytes > self.memory {
            return invalid!(
                "{photons} photons and {} spectra of what became of them take more than --solver-memory; fewer \
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

    /// Follows a photon through the medium that it is in, as far as a place: where it scatters on the way, if it does.
    fn fly(&self, p: &mut Flying, to: Option<Vec3A>, lots: [f32; 2], way: &mut Way) -> Option<Vec3A> {
        let medium = self.scene.media.current(p.inside)?;
        let line = media::between(p.from, p.direction, to);
        let all = media::column(self.scene, medium, &line);
        let (depth, number) = (medium.extinction, medium.number as usize);
        let Some(scattering) = medium.scattering else {
            self.dim(medium, &medium.inside(all), p, way);
            return None;
        };
        let flight = self.rates[number].flight(self.outline, &p.outline, all);
        let column = flight.column(lots);
        let reached = if column < all { media::reach(self.scene, medium, &line, column) } else { None };
        let Some(t) = reached else {
            let over = 1.0 / flight.survival();
            self.dim(medium, &Tint::Inside { depth, metres: all, over }, p, way);
            return None;
        };
        let over = 1.0 / flight.density(column);
        self.dim(medium, &Tint::Collision { depth, scattering, metres: column, over }, p, way);
        let place = line.at(t);
        if !p.straight {
            let (normal, tints) = (-p.direction, way.tints.len());
            way.arrivals.push(Arrival { scattered: true, place, normal, flux: p.flux, light: p.light, tints });
        }
        Some(place)
    }

    /// Notes what a medium leaves.
    fn dim(&self, medium: &Medium, tint: &Tint, p: &mut Flying, way: &mut Way) {
        match medium.grey_share(tint) {
            Some(k) => p.flux *= k,
            None => {
                self.outline.tint(&mut p.outline, tint);
                way.tints.push(*tint);
            }
        }
    }

    /// Turns a photon that has scattered; false where it ends by lot.
    fn turn(&self, p: &mut Flying, place: Vec3A, before: f32, [lots, turn]: [[f32; 2]; 2]) -> bool {
        let Some(medium) = self.scene.media.current(p.inside) else { return false };
        let odds = p.worth(self.outline) / before.max(f32::MIN_POSITIVE);
        if odds < 1.0 && !p.straight {
            if lots[1] >= odds {
                return false;
            }
            p.flux /= odds;
        }
        p.direction = medium.phase.turned(p.direction, turn).0;
        (p.origin, p.from, p.straight) = (place, place, false);
        true
    }

    /// Follows a photon to its end.
    fn way(&self, Start { origin, direction, light, flux }: Start, sampler: &Sampler) -> Way {
        let mut way = Way::default();
        let inside = self.scene.inside(origin);
        let outline = Lanes::<1>::splat(1.0);
        let mut p = Flying { origin, from: origin, direction, inside, light, flux, outline, straight: true };
        // The wavelength that says where it goes, once they have gone apart.
        let mut nm = None;
        for bounce in 0..=MOST_BOUNCES {
            let pair = emit::PAIRS + PAIRS * bounce;
            let [lot, end] = sampler.pair(pair);
            let before = p.worth(self.outline);
            let hit = self.scene.geometry.closest(p.origin, p.direction);
            if self.scene.is_filled() {
                let to = hit.as_ref().map(|h| h.point);
                if let Some(place) = self.fly(&mut p, to, sampler.pair(FLIGHTS + bounce), &mut way) {
                    if self.turn(&mut p, place, before, [[lot, end], sampler.pair(pair + 1)]) {
                        continue;
                    }
                    return way;
                }
            }
            let Some(hit) = hit else { return way };
            let (at, lobes) = Meeting::with_lobes(self.scene, &hit, p.direction);
            p.from = hit.point;
            if self.scene.materials[hit.surface.material as usize].is_void() {
                p.inside = at.beyond(p.inside);
                p.origin = ray::onward(hit.point, p.direction, hit.normal, hit.reach);
                continue;
            }
            if !p.straight && lobes.iter().any(|l| !l.kernel.is_specular()) {
                let (place, normal, tints) = (hit.point, at.side, way.tints.len());
                way.arrivals.push(Arrival { scattered: false, place, normal, flux: p.flux, light, tints });
            }
            let Some(lobe) = lobes.choose(lot) else { return way };
            if nm.is_none() && self.scene.effects.disperses {
                nm = self.apart(lobe.kernel.spread(at.out), sampler, &mut way, &mut p.flux);
            }
            let single = nm.and_then(|nm| lobe.kernel.at(nm));
            let kernel: &dyn Kernel = single.as_ref().map_or(lobe.kernel, |s| s);
            let Some(turn) = kernel.sample(at.out, sampler.pair(pair + 1)) else { return way };
            if !self.leave(&mut p, &at, &lobe, &turn, end, &mut way) {
                return way;
            }
        }
        way.endless = true;
        way
    }

    /// Sends a photon on from a surface by a lobe; false where it ends by lot or has nowhere to go.
    fn leave(&self, p: &mut Flying, at: &Meeting, lobe: &Lobe, turn: &Turn, end: f32, way: &mut Way) -> bool {
        let tint = lobe.tint.turned(at.out, turn.inc);
        let before = self.outline.value(&p.outline);
        self.outline.tint(&mut p.outline, &tint);
        match tint {
            Tint::None => {}
            Tint::Base(Base::Grey(r)) => p.flux *= r,
            tint => way.tints.push(tint),
        }
        let factor = lobe.factor * turn.weight;
        p.flux *= factor;
        // It ends by lot, so that those that go on carry about as much as before.
        let odds = factor * self.outline.value(&p.outline) / before.max(f32::MIN_POSITIVE);
        // All go on from the first surface: dark ones would leave few that arrive anywhere.
        if odds < 1.0 && !p.straight {
            if end >= odds {
                return false;
            }
            p.flux /= odds;
        }
        p.straight &= lobe.kernel.is_straight();
        if !lobe.kernel.is_straight() {
            p.direction = at.world(turn.inc).normalize();
        }
        if lobe.kernel.transmits() {
            p.inside = at.beyond(p.inside);
        }
        let (from, side) = at.start(lobe.kernel.transmits());
        p.origin = from;
        p.direction.dot(side) > 0.0
    }
}
