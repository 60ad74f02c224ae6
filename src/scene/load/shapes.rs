//! `[[shape]]` and `[[group]]`: surfaces in metres, then in the geometry's numbers.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DVec3};

use crate::Result;
use crate::keys::Keys;
use crate::scene::geometry::{Attributes, Geometry, Group, Parts, Placement, Surface};
use crate::scene::light::area::{Emitter, Shape};
use crate::scene::load::{Names, look_up, point};
use crate::scene::mesh::{self, Mesh};
use crate::scene::transform::Transform;
use crate::scene::{Frame, load::solid};

use solid::Solid;

/// Everything that grows while shapes are read, in metres.
#[derive(Default)]
pub(super) struct Shapes {
    pub(super) solids: Vec<Solid>,
    pub(super) emitters: Vec<Emitter>,
}

/// Shapes that are placed together, many times.
pub(super) struct GroupShapes {
    name: String,
    shapes: Shapes,
    frame: Frame,
}

/// Reads `[[group]]`, each with `name` and its own `[[group.shape]]`.
pub(super) fn read_groups(keys: &mut Keys, metres: f64, folder: &Path, names: &Names) -> Result<Vec<GroupShapes>> {
    let mut groups: Vec<GroupShapes> = Vec::new();
    for mut k in keys.array("group")? {
        let name: String = k.need("name")?;
        if groups.iter().any(|g| g.name == name) {
            return Err(k.wrong("name: there is a group of that name already"));
        }
        let mut shapes = Shapes::default();
        for table in k.array("shape")? {
            read(table, metres, folder, names, &[], &mut shapes)?;
        }
        if shapes.solids.is_empty() || !shapes.emitters.is_empty() {
            return Err(k.wrong("a group needs shapes, and none of them may shine"));
        }
        k.finish()?;
        let frame = shapes.frame(&[]);
        groups.push(GroupShapes { name, shapes, frame });
    }
    Ok(groups)
}

/// Reads one shape.
pub(super) fn read(
    mut k: Keys,
    metres: f64,
    folder: &Path,
    names: &Names,
    groups: &[GroupShapes],
    shapes: &mut Shapes,
) -> Result<()> {
    let Some((kind, span)) = k.get_spanned::<String>("type")? else { return Err(k.wrong("key 'type' is missing")) };
    let material = look_up(&mut k, "material", &names.materials)?;
    k.get::<String>("name")?;
    if kind == "instance" {
        return read_instance(k, metres, groups, material, shapes);
    }
    let material = material.ok_or_else(|| k.wrong("key 'material' is missing"))? as u32;
    let light = look_up(&mut k, "light", &names.lights)?;
    let mut add = Adder { shapes, material, light };
    match kind.as_str() {
        "quad" => {
            let (points, span) =
                k.get_spanned::<[[f64; 3]; 4]>("points")?.ok_or_else(|| k.wrong("key 'points' is missing"))?;
            let p = points.map(|p| DVec3::from(p) * metres);
            add.quad(p).map_err(|e| k.wrong_key("points", span, &e))?;
        }
        "triangle" => {
            let (points, span) =
                k.get_spanned::<[[f64; 3]; 3]>("points")?.ok_or_else(|| k.wrong("key 'points' is missing"))?;
            add.triangle(points.map(|p| DVec3::from(p) * metres)).map_err(|e| k.wrong_key("points", span, &e))?;
        }
        "box" => {
            let (a, b) = (point(&mut k, "min")? * metres, point(&mut k, "max")? * metres);
            add.cuboid(a, b).map_err(|e| k.wrong(&e))?;
        }
        "sphere" => {
            let center = point(&mut k, "center")? * metres;
            let radius = radius(&mut k, metres)?;
            let inward = k.get("inward")?.unwrap_or(false);
            add.solid(Shape::Sphere { center, radius, inward });
        }
        "disk" => {
            let center = point(&mut k, "center")? * metres;
            let normal = point(&mut k, "normal")?.normalize_or_zero();
            if normal == DVec3::ZERO {
                return Err(k.wrong("normal: has no length"));
            }
            let radius = radius(&mut k, metres)?;
            let inner = inner_radius(&mut k, metres, radius)?;
            add.solid(Shape::Disk { center, normal, radius, inner });
        }
        "cylinder" => {
            let (base, top) = (point(&mut k, "base")? * metres, point(&mut k, "top")? * metres);
            if base == top {
                return Err(k.wrong("base and top are one point"));
            }
            let radius = radius(&mut k, metres)?;
            let inward = k.get("inward")?.unwrap_or(false);
            add.solid(Shape::Cylinder { base, axis: top - base, radius, inward });
        }
        "cone" => {
            let cone = cone(&mut k, metres)?;
            add.solid(cone);
        }
        "polygon" => {
            let (points, span) =
                k.get_spanned::<Vec<[f64; 3]>>("points")?.ok_or_else(|| k.wrong("key 'points' is missing"))?;
            let points = points.into_iter().map(|p| DVec3::from(p) * metres).collect();
            add.polygon(points).map_err(|e| k.wrong_key("points", span, &e))?;
        }
        "mesh" => read_mesh(&mut k, metres, folder, names, &mut add)?,
        other => {
            let other = crate::error::printable(other.as_bytes());
            let message = format!(
                "no shape '{other}'; there are quad, triangle, polygon, box, sphere, disk, cylinder, cone, mesh, instance"
            );
            return Err(k.wrong_key("type", span, &message));
        }
    }
    k.finish()
}

