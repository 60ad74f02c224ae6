//! Wavefront OBJ [Alias|Wavefront, "Advanced Visualizer" manual, appendix B1]: `v`, `vn`, `vt`, `f` and `usemtl` lines.
//!
//! A vertex may carry a colour after its place (`v x y z r g b`, linear sRGB, 0..1; a lone fourth number is a weight, and
//! passed over). Faces have any number of corners, `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1 or backwards from the
//! last; outlines may be bent. A vertex that comes with several normals or texture coordinates is split. Groups are
//! materials (`usemtl`); objects, smoothing groups, lines, curves and material libraries are passed over.

use std::collections::HashMap;

use glam::DVec3;

use super::{Mesh, colour, direction, shown, texture_place};
use crate::{Result, invalid};

/// What a corner has beside its vertex: texture place and normal, counted from 1; 0 for none.
type Beside = [u32; 2];

/// The file as it is read.
#[derive(Default)]
struct Reader {
    mesh: Mesh,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// By vertex, what its first corner has beside it.
    first: Vec<Option<Beside>>,
    /// Corners that share a vertex with another that has other things beside it, and their numbers among `extra`.
    splits: HashMap<(u32, Beside), u32>,
    extra: Vec<(u32, Beside)>,
    /// Whether any corner has a texture place or a normal.
    used: [bool; 2],
    /// Corners of triangles that are splits: triangle, corner, number among `extra`.
    pending: Vec<(u32, u8, u32)>,
}

/// Reads the text of an OBJ file.
pub fn parse(bytes: &[u8]) -> Result<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    reader.mesh.places.lines = true;
    let mut corners = Vec::new();
    for (n, line) in text.lines().enumerate() {
        let what = || format!("line {}", n + 1);
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => reader.vertex(words, what)?,
            Some("vn") => {
                let Some(normal) = numbers(words) else { return invalid!("{}: expected vn x y z", what()) };
                reader.normals.push(direction(normal, what)?);
            }
            Some("vt") => {
                let uv = numbers(words.clone()).or_else(|| numbers(words).map(|[u]| [u, 0.0]));
                let Some(uv) = uv else { return invalid!("{}: expected vt u v", what()) };
                reader.uvs.push(texture_place(uv, what)?);
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    corners.push(reader.corner(word, what)?);
                }
                reader.face(&corners, n as u32 + 1, what)?;
            }
            Some("usemtl") => reader.mesh.group(line.trim_ascii().strip_prefix("usemtl").unwrap_or("").trim_ascii()),
            _ => {}
        }
    }
    reader.finish()
}

/// The first N words as numbers.
fn numbers<'a, const N: usize>(words: impl Iterator<Item = &'a str>) -> Option<[f64; N]> {
    let mut out = [0.0; N];
    let mut read = 0;
    for (slot, word) in out.iter_mut().zip(words) {
        *slot = word.parse().ok()?;
        read += 1;
    }
    (read == N).then_some(out)
}

