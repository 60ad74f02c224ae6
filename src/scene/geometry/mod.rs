//! All surfaces of a scene and what rays meet of them.
//!
//! Triangles, parallelograms, spheres, disks and open cylinders hang on one tree of eight children a node, or, where they are
//! few, all are tested; groups that are built once and placed many times hang on it as trees of their own. Boxes and flat
//! surfaces are tested eight at a time, by AVX2 where the processor has it. A ray is `origin + t direction`, t > 0, its
//! direction of any length; a ray that is no number, or has no direction, meets nothing.

mod block;
mod eight;
mod few;
mod parts;
mod patch;
mod ray;
mod round;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_shading;
mod traverse;
mod tree;

use glam::Vec3A;

pub use parts::{Attributes, Group, Parts, Placement};
pub use patch::Patch;

use crate::{Result, invalid};
use eight::{Eight, Isa, Plain};
use parts::Placed;
use ray::Ray;
use traverse::Found;
use tree::{Link, Tree};

/// A surface without its attributes.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// Front side: the one from which the corners run counter-clockwise.
    Triangle([Vec3A; 3]),
    /// Front side: that of u x v.
    Parallelogram {
        /// A corner.
        corner: Vec3A,
        /// From the corner to one neighbour.
        u: Vec3A,
        /// From the corner to the other.
        v: Vec3A,
    },
    /// Front side: outside, or inside where `inward`.
    Sphere {
        /// Centre.
        center: Vec3A,
        /// Radius.
        radius: f32,
        /// The front is the inside.
        inward: bool,
    },
    /// Front side: that of the normal.
    Disk {
        /// Centre.
        center: Vec3A,
        /// Normal of any length.
        normal: Vec3A,
        /// Outer radius.
        radius: f32,
        /// Radius of the hole in the middle; 0 for none.
        inner_radius: f32,
    },
    /// A tube without caps. Front side: outside, or inside where `inward`.
    Cylinder {
        /// Middle of one end.
        base: Vec3A,
        /// From there to the middle of the other end.
        axis: Vec3A,
        /// Radius.
        radius: f32,
        /// The front is the inside.
        inward: bool,
    },
    /// A frustum of a cone without caps. Front side: outside, or inside where `inward`.
    Cone {
        /// Middle of one end.
        base: Vec3A,
        /// From there to the middle of the other end.
        axis: Vec3A,
        /// Radius at the base, and at the other end; one of them may be 0.
        radii: [f32; 2],
        /// The front is the inside.
        inward: bool,
    },
}

/// What a surface is made of, and whether it shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Index of the material.
    pub material: u32,
    /// Index of the emitter it belongs to.
    pub emitter: Option<u32>,
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// The point, on the surface as well as floats can say.
    pub point: Vec3A,
    /// Unit normal of the front side.
    pub normal: Vec3A,
    /// What was met.
    pub surface: Surface,
    /// Index of the primitive in its list: the scene's, or the group's that was placed.
    pub primitive: u32,
    /// Index of the placement it belongs to.
    pub placement: Option<u32>,
    /// Triangle: weights of its second and third corner. Parallelogram: fractions of u and v. Sphere: longitude and
    /// colatitude about z; disk: angle and radius; cylinder: angle and height; all in 0..1.
    pub bary: [f32; 2],
    /// The largest coordinate that the point was computed from: it is as uncertain as that number's last place.
    pub reach: f32,
}

/// What a material may ask of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Unit normal, smooth where the mesh has normals, on the front side of the surface.
    pub normal: Vec3A,
    /// The mesh's texture coordinates, or the hit's own.
    pub uv: [f32; 2],
    /// The mesh's colour.
    pub colour: Option<[f32; 3]>,
}

/// Entries of a traversal's stack, which has to be cleared for every ray: those that a box of few surfaces needs, those that
/// most trees need, and those that any tree needs.
const FLAT: usize = 16;
const SHALLOW: usize = 64;
const DEEP: usize = tree::DEEPEST;

/// Surfaces with a tree over them.
pub struct Geometry {
    isa: Isa,
    scene: Group,
    groups: Vec<Group>,
    placed: Vec<Placed>,
}

impl Geometry {
    /// Builds the tree over at least one surface.
    pub fn build(primitives: Vec<Primitive>, surfaces: Vec<Surface>) -> Result<Geometry> {
        Geometry::assemble(Parts { primitives, surfaces, attributes: Vec::new() }, Vec::new(), &[])
    }

