//! `[[shape]]`: surfaces in metres, then in the geometry's numbers.

use std::path::Path;

use glam::DVec3;

use crate::Result;
use crate::keys::Keys;
use crate::scene::geometry::{Primitive, Surface};
use crate::scene::light::area::{Emitter, Shape};
use crate::scene::load::{Names, look_up, point};
use crate::scene::{Frame, mesh};

/// Everything that grows while shapes are read.
#[derive(Default)]
pub(super) struct Shapes {
    /// In metres.
    pub(super) solids: Vec<Solid>,
    pub(super) surfaces: Vec<Surface>,
    /// In metres.
    pub(super) emitters: Vec<Emitter>,
}

/// A surface in metres, before it gets the geometry's numbers.
pub(super) enum Solid {
    Triangle([DVec3; 3]),
    Sphere { center: DVec3, radius: f64, inward: bool },
}

impl Solid {
    fn middle(&self) -> DVec3 {
        match self {
            Solid::Triangle([a, b, c]) => (*a + *b + *c) / 3.0,
            Solid::Sphere { center, .. } => *center,
        }
    }

    /// Largest distance of its surface from a point.
    fn reach(&self, from: DVec3) -> f64 {
        match self {
            Solid::Triangle(t) => t.iter().map(|p| p.distance(from)).fold(0.0, f64::max),
            Solid::Sphere { center, radius, .. } => center.distance(from) + radius,
        }
    }

    pub(super) fn placed(&self, frame: &Frame) -> Primitive {
        match self {
            Solid::Triangle(t) => Primitive::Triangle(t.map(|p| frame.place(p).as_vec3a())),
            Solid::Sphere { center, radius, inward } => Primitive::Sphere {
                center: frame.place(*center).as_vec3a(),
                radius: (radius * frame.scale) as f32,
                inward: *inward,
            },
        }
    }
}

/// The frame about the middle of most surfaces, on the scale of half of them: a far sun or a wide ground plane does not
/// rob the rest of its digits.
pub(super) fn frame(solids: &[Solid]) -> Frame {
    let median = |mut values: Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    if solids.is_empty() {
        return Frame { centre: DVec3::ZERO, scale: 1.0 };
    }
    let axis = |f: fn(DVec3) -> f64| median(solids.iter().map(|s| f(s.middle())).collect());
    let centre = DVec3::new(axis(|p| p.x), axis(|p| p.y), axis(|p| p.z));
    let reach = median(solids.iter().map(|s| s.reach(centre)).collect());
    Frame { centre, scale: if reach > 0.0 { 1.0 / reach } else { 1.0 } }
}

pub(super) fn placed_emitter(e: &Emitter, frame: &Frame) -> Emitter {
    let shape = match &e.shape {
        Shape::Rectangle { corner, u, v } => {
            Shape::Rectangle { corner: frame.place(*corner), u: *u * frame.scale, v: *v * frame.scale }
        }
        Shape::Triangle(t) => Shape::Triangle(t.map(|p| frame.place(p))),
        Shape::Sphere { center, radius, inward } => {
            Shape::Sphere { center: frame.place(*center), radius: radius * frame.scale, inward: *inward }
        }
        Shape::Disk { center, normal, radius } => {
            Shape::Disk { center: frame.place(*center), normal: *normal, radius: radius * frame.scale }
        }
        Shape::Cylinder { base, axis, radius, inward } => Shape::Cylinder {
            base: frame.place(*base),
            axis: *axis * frame.scale,
            radius: radius * frame.scale,
            inward: *inward,
        },
    };
    Emitter { light: e.light, shape }
}

