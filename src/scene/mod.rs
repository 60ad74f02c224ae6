//! Scenes: what is there, what it is made of, what shines, who looks. Spectra stay spectra here; a renderer samples them.

pub mod camera;
pub mod geometry;
pub mod light;
pub mod load;
pub mod mesh;
pub mod palette;
pub mod ray;
pub mod transform;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3A};

use crate::Result;
use crate::color::Xy;
use crate::material::{Effects, Ink, Material, Site};
use crate::medium::{Inside, Media};
use crate::spectral::{Observer, Spectrum};
use crate::statistics::fnv1a;
use crate::units::K_M;

pub use camera::Camera;
pub use geometry::{Geometry, Hit};
use light::Lamp;
use light::tree::LightTree;

/// A scene, lengths in metres.
pub struct Scene {
    /// Who looks, if anyone.
    pub camera: Option<Camera>,
    /// Materials, in the order of their names.
    pub materials: Vec<Arc<dyn Material>>,
    /// Which of them need to know the place: texture coordinates, smooth normals.
    pub looks_at_site: Vec<bool>,
    /// Any of them can be looked through.
    pub clear: bool,
    /// What any of them needs beside lobes.
    pub effects: Effects,
    /// What fills bodies and space.
    pub media: Media,
    /// Lamps or surfaces that mean nothing without polarization, or the file asks for it.
    pub polarised: bool,
    /// Spectra that materials refer to by number.
    pub inks: Vec<Ink>,
    /// Basis of RGB colours.
    pub srgb: [Spectrum; 3],
    /// Light spectra, in the order of their names.
    pub lights: Vec<Light>,
    /// All surfaces.
    pub geometry: Geometry,
    /// Whatever shines.
    pub lamps: Vec<Lamp>,
    /// Which of them to look at.
    pub tree: LightTree,
    /// Where the geometry's numbers come from.
    pub frame: Frame,
    /// What was noticed while the scene was read, a line each.
    pub remarks: Vec<String>,
    /// Metres in one of the scene file's lengths.
    pub unit_m: f64,
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

