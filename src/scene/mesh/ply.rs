//! PLY (Stanford): ascii and both binary orders; vertices' x y z and faces' index lists, everything else passed over.

use super::Mesh;
use crate::{Error, Result, invalid};

#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy)]
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
    let (coding, elements, mut body) = header(bytes)?;
    let mut mesh = Mesh::default();
    for element in &elements {
        // A count is a claim: nothing is reserved for it, and the data must bear it out.
        for i in 0..element.count {
            let what = format!("{} {}", element.name, i + 1);
            let mut position = [0f32; 3];
            let mut corners = Vec::new();
            for (name, property) in &element.properties {
                match property {
                    Property::One(kind) => {
                        let value = body.number(*kind, &what)?;
                        if let Some(axis) = ["x", "y", "z"].iter().position(|a| a == name) {
                            position[axis] = value as f32;
                        }
                    }
                    Property::List(count, kind) => {
                        let n = body.number(*count, &what)?;
                        let wanted = ["vertex_indices", "vertex_index"].contains(&name.as_str());
                        for _ in 0..n as usize {
                            let value = body.number(*kind, &what)?;
                            if wanted {
                                corners.push(value);
                            }
                        }
                    }
                }
            }
            if element.name == "vertex" {
                mesh.corner(position, &what)?;
            } else if element.name == "face" {
                let whole =
                    |c: &f64| (c.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(c)).then_some(*c as u32);
                let corners: Option<Vec<u32>> = corners.iter().map(whole).collect();
                let corners = corners.ok_or_else(|| Error::Invalid(format!("{what}: a corner is no index")))?;
                mesh.polygon(&corners, &what)?;
            }
        }
    }
    if coding == Coding::Ascii && mesh.positions.is_empty() || mesh.triangles.is_empty() {
        return invalid!("no face found");
    }
    Ok(mesh)
}

fn header(bytes: &[u8]) -> Result<(Coding, Vec<Element>, Body<'_>)> {
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
        let wrong = || {
            Error::Invalid(format!("line {number}: '{}' is no PLY header", crate::error::printable(line.as_bytes())))
        };
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
        return invalid!("element {} has no property", crate::error::printable(e.name.as_bytes()));
    }
    let coding = coding.ok_or_else(|| Error::Invalid("header has no format line".into()))?;
    Ok((coding, elements, Body { coding, rest }))
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
    fn number(&mut self, kind: Scalar, what: &str) -> Result<f64> {
        let ends = || Error::Invalid(format!("the file ends in {what}"));
        if self.coding == Coding::Ascii {
            let start = self.rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(ends)?;
            let word = &self.rest[start..];
            let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
            self.rest = &self.rest[start + word.len()..];
            let text = std::str::from_utf8(word).ok().and_then(|t| t.parse::<f64>().ok());
            return text
                .ok_or_else(|| Error::Invalid(format!("{what}: '{}' is no number", crate::error::printable(word))));
        }
        Ok(match kind {
            Scalar::I8 => f64::from(self.bytes::<1>().ok_or_else(ends)?[0] as i8),
            Scalar::U8 => f64::from(self.bytes::<1>().ok_or_else(ends)?[0]),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.bytes().ok_or_else(ends)?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.bytes().ok_or_else(ends)?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.bytes().ok_or_else(ends)?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.bytes().ok_or_else(ends)?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.bytes().ok_or_else(ends)?)),
            Scalar::F64 => f64::from_le_bytes(self.bytes().ok_or_else(ends)?),
        })
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
    fn every_cut_is_an_error() {
        let file = binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes);
        for cut in 0..file.len() {
            assert!(parse(&file[..cut]).is_err(), "cut at {cut}");
        }
    }
}
