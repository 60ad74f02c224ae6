//! From a camera's channels to XYZ: a 3 x 3 matrix from a file, or fitted to a chart in the picture.
//!
//! A chart is TOML: rectangles of the upright picture and the colours that are there,
//!
//! ```toml
//! illuminant = "D50"                   # any spectrum: what the patches' reflectances were lit by
//! white_cd_m2 = 930                    # luminance of a perfect diffuser there, if it was measured: the picture is then absolute
//! [[patch]]
//! rect = [812, 440, 60, 60]            # x, y, width, height in pixels
//! spectrum = "cc_babel_01_dark_skin"   # a table of spectra/, a CSV beside this file, or pairs
//! [[patch]]
//! rect = [902, 440, 60, 60]
//! xyz = [112.4, 120.3, 88.1]           # cd/m2, read by an instrument; all patches or none
//! ```
//!
//! M minimises sum |M c - X|^2 / |X|^2, so that dark patches count as much as light ones. The camera's responses are not the observer's,
//! so the colours of other things are off by more than the patches are; the residual is told as CIEDE2000.

use std::path::Path;

use crate::color::difference::delta_e_2000;
use crate::color::{Mat3, Xy};
use crate::keys;
use crate::spectral::key::SpectrumKey;
use crate::spectral::{Observer, Spectrum};
use crate::{Error, Result, invalid};

/// Patches that a chart may have.
const MOST_PATCHES: usize = 4096;

/// A patch: where it is, and its colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// x, y, width, height in pixels of the upright picture.
    pub rect: [usize; 4],
    /// cd/m2, or relative to a perfect diffuser of 1.
    pub xyz: [f64; 3],
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// At least three.
    pub patches: Vec<Patch>,
    /// Colours are in cd/m2.
    pub absolute: bool,
    /// What lit it, if that was said: chromaticity and the XYZ of a perfect diffuser.
    pub white: Option<(Xy, [f64; 3])>,
}

/// What a chart tells of a camera.
#[derive(Clone, Debug)]
pub struct Fit {
    /// From the camera's channels to XYZ; of a relative chart white light of (1, 1, 1) has Y = 1.
    pub matrix: Mat3,
    /// Mean and largest CIEDE2000 of the patches, and which has the largest, from 1.
    pub errors: (f64, f64, usize),
}

/// Reads a chart; files of spectra lie in `folder`. Errors name line, column and key.
pub fn parse(text: &str, folder: &Path) -> Result<Chart> {
    let mut k = keys::parse(text)?;
    let light = match k.get_spanned::<SpectrumKey>("illuminant")? {
        None => None,
        Some((key, span)) => {
            let light = key.resolve(folder).map_err(|e| k.wrong_key("illuminant", span.clone(), &e.to_string()))?;
            let xyz = Observer::cie1931()?.integrate(&light);
            let white = Xy::of(xyz).ok_or_else(|| k.wrong_key("illuminant", span, "has no visible light"))?;
            Some((light, xyz[1], white))
        }
    };
    let white_cd_m2 = k.number("white_cd_m2", "must be above 0", |x| x > 0.0 && x < 1e9)?;
    let mut patches = Vec::new();
    let mut read = 0;
    for mut p in k.array("patch")? {
        let rect = p.need::<[usize; 4]>("rect")?;
        if rect[2] == 0 || rect[3] == 0 {
            return Err(p.wrong("rect: expected x, y, width and height, these above 0"));
        }
        let xyz = match (p.get::<[f64; 3]>("xyz")?, p.get_spanned::<SpectrumKey>("spectrum")?) {
            (Some(xyz), None) if xyz.iter().all(|x| *x >= 0.0 && *x < 1e9) && xyz[1] > 0.0 => {
                read += 1;
                xyz
            }
            (None, Some((key, span))) => {
                let Some((light, y, _)) = &light else {
                    return Err(p.wrong_key("spectrum", span, "needs the chart's illuminant"));
                };
                let spectrum = key.resolve(folder).map_err(|e| p.wrong_key("spectrum", span, &e.to_string()))?;
                reflected(light, &spectrum)?.map(|x| x / y * white_cd_m2.unwrap_or(1.0))
            }
            _ => return Err(p.wrong("expected xyz in cd/m2 with Y above 0, or a spectrum")),
        };
        p.finish()?;
        patches.push(Patch { rect, xyz });
    }
    if read > 0 && (read < patches.len() || white_cd_m2.is_some()) {
        return Err(k.wrong("patches have xyz or spectra, not some of each; white_cd_m2 is for spectra"));
    }
    if !(3..=MOST_PATCHES).contains(&patches.len()) {
        return Err(k.wrong(&format!("has {} [[patch]]; expected 3 to {MOST_PATCHES}", patches.len())));
    }
    k.finish()?;
    let white = light.map(|(_, _, xy)| (xy, xy.xyz().map(|x| x * white_cd_m2.unwrap_or(1.0))));
    Ok(Chart { patches, absolute: read > 0 || white_cd_m2.is_some(), white })
}

/// XYZ of a light that a surface throws back, without the factor 683.
fn reflected(light: &Spectrum, reflectance: &Spectrum) -> Result<[f64; 3]> {
    let xyz = Observer::cie1931()?.integrate(&light.combined(reflectance, |a, b| a * b));
    if xyz[1] > 0.0 { Ok(xyz) } else { invalid!("a patch throws no visible light back") }
}

