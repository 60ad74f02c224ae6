//! Path tracing with next event estimation and multiple importance sampling [Veach 1997].

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3A;

use crate::render::film::Film;
use crate::render::lanes::Throughput;
use crate::render::sampler::Sampler;
use crate::scene::{Hit, Scene, ray};

/// From this bounce on a path may end by lot.
const ROULETTE_FROM: u32 = 4;
/// The lot never lets a path go on with more than this probability: a closed white room ends too.
const LONGEST_ODDS: f32 = 0.98;

/// Traces paths through a scene. Cheap to make.
pub struct Tracer<'a, T: Throughput, F> {
    /// What is there.
    pub scene: &'a Scene,
    /// What each material does to a path.
    pub events: &'a [T::Event],
    /// What light makes of a path.
    pub film: &'a F,
    /// Running sums of the probabilities with which emitters are chosen, from [`running_chances`].
    pub chances: &'a [f32],
    /// Most bounces.
    pub max_bounces: u32,
}

/// Running sums of `power` over its total.
pub fn running_chances(power: &[f64]) -> Vec<f32> {
    let total: f64 = power.iter().sum();
    let mut sum = 0.0;
    let running = |p: &f64| {
        sum += p / total;
        sum as f32
    };
    power.iter().map(running).collect()
}

impl<T: Throughput, F: Film<T>> Tracer<'_, T, F> {
    /// Probability of choosing an emitter.
    fn chance(&self, emitter: usize) -> f32 {
        self.chances[emitter] - if emitter > 0 { self.chances[emitter - 1] } else { 0.0 }
    }

    /// Chooses an emitter with a number in 0..1, which comes back stretched to 0..1 for use on its area.
    fn choose(&self, u: &mut f32) -> usize {
        let last = self.chances.len() - 1;
        let i = self.chances.partition_point(|c| *c <= *u).min(last);
        let before = if i > 0 { self.chances[i - 1] } else { 0.0 };
        *u = ((*u - before) / (self.chances[i] - before)).clamp(0.0, 0.999_999_94);
        i
    }

    /// Follows one path from the eye and adds what it finds to `pixel`.
    pub fn trace(&self, mut origin: Vec3A, mut direction: Vec3A, sampler: &mut Sampler, pixel: &mut F::Pixel) {
        let mut path = T::identity();
        // Density of the last direction, 1/sr, and where it was chosen; none from the eye, which aims at no light.
        let mut aimed: Option<(f32, Vec3A)> = None;
        for bounce in 0.. {
            let Some(hit) = self.scene.geometry.closest(origin, direction) else { return };
            let front = hit.normal.dot(direction) < 0.0;
            if let Some(emitter) = hit.surface.emitter.filter(|_| front) {
                self.meet(emitter as usize, &hit, aimed, &path, pixel);
            }
            let material = hit.surface.material as usize;
            if bounce >= self.max_bounces || !(front || self.scene.materials[material].two_sided) {
                return;
            }
            let normal = if front { hit.normal } else { -hit.normal };
            origin = ray::offset(hit.point, normal);
            path.then(&self.events[material]);
            self.look_at_light(origin, normal, &path, sampler, pixel);
            let largest = path.largest();
            if bounce >= ROULETTE_FROM || largest == 0.0 {
                let odds = largest.min(LONGEST_ODDS);
                if sampler.next2()[0] >= odds {
                    return;
                }
                path.scale(1.0 / odds);
            }
            direction = ray::cosine_direction(normal, sampler.next2());
            aimed = Some((direction.dot(normal).max(1e-7) * FRAC_1_PI, origin));
        }
    }

    /// A path ran into light: weighed against the chance of having aimed at it.
    fn meet(&self, emitter: usize, hit: &Hit, aimed: Option<(f32, Vec3A)>, path: &T, pixel: &mut F::Pixel) {
        let e = &self.scene.emitters[emitter];
        let weight = match aimed {
            None => 1.0,
            Some((pdf, from)) => power_heuristic(pdf, e.pdf(from, hit.point, hit.normal) * self.chance(emitter)),
        };
        self.film.connect(pixel, e.light, weight, path);
    }

    /// Next event estimation: one place on one emitter, weighed against the chance of running into it.
    fn look_at_light(&self, from: Vec3A, normal: Vec3A, path: &T, sampler: &mut Sampler, pixel: &mut F::Pixel) {
        if self.chances.is_empty() {
            return;
        }
        let mut u = sampler.next2();
        let chosen = self.choose(&mut u[0]);
        let emitter = &self.scene.emitters[chosen];
        let Some(aim) = emitter.aim(from, u) else { return };
        let cos = normal.dot(aim.direction);
        if cos <= 0.0 || !self.scene.geometry.visible(from, ray::offset(aim.point, aim.normal)) {
            return;
        }
        let pdf = aim.pdf * self.chance(chosen);
        let weight = cos / (PI * pdf) * power_heuristic(pdf, cos * FRAC_1_PI);
        self.film.connect(pixel, emitter.light, weight, path);
    }
}

/// Weight of the first of two ways to find the same light, densities a and b [Veach 1997].
fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}
