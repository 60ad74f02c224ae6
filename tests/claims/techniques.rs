//! Tone mapping: intents and techniques.

use super::*;

/// Percent of the pixels of a stage under coloured lamps that BT.709 cannot show as they are (docs/gamut.md).
pub fn colorimetric_moves() -> f64 {
    let wanted = gamut::sets::picture().colours;
    let shown = gamut::methods::shown("--intent colorimetric", Primaries::BT709, &wanted);
    gamut::errors::Errors::of(&wanted, &shown).moved
}

/// Light of 450 to 650 nm with 0, 50 and 90 % white, so dark that every chromaticity of BT.709 fits.
pub fn lamps() -> Vec<Xyz> {
    let paler = |nm: i32| [0.0, 0.5, 0.9].map(|white| gamut::sets::mixed(f64::from(nm), white, 0.02));
    (450..=650).step_by(10).flat_map(paler).collect()
}

pub fn lamps_as_rgb(options: &str) -> Vec<Xyz> {
    let command: Vec<&str> = ["xyz2rgb"].into_iter().chain(options.split(' ')).collect();
    through(&command, &picture(DISPLAY, lamps().len(), &lamps()))
}

/// Share of their saturation in u'v' that these colours keep.
pub fn kept(options: &str) -> Vec<f64> {
    let to_xyz = Primaries::BT709.to_xyz().unwrap();
    let white = in_uv(Xy::D65.xyz());
    let saturation = |c: Xyz| {
        let at = in_uv(c);
        (at[0] - white[0]).hypot(at[1] - white[1])
    };
    let share = |(rgb, wanted): (Xyz, Xyz)| saturation(to_xyz.apply(rgb)) / saturation(wanted);
    lamps_as_rgb(options).into_iter().zip(lamps()).map(share).collect()
}

/// Largest difference of RGB, white at 1, between technique B with its knee at the edge and clipping of saturation.
pub fn knee_1_is_clipping() -> f64 {
    let [bent, clipped] = ["--gamut compress --knee 1", "--gamut desaturate"].map(lamps_as_rgb);
    apart(bent.as_flattened(), clipped.as_flattened())
}

/// What pcond shows for 100 cd/m2 in a picture of other luminances.
pub fn shown_100(range: [f64; 2]) -> f64 {
    let others = evenly(range, 63 * 64).into_iter().map(neutral);
    let colours: Vec<Xyz> = std::iter::repeat_n(neutral(100.0), 64).chain(others).collect();
    through(&["pcond"], &picture(CD_M2, 64, &colours))[0][1]
}

/// What is shown for 100 cd/m2 within 10 cd/m2, over what is shown for the same within 1000 cd/m2 of the same picture.
pub fn two_surrounds(command: &[&str]) -> f64 {
    let inside = |x: usize, row: usize| (28..36).contains(&row) && (28..36).contains(&(x % 64));
    let luminance = |i: usize| match (i % 128, i / 128) {
        (x, row) if inside(x, row) => 100.0,
        (x, _) if x < 64 => 10.0,
        _ => 1000.0,
    };
    let colours: Vec<Xyz> = (0..128 * 64).map(|i| neutral(luminance(i))).collect();
    let shown = through(command, &picture(CD_M2, 128, &colours));
    shown[32 * 128 + 32][1] / shown[32 * 128 + 96][1]
}
