//! The incoherent lobe of a rough surface by wave optics ([`Rough`]): how wide it is depends on the wavelength. Directions are drawn
//! from the mean of four wavelengths' lobes; what each wavelength makes of one is its tint, so that all go together.

use std::sync::Arc;

use glam::Vec3A;

use super::{Kernel, Turn, Value};
use crate::material::albedo::Albedo;
use crate::material::tint::{Scattering, cos_half};
use crate::optics::roughness::Rough;

/// Wavelengths whose lobes are drawn from, nm.
const DRAWN_NM: [f32; 4] = [410.0, 480.0, 560.0, 680.0];

/// Cosines of directions whose lobes are drawn from, half of the draws each: light that grazes on one way may be steep on the other.
fn drawn_cosines(cos_out: f32) -> [f32; 2] {
    [cos_out, 0.5 * (cos_out + 1.0)]
}

/// The lobe; its value is the density that it is drawn with.
///
/// At grazing angles the theory's lobe may have more than the mirror has lost. There it is divided by as much, the larger of both
/// directions', which keeps it reciprocal.
#[derive(Clone, Debug)]
pub struct Incoherent {
    /// The surface.
    pub rough: Rough,
    /// What it has over what the mirror has lost, at the wavelength that has the most of it.
    most: Arc<Albedo>,
}

impl Incoherent {
    /// Of a surface.
    pub fn new(rough: Rough) -> Incoherent {
        const POINTS: u32 = 512;
        const MARGIN: f32 = 1.02;
        let even = Incoherent { rough, most: Arc::new(Albedo::from_fn(|_| 1.0)) };
        let most = |cos: f32| {
            let cos = cos.max(1e-3);
            let out = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let share = |nm: f32| {
                let one = |i: u32| {
                    let u = [(i as f32 + 0.5) / POINTS as f32, (i.reverse_bits() >> 8) as f32 / (1 << 24) as f32];
                    let Some(turn) = even.sample(out, u) else { return 0.0 };
                    Scattering::new(&rough, [out.z, turn.inc.z, cos_half(out, turn.inc)]).at(nm)
                };
                let lost = 1.0 - rough.seen(cos, cos).coherent(cos, nm);
                let sum: f32 = (0..POINTS).map(one).sum();
                if lost > 1e-4 { sum / POINTS as f32 / lost } else { 1.0 }
            };
            let most = DRAWN_NM.map(share).into_iter().fold(1.0, f32::max);
            // What the points and the table leave open.
            if most > 1.0 { MARGIN * most } else { 1.0 }
        };
        Incoherent { rough, most: Arc::new(Albedo::from_fn(most)) }
    }

    fn limit(&self, cos_out: f32, cos_inc: f32) -> f32 {
        1.0 / self.most.at(cos_out).max(self.most.at(cos_inc))
    }
}

/// The density over directions with which [`Incoherent`] chooses `inc`, 1/sr, by the cosines of both ways and the square of what the
/// plane sees of their sum.
pub fn density(rough: &Rough, cos_out: f32, cos_inc: f32, across2: f32) -> f32 {
    let of = |nm: &f32| drawn_cosines(cos_out).iter().map(|cos| rough.density(*cos, across2, *nm)).sum::<f32>();
    // d^2 of the plane = cos inc d omega.
    DRAWN_NM.iter().map(of).sum::<f32>() / (2 * DRAWN_NM.len()) as f32 * cos_inc
}

fn across2(out: Vec3A, inc: Vec3A) -> f32 {
    (out.x + inc.x).powi(2) + (out.y + inc.y).powi(2)
}

impl Kernel for Incoherent {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        if inc.z <= 0.0 || out.z <= 0.0 {
            return Value::default();
        }
        let pdf = density(&self.rough, out.z, inc.z, across2(out, inc));
        Value { f_cos: pdf * self.limit(out.z, inc.z), pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let count = DRAWN_NM.len();
        let which = u[1] * (2 * count) as f32;
        let i = (which as usize).min(2 * count - 1);
        let (nm, cos) = (DRAWN_NM[i % count], drawn_cosines(out.z)[i / count]);
        let [x, y] = self.rough.draw(cos, nm, [u[0], which.fract()]);
        let (x, y) = (x - out.x, y - out.y);
        let cos2 = 1.0 - x * x - y * y;
        if cos2.is_nan() || cos2 <= 1e-12 {
            return None;
        }
        let inc = Vec3A::new(x, y, cos2.sqrt());
        let pdf = density(&self.rough, out.z, inc.z, across2(out, inc));
        let weight = self.limit(out.z, inc.z);
        (pdf > 0.0 && pdf.is_finite()).then_some(Turn { inc, weight, pdf })
    }
}
