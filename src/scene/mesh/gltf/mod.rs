//! glTF 2.0 [Khronos, "glTF 2.0 Specification", ISO/IEC 12113:2022]: JSON with its buffers beside it or within, and GLB.
//!
//! The default scene (else the first; without any, all nodes) comes as one mesh, each node in its place. Of primitives are
//! read triangles, strips and fans, `POSITION`, `NORMAL`, `TEXCOORD_0` and `COLOR_0` (linear) in every number type, so
//! `KHR_mesh_quantization` too, and the material's name, which is the group's. Points, lines, skins, morph targets,
//! animations, cameras, lights and textures are passed over; compressed geometry, instances by extension and sparse data
//! are refused. Stitches of strips (triangles with a corner twice) are no faces.
//!
//! glTF is right-handed, in metres, y upward, and stays so: `rotate_deg = [90, 0, 0]` stands it up where z is upward.

mod data;

use std::path::Path;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec3};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Node, Root};

use super::{Mesh, colour, direction, shown, texture_place};
use crate::{Error, Result, invalid};
use data::{Buffers, Numbers};

/// Triangles of a scene; nodes repeat meshes, so that a small file can ask for any number.
const MOST_TRIANGLES: usize = 1 << 24;
/// No vertex.
const NONE: u32 = u32::MAX;

/// What a required extension begins with that leaves the geometry as it is.
const HARMLESS: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "KHR_lights_punctual", "KHR_mesh_quantization", "EXT_texture_"];

/// Reads a .gltf or .glb whose other files lie in `folder`.
pub fn parse_beside(bytes: &[u8], folder: &Path) -> Result<Mesh> {
    parse(bytes, |uri, length| data::read_file(folder, uri, length))
}

/// Reads a .gltf or .glb; `fetch` gets the first bytes, as many as it is told, of the file that a buffer's URI names.
pub fn parse(bytes: &[u8], fetch: impl Fn(&str, u64) -> Result<Vec<u8>>) -> Result<Mesh> {
    let (json, rest) = data::chunks(bytes)?;
    let root = Root::from_slice(json)
        .map_err(|e| Error::Invalid(format!("its JSON is no glTF 2.0: {}", shown(&e.to_string()))))?;
    if !root.asset.version.starts_with("2.") {
        return Err(Error::Unsupported(format!("glTF version {}; expected 2.0", shown(&root.asset.version))));
    }
    let needs = |e: &&String| !HARMLESS.iter().any(|h| e.starts_with(h));
    if let Some(e) = root.extensions_required.iter().find(needs) {
        return Err(Error::Unsupported(format!("it needs the extension {}, which is not read", shown(e))));
    }
    let buffers = Buffers::new(&root, rest, fetch)?;
    let mut reader = Reader { root: &root, buffers, mesh: Mesh::default() };
    for (node, place) in nodes(&root)? {
        reader.node(node, &place)?;
    }
    reader.mesh.finished()
}

/// The scene's nodes that have a mesh, each with its place in the scene.
fn nodes(root: &Root) -> Result<Vec<(usize, DAffine3)>> {
    let scene = root.scene.map_or(0, |s| s.value());
    let mut left: Vec<(usize, DAffine3)> = match root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(|n| (n.value(), DAffine3::IDENTITY)).collect(),
        None if root.scene.is_some() => return invalid!("scene {scene} is missing"),
        None => {
            let mut child = vec![false; root.nodes.len()];
            let children = root.nodes.iter().flat_map(|n| n.children.iter().flatten());
            children.for_each(|c| child.get_mut(c.value()).into_iter().for_each(|c| *c = true));
            (0..root.nodes.len()).filter(|n| !child[*n]).map(|n| (n, DAffine3::IDENTITY)).collect()
        }
    };
    left.reverse();
    let mut met = vec![false; root.nodes.len()];
    let mut out = Vec::new();
    while let Some((n, parent)) = left.pop() {
        let Some(node) = root.nodes.get(n) else { return invalid!("node {n} is missing") };
        // Nodes are a forest: one that is met again has two parents, or is its own ancestor.
        if std::mem::replace(&mut met[n], true) {
            return invalid!("{}: hangs in the scene twice", node_name(root, n));
        }
        let place = parent
            * local(node).ok_or_else(|| {
                Error::Invalid(format!("{}: its transform is not finite, affine or a rotation", node_name(root, n)))
            })?;
        left.extend(node.children.iter().flatten().rev().map(|c| (c.value(), place)));
        // Scaled to nothing is how nodes are hidden.
        if node.mesh.is_some() && place.matrix3 != DMat3::ZERO {
            out.push((n, place));
        }
    }
    Ok(out)
}

