//! A mesh as a scene file asks for it: read, checked, smoothed and put in its place.
//!
//! | key | value |
//! |---|---|
//! | `file` | a mesh beside the scene |
//! | `degenerate` | `"refuse"` (default) or `"skip"`: what becomes of faces without area |
//! | `smooth_deg` | normals where the file has none, across edges of up to so many degrees; absent: faces are flat |
//!
//! and the keys of [`Transform`].

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::{Degenerate, Mesh, load};
use crate::Result;
use crate::keys::Keys;
use crate::scene::transform::Transform;

/// Takes a mesh's keys out of a shape's table. Files lie in `folder`; a unit of length has `metres`; the mesh has its origin
/// and positions in metres. What was passed over or changed is noted.
pub fn read(k: &mut Keys, folder: &Path, metres: f64) -> Result<Mesh> {
    let Some((file, span)) = k.get_spanned::<String>("file")? else { return Err(k.wrong("key 'file' is missing")) };
    let policy = k.get::<Degenerate>("degenerate")?.unwrap_or_default();
    let crease = k.number("smooth_deg", "must lie in 0 to 180", |x| (0.0..=180.0).contains(&x))?;
    let own = Transform::read(k)?;
    let unit = Transform::new(DAffine3::from_scale(DVec3::splat(metres)));
    let place = unit.and_then(|u| own.then(&u)).ok_or_else(|| k.wrong("its transform flattens space: no inverse"))?;

    let shown = super::shown(&file);
    let wrong = |e: &str| k.wrong_key("file", span.clone(), e);
    let mut mesh = load(&folder.join(&file)).map_err(|e| wrong(&e.to_string()))?;
    let passed = mesh.check(policy).map_err(|e| wrong(&format!("mesh '{shown}': {e}")))?;
    let sides = mesh.turn_normals();
    if let Some(degrees) = crease {
        mesh.smooth(degrees);
    }
    mesh.transform(&place);
    let note = |n: usize, what: &str| {
        if n > 0 {
            k.notes().add(format!("mesh '{shown}': {n} {what}"));
        }
    };
    note(passed, "faces without area are passed over");
    note(sides.turned, "normals point behind their faces and are turned");
    note(sides.mixed, "normals point behind some of their faces");
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys;

    const FILE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\nf 1 2 2\n";

    fn placed(text: &str) -> Result<(Mesh, Vec<String>)> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), FILE).unwrap();
        let mut k = keys::parse(text)?;
        let mesh = read(&mut k, folder.path(), 0.01)?;
        let notes = k.notes().take();
        k.finish().map(|()| (mesh, notes))
    }

    #[test]
    fn keys_check_smooth_and_place() {
        let text = "file = \"a.obj\"\ndegenerate = \"skip\"\nsmooth_deg = 30\nscale = 2\ntranslate = [0, 0, 50]";
        let (mesh, notes) = placed(text).unwrap();
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (1, 5));
        assert!((mesh.place(mesh.triangles[0][1]) - DVec3::new(0.02, 0.0, 0.5)).length() < 1e-9);
        assert_eq!(mesh.normals.unwrap()[0], [0.0, 0.0, 1.0]);
        assert_eq!(
            notes,
            [
                "mesh 'a.obj': 1 faces without area are passed over",
                "mesh 'a.obj': 3 normals point behind their faces and are turned"
            ]
        );
        for (bad, word) in [
            (
                "file = \"a.obj\"",
                "line 1, column 8: file: mesh 'a.obj': face 2 (line 6): it has the same corner twice; `",
            ),
            ("file = \"b.obj\"", "file: cannot read"),
            ("file = \"a.obj\"\ndegenerate = \"maybe\"", "degenerate"),
            ("file = \"a.obj\"\nsmooth_deg = 200", "smooth_deg: 200 must lie in 0 to 180"),
            ("file = \"a.obj\"\ndegenerate = \"skip\"\ntwist = 1", "twist: unknown key"),
            ("scale = 2", "'file' is missing"),
        ] {
            let message = placed(bad).unwrap_err().to_string();
            assert!(message.contains(word), "{bad}: {message}");
        }
    }
}