fn radius(k: &mut Keys, metres: f64) -> Result<f64> {
    let positive = |x: f64| x > 0.0 && x < 1e9;
    let radius = k.number("radius", "must be above 0", positive)?;
    Ok(radius.ok_or_else(|| k.wrong("key 'radius' is missing"))? * metres)
}

/// The hole of a disk, which makes it a ring.
fn inner_radius(k: &mut Keys, metres: f64, radius: f64) -> Result<f64> {
    let inner = k.number("inner_radius", "must be from 0 to below radius", |x| x >= 0.0 && x * metres < radius)?;
    Ok(inner.unwrap_or(0.0) * metres)
}

/// A frustum: `radius` at its base, `top_radius` (0: it ends in a point) at its top.
fn cone(k: &mut Keys, metres: f64) -> Result<Shape> {
    let (base, top) = (point(k, "base")? * metres, point(k, "top")? * metres);
    if base == top {
        return Err(k.wrong("base and top are one point"));
    }
    let size = |x: f64| (0.0..1e9).contains(&x);
    let radius = k.number("radius", "must be from 0", size)?.ok_or_else(|| k.wrong("key 'radius' is missing"))?;
    let top_radius = k.number("top_radius", "must be from 0", size)?.unwrap_or(0.0);
    if radius + top_radius <= 0.0 {
        return Err(k.wrong("radius and top_radius: one must be above 0"));
    }
    let inward = k.get("inward")?.unwrap_or(false);
    Ok(Shape::Cone { base, axis: top - base, radii: [radius * metres, top_radius * metres], inward })
}

/// A uniform scale.
fn scaling(by: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(by))
}

fn read_instance(
    mut k: Keys,
    metres: f64,
    groups: &[GroupShapes],
    material: Option<usize>,
    shapes: &mut Shapes,
) -> Result<()> {
    let (name, span) = k.get_spanned::<String>("group")?.ok_or_else(|| k.wrong("key 'group' is missing"))?;
    let Some(group) = groups.iter().position(|g| g.name == name) else {
        let known: Vec<&str> = groups.iter().map(|g| g.name.as_str()).collect();
        return Err(k.wrong_key("group", span, &format!("there are {}", known.join(", "))));
    };
    let affine = Transform::read(&mut k)?.affine();
    let transform = scaling(metres) * affine * scaling(1.0 / metres);
    shapes.solids.push(Solid::Placed { group, transform, material: material.map(|m| m as u32) });
    k.finish()
}

