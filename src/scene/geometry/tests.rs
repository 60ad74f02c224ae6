use glam::{DAffine3, DQuat, DVec3, Vec3A, vec3a};

use super::*;
use crate::scene::ray::{cosine_direction, frame, offset};

/// Numbers in 0..1 that repeat (Knuth's constants).
pub(super) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u32 << 24) as f32
    }

    /// In the cube from -1 to 1.
    pub fn cube(&mut self) -> Vec3A {
        Vec3A::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    pub fn direction(&mut self) -> Vec3A {
        loop {
            let v = self.cube();
            if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }

    fn primitive(&mut self, size: f32) -> Primitive {
        let center = self.cube();
        match (self.unit() * 6.0) as u32 {
            0 => Primitive::Triangle([center, center + self.cube() * size, center + self.cube() * size]),
            1 => Primitive::Parallelogram { corner: center, u: self.cube() * size, v: self.cube() * size },
            2 => Primitive::Sphere { center, radius: self.unit() * size, inward: self.unit() < 0.5 },
            3 => {
                let radius = self.unit() * size;
                let inner_radius = if self.unit() < 0.5 { 0.0 } else { 0.5 * radius };
                Primitive::Disk { center, normal: self.direction() * 3.0, radius, inner_radius }
            }
            4 => {
                let (axis, inward) = (self.cube() * size, self.unit() < 0.5);
                let radii = [0.3 * self.unit() * size, if inward { 0.3 * self.unit() * size } else { 0.0 }];
                Primitive::Cone { base: center, axis, radii, inward }
            }
            _ => {
                let axis = self.cube() * size;
                Primitive::Cylinder { base: center, axis, radius: 0.3 * self.unit() * size, inward: self.unit() < 0.5 }
            }
        }
    }
}

fn parts(primitives: Vec<Primitive>) -> Parts {
    let surfaces = (0..primitives.len() as u32).map(|material| Surface { material, emitter: None }).collect();
    Parts { primitives, surfaces, attributes: Vec::new() }
}

fn of(primitives: Vec<Primitive>) -> Geometry {
    Geometry::assemble(parts(primitives), Vec::new(), &[]).unwrap()
}

fn triangles(points: &[Vec3A], corners: &[[u32; 3]]) -> Geometry {
    let mut parts = Parts::default();
    parts.mesh(points, corners, Surface { material: 0, emitter: None }, Attributes::default()).unwrap();
    Geometry::assemble(parts, Vec::new(), &[]).unwrap()
}

fn placement(random: &mut Random, group: u32) -> Placement {
    let turn = DQuat::from_axis_angle(random.direction().as_dvec3(), f64::from(random.unit()) * 6.0);
    let scale = DVec3::new(1.5, 0.7, if random.unit() < 0.5 { 1.0 } else { -1.0 });
    let transform = DAffine3::from_scale_rotation_translation(scale, turn, random.cube().as_dvec3() * 3.0);
    Placement { group, transform, material: None }
}

fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.t == b.t && a.primitive == b.primitive && a.placement == b.placement,
        (None, None) => true,
        _ => false,
    }
}

#[test]
fn the_tree_finds_what_every_surface_alone_would() {
    for (seed, count, size) in [(1, 3, 1.0), (2, 7, 0.9), (2, 17, 0.8), (3, 90, 0.4), (4, 700, 0.2), (5, 3000, 0.05)] {
        let mut random = Random::new(seed);
        let all: Vec<Primitive> = (0..count).map(|_| random.primitive(size)).collect();
        let alone: Vec<Geometry> = all.iter().map(|p| of(vec![*p])).collect();
        let tree = of(all);
        let mut hits = 0;
        for i in 0..(120_000 / count).clamp(1500, 6000) {
            let origin = random.cube() * 1.5;
            let direction = if i % 9 == 0 { Vec3A::AXES[i % 3] } else { random.direction() };
            let found = tree.closest(origin, direction);
            let first = alone
                .iter()
                .enumerate()
                .filter_map(|(i, g)| g.closest(origin, direction).map(|h| Hit { primitive: i as u32, ..h }))
                .min_by(|a, b| a.t.total_cmp(&b.t));
            let agree = found.map(|h| (h.t, h.point)) == first.map(|h| (h.t, h.point));
            assert!(agree, "{origin} {direction}: {found:?} and {first:?}");
            assert_eq!(found.is_none(), tree.unoccluded(origin, direction));
            if let Some(h) = found {
                hits += 1;
                assert!(tree.visible(origin, origin + direction * (h.t * 0.999)));
                assert!(!tree.visible(origin, origin + direction * (h.t * 1.001)));
            }
        }
        assert!(hits > 100, "{hits} of {count} are too few to mean something");
    }
}

