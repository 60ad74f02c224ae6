//! 3 x 3 matrices in double precision, and their application to rows of pixels.

use crate::simd::{self, GROUP, padded};

/// A 3 x 3 matrix, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat3(pub [[f64; 3]; 3]);

impl Mat3 {
    /// The identity.
    pub const IDENTITY: Mat3 = Mat3::diagonal([1.0, 1.0, 1.0]);

    /// diag(d)
    pub const fn diagonal(d: [f64; 3]) -> Mat3 {
        Mat3([[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]])
    }

    /// self x v
    pub fn apply(&self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }

    /// self x other
    pub fn times(&self, other: &Mat3) -> Mat3 {
        let column = |j: usize| self.apply([other.0[0][j], other.0[1][j], other.0[2][j]]);
        let c = [column(0), column(1), column(2)];
        Mat3([0, 1, 2].map(|i| [c[0][i], c[1][i], c[2][i]]))
    }

    /// Every entry times k.
    pub fn scaled(&self, k: f64) -> Mat3 {
        Mat3(self.0.map(|r| r.map(|x| x * k)))
    }

    /// The inverse; `None` when the matrix is singular to working precision.
    ///
    /// ```
    /// use luxpipe::color::Mat3;
    /// let m = Mat3([[2.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]]);
    /// assert_eq!(m.times(&m.inverse().unwrap()), Mat3::IDENTITY);
    /// ```
    pub fn inverse(&self) -> Option<Mat3> {
        let [a, b, c] = self.0;
        let cross = |u: [f64; 3], v: [f64; 3]| {
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        };
        let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
        let det = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
        let size = self.0.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        if det.is_nan() || det.abs() <= 1e-12 * size.powi(3) {
            return None;
        }
        Some(Mat3([0, 1, 2].map(|i| [bc[i] / det, ca[i] / det, ab[i] / det])))
    }

    /// The entries as f32, for pixels.
    pub fn to_f32(&self) -> [[f32; 3]; 3] {
        self.0.map(|r| r.map(|x| x as f32))
    }
}

/// m x v of one pixel.
#[inline(always)]
pub fn multiply(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// Hands pixel-interleaved triples to `f` as planes of [`GROUP`] values, a short last group padded with zeros.
///
/// `f` is compiled for the widest instruction set; it must be inlineable. `triples.len()` is a multiple of 3.
#[inline(always)]
pub fn for_planes(triples: &mut [f32], f: impl Fn(&mut [[f32; GROUP]; 3])) {
    simd::wide(
        #[inline(always)]
        || {
            let (groups, rest) = triples.as_chunks_mut();
            for group in groups {
                let mut planes = split(group);
                f(&mut planes);
                *group = join(&planes);
            }
            if !rest.is_empty() {
                let mut planes = split(&padded(rest));
                f(&mut planes);
                rest.copy_from_slice(&join(&planes)[..rest.len()]);
            }
        },
    )
}

/// Pixel-interleaved triples as planes.
#[inline(always)]
fn split(group: &[f32; 3 * GROUP]) -> [[f32; GROUP]; 3] {
    let mut planes = [[0f32; GROUP]; 3];
    for i in 0..GROUP {
        planes[0][i] = group[3 * i];
        planes[1][i] = group[3 * i + 1];
        planes[2][i] = group[3 * i + 2];
    }
    planes
}

/// Planes as pixel-interleaved triples.
#[inline(always)]
fn join(planes: &[[f32; GROUP]; 3]) -> [f32; 3 * GROUP] {
    let mut group = [0f32; 3 * GROUP];
    for i in 0..GROUP {
        group[3 * i] = planes[0][i];
        group[3 * i + 1] = planes[1][i];
        group[3 * i + 2] = planes[2][i];
    }
    group
}

/// One plane each of m x p, without touching `p`.
#[inline(always)]
pub fn multiply_planes(m: &[[f32; 3]; 3], p: &[[f32; GROUP]; 3]) -> [[f32; GROUP]; 3] {
    let mut out = [[0f32; GROUP]; 3];
    for (row, plane) in m.iter().zip(&mut out) {
        for i in 0..GROUP {
            plane[i] = row[0] * p[0][i] + row[1] * p[1][i] + row[2] * p[2][i];
        }
    }
    out
}

/// Multiplies every triple of a row block by `m`, in place.
pub fn multiply_rows(m: &[[f32; 3]; 3], triples: &mut [f32]) {
    for_planes(
        triples,
        #[inline(always)]
        |p| *p = multiply_planes(m, p),
    );
}

/// The matrix over a power of two that no row's sum exceeds, and that power: the terms of a finite colour cannot overflow
/// against each other.
pub fn over_largest_sum(m: &[[f32; 3]; 3]) -> ([[f32; 3]; 3], f32) {
    let rows = m.map(|r| r.iter().map(|x| x.abs()).sum::<f32>());
    let scale = rows.iter().fold(1.0, |most: f32, x| most.max(*x)).log2().ceil().exp2();
    (m.map(|r| r.map(|x| x / scale)), scale)
}

/// Colours up to this are far from overflow under any matrix of colours.
const TAME: f32 = 1e30;

/// The same, a finite colour never becoming infinite or NaN: the sums are taken over a power of two that none exceeds, and
/// what is too large for a float is the largest one.
pub fn multiply_rows_finite(m: &[[f32; 3]; 3], triples: &mut [f32]) {
    if simd::all_within(triples, TAME) {
        return multiply_rows(m, triples);
    }
    let (m, scale) = over_largest_sum(m);
    let top = f32::MAX / scale;
    for_planes(
        triples,
        #[inline(always)]
        |p| {
            *p = multiply_planes(&m, p);
            for plane in p.iter_mut() {
                for x in plane {
                    // Infinities and NaN that came in stay what they are.
                    let held = if *x > top {
                        top
                    } else if *x < -top {
                        -top
                    } else {
                        *x
                    };
                    *x = if x.is_finite() { held * scale } else { *x };
                }
            }
        },
    );
}
