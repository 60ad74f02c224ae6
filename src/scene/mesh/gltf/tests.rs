use std::path::PathBuf;

use super::*;
use crate::scene::mesh::{Degenerate, load};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mesh").join(name)
}

fn alone(bytes: &[u8]) -> Result<Mesh> {
    parse(bytes, |uri, _| invalid!("no '{uri}' here"))
}

/// Scaled by 2, (x, y) to (-y, x), moved by (10, 20, 30).
#[test]
fn the_cube_stands_where_its_node_says() {
    let mut mesh = load(&file("cube.gltf")).unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12));
    assert_eq!(mesh.check(Degenerate::Refuse).unwrap(), 0);
    let places: Vec<DVec3> = (0..24).map(|c| mesh.place(c)).collect();
    let least = places.iter().copied().reduce(DVec3::min).unwrap();
    let most = places.iter().copied().reduce(DVec3::max).unwrap();
    assert!((least - DVec3::new(8.0, 20.0, 30.0)).length() < 1e-6, "{least}");
    assert!((most - DVec3::new(10.0, 22.0, 32.0)).length() < 1e-6, "{most}");
    let (normals, uvs) = (mesh.normals.as_ref().unwrap(), mesh.uvs.as_ref().unwrap());
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|c| places[c as usize]);
        let face = (b - a).cross(c - a).normalize();
        assert!(face.dot((a + b + c) / 3.0 - DVec3::new(9.0, 21.0, 31.0)) > 0.0, "outward");
        for c in t {
            assert!((face - Vec3::from(normals[*c as usize]).as_dvec3()).length() < 1e-6);
        }
    }
    // From the bottom left, counter-clockwise, on every face.
    assert!(uvs.chunks(4).all(|f| f == [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
    assert_eq!(mesh.groups.len(), 1);
    assert_eq!((mesh.groups[0].name.as_str(), mesh.groups[0].triangles.clone()), ("chalk", 0..12));
}

#[test]
fn buffers_beside_within_and_in_a_chunk_are_one() {
    let beside = load(&file("cube.gltf")).unwrap();
    assert_eq!(load(&file("cube_base64.gltf")).unwrap(), beside);
    assert_eq!(load(&file("cube.glb")).unwrap(), beside);
}

#[test]
fn strips_fans_parents_and_mirrors() {
    let mut mesh = load(&file("modes.glb")).unwrap();
    assert_eq!(mesh.triangles.len(), 6);
    assert_eq!(mesh.check(Degenerate::Refuse).unwrap(), 0);
    let groups: Vec<_> = mesh.groups.iter().map(|g| (g.name.as_str(), g.triangles.clone())).collect();
    assert_eq!(groups, [("red", 0..2), ("material 1", 2..4), ("", 4..6)]);
    for (i, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.map(|c| mesh.place(c));
        // Half a unit square each, the front upward even where mirrored, on the parent's height.
        assert_eq!((b - a).cross(c - a), DVec3::Z, "triangle {i}");
        assert_eq!(a.z, 5.0);
        let (low, high) = if i < 2 { (100.0, 101.0) } else { (-1.0, 0.0) };
        assert!([a, b, c].iter().all(|p| (low..=high).contains(&p.x)), "triangle {i}");
    }
    let (colours, uvs) = (mesh.colours.as_ref().unwrap(), mesh.uvs.as_ref().unwrap());
    assert_eq!(colours[..5], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2; 3], [1.0; 3]]);
    assert_eq!(uvs[..4], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
    assert_eq!(colours.len(), mesh.positions.len());
}

/// The cube's JSON with one text in place of another.
fn changed(from: &str, to: &str) -> String {
    let text = std::fs::read_to_string(file("cube_base64.gltf")).unwrap();
    assert!(text.contains(from), "{from}");
    alone(text.replacen(from, to, 1).as_bytes()).map_or_else(|e| e.to_string(), |_| "no error".into())
}

#[test]
fn faults_are_named() {
    for (from, to, word) in [
        ("\"version\":\"2.0\"", "\"version\":\"1.0\"", "glTF version 1.0"),
        ("\"scene\":0", "\"scene\":7", "scene 7 is missing"),
        ("\"nodes\":[0]", "\"nodes\":[4]", "node 4 is missing"),
        ("\"nodes\":[0]", "\"nodes\":[0,0]", "node 0 'cube': hangs in the scene twice"),
        ("\"mesh\":0", "\"mesh\":1", "node 0 'cube': mesh 1 is missing"),
        ("\"scale\":[2,2,2]", "\"matrix\":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]", "its transform"),
        ("\"count\":36", "\"count\":37", "node 0 'cube', primitive 0: accessor 3: its 37 items"),
        ("\"count\":24", "\"count\":23", "NORMAL has 23 items, POSITION 24"),
        ("\"componentType\":5123", "\"componentType\":5126", "accessor 3: its 36 items"),
        ("\"componentType\":5123", "\"componentType\":5122", "unsigned whole numbers"),
        ("\"componentType\":5123", "\"componentType\":1", "accessor 3: its type"),
        ("\"indices\":3", "\"indices\":0", "have not the 1 components"),
        ("\"byteStride\":32", "\"byteStride\":4", "stride of 4 bytes"),
        ("\"bufferView\":1", "\"bufferView\":9", "accessor 3: its buffer view is missing"),
        ("\"uri\":\"data:application/octet-stream;base64,", "\"uri\":\"data:,", "not base64"),
        ("\"uri\":\"data:application/octet-stream;base64,", "\"uri\":\"x", "buffer 0: no 'x"),
        ("\"uri\":", "\"other\":", "buffer 0 has neither"),
        ("\"buffers\":[{\"byteLength\":840", "\"buffers\":[{\"byteLength\":841", "buffer 0 has 840 bytes of 841"),
        ("\"scene\":0", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"scene\":0", "KHR_draco"),
        (
            "\"count\":36",
            "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":1}},\"count\":36",
            "sparse",
        ),
        ("{", "{{", "no glTF 2.0"),
    ] {
        let message = changed(from, to);
        assert!(message.contains(word), "{to}: {message}");
    }
    // An index beyond the vertices, a normal without direction.
    let mut glb = std::fs::read(file("cube.glb")).unwrap();
    let end = glb.len();
    glb[end - 2] = 24;
    assert!(alone(&glb).unwrap_err().to_string().contains("face 12: corner 24 of 24 vertices"));
    glb[end - 2..].fill(0);
    let binary = end - 840;
    glb[binary..binary + 12].fill(0);
    assert!(alone(&glb).unwrap_err().to_string().contains("primitive 0: vertex 0: the normal 0 0 0"));
}

