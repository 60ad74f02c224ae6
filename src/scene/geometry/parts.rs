//! What geometry is made of: surfaces, meshes with attributes at their corners, and groups of both placed many times.

use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3A};

use super::tree::{Items, Link, Tree};
use super::{Primitive, Surface};
use crate::{Result, invalid};

/// What varies over a mesh, shared by its triangles. Empty lists are absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// For each triangle the places of its three corners in the lists below.
    pub corners: Vec<[u32; 3]>,
    /// Smooth normals, of any length.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates.
    pub uv: Vec<[f32; 2]>,
    /// Colours.
    pub colours: Vec<[f32; 3]>,
}

/// Surfaces to build a tree over.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// Shapes.
    pub primitives: Vec<Primitive>,
    /// For each primitive what it is made of.
    pub surfaces: Vec<Surface>,
    /// Attributes of triangles: index of the first, and as many as there are corners.
    pub attributes: Vec<(u32, Attributes)>,
}

impl Parts {
    /// Adds one surface.
    pub fn push(&mut self, primitive: Primitive, surface: Surface) {
        self.primitives.push(primitive);
        self.surfaces.push(surface);
    }

    /// Adds triangles over shared points. `attributes` have as many corners as `corners`, or none.
    pub fn mesh(
        &mut self,
        points: &[Vec3A],
        corners: &[[u32; 3]],
        surface: Surface,
        attributes: Attributes,
    ) -> Result<()> {
        let first = self.primitives.len() as u32;
        self.primitives.reserve(corners.len());
        for (i, corner) in corners.iter().enumerate() {
            let point = |c: u32| points.get(c as usize).copied();
            let [Some(a), Some(b), Some(c)] = corner.map(point) else {
                return invalid!("triangle {i} names points {corner:?}, but there are {}", points.len());
            };
            self.primitives.push(Primitive::Triangle([a, b, c]));
        }
        self.surfaces.resize(self.primitives.len(), surface);
        if !attributes.corners.is_empty() {
            self.attributes.push((first, attributes));
        }
        Ok(())
    }

    fn check(&self) -> Result<()> {
        if self.surfaces.len() != self.primitives.len() {
            return invalid!("{} shapes have {} surfaces", self.primitives.len(), self.surfaces.len());
        }
        if self.primitives.len() >= Link::MOST {
            return invalid!("{} shapes are more than {}", self.primitives.len(), Link::MOST - 1);
        }
        if let Some(i) = self.primitives.iter().position(|p| !p.is_finite()) {
            return invalid!("shape {i} has a coordinate that is no finite number");
        }
        for (first, attributes) in &self.attributes {
            attributes.check(*first, &self.primitives)?;
        }
        Ok(())
    }
}

impl Attributes {
    fn check(&self, first: u32, primitives: &[Primitive]) -> Result<()> {
        let range = first as usize..first as usize + self.corners.len();
        let triangles = primitives.get(range).is_some_and(|p| p.iter().all(|p| matches!(p, Primitive::Triangle(_))));
        if !triangles {
            return invalid!(
                "attributes for {} triangles from shape {first} on, which are not there",
                self.corners.len()
            );
        }
        let most = self.corners.iter().flatten().max().map_or(0, |m| *m as usize);
        let lists = [("normals", self.normals.len()), ("uv", self.uv.len()), ("colours", self.colours.len())];
        for (name, len) in lists {
            if len > 0 && most >= len {
                return invalid!("a triangle's corner {most} is beyond the {len} {name}");
            }
        }
        Ok(())
    }

    fn blend<const N: usize>(&self, list: &[[f32; N]], triangle: usize, bary: [f32; 2]) -> Option<[f32; N]> {
        let corners = self.corners.get(triangle)?;
        let [a, b, c] = corners.map(|i| list.get(i as usize));
        let (a, b, c) = (a?, b?, c?);
        let first = 1.0 - bary[0] - bary[1];
        Some(std::array::from_fn(|k| a[k] * first + b[k] * bary[0] + c[k] * bary[1]))
    }
}

/// A tree that can be placed many times.
pub struct Group {
    pub(super) tree: Tree,
    /// Material, and emitter or `u32::MAX`: a third less than `Surface`.
    surfaces: Vec<[u32; 2]>,
    /// By first triangle.
    attributes: Vec<(Range<usize>, Attributes)>,
}

impl Group {
    /// Builds the tree. A group's surfaces do not shine: each placement would be an emitter of its own.
    pub fn build(parts: Parts) -> Result<Group> {
        if parts.primitives.is_empty() {
            return invalid!("the group has no shape");
        }
        if let Some(i) = parts.surfaces.iter().position(|s| s.emitter.is_some()) {
            return invalid!("shape {i} of a group shines; only shapes that are placed once can");
        }
        Group::with(parts, &[])
    }

    pub(super) fn with(parts: Parts, placed: &[(Vec3A, Vec3A)]) -> Result<Group> {
        parts.check()?;
        if placed.len() >= Link::MOST {
            return invalid!("{} placements are more than {}", placed.len(), Link::MOST - 1);
        }
        let tree = Tree::build(Items { primitives: &parts.primitives, placed });
        drop(parts.primitives);
        let surfaces = parts.surfaces.iter().map(|s| [s.material, s.emitter.unwrap_or(u32::MAX)]).collect();
        let mut attributes: Vec<(Range<usize>, Attributes)> = parts
            .attributes
            .into_iter()
            .map(|(first, a)| (first as usize..first as usize + a.corners.len(), a))
            .collect();
        attributes.sort_by_key(|(range, _)| range.start);
        Ok(Group { tree, surfaces, attributes })
    }

