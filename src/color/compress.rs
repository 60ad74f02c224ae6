//! Techniques A and B of the paper: bringing saturations into a gamut along lines of constant hue.
//!
//! A colour's *excess* is its distance from the neutral over that of the gamut's edge in the same direction: 1 on the edge.
//! **A** (shrink) divides all saturations by the largest excess there is. **B** (compress) leaves excesses up to the knee
//! alone and bends the rest into what is left; with the knee at 1 it is clipping. Luminance stays as it is.
//!
//! Hue is constant along straight lines in u'v' or in Oklab. The two part most for saturated blues, which by Oklab's measure
//! drift toward purple as they pale along u'v'; docs/gamut.md holds both against Munsell's blues.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::difference::{OKLAB_M1, OKLAB_M2, uv, uv_to_xyz};
use super::{Mat3, Primaries, Xy};
use crate::spectral::{Observer, Spectrum};
use crate::{Error, Result};

/// Where lines of constant hue are straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Hue {
    /// CIE 1976 u'v'
    Uv,
    /// Oklab
    Oklab,
}

/// How saturations change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// A: all alike.
    Shrink,
    /// B: those over the knee, 0..1.
    Compress(f64),
}

/// Steps of the search for Oklab's edge: 2^-20 of the colour's distance from grey.
const BISECTIONS: u32 = 20;

/// Brings colours toward the neutral.
#[derive(Clone, Debug)]
pub struct Compressor {
    hue: Hue,
    curve: Curve,
    /// The largest excess that has to fit.
    pub reach: f64,
    white_uv: [f64; 2],
    /// For each edge of the triangle: inward normal over the distance of the white, so that n . (uv - white) = -1 on it.
    edges: [[f64; 2]; 3],
    to_rgb: Mat3,
    /// White of D65 over the gamut's: Oklab's neutral is D65.
    to_d65: [f64; 3],
    lms_to_xyz: Mat3,
    lab_to_lms: Mat3,
}

impl Compressor {
    /// For the gamut of these primaries, whose white must lie inside their triangle.
    pub fn new(primaries: Primaries, hue: Hue, curve: Curve) -> Result<Compressor> {
        let wrong = || Error::Invalid(format!("the white of {primaries} lies outside the triangle of its primaries"));
        let of = |p: Xy| uv(p.xyz()).filter(|q| q.iter().all(|x| x.is_finite()));
        let white_uv = of(primaries.white).ok_or_else(wrong)?;
        let corners = [0, 1, 2].map(|i| {
            let p = primaries.rgb[i];
            let d = -2.0 * p.x + 12.0 * p.y + 3.0; // u', v' straight from x, y: a primary may have y <= 0
            [4.0 * p.x / d, 9.0 * p.y / d]
        });
        let mut edges = [[0.0; 2]; 3];
        for (i, edge) in edges.iter_mut().enumerate() {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let n = [a[1] - b[1], b[0] - a[0]];
            let distance = n[0] * (white_uv[0] - a[0]) + n[1] * (white_uv[1] - a[1]);
            if distance == 0.0 || !distance.is_finite() {
                return Err(wrong());
            }
            *edge = n.map(|x| x / distance);
        }
        let inverse = |m: [[f64; 3]; 3]| Mat3(m).inverse().unwrap_or(Mat3::IDENTITY); // both are regular
        let (w, d65) = (primaries.white.xyz(), Xy::D65.xyz());
        let this = Compressor {
            hue,
            curve,
            reach: 1.0,
            white_uv,
            edges,
            to_rgb: primaries.from_xyz().ok_or_else(wrong)?,
            to_d65: [0, 1, 2].map(|i| d65[i] / w[i]),
            lms_to_xyz: inverse(OKLAB_M1),
            lab_to_lms: inverse(OKLAB_M2),
        };
        if this.to_rgb.apply(w).iter().any(|x| *x <= 0.0) { Err(wrong()) } else { Ok(this) }
    }

    /// Largest excess of the spectral locus and the purples: what has to fit when any visible colour may come.
    pub fn visible_reach(&self) -> Result<f64> {
        let observer = Observer::cie1931()?;
        let locus: Vec<[f64; 3]> =
            (390..=700).map(|nm| observer.cmf.each_ref().map(|c: &Spectrum| c.at(f64::from(nm)))).collect();
        let (first, last) = (locus[0], locus[locus.len() - 1]);
        let purples = (0..=100).map(|i| {
            let t = f64::from(i) / 100.0;
            [0, 1, 2].map(|c| first[c] / first[1] * t + last[c] / last[1] * (1.0 - t))
        });
        Ok(locus.iter().copied().chain(purples).map(|xyz| self.excess(xyz)).fold(1.0, f64::max))
    }