#[test]
fn damaged_files_are_refused_by_what_is_wrong() {
    let bad = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    for (name, word) in [
        ("mesh_cut.glb", "the GLB ends after"),
        ("mesh_nodes_in_a_ring.glb", "twice"),
        ("mesh_count_huge.glb", "its 4611686018427387904 items"),
        ("mesh_accessor_missing.glb", "accessor 99 is missing"),
        ("mesh_stride_short.glb", "stride of 4"),
        ("mesh_line.obj", "face 1 (line 4): its corners lie on one line"),
        ("mesh_nan.obj", "face 1 (line 4): vertex 2 is not finite"),
        ("mesh_list_huge.ply", "face 1"),
    ] {
        let message = match load(&bad.join(name)) {
            Ok(mut mesh) => mesh.check(Degenerate::Refuse).unwrap_err().to_string(),
            Err(e) => e.to_string(),
        };
        assert!(message.contains(word), "{name}: {message}");
        assert_eq!(message.lines().count(), 1);
    }
}

#[test]
fn every_cut_is_an_error_and_no_flip_a_panic() {
    for name in ["modes.glb", "cube_base64.gltf"] {
        let whole = std::fs::read(file(name)).unwrap();
        for cut in 0..whole.len() {
            assert!(alone(&whole[..cut]).is_err(), "{name} cut at {cut}");
            for bit in [0, 3, 6, 7] {
                let mut bad = whole.clone();
                bad[cut] ^= 1 << bit;
                let _ = alone(&bad);
            }
        }
    }
}