impl Reader {
    fn vertex<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str> + Clone,
        what: impl Fn() -> String + Copy,
    ) -> Result<()> {
        let Some(place) = numbers::<3>(words.clone()) else { return invalid!("{}: expected v x y z", what()) };
        let read = self.mesh.positions.len();
        if read == (u32::MAX / 2) as usize {
            return invalid!("{}: more than {} vertices", what(), u32::MAX / 2);
        }
        if let Some([_, _, _, r, g, b]) = numbers(words) {
            let colours = self.mesh.colours.get_or_insert_default();
            colours.resize(read, [1.0; 3]);
            colours.push(colour([r, g, b], what)?);
        }
        self.mesh.corner(DVec3::from(place));
        self.first.push(None);
        Ok(())
    }

    /// One word of a face: its vertex, texture place and normal, each checked.
    fn corner(&mut self, word: &str, what: impl Fn() -> String) -> Result<(u32, Beside)> {
        let mut parts = word.split('/');
        let mut index = |count: usize, kind: &str, must: bool| -> Result<u32> {
            let part = parts.next().unwrap_or("");
            if part.is_empty() && !must {
                return Ok(0);
            }
            // Counted from 1, or backwards from the last with a minus.
            let count = count as i64;
            let at = match part.parse::<i64>() {
                Ok(i) if i > 0 => i,
                Ok(i) if i < 0 => count.saturating_add(i).saturating_add(1),
                _ => return invalid!("{}: '{}' is no corner", what(), shown(word)),
            };
            if !(1..=count).contains(&at) {
                return invalid!("{}: corner {} of {count} {kind}", what(), shown(word));
            }
            Ok(at as u32)
        };
        let vertex = index(self.mesh.positions.len(), "vertices", true)? - 1;
        let beside =
            [index(self.uvs.len(), "texture coordinates", false)?, index(self.normals.len(), "normals", false)?];
        Ok((vertex, beside))
    }

    fn face(&mut self, corners: &[(u32, Beside)], line: u32, what: impl Fn() -> String) -> Result<()> {
        let start = self.mesh.triangles.len();
        let vertices: Vec<u32> = corners.iter().map(|c| c.0).collect();
        self.mesh.polygon(&vertices, line, what)?;
        // Corner by corner, which of its vertex's splits it is; a face that meets a vertex twice means its first.
        for &(vertex, beside) in corners {
            self.used[0] |= beside[0] > 0;
            self.used[1] |= beside[1] > 0;
            let first = self.first[vertex as usize].get_or_insert(beside);
            if *first == beside {
                continue;
            }
            let next = self.extra.len() as u32;
            let extra = *self.splits.entry((vertex, beside)).or_insert(next);
            if extra == next {
                self.extra.push((vertex, beside));
            }
            for (t, triangle) in self.mesh.triangles[start..].iter().enumerate() {
                for (k, c) in triangle.iter().enumerate() {
                    if *c == vertex {
                        self.pending.push(((start + t) as u32, k as u8, extra));
                    }
                }
            }
        }
        Ok(())
    }

    /// Puts splits after the vertices, each with what it has beside it.
    fn finish(self) -> Result<Mesh> {
        let Reader { mut mesh, uvs, normals, first, extra, used, pending, .. } = self;
        let vertices = mesh.positions.len();
        if let Some(colours) = &mut mesh.colours {
            colours.resize(vertices, [1.0; 3]);
            colours.reserve_exact(extra.len());
            for (vertex, _) in &extra {
                colours.push(colours[*vertex as usize]);
            }
        }
        for (vertex, _) in &extra {
            mesh.positions.push(mesh.positions[*vertex as usize]);
        }
        for (t, k, e) in pending {
            mesh.triangles[t as usize][k as usize] = vertices as u32 + e;
        }
        let beside = || first.iter().map(|b| b.unwrap_or_default()).chain(extra.iter().map(|e| e.1));
        if used[0] {
            mesh.uvs = Some(beside().map(|b| if b[0] > 0 { uvs[b[0] as usize - 1] } else { [0.0; 2] }).collect());
        }
        if used[1] {
            mesh.normals =
                Some(beside().map(|b| if b[1] > 0 { normals[b[1] as usize - 1] } else { [0.0; 3] }).collect());
        }
        mesh.finished()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_negative_indices_and_faults() {
        let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 -2 4\n";
        assert_eq!(parse(quad.as_bytes()).unwrap().triangles, [[0, 1, 2], [0, 2, 3]]);
        for (bad, word) in [
            ("v 0 0\nf 1 1 1\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "corner 2"),
            ("v 0 0 0\nf 1 1\n", "three corners"),
            ("", "no face"),
            ("v 0 0 0\nf a b c\n", "no corner"),
            ("v 0 0 0\nf 1/1 1 1\n", "corner 1/1 of 0 texture coordinates"),
            ("v 0 0 0\nf 1//-1 1 1\n", "corner 1//-1 of 0 normals"),
            ("v 0 0 0\nf -9223372036854775808 1 1\n", "corner -9223372036854775808 of 1"),
            ("v 0 0 0\nvn 0 0 0\n", "line 2: the normal 0 0 0 has no direction"),
            ("vn inf 0 0\n", "no direction"),
            ("vt nan 0\n", "line 1: a texture coordinate"),
            ("v 0 0 0 1 1 1.5\n", "line 1: the colour 1 1 1.5"),
            ("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 1\nf 1 2 3\n", "face 2 (line 5): vertex 3 is not finite"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e99 0 0\nf 1 2 3\n", "vertex 4, which no face uses"),
            ("v 0 0 0\nv 2 2 0\nv 0 2 0\nv 3 0 0\nv 3 .5 0\nf 1 2 3 4 5\n", "line 6: the outline"),
        ] {
            let message = parse(bad.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(word), "{bad:?}: {message}");
        }
    }

    #[test]
    fn vertices_split_where_corners_differ() {
        let text = "v 0 0 0 0 0.5 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0.25 1 9\nvn 0 0 2\n\
            f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/2/1 4\nf 3/3/1 2/2/1 1/1/1\nv 5 5 5\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 5, 3], [2, 1, 0]]);
        assert_eq!(mesh.positions[5], [1.0, 1.0, 0.0]);
        let uvs = mesh.uvs.unwrap();
        assert_eq!(uvs, [[0.0, 0.0], [1.0, 0.0], [0.25, 1.0], [0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]);
        let normals = mesh.normals.unwrap();
        assert_eq!((normals[0], normals[3], normals[5]), ([0.0, 0.0, 1.0], [0.0; 3], [0.0, 0.0, 1.0]));
        assert_eq!(mesh.colours.unwrap()[..2], [[0.0, 0.5, 1.0], [1.0; 3]]);
    }

    #[test]
    fn groups_keep_their_names() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl none\nusemtl red paint\nf 1 2 3\nf 1 2 3\nusemtl x\n";
        let groups = parse(text.as_bytes()).unwrap().groups;
        let shown: Vec<_> = groups.iter().map(|g| (g.name.as_str(), g.triangles.clone())).collect();
        assert_eq!(shown, [("", 0..1), ("red paint", 1..3)]);
        let twice = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl a\nf 1 2 3\n";
        assert_eq!(parse(twice.as_bytes()).unwrap().groups.len(), 1);
    }

    /// The same mesh at zero and a million metres out, where floats step by 6 cm.
    #[test]
    fn far_out_digits_are_kept() {
        let tower = include_str!("../../../scenes/tower/mug.obj");
        let near = parse(tower.as_bytes()).unwrap();
        let (dx, dy) = (1_000_000.0, -4_500_000.0);
        let moved = |line: &str| match numbers::<3>(line.split(' ').skip(1)).filter(|_| line.starts_with("v ")) {
            Some([x, y, z]) => format!("v {:.6} {:.6} {z}\n", x + dx, y + dy),
            None => format!("{line}\n"),
        };
        let far = parse(tower.lines().map(moved).collect::<String>().as_bytes()).unwrap();
        assert_eq!(near.origin, DVec3::ZERO);
        assert_eq!(far.triangles, near.triangles);
        for c in 0..near.positions.len() as u32 {
            let off = far.place(c) - DVec3::new(dx, dy, 0.0) - near.place(c);
            assert!(off.length() < 2e-6, "vertex {c} is off by {off}");
        }
    }

    #[test]
    fn cuts_and_flips_never_panic() {
        let text =
            "v 0 0 0 1 1 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2 3//1 -1\n".as_bytes();
        for cut in 0..text.len() {
            let _ = parse(&text[..cut]);
            for bit in 0..8 {
                let mut bad = text.to_vec();
                bad[cut] ^= 1 << bit;
                let _ = parse(&bad);
            }
        }
    }
}
