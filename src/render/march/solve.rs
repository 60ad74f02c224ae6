//! The zonal method [Rushmeier 1987]: what falls on each element is what lamps send it and what all elements do,
//! `G = D + F (A G)`: G the mean radiance around a place of a zone, or over the hemisphere of a tile; D that of the lamps; F the
//! exchange shares; A the albedo of a zone and the reflectance of a tile. All wavelengths of a light are solved eight by eight.

use rayon::prelude::*;

use crate::material::{Lobe, Lobes};
use crate::medium::Medium;
use crate::render::direct::{Direct, Look};
use crate::render::lanes::GROUP;
use crate::render::march::exchange::{self, Rays};
use crate::render::march::zones::Zones;
use crate::render::media::{Bodies, Lots};
use crate::render::meeting::Meeting;
use crate::render::sampler::Sampler;
use crate::render::shade::{self, Pairs};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::Scene;
use crate::{Result, invalid};

/// Steps of the balance at most, and the change at which it ends.
pub const MOST_STEPS: usize = 4000;
const SETTLED: f32 = 1e-5;

/// What is asked of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Cubes along the longest side of what is filled.
    pub along: u32,
    /// Rays from each element.
    pub rays: u32,
    /// Bytes at most.
    pub memory: usize,
}

/// Balanced light.
pub struct Solution {
    /// The elements.
    pub zones: Zones,
    /// Rows of each element for each light: what zones have around them, and tiles send back. After those, of zones, the same without
    /// what comes straight from the lamps.
    pub stored: Stored,
    /// Of the matrices.
    pub account: Account,
}

/// How it went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Account {
    /// Elements.
    pub elements: usize,
    /// See [`exchange::Shares`].
    pub closure: f32,
    /// See [`exchange::Shares`].
    pub noise: f32,
    /// Steps of the balance.
    pub steps: usize,
    /// The last change over the largest value.
    pub residual: f32,
    /// Largest optical depth of a zone's edge.
    pub thickest: f32,
}

impl Solution {
    /// Of a scene.
    pub fn new(scene: &Scene, o: &Options, wavelengths: &dyn Wavelengths) -> Result<Solution> {
        let zones = Zones::new(scene, o.along, 2 * o.along * o.along);
        let (n, lanes, lights) = (zones.count(), wavelengths.lanes(), scene.lights.len());
        let bytes = n * n * size_of::<[f32; GROUP]>() + 3 * n * lanes * lights * 4;
        if bytes > o.memory {
            return invalid!(
                "{n} zones and tiles take {} MiB, more than --solver-memory; fewer --zones take less",
                bytes >> 20
            );
        }
        let rays = Rays::trace(scene, &zones, o.rays);
        let direct = lit(scene, &zones, o.rays, wavelengths);
        let albedos = albedos(scene, &zones, wavelengths);
        let mut account = Account { elements: n, ..Account::default() };
        let mut all = direct.clone();
        for first in (0..lanes).step_by(GROUP) {
            let sigma: Vec<[f32; GROUP]> = coefficients(scene, wavelengths, first, |m| m.extinction);
            let areas = areas(scene, &zones, &sigma);
            for zone in &zones.zones {
                let edge = scene.frame.length_m(zones.edge)
                    * scene.media.list[zone.medium as usize].density.at(zone.places[0]);
                let most = sigma[zone.medium as usize].iter().fold(0.0f32, |a, b| a.max(*b));
                account.thickest = account.thickest.max(most * edge);
            }
            let shares = rays.shares(&sigma, &areas);
            account.closure = account.closure.max(shares.closure);
            account.noise = account.noise.max(shares.noise);
            let part = |rows: &[f32], light: usize| -> Vec<[f32; GROUP]> {
                (0..n).map(|i| std::array::from_fn(|k| rows[(i * lights + light) * lanes + first + k])).collect()
            };
            let albedo: Vec<[f32; GROUP]> =
                (0..n).map(|i| std::array::from_fn(|k| albedos[i * lanes + first + k])).collect();
            for light in 0..lights {
                let mut source = part(&direct, light);
                glow(
                    scene,
                    &zones,
                    light,
                    &shares.data,
                    &coefficients(scene, wavelengths, first, |m| m.absorption),
                    &sigma,
                    &mut source,
                );
                let (solved, steps, residual) = balance(&source, &shares.data, &albedo);
                account.steps = account.steps.max(steps);
                account.residual = account.residual.max(residual);
                for (i, g) in solved.iter().enumerate() {
                    all[(i * lights + light) * lanes + first..][..GROUP].copy_from_slice(g);
                }
            }
        }
        Ok(Solution { stored: stored(&zones, all, &direct, &albedos, lanes, lights), zones, account })
    }
}

