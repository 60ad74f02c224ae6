//! How much light arrives along a pixel, a ray or on a point: paths until there are enough.
//!
//! A fixed number of paths is one randomised net, the best there is for that number. To know the error as well, the paths
//! come in [`REPLICATES`] nets with randomisations of their own, each of them doubled until the spread of their means says
//! that the mean is good enough [Owen 1997].

use std::marker::PhantomData;
use std::sync::Arc;

use glam::Vec3A;

use crate::material::{Ink, Tint};
use crate::notes::Notes;
use crate::optics::aperture::Airy;
use crate::render::beam::{Beam, Stokes};
use crate::render::comb::Comb;
use crate::render::few::Few;
use crate::render::film::{Bands, Film, Responses, StokesBands, light_weights};
use crate::render::inks::{Inks, Outline};
use crate::render::lanes::{GROUP, Lanes};
use crate::render::layers::Layers;
use crate::render::method::{Choice, Method};
use crate::render::plane;
use crate::render::pool::{MEMBERS, Pool};
use crate::render::sampler::Sampler;
use crate::render::tile::{Deal, Tile};
use crate::render::trail::{Arrived, Trail, find};
use crate::render::wavelengths::Carried;
use crate::scene::{Scene, ray};
use crate::simd;
use crate::spectral::{Observer, Sampling, Spectrum, builtin};
use crate::units::K_M;
use crate::{Error, Result, invalid};

/// The pairs of a sampler's numbers that diffraction at the eye's opening takes.
const PUPIL: u32 = 0x4000_0010;
/// Tells who meets whom in pools from where their paths go.
const POOLS: u32 = 0xa511_e9b3;
/// Independent randomisations that tell the error.
pub const REPLICATES: u32 = 8;
/// Paths that each of them takes at first.
const FIRST_PATHS: u32 = 4;
/// Paths that an error takes at least.
pub const FEWEST_PATHS: u32 = REPLICATES * FIRST_PATHS;
/// Most wavelengths: 8 lanes x the largest number of groups below.
pub const MOST_WAVELENGTHS: usize = GROUP * 60;
/// Wavelengths that outlines of the light for an observer are made of.
const OUTLINED: usize = 80;
/// What all wavelengths together count by, over what they count for the observer, where some may fluoresce.
const UNSEEN: f64 = 0.3;
/// Probes that are neighbours, and judged together: the error of one alone is itself uncertain.
pub const NEIGHBOURS: usize = 16;

/// What an estimate is of.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Wavelengths that paths carry.
    pub sampling: Sampling,
    /// Wavelengths that count, nm.
    pub range_nm: (f64, f64),
    /// What a probe's numbers are.
    pub what: What,
    /// Another seed, another noise.
    pub seed: u32,
    /// What XYZ the wavelengths stand for, light by light, where they are few and chosen for the scene; `sampling` is its own.
    pub few: Option<Arc<Few>>,
}

/// What the numbers of a probe are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// XYZ in cd/m2 (lx).
    Xyz,
    /// W/sr/m2/nm (W/m2/nm), a number a wavelength.
    Spectrum,
    /// The same as Stokes vectors: I, Q, U and V of each wavelength.
    Stokes,
    /// Of each light, how much of its radiance arrives, a number a wavelength; the lights one after the other ([`Layers`]).
    Layers,
    /// XYZ, and the five alpha-opic radiances (irradiances) of CIE S 026 in W/sr/m2 (W/m2): S, M, L cone, rhodopic,
    /// melanopic.
    Lighting,
}

/// How much work a probe is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// Paths a probe.
    Paths(u32),
    /// Standard error of the luminance over the luminance, and most paths a probe.
    Error {
        /// Relative standard error.
        target: f64,
        /// Paths at most.
        most: u32,
    },
}

/// Where light is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Probe {
    /// The mean radiance of a pixel.
    Pixel {
        /// From the left.
        x: u32,
        /// From the top.
        y: u32,
    },
    /// Radiance along a ray, in the scene's frame.
    Ray {
        /// Start.
        origin: Vec3A,
        /// Unit direction.
        direction: Vec3A,
        /// Tells rays apart.
        number: u64,
    },
    /// Irradiance of a point.
    Irradiance {
        /// Place in the scene's frame.
        point: Vec3A,
        /// Unit normal.
        normal: Vec3A,
        /// Tells points apart.
        number: u64,
    },
}

