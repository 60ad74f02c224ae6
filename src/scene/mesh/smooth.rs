//! Normals of vertices: made where a file has none, and turned to the front where they point behind it.

use glam::DVec3;

use super::Mesh;

/// What [`Mesh::turn_normals`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Normals that pointed behind all faces of their vertex, and were turned.
    pub turned: usize,
    /// Normals in front of some faces of their vertex and behind others, and left.
    pub mixed: usize,
}

impl Mesh {
    /// A triangle's unit normal; zero without area.
    fn face_normal(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(self.triangles[t]);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Turns stated normals that point behind every face of their vertex: files that wind one way and point the other.
    pub fn turn_normals(&mut self) -> Sides {
        let Some(mut normals) = self.normals.take() else { return Sides::default() };
        const FRONT: u8 = 1;
        const BEHIND: u8 = 2;
        let mut seen = vec![0u8; normals.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let face = self.face_normal(t);
            for c in corners.map(|c| c as usize) {
                let dot = DVec3::from(normals[c].map(f64::from)).dot(face);
                seen[c] |= if dot > 0.0 { FRONT } else { BEHIND * u8::from(dot < 0.0) };
            }
        }
        let mut sides = Sides::default();
        for (n, seen) in normals.iter_mut().zip(seen) {
            if seen == BEHIND {
                *n = n.map(|x| -x);
                sides.turned += 1;
            }
            sides.mixed += usize::from(seen == FRONT | BEHIND);
        }
        self.normals = Some(normals);
        sides
    }

    /// Makes normals for corners that have none: the mean of the faces about a vertex, each weighted by its angle there
    /// [Thürmer & Wüthrich 1998]. Faces belong together as far as edges of at most `crease_deg` between their normals join
    /// them about the vertex; beyond, the vertex is split. Vertices at one place count as one, whatever else they carry.
    pub fn smooth(&mut self, crease_deg: f64) {
        let crease = crease_deg.clamp(0.0, 180.0).to_radians().cos();
        let faces: Vec<[f32; 3]> =
            (0..self.triangles.len()).map(|t| self.face_normal(t).as_vec3().to_array()).collect();
        let stated = self.normals.take();
        let mut normals = stated.unwrap_or_else(|| vec![[0.0; 3]; self.positions.len()]);
        let had: Vec<bool> = normals.iter().map(|n| *n != [0.0; 3]).collect();
        let (place, order) = self.corners_by_place();
        let mut taken = vec![false; self.positions.len()];
        let mut about = About::default();
        for corners in order.chunk_by(|a, b| place[*a as usize] == place[*b as usize]) {
            about.gather(self, &place, &faces, corners, crease);
            let mut assigned: Vec<(u32, u32, usize)> =
                (0..corners.len()).map(|i| (self.vertex(corners[i]), about.root(i) as u32, i)).collect();
            assigned.retain(|a| !had[a.0 as usize]);
            assigned.sort_unstable();
            for same in assigned.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
                let (vertex, root, _) = same[0];
                let normal = about.sums[root as usize].normalize_or_zero().as_vec3().to_array();
                let new = if std::mem::replace(&mut taken[vertex as usize], true) {
                    self.copy_vertex(vertex, &mut normals)
                } else {
                    vertex
                };
                normals[new as usize] = normal;
                for (_, _, i) in same {
                    let corner = corners[*i] as usize;
                    self.triangles[corner / 3][corner % 3] = new;
                }
            }
        }
        self.normals = Some(normals);
    }

    /// Vertex of a corner, corners numbered three a triangle.
    fn vertex(&self, corner: u32) -> u32 {
        self.triangles[corner as usize / 3][corner as usize % 3]
    }