    /// Builds the tree over surfaces and placements of groups, at least one in all.
    pub fn assemble(parts: Parts, groups: Vec<Group>, placements: &[Placement]) -> Result<Geometry> {
        if parts.primitives.is_empty() && placements.is_empty() {
            return invalid!("the scene has no shape");
        }
        let (mut placed, mut boxes) = (Vec::new(), Vec::new());
        for (i, placement) in placements.iter().enumerate() {
            let Some(group) = groups.get(placement.group as usize) else {
                return invalid!("placement {i} is of group {}, but there are {}", placement.group, groups.len());
            };
            let Some(one) = Placed::new(placement) else {
                return invalid!("placement {i} has a transform that cannot be undone");
            };
            let (low, high) = one.bounds(group.tree.low, group.tree.high);
            if !(low.is_finite() && high.is_finite()) {
                return invalid!("placement {i} reaches beyond the numbers of floats");
            }
            boxes.push((low, high));
            placed.push(one);
        }
        Ok(Geometry { isa: Isa::best(), scene: Group::with(parts, &boxes)?, groups, placed })
    }

    /// Number of surfaces, those of placements as often as they are placed.
    pub fn len(&self) -> usize {
        self.scene.len() + self.placed.iter().map(|p| self.groups[p.group as usize].len()).sum::<usize>()
    }

    /// Never true: a scene has at least one surface.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Lower and upper corner of a box around all.
    pub fn bounds(&self) -> (Vec3A, Vec3A) {
        (self.scene.tree.low, self.scene.tree.high)
    }

    /// Bytes on the heap.
    pub fn bytes(&self) -> usize {
        let groups: usize = self.groups.iter().map(Group::bytes).sum();
        self.scene.bytes() + groups + size_of_val(&self.placed[..])
    }

    /// The nearest surface along a ray.
    pub fn closest(&self, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(s) => self.first(s, origin, direction),
            Isa::Plain => self.first(Plain, origin, direction),
        }
    }

    #[inline(always)]
    fn first<S: Eight>(&self, s: S, origin: Vec3A, direction: Vec3A) -> Option<Hit> {
        let tree = &self.scene.tree;
        if tree.is_few() {
            // All in one for the compiler; where a tree is walked that would be slower.
            return s.run(
                #[inline(always)]
                || {
                    let ray = Ray::new(origin, direction, tree.low, tree.high)?;
                    let mut found = Found::nothing(f32::MAX);
                    few::closest(s, tree, &ray, &mut found);
                    if found.link == Link::NONE {
                        return None;
                    }
                    Some(self.scene.hit(&ray, &found))
                },
            );
        }
        let ray = Ray::new(origin, direction, tree.low, tree.high)?;
        let mut found = Found::nothing(f32::MAX);
        self.nearest(s, tree, &ray, &mut found);
        (found.link != Link::NONE).then(|| self.hit(&ray, &found))
    }

    /// True when nothing stands between two points, both already moved off their surfaces.
    pub fn visible(&self, from: Vec3A, to: Vec3A) -> bool {
        // From far away the other point cannot be told from its surface, however far it was moved off.
        const SHORT: f32 = 1.0 - 1.0 / 131_072.0;
        !self.any(from, to - from, SHORT)
    }

    /// True when a ray meets nothing.
    pub fn unoccluded(&self, origin: Vec3A, direction: Vec3A) -> bool {
        !self.any(origin, direction, f32::MAX)
    }

    /// Normal, texture coordinates and colour at a hit.
    pub fn shading(&self, hit: &Hit) -> Shading {
        let placed = hit.placement.map(|p| &self.placed[p as usize]);
        let group = placed.map_or(&self.scene, |p| &self.groups[p.group as usize]);
        let blended = group.blended(hit.primitive, hit.bary);
        let smooth = blended.normal.and_then(|n| placed.map_or(n, |p| p.normal(n)).try_normalize());
        let normal = smooth.map_or(hit.normal, |n| if n.dot(hit.normal) < 0.0 { -n } else { n });
        Shading { normal, uv: blended.uv.unwrap_or(hit.bary), colour: blended.colour }
    }

    fn nearest<S: Eight>(&self, s: S, tree: &Tree, ray: &Ray, found: &mut Found) {
        let deeper = |p: u32, found: &mut Found| self.nearest_placed(s, p, ray, found);
        if tree.is_few() {
            s.run(
                #[inline(always)]
                || few::closest(s, tree, ray, found),
            );
        } else if tree.stacked <= FLAT {
            s.run(
                #[inline(always)]
                || traverse::closest::<S, FLAT>(s, tree, ray, found, deeper),
            );
        } else if tree.stacked <= SHALLOW {
            s.run(
                #[inline(always)]
                || traverse::closest::<S, SHALLOW>(s, tree, ray, found, deeper),
            );
        } else {
            s.run(
                #[inline(always)]
                || traverse::closest::<S, DEEP>(s, tree, ray, found, deeper),
            );
        }
    }

    /// Groups hold no placements: this goes no deeper.
    #[inline(never)]
    fn nearest_placed<S: Eight>(&self, s: S, placement: u32, ray: &Ray, found: &mut Found) {
        let placed = &self.placed[placement as usize];
        let tree = &self.groups[placed.group as usize].tree;
        let (origin, direction) = placed.ray(ray.origin, ray.direction);
        let Some(ray) = Ray::new(origin, direction, tree.low, tree.high) else { return };
        let mut inside = Found::nothing(found.t);
        self.nearest(s, tree, &ray, &mut inside);
        if inside.link != Link::NONE {
            *found = Found { placement, ..inside };
        }
    }

    fn any(&self, origin: Vec3A, direction: Vec3A, limit: f32) -> bool {
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2(s) => self.some(s, origin, direction, limit),
            Isa::Plain => self.some(Plain, origin, direction, limit),
        }
    }

    #[inline(always)]
    fn some<S: Eight>(&self, s: S, origin: Vec3A, direction: Vec3A, limit: f32) -> bool {
        let tree = &self.scene.tree;
        if tree.is_few() {
            return s.run(
                #[inline(always)]
                || {
                    let ray = Ray::new(origin, direction, tree.low, tree.high);
                    ray.is_some_and(
                        #[inline(always)]
                        |ray| few::any(s, tree, &ray, limit),
                    )
                },
            );
        }
        Ray::new(origin, direction, tree.low, tree.high).is_some_and(|ray| self.meets(s, tree, &ray, limit))
    }

    fn meets<S: Eight>(&self, s: S, tree: &Tree, ray: &Ray, limit: f32) -> bool {
        let deeper = |p: u32| self.meets_placed(s, p, ray, limit);
        if tree.is_few() {
            s.run(
                #[inline(always)]
                || few::any(s, tree, ray, limit),
            )
        } else if tree.stacked <= FLAT {
            s.run(
                #[inline(always)]
                || traverse::any::<S, FLAT>(s, tree, ray, limit, deeper),
            )
        } else if tree.stacked <= SHALLOW {
            s.run(
                #[inline(always)]
                || traverse::any::<S, SHALLOW>(s, tree, ray, limit, deeper),
            )
        } else {
            s.run(
                #[inline(always)]
                || traverse::any::<S, DEEP>(s, tree, ray, limit, deeper),
            )
        }
    }

    #[inline(never)]
    fn meets_placed<S: Eight>(&self, s: S, placement: u32, ray: &Ray, limit: f32) -> bool {
        let placed = &self.placed[placement as usize];
        let tree = &self.groups[placed.group as usize].tree;
        let (origin, direction) = placed.ray(ray.origin, ray.direction);
        Ray::new(origin, direction, tree.low, tree.high).is_some_and(|ray| self.meets(s, tree, &ray, limit))
    }

    /// All about a crossing.
    fn hit(&self, ray: &Ray, found: &Found) -> Hit {
        if found.placement == u32::MAX {
            return self.scene.hit(ray, found);
        }
        let placed = &self.placed[found.placement as usize];
        let group = &self.groups[placed.group as usize];
        let (origin, direction) = placed.ray(ray.origin, ray.direction);
        // The same ray was traced there: it is one.
        let inside = Ray::new(origin, direction, group.tree.low, group.tree.high).unwrap_or(*ray);
        let mut place = group.tree.place(&inside, found);
        place.reach = placed.reach(place.point, place.reach);
        place.point = placed.point(place.point);
        place.normal = placed.normal(place.normal);
        let own = group.surface(place.primitive);
        let surface = Surface { material: placed.material.unwrap_or(own.material), emitter: own.emitter };
        Hit::new(found.t, place, surface, Some(found.placement))
    }
}

