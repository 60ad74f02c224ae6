//! Fresnel's equations for smooth boundaries, unpolarised unless said otherwise; cosines are those on the side that light
//! comes from.

use crate::optics::polarization::{Diattenuation, Response};

/// Reflectances of s and p polarised light at a boundary where the index grows by the factor `eta` (> 0), and the cosine
/// on the other side; total reflection gives (1, 1, 0).
///
/// ```
/// use luxpipe::optics::fresnel::polarised;
/// let (s, p, _) = polarised(60f64.to_radians().cos(), 1.5);
/// assert!((s - 0.17657149).abs() < 1e-8 && (p - 0.0018019375).abs() < 1e-9);
/// ```
pub fn polarised(cos: f64, eta: f64) -> (f64, f64, f64) {
    let sin2 = (1.0 - cos * cos).max(0.0) / (eta * eta);
    if sin2 >= 1.0 {
        return (1.0, 1.0, 0.0);
    }
    let inside = (1.0 - sin2).sqrt();
    let s = (cos - eta * inside) / (cos + eta * inside);
    let p = (eta * cos - inside) / (eta * cos + inside);
    (s * s, p * p, inside)
}

/// Reflectance of a dielectric, and the cosine beyond the boundary.
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let (s, p, inside) = polarised(f64::from(cos), f64::from(eta));
    (((s + p) / 2.0) as f32, inside as f32)
}

/// Reflectance of a metal with index n + ik in air (real form of the complex equations, Born and Wolf section 14.2).
#[inline(always)]
pub fn conductor(cos: f32, n: f32, k: f32) -> f32 {
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let (n2, k2) = (n * n, k * k);
    // (n + ik)^2 - sin^2 = (a + ib)^2.
    let t = n2 - k2 - sin2;
    let length = (t * t + 4.0 * n2 * k2).sqrt();
    let a = (0.5 * (length + t)).max(0.0).sqrt();
    let s1 = length + cos2;
    let s2 = 2.0 * a * cos;
    // Both 0 only where a medium like air (n = 1, k = 0) is met at grazing: nothing to reflect.
    let s = (s1 - s2) / (s1 + s2).max(f32::MIN_POSITIVE);
    let p1 = cos2 * length + sin2 * sin2;
    let p2 = s2 * sin2;
    let p = s * ((p1 - p2) / (p1 + p2).max(f32::MIN_POSITIVE));
    0.5 * (s + p)
}

/// A metal's reflectances of s and p light and their retardance arg(-rp conj(rs)) in degrees, 0..180, with the time factor
/// exp(-i w t): n + ik absorbs.
///
/// ```
/// use luxpipe::optics::fresnel::conductor_polarised;
/// let (s, p, retardance_deg) = conductor_polarised(45f64.to_radians().cos(), 0.43, 2.455);
/// assert!((s - 0.84941373).abs() < 1e-7 && (p - 0.72150368).abs() < 1e-7 && (retardance_deg - 30.268163).abs() < 1e-5);
/// ```
pub fn conductor_polarised(cos: f64, n: f64, k: f64) -> (f64, f64, f64) {
    type Complex = (f64, f64);
    let times = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let over = |a: Complex, b: Complex| {
        let d = b.0 * b.0 + b.1 * b.1;
        ((a.0 * b.0 + a.1 * b.1) / d, (a.1 * b.0 - a.0 * b.1) / d)
    };
    let index2 = times((n, k), (n, k));
    // n cos inside = sqrt(n^2 - sin^2), the root that decays.
    let (re, im) = (index2.0 - (1.0 - cos * cos), index2.1);
    let length = re.hypot(im);
    let inside = ((0.5 * (length + re)).max(0.0).sqrt(), (0.5 * (length - re)).max(0.0).sqrt());
    let s = over((cos - inside.0, -inside.1), (cos + inside.0, inside.1));
    let front = (index2.0 * cos, index2.1 * cos);
    let p = over((front.0 - inside.0, front.1 - inside.1), (front.0 + inside.0, front.1 + inside.1));
    let product = times((-p.0, -p.1), (s.0, -s.1));
    let square = |z: Complex| z.0 * z.0 + z.1 * z.1;
    (square(s), square(p), product.1.atan2(product.0).to_degrees().abs())
}

