//! A scene rendered as a picture: rows on demand, pixels on all threads, each the same whatever the order.

use std::sync::Arc;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use crate::render::film::{Bands, Film, Tristimulus};
use crate::render::lanes::{Diagonal, GROUP, Lanes};
use crate::render::path::{Tracer, running_chances};
use crate::render::sampler::Sampler;
use crate::scene::Scene;
use crate::spectral::{Observer, Sampling, Spectrum};
use crate::stream::{Block, Components, Header, Picture, Resolution, Units};
use crate::{Error, Result, invalid, parallel};

/// What to render.
#[derive(Clone, Debug)]
pub struct Job {
    /// Wavelengths that paths carry.
    pub sampling: Sampling,
    /// Wavelengths that count, nm.
    pub range_nm: (f64, f64),
    /// Spectral radiance instead of XYZ.
    pub spectrum: bool,
    /// Paths a pixel.
    pub samples: u32,
    /// Another seed, another noise.
    pub seed: u32,
    /// Most bounces; light that comes straight from a lamp has none.
    pub max_bounces: u32,
    /// Rows from and to (not included).
    pub rows: (usize, usize),
    /// Progress on standard error.
    pub progress: bool,
}

/// Rows rendered at a time: enough pixels that all threads stay busy.
const PIXELS_A_BLOCK: usize = 8192;
/// Pixels that one thread takes at a time.
const PIXELS_A_TASK: usize = 64;
/// Most wavelengths: 8 lanes x the largest number of groups below.
pub const MOST_WAVELENGTHS: usize = GROUP * 60;

/// One pixel: x, y and its components.
type Shade = Box<dyn Fn(usize, usize, &mut [f32]) + Send + Sync>;

/// A render in progress.
struct Rendering {
    header: Header,
    width: usize,
    row: usize,
    end: usize,
    first: usize,
    shade: Shade,
    bar: ProgressBar,
}

/// Begins a render; rows are computed as they are read.
pub fn render(scene: Scene, job: &Job, history: Vec<u8>) -> Result<Box<dyn Picture>> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let components = if job.spectrum { Components::Spectrum } else { Components::Xyz };
    let ncomp = if job.spectrum { job.sampling.count() } else { 3 };
    let units = if job.spectrum { Units::SpectralRadiance } else { Units::CdM2 };
    let (first, end) = job.rows;
    let mut header = Header::new(Resolution::upright(width, end - first), components, ncomp, units);
    header.white = scene.white()?;
    if header.white.is_none() && !job.spectrum {
        return invalid!("no surface of the scene gives off visible light");
    }
    header.sampling = job.spectrum.then(|| job.sampling.clone());
    header.lines.push(history);
    header.lines.push(format!("VIEW= {}", scene.camera.view()).into_bytes());
    if (first, end) != (0, height) {
        header.lines.push(format!("ROWS= {first} {end} {height}").into_bytes());
    }
    let shade = shader(Arc::new(scene), job)?;
    let target = if job.progress { ProgressDrawTarget::stderr_with_hz(4) } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some((end - first) as u64), target);
    if let Ok(style) = ProgressStyle::with_template("spectrace {wide_bar} row {pos} of {len}, {eta} left") {
        bar.set_style(style);
    }
    Ok(Box::new(Rendering { header, width, row: first, end, first, shade, bar }))
}

/// The smallest number of lane groups that holds the wavelengths.
fn shader(scene: Arc<Scene>, job: &Job) -> Result<Shade> {
    match job.sampling.count().div_ceil(GROUP) {
        0..=1 => film::<1>(scene, job),
        2 => film::<2>(scene, job),
        3 => film::<3>(scene, job),
        4..=6 => film::<6>(scene, job),
        7..=10 => film::<10>(scene, job),
        11..=20 => film::<20>(scene, job),
        21..=60 => film::<60>(scene, job),
        _ => Err(Error::Unsupported(format!("{} wavelengths; at most {MOST_WAVELENGTHS}", job.sampling.count()))),
    }
}

fn film<const G: usize>(scene: Arc<Scene>, job: &Job) -> Result<Shade> {
    let lights: Vec<&Spectrum> = scene.lights.iter().map(|l| &l.radiance).collect();
    if job.spectrum {
        let film = Bands::<G>::new(&lights, &job.sampling);
        pixels(scene, film, job)
    } else {
        let film = Tristimulus::<G>::new(&lights, &job.sampling, job.range_nm, &Observer::cie1931()?);
        pixels(scene, film, job)
    }
}

fn pixels<const G: usize, F>(scene: Arc<Scene>, film: F, job: &Job) -> Result<Shade>
where
    F: Film<Diagonal<G>> + 'static,
{
    let events: Vec<Lanes<G>> =
        scene.materials.iter().map(|m| Lanes::from_values(&job.sampling.sample(&m.reflectance))).collect();
    let chances = running_chances(&power(&scene)?);
    let (samples, seed, max_bounces) = (job.samples, job.seed, job.max_bounces);
    Ok(Box::new(move |x, y, out| {
        let tracer =
            Tracer::<Diagonal<G>, F> { scene: &scene, events: &events, film: &film, chances: &chances, max_bounces };
        let mut sum = film.black();
        for index in 0..samples {
            let mut sampler = Sampler::new(x, y, index, seed);
            let place = sampler.next2();
            let (origin, direction) = scene.camera.ray(x as f64 + f64::from(place[0]), y as f64 + f64::from(place[1]));
            tracer.trace(origin, direction, &mut sampler, &mut sum);
        }
        film.develop(&sum, 1.0 / f64::from(samples), out);
    }))
}

/// Luminous power of each emitter; equal weights where a scene has none.
fn power(scene: &Scene) -> Result<Vec<f64>> {
    let observer = Observer::cie1931()?;
    // Once a light: a shining mesh has as many emitters as triangles.
    let y: Vec<f64> = scene.lights.iter().map(|l| observer.integrate(&l.radiance)[1]).collect();
    let power: Vec<f64> = scene.emitters.iter().map(|e| y[e.light] * e.area_m2()).collect();
    Ok(if power.iter().all(|p| *p > 0.0) { power } else { vec![1.0; power.len()] })
}

impl Picture for Rendering {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let rows = PIXELS_A_BLOCK.div_ceil(self.width).min(self.end - self.row);
        let n = self.header.ncomp;
        block.rows = rows;
        block.data.resize(rows * self.width * n, 0.0);
        let (first, width, shade) = (self.row, self.width, &self.shade);
        let task = |(i, pixels): (usize, &mut [f32])| {
            for (k, out) in pixels.chunks_exact_mut(n).enumerate() {
                let at = i * PIXELS_A_TASK + k;
                shade(at % width, first + at / width, out);
            }
        };
        if parallel::pool() {
            block.data.par_chunks_mut(PIXELS_A_TASK * n).enumerate().for_each(task);
        } else {
            block.data.chunks_mut(PIXELS_A_TASK * n).enumerate().for_each(task);
        }
        self.row += rows;
        self.bar.set_position((self.row - self.first) as u64);
        if rows == 0 {
            self.bar.finish_and_clear();
        }
        Ok(rows > 0)
    }
}
