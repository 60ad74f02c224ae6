//! Introduction: records of light.

use super::*;

/// Bits by which a pixel lengthens a file; four across, too few for run lengths.
pub fn bits_a_pixel(name: &str, options: &[&str]) -> f64 {
    let size = |rows: usize| {
        let input = picture(CD_M2, 4, &vec![neutral(1.0); 4 * rows]);
        stdout_of(name, &[options, &["--quiet"]].concat(), &input).len()
    };
    8.0 * (size(90) - size(10)) as f64 / (4.0 * 80.0)
}

/// Largest error in percent of the largest component, of the locus and paler colours by way of BT.709 without any gamut mapping.
pub fn primaries_lose() -> f64 {
    let paler = |nm: i32| [0.0, 0.3, 0.7].map(|white| gamut::sets::mixed(f64::from(nm), white, 1.0));
    let colours: Vec<Xyz> = (400..=700).step_by(5).flat_map(paler).collect();
    let rgb = stdout_of("xyz2rgb", &["--quiet"], &picture(CD_M2, colours.len(), &colours));
    assert!(triples(&rgb).as_flattened().iter().any(|x| *x < 0.0), "nothing outside");
    let back = through(&["xyz2rgb", "-r"], &rgb);
    let error = |(a, b): (&Xyz, &Xyz)| 100.0 * apart(a, b) / largest(a);
    largest(&colours.iter().zip(&back).map(error).collect::<Vec<_>>())
}

/// The bytes of a pixel's four planes.
pub fn logluv_32_bits() -> f64 {
    let mut planes = Planes::default();
    encode_32(&[0.3, 0.4, 0.5], 1.0, &mut planes, &mut Losses::default());
    8.0 * planes.iter().map(Vec::len).sum::<usize>() as f64
}