/// Share of diffuse light that a dielectric reflects: from outside (`eta` > 1) or inside (`eta` < 1), 2 x integral of
/// R cos over the cosine.
///
/// ```
/// use luxpipe::optics::fresnel::diffuse;
/// assert!((diffuse(1.5) - 0.091777959).abs() < 1e-6 && (diffuse(1.0 / 1.5) - 0.59634576).abs() < 1e-6);
/// ```
pub fn diffuse(eta: f64) -> f64 {
    // From inside all beyond the critical angle is 1; the substitution cos^2 = c^2 + (1 - c^2) x^2 opens the root there.
    let critical2 = (1.0 - eta * eta).max(0.0);
    let n = 2000;
    let simpson = |f: &dyn Fn(f64) -> f64| {
        let h = 1.0 / f64::from(n);
        let inner: f64 = (1..n).map(|i| f(f64::from(i) * h) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (f(0.0) + inner + f(1.0)) * h / 3.0
    };
    let open = simpson(&|x| {
        let (s, p, _) = polarised((critical2 + (1.0 - critical2) * x * x).sqrt(), eta);
        (s + p) * x * (1.0 - critical2)
    });
    critical2 + open
}

/// Parallel panes of one kind, polarisation kept between them, reflections between all surfaces added up without
/// interference: per polarisation T = t (1 - r)^2 / (1 - r^2 t^2), R = r (1 + t T), and N panes by adding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stack {
    /// Reflectance of one surface for s light.
    pub s: f32,
    /// For p light.
    pub p: f32,
    /// Way through the glass in units of its thickness: 1 / cosine inside.
    pub way: f32,
    /// How many panes, from 1.
    pub panes: u32,
}

impl Stack {
    /// Panes of index `n` seen under a cosine.
    pub fn new(cos: f32, n: f32, panes: u32) -> Stack {
        let (s, p, inside) = polarised(f64::from(cos), f64::from(n));
        Stack { s: s as f32, p: p as f32, way: (1.0 / inside) as f32, panes }
    }

    /// Share of unpolarised light that goes through, or comes back, where one pane has this optical depth along its normal.
    ///
    /// ```
    /// use luxpipe::optics::fresnel::Stack;
    /// let clear = Stack::new(1.0, 1.52, 1);
    /// assert!((clear.share(0.0, false) - 0.91831803).abs() < 1e-6 && (clear.share(0.0, true) - 0.081681972).abs() < 1e-6);
    /// ```
    #[inline(always)]
    pub fn share(&self, depth: f32, back: bool) -> f32 {
        let t = (-depth * self.way).exp();
        let one = |r: f32| {
            let through = t * (1.0 - r) * (1.0 - r) / (1.0 - r * r * t * t);
            let sent = r * (1.0 + t * through);
            let (mut all_through, mut all_sent) = (through, sent);
            for _ in 1..self.panes {
                let between = 1.0 / (1.0 - all_sent * sent);
                (all_through, all_sent) =
                    (all_through * through * between, all_sent + all_through * all_through * sent * between);
            }
            if back { all_sent } else { all_through }
        };
        0.5 * (one(self.s) + one(self.p))
    }
}

/// What a boundary with a medium of complex index n + ik makes of polarization, of light thrown back; fast, for many wavelengths.
///
/// ```
/// use luxpipe::optics::{film, fresnel};
/// let fast = fresnel::diattenuation(0.5, 0.43, 2.455);
/// let slow = film::shares(0.5, 1.0, &[], film::Complex64::new(0.43, 2.455)).back.relative();
/// assert!((fast.a - slow.a).abs() < 1e-5 && (fast.b - slow.b).abs() < 1e-5 && (fast.c - slow.c).abs() < 1e-5);
/// ```
#[inline(always)]
pub fn diattenuation(cos: f32, n: f32, k: f32) -> Diattenuation {
    let cos = cos.max(1e-6);
    // (n + ik)^2, and its root less the sine's square: x + iy inwards.
    let (re, im) = (n * n - k * k, 2.0 * n * k);
    let t = re - (1.0 - cos * cos);
    let length = (t * t + im * im).sqrt();
    let (x, y) = ((0.5 * (length + t)).max(0.0).sqrt(), (0.5 * (length - t)).max(0.0).sqrt());
    // rs = (cos - z) / (cos + z), rp = (n^2 cos - z) / (n^2 cos + z); only rs conj(rp) and the squares are needed.
    let over = |ar: f32, ai: f32, br: f32, bi: f32| {
        let d = (br * br + bi * bi).max(f32::MIN_POSITIVE);
        ((ar * br + ai * bi) / d, (ai * br - ar * bi) / d)
    };
    let (sr, si) = over(cos - x, -y, cos + x, y);
    let (pr, pi) = over(re * cos - x, im * cos - y, re * cos + x, im * cos + y);
    let (s, p) = (sr * sr + si * si, pr * pr + pi * pi);
    let sum = 1.0 / (s + p).max(f32::MIN_POSITIVE);
    Diattenuation { a: (s - p) * sum, b: 2.0 * (sr * pr + si * pi) * sum, c: 2.0 * (si * pr - sr * pi) * sum }
}

/// The same of light that comes through a clear boundary, index beyond over index here: no phase is lost.
#[inline(always)]
pub fn diattenuation_through(cos: f32, eta: f32) -> Diattenuation {
    let inside2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
    let inside = inside2.max(0.0).sqrt();
    // Amplitudes but for what is the same in both.
    let (s, p) = (eta * cos + inside, cos + eta * inside);
    let (s2, p2) = (s * s, p * p);
    let sum = 1.0 / (s2 + p2).max(f32::MIN_POSITIVE);
    Diattenuation { a: (s2 - p2) * sum, b: 2.0 * s * p * sum, c: 0.0 }
}

