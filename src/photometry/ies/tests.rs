use std::f64::consts::PI;

use super::*;

fn file(name: &str) -> Photometry {
    let path = format!("{}/tests/data/ies/{name}.ies", env!("CARGO_MANIFEST_DIR"));
    Photometry::parse(&std::fs::read(path).unwrap()).unwrap()
}

/// A file of one horizontal angle and intensities at 0, 90, 180 degrees.
fn small(head: &str, second: &str, units: &str, candela: &str) -> String {
    format!("{head}TILT=NONE\n1 1000 2 3 1 1 {units} 1 2 0\n0.9 {second} 10\n0 90 180\n0\n{candela}\n")
}

fn error(text: &str) -> String {
    Photometry::parse(text.as_bytes()).unwrap_err().to_string()
}

/// pi I0 of a Lambertian, less what linear interpolation between cosines 2.5 degrees apart loses: h^2 / 12 of it, and the
/// rounding of the file to 0.01 cd.
#[test]
fn a_lambertian_gives_its_flux() {
    let lamp = file("lambertian");
    let step = 2.5f64.to_radians();
    let want = 1000.0 * (1.0 - step * step / 12.0);
    assert!((lamp.flux_lm() / want - 1.0).abs() < 1e-5, "{}", lamp.flux_lm());
    assert!((lamp.at(60.0, 123.0) - 500.0 / PI).abs() < 0.005);
    assert_eq!((lamp.at(90.5, 0.0), lamp.intensity([0.1, 0.2, 0.3])), (0.0, 0.0));
    assert_eq!(lamp.opening_m, [0.6, 0.6, 0.0]);
    assert_eq!(lamp.lamps, Some((1.0, 1000.0)));
    assert_eq!(lamp.keyword("LUMINAIRE"), Some("Lambertian downlight, 1000 lm square opening of 0.6 m"));
}

/// Four quadrants alike, absolute photometry; the formula's flux is 2 pi 800 (0.6 / 2 + 2.4 x 0.7 / 4).
#[test]
fn a_quadrant_is_unfolded() {
    let lamp = file("batwing");
    assert_eq!((lamp.edition, lamp.lamps, lamp.watts), (Edition::Y2019, None, 30.0));
    assert!((lamp.flux_lm() / (2.0 * PI * 800.0 * 0.72) - 1.0).abs() < 1e-3, "{}", lamp.flux_lm());
    let formula = |v: f64, h: f64| 800.0 * v.cos() * (0.6 + 2.4 * v.sin().powi(2) * (0.4 + 0.6 * h.sin().powi(2)));
    for h in [0.0, 30.0, 90.0, 150.0, 180.0, 210.0, 270.0, 330.0, 360.0, -30.0, 750.0] {
        for v in [0.0, 20.0, 45.0, 75.0] {
            assert!((lamp.at(v, h) - formula(f64::to_radians(v), f64::to_radians(h))).abs() < 0.006, "{v} {h}");
        }
    }
    // Most light across the luminaire, which lies along x.
    assert!(lamp.intensity([0.0, 0.7, -0.7]) > 1.5 * lamp.intensity([0.7, 0.0, -0.7]));
}

/// All around, no symmetry; between the angles, Radiance's ies2rad and rtrace say the same of this file (100 m away, by
/// `-I -dj 0 -ds 0`, times 179 x 10^4).
#[test]
fn a_lopsided_one_lies_as_in_radiance() {
    let lamp = file("skew");
    assert_eq!(lamp.edition, Edition::Y1986);
    assert!((lamp.flux_lm() / (500.0 * PI) - 1.0).abs() < 5e-4, "{}", lamp.flux_lm());
    let radiance = [
        (40.0, 30.0, 579.982),
        (40.0, 120.0, 383.022),
        (25.0, 75.0, 561.078),
        (61.0, 215.0, 74.180),
        (33.3, 305.5, 435.337),
    ];
    for (v, h, want) in radiance {
        let (v, h): (f64, f64) = (f64::to_radians(v), f64::to_radians(h));
        let got = lamp.intensity([v.sin() * h.cos(), v.sin() * h.sin(), -v.cos()]);
        assert!((got / want - 1.0).abs() < 3e-4, "{v} {h}: {got} {want}");
    }
    let tilt = lamp.tilt.unwrap();
    assert_eq!((tilt.factor(-5.0), tilt.factor(15.0), tilt.factor(37.5), tilt.factor(120.0)), (1.0, 0.99, 0.955, 0.9));
}

#[test]
fn an_isotropic_source() {
    let candela = 1000.0 / (4.0 * PI);
    for head in ["", "IESNA91\n", "IESNA:LM-63-1995\n", "IESNA:LM-63-2002\n", "IES:LM-63-2019\n"] {
        let text = format!("{head}TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 10\n0 180 0 {candela} {candela}");
        let lamp = Photometry::parse(text.as_bytes()).unwrap();
        assert!((lamp.flux_lm() - 1000.0).abs() < 1e-9);
        assert!((lamp.intensity([3.0, 1.0, 2.0]) / 9.0 - 8.842).abs() < 1e-3);
    }
}

