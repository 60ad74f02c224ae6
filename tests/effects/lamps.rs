//! Lamps by their profiles, and what is refused.

use glam::DVec3;
use luxpipe::render::estimate::{Probe, What};
use luxpipe::scene::load;

use super::fluorescence::matrix_file;
use super::scenes::*;

/// Flux is what was asked for, however it goes with the angle; a table of the cosine is the cosine's power.
#[test]
fn lamps_give_their_flux_by_any_profile() {
    let lit = |lamp: &str, shape: &str| {
        let text = format!(
            "[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = \"E\"\nlumens = 100\n{lamp}\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 2\ninward = true\nmaterial = \"black\"\n{shape}"
        );
        let scene = scene(&text);
        // Mean illuminance of the sphere by places evenly over it.
        let n = 400;
        let sum: f64 = (0..n)
            .map(|i| {
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
                let (s, c) = (f64::from(i) * 2.399963229728653).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let p = DVec3::new(r * c, r * s, z);
                let point = scene.lifted(scene.frame.place(p * 2.0).as_vec3a(), -p.as_vec3a());
                let probe = Probe::Irradiance { point, normal: -p.as_vec3a(), number: 1 };
                measured(&scene, &bins(4), What::Xyz, &PATH, &probe, 16)[1]
            })
            .sum();
        sum / f64::from(n) * 16.0 * std::f64::consts::PI
    };
    let disk = "[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 0.05\nmaterial = \"black\"\nlight = \"l\"\n";
    let point = |rest: &str| format!("type = \"point\"\nposition = [0, 0, 0]\n{rest}");
    for (lamp, shape) in [
        (String::new(), disk),
        ("cosine_power = 4".to_string(), disk),
        ("angles = [[0, 1], [30, 0.8], [60, 0.1], [90, 0]]".to_string(), disk),
        (point(""), ""),
        (point("cosine_power = 4\ndirection = [0, 0, 1]"), ""),
        (point("angles = [[0, 0.2], [90, 1], [180, 0.5]]\ndirection = [1, 0, 1]"), ""),
    ] {
        let got = lit(&lamp, shape);
        assert!((got / 100.0 - 1.0).abs() < 0.02, "{lamp}: {got} lm");
    }
}

/// A surface shines with the light that it names, whatever lights of other kinds stand before that one.
#[test]
fn surfaces_find_their_light_among_others() {
    let text = format!(
        "[lights.a]\ntype = \"point\"\nspectrum = 1\nposition = [0, 0, 5]\nintensity = 1\n[lights.b]\nspectrum = 1\nradiance = 3\n[lights.c]\nspectrum = 1\nradiance = 7\n{BLACK}{}{}",
        quad([[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]], "black", "light = \"c\""),
        quad([[0.0, -1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]], "black", "light = \"b\""),
    );
    for (x, want) in [(-0.5, 7.0), (0.5, 3.0)] {
        let got = spectrum(&text, &bins(1), DVec3::new(x, 0.0, 0.0), DVec3::Z, 1)[0];
        assert!((got - want).abs() < 1e-5, "{got} for {want}");
    }
}

/// What cannot be is refused, each with the key that says it.
#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = matrix_file(folder.path(), 1.25);
    for (material, word) in [
        (format!("type = \"fluorescent\"\nmatrix = \"{file}\""), "photons come out"),
        (
            "type = \"fluorescent\"\nreflectance = 0.5\nabsorption = 0.6\nemission = [[500, 1], [600, 0]]".into(),
            "more than 1",
        ),
        ("type = \"fluorescent\"\nreflectance = 0.5".into(), "absorption"),
        ("type = \"dielectric\"\nindex = 9".into(), "index"),
        ("type = \"dielectric\"\nindex = { sellmeier = [1, 2] }".into(), "six numbers"),
        ("type = \"dielectric\"\nabsorption = -1".into(), "absorption"),
        ("type = \"dielectric\"\ntransmittance = 0.5".into(), "thickness"),
        ("type = \"film\"".into(), "layers"),
        ("type = \"film\"\nlayers = [{ index = 1.3, thickness_nm = -1 }]".into(), "thickness_nm"),
        ("type = \"film\"\nlayers = [{ index = 1.3, thickness_nm = 100, color = 1 }]".into(), "color"),
        ("type = \"grating\"\npitch_nm = 1000\norders = [0.6]\nacross = [1, 0, 0]".into(), "orders"),
        ("type = \"grating\"\npitch_nm = 1000\norders = [0.1]".into(), "across"),
        ("type = \"polarizer\"\naxis = [0, 0, 0]".into(), "axis"),
        ("type = \"polarizer\"\naxis = [1, 0, 0]\ntransmittance = 0.1\nleak = 0.2".into(), "leak"),
        ("type = \"retarder\"\naxis = [1, 0, 0]".into(), "retardance_nm"),
        ("type = \"translucent\"\nreflectance = 0.6\ntransmittance = 0.6".into(), "more than 1"),
        ("type = \"wave_rough\"\nmetal = \"Al\"\nsigma_nm = 100\ntau_nm = 10".into(), "sigma_nm"),
    ] {
        let text = format!("{AROUND}[materials.m]\n{material}\n{}", level(0.0, "m"));
        let Err(e) = load::parse(&text, folder.path()) else { panic!("taken: {material}") };
        let message = e.to_string();
        assert!(message.contains(word) && message.contains("line "), "{material}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}
