//! spectrace: spectral radiance of a scene, Eq. (1) of [Ward 2001], by one of several methods.

mod methods;
mod planned;

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::filter::{Filter, Product, Run};
use crate::material::read::Without;
use crate::options::{Numbers, Range, lossy};
use crate::render::checkpoint::{Checkpoint, fingerprint};
use crate::render::estimate::{Effort, FEWEST_PATHS, MOST_WAVELENGTHS, Quantity as Measured, What, estimator};
use crate::render::few::Few;
use crate::render::local;
use crate::render::picture::{Job, Work, render};
use crate::render::rays::Lines;
use crate::render::report::Report;
use crate::scene::{Scene, load};
use crate::spectral::{Observer, Sampling};
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults, usage};

/// What a pixel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Quantity {
    /// Tristimulus values in cd/m2, each lamp's spectrum at its finest folded in
    Xyz,
    /// Spectral radiance in W/sr/m2/nm
    Spectrum,
    /// Stokes vectors of it: I, Q, U and V of each wavelength
    Stokes,
}

/// How Eq. (1) is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Solver {
    /// Path tracing: all of it, with noise that falls as the root of time
    Path,
    /// Local illumination: the lamps' light and an ambient term; no light from surface to surface, nothing bent by glass, no
    /// mirrored rooms
    Local,
    /// Radiosity: surfaces in elements, whose light is balanced before the eye looks; what gloss, mirrors and glass throw onto
    /// other surfaces is spread as if they were matt
    Radiosity,
    /// Photon map: light that lamps send out, counted where it arrives, on surfaces and in media; shows caustics, is blurred within
    /// its disks
    Photon,
    /// Marching: Eq. (2) by steps along what the eye sees; the lamps' light on surfaces and, scattered once, in media
    March,
    /// Zonal: marching, and light that has scattered or was reflected before, balanced in cubes of space and tiles of surfaces
    Zonal,
}

/// What a picture takes from the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Shown {
    /// All light, from elements: no noise, soft shadows as coarse as they are
    Mesh,
    /// Light between surfaces, from elements or photons; the lamps are looked at from each place
    Direct,
    /// What is seen around each place (final gather)
    Gather,
}

/// What can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Effect {
    /// Light is its amount alone
    Polarization,
    /// Fluorescent surfaces keep what they reflect
    Fluorescence,
    /// Bodies have the index that they have at 555 nm
    Dispersion,
}

/// Wavelengths that count where a surface fluoresces, nm, and bands over them, as wide as the others.
const EXCITING: Range = Range(300.0, 780.0);
const EXCITED_BANDS: usize = 96;

