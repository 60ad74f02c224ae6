//! The meshes of scenes/mesh.toml: a height field and spheres with bumps, from the numbers of scenes/mesh/*.csv.

use std::f64::consts::PI;
use std::fs::{self, File};
use std::io::{BufWriter, Error, Result, Write};
use std::path::Path;

/// Cells of the ground along x and along z.
const CELLS: usize = 256;
/// Half of its side.
const HALF: f64 = 5.0;
/// Meridians and rings of a sphere.
const AROUND: usize = 128;
const RINGS: usize = 64;

/// Vertices and the triangles between them.
pub struct Mesh {
    /// File name without suffix.
    pub name: String,
    /// Positions, computed in double precision and rounded.
    pub vertices: Vec<[f32; 3]>,
    /// Three indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// The rows of a table: its names, and its numbers.
fn table(path: &Path, named: bool) -> Result<Vec<(String, Vec<f64>)>> {
    let wrong = |line: &str| Error::other(format!("{}: not a row of numbers: {line}", path.display()));
    let text = fs::read_to_string(path)?;
    let mut rows = Vec::new();
    for line in text.lines().filter(|l| !l.starts_with('#')).skip(1) {
        let mut fields = line.split(',');
        let name = if named { fields.next().unwrap_or_default().to_string() } else { String::new() };
        let numbers: Vec<f64> =
            fields.map(str::parse).collect::<std::result::Result<_, _>>().map_err(|_| wrong(line))?;
        if numbers.len() != 4 {
            return Err(wrong(line));
        }
        rows.push((name, numbers));
    }
    Ok(rows)
}

fn ground(waves: &[(String, Vec<f64>)]) -> Mesh {
    let side = CELLS + 1;
    let at = |i: usize| -HALF + 2.0 * HALF * i as f64 / CELLS as f64;
    let height = |x: f64, z: f64| waves.iter().map(|(_, w)| w[0] * (w[1] * x + w[2] * z + w[3]).sin()).sum::<f64>();
    let vertex = |k: usize| {
        let (x, z) = (at(k % side), at(k / side));
        [x, height(x, z), z].map(|c| c as f32)
    };
    let mut triangles = Vec::new();
    for j in 0..CELLS {
        for i in 0..CELLS {
            let v = |di: usize, dj: usize| (i + di + side * (j + dj)) as u32;
            triangles.push([v(0, 0), v(0, 1), v(1, 1)]);
            triangles.push([v(0, 0), v(1, 1), v(1, 0)]);
        }
    }
    Mesh { name: "ground".into(), vertices: (0..side * side).map(vertex).collect(), triangles }
}

fn sphere(name: &str, sphere: &[f64], bumps: &[&Vec<f64>]) -> Mesh {
    let vertex = |k: usize| {
        let (theta, phi) = (PI * (k / AROUND) as f64 / RINGS as f64, 2.0 * PI * (k % AROUND) as f64 / AROUND as f64);
        let bump = |b: &&Vec<f64>| b[0] * (b[1] * phi + b[3]).sin() * theta.sin() * (b[2] * theta).sin();
        let r = sphere[3] * (1.0 + bumps.iter().map(bump).sum::<f64>());
        let unit = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
        [0, 1, 2].map(|c| (sphere[c] + r * unit[c]) as f32)
    };
    let mut triangles = Vec::new();
    for j in 0..RINGS {
        for i in 0..AROUND {
            let v = |di: usize, dj: usize| ((i + di) % AROUND + AROUND * (j + dj)) as u32;
            let (a, b, c, d) = (v(0, 0), v(1, 0), v(1, 1), v(0, 1));
            if j > 0 {
                triangles.push([a, b, c]);
            }
            if j < RINGS - 1 {
                triangles.push([a, c, d]);
            }
        }
    }
    Mesh { name: name.into(), vertices: (0..AROUND * (RINGS + 1)).map(vertex).collect(), triangles }
}

/// All of them, from the tables of `folder`.
pub fn meshes(folder: &Path) -> Result<Vec<Mesh>> {
    let bumps = table(&folder.join("bumps.csv"), true)?;
    let mut all = vec![ground(&table(&folder.join("waves.csv"), false)?)];
    for (name, numbers) in table(&folder.join("spheres.csv"), true)? {
        let own: Vec<&Vec<f64>> = bumps.iter().filter(|b| b.0 == name).map(|b| &b.1).collect();
        all.push(sphere(&name, &numbers, &own));
    }
    Ok(all)
}

/// Writes them as binary PLY into `folder`, which is made.
pub fn write(meshes: &[Mesh], folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    for mesh in meshes {
        let mut out = BufWriter::new(File::create(folder.join(&mesh.name).with_extension("ply"))?);
        write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.vertices.len())?;
        write!(out, "property float x\nproperty float y\nproperty float z\nelement face {}\n", mesh.triangles.len())?;
        out.write_all(b"property list uchar int vertex_indices\nend_header\n")?;
        for v in mesh.vertices.iter().flatten() {
            out.write_all(&v.to_le_bytes())?;
        }
        for t in &mesh.triangles {
            out.write_all(&[3])?;
            for i in t {
                out.write_all(&i.to_le_bytes())?;
            }
        }
        out.flush()?;
    }
    Ok(())
}