/// Parallel panes of an index from 1 as a [`Response`], without interference: sums over reflections between all surfaces keep s and p
/// apart, and what is neither, the product of their amplitudes, which are real without total reflection.
pub fn panes(cos: f64, index: f64, depth: f64, panes: u32, through: bool) -> Response {
    let (_, _, inside) = polarised(cos, index);
    let s = (cos - index * inside) / (cos + index * inside);
    let p = (index * cos - inside) / (index * cos + inside);
    let t = (-depth / inside).exp();
    // Products of two amplitudes of s, of p, and of one of each; a reflection from within has both signs turned.
    let sent = [s * s, p * p, s * p];
    let open = [1.0 - sent[0], 1.0 - sent[1], ((1.0 - sent[0]) * (1.0 - sent[1])).sqrt()];
    let all = [0, 1, 2].map(|i| {
        let (r, way) = (sent[i], open[i] * open[i] * t);
        let onward = way / (1.0 - r * r * t * t);
        let back = r + onward * r * t;
        let (mut all_on, mut all_back) = (onward, back);
        for _ in 1..panes {
            let between = 1.0 / (1.0 - all_back * back);
            (all_on, all_back) = (all_on * onward * between, all_back + all_on * all_on * back * between);
        }
        if through { all_on } else { all_back }
    });
    Response { s: all[0], p: all[1], cross: all[2].into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::film::{self, Complex64};

    #[test]
    fn metals_are_those_of_the_complex_equations() {
        // Gold at 548.6 nm [Johnson 1972]: Rs and Rp by complex arithmetic in double precision.
        let rows: [(f64, f64, f64); 3] =
            [(0.0, 0.78691576, 0.78691576), (45.0, 0.84941373, 0.72150368), (75.0, 0.94370064, 0.70635793)];
        for (deg, s, p) in rows {
            let got = f64::from(conductor(deg.to_radians().cos() as f32, 0.43, 2.455));
            assert!((got - (s + p) / 2.0).abs() < 2e-6, "{deg}: {got}");
        }
        assert_eq!(conductor(0.0, 0.43, 2.455), 1.0);
        assert!(conductor(1.0, 1.0, 0.0) == 0.0);
    }

    #[test]
    fn panes_lose_nothing_that_they_do_not_absorb() {
        for panes in 1..5 {
            for deg in [0.0f32, 30.0, 60.0, 85.0, 89.9] {
                let stack = Stack::new(deg.to_radians().cos(), 1.52, panes);
                assert!((stack.share(0.0, false) + stack.share(0.0, true) - 1.0).abs() < 1e-5);
                assert!(stack.share(0.03, false) + stack.share(0.03, true) < 1.0);
            }
        }
    }

    #[test]
    fn fast_polarization_is_that_of_the_matrices() {
        for deg in [0.0f64, 20.0, 56.3, 75.0, 89.0] {
            let cos = deg.to_radians().cos();
            let near = |a: Diattenuation, b: Diattenuation| {
                (a.a - b.a).abs() < 2e-4 && (a.b - b.b).abs() < 2e-4 && (a.c - b.c).abs() < 2e-4
            };
            for (n, k) in [(1.5, 0.0), (0.43, 2.455), (0.05, 3.0), (1.0 / 1.5, 0.0)] {
                let slow = film::shares(cos, 1.0, &[], Complex64::new(n, k));
                assert!(near(diattenuation(cos as f32, n as f32, k as f32), slow.back.relative()), "{deg} {n} {k}");
                if k == 0.0 && slow.through.mean() > 0.0 {
                    assert!(near(diattenuation_through(cos as f32, n as f32), slow.through.relative()), "{deg} {n}");
                }
            }
        }
    }

    #[test]
    fn polarised_panes_are_the_same_panes() {
        for count in 1..4 {
            for deg in [0.0f64, 40.0, 70.0, 85.0] {
                let cos = deg.to_radians().cos();
                for depth in [0.0, 0.03, 1.0] {
                    for through in [true, false] {
                        let want = f64::from(Stack::new(cos as f32, 1.52, count).share(depth as f32, !through));
                        let got = panes(cos, 1.52, depth, count, through);
                        assert!((got.mean() - want).abs() < 2e-6, "{count} {deg} {depth}: {} for {want}", got.mean());
                        assert!(got.cross.norm_sqr() <= got.s * got.p + 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn panes_of_6_mm_are_those_of_cie_171_case_5_5() {
        let rows: [(f64, f64, f64); 3] =
            [(0.0, 0.89108337, 0.079400955), (60.0, 0.8124218, 0.15187608), (85.0, 0.2261219, 0.73756654)];
        for (deg, t, r) in rows {
            let stack = Stack::new(deg.to_radians().cos() as f32, 1.52, 1);
            let (through, back) = (f64::from(stack.share(0.03, false)), f64::from(stack.share(0.03, true)));
            assert!((through - t).abs() < 1e-6 && (back - r).abs() < 1e-6, "{deg}");
        }
    }
}
