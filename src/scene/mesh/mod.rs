//! Triangle meshes from files. One format, one file, one line in [`load`].
//!
//! | suffix | what is read |
//! |---|---|
//! | .obj | [`obj`]: polygons, normals, texture coordinates, colours of vertices, `usemtl` groups |
//! | .ply | [`ply`]: the same from ascii and both binary orders; no groups |
//! | .gltf, .glb | [`gltf`]: the default scene, every node in its place; groups by material |
//!
//! Coordinates are floats about the mesh's own [`Mesh::origin`]: 12 bytes a vertex, and a tower in map coordinates of a
//! million metres keeps the digits of one at zero. The origin follows the first vertex where that lies far out.
//!
//! What every file must hold, else it is refused and the face named: finite coordinates, normals with a direction, colours
//! within 0 to 1, corners that exist. Faces without area are found by [`Mesh::check`], which knows whether to refuse them;
//! [`Mesh::smooth`] makes normals where the file has none; [`Mesh::transform`] puts the mesh in its place.
//!
//! Texture coordinates have v = 0 at the bottom of the picture. Colours are linear sRGB; those of whole numbers in a PLY are
//! taken as sRGB-coded, floats and everything in glTF as linear.

mod check;
pub mod gltf;
pub mod obj;
pub mod ply;
pub(crate) mod polygon;
pub mod shape;
mod smooth;

use std::ops::Range;
use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::printable;
use crate::scene::transform::Transform;
use crate::{Error, Result, invalid};

pub use check::Degenerate;
pub use smooth::Sides;

/// From here out a float resolves a thousandth of a unit at best: the origin leaves zero.
const FAR: f64 = 16384.0;

/// Triangles over shared corners; every index is in range, every number finite.
///
/// `normals`, `uvs` and `colours` run along `positions` where they are there at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Where the corners' numbers begin, in the file's unit.
    pub origin: DVec3,
    /// Corners, in the file's unit, from the origin on.
    pub positions: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit vectors; zero where the file states none: there the face's own is meant.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates, v upward; 0 0 where the file states none.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Linear sRGB, 0..1; white where the file states none.
    pub colours: Option<Vec<[f32; 3]>>,
    /// Triangles by material: one range after the other, all of them covered.
    pub groups: Vec<Group>,
    places: Places,
}

/// Consecutive triangles of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The material's name in the file; empty where it states none.
    pub name: String,
    /// Which triangles.
    pub triangles: Range<usize>,
}

/// Where triangles stand in the file, for messages.
#[derive(Clone, Debug, Default, PartialEq)]
struct Places {
    /// Of each triangle: the line of its face, or its face's number from 1 within its part.
    of: Vec<u32>,
    lines: bool,
    /// Parts of the file, each with its first triangle.
    parts: Vec<(usize, String)>,
}

/// Reads a mesh by its suffix.
pub fn load(path: &Path) -> Result<Mesh> {
    let suffix = path.extension().and_then(|s| s.to_str()).unwrap_or("").to_ascii_lowercase();
    let parse: fn(&[u8], &Path) -> Result<Mesh> = match suffix.as_str() {
        "obj" => |bytes, _| obj::parse(bytes),
        "ply" => |bytes, _| ply::parse(bytes),
        "gltf" | "glb" => gltf::parse_beside,
        _ => {
            return Err(Error::Unsupported(format!(
                "'{}' is no mesh; known suffixes are .obj, .ply, .gltf and .glb",
                path.display()
            )));
        }
    };
    let bytes =
        crate::files::read(path).map_err(|e| Error::Invalid(format!("cannot read '{}': {e}", path.display())))?;
    parse(&bytes, path.parent().unwrap_or(Path::new("."))).map_err(|e| e.in_file(path))
}