#[test]
fn placements_are_met_as_their_shapes_moved_there() {
    let mut random = Random::new(11);
    // Parallelograms and triangles stay what they are under an affine map, spheres do not.
    let flat: Vec<Primitive> = std::iter::repeat_with(|| random.primitive(0.3))
        .filter(|p| matches!(p, Primitive::Triangle(_) | Primitive::Parallelogram { .. }))
        .take(60)
        .collect();
    let placements: Vec<Placement> = (0..40).map(|_| placement(&mut random, 0)).collect();
    let loose = vec![Primitive::Sphere { center: Vec3A::ZERO, radius: 0.5, inward: false }];
    let group = Group::build(parts(flat.clone())).unwrap();
    let two = Geometry::assemble(parts(loose.clone()), vec![group], &placements).unwrap();
    let mut all = loose;
    for p in &placements {
        let point = |x: Vec3A| p.transform.transform_point3(x.as_dvec3()).as_vec3a();
        let vector = |x: Vec3A| p.transform.transform_vector3(x.as_dvec3()).as_vec3a();
        all.extend(flat.iter().map(|f| match *f {
            Primitive::Triangle(v) => Primitive::Triangle(v.map(point)),
            Primitive::Parallelogram { corner, u, v } => {
                Primitive::Parallelogram { corner: point(corner), u: vector(u), v: vector(v) }
            }
            other => other,
        }));
    }
    let one = of(all);
    assert_eq!(one.len(), two.len());
    let (mut hits, mut differ) = (0, 0);
    for _ in 0..20_000 {
        let (origin, direction) = (random.cube() * 4.0, random.direction());
        let (a, b) = (one.closest(origin, direction), two.closest(origin, direction));
        assert_eq!(b.is_none(), two.unoccluded(origin, direction));
        // At the very edge rounding may decide either way.
        let (Some(a), Some(b)) = (a, b) else {
            differ += i32::from(a.is_some() != b.is_some());
            continue;
        };
        hits += 1;
        if (a.t - b.t).abs() > 1e-4 * a.t.max(1.0) {
            differ += 1;
            continue;
        }
        assert!(a.point.distance(b.point) < 1e-4, "{a:?} {b:?}");
        assert_eq!(b.placement, (a.primitive > 0).then(|| (a.primitive - 1) / 60));
        // The side of the front is that of the shape before it was moved; a mirror turns the order of the corners.
        let mirrored = b.placement.is_some_and(|p| placements[p as usize].transform.matrix3.determinant() < 0.0);
        let normal = if mirrored { -a.normal } else { a.normal };
        assert!(normal.dot(b.normal) > 0.999, "{a:?} {b:?}");
    }
    assert!(hits > 3000 && differ < 5, "{hits} {differ}");
}

