//! A quantity over wavelength: piecewise linear between listed points and zero outside them, or one constant.

use crate::{Result, invalid};

/// A spectrum. Its unit is its owner's business: W/sr/m2/nm for radiance, 1 for reflectance.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same value at every wavelength.
    Constant(f64),
    /// (wavelength in nm, value), wavelengths strictly ascending, at least one point.
    Table(Vec<(f64, f64)>),
}

impl Spectrum {
    /// A table checked for order and finite numbers; names the offending entry.
    pub fn from_points(points: Vec<(f64, f64)>) -> Result<Spectrum> {
        if points.is_empty() {
            return invalid!("a spectrum needs at least one point");
        }
        for (i, (nm, value)) in points.iter().enumerate() {
            if !(*nm > 0.0 && nm.is_finite() && value.is_finite()) {
                return invalid!(
                    "point {}: wavelength must be positive and both numbers finite, got {nm},{value}",
                    i + 1
                );
            }
            if i > 0 && *nm <= points[i - 1].0 {
                return invalid!("point {}: wavelengths must ascend, got {nm} after {}", i + 1, points[i - 1].0);
            }
        }
        Ok(Spectrum::Table(points))
    }

    /// Two columns of CSV: comment lines from `#`, one optional line of column names, then wavelength_nm,value.
    ///
    /// ```
    /// let s = luxpipe::spectral::Spectrum::from_csv("# test\nwavelength_nm,value\n400,0\n500,8\n").unwrap();
    /// assert_eq!(s.at(450.0), 4.0);
    /// ```
    pub fn from_csv(text: &str) -> Result<Spectrum> {
        super::text::columns(text)
    }