/// Reads one shape.
pub(super) fn read(mut k: Keys, metres: f64, folder: &Path, names: &Names, shapes: &mut Shapes) -> Result<()> {
    let Some((kind, span)) = k.get_spanned::<String>("type")? else { return Err(k.wrong("key 'type' is missing")) };
    let material = look_up(&mut k, "material", &names.materials)?;
    let material = material.ok_or_else(|| k.wrong("key 'material' is missing"))? as u32;
    let light = look_up(&mut k, "light", &names.lights)?;
    k.get::<String>("name")?;
    let mut add = Adder { shapes, material, light };
    match kind.as_str() {
        "quad" => {
            let (points, span) =
                k.get_spanned::<[[f64; 3]; 4]>("points")?.ok_or_else(|| k.wrong("key 'points' is missing"))?;
            let p = points.map(|p| DVec3::from(p) * metres);
            add.quad(p).map_err(|e| k.wrong_key("points", span, &e))?;
        }
        "box" => {
            let (a, b) = (point(&mut k, "min")? * metres, point(&mut k, "max")? * metres);
            add.cuboid(a, b).map_err(|e| k.wrong(&e))?;
        }
        "sphere" => {
            let center = point(&mut k, "center")? * metres;
            let positive = |x: f64| x > 0.0 && x < 1e9;
            let radius =
                k.number("radius", "must be above 0", positive)?.ok_or_else(|| k.wrong("key 'radius' is missing"))?;
            let inward = k.get("inward")?.unwrap_or(false);
            add.sphere(center, radius * metres, inward);
        }
        "mesh" => {
            let (file, span) = k.get_spanned::<String>("file")?.ok_or_else(|| k.wrong("key 'file' is missing"))?;
            let scale = k.number("scale", "must be above 0", |x| x > 0.0 && x < 1e9)?.unwrap_or(1.0);
            let shift = DVec3::from(k.get::<[f64; 3]>("translate")?.unwrap_or_default());
            let mesh =
                mesh::load(&folder.join(&file)).map_err(|e| k.wrong_key("file", span.clone(), &e.to_string()))?;
            let place = |p: [f32; 3]| (DVec3::from(p.map(f64::from)) * scale + shift) * metres;
            // Scans and CAD have triangles without area: nothing can be seen of them, or shine.
            let whole =
                mesh.triangles.iter().filter(|t| add.triangle(t.map(|v| place(mesh.positions[v as usize]))).is_ok());
            if whole.count() == 0 {
                return Err(k.wrong_key("file", span, "no face has an area"));
            }
        }
        other => {
            let other = crate::error::printable(other.as_bytes());
            return Err(k.wrong_key("type", span, &format!("no shape '{other}'; there are quad, box, sphere, mesh")));
        }
    }
    k.finish()
}

/// Adds surfaces that share a material and a light.
struct Adder<'a> {
    shapes: &'a mut Shapes,
    material: u32,
    light: Option<usize>,
}

impl Adder<'_> {
    fn emitter(&mut self, shape: Shape) -> Option<u32> {
        let light = self.light?;
        self.shapes.emitters.push(Emitter { light, shape });
        Some(self.shapes.emitters.len() as u32 - 1)
    }

    fn push(&mut self, solid: Solid, emitter: Option<u32>) {
        self.shapes.solids.push(solid);
        self.shapes.surfaces.push(Surface { material: self.material, emitter });
    }

    fn triangle(&mut self, p: [DVec3; 3]) -> Result<(), String> {
        check_triangle(p)?;
        let emitter = self.emitter(Shape::Triangle(p));
        self.push(Solid::Triangle(p), emitter);
        Ok(())
    }

    /// Triangles 0 1 2 and 0 2 3; a rectangle shines as one.
    fn quad(&mut self, p: [DVec3; 4]) -> Result<(), String> {
        let (u, v) = (p[1] - p[0], p[3] - p[0]);
        let size = u.length() + v.length();
        let turn = |a: usize, b: usize, c: usize| (p[b] - p[a]).cross(p[c] - p[b]);
        let first = turn(0, 1, 2);
        if [turn(1, 2, 3), turn(2, 3, 0), turn(3, 0, 1)].iter().any(|t| t.dot(first) < 0.0) {
            return Err("the corners do not go round a convex quad".into());
        }
        let rectangle = (p[2] - (p[0] + u + v)).length() < 1e-6 * size && u.dot(v).abs() < 1e-6 * size * size;
        if !rectangle {
            return self.triangle([p[0], p[1], p[2]]).and_then(|()| self.triangle([p[0], p[2], p[3]]));
        }
        check_triangle([p[0], p[1], p[2]])?;
        let emitter = self.emitter(Shape::Rectangle { corner: p[0], u, v });
        for t in [[p[0], p[1], p[2]], [p[0], p[2], p[3]]] {
            self.push(Solid::Triangle(t), emitter);
        }
        Ok(())
    }

    fn sphere(&mut self, center: DVec3, radius: f64, inward: bool) {
        let emitter = self.emitter(Shape::Sphere { center, radius, inward });
        self.push(Solid::Sphere { center, radius, inward }, emitter);
    }

    /// Six rectangles that face outward.
    fn cuboid(&mut self, a: DVec3, b: DVec3) -> Result<(), String> {
        if !(b - a).cmpgt(DVec3::ZERO).all() {
            return Err("max must be above min in every coordinate".into());
        }
        let at = |x: usize, y: usize, z: usize| DVec3::new([a.x, b.x][x], [a.y, b.y][y], [a.z, b.z][z]);
        let faces = [
            [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
            [at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)],
            [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
            [at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)],
            [at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)],
            [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
        ];
        faces.into_iter().try_for_each(|f| self.quad(f))
    }
}

fn check_triangle(p: [DVec3; 3]) -> Result<(), String> {
    if p.iter().any(|p| !p.is_finite() || p.abs().max_element() >= 1e9) {
        return Err("a corner is not finite or beyond 1e9 m".into());
    }
    let (u, v) = (p[1] - p[0], p[2] - p[0]);
    // Thinner than floats can tell from a line.
    if u.cross(v).length() > 1e-7 * u.length() * v.length() {
        Ok(())
    } else {
        Err("three corners lie on one line".into())
    }
}
