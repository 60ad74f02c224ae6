//! Microfacets with the GGX distribution and Smith's height-correlated masking [Walter 2007, Heitz 2014]; directions from the
//! facets that can be seen [Heitz 2018]. One reflection only: what is reflected again is [`super::complement`]'s.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3A;

use super::{Kernel, Turn, Value};
use crate::optics::fresnel;

/// A rough reflecting surface.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// Width of the slopes' distribution, 0 < alpha <= 1.
    pub alpha: f32,
    /// Index of a dielectric, whose Fresnel reflectance is part of the kernel; without, facets are perfect mirrors.
    pub eta: Option<f32>,
}

impl Ggx {
    /// Distribution of facet normals, 1/sr: integral of D cos = 1.
    pub(super) fn facets(&self, cos: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        // cos^2 (a2 - 1) + 1 written so that it keeps its digits for small alpha near the normal.
        let t = a2 * cos * cos + (1.0 - cos * cos).max(0.0);
        a2 * FRAC_1_PI / (t * t)
    }

    /// Smith's Lambda.
    pub(super) fn lambda(&self, cos: f32) -> f32 {
        let tan2 = (1.0 - cos * cos).max(0.0) / (cos * cos);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    fn fresnel(&self, cos_half: f32) -> f32 {
        self.eta.map_or(1.0, |eta| fresnel::dielectric(cos_half, eta).0)
    }

    /// The normal of a visible facet (Heitz 2018, its names).
    pub(super) fn facet(&self, out: Vec3A, u: [f32; 2]) -> Vec3A {
        let vh = Vec3A::new(self.alpha * out.x, self.alpha * out.y, out.z).normalize();
        let across = vh.x * vh.x + vh.y * vh.y;
        let t1 = if across > 0.0 { Vec3A::new(-vh.y, vh.x, 0.0) / across.sqrt() } else { Vec3A::X };
        let t2 = vh.cross(t1);
        let r = u[0].sqrt();
        let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
        let (p1, s) = (r * cos, 0.5 * (1.0 + vh.z));
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * (r * sin);
        let nh = t1 * p1 + t2 * p2 + vh * (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        Vec3A::new(self.alpha * nh.x, self.alpha * nh.y, nh.z.max(1e-7)).normalize()
    }
}

impl Kernel for Ggx {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        let half = out + inc;
        if inc.z <= 0.0 || out.z <= 0.0 || half.length_squared() == 0.0 {
            return Value::default();
        }
        let half = half.normalize();
        let d = self.facets(half.z);
        let (lo, li) = (self.lambda(out.z), self.lambda(inc.z));
        let cos_half = out.dot(half).clamp(0.0, 1.0);
        let f_cos = self.fresnel(cos_half) * d / (4.0 * out.z * (1.0 + lo + li));
        Value { f_cos, pdf: d / (4.0 * out.z * (1.0 + lo)) }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let half = self.facet(out, u);
        let cos_half = out.dot(half).min(1.0);
        let inc = half * (2.0 * cos_half) - out;
        if cos_half <= 0.0 || inc.z <= 0.0 {
            return None;
        }
        let inc = inc.normalize();
        let (lo, li) = (self.lambda(out.z), self.lambda(inc.z));
        let weight = self.fresnel(cos_half) * (1.0 + lo) / (1.0 + lo + li);
        let pdf = self.facets(half.z) / (4.0 * out.z * (1.0 + lo));
        (pdf > 0.0 && pdf.is_finite()).then_some(Turn { inc, weight, pdf })
    }
}
