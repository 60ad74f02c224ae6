//! The balance of light between a scene's surfaces, and the one radiance that stands for all that they send each other.
//!
//! If every surface were lit from everywhere by the same ambient radiance `La`, surfaces would send on in the mean
//! `La = Lr + rho c La`: what they reflect of the lamps at once, and the share `rho` of what comes from surfaces, which is the
//! share `c` of all directions. So `La = Lr / (1 - rho c)`, a wavelength each; exact for a closed sphere.
//!
//! The means are over area and cosine, as a gas of particles that every surface scatters as white matt ones do would find
//! them: it fills a closed space evenly by area (Knudsen 1909), and of an open one it reaches what light can reach. It starts
//! where the camera looks; without a camera, at the lamps.

use glam::Vec3A;
use rayon::prelude::*;

use crate::Result;
use crate::material::kernel;
use crate::medium::Inside;
use crate::render::film::light_weights;
use crate::render::inks::Inks;
use crate::render::lanes::GROUP;
use crate::render::meeting::Meeting;
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, LampsAlone, Pairs, Shade};
use crate::render::stored::Stored;
use crate::render::trail::{Arrived, Trail};
use crate::scene::light::{Emission, Lamp};
use crate::scene::{Hit, Scene, ray};
use crate::simd;
use crate::spectral::{Observer, Sampling, Spectrum};
use crate::units::K_M;

/// Wavelengths of the balance: 8 lanes each.
const GROUPS: usize = 10;
/// Particles, and surfaces that each of them meets.
const PARTICLES: u32 = 256;
const MEETINGS: u32 = 64;
/// A particle that gets this far has forgotten where it came from; the first half of so many meetings is left out.
const FORGOTTEN: usize = 8;
/// Least share of light that ends at a meeting: where none ends there is no balance.
const LEAST_LOSS: f64 = 1e-3;

/// What a scene's surfaces send each other.
#[derive(Clone, Debug)]
pub struct Balance {
    /// `La` by lights: the light's number, and factors of its radiance.
    pub ambient: Vec<(u32, Spectrum)>,
    /// Luminance of `La`, cd/m2, and its standard error.
    pub luminance_cd_m2: [f64; 2],
    /// Share of the light on surfaces that comes from other surfaces, by luminance: `rho c`.
    pub interreflected: f64,
    /// Share of directions in which surfaces see others.
    pub closed: f64,
}

/// Sums of one particle's meetings.
#[derive(Clone)]
struct Sums {
    /// Reflected of each light, as factors of it.
    direct: Vec<[f64; GROUP * GROUPS]>,
    /// Reflected of light that comes from everywhere.
    white: [f64; GROUP * GROUPS],
    meetings: f64,
    /// Directions from surfaces in which there was another, and all of them.
    returns: f64,
    departures: f64,
}

impl Sums {
    fn new(lights: usize) -> Sums {
        Sums {
            direct: vec![[0.0; GROUP * GROUPS]; lights],
            white: [0.0; GROUP * GROUPS],
            meetings: 0.0,
            returns: 0.0,
            departures: 0.0,
        }
    }

    fn add(&mut self, other: &Sums) {
        let rows = self.direct.iter_mut().zip(&other.direct).chain([(&mut self.white, &other.white)]);
        rows.for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += b));
        self.meetings += other.meetings;
        self.returns += other.returns;
        self.departures += other.departures;
    }

    fn closed(&self) -> f64 {
        self.returns / self.departures.max(1.0)
    }
}

