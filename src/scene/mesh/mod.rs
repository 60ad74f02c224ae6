//! Triangle meshes from files. One format, one file, one line in [`load`].

pub mod obj;
pub mod ply;

use std::path::Path;

use crate::{Error, Result};

/// Triangles over shared corners; every index is in range, every coordinate finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub positions: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a mesh by its suffix.
pub fn load(path: &Path) -> Result<Mesh> {
    let bytes = std::fs::read(path).map_err(|e| Error::Invalid(format!("cannot read '{}': {e}", path.display())))?;
    let suffix = path.extension().and_then(|s| s.to_str()).unwrap_or("").to_ascii_lowercase();
    let mesh = match suffix.as_str() {
        "obj" => obj::parse(&bytes),
        "ply" => ply::parse(&bytes),
        _ => {
            return Err(Error::Unsupported(format!(
                "'{}' is no mesh; known suffixes are .obj and .ply",
                path.display()
            )));
        }
    };
    mesh.map_err(|e| e.in_file(path))
}

impl Mesh {
    /// Adds a polygon as a fan, its corners checked; `what` names it in the error.
    fn polygon(&mut self, corners: &[u32], what: &str) -> Result<()> {
        if let Some(bad) = corners.iter().find(|c| **c as usize >= self.positions.len()) {
            return crate::invalid!("{what}: corner {} of {} vertices", u64::from(*bad) + 1, self.positions.len());
        }
        if corners.len() < 3 {
            return crate::invalid!("{what}: a face needs three corners, this has {}", corners.len());
        }
        for pair in corners[1..].windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
        Ok(())
    }

    /// Adds a corner, which must be finite.
    fn corner(&mut self, p: [f32; 3], what: &str) -> Result<()> {
        if !p.iter().all(|x| x.is_finite()) {
            return crate::invalid!("{what}: a coordinate is not finite");
        }
        self.positions.push(p);
        Ok(())
    }
}