#[test]
fn arrays_and_vectors_give_the_same_bits() {
    let mut random = Random::new(21);
    // Many surfaces, and so few that no tree is built, loose and placed.
    for (loose, grouped, placed, least) in [(1000, 300, 20, 1000), (6, 6, 20, 200), (6, 0, 0, 0)] {
        let mut of = |count, size| parts((0..count).map(|_| random.primitive(size)).collect());
        let group = (grouped > 0).then(|| Group::build(of(grouped, 0.2)).unwrap());
        let loose = of(loose, 0.8);
        let placements: Vec<Placement> = (0..placed).map(|_| placement(&mut random, 0)).collect();
        let mut scene = Geometry::assemble(loose, group.into_iter().collect(), &placements).unwrap();
        let rays: Vec<(Vec3A, Vec3A)> = (0..20_000).map(|_| (random.cube() * 4.0, random.direction())).collect();
        let answers = |g: &Geometry| -> Vec<_> {
            rays.iter().map(|(o, d)| (g.closest(*o, *d), g.visible(*o, *o + *d), g.unoccluded(*o, *d))).collect()
        };
        let best = answers(&scene);
        scene.isa = Isa::Plain;
        assert_eq!(answers(&scene), best);
        let hits = best.iter().filter_map(|a| a.0).filter(|h| h.placement.is_some() == (placed > 0)).count();
        assert!(hits > least, "{hits} hits of {placed} placements say little");
    }
}

#[test]
fn rays_at_known_points_meet_them() {
    let mut random = Random::new(31);
    for _ in 0..30_000 {
        let primitive = random.primitive(1.0);
        // Well inside, and outside where there is an outside.
        let (u, v) = (0.02 + 0.96 * random.unit(), 0.02 + 0.96 * random.unit());
        let angle = std::f32::consts::TAU * u;
        let (target, normal, bary, beyond) = match primitive {
            Primitive::Triangle([a, b, c]) => {
                let (u, v) = if u + v > 0.98 { (0.98 - 0.9 * u, 0.9 * u * v) } else { (u, v) };
                let at = |u: f32, v: f32| a + (b - a) * u + (c - a) * v;
                (at(u, v), (b - a).cross(c - a), [u, v], Some(at(1.02 - v, v)))
            }
            Primitive::Parallelogram { corner, u: s, v: t } => {
                (corner + s * u + t * v, s.cross(t), [u, v], Some(corner + s * u + t * 1.02))
            }
            Primitive::Disk { center, normal, radius, inner_radius } => {
                let (s, t) = frame(normal.normalize());
                let out = s * angle.cos() + t * angle.sin();
                let r = inner_radius + (radius - inner_radius) * v;
                (center + out * r, normal, [u, v], Some(center + out * (1.02 * radius)))
            }
            Primitive::Sphere { center, radius, inward } => {
                let (z, r) = ((std::f32::consts::PI * v).cos(), (std::f32::consts::PI * v).sin());
                let out = vec3a(r * angle.cos(), r * angle.sin(), z);
                (center + out * radius, if inward { -out } else { out }, [u, v], None)
            }
            Primitive::Cylinder { base, axis, radius, inward } => {
                let (s, t) = frame(axis.normalize());
                let out = s * angle.cos() + t * angle.sin();
                let at = base + axis * v + out * radius;
                (at, if inward { -out } else { out }, [u, v], None)
            }
            Primitive::Cone { base, axis, radii: [a, b], inward } => {
                let (s, t) = frame(axis.normalize());
                let out = s * angle.cos() + t * angle.sin();
                let at = base + axis * v + out * (a + (b - a) * v);
                let normal = out * axis.length() - axis.normalize() * (b - a);
                (at, if inward { -normal } else { normal }, [u, v], None)
            }
        };
        let size = primitive_size(&primitive);
        if size < 0.05 {
            continue;
        }
        let origin = match primitive {
            Primitive::Sphere { center, radius, .. } => center + random.direction() * (0.8 * radius),
            Primitive::Cylinder { base, axis, .. } => base + axis * (0.1 + 0.8 * random.unit()),
            // Inside: from there the crossing is the only one.
            Primitive::Cone { base, axis, .. } => base + axis * (0.1 + 0.6 * random.unit()),
            _ => random.cube() * 2.0,
        };
        let normal = normal.normalize();
        // From near the plane the crossing is not so sharp.
        if (target - origin).normalize().dot(normal).abs() < 0.1 {
            continue;
        }
        let scene = of(vec![primitive]);
        let hit = scene.closest(origin, target - origin).expect("the ray goes there");
        assert!((hit.t - 1.0).abs() < 2e-5, "{primitive:?} {hit:?}");
        assert!(hit.point.distance(target) < 2e-5, "{primitive:?} {hit:?} {target}");
        assert!(hit.normal.dot(normal) > 0.9999 && hit.normal.is_normalized(), "{primitive:?} {hit:?} {normal}");
        let off = (hit.bary[0] - bary[0]).abs().max((hit.bary[1] - bary[1]).abs());
        assert!(off < 2e-4 / size, "{primitive:?} {hit:?} {bary:?}");
        assert!(!scene.unoccluded(origin, target - origin));
        if let Some(beyond) = beyond {
            assert!(scene.closest(origin, beyond - origin).is_none(), "{primitive:?}");
        }
    }
}