fn node_name(root: &Root, n: usize) -> String {
    match root.nodes.get(n).and_then(|n| n.name.as_deref()) {
        Some(name) => format!("node {n} '{}'", shown(name)),
        None => format!("node {n}"),
    }
}

/// A node's transform within its parent.
fn local(node: &Node) -> Option<DAffine3> {
    let affine = match node.matrix {
        Some(m) => {
            let m = DMat4::from_cols_array(&m.map(f64::from));
            if m.row(3) != glam::DVec4::W {
                return None;
            }
            DAffine3::from_mat4(m)
        }
        None => {
            let vector = |v: Option<[f32; 3]>, default: DVec3| v.map_or(default, |v| Vec3::from(v).as_dvec3());
            let q = DQuat::from_array(node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0.map(f64::from)));
            if !(q.length() > 0.0 && q.is_finite()) {
                return None;
            }
            let (scale, shift) = (vector(node.scale, DVec3::ONE), vector(node.translation, DVec3::ZERO));
            DAffine3::from_scale_rotation_translation(scale, q.normalize(), shift)
        }
    };
    affine.is_finite().then_some(affine)
}

struct Reader<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    mesh: Mesh,
}

impl Reader<'_> {
    fn node(&mut self, n: usize, place: &DAffine3) -> Result<()> {
        let root = self.root;
        let Some(index) = root.nodes[n].mesh else { return Ok(()) };
        let what = node_name(root, n);
        let Some(mesh) = root.get(index) else { return invalid!("{what}: mesh {} is missing", index.value()) };
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let what = format!("{what}, primitive {i}");
            self.primitive(primitive, place, &what).map_err(|e| e.within(&what))?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, place: &DAffine3, what: &str) -> Result<()> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            Checked::Valid(_) => return Ok(()),
            Checked::Invalid => return invalid!("mode must be a number from 0 to 6"),
        };
        // The specification: without positions, there is nothing to be seen.
        let Some(vertices) = Vertices::of(primitive, &self.buffers, place)? else { return Ok(()) };
        let indices = primitive.indices.map(|i| self.buffers.accessor(i.value(), &[1])).transpose()?;
        if indices.as_ref().is_some_and(|i| !i.are_indices()) {
            return invalid!("its indices must be unsigned whole numbers");
        }
        let corners = indices.as_ref().map_or(vertices.count(), |i| i.count);

        let mesh = &mut self.mesh;
        mesh.group(&material_name(self.root, primitive));
        mesh.places.parts.push((mesh.triangles.len(), what.to_string()));
        let mut numbers = vec![NONE; vertices.count()];
        for (face, mut corners) in triangles(mode, corners).enumerate() {
            if mesh.triangles.len() == MOST_TRIANGLES {
                return Err(Error::Unsupported(format!("the scene has over {MOST_TRIANGLES} triangles")));
            }
            if vertices.mirrored {
                corners.swap(1, 2);
            }
            let mut triangle = [0u32; 3];
            for (slot, i) in triangle.iter_mut().zip(corners) {
                let v = indices.as_ref().map_or(i, |x| x.at(i, 0) as usize);
                let Some(number) = numbers.get_mut(v) else {
                    return invalid!("face {}: corner {v} of {} vertices", face + 1, vertices.count());
                };
                // What no triangle uses is not kept: primitives often share one long list.
                if *number == NONE {
                    *number = mesh.positions.len() as u32;
                    vertices.add(v, mesh)?;
                }
                *slot = *number;
            }
            let [a, b, c] = triangle;
            let stitch = mode == Mode::TriangleStrip && (a == b || b == c || c == a);
            if !stitch {
                mesh.triangles.push(triangle);
                mesh.places.of.push(face as u32 + 1);
            }
        }
        Ok(())
    }
}

