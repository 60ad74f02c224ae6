//! Rendering intents that mean something, for colours a display cannot make.
//!
//! *Colorimetric*: the nearest colour in CIEDE2000 that the display has at the same luminance. *Saturation*: the same u'v'
//! saturation, at a lower luminance or another hue if need be.

use super::difference::{ciede2000, lab, uv, uv_to_xyz};
use super::{Mat3, Primaries};
use crate::{Error, Result};

/// Rounding below and above the range that is no excess.
const ROUNDING: f64 = 1e-6;
/// Places tried along each edge of a luminance's slice before the search narrows.
const TRIES: usize = 16;
/// Valleys of the error that are searched.
const VALLEYS: usize = 2;
/// Rounds of the narrowing, each four times finer.
const NARROWINGS: usize = 4;

/// A display's gamut in linear RGB 0..1, luminance relative to its white.
#[derive(Clone, Debug)]
pub struct Gamut {
    to_xyz: Mat3,
    to_rgb: Mat3,
    white: [f64; 3],
    corners_uv: [[f64; 2]; 3],
}

impl Gamut {
    /// Of these primaries.
    pub fn new(primaries: Primaries) -> Result<Gamut> {
        let wrong = || Error::Invalid(format!("{primaries} make no display"));
        let (to_xyz, to_rgb) = (primaries.to_xyz().ok_or_else(wrong)?, primaries.from_xyz().ok_or_else(wrong)?);
        let corner = |i: usize| uv([to_xyz.0[0][i], to_xyz.0[1][i], to_xyz.0[2][i]]).ok_or_else(wrong);
        Ok(Gamut { to_xyz, to_rgb, white: primaries.white.xyz(), corners_uv: [corner(0)?, corner(1)?, corner(2)?] })
    }

    /// True for RGB that the display has.
    pub fn holds(rgb: [f64; 3]) -> bool {
        rgb.iter().all(|x| (-ROUNDING..=1.0 + ROUNDING).contains(x))
    }

    /// True for a colour that the display shows as it is; XYZ relative to the white's Y = 1.
    pub fn is_exact(&self, xyz: [f64; 3]) -> bool {
        Gamut::holds(self.to_rgb.apply(xyz))
    }

    /// The RGB nearest to a colour in CIEDE2000 among those of its luminance; XYZ relative to the white's Y = 1.
    pub fn nearest(&self, xyz: [f64; 3]) -> [f64; 3] {
        let rgb = self.to_rgb.apply(xyz);
        if Gamut::holds(rgb) {
            return rgb.map(|x| x.clamp(0.0, 1.0));
        }
        let y = self.to_xyz.0[1];
        let luminance = xyz[1];
        if luminance.is_nan() || luminance <= 0.0 || luminance >= 1.0 {
            return [if luminance >= 1.0 { 1.0 } else { 0.0 }; 3];
        }
        let wanted = lab(xyz, self.white);
        let error = |rgb: [f64; 3]| self.difference(rgb, wanted);
        // The slice's border as a ring: edge number plus place on the edge.
        let corners = slice(y, luminance);
        let n = corners.len();
        let place = |s: f64| {
            let edge = s.rem_euclid(n as f64);
            let i = (edge as usize).min(n - 1);
            between(corners[i], corners[(i + 1) % n], edge - i as f64)
        };
        let tries = n * TRIES;
        let at = |k: usize| k as f64 / TRIES as f64;
        let errors: Vec<f64> = (0..tries).map(|k| error(place(at(k)))).collect();
        // CIEDE2000 along the ring may have several valleys: each of the deepest is searched.
        let valley = |k: &usize| errors[*k] <= errors[(k + 1) % tries] && errors[*k] <= errors[(k + tries - 1) % tries];
        let mut valleys: Vec<usize> = (0..tries).filter(valley).collect();
        valleys.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]));
        let bottom = |k: &usize| narrow((errors[*k], at(*k)), at(1), |s| error(place(s)));
        let best = valleys.iter().take(VALLEYS).map(bottom).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or([luminance; 3], |b| place(b.1)).map(|x| x.clamp(0.0, 1.0))
    }

    /// CIEDE2000 of a displayed colour from a CIELAB one; infinite beyond the neutral, where the formula's mean hue jumps and
    /// makes an opposite hue look near.
    fn difference(&self, rgb: [f64; 3], wanted: [f64; 3]) -> f64 {
        let seen = lab(self.to_xyz.apply(rgb), self.white);
        if seen[1] * wanted[1] + seen[2] * wanted[2] < 0.0 { f64::INFINITY } else { ciede2000(seen, wanted) }
    }

    /// The RGB of the same u'v' saturation: a hue beside the colour's own where the triangle is too narrow, then as much
    /// luminance as the display has for it. XYZ relative to the white's Y = 1.
    pub fn as_saturated(&self, xyz: [f64; 3]) -> [f64; 3] {
        let rgb = self.to_rgb.apply(xyz);
        if Gamut::holds(rgb) {
            return rgb.map(|x| x.clamp(0.0, 1.0));
        }
        let (Some(c), Some(w)) = (uv(xyz).filter(|c| c[1] > 0.0), uv(self.white)) else { return [0.0; 3] };
        if xyz[1].is_nan() || xyz[1] <= 0.0 {
            return [0.0; 3];
        }
        let inside = rgb.iter().all(|x| *x >= -ROUNDING * xyz[1]);
        let chroma = if inside { c } else { self.turned(c, w) };
        let rgb = self.to_rgb.apply(uv_to_xyz(chroma, xyz[1])).map(|x| x.max(0.0));
        let top = rgb.iter().fold(1.0f64, |m, x| m.max(*x));
        rgb.map(|x| x / top)
    }

    /// The place on the triangle as far from the white as `c`, nearest to it; the corner nearest in angle if none is.
    fn turned(&self, c: [f64; 2], w: [f64; 2]) -> [f64; 2] {
        let d = [c[0] - w[0], c[1] - w[1]];
        let radius = d[0].hypot(d[1]);
        // (loss, place) of what can be had.
        let mut places: Vec<(f64, [f64; 2])> = Vec::new();
        for i in 0..3 {
            let (a, b) = (self.corners_uv[i], self.corners_uv[(i + 1) % 3]);
            let (e, f) = ([b[0] - a[0], b[1] - a[1]], [a[0] - w[0], a[1] - w[1]]);
            // |f + t e| = radius
            let (p, q, r) =
                (e[0] * e[0] + e[1] * e[1], f[0] * e[0] + f[1] * e[1], f[0] * f[0] + f[1] * f[1] - radius * radius);
            let root = q * q - p * r;
            if root < 0.0 {
                continue;
            }
            for t in [(-q - root.sqrt()) / p, (-q + root.sqrt()) / p] {
                if (0.0..=1.0).contains(&t) {
                    let place = [a[0] + t * e[0], a[1] + t * e[1]];
                    places.push(((place[0] - c[0]).hypot(place[1] - c[1]), place));
                }
            }
        }
        if places.is_empty() {
            for corner in self.corners_uv {
                let g = [corner[0] - w[0], corner[1] - w[1]];
                places.push((-(g[0] * d[0] + g[1] * d[1]) / g[0].hypot(g[1]), corner));
            }
        }
        places.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(w, |b| b.1)
    }
}