fn read_mesh(k: &mut Keys, metres: f64, folder: &Path, names: &Names, add: &mut Adder) -> Result<()> {
    let of = k.get_spanned::<BTreeMap<String, String>>("materials")?;
    let mesh = mesh::shape::read(k, folder, metres)?;
    let mut materials = vec![add.material; mesh.groups.len()];
    if let Some((of, span)) = of {
        for (group, name) in &of {
            let found = names.materials.get(name).copied();
            let in_mesh = mesh.groups.iter().any(|g| g.name == *group);
            let (Some(index), true) = (found, in_mesh) else {
                return Err(k.wrong_key(
                    "materials",
                    span,
                    &format!("no group '{group}' in the mesh, or no material '{name}'"),
                ));
            };
            let hits = mesh.groups.iter().zip(&mut materials).filter(|(g, _)| g.name == *group);
            hits.for_each(|(_, m)| *m = index as u32);
        }
    }
    add.mesh(mesh, materials);
    Ok(())
}

/// Adds surfaces that share a material and a light.
struct Adder<'a> {
    shapes: &'a mut Shapes,
    material: u32,
    light: Option<usize>,
}

impl Adder<'_> {
    fn solid(&mut self, shape: Shape) {
        let emitter = self.light.map(|light| {
            self.shapes.emitters.push(Emitter::new(light, shape.clone()));
            self.shapes.emitters.len() as u32 - 1
        });
        self.shapes.solids.push(Solid::One { shape, surface: Surface { material: self.material, emitter } });
    }

    fn mesh(&mut self, mesh: Mesh, materials: Vec<u32>) {
        let first = self.light.map(|light| {
            let first = self.shapes.emitters.len() as u32;
            let shape = |t: &[u32; 3]| Shape::Triangle(t.map(|c| mesh.place(c)));
            self.shapes.emitters.extend(mesh.triangles.iter().map(|t| Emitter::new(light, shape(t))));
            first
        });
        self.shapes.solids.push(Solid::Mesh { mesh: Box::new(mesh), materials, emitter: first });
    }

    fn triangle(&mut self, p: [DVec3; 3]) -> Result<(), String> {
        check_triangle(p)?;
        self.solid(Shape::Triangle(p));
        Ok(())
    }

    /// A flat outline of three corners or more, bent as it likes; one with holes goes to them and back along one line.
    fn polygon(&mut self, points: Vec<DVec3>) -> Result<(), String> {
        let mut points = points;
        points.dedup();
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            return Err(format!("a polygon needs 3 corners or more, got {}", points.len()));
        }
        if points.iter().any(|p| !p.is_finite() || p.abs().max_element() >= 1e9) {
            return Err("a corner is not finite or beyond 1e9 m".into());
        }
        let triangles = mesh::polygon::cut(&points)?;
        if triangles.is_empty() {
            return Err("the corners enclose no area".into());
        }
        triangles.iter().try_for_each(|t| self.triangle(t.map(|i| points[i])))
    }

    /// A rectangle is one surface, another quad triangles 0 1 2 and 0 2 3.
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
        self.solid(Shape::Rectangle { corner: p[0], u, v });
        Ok(())
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

impl Shapes {
    /// The frame about the middle of most surfaces, on the scale of half of them: a far sun or a wide ground plane does not
    /// rob the rest of its digits.
    pub(super) fn frame(&self, groups: &[GroupShapes]) -> Frame {
        let mut boxes = Vec::new();
        for solid in &self.solids {
            solid.boxes(groups, &mut boxes);
        }
        if boxes.is_empty() {
            return Frame { centre: DVec3::ZERO, scale: 1.0 };
        }
        let middle = |b: &([DVec3; 2], f64)| (b.0[0] + b.0[1]) * 0.5;
        let axis = |f: fn(DVec3) -> f64| median(boxes.iter().map(|b| (f(middle(b)), b.1)).collect());
        let centre = DVec3::new(axis(|p| p.x), axis(|p| p.y), axis(|p| p.z));
        let farthest = |[low, high]: [DVec3; 2]| (low - centre).abs().max((high - centre).abs()).length();
        let reach = median(boxes.iter().map(|b| (farthest(b.0), b.1)).collect());
        Frame { centre, scale: if reach > 0.0 { 1.0 / reach } else { 1.0 } }
    }

