//! A solution as bytes, little endian: for each surface its cells along both sides (u32, u32) and which of its sides are awake
//! (u32, front 1, back 2), preceded by their number (u32); the lights (u32) preceded by their number; error, residual, share of
//! glossy area (f64, an error that was not asked for is NaN) and steps (u32); the rows (f32).

use crate::render::radiosity::mesh::Mesh;
use crate::render::radiosity::solve::Solved;
use crate::render::radiosity::{Account, Options, Show};
use crate::render::solution::Bytes;
use crate::render::stored::Stored;
use crate::scene::Scene;

/// What options a solution depends on.
pub fn options(options: &Options) -> String {
    let Options { divide, tolerance, rays, show, memory: _, solution: _, seed } = options;
    format!("{divide:?} {tolerance} {rays} {} {seed}", *show == Show::Mesh)
}

/// A solution's bytes.
pub fn bytes(mesh: &Mesh, stored: &Stored, account: &Account) -> Vec<u8> {
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
    bytes
}

/// And back; `None` where they make no sense.
pub fn parse(bytes: &mut Bytes, scene: &Scene, lanes: usize) -> Option<(Mesh, Stored, Account)> {
    let mut mesh = Mesh::new(&scene.geometry);
    if bytes.word()? as usize != mesh.tiles().len() {
        return None;
    }
    for i in 0..mesh.tiles().len() {
        let [n, m, awake] = [bytes.word()?, bytes.word()?, bytes.word()?];
        if n > 1 << 16 || m > 1 << 16 {
            return None;
        }
        mesh.divide(i, [n, m]);
        mesh.wake(i, true, awake & 1 != 0);
        mesh.wake(i, false, awake & 2 != 0);
    }
    mesh.number();
    let count = bytes.word()? as usize;
    let lights = bytes.words(count)?;
    // One more is that of fluorescent surfaces.
    let known = scene.lights.len() + usize::from(scene.fluoresces());
    if count > known || lights.iter().any(|l| *l as usize >= known) {
        return None;
    }
    let [error, residual, glossy] = [bytes.number()?, bytes.number()?, bytes.number()?];
    let steps = bytes.word()? as usize;
    let data = bytes.floats(2 * mesh.len() * count * lanes)?;
    let account = Account {
        surfaces: mesh.surfaces(),
        error: Some(error).filter(|e| !e.is_nan()),
        solved: Solved { residual, steps },
        glossy,
        from_file: true,
        ..Account::default()
    };
    Some((mesh, Stored { lights, lanes, data }, account))
}
