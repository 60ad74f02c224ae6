//! Photons in a balanced tree of places [Bentley 1975]: the middle one of a run of photons is its node, what lies below it in one
//! coordinate comes before it, what lies above after it. Runs of a few are not divided.

use glam::Vec3A;

use crate::medium::density::Way;

/// Photons that are not divided.
const FEW: usize = 12;

/// Light that arrived on a surface, or scattered in a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where.
    pub place: [f32; 3],
    /// Unit normal of the side on which it arrived; the direction from which it came to where it scattered.
    pub normal: [f32; 3],
    /// Flux, as a factor of its row.
    pub flux: f32,
    /// Row of what became of its light's spectrum.
    pub row: u32,
    /// Coordinate in which it divides the photons around it.
    axis: u32,
}

impl Photon {
    /// Not yet in a tree.
    pub fn new(place: Vec3A, normal: Vec3A, flux: f32, row: u32) -> Photon {
        Photon { place: place.to_array(), normal: normal.to_array(), flux, row, axis: 0 }
    }

    /// Its five numbers and its row as words, with the axis.
    pub fn words(&self) -> [u32; 9] {
        let [x, y, z] = self.place.map(f32::to_bits);
        let [a, b, c] = self.normal.map(f32::to_bits);
        [x, y, z, a, b, c, self.flux.to_bits(), self.row, self.axis]
    }

    /// And back.
    pub fn from_words([x, y, z, a, b, c, flux, row, axis]: [u32; 9]) -> Photon {
        let [place, normal] = [[x, y, z], [a, b, c]].map(|v| v.map(f32::from_bits));
        Photon { place, normal, flux: f32::from_bits(flux), row, axis: axis % 3 }
    }
}

/// Puts photons into the order of a tree.
pub fn build(photons: &mut [Photon]) {
    if photons.len() <= FEW {
        return;
    }
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for p in photons.iter() {
        let at = Vec3A::from_array(p.place);
        (low, high) = (low.min(at), high.max(at));
    }
    let size = high - low;
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let middle = photons.len() / 2;
    let (below, node, above) = photons.select_nth_unstable_by(middle, |a, b| a.place[axis].total_cmp(&b.place[axis]));
    node.axis = axis as u32;
    if below.len() > 4096 {
        rayon::join(|| build(below), || build(above));
    } else {
        build(below);
        build(above);
    }
}

/// Calls `f` with all photons closer than the root of what it returns last, and their squared distance; begins with `squared`.
pub fn within(photons: &[Photon], at: Vec3A, squared: &mut f32, f: &mut impl FnMut(&Photon, f32) -> f32) {
    if photons.len() <= FEW {
        for photon in photons {
            let away = (Vec3A::from_array(photon.place) - at).length_squared();
            if away < *squared {
                *squared = f(photon, away);
            }
        }
        return;
    }
    let middle = photons.len() / 2;
    let node = &photons[middle];
    let axis = node.axis as usize;
    let off = at[axis] - node.place[axis];
    let (near, far) = if off < 0.0 {
        (&photons[..middle], &photons[middle + 1..])
    } else {
        (&photons[middle + 1..], &photons[..middle])
    };
    within(near, at, squared, f);
    let away = (Vec3A::from_array(node.place) - at).length_squared();
    if away < *squared {
        *squared = f(node, away);
    }
    if off * off < *squared {
        within(far, at, squared, f);
    }
}

/// Calls `f` with all photons within a radius of a way, how far along it each lies, and its squared distance from it.
pub fn along(
    photons: &[Photon],
    way: &Way,
    (from, to): (f32, f32),
    radius: f32,
    f: &mut impl FnMut(&Photon, f32, f32),
) {
    if from > to {
        return;
    }
    let mut meet = |photon: &Photon| {
        let off = Vec3A::from_array(photon.place) - way.origin;
        let t = off.dot(way.direction);
        let away = off.length_squared() - t * t;
        if away < radius * radius && t >= 0.0 && t <= way.length {
            f(photon, t, away);
        }
    };
    if photons.len() <= FEW {
        return photons.iter().for_each(meet);
    }
    let middle = photons.len() / 2;
    let node = &photons[middle];
    meet(node);
    let axis = node.axis as usize;
    let (start, speed) = (way.origin[axis] - node.place[axis], way.direction[axis]);
    // Where the way is below the node by more than the radius no photon above it is near, and the other way round.
    let cut = |sign: f32| {
        let (start, speed) = (start * sign - radius, speed * sign);
        match speed {
            0.0 if start > 0.0 => (f32::INFINITY, f32::NEG_INFINITY),
            0.0 => (from, to),
            s if s > 0.0 => (from, to.min(-start / s)),
            s => (from.max(-start / s), to),
        }
    };
    along(&photons[..middle], way, cut(1.0), radius, f);
    along(&photons[middle + 1..], way, cut(-1.0), radius, f);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sampler::Sampler;

    /// The same photons as a search through all of them finds.
    #[test]
    fn finds_what_is_near() {
        let mut photons: Vec<Photon> = (0..1000)
            .map(|i| {
                let s = Sampler::new(i, 0, 0, 1);
                let [[x, y], [z, _]] = [s.pair(0), s.pair(1)];
                Photon::new(Vec3A::new(x, y, if i % 3 == 0 { 0.5 } else { z }), Vec3A::Z, 1.0, i)
            })
            .collect();
        build(&mut photons);
        for i in 0..50 {
            let s = Sampler::new(i, 1, 0, 1);
            let at = Vec3A::new(s.pair(0)[0], s.pair(0)[1], s.pair(1)[0]);
            let mut found = Vec::new();
            within(&photons, at, &mut 0.04, &mut |p, _| {
                found.push(p.row);
                0.04
            });
            let near = |p: &&Photon| (Vec3A::from_array(p.place) - at).length_squared() < 0.04;
            let mut want: Vec<u32> = photons.iter().filter(near).map(|p| p.row).collect();
            found.sort_unstable();
            want.sort_unstable();
            assert_eq!(found, want);
        }
        for i in 0..50 {
            let s = Sampler::new(i, 2, 0, 1);
            let origin = Vec3A::new(s.pair(0)[0], s.pair(0)[1], s.pair(1)[0]) * 3.0 - 1.0;
            let direction = if i % 5 == 0 { Vec3A::X } else { (Vec3A::splat(0.5) - origin).normalize() };
            let way = Way { origin, direction, length: if i % 2 == 0 { f32::INFINITY } else { 0.7 } };
            let mut found = Vec::new();
            along(&photons, &way, (0.0, way.length), 0.1, &mut |p, _, _| found.push(p.row));
            let near = |p: &&Photon| {
                let off = Vec3A::from_array(p.place) - origin;
                let t = off.dot(direction);
                t >= 0.0 && t <= way.length && off.length_squared() - t * t < 0.1 * 0.1
            };
            let mut want: Vec<u32> = photons.iter().filter(near).map(|p| p.row).collect();
            found.sort_unstable();
            want.sort_unstable();
            assert_eq!(found, want);
        }
    }
}