    /// For every corner the number of its place, and all corners in order of these.
    fn corners_by_place(&self) -> (Vec<u32>, Vec<u32>) {
        // 0 and -0 are one place.
        let bits = |v: u32| self.positions[v as usize].map(|x| (x + 0.0).to_bits());
        let mut vertices: Vec<u32> = (0..self.positions.len() as u32).collect();
        vertices.sort_unstable_by_key(|v| bits(*v));
        let mut number = vec![0u32; vertices.len()];
        for (n, same) in vertices.chunk_by(|a, b| bits(*a) == bits(*b)).enumerate() {
            same.iter().for_each(|v| number[*v as usize] = n as u32);
        }
        let place: Vec<u32> = self.triangles.iter().flatten().map(|v| number[*v as usize]).collect();
        let mut order: Vec<u32> = (0..place.len() as u32).collect();
        order.sort_unstable_by_key(|c| (place[*c as usize], *c));
        (place, order)
    }

    fn copy_vertex(&mut self, vertex: u32, normals: &mut Vec<[f32; 3]>) -> u32 {
        let v = vertex as usize;
        self.positions.push(self.positions[v]);
        normals.push([0.0; 3]);
        if let Some(uvs) = &mut self.uvs {
            uvs.push(uvs[v]);
        }
        if let Some(colours) = &mut self.colours {
            colours.push(colours[v]);
        }
        self.positions.len() as u32 - 1
    }
}

/// The corners about one place, joined into smooth parts.
#[derive(Default)]
struct About {
    parent: Vec<usize>,
    /// By root, the weighted sum of normals.
    sums: Vec<DVec3>,
    /// Edges that leave the place: where to, and which corner's face they bound.
    edges: Vec<(u32, usize)>,
}

impl About {
    fn gather(&mut self, mesh: &Mesh, place: &[u32], faces: &[[f32; 3]], corners: &[u32], crease: f64) {
        self.parent.clear();
        self.parent.extend(0..corners.len());
        self.edges.clear();
        let normal = |i: usize| DVec3::from(faces[corners[i] as usize / 3].map(f64::from));
        for (i, corner) in corners.iter().enumerate() {
            let (t, k) = (corner / 3, corner % 3);
            self.edges.extend([(place[(3 * t + (k + 1) % 3) as usize], i), (place[(3 * t + (k + 2) % 3) as usize], i)]);
        }
        self.edges.sort_unstable();
        for e in 1..self.edges.len() {
            let ((to, i), (also, j)) = (self.edges[e - 1], self.edges[e]);
            // A float's rounding must not crease what is flat.
            if to == also && normal(i).dot(normal(j)) >= crease - 1e-6 {
                let (a, b) = (self.root(i), self.root(j));
                self.parent[a.max(b)] = a.min(b);
            }
        }
        self.sums.clear();
        self.sums.resize(corners.len(), DVec3::ZERO);
        for (i, corner) in corners.iter().enumerate() {
            let (t, k) = (*corner as usize / 3, *corner as usize % 3);
            let p = mesh.corners(mesh.triangles[t]);
            let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            let angle = u.cross(v).length().atan2(u.dot(v));
            let root = self.root(i);
            self.sums[root] += normal(i) * angle;
        }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::scene::mesh::obj;

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

    /// At a cube's corner, three right angles, whichever way its squares are cut: the mean is the diagonal. Unweighted, a
    /// square cut through the corner would count twice.
    #[test]
    fn a_cubes_normals_are_its_diagonals() {
        let mut mesh = obj::parse(CUBE.as_bytes()).unwrap();
        mesh.smooth(91.0);
        assert_eq!(mesh.positions.len(), 8);
        for (p, n) in mesh.positions.iter().zip(mesh.normals.unwrap()) {
            for k in 0..3 {
                assert!((n[k] - (2.0 * p[k] - 1.0) / 3f32.sqrt()).abs() < 1e-6, "{p:?}: {n:?}");
            }
        }
    }

    #[test]
    fn beyond_the_crease_faces_keep_their_own() {
        let mut mesh = obj::parse(CUBE.as_bytes()).unwrap();
        let before = mesh.clone();
        mesh.smooth(89.0);
        assert_eq!(mesh.positions.len(), 24);
        let normals = mesh.normals.as_ref().unwrap();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let face = before.face_normal(t);
            for (k, c) in corners.iter().enumerate() {
                assert_eq!(DVec3::from(normals[*c as usize].map(f64::from)), face);
                assert_eq!(mesh.place(*c), before.place(before.triangles[t][k]));
            }
        }
    }

