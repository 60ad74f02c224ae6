//! The method that the options ask for, and what does not go with it.

use super::{Quantity, Shown, Solver, Spectrace};
use crate::filter::Run;
use crate::render::method::Choice;
use crate::render::radiosity::MOST_RAYS;
use crate::render::{local, march, path, photon, radiosity};
use crate::scene::Scene;
use crate::{Result, usage};

impl Spectrace {
    /// The method, and that no other's options were given.
    pub(super) fn choice(&self, scene: &Scene, run: &Run) -> Result<Choice> {
        self.note_left_out(scene, run)?;
        let plain = Spectrace::default();
        let march = self.step != plain.step;
        let zonal = self.zones != plain.zones;
        let path = (self.max_bounces, self.split, self.no_pool) != (plain.max_bounces, plain.split, false);
        let local = (self.ambient, self.no_shadows, self.no_reflections) != (plain.ambient, false, false);
        let radiosity = (self.mesh_error, self.divide) != (plain.mesh_error, None);
        let rays = self.element_rays != plain.element_rays;
        let photon = (self.photons, self.passes, self.count) != (plain.photons, plain.passes, plain.count);
        let solved = (self.show, &self.solution) != (plain.show, &plain.solution);
        let memory = self.solver_memory != plain.solver_memory;
        use Solver::{Local, March, Path, Photon, Radiosity, Zonal};
        let strangers: [(bool, &[Solver], &str); 9] = [
            (path, &[Path], "--max-bounces, --split and --no-pool go with --method path"),
            (local, &[Local], "--ambient, --no-shadows and --no-reflections go with --method local"),
            (radiosity, &[Radiosity], "--mesh-error and --divide go with --method radiosity"),
            (rays, &[Radiosity, Zonal], "--element-rays goes with --method radiosity or zonal"),
            (march, &[March, Zonal, Photon], "--step goes with --method march, zonal or photon"),
            (zonal, &[Zonal], "--zones goes with --method zonal"),
            (memory, &[Radiosity, Photon, Zonal], "--solver-memory goes with --method radiosity, photon or zonal"),
            (photon, &[Photon], "--photons, --passes and --count go with --method photon"),
            (solved, &[Radiosity, Photon], "--show and --solution go with --method radiosity or photon"),
        ];
        if let Some((.., message)) = strangers.iter().find(|(given, of, _)| *given && !of.contains(&self.method)) {
            return usage!("{message}");
        }
        Ok(match self.method {
            Solver::Path => {
                let max_bounces = self.max_bounces.unwrap_or(u32::MAX).min(scene.max_bounces.unwrap_or(u32::MAX));
                Choice::Path(path::Options { max_bounces, split: self.split, pool: !self.no_pool })
            }
            Solver::Local => {
                let (shadows, reflections) = (!self.no_shadows, !self.no_reflections);
                Choice::Local(local::Options { ambient: self.ambient, shadows, reflections })
            }
            Solver::Radiosity => Choice::Radiosity(self.radiosity()?),
            Solver::Photon => Choice::Photon(self.photon()?),
            Solver::March | Solver::Zonal => Choice::March(self.march()?),
        })
    }

    /// Effects that only path tracing has.
    fn note_left_out(&self, scene: &Scene, run: &Run) -> Result<()> {
        if self.method == Solver::Path {
            return Ok(());
        }
        let method = format!("{:?}", self.method).to_lowercase();
        if self.quantity == Quantity::Stokes {
            return usage!("--output stokes goes with --method path; {method} knows nothing of polarization");
        }
        if self.method == Solver::Radiosity && scene.materials.iter().any(|m| m.is_void()) {
            return usage!("--method radiosity stops light at the boundaries of media; take --method zonal");
        }
        let photon = self.method == Solver::Photon;
        let marched = matches!(self.method, Solver::March | Solver::Zonal);
        let media = photon || marched;
        let out = [
            (scene.polarised, "polarization"),
            (scene.effects.disperses && !photon, "dispersion"),
            (scene.media.scatter() && !media, "scattering in media"),
            (scene.media.glow() && !marched, "light that media give off"),
            (scene.effects.subsurface, "light that leaves bodies elsewhere than where it went in"),
            (scene.effects.disperses && photon, "dispersion of what the eye sees through a body"),
            (scene.fluoresces() && photon, "light that photons would have at other wavelengths"),
        ];
        for (_, what) in out.iter().filter(|o| o.0) {
            run.notes.add(format!("{what} is left out by --method {method}; path has it"));
        }
        Ok(())
    }

    fn radiosity(&self) -> Result<radiosity::Options> {
        if !(self.mesh_error >= 1e-4 && self.mesh_error < 1.0) {
            return usage!("--mesh-error {}: a relative error from 0.0001 to 1, such as 0.01", self.mesh_error);
        }
        if let Some(n) = self.divide.filter(|n| !(1..=4096).contains(n)) {
            return usage!("--divide {n}: 1 to 4096 elements");
        }
        if !(1..=MOST_RAYS).contains(&self.element_rays) {
            return usage!("--element-rays {}: 1 to {MOST_RAYS}", self.element_rays);
        }
        Ok(radiosity::Options {
            divide: self.divide,
            tolerance: self.mesh_error,
            rays: self.element_rays,
            show: match self.show {
                Shown::Mesh => radiosity::Show::Mesh,
                Shown::Direct => radiosity::Show::Direct,
                Shown::Gather => radiosity::Show::Gather,
            },
            memory: self.solver_memory.saturating_mul(1 << 20),
            solution: self.solution.clone(),
            seed: self.seed,
        })
    }

    fn depth_of_steps(&self) -> Result<f32> {
        match self.step {
            step if (1e-3..=10.0).contains(&step) => Ok(step as f32),
            step => usage!("--step {step}: an optical depth of 0.001 to 10"),
        }
    }

    fn march(&self) -> Result<march::Options> {
        let step = self.depth_of_steps()?;
        if !(1..=64).contains(&self.zones) || !(1..=MOST_RAYS).contains(&self.element_rays) {
            return usage!(
                "--zones {} --element-rays {}: 1 to 64 cubes, 1 to {MOST_RAYS} rays",
                self.zones,
                self.element_rays
            );
        }
        let zonal = march::solve::Options {
            along: self.zones,
            rays: self.element_rays,
            memory: self.solver_memory.saturating_mul(1 << 20),
        };
        Ok(march::Options { step, zonal: (self.method == Solver::Zonal).then_some(zonal) })
    }

    fn photon(&self) -> Result<photon::Options> {
        if !(1..=1 << 30).contains(&self.photons) || !(1..=1024).contains(&self.passes) {
            return usage!(
                "--photons {} --passes {}: 1 to 1073741824 photons, 1 to 1024 maps",
                self.photons,
                self.passes
            );
        }
        if !(8..=100_000).contains(&self.count) {
            return usage!("--count {}: 8 to 100000 photons", self.count);
        }
        if self.show == Shown::Mesh {
            return usage!("--show mesh goes with --method radiosity");
        }
        if self.error.is_some() {
            return usage!(
                "--error sees the noise of paths, not that of photons, which all pixels share; take --samples"
            );
        }
        Ok(photon::Options {
            photons: self.photons,
            passes: self.passes,
            count: self.count,
            gather_once: self.show == Shown::Gather,
            step: self.depth_of_steps()?,
            seed: self.seed,
            memory: self.solver_memory.saturating_mul(1 << 20),
            solution: self.solution.clone(),
        })
    }
}
