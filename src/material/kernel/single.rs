//! Kernels at one wavelength, of those that are not the same at all.

use glam::Vec3A;

use super::ggx_through::GgxThrough;
use super::order::Order;
use super::specular::Specular;
use super::{Kernel, Turn, Value};

/// A kernel at one wavelength.
#[derive(Clone, Copy, Debug)]
pub enum Single {
    /// Bent at a smooth boundary, its radiance as it was: the tint says what it is squeezed by.
    Bent(Specular),
    /// The same at a rough one.
    Rough(GgxThrough),
    /// An order of a grating.
    Order(Order),
}

impl Single {
    fn kernel(&self) -> &dyn Kernel {
        match self {
            Single::Bent(k) => k,
            Single::Rough(k) => k,
            Single::Order(k) => k,
        }
    }

    /// What the tint has already.
    fn squeezed(&self) -> f32 {
        match self {
            Single::Bent(Specular::Bent { eta }) => eta * eta,
            Single::Rough(GgxThrough { eta, .. }) => eta * eta,
            _ => 1.0,
        }
    }
}

impl Kernel for Single {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        let value = self.kernel().evaluate(out, inc);
        Value { f_cos: value.f_cos * self.squeezed(), ..value }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let turn = self.kernel().sample(out, u)?;
        Some(Turn { weight: turn.weight * self.squeezed(), ..turn })
    }

    fn transmits(&self) -> bool {
        self.kernel().transmits()
    }

    fn is_specular(&self) -> bool {
        self.kernel().is_specular()
    }
}