/// How good an estimate is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// cd/m2, or lx; of spectra without visible light the sum of the bands.
    pub luminance: f64,
    /// Of the luminance; NaN where a fixed number of paths does not tell.
    pub standard_error: f64,
    /// Paths taken.
    pub paths: u64,
    /// The target was not reached.
    pub short: bool,
}

/// Estimates of one scene.
pub trait Estimate: Send + Sync {
    /// Numbers a probe gives.
    fn components(&self) -> usize;

    /// Measures neighbours, at most [`NEIGHBOURS`] of them; `out` holds their components one after the other.
    fn measure(&self, probes: &[Probe], effort: Effort, out: &mut [f32]) -> [Quality; NEIGHBOURS];

    /// The paths of pixels are pooled by [`Estimate::tile`].
    fn pools(&self) -> bool;

    /// The same of a rectangle of pixels, row by row, by so many paths each, which are pooled among pixels near each other.
    fn tile(&self, tile: &Tile, paths: u32, out: &mut [f32]);

    /// Says at the end how well it went.
    fn report(&self, notes: &Notes);
}

/// The smallest number of lane groups that holds the wavelengths.
pub fn estimator(scene: Arc<Scene>, quantity: &Quantity, method: &Choice) -> Result<Arc<dyn Estimate>> {
    match quantity.sampling.count().div_ceil(GROUP) {
        0..=1 => film::<1>(scene, quantity, method),
        2 => film::<2>(scene, quantity, method),
        3 => film::<3>(scene, quantity, method),
        4..=6 => film::<6>(scene, quantity, method),
        7..=10 => film::<10>(scene, quantity, method),
        11..=12 => film::<12>(scene, quantity, method),
        13..=20 => film::<20>(scene, quantity, method),
        21..=60 => film::<60>(scene, quantity, method),
        _ => {
            let count = quantity.sampling.count();
            Err(Error::Unsupported(format!("{count} wavelengths; at most {MOST_WAVELENGTHS}")))
        }
    }
}

fn film<const G: usize>(scene: Arc<Scene>, quantity: &Quantity, method: &Choice) -> Result<Arc<dyn Estimate>> {
    if scene.lamps.is_empty() && !scene.media.glow() {
        return invalid!("nothing in the scene gives off light");
    }
    // Light that has changed its wavelength is one of its own, whose factors are its radiance.
    let changed = Spectrum::Constant(1.0);
    let mut lights: Vec<&Spectrum> = scene.lights.iter().map(|l| &l.radiance).collect();
    if scene.fluoresces() {
        lights.push(&changed);
    }
    let observer = Observer::cie1931()?;
    let Quantity { sampling, range_nm, seed, .. } = quantity.clone();
    let outline = match quantity.what {
        What::Spectrum | What::Stokes => Outline::new(&scene.inks, &scene.srgb, &sampling, None),
        // The same paths however many wavelengths they carry.
        What::Xyz | What::Layers | What::Lighting => {
            let fine = Sampling::bins(range_nm.0, range_nm.1, OUTLINED)?;
            let mut counts = fine.xyz_weights(&observer);
            if scene.fluoresces() {
                // What cannot be seen may come back as light: each wavelength counts besides.
                for counts in &mut counts {
                    let each = UNSEEN * counts.iter().sum::<f64>() / OUTLINED as f64;
                    counts.iter_mut().for_each(|c| *c += each);
                }
            }
            Outline::new(&scene.inks, &scene.srgb, &fine, Some(&counts))
        }
    };
    // The paths are those of the scene's own spectra, whatever stands in their place.
    let converted = quantity.few.as_ref().and_then(|f| f.converted.as_ref());
    let (own, srgb) = converted.map_or((&scene.inks, &scene.srgb), |c| (&c.inks, &c.srgb));
    let carried = Carried::<G>::new(&scene, (own, srgb), &sampling, range_nm)?;
    // The other methods know nothing of it.
    let polarised = matches!(method, Choice::Path(_)) && (scene.polarised || quantity.what == What::Stokes);
    let method = method.on(scene.clone(), outline, range_nm, (Comb::new(&sampling), polarised), &carried)?;
    let all: Vec<Ink> = own.iter().chain(method.inks()).cloned().collect();
    let inks = Inks::<G>::new(&all, srgb, &sampling).with_lights(&lights[..scene.lights.len()], &sampling);
    let cmf = observer.cmf.each_ref().map(|c| c.scaled(K_M));
    let paths = Paths { scene: scene.clone(), method, polarised, comb: Comb::new(&sampling), seed };
    Ok(match quantity.what {
        What::Spectrum => {
            let film = Bands::<G>::new(&lights, &sampling, &observer);
            carrying(polarised, paths, film, inks)
        }
        What::Stokes => {
            let film = StokesBands(Bands::<G>::new(&lights, &sampling, &observer));
            carrying(polarised, paths, film, inks)
        }
        What::Xyz => {
            let film = match &quantity.few {
                Some(few) => Responses::<G, 3>::of(&few.rule.weights),
                None => Responses::<G, 3>::new(&lights, &sampling, range_nm, &cmf),
            };
            carrying(polarised, paths, film, inks)
        }
        What::Layers => {
            if scene.fluoresces() {
                return invalid!("the scene fluoresces: light that changes its wavelength is of no one light");
            }
            let luminance = match &quantity.few {
                Some(few) => few.rule.weights.iter().map(|w| w[1].clone()).collect(),
                None => lights.iter().map(|l| light_weights(l, &sampling, range_nm, &cmf[1])).collect(),
            };
            carrying(polarised, paths, Layers::<G>::new(luminance, sampling.count()), inks)
        }
        What::Lighting => {
            let opic = |n: &str| builtin::spectrum(&format!("alphaopic_{n}"));
            let [x, y, z] = cmf;
            let (s, m, l) = (opic("s_cone")?, opic("m_cone")?, opic("l_cone")?);
            let responses = [x, y, z, s, m, l, opic("rhodopic")?, opic("melanopic")?];
            let film = Responses::<G, 8>::new(&lights, &sampling, range_nm, &responses);
            carrying(polarised, paths, film, inks)
        }
    })
}

