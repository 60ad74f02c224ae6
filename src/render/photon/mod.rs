//! The photon map [Jensen 1996; the paper's 12]: lamps send out photons, which stay where they arrive on surfaces; how dense they
//! lie around a place is the light that it has from other surfaces, by mirrors and through glass.
//!
//! Photons of several maps, one for each path of a pixel in turn, are counted within disks that shrink from map to map, so that
//! errors of both kinds go to nothing with more of them [Knaus and Zwicker 2011]; the disks end at edges and in corners
//! ([`gather`]). All wavelengths of a photon are one row of factors, which photons that met the same paints share. The lamps
//! themselves are looked at, and lobes that are not matt are followed to what they show; with [`Options::gather_once`] so are
//! matt ones, and photons are counted there (final gather), which has no blotches but cannot sharpen caustics seen directly.
//!
//! It cannot show what no photon reaches: scenes much larger than what is seen of them, and light of a lamp behind glass in gloss.

pub mod beams;
pub mod emit;
pub mod gather;
pub mod guide;
pub mod map;
pub mod tree;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3A;

use crate::material::{Lobe, Lobes};
use crate::medium::Inside;
use crate::medium::density::Way;
use crate::notes::Notes;
use crate::render::comb::Comb;
use crate::render::flight::Rates;
use crate::render::inks::Outline;
use crate::render::march::steps::Steps;
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, Pairs, Rest, Shade};
use crate::render::solution::{self, Bytes, Fingerprint};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::view::{self, Eye, Seen};
use crate::render::wavelengths::Wavelengths;
use crate::scene::{Hit, Scene};
use crate::{Result, parallel};

use gather::Spot;
use map::{Maps, Plan, THINNED};
use tree::Photon;

/// Of solution files.
const KIND: &str = "photon";
/// The first pair of a sampler's numbers that is free.
const FIRST_PAIR: u32 = 2;
/// Squared radius beyond which photons are not looked for, in the scene's own scale.
const MOST_RADIUS2: f32 = 0.25;
/// How fast disks shrink: areas go as the number of the map to the power of this less 1.
const ALPHA: f32 = 2.0 / 3.0;

/// What can be asked of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Photons that lamps send out in all.
    pub photons: u32,
    /// Maps that they are shared between.
    pub passes: u32,
    /// Photons that a disk holds in the first map.
    pub count: u32,
    /// Matt surfaces look around once, and photons are counted at what they see.
    pub gather_once: bool,
    /// Optical depth of a step through a medium, for the lamps' own light.
    pub step: f32,
    /// Another seed, another noise.
    pub seed: u32,
    /// Bytes at most.
    pub memory: usize,
    /// Photons are kept here, and taken from here where it is there.
    pub solution: Option<PathBuf>,
}

/// Photons of a scene.
pub struct PhotonMap {
    scene: Arc<Scene>,
    options: Options,
    maps: Maps,
    from_file: bool,
    /// Of each medium.
    rates: Vec<Rates>,
    /// Radius about ways within which photons in media count, in the first map.
    beam: f32,
    /// Disks and the sum of their radii, in millionths of the scene's scale: sums that do not depend on the order.
    disks: AtomicU64,
    radii: AtomicU64,
}

impl PhotonMap {
    /// Sends photons out, or takes them from their file.
    pub fn new(
        scene: Arc<Scene>,
        outline: Outline,
        options: &Options,
        comb: &Comb,
        wavelengths: &dyn Wavelengths,
    ) -> Result<PhotonMap> {
        parallel::ready();
        let Options { photons, passes, seed, memory, .. } = *options;
        let rates = Rates::of(&scene.media, &outline);
        let asked = format!("{photons} {passes} {seed}");
        let known = options.solution.as_deref().map(|p| (p, Fingerprint::of(&scene, &asked, wavelengths)));
        let (maps, from_file) = solution::kept(
            known,
            KIND,
            |b| parse(b, &scene, wavelengths.lanes()),
            || {
                let photons = (photons / passes).max(1);
                let rates = &rates;
                Plan { scene: &scene, outline: &outline, comb, wavelengths, photons, passes, seed, memory, rates }
                    .trace()
            },
            bytes,
        )?;
        let (disks, radii) = Default::default();
        let count = options.count.div_ceil(THINNED as u32) as f32;
        let beam = maps.volumes.first().map_or(0.0, |v| beams::radius(v, count));
        Ok(PhotonMap { scene, options: options.clone(), maps, from_file, rates, beam, disks, radii })
    }

