//! PLY [Turk 1994, "The PLY Polygon File Format"]: ascii and both binary orders.
//!
//! Of a vertex are read `x y z`, a normal `nx ny nz`, a texture place (`s t`, `u v`, `texture_u texture_v`) and a colour
//! (`red green blue`); of a face its list `vertex_indices` or `vertex_index`. Everything else is passed over, strips and
//! texture places of faces included. Whole numbers as colours are shares of their type's greatest and sRGB-coded, as
//! scanners write them; floats are linear, 0..1.

use glam::DVec3;

use super::{Mesh, colour, direction, shown, texture_place};
use crate::display::transfer::srgb_decode;
use crate::{Error, Result, invalid};

#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// What stands for 1 in a colour of this type; `None` for floats.
    fn full(self) -> Option<f64> {
        Some(match self {
            Scalar::I8 => f64::from(i8::MAX),
            Scalar::U8 => f64::from(u8::MAX),
            Scalar::I16 => f64::from(i16::MAX),
            Scalar::U16 => f64::from(u16::MAX),
            Scalar::I32 => f64::from(i32::MAX),
            Scalar::U32 => f64::from(u32::MAX),
            Scalar::F32 | Scalar::F64 => return None,
        })
    }
}

#[derive(Clone, Copy)]
enum Property {
    One(Scalar),
    List(Scalar, Scalar),
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<(String, Property)>,
}

/// Reads a PLY file.
pub fn parse(bytes: &[u8]) -> Result<Mesh> {
    let (elements, mut body) = header(bytes)?;
    let mut mesh = Mesh::default();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => vertices(element, &mut body, &mut mesh)?,
            "face" => faces(element, &mut body, &mut mesh)?,
            _ => pass_over(element, &mut body)?,
        }
    }
    mesh.finished()
}

/// What a vertex may have: `x y z`, normal, texture place, colour, by their names.
const ROLES: [(&[&str], usize); 11] = [
    (&["x"], 0),
    (&["y"], 1),
    (&["z"], 2),
    (&["nx"], 3),
    (&["ny"], 4),
    (&["nz"], 5),
    (&["s", "u", "texture_u"], 6),
    (&["t", "v", "texture_v"], 7),
    (&["red"], 8),
    (&["green"], 9),
    (&["blue"], 10),
];

fn vertices(element: &Element, body: &mut Body, mesh: &mut Mesh) -> Result<()> {
    let role = |name: &str| ROLES.iter().find(|r| r.0.contains(&name)).map(|r| r.1);
    let plan: Vec<(Option<usize>, Property)> = element.properties.iter().map(|(name, p)| (role(name), *p)).collect();
    let kind = |slot: usize| {
        plan.iter().rev().find_map(|(role, p)| match p {
            Property::One(kind) if *role == Some(slot) => Some(*kind),
            _ => None,
        })
    };
    let has = |slots: std::ops::Range<usize>| slots.into_iter().all(|s| kind(s).is_some());
    if element.count > 0 && !has(0..3) {
        return invalid!("its vertices have no x y z");
    }
    let (normals, uvs, colours) = (has(3..6), has(6..8), has(8..11));
    let full = [8, 9, 10].map(|s| kind(s).and_then(Scalar::full));
    // A count is a claim: nothing is reserved for it, and the data must bear it out.
    for i in 0..element.count {
        let what = || format!("vertex {}", i + 1);
        let mut v = [0.0; 11];
        for (role, property) in &plan {
            match (property, role) {
                (Property::One(kind), Some(slot)) => v[*slot] = body.number(*kind, what)?,
                (Property::One(kind), None) => drop(body.number(*kind, what)?),
                (Property::List(count, kind), _) => body.list(*count, *kind, what, |_| ())?,
            }
        }
        mesh.corner(DVec3::new(v[0], v[1], v[2]));
        if normals {
            mesh.normals.get_or_insert_default().push(direction([v[3], v[4], v[5]], what)?);
        }
        if uvs {
            mesh.uvs.get_or_insert_default().push(texture_place([v[6], v[7]], what)?);
        }
        if colours {
            let linear = [0, 1, 2].map(|k| full[k].map_or(v[8 + k], |full| srgb_decode(v[8 + k] / full)));
            mesh.colours.get_or_insert_default().push(colour(linear, what)?);
        }
    }
    Ok(())
}

