//! Where a shape stands: an affine transform from a scene file's keys.
//!
//! | key | value |
//! |---|---|
//! | `scale` | a number, or one an axis; below 0 mirrors |
//! | `rotate` | `[x, y, z, degrees]`: about an axis, counter-clockwise seen against it |
//! | `rotate_deg` | `[rx, ry, rz]`: about x, then y, then z, as `xform -rx -ry -rz` does |
//! | `translate` | `[x, y, z]`, in the scene's unit |
//! | `matrix` | three rows of four: place' = M (x y z 1); in place of all others |
//!
//! In this order: scaled first, moved last. Normals follow by the inverse transpose [Turkowski 1990, "Properties of
//! surface-normal transformations"].

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::Deserialize;

use crate::Result;
use crate::keys::Keys;

/// An affine transform that can be undone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    affine: DAffine3,
    /// Inverse transpose of the linear part, to a factor.
    normals: DMat3,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Scale {
    One(f64),
    Three([f64; 3]),
}

/// Volume over the product of the edges up to which a cell is flat.
const FLAT: f64 = 1e-12;

impl Transform {
    /// Everything stays where it is.
    pub const IDENTITY: Transform = Transform { affine: DAffine3::IDENTITY, normals: DMat3::IDENTITY };

    /// From an affine map; `None` where it flattens space, or is not finite.
    pub fn new(affine: DAffine3) -> Option<Transform> {
        let m = affine.matrix3;
        let edges = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        let determinant = m.determinant();
        if !(affine.is_finite() && edges.is_finite() && determinant.abs() > FLAT * edges) {
            return None;
        }
        Some(Transform { affine, normals: m.inverse().transpose() }).filter(|t| t.normals.is_finite())
    }

