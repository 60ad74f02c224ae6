//! A surface as a map from the unit square, or of a triangle from its lower left half, by which equal areas of it are equal
//! areas of the surface: what a mesh of elements is laid over.

use std::f32::consts::{PI, TAU};

use glam::{DAffine3, Vec3A};

use super::round::Round;
use super::tree::Tree;
use super::{Geometry, Group, Hit, Surface};
use crate::scene::ray::frame;

/// One surface where it lies in the scene.
#[derive(Clone, Debug)]
pub struct Patch {
    form: Form,
    /// Of a group that is placed: areas are then equal where this does not stretch a round surface.
    to_scene: Option<Box<DAffine3>>,
    /// What it is made of.
    pub surface: Surface,
    /// Index in its list, and the placement.
    pub primitive: u32,
    /// See [`super::Hit::placement`].
    pub placement: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Flat { corner: Vec3A, u: Vec3A, v: Vec3A, triangle: bool },
    Round(Round),
}

impl Patch {
    /// Fills only the lower left half of the square.
    pub fn is_triangle(&self) -> bool {
        matches!(self.form, Form::Flat { triangle: true, .. })
    }

    /// Goes round in its first coordinate.
    pub fn is_round(&self) -> bool {
        matches!(self.form, Form::Round(_))
    }

    /// Place and unit normal of the front at a point of the square; the normal of a surface without area is zero.
    pub fn place(&self, [s, t]: [f32; 2]) -> (Vec3A, Vec3A) {
        let (point, normal) = match &self.form {
            Form::Flat { corner, u, v, .. } => {
                let normal = u.as_dvec3().cross(v.as_dvec3()).normalize_or_zero().as_vec3a();
                (*corner + *u * s + *v * t, normal)
            }
            Form::Round(round) => round.place(s, t),
        };
        match &self.to_scene {
            None => (point, normal),
            Some(m) => {
                let turned = m.matrix3.inverse().transpose() * normal.as_dvec3();
                (m.transform_point3(point.as_dvec3()).as_vec3a(), turned.normalize_or_zero().as_vec3a())
            }
        }
    }

    /// A point of it as a ray would have met it.
    pub fn hit(&self, square: [f32; 2]) -> Hit {
        let (point, normal) = self.place(square);
        Hit {
            t: 0.0,
            point,
            normal,
            surface: self.surface,
            primitive: self.primitive,
            placement: self.placement,
            bary: self.bary(square),
            reach: self.reach(),
        }
    }

    /// The point of the square of a hit's coordinates.
    pub fn square(&self, [a, b]: [f32; 2]) -> [f32; 2] {
        match &self.form {
            Form::Round(Round::Sphere { .. }) => [a, 0.5 - 0.5 * (PI * b).cos()],
            Form::Round(Round::Disk { radius, inner, .. }) => {
                let r = inner + (radius - inner) * b;
                [a, (r * r - inner * inner) / (radius * radius - inner * inner)]
            }
            Form::Round(Round::Cone { radii, .. }) => [a, ring_share(*radii, b)],
            _ => [a, b],
        }
    }

    /// And back.
    pub fn bary(&self, [s, t]: [f32; 2]) -> [f32; 2] {
        match &self.form {
            Form::Round(Round::Sphere { .. }) => [s, (1.0 - 2.0 * t).clamp(-1.0, 1.0).acos() / PI],
            Form::Round(Round::Disk { radius, inner, .. }) => {
                let r = (inner * inner + (radius * radius - inner * inner) * t).max(0.0).sqrt();
                [s, (r - inner) / (radius - inner)]
            }
            Form::Round(Round::Cone { radii, .. }) => [s, ring_height(*radii, t)],
            _ => [s, t],
        }
    }

    /// About how long it is along both sides of the square.
    pub fn sides(&self) -> [f32; 2] {
        let walk = |f: &dyn Fn(f32) -> [f32; 2]| -> f32 {
            (0..8).map(|i| self.place(f(i as f32 / 8.0)).0.distance(self.place(f((i + 1) as f32 / 8.0)).0)).sum()
        };
        match self.form {
            Form::Flat { .. } => {
                let at = |s: f32, t: f32| self.place([s, t]).0;
                [at(1.0, 0.0).distance(at(0.0, 0.0)), at(0.0, 1.0).distance(at(0.0, 0.0))]
            }
            // Around at the widest.
            Form::Round(Round::Disk { .. }) => [walk(&|x| [x, 1.0]), walk(&|x| [0.0, x])],
            Form::Round(_) => [walk(&|x| [x, 0.5]), walk(&|x| [0.0, x])],
        }
    }

    /// Area in the scene's units.
    pub fn area(&self) -> f64 {
        const N: usize = 16;
        let step = 1e-2 / N as f32;
        let local = |s: f32, t: f32| -> f64 {
            let at = |s: f32, t: f32| self.place([s, t]).0.as_dvec3();
            let across = (at(s + step, t) - at(s - step, t)).cross(at(s, t + step) - at(s, t - step));
            across.length() / f64::from(4.0 * step * step)
        };
        match &self.form {
            Form::Flat { u, v, triangle, .. } => {
                let turn = |v: &Vec3A| match &self.to_scene {
                    None => v.as_dvec3(),
                    Some(m) => m.matrix3 * v.as_dvec3(),
                };
                turn(u).cross(turn(v)).length() * if *triangle { 0.5 } else { 1.0 }
            }
            Form::Round(round) if self.to_scene.is_none() => round.area(),
            Form::Round(_) => {
                let middle = |i: usize| (i as f32 + 0.5) / N as f32;
                let cells = (0..N * N).map(|i| local(middle(i % N), middle(i / N)));
                cells.sum::<f64>() / (N * N) as f64
            }
        }
    }

