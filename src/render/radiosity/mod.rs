//! Radiosity: surfaces divided into elements, whose light is balanced before the eye looks.
//!
//! The light on each element by the lamps is found by looking at them from places all over it; the light that elements send each
//! other is the solution of `W = D + F (rho W)` (radiance that a white matt surface would show, so `E / pi`; D by the lamps, F the
//! form factors), all wavelengths of a light at once. Surfaces are divided until what is linear between elements errs by no more
//! than the tolerance.
//!
//! A picture takes the light between surfaces from the elements, smoothly, and the lamps' light from the elements as well
//! ([`Show::Mesh`]), by looking at the lamps from each place ([`Show::Direct`]), or it looks once around from each place and takes
//! from the elements what is seen there ([`Show::Gather`]).
//!
//! It cannot show light that gloss, mirrors and glass throw onto other surfaces: what they reflect is spread as if they were matt,
//! and nothing goes through. What the eye sees in them is followed. Light leaks through a wall with light on both sides that
//! cuts through an element, as far as the element reaches.

mod cover;
mod divide;
mod file;
mod matter;
mod mesh;
mod prepare;
mod rows;
mod solve;

use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::{Lobe, Lobes};
use crate::medium::Inside;
use crate::notes::Notes;
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, Pairs, Rest, Shade};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::view::{self, Eye, Seen};
use crate::render::wavelengths::Wavelengths;
use crate::scene::{Hit, Scene, ray};

use cover::{Cover, Ground};
use mesh::Mesh;
pub use rows::MOST_RAYS;
use solve::Solved;

/// The first pair of a sampler's numbers that is free.
const FIRST_PAIR: u32 = 2;

/// What a picture takes from the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Everything.
    Mesh,
    /// Light between surfaces.
    Direct,
    /// What is seen from each place.
    Gather,
}

/// What can be asked of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Elements along both sides of each surface; `None` as many as the tolerance needs.
    pub divide: Option<u32>,
    /// Mean error of what is linear between elements, relative.
    pub tolerance: f64,
    /// Rays from each element, for its form factors.
    pub rays: u32,
    /// What a picture takes from the elements.
    pub show: Show,
    /// Bytes that the solution and the work on it may take.
    pub memory: usize,
    /// Kept here, and taken from here where it is there.
    pub solution: Option<PathBuf>,
    /// Another seed, another noise.
    pub seed: u32,
}

/// A solution of a scene.
pub struct Radiosity {
    scene: Arc<Scene>,
    show: Show,
    mesh: Mesh,
    cover: Cover,
    /// Rows for each element and light: all light, then once more only that from other surfaces.
    stored: Stored,
    /// Luminance of elements, of all light and of that from other surfaces.
    brightness: [Vec<f32>; 2],
    account: Account,
}

/// How it went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// Surfaces with elements.
    pub surfaces: usize,
    /// Mean error of what is linear between elements; `None` where it was not asked for.
    pub error: Option<f64>,
    /// The tolerance needs more memory.
    pub out_of_memory: bool,
    /// Of the system of equations.
    pub solved: Solved,
    /// Rays from each element.
    pub rays: u32,
    /// Rows of form factors that were kept, of all.
    pub rows_kept: [usize; 2],
    /// Bytes at most.
    pub bytes: usize,
    /// Share of the area that is not only matt.
    pub glossy: f64,
    /// Taken from a file.
    pub from_file: bool,
}

impl Radiosity {
    /// Meshes and solves, or takes the solution from its file.
    pub fn new(scene: Arc<Scene>, options: &Options, wavelengths: &dyn Wavelengths) -> Result<Radiosity> {
        prepare::prepared(scene, options, wavelengths)
    }

    /// Notes what the elements around a place have, of all light or of that from other surfaces only.
    fn take(&self, hit: &Hit, front: bool, all: bool, weight: f32, trail: &mut Trail) {
        if !self.is_open(hit, front) {
            return;
        }
        let (shares, count) = self.mesh.around(hit, front, &self.brightness[usize::from(!all)]);
        let lights = self.stored.lights.len() as u32;
        let first = if all { 0 } else { self.mesh.len() as u32 };
        for (element, share) in &shares[..count] {
            for light in 0..lights {
                trail.stored((first + element) * lights + light, share * weight);
            }
        }
    }

    /// Light reaches the place, as far as walls that stand on its element tell.
    fn is_open(&self, hit: &Hit, front: bool) -> bool {
        let ground = Ground { geometry: &self.scene.geometry, mesh: &self.mesh, cover: &self.cover };
        let Some(number) = self.mesh.met(hit, front).filter(|n| self.cover.is_walled(*n)) else { return true };
        let normal = if front { hit.normal } else { -hit.normal };
        ground.opening(number)(ray::offset(hit.point, normal, hit.reach), normal)
    }

