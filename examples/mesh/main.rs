//! Writes the meshes that scenes/mesh.toml reads: `make mesh`.

mod shapes;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let meshes = shapes::meshes(Path::new("scenes/mesh"))?;
    shapes::write(&meshes, Path::new("out/mesh"))?;
    let triangles: usize = meshes.iter().map(|m| m.triangles.len()).sum();
    println!("out/mesh: {} files, {triangles} triangles", meshes.len());
    Ok(())
}