    /// The largest coordinate that its places are computed from, see [`super::Hit::reach`].
    pub fn reach(&self) -> f32 {
        let largest = |s: f32, t: f32| self.place([s, t]).0.abs().max_element();
        match &self.form {
            Form::Flat { .. } => {
                let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
                corners.into_iter().map(|(s, t)| largest(s, t)).fold(0.0, f32::max)
            }
            Form::Round(round) if self.to_scene.is_none() => round.reach(),
            Form::Round(_) => 2.0 * (0..16).map(|i| largest(i as f32 / 16.0, 0.5)).fold(0.0, f32::max),
        }
    }
}

impl Round {
    /// Place and normal of the front at longitude s and share t of the area below.
    fn place(&self, s: f32, t: f32) -> (Vec3A, Vec3A) {
        let (sin, cos) = (TAU * s).sin_cos();
        let facing = |out: Vec3A, inward: bool| if inward { -out } else { out };
        match *self {
            Round::Sphere { center, radius, inward } => {
                let z = 1.0 - 2.0 * t;
                let r = (1.0 - z * z).max(0.0).sqrt();
                let out = Vec3A::new(r * cos, r * sin, z);
                (center + out * radius, facing(out, inward))
            }
            Round::Disk { center, normal, radius, inner } => {
                let (x, y) = frame(normal);
                let r = (inner * inner + (radius * radius - inner * inner) * t).max(0.0).sqrt();
                (center + (x * cos + y * sin) * r, normal)
            }
            Round::Cylinder { base, axis, height, radius, inward } => {
                let (x, y) = frame(axis);
                let out = x * cos + y * sin;
                (base + axis * (height * t) + out * radius, facing(out, inward))
            }
            Round::Cone { base, axis, height, radii, inward } => {
                let (x, y) = frame(axis);
                let (h, out) = (ring_height(radii, t), x * cos + y * sin);
                let point = base + axis * (height * h) + out * (radii[0] + (radii[1] - radii[0]) * h);
                (point, facing((out * height - axis * (radii[1] - radii[0])).normalize_or(out), inward))
            }
        }
    }

    fn area(&self) -> f64 {
        let area = match *self {
            Round::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Round::Disk { radius, inner, .. } => PI * (radius * radius - inner * inner),
            Round::Cylinder { height, radius, .. } => TAU * radius * height,
            Round::Cone { height, radii: [a, b], .. } => PI * (a + b) * height.hypot(b - a),
        };
        f64::from(area)
    }
}

/// Share of a frustum's area below a share h of its height.
fn ring_share([a, b]: [f32; 2], h: f32) -> f32 {
    h * (2.0 * a + (b - a) * h) / (a + b)
}

/// And back: the height below which a share t of the area lies.
fn ring_height([a, b]: [f32; 2], t: f32) -> f32 {
    let r = (a * a + (b * b - a * a) * t).max(0.0).sqrt();
    (t * (a + b) / (r + a)).min(1.0)
}

impl Tree {
    /// What each primitive of the tree is, by its index.
    fn forms(&self, count: usize) -> Vec<Option<Form>> {
        let mut forms = vec![None; count];
        let mut put = |id: u32, form: Form| {
            if let Some(f) = forms.get_mut(id as usize) {
                *f = Some(form);
            }
        };
        for block in &self.triangles {
            for (lane, id) in block.ids.into_iter().enumerate() {
                let [corner, b, c] = [0, 1, 2].map(|i| block.corner(i, lane));
                put(id, Form::Flat { corner, u: b - corner, v: c - corner, triangle: true });
            }
        }
        for block in &self.quads {
            for (lane, id) in block.ids.into_iter().enumerate() {
                let [corner, b, d] = [0, 1, 3].map(|i| block.corner(i, lane));
                put(id, Form::Flat { corner, u: b - corner, v: d - corner, triangle: false });
            }
        }
        self.rounds.iter().for_each(|(round, id)| put(*id, Form::Round(*round)));
        forms
    }
}

impl Group {
    fn patches(&self, placement: Option<(u32, &super::parts::Placed)>, out: &mut Vec<Patch>) {
        let forms = self.tree.forms(self.len());
        for (primitive, form) in forms.into_iter().enumerate() {
            let Some(form) = form else { continue };
            let primitive = primitive as u32;
            let mut surface = self.surface(primitive);
            if let Some((_, placed)) = placement {
                surface.material = placed.material.unwrap_or(surface.material);
            }
            let to_scene = placement.map(|(_, placed)| Box::new(placed.to_scene));
            out.push(Patch { form, to_scene, surface, primitive, placement: placement.map(|p| p.0) });
        }
    }
}

impl Geometry {
    /// All surfaces: the scene's own, then those of each placement.
    pub fn patches(&self) -> Vec<Patch> {
        let mut out = Vec::with_capacity(self.len());
        self.scene.patches(None, &mut out);
        for (i, placed) in self.placed.iter().enumerate() {
            self.groups[placed.group as usize].patches(Some((i as u32, placed)), &mut out);
        }
        out
    }
}