    /// The excess of a colour; 0 for black and for what is no colour.
    pub fn excess(&self, xyz: [f64; 3]) -> f64 {
        if !(xyz[1] > 0.0 && xyz.iter().all(|x| x.is_finite())) {
            return 0.0;
        }
        match self.hue {
            Hue::Uv => {
                let Some([u, v]) = uv(xyz).filter(|c| c[1] > 0.0) else { return f64::MAX };
                let d = [u - self.white_uv[0], v - self.white_uv[1]];
                self.edges.iter().map(|n| -(n[0] * d[0] + n[1] * d[1])).fold(0.0, f64::max)
            }
            Hue::Oklab => {
                let lab = self.oklab(xyz);
                let fits = |k: f64| {
                    let rgb = self.to_rgb.apply(self.unoklab([lab[0], lab[1] * k, lab[2] * k]));
                    let top = rgb.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                    rgb.iter().all(|x| *x >= -1e-9 * top)
                };
                // The edge is at k = 1 / excess. Colours well inside need no number: the knee leaves them alone.
                let (mut inside, mut outside) = (0.0, 4.0);
                if fits(outside) {
                    return 1.0 / outside;
                }
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (inside + outside);
                    *(if fits(middle) { &mut inside } else { &mut outside }) = middle;
                }
                if inside > 0.0 { 1.0 / inside } else { f64::MAX }
            }
        }
    }

    /// The colour brought in, at the same luminance; black for what is no colour.
    pub fn apply(&self, xyz: [f64; 3]) -> [f64; 3] {
        let excess = self.excess(xyz);
        let keep = self.keep(excess);
        if !(xyz[1] > 0.0 && xyz.iter().all(|x| x.is_finite())) {
            return [0.0; 3];
        }
        if keep >= 1.0 {
            return xyz;
        }
        match self.hue {
            Hue::Uv => match uv(xyz).filter(|c| c[1] > 0.0) {
                Some(c) => uv_to_xyz([0, 1].map(|i| self.white_uv[i] + keep * (c[i] - self.white_uv[i])), xyz[1]),
                None => uv_to_xyz(self.white_uv, xyz[1]),
            },
            Hue::Oklab => {
                let lab = self.oklab(xyz);
                let moved = self.unoklab([lab[0], lab[1] * keep, lab[2] * keep]);
                moved.map(|x| x * xyz[1] / moved[1])
            }
        }
    }

    /// Share of its distance from the neutral that a colour keeps.
    fn keep(&self, excess: f64) -> f64 {
        let reach = self.reach.max(1.0);
        match self.curve {
            Curve::Shrink => (1.0 / reach).min(1.0 / excess),
            Curve::Compress(knee) if excess > knee => {
                let room = 1.0 - knee;
                if room <= 0.0 {
                    return (1.0 / excess).min(1.0);
                }
                // x (1 + x / X^2) / (1 + x) leaves the knee with slope 1 and takes X to 1.
                let (x, top) = ((excess.min(reach) - knee) / room, (reach - knee) / room);
                (knee + room * x * (1.0 + x / (top * top)) / (1.0 + x)) / excess
            }
            Curve::Compress(_) => 1.0,
        }
    }

    fn oklab(&self, xyz: [f64; 3]) -> [f64; 3] {
        super::difference::oklab([0, 1, 2].map(|i| xyz[i] * self.to_d65[i]))
    }

    fn unoklab(&self, lab: [f64; 3]) -> [f64; 3] {
        let xyz = self.lms_to_xyz.apply(self.lab_to_lms.apply(lab).map(|x| x.powi(3)));
        [0, 1, 2].map(|i| xyz[i] / self.to_d65[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(reach: f64) -> Vec<Compressor> {
        let mut all = Vec::new();
        for hue in [Hue::Uv, Hue::Oklab] {
            for curve in [Curve::Shrink, Curve::Compress(0.8), Curve::Compress(1.0)] {
                let mut c = Compressor::new(Primaries::BT709, hue, curve).unwrap();
                c.reach = reach;
                all.push(c);
            }
        }
        all
    }

    #[test]
    fn the_edge_of_bt709_has_excess_1() {
        for c in all(1.0) {
            for edge in [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.3, 0.0, 0.7]] {
                let xyz = Primaries::BT709.to_xyz().unwrap().apply(edge);
                assert!((c.excess(xyz) - 1.0).abs() < 1e-5, "{:?} {edge:?}: {}", c.hue, c.excess(xyz));
            }
            let reach = c.visible_reach().unwrap();
            assert!((1.5..10.0).contains(&reach), "{:?}: {reach}", c.hue);
        }
    }

    proptest! {
        #[test]
        fn visible_colours_fit_and_keep_their_luminance(nm in 400f64..690.0, white in 0f64..1.0, y in 1e-3f64..1e4) {
            let observer = Observer::cie1931().unwrap();
            let pure = observer.cmf.each_ref().map(|c| c.at(nm));
            let w = Xy::D65.xyz();
            let xyz = [0, 1, 2].map(|i| y * (pure[i] / pure[1] * (1.0 - white) + w[i] * white));
            for mut c in all(1.0) {
                c.reach = c.visible_reach().unwrap();
                let out = c.apply(xyz);
                prop_assert!((out[1] / y - 1.0).abs() < 1e-9);
                let rgb = c.to_rgb.apply(out);
                let top = rgb.iter().fold(0.0f64, |m, x| m.max(*x));
                prop_assert!(rgb.iter().all(|x| *x >= -2e-5 * top), "{:?} {:?} {nm}: {rgb:?}", c.hue, c.curve);
                prop_assert!(c.excess(out) <= c.excess(xyz) * (1.0 + 1e-9) + 1e-9);
            }
        }

        #[test]
        fn colours_below_the_knee_are_untouched(r in 0.3f64..1.0, g in 0.3f64..1.0, b in 0.3f64..1.0) {
            let xyz = Primaries::BT709.to_xyz().unwrap().apply([r, g, b]);
            for c in all(3.0).into_iter().filter(|c| c.curve != Curve::Shrink) {
                if c.excess(xyz) < 0.8 {
                    prop_assert_eq!(c.apply(xyz), xyz);
                }
            }
        }
    }
}