    /// Emitters in the geometry's numbers.
    pub(super) fn placed_emitters(&self, frame: &Frame) -> Vec<Emitter> {
        self.emitters.iter().map(|e| Emitter::new(e.light, solid::placed(&e.shape, frame))).collect()
    }

    /// Some mesh has normals of its own.
    pub(super) fn is_smooth(&self, groups: &[GroupShapes]) -> bool {
        let all = groups.iter().flat_map(|g| &g.shapes.solids).chain(&self.solids);
        all.into_iter().any(|s| matches!(s, Solid::Mesh { mesh, .. } if mesh.normals.is_some()))
    }

    fn parts(self, frame: &Frame, groups: &[GroupShapes]) -> Result<(Parts, Vec<Placement>)> {
        let mut parts = Parts::default();
        let mut placements = Vec::new();
        for solid in self.solids {
            match solid {
                Solid::One { shape, surface } => parts.push(solid::primitive(&shape, frame), surface),
                Solid::Placed { group, transform, material } => {
                    let local = groups[group].frame;
                    let transform = frame.affine() * transform * local.affine().inverse();
                    placements.push(Placement { group: group as u32, transform, material });
                }
                Solid::Mesh { mesh, materials, emitter } => add_mesh(&mut parts, *mesh, &materials, emitter, frame)?,
            }
        }
        Ok((parts, placements))
    }

    /// Builds the trees.
    pub(super) fn geometry(self, groups: Vec<GroupShapes>, frame: &Frame) -> Result<Geometry> {
        let (parts, placements) = self.parts(frame, &groups)?;
        let build = |g: GroupShapes| Group::build(g.shapes.parts(&g.frame, &[])?.0);
        let groups = groups.into_iter().map(build).collect::<Result<_>>()?;
        Geometry::assemble(parts, groups, &placements)
    }
}

fn add_mesh(parts: &mut Parts, mesh: Mesh, materials: &[u32], emitter: Option<u32>, frame: &Frame) -> Result<()> {
    let points: Vec<_> = (0..mesh.positions.len() as u32).map(|c| frame.place(mesh.place(c)).as_vec3a()).collect();
    let first = parts.primitives.len();
    let surface = Surface { material: 0, emitter: None };
    let varies = mesh.normals.is_some() || mesh.uvs.is_some() || mesh.colours.is_some();
    let attributes = Attributes {
        corners: if varies { mesh.triangles.clone() } else { Vec::new() },
        normals: mesh.normals.unwrap_or_default(),
        uv: mesh.uvs.unwrap_or_default(),
        colours: mesh.colours.unwrap_or_default(),
    };
    parts.mesh(&points, &mesh.triangles, surface, attributes)?;
    for (group, material) in mesh.groups.iter().zip(materials) {
        for t in group.triangles.clone() {
            let emitter = emitter.map(|e| e + t as u32);
            parts.surfaces[first + t] = Surface { material: *material, emitter };
        }
    }
    Ok(())
}

/// The value that half of the weight lies below.
fn median(mut values: Vec<(f64, f64)>) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = values.iter().map(|v| v.1).sum::<f64>() / 2.0;
    let mut below = 0.0;
    for (value, weight) in &values {
        below += weight;
        if below > half {
            return *value;
        }
    }
    values.last().map_or(0.0, |v| v.0)
}

impl GroupShapes {
    /// Bounding box, m.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let mut boxes = Vec::new();
        self.shapes.solids.iter().for_each(|s| s.boxes(&[], &mut boxes));
        solid::hull(boxes.iter().flat_map(|b| b.0))
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