fn faces(element: &Element, body: &mut Body, mesh: &mut Mesh) -> Result<()> {
    let mut corners: Vec<u32> = Vec::new();
    for i in 0..element.count {
        let what = || format!("face {}", i + 1);
        corners.clear();
        let mut whole = true;
        for (name, property) in &element.properties {
            match property {
                Property::One(kind) => drop(body.number(*kind, what)?),
                Property::List(count, kind) if ["vertex_indices", "vertex_index"].contains(&name.as_str()) => {
                    body.list(*count, *kind, what, |c| {
                        whole &= c.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&c);
                        corners.push(c as u32);
                    })?;
                }
                Property::List(count, kind) => body.list(*count, *kind, what, |_| ())?,
            }
        }
        if !whole {
            return invalid!("{}: a corner is no index", what());
        }
        mesh.polygon(&corners, u32::try_from(i + 1).unwrap_or(u32::MAX), what)?;
    }
    Ok(())
}

fn pass_over(element: &Element, body: &mut Body) -> Result<()> {
    for i in 0..element.count {
        let what = || format!("{} {}", shown(&element.name), i + 1);
        for (_, property) in &element.properties {
            match property {
                Property::One(kind) => drop(body.number(*kind, what)?),
                Property::List(count, kind) => body.list(*count, *kind, what, |_| ())?,
            }
        }
    }
    Ok(())
}

fn header(bytes: &[u8]) -> Result<(Vec<Element>, Body<'_>)> {
    let mut rest = bytes;
    let mut coding = None;
    let mut elements: Vec<Element> = Vec::new();
    for number in 1.. {
        let Some(end) = rest.iter().position(|b| *b == b'\n').filter(|_| number < 10_000) else {
            return invalid!("header has no end_header line");
        };
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = &rest[end + 1..];
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let wrong = || Error::Invalid(format!("line {number}: '{}' is no PLY header", shown(&line)));
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(wrong()),
            ["format", "ascii", _] => coding = Some(Coding::Ascii),
            ["format", "binary_little_endian", _] => coding = Some(Coding::Little),
            ["format", "binary_big_endian", _] => coding = Some(Coding::Big),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong())?;
                elements.push(Element { name: name.to_string(), count, properties: Vec::new() });
            }
            ["property", "list", count, kind, name] => {
                let list = Property::List(scalar(count).ok_or_else(wrong)?, scalar(kind).ok_or_else(wrong)?);
                elements.last_mut().ok_or_else(wrong)?.properties.push((name.to_string(), list));
            }
            ["property", kind, name] => {
                let one = Property::One(scalar(kind).ok_or_else(wrong)?);
                elements.last_mut().ok_or_else(wrong)?.properties.push((name.to_string(), one));
            }
            ["end_header"] => break,
            ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(wrong()),
        }
    }
    if let Some(e) = elements.iter().find(|e| e.properties.is_empty() && e.count > 0) {
        return invalid!("element {} has no property", shown(&e.name));
    }
    for name in ["vertex", "face"] {
        if elements.iter().filter(|e| e.name == name).count() > 1 {
            return invalid!("element {name} comes twice");
        }
    }
    let coding = coding.ok_or_else(|| Error::Invalid("header has no format line".into()))?;
    Ok((elements, Body { coding, rest }))
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return None,
    })
}

struct Body<'a> {
    coding: Coding,
    rest: &'a [u8],
}

