//! Wavefront OBJ: `v` and `f` lines; normals, texture coordinates, groups and materials are passed over.

use super::Mesh;
use crate::{Result, invalid};

/// Reads the text of an OBJ file.
pub fn parse(bytes: &[u8]) -> Result<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    for (n, line) in text.lines().enumerate() {
        let what = || format!("line {}", n + 1);
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words.take(3).map_while(|w| w.parse().ok()).collect();
                let Ok(p) = <[f32; 3]>::try_from(numbers) else { return invalid!("{}: expected v x y z", what()) };
                mesh.corner(p, &what())?;
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    let index = word.split('/').next().and_then(|w| w.parse::<i64>().ok());
                    // Counted from 1, or backwards from the last with a minus.
                    let count = mesh.positions.len() as i64;
                    let at = match index {
                        Some(i) if i > 0 => i - 1,
                        Some(i) if i < 0 => count + i,
                        _ => {
                            return invalid!("{}: '{}' is no corner", what(), crate::error::printable(word.as_bytes()));
                        }
                    };
                    if !(0..count).contains(&at) {
                        return invalid!("{}: corner {word} of {count} vertices", what());
                    }
                    corners.push(at as u32);
                }
                mesh.polygon(&corners, &what())?;
            }
            _ => {}
        }
    }
    if mesh.triangles.is_empty() {
        return invalid!("no face found");
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_negative_indices_and_faults() {
        let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/2/3 2//3 -2 4\n";
        assert_eq!(parse(quad.as_bytes()).unwrap().triangles, [[0, 1, 2], [0, 2, 3]]);
        for (bad, word) in [
            ("v 0 0\nf 1 1 1\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "corner 2"),
            ("v 0 0 nan\n", "finite"),
            ("v 0 0 0\nf 1 1\n", "three corners"),
            ("", "no face"),
            ("v 0 0 0\nf a b c\n", "no corner"),
        ] {
            assert!(parse(bad.as_bytes()).unwrap_err().to_string().contains(word), "{bad:?}");
        }
    }
}
