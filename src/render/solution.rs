//! A solution kept in a file, to be seen from other cameras.
//!
//! Two lines of text, `luxpipe solution 2 KIND` and the fingerprint of scene and options, then a check sum (u64, little endian)
//! and the bytes of the solution. The file appears whole or not at all; one of another scene, or damaged, is refused.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::Path;

use glam::Vec3A;

use crate::material::{Lobes, Site};
use crate::render::wavelengths::Wavelengths;
use crate::scene::Scene;
use crate::stream::output::Output;
use crate::{Error, Result};

/// Stands for all that a solution depends on: surfaces, what they do to light, lamps, wavelengths, options; not for who looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Fingerprint {
    /// Of a scene and of a text that says what was asked of it.
    pub fn of(scene: &Scene, options: &str, wavelengths: &dyn Wavelengths) -> Fingerprint {
        let mut h = DefaultHasher::new();
        let media = format!("{:?}", scene.media);
        (env!("CARGO_PKG_VERSION"), options, format!("{:?}", scene.inks), media).hash(&mut h);
        (scene.frame.centre.to_array().map(f64::to_bits), scene.frame.scale.to_bits()).hash(&mut h);
        surfaces(scene, &mut h);
        lamps(scene, wavelengths, &mut h);
        Fingerprint(h.finish())
    }
}

fn bits(v: Vec3A) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}

fn surfaces(scene: &Scene, h: &mut impl Hasher) {
    for patch in scene.geometry.patches() {
        for square in [[0.1, 0.2], [0.7, 0.2], [0.1, 0.8]] {
            let (point, normal) = patch.place(square);
            (bits(point), bits(normal), patch.surface.material, patch.surface.emitter).hash(h);
        }
    }
    // A material may look at where it is: at some places and from some directions it is asked what it does.
    for material in &scene.materials {
        for i in 0..64u16 {
            let x = f32::from(i) / 64.0;
            let uv = [x, (x * 13.0).fract()];
            let place = glam::DVec3::new(x.into(), uv[1].into(), (x * 7.0).fract().into());
            let site = Site { place, uv, colour: Some([x, uv[1], 0.5]), front: i % 2 == 0 };
            let out = Vec3A::new(0.9 * x, 0.0, 1.0).normalize();
            let mut lobes = Lobes::default();
            material.lobes(&site, out, &mut lobes);
            for lobe in lobes.iter() {
                (format!("{:?}", lobe.tint), lobe.factor.to_bits(), lobe.kernel.transmits()).hash(h);
                let turn = lobe.kernel.sample(out, [0.3, 0.6]);
                turn.map(|t| (bits(t.inc), t.weight.to_bits(), t.pdf.to_bits())).hash(h);
            }
        }
    }
}

fn lamps(scene: &Scene, wavelengths: &dyn Wavelengths, h: &mut impl Hasher) {
    for (i, light) in scene.lights.iter().enumerate() {
        format!("{:?}", light.radiance).hash(h);
        wavelengths.brightness(i).iter().for_each(|x| x.to_bits().hash(h));
    }
    let places = [Vec3A::new(0.1, 0.2, 0.3), Vec3A::new(-0.7, 0.4, -0.9), Vec3A::Z * 3.0];
    for lamp in &scene.lamps {
        for (i, from) in places.into_iter().enumerate() {
            for u in [[0.2, 0.3], [0.8, 0.1], [0.6, 0.9]] {
                let Some(aim) = lamp.aim(from, u) else { continue };
                let emission = (aim.emission.light, aim.emission.parts.map(f32::to_bits));
                (i, bits(aim.direction), aim.pdf.to_bits(), emission).hash(h);
            }
        }
    }
}

fn check_sum(bytes: &[u8]) -> u64 {
    let mut h = DefaultHasher::new();
    bytes.hash(&mut h);
    h.finish()
}

fn magic(kind: &str) -> String {
    format!("luxpipe solution 2 {kind}\n")
}

/// Writes a solution.
fn write(path: &Path, kind: &str, fingerprint: Fingerprint, bytes: &[u8]) -> Result<()> {
    let mut out = Output::create(Some(path), true)?;
    let head = format!("{}{:016x}\n", magic(kind), fingerprint.0);
    let write = |out: &mut Output| {
        out.write_all(head.as_bytes())?;
        out.write_all(&check_sum(bytes).to_le_bytes())?;
        out.write_all(bytes)
    };
    write(&mut out).map_err(|e| out.error(e))?;
    out.finish()
}

/// Reads the solution of a scene; `parse` makes sense of its bytes. `None` where the file is not there yet.
fn read<T>(
    path: &Path,
    kind: &str,
    fingerprint: Fingerprint,
    parse: impl FnOnce(&mut Bytes) -> Option<T>,
) -> Result<Option<T>> {
    let all = match std::fs::read(path) {
        Ok(all) => all,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io(path.display().to_string(), e)),
    };
    let wrong = |what: String| Error::Invalid(what).in_file(path);
    let Some(rest) = all.strip_prefix(magic(kind).as_bytes()) else {
        return Err(wrong(format!("is no {kind} solution; name a new file, or one that --solution has written")));
    };
    let damaged = || wrong("the solution is damaged; remove it to solve again".into());
    let (line, rest) = rest.split_at_checked(17).ok_or_else(damaged)?;
    if line != format!("{:016x}\n", fingerprint.0).as_bytes() {
        let message = "the solution is of another scene or of other options; take those, or remove it";
        return Err(wrong(message.into()));
    }
    let (sum, body) = rest.split_first_chunk::<8>().ok_or_else(damaged)?;
    if u64::from_le_bytes(*sum) != check_sum(body) {
        return Err(damaged());
    }
    parse(&mut Bytes(body)).map(Some).ok_or_else(damaged)
}

/// The solution that a file keeps, or else a new one, which is then kept there; whether it was there.
pub fn kept<T>(
    file: Option<(&Path, Fingerprint)>,
    kind: &str,
    parse: impl FnOnce(&mut Bytes) -> Option<T>,
    solve: impl FnOnce() -> Result<T>,
    bytes: impl FnOnce(&T) -> Vec<u8>,
) -> Result<(T, bool)> {
    let Some((path, fingerprint)) = file else { return Ok((solve()?, false)) };
    if let Some(known) = read(path, kind, fingerprint, parse)? {
        return Ok((known, true));
    }
    let new = solve()?;
    write(path, kind, fingerprint, &bytes(&new))?;
    Ok((new, false))
}

/// Bytes that are read from the front.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    /// A whole number.
    pub fn word(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    /// A number.
    pub fn number(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// So many whole numbers.
    pub fn words(&mut self, count: usize) -> Option<Vec<u32>> {
        let (first, rest) = self.0.split_at_checked(count.checked_mul(4)?)?;
        self.0 = rest;
        Some(first.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    /// So many numbers.
    pub fn floats(&mut self, count: usize) -> Option<Vec<f32>> {
        Some(self.words(count)?.into_iter().map(f32::from_bits).collect())
    }
}