/// A length that the smallest angle of the shape scales with.
fn primitive_size(primitive: &Primitive) -> f32 {
    match *primitive {
        Primitive::Triangle([a, b, c]) => (b - a).cross(c - a).length() / (b - a).length().max((c - a).length()),
        Primitive::Parallelogram { u, v, .. } => u.cross(v).length() / u.length().max(v.length()),
        Primitive::Sphere { radius, .. } => radius,
        Primitive::Disk { radius, inner_radius, .. } => radius - inner_radius,
        Primitive::Cylinder { axis, radius, .. } => radius.min(axis.length()),
        // What its apex has of angles is less.
        Primitive::Cone { axis, radii: [a, b], .. } => 0.2 * (0.5 * (a + b)).min(axis.length()),
    }
}

/// The unit sphere as triangles, moved and scaled.
fn tessellated(n: u32, scale: f32, centre: Vec3A) -> (Vec<Vec3A>, Vec<[u32; 3]>) {
    let (mut points, mut corners) = (Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..2 * n {
            let (theta, phi) = (std::f32::consts::PI * j as f32 / n as f32, std::f32::consts::PI * i as f32 / n as f32);
            // The poles are one point each.
            let r = if j == 0 || j == n { 0.0 } else { theta.sin() };
            points.push(centre + vec3a(r * phi.cos(), r * phi.sin(), theta.cos()) * scale);
        }
    }
    let at = |i: u32, j: u32| j * 2 * n + i % (2 * n);
    for j in 0..n {
        for i in 0..2 * n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            corners.extend([[a, c, b], [a, d, c]].into_iter().filter(|t| {
                let [a, b, c] = t.map(|k| points[k as usize]);
                a != b && b != c && a != c
            }));
        }
    }
    (points, corners)
}

/// Rays from within at corners, along edges, and a few units in the last place beside both.
fn leaks(scene: &Geometry, points: &[Vec3A], corners: &[[u32; 3]], centre: Vec3A, reach: f32, rays: usize) -> usize {
    let mut random = Random::new(41);
    let mut missed = 0;
    for i in 0..rays {
        let corner = corners[(random.unit() * corners.len() as f32) as usize % corners.len()];
        let (a, b) = (points[corner[i % 3] as usize], points[corner[(i + 1) % 3] as usize]);
        let target = if i % 4 == 0 { a } else { a + (b - a) * random.unit() };
        let origin = centre + random.cube() * reach;
        let beside = if i % 3 == 0 { random.cube() * (2.0 * f32::EPSILON * reach) } else { Vec3A::ZERO };
        let direction = (target - origin + beside) * if i % 5 == 0 { 1e-3 } else { 1.0 };
        missed += usize::from(scene.closest(origin, direction).is_none() || scene.unoccluded(origin, direction));
    }
    missed
}

