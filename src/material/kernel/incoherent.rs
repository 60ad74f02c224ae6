//! The incoherent lobe of a rough surface by wave optics ([`Rough`]): how wide it is depends on the wavelength. Directions are drawn
//! from the mean of four wavelengths' lobes; what each wavelength makes of one is its tint, so that all go together.

use glam::Vec3A;

use super::{Kernel, Turn, Value};
use crate::optics::roughness::Rough;

/// Wavelengths whose lobes are drawn from, nm.
const DRAWN_NM: [f32; 4] = [410.0, 480.0, 560.0, 680.0];

/// The lobe; its value is the density that it is drawn with.
#[derive(Clone, Copy, Debug)]
pub struct Incoherent(pub Rough);

/// The density over directions with which [`Incoherent`] chooses `inc`, 1/sr, by the cosines of both ways and the square of what the
/// plane sees of their sum.
pub fn density(rough: &Rough, cos_out: f32, cos_inc: f32, across2: f32) -> f32 {
    let sum: f32 = DRAWN_NM.iter().map(|nm| rough.density(cos_out, across2, *nm)).sum();
    // d^2 of the plane = cos inc d omega.
    sum / DRAWN_NM.len() as f32 * cos_inc
}

fn across2(out: Vec3A, inc: Vec3A) -> f32 {
    (out.x + inc.x).powi(2) + (out.y + inc.y).powi(2)
}

impl Kernel for Incoherent {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        if inc.z <= 0.0 || out.z <= 0.0 {
            return Value::default();
        }
        let pdf = density(&self.0, out.z, inc.z, across2(out, inc));
        Value { f_cos: pdf, pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let which = u[1] * DRAWN_NM.len() as f32;
        let nm = DRAWN_NM[(which as usize).min(DRAWN_NM.len() - 1)];
        let [x, y] = self.0.draw(out.z, nm, [u[0], which.fract()]);
        let (x, y) = (x - out.x, y - out.y);
        let cos2 = 1.0 - x * x - y * y;
        if !(cos2 > 1e-12) {
            return None;
        }
        let inc = Vec3A::new(x, y, cos2.sqrt());
        let pdf = density(&self.0, out.z, inc.z, across2(out, inc));
        (pdf > 0.0 && pdf.is_finite()).then_some(Turn { inc, weight: 1.0, pdf })
    }
}