    /// Takes the keys `scale`, `rotate`, `rotate_deg`, `translate` and `matrix` out of a table; the identity where there are
    /// none.
    pub fn read(k: &mut Keys) -> Result<Transform> {
        let matrix = k.get_spanned::<[[f64; 4]; 3]>("matrix")?;
        let scale = k.get_spanned::<Scale>("scale")?;
        let axis = k.get_spanned::<[f64; 4]>("rotate")?;
        let turns = k.get_spanned::<[f64; 3]>("rotate_deg")?;
        let shift = k.get_spanned::<[f64; 3]>("translate")?;
        if let Some((rows, span)) = matrix {
            if scale.is_some() || axis.is_some() || turns.is_some() || shift.is_some() {
                return Err(k.wrong_key("matrix", span, "stands in place of scale, rotate, rotate_deg and translate"));
            }
            let column = |j: usize| DVec3::new(rows[0][j], rows[1][j], rows[2][j]);
            let linear = DMat3::from_cols(column(0), column(1), column(2));
            let affine = DAffine3::from_mat3_translation(linear, column(3));
            return Transform::new(affine).ok_or_else(|| k.wrong_key("matrix", span, "it flattens space: no inverse"));
        }
        let mut affine = DAffine3::IDENTITY;
        if let Some((scale, span)) = scale {
            let s = match scale {
                Scale::One(x) => DVec3::splat(x),
                Scale::Three(xyz) => DVec3::from(xyz),
            };
            if s.to_array().iter().any(|x| *x == 0.0 || x.is_nan() || x.abs() >= 1e9) {
                return Err(k.wrong_key("scale", span, "must not be 0 in any direction, and under 1e9"));
            }
            affine = DAffine3::from_scale(s);
        }
        if let Some(([x, y, z, degrees], span)) = axis {
            let axis = DVec3::new(x, y, z).normalize_or_zero();
            if axis == DVec3::ZERO || !degrees.is_finite() {
                return Err(k.wrong_key("rotate", span, "expected [x, y, z, degrees], the axis not 0"));
            }
            affine = DAffine3::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians())) * affine;
        }
        if let Some((turns, span)) = turns {
            if turns.iter().any(|x| !x.is_finite()) {
                return Err(k.wrong_key("rotate_deg", span, "expected three angles in degrees"));
            }
            let [rx, ry, rz] = turns.map(f64::to_radians);
            let turn = DMat3::from_rotation_z(rz) * DMat3::from_rotation_y(ry) * DMat3::from_rotation_x(rx);
            affine = DAffine3::from_mat3(turn) * affine;
        }
        if let Some((shift, span)) = shift {
            if shift.iter().any(|x| !x.is_finite()) {
                return Err(k.wrong_key("translate", span, "expected three finite numbers"));
            }
            affine = DAffine3::from_translation(DVec3::from(shift)) * affine;
        }
        Transform::new(affine).ok_or_else(|| k.wrong("its transform flattens space: no inverse"))
    }

    /// This one first, then `next`.
    pub fn then(&self, next: &Transform) -> Option<Transform> {
        Transform::new(next.affine * self.affine)
    }

    /// The map itself.
    pub fn affine(&self) -> DAffine3 {
        self.affine
    }

    /// The map back.
    pub fn inverse(&self) -> DAffine3 {
        self.affine.inverse()
    }

    /// Where a place goes.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.affine.transform_point3(p)
    }

    /// What becomes of a surface's normal, at unit length; zero stays zero.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        (self.normals * n).normalize_or_zero()
    }

    /// True where left becomes right: what was counter-clockwise is clockwise.
    pub fn mirrors(&self) -> bool {
        self.affine.matrix3.determinant() < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys;
    use crate::scene::mesh::obj;

    fn read(text: &str) -> Result<Transform> {
        let mut k = keys::parse(text)?;
        let t = Transform::read(&mut k)?;
        k.finish().map(|()| t)
    }

    fn goes(text: &str, from: [f64; 3], to: [f64; 3]) {
        let got = read(text).unwrap().point(DVec3::from(from));
        assert!((got - DVec3::from(to)).length() < 1e-12, "{text}: {from:?} to {got}");
    }

    #[test]
    fn scaled_turned_moved_in_this_order() {
        goes("", [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]);
        goes("scale = 2\ntranslate = [1, 0, 0]", [1.0, 2.0, 3.0], [3.0, 4.0, 6.0]);
        goes("scale = [1, 2, -3]", [1.0, 1.0, 1.0], [1.0, 2.0, -3.0]);
        goes("rotate = [0, 0, 5, 90]", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        goes("rotate = [1, 1, 1, 120]", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        goes("rotate_deg = [90, 0, 0]", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        // x first: y goes to z, and about y on to x; z last takes it to y.
        goes("rotate_deg = [90, 90, 90]", [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
        goes("rotate_deg = [90, 90, 0]", [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
        goes("rotate_deg = [0, 0, 90]\nscale = [2, 1, 1]\ntranslate = [0, 0, 7]", [1.0, 0.0, 0.0], [0.0, 2.0, 7.0]);
        goes("matrix = [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7]]", [1.0, 2.0, 3.0], [3.0, 7.0, 10.0]);
    }

    #[test]
    fn what_flattens_is_refused_with_its_key() {
        for (bad, word) in [
            ("scale = 0", "line 1, column 9: scale"),
            ("scale = [1, 0, 1]", "scale: must not be 0"),
            ("scale = nan", "scale"),
            ("rotate = [0, 0, 0, 5]", "rotate: expected"),
            ("rotate_deg = [inf, 0, 0]", "rotate_deg"),
            ("translate = [0, nan, 0]", "translate"),
            ("matrix = [[1, 2, 3, 0], [2, 4, 6, 0], [0, 0, 1, 0]]", "matrix: it flattens"),
            ("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]\nscale = 2", "in place of"),
        ] {
            let message = read(bad).unwrap_err().to_string();
            assert!(message.contains(word), "{bad}: {message}");
        }
        // Small is not flat.
        assert!(read("scale = 1e-6").is_ok() && read("scale = [1e-6, 1, 1e6]").is_ok());
    }

    /// The normal of what was moved, by two edges, is the normal moved: under shear and mirrors too.
    #[test]
    fn normals_stay_normal_and_windings_follow() {
        for text in [
            "scale = [1, 2, 3]\nrotate_deg = [10, 20, 30]",
            "scale = [-1, 2, 3]",
            "matrix = [[1, 2, 0, 0], [0, 1, 0.5, 0], [0, 0, -2, 9]]",
        ] {
            let t = read(text).unwrap();
            let mut mesh = obj::parse(b"v 0 0 1\nv 1 0 0\nv 0 3 0\nvn 3 1 3\nf 1//1 2//1 3//1\n").unwrap();
            mesh.transform(&t);
            let [a, b, c] = mesh.triangles[0].map(|i| mesh.place(i));
            let face = (b - a).cross(c - a).normalize();
            let stated = DVec3::from(mesh.normals.unwrap()[0].map(f64::from));
            assert!((face - stated).length() < 1e-6, "{text}: {face} and {stated}");
        }
        assert!(!read("scale = -1").unwrap().then(&read("scale = -2").unwrap()).unwrap().mirrors());
        let t = read("scale = [1, 2, 3]\nrotate = [1, 2, 3, 40]\ntranslate = [5, 6, 7]").unwrap();
        let p = DVec3::new(0.1, 0.2, 0.3);
        assert!((t.inverse().transform_point3(t.point(p)) - p).length() < 1e-12);
    }
}
