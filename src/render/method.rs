//! Ways to solve Eq. (1) and (2), one file each, behind one interface: a method follows light from where it is asked for, and notes
//! on a trail what came of each lamp and what tinted it. Wavelengths, films, pixels and errors are the same for all.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::Ink;
use crate::notes::Notes;
use crate::render::comb::Comb;
use crate::render::inks::Outline;
use crate::render::local::{self, Local};
use crate::render::march::{self, March};
use crate::render::path::{self, PathTracing};
use crate::render::photon::{self, PhotonMap};
use crate::render::pool::Pool;
use crate::render::radiosity::{self, Radiosity};
use crate::render::sampler::Sampler;
use crate::render::stored::{NOTHING, Stored};
use crate::render::trail::Trail;
use crate::render::wavelengths::Wavelengths;
use crate::scene::Scene;

/// A method on one scene.
pub trait Method: Send + Sync {
    /// Notes what comes along a ray, of unit direction: radiance.
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail);

    /// Pools what the paths of neighbouring pixels find.
    fn pools(&self) -> bool {
        false
    }

    /// The same as [`Method::radiance`] for a member of a pool that has just entered it.
    fn pooled(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail, _pool: &mut Pool) {
        self.radiance(origin, direction, sampler, trail);
    }

    /// Notes what falls on a point: irradiance over pi, as a white matt surface would show it.
    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail);

    /// Spectra of its own that trails refer to, numbered after the scene's.
    fn inks(&self) -> &[Ink] {
        &[]
    }

    /// Light worked out before, which trails refer to by rows.
    fn stored(&self) -> &Stored {
        &NOTHING
    }

    /// Says at the end how well it did, and what it left out.
    fn report(&self, notes: &Notes);
}

/// A method and what is asked of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// Path tracing.
    Path(path::Options),
    /// Local illumination.
    Local(local::Options),
    /// Radiosity.
    Radiosity(radiosity::Options),
    /// Photon map.
    Photon(photon::Options),
    /// Marching through media, with zones or without.
    March(march::Options),
}

impl Choice {
    /// Makes the method ready for a scene, of which wavelengths in `range_nm` count. Where they go their own ways those of the picture
    /// say which; whether their polarization counts is path tracing's.
    pub fn on(
        &self,
        scene: Arc<Scene>,
        outline: Outline,
        range_nm: (f64, f64),
        (comb, polarised): (Comb, bool),
        wavelengths: &dyn Wavelengths,
    ) -> Result<Box<dyn Method>> {
        Ok(match self {
            Choice::Path(options) => Box::new(PathTracing::new(scene, outline, *options, comb, polarised)),
            Choice::Local(options) => Box::new(Local::new(scene, *options, range_nm)?),
            Choice::Photon(options) => Box::new(PhotonMap::new(scene, outline, options, &comb, wavelengths)?),
            Choice::March(options) => Box::new(March::new(scene, &outline, options, wavelengths)?),
            Choice::Radiosity(options) => Box::new(Radiosity::new(scene, options, wavelengths)?),
        })
    }
}
