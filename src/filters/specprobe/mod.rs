//! specprobe: one material or medium by itself, as a gonioreflectometer sees it.
//!
//! For each angle and wavelength a line: angle, wavelength, reflectance, transmittance, directional-hemispherical (by
//! reciprocity the share of light that falls in at that angle and goes back, or through). With `--pairs` each line of
//! standard input is two directions, theta and phi (degrees) of where light goes and of where it comes from, and the answer
//! is the scattering function in 1/sr at each wavelength; theta above 90 lies beyond the surface.
//!
//! With `--mueller` it is matrices, sixteen numbers by rows, of what is sent back as by a mirror and of what goes through (rough lobes
//! go no one way); with `--pairs` too, of the scattering function, a line a wavelength. Their frames have x along (direction that
//! light goes to) x normal, with pairs x (direction that it comes from), the same before and after; +U lies counter-clockwise from +Q and V > 0 is clockwise, as the receiver
//! sees it.

mod medium;

use std::io::{BufRead, Write};
use std::path::PathBuf;

use clap::{Args, ValueHint};
use glam::Vec3A;
use serde::{Deserialize, Serialize};

use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::material::Site;
use crate::material::probe::{Sample, at_angle};
use crate::options::{Numbers, lossy};
use crate::scene::load::{self, Materials};
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults, invalid, usage};

/// Options of `specprobe`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Specprobe {
    /// Scene with the material (TOML); only its [materials] are read
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required = true)]
    #[serde(serialize_with = "lossy")]
    pub scene: Option<PathBuf>,
    /// Name of the material
    #[arg(long, short, value_name = "NAME", default_value = "")]
    pub material: String,
    /// Name of a medium instead: its coefficients, and its phase function at the angles
    #[arg(long, value_name = "NAME", conflicts_with_all = ["material", "back", "pairs"], help_heading = "Media")]
    pub medium: Option<String>,
    /// A slab of it, so thick, in the scene's lengths, or inf: reflectance and transmittance
    #[arg(long, value_name = "LENGTH", requires = "medium", conflicts_with = "mueller", help_heading = "Media")]
    pub thickness: Option<f64>,
    /// Index of refraction of the slab's smooth surfaces, inside over outside
    #[arg(long, value_name = "N", default_value_t = 1.0, requires = "medium", help_heading = "Media")]
    pub index: f64,
    /// The dipole's light at these distances from where light goes in, in the scene's lengths
    #[arg(long, value_name = "LIST", requires = "medium", conflicts_with_all = ["thickness", "mueller"], help_heading = "Media")]
    pub radii: Option<Numbers>,
    /// Angles from the normal, degrees
    #[arg(long, value_name = "LIST", default_value = "0,10,20,30,40,50,60,70,80,85")]
    pub angles: Numbers,
    /// Wavelengths, nm
    #[arg(long, value_name = "LIST", default_value = "450,500,550,600,650")]
    pub wavelengths: Numbers,
    /// From behind
    #[arg(long)]
    pub back: bool,
    /// Read pairs of directions (theta phi theta phi, degrees; out, then in), write the scattering function
    #[arg(long)]
    pub pairs: bool,
    /// Write Mueller matrices, sixteen numbers by rows, in the frame of the plane of incidence
    #[arg(long)]
    pub mueller: bool,
}

clap_defaults!(Specprobe);

fn io(e: std::io::Error) -> Error {
    Error::io("standard output", e)
}

impl Specprobe {
    fn totals(&self, sample: &Sample, out: &mut dyn Write) -> Result<()> {
        writeln!(out, "# angle_deg\twavelength_nm\treflectance\ttransmittance").map_err(io)?;
        for angle in &self.angles.0 {
            let totals = sample.totals(at_angle(*angle), &self.wavelengths.0);
            for (nm, [r, t]) in self.wavelengths.0.iter().zip(totals) {
                writeln!(out, "{angle}\t{nm}\t{r:.6}\t{t:.6}").map_err(io)?;
            }
        }
        Ok(())
    }

    fn matrices(&self, sample: &Sample, out: &mut dyn Write) -> Result<()> {
        writeln!(out, "# angle_deg\twavelength_nm\tside\tm00 m01 ... m33").map_err(io)?;
        for angle in &self.angles.0 {
            for nm in &self.wavelengths.0 {
                for (side, matrix) in ["back", "through"].iter().zip(sample.mueller(at_angle(*angle), *nm)) {
                    writeln!(out, "{angle}\t{nm}\t{side}\t{}", words(&matrix)).map_err(io)?;
                }
            }
        }
        Ok(())
    }

