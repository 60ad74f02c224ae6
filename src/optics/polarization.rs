//! Polarization: Stokes vectors and Mueller matrices.
//!
//! A Stokes vector (I, Q, U, V) belongs to a frame: x at right angles to the direction k in which light travels, y = k x x. Seen
//! by the receiver (looking towards the source) with x to the right, y is up: Q > 0 swings along x, U > 0 along the line 45 degrees
//! counter-clockwise from it, V > 0 turns clockwise. In terms of the field, with exp(-i w t): Q = |Ex|^2 - |Ey|^2,
//! U + iV = 2 Ex conj(Ey).

use num_complex::Complex64;

/// What a surface does to light by its plane of incidence alone: amplitudes for s and p light, as the four products that can be
/// seen. Sums of responses are those of light that does not interfere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Share of s light that is passed on.
    pub s: f64,
    /// Share of p light.
    pub p: f64,
    /// Amplitude of s times the conjugate one of p.
    pub cross: Complex64,
}

impl Response {
    /// By the amplitudes, `power` times their squares.
    pub fn of(s: Complex64, p: Complex64, power: f64) -> Response {
        Response { s: power * s.norm_sqr(), p: power * p.norm_sqr(), cross: s * p.conj() * power }
    }

    /// Times a number.
    pub fn scaled(self, k: f64) -> Response {
        Response { s: self.s * k, p: self.p * k, cross: self.cross * k }
    }

    /// Side by side with another, without interference.
    pub fn plus(self, o: Response) -> Response {
        Response { s: self.s + o.s, p: self.p + o.p, cross: self.cross + o.cross }
    }

    /// One after the other.
    pub fn then(self, o: Response) -> Response {
        Response { s: self.s * o.s, p: self.p * o.p, cross: self.cross * o.cross }
    }

    /// Share of unpolarised light.
    pub fn mean(&self) -> f64 {
        0.5 * (self.s + self.p)
    }

    /// The matrix over its first number, by which `mean` is left out: [`Diattenuation`]; nothing is kept where nothing comes.
    pub fn relative(&self) -> Diattenuation {
        let sum = self.s + self.p;
        if sum <= 0.0 {
            return Diattenuation::default();
        }
        let a = (self.s - self.p) / sum;
        Diattenuation { a: a as f32, b: (2.0 * self.cross.re / sum) as f32, c: (2.0 * self.cross.im / sum) as f32 }
    }

    /// The Mueller matrix in the frame of s.
    ///
    /// ```
    /// use luxpipe::optics::polarization::Response;
    /// // An ideal polariser: half of unpolarised light, all of it along s.
    /// let ideal = Response { s: 1.0, ..Response::default() };
    /// assert_eq!(ideal.mueller()[0], [0.5, 0.5, 0.0, 0.0]);
    /// ```
    pub fn mueller(&self) -> [[f64; 4]; 4] {
        let (mean, half) = (self.mean(), 0.5 * (self.s - self.p));
        let Complex64 { re, im } = self.cross;
        [[mean, half, 0.0, 0.0], [half, mean, 0.0, 0.0], [0.0, 0.0, re, -im], [0.0, 0.0, im, re]]
    }
}

/// A Mueller matrix over its first number, in the frame of s: [[1 a 0 0] [a 1 0 0] [0 0 b -c] [0 0 c b]].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diattenuation {
    /// What polarises.
    pub a: f32,
    /// What is left of U and V.
    pub b: f32,
    /// What turns U into V.
    pub c: f32,
}

impl Diattenuation {
    /// What becomes of a Stokes vector.
    #[inline(always)]
    pub fn apply(&self, [i, q, u, v]: [f32; 4]) -> [f32; 4] {
        let Diattenuation { a, b, c } = *self;
        [i + a * q, a * i + q, b * u - c * v, c * u + b * v]
    }
}

/// Sine and cosine of twice the angle by which a Stokes vector's frame is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Cosine of twice the angle.
    pub cos2: f32,
    /// Its sine.
    pub sin2: f32,
}

impl Rotation {
    /// None.
    pub const NONE: Rotation = Rotation { cos2: 1.0, sin2: 0.0 };