impl Balance {
    /// Of a scene, over wavelengths in nm.
    pub fn of(scene: &Scene, range_nm: (f64, f64)) -> Result<Balance> {
        let sampling = Sampling::bins(range_nm.0, range_nm.1, GROUP * GROUPS)?;
        let inks = Inks::<GROUPS>::new(&scene.inks, &scene.srgb, &sampling);
        let observer = Observer::cie1931()?;
        let y = observer.cmf[1].scaled(K_M);
        let weights: Vec<Vec<f64>> =
            scene.lights.iter().map(|l| light_weights(&l.radiance, &sampling, range_nm, &y)).collect();
        let gas = Gas { scene, inks };
        let parts: Vec<Sums> = (0..PARTICLES).into_par_iter().map(|i| gas.particle(i)).collect();
        let mut all = Sums::new(scene.lights.len());
        parts.iter().for_each(|p| all.add(p));
        let (n, closed) = (all.meetings.max(1.0), all.closed());
        let loss: Vec<f64> = all.white.iter().map(|w| (1.0 - w / n * closed).max(LEAST_LOSS)).collect();
        let ambient = |i: usize| -> Vec<f64> { all.direct[i].iter().zip(&loss).map(|(d, l)| d / n / l).collect() };
        let luminance = |direct: &[[f64; GROUP * GROUPS]], n: f64| -> f64 {
            let of = |(d, w): (&[f64; GROUP * GROUPS], &Vec<f64>)| -> f64 {
                d.iter().zip(w).zip(&loss).map(|((d, w), l)| d * w / l).sum()
            };
            direct.iter().zip(&weights).map(of).sum::<f64>() / n
        };
        let mean = luminance(&all.direct, n);
        let k = parts.len() as f64;
        // Particles weigh by their meetings: the ratio's own variance.
        let deviation = |p: &Sums| (luminance(&p.direct, 1.0) - mean * p.meetings).powi(2);
        let error = (parts.iter().map(deviation).sum::<f64>() * k / (k - 1.0)).sqrt() / n;
        // By what the lamps give: light that is reflected twice over light that is reflected once.
        let twice: Vec<[f64; GROUP * GROUPS]> =
            all.direct.iter().map(|d| std::array::from_fn(|i| d[i] * (1.0 - loss[i]))).collect();
        Ok(Balance {
            ambient: (0..scene.lights.len())
                .filter(|i| all.direct[*i].iter().any(|d| *d > 0.0))
                .map(|i| Ok((i as u32, spectrum(&sampling, &ambient(i))?)))
                .collect::<Result<_>>()?,
            luminance_cd_m2: [mean, error],
            interreflected: if mean > 0.0 { luminance(&twice, n) / mean } else { 0.0 },
            closed,
        })
    }
}

/// Through the middles of bins, level beyond the outermost.
fn spectrum(sampling: &Sampling, values: &[f64]) -> Result<Spectrum> {
    let mut points: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, v)| (sampling.centre_nm(i), *v)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Spectrum::from_points(points)?.extended())
}

struct Gas<'a> {
    scene: &'a Scene,
    inks: Inks<GROUPS>,
}