/// Options of `spectrace`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Spectrace {
    /// Scene to render (TOML)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required = true)]
    #[serde(serialize_with = "lossy")]
    pub scene: Option<PathBuf>,
    /// How Eq. (1) is solved
    #[arg(long, value_enum, value_name = "METHOD", default_value = "path")]
    pub method: Solver,
    /// What a pixel holds (in a pipeline file: quantity)
    #[arg(long, visible_alias = "output", value_enum, value_name = "WHAT", default_value = "xyz")]
    pub quantity: Quantity,
    /// Equal wavelength bins that paths carry
    #[arg(long, value_name = "N", default_value_t = 80, conflicts_with = "wavelengths")]
    pub bands: usize,
    /// Points that paths carry instead, nm: 450,550,650
    #[arg(long, value_name = "LIST")]
    pub wavelengths: Option<Numbers>,
    /// What specplan found that the scene needs: a few wavelengths, or bands
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["wavelengths", "bands", "range"])]
    #[serde(serialize_with = "lossy")]
    pub plan: Option<PathBuf>,
    /// Find that here, for a colour error of any pixel, Delta E 2000
    #[arg(long, value_name = "DE", conflicts_with_all = ["plan", "wavelengths", "bands", "range"])]
    pub tolerance: Option<f64>,
    /// With --tolerance: dark pixels are looked at up to so many times brighter
    #[arg(long, value_name = "FACTOR", default_value_t = 10.0, requires = "tolerance")]
    pub gain: f64,
    /// Effects to leave out, parted by commas: polarization, fluorescence, dispersion
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with = "plan")]
    pub without: Vec<Effect>,
    /// One layer a light in place of XYZ: how much of it arrives, by wavelength; relight sums them under other lamps
    #[arg(long, conflicts_with_all = ["quantity", "rays", "irradiance"])]
    pub per_light: bool,
    /// Wavelengths that count, nm; from 300 where a surface fluoresces, in 96 bands, unless given
    #[arg(long, value_name = "A:B", default_value = "380:780")]
    pub range: Range,
    /// Paths a pixel; powers of two share the pixel best. With --error the most
    #[arg(long, value_name = "N", default_value_t = 64, help_heading = "Effort")]
    pub samples: u32,
    /// Paths that go on from the first surface of each, or where it first scatters, and look at the lamps
    #[arg(long, value_name = "N", default_value_t = 4, help_heading = "Effort")]
    pub split: u32,
    /// Each pixel's paths light that pixel alone: more noise, but none that pixels have in common
    #[arg(long, help_heading = "Effort")]
    pub no_pool: bool,
    /// As many paths as each pixel needs for this relative standard error of Y
    #[arg(long, value_name = "E", conflicts_with = "time", help_heading = "Effort")]
    pub error: Option<f64>,
    /// As many paths as fit into this many seconds
    #[arg(long, value_name = "SECONDS", conflicts_with = "samples", help_heading = "Effort")]
    pub time: Option<f64>,
    /// Most bounces; otherwise paths end by lot
    #[arg(long, value_name = "N")]
    pub max_bounces: Option<u32>,
    /// Radiance that stands for all light from other surfaces: auto (what keeps the balance of light) or cd/m2, 0 for none
    #[arg(long, value_name = "CD_M2", default_value = "auto", help_heading = "Local illumination")]
    pub ambient: local::Term,
    /// Lamps shine through everything
    #[arg(long, help_heading = "Local illumination")]
    pub no_shadows: bool,
    /// Mirrors and gloss do not show sky and lamps
    #[arg(long, help_heading = "Local illumination")]
    pub no_reflections: bool,
    /// Mean error of what is linear between elements, relative; surfaces are divided until it is met
    #[arg(long, value_name = "E", default_value_t = 0.01, help_heading = "Radiosity")]
    pub mesh_error: f64,
    /// Elements along both sides of each surface instead
    #[arg(long, value_name = "N", help_heading = "Radiosity")]
    pub divide: Option<u32>,
    /// Rays from each element (with --method zonal: zone and tile), for its form factors; from a quarter as many places the lamps are looked at
    #[arg(long, value_name = "N", default_value_t = 512, help_heading = "Radiosity")]
    pub element_rays: u32,
    /// Photons that lamps send out
    #[arg(long, value_name = "N", default_value_t = 1_000_000, help_heading = "Photon map")]
    pub photons: u32,
    /// Maps that they are shared between, one for each path of a pixel in turn; their disks shrink
    #[arg(long, value_name = "N", default_value_t = 8, help_heading = "Photon map")]
    pub passes: u32,
    /// Photons that a disk of the first map holds
    #[arg(long, value_name = "N", default_value_t = 200, help_heading = "Photon map")]
    pub count: u32,
    /// Optical depth of a step through a medium, and its length over half the distance to a lamp
    #[arg(long, value_name = "DEPTH", default_value_t = 0.1, help_heading = "Marching and zones")]
    pub step: f64,
    /// Cubes along the longest side of what a medium fills
    #[arg(long, value_name = "N", default_value_t = 10, help_heading = "Marching and zones")]
    pub zones: u32,
    /// What a picture takes from elements or photons
    #[arg(long, value_enum, value_name = "WHAT", default_value = "direct", help_heading = "Radiosity and photon map")]
    pub show: Shown,
    /// Memory that the solution and the work on it may take, MiB
    #[arg(long, value_name = "MIB", default_value_t = 1024, help_heading = "Radiosity and photon map")]
    pub solver_memory: usize,
    /// Keep the solution in a file, or take it from there: other cameras, the same light
    #[arg(long, value_name = "FILE", value_hint = ValueHint::Other, help_heading = "Radiosity and photon map")]
    #[serde(serialize_with = "lossy")]
    pub solution: Option<PathBuf>,
    /// Read one ray a line (origin, direction) from standard input, write its radiance
    #[arg(long, conflicts_with_all = ["irradiance", "time", "rows", "checkpoint", "width", "height"], help_heading = "Rays and points")]
    pub rays: bool,
    /// Read one point and normal a line, write the irradiance (XYZ: lx)
    #[arg(long, conflicts_with_all = ["time", "rows", "checkpoint", "width", "height"], help_heading = "Rays and points")]
    pub irradiance: bool,
    /// Lines are raw f32, both ways
    #[arg(long, help_heading = "Rays and points")]
    pub float: bool,
    /// Two more columns: standard error of Y (with --error), and number of paths
    #[arg(long, help_heading = "Rays and points")]
    pub with_error: bool,
    /// With --irradiance: lux, CCT, Duv, alpha-opic EDI of CIE S 026 and daylight factor in columns
    #[arg(long, requires = "irradiance", conflicts_with = "float", help_heading = "Rays and points")]
    pub report: bool,
    /// Pixels across, in place of the scene's; the height follows unless given
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<usize>,
    /// Pixels down
    #[arg(long, value_name = "PIXELS")]
    pub height: Option<usize>,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Render rows A to B (not included) only; the pixels are those of the whole picture
    #[arg(long, value_name = "A:B", help_heading = "Running in parts")]
    pub rows: Option<Range>,
    /// Keep finished rows in a file; the same command goes on from there after a kill
    #[arg(long, value_name = "FILE", value_hint = ValueHint::Other, conflicts_with = "time", help_heading = "Running in parts")]
    #[serde(serialize_with = "lossy")]
    pub checkpoint: Option<PathBuf>,
}

