//! Light that changes its wavelength.

use glam::DVec3;
use luxpipe::render::estimate::What;
use luxpipe::render::method::Choice;
use luxpipe::render::radiosity;
use luxpipe::spectral::Sampling;

use super::scenes::*;

/// The 5-band matrix of the table.
fn donaldson() -> toml::Table {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ref/validation.toml");
    let all: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
    all["fluorescence-donaldson-5band"].as_table().unwrap().clone()
}

fn numbers(v: &toml::Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_float().unwrap_or_else(|| x.as_integer().unwrap() as f64)).collect()
}

/// Written beside the scene, k times the matrix.
pub fn matrix_file(folder: &std::path::Path, k: f64) -> String {
    let m = donaldson();
    let rows = m["M"].as_array().unwrap();
    let nm = numbers(&m["lambda_nm"]);
    let line = |first: String, row: Vec<f64>| {
        format!("{first},{}\n", row.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
    };
    let mut text = line("nm".into(), nm.clone());
    for (nm, row) in nm.iter().zip(rows) {
        text += &line(nm.to_string(), numbers(row).iter().map(|x| x * k).collect());
    }
    let path = folder.join(format!("matrix{k}.csv"));
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

fn five() -> Sampling {
    Sampling::bins(375.0, 625.0, 5).unwrap()
}

/// Long end first: the table runs the other way. Of a piecewise linear reflectance a bin shows the mean, an eighth of each
/// neighbour's value in it, so that the diagonal is compared by its own mean.
fn ascending(mut x: Vec<f64>) -> Vec<f64> {
    x.reverse();
    x
}

/// B = M E in the open, and (1 - 0.9 M) B = E in a closed sphere, by paths and by radiosity.
#[test]
fn fluorescent_surfaces_give_off_what_the_matrix_says() {
    let folder = tempfile::tempdir().unwrap();
    let m = donaldson();
    let file = matrix_file(folder.path(), 1.0);
    let paint = format!("[materials.paint]\ntype = \"fluorescent\"\nmatrix = \"{file}\"\n");
    let e = [
        ("B_equal_energy", vec![1.0; 5]),
        ("B_warm_E=[.3,.5,.8,1.1,1.4]", vec![0.3, 0.5, 0.8, 1.1, 1.4]),
        ("monochromatic_400_unit", vec![1.0, 0.0, 0.0, 0.0, 0.0]),
    ];
    // Reflectances as a bin sees the table: linear between the bands' middles.
    let rho: Vec<f64> = numbers(
        &m["M"]
            .as_array()
            .unwrap()
            .iter()
            .enumerate()
            .map(|(i, r)| toml::Value::Float(numbers(r)[i]))
            .collect::<Vec<_>>()
            .into(),
    );
    let seen = |i: usize| {
        let at = |j: i64| rho[j.clamp(0, 4) as usize];
        0.75 * rho[i] + 0.125 * (at(i as i64 - 1) + at(i as i64 + 1))
    };
    for (key, light) in e {
        // Bands as steps: a table that jumps within a hundredth of a nanometre.
        let steps: Vec<[f64; 2]> = light
            .iter()
            .enumerate()
            .flat_map(|(i, x)| [[375.001 + 50.0 * i as f64, *x], [424.999 + 50.0 * i as f64, *x]])
            .collect();
        let text = format!("[environment]\nspectrum = {steps:?}\nradiance = 1\n{paint}{}", level(0.0, "paint"));
        let got = ascending(spectrum(&text, &five(), DVec3::Z, -DVec3::Z, 256));
        for (i, want) in numbers(&m[key]).iter().enumerate() {
            let want = want + (seen(i) - rho[i]) * light[i];
            assert!((got[i] - want).abs() < 2e-3 * want.max(0.01), "{key}, band {i}: {} for {want}", got[i]);
        }
    }
    // In the sphere the mean reflectance of a bin is that of the piecewise linear diagonal.
    let file = matrix_file(folder.path(), 0.9);
    let text = format!(
        "[materials.paint]\ntype = \"fluorescent\"\nmatrix = \"{file}\"\n[lights.l]\nspectrum = 1\nradiance = 1\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\ninward = true\nmaterial = \"paint\"\nlight = \"l\"\n"
    );
    // B = (1 - 0.9 R)^-1 (1 + 0.9 F B), upwards band by band.
    let full: Vec<Vec<f64>> = m["M"].as_array().unwrap().iter().map(numbers).collect();
    let mut want = [0.0; 5];
    for i in 0..5 {
        let from: f64 = (0..i).map(|j| 0.9 * full[i][j] * want[j]).sum();
        want[i] = (1.0 + from) / (1.0 - 0.9 * seen(i));
    }
    let radiosity = Choice::Radiosity(radiosity::Options {
        divide: Some(16),
        tolerance: 0.01,
        rays: 256,
        show: radiosity::Show::Mesh,
        memory: 1 << 30,
        solution: None,
        seed: 0,
    });
    let scene = scene(&text);
    for (choice, paths, tolerance) in [(&PATH, 1 << 12, 0.01), (&radiosity, 64, 0.01)] {
        let probe = ray(&scene, DVec3::ZERO, DVec3::X);
        let got = ascending(measured(&scene, &five(), What::Spectrum, choice, &probe, paths));
        for (i, want) in want.iter().enumerate() {
            assert!((got[i] / want - 1.0).abs() < tolerance, "{choice:?}, band {i}: {} for {want}", got[i]);
        }
    }
}

/// Photons that leave a dye are those it took in times its yield, seen through whole paths.
#[test]
fn no_photon_is_gained() {
    let text = format!(
        "[environment]\nspectrum = [[360, 1], [370, 1]]\nradiance = 1\n[materials.paint]\ntype = \"fluorescent\"\nreflectance = 0.1\nabsorption = [[350, 0.8], [380, 0.8], [420, 0]]\nemission = [[420, 0], [450, 1], [600, 0]]\nquantum_yield = 0.75\n{}",
        level(0.0, "paint")
    );
    for n in [48, 96, 160] {
        let sampling = Sampling::bins(300.0, 780.0, n).unwrap();
        let got = spectrum(&text, &sampling, DVec3::Z, -DVec3::Z, 64);
        let photons = |range: std::ops::Range<f64>| -> f64 {
            let within = (0..n).filter(|i| range.contains(&sampling.centre_nm(*i)));
            within.map(|i| got[i] * sampling.centre_nm(i)).sum::<f64>() * 480.0 / n as f64
        };
        let took = 10.0 * 365.0;
        let (back, given) = (photons(300.0..395.0) / took, photons(395.0..780.0) / took);
        assert!((back - 0.1).abs() < 2e-3 && (given - 0.6).abs() < 4e-3, "{n} bins: {back} and {given}");
    }
}

/// A polarised lamp lights a fluorescent sheet: what it gives off is not polarised.
#[test]
fn fluorescence_is_unpolarised() {
    let folder = tempfile::tempdir().unwrap();
    let file = matrix_file(folder.path(), 1.0);
    let text = format!(
        "{AROUND}[materials.paint]\ntype = \"fluorescent\"\nmatrix = \"{file}\"\n[materials.p]\ntype = \"polarizer\"\naxis = [1, 0, 0]\n{}{}",
        level(0.0, "paint"),
        level(0.1, "p")
    );
    let scene = scene(&text);
    let stokes = |from: DVec3, to: DVec3| measured(&scene, &five(), What::Stokes, &PATH, &ray(&scene, from, to), 256);
    // From below the sheet.
    let under = stokes(DVec3::new(0.0, 0.0, 0.05), DVec3::new(0.3, 0.1, -1.0));
    for v in under.chunks(4) {
        assert!(v[0] > 0.01 && v[1..].iter().all(|x| x.abs() < 1e-6 * v[0]), "{v:?}");
    }
    // And from above, through the polariser.
    let over = stokes(DVec3::Z, DVec3::new(0.0, 0.0, -1.0));
    for v in over.chunks(4) {
        assert!((v[1].hypot(v[2]) / v[0] - 1.0).abs() < 1e-5, "{v:?}");
    }
}