    /// Notes the light that photons bring to a side of a place: as a white matt surface would show it, times `weight`.
    fn count(&self, spot: &Spot, weight: f32, pass: usize, turn: f32, trail: &mut Trail) {
        let passes = &self.maps.passes;
        let pass = pass % passes.len();
        let count = (self.options.count as usize).div_ceil(THINNED);
        let first = spot.radius2(&self.maps.pilot, count, MOST_RADIUS2);
        let radius2 = first * shrunk(pass);
        let mut found = Vec::new();
        gather::density(&self.scene, &passes[pass], spot, radius2, turn, &mut found);
        for (row, flux_a_area) in found {
            trail.stored(row, weight * flux_a_area * std::f32::consts::FRAC_1_PI);
        }
        self.disks.fetch_add(1, Ordering::Relaxed);
        self.radii.fetch_add((radius2.sqrt() * 1e6) as u64, Ordering::Relaxed);
    }

    /// Notes what a way's medium shows of lamps and photons, and lets through.
    fn travel(&self, inside: Inside, way: &Way, pass: usize, pairs: &mut Pairs, trail: &mut Trail) {
        let pass = pass % self.maps.volumes.len();
        let photons = &self.maps.volumes[pass];
        trail.fork();
        if !photons.is_empty() {
            beams::note(&self.scene, photons, inside, way, self.beam * shrunk(pass).sqrt(), trail);
        }
        trail.branch();
        let steps = Steps { scene: &self.scene, rates: &self.rates, step: self.options.step };
        steps.march(inside, way, pairs, trail, |_, _| {});
    }

    fn shade<'a>(&'a self, around: &'a Around<'a>) -> Shade<'a> {
        let follow = if self.options.gather_once { Follow::All } else { Follow::Gloss };
        Shade { scene: &self.scene, rest: around, shadows: true, follow, inside: around.inside }
    }
}

/// Share that is left of a disk's area in a map.
fn shrunk(pass: usize) -> f32 {
    (1..=pass).map(|i| (i as f32 + ALPHA) / (i as f32 + 1.0)).product()
}

/// What photons know of the surroundings of a place.
struct Around<'a> {
    map: &'a PhotonMap,
    /// The surface, and whether its front is asked.
    place: Option<(&'a Hit, bool)>,
    pass: usize,
    turn: f32,
    /// The bodies that the eye's side of it is in.
    inside: Inside,
    /// Mirrors that light is still followed through.
    mirrors: u32,
}

/// Mirrors in turn that light from gloss is followed through.
const MIRRORS: u32 = 16;

fn spot(hit: &Hit, front: bool) -> Spot {
    Spot { place: hit.point, normal: if front { hit.normal } else { -hit.normal }, reach: hit.reach }
}

impl Rest for Around<'_> {
    fn spread(&self, _: &Meeting, lobe: &Lobe, weight: f32, trail: &mut Trail) {
        if let Some((hit, front)) = self.place {
            let spot = spot(hit, front != lobe.kernel.transmits());
            self.map.count(&spot, weight, self.pass, self.turn, trail);
        }
    }

    /// Of all ways in which the surface sends light on one by lot: through mirrors and what is bent to what they show, else as if it were
    /// matt, lamps that it sees and photons.
    fn sent(&self, met: Option<&Hit>, direction: Vec3A, weight: f32, pairs: &mut Pairs, trail: &mut Trail) {
        let Some(hit) = met else { return };
        let scene = &*self.map.scene;
        let (at, lobes) = Meeting::with_lobes(scene, hit, direction);
        let mut back = Lobes::default();
        lobes.iter().filter(|l| !l.kernel.is_straight()).for_each(|l| back.push(*l));
        let lot = if back.len() > 1 { pairs.pair()[0] } else { 0.0 };
        let Some(mut lobe) = back.choose(lot) else { return };
        lobe.factor *= weight;
        let front = hit.normal.dot(direction) < 0.0;
        // No photons are kept on mirrors.
        let mirrored = lobe.kernel.is_specular() && self.mirrors > 0;
        let inside = if mirrored && lobe.kernel.transmits() { at.beyond(self.inside) } else { self.inside };
        let mirrors = self.mirrors - u32::from(mirrored);
        let around = Around { place: Some((hit, front)), turn: pairs.pair()[0], inside, mirrors, ..*self };
        let follow = if mirrored { Follow::All } else { Follow::Nothing };
        let shade = Shade { scene, rest: &around, shadows: true, follow, inside: self.inside };
        shade.lobe(&at, &lobe, pairs, trail);
    }
}