/// Multiplier 2, ballast factor 0.9, and the second factor where the edition has one.
#[test]
fn factors_and_units() {
    for (head, second, factor) in [
        ("", "0.5", 0.9),
        ("IESNA91\n", "0.5", 0.9),
        ("IESNA:LM-63-1995\n", "0.5", 1.8),
        ("IESNA:LM-63-2002\n", "1", 1.8),
        ("IES:LM-63-2019\n", "1.10001", 1.8),
    ] {
        let lamp = Photometry::parse(small(head, second, "1", "100 50 0").as_bytes()).unwrap();
        assert!((lamp.at(0.0, 0.0) - 100.0 * factor).abs() < 1e-12, "{head}");
        assert!((lamp.at(135.0, 7.0) - 25.0 * factor).abs() < 1e-12, "{head}");
        assert!(lamp.opening_m.iter().zip([0.3048, 0.6096, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(lamp.peak(), lamp.at(0.0, 90.0));
    }
}

/// The symmetries, each with intensities 1, 2, 3.. on its horizontal angles.
#[test]
fn symmetries() {
    let lamp = |angles: &str, n: usize| {
        let rows: String = (1..=n).map(|i| format!("{i} {i}\n")).collect();
        let text = format!("TILT=NONE\n1 -1 1 2 {n} 1 2 0 0 0 1 1 0 90 180 {angles}\n{rows}");
        let lamp = Photometry::parse(text.as_bytes()).unwrap();
        move |h: f64| lamp.at(135.0, h)
    };
    let quarter = lamp("0 45 90", 3);
    assert_eq!([0.0, 90.0, 135.0, 180.0, 225.0, 300.0].map(quarter), [1.0, 3.0, 2.0, 1.0, 2.0, 2.0 + 1.0 / 3.0]);
    let half = lamp("0 90 180", 3);
    assert_eq!([0.0, 90.0, 180.0, 225.0, 270.0, 315.0].map(half), [1.0, 2.0, 3.0, 2.5, 2.0, 1.5]);
    let across = lamp("90 180 270", 3);
    assert_eq!([0.0, 45.0, 90.0, 180.0, 270.0, 315.0].map(across), [2.0, 1.5, 1.0, 2.0, 3.0, 2.5]);
    let all = lamp("0 90 180 270 360", 5);
    assert_eq!([0.0, 45.0, 270.0, 315.0, 359.0].map(all)[..4], [1.0, 1.5, 4.0, 4.5]);
}

#[test]
fn flux_of_halves_is_that_of_the_whole() {
    let flux = |text: &str| Photometry::parse(text.as_bytes()).unwrap().flux_lm();
    let whole = flux("TILT=NONE\n1 -1 1 2 5 1 2 0 0 0 1 1 0 0 180 0 90 180 270 360 1 1 2 2 3 3 2 2 1 1");
    let half = flux("TILT=NONE\n1 -1 1 2 3 1 2 0 0 0 1 1 0 0 180 0 90 180 1 1 2 2 3 3");
    assert!((whole - 8.0 * PI).abs() < 1e-9 && (half - whole).abs() < 1e-12, "{whole} {half}");
}

#[test]
fn damaged_files_are_refused_with_their_line() {
    let good = small("[TEST] x\n", "1", "2", "100 50 0");
    assert!(Photometry::parse(good.as_bytes()).is_ok());
    assert!(Photometry::parse(good.replace("TILT=NONE", " Tilt = none\r").as_bytes()).is_ok());
    for (from, to, want) in [
        ("TILT=NONE", "TILT=lamp.tlt", "line 2: tilt factors in another file, 'lamp.tlt'"),
        ("TILT=NONE", "TILD=NONE", "no line TILT="),
        ("3 1 1 2", "3 1 2 2", "line 3: photometry of type B"),
        ("3 1 1 2", "3 1 3 2", "line 3: photometry of type A"),
        ("3 1 1 2", "3 1 1 3", "line 3: the unit"),
        ("3 1 1 2", "3.5 1 1 2", "line 3: the number of vertical angles must be a whole number"),
        ("3 1 1 2", "4000000 4000000 1 2", "line 3: 4000000 x 4000000 intensities"),
        ("3 1 1 2", "1e300 1 1 2", "line 3: the number of vertical angles is"),
        ("0 90 180", "0 90 90", "line 5: vertical angle 3 of 3 is 90"),
        ("0 90 180", "0 90 170", "line 5: vertical angles from 0 to 170"),
        ("\n0\n", "\n5\n", "line 6: horizontal angles from 5"),
        ("100 50 0", "100 50", "the file ends after line 7 before intensity 3 of 3"),
        ("100 50 0", "100 -50 0", "line 7: intensity 2 of 3 is -50"),
        ("100 50 0", "100 nan 0", "line 7: intensity 2 of 3 is NaN"),
        ("100 50 0", "100 fifty 0", "line 7: intensity 2 of 3 must be a number, got 'fifty'"),
        ("100 50 0", "100 50 0\n7", "line 8: '7' after the last intensity"),
        ("[TEST] x", "IESNA:LM-63-2031", "line 1: 'IESNA:LM-63-2031': the editions known"),
    ] {
        assert!(good.contains(from), "{from}");
        let message = error(&good.replacen(from, to, 1));
        assert!(message.starts_with(want), "{message}\n  wants {want}");
    }
    assert!(error("TILT=INCLUDE\n1\n3\n0 90 45\n").starts_with("line 4: tilt angle 3 of 3 is 45"));
}

/// Every prefix, and every byte of a file in turn replaced by others: an answer or an error, never a panic.
#[test]
fn no_bytes_panic() {
    let good = small("IESNA91\n[MORE] a\n", "1", "2", "100 50 0").into_bytes();
    for n in 0..good.len() {
        let _ = Photometry::parse(&good[..n]);
        for byte in [0, b' ', b'-', b'9', b'e', b'\n', 0xff] {
            let mut bad = good.clone();
            bad[n] = byte;
            if let Ok(lamp) = Photometry::parse(&bad) {
                assert!(lamp.flux_lm().is_finite() && lamp.intensity([f64::NAN, 0.0, 1.0]) >= 0.0);
            }
        }
    }
}