impl Gas<'_> {
    /// The meetings of one particle.
    fn particle(&self, number: u32) -> Sums {
        let mut sums = Sums::new(self.scene.lights.len());
        let (mut left, mut walks) = (MEETINGS, 0);
        while left > 0 && walks < MEETINGS {
            let (met, left_the_scene) = self.walk(number, walks, left);
            sums.returns += met.len().saturating_sub(1) as f64;
            sums.departures += met.len().saturating_sub(usize::from(!left_the_scene)) as f64;
            walks += 1;
            left -= met.len() as u32;
            let skipped = if met.len() >= FORGOTTEN { FORGOTTEN / 2 } else { 0 };
            for (i, (hit, direction)) in met.iter().enumerate().skip(skipped) {
                self.measure(hit, *direction, &Sampler::new(number, walks, i as u32, 2), &mut sums);
            }
        }
        sums
    }

    /// What a particle meets until it leaves the scene, if it does.
    fn walk(&self, number: u32, walk: u32, most: u32) -> (Vec<(Hit, Vec3A)>, bool) {
        let sampler = Sampler::new(number, walk, 0, 1);
        let mut met = Vec::new();
        let Some((mut origin, mut direction)) = self.start(number, &sampler) else { return (met, true) };
        for i in 0..most {
            let Some(hit) = self.scene.geometry.closest(origin, direction) else { return (met, true) };
            met.push((hit, direction));
            let side = if hit.normal.dot(direction) < 0.0 { hit.normal } else { -hit.normal };
            origin = ray::offset(hit.point, side, hit.reach);
            direction = ray::cosine_direction(side, sampler.pair(8 + i));
        }
        (met, false)
    }

    /// Where the camera looks, or from a lamp.
    fn start(&self, number: u32, sampler: &Sampler) -> Option<(Vec3A, Vec3A)> {
        if let Some(camera) = &self.scene.camera {
            let [x, y] = sampler.pair(0);
            let (width, height) = (camera.width as f64, camera.height as f64);
            return camera.ray(f64::from(x) * width, f64::from(y) * height, sampler.pair(1));
        }
        let lamps = &self.scene.lamps;
        // Media alone may give off light.
        let lamp = lamps.get(number as usize % lamps.len().max(1))?;
        if lamp.is_distant() {
            let to = lamp.aim(Vec3A::ZERO, sampler.pair(0))?.direction;
            let ([x, y], (s, t)) = (kernel::disk(sampler.pair(1)), ray::frame(to));
            // The scene is about a unit sphere.
            return Some((to * 2.0 + s * x + t * y, -to));
        }
        // Seen from somewhere around, which a lamp that shines one way may turn its back to.
        (0..6).find_map(|i| {
            let [a, z] = sampler.pair(i);
            let (sin, cos) = (a * std::f32::consts::TAU).sin_cos();
            let (z, r) = (2.0 * z - 1.0, 2.0 * (z - z * z).max(0.0).sqrt());
            let aim = lamp.aim(Vec3A::new(r * cos, r * sin, z) * 2.0, sampler.pair(7))?;
            matches!(lamp, Lamp::Area(_) | Lamp::Point(_)).then_some((aim.point?, -aim.direction))
        })
    }

    /// What a surface sends towards where a particle came from.
    fn measure(&self, hit: &Hit, direction: Vec3A, sampler: &Sampler, sums: &mut Sums) {
        let (at, lobes) = Meeting::with_lobes(self.scene, hit, direction);
        let shade = Shade {
            scene: self.scene,
            rest: &LampsAlone,
            shadows: true,
            follow: Follow::Gloss,
            inside: Inside::default(),
        };
        let mut pairs = Pairs::new(sampler, 0);
        let (mut direct, mut white) = (Trail::default(), Trail::default());
        direct.fork();
        white.fork();
        for lobe in lobes.iter() {
            direct.branch();
            shade.lobe(&at, lobe, &mut pairs, &mut direct);
            if let Some(turn) = lobe.kernel.sample(at.out, pairs.pair()) {
                white.branch();
                white.tint(&lobe.tint.turned(at.out, turn.inc));
                white.light(&Emission::one(0, 1.0), lobe.factor * turn.weight, 0);
            }
        }
        sums.meetings += 1.0;
        let (mut arrived, nothing) = (Arrived::<GROUPS>::default(), Stored::default());
        simd::wide(
            #[inline(always)]
            || {
                for (light, lanes) in arrived.follow(&direct, &self.inks, &nothing) {
                    let sum = &mut sums.direct[*light as usize];
                    for (sum, x) in sum.iter_mut().zip(lanes.0.as_flattened()) {
                        *sum += f64::from(*x);
                    }
                }
                for (_, lanes) in arrived.follow(&white, &self.inks, &nothing) {
                    for (sum, x) in sums.white.iter_mut().zip(lanes.0.as_flattened()) {
                        *sum += f64::from(*x);
                    }
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    fn balance(text: &str) -> Balance {
        let scene = load::parse(text, std::path::Path::new(".")).unwrap();
        Balance::of(&scene, (380.0, 780.0)).unwrap()
    }

    /// What a light on the ceiling of a room of 4 x 4 x 3 m (tests/ref: room C) sends on at once is known by surfaces; the
    /// balance follows from it.
    #[test]
    fn a_closed_room_is_in_balance() {
        let quad = |material: &str, points: &str| {
            format!("[[shape]]\ntype = \"quad\"\nmaterial = \"{material}\"\npoints = {points}\n")
        };
        let mut text = String::from("[lights.l]\nspectrum = \"E\"\nluminance = 31.830988618\n");
        for (name, reflectance) in [("wall", 0.5), ("floor", 0.2), ("ceiling", 0.7)] {
            text += &format!("[materials.{name}]\nreflectance = {reflectance}\n");
        }
        text += &quad("floor", "[[0,0,0],[4,0,0],[4,4,0],[0,4,0]]");
        text += &(quad("ceiling", "[[0,0,3],[0,4,3],[4,4,3],[4,0,3]]") + "light = \"l\"\n");
        text += &quad("wall", "[[0,0,0],[0,4,0],[0,4,3],[0,0,3]]");
        text += &quad("wall", "[[4,0,0],[4,0,3],[4,4,3],[4,4,0]]");
        text += &quad("wall", "[[0,0,0],[0,0,3],[4,0,3],[4,0,0]]");
        text += &quad("wall", "[[0,4,0],[4,4,0],[4,4,3],[0,4,3]]");
        let got = balance(&text);
        // Mean direct illuminances of floor and walls from case method-error-sizes; mean reflectance 0.48.
        let reflected_lx = (16.0 * 0.2 * 28.2733 + 48.0 * 0.5 * 23.9089) / 80.0;
        let want = reflected_lx / (1.0 - 0.48) / std::f64::consts::PI;
        let [luminance, error] = got.luminance_cd_m2;
        assert!(error < 0.01 * want && (luminance - want).abs() < 3.0 * error, "{luminance} +- {error} for {want}");
        assert_eq!(got.closed, 1.0);
        assert!((got.interreflected - 0.48).abs() < 0.005, "{}", got.interreflected);
    }

    /// Nothing is sent on in the open.
    #[test]
    fn a_ball_in_the_open_sees_nothing() {
        let got = balance(
            "[environment]\nspectrum = \"E\"\nluminance = 100\n[materials.m]\nreflectance = 0.5\n[[shape]]\ntype = \"sphere\"\n\
             center = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n",
        );
        assert_eq!((got.closed, got.interreflected), (0.0, 0.0));
        // What the others would see of it, had it others.
        let [luminance, error] = got.luminance_cd_m2;
        assert!((luminance - 50.0).abs() < 3.0 * error + 1e-3, "{luminance} +- {error}");
    }
}