#[test]
fn no_ray_slips_between_triangles() {
    for (scale, centre) in [(1.0, Vec3A::ZERO), (0.37, vec3a(0.3, -0.2, 0.7)), (900.0, vec3a(8e3, -9e3, 1e4))] {
        let (points, corners) = tessellated(24, scale, centre);
        let scene = triangles(&points, &corners);
        assert_eq!(leaks(&scene, &points, &corners, centre, 0.5 * scale, 500_000), 0, "{scale}");
    }
    for scale in [1.0, 0.1, 1e4] {
        let points: Vec<Vec3A> = (0..8)
            .map(|i| {
                Vec3A::new((i & 1) as f32 * 2.0 - 1.0, (i >> 1 & 1) as f32 * 2.0 - 1.0, (i >> 2) as f32 * 2.0 - 1.0)
            })
            .map(|p| p * scale)
            .collect();
        let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let corners: Vec<[u32; 3]> = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let scene = triangles(&points, &corners);
        assert_eq!(leaks(&scene, &points, &corners, Vec3A::ZERO, 0.99 * scale, 500_000), 0, "{scale}");
        let quads = sides.map(|[a, b, c, d]| {
            let [a, b, _, d] = [a, b, c, d].map(|i| points[i as usize]);
            Primitive::Parallelogram { corner: a, u: b - a, v: d - a }
        });
        let scene = of(quads.to_vec());
        assert_eq!(
            leaks(&scene, &points, &corners, Vec3A::ZERO, 0.99 * scale, 500_000),
            0,
            "{scale} of parallelograms"
        );
    }
}

#[test]
fn no_ray_slips_between_placed_triangles() {
    let (points, corners) = tessellated(16, 1.0, Vec3A::ZERO);
    let mut parts = Parts::default();
    parts.mesh(&points, &corners, Surface { material: 0, emitter: None }, Attributes::default()).unwrap();
    let mut random = Random::new(42);
    let placed = placement(&mut random, 0);
    let scene = Geometry::assemble(Parts::default(), vec![Group::build(parts).unwrap()], &[placed]).unwrap();
    let moved: Vec<Vec3A> = points.iter().map(|p| placed.transform.transform_point3(p.as_dvec3()).as_vec3a()).collect();
    let centre = placed.transform.translation.as_vec3a();
    assert_eq!(leaks(&scene, &moved, &corners, centre, 0.3, 500_000), 0);
}

/// Leaves a hit on both sides and says how often the ray meets the same surface at once.
fn caught(scene: &Geometry, random: &mut Random, origin: Vec3A, target: Vec3A, near: f32) -> Option<usize> {
    let hit = scene.closest(origin, target - origin)?;
    let mut again = 0;
    for normal in [hit.normal, -hit.normal] {
        let direction = cosine_direction(normal, [random.unit(), random.unit()]);
        let from = offset(hit.point, normal, hit.reach);
        let next = scene.closest(from, direction);
        again += usize::from(
            next.is_some_and(|h| (h.primitive, h.placement) == (hit.primitive, hit.placement) && h.t < near),
        );
    }
    Some(again)
}

#[test]
fn no_surface_is_met_twice() {
    let mut random = Random::new(51);
    for (away, size) in [(0.0, 0.5), (1.0, 1e-2), (50.0, 3.0), (1e4, 300.0)] {
        let centre = random.direction() * away;
        let (mut hits, mut again) = (0, 0);
        for _ in 0..300 {
            let primitive = moved(random.primitive(1.0), size, centre);
            // Flat ones are never met again; round ones may be, across the room.
            let near = match primitive {
                Primitive::Sphere { radius, .. } | Primitive::Cylinder { radius, .. } if radius < 0.05 * size => {
                    continue;
                }
                Primitive::Cone { radii, .. } if radii[0].min(radii[1]) < 0.05 * size => continue,
                Primitive::Sphere { .. } | Primitive::Cylinder { .. } | Primitive::Cone { .. } => 1e-3 * size,
                _ => f32::INFINITY,
            };
            let scene = of(vec![primitive]);
            for _ in 0..200 {
                let (origin, target) = (centre + random.direction() * (4.0 * size), centre + random.cube() * size);
                if let Some(n) = caught(&scene, &mut random, origin, target, near) {
                    hits += 1;
                    again += n;
                }
            }
        }
        assert!(hits > 3000 && again == 0, "{again} of {hits} at {away}");
    }
}

