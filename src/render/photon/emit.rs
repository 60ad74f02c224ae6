//! Lamps give off photons: each lamp as often as its share of the luminous flux, each place and direction as often as light comes
//! from there.

use std::f32::consts::{PI, TAU};

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::kernel::disk;
use crate::render::photon::guide::{self, Guide};
use crate::render::sampler::Sampler;
use crate::render::wavelengths::Wavelengths;
use crate::scene::geometry::Patch;
use crate::scene::light::{Emission, Lamp};
use crate::scene::{Scene, ray};

/// All lamps.
pub struct Lamps<'a> {
    scene: &'a Scene,
    sources: Vec<Source>,
    /// What a factor of each light is worth.
    worth: Vec<f64>,
    centre: Vec3A,
    radius: f32,
}

struct Source {
    lamp: usize,
    /// Of a surface.
    patch: Option<Patch>,
    /// Chance to be chosen, and of those before it.
    chance: f64,
    before: f64,
    guide: Option<Guide>,
}

/// A photon that sets out.
pub struct Start {
    /// Where.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
    /// Its light.
    pub light: u32,
    /// Flux as a factor of the light's radiance, in the scene's units; may be negative where a sky's parts are.
    pub flux: f32,
}

/// Pairs of a sampler's numbers that a start takes.
pub const PAIRS: u32 = 3;

