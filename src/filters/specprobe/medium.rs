//! Media by themselves: coefficients and phase function; slabs and half spaces by adding and doubling ([`slab`]), which is exact but
//! for its quadrature, with the dipole's light ([`Dipole`]) beside it where both have something to say.

use std::io::Write;

use crate::filter::Product;
use crate::filters::specprobe::{Specprobe, io, words};
use crate::material::Ink;
use crate::medium::Medium;
use crate::optics::dipole::Dipole;
use crate::optics::polarization::Response;
use crate::optics::slab::{self, Slab};
use crate::stream::output::Output;
use crate::{Result, usage};

/// What is asked for of a medium, as text.
pub fn measure(options: Specprobe, medium: Medium, inks: Vec<Ink>, unit_m: f64) -> Result<Product> {
    let slab = options.thickness.is_some();
    let most = if slab { 90.0 } else { 180.000_001 };
    if !options.angles.0.iter().all(|a| (0.0..most).contains(a)) {
        return usage!("--angles: from 0 to {} degrees", if slab { "below 90" } else { "180" });
    }
    if options.thickness.is_some_and(|t| t.is_nan() || t < 0.0) || !(0.25..=4.0).contains(&options.index) {
        return usage!("--thickness must be 0 or more, --index 0.25 to 4");
    }
    let write = Box::new(move |out: &mut Output| match (options.thickness, &options.radii) {
        (Some(thickness), _) => slabs(&options, &medium, &inks, thickness * unit_m, out),
        (None, Some(radii)) => radial(&options, &medium, &inks, &radii.0, unit_m, out),
        (None, None) => phase(&options, &medium, &inks, out),
    });
    Ok(Product::Bytes { binary: false, write })
}

/// Reflectance and transmittance of a slab, a line for each angle and wavelength, then for diffuse light.
fn slabs(o: &Specprobe, medium: &Medium, inks: &[Ink], thickness_m: f64, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "# angle_deg\twavelength_nm\treflectance\ttransmittance\tof_it_specular\tdipole").map_err(io)?;
    let cosines: Vec<f64> = o.angles.0.iter().map(|deg| deg.to_radians().cos()).collect();
    let phase = |cos: f64| 4.0 * std::f64::consts::PI * f64::from(medium.phase.value((1.0 - cos) as f32));
    let [absorption, scattering] = medium.coefficients(inks);
    let g = medium.phase.mean_cosine();
    let mut lines = Vec::new();
    for nm in &o.wavelengths.0 {
        let (a, s) = (absorption.at(*nm), scattering.at(*nm));
        let albedo = if a + s > 0.0 { s / (a + s) } else { 0.0 };
        let depth = if a + s > 0.0 { (a + s) * thickness_m } else { 0.0 };
        let (beams, diffuse) = slab::measure(&Slab { optical_depth: depth, albedo, eta: o.index }, &phase, &cosines);
        let angles = o.angles.0.iter().map(f64::to_string).chain(["diffuse".to_string()]);
        // Of what has gone in; for the dipole a body has no other side.
        let dipole = Dipole::new(s * (1.0 - g), a, o.index.max(1.0)).total();
        for (i, (angle, shares)) in angles.zip(beams.into_iter().chain([diffuse])).enumerate() {
            let slab::Shares { reflectance, transmittance, specular } = shares;
            let by_dipole = match thickness_m.is_infinite() {
                true => format!("{:.6}", specular + (1.0 - specular) * dipole),
                false => "-".to_string(),
            };
            let line = format!("{angle}\t{nm}\t{reflectance:.6}\t{transmittance:.6}\t{specular:.6}\t{by_dipole}");
            lines.push((i, line));
        }
    }
    lines.sort_by_key(|l| l.0);
    lines.iter().try_for_each(|l| writeln!(out, "{}", l.1)).map_err(io)
}

/// The dipole's profile.
fn radial(o: &Specprobe, medium: &Medium, inks: &[Ink], radii: &[f64], unit_m: f64, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "# radius\twavelength_nm\tdipole_per_area\tshare_within\tof_all").map_err(io)?;
    let [scattering, absorption] = medium.reduced(inks);
    for r in radii {
        for nm in &o.wavelengths.0 {
            let dipole = Dipole::new(scattering.at(*nm) * unit_m, absorption.at(*nm) * unit_m, o.index.max(1.0));
            let (density, within) = (dipole.radial(*r), dipole.within(*r));
            writeln!(out, "{r}\t{nm}\t{density:.7e}\t{within:.6}\t{:.6}", dipole.total()).map_err(io)?;
        }
    }
    Ok(())
}

/// Coefficients, and the phase function at the angles.
fn phase(o: &Specprobe, medium: &Medium, inks: &[Ink], out: &mut dyn Write) -> Result<()> {
    let [absorption, scattering] = medium.coefficients(inks);
    writeln!(out, "# wavelength_nm\tabsorption_per_m\tscattering_per_m\talbedo\tmean_cosine").map_err(io)?;
    for nm in &o.wavelengths.0 {
        let (a, s) = (absorption.at(*nm), scattering.at(*nm));
        let albedo = if a + s > 0.0 { s / (a + s) } else { 0.0 };
        writeln!(out, "{nm}\t{a:.6e}\t{s:.6e}\t{albedo:.6}\t{:.6}", medium.phase.mean_cosine()).map_err(io)?;
    }
    let head = if o.mueller { "m00 m01 ... m33, 1/sr" } else { "phase_per_sr\ttimes_4pi" };
    writeln!(out, "# angle_deg\t{head}").map_err(io)?;
    for deg in &o.angles.0 {
        let half = (0.5 * deg.to_radians()).sin();
        let value = f64::from(medium.phase.value((2.0 * half * half) as f32));
        if o.mueller {
            let cos = 1.0 - 2.0 * half * half;
            let dipole = Response { s: 1.0, p: cos * cos, cross: cos.into() };
            let mut matrix = dipole.scaled(value / dipole.mean()).mueller();
            if !medium.phase.is_rayleigh() {
                matrix = [[0.0; 4]; 4];
                matrix[0][0] = value;
            }
            writeln!(out, "{deg}\t{}", words(&matrix)).map_err(io)?;
        } else {
            writeln!(out, "{deg}\t{value:.7e}\t{:.7}", 4.0 * std::f64::consts::PI * value).map_err(io)?;
        }
    }
    Ok(())
}