/// A wide floor met near its middle is as uncertain as its far corners; a lamp seen from far off as its distance.
#[test]
fn wide_floors_and_far_lamps_do_not_hide_themselves() {
    let mut random = Random::new(53);
    for size in [1.0f32, 30.0, 1e3, 1e5] {
        for i in 0..2000u32 {
            let turn = |x: f32, y: f32| vec3a(x, y, 0.3 * x + 0.1 * y) * size;
            let [a, b, c] = [turn(-1.0, -1.1), turn(1.2, -0.9), turn(-0.8, 1.3)];
            let floor = match i % 2 {
                0 => Primitive::Triangle([a, b, c]),
                _ => Primitive::Parallelogram { corner: a, u: b - a, v: c - a },
            };
            let scene = of(vec![floor]);
            let Some(n) = caught(&scene, &mut random, vec3a(0.5, 0.2, 3.0), random_near(i), f32::INFINITY) else {
                continue;
            };
            assert_eq!(n, 0, "floor of {size}");
        }
    }
    for away in [10.0f32, 1e3, 1e5] {
        for i in 0..2000 {
            let lamp = random.primitive(0.5);
            let scene = of(vec![lamp]);
            let from = random.direction() * away;
            let Some(hit) = scene.closest(from, random.cube() * 0.3 - from) else { continue };
            let side = if hit.normal.dot(from) > 0.0 { hit.normal } else { -hit.normal };
            // What a lamp is aimed at lies off it by what its own coordinates are worth.
            assert!(scene.visible(from, offset(hit.point, side, 1.0)), "{i}: {lamp:?} from {from}");
        }
    }
}

fn random_near(i: u32) -> Vec3A {
    let mut random = Random::new(u64::from(i));
    random.cube() * 0.5
}

fn moved(primitive: Primitive, size: f32, by: Vec3A) -> Primitive {
    match primitive {
        Primitive::Triangle(v) => Primitive::Triangle(v.map(|p| p * size + by)),
        Primitive::Parallelogram { corner, u, v } => {
            Primitive::Parallelogram { corner: corner * size + by, u: u * size, v: v * size }
        }
        Primitive::Sphere { center, radius, inward } => {
            Primitive::Sphere { center: center * size + by, radius: radius * size, inward }
        }
        Primitive::Disk { center, normal, radius, inner_radius } => Primitive::Disk {
            center: center * size + by,
            normal,
            radius: radius * size,
            inner_radius: inner_radius * size,
        },
        Primitive::Cylinder { base, axis, radius, inward } => {
            Primitive::Cylinder { base: base * size + by, axis: axis * size, radius: radius * size, inward }
        }
        Primitive::Cone { base, axis, radii, inward } => {
            Primitive::Cone { base: base * size + by, axis: axis * size, radii: radii.map(|r| r * size), inward }
        }
    }
}

#[test]
fn no_placed_surface_is_met_twice() {
    let mut random = Random::new(52);
    let (points, corners) = tessellated(12, 1.0, Vec3A::ZERO);
    let mut parts = Parts::default();
    parts.mesh(&points, &corners, Surface { material: 0, emitter: None }, Attributes::default()).unwrap();
    let group = Group::build(parts).unwrap();
    let placements: Vec<Placement> = (0..50)
        .map(|i| {
            let mut p = placement(&mut random, 0);
            p.transform.translation *= [0.0, 1.0, 30.0, 1000.0][i % 4];
            p
        })
        .collect();
    let scene = Geometry::assemble(Parts::default(), vec![group], &placements).unwrap();
    let (mut hits, mut again) = (0, 0);
    for i in 0..20_000 {
        let centre = placements[i % placements.len()].transform.translation.as_vec3a();
        let (origin, target) = (centre + random.direction() * 3.0, centre + random.cube() * 0.5);
        if let Some(n) = caught(&scene, &mut random, origin, target, f32::INFINITY) {
            hits += 1;
            again += n;
        }
    }
    assert!(hits > 10_000 && again == 0, "{again} of {hits}");
}