    fn shade<'a>(&'a self, around: &'a Around<'a>, inside: Inside) -> Shade<'a> {
        let follow = if self.show == Show::Gather { Follow::All } else { Follow::Gloss };
        Shade { scene: &self.scene, rest: around, shadows: true, follow, inside }
    }

    /// A lobe of a place.
    fn lobe(&self, seen: &Seen, lobe: &Lobe, pairs: &mut Pairs, trail: &mut Trail) {
        let Seen { hit, front, at, inside } = *seen;
        if self.show == Show::Mesh && lobe.kernel.is_matt() {
            trail.tint(&lobe.tint);
            return self.take(hit, front != lobe.kernel.transmits(), true, lobe.factor, trail);
        }
        let around = Around { radiosity: self, place: Some((hit, front)) };
        self.shade(&around, inside).lobe(at, lobe, pairs, trail);
    }
}

/// What the solution knows of the surroundings of a place.
struct Around<'a> {
    radiosity: &'a Radiosity,
    /// The surface, and whether its front is asked.
    place: Option<(&'a Hit, bool)>,
}

impl Rest for Around<'_> {
    fn spread(&self, _: &Meeting, lobe: &Lobe, weight: f32, trail: &mut Trail) {
        if let Some((hit, front)) = self.place {
            self.radiosity.take(hit, front != lobe.kernel.transmits(), false, weight, trail);
        }
    }

    /// Of all ways in which the surface sends light back one by lot, as if it were matt.
    fn sent(&self, met: Option<&Hit>, direction: Vec3A, weight: f32, pairs: &mut Pairs, trail: &mut Trail) {
        let Some(hit) = met else { return };
        let (at, lobes) = Meeting::with_lobes(&self.radiosity.scene, hit, direction);
        let mut back = Lobes::default();
        lobes.iter().filter(|l| !l.kernel.transmits() && !l.kernel.is_straight()).for_each(|l| back.push(*l));
        let lot = if back.len() > 1 { pairs.pair()[0] } else { 0.0 };
        let Some(lobe) = back.choose(lot) else { return };
        let Some(turn) = lobe.kernel.sample(at.out, pairs.pair()) else { return };
        trail.tint(&lobe.tint.turned(at.out, turn.inc));
        let front = hit.normal.dot(direction) < 0.0;
        self.radiosity.take(hit, front, true, weight * lobe.factor * turn.weight, trail);
    }
}

impl Method for Radiosity {
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut pairs = Pairs::new(sampler, FIRST_PAIR);
        let scene = &*self.scene;
        Eye { scene, origin, direction }.look(
            &mut pairs,
            trail,
            |lobe| lobe.kernel.is_specular(),
            |inside, way, pairs, trail| view::dim(scene, inside, way, pairs, trail),
            |seen, lobe, pairs, trail| self.lobe(seen, lobe, pairs, trail),
        );
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let mut pairs = Pairs::new(sampler, FIRST_PAIR);
        let at = Meeting::facing(point, normal);
        let inside = self.scene.inside(point);
        match view::under(&self.scene, point, normal).filter(|_| self.show != Show::Gather) {
            Some((hit, front)) => {
                self.lobe(&Seen { hit: &hit, front, at: &at, inside }, &Lobe::WHITE, &mut pairs, trail);
            }
            None => {
                // In mid-air there are no elements: it looks around.
                let around = Around { radiosity: self, place: None };
                let shade = Shade { follow: Follow::All, ..self.shade(&around, inside) };
                shade.lobe(&at, &Lobe::WHITE, &mut pairs, trail);
            }
        }
    }

    fn stored(&self) -> &Stored {
        &self.stored
    }

    fn report(&self, notes: &Notes) {
        let Account { surfaces, error, out_of_memory, solved, rays, rows_kept: [kept, rows], bytes, glossy, from_file } =
            &self.account;
        let error = error.map_or(String::new(), |e| format!(", {:.2} % of mean error between them", 100.0 * e));
        let how = if *from_file {
            "taken from its file".into()
        } else {
            let again = if kept < rows {
                format!(", {} of the rows traced again each step", rows - kept)
            } else {
                String::new()
            };
            format!("{rays} rays each, {} steps, {:.0} MiB{again}", solved.steps, *bytes as f64 / f64::from(1 << 20))
        };
        notes.add(format!(
            "radiosity: {} elements on {surfaces} surfaces{error}; residual {:.1e}; {how}",
            self.mesh.len(),
            solved.residual
        ));
        if *out_of_memory {
            notes.add("the elements that --mesh-error asks for need more than --solver-memory".to_string());
        }
        if solved.residual.is_nan() || solved.residual > 10.0 * prepare::RESIDUAL {
            notes.add(
                "the balance did not converge: surfaces absorb next to nothing, and light hardly ends".to_string(),
            );
        }
        if *glossy > 0.0 {
            notes.add(format!(
                "{:.1} % of the area has gloss, mirrors or glass: their light on other surfaces is spread as if they were matt, \
                 and none goes through; see --method path",
                100.0 * glossy
            ));
        }
    }
}
