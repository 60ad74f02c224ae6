//! Exchange areas [Rushmeier 1987]: of what is on its way to each element, which share comes from which other; by rays, whose columns
//! are kept once for all wavelengths.
//!
//! A row by rays closes: all that is on its way comes from somewhere. Area times share is the same both ways, but for the rays' noise;
//! it is smoothed until both hold [Larsen 1986]. The area of a tile is its own, that of a zone 4 sigma_t V.

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::kernel::lambert;
use crate::medium::Inside;
use crate::render::lanes::GROUP;
use crate::render::march::zones::{NONE, Zones};
use crate::render::media;
use crate::render::sampler::Sampler;
use crate::scene::{Scene, ray};
use crate::simd;

/// Surfaces that a ray goes through at most.
const MOST_CROSSED: usize = 64;
/// Rounds of smoothing.
const ROUNDS: usize = 12;

/// Part of a ray.
#[derive(Clone, Copy)]
struct Part {
    /// Where: a zone, a tile, or [`NONE`].
    element: u32,
    /// Medium that it lies in; [`NONE`] of a tile.
    medium: u32,
    /// Column, m.
    column: f32,
}

/// The start of a ray.
#[derive(Clone, Copy)]
pub struct Start {
    /// A place off all surfaces.
    pub place: Vec3A,
    /// Unit direction in which it looks.
    pub direction: Vec3A,
    /// Of a tile, its normal.
    pub normal: Option<Vec3A>,
    /// Bodies that the place is in.
    pub inside: Inside,
}

/// The rays of all elements.
pub struct Rays {
    /// Of each element, its rays one after the other.
    each: Vec<Vec<Vec<Part>>>,
}

/// One wavelength group's shares: row i, column j, lane.
pub struct Shares {
    /// E x E x 8.
    pub data: Vec<[f32; GROUP]>,
    /// How far a row's sum and what it leaves the scene by is off 1, at most, after smoothing.
    pub closure: f32,
    /// How far areas times shares differ both ways, over their sum, before smoothing: the rays' noise.
    pub noise: f32,
}

/// Where ray number `i` of an element begins.
pub fn start(scene: &Scene, zones: &Zones, element: usize, i: u32) -> Start {
    let sampler = Sampler::new(element as u32, 0x2545_f491, i, 0);
    let [place, away] = [sampler.pair(0), sampler.pair(1)];
    if let Some(zone) = zones.zones.get(element) {
        let place = zone.places[i as usize % zone.places.len()];
        let z = 1.0 - 2.0 * away[0];
        let (sin, cos) = (away[1] * std::f32::consts::TAU).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        return Start { place, direction: Vec3A::new(r * cos, r * sin, z), normal: None, inside: scene.inside(place) };
    }
    let tile = &zones.tiles[element - zones.zones.len()];
    let patch = &zones.patches[tile.patch];
    let of = tile.of as f32;
    let mut square = [(tile.at[0] as f32 + place[0]) / of, (tile.at[1] as f32 + place[1]) / of];
    if patch.is_triangle() && square[0] + square[1] > 1.0 {
        square = square.map(|s| 1.0 - s);
    }
    let (point, normal) = patch.place(square);
    let normal = if tile.front { normal } else { -normal };
    let place = ray::offset(point, normal, point.abs().max_element().max(1.0));
    let local = lambert::cosine(away);
    let (s, t) = ray::frame(normal);
    let direction = (s * local.x + t * local.y + normal * local.z.max(1e-4)).normalize();
    Start { place, direction, normal: Some(normal), inside: scene.inside(place) }
}

impl Rays {
    /// Traces so many for each element.
    pub fn trace(scene: &Scene, zones: &Zones, rays: u32) -> Rays {
        let one = |element: usize| (0..rays).map(|i| trace(scene, zones, &start(scene, zones, element, i))).collect();
        Rays { each: (0..zones.count()).into_par_iter().map(one).collect() }
    }

