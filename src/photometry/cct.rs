//! Correlated colour temperature and Duv: the blackbody whose chromaticity lies nearest in CIE 1960 (u, v), and how far away
//! it is, above 0 where the light is greener, below where it is pinker [CIE15, Ohno 2014].
//!
//! The distance itself is minimised over the reciprocal temperature, by a scan and a golden section: no table of isotherms,
//! so the answer is the definition's. The blackbodies are Planck's with c2 of today (CODATA): illuminant A, made with that of
//! its time, is 2855.5 K on this scale, and D65 6503 K.
//!
//! Beyond |Duv| = 0.05 the CIE gives a light no correlated colour temperature.

use crate::Result;
use crate::color::Xy;
use crate::spectral::{Observer, Spectrum};
use crate::units::C2_M_K;

/// |Duv| up to which a correlated colour temperature means something [CIE15].
pub const LARGEST_DUV: f64 = 0.05;
/// Coolest and hottest blackbody looked at, kelvin.
pub const RANGE_K: (f64, f64) = (1000.0, 100_000.0);
/// Steps of the scan, equal in the reciprocal temperature's logarithm.
const STEPS: usize = 200;

/// The nearest blackbody.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cct {
    /// Its temperature.
    pub kelvin: f64,
    /// Distance in (u, v), positive above the locus.
    pub duv: f64,
}

impl Cct {
    /// True where the CIE lets a light have a correlated colour temperature, and the blackbody is not one of the range's ends.
    pub fn is_meaningful(&self) -> bool {
        self.duv.abs() <= LARGEST_DUV && self.kelvin > 1.0001 * RANGE_K.0 && self.kelvin < 0.9999 * RANGE_K.1
    }
}

/// The Planckian locus of the CIE 1931 observer.
#[derive(Clone, Debug)]
pub struct Locus {
    /// Wavelength in m, then xbar, ybar, zbar over the wavelength's fifth power.
    rows: Vec<[f64; 4]>,
    /// Temperatures of the scan and their (u, v).
    scan: Vec<(f64, [f64; 2])>,
}

impl Locus {
    /// Sums at the observer's own 1 nm.
    pub fn new() -> Result<Locus> {
        let [x, y, z] = Observer::cie1931()?.cmf;
        let wavelengths: Vec<f64> = match &y {
            Spectrum::Table(points) => points.iter().map(|p| p.0).collect(),
            Spectrum::Constant(_) => Vec::new(),
        };
        let row = |nm: &f64| {
            let fifth = (nm / 560.0).powi(5);
            [nm * 1e-9, x.at(*nm) / fifth, y.at(*nm) / fifth, z.at(*nm) / fifth]
        };
        let mut locus = Locus { rows: wavelengths.iter().map(row).collect(), scan: Vec::new() };
        let ratio = RANGE_K.1 / RANGE_K.0;
        let kelvin = |i: usize| RANGE_K.0 * ratio.powf(i as f64 / STEPS as f64);
        locus.scan = (0..=STEPS).map(kelvin).map(|t| (t, locus.uv(t))).collect();
        Ok(locus)
    }

    /// CIE 1960 (u, v) of a blackbody.
    ///
    /// ```
    /// let locus = luxpipe::photometry::cct::Locus::new().unwrap();
    /// let [u, v] = locus.uv(2855.54);
    /// assert!((u - 0.2560).abs() < 1e-4 && (v - 0.3495).abs() < 1e-4); // illuminant A
    /// ```
    pub fn uv(&self, kelvin: f64) -> [f64; 2] {
        let mut sums = [0.0; 3];
        for [m, cmf @ ..] in &self.rows {
            let power = 1.0 / ((C2_M_K / (m * kelvin)).exp() - 1.0);
            sums.iter_mut().zip(cmf).for_each(|(s, c)| *s += c * power);
        }
        of_xyz(sums)
    }

    /// The blackbody nearest to a chromaticity.
    ///
    /// ```
    /// use luxpipe::{color::Xy, photometry::cct::Locus};
    /// let cct = Locus::new().unwrap().nearest(Xy { x: 0.31272, y: 0.32903 });
    /// assert!((cct.kelvin - 6503.0).abs() < 1.5 && (cct.duv - 0.0032).abs() < 1e-4 && cct.is_meaningful());
    /// ```
    pub fn nearest(&self, xy: Xy) -> Cct {
        let light = of_xyz(xy.xyz());
        let apart = |uv: [f64; 2]| (uv[0] - light[0]).hypot(uv[1] - light[1]);
        let best = (0..self.scan.len()).min_by(|a, b| apart(self.scan[*a].1).total_cmp(&apart(self.scan[*b].1)));
        let best = best.unwrap_or(0);
        let (cool, hot) = (self.scan[best.saturating_sub(1)].0, self.scan[(best + 1).min(STEPS)].0);
        let reciprocal = golden(1.0 / hot, 1.0 / cool, |r| apart(self.uv(1.0 / r)));
        let kelvin = 1.0 / reciprocal;
        let nearest = self.uv(kelvin);
        Cct { kelvin, duv: apart(nearest).copysign(light[1] - nearest[1]) }
    }
}