    /// Triangles that share no index are one surface all the same; texture places stay apart.
    #[test]
    fn places_join_what_indices_do_not() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0.1\nv 1 0 0\nv 1 1 0.3\nv -0 1 0.1\nvt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 4/2 5/2 6/2\n";
        let mut mesh = obj::parse(text.as_bytes()).unwrap();
        mesh.smooth(30.0);
        let normals = mesh.normals.unwrap();
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(normals[1], normals[3]);
        assert_eq!(normals[2], normals[5]);
        assert_ne!(normals[0], normals[1]);
        assert_eq!(mesh.uvs.unwrap()[3], [1.0, 1.0]);
    }

    /// The octahedron's faces cut in four three times, on to the sphere: its six corners are alike from four sides, so their
    /// normals are the radii; and no mean of faces lies further from the radius than the furthest of them.
    #[test]
    fn a_spheres_normals_are_its_radii() {
        let mut triangles: Vec<[DVec3; 3]> = Vec::new();
        for (x, y, z) in
            (0..8).map(|i| (1.0 - f64::from(i & 2), 1.0 - f64::from((i & 1) * 2), 1.0 - f64::from((i & 4) / 2)))
        {
            let t = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z];
            triangles.push(if x * y * z > 0.0 { t } else { [t[0], t[2], t[1]] });
        }
        for _ in 0..3 {
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [d, e, f] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                })
                .collect();
        }
        let text: String = triangles.iter().flatten().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
        let faces: String =
            (0..triangles.len()).map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3)).collect();
        let mut mesh = obj::parse((text + &faces).as_bytes()).unwrap();
        let cos = |v: u32, n: DVec3| triangles[v as usize / 3][v as usize % 3].dot(n);
        let mut least = HashMap::new();
        for t in 0..triangles.len() {
            for v in mesh.triangles[t] {
                let near = least.entry(mesh.positions[v as usize].map(f32::to_bits)).or_insert(1.0f64);
                *near = near.min(cos(v, mesh.face_normal(t)));
            }
        }
        mesh.smooth(60.0);
        assert_eq!(mesh.positions.len(), 3 * triangles.len());
        for (v, (p, n)) in mesh.positions.iter().zip(mesh.normals.unwrap()).enumerate() {
            let cos = cos(v as u32, DVec3::from(n.map(f64::from)));
            let axis = p.iter().any(|x| x.abs() == 1.0);
            let bound = if axis { 1.0 } else { least[&p.map(f32::to_bits)] };
            assert!(cos > bound - 1e-6, "{p:?}: {n:?}");
        }
    }

    #[test]
    fn normals_that_point_behind_are_turned() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 9\nvn 0 0 -1\nvn 0 0.6 0.8\nvn 1 0 0\n";
        let faces = "f 1//1 2//2 3//1\nf 3//3 2//2 1//3\n";
        let mut mesh = obj::parse(format!("{text}{faces}").as_bytes()).unwrap();
        assert_eq!(mesh.turn_normals(), Sides { turned: 2, mixed: 1 });
        let normals = mesh.normals.as_ref().unwrap();
        assert_eq!((normals[0], normals[1], normals[2]), ([0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]));
        assert_eq!(mesh.turn_normals(), Sides { turned: 0, mixed: 1 });
        assert_eq!(obj::parse(CUBE.as_bytes()).unwrap().turn_normals(), Sides::default());
    }

    /// Stated normals stay, and only the others are made.
    #[test]
    fn only_what_lacks_is_made() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.6 0.8\nf 1//1 2//1 3//1\nf 1 2 3\n";
        let mut mesh = obj::parse(text.as_bytes()).unwrap();
        mesh.smooth(30.0);
        let normals = mesh.normals.unwrap();
        assert_eq!(mesh.triangles[0].map(|c| normals[c as usize]), [[0.0, 0.6, 0.8]; 3]);
        assert_eq!(mesh.triangles[1].map(|c| normals[c as usize]), [[0.0, 0.0, 1.0]; 3]);
    }
}
