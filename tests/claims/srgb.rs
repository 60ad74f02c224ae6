//! Introduction: what sRGB holds.

use super::*;

/// White over black of a shipped display, light of the room included.
pub fn contrast(name: &str) -> f64 {
    let display: Display = name.parse().unwrap();
    display.white_cd_m2 / display.black_cd_m2
}

pub fn code_light(code: u32) -> f64 {
    srgb_decode(f64::from(code) / 255.0)
}

/// White over the darkest 8-bit code from which no code is further from the next than a step.
pub fn code_range(step: f64) -> f64 {
    let coarse = (1..255u32).rev().find(|k| code_light(k + 1) / code_light(*k) - 1.0 > step).unwrap();
    1.0 / code_light(coarse + 1)
}

/// Percent from the code at this range below white to the next.
pub fn step_below(range: f64) -> f64 {
    let code = (1..255u32).rev().find(|k| code_light(*k) <= 1.0 / range).unwrap();
    100.0 * (code_light(code + 1) / code_light(code) - 1.0)
}

/// The power nearest to the sRGB curve: least squares of its codes at 1001 even lights.
pub fn best_exponent() -> f64 {
    let light = |i: u32| f64::from(i) / 1000.0;
    let misfit =
        |gamma: f64| -> f64 { (0..=1000).map(|i| (srgb_encode(light(i)) - light(i).powf(1.0 / gamma)).powi(2)).sum() };
    (1800..=2800u32).map(light).min_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).unwrap()
}

pub fn cmf(nm: f64) -> Xyz {
    static OBSERVER: LazyLock<Observer> = LazyLock::new(|| Observer::cie1931().unwrap());
    OBSERVER.cmf.each_ref().map(|c| c.at(nm))
}

pub fn in_xy(c: Xyz) -> [f64; 2] {
    let sum = c[0] + c[1] + c[2];
    [c[0] / sum, c[1] / sum]
}

pub fn in_uv(c: Xyz) -> [f64; 2] {
    uv(c).unwrap()
}

/// Area of a polygon (the shoelace formula).
pub fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let twice: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    0.5 * twice.abs()
}

/// Percent of the area within the spectral locus (380 to 700 nm and the purples) that BT.709's triangle takes; numpy: 33.524 in xy,
/// 33.246 in u'v'.
pub fn share_of_locus(place: fn(Xyz) -> [f64; 2]) -> f64 {
    let triangle = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]].map(|[x, y]| place(Xy { x, y }.xyz()));
    let locus: Vec<[f64; 2]> = (380..=700u32).map(|nm| place(cmf(f64::from(nm)))).collect();
    100.0 * area(&triangle) / area(&locus)
}

/// Percent of the colours on Pointer's boundary that a display of these primaries shows.
pub fn surfaces_inside(primaries: Primaries) -> f64 {
    let display = Gamut::new(primaries).unwrap();
    let colours = gamut::sets::pointer().colours;
    100.0 * colours.iter().filter(|c| display.is_exact(**c)).count() as f64 / colours.len() as f64
}

/// Percent of the way in u'v' from D65 to light of one wavelength that BT.709 goes; numpy by crossing lines: 32.36 at 500 nm,
/// 53.62 at 420, 90.54 at 610.
pub fn reach(nm: f64) -> f64 {
    let (white, edge) = (in_uv(Xy::D65.xyz()), in_uv(cmf(nm)));
    let to_rgb = blueflower::c709();
    let fits = |t: f64| {
        let at = [0, 1].map(|i| white[i] + t * (edge[i] - white[i]));
        to_rgb.apply(uv_to_xyz(at, 1.0)).iter().all(|x| *x >= 0.0)
    };
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (inside + outside);
        if fits(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    100.0 * inside
}