/// The matrix that takes the camera's mean channels of each patch to its colour.
pub fn fit(chart: &Chart, channels: &[[f64; 3]]) -> Result<Fit> {
    let (mut colours, mut own) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    for (patch, c) in chart.patches.iter().zip(channels) {
        let weight = 1.0 / patch.xyz.iter().map(|x| x * x).sum::<f64>();
        for i in 0..3 {
            for j in 0..3 {
                colours[i][j] += weight * patch.xyz[i] * c[j];
                own[i][j] += weight * c[i] * c[j];
            }
        }
    }
    let inverse = Mat3(own).inverse().ok_or_else(|| {
        Error::Invalid("the patches are all of one or two colours to the camera; expected three or more".into())
    })?;
    let matrix = Mat3(colours).times(&inverse);
    let brightest = chart.patches.iter().map(|p| p.xyz).max_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or([1.0; 3]);
    let white = chart.white.map_or(brightest, |w| w.1);
    let off: Vec<f64> =
        chart.patches.iter().zip(channels).map(|(p, c)| delta_e_2000(matrix.apply(*c), p.xyz, white)).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let (worst, most) = off.iter().enumerate().fold((0, 0.0), |m, (i, d)| if *d > m.1 { (i, *d) } else { m });
    let y = matrix.apply([1.0; 3])[1];
    if y.is_nan() || y <= 0.0 {
        return invalid!("fits no camera: white light would have the luminance {y}; are the patches in order?");
    }
    let matrix = if chart.absolute { matrix } else { matrix.scaled(1.0 / y) };
    Ok(Fit { matrix, errors: (mean, most, worst + 1) })
}

/// A 3 x 3 matrix as text: three lines of three numbers, '#' before remarks.
pub fn parse_matrix(text: &str) -> Result<Mat3> {
    let words = text.lines().filter(|l| !l.trim_start().starts_with('#')).flat_map(|l| l.split([' ', '\t', ',']));
    let numbers: Option<Vec<f64>> =
        words.filter(|w| !w.is_empty()).map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    let Some([a, b, c, d, e, f, g, h, i]) = numbers.as_deref() else {
        return invalid!("expected nine numbers, three rows that make X, Y and Z of red, green and blue");
    };
    let m = Mat3([[*a, *b, *c], [*d, *e, *f], [*g, *h, *i]]);
    match m.inverse() {
        Some(_) if m.apply([1.0; 3])[1] > 0.0 => Ok(m),
        _ => invalid!("expected a matrix that has an inverse and makes white light of a luminance above 0"),
    }
}

/// The text that [`parse_matrix`] reads.
pub fn matrix_text(m: &Mat3) -> String {
    m.0.iter().map(|r| format!("{:.9} {:.9} {:.9}\n", r[0], r[1], r[2])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: &str = "illuminant = 'D65'\n[[patch]]\nrect = [0, 0, 2, 2]\nspectrum = 'cc_babel_15_red'\n\
        [[patch]]\nrect = [2, 0, 2, 2]\nspectrum = 'cc_babel_14_green'\n\
        [[patch]]\nrect = [4, 0, 2, 2]\nspectrum = 'cc_babel_13_blue'\n\
        [[patch]]\nrect = [6, 0, 2, 2]\nspectrum = 'cc_babel_19_white_9_5'\n";

    /// A camera that is a matrix is found exactly, whatever the scale of its channels.
    #[test]
    fn a_linear_camera_comes_back() {
        let chart = parse(CHART, Path::new("")).unwrap();
        assert!(!chart.absolute && chart.white.unwrap().0.distance(Xy::D65) < 1e-3);
        let camera = Mat3([[0.6, 0.3, 0.1], [0.2, 0.7, 0.1], [0.05, 0.15, 0.8]]);
        let channels: Vec<[f64; 3]> = chart.patches.iter().map(|p| camera.apply(p.xyz.map(|x| 40.0 * x))).collect();
        let Fit { matrix, errors } = fit(&chart, &channels).unwrap();
        let back = matrix.times(&camera);
        assert!(errors.0 < 1e-6 && (matrix.apply([1.0; 3])[1] - 1.0).abs() < 1e-12, "{errors:?}");
        for i in 0..3 {
            for j in 0..3 {
                let want = if i == j { back.0[0][0] } else { 0.0 };
                assert!((back.0[i][j] - want).abs() < 1e-9);
            }
        }
        assert_eq!(parse_matrix(&matrix_text(&camera)).unwrap(), camera);
        assert!(fit(&chart, &[[1.0, 1.0, 1.0]; 4]).is_err());
    }

    #[test]
    fn absolute_charts_and_wrong_ones() {
        let lit = format!("white_cd_m2 = 500\n{CHART}");
        let chart = parse(&lit, Path::new("")).unwrap();
        assert!(chart.absolute && chart.patches[3].xyz[1] > 400.0 && chart.patches[3].xyz[1] < 500.0);
        for (text, word) in [
            ("", "has 0 [[patch]]"),
            ("[[patch]]\nrect = [0, 0, 1, 1]\nspectrum = 'cc_babel_15_red'", "illuminant"),
            ("[[patch]]\nrect = [0, 0, 0, 1]\nxyz = [1, 1, 1]", "above 0"),
            ("[[patch]]\nrect = [0, 0, 1, 1]\nxyz = [1, 0, 1]", "Y above 0"),
            (&format!("{CHART}[[patch]]\nrect = [0, 0, 1, 1]\nxyz = [1, 1, 1]"), "not some of each"),
        ] {
            let message = parse(text, Path::new("")).unwrap_err().to_string();
            assert!(message.contains(word) && message.starts_with("line "), "{message}");
        }
        assert!(parse_matrix("1 0 0 0 1 0 0 0 0").is_err() && parse_matrix("1 2").is_err());
    }
}