/// With Stokes vectors, or amounts of light alone.
fn carrying<const G: usize, F: Film<G> + 'static>(
    polarised: bool,
    paths: Paths,
    film: F,
    inks: Inks<G>,
) -> Arc<dyn Estimate> {
    if polarised {
        Arc::new(Estimator::<G, F, Stokes<G>> { paths, film, inks, beam: PhantomData })
    } else {
        Arc::new(Estimator::<G, F, Lanes<G>> { paths, film, inks, beam: PhantomData })
    }
}

/// What paths need to know whatever the wavelengths.
struct Paths {
    scene: Arc<Scene>,
    method: Box<dyn Method>,
    polarised: bool,
    comb: Comb,
    seed: u32,
}

impl Paths {
    /// A ray from the eye through a place of the pixel.
    fn eye(&self, x: u32, y: u32, sampler: &Sampler, trail: &mut Trail) -> Option<(Vec3A, Vec3A)> {
        let camera = self.scene.camera.as_ref()?;
        let place = sampler.pair(0);
        let lens = if camera.has_lens() { sampler.pair(1) } else { [0.0; 2] };
        let (x, y) = (f64::from(x) + f64::from(place[0]), f64::from(y) + f64::from(place[1]));
        if self.polarised {
            trail.frame = camera.rightwards(x, y)?;
        }
        let (origin, direction) = camera.ray(x, y, lens)?;
        let Some(pupil_m) = camera.pupil_m else { return Some((origin, direction)) };
        // Diffracted as one wavelength is; the others weigh the way by how likely it is theirs.
        let (place, lot) = (sampler.pair(PUPIL), sampler.pair(PUPIL + 1)[0]);
        let v_nm = Airy::get().draw(place[0].into()) as f32 * self.comb.any(lot);
        trail.tint(&Tint::Airy { v_nm });
        let sin = f64::from(v_nm) * 1e-9 / (std::f64::consts::PI * pupil_m);
        let ((s, t), (b, a)) = (ray::frame(direction), (place[1] * std::f32::consts::TAU).sin_cos());
        Some((origin, (direction + (s * a + t * b) * sin as f32).normalize()))
    }

    /// Follows one path of a pixel as a member of a pool.
    fn pool(&self, (x, y): (u32, u32), index: u32, trail: &mut Trail, pool: &mut Pool) {
        let sampler = Sampler::new(x, y, index, self.seed);
        if let Some((origin, direction)) = self.eye(x, y, &sampler, trail) {
            self.method.pooled(origin, direction, &sampler, trail, pool);
        }
    }

