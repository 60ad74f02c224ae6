//! Faces without area: refused by name, or passed over.

use glam::DVec3;
use serde::Deserialize;

use super::Mesh;
use crate::{Result, invalid};

/// Height over longest edge up to which three corners lie on one line: what rounding to floats can do to a triangle.
pub(super) const THIN: f64 = 1e-7;

/// What becomes of faces without area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Degenerate {
    /// They are an error.
    #[default]
    Refuse,
    /// They are passed over: nothing can be seen of them, or shine.
    Skip,
}

/// Why a triangle has no area. A matter of its shape alone: height against longest edge, whatever the unit and the place.
fn fault([a, b, c]: [DVec3; 3], corners: [u32; 3]) -> Option<&'static str> {
    let edges = [b - a, c - b, a - c];
    if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
        return Some("it has the same corner twice");
    }
    if edges.contains(&DVec3::ZERO) {
        return Some("two of its corners lie at one place");
    }
    let longest = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
    // Not `<=`: what is no number is no area.
    let thick = edges[0].cross(edges[1]).length() > THIN * longest;
    (!thick).then_some("its corners lie on one line")
}

impl Mesh {
    /// Looks for faces without area. Returns how many were passed over; refused, the first is named. A mesh of nothing else
    /// is an error either way.
    pub fn check(&mut self, policy: Degenerate) -> Result<usize> {
        let faults = |mesh: &Mesh, t: usize| fault(mesh.corners(mesh.triangles[t]), mesh.triangles[t]);
        let all = self.triangles.len();
        let Some((first, why)) = (0..all).find_map(|t| Some((t, faults(self, t)?))) else { return Ok(0) };
        if policy == Degenerate::Refuse {
            return invalid!("{}: {why}; `degenerate = \"skip\"` passes over such faces", self.face(first));
        }
        let mut groups = self.groups.clone();
        let mut parts = self.places.parts.clone();
        let (mut kept, mut group, mut part) = (0, 0, 0);
        // Bounds of groups and parts move to the number of triangles kept before them.
        for t in 0..=all {
            while let Some(p) = parts.get_mut(part).filter(|p| p.0 <= t) {
                p.0 = kept;
                part += 1;
            }
            while let Some(g) = groups.get_mut(group).filter(|g| g.triangles.end <= t) {
                g.triangles.end = kept;
                group += 1;
            }
            if t < all && (t < first || faults(self, t).is_none()) {
                self.triangles[kept] = self.triangles[t];
                self.places.of[kept] = self.places.of[t];
                kept += 1;
            }
        }
        if kept == 0 {
            return invalid!("no face has an area");
        }
        self.triangles.truncate(kept);
        self.places.of.truncate(kept);
        self.places.parts = parts;
        let mut start = 0;
        for g in &mut groups {
            g.triangles.start = std::mem::replace(&mut start, g.triangles.end);
        }
        groups.retain(|g| !g.triangles.is_empty());
        self.groups = groups;
        Ok(all - kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::{load, obj};

    #[test]
    fn the_face_is_named_and_said_how_to_go_on() {
        let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 0 0\n\nf 1 2 4\nf 4 1 3 2\nf 1 2 3\nf 2 5 4\nf 1 4 4\n";
        let mut mesh = obj::parse(text.as_bytes()).unwrap();
        let message = mesh.check(Degenerate::Refuse).unwrap_err().to_string();
        assert_eq!(
            message,
            "face 3 (line 9): its corners lie on one line; `degenerate = \"skip\"` passes over such faces"
        );
        assert_eq!(mesh.check(Degenerate::Skip).unwrap(), 3);
        assert_eq!(mesh.check(Degenerate::Refuse).unwrap(), 0);
        for (faces, why) in [("f 2 5 4", "one place"), ("f 1 4 4", "same corner twice")] {
            let text = format!("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 0 0\n{faces}\n");
            let message = obj::parse(text.as_bytes()).unwrap().check(Degenerate::Refuse).unwrap_err().to_string();
            assert!(message.starts_with("face 1 (line 6)") && message.contains(why), "{message}");
        }
    }

    #[test]
    fn groups_follow_what_is_passed_over() {
        let text =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 1 2\nusemtl b\nf 1 2 2\nf 1 2 3\nusemtl c\nf 3 2 1\nf 1 1 1\n";
        let mut mesh = obj::parse(text.as_bytes()).unwrap();
        assert_eq!(mesh.check(Degenerate::Skip).unwrap(), 3);
        let groups: Vec<_> = mesh.groups.iter().map(|g| (g.name.as_str(), g.triangles.clone())).collect();
        assert_eq!(groups, [("b", 0..1), ("c", 1..2)]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 0]]);
        let mut none = obj::parse(b"v 0 0 0\nv 1 0 0\nf 1 2 1\n").unwrap();
        assert!(none.check(Degenerate::Skip).unwrap_err().to_string().contains("no face has an area"));
    }

    /// The same shapes a ten-thousandth and a million times as large, at zero and far out.
    #[test]
    fn a_shape_is_judged_by_its_shape() {
        for (size, shift) in [(1.0, 0.0), (1e-4, 0.0), (1e6, 0.0), (1.0, 1e6), (1e-3, 1e6), (1e6, -1e9)] {
            for (height, good) in [(1.0, true), (1e-5, true), (0.0, false), (1e-9, false)] {
                let at = |x: f64, y: f64| format!("v {} {} 0\n", shift + size * x, shift + size * y);
                let text = at(0.0, 0.0) + &at(1.0, 0.0) + &at(0.5, height) + "f 1 2 3\n";
                let mut mesh = obj::parse(text.as_bytes()).unwrap();
                // Nothing says more than the digits of the file's own numbers.
                if height * size > 1e-9 * shift.abs() || height == 0.0 {
                    assert_eq!(mesh.check(Degenerate::Refuse).is_ok(), good, "{size} at {shift}, height {height}");
                }
            }
        }
    }

    #[test]
    fn the_towers_meshes_are_whole() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tower");
        let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
        let meshes: Vec<_> = files.filter(|f| f.extension().is_some_and(|e| e == "obj")).collect();
        assert!(meshes.len() > 40);
        for file in meshes {
            assert_eq!(load(&file).unwrap().check(Degenerate::Refuse).unwrap(), 0, "{}", file.display());
        }
    }
}