    /// From a frame with the unit axis `from` to one with `to`, light travelling along `k`; counter-clockwise for the receiver.
    /// Any turn will do where an axis has no length.
    pub fn between(from: glam::Vec3A, to: glam::Vec3A, k: glam::Vec3A) -> Rotation {
        let (cos, sin) = (from.dot(to), k.cross(from).dot(to));
        let length2 = cos * cos + sin * sin;
        if length2 < 1e-12 {
            return Rotation::NONE;
        }
        Rotation { cos2: (cos * cos - sin * sin) / length2, sin2: 2.0 * cos * sin / length2 }
    }

    /// A Stokes vector in the turned frame.
    ///
    /// ```
    /// use luxpipe::optics::polarization::Rotation;
    /// // Seen from a frame turned by 45 degrees towards it, light along the diagonal lies along x.
    /// let turn = Rotation { cos2: 0.0, sin2: 1.0 };
    /// assert_eq!(turn.apply([1.0, 0.0, 1.0, 0.0]), [1.0, 1.0, 0.0, 0.0]);
    /// ```
    #[inline(always)]
    pub fn apply(&self, [i, q, u, v]: [f32; 4]) -> [f32; 4] {
        [i, self.cos2 * q + self.sin2 * u, self.cos2 * u - self.sin2 * q, v]
    }
}

/// A sheet that acts by an axis of its own: `along` and `across` it shares of the power, and the phase of the one before the
/// other.
///
/// ```
/// use luxpipe::optics::polarization::sheet;
/// // A quarter wave with its fast axis along x turns light along the diagonal into circular light.
/// let m = sheet(1.0, 1.0, std::f64::consts::FRAC_PI_2).mueller();
/// assert!((m[3][2].abs() - 1.0).abs() < 1e-12 && m[2][2].abs() < 1e-12);
/// ```
pub fn sheet(along: f64, across: f64, retardance_rad: f64) -> Response {
    // The fast axis is ahead: its phase exp(i k d n) is smaller.
    let fast = Complex64::from_polar(along.sqrt(), -retardance_rad);
    Response::of(fast, Complex64::from(across.sqrt()), 1.0)
}

/// Degree of polarization of unpolarised light that a molecule has scattered by an angle, sin^2 / (1 + cos^2) [Rayleigh].
///
/// ```
/// use luxpipe::optics::polarization::rayleigh;
/// assert!((rayleigh(30f64.to_radians().cos()) - 0.14285714).abs() < 1e-8 && rayleigh(0.0) == 1.0);
/// ```
pub fn rayleigh(cos: f64) -> f64 {
    (1.0 - cos * cos) / (1.0 + cos * cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    /// Malus' law by turning frames; crossed polarisers with a third between them.
    #[test]
    fn polarisers_in_a_row() {
        let pass = |[i, q, u, v]: [f32; 4], deg: f32| {
            let turn = Rotation { cos2: (2.0 * deg.to_radians()).cos(), sin2: (2.0 * deg.to_radians()).sin() };
            let back = Rotation { sin2: -turn.sin2, ..turn };
            let [i, q, ..] = turn.apply([i, q, u, v]);
            back.apply([0.5 * (i + q), 0.5 * (i + q), 0.0, 0.0])
        };
        let first = pass([1.0, 0.0, 0.0, 0.0], 0.0);
        for (deg, want) in [(0.0, 0.5), (15.0, 0.46650635), (30.0, 0.375), (60.0, 0.125), (90.0, 0.0)] {
            assert!((pass(first, deg)[0] - want).abs() < 1e-6, "{deg}");
        }
        assert!((pass(pass(first, 45.0), 90.0)[0] - 0.125).abs() < 1e-6);
    }

    /// A frame turned there and back is the same; the sense of the turn is the receiver's.
    #[test]
    fn frames_turn_back() {
        let k = Vec3A::Z;
        let to = Vec3A::new(30f32.to_radians().cos(), 30f32.to_radians().sin(), 0.0);
        let there = Rotation::between(Vec3A::X, to, k);
        assert!((there.cos2 - 0.5).abs() < 1e-6 && (there.sin2 - 3f32.sqrt() / 2.0).abs() < 1e-6);
        let got = Rotation::between(to, Vec3A::X, k).apply(there.apply([1.0, 0.3, -0.4, 0.5]));
        for (got, want) in got.iter().zip([1.0f32, 0.3, -0.4, 0.5]) {
            assert!((got - want).abs() < 1e-6);
        }
    }
}
