//! What elements are made of: what they send back of the light that falls on them.

use std::collections::HashMap;

use glam::Vec3A;
use rayon::prelude::*;

use crate::material::{Lobes, Tint, kernel::lambert};
use crate::render::meeting::Meeting;
use crate::render::radiosity::mesh::{Element, Mesh};
use crate::render::radiosity::prepare::Workshop;
use crate::render::sampler::Sampler;
use crate::render::shade::{self, Pairs};
use crate::render::stored::Stored;
use crate::render::trail::Trail;
use crate::scene::ray;

/// What an element fluoresces by, if it does: number of the ink, and the share of the area that it has.
pub type Dye = Option<(u32, f32)>;

impl Workshop<'_> {
    /// Mean reflectance of each element for light from everywhere to everywhere.
    pub fn reflectances(&self, mesh: &Mesh) -> Vec<f32> {
        let lanes = self.wavelengths.lanes();
        let mut uniform: HashMap<(u32, bool), Vec<f32>> = HashMap::new();
        for (i, tile) in mesh.tiles().iter().enumerate() {
            let material = tile.patch.surface.material;
            for front in [true, false] {
                if mesh.is_awake(i, front) && !self.scene.looks_at_site[material as usize] {
                    uniform.entry((material, front)).or_insert_with(|| {
                        let number = mesh.elements(i, front).start;
                        self.reflectance(&mesh.element(number).1, number)
                    });
                }
            }
        }
        let mut all = vec![0f32; mesh.len() * lanes];
        all.par_chunks_mut(lanes).enumerate().for_each(|(number, row)| {
            let (_, element) = mesh.element(number as u32);
            match uniform.get(&(element.tile.patch.surface.material, element.front)) {
                Some(known) => row.copy_from_slice(known),
                None => row.copy_from_slice(&self.reflectance(&element, number as u32)),
            }
        });
        all
    }

    /// Of one element: all that its lobes send back.
    fn reflectance(&self, element: &Element, number: u32) -> Vec<f32> {
        const PLACES: u32 = 64;
        let mut trail = Trail::default();
        trail.fork();
        for i in 0..PLACES {
            let sampler = Sampler::new(number, 0x7ed5_5d16, i, self.options.seed);
            let hit = element.tile.patch.hit(element.square(sampler.pair(0)));
            let away = lambert::cosine(sampler.pair(1));
            let (site, shading) = self.scene.site(&hit, element.front);
            let axis = if element.front { shading } else { -shading };
            let (s, t) = ray::frame(axis);
            let out = (s * away.x + t * away.y + axis * away.z.max(1e-3)).normalize();
            let at = Meeting::new(&hit, element.front, shading, -out);
            let mut lobes = Lobes::default();
            self.scene.materials[hit.surface.material as usize].lobes(&site, at.out, &mut lobes);
            shade::note_sent(&lobes, at.out, &mut Pairs::new(&sampler, 2), &mut trail);
        }
        let mut sums = vec![0f32; self.wavelengths.lanes()];
        self.wavelengths.gather(&trail, &Stored::default(), 1.0 / PLACES as f32, &mut sums);
        sums
    }

    /// The fluorescent surfaces among elements.
    pub fn dyes(&self, mesh: &Mesh) -> Vec<Dye> {
        let dye = |number: usize| {
            let (_, element) = mesh.element(number as u32);
            let hit = element.tile.patch.hit([0.5, 0.5]);
            let (site, _) = self.scene.site(&hit, element.front);
            let mut lobes = Lobes::default();
            self.scene.materials[hit.surface.material as usize].lobes(&site, Vec3A::Z, &mut lobes);
            lobes.iter().find_map(|l| if let Tint::Fluorescent(ink) = l.tint { Some((ink, l.factor)) } else { None })
        };
        (0..mesh.len()).map(dye).collect()
    }

    /// Share of the area that is not only matt.
    pub fn glossy(&self, mesh: &Mesh) -> f64 {
        let (mut some, mut all) = (0.0, 0.0);
        for (i, tile) in mesh.tiles().iter().enumerate() {
            if !(mesh.is_awake(i, true) || mesh.is_awake(i, false)) {
                continue;
            }
            let area = tile.area;
            all += area;
            let hit = tile.patch.hit([0.3, 0.3]);
            let shiny = [true, false].into_iter().filter(|front| mesh.is_awake(i, *front)).any(|front| {
                let (site, _) = self.scene.site(&hit, front);
                let mut lobes = Lobes::default();
                let out = Vec3A::new(0.3, 0.2, 0.9).normalize();
                self.scene.materials[hit.surface.material as usize].lobes(&site, out, &mut lobes);
                lobes.iter().any(|l| !l.kernel.is_matt() || l.kernel.transmits())
            });
            some += if shiny { area } else { 0.0 };
        }
        if all > 0.0 { some / all } else { 0.0 }
    }
}
