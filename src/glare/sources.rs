//! Finding glare sources: pixels above a threshold, gathered where they are near each other, and within them peaks that
//! glare by themselves [Wienold 2006; evalglare's manual].

use std::collections::BTreeMap;

use crate::glare::{Field, Ray, Sums};

/// How to find them.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Brighter pixels belong to sources, cd/m2.
    pub threshold_cd_m2: f64,
    /// Pixels whose directions lie within half this angle, rad, are of one source.
    pub radius_rad: f64,
    /// Brighter pixels become sources of their own, cd/m2; infinite for none.
    pub peak_cd_m2: f64,
}

/// Shorter links than this are none: a fraction of any pixel.
const SHORTEST_CHORD: f64 = 1e-6;

/// One glare source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Source {
    /// Number of pixels.
    pub pixels: u64,
    /// Solid angle, luminance and illuminance.
    pub sums: Sums,
    /// Brightest pixel, cd/m2.
    pub max_cd_m2: f64,
    /// Veiling luminance it gives, cd/m2.
    pub veiling_cd_m2: f64,
    /// Sum of L w and direction.
    moment: [f64; 3],
}

impl Source {
    fn add(&mut self, ray: &Ray, veiling: &impl Fn(&Ray) -> f64) {
        self.pixels += 1;
        self.sums.add(ray);
        self.max_cd_m2 = self.max_cd_m2.max(ray.luminance);
        self.veiling_cd_m2 += veiling(ray);
        for (sum, x) in self.moment.iter_mut().zip(ray.direction) {
            *sum += ray.luminance * ray.solid_angle_sr * x;
        }
    }

    /// Its centre of light, a unit vector.
    pub fn direction(&self) -> [f64; 3] {
        let n = self.moment.iter().map(|x| x * x).sum::<f64>().sqrt();
        if n > 0.0 { self.moment.map(|x| x / n) } else { [0.0, 0.0, 1.0] }
    }

    /// Angle of its centre from the line of sight, degrees.
    pub fn angle_deg(&self) -> f64 {
        let [x, y, z] = self.direction();
        x.hypot(y).atan2(z).to_degrees()
    }

    /// Position index of its centre.
    pub fn position_index(&self) -> f64 {
        super::position::index(self.direction())
    }
}

/// The glare sources of a field, in the order of their first pixels, peaks after the rest. `veiling` gives the veiling luminance
/// of a pixel.
pub fn find(field: &Field, search: &Search, veiling: impl Fn(&Ray) -> f64) -> Vec<Source> {
    let brighter = |limit: f64| -> Vec<usize> {
        let bright = |i: &usize| f64::from(field.luminance[*i]) > limit;
        (0..field.luminance.len()).filter(bright).filter(|i| field.ray(*i).is_some()).collect()
    };
    let all = brighter(search.threshold_cd_m2);
    let peaks = brighter(search.peak_cd_m2.max(search.threshold_cd_m2));
    let mut sources = Vec::new();
    for (pixels, is_peak) in [(&all, false), (&peaks, true)] {
        let roots = gather(field, pixels, search.radius_rad / 2.0);
        let mut slots = BTreeMap::new();
        for (pixel, root) in pixels.iter().zip(&roots) {
            let Some(ray) = field.ray(*pixel).filter(|r| is_peak || r.luminance <= search.peak_cd_m2) else { continue };
            let slot = *slots.entry(*root).or_insert_with(|| {
                sources.push(Source::default());
                sources.len() - 1
            });
            sources[slot].add(&ray, &veiling);
        }
    }
    sources
}

/// For each pixel (ascending) the place in the list of the first of its group: pixels that touch, sides or corners, and pixels
/// whose directions lie within `angle_rad`, directly or by way of others.
fn gather(field: &Field, pixels: &[usize], angle_rad: f64) -> Vec<usize> {
    let mut sets = Sets((0..pixels.len()).collect());
    let mut edge = Vec::new();
    let mut places = vec![usize::MAX; field.luminance.len()];
    pixels.iter().enumerate().for_each(|(k, pixel)| places[*pixel] = k);
    let place = |index: usize| places.get(index).copied().filter(|k| *k != usize::MAX);
    for (k, pixel) in pixels.iter().enumerate() {
        let (x, last, w) = (pixel % field.width, field.width - 1, field.width);
        let above = |dx: usize| (*pixel + dx).checked_sub(w + 1).and_then(place);
        let left = if x > 0 { pixel.checked_sub(1).and_then(place) } else { None };
        let above = [if x > 0 { above(0) } else { None }, above(1), if x < last { above(2) } else { None }];
        [left, above[0], above[1], above[2]].into_iter().flatten().for_each(|n| sets.join(k, n));
        let right = x < last && place(pixel + 1).is_some();
        if left.is_none() || !right || above[1].is_none() || place(pixel + w).is_none() {
            edge.push(k);
        }
    }
    let chord = 2.0 * (0.5 * angle_rad.min(3.0)).sin();
    if chord > SHORTEST_CHORD {
        link(field, pixels, &edge, chord, &mut sets);
    }
    (0..pixels.len()).map(|k| sets.root(k)).collect()
}

/// Joins edge pixels not further apart than a chord. Space is cut in cubes whose diagonal is the chord: pixels of one belong
/// together, and only those of cubes up to two apart need looking at.
fn link(field: &Field, pixels: &[usize], edge: &[usize], chord: f64, sets: &mut Sets) {
    let side = chord / 3f64.sqrt();
    let mut cubes: BTreeMap<[i32; 3], Vec<(usize, [f64; 3])>> = BTreeMap::new();
    for k in edge {
        let Some(ray) = field.ray(pixels[*k]) else { continue };
        let cube = cubes.entry(ray.direction.map(|x| (x / side).floor() as i32)).or_default();
        if let Some((first, _)) = cube.first() {
            sets.join(*k, *first);
        }
        cube.push((*k, ray.direction));
    }
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() <= chord * chord * (1.0 + 1e-9)
    };
    for ([i, j, l], here) in &cubes {
        // Cubes at this height or after: each pair at least once.
        for (di, dj) in (0..=2).flat_map(|di| (-2..=2).map(move |dj| (di, dj))) {
            for (_, there) in cubes.range([i + di, j + dj, l - 2]..=[i + di, j + dj, l + 2]) {
                let apart = sets.root(here[0].0) != sets.root(there[0].0);
                if apart && here.iter().any(|(_, a)| there.iter().any(|(_, b)| near(a, b))) {
                    sets.join(here[0].0, there[0].0);
                }
            }
        }
    }
}

/// Disjoint sets; the root of each is its first member.
struct Sets(Vec<usize>);

impl Sets {
    fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
