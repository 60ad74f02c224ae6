//! A solution kept in a file, to be seen from other cameras.
//!
//! Two lines of text, `luxpipe radiosity 1` and the fingerprint of scene and options, then numbers, little endian: a check sum
//! (u64) of all that follows; for each surface its cells along both sides (u32, u32) and which of its sides are awake (u32, front
//! 1, back 2), preceded by their number (u32); the lights (u32) preceded by their number; error, residual, share of glossy area
//! (f64, an error that was not asked for is NaN) and steps (u32); the rows (f32). The file appears whole or not at all.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::Path;

use glam::Vec3A;

use crate::render::radiosity::mesh::Mesh;
use crate::render::radiosity::prepare::Workshop;
use crate::render::radiosity::solve::Solved;
use crate::render::radiosity::{Account, Options, Show};
use crate::render::stored::Stored;
use crate::render::wavelengths::Wavelengths;
use crate::scene::Scene;
use crate::stream::output::Output;
use crate::{Error, Result};

const MAGIC: &str = "luxpipe radiosity 1\n";

/// Stands for all that a solution depends on: surfaces, what they reflect, what lamps send, options; not for who looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Fingerprint {
    /// Of a scene and what is asked of it.
    pub fn of(scene: &Scene, options: &Options, wavelengths: &dyn Wavelengths) -> Fingerprint {
        let mut h = DefaultHasher::new();
        env!("CARGO_PKG_VERSION").hash(&mut h);
        let Options { divide, tolerance, rays, show, memory: _, solution: _, seed } = options;
        (divide, tolerance.to_bits(), rays, *show == Show::Mesh, seed).hash(&mut h);
        let bits = |v: Vec3A| v.to_array().map(f32::to_bits);
        (scene.frame.centre.to_array().map(f64::to_bits), scene.frame.scale.to_bits()).hash(&mut h);
        let mesh = Mesh::new(&scene.geometry, |_| [2, 2]);
        let workshop = Workshop { scene, options, wavelengths, lights: Vec::new() };
        let mut asked = vec![[0u32; 2]; scene.materials.len()];
        for (i, tile) in mesh.tiles().iter().enumerate() {
            let material = tile.patch.surface.material as usize;
            for square in [[0.1, 0.2], [0.7, 0.2], [0.1, 0.8]] {
                let (point, normal) = tile.patch.place(square);
                (bits(point), bits(normal), material, tile.patch.surface.emitter).hash(&mut h);
            }
            for front in [true, false] {
                // What a material reflects is asked for on its first surfaces.
                let times = &mut asked[material][usize::from(front)];
                if let Some(number) = mesh.elements(i, front).next().filter(|_| *times < 8) {
                    *times += 1;
                    for x in workshop.reflectance(&mesh.element(number).1, number) {
                        x.to_bits().hash(&mut h);
                    }
                }
            }
        }
        for light in 0..scene.lights.len() {
            wavelengths.brightness(light).iter().for_each(|x| x.to_bits().hash(&mut h));
        }
        for lamp in &scene.lamps {
            for (i, from) in
                [Vec3A::new(0.1, 0.2, 0.3), Vec3A::new(-0.7, 0.4, -0.9), Vec3A::Z * 3.0].into_iter().enumerate()
            {
                for u in [[0.2, 0.3], [0.8, 0.1], [0.6, 0.9]] {
                    let Some(aim) = lamp.aim(from, u) else { continue };
                    let emission = (aim.emission.light, aim.emission.parts.map(f32::to_bits));
                    (i, bits(aim.direction), aim.pdf.to_bits(), emission).hash(&mut h);
                }
            }
        }
        Fingerprint(h.finish())
    }
}

fn check_sum(bytes: &[u8]) -> u64 {
    let mut h = DefaultHasher::new();
    bytes.hash(&mut h);
    h.finish()
}