impl Mesh {
    /// From corners and triangles, three corners each, counter-clockwise from the front; in one group without a name.
    pub fn new(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Mesh> {
        let mut mesh = Mesh::default();
        positions.iter().for_each(|p| mesh.corner(DVec3::from(*p)));
        for (i, t) in triangles.iter().enumerate() {
            mesh.polygon(t, i as u32 + 1, || format!("face {}", i + 1))?;
        }
        mesh.finished()
    }

    /// A corner's place, in the file's unit or wherever [`Mesh::transform`] put it.
    pub fn place(&self, corner: u32) -> DVec3 {
        self.origin + Vec3::from(self.positions[corner as usize]).as_dvec3()
    }

    /// A triangle's corners about the mesh's origin.
    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|c| Vec3::from(self.positions[c as usize]).as_dvec3())
    }

    /// Moves the mesh: places, normals, and the winding where the transform mirrors.
    pub fn transform(&mut self, by: &Transform) {
        let linear = by.affine().matrix3;
        self.origin = by.point(self.origin);
        for p in &mut self.positions {
            *p = (linear * Vec3::from(*p).as_dvec3()).as_vec3().to_array();
        }
        for n in self.normals.iter_mut().flatten() {
            *n = by.normal(Vec3::from(*n).as_dvec3()).as_vec3().to_array();
        }
        if by.mirrors() {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }

    /// Adds a corner; the first settles the origin. Whether it is finite, [`Mesh::finished`] says.
    fn corner(&mut self, p: DVec3) {
        if self.positions.is_empty() {
            let far = |x: f64| if x.is_finite() && x.abs() >= FAR { x.round() } else { 0.0 };
            self.origin = DVec3::new(far(p.x), far(p.y), far(p.z));
        }
        self.positions.push((p - self.origin).as_vec3().to_array());
    }

    /// Adds a face of three corners and more that the file has at `place`. Corners are checked against `positions`, for the
    /// cut into triangles needs them.
    fn polygon(&mut self, corners: &[u32], place: u32, what: impl Fn() -> String) -> Result<()> {
        if let Some(bad) = corners.iter().find(|c| **c as usize >= self.positions.len()) {
            return invalid!("{}: corner {} of {} vertices", what(), u64::from(*bad) + 1, self.positions.len());
        }
        match corners {
            [a, b, c] => self.triangles.push([*a, *b, *c]),
            [_, _, _, _, ..] => {
                let places: Vec<DVec3> =
                    corners.iter().map(|c| Vec3::from(self.positions[*c as usize]).as_dvec3()).collect();
                let cut = polygon::cut(&places).map_err(|e| Error::Invalid(format!("{}: {e}", what())))?;
                self.triangles.extend(cut.iter().map(|t| t.map(|i| corners[i])));
            }
            _ => return invalid!("{}: a face needs three corners, this has {}", what(), corners.len()),
        }
        self.places.of.resize(self.triangles.len(), place);
        Ok(())
    }

    /// Begins a group at the next triangle; one that got no triangle is forgotten.
    fn group(&mut self, name: &str) {
        self.end_group();
        let at = self.triangles.len();
        match self.groups.last() {
            Some(last) if last.name == name => {}
            _ => self.groups.push(Group { name: name.to_string(), triangles: at..at }),
        }
    }

    fn end_group(&mut self) {
        let at = self.triangles.len();
        match self.groups.last_mut() {
            Some(last) => last.triangles.end = at,
            None if at > 0 => self.groups.push(Group { name: String::new(), triangles: 0..at }),
            None => {}
        }
        self.groups.pop_if(|g| g.triangles.is_empty());
    }

    /// The mesh after its last face, if it has one and all that its faces use is finite.
    fn finished(mut self) -> Result<Mesh> {
        self.end_group();
        if self.triangles.is_empty() {
            return invalid!("no face found");
        }
        let wrong = |c: u32| !self.positions[c as usize].iter().all(|x| x.is_finite());
        if let Some((t, c)) =
            self.triangles.iter().enumerate().find_map(|(t, c)| Some((t, *c.iter().find(|c| wrong(**c))?)))
        {
            return invalid!("{}: vertex {} is not finite", self.face(t), u64::from(c) + 1);
        }
        if let Some(c) = (0..self.positions.len() as u32).find(|c| wrong(*c)) {
            return invalid!("vertex {}, which no face uses, is not finite", u64::from(c) + 1);
        }
        Ok(self)
    }

    /// How a message names a triangle's face.
    fn face(&self, triangle: usize) -> String {
        let places = &self.places;
        let Some(at) = places.of.get(triangle) else { return format!("triangle {}", triangle + 1) };
        if places.lines {
            let faces = places.of[..=triangle].chunk_by(|a, b| a == b).count();
            return format!("face {faces} (line {at})");
        }
        match places.parts[..places.parts.partition_point(|p| p.0 <= triangle)].last() {
            Some((_, part)) => format!("{part}: face {at}"),
            None => format!("face {at}"),
        }
    }
}

/// A stated normal at unit length.
fn direction(n: [f64; 3], what: impl Fn() -> String) -> Result<[f32; 3]> {
    let unit = DVec3::from(n).normalize_or_zero();
    if unit == DVec3::ZERO || !unit.is_finite() {
        return invalid!("{}: the normal {} {} {} has no direction", what(), n[0], n[1], n[2]);
    }
    Ok(unit.as_vec3().to_array())
}

/// Texture coordinates, which must be finite.
fn texture_place(uv: [f64; 2], what: impl Fn() -> String) -> Result<[f32; 2]> {
    let floats = uv.map(|x| x as f32);
    if !floats.iter().all(|x| x.is_finite()) {
        return invalid!("{}: a texture coordinate is not finite", what());
    }
    Ok(floats)
}

/// A linear colour, which must be one of a surface.
fn colour(c: [f64; 3], what: impl Fn() -> String) -> Result<[f32; 3]> {
    if !c.iter().all(|x| (0.0..=1.0).contains(x)) {
        return invalid!("{}: the colour {} {} {} must lie in 0 to 1", what(), c[0], c[1], c[2]);
    }
    Ok(c.map(|x| x as f32))
}

