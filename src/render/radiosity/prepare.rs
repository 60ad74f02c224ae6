//! From a scene to its solution: which sides light reaches, how far surfaces are divided, what falls on elements.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::{Lobe, Lobes};
use crate::render::meeting::Meeting;
use crate::render::radiosity::file;
use crate::render::radiosity::mesh::{Element, Mesh};
use crate::render::radiosity::rows::{Rows, is_all_covered, is_covered, look_around, may_be_covered};
use crate::render::radiosity::solve::{Solved, System};
use crate::render::radiosity::{Account, Options, Radiosity, Show};
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, LampsAlone, Pairs, Shade};
use crate::render::solution::{self, Fingerprint};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::geometry::Patch;
use crate::scene::light::Emission;
use crate::scene::{Hit, Scene, ray};
use crate::{Result, invalid, parallel};

/// Of solution files.
const KIND: &str = "radiosity";
/// Residual at which the balance is good enough: far below what rays and elements leave.
pub const RESIDUAL: f64 = 1e-4;
/// Rays from an element for each place on it from which the lamps are looked at.
const RAYS_A_LOOK: u32 = 4;
/// Rays that tell an error of 2 % where surfaces are to be divided.
const ROUGH: f64 = 64.0;
/// Rays from each element by which sides are found that light reaches.
const FEELERS: u32 = 16;
/// Length of elements at first, in the scene's own scale: about a tenth of a room.
const COARSE: f32 = 0.3;
/// Beyond this it makes no fewer.
const LONGEST: f32 = 1e4;
/// Elements that a scene begins with, or four a side and surface where these are more.
const MANY_AT_FIRST: usize = 8192;
/// Most elements along a side at first, and at last.
const MOST_AT_FIRST: u32 = 64;
const MOST_ALONG: u32 = 1024;
/// Times that surfaces are divided.
const MOST_LEVELS: usize = 8;
/// Dividing has to leave less than this of an error to be worth while: of what is smooth it leaves a quarter.
const WORTH: f64 = 0.75;
/// Darker places than this share of the mean need not be known better than it.
const DARK: f32 = 0.05;
/// Bytes that an element may take for each wavelength of a light where rows need more than what follows.
const BYTES: usize = 64;
/// Bytes of rows that are kept in any case.
const SOME_ROWS: usize = 256 << 20;

/// Meshes and solves, or takes the solution from its file.
pub fn prepared(scene: Arc<Scene>, options: &Options, wavelengths: &dyn Wavelengths) -> Result<Radiosity> {
    parallel::ready();
    let mut workshop = Workshop { scene: &scene, options, wavelengths, lights: Vec::new() };
    let known = options.solution.as_deref().map(|p| (p, Fingerprint::of(&scene, &file::options(options), wavelengths)));
    let ((mesh, stored, account), _) = solution::kept(
        known,
        KIND,
        |b| file::parse(b, &scene, wavelengths.lanes()),
        || workshop.solution(),
        |(mesh, stored, account)| file::bytes(mesh, stored, account),
    )?;
    let brightness = workshop.brightness(&mesh, &stored);
    Ok(Radiosity { scene: scene.clone(), show: options.show, mesh, stored, brightness, account })
}

/// What a solution is made of.
struct Workshop<'a> {
    scene: &'a Scene,
    options: &'a Options,
    wavelengths: &'a dyn Wavelengths,
    /// Lights that shine on anything.
    lights: Vec<u32>,
}