clap_defaults!(Spectrace);

impl Spectrace {
    fn measured(&self, scene: &Arc<Scene>, few: Option<Arc<Few>>) -> Result<Measured> {
        if let Some(few) = few {
            let own = few.quantity(self.seed)?;
            return Ok(if self.per_light { Measured { what: What::Layers, ..own } } else { own });
        }
        let plain = Spectrace::default();
        // What cannot be seen may come back as light, and bands stay as fine.
        let excited = scene.fluoresces() && self.range == plain.range;
        let Range(from, to) = if excited { EXCITING } else { self.range };
        let bands = if excited && self.bands == plain.bands { EXCITED_BANDS } else { self.bands };
        if !(250.0..=2500.0).contains(&from) || !(250.0..=2500.0).contains(&to) {
            return usage!("--range {}: wavelengths run from 250 to 2500 nm", self.range);
        }
        let sampling = match &self.wavelengths {
            Some(nm) if nm.0.len() > MOST_WAVELENGTHS => {
                return usage!("--wavelengths: {} of them; at most {MOST_WAVELENGTHS}", nm.0.len());
            }
            Some(nm) => Sampling::points(nm.0.clone()).map_err(|e| Error::Usage(format!("--wavelengths: {e}")))?,
            None if bands > MOST_WAVELENGTHS => {
                return usage!("--bands {bands}: at most {MOST_WAVELENGTHS}");
            }
            None => Sampling::bins(from, to, bands).map_err(|e| Error::Usage(format!("--bands: {e}")))?,
        };
        let what = match self.quantity {
            _ if self.report => What::Lighting,
            _ if self.per_light => What::Layers,
            Quantity::Spectrum => What::Spectrum,
            Quantity::Stokes => What::Stokes,
            Quantity::Xyz => What::Xyz,
        };
        Ok(Measured { sampling, range_nm: (from, to), what, seed: self.seed, few: None })
    }