    fn functions(&self, sample: &Sample, out: &mut dyn Write) -> Result<()> {
        for (i, line) in std::io::stdin().lock().lines().enumerate() {
            let line = line.map_err(|e| Error::io("standard input", e))?;
            let text = line.trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|w| w.parse().ok()).collect();
            let Some([a, b, c, d]) = numbers.as_deref() else { return wrong(i, text) };
            let (toward, from) = (direction(*a, *b), direction(*c, *d));
            if !(toward.is_finite() && from.is_finite()) || toward.z <= 0.0 {
                return invalid!(
                    "standard input: line {}: light must leave at a theta of 0 to below 90 degrees",
                    i + 1
                );
            }
            if self.mueller {
                for nm in &self.wavelengths.0 {
                    writeln!(out, "{}", words(&sample.scattering_mueller(toward, from, *nm))).map_err(io)?;
                }
                continue;
            }
            let values = sample.scattering(toward, from, &self.wavelengths.0);
            let words: Vec<String> = values.iter().map(|v| format!("{v:.6e}")).collect();
            writeln!(out, "{}", words.join("\t")).map_err(io)?;
        }
        Ok(())
    }
}

/// A matrix on a line, tabs between its numbers.
fn words(matrix: &[[f64; 4]; 4]) -> String {
    // + 0.0 turns -0 to 0.
    matrix.iter().flatten().map(|x| format!("{:.6}", (x * 1e6).round() / 1e6 + 0.0)).collect::<Vec<_>>().join("\t")
}

fn direction(theta_deg: f64, phi_deg: f64) -> Vec3A {
    let (s, c) = theta_deg.to_radians().sin_cos();
    let (y, x) = phi_deg.to_radians().sin_cos();
    Vec3A::new((s * x) as f32, (s * y) as f32, c as f32)
}

fn wrong<T>(line: usize, text: &str) -> Result<T> {
    let shown: String = printable(text.as_bytes()).chars().take(60).collect();
    invalid!("standard input: line {}: expected theta phi theta phi in degrees, got '{shown}'", line + 1)
}

impl Filter for Specprobe {
    const NAME: &'static str = "specprobe";
    const ABOUT: &'static str = "Measure one material, medium or slab: reflectance and transmittance at angles and wavelengths, scattering and phase function, Mueller matrices";
    const EXAMPLE: &'static str = "specprobe scenes/materials.toml --material gold --angles 0,45,80 --wavelengths 450,550,650\necho '30 0 30 180' | specprobe scenes/materials.toml --material satin --pairs\nspecprobe scenes/marble.toml --medium marble --thickness inf --index 1.5";
    const READS: bool = false;

    fn look_ahead(&self) -> Result<Option<usize>> {
        self.scene.as_deref().map(load::materials).transpose().map(|_| None)
    }

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let path = self.scene.clone().ok_or_else(|| Error::Usage("expected a scene file".into()))?;
        let right = |x: &f64| (0.0..90.0).contains(x);
        if self.medium.is_none() && !self.angles.0.iter().all(right) {
            return usage!("--angles: from 0 to below 90 degrees");
        }
        let Materials { materials, inks, srgb, media, unit_m, remarks } = load::materials(&path)?;
        run.notes.extend(&remarks);
        if let Some(name) = self.medium.clone() {
            let Some(medium) = media.into_iter().find(|m| m.name == name) else {
                return usage!("--medium '{}': the scene has no such medium", printable(name.as_bytes()));
            };
            return medium::measure(self, medium, inks, unit_m);
        }
        let Some((_, material)) = materials.iter().find(|m| m.0 == self.material).cloned() else {
            let names: Vec<&str> = materials.iter().map(|m| m.0.as_str()).collect();
            let name = printable(self.material.as_bytes());
            return usage!("--material '{name}': the scene has {}", names.join(", "));
        };
        let write = Box::new(move |out: &mut Output| {
            let site = Site { front: !self.back, ..Site::default() };
            let sample = Sample { material: &*material, inks: &inks, srgb: &srgb, site };
            match (self.pairs, self.mueller) {
                (true, _) => self.functions(&sample, out),
                (false, true) => self.matrices(&sample, out),
                (false, false) => self.totals(&sample, out),
            }
        });
        Ok(Product::Bytes { binary: false, write })
    }
}