    /// Follows one path and leaves its trail.
    fn trace(&self, probe: &Probe, index: u32, replicate: u32, trail: &mut Trail) {
        let seed = self.seed ^ replicate.wrapping_mul(0x9e37_79b9);
        match *probe {
            Probe::Pixel { x, y } => {
                let sampler = Sampler::new(x, y, index, seed);
                if let Some((origin, direction)) = self.eye(x, y, &sampler, trail) {
                    self.method.radiance(origin, direction, &sampler, trail);
                }
            }
            Probe::Ray { origin, direction, number } => {
                trail.frame = plane::across(direction);
                self.method.radiance(origin, direction, &numbered(number, index, seed), trail);
            }
            Probe::Irradiance { point, normal, number } => {
                self.method.irradiance(point, normal, &numbered(number, index, seed), trail);
            }
        }
    }
}

/// Paths with the wavelengths they carry and what becomes of them.
struct Estimator<const G: usize, F, B> {
    paths: Paths,
    film: F,
    inks: Inks<G>,
    beam: PhantomData<fn() -> B>,
}

/// Room to work in, for one path or those of a pool.
struct Desk<const G: usize, B> {
    pool: Pool,
    /// Of each member.
    trails: [Trail; MEMBERS],
    /// What it has of the pool's tails.
    pooled: [Vec<(u32, B)>; MEMBERS],
    arrived: Arrived<G, B>,
}

impl<const G: usize, B> Default for Desk<G, B> {
    fn default() -> Self {
        let pooled = std::array::from_fn(|_| Vec::new());
        Desk { pool: Pool::default(), trails: Default::default(), pooled, arrived: Arrived::default() }
    }
}

impl<const G: usize, F: Film<G>, B: Beam<G>> Estimator<G, F, B> {
    /// Paths `from..to` of all replicates.
    fn add(&self, probe: &Probe, (from, to): (u32, u32), sums: &mut [F::Pixel], desk: &mut Desk<G, B>) {
        for (replicate, sum) in sums.iter_mut().enumerate() {
            for index in from..to {
                desk.trails[0].clear();
                self.paths.trace(probe, index, replicate as u32, &mut desk.trails[0]);
                self.expose(desk, &[0], std::slice::from_mut(sum));
            }
        }
    }

    /// One path of each member, pooled.
    fn together(&self, tile: &Tile, members: &[usize], index: u32, sums: &mut [F::Pixel], desk: &mut Desk<G, B>) {
        desk.pool.clear();
        for (m, trail) in members.iter().zip(&mut desk.trails) {
            trail.clear();
            desk.pool.enter();
            self.paths.pool(tile.pixel(*m), index, trail, &mut desk.pool);
        }
        desk.pool.connect(&self.paths.scene.geometry);
        self.expose(desk, members, sums);
    }

    /// Adds what the trails of some members bring to their sums; before that what the tails of their pool bring to each.
    fn expose(&self, desk: &mut Desk<G, B>, members: &[usize], sums: &mut [F::Pixel]) {
        let stored = self.paths.method.stored();
        let Desk { pool, trails, pooled, arrived } = desk;
        let tails = pool.tails();
        simd::wide(
            #[inline(always)]
            || {
                // One loop for both: a trail is followed in one place, which takes long to compile.
                for i in 0..tails.len() + members.len() {
                    let tail = tails.get(i);
                    let m = i - tails.len().min(i);
                    let (trail, more) = tail.map_or((&trails[m], &pooled[m][..]), |t| (&t.trail, &[][..]));
                    let found = arrived.follow_pooled(trail, &self.inks, stored, more);
                    let Some(tail) = tail else {
                        for (light, factors) in found {
                            self.film.expose(&mut sums[members[m]], *light, factors);
                        }
                        pooled[m].clear();
                        continue;
                    };
                    for (sums, weight) in pooled.iter_mut().zip(&tail.weights).filter(|p| *p.1 > 0.0) {
                        for (light, beam) in found {
                            find(sums, *light).add_scaled(beam, *weight);
                        }
                    }
                }
            },
        );
    }
}

/// The points of a numbered ray.
fn numbered(number: u64, index: u32, seed: u32) -> Sampler {
    Sampler::new(number as u32, (number >> 32) as u32 ^ 0x5bd1_e995, index, seed)
}

/// What turns a mean over paths into the probe's unit.
fn unit(probe: &Probe) -> f64 {
    match probe {
        Probe::Irradiance { .. } => std::f64::consts::PI,
        _ => 1.0,
    }
}

impl<const G: usize, F: Film<G>, B: Beam<G>> Estimate for Estimator<G, F, B> {
    fn components(&self) -> usize {
        self.film.components()
    }

    fn report(&self, notes: &Notes) {
        self.paths.method.report(notes);
    }

    fn pools(&self) -> bool {
        self.paths.method.pools()
    }

