//! Single directions: a mirror's, straight on, and bent at the boundary of a dielectric.

use glam::Vec3A;

use super::{Kernel, Turn, Value};

/// A kernel of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// Thrown back.
    Mirror,
    /// Through, as if there were nothing.
    Straight,
    /// Through the boundary of two media. Radiance is squeezed with the solid angle, L / n^2 is kept.
    Bent {
        /// Index on the side of `inc` over that on the side of `out`.
        eta: f32,
    },
}

impl Kernel for Specular {
    fn evaluate(&self, _: Vec3A, _: Vec3A) -> Value {
        Value::default()
    }

    fn sample(&self, out: Vec3A, _: [f32; 2]) -> Option<Turn> {
        let (inc, weight) = match self {
            Specular::Mirror => (Vec3A::new(-out.x, -out.y, out.z), 1.0),
            Specular::Straight => (-out, 1.0),
            Specular::Bent { eta } => {
                let (x, y) = (-out.x / eta, -out.y / eta);
                let cos2 = 1.0 - x * x - y * y;
                if cos2 <= 0.0 {
                    return None;
                }
                (Vec3A::new(x, y, -cos2.sqrt()), 1.0 / (eta * eta))
            }
        };
        Some(Turn { inc, weight, pdf: f32::INFINITY })
    }

    fn transmits(&self) -> bool {
        *self != Specular::Mirror
    }

    fn is_straight(&self) -> bool {
        *self == Specular::Straight
    }

    fn is_specular(&self) -> bool {
        true
    }
}