    fn effort(&self) -> Result<Work> {
        match (self.error, self.time) {
            (None, None) => Ok(Work::Each(Effort::Paths(self.samples))),
            (Some(target), _) if target > 0.0 && target < 10.0 => {
                // Without a word on it, enough for 0.1 % of a pixel whose paths differ by 100 %.
                let most = if self.samples == Spectrace::default().samples { 1 << 20 } else { self.samples };
                if most < FEWEST_PATHS {
                    return usage!("--samples {most}: --error needs at least {FEWEST_PATHS} paths to tell an error");
                }
                Ok(Work::Each(Effort::Error { target, most }))
            }
            (Some(e), _) => usage!("--error {e}: a relative error above 0, such as 0.01"),
            (None, Some(s)) if s > 0.0 && s < 1e9 => Ok(Work::Time(Duration::from_secs_f64(s))),
            (None, Some(s)) => usage!("--time {s}: seconds above 0"),
        }
    }

    fn row_range(&self, height: usize) -> Result<(usize, usize)> {
        match self.rows {
            None => Ok((0, height)),
            Some(Range(a, b)) if a >= 0.0 && b <= height as f64 && a.fract() == 0.0 && b.fract() == 0.0 => {
                Ok((a as usize, b as usize))
            }
            Some(r) => usage!("--rows {r}: the picture has rows 0:{height}"),
        }
    }

    /// Rays or points from standard input.
    fn lines(self, scene: Arc<Scene>, few: Option<Arc<Few>>, run: &Run) -> Result<Product> {
        let (quantity, choice) = (self.measured(&scene, few)?, self.choice(&scene, run)?);
        note_lost_light(&scene, quantity.range_nm, run)?;
        let Work::Each(effort) = self.effort()? else { return usage!("--time is for pictures") };
        let estimate = estimator(scene.clone(), &quantity, &choice)?;
        let lines = Lines {
            scene,
            estimate: estimate.clone(),
            effort,
            irradiance: self.irradiance,
            float: self.float,
            with_error: self.with_error,
        };
        let notes = run.notes.clone();
        let report = self.report.then(|| Report::new(&lines.scene)).transpose()?;
        let write = Box::new(move |out: &mut Output| {
            let mut input = std::io::stdin().lock();
            match report {
                None => lines.run(&mut input, out, &|v| v.iter().map(|v| f64::from(*v)).collect())?,
                Some(report) => {
                    let more = if lines.with_error { "\tse_lux\tpaths" } else { "" };
                    writeln!(out, "# {}{more}", Report::COLUMNS).map_err(|e| Error::io("standard output", e))?;
                    lines.run(&mut input, out, &|v| report.row(v))?;
                }
            }
            estimate.report(&notes);
            Ok(())
        });
        Ok(Product::Bytes { binary: self.float, write })
    }

    /// The checkpoint file, which must be of this very picture.
    fn checkpoint(&self, scene: &Scene, path: &Path, few: Option<&Few>, run: &Run) -> Result<Option<Checkpoint>> {
        let Some(file) = &self.checkpoint else { return Ok(None) };
        let text = std::fs::read(path).map_err(|e| Error::io(path.display().to_string(), e))?;
        let spectra = format!("{:?} {:?}", scene.inks, scene.lights);
        let rows = format!("{:?} {} {:?} {:?}", self.rows, scene.geometry.len(), few, self.max_bounces);
        let parts: [&[u8]; 4] = [&text, spectra.as_bytes(), &run.history, rows.as_bytes()];
        Checkpoint::open(file, fingerprint(&parts)).map(Some)
    }
}