    fn tile(&self, tile: &Tile, paths: u32, out: &mut [f32]) {
        let mut desk = Desk::<G, B>::default();
        let mut sums = vec![self.film.black(); tile.pixels()];
        let mut deal = Deal::default();
        for index in 0..paths {
            let sampler = Sampler::new(tile.x as u32, tile.y as u32, index, self.paths.seed ^ POOLS);
            tile.deal(&sampler, &mut deal);
            for members in deal.pools() {
                self.together(tile, members, index, &mut sums, &mut desk);
            }
        }
        for (sum, out) in sums.iter().zip(out.chunks_exact_mut(self.film.components())) {
            self.film.develop(sum, 1.0 / f64::from(paths), out);
        }
    }

    fn measure(&self, probes: &[Probe], effort: Effort, out: &mut [f32]) -> [Quality; NEIGHBOURS] {
        let mut quality = [Quality::default(); NEIGHBOURS];
        let n = self.film.components();
        let mut desk = Desk::<G, B>::default();
        let (target, most) = match effort {
            Effort::Paths(paths) => {
                for ((probe, out), quality) in probes.iter().zip(out.chunks_exact_mut(n)).zip(&mut quality) {
                    let mut sum = self.film.black();
                    self.add(probe, (0, paths), std::slice::from_mut(&mut sum), &mut desk);
                    let factor = unit(probe) / f64::from(paths);
                    self.film.develop(&sum, factor, out);
                    let luminance = self.film.luminance(&sum) * factor;
                    *quality = Quality { luminance, standard_error: f64::NAN, paths: paths.into(), short: false };
                }
                return quality;
            }
            Effort::Error { target, most } => (target, (most / REPLICATES).max(FIRST_PATHS)),
        };
        let mut sums = vec![vec![self.film.black(); REPLICATES as usize]; probes.len()];
        let mut open = vec![true; probes.len()];
        let mut done = vec![0u32; probes.len()];
        let mut paths = FIRST_PATHS;
        while open.contains(&true) {
            for (i, probe) in probes.iter().enumerate().filter(|(i, _)| open[*i]) {
                self.add(probe, (done[i], paths), &mut sums[i], &mut desk);
                done[i] = paths;
                quality[i] = self.quality(probe, &sums[i], paths);
            }
            judge(&quality[..probes.len()], target, &mut open);
            if paths >= most {
                (0..probes.len()).filter(|i| open[*i]).for_each(|i| quality[i].short = true);
                break;
            }
            paths = (2 * paths).min(most);
        }
        for (i, (probe, out)) in probes.iter().zip(out.chunks_exact_mut(n)).enumerate() {
            let mut all = self.film.black();
            sums[i].iter().for_each(|s| self.film.add(&mut all, s));
            self.film.develop(&all, unit(probe) / f64::from(done[i] * REPLICATES), out);
        }
        quality
    }
}

impl<const G: usize, F: Film<G>, B: Beam<G>> Estimator<G, F, B> {
    fn quality(&self, probe: &Probe, sums: &[F::Pixel], paths: u32) -> Quality {
        let r = f64::from(REPLICATES);
        let factor = unit(probe) / f64::from(paths);
        let means: Vec<f64> = sums.iter().map(|s| self.film.luminance(s) * factor).collect();
        let luminance = means.iter().sum::<f64>() / r;
        let variance = means.iter().map(|m| (m - luminance).powi(2)).sum::<f64>() / (r - 1.0);
        let paths = u64::from(paths) * u64::from(REPLICATES);
        Quality { luminance, standard_error: (variance / r).sqrt(), paths, short: false }
    }
}

/// Which probes need more paths. An error from eight means is known to a quarter of itself only, so that each probe is
/// judged by the larger one of its own and half of what its neighbours have, in squares; one much darker than its
/// neighbours need not be known better than to a hundredth of their luminance.
fn judge(quality: &[Quality], target: f64, open: &mut [bool]) {
    let n = quality.len() as f64;
    let mean = quality.iter().map(|q| q.luminance).sum::<f64>() / n;
    let error2 = |q: &Quality| (q.standard_error / q.luminance.max(0.01 * mean).max(f64::MIN_POSITIVE)).powi(2);
    let neighbours = quality.iter().map(error2).sum::<f64>() / n;
    for (q, open) in quality.iter().zip(open) {
        // Nothing found yet may mean that there is nothing, or that it is hard to find.
        let blank = q.luminance <= 0.0 && q.paths < 512;
        *open = blank || error2(q).max(0.5 * neighbours) > target * target;
    }
}