#[test]
fn no_number_is_met_by_no_ray() {
    let mut random = Random::new(61);
    let group = Group::build(parts((0..50).map(|_| random.primitive(0.5)).collect())).unwrap();
    let placements = [placement(&mut random, 0)];
    let scene =
        Geometry::assemble(parts((0..50).map(|_| random.primitive(0.5)).collect()), vec![group], &placements).unwrap();
    let odd =
        [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-42, -1e30];
    for _ in 0..200_000 {
        let mut pick = || odd[(random.unit() * odd.len() as f32) as usize % odd.len()];
        let (origin, direction) = (vec3a(pick(), pick(), pick()), vec3a(pick(), pick(), pick()));
        let hit = scene.closest(origin, direction);
        let clear = scene.unoccluded(origin, direction);
        scene.visible(origin, direction);
        if !origin.is_finite() || !direction.is_finite() || direction == Vec3A::ZERO {
            assert!(hit.is_none() && clear, "{origin} {direction} {hit:?}");
        }
        if let Some(h) = hit {
            assert!(h.t > 0.0 && h.t.is_finite() && h.point.is_finite() && h.normal.is_normalized(), "{h:?}");
            assert!(h.bary.iter().all(|b| b.is_finite()), "{origin} {direction} {h:?}");
        }
    }
}

#[test]
fn flattened_shapes_do_no_harm() {
    let p = vec3a(0.1, 0.2, 0.3);
    let flat = [
        Primitive::Triangle([p, p, p]),
        Primitive::Triangle([p, p + Vec3A::X, p + Vec3A::X * 2.0]),
        Primitive::Parallelogram { corner: p, u: Vec3A::X, v: Vec3A::ZERO },
        Primitive::Sphere { center: p, radius: 0.0, inward: false },
        Primitive::Disk { center: p, normal: Vec3A::ZERO, radius: 1.0, inner_radius: 0.0 },
        Primitive::Disk { center: p, normal: Vec3A::Z, radius: 0.5, inner_radius: 0.6 },
        Primitive::Cylinder { base: p, axis: Vec3A::ZERO, radius: 1.0, inward: false },
    ];
    let scene = of(flat.to_vec());
    let mut random = Random::new(71);
    for i in 0..10_000 {
        let origin = random.cube() * 2.0;
        let target = if i % 2 == 0 { p } else { p + Vec3A::X * random.unit() };
        // What has the extent of a line closes a crack between its neighbours, and faces the ray.
        if let Some(h) = scene.closest(origin, target - origin) {
            let on = h.point.x >= p.x && h.point.x <= p.x + 2.0 && h.point.y == p.y && h.point.z == p.z;
            assert!((1..=2).contains(&h.primitive) && on, "{h:?}");
            assert!(h.normal.is_normalized() && h.normal.dot(target - origin) < 0.0, "{h:?}");
        }
    }
}

#[test]
fn halved_trees_find_the_same_and_stay_shallow() {
    let mut random = Random::new(81);
    let mut scene = of((0..3000).map(|_| random.primitive(0.1)).collect());
    let rays: Vec<(Vec3A, Vec3A)> = (0..5000).map(|_| (random.cube() * 1.5, random.direction())).collect();
    let before: Vec<_> = rays.iter().map(|(o, d)| scene.closest(*o, *d)).collect();
    let mut random = Random::new(81);
    let primitives: Vec<Primitive> = (0..3000).map(|_| random.primitive(0.1)).collect();
    scene.scene.tree = Tree::halved(tree::Items { primitives: &primitives, placed: &[] });
    assert!(scene.scene.tree.stacked <= DEEP);
    for ((o, d), before) in rays.iter().zip(before) {
        assert!(same(scene.closest(*o, *d), before));
    }
    // Spheres each half of the last, all in one point, and many in one place.
    for sizes in [0.5f32, 1.0] {
        let nested: Vec<Primitive> = (0..5000)
            .map(|i| Primitive::Sphere {
                center: Vec3A::ONE * sizes.powi(i % 120),
                radius: sizes.powi(i % 120),
                inward: false,
            })
            .collect();
        let scene = of(nested);
        assert!(scene.scene.tree.stacked <= DEEP, "{}", scene.scene.tree.stacked);
        assert!(scene.closest(vec3a(3.0, 0.9, 0.9), -Vec3A::X).is_some());
    }
}