/// A primitive's vertices, and where they are to stand.
struct Vertices<'a> {
    positions: Numbers<'a>,
    normals: Option<Numbers<'a>>,
    uvs: Option<Numbers<'a>>,
    colours: Option<Numbers<'a>>,
    place: &'a DAffine3,
    cofactors: DMat3,
    mirrored: bool,
}

impl<'a> Vertices<'a> {
    fn of(primitive: &Primitive, buffers: &'a Buffers, place: &'a DAffine3) -> Result<Option<Vertices<'a>>> {
        let attribute = |semantic, widths: &[usize]| {
            let index = primitive.attributes.get(&Checked::Valid(semantic));
            index.map(|a| buffers.accessor(a.value(), widths)).transpose()
        };
        let Some(positions) = attribute(Semantic::Positions, &[3])? else { return Ok(None) };
        let normals = attribute(Semantic::Normals, &[3])?;
        let uvs = attribute(Semantic::TexCoords(0), &[2])?;
        let colours = attribute(Semantic::Colors(0), &[3, 4])?;
        for (data, name) in [(&normals, "NORMAL"), (&uvs, "TEXCOORD_0"), (&colours, "COLOR_0")] {
            if let Some(data) = data.as_ref().filter(|d| d.count < positions.count) {
                return invalid!("{name} has {} items, POSITION {}", data.count, positions.count);
            }
        }
        let linear = place.matrix3;
        let mirrored = linear.determinant() < 0.0;
        Ok(Some(Vertices { positions, normals, uvs, colours, place, cofactors: cofactors(&linear), mirrored }))
    }

    fn count(&self) -> usize {
        self.positions.count
    }

    /// Adds vertex `v` to a mesh.
    fn add(&self, v: usize, mesh: &mut Mesh) -> Result<()> {
        let what = || format!("vertex {v}");
        let n = mesh.positions.len();
        mesh.corner(self.place.transform_point3(DVec3::from(self.positions.triple(v))));
        let normal = self.normals.as_ref().map(|d| direction(d.triple(v), what)).transpose()?;
        let turned = |n: [f32; 3]| (self.cofactors * Vec3::from(n).as_dvec3()).normalize_or_zero().as_vec3().to_array();
        append(&mut mesh.normals, n, normal.map(turned), [0.0; 3]);
        // Pictures begin at the top in glTF.
        let uv = self.uvs.as_ref().map(|d| texture_place([d.at(v, 0), 1.0 - d.at(v, 1)], what)).transpose()?;
        append(&mut mesh.uvs, n, uv, [0.0; 2]);
        let colour = self.colours.as_ref().map(|d| colour(d.triple(v), what)).transpose()?;
        append(&mut mesh.colours, n, colour, [1.0; 3]);
        Ok(())
    }
}

/// Inverse transpose times determinant, signed so that mirrored normals stay in front; it lives where the inverse does not.
fn cofactors(m: &DMat3) -> DMat3 {
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}

/// Adds the item of vertex `n`, filling up where earlier vertices had none.
fn append<T: Copy>(list: &mut Option<Vec<T>>, n: usize, item: Option<T>, none: T) {
    if item.is_some() || list.is_some() {
        let list = list.get_or_insert_default();
        list.resize(n, none);
        list.push(item.unwrap_or(none));
    }
}

/// The name of a primitive's material; `material 3` where it has none.
fn material_name(root: &Root, primitive: &Primitive) -> String {
    let Some(index) = primitive.material else { return String::new() };
    let name = root.get(index).and_then(|m| m.name.clone());
    name.unwrap_or_else(|| format!("material {}", index.value()))
}

/// The corners of each triangle, counter-clockwise, as places in the list of corners.
fn triangles(mode: Mode, count: usize) -> impl Iterator<Item = [usize; 3]> {
    let n = match mode {
        Mode::Triangles => count / 3,
        _ => count.saturating_sub(2),
    };
    (0..n).map(move |i| match mode {
        Mode::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
        Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
        _ => [i + 1, i + 2, 0],
    })
}

#[cfg(test)]
mod tests;