/// Writes a solution.
pub fn write(path: &Path, fingerprint: Fingerprint, mesh: &Mesh, stored: &Stored, account: &Account) -> Result<()> {
    let mut bytes = Vec::new();
    let mut put = |word: u32| bytes.extend_from_slice(&word.to_le_bytes());
    put(mesh.tiles().len() as u32);
    for (i, tile) in mesh.tiles().iter().enumerate() {
        let awake = u32::from(mesh.is_awake(i, true)) + 2 * u32::from(mesh.is_awake(i, false));
        [tile.cells[0], tile.cells[1], awake].into_iter().for_each(&mut put);
    }
    put(stored.lights.len() as u32);
    stored.lights.iter().copied().for_each(&mut put);
    for x in [account.error.unwrap_or(f64::NAN), account.solved.residual, account.glossy] {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
    bytes.extend_from_slice(&(account.solved.steps as u32).to_le_bytes());
    stored.data.iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
    let mut out = Output::create(Some(path), true)?;
    let head = format!("{MAGIC}{:016x}\n", fingerprint.0);
    let write = |out: &mut Output| {
        out.write_all(head.as_bytes())?;
        out.write_all(&check_sum(&bytes).to_le_bytes())?;
        out.write_all(&bytes)
    };
    write(&mut out).map_err(|e| out.error(e))?;
    out.finish()
}

/// Reads the solution of a scene; `None` where the file is not there yet.
pub fn read(
    path: &Path,
    fingerprint: Fingerprint,
    scene: &Scene,
    lanes: usize,
) -> Result<Option<(Mesh, Stored, Account)>> {
    let all = match std::fs::read(path) {
        Ok(all) => all,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io(path.display().to_string(), e)),
    };
    let wrong = |what: &str| Error::Invalid(what.to_string()).in_file(path);
    let Some(rest) = all.strip_prefix(MAGIC.as_bytes()) else {
        return Err(wrong("is no radiosity solution; name a new file, or one that --solution has written"));
    };
    let Some((line, rest)) = rest.split_at_checked(17) else { return Err(wrong("the solution ends in its head")) };
    if line != format!("{:016x}\n", fingerprint.0).as_bytes() {
        return Err(wrong("the solution is of another scene or of other options; take those, or remove it"));
    }
    let damaged = || wrong("the solution is damaged: its check sum differs; remove it to solve again");
    let (sum, body) = rest.split_first_chunk::<8>().ok_or_else(damaged)?;
    if u64::from_le_bytes(*sum) != check_sum(body) {
        return Err(damaged());
    }
    parse(body, scene, lanes).map(Some).ok_or_else(damaged)
}

fn parse(mut body: &[u8], scene: &Scene, lanes: usize) -> Option<(Mesh, Stored, Account)> {
    fn take<const N: usize>(body: &mut &[u8]) -> Option<[u8; N]> {
        let (first, rest) = body.split_first_chunk::<N>()?;
        *body = rest;
        Some(*first)
    }
    let word = |body: &mut &[u8]| take::<4>(body).map(u32::from_le_bytes);
    let number = |body: &mut &[u8]| take::<8>(body).map(f64::from_le_bytes);
    let mut mesh = Mesh::new(&scene.geometry, |_| [1, 1]);
    if word(&mut body)? as usize != mesh.tiles().len() {
        return None;
    }
    for i in 0..mesh.tiles().len() {
        let [n, m, awake] = [word(&mut body)?, word(&mut body)?, word(&mut body)?];
        if n > 1 << 16 || m > 1 << 16 {
            return None;
        }
        mesh.divide(i, [n, m]);
        mesh.wake(i, true, awake & 1 != 0);
        mesh.wake(i, false, awake & 2 != 0);
    }
    mesh.number();
    let count = word(&mut body)? as usize;
    if count > scene.lights.len() {
        return None;
    }
    let lights = (0..count).map(|_| word(&mut body)).collect::<Option<Vec<u32>>>()?;
    if lights.iter().any(|l| *l as usize >= scene.lights.len()) {
        return None;
    }
    let [error, residual, glossy] = [number(&mut body)?, number(&mut body)?, number(&mut body)?];
    let steps = word(&mut body)? as usize;
    let values = 2 * mesh.len() * count * lanes;
    if body.len() != values.checked_mul(4)? {
        return None;
    }
    let data = body.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let sides = |i: &usize| mesh.is_awake(*i, true) || mesh.is_awake(*i, false);
    let account = Account {
        surfaces: (0..mesh.tiles().len()).filter(sides).count(),
        error: Some(error).filter(|e| !e.is_nan()),
        solved: Solved { residual, steps },
        glossy,
        from_file: true,
        ..Account::default()
    };
    Some((mesh, Stored { lights, lanes, data }, account))
}