impl Workshop<'_> {
    fn solution(&mut self) -> Result<(Mesh, Stored, Account)> {
        let mut length = COARSE;
        let mut mesh = loop {
            let mesh = Mesh::new(&self.scene.geometry, |p| match self.options.divide {
                Some(n) => [n, n],
                None => coarse(p, length),
            });
            // Wide grounds and far hills begin with longer ones, as long as that makes fewer.
            let few = mesh.len() <= MANY_AT_FIRST.max(8 * mesh.tiles().len());
            if few || length > LONGEST || self.options.divide.is_some() {
                break mesh;
            }
            length *= 2.0;
        };
        self.afford(mesh.len(), 1)?;
        self.wake(&mut mesh);
        self.afford(mesh.len(), self.lights.len())?;
        let mut account = Account::default();
        let mut before: HashMap<(usize, bool), f64> = HashMap::new();
        let rough = (ROUGH * (0.02 / self.options.tolerance).powi(2)).max(ROUGH).min(f64::from(self.options.rays));
        let mut level = 0;
        let stored = loop {
            let reflectance = self.reflectances(&mesh);
            if self.options.divide.is_none() && level < MOST_LEVELS {
                level += 1;
                let mut trial = self.direct(&mesh, rough as u32);
                self.balance(&mesh, &reflectance, &mut trial, rough as u32, 1e-2);
                let judged = self.judge(&mesh, &trial);
                account.error = Some(judged.error);
                let worth = |side: &(usize, bool), error: f64| {
                    error > self.options.tolerance && before.get(side).is_none_or(|b| error < WORTH * b)
                };
                let mut again: Vec<usize> =
                    judged.sides.iter().filter(|(side, e)| worth(side, *e)).map(|(side, _)| side.0).collect();
                again.dedup();
                before.extend(judged.sides);
                let (fits, finer) = self.divided(&mut mesh, &again);
                account.out_of_memory |= !fits;
                if finer {
                    continue;
                }
            }
            let mut stored = self.direct(&mesh, self.options.rays);
            (account.solved, account.rows_kept, account.bytes) =
                self.balance(&mesh, &reflectance, &mut stored, self.options.rays, RESIDUAL);
            break stored;
        };
        account.surfaces = mesh.surfaces();
        account.glossy = self.glossy(&mesh);
        Ok((mesh, stored, account))
    }

    /// Bytes that elements take without their rows: two solutions, reflectances, and six vectors of the solver.
    fn bytes(&self, elements: usize, lights: usize) -> usize {
        elements * self.wavelengths.lanes() * size_of::<f32>() * (2 * lights + 7)
    }

    fn afford(&self, elements: usize, lights: usize) -> Result<()> {
        let (bytes, memory) = (self.bytes(elements, lights), self.options.memory);
        if bytes > memory {
            let mib = |b: usize| (b as f64 / f64::from(1 << 20)).ceil();
            return invalid!(
                "radiosity of {elements} elements, {} wavelengths and {lights} lights takes {} MiB, and --solver-memory is {}; fewer \
                 --bands take less",
                self.wavelengths.lanes(),
                mib(bytes),
                mib(memory)
            );
        }
        Ok(())
    }

    /// Leaves out sides that no light reaches, such as the outside of a closed room, and lights that reach no side.
    fn wake(&mut self, mesh: &mut Mesh) {
        let lanes = self.wavelengths.lanes();
        let side = |tile: usize, front: bool| 2 * tile as u32 + u32::from(!front);
        let found: Vec<(u32, Vec<bool>, Vec<u32>)> = (0..mesh.len() as u32)
            .into_par_iter()
            .map(|number| {
                let (tile, element) = mesh.element(number);
                let mut sums = vec![0f32; self.scene.lights.len() * lanes];
                self.look(&element, number, FEELERS, &mut sums);
                let lights = sums.chunks(lanes).map(|s| s.iter().any(|x| *x > 0.0)).collect();
                let mut seen = Vec::new();
                look_around(&self.scene.geometry, mesh, number, FEELERS, self.options.seed, |e| {
                    let (tile, element) = mesh.element(e);
                    seen.push(side(tile, element.front));
                });
                seen.sort_unstable();
                seen.dedup();
                (side(tile, element.front), lights, seen)
            })
            .collect();
        let mut awake = vec![false; 2 * mesh.tiles().len()];
        let mut lights = vec![false; self.scene.lights.len()];
        for (side, lit, _) in &found {
            awake[*side as usize] |= lit.contains(&true);
            lights.iter_mut().zip(lit).for_each(|(l, lit)| *l |= lit);
        }
        loop {
            let mut more = false;
            for (side, _, seen) in &found {
                if !awake[*side as usize] && seen.iter().any(|s| awake[*s as usize]) {
                    awake[*side as usize] = true;
                    more = true;
                }
            }
            if !more {
                break;
            }
        }
        for (i, awake) in awake.iter().enumerate() {
            mesh.wake(i / 2, i % 2 == 0, *awake);
        }
        mesh.number();
        self.lights = (0..lights.len() as u32).filter(|i| lights[*i as usize]).collect();
    }

    /// Adds the lamps' light on an element, a row a light of the scene.
    fn look(&self, element: &Element, number: u32, looks: u32, sums: &mut [f32]) {
        let shade = Shade { scene: self.scene, rest: &LampsAlone, shadows: true, follow: Follow::Nothing };
        let (mut trail, reach, size) = (Trail::default(), element.tile.patch.reach(), element.size());
        trail.fork();
        let open = !may_be_covered(&self.scene.geometry, element, number);
        let mut taken = 0;
        for i in 0..looks {
            let sampler = Sampler::new(number, 0x2c1b_3c6d, i, self.options.seed);
            let (point, normal) = element.place(sampler.pair(0));
            let at = Meeting { reach, ..Meeting::facing(point, normal) };
            if !open && is_covered(&self.scene.geometry, at.start(false).0, normal, size) {
                continue;
            }
            taken += 1;
            trail.branch();
            shade.lobe(&at, &Lobe::WHITE, &mut Pairs::new(&sampler, 1), &mut trail);
        }
        self.wavelengths.gather(&trail, &Stored::default(), 1.0 / taken.max(1) as f32, sums);
    }

    /// The lamps' light on all elements; room for as much again behind it.
    fn direct(&self, mesh: &Mesh, rays: u32) -> Stored {
        let (lanes, lights) = (self.wavelengths.lanes(), self.lights.len());
        let mut data = vec![0f32; 2 * mesh.len() * lights * lanes];
        let (direct, _) = data.split_at_mut(mesh.len() * lights * lanes);
        if lights > 0 {
            direct.par_chunks_mut(lights * lanes).enumerate().for_each(|(number, row)| {
                let mut sums = vec![0f32; self.scene.lights.len() * lanes];
                self.look(&mesh.element(number as u32).1, number as u32, (rays / RAYS_A_LOOK).max(1), &mut sums);
                for (row, light) in row.chunks_mut(lanes).zip(&self.lights) {
                    row.copy_from_slice(&sums[*light as usize * lanes..][..lanes]);
                }
            });
        }
        Stored { lights: self.lights.clone(), lanes, data }
    }

    /// Solves for each light; adds what comes from other surfaces to what is there, and puts it behind it.
    fn balance(
        &self,
        mesh: &Mesh,
        reflectance: &[f32],
        stored: &mut Stored,
        rays: u32,
        tolerance: f64,
    ) -> (Solved, [usize; 2], usize) {
        let (n, lanes, lights) = (mesh.len(), self.wavelengths.lanes(), self.lights.len());
        let fixed = self.bytes(n, lights);
        let room = (BYTES * n * lanes * lights).max(fixed + SOME_ROWS).min(self.options.memory).saturating_sub(fixed);
        let rows = Rows::trace(&self.scene.geometry, mesh, rays, self.options.seed, room);
        let sees = |from: &[f32], to: &mut [f32]| rows.apply(from, to, lanes);
        let system = System { lanes, reflectance, sees };
        let mut all = Solved::default();
        let (total, between) = stored.data.split_at_mut(n * lights * lanes);
        for light in 0..lights {
            let mut direct = vec![0f32; n * lanes];
            for (to, from) in direct.chunks_mut(lanes).zip(total.chunks(lights * lanes)) {
                to.copy_from_slice(&from[light * lanes..][..lanes]);
            }
            let (x, solved) = system.solve(&direct, tolerance);
            all = all.worse(solved);
            let rows = total.chunks_mut(lights * lanes).zip(between.chunks_mut(lights * lanes));
            for ((total, between), x) in rows.zip(x.chunks(lanes)) {
                let at = light * lanes..(light + 1) * lanes;
                between[at.clone()].copy_from_slice(x);
                total[at].iter_mut().zip(x).for_each(|(t, x)| *t += x);
            }
        }
        (all, [rows.kept(), n], fixed + rows.bytes())
    }

    /// Luminance that white elements would show, of all light and of that from other surfaces; -1 of those that are covered.
    fn brightness(&self, mesh: &Mesh, stored: &Stored) -> [Vec<f32>; 2] {
        let lights = stored.lights.len();
        let covered: Vec<bool> = (0..mesh.len())
            .into_par_iter()
            .map(|e| is_all_covered(&self.scene.geometry, &mesh.element(e as u32).1, e as u32))
            .collect();
        [0, mesh.len()].map(|first| {
            let element = |e: usize| -> f32 {
                let row = |l: usize| {
                    let weights = self.wavelengths.brightness(stored.lights[l] as usize);
                    let row = stored.row(((first + e) * lights + l) as u32);
                    row.iter().zip(weights).map(|(r, w)| r * w).sum::<f32>()
                };
                if covered[e] { -1.0 } else { (0..lights).map(row).sum() }
            };
            (0..mesh.len()).into_par_iter().map(element).collect()
        })
    }

    /// How far what is linear between elements errs on each side.
    fn judge(&self, mesh: &Mesh, stored: &Stored) -> Judged {
        let [all, between] = self.brightness(mesh, stored);
        let shown = if self.options.show == Show::Mesh { all } else { between };
        let areas: Vec<f64> = mesh.tiles().iter().map(|t| t.area).collect();
        let sides: Vec<(usize, bool)> = (0..areas.len())
            .flat_map(|i| [(i, true), (i, false)])
            .filter(|(i, front)| mesh.is_awake(*i, *front))
            .collect();
        let mean_of = |(i, front): &(usize, bool)| -> f64 {
            let elements = mesh.elements(*i, *front);
            let count = elements.len().max(1) as f64;
            elements.map(|e| f64::from(shown[e as usize].max(0.0))).sum::<f64>() / count
        };
        let area: f64 = sides.iter().map(|s| areas[s.0]).sum();
        let mean = sides.iter().map(|s| areas[s.0] * mean_of(s)).sum::<f64>() / area.max(f64::MIN_POSITIVE);
        let errors: Vec<((usize, bool), f64)> = sides
            .into_iter()
            .map(|side| {
                let elements = mesh.elements(side.0, side.1);
                let values = &shown[elements.start as usize..elements.end as usize];
                (side, mesh.tiles()[side.0].error(values, DARK * mean as f32))
            })
            .collect();
        // By the light on them: the inside of a box does not count as its outside does.
        let light = |side: &(usize, bool)| areas[side.0] * mean_of(side);
        let all = errors.iter().map(|(side, _)| light(side)).sum::<f64>().max(f64::MIN_POSITIVE);
        let error = errors.iter().map(|(side, e)| light(side) * e).sum::<f64>() / all;
        Judged { error, sides: errors }
    }

    /// Divides surfaces as far as memory allows; whether it did for all, and whether it did at all.
    fn divided(&self, mesh: &mut Mesh, tiles: &[usize]) -> (bool, bool) {
        let (mut fits, mut finer) = (true, false);
        let mut count = mesh.len();
        for tile in tiles {
            let sides = [true, false].iter().filter(|front| mesh.is_awake(*tile, **front)).count();
            let [n, m] = mesh.tiles()[*tile].cells;
            let more = 3 * sides * (n * m) as usize;
            if 2 * n.max(m) > MOST_ALONG {
                continue;
            }
            if self.bytes(count + more, self.lights.len()) > self.options.memory {
                fits = false;
                continue;
            }
            count += more;
            mesh.divide(*tile, [2 * n, 2 * m]);
            finer = true;
        }
        mesh.number();
        (fits, finer)
    }

    /// Mean reflectance of each element for light from everywhere to everywhere.
    fn reflectances(&self, mesh: &Mesh) -> Vec<f32> {
        let lanes = self.wavelengths.lanes();
        let mut uniform: HashMap<(u32, bool), Vec<f32>> = HashMap::new();
        for (i, tile) in mesh.tiles().iter().enumerate() {
            let material = tile.patch.surface.material;
            for front in [true, false] {
                if mesh.is_awake(i, front) && !self.scene.looks_at_site[material as usize] {
                    uniform.entry((material, front)).or_insert_with(|| {
                        let number = mesh.elements(i, front).start;
                        self.reflectance(&mesh.element(number).1, number)
                    });
                }
            }
        }
        let mut all = vec![0f32; mesh.len() * lanes];
        all.par_chunks_mut(lanes).enumerate().for_each(|(number, row)| {
            let (_, element) = mesh.element(number as u32);
            match uniform.get(&(element.tile.patch.surface.material, element.front)) {
                Some(known) => row.copy_from_slice(known),
                None => row.copy_from_slice(&self.reflectance(&element, number as u32)),
            }
        });
        all
    }

    /// Of one element: all that its lobes send back.
    fn reflectance(&self, element: &Element, number: u32) -> Vec<f32> {
        const PLACES: u32 = 64;
        let mut trail = Trail::default();
        trail.fork();
        for i in 0..PLACES {
            let sampler = Sampler::new(number, 0x7ed5_5d16, i, self.options.seed);
            let hit = hit(&element.tile.patch, element.square(sampler.pair(0)));
            let away = crate::material::kernel::lambert::cosine(sampler.pair(1));
            let (site, shading) = self.scene.site(&hit, element.front);
            let axis = if element.front { shading } else { -shading };
            let (s, t) = ray::frame(axis);
            let out = (s * away.x + t * away.y + axis * away.z.max(1e-3)).normalize();
            let at = Meeting::new(&hit, element.front, shading, -out);
            let mut lobes = Lobes::default();
            self.scene.materials[hit.surface.material as usize].lobes(&site, at.out, &mut lobes);
            let mut pairs = Pairs::new(&sampler, 2);
            for lobe in lobes.iter().filter(|l| !l.kernel.transmits() && !l.kernel.is_straight()) {
                if let Some(turn) = lobe.kernel.sample(at.out, pairs.pair()) {
                    trail.branch();
                    trail.tint(&lobe.tint, at.cos_half(turn.inc));
                    trail.light(&Emission::one(0, 1.0), lobe.factor * turn.weight, 0);
                }
            }
        }
        let mut sums = vec![0f32; self.wavelengths.lanes()];
        self.wavelengths.gather(&trail, &Stored::default(), 1.0 / PLACES as f32, &mut sums);
        sums
    }

    /// Share of the area that is not only matt.
    fn glossy(&self, mesh: &Mesh) -> f64 {
        let (mut some, mut all) = (0.0, 0.0);
        for (i, tile) in mesh.tiles().iter().enumerate() {
            if !(mesh.is_awake(i, true) || mesh.is_awake(i, false)) {
                continue;
            }
            let area = tile.area;
            all += area;
            let hit = hit(&tile.patch, [0.3, 0.3]);
            let shiny = [true, false].into_iter().filter(|front| mesh.is_awake(i, *front)).any(|front| {
                let (site, _) = self.scene.site(&hit, front);
                let mut lobes = Lobes::default();
                let out = Vec3A::new(0.3, 0.2, 0.9).normalize();
                self.scene.materials[hit.surface.material as usize].lobes(&site, out, &mut lobes);
                lobes.iter().any(|l| !l.kernel.is_matt() || l.kernel.transmits())
            });
            some += if shiny { area } else { 0.0 };
        }
        if all > 0.0 { some / all } else { 0.0 }
    }
}

/// Errors of sides.
struct Judged {
    /// Mean over area and light.
    error: f64,
    sides: Vec<((usize, bool), f64)>,
}

/// A point of a surface as a ray would have met it.
fn hit(patch: &Patch, square: [f32; 2]) -> Hit {
    let (point, normal) = patch.place(square);
    Hit {
        t: 0.0,
        point,
        normal,
        surface: patch.surface,
        primitive: patch.primitive,
        placement: patch.placement,
        bary: patch.bary(square),
        reach: patch.reach(),
    }
}

/// Elements that a surface is divided into at first.
fn coarse(patch: &Patch, length: f32) -> [u32; 2] {
    let small = patch.area() < f64::from(0.1 * length * length);
    let along = |side: f32| ((side / length).ceil() as u32).min(MOST_AT_FIRST);
    let [a, b] = patch.sides().map(along);
    match (patch.is_triangle(), patch.is_round()) {
        // Triangles are what meshes are made of.
        (true, _) => {
            let n = a.max(b).max(1);
            [n, n]
        }
        (_, true) => [a.max(if small { 4 } else { 8 }), b.max(if small { 2 } else { 4 })],
        (..) if small => [1, 1],
        _ => [a.max(3), b.max(3)],
    }
}
