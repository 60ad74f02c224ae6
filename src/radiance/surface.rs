//! Radiance's surfaces, moved to where they stand, and the tables of the scene language that they become.
//!
//! | Radiance's | arguments | front | becomes |
//! |---|---|---|---|
//! | polygon | x y z of three corners or more | from where they run counter-clockwise | `triangle`, `quad` where it is a rectangle, `polygon` |
//! | sphere, bubble | centre, radius | outside, inside | `sphere` |
//! | cylinder, tube | both ends, radius | outside, inside | `cylinder` |
//! | cone, cup | both ends, both radii | outside, inside | `cone` |
//! | ring | centre, normal, both radii | that of the normal | `disk` |
//! | mesh | file, transform | the file's | `mesh` |
//!
//! A polygon without area is left out, as Radiance does.

use std::fmt::Write as _;
use std::path::Path;

use glam::{DMat3, DVec3};

use crate::Result;
use crate::error::printable;
use crate::radiance::Scene;
use crate::radiance::material::Look;
use crate::radiance::object::Object;
use crate::radiance::read::{Around, beside};
use crate::radiance::write::{list, number, quoted};
use crate::radiance::xform::motion;
use crate::scene::mesh::polygon;

/// Types that are no modifiers.
pub const KINDS: &[&str] =
    &["polygon", "sphere", "bubble", "cylinder", "tube", "cone", "cup", "ring", "source", "mesh", "instance"];

/// A surface's own lines, and its normal where it has only one.
struct Form {
    keys: String,
    normal: Option<DVec3>,
}

impl Scene {
    /// Writes a surface.
    pub fn surface(&mut self, object: &Object, around: &Around, folder: &Path) -> Result<()> {
        self.count(&object.place)?;
        let modifier = around.modifier.as_ref().unwrap_or(&object.modifier);
        let first = self.modifiers.find(modifier, object)?;
        let form = match object.kind.as_str() {
            "source" => None,
            "instance" => {
                let message = format!(
                    "{} is an octree, which is not read; expected the scene that it was made of",
                    object.shown()
                );
                return self.refuse(&object.place, "instance", &message);
            }
            "mesh" => match self.mesh(object, around, folder)? {
                None => return Ok(()),
                form => form,
            },
            _ => match form(object, around)? {
                None => {
                    self.leave_out("surface without area");
                    return Ok(());
                }
                form => form,
            },
        };
        let Some(first) = first else {
            self.leave_out("surface of void");
            return Ok(());
        };
        let resolved = self.modifiers.resolve(first);
        if let Some(kind) = &resolved.unread {
            self.leave_out(&format!("surface of {kind}"));
            return Ok(());
        }
        let Some(form) = form else { return self.source(object, around, &resolved) };
        if resolved.sky.is_some() {
            return Err(object.wrong("has a sky's brightness function, which only a source can show here"));
        }
        let Some(look) = self.palette.look(first, modifier, &resolved, object)? else {
            self.leave_out("surface that is not seen");
            return Ok(());
        };
        check_spot(object, &look, &form)?;
        self.note_illum(&resolved, modifier);
        self.write(&around.name(&object.name), &form, &look);
        Ok(())
    }

    fn write(&mut self, name: &str, form: &Form, look: &Look) {
        let shapes = &mut self.shapes;
        // A String takes them all.
        let _ = write!(shapes, "\n[[shape]]\n{}material = {}\n", form.keys, quoted(&look.material));
        if let Some(light) = &look.light {
            let _ = writeln!(shapes, "light = {}", quoted(light));
        }
        let _ = writeln!(shapes, "name = {}", quoted(name));
    }

    fn note_illum(&self, resolved: &crate::radiance::modifier::Resolved, name: &str) {
        use crate::radiance::material::Material;
        if matches!(&resolved.material, Some(Material::Light(shine)) if shine.illum) {
            let name = printable(name.as_bytes());
            self.notes.add(format!("illum '{name}' is seen as the light that it gives, and hides what is behind it"));
        }
    }

