//! Uniform colour spaces and colour differences: CIELAB, CIELUV [CIE15], Oklab [Ottosson 2020], CIEDE2000 [Sharma 2005].
//!
//! All take XYZ and the white's XYZ in the same unit; the white's Y is what L* = 100 stands for.

/// CIELAB L*, a*, b*.
///
/// ```
/// use luxpipe::color::difference::lab;
/// let w = [0.9505, 1.0, 1.0891];
/// assert_eq!(lab(w, w), [100.0, 0.0, 0.0]);
/// assert!((lab([0.18, 0.18, 0.18], w)[0] - 49.496).abs() < 1e-3);
/// ```
pub fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = [0, 1, 2].map(|i| root(xyz[i] / white[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The cube root, and below (6/29)^3 a line that meets it.
fn root(t: f64) -> f64 {
    if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * 841.0 / 108.0 + 4.0 / 29.0 }
}

/// XYZ of a CIELAB colour.
pub fn lab_to_xyz(lab: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let g = |t: f64| if t > 6.0 / 29.0 { t.powi(3) } else { (t - 4.0 / 29.0) * 108.0 / 841.0 };
    let y = (lab[0] + 16.0) / 116.0;
    let parts = [y + lab[1] / 500.0, y, y - lab[2] / 200.0];
    [0, 1, 2].map(|i| white[i] * g(parts[i]))
}

/// CIE 1976 chromaticity u', v'; the white's own for black.
pub fn uv(xyz: [f64; 3]) -> Option<[f64; 2]> {
    let sum = xyz[0] + 15.0 * xyz[1] + 3.0 * xyz[2];
    (sum > 0.0).then(|| [4.0 * xyz[0] / sum, 9.0 * xyz[1] / sum])
}

/// XYZ of a u', v' chromaticity at luminance Y.
pub fn uv_to_xyz([u, v]: [f64; 2], y: f64) -> [f64; 3] {
    [y * 2.25 * u / v, y, y * (3.0 - 0.75 * u - 5.0 * v) / v]
}

/// CIELUV L*, u*, v*.
pub fn luv(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    luv_at(116.0 * root(xyz[1] / white[1]) - 16.0, xyz, white)
}

/// CIELUV of a colour whose L* is known, from CIELAB for instance.
pub fn luv_at(l: f64, xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let Some(w) = uv(white) else { return [l, 0.0, 0.0] };
    let [u, v] = uv(xyz).unwrap_or(w);
    [l, 13.0 * l * (u - w[0]), 13.0 * l * (v - w[1])]
}

/// Euclidean distance: CIE 1976 differences of CIELAB or CIELUV colours.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

/// Delta E*uv of two colours under one white, the metric of the paper.
pub fn delta_e_uv(a: [f64; 3], b: [f64; 3], white: [f64; 3]) -> f64 {
    distance(luv(a, white), luv(b, white))
}

/// Delta E*ab of 1976.
pub fn delta_e_ab(a: [f64; 3], b: [f64; 3], white: [f64; 3]) -> f64 {
    distance(lab(a, white), lab(b, white))
}

/// Delta E 2000 of two colours under one white.
pub fn delta_e_2000(a: [f64; 3], b: [f64; 3], white: [f64; 3]) -> f64 {
    ciede2000(lab(a, white), lab(b, white))
}

/// CIEDE2000 of two CIELAB colours, all parametric factors 1.
///
/// ```
/// let d = luxpipe::color::difference::ciede2000([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485]);
/// assert!((d - 2.0425).abs() < 5e-5);
/// ```
pub fn ciede2000(p: [f64; 3], q: [f64; 3]) -> f64 {
    let length = |a: f64, b: f64| (a * a + b * b).sqrt();
    let chroma = |c: [f64; 3]| length(c[1], c[2]);
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - seventh(0.5 * (chroma(p) + chroma(q))));
    let polar = |c: [f64; 3]| {
        let a = (1.0 + g) * c[1];
        let hue = if a == 0.0 && c[2] == 0.0 { 0.0 } else { c[2].atan2(a).to_degrees().rem_euclid(360.0) };
        (c[0], length(a, c[2]), hue)
    };
    let ((l1, c1, h1), (l2, c2, h2)) = (polar(p), polar(q));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * (turn / 2.0).to_radians().sin();
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let h = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
        sum if sum < 360.0 => 0.5 * (sum + 360.0),
        sum => 0.5 * (sum - 360.0),
    };
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0) - 0.20 * cos(4.0 * h - 63.0);
    let rotation = -2.0 * seventh(c) * (60.0 * (-((h - 275.0) / 25.0).powi(2)).exp()).to_radians().sin();
    let off = (l - 50.0).powi(2);
    let (sl, sc, sh) = (1.0 + 0.015 * off / (20.0 + off).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let (l, c, h) = (dl / sl, dc / sc, dh / sh);
    (l * l + c * c + h * h + rotation * c * h).max(0.0).sqrt()
}

/// Oklab L, a, b of XYZ under D65 with white at Y = 1.
///
/// ```
/// let w = luxpipe::color::difference::oklab([0.950, 1.0, 1.089]);
/// assert!((w[0] - 1.0).abs() < 1e-3 && w[1].abs() < 1e-3 && w[2].abs() < 1e-3);
/// ```
pub fn oklab(xyz: [f64; 3]) -> [f64; 3] {
    let lms = OKLAB_M1.map(|r| (r[0] * xyz[0] + r[1] * xyz[1] + r[2] * xyz[2]).cbrt());
    OKLAB_M2.map(|r| r[0] * lms[0] + r[1] * lms[1] + r[2] * lms[2])
}

/// XYZ to Oklab's cone-like responses [Ottosson 2020].
pub const OKLAB_M1: [[f64; 3]; 3] = [
    [0.8189330101, 0.3618667424, -0.1288597137],
    [0.0329845436, 0.9293118715, 0.0361456387],
    [0.0482003018, 0.2643662691, 0.6338517070],
];

/// Their cube roots to Oklab.
pub const OKLAB_M2: [[f64; 3]; 3] = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_34_published_pairs_of_ciede2000() {
        let text = include_str!("../../tests/ref/ciede2000.csv");
        let rows: Vec<Vec<f64>> = text
            .lines()
            .filter(|l| !l.starts_with(['#', 'L']))
            .map(|l| l.split(',').map(|n| n.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows.len(), 34);
        for r in rows {
            let got = ciede2000([r[0], r[1], r[2]], [r[3], r[4], r[5]]);
            assert!((got - r[6]).abs() < 1e-4, "{r:?}: {got}");
        }
    }

    proptest! {
        #[test]
        fn lab_and_uv_come_back(x in 0.0f64..2.0, y in 1e-6f64..2.0, z in 0.0f64..2.0) {
            let white = [0.9505, 1.0, 1.089];
            let back = lab_to_xyz(lab([x, y, z], white), white);
            prop_assert!(distance(back, [x, y, z]) < 1e-12);
            let chroma = uv([x, y, z]).unwrap();
            prop_assert!(distance(uv_to_xyz(chroma, y), [x, y, z]) < 1e-9 * (1.0 + (x + z) / y));
        }
    }
}
