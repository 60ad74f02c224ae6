//! Light through a rough boundary, bent at GGX microfacets [Walter 2007]:
//! f = |o.h| |i.h| / (|o.n| |i.n|) (1 - F) G D / (o.h + eta i.h)^2, h = -(out + eta inc) on the side of `out`, eta the index on the
//! side of `inc` over that of `out`. Radiance follows n^2.

use glam::Vec3A;

use super::bend::Index;
use super::complement::Complement;
use super::ggx::Ggx;
use super::lambert::cosine;
use super::{Kernel, Single, Turn, Value};
use crate::material::albedo::Albedo;
use crate::optics::fresnel;

/// A rough boundary of one index.
#[derive(Clone, Copy, Debug)]
pub struct GgxThrough {
    /// Width of the slopes' distribution, 0 < alpha <= 1.
    pub alpha: f32,
    /// Index on the side of `inc` over that on the side of `out`.
    pub eta: f32,
}

impl GgxThrough {
    fn facets(&self) -> Ggx {
        Ggx { alpha: self.alpha, eta: None }
    }

    /// Density of `inc` over that of its facet's normal, (1 - F), and cosines of both directions with it; `None` where no facet
    /// joins them.
    fn facet(&self, out: Vec3A, inc: Vec3A) -> Option<(Vec3A, f32, f32, f32)> {
        let h = (out + inc * self.eta).normalize_or_zero();
        let h = if h.z < 0.0 { -h } else { h };
        let (oh, ih) = (out.dot(h), inc.dot(h));
        if h.z <= 0.0 || oh <= 0.0 || ih >= 0.0 {
            return None;
        }
        let through = 1.0 - fresnel::dielectric(oh.min(1.0), self.eta).0;
        let root = oh + self.eta * ih;
        Some((h, oh, ih, through * self.eta * self.eta / (root * root)))
    }
}

impl Kernel for GgxThrough {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        if inc.z >= 0.0 || out.z <= 0.0 || (self.eta - 1.0).abs() < 1e-6 {
            return Value::default();
        }
        let Some((h, oh, ih, jacobian)) = self.facet(out, inc) else { return Value::default() };
        let ggx = self.facets();
        let d = ggx.facets(h.z);
        let (lo, li) = (ggx.lambda(out.z), ggx.lambda(-inc.z));
        let visible = d * oh / (out.z * (1.0 + lo));
        let through = 1.0 - fresnel::dielectric(oh.min(1.0), self.eta).0;
        let pdf = visible * jacobian / through.max(1e-12) * -ih;
        let f_cos = visible * jacobian * -ih / ((1.0 + li) * self.eta * self.eta);
        Value { f_cos, pdf: if through > 0.0 { pdf } else { 0.0 } }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let ggx = self.facets();
        let h = ggx.facet(out, u);
        let oh = out.dot(h).min(1.0);
        if oh <= 0.0 {
            return None;
        }
        let (sent, inside) = fresnel::dielectric(oh, self.eta);
        if sent >= 1.0 {
            return None;
        }
        let inc = (-out / self.eta + h * (oh / self.eta - inside)).normalize();
        if inc.z >= 0.0 {
            return None;
        }
        let weight = (1.0 - sent) / ((1.0 + ggx.lambda(-inc.z)) * self.eta * self.eta);
        let root = oh - self.eta * inside;
        let (lo, d) = (ggx.lambda(out.z), ggx.facets(h.z));
        let pdf = d * oh / (out.z * (1.0 + lo)) * self.eta * self.eta * inside / (root * root);
        // Without a difference of the indices nothing is bent, and a facet says nothing of the direction.
        if (self.eta - 1.0).abs() < 1e-6 {
            return Some(Turn { inc: -out, weight: 1.0, pdf: f32::INFINITY });
        }
        (pdf > 0.0 && pdf.is_finite()).then_some(Turn { inc, weight, pdf })
    }

    fn transmits(&self) -> bool {
        true
    }

    fn is_specular(&self) -> bool {
        (self.eta - 1.0).abs() < 1e-6
    }
}