impl Method for PhotonMap {
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut pairs = Pairs::new(sampler, FIRST_PAIR);
        let scene = &*self.scene;
        Eye { scene, origin, direction }.look(
            &mut pairs,
            trail,
            |lobe| lobe.kernel.is_specular(),
            |inside, way, pairs, trail| self.travel(inside, way, sampler.index() as usize, pairs, trail),
            |seen, lobe, pairs, trail| {
                let Seen { hit, front, at, inside } = *seen;
                let place = Some((hit, front));
                let around = Around {
                    map: self,
                    place,
                    pass: sampler.index() as usize,
                    turn: pairs.pair()[0],
                    inside,
                    mirrors: MIRRORS,
                };
                self.shade(&around).lobe(at, lobe, pairs, trail);
            },
        );
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut pairs = Pairs::new(sampler, FIRST_PAIR);
        let at = Meeting::facing(point, normal);
        let under = view::under(&self.scene, point, normal);
        let place = under.as_ref().map(|(hit, front)| (hit, *front));
        let inside = self.scene.inside(point);
        let (pass, turn) = (sampler.index() as usize, pairs.pair()[0]);
        let around = Around { map: self, place, pass, turn, inside, mirrors: MIRRORS };
        let mut shade = self.shade(&around);
        if place.is_none() {
            // In mid-air no photons arrive: it looks around.
            shade.follow = Follow::All;
        }
        shade.lobe(&at, &Lobe::WHITE, &mut pairs, trail);
    }

    fn stored(&self) -> &Stored {
        &self.maps.stored
    }

    fn report(&self, notes: &Notes) {
        let kept: usize = self.maps.passes.iter().chain(&self.maps.volumes).map(Vec::len).sum();
        let disks = self.disks.load(Ordering::Relaxed).max(1);
        let radius = self.radii.load(Ordering::Relaxed) as f64 / disks as f64 / 1e6 / self.scene.frame.scale;
        notes.add(format!(
            "photon map: {kept} arrivals of {} photons in {} maps, {} spectra of what became of them{}; mean radius {radius:.3} m, \
             the last map's {:.2} of the first's",
            self.options.photons,
            self.options.passes,
            self.maps.stored.lights.len(),
            if self.from_file { ", taken from their file" } else { "" },
            shrunk(self.maps.passes.len() - 1).sqrt()
        ));
        if self.beam > 0.0 {
            let within: usize = self.maps.volumes.iter().map(Vec::len).sum();
            let radius = f64::from(self.beam) / self.scene.frame.scale;
            notes
                .add(format!("{within} of them scattered in media, counted within {radius:.3} m of what the eye sees"));
        }
        if self.maps.endless > 0 {
            notes.add(format!("{} photons were cut: light hardly ends in this scene", self.maps.endless));
        }
        if kept == 0 {
            notes.add(
                "no photon arrived anywhere after a first surface: only lamps and what they light at once are shown",
            );
        }
    }
}

/// Maps as bytes, little endian: paths that were cut (u32), rows (u32), each row's light (u32), rows (f32); maps (u32), for each
/// of them, then for each one's media, and for the pilot its photons (u32) and their nine words.
fn bytes(maps: &Maps) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut put = |word: u32| bytes.extend_from_slice(&word.to_le_bytes());
    put(maps.endless.min(u64::from(u32::MAX)) as u32);
    put(maps.stored.lights.len() as u32);
    maps.stored.lights.iter().copied().for_each(&mut put);
    maps.stored.data.iter().for_each(|x| put(x.to_bits()));
    put(maps.passes.len() as u32);
    for pass in maps.passes.iter().chain(&maps.volumes).chain([&maps.pilot]) {
        put(pass.len() as u32);
        pass.iter().flat_map(Photon::words).for_each(&mut put);
    }
    bytes
}

fn parse(bytes: &mut Bytes, scene: &Scene, lanes: usize) -> Option<Maps> {
    let endless = bytes.word()?.into();
    let count = bytes.word()? as usize;
    let lights = bytes.words(count)?;
    let data = bytes.floats(count.checked_mul(lanes)?)?;
    let passes = bytes.word()?;
    if passes == 0 || lights.iter().any(|l| *l as usize >= scene.lights.len()) {
        return None;
    }
    let mut maps = Maps {
        passes: Vec::new(),
        volumes: Vec::new(),
        pilot: Vec::new(),
        stored: Stored { lights, lanes, data },
        endless,
    };
    for i in 0..=passes.checked_mul(2)? {
        let photons = bytes.word()? as usize;
        let words = bytes.words(photons.checked_mul(9)?)?;
        let photons: Vec<Photon> = words.as_chunks::<9>().0.iter().map(|w| Photon::from_words(*w)).collect();
        if photons.iter().any(|p| p.row as usize >= count) {
            return None;
        }
        match i {
            i if i < passes => maps.passes.push(photons),
            i if i < 2 * passes => maps.volumes.push(photons),
            _ => maps.pilot = photons,
        }
    }
    Some(maps)
}