/// Each medium's coefficient at eight wavelengths.
fn coefficients(scene: &Scene, w: &dyn Wavelengths, first: usize, of: impl Fn(&Medium) -> u32) -> Vec<[f32; GROUP]> {
    let one = |m: &Medium| {
        let lanes = w.ink(of(m));
        std::array::from_fn(|k| lanes[first + k])
    };
    scene.media.list.iter().map(one).collect()
}

/// 4 sigma_t V of zones, areas of tiles, in metres.
fn areas(scene: &Scene, zones: &Zones, sigma: &[[f32; GROUP]]) -> Vec<[f32; GROUP]> {
    let metre = scene.frame.scale;
    let volumes = zones.zones.iter().map(|z| {
        let mean: f32 = z.places.iter().map(|p| scene.media.list[z.medium as usize].density.at(*p)).sum::<f32>()
            / z.places.len() as f32;
        let volume = (z.volume / metre.powi(3)) as f32 * mean;
        sigma[z.medium as usize].map(|s| 4.0 * s * volume)
    });
    let tiles = zones.tiles.iter().map(|t| [(t.area / metre.powi(2)) as f32; GROUP]);
    volumes.chain(tiles).collect()
}

/// What lamps send each element: rows of all lights.
fn lit(scene: &Scene, zones: &Zones, rays: u32, wavelengths: &dyn Wavelengths) -> Vec<f32> {
    let (lanes, lights) = (wavelengths.lanes(), scene.lights.len());
    let mut rows = vec![0f32; zones.count() * lanes * lights];
    let looks = (rays / 4).max(16);
    rows.par_chunks_mut(lanes * lights).enumerate().for_each(|(element, row)| {
        let mut trail = Trail::default();
        let mut sums = vec![0f32; lanes * (lights + 1)];
        for i in 0..looks {
            let start = exchange::start(scene, zones, element, i);
            let sampler = Sampler::new(element as u32, 0x6a09_e667, i, 0);
            let mut lots = Lots::of(scene, &sampler);
            trail.clear();
            for lamp in 0..scene.lamps.len() {
                let mut bodies = Bodies { inside: start.inside, from: start.place, lots: &mut lots };
                let direct = Direct { scene };
                let u = sampler.pair(lamp as u32);
                if let Some(normal) = start.normal {
                    let at = Meeting::facing(start.place, normal);
                    let look = Look { lamp, chance: 1.0, u, may_run_into: false, shadows: true };
                    direct.look_in(&at, &Lobe::WHITE, 1.0, &look, (None, Some(bodies)), &mut trail);
                    continue;
                }
                let Some(aim) = scene.lamps[lamp].aim(start.place, u) else { continue };
                let density = if aim.pdf.is_finite() { aim.pdf } else { 1.0 };
                let weight = 0.25 * std::f32::consts::FRAC_1_PI / density;
                direct.note(start.place, lamp, &aim, weight, &mut bodies, &mut trail);
            }
            wavelengths.gather(&trail, &Stored::default(), 1.0 / looks as f32, &mut sums);
        }
        row.copy_from_slice(&sums[..lanes * lights]);
    });
    rows
}

/// Of zones the albedo, of tiles the reflectance, a row each.
fn albedos(scene: &Scene, zones: &Zones, wavelengths: &dyn Wavelengths) -> Vec<f32> {
    let lanes = wavelengths.lanes();
    let mut rows = Vec::with_capacity(zones.count() * lanes);
    for zone in &zones.zones {
        let medium = &scene.media.list[zone.medium as usize];
        let extinction = wavelengths.ink(medium.extinction);
        let scattering = medium.scattering.map(|s| wavelengths.ink(s));
        rows.extend((0..lanes).map(|k| match &scattering {
            Some(s) if extinction[k] > 0.0 => s[k] / extinction[k],
            _ => 0.0,
        }));
    }
    for (i, tile) in zones.tiles.iter().enumerate() {
        rows.extend(reflectance(scene, zones, i, tile.front, wavelengths));
    }
    rows
}

