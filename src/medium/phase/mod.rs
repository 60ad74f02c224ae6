//! Phase functions: P / 4 pi of Eq. (2), the density per solid angle with which light that scatters goes on at an angle to its way.
//! One function, one file whose head is its manual page; a new one also gets its line in [`KINDS`].
//!
//! Angles are told by their versine, 1 - cos: what scatters by a thousandth of a degree has one that floats can hold.

pub mod henyey_greenstein;
pub mod isotropic;
pub mod rayleigh;
pub mod table;

use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec3A;

use crate::error::printable;
use crate::keys::Keys;
use crate::{Error, Result};

/// How light that scatters is spread.
pub trait Phase: Send + Sync + Debug {
    /// Density at a versine 0..2, 1/sr; its integral over the sphere is 1.
    fn value(&self, versine: f32) -> f32;

    /// The versine that a number in 0..1 draws, as often as [`Phase::value`] says.
    fn sample(&self, u: f32) -> f32;

    /// Mean cosine of the angle, the g of radiative transfer.
    fn mean_cosine(&self) -> f64;

    /// A direction that light goes on to by two numbers in 0..1, both unit vectors, and the versine between them.
    fn turned(&self, direction: Vec3A, u: [f32; 2]) -> (Vec3A, f32) {
        let versine = self.sample(u[0]);
        let (s, t) = direction.any_orthonormal_pair();
        let (b, a) = (u[1] * std::f32::consts::TAU).sin_cos();
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        ((direction * (1.0 - versine) + (s * a + t * b) * sin).normalize(), versine)
    }

    /// It is that of a dipole, and polarises as one does.
    fn is_rayleigh(&self) -> bool {
        false
    }
}

/// Reads one kind of phase function from its table.
pub type Read = fn(&mut Keys) -> Result<Arc<dyn Phase>>;

/// All kinds, by the word after `type`.
pub const KINDS: &[(&str, Read)] = &[
    ("isotropic", isotropic::read),
    ("henyey_greenstein", henyey_greenstein::read),
    ("rayleigh", rayleigh::read),
    ("table", table::read),
];

/// The key `phase`: a word for those that have no keys of their own, or a table with `type`; isotropic where it is not there.
pub fn read(keys: &mut Keys) -> Result<Arc<dyn Phase>> {
    if let Some(word) = keys.peek::<String>("phase") {
        let span = keys.get_spanned::<String>("phase")?.map_or(0..0, |w| w.1);
        return match word.as_str() {
            "isotropic" => Ok(Arc::new(isotropic::Isotropic)),
            "rayleigh" => Ok(Arc::new(rayleigh::Rayleigh)),
            _ => Err(keys.wrong_key("phase", span, "expected \"isotropic\", \"rayleigh\" or a table with its type")),
        };
    }
    let Some(mut table) = keys.table("phase")? else { return Ok(Arc::new(isotropic::Isotropic)) };
    let kind: String = table.need("type")?;
    let Some((_, read)) = KINDS.iter().find(|k| k.0 == kind) else {
        let known: Vec<&str> = KINDS.iter().map(|k| k.0).collect();
        let name = printable(kind.as_bytes());
        return Err(Error::Invalid(format!(
            "{}: no phase function '{name}'; there are {}",
            table.what,
            known.join(", ")
        )));
    };
    let phase = read(&mut table)?;
    table.finish()?;
    Ok(phase)
}