    /// A mesh by the OBJ that `obj2mesh` was given; `None` where it is left out.
    fn mesh(&mut self, object: &Object, around: &Around, folder: &Path) -> Result<Option<Form>> {
        let [file, transform @ ..] = object.strings.as_slice() else {
            return Err(object.wrong("expected the name of a file, and transforms"));
        };
        let (own, rest) = motion(transform).map_err(|e| object.wrong(e))?;
        if let Some(word) = rest.first() {
            return Err(object.wrong(format!("'{}' is no transform", printable(word.as_bytes()))));
        }
        let found = beside(folder, Path::new(file)).with_extension("obj");
        let Ok(full) = std::fs::canonicalize(&found) else {
            let shown = printable(found.as_os_str().as_encoded_bytes());
            let message = format!(
                "{}: compiled meshes are not read, and there is no '{shown}' that it was made of",
                object.shown()
            );
            return self.refuse(&object.place, "mesh", &message).map(|()| None);
        };
        let Some(full) = full.to_str() else { return Err(object.wrong("the file's name is no text")) };
        let affine = own.then(&around.motion).affine;
        let m: DMat3 = affine.matrix3;
        let row = |i: usize| list([m.row(i).x, m.row(i).y, m.row(i).z, affine.translation[i]]);
        let keys = format!("type = \"mesh\"\nfile = {}\nmatrix = [{}, {}, {}]\n", quoted(full), row(0), row(1), row(2));
        Ok(Some(Form { keys, normal: None }))
    }
}

/// Light in a cone is told by the angle from the surface's normal here.
fn check_spot(object: &Object, look: &Look, form: &Form) -> Result<()> {
    let Some((angle_deg, aim)) = look.spot.filter(|_| look.light.is_some()) else { return Ok(()) };
    // Within a quarter of a degree.
    let along = form.normal.is_some_and(|n| n.dot(aim) > 0.25f64.to_radians().cos());
    if along || angle_deg >= 360.0 {
        return Ok(());
    }
    Err(object.wrong("a spotlight that is not aimed along the normal of a polygon or ring is not read; expected a light, or another aim"))
}

fn point(p: DVec3) -> String {
    list(p.to_array())
}

/// `None` where it has no area.
fn form(object: &Object, around: &Around) -> Result<Option<Form>> {
    let moved = &around.motion;
    let inward = |inside: bool| if inside != around.inverted { "inward = true\n" } else { "" };
    let positive = |what: &str, x: f64| {
        if x > 0.0 { Ok(x * moved.scale) } else { Err(object.wrong(format!("{what} {x} must be above 0"))) }
    };
    let ends = |a: DVec3, b: DVec3| {
        if a == b { Err(object.wrong("both ends are one point")) } else { Ok((moved.point(a), moved.point(b))) }
    };
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let keys = match object.kind.as_str() {
        "polygon" => return outline(object, around),
        "ring" => return ring(object, around).map(Some),
        "sphere" | "bubble" => {
            let [x, y, z, r] = object.exactly("x y z radius")?;
            // A negative radius turns it inside out in Radiance.
            let inside = (object.kind == "bubble") != (r < 0.0);
            let (centre, r) = (point(moved.point(v(x, y, z))), number(positive("radius", r.abs())?));
            format!("type = \"sphere\"\ncenter = {centre}\nradius = {r}\n{}", inward(inside))
        }
        "cylinder" | "tube" => {
            let [x, y, z, p, q, s, r] = object.exactly("x y z of both ends, radius")?;
            let (a, b) = ends(v(x, y, z), v(p, q, s))?;
            let r = number(positive("radius", r)?);
            cylinder(a, b, &r, inward(object.kind == "tube"))
        }
        _ => {
            let [x, y, z, p, q, s, r0, r1] = object.exactly("x y z of both ends, both radii")?;
            let (a, b) = ends(v(x, y, z), v(p, q, s))?;
            if r0 < 0.0 || r1 < 0.0 || r0 + r1 == 0.0 {
                return Err(object.wrong(format!("radii {r0} and {r1}: neither must be below 0, and one above")));
            }
            let [first, last] = [r0, r1].map(|r| number(r * moved.scale));
            if r0 == r1 {
                return Ok(Some(Form { keys: cylinder(a, b, &first, inward(object.kind == "cup")), normal: None }));
            }
            let (a, b, inward) = (point(a), point(b), inward(object.kind == "cup"));
            format!("type = \"cone\"\nbase = {a}\ntop = {b}\nradius = {first}\ntop_radius = {last}\n{inward}")
        }
    };
    Ok(Some(Form { keys, normal: None }))
}