    /// The same as a map.
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(self.scale)) * DAffine3::from_translation(-self.centre)
    }

    /// A length in metres as the geometry has it.
    pub fn units(&self, metres: f32) -> f32 {
        (f64::from(metres) * self.scale) as f32
    }

    /// A length of the geometry in metres.
    pub fn length_m(&self, units: f32) -> f32 {
        (f64::from(units) / self.scale) as f32
    }

    /// And back.
    pub fn metres(&self, place: DVec3) -> DVec3 {
        place / self.scale + self.centre
    }
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
    /// What a material may ask of a hit, and the shading normal on the front side.
    #[inline]
    pub fn site(&self, hit: &Hit, front: bool) -> (Site, Vec3A) {
        if !self.looks_at_site[hit.surface.material as usize] {
            return (Site { front, ..Site::default() }, hit.normal);
        }
        let shading = self.geometry.shading(hit);
        let place = self.frame.metres(hit.point.as_dvec3());
        (Site { place, uv: shading.uv, colour: shading.colour, front }, shading.normal)
    }

    /// The bodies that a place is in: those that a ray from there leaves before it enters them.
    pub fn inside(&self, point: Vec3A) -> Inside {
        // So many surfaces at most; rays that begin on a surface may meet it again and again.
        const MOST: usize = 256;
        let mut bodies = Vec::new();
        if !self.effects.fills {
            return Inside::default();
        }
        // No direction that surfaces are built along.
        let direction = Vec3A::new(0.336, 0.478, 0.8115).normalize();
        let (mut origin, mut entered) = (point, Inside::default());
        for _ in 0..MOST {
            let Some(hit) = self.geometry.closest(origin, direction) else { break };
            let leaves = hit.normal.dot(direction) > 0.0;
            if let Some(medium) = self.materials[hit.surface.material as usize].interior() {
                match (leaves, entered.holds(medium)) {
                    (false, _) => entered = entered.entered(medium),
                    (true, true) => entered = entered.left(medium),
                    (true, false) => bodies.push(medium),
                }
            }
            origin = ray::offset(hit.point, if leaves { hit.normal } else { -hit.normal }, hit.reach);
        }
        // The innermost is left first.
        bodies.into_iter().rev().fold(Inside::default(), Inside::entered)
    }

    /// A way's light changes between surfaces: bodies or space are filled.
    pub fn is_filled(&self) -> bool {
        self.effects.fills || self.media.everywhere.is_some()
    }

    /// Stands for a scene's lights and the extent of its surfaces, however it is seen and whatever these are made of.
    pub fn fingerprint(&self) -> u64 {
        let text = format!("{:?} {:?} {} {}", self.lights, self.frame, self.geometry.len(), self.lamps.len());
        fnv1a(text.as_bytes())
    }

    /// Light changes its wavelength on some surface.
    pub fn fluoresces(&self) -> bool {
        self.inks.iter().any(|i| matches!(i, Ink::Reradiation { .. }))
    }

    /// A point that is meant to lie on a surface, moved off it to the side of its normal; one that lies on none stays where it
    /// is.
    pub fn lifted(&self, point: Vec3A, normal: Vec3A) -> Vec3A {
        // As far as text of six digits may be off.
        let near = normal * (4e-6 * point.abs().max_element().max(0.25));
        let towards = |from: Vec3A, to: Vec3A| self.geometry.closest(from, to - from).filter(|h| h.t <= 1.0);
        let hit = towards(point + near, point - near).or_else(|| towards(point - near, point + near));
        hit.map_or(point, |h| ray::offset(h.point, normal, h.reach))
    }

    /// Chromaticity of the light that emits the most luminous flux: the picture's white. `None` without visible light.
    pub fn white(&self) -> Result<Option<Xy>> {
        Ok(self.dominant()?.map(|d| d.1))
    }

    /// Which light emits the most luminous flux, and its chromaticity. `None` without visible light.
    pub fn dominant(&self) -> Result<Option<(usize, Xy)>> {
        self.dominant_dimmed(&vec![1.0; self.lights.len()])
    }

    /// The same where each light is dimmed by a factor.
    pub fn dominant_dimmed(&self, factors: &[f64]) -> Result<Option<(usize, Xy)>> {
        let observer = Observer::cie1931()?;
        let flux = |i: usize| {
            let extent = self.lamps.iter().map(|l| self.extent(l, i)).sum::<f64>();
            observer.integrate(&self.lights[i].radiance).map(|x| factors[i] * x * extent)
        };
        let mut best: Option<(f64, (usize, Xy))> = None;
        let mut i = 0;
        while i < self.lights.len() {
            // A sky or panorama of several spectra is one light.
            let parts = self.lamps.iter().find_map(|lamp| match lamp {
                Lamp::Environment(e) if e.light as usize == i => Some(e.surround.parts()),
                _ => None,
            });
            let group = i..i + parts.unwrap_or(1).max(1);
            i = group.end;
            let strongest = group.clone().max_by(|a, b| flux(*a)[1].total_cmp(&flux(*b)[1]));
            let sum = group.map(flux).fold([0.0; 3], |s, x| [0, 1, 2].map(|c| s[c] + x[c]));
            if let (Some(light), Some(xy)) = (strongest, Xy::of(sum))
                && best.is_none_or(|b| sum[1] > b.0)
            {
                best = Some((sum[1], (light, xy)));
            }
        }
        Ok(best.filter(|b| b.0 > 0.0).map(|b| b.1))
    }

    /// Illuminance in lx of a horizontal surface in the open, by the sky alone; `None` where there is other light, by which a
    /// daylight factor would mean nothing.
    pub fn daylight_lux(&self) -> Result<Option<f64>> {
        let observer = Observer::cie1931()?;
        let mut lux = 0.0;
        for lamp in &self.lamps {
            let Lamp::Environment(e) = lamp else { return Ok(None) };
            let first = e.light as usize;
            for (light, sr) in self.lights[first..first + e.surround.parts()].iter().zip(e.horizontal_sr()) {
                lux += K_M * observer.integrate(&light.radiance)[1] * sr;
            }
        }
        Ok(Some(lux).filter(|l| *l > 0.0))
    }

    /// What a lamp's radiance times this gives its flux by, as far as it is of light `i`; beyond the scene, the flux through
    /// it.
    fn extent(&self, lamp: &Lamp, i: usize) -> f64 {
        use std::f64::consts::PI;
        // The scene is about a unit sphere in its frame.
        match lamp {
            Lamp::Area(e) if e.light == i => e.etendue_sr() * e.area_m2(),
            Lamp::Point(p) if p.light as usize == i => {
                p.distribution.integral_sr() * self.frame.scale * self.frame.scale
            }
            Lamp::Sun(s) if s.light() == i => PI * s.solid_angle_sr(),
            Lamp::Environment(e) if (e.light as usize..e.light as usize + e.surround.parts()).contains(&i) => {
                PI * e.surround.integrals_sr()[i - e.light as usize]
            }
            _ => 0.0,
        }
    }
}