/// A rough boundary whose index depends on the wavelength. What it squeezes of the radiance is in the tint.
#[derive(Clone, Debug)]
pub struct RoughBend {
    /// Width of the slopes' distribution.
    pub alpha: f32,
    /// Of the body.
    pub index: Index,
    /// Light leaves to the outside.
    pub front: bool,
}

impl RoughBend {
    fn middle(&self) -> Single {
        Single::Rough(GgxThrough { alpha: self.alpha, eta: self.index.middle(self.front) })
    }
}

impl Kernel for RoughBend {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        self.middle().evaluate(out, inc)
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        self.middle().sample(out, u)
    }

    fn transmits(&self) -> bool {
        true
    }

    fn spread(&self, out: Vec3A) -> f32 {
        // As of a facet that stands off by alpha: at least that much is seen of the boundary's own spread.
        self.index.spread((out.z - self.alpha).max(0.1), self.front)
    }

    fn at(&self, nm: f32) -> Option<Single> {
        Some(Single::Rough(GgxThrough { alpha: self.alpha, eta: self.index.eta(nm, self.front) }))
    }
}

/// The part of what one facet loses that comes through: f = k (1 - E(out)) (1 - E'(inc)) / pi, E and E' what either side gives
/// back in all [Kulla 2017].
#[derive(Clone, Debug)]
pub struct Rest {
    /// Of the side that light leaves to.
    pub out: Complement,
    /// Of the side that it comes from.
    pub inc: Complement,
    /// The factor, 1 over the mean that is lost there included.
    pub k: f32,
}

impl Rest {
    fn over_pi(&self, out: Vec3A, inc: Vec3A) -> f32 {
        self.k * (1.0 - self.out.albedo.at(out.z)) * (1.0 - self.inc.albedo.at(-inc.z))
    }
}

impl Kernel for Rest {
    fn evaluate(&self, out: Vec3A, inc: Vec3A) -> Value {
        let pdf = (-inc.z).max(0.0) * std::f32::consts::FRAC_1_PI;
        Value { f_cos: self.over_pi(out, inc) * pdf, pdf }
    }

    fn sample(&self, out: Vec3A, u: [f32; 2]) -> Option<Turn> {
        let up = cosine(u);
        let inc = Vec3A::new(up.x, up.y, -up.z.max(1e-7));
        Some(Turn { inc, weight: self.over_pi(out, inc), pdf: -inc.z * std::f32::consts::FRAC_1_PI })
    }

    fn transmits(&self) -> bool {
        true
    }
}

/// Both rests of a rough boundary, [front, back]: through, and the share of what is lost that is thrown back. Reciprocity asks
/// that `share through x mean lost x n^2` is the same from either side; it is as near to a smooth boundary's as both allow.
pub fn rests(lost: [&Complement; 2], index: f32) -> ([Rest; 2], [f32; 2]) {
    let squared = [1.0, index * index];
    let mean = [0, 1].map(|i| (1.0 - lost[i].albedo.mean()).max(1e-9));
    let open = [index, 1.0 / index].map(|eta| 1.0 - fresnel::diffuse(eta.into()) as f32);
    let c = (mean[0] * squared[0] * open[0]).min(mean[1] * squared[1] * open[1]);
    let share = [0, 1].map(|i| c / (mean[i] * squared[i]));
    // Seen from `i` light comes from the other side, of which its own share goes through.
    let rest = |i: usize| Rest { out: lost[i].clone(), inc: lost[1 - i].clone(), k: share[1 - i] / mean[i] };
    ([rest(0), rest(1)], share.map(|s| 1.0 - s))
}

/// What a rough boundary gives back of light that leaves to one side, and what it gives back and lets through, one reflection each.
pub fn shares(alpha: f32, eta: f32) -> (Albedo, Complement) {
    let (back, on) = (Ggx { alpha, eta: Some(eta) }, GgxThrough { alpha, eta });
    // By reciprocity: radiance from beyond is eta^2 times as much.
    let all = Albedo::of_all(&[(&back, 1.0), (&on, eta * eta)]);
    (Albedo::of(&back), Complement::new(all))
}
