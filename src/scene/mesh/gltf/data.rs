//! glTF's bytes: GLB chunks, buffers from anywhere, numbers in them.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use gltf_json::Root;
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::validation::Checked;

use super::shown;
use crate::{Error, Result, invalid};

/// The JSON and the binary chunk of a GLB; a file that is no GLB is JSON.
pub fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let (version, length) = (word(4), word(8));
    if version.is_some_and(|v| v != 2) {
        return Err(Error::Unsupported(format!("GLB version {}; expected 2", version.unwrap_or(0))));
    }
    let Some(bytes) = length.and_then(|n| bytes.get(..n as usize)) else {
        return invalid!("the GLB ends after {} bytes; it says it has {}", bytes.len(), length.unwrap_or(12));
    };
    let mut found: [Option<&[u8]>; 2] = [None; 2];
    let mut rest = bytes.get(12..).unwrap_or_default();
    while !rest.is_empty() {
        let head = rest.split_first_chunk::<4>().and_then(|(n, rest)| Some((n, rest.split_first_chunk::<4>()?)));
        let Some((n, (kind, body))) = head else { return invalid!("the GLB ends within a chunk's head") };
        let n = u32::from_le_bytes(*n) as usize;
        let Some((chunk, after)) = body.split_at_checked(n) else {
            return invalid!("a chunk of the GLB has {} bytes of {n}", body.len());
        };
        // The first of each counts; others are for extensions.
        match kind {
            b"JSON" => _ = found[0].get_or_insert(chunk),
            b"BIN\0" => _ = found[1].get_or_insert(chunk),
            _ => {}
        }
        rest = after;
    }
    let [Some(json), binary] = found else { return invalid!("the GLB has no JSON chunk") };
    Ok((json, binary))
}

/// The first bytes of a file beside the scene.
pub fn read_file(folder: &Path, uri: &str, length: u64) -> Result<Vec<u8>> {
    let name = unescaped(uri)?;
    if name.contains("://") || name.starts_with('/') || name.contains('\0') {
        return Err(Error::Unsupported(format!("'{}': only files beside the glTF are read", shown(&name))));
    }
    let failed = |e| Error::io(shown(&name), e);
    let file = crate::files::open(folder.join(&name)).map_err(failed)?;
    if !file.metadata().map_err(failed)?.is_file() {
        return invalid!("'{}' is no file", shown(&name));
    }
    let mut out = Vec::new();
    file.take(length).read_to_end(&mut out).map_err(failed)?;
    Ok(out)
}

/// A URI's path with its %XX read [RFC 3986].
fn unescaped(uri: &str) -> Result<String> {
    let mut out = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        rest = after;
        if *first != b'%' {
            out.push(*first);
            continue;
        }
        let code =
            after.get(..2).and_then(|h| std::str::from_utf8(h).ok()).and_then(|h| u8::from_str_radix(h, 16).ok());
        let Some(code) = code else { return invalid!("'{}' is no URI", shown(uri)) };
        out.push(code);
        rest = &after[2..];
    }
    String::from_utf8(out).map_err(|_| Error::Invalid(format!("'{}' is no URI", shown(uri))))
}