/// CIE 1960 (u, v).
fn of_xyz([x, y, z]: [f64; 3]) -> [f64; 2] {
    let sum = x + 15.0 * y + 3.0 * z;
    [4.0 * x / sum, 6.0 * y / sum]
}

/// Where f, with one minimum between a and b, is least; to the square root of double precision.
fn golden(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (3.0 - 5f64.sqrt());
    let (mut p, mut q) = (a + share * (b - a), b - share * (b - a));
    let (mut fp, mut fq) = (f(p), f(q));
    while (b - a) > 1e-9 * b.abs() {
        if fp < fq {
            (b, q, fq) = (q, p, fp);
            p = a + share * (b - a);
            fp = f(p);
        } else {
            (a, p, fp) = (p, q, fq);
            q = b - share * (b - a);
            fq = f(q);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{builtin, planck};

    /// The definition minimised by another program (numpy, scipy's bounded Brent method on colour-science's observer), x, y,
    /// K, Duv; colour-science's own interpolated tables (`uv_to_CCT_Ohno2013`) agree with it within 1 K below 10000 K.
    const LIGHTS: [(&str, f64, f64, f64, f64); 10] = [
        ("A", 0.44758, 0.40745, 2855.4812, 3.365e-6),
        ("D65", 0.31272, 0.32903, 6502.9287, 3.21250e-3),
        ("D50", 0.34567, 0.35851, 5001.7804, 3.21015e-3),
        ("E", 1.0 / 3.0, 1.0 / 3.0, 5455.3981, -4.42332e-3),
        ("FL2", 0.3721, 0.3751, 4223.3583, 1.76823e-3),
        ("FL4", 0.4402, 0.4031, 2937.6787, -8.1743e-4),
        ("FL11", 0.3805, 0.3769, 3999.4834, 5.4137e-5),
        ("C", 0.31006, 0.31616, 6774.0442, -2.15151e-3),
        ("pink", 0.48, 0.39, 2288.4881, -8.36535e-3),
        ("blue sky", 0.25, 0.25, 28793.2229, 6.8181e-4),
    ];

    #[test]
    fn temperatures_of_the_definition() {
        let locus = Locus::new().unwrap();
        for (name, x, y, kelvin, duv) in LIGHTS {
            let got = locus.nearest(Xy { x, y });
            assert!((got.kelvin / kelvin - 1.0).abs() < 1e-6, "{name}: {got:?}");
            assert!((got.duv - duv).abs() < 1e-8, "{name}: {got:?}");
            assert!(got.is_meaningful());
        }
    }

    /// A blackbody is its own, a step off at right angles to the locus is the Duv.
    #[test]
    fn blackbodies_and_steps_off_the_locus() {
        let locus = Locus::new().unwrap();
        let xy = |[u, v]: [f64; 2]| {
            let d = 2.0 * u - 8.0 * v + 4.0;
            Xy { x: 3.0 * u / d, y: 2.0 * v / d }
        };
        for kelvin in [1100.0, 1900.0, 2856.0, 4000.0, 6500.0, 15000.0, 60000.0f64] {
            let [u, v] = locus.uv(kelvin);
            let (a, b) = (locus.uv(0.999 * kelvin), locus.uv(1.001 * kelvin));
            let along = [b[0] - a[0], b[1] - a[1]];
            let length = along[0].hypot(along[1]);
            for duv in [-0.02, 0.0, 0.01] {
                let at = [u + duv * along[1] / length, v - duv * along[0] / length];
                let got = locus.nearest(xy(at));
                assert!((got.kelvin / kelvin - 1.0).abs() < 1e-4, "{kelvin} {duv}: {got:?}");
                assert!(
                    (got.duv.abs() - f64::abs(duv)).abs() < 1e-7 && got.duv * duv >= 0.0,
                    "{kelvin} {duv}: {got:?}"
                );
            }
        }
    }

    #[test]
    fn spectra_by_the_observer() {
        let locus = Locus::new().unwrap();
        let observer = Observer::cie1931().unwrap();
        let of = |s: &Spectrum| locus.nearest(Xy::of(observer.integrate(s)).unwrap());
        let thermal = of(&planck::blackbody(3200.0).unwrap());
        assert!((thermal.kelvin - 3200.0).abs() < 0.1 && thermal.duv.abs() < 1e-6, "{thermal:?}");
        // 2848 K with c2 = 1.435e-2 is 2855.5 K with today's.
        let a = of(&builtin::spectrum("A").unwrap());
        assert!((a.kelvin - 2848.0 * C2_M_K / 1.435e-2).abs() < 0.1 && a.duv.abs() < 1e-5, "{a:?}");
    }

    #[test]
    fn colours_without_a_temperature() {
        let locus = Locus::new().unwrap();
        assert!(locus.nearest(Xy { x: 0.2, y: 0.7 }).duv > LARGEST_DUV);
        for xy in [Xy { x: 0.3, y: 0.6 }, Xy { x: 0.2, y: 0.1 }, Xy { x: 0.7, y: 0.3 }, Xy { x: f64::NAN, y: 0.3 }] {
            assert!(!locus.nearest(xy).is_meaningful(), "{xy}");
        }
    }
}