impl<'a> Lamps<'a> {
    /// Of a scene.
    pub fn new(scene: &'a Scene, wavelengths: &dyn Wavelengths) -> Lamps<'a> {
        let worth: Vec<f64> = (0..scene.lights.len())
            .map(|i| wavelengths.brightness(i).iter().map(|b| f64::from(*b)).sum::<f64>().max(1e-30))
            .collect();
        let (low, high) = scene.geometry.bounds();
        let (centre, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
        let mut patches: Vec<Option<Patch>> = (0..scene.lamps.len()).map(|_| None).collect();
        for patch in scene.geometry.patches() {
            if let Some(lamp) = patch.surface.emitter {
                patches[lamp as usize] = Some(patch);
            }
        }
        let across = std::f64::consts::PI * f64::from(radius * radius);
        let power = |lamp: &Lamp, patch: &Option<Patch>| -> f64 {
            match lamp {
                Lamp::Area(e) => {
                    let area = patch.as_ref().map_or(0.0, Patch::area);
                    worth[e.light] * e.etendue_sr() * area
                }
                Lamp::Point(p) => worth[p.light as usize] * f64::from(p.factor) * p.distribution.integral_sr(),
                Lamp::Sun(s) => worth[s.light()] * s.solid_angle_sr() * across,
                Lamp::Environment(e) => {
                    let parts = e.surround.integrals_sr();
                    let part = |i: usize| worth[e.light as usize + i] * parts[i].abs();
                    (0..e.surround.parts()).map(part).sum::<f64>() * across
                }
            }
        };
        let powers: Vec<f64> = scene.lamps.iter().zip(&patches).map(|(l, p)| power(l, p)).collect();
        let total: f64 = powers.iter().sum();
        let mut before = 0.0;
        let mut sources = Vec::new();
        for (lamp, (patch, power)) in patches.into_iter().zip(powers).enumerate() {
            if power > 0.0 {
                sources.push(Source { lamp, patch, chance: power / total, before, guide: None });
                before += power / total;
            }
        }
        Lamps { scene, sources, worth, centre, radius }
    }

    /// Learns from photons which of them arrive.
    pub fn learn(&mut self, photons: u32, seed: u32, arrives: impl Fn(Start, &Sampler) -> bool + Sync) {
        for source in 0..self.sources.len() {
            let count = (f64::from(photons) * self.sources[source].chance) as u32;
            let one = |i: u32| -> (usize, bool) {
                let sampler = Sampler::new(source as u32, 0x1f83_d9ab, i, seed);
                let (place, turn) = (sampler.pair(1), sampler.pair(2));
                let start = self.from(&self.sources[source], place, turn, sampler.pair(0)[1]);
                (guide::cell(place, turn), start.is_some_and(|s| arrives(s, &sampler)))
            };
            let all: Vec<(usize, bool)> = (0..count).into_par_iter().map(one).collect();
            let (mut sent, mut arrived) = (vec![0; guide::CELLS], vec![0; guide::CELLS]);
            for (cell, well) in all {
                sent[cell] += 1;
                arrived[cell] += u32::from(well);
            }
            self.sources[source].guide = Guide::new(&sent, &arrived);
        }
    }

    /// A photon; `None` where the lamp sends nothing in the direction that was chosen.
    pub fn start(&self, sampler: &Sampler) -> Option<Start> {
        let ([lot, part], place, turn) = (sampler.pair(0), sampler.pair(1), sampler.pair(2));
        let i = self.sources.partition_point(|s| s.before <= f64::from(lot)).max(1) - 1;
        let source = self.sources.get(i)?;
        let Some(guide) = &source.guide else { return self.from(source, place, turn, part) };
        // What is left of the lot is as good as a new one.
        let lot = (f64::from(lot) - source.before) / source.chance;
        let (place, turn, density) = guide.place(lot, place, turn);
        let start = self.from(source, place, turn, part)?;
        Some(Start { flux: start.flux / density, ..start })
    }

    /// From a lamp, by two numbers for the place and two for the direction.
    fn from(&self, source: &Source, place: [f32; 2], turn: [f32; 2], part: f32) -> Option<Start> {
        let chance = source.chance as f32;
        match (&self.scene.lamps[source.lamp], &source.patch) {
            (Lamp::Area(e), Some(patch)) => {
                let [mut s, mut t] = place;
                if patch.is_triangle() && s + t > 1.0 {
                    (s, t) = (1.0 - s, 1.0 - t);
                }
                let (point, normal) = patch.place([s, t]);
                let flux = PI * patch.area() as f32 / chance;
                let origin = ray::offset(point, normal, patch.reach());
                let direction = ray::cosine_direction(normal, turn);
                Some(self.one(origin, direction, &e.emission(direction.dot(normal)), flux, part))
            }
            (Lamp::Point(p), _) => {
                let z = 1.0 - 2.0 * turn[0];
                let r = (1.0 - z * z).max(0.0).sqrt();
                let (sin, cos) = (TAU * turn[1]).sin_cos();
                let direction = Vec3A::new(r * cos, r * sin, z);
                // At unit distance the intensity is what arrives.
                let aim = p.aim(p.place + direction)?;
                Some(self.one(p.place, direction, &aim.emission, 2.0 * TAU / chance, part))
            }
            (lamp, _) => {
                let aim = lamp.aim(self.centre, turn)?;
                let ([x, y], (s, t)) = (disk(place), ray::frame(aim.direction));
                let origin = self.centre + (aim.direction * 1.01 + s * x + t * y) * self.radius;
                let flux = PI * self.radius * self.radius / (aim.pdf * chance);
                Some(self.one(origin, -aim.direction, &aim.emission, flux, part))
            }
        }
    }

    /// One of an emission's spectra, as likely as it is worth.
    fn one(&self, origin: Vec3A, direction: Vec3A, emission: &Emission, flux: f32, lot: f32) -> Start {
        let count = emission.count as usize;
        let worth = |i: usize| emission.parts[i].abs() as f64 * self.worth[emission.light as usize + i];
        let total: f64 = (0..count).map(worth).sum();
        let (mut chosen, mut left) = (0, f64::from(lot) * total);
        for i in (0..count).filter(|i| worth(*i) > 0.0) {
            chosen = i;
            if left < worth(i) {
                break;
            }
            left -= worth(i);
        }
        let chance = if total > 0.0 { (worth(chosen) / total) as f32 } else { 1.0 };
        let flux = flux * emission.parts[chosen] / chance;
        Start { origin, direction, light: emission.light + chosen as u32, flux }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::wavelengths::Carried;
    use crate::scene::load;
    use crate::spectral::Sampling;

    /// Photons through a small sphere tell what the lamps' closed forms say of the flux through it.
    #[test]
    fn lamps_give_off_what_they_should() {
        let black = "[materials.m]\nreflectance = 0\n";
        let ball = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n";
        let light = "[lights.l]\nspectrum = \"E\"\nluminance = 1\n";
        let quad = "[[shape]]\ntype = \"quad\"\npoints = [[-1,-1,4],[-1,1,4],[1,1,4],[1,-1,4]]\nmaterial = \"m\"\nlight = \"l\"\n";
        let disk = "[[shape]]\ntype = \"disk\"\ncenter = [0,0,4]\nnormal = [0,0,-1]\nradius = 1\nmaterial = \"m\"\nlight = \"l\"\n";
        // Flux onto the ball by radiance 1: over all directions pi r^2 x 4 pi; by reciprocity pi x (area of the lamp seen from
        // the ball by its own form factor), taken by quadrature of the solid angle of the ball from the lamp.
        let onto = |corner: bool| {
            let n = 400;
            let mut sum = 0.0;
            for i in 0..n {
                for j in 0..n {
                    let (x, y) = ((f64::from(i) + 0.5) / 200.0 - 1.0, (f64::from(j) + 0.5) / 200.0 - 1.0);
                    if corner || x * x + y * y < 1.0 {
                        let d2 = x * x + y * y + 16.0;
                        // A sphere seen under the angle a from its own plane's normal fills pi sin^2(s) cos(a) of the cosine.
                        sum += std::f64::consts::PI / d2 * (4.0 / d2.sqrt()) * 4.0 / f64::from(n * n);
                    }
                }
            }
            sum
        };
        let cases = [
            (
                format!("[environment]\nspectrum = \"E\"\nluminance = 1\n{black}{ball}"),
                4.0 * std::f64::consts::PI.powi(2),
            ),
            (format!("{light}{black}{ball}{quad}"), onto(true)),
            (format!("{light}{black}{ball}{disk}"), onto(false)),
        ];
        for (text, want) in cases {
            let scene = load::parse(&text, std::path::Path::new(".")).unwrap();
            let sampling = Sampling::bins(380.0, 780.0, 8).unwrap();
            let carried = Carried::<1>::new(&scene, (&scene.inks, &scene.srgb), &sampling, (380.0, 780.0)).unwrap();
            let lamps = Lamps::new(&scene, &carried);
            // 4 % of them meet the ball: 80,000, a third of a per cent.
            let n = 1 << 21;
            let mut flux = 0.0;
            for i in 0..n {
                let Some(start) = lamps.start(&Sampler::new(0, 0, i, 7)) else { continue };
                let hit = scene.geometry.closest(start.origin, start.direction);
                if hit.is_some_and(|h| h.surface.emitter.is_none()) {
                    flux += f64::from(start.flux) / f64::from(n);
                }
            }
            let flux_m2 = flux / scene.frame.scale.powi(2);
            assert!((flux_m2 / want - 1.0).abs() < 0.01, "{flux_m2} for {want}: {text}");
        }
    }
}