/// All buffers of a glTF.
pub struct Buffers<'a> {
    root: &'a Root,
    bytes: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    /// Gets them from the GLB's binary chunk, from base64 or from other files.
    pub fn new(root: &'a Root, glb: Option<&'a [u8]>, fetch: impl Fn(&str, u64) -> Result<Vec<u8>>) -> Result<Self> {
        let mut bytes = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let length = buffer.byte_length.0;
            let data: Cow<[u8]> = match (&buffer.uri, glb) {
                (Some(uri), _) if uri.starts_with("data:") => {
                    let data = uri.split_once(";base64,").and_then(|u| crate::base64::decoded(u.1));
                    Cow::from(data.ok_or_else(|| Error::Invalid(format!("buffer {i}: its data URI is not base64")))?)
                }
                (Some(uri), _) => Cow::from(fetch(uri, length).map_err(|e| e.within(&format!("buffer {i}")))?),
                (None, Some(glb)) if i == 0 => Cow::from(glb),
                (None, _) => return invalid!("buffer {i} has neither a URI nor the GLB's binary chunk"),
            };
            if (data.len() as u64) < length {
                return invalid!("buffer {i} has {} bytes of {length}", data.len());
            }
            bytes.push(data);
        }
        Ok(Buffers { root, bytes })
    }

    /// The numbers of an accessor whose items have as many components as `widths` allows.
    pub fn accessor(&self, index: usize, widths: &[usize]) -> Result<Numbers<'_>> {
        let what = format!("accessor {index}");
        let Some(accessor) = self.root.accessors.get(index) else { return invalid!("{what} is missing") };
        if accessor.sparse.is_some() {
            return Err(Error::Unsupported(format!("{what} is sparse, which is not read")));
        }
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
            return invalid!("{what}: its type is none of glTF's");
        };
        let width = match kind {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 => 4,
            _ => 0,
        };
        if !widths.contains(&width) {
            return invalid!("{what}: its items have not the {} components wanted here", widths[0]);
        }
        let Some(view) = accessor.buffer_view.and_then(|v| self.root.get(v)) else {
            return invalid!("{what}: its buffer view is missing");
        };
        let Some(buffer) = self.bytes.get(view.buffer.value()) else {
            return invalid!("{what}: its buffer is missing");
        };
        let size = size(component.0);
        let stride = view.byte_stride.map_or(width * size, |s| s.0);
        if stride < width * size {
            return invalid!("{what}: a stride of {stride} bytes is too short for its items");
        }
        let within = |bytes: &'_ [u8], from: u64, length: Option<u64>| -> Option<std::ops::Range<usize>> {
            let from = usize::try_from(from).ok()?;
            let to = match length {
                Some(n) => from.checked_add(usize::try_from(n).ok()?)?,
                None => bytes.len(),
            };
            (from <= to && to <= bytes.len()).then_some(from..to)
        };
        let view_range = within(buffer, view.byte_offset.map_or(0, |o| o.0), Some(view.byte_length.0));
        let bytes = view_range.map(|r| &buffer[r]);
        let bytes = bytes.and_then(|b| Some(&b[within(b, accessor.byte_offset.map_or(0, |o| o.0), None)?]));
        let count = usize::try_from(accessor.count.0).ok();
        let last = count.and_then(|n| n.saturating_sub(1).checked_mul(stride)?.checked_add(width * size));
        match (bytes, count, last) {
            (Some(bytes), Some(count), Some(last)) if count == 0 || last <= bytes.len() => {
                Ok(Numbers { bytes, stride, count, component: component.0, normalized: accessor.normalized })
            }
            _ => invalid!("{what}: its {} items lie beyond its buffer", accessor.count.0),
        }
    }
}

fn size(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// Numbers in a buffer, all within it.
pub struct Numbers<'a> {
    bytes: &'a [u8],
    stride: usize,
    /// Items.
    pub count: usize,
    component: ComponentType,
    normalized: bool,
}

impl Numbers<'_> {
    /// Component `k` of item `i`; whole numbers as shares of their greatest where they are normalized.
    pub fn at(&self, i: usize, k: usize) -> f64 {
        let at = &self.bytes[i * self.stride + k * size(self.component)..];
        let (value, full) = match self.component {
            ComponentType::I8 => (f64::from(at[0] as i8), 127.0),
            ComponentType::U8 => (f64::from(at[0]), 255.0),
            ComponentType::I16 => (f64::from(i16::from_le_bytes([at[0], at[1]])), 32767.0),
            ComponentType::U16 => (f64::from(u16::from_le_bytes([at[0], at[1]])), 65535.0),
            ComponentType::U32 => (f64::from(u32::from_le_bytes([at[0], at[1], at[2], at[3]])), 4_294_967_295.0),
            ComponentType::F32 => return f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]])),
        };
        if self.normalized { (value / full).max(-1.0) } else { value }
    }

    /// True for plain whole numbers from 0.
    pub fn are_indices(&self) -> bool {
        !self.normalized && matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
    }

    /// The first three components of item `i`.
    pub fn triple(&self, i: usize) -> [f64; 3] {
        [self.at(i, 0), self.at(i, 1), self.at(i, 2)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unescaped_and_stay_beside_the_file() {
        assert_eq!(unescaped("my%20cube%C3%A9.bin").unwrap(), "my cubeé.bin");
        for bad in ["%", "%2", "%zz", "%FF", "%é"] {
            assert!(unescaped(bad).is_err(), "{bad}");
        }
        for (uri, word) in
            [("http://x/y.bin", "beside"), ("/dev/zero", "beside"), ("src", "no file"), ("none.bin", "none")]
        {
            let message = read_file(Path::new(env!("CARGO_MANIFEST_DIR")), uri, 9).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
