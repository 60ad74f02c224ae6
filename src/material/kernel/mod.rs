//! Kernels: how directions go, the same for every wavelength unless they say otherwise. One kernel, one file.

pub mod bend;
pub mod complement;
pub mod entering;
pub mod ggx;
pub mod ggx_through;
pub mod incoherent;
pub mod lambert;
pub mod lobe;
pub mod order;
pub mod single;
pub mod specular;
pub mod ward;

use glam::Vec3A;

pub use single::Single;

/// A kernel's value for a pair of directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Value {
    /// f |cos inc|, 1/sr.
    pub f_cos: f32,
    /// Density with which [`Kernel::sample`] chooses `inc`, 1/sr.
    pub pdf: f32,
}

/// A direction chosen by a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Where light comes from, unit.
    pub inc: Vec3A,
    /// f |cos inc| / density.
    pub weight: f32,
    /// Density, 1/sr; infinite where one direction is the only one, as for a mirror.
    pub pdf: f32,
}

/// A scalar scattering function in the frame of [`crate::material`].
pub trait Kernel: Send + Sync {
    /// Value and density; both 0 where a kernel sends light along single directions.
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value;

    /// Chooses `inc` with two numbers in 0..1; `None` where the choice meets nothing.
    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn>;

    /// Light comes through the surface from the other side.
    fn transmits(&self) -> bool {
        false
    }

    /// Lets light go on as if there were nothing, so that lamps can be seen through it.
    fn is_straight(&self) -> bool {
        false
    }

    /// Shows the same of its light from everywhere: a lobe of the cosine.
    fn is_matt(&self) -> bool {
        false
    }

    /// Sends light along single directions only: nothing to aim at a lamp for.
    fn is_specular(&self) -> bool {
        false
    }

    /// About the angle, rad, by which it sends the ends of the visible spectrum apart; 0 where all go together.
    fn spread(&self, _out: Vec3A) -> f32 {
        0.0
    }

    /// What it is at one wavelength, where it is not the same at all.
    fn at(&self, _nm: f32) -> Option<Single> {
        None
    }
}

/// A point of the unit disk from two numbers in 0..1, areas kept, squares to rings (Shirley and Chiu 1997).
pub fn disk(u: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    // Within an eighth of a turn a few terms of the series leave an error of 4e-7.
    let (r, other) = (a.abs().max(b.abs()), a.abs().min(b.abs()));
    let phi = std::f32::consts::FRAC_PI_4 * (other / r.max(f32::MIN_POSITIVE));
    let p2 = phi * phi;
    let sin = phi * (1.0 + p2 * (-1.0 / 6.0 + p2 * (1.0 / 120.0 + p2 * (-1.0 / 5040.0))));
    let cos = 1.0 + p2 * (-0.5 + p2 * (1.0 / 24.0 + p2 * (-1.0 / 720.0 + p2 * (1.0 / 40320.0))));
    let (long, short) = (r * cos, r * sin);
    let flat = a.abs() > b.abs();
    [if flat { long } else { short }.copysign(a), if flat { short } else { long }.copysign(b)]
}
