//! Space in zones: cubes laid over all that a medium fills, and surfaces in tiles; together the elements of the zonal method.

use std::collections::HashMap;

use glam::Vec3A;

use crate::medium::Inside;
use crate::medium::density::Way;
use crate::render::media;
use crate::render::sampler::Sampler;
use crate::scene::geometry::Patch;
use crate::scene::{Hit, Scene};

/// Places that are tried in a cube, to see what fills it.
const TRIED: u32 = 16;
/// Of no zone.
pub const NONE: u32 = u32::MAX;

/// A cube, or what of it one medium fills.
pub struct Zone {
    /// Number of the medium.
    pub medium: u32,
    /// Places in it.
    pub places: Vec<Vec3A>,
    /// Volume in the scene's units.
    pub volume: f64,
}

/// Part of one side of a surface.
pub struct Tile {
    /// Index of the surface's patch.
    pub patch: usize,
    /// Its front.
    pub front: bool,
    /// Number along both sides of the square, and how many there are.
    pub at: [u32; 2],
    /// See `at`.
    pub of: u32,
    /// Area in the scene's units.
    pub area: f64,
}

/// All elements: zones first, then tiles.
pub struct Zones {
    low: Vec3A,
    /// Edge of a cube.
    pub edge: f32,
    size: [usize; 3],
    /// Of each cube, the zone.
    numbers: Vec<u32>,
    /// All zones.
    pub zones: Vec<Zone>,
    /// All surfaces.
    pub patches: Vec<Patch>,
    /// All tiles.
    pub tiles: Vec<Tile>,
    /// First tile of each surface by placement and primitive: that of the front.
    first: HashMap<(Option<u32>, u32), (u32, u32)>,
}