impl Body<'_> {
    /// A list's items, one by one.
    fn list(
        &mut self,
        count: Scalar,
        kind: Scalar,
        what: impl Fn() -> String + Copy,
        mut item: impl FnMut(f64),
    ) -> Result<()> {
        let n = self.number(count, what)?;
        if n.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&n) {
            return invalid!("{}: {n} is no length of a list", what());
        }
        for _ in 0..n as u32 {
            item(self.number(kind, what)?);
        }
        Ok(())
    }

    fn number(&mut self, kind: Scalar, what: impl Fn() -> String) -> Result<f64> {
        if self.coding == Coding::Ascii {
            let Some(start) = self.rest.iter().position(|b| !b.is_ascii_whitespace()) else {
                return invalid!("the file ends in {}", what());
            };
            let word = &self.rest[start..];
            let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
            self.rest = &self.rest[start + word.len()..];
            let number = std::str::from_utf8(word).ok().and_then(|t| t.parse::<f64>().ok());
            let wrong = || Error::Invalid(format!("{}: '{}' is no number", what(), crate::error::printable(word)));
            return number.ok_or_else(wrong);
        }
        let number = match kind {
            Scalar::I8 => self.bytes::<1>().map(|b| f64::from(b[0] as i8)),
            Scalar::U8 => self.bytes::<1>().map(|b| f64::from(b[0])),
            Scalar::I16 => self.bytes().map(|b| f64::from(i16::from_le_bytes(b))),
            Scalar::U16 => self.bytes().map(|b| f64::from(u16::from_le_bytes(b))),
            Scalar::I32 => self.bytes().map(|b| f64::from(i32::from_le_bytes(b))),
            Scalar::U32 => self.bytes().map(|b| f64::from(u32::from_le_bytes(b))),
            Scalar::F32 => self.bytes().map(|b| f64::from(f32::from_le_bytes(b))),
            Scalar::F64 => self.bytes().map(f64::from_le_bytes),
        };
        number.ok_or_else(|| Error::Invalid(format!("the file ends in {}", what())))
    }

    /// The next N bytes in little-endian order.
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *head;
        if self.coding == Coding::Big {
            bytes.reverse();
        }
        Some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn binary(coding: &str, bytes: impl Fn(f32) -> [u8; 4], index: impl Fn(i32) -> [u8; 4]) -> Vec<u8> {
        let mut file = format!("ply\nformat {coding} 1.0\n{HEADER}").into_bytes();
        for p in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]] {
            p.iter().for_each(|x| file.extend(bytes(*x)));
            file.push(7);
        }
        file.push(3);
        (0..3).for_each(|i| file.extend(index(i)));
        file
    }

    #[test]
    fn the_three_codings_agree() {
        let ascii = format!("ply\nformat ascii 1.0\n{HEADER}0 0 0 7\n1 0 0 7\n0 2 0 7\n3 0 1 2\n").into_bytes();
        let mesh = parse(&ascii).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.positions[2], [0.0, 2.0, 0.0]);
        assert_eq!(parse(&binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes)).unwrap(), mesh);
        assert_eq!(parse(&binary("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes)).unwrap(), mesh);
    }

    #[test]
    fn every_cut_is_an_error_and_no_flip_a_panic() {
        let file = binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes);
        for cut in 0..file.len() {
            assert!(parse(&file[..cut]).is_err(), "cut at {cut}");
            for bit in 0..8 {
                let mut bad = file.clone();
                bad[cut] ^= 1 << bit;
                let _ = parse(&bad);
            }
        }
    }

    fn with(vertex: &str, rows: [&str; 3]) -> Result<Mesh> {
        let properties: String = vertex.split(", ").map(|p| format!("property {p}\n")).collect();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\n{properties}element face 1\n\
             property list uchar int vertex_index\nend_header\n{}\n3 0 1 2\n",
            rows.join("\n")
        );
        parse(text.as_bytes())
    }

    #[test]
    fn normals_texture_places_and_colours() {
        let all = "double x, double y, double z, float nx, float ny, float nz, float texture_u, float texture_v, \
            uchar red, uchar green, uchar blue, uchar alpha";
        let mesh =
            with(all, ["0 0 0 0 0 3 0 0.5 0 128 255 9", "1 0 0 0 0 1 1 0 0 0 0 9", "0 1 0 0 0 1 0 0 0 0 0 9"]).unwrap();
        assert_eq!(mesh.normals.unwrap()[0], [0.0, 0.0, 1.0]);
        assert_eq!(mesh.uvs.unwrap()[0], [0.0, 0.5]);
        // IEC 61966-2-1: ((128/255 + 0.055) / 1.055)^2.4 = 0.215861.
        let [r, g, b] = mesh.colours.unwrap()[0];
        assert!(r == 0.0 && (g - 0.215_861).abs() < 1e-6 && b == 1.0, "{r} {g} {b}");
        let floats = "float x, float y, float z, float red, float green, float blue, float s, float t";
        let mesh = with(floats, ["0 0 0 0.5 0 1 2 3", "1 0 0 0 0 0 0 0", "0 1 0 0 0 0 0 0"]).unwrap();
        assert_eq!((mesh.colours.unwrap()[0], mesh.uvs.unwrap()[0]), ([0.5, 0.0, 1.0], [2.0, 3.0]));
        for (properties, row, word) in [
            ("float x, float y, float z, float nx, float ny, float nz", "0 0 0 0 0 0", "vertex 1: the normal"),
            ("float x, float y, float z, float u, float v", "0 0 0 inf 0", "vertex 1: a texture coordinate"),
            ("float x, float y, float z, float red, float green, float blue", "0 0 0 0 -1 0", "vertex 1: the colour"),
            ("float x, float y, float z", "0 nan 0", "face 1: vertex 1 is not finite"),
            ("float x, float y", "0 0", "no x y z"),
        ] {
            let message = with(properties, [row; 3]).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn doubles_far_out_keep_their_digits() {
        let mesh = with(
            "double x, double y, double z",
            ["500000.0001 4500000.0002 0", "500000.0003 4500000.0002 0", "500000.0001 4500000.0005 0"],
        )
        .unwrap();
        let edge = mesh.place(2) - mesh.place(0);
        assert!((edge.y - 3e-4).abs() < 1e-9, "{edge}");
    }

    #[test]
    fn lists_have_a_length() {
        let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list float int vertex_indices\nend_header\n0 0 0\n";
        for length in ["-3", "2.5", "nan", "1e30"] {
            let message = parse(format!("{text}{length} 0 0 0\n").as_bytes()).unwrap_err().to_string();
            assert!(message.contains("is no length"), "{message}");
        }
    }
}
