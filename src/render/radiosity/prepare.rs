//! From a scene to its solution: which sides light reaches, what falls on elements, and how they share it.

use std::sync::Arc;

use rayon::prelude::*;

use crate::material::Lobe;
use crate::medium::Inside;
use crate::render::meeting::Meeting;
use crate::render::radiosity::cover::{self, Cover, Ground, Reached};
use crate::render::radiosity::divide;
use crate::render::radiosity::file;
use crate::render::radiosity::matter::Dye;
use crate::render::radiosity::mesh::Mesh;
use crate::render::radiosity::rows::{self, Rows};
use crate::render::radiosity::solve::{Solved, System};
use crate::render::radiosity::{Account, Options, Radiosity, Show};
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, LampsAlone, Pairs, Shade};
use crate::render::solution::{self, Fingerprint};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::{Scene, ray};
use crate::{Result, invalid, parallel};

/// Of solution files.
const KIND: &str = "radiosity";
/// Residual at which the balance is good enough: far below what rays and elements leave.
pub const RESIDUAL: f64 = 1e-4;
/// Rays from an element for each place on it from which the lamps are looked at: where that is shown, and where it only goes
/// on to others.
const RAYS_A_LOOK: [u32; 2] = [4, 16];
/// Bytes that an element may take for each wavelength of a light where rows need more than what follows.
const BYTES: usize = 64;
/// Vectors that the solver works on.
const VECTORS: usize = 8;
/// Rays for whose rows there has to be room where surfaces are divided.
const SOME_RAYS: u32 = 256;
/// Bytes of rows that are kept in any case.
const SOME_ROWS: usize = 256 << 20;

/// Meshes and solves, or takes the solution from its file.
pub fn prepared(scene: Arc<Scene>, options: &Options, wavelengths: &dyn Wavelengths) -> Result<Radiosity> {
    parallel::ready();
    let mut workshop = Workshop { scene: &scene, options, wavelengths, lights: Vec::new(), covered: None };
    let known = options.solution.as_deref().map(|p| (p, Fingerprint::of(&scene, &file::options(options), wavelengths)));
    let ((mesh, stored, account), _) = solution::kept(
        known,
        KIND,
        |b| file::parse(b, &scene, wavelengths.lanes()),
        || workshop.solution(),
        |(mesh, stored, account)| file::bytes(mesh, stored, account),
    )?;
    let cover = workshop.covered.take().unwrap_or_else(|| workshop.cover(&mesh));
    let ground = Ground { geometry: &scene.geometry, mesh: &mesh, cover: &cover };
    let brightness = workshop.brightness(ground, &stored.data, &workshop.weights(&stored.lights));
    Ok(Radiosity { scene: scene.clone(), show: options.show, mesh, cover, stored, brightness, account })
}

/// What a solution is made of.
pub struct Workshop<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What is asked for.
    pub options: &'a Options,
    /// What light is made of.
    pub wavelengths: &'a dyn Wavelengths,
    /// Lights that shine on anything.
    lights: Vec<u32>,
    /// Of the mesh that was solved.
    covered: Option<Cover>,
}