impl Zones {
    /// `along` cubes along the longest side of what is filled; as many tiles as `tiles`, about.
    pub fn new(scene: &Scene, along: u32, tiles: u32) -> Zones {
        let patches = scene.geometry.patches();
        let (low, high) = filled(scene, &patches);
        let edge = ((high - low).max_element() / along as f32).max(f32::MIN_POSITIVE);
        let size = ((high - low) / edge).to_array().map(|n| (n - 1e-3).ceil().max(1.0) as usize);
        let mut zones = Zones {
            low,
            edge,
            size,
            numbers: Vec::new(),
            zones: Vec::new(),
            patches: Vec::new(),
            tiles: Vec::new(),
            first: HashMap::new(),
        };
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    zones.fill(scene, Vec3A::new(x as f32, y as f32, z as f32));
                }
            }
        }
        zones.tile(scene, patches, tiles);
        zones
    }

    /// How many elements there are.
    pub fn count(&self) -> usize {
        self.zones.len() + self.tiles.len()
    }

    /// Adds a cube, where a medium that scatters or gives off light fills any of it.
    fn fill(&mut self, scene: &Scene, cube: Vec3A) {
        let corner = self.low + cube * self.edge;
        let mut found: Vec<(u32, Vec<Vec3A>)> = Vec::new();
        for i in 0..TRIED {
            let sampler = Sampler::new(self.numbers.len() as u32, 0x51ed_270b, i, 0);
            let [[a, b], [c, _]] = [sampler.pair(0), sampler.pair(1)];
            let place = corner + Vec3A::new(a, b, c) * self.edge;
            let inside = scene.inside(place);
            let Some(medium) = scene.media.current(inside) else { continue };
            let number = medium.number;
            if medium.scattering.is_none() && medium.glow.is_none() {
                continue;
            }
            match found.iter_mut().find(|f| f.0 == number) {
                Some(f) => f.1.push(place),
                None => found.push((number, vec![place])),
            }
        }
        // Of several media the one that has the most of it.
        let most = found.into_iter().max_by_key(|f| f.1.len());
        self.numbers.push(most.as_ref().map_or(NONE, |_| self.zones.len() as u32));
        if let Some((medium, places)) = most {
            let volume = f64::from(self.edge).powi(3) * places.len() as f64 / f64::from(TRIED);
            self.zones.push(Zone { medium, places, volume });
        }
    }

    fn tile(&mut self, scene: &Scene, patches: Vec<Patch>, count: u32) {
        let opaque: Vec<Patch> =
            patches.into_iter().filter(|p| !scene.materials[p.surface.material as usize].is_clear()).collect();
        let areas: Vec<f64> = opaque.iter().map(Patch::area).collect();
        let all: f64 = areas.iter().sum();
        for (i, (patch, area)) in opaque.iter().zip(&areas).enumerate() {
            let of = ((area / all * f64::from(count)).sqrt().round() as u32).clamp(1, 64);
            self.first.insert((patch.placement, patch.primitive), (self.tiles.len() as u32, of));
            for front in [true, false] {
                for a in 0..of {
                    for b in 0..of {
                        let area = area / f64::from(of * of);
                        self.tiles.push(Tile { patch: i, front, at: [a, b], of, area });
                    }
                }
            }
        }
        self.patches = opaque;
    }

    /// The zone that a place lies in.
    pub fn zone(&self, place: Vec3A) -> u32 {
        self.cube(((place - self.low) / self.edge).floor())
    }

    fn cube(&self, at: Vec3A) -> u32 {
        let within = (0..3).all(|a| at[a] >= 0.0 && at[a] < self.size[a] as f32);
        let [x, y, z] = at.to_array().map(|i| i as usize);
        if within { self.numbers[(z * self.size[1] + y) * self.size[0] + x] } else { NONE }
    }

    /// Zones around a place with a medium, and their shares, linear between the middles of cubes.
    pub fn around(&self, place: Vec3A, medium: u32) -> impl Iterator<Item = (u32, f32)> {
        let at = (place - self.low) / self.edge - 0.5;
        let (cube, part) = (at.floor(), at - at.floor());
        let mut found = [(NONE, 0.0f32); 8];
        for (i, f) in found.iter_mut().enumerate() {
            let far = Vec3A::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
            let share = (0..3).map(|a| if far[a] > 0.0 { part[a] } else { 1.0 - part[a] }).product();
            let zone = self.cube(cube + far);
            if zone != NONE && self.zones[zone as usize].medium == medium {
                *f = (zone, share);
            }
        }
        let sum: f32 = found.iter().map(|f| f.1).sum();
        found.into_iter().filter(move |f| f.1 > 0.0).map(move |(zone, share)| (zone, share / sum))
    }

    /// Number of the element that a surface was met in.
    pub fn met(&self, hit: &Hit, front: bool) -> Option<u32> {
        let (first, of) = *self.first.get(&(hit.placement, hit.primitive))?;
        let patch = &self.patches[self.tiles[first as usize].patch];
        let [a, b] = patch.square(hit.bary).map(|s| ((s * of as f32) as u32).min(of - 1));
        let side = if front { 0 } else { of * of };
        Some(self.zones.len() as u32 + first + side + a * of + b)
    }

    /// Has each part of a way visited: its zone (or [`NONE`]) and its column in metres.
    pub fn walk(&self, scene: &Scene, inside: Inside, way: &Way, mut visit: impl FnMut(u32, u32, f32)) {
        let Some(medium) = scene.media.current(inside) else { return };
        let number = medium.number;
        let (mut t, mut before) = (0.0f32, 0.0f32);
        let mut part = |zone: u32, to: f32| {
            let column = media::column(scene, medium, &way.up_to(to));
            if column > before {
                visit(zone, number, column - before);
                before = column;
            }
        };
        let start = (way.origin - self.low) / self.edge;
        // A component of 0 would make nothing of 0 / 0.
        let tiny = Vec3A::splat(1e-20);
        let direction = Vec3A::select(way.direction.abs().cmplt(tiny), tiny, way.direction) / self.edge;
        let high = Vec3A::from(self.size.map(|n| n as f32));
        // Up to the box of cubes, from cube to cube, and beyond.
        let (a, b) = (-start / direction, (high - start) / direction);
        let near = a.min(b).max_element().max(0.0);
        let far = a.max(b).min_element().min(way.length);
        if near < far {
            if near > 0.0 {
                part(NONE, near);
            }
            t = near;
            while t < far {
                let place = start + direction * (t + 1e-4);
                let cube = place.floor();
                let walls = cube + Vec3A::select(direction.cmpgt(Vec3A::ZERO), Vec3A::ONE, Vec3A::ZERO);
                let next = ((walls - start) / direction).to_array();
                let next = next.into_iter().filter(|n| *n > t + 1e-5).fold(far, f32::min);
                part(self.cube(cube), next);
                t = next;
            }
        }
        if t < way.length {
            part(NONE, way.length);
        }
    }
}

/// The box of what is filled.
fn filled(scene: &Scene, patches: &[Patch]) -> (Vec3A, Vec3A) {
    let bounds = scene.geometry.bounds();
    if scene.media.everywhere.is_some() {
        return bounds;
    }
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for patch in patches.iter().filter(|p| scene.materials[p.surface.material as usize].interior().is_some()) {
        for i in 0..64u32 {
            let square = [(i % 8) as f32 / 7.0, (i / 8) as f32 / 7.0];
            let (place, _) = patch.place(square);
            (low, high) = (low.min(place), high.max(place));
        }
    }
    if low.x <= high.x { (low.max(bounds.0), high.min(bounds.1)) } else { bounds }
}
