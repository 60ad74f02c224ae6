//! Which places of elements take part in the exchange of light: not those that something lies on, and not those that are walled
//! off from all light, as the floor within a box that stands on it. What the rest of such an element shows would be the darker
//! for them.

use std::collections::HashMap;

use glam::Vec3A;
use rayon::prelude::*;

use crate::render::radiosity::mesh::{Element, Mesh};
use crate::render::sampler::Sampler;
use crate::scene::{Geometry, ray};

/// Places on an element at which it is seen what stands on it; as many rays tell what an element sees at all.
pub const FEELERS: u32 = 16;
/// Share of an element's length above it that counts as lying on it.
const NEXT_TO_NOTHING: f32 = 0.02;

/// A place on an element that nothing lies on.
#[derive(Clone, Copy, Debug)]
pub struct Feeler {
    /// The place, just off the surface.
    pub start: Vec3A,
    /// The normal there.
    pub normal: Vec3A,
    /// A little higher.
    above: Vec3A,
    /// Places of a group see each other, one from another, just above the element.
    group: u32,
}

/// Feeler number `i` of an element, whether or not something lies on it.
fn feeler(element: &Element, number: u32, i: u32) -> Feeler {
    let (point, normal) = element.place(Sampler::new(number, 0x0165_667b, i, 0).pair(0));
    let start = ray::offset(point, normal, element.tile.patch.reach());
    Feeler { start, normal, above: start + NEXT_TO_NOTHING * element.size() * normal, group: 0 }
}

/// Feelers of an element, their groups numbered from 0, and how many groups there are.
struct Feelers {
    places: Vec<Feeler>,
    groups: u32,
}

impl Feelers {
    fn of(geometry: &Geometry, element: &Element, number: u32) -> Feelers {
        let open = |p: &Feeler| geometry.visible(p.start, p.above);
        let mut places: Vec<Feeler> = (0..FEELERS).map(|i| feeler(element, number, i)).filter(open).collect();
        // What is round bends away from under a straight line; nothing stands on it squarely.
        if element.tile.patch.is_round() {
            return Feelers { groups: u32::from(!places.is_empty()), places };
        }
        places.iter_mut().for_each(|p| p.group = u32::MAX);
        let mut groups = 0;
        while let Some(first) = places.iter().position(|p| p.group == u32::MAX) {
            places[first].group = groups;
            // From one to the next until no more is seen: mostly all are from the first.
            let mut edge = vec![first];
            while let Some(from) = edge.pop() {
                for to in 0..places.len() {
                    if places[to].group == u32::MAX && geometry.visible(places[from].above, places[to].above) {
                        places[to].group = groups;
                        edge.push(to);
                    }
                }
            }
            groups += 1;
        }
        Feelers { places, groups }
    }

    fn are_plain(&self) -> bool {
        self.groups == 1 && self.places.len() == FEELERS as usize
    }
}

/// Feelers of all elements, kept for those where they are not all of one group.
struct Felt<'a> {
    geometry: &'a Geometry,
    mesh: &'a Mesh,
    odd: HashMap<u32, Feelers>,
    /// The first group of each element, and the number of all.
    first: Vec<u32>,
}

impl<'a> Felt<'a> {
    fn new(geometry: &'a Geometry, mesh: &'a Mesh) -> Felt<'a> {
        let odd: HashMap<u32, Feelers> = (0..mesh.len() as u32)
            .into_par_iter()
            .map(|n| (n, Feelers::of(geometry, &mesh.element(n).1, n)))
            .filter(|(_, feelers)| !feelers.are_plain())
            .collect();
        let mut first = vec![0u32];
        let groups = |n: u32| odd.get(&n).map_or(1, |f| f.groups);
        first.extend((0..mesh.len() as u32).scan(0, |sum, n| {
            *sum += groups(n);
            Some(*sum)
        }));
        Felt { geometry, mesh, odd, first }
    }

    /// Groups of an element.
    fn groups(&self, number: u32) -> std::ops::Range<u32> {
        self.first[number as usize]..self.first[number as usize + 1]
    }

    /// Places of one of its groups.
    fn places(&self, number: u32, group: u32) -> Vec<Feeler> {
        let own = group - self.first[number as usize];
        match self.odd.get(&number) {
            Some(f) => f.places.iter().copied().filter(|p| p.group == own).collect(),
            None => (0..FEELERS).map(|i| feeler(&self.mesh.element(number).1, number, i)).collect(),
        }
    }

    /// The group that a place just off an element belongs to, where any feeler sees it.
    fn group(&self, number: u32, place: Vec3A) -> Option<u32> {
        let (_, element) = self.mesh.element(number);
        let sees = |p: &Feeler| element.tile.patch.is_round() || self.geometry.visible(place, p.above);
        let own = match self.odd.get(&number) {
            Some(f) => f.places.iter().find(|p| sees(p)).map(|p| p.group),
            None => (0..FEELERS).find(|i| sees(&feeler(&element, number, *i))).map(|_| 0),
        };
        own.map(|g| self.first[number as usize] + g)
    }
}

/// Elements that are not wholly open.
#[derive(Default)]
pub struct Cover {
    some: HashMap<u32, Partly>,
}