    /// Number of surfaces.
    pub fn len(&self) -> usize {
        self.surfaces.len()
    }

    /// True for none.
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
    }

    pub(super) fn surface(&self, primitive: u32) -> Surface {
        let [material, emitter] = self.surfaces[primitive as usize];
        Surface { material, emitter: (emitter != u32::MAX).then_some(emitter) }
    }

    fn attributes(&self, primitive: u32) -> Option<(&Attributes, usize)> {
        let primitive = primitive as usize;
        let after = self.attributes.partition_point(|(range, _)| range.start <= primitive);
        let (range, attributes) = self.attributes.get(after.checked_sub(1)?)?;
        range.contains(&primitive).then_some((attributes, primitive - range.start))
    }

    /// Smooth normal of any length, texture coordinates and colour where the mesh has them.
    pub(super) fn blended(&self, primitive: u32, bary: [f32; 2]) -> Blended {
        let Some((a, i)) = self.attributes(primitive) else { return Blended::default() };
        Blended {
            normal: a.blend(&a.normals, i, bary).map(Vec3A::from_array),
            uv: a.blend(&a.uv, i, bary),
            colour: a.blend(&a.colours, i, bary),
        }
    }

    /// Bytes on the heap.
    pub fn bytes(&self) -> usize {
        let attributes = self.attributes.iter().map(|(_, a)| {
            size_of_val(&a.corners[..])
                + size_of_val(&a.normals[..])
                + size_of_val(&a.uv[..])
                + size_of_val(&a.colours[..])
        });
        self.tree.bytes() + size_of_val(&self.surfaces[..]) + attributes.sum::<usize>()
    }
}

/// Attributes at a point.
#[derive(Default)]
pub(super) struct Blended {
    pub normal: Option<Vec3A>,
    pub uv: Option<[f32; 2]>,
    pub colour: Option<[f32; 3]>,
}

/// A group put into the scene.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Index of the group.
    pub group: u32,
    /// From the group's coordinates to the scene's; may scale, shear and mirror, but not flatten.
    pub transform: DAffine3,
    /// Material of all its surfaces, in place of their own.
    pub material: Option<u32>,
}

/// A placement with both ways. Points go through it in f64: rotated coordinates of different size would lose more than the
/// step off a surface.
pub(super) struct Placed {
    pub group: u32,
    pub material: Option<u32>,
    pub to_scene: DAffine3,
    pub to_group: DAffine3,
}

impl Placed {
    pub fn new(placement: &Placement) -> Option<Placed> {
        let to_group = placement.transform.inverse();
        let usable = placement.transform.is_finite() && to_group.is_finite();
        usable.then_some(Placed {
            group: placement.group,
            material: placement.material,
            to_scene: placement.transform,
            to_group,
        })
    }

    /// Box of a transformed box, a unit in the last place wider.
    pub fn bounds(&self, low: Vec3A, high: Vec3A) -> (Vec3A, Vec3A) {
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..8 {
            let pick = |k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
            let p = self.to_scene.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
            (least, most) = (least.min(p), most.max(p));
        }
        (least.as_vec3a().map(f32::next_down), most.as_vec3a().map(f32::next_up))
    }

    /// A ray of the scene in the group's coordinates; distances along it stay the same.
    pub fn ray(&self, origin: Vec3A, direction: Vec3A) -> (Vec3A, Vec3A) {
        let origin = self.to_group.transform_point3(origin.as_dvec3());
        (origin.as_vec3a(), self.to_group.transform_vector3(direction.as_dvec3()).as_vec3a())
    }

    pub fn point(&self, point: Vec3A) -> Vec3A {
        self.to_scene.transform_point3(point.as_dvec3()).as_vec3a()
    }

    /// The largest coordinate that a place in the scene was computed from, by the place and that number in the group.
    pub fn reach(&self, point: Vec3A, reach: f32) -> f32 {
        let m = &self.to_scene.matrix3;
        let stretch = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        let local = stretch.max_element() as f32 * reach.max(point.abs().max_element());
        local.max(self.to_scene.translation.abs().max_element() as f32)
    }

    /// A normal goes by the transposed inverse and stays on its side.
    pub fn normal(&self, normal: Vec3A) -> Vec3A {
        (self.to_group.matrix3.transpose() * normal.as_dvec3()).normalize_or_zero().as_vec3a()
    }
}

impl Primitive {
    fn is_finite(&self) -> bool {
        let numbers = match self {
            Primitive::Triangle([a, b, c]) => *a + *b + *c,
            Primitive::Parallelogram { corner, u, v } => *corner + *u + *v,
            Primitive::Sphere { center, radius, .. } => *center + *radius,
            Primitive::Disk { center, normal, radius, inner_radius } => *center + *normal + *radius + *inner_radius,
            Primitive::Cylinder { base, axis, radius, .. } => *base + *axis + *radius,
            Primitive::Cone { base, axis, radii: [a, b], .. } => *base + *axis + *a + *b,
        };
        // Sums of finite numbers of such a size are finite, and others' are not.
        numbers.abs().max_element() < f32::MAX / 16.0 && numbers.is_finite()
    }
}