/// What a tile sends back of light from everywhere, seen along its normal.
fn reflectance(scene: &Scene, zones: &Zones, number: usize, front: bool, wavelengths: &dyn Wavelengths) -> Vec<f32> {
    const PLACES: u32 = 16;
    let tile = &zones.tiles[number];
    let patch = &zones.patches[tile.patch];
    let mut trail = Trail::default();
    trail.fork();
    for i in 0..PLACES {
        let sampler = Sampler::new(number as u32, 0x3c6e_f372, i, 0);
        let [a, b] = sampler.pair(0);
        let square = [(tile.at[0] as f32 + a) / tile.of as f32, (tile.at[1] as f32 + b) / tile.of as f32];
        let hit = patch.hit(square);
        let (site, shading) = scene.site(&hit, front);
        let at = Meeting::new(&hit, front, shading, if front { -hit.normal } else { hit.normal });
        let mut lobes = Lobes::default();
        scene.materials[patch.surface.material as usize].lobes(&site, at.out, &mut lobes);
        shade::note_sent(&lobes, at.out, &mut Pairs::new(&sampler, 1), &mut trail);
    }
    let mut sums = vec![0f32; wavelengths.lanes() * (scene.lights.len() + 1)];
    wavelengths.gather(&trail, &Stored::default(), 1.0 / PLACES as f32, &mut sums);
    sums.truncate(wavelengths.lanes());
    sums
}

/// Adds what zones give off themselves to what falls on the others.
fn glow(
    scene: &Scene,
    zones: &Zones,
    light: usize,
    shares: &[[f32; GROUP]],
    absorption: &[[f32; GROUP]],
    extinction: &[[f32; GROUP]],
    source: &mut [[f32; GROUP]],
) {
    let n = zones.count();
    for (j, zone) in zones.zones.iter().enumerate() {
        let m = zone.medium as usize;
        if scene.media.list[m].glow != Some(light as u32) {
            continue;
        }
        for (i, source) in source.iter_mut().enumerate() {
            for k in 0..GROUP {
                let share = if extinction[m][k] > 0.0 { absorption[m][k] / extinction[m][k] } else { 0.0 };
                source[k] += shares[i * n + j][k] * share;
            }
        }
    }
}

/// Solves G = D + F (A G) by steps; how many, and the last change over the largest value.
fn balance(
    source: &[[f32; GROUP]],
    shares: &[[f32; GROUP]],
    albedo: &[[f32; GROUP]],
) -> (Vec<[f32; GROUP]>, usize, f32) {
    let n = source.len();
    let mut light = source.to_vec();
    let mut residual = 0.0;
    for step in 1..=MOST_STEPS {
        let sent: Vec<[f32; GROUP]> =
            light.iter().zip(albedo).map(|(g, a)| std::array::from_fn(|k| g[k] * a[k])).collect();
        let next: Vec<[f32; GROUP]> = (shares.par_chunks(n.max(1)).zip(source))
            .map(|(row, source)| {
                let mut sum = *source;
                for (f, s) in row.iter().zip(&sent) {
                    for k in 0..GROUP {
                        sum[k] += f[k] * s[k];
                    }
                }
                sum
            })
            .collect();
        let most = next.iter().flatten().fold(0.0f32, |a, b| a.max(*b));
        let change = next.iter().flatten().zip(light.iter().flatten()).fold(0.0f32, |a, (x, y)| a.max((x - y).abs()));
        light = next;
        residual = if most > 0.0 { change / most } else { 0.0 };
        if residual < SETTLED {
            return (light, step, residual);
        }
    }
    (light, MOST_STEPS, residual)
}

fn stored(zones: &Zones, all: Vec<f32>, direct: &[f32], albedos: &[f32], lanes: usize, lights: usize) -> Stored {
    let mut data = all.clone();
    // What a tile sends back.
    for (i, rows) in data.chunks_exact_mut(lanes * lights).enumerate().skip(zones.zones.len()) {
        for row in rows.chunks_exact_mut(lanes) {
            row.iter_mut().zip(&albedos[i * lanes..]).for_each(|(x, a)| *x *= a);
        }
    }
    let of_zones = zones.zones.len() * lanes * lights;
    data.extend(all[..of_zones].iter().zip(direct).map(|(g, d)| (g - d).max(0.0)));
    Stored { lights: (0..lights as u32).collect(), lanes, data }
}