/// A word of the file, for a message.
fn shown(word: &str) -> String {
    printable(word.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn made_from_numbers() {
        let corners = [[1e6, 0.0, 0.0], [1e6 + 1e-3, 0.0, 0.0], [1e6, 2e-3, 0.0]];
        let mut mesh = Mesh::new(&corners, &[[0, 1, 2]]).unwrap();
        assert!((mesh.place(1).x - corners[1][0]).abs() < 1e-9);
        assert_eq!(mesh.check(Degenerate::Refuse).unwrap(), 0);
        for (triangle, word) in [([0, 1, 3], "face 1: corner 4 of 3"), ([0, 1, 1], "face 1: it has the same corner")] {
            let made = Mesh::new(&corners, &[triangle]);
            let message = made.and_then(|mut m| m.check(Degenerate::Refuse)).unwrap_err().to_string();
            assert!(message.starts_with(word), "{message}");
        }
        assert!(
            Mesh::new(&[[f64::NAN; 3]; 3], &[[0, 1, 2]]).unwrap_err().to_string().contains("vertex 1 is not finite")
        );
    }

    #[test]
    fn suffixes_decide() {
        assert!(load(Path::new("a.stl")).unwrap_err().to_string().contains(".obj, .ply, .gltf and .glb"));
        assert!(load(Path::new("/nowhere/a.glb")).unwrap_err().to_string().contains("cannot read '/nowhere/a.glb'"));
    }

    /// All that the fields promise.
    fn sound(mesh: &Mesh) {
        let n = mesh.positions.len();
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()) && mesh.origin.is_finite());
        assert!(mesh.triangles.iter().flatten().all(|c| (*c as usize) < n));
        assert!(mesh.normals.iter().flatten().all(|x| {
            let length = Vec3::from(*x).length();
            length == 0.0 || (length - 1.0).abs() < 1e-5
        }));
        assert!(mesh.uvs.iter().flatten().flatten().all(|x| x.is_finite()));
        assert!(mesh.colours.iter().flatten().flatten().all(|x| (0.0..=1.0).contains(x)));
        for along in
            [mesh.normals.as_ref().map(Vec::len), mesh.uvs.as_ref().map(Vec::len), mesh.colours.as_ref().map(Vec::len)]
        {
            assert!(along.is_none_or(|len| len == n));
        }
        let mut next = 0;
        for g in &mesh.groups {
            assert!(g.triangles.start == next && g.triangles.end > next);
            next = g.triangles.end;
        }
        assert_eq!((next, mesh.places.of.len()), (mesh.triangles.len(), mesh.triangles.len()));
    }

    /// Bytes changed, cut out and repeated at random: an error in one line, or a mesh that keeps every promise, through all
    /// that is done to meshes.
    #[test]
    fn damage_is_refused_or_harmless() {
        let data = |name: &str| {
            std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mesh").join(name)).unwrap()
        };
        let obj = b"v 0 0 0 1 .5 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 1\nvt 1 1\nvn 0 0 1\n\
            usemtl a\nf 1/1/1 2/2/1 3//1 4\nusemtl b\nf 1 -3 -2\n";
        let head = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar uchar vertex_indices\nend_header\n";
        let ascii = format!("ply\nformat ascii 1.0\n{head}0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n3 2 1 0\n")
            .into_bytes();
        let mut binary = format!("ply\nformat binary_little_endian 1.0\n{head}").into_bytes();
        for p in [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            p.iter().for_each(|x| binary.extend(x.to_le_bytes()));
            binary.extend([9, 8, 7]);
        }
        binary.extend([3, 0, 1, 2, 3, 2, 1, 0]);
        type Parse = fn(&[u8]) -> Result<Mesh>;
        let gltf: Parse = |b| gltf::parse_beside(b, Path::new("/nowhere"));
        let files: [(Vec<u8>, Parse); 6] = [
            (obj.to_vec(), obj::parse),
            (ascii, ply::parse),
            (binary, ply::parse),
            (data("modes.glb"), gltf),
            (data("cube.glb"), gltf),
            (data("cube_base64.gltf"), gltf),
        ];
        let mut state = 1u64;
        let mut random = |below: usize| {
            // Knuth's MMIX generator.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as usize) % below.max(1)
        };
        for (whole, parse) in files {
            sound(&parse(&whole).unwrap());
            let mut passed = 0;
            for _ in 0..4000 {
                let mut bad = whole.clone();
                for _ in 0..=random(3) {
                    let at = random(bad.len());
                    let span = at..(at + random(9)).min(bad.len());
                    match random(4) {
                        0 => drop(bad.drain(span)),
                        1 => bad.extend_from_within(span),
                        2 => bad[at] = b"0123456789-.e/[]{},\"\xff\x00"[random(22)],
                        _ => bad[at] = random(256) as u8,
                    }
                }
                match parse(&bad) {
                    Err(e) => assert_eq!(e.to_string().lines().count(), 1, "{e}"),
                    Ok(mut mesh) => {
                        passed += 1;
                        sound(&mesh);
                        if mesh.check(Degenerate::Skip).is_ok() {
                            sound(&mesh);
                            assert_eq!(mesh.check(Degenerate::Refuse).unwrap(), 0);
                            mesh.turn_normals();
                            mesh.smooth(30.0);
                            sound(&mesh);
                        }
                    }
                }
            }
            assert!(passed > 20, "{passed} of 4000 passed: damage too great to tell");
        }
    }
}
