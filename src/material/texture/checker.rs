//! A checker: squares of two values in turn over texture coordinates, or cubes over places.

use glam::DVec3;
use serde::Deserialize;

use crate::Result;
use crate::keys::Keys;

/// Cubes begin this share of a cube before zero: a floor at z = 0, or at any whole number of cubes, lies within one layer of
/// them and not where rounding decides.
const SHIFT: f64 = 1e-4;

/// What a checker is laid over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Space {
    /// Texture coordinates.
    #[default]
    Uv,
    /// Places in the scene.
    Place,
}

/// Two values in turn; the first has the square or cube from zero on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// Linear sRGB, 0..1.
    pub values: [[f32; 3]; 2],
    /// Edge of a square in texture coordinates, or of a cube in metres.
    pub size: f64,
    /// Which of the two.
    pub space: Space,
}

/// A value as written.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Value {
    Grey(f64),
    Rgb([f64; 3]),
}

impl Checker {
    /// Takes `values`, `size` and `space`.
    pub(super) fn read(k: &mut Keys, metres: f64) -> Result<Checker> {
        let Some((values, span)) = k.get_spanned::<[Value; 2]>("values")? else {
            return Err(k.wrong("key 'values' is missing"));
        };
        let values = values.map(|v| match v {
            Value::Grey(x) => [x; 3],
            Value::Rgb(rgb) => rgb,
        });
        if let Some(x) = values.iter().flatten().find(|x| !(0.0..=1.0).contains(*x)) {
            return Err(k.wrong_key("values", span, &format!("{x} must lie in 0 to 1")));
        }
        let positive = |x: f64| x > 0.0 && x < 1e9;
        let size = k.number("size", "must be above 0", positive)?.ok_or_else(|| k.wrong("key 'size' is missing"))?;
        let space = k.get::<Space>("space")?.unwrap_or_default();
        let size = if space == Space::Place { size * metres } else { size };
        Ok(Checker { values: values.map(|v| v.map(|x| x as f32)), size, space })
    }

    /// The value at texture coordinates or a place in metres.
    pub fn at(&self, [u, v]: [f64; 2], place: DVec3) -> [f32; 3] {
        // Odd or even, of any size: whole numbers of floats stay whole.
        let odd = |x: f64| (x / self.size).floor().rem_euclid(2.0);
        let sum = match self.space {
            Space::Uv => odd(u) + odd(v),
            Space::Place => place.to_array().iter().map(|x| odd(x + SHIFT * self.size)).sum(),
        };
        self.values[usize::from(sum % 2.0 == 1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_alternate_through_zero() {
        let values = [[0.1; 3], [0.9; 3]];
        let checker = Checker { values, size: 0.25, space: Space::Uv };
        for i in -9..9i32 {
            for j in -9..9i32 {
                let uv = [f64::from(i), f64::from(j)].map(|x| (x + 0.5) * 0.25);
                assert_eq!(checker.at(uv, DVec3::ZERO), values[(i + j).rem_euclid(2) as usize]);
            }
        }
    }

    /// A floor on the grid, its height rounded either way, is squares and no noise.
    #[test]
    fn planes_on_the_grid_are_not_noise() {
        let checker = Checker { values: [[0.0; 3], [1.0; 3]], size: 0.3, space: Space::Place };
        for height in [-3.0, 0.0, 1.0, 2.0, 7.0] {
            let at = |off: f64| checker.at([0.0; 2], DVec3::new(0.1, 0.4, height * 0.3 + off));
            assert_eq!(at(-1e-7), at(1e-7), "height {height}");
            assert_ne!(at(-1e-7), at(0.3));
        }
    }
}
