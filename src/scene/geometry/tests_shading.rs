use glam::{DAffine3, DQuat, DVec3, Vec3A, vec3a};

use super::*;

const PLAIN: Surface = Surface { material: 3, emitter: None };

/// Two triangles of a square in z = 0 from 0 to 1, wound so that the front is +z, normals leaning outwards.
fn square(flip: f32) -> Parts {
    let points = [Vec3A::ZERO, Vec3A::X, vec3a(1.0, 1.0, 0.0), Vec3A::Y];
    let attributes = Attributes {
        corners: vec![[0, 1, 2], [0, 2, 3]],
        normals: points.iter().map(|p| ((*p - vec3a(0.5, 0.5, -1.0)) * (2.0 * flip)).to_array()).collect(),
        uv: points.iter().map(|p| [2.0 * p.x, 1.0 - p.y]).collect(),
        colours: points.iter().map(|p| [p.x, p.y, 0.25]).collect(),
    };
    let mut parts = Parts::default();
    parts.push(Primitive::Sphere { center: vec3a(9.0, 9.0, 9.0), radius: 1.0, inward: false }, PLAIN);
    parts.mesh(&points, &[[0, 1, 2], [0, 2, 3]], PLAIN, attributes).unwrap();
    parts.push(Primitive::Triangle([vec3a(5.0, 0.0, 0.0), vec3a(6.0, 0.0, 0.0), vec3a(5.0, 1.0, 0.0)]), PLAIN);
    parts
}

#[test]
fn attributes_are_linear_over_a_mesh() {
    // Normals that point to the back are turned: the winding says where the front is.
    for flip in [1.0, -1.0] {
        let scene = Geometry::assemble(square(flip), Vec::new(), &[]).unwrap();
        for (x, y) in [(0.25, 0.125), (0.125, 0.75), (0.9, 0.8), (0.5, 0.5)] {
            let hit = scene.closest(vec3a(x, y, 2.0), -Vec3A::Z).unwrap();
            let shading = scene.shading(&hit);
            let expected = vec3a(x - 0.5, y - 0.5, 1.0).normalize();
            assert!(shading.normal.distance(expected) < 1e-6, "{shading:?} {expected}");
            assert!((shading.uv[0] - 2.0 * x).abs() < 1e-6 && (shading.uv[1] - (1.0 - y)).abs() < 1e-6);
            let colour = shading.colour.unwrap();
            assert!((colour[0] - x).abs() < 1e-6 && (colour[1] - y).abs() < 1e-6 && (colour[2] - 0.25).abs() < 1e-6);
            assert_eq!(hit.normal, Vec3A::Z);
        }
        let without = scene.closest(vec3a(5.25, 0.25, 2.0), -Vec3A::Z).unwrap();
        let expected = Shading { normal: Vec3A::Z, uv: [0.25, 0.25], colour: None };
        assert_eq!(scene.shading(&without), expected);
    }
}

#[test]
fn placed_meshes_shade_as_if_moved() {
    let turn = DQuat::from_rotation_x(1.0) * DQuat::from_rotation_y(-0.4);
    for scale in [DVec3::new(2.0, 2.0, 2.0), DVec3::new(0.5, 3.0, -1.0)] {
        let transform = DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(0.5, -3.0, 2.0));
        let placement = Placement { group: 0, transform, material: Some(7) };
        let groups = vec![Group::build(square(1.0)).unwrap()];
        let scene = Geometry::assemble(Parts::default(), groups, &[placement]).unwrap();
        let (x, y) = (0.3, 0.6);
        let target = transform.transform_point3(DVec3::new(x, y, 0.0));
        let above = transform.transform_point3(DVec3::new(x, y, 1.5));
        let hit = scene.closest(above.as_vec3a(), (target - above).as_vec3a()).unwrap();
        assert!((hit.t - 1.0).abs() < 1e-6 && hit.point.distance(target.as_vec3a()) < 1e-6, "{hit:?}");
        assert_eq!((hit.surface, hit.placement), (Surface { material: 7, emitter: None }, Some(0)));
        // Normals of a surface are the directions its two tangents have none of: moved tangents say which.
        let normal = |n: DVec3| {
            let (s, t) = n.any_orthonormal_pair();
            let n = transform.transform_vector3(s).cross(transform.transform_vector3(t)).normalize();
            let front = (above - target).dot(n);
            if front < 0.0 { -n } else { n }
        };
        let smooth = normal(DVec3::new(x - 0.5, y - 0.5, 1.0).normalize()).as_vec3a();
        let shading = scene.shading(&hit);
        assert!(shading.normal.distance(smooth) < 1e-6, "{shading:?} {smooth}");
        assert!(hit.normal.distance(normal(DVec3::Z).as_vec3a()) < 1e-6, "{hit:?}");
        assert!((shading.uv[0] - 0.6).abs() < 1e-6 && (shading.uv[1] - 0.4).abs() < 1e-6);
    }
}

fn error<T>(result: Result<T>) -> String {
    result.err().map_or(String::new(), |e| e.to_string())
}

#[test]
fn what_does_not_fit_is_refused() {
    let square = || square(1.0);
    assert_eq!(error(Geometry::build(Vec::new(), Vec::new())), "the scene has no shape");
    assert_eq!(error(Group::build(Parts::default())), "the group has no shape");
    let mut parts = square();
    parts.surfaces.pop();
    assert_eq!(error(Group::build(parts)), "4 shapes have 3 surfaces");
    let mut parts = square();
    parts.primitives[3] = Primitive::Sphere { center: vec3a(0.0, f32::NAN, 0.0), radius: 1.0, inward: true };
    assert_eq!(error(Group::build(parts)), "shape 3 has a coordinate that is no finite number");
    let mut parts = square();
    parts.surfaces[1].emitter = Some(0);
    assert_eq!(error(Group::build(parts)), "shape 1 of a group shines; only shapes that are placed once can");
    let mut parts = square();
    parts.attributes[0].1.uv.pop();
    assert_eq!(error(Group::build(parts)), "a triangle's corner 3 is beyond the 3 uv");
    for first in [0, 3, u32::MAX] {
        let mut parts = square();
        parts.attributes[0].0 = first;
        let expected = format!("attributes for 2 triangles from shape {first} on, which are not there");
        assert_eq!(error(Group::build(parts)), expected);
    }
    let corners = Parts::default().mesh(&[Vec3A::ZERO; 2], &[[0, 1, 2]], PLAIN, Attributes::default());
    assert_eq!(error(corners), "triangle 0 names points [0, 1, 2], but there are 2");
    let place = |group, transform| {
        let groups = vec![Group::build(square()).unwrap()];
        error(Geometry::assemble(Parts::default(), groups, &[Placement { group, transform, material: None }]))
    };
    assert_eq!(place(1, DAffine3::IDENTITY), "placement 0 is of group 1, but there are 1");
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(place(0, flat), "placement 0 has a transform that cannot be undone");
    let huge = DAffine3::from_scale(DVec3::splat(1e39));
    assert_eq!(place(0, huge), "placement 0 reaches beyond the numbers of floats");
}
