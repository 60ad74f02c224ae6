//! An order of a reflection grating, at one wavelength; the first tangent lies across the rulings.

use glam::Vec3A;

use super::{Kernel, Single, Turn, Value};

/// Light that comes from where order `m` of what leaves along `out` would go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Number of the order; 0 is the mirror's.
    pub m: i32,
    /// Period, nm.
    pub pitch_nm: f32,
    /// Wavelength, nm.
    pub nm: f32,
}

impl Order {
    /// Where it comes from; `None` where it is evanescent.
    ///
    /// ```
    /// use luxpipe::material::kernel::order::Order;
    /// let order = Order { m: 1, pitch_nm: 1600.0, nm: 550.0 };
    /// let inc = order.from(glam::Vec3A::new(0.5, 0.0, 0.75f32.sqrt())).unwrap();
    /// assert!((inc.x.asin().to_degrees() + 8.9893).abs() < 1e-3);
    /// ```
    pub fn from(&self, out: Vec3A) -> Option<Vec3A> {
        let (x, y) = (self.m as f32 * self.nm / self.pitch_nm - out.x, -out.y);
        let cos2 = 1.0 - x * x - y * y;
        // An order that grazes carries nothing.
        (cos2 > 1e-10).then(|| Vec3A::new(x, y, cos2.sqrt()))
    }
}

impl Kernel for Order {
    fn evaluate(&self, _: Vec3A, _: Vec3A) -> Value {
        Value::default()
    }

    fn sample(&self, out: Vec3A, _: [f32; 2]) -> Option<Turn> {
        Some(Turn { inc: self.from(out)?, weight: 1.0, pdf: f32::INFINITY })
    }

    fn is_specular(&self) -> bool {
        true
    }

    fn spread(&self, _: Vec3A) -> f32 {
        if self.m == 0 { 0.0 } else { 1.0 }
    }

    fn at(&self, nm: f32) -> Option<Single> {
        (self.m != 0).then_some(Single::Order(Order { nm, ..*self }))
    }
}