fn between(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t)
}

/// Corners, in order, of the polygon where the plane y . rgb = luminance cuts the unit cube; 0 < luminance < 1.
fn slice(y: [f64; 3], luminance: f64) -> Vec<[f64; 3]> {
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for axis in 0..3 {
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        for (b, c) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            let x = (luminance - y[j] * b - y[k] * c) / y[axis];
            if (0.0..=1.0).contains(&x) {
                let mut p = [0.0; 3];
                (p[axis], p[j], p[k]) = (x, b, c);
                corners.push(p);
            }
        }
    }
    let n = corners.len().max(1) as f64;
    let centre = [0, 1, 2].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / n);
    // Angle in the plane, seen along the luminance axis: red and blue alone tell it.
    corners.sort_by(|a, b| {
        let angle = |c: &[f64; 3]| (c[2] - centre[2]).atan2(c[0] - centre[0]);
        angle(a).total_cmp(&angle(b))
    });
    corners
}

/// Follows the best of eight places round the last best, nearer each time. CIEDE2000 jumps where hues lie opposite, which
/// a search that trusts in slopes would not survive.
fn narrow(mut best: (f64, f64), mut step: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    for _ in 0..NARROWINGS {
        let centre = best.1;
        for k in [-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0] {
            let s = centre + step * k / 4.5;
            let e = f(s);
            if e < best.0 {
                best = (e, s);
            }
        }
        step /= 4.0;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Xy;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_colour_is_nearest_and_as_bright(x in 0.05f64..0.65, y in 0.05f64..0.6, l in 0.02f64..0.95) {
            prop_assume!(x + y < 0.95);
            let gamut = Gamut::new(Primaries::BT709).unwrap();
            let xyz = Xy { x, y }.xyz().map(|v| v * l);
            let got = gamut.nearest(xyz);
            prop_assert!(Gamut::holds(got));
            let seen = gamut.to_xyz.apply(got);
            prop_assert!((seen[1] - l).abs() < 1e-9);
            let want = lab(xyz, gamut.white);
            let error = |rgb: [f64; 3]| gamut.difference(rgb, want);
            // Brute force over the slice's border.
            let corners = slice(gamut.to_xyz.0[1], l);
            let mut best = f64::MAX;
            for (i, a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                for k in 0..200 {
                    best = best.min(error(between(*a, b, f64::from(k) / 200.0)));
                }
            }
            if !Gamut::holds(gamut.to_rgb.apply(xyz)) {
                prop_assert!(error(got) <= best + 0.02 + 0.01 * best, "{} for {best}", error(got));
            }
        }

        #[test]
        fn saturation_is_kept_where_the_gamut_has_it(x in 0.05f64..0.65, y in 0.05f64..0.6, l in 0.02f64..0.95) {
            prop_assume!(x + y < 0.95);
            let gamut = Gamut::new(Primaries::BT709).unwrap();
            let xyz = Xy { x, y }.xyz().map(|v| v * l);
            let got = gamut.as_saturated(xyz);
            prop_assert!(Gamut::holds(got));
            let w = uv(gamut.white).unwrap();
            let radius = |c: [f64; 2]| (c[0] - w[0]).hypot(c[1] - w[1]);
            let most = gamut.corners_uv.map(radius).iter().fold(0.0f64, |m, r| m.max(*r));
            let (wanted, seen) = (radius(uv(xyz).unwrap()), radius(uv(gamut.to_xyz.apply(got)).unwrap()));
            if wanted < most {
                prop_assert!((seen / wanted - 1.0).abs() < 0.01, "{seen} for {wanted}");
            }
        }
    }
}
