//! What a lobe does to the polarization of light, beside what it does to its amount: a matrix over its first number, by the plane
//! of incidence or by an axis of the surface. Lobes without one give off unpolarised light.

use num_complex::Complex64;

use crate::material::Ink;
use crate::optics::film::{self, Shares};
use crate::optics::fresnel;
use crate::optics::polarization::{Diattenuation, Response, sheet};
use crate::spectral::Spectrum;

/// By what light is told apart. Cosines are those on the side that light leaves to, between the (micro-)normal and the way out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Polar {
    /// A clear boundary, index beyond over index here.
    Boundary {
        /// The same at each wavelength.
        eta: f32,
        /// Light that comes through.
        through: bool,
    },
    /// A boundary by the number of its index n + ik, of what is behind the front over what is before it.
    Index {
        /// Number of the index.
        index: u32,
        /// Index beyond over index here, of about the middle of the spectrum; of a metal anything.
        eta: f32,
        /// Light leaves to the front.
        front: bool,
        /// Light that comes through.
        through: bool,
    },
    /// Parallel panes.
    Panes {
        /// Number of the optical depth of one.
        depth: u32,
        /// Index of refraction.
        index: f32,
        /// How many.
        panes: u32,
        /// Light that comes through.
        through: bool,
    },
    /// A stack of films by its number.
    Film {
        /// Number of the stack.
        film: u32,
        /// Light that comes through.
        through: bool,
    },
    /// A sheet with its axis along the first tangent of the surface: transmittances along and across it, and by how many nm the
    /// wave across it falls behind.
    Sheet {
        /// Along the axis.
        along: f32,
        /// Across it.
        across: f32,
        /// Path difference, nm.
        retardance_nm: f32,
    },
    /// Light scattered by particles much smaller than the wave; the cosine is that of the angle by which it turns.
    Rayleigh,
}

/// Shares of a boundary between complex indices.
pub fn boundary(cos: f64, here: Complex64, beyond: Complex64) -> Shares {
    film::shares(cos, 1.0, &[], beyond / here)
}

impl Polar {
    /// Its axis is the surface's, not that of the plane of incidence.
    pub fn has_axis(&self) -> bool {
        matches!(self, Polar::Sheet { .. })
    }

    /// Index beyond over index here, where it bends light.
    pub fn eta(&self) -> Option<f32> {
        match *self {
            Polar::Boundary { eta, .. } | Polar::Index { eta, .. } => Some(eta),
            _ => None,
        }
    }

    /// The same matrix at each wavelength, if it is.
    pub fn constant(&self, cos: f32, inks: &[Ink]) -> Option<Diattenuation> {
        match *self {
            Polar::Boundary { eta, through: true } => Some(fresnel::diattenuation_through(cos, eta)),
            Polar::Boundary { eta, through: false } => Some(fresnel::diattenuation(cos, eta, 0.0)),
            Polar::Sheet { along, across, retardance_nm: 0.0 } => {
                Some(sheet(along.into(), across.into(), 0.0).relative())
            }
            Polar::Rayleigh => Some(rayleigh(cos.into()).relative()),
            Polar::Panes { depth, .. } => match &inks[depth as usize] {
                Ink::Depth(Spectrum::Constant(_)) => Some(self.at(555.0, cos, inks).relative()),
                _ => None,
            },
            _ => None,
        }
    }

    /// The response at a wavelength, lossless where only the relative one matters.
    pub fn at(&self, nm: f64, cos: f32, inks: &[Ink]) -> Response {
        let cos64 = f64::from(cos);
        match *self {
            Polar::Boundary { eta, through } => side(&boundary(cos64, 1.0.into(), f64::from(eta).into()), through),
            Polar::Index { index, front, through, .. } => match &inks[index as usize] {
                Ink::Index { n, k } => {
                    let n = Complex64::new(n.at(nm), k.at(nm));
                    let one = Complex64::from(1.0);
                    let (here, beyond) = if front { (one, n) } else { (n, one) };
                    side(&boundary(cos64, here, beyond), through)
                }
                _ => Response::default(),
            },
            Polar::Panes { depth, index, panes, through } => match &inks[depth as usize] {
                Ink::Depth(depth) => fresnel::panes(cos64, index.into(), depth.at(nm), panes, through),
                _ => Response::default(),
            },
            Polar::Rayleigh => rayleigh(cos64),
            Polar::Film { film, through } => match &inks[film as usize] {
                Ink::Film(stack) => side(&stack.at(cos64, nm), through),
                _ => Response::default(),
            },
            Polar::Sheet { along, across, retardance_nm } => {
                sheet(along.into(), across.into(), std::f64::consts::TAU * f64::from(retardance_nm) / nm)
            }
        }
    }
}

/// A dipole's light across the plane of scattering, and in it.
fn rayleigh(cos: f64) -> Response {
    Response { s: 1.0, p: cos * cos, cross: cos.into() }
}

fn side(shares: &Shares, through: bool) -> Response {
    if through { shares.through } else { shares.back }
}