/// Visible light outside the range is lost to the picture: worth a word.
fn note_lost_light(scene: &Scene, (from, to): (f64, f64), run: &Run) -> Result<()> {
    let y = &Observer::cie1931()?.cmf[1];
    for light in &scene.lights {
        let all = light.radiance.product_integral(y, 0.0, f64::INFINITY);
        let within = light.radiance.product_integral(y, from, to);
        if all > 0.0 && within < 0.99 * all {
            let name = crate::error::printable(light.name.as_bytes());
            run.notes.add(format!(
                "of the light of '{name}' only {:.1} % lies within --range {from}:{to}",
                100.0 * within / all
            ));
        }
    }
    Ok(())
}

impl Filter for Spectrace {
    const NAME: &'static str = "spectrace";
    const ABOUT: &'static str = "Render a scene to absolute XYZ or spectral radiance (Eq. 1)";
    const EXAMPLE: &'static str =
        "spectrace scenes/cornell.toml | vonkries --to D65 | pcond | xyz2rgb --gamut desaturate | ra_png > cornell.png";
    const READS: bool = false;

    fn look_ahead(&self) -> Result<Option<usize>> {
        let Some(path) = &self.scene else { return Ok(None) };
        let scene = load::load(path)?;
        let camera = scene.camera.map(|c| c.resized(self.width, self.height)).transpose()?;
        // Paths that a time allows are counted on the whole picture.
        Ok(camera.map(|c| c.height).filter(|_| self.rows.is_none() && self.time.is_none()))
    }

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let path = self.scene.as_ref().ok_or_else(|| Error::Usage("expected a scene file".into()))?;
        if [self.width, self.height].iter().flatten().any(|n| !(1..=1_000_000).contains(n))
            || self.samples == 0
            || !(1..=64).contains(&self.split)
        {
            return usage!(
                "--width, --height and --samples must be at least 1, sizes at most 1000000, --split 1 to 64"
            );
        }
        let by_lines = self.rays || self.irradiance;
        if !by_lines && (self.float || self.with_error || self.report) {
            return usage!("--float and --with-error go with --rays or --irradiance, --report with --irradiance");
        }
        let load = |without: Without| load::load_without(path, without);
        let scene = Arc::new(load(self.without()?)?);
        run.notes.extend(&scene.remarks);
        // Planned as the scene file has its camera: a plan does not depend on the size of the picture.
        let (planned, without, scene, few) = self.planned(scene, &load, &run.notes)?;
        let mut scene = Arc::try_unwrap(scene).or_else(|_| load(without))?;
        scene.camera = scene.camera.map(|c| c.resized(self.width, self.height)).transpose()?;
        let scene = Arc::new(scene);
        if by_lines {
            return planned.lines(scene, few, run);
        }
        planned.picture(path, scene, few, run)
    }
}

impl Spectrace {
    fn picture(&self, path: &Path, scene: Arc<Scene>, few: Option<Arc<Few>>, run: &Run) -> Result<Product> {
        let Some(camera) = &scene.camera else {
            return Err(Error::Invalid("the scene has no [camera]".into()).in_file(path));
        };
        let rows = self.row_range(camera.height)?;
        let quantity = self.measured(&scene, few)?;
        note_lost_light(&scene, quantity.range_nm, run)?;
        let checkpoint = self.checkpoint(&scene, path, quantity.few.as_deref(), run)?;
        let job = Job {
            quantity,
            method: self.choice(&scene, run)?,
            effort: self.effort()?,
            rows,
            progress: !run.options.quiet && std::io::stderr().is_terminal(),
            checkpoint,
            notes: run.notes.clone(),
        };
        // What gives the same bytes again: the number of paths in place of the time.
        let history = |paths: Option<u32>| match paths {
            Some(samples) => run.history_of(&Spectrace { samples, time: None, ..self.clone() }),
            None => run.history.clone(),
        };
        render(scene, job, history).map(Product::Picture).map_err(|e| e.in_file(path))
    }
}