    /// Value at a wavelength in nm.
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Spectrum::Constant(c) => *c,
            Spectrum::Table(p) => {
                let above = p.partition_point(|q| q.0 < nm);
                match (above.checked_sub(1).map(|i| p[i]), p.get(above)) {
                    (_, Some(b)) if b.0 == nm => b.1,
                    (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (nm - a.0) / (b.0 - a.0),
                    _ => 0.0,
                }
            }
        }
    }

    /// Exact integral over from_nm..to_nm, in value x nm.
    ///
    /// ```
    /// # use luxpipe::spectral::Spectrum;
    /// let ramp = Spectrum::from_points(vec![(400.0, 0.0), (700.0, 3.0)]).unwrap();
    /// assert!((ramp.integral(600.0, 900.0) - 250.0).abs() < 1e-12);
    /// ```
    pub fn integral(&self, from_nm: f64, to_nm: f64) -> f64 {
        match self {
            Spectrum::Constant(c) => c * (to_nm - from_nm).max(0.0),
            Spectrum::Table(p) => {
                let first = p.partition_point(|q| q.0 <= from_nm).saturating_sub(1);
                p[first..]
                    .windows(2)
                    .take_while(|w| w[0].0 < to_nm)
                    .map(|w| {
                        let (a, b) = (w[0].0.max(from_nm), w[1].0.min(to_nm));
                        let line = |nm: f64| w[0].1 + (w[1].1 - w[0].1) * (nm - w[0].0) / (w[1].0 - w[0].0);
                        if b > a { 0.5 * (line(a) + line(b)) * (b - a) } else { 0.0 }
                    })
                    .sum()
            }
        }
    }

    /// Exact integral of the product with `other` over from_nm..to_nm: both are linear between all breaks, where two Gauss
    /// nodes integrate up to cubics and never touch a table's end.
    ///
    /// ```
    /// # use luxpipe::spectral::Spectrum;
    /// let ramp = Spectrum::from_points(vec![(400.0, 0.0), (700.0, 3.0)]).unwrap();
    /// assert!((ramp.product_integral(&ramp, 0.0, 1e4) - 900.0).abs() < 1e-9);
    /// ```
    pub fn product_integral(&self, other: &Spectrum, from_nm: f64, to_nm: f64) -> f64 {
        gauss(&breaks(&[self, other], from_nm, to_nm), |nm| self.at(nm) * other.at(nm))
    }

    /// Mean over from_nm..to_nm (the part outside the table counts as zero).
    pub fn mean(&self, from_nm: f64, to_nm: f64) -> f64 {
        self.integral(from_nm, to_nm) / (to_nm - from_nm)
    }

    /// Every value times k.
    pub fn scaled(&self, k: f64) -> Spectrum {
        match self {
            Spectrum::Constant(c) => Spectrum::Constant(c * k),
            Spectrum::Table(p) => Spectrum::Table(p.iter().map(|(nm, v)| (*nm, v * k)).collect()),
        }
    }

    /// A function of every listed value.
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Spectrum {
        match self {
            Spectrum::Constant(c) => Spectrum::Constant(f(*c)),
            Spectrum::Table(p) => Spectrum::Table(p.iter().map(|(nm, v)| (*nm, f(*v))).collect()),
        }
    }

    /// A function of both at every wavelength: linear between their listed wavelengths and at most 5 nm, zero where either ends.
    pub fn combined(&self, other: &Spectrum, f: impl Fn(f64, f64) -> f64) -> Spectrum {
        const FINE_NM: f64 = 5.0;
        if let (Spectrum::Constant(a), Spectrum::Constant(b)) = (self, other) {
            return Spectrum::Constant(f(*a, *b));
        }
        let breaks = breaks(&[self, other], 1.0, 1e6);
        let mut nodes = Vec::new();
        for w in breaks.windows(2) {
            // Nobody asks for what lies far from light.
            let parts = if w[0] < 200.0 || w[1] > 3000.0 { 1.0 } else { ((w[1] - w[0]) / FINE_NM).ceil() };
            nodes.extend((0..parts as usize).map(|i| w[0] + (w[1] - w[0]) * i as f64 / parts));
        }
        nodes.extend(breaks.last());
        Spectrum::Table(nodes.into_iter().map(|nm| (nm, f(self.at(nm), other.at(nm)))).collect())
    }

    /// The same with its first and last value going on for ever, for quantities that do not end where their table does.
    pub fn extended(&self) -> Spectrum {
        let Spectrum::Table(points) = self else { return self.clone() };
        let (first, last) = (points[0], points[points.len() - 1]);
        let mut all = points.clone();
        if first.0 > 1.0 {
            all.insert(0, (1.0, first.1));
        }
        if last.0 < 1e6 {
            all.push((1e6, last.1));
        }
        Spectrum::Table(all)
    }

    /// Smallest and largest value.
    pub fn range(&self) -> (f64, f64) {
        match self {
            Spectrum::Constant(c) => (*c, *c),
            Spectrum::Table(p) => {
                p.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), q| (lo.min(q.1), hi.max(q.1)))
            }
        }
    }

    /// First and last wavelength that the table lists; everything for a constant.
    pub fn extent_nm(&self) -> (f64, f64) {
        match self {
            Spectrum::Constant(_) => (0.0, f64::INFINITY),
            Spectrum::Table(p) => (p[0].0, p[p.len() - 1].0),
        }
    }
}

/// Ends of the range and all listed wavelengths between them, ascending, where every spectrum has a value beyond zero.
pub fn breaks(spectra: &[&Spectrum], from_nm: f64, to_nm: f64) -> Vec<f64> {
    let (mut low, mut high) = (from_nm, to_nm);
    for s in spectra {
        let (a, b) = s.extent_nm();
        (low, high) = (low.max(a), high.min(b));
    }
    let mut breaks = vec![low, high];
    for s in spectra {
        if let Spectrum::Table(points) = s {
            breaks.extend(points.iter().map(|p| p.0).filter(|nm| *nm > low && *nm < high));
        }
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    if low < high { breaks } else { Vec::new() }
}

/// Integral of `f` by two Gauss nodes between each pair of breaks.
pub fn gauss(breaks: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let piece = |w: &[f64]| {
        let (middle, half) = (0.5 * (w[0] + w[1]), 0.5 * (w[1] - w[0]));
        let off = half / 3f64.sqrt();
        half * (f(middle - off) + f(middle + off))
    };
    breaks.windows(2).map(piece).sum()
}