fn cylinder(a: DVec3, b: DVec3, r: &str, inward: &str) -> String {
    format!("type = \"cylinder\"\nbase = {}\ntop = {}\nradius = {r}\n{inward}", point(a), point(b))
}

fn ring(object: &Object, around: &Around) -> Result<Form> {
    let [x, y, z, p, q, s, r0, r1] = object.exactly("x y z of the centre and of the normal, both radii")?;
    let (inner, outer) = if r0 < r1 { (r0, r1) } else { (r1, r0) };
    let normal = around.motion.vector(DVec3::new(p, q, s)).normalize_or_zero();
    if normal == DVec3::ZERO {
        return Err(object.wrong("the normal has no length"));
    }
    if inner < 0.0 || inner == outer {
        return Err(object.wrong(format!("radii {r0} and {r1}: neither must be below 0, and one larger")));
    }
    let normal = if around.inverted { -normal } else { normal };
    let centre = point(around.motion.point(DVec3::new(x, y, z)));
    let [inner, outer] = [inner, outer].map(|r| number(r * around.motion.scale));
    let hole = if inner == "0" { String::new() } else { format!("inner_radius = {inner}\n") };
    let keys = format!("type = \"disk\"\ncenter = {centre}\nnormal = {}\nradius = {outer}\n{hole}", point(normal));
    Ok(Form { keys, normal: Some(normal) })
}

fn outline(object: &Object, around: &Around) -> Result<Option<Form>> {
    let n = object.reals.len();
    if !object.strings.is_empty() || !n.is_multiple_of(3) || n < 9 {
        let message =
            format!("has {} words and {n} numbers; expected x y z of three corners or more", object.strings.len());
        return Err(object.wrong(message));
    }
    let mut p: Vec<DVec3> = object.reals.chunks_exact(3).map(|c| around.motion.point(DVec3::from_slice(c))).collect();
    if around.motion.mirrored != around.inverted {
        p.reverse();
    }
    p.dedup();
    if p.len() > 1 && p.first() == p.last() {
        p.pop();
    }
    let Some(normal) = normal(&p) else { return Ok(None) };
    // It is cut when the scene is read; what cannot be is better said here.
    polygon::cut(&p).map_err(|e| object.wrong(e))?;
    let kind = match p[..] {
        [_, _, _] => "triangle",
        [a, b, c, d] if is_rectangle([a, b, c, d]) => "quad",
        _ => "polygon",
    };
    let points: Vec<String> = p.iter().map(|p| point(*p)).collect();
    let keys = format!("type = \"{kind}\"\npoints = [{}]\n", points.join(", "));
    Ok(Some(Form { keys, normal: Some(normal) }))
}

/// Newell's normal, whatever the outline's bends; `None` without area.
fn normal(p: &[DVec3]) -> Option<DVec3> {
    let first = *p.first()?;
    let sum: DVec3 = p.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum();
    let size = p.iter().map(|q| q.distance_squared(first)).fold(0.0, f64::max);
    (p.len() > 2 && sum.length() > 1e-7 * size).then(|| sum.normalize())
}

fn is_rectangle([a, b, c, d]: [DVec3; 4]) -> bool {
    let (u, v) = (b - a, d - a);
    let size = u.length() + v.length();
    (c - (b + v)).length() < 1e-9 * size && u.dot(v).abs() < 1e-9 * size * size
}