/// A point of a tree's surface.
struct Place {
    point: Vec3A,
    normal: Vec3A,
    bary: [f32; 2],
    reach: f32,
    primitive: u32,
}

impl Hit {
    fn new(t: f32, place: Place, surface: Surface, placement: Option<u32>) -> Hit {
        let Place { point, normal, bary, reach, primitive } = place;
        Hit { t, point, normal, surface, primitive, placement, bary, reach }
    }
}

impl Group {
    /// All about a crossing where nothing is placed.
    #[inline(always)]
    fn hit(&self, ray: &Ray, found: &Found) -> Hit {
        let place = self.tree.place(ray, found);
        let surface = self.surface(place.primitive);
        Hit::new(found.t, place, surface, None)
    }
}

impl Tree {
    /// Where on its primitive a crossing lies.
    #[inline(always)]
    fn place(&self, ray: &Ray, found: &Found) -> Place {
        let (index, lane) = (found.link.index(), found.lane as usize);
        match found.link.kind() {
            Link::TRIANGLES => {
                let block = &self.triangles[index];
                let (point, normal, bary, reach) = block.locate(lane, ray, found.t);
                Place { point, normal, bary, reach, primitive: block.ids[lane & 7] }
            }
            Link::QUADS => {
                let block = &self.quads[index];
                let (point, normal, bary, reach) = block.locate(lane, ray, found.t);
                Place { point, normal, bary, reach, primitive: block.ids[lane & 7] }
            }
            _ => {
                let (round, primitive) = &self.rounds[index];
                let (point, normal, bary) = round.locate(ray.origin + ray.direction * found.t);
                Place { point, normal, bary, reach: round.reach(), primitive: *primitive }
            }
        }
    }
}