    /// Shares at eight wavelengths: `sigma` has each medium's extinction at them, 1/m; `areas` the elements' areas there.
    pub fn shares(&self, sigma: &[[f32; GROUP]], areas: &[[f32; GROUP]]) -> Shares {
        let n = self.each.len();
        let mut data = vec![[0f32; GROUP]; n * n];
        let mut left = vec![[0f32; GROUP]; n];
        // Nothing but panes may have neither zones nor tiles.
        data.par_chunks_mut(n.max(1)).zip(&self.each).zip(&mut left).for_each(|((row, rays), left)| {
            simd::wide(
                #[inline(always)]
                || add(row, rays, sigma, left),
            );
        });
        let noise = asymmetry(&data, areas, n);
        smooth(&mut data, areas, &left, n);
        let closure = (0..n)
            .flat_map(|i| (0..GROUP).map(move |k| (i, k)))
            .map(|(i, k)| {
                let sum: f32 = data[i * n..][..n].iter().map(|s| s[k]).sum();
                (sum + left[i][k] - 1.0).abs()
            })
            .fold(0.0, f32::max);
        Shares { data, closure, noise }
    }
}

/// Adds the shares of an element's rays to its row, and what leaves the scene, or scatters where no zone is.
#[inline(always)]
fn add(row: &mut [[f32; GROUP]], rays: &[Vec<Part>], sigma: &[[f32; GROUP]], left: &mut [f32; GROUP]) {
    let weight = 1.0 / rays.len() as f32;
    for ray in rays {
        let mut seen = [weight; GROUP];
        for part in ray {
            let mut taken = seen;
            if part.medium != NONE {
                let s = &sigma[part.medium as usize];
                for k in 0..GROUP {
                    taken[k] = seen[k] * (1.0 - simd::exp(-s[k] * part.column));
                }
            }
            let to = if part.element == NONE { &mut *left } else { &mut row[part.element as usize] };
            for k in 0..GROUP {
                to[k] += taken[k];
                seen[k] -= taken[k];
            }
        }
        for k in 0..GROUP {
            left[k] += seen[k];
        }
    }
}

fn trace(scene: &Scene, zones: &Zones, start: &Start) -> Vec<Part> {
    let mut parts = Vec::new();
    let (mut from, mut origin, mut inside) = (start.place, start.place, start.inside);
    for _ in 0..MOST_CROSSED {
        let hit = scene.geometry.closest(origin, start.direction);
        let way = media::between(from, start.direction, hit.map(|h| h.point));
        zones.walk(scene, inside, &way, |element, medium, column| parts.push(Part { element, medium, column }));
        let Some(hit) = hit else { break };
        let front = hit.normal.dot(start.direction) < 0.0;
        let material = &scene.materials[hit.surface.material as usize];
        if !material.is_clear() {
            let element = zones.met(&hit, front).unwrap_or(NONE);
            parts.push(Part { element, medium: NONE, column: 0.0 });
            break;
        }
        inside = inside.beyond(material.interior(), front);
        from = hit.point;
        origin = ray::onward(hit.point, start.direction, hit.normal, hit.reach);
    }
    parts
}

/// Largest difference of areas times shares both ways, over the area.
fn asymmetry(data: &[[f32; GROUP]], areas: &[[f32; GROUP]], n: usize) -> f32 {
    let mut sums = (0.0f64, 0.0f64);
    for i in 0..n {
        for j in 0..i {
            let (a, b) = (areas[i][0] * data[i * n + j][0], areas[j][0] * data[j * n + i][0]);
            sums = (sums.0 + f64::from((a - b).abs()), sums.1 + f64::from(a + b));
        }
    }
    (sums.0 / sums.1.max(1e-30)) as f32
}

/// Makes areas times shares the same both ways, and rows sum to 1 with what they leave the scene by, in turn.
fn smooth(data: &mut [[f32; GROUP]], areas: &[[f32; GROUP]], left: &[[f32; GROUP]], n: usize) {
    for _ in 0..ROUNDS {
        for i in 0..n {
            for j in 0..i {
                for k in 0..GROUP {
                    let (a, b) = (areas[i][k], areas[j][k]);
                    if a > 0.0 && b > 0.0 {
                        let both = 0.5 * (a * data[i * n + j][k] + b * data[j * n + i][k]);
                        (data[i * n + j][k], data[j * n + i][k]) = (both / a, both / b);
                    }
                }
            }
        }
        // Nothing but panes may have neither zones nor tiles.
        data.par_chunks_mut(n.max(1)).zip(left).for_each(|(row, left)| {
            let mut sum = [0f32; GROUP];
            row.iter().for_each(|s| (0..GROUP).for_each(|k| sum[k] += s[k]));
            let scale: [f32; GROUP] =
                std::array::from_fn(|k| if sum[k] > 0.0 { (1.0 - left[k]).max(0.0) / sum[k] } else { 0.0 });
            row.iter_mut().for_each(|s| (0..GROUP).for_each(|k| s[k] *= scale[k]));
        });
    }
}
