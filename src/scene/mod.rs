//! Scenes: what is there, what it is made of, what shines, who looks. Spectra stay spectra here; a renderer samples them.

pub mod bvh;
pub mod camera;
pub mod emitter;
pub mod load;
pub mod mesh;
pub mod palette;
pub mod ray;
pub mod spectrum_key;
pub mod texture;
pub mod transform;

use glam::DVec3;

use crate::Result;
use crate::color::Xy;
use crate::spectral::{Observer, Spectrum};

pub use bvh::{Geometry, Hit};
pub use camera::Camera;
pub use emitter::Emitter;

/// A scene, lengths in metres.
pub struct Scene {
    /// Who looks.
    pub camera: Camera,
    /// Materials, in the order of their names.
    pub materials: Vec<Material>,
    /// Light spectra, in the order of their names.
    pub lights: Vec<Light>,
    /// All surfaces.
    pub geometry: Geometry,
    /// Surfaces that shine, each with its light.
    pub emitters: Vec<Emitter>,
    /// Where the geometry's numbers come from.
    pub frame: Frame,
    /// Most bounces that the scene file asks for.
    pub max_bounces: Option<u32>,
}

/// Rays are traced in numbers near 1, where floats are finest: (place - centre) x scale, place in metres. Radiance does not
/// know the difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Middle of the scene, m.
    pub centre: DVec3,
    /// Units a metre.
    pub scale: f64,
}

impl Frame {
    /// A place in metres as the geometry has it.
    pub fn place(&self, metres: DVec3) -> DVec3 {
        (metres - self.centre) * self.scale
    }
}

/// A diffuse surface.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene file.
    pub name: String,
    /// Reflectance 0..1.
    pub reflectance: Spectrum,
    /// Both sides reflect; otherwise the back is black.
    pub two_sided: bool,
}

/// Light that one or more surfaces give off, the same in every direction of the front.
#[derive(Clone, Debug)]
pub struct Light {
    /// Name in the scene file.
    pub name: String,
    /// Spectral radiance, W/sr/m2/nm.
    pub radiance: Spectrum,
}

impl Scene {
    /// Chromaticity of the light that emits the most luminous flux: the picture's white. `None` without visible light.
    pub fn white(&self) -> Result<Option<Xy>> {
        let observer = Observer::cie1931()?;
        let mut best: Option<(f64, Xy)> = None;
        for (i, light) in self.lights.iter().enumerate() {
            let xyz = observer.integrate(&light.radiance);
            let area: f64 = self.emitters.iter().filter(|e| e.light == i).map(Emitter::area_m2).sum();
            let flux = xyz[1] * area;
            if let Some(xy) = Xy::of(xyz).filter(|_| best.is_none_or(|b| flux > b.0)) {
                best = Some((flux, xy));
            }
        }
        Ok(best.filter(|b| b.0 > 0.0).map(|b| b.1))
    }
}