impl Workshop<'_> {
    fn solution(&mut self) -> Result<(Mesh, Stored, Account)> {
        let mut mesh = Mesh::new(&self.scene.geometry);
        divide::at_first(&mut mesh, self.options.divide);
        self.afford(mesh.len(), 1)?;
        self.wake(&mut mesh);
        self.afford(mesh.len(), self.lights.len())?;
        let mut account = Account::default();
        let known = if self.options.divide.is_none() { self.divide(&mut mesh, &mut account) } else { None };
        let cover = known.unwrap_or_else(|| self.cover(&mesh));
        let ground = Ground { geometry: &self.scene.geometry, mesh: &mesh, cover: &cover };
        let mut data = self.direct(ground, self.options.rays, false);
        let reflectance = self.reflectances(&mesh);
        let dyes = if self.has_own() { self.dyes(&mesh) } else { Vec::new() };
        let balanced = self.balance(ground, (&reflectance, &dyes), &mut data, self.options.rays, RESIDUAL);
        account = Account { out_of_memory: account.out_of_memory, ..balanced };
        if self.options.divide.is_none() {
            account.error = Some(self.error(&mesh, self.brightness(ground, &data, &self.weights(&self.lights))));
        }
        account.surfaces = mesh.surfaces();
        account.glossy = self.glossy(&mesh);
        let stored = Stored { lights: self.lights.clone(), lanes: self.wavelengths.lanes(), data };
        self.covered = Some(cover);
        Ok((mesh, stored, account))
    }

    /// Luminance of elements as in [`Workshop::brightness`], roughly: by few rays, and all lights as one.
    pub fn trial(&self, mesh: &Mesh, cover: &Cover, rays: u32) -> [Vec<f32>; 2] {
        const TOLERANCE: f64 = 1e-2;
        let ground = Ground { geometry: &self.scene.geometry, mesh, cover };
        let mut data = self.direct(ground, rays, true);
        self.balance(ground, (&self.reflectances(mesh), &[]), &mut data, rays, TOLERANCE);
        self.brightness(ground, &data, &[&vec![1.0; self.wavelengths.lanes()]])
    }

    /// As many elements fit into the memory that is granted, with rows of some rays.
    pub fn fits(&self, elements: usize) -> bool {
        let rows = elements * self.options.rays.min(SOME_RAYS) as usize * rows::BYTES_A_RAY;
        self.bytes(elements, self.lights.len()) + rows <= self.options.memory
    }

    /// Bytes that elements take without their rows: two solutions, reflectances, and the solver's vectors.
    fn bytes(&self, elements: usize, lights: usize) -> usize {
        elements * self.wavelengths.lanes() * size_of::<f32>() * (2 * lights + 1 + VECTORS)
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
        let Reached { sides, lights, .. } = self.reached(mesh, cover::FEELERS as usize);
        for (i, awake) in sides.iter().enumerate() {
            mesh.wake(i / 2, i % 2 == 0, *awake);
        }
        mesh.number();
        self.lights = (0..lights.len() as u32).filter(|i| lights[*i as usize]).collect();
        if self.scene.fluoresces() && !self.lights.is_empty() {
            self.lights.push(self.scene.lights.len() as u32);
        }
    }

    /// The last light is that of fluorescent surfaces.
    fn has_own(&self) -> bool {
        self.lights.last() == Some(&(self.scene.lights.len() as u32))
    }

    /// What of a mesh's elements is open.
    pub fn cover(&self, mesh: &Mesh) -> Cover {
        const LOOKS: usize = 4;
        self.reached(mesh, LOOKS).cover
    }

    fn reached(&self, mesh: &Mesh, looks: usize) -> Reached {
        let (lanes, lights, seed) = (self.wavelengths.lanes(), self.scene.lights.len(), self.options.seed);
        cover::reached(&self.scene.geometry, mesh, (seed, looks), |number, places| {
            let mut sums = vec![0f32; lights * lanes];
            self.look(number, places.iter().map(|p| Meeting::facing(p.start, p.normal)), &mut sums);
            sums.chunks(lanes).map(|s| s.iter().any(|x| *x > 0.0)).collect()
        })
    }

    /// The mean of the lamps' light on some places of an element, a row a light of the scene.
    fn look(&self, number: u32, places: impl Iterator<Item = Meeting>, sums: &mut [f32]) {
        let shade = Shade {
            scene: self.scene,
            rest: &LampsAlone,
            shadows: true,
            follow: Follow::Nothing,
            inside: Inside::default(),
        };
        let mut trail = Trail::default();
        trail.fork();
        let mut looks = 0;
        for at in places {
            let sampler = Sampler::new(number, 0x2c1b_3c6d, looks, self.options.seed);
            trail.branch();
            shade.lobe(&at, &Lobe::WHITE, &mut Pairs::new(&sampler, 1), &mut trail);
            looks += 1;
        }
        self.wavelengths.gather(&trail, &Stored::default(), 1.0 / looks.max(1) as f32, sums);
    }

    /// The lamps' light on all elements, a row a light, or one for all in which wavelengths count as they are seen; room for as
    /// much again behind it.
    fn direct(&self, ground: Ground, rays: u32, as_one: bool) -> Vec<f32> {
        let (lanes, n) = (self.wavelengths.lanes(), ground.mesh.len());
        let rows = if as_one { self.lights.len().min(1) } else { self.lights.len() };
        let mut data = vec![0f32; 2 * n * rows * lanes];
        if rows == 0 {
            return data;
        }
        let looks = (rays / RAYS_A_LOOK[usize::from(self.options.show != Show::Mesh)]).max(1);
        data[..n * rows * lanes].par_chunks_mut(rows * lanes).enumerate().for_each(|(number, row)| {
            let number = number as u32;
            let mut sums = vec![0f32; self.scene.lights.len() * lanes];
            let (_, element) = ground.mesh.element(number);
            let (reach, is_open) = (element.tile.patch.reach(), ground.opening(number));
            let sampler = |i| Sampler::new(number, 0x2c1b_3c6d, i, self.options.seed);
            let places = (0..looks).map(|i| element.place(sampler(i).pair(0)));
            let open = places.filter(|(p, normal)| is_open(ray::offset(*p, *normal, reach), *normal));
            let open = open.map(|(point, normal)| Meeting { reach, ..Meeting::facing(point, normal) });
            self.look(number, open, &mut sums);
            let lamps = self.lights.iter().map(|l| *l as usize).filter(|l| *l < self.scene.lights.len());
            for (i, light) in lamps.enumerate() {
                let from = &sums[light * lanes..][..lanes];
                if as_one {
                    let seen = self.wavelengths.brightness(light);
                    row.iter_mut().zip(from).zip(seen).for_each(|((row, x), w)| *row += x * w);
                } else {
                    row[i * lanes..][..lanes].copy_from_slice(from);
                }
            }
        });
        data
    }

    /// Solves for all lights; adds what comes from other surfaces to what is there, and puts it behind it. `dyes` are those of
    /// fluorescent elements, none where they do not count.
    fn balance(
        &self,
        ground: Ground,
        (reflectance, dyes): (&[f32], &[Dye]),
        data: &mut [f32],
        rays: u32,
        tolerance: f64,
    ) -> Account {
        let (n, lanes) = (ground.mesh.len(), self.wavelengths.lanes());
        let lights = data.len() / (2 * n * lanes).max(1);
        let fixed = self.bytes(n, lights);
        let room = (BYTES * n * lanes * lights).max(fixed + SOME_ROWS).min(self.options.memory).saturating_sub(fixed);
        let rows = Rows::trace(ground, rays, self.options.seed, room);
        let sees = |from: &[f32], to: &mut [f32]| rows.apply(from, to, lanes);
        let system = System { lanes, reflectance, sees };
        let mut all = Solved::default();
        let (total, between) = data.split_at_mut(n * lights * lanes);
        let lamps = if dyes.is_empty() { lights } else { lights - 1 };
        for light in 0..lamps {
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
        if !dyes.is_empty() {
            all = all.worse(self.fluoresce(&system, dyes, (total, between), tolerance));
        }
        let bytes = fixed + rows.bytes();
        Account { solved: all, rays: rows.rays(), rows_kept: [rows.kept(), n], bytes, ..Account::default() }
    }

    /// Light of fluorescent elements, which is the last: what they give off for all that falls on them falls on others, and is
    /// balanced as any light is; for that they give off again, at ever longer wavelengths.
    fn fluoresce<F: Fn(&[f32], &mut [f32]) + Sync>(
        &self,
        system: &System<F>,
        dyes: &[Dye],
        (total, between): (&mut [f32], &mut [f32]),
        tolerance: f64,
    ) -> Solved {
        const MOST_TURNS: usize = 16;
        let (lanes, lights) = (self.wavelengths.lanes(), self.lights.len());
        let own = (lights - 1) * lanes..lights * lanes;
        let mut given = vec![0f32; dyes.len() * lanes];
        let mut all = Solved::default();
        for _ in 0..MOST_TURNS {
            let before: f64 = given.iter().map(|x| f64::from(*x)).sum();
            let each = given.par_chunks_mut(lanes).zip(dyes).zip(total.par_chunks(lights * lanes));
            each.for_each(|((given, dye), falls)| {
                let Some((ink, share)) = dye else { return };
                self.wavelengths.reradiated(*ink, &self.lights, falls, given);
                given.iter_mut().for_each(|x| *x *= share);
            });
            let mut direct = vec![0f32; given.len()];
            (system.sees)(&given, &mut direct);
            let (x, solved) = system.solve(&direct, tolerance);
            all = all.worse(solved);
            let rows = total.chunks_mut(lights * lanes).zip(between.chunks_mut(lights * lanes));
            for ((total, between), (x, direct)) in rows.zip(x.chunks(lanes).zip(direct.chunks(lanes))) {
                let sum = x.iter().zip(direct).map(|(x, d)| x + d);
                total[own.clone()].iter_mut().zip(sum).for_each(|(to, sum)| *to = sum);
                between[own.clone()].copy_from_slice(&total[own.clone()]);
            }
            let after: f64 = given.iter().map(|x| f64::from(*x)).sum();
            if (after - before).abs() <= tolerance * after {
                break;
            }
        }
        all
    }

    /// What wavelengths of lights count in luminance.
    fn weights(&self, lights: &[u32]) -> Vec<&[f32]> {
        lights.iter().map(|l| self.wavelengths.brightness(*l as usize)).collect()
    }

    /// Luminance that white elements would show, of all light and of that from other surfaces, -1 of those that are covered;
    /// `weights` of the wavelengths of each light.
    fn brightness(&self, ground: Ground, data: &[f32], weights: &[&[f32]]) -> [Vec<f32>; 2] {
        let (n, lanes) = (ground.mesh.len(), self.wavelengths.lanes());
        [0, n].map(|first| {
            let element = |e: usize| -> f32 {
                if ground.cover.is_whole(e as u32) {
                    return -1.0;
                }
                let rows = data[(first + e) * weights.len() * lanes..].chunks_exact(lanes.max(1));
                rows.zip(weights).map(|(row, w)| row.iter().zip(*w).map(|(r, w)| r * w).sum::<f32>()).sum()
            };
            (0..n).into_par_iter().map(element).collect()
        })
    }
}