struct Partly {
    /// Places that are open, a little above the element.
    open: Vec<Vec3A>,
    /// Something stands on it that parts open places from others.
    walled: bool,
}

/// Where light gets in a mesh.
pub struct Reached {
    /// Whether it reaches sides, two for each surface, front first.
    pub sides: Vec<bool>,
    /// Whether lights shine on anything.
    pub lights: Vec<bool>,
    /// Elements of which light does not reach all.
    pub cover: Cover,
}

/// A group of places, which light reaches or not.
struct Group {
    /// Lights that shine on it.
    lights: Vec<bool>,
    /// Groups that it sees, where no light shines on it.
    seen: Vec<u32>,
    /// It sees out of the scene.
    out: bool,
}

/// Finds where light gets. `lamps` says which lights shine on places of an element; it is asked for `looks` of them at a time,
/// until one does.
pub fn reached(
    geometry: &Geometry,
    mesh: &Mesh,
    (seed, looks): (u32, usize),
    lamps: impl Fn(u32, &[Feeler]) -> Vec<bool> + Sync,
) -> Reached {
    let felt = Felt::new(geometry, mesh);
    let group = |number: u32, group: u32| -> Group {
        let own = felt.places(number, group);
        let mut found = Group { lights: Vec::new(), seen: Vec::new(), out: false };
        for some in own.chunks(looks) {
            found.lights = lamps(number, some);
            if found.lights.contains(&true) {
                return found;
            }
        }
        for (i, place) in (0..FEELERS).zip(own.iter().cycle()) {
            let direction = ray::cosine_direction(place.normal, Sampler::new(number, 0x51ed_270b, i, seed).pair(1));
            let Some(hit) = geometry.closest(place.start, direction) else {
                found.out = true;
                continue;
            };
            let front = hit.normal.dot(direction) < 0.0;
            let Some(other) = mesh.met(&hit, front) else { continue };
            let lifted = ray::offset(hit.point, if front { hit.normal } else { -hit.normal }, hit.reach);
            found.seen.extend(felt.group(other, lifted));
        }
        found.seen.sort_unstable();
        found.seen.dedup();
        found
    };
    let groups: Vec<Group> = (0..mesh.len() as u32)
        .into_par_iter()
        .flat_map_iter(|n| felt.groups(n).map(move |g| (n, g)))
        .map(|(n, g)| group(n, g))
        .collect();
    let lit = flood(&groups);
    let mut reached =
        Reached { sides: vec![false; 2 * mesh.tiles().len()], lights: Vec::new(), cover: Cover::default() };
    for group in &groups {
        reached.lights.resize(group.lights.len().max(reached.lights.len()), false);
        reached.lights.iter_mut().zip(&group.lights).for_each(|(all, lit)| *all |= lit);
    }
    for number in 0..mesh.len() as u32 {
        let own = felt.groups(number);
        let (tile, element) = mesh.element(number);
        let is_open = |g: u32| lit[g as usize] || groups[g as usize].out;
        reached.sides[2 * tile + usize::from(!element.front)] |= own.clone().any(|g| lit[g as usize]);
        let walled = own.clone().any(|g| !is_open(g));
        if walled || felt.odd.get(&number).is_some_and(|f| f.places.len() < FEELERS as usize) {
            let places = own.filter(|g| is_open(*g)).flat_map(|g| felt.places(number, g));
            reached.cover.some.insert(number, Partly { open: places.map(|p| p.above).collect(), walled });
        }
    }
    reached
}

/// Groups that light reaches: on which lamps shine, and which see others that it reaches.
fn flood(groups: &[Group]) -> Vec<bool> {
    let mut lit: Vec<bool> = groups.iter().map(|g| g.lights.contains(&true)).collect();
    loop {
        let mut more = false;
        for (i, group) in groups.iter().enumerate() {
            if !lit[i] && group.seen.iter().any(|s| lit[*s as usize]) {
                (lit[i], more) = (true, true);
            }
        }
        if !more {
            return lit;
        }
    }
}

impl Cover {
    /// Something stands on an element that parts its places.
    pub fn is_walled(&self, number: u32) -> bool {
        self.some.get(&number).is_some_and(|p| p.walled && !p.open.is_empty())
    }

    /// Nothing of an element is open, as far as a few places tell.
    pub fn is_whole(&self, number: u32) -> bool {
        self.some.get(&number).is_some_and(|p| p.open.is_empty())
    }
}

/// Elements in a scene, as far as they are open.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// What surfaces there are.
    pub geometry: &'a Geometry,
    /// Their elements.
    pub mesh: &'a Mesh,
    /// What of them is not open.
    pub cover: &'a Cover,
}

impl<'a> Ground<'a> {
    /// Says of places just off an element, with the normal of its side, whether they are open.
    pub fn opening(self, number: u32) -> impl Fn(Vec3A, Vec3A) -> bool + 'a {
        let partly = self.cover.some.get(&number).map(|p| (p, NEXT_TO_NOTHING * self.mesh.element(number).1.size()));
        move |place, normal| {
            let Some((Partly { open, walled }, up)) = partly else { return true };
            let above = place + up * normal;
            let visible = |to| self.geometry.visible(above, to);
            self.geometry.visible(place, above) && (!walled || open.iter().any(|o| visible(*o)))
        }
    }
}
