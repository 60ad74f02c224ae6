//! What Eq. (1) leaves out, on surfaces and lights, through whole paths: against closed forms and tables, and where methods fail.

use std::sync::Arc;

use glam::{DVec3, Vec3A};
use luxpipe::render::estimate::{Effort, Probe, Quantity, What, estimator};
use luxpipe::render::method::Choice;
use luxpipe::render::{path, radiosity};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;

const PATH: Choice = Choice::Path(path::Options { max_bounces: u32::MAX, split: 4 });

fn scene(text: &str) -> Arc<Scene> {
    Arc::new(load::parse(text, std::path::Path::new(".")).unwrap_or_else(|e| panic!("{e}\n{text}")))
}

/// Probes' numbers by so many paths.
fn all_measured(
    scene: &Arc<Scene>,
    sampling: &Sampling,
    what: What,
    choice: &Choice,
    probes: &[Probe],
    paths: u32,
) -> Vec<Vec<f64>> {
    let quantity = Quantity { sampling: sampling.clone(), range_nm: (300.0, 780.0), what, seed: 1 };
    let estimate = estimator(scene.clone(), &quantity, choice).unwrap_or_else(|e| panic!("{e}"));
    let one = |probe: &Probe| {
        let mut out = vec![0f32; estimate.components()];
        estimate.measure(std::slice::from_ref(probe), Effort::Paths(paths), &mut out);
        out.into_iter().map(f64::from).collect()
    };
    probes.iter().map(one).collect()
}

/// One probe's.
fn measured(
    scene: &Arc<Scene>,
    sampling: &Sampling,
    what: What,
    choice: &Choice,
    probe: &Probe,
    paths: u32,
) -> Vec<f64> {
    all_measured(scene, sampling, what, choice, std::slice::from_ref(probe), paths).remove(0)
}

fn ray(scene: &Scene, from: DVec3, to: DVec3) -> Probe {
    Probe::Ray { origin: scene.frame.place(from).as_vec3a(), direction: to.normalize().as_vec3a(), number: 0 }
}

/// Radiance along a ray, a number a wavelength.
fn spectrum(text: &str, sampling: &Sampling, from: DVec3, to: DVec3, paths: u32) -> Vec<f64> {
    let scene = scene(text);
    measured(&scene, sampling, What::Spectrum, &PATH, &ray(&scene, from, to), paths)
}

fn bins(n: usize) -> Sampling {
    Sampling::bins(380.0, 780.0, n).unwrap()
}

const AROUND: &str = "[environment]\nspectrum = 1\nradiance = 1\n";
const BLACK: &str = "[materials.black]\nreflectance = 0\n";

fn quad(p: [[f64; 3]; 4], material: &str, rest: &str) -> String {
    format!("[[shape]]\ntype = \"quad\"\npoints = {p:?}\nmaterial = \"{material}\"\n{rest}\n")
}

/// A level square that faces up.
fn level(z: f64, material: &str) -> String {
    quad([[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]], material, "")
}

const BK7: &str = "{ sellmeier = [1.03961212, 0.231792344, 1.01046945, 0.00600069867, 0.0200179144, 103.560653] }";

/// A prism of 60 degrees about the y axis; light comes from -x and leaves to +x. Angles of incidence and deviation are in its plane.
fn prism(sun_to: DVec3, sun_deg: f64) -> String {
    // Corners: left and right below, the edge above.
    let (l, r, e) = ([-0.5, 0.0], [0.5, 0.0], [0.0, 0.75f64.sqrt()]);
    let side = |a: [f64; 2], b: [f64; 2]| {
        quad([[a[0], 1.0, a[1]], [b[0], 1.0, b[1]], [b[0], -1.0, b[1]], [a[0], -1.0, a[1]]], "glass", "")
    };
    format!(
        "[materials.glass]\ntype = \"dielectric\"\nindex = {BK7}\n[lights.sun]\ntype = \"sun\"\nspectrum = 1\nradiance = 1\ndiameter_deg = {sun_deg}\ndirection = [{}, {}, {}]\n{}{}{}",
        sun_to.x,
        sun_to.y,
        sun_to.z,
        side(l, r),
        side(r, e),
        side(e, l)
    )
}

/// Deviations of a BK7 prism at minimum deviation, degrees, from its data sheet's Sellmeier formula.
const DEVIATIONS: [(f64, f64); 4] = [(435.8, 39.520), (486.13, 39.138), (587.56, 38.647), (656.27, 38.429)];

/// The way into the prism that leaves it by `deviation` at the minimum, and the way out.
fn at_minimum(deviation_deg: f64) -> (DVec3, DVec3) {
    // In the middle light goes level; half of the deviation at each face, up first: the edge is above.
    let half = (deviation_deg / 2.0).to_radians();
    (DVec3::new(half.cos(), 0.0, half.sin()), DVec3::new(half.cos(), 0.0, -half.sin()))
}

#[test]
fn a_prism_turns_each_wavelength_by_its_own_angle() {
    let all = Sampling::points(DEVIATIONS.map(|d| d.0).to_vec()).unwrap();
    for (i, (nm, deviation)) in DEVIATIONS.into_iter().enumerate() {
        let (way_in, way_out) = at_minimum(deviation);
        // Through the middle of the left face.
        let from = DVec3::new(-0.25, 0.0, 0.43) - way_in * 3.0;
        // A sun of 0.004 degrees: within 0.002 of its middle or dark.
        let scene = scene(&prism(way_out, 0.004));
        // Two boundaries and no more: what goes around in the prism may leave it by the same way at any wavelength.
        let through = Choice::Path(path::Options { max_bounces: 2, split: 4 });
        let seen = |sampling: &Sampling, paths| {
            measured(&scene, sampling, What::Spectrum, &through, &ray(&scene, from, way_in), paths)
        };
        let alone = seen(&Sampling::points(vec![nm]).unwrap(), 512)[0];
        // What two boundaries let through, of s and p light apart, is the unpolarised path's mean of each.
        assert!(alone > 0.8 && alone < 0.95, "{nm} nm: {alone}");
        // All four at once: each wavelength's part finds its own way, the others miss the sun.
        let four = seen(&all, 4096);
        for (k, got) in four.iter().enumerate() {
            if k == i {
                assert!((got / alone - 1.0).abs() < 0.1, "{nm} nm: {got} for {alone}");
            } else {
                assert!(*got == 0.0, "{} nm takes the way of {nm}: {got}", DEVIATIONS[k].0);
            }
        }
    }
}

/// The sun through a prism onto a wall: photons paint red where red goes and blue where blue goes.
#[test]
fn photons_go_apart_too() {
    let (way_in, way_out) = at_minimum(38.647);
    // What the sun sends along the way out arrives along the way in: a wall far behind the prism, seen from before it.
    let middle_of_wall = way_in * -4.0 + DVec3::new(0.0, 0.0, 0.43);
    let wall = |at: DVec3| quad_across(at, -way_in, 1.5, "wall", "");
    let text = format!("{}[materials.wall]\nreflectance = 0.8\n{}", prism(way_out, 0.5), wall(middle_of_wall));
    let scene = scene(&text);
    let photon = Choice::Photon(luxpipe::render::photon::Options {
        photons: 1_000_000,
        passes: 1,
        count: 60,
        gather_once: false,
        seed: 0,
        memory: 1 << 30,
        solution: None,
    });
    let sampling = Sampling::points(vec![435.8, 656.27]).unwrap();
    let normal = way_in;
    // Light of 435.8 nm goes the other way round through the prism: it is bent more, and meets the wall by so much off.
    let place = |off_deg: f64| {
        let up = way_in.cross(DVec3::Y);
        let place = middle_of_wall + up * (off_deg.to_radians().tan() * 4.0);
        let point = scene.lifted(scene.frame.place(place).as_vec3a(), normal.as_vec3a());
        Probe::Irradiance { point, normal: normal.as_vec3a(), number: 0 }
    };
    let places: Vec<Probe> = (-60..=60).map(|i| place(f64::from(i) * 0.1)).collect();
    let all = all_measured(&scene, &sampling, What::Spectrum, &photon, &places, 1);
    let middle = |k: usize| {
        // The sun shines on the wall beside as well, evenly.
        let least = all.iter().map(|v| v[k]).fold(f64::INFINITY, f64::min);
        let sum: f64 = all.iter().map(|v| v[k] - least).sum();
        assert!(sum > 0.0, "no light of wavelength {k}");
        all.iter().enumerate().map(|(i, v)| (i as f64 - 60.0) * 0.1 * (v[k] - least)).sum::<f64>() / sum
    };
    // 39.520 - 38.429 degrees at least deviation; from one side the same to a tenth.
    let apart = (middle(0) - middle(1)).abs();
    assert!((apart - 1.09).abs() < 0.25, "{apart} degrees");
}

/// However often light goes apart and is bent again, what is lossless loses nothing, at any wavelength.
#[test]
fn dispersion_through_ten_boundaries_loses_nothing() {
    let plates: String = (0..5)
        .map(|i| {
            let z = f64::from(i);
            format!("[[shape]]\ntype = \"box\"\nmin = [-9, -9, {z}]\nmax = [9, 9, {}]\nmaterial = \"glass\"\n", z + 0.5)
        })
        .collect();
    let glass = "[materials.glass]\ntype = \"dielectric\"\nindex = \"glass_SF10_n\"\n";
    let ball = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"glass\"\n";
    for (shapes, to) in [(plates.as_str(), DVec3::new(0.4, 0.2, 1.0)), (ball, DVec3::new(0.3, 0.1, 3.0))] {
        let from = DVec3::new(0.0, 0.0, -3.0);
        for n in [8, 33] {
            let got = spectrum(&format!("{AROUND}{glass}{shapes}"), &bins(n), from, to, 4096);
            let mean = got.iter().sum::<f64>() / n as f64;
            assert!((mean - 1.0).abs() < 0.01, "{n} bands: {mean}");
            assert!(got.iter().all(|x| (x - 1.0).abs() < 0.06), "{n} bands: {got:?}");
        }
    }
}

/// A matched body is not there; an absorbing one leaves exp(-depth) of the way, whether its front or its back is met.
#[test]
fn bodies_absorb_by_their_depth() {
    let body = |index: &str, absorption: &str| {
        format!(
            "{AROUND}[materials.m]\ntype = \"dielectric\"\nindex = {index}\n{absorption}\n[[shape]]\ntype = \"box\"\nmin = [-2, -2, 0]\nmax = [2, 2, 0.5]\nmaterial = \"m\"\n"
        )
    };
    let below = DVec3::new(0.0, 0.0, -0.2);
    let got = spectrum(&body("1", ""), &bins(4), below, DVec3::Z, 64);
    assert!(got.iter().all(|x| (x - 1.0).abs() < 1e-5), "{got:?}");
    let slope = DVec3::new(3f64.sqrt(), 0.0, 1.0);
    for (to, from, depth) in [(DVec3::Z, below, 1.0), (slope, below, 2.0), (DVec3::Z, DVec3::new(0.0, 0.0, 0.25), 0.5)]
    {
        let got = spectrum(&body("1", "absorption = 2"), &bins(4), from, to, 64);
        assert!(got.iter().all(|x| (x / f64::exp(-depth) - 1.0).abs() < 1e-4), "{to}: {got:?}");
    }
    // 10 cm let 40 % through at 400 nm and 90 % at 700: half a metre is nearly all red.
    let got = spectrum(
        &body("1", "transmittance = [[400, 0.4], [700, 0.9]]\nthickness = 0.1"),
        &Sampling::points(vec![400.0, 700.0]).unwrap(),
        below,
        DVec3::Z,
        16,
    );
    for (got, want) in got.iter().zip([0.4f64.powi(5), 0.9f64.powi(5)]) {
        assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
    }
}

/// A rough lossless body in the same light from all sides cannot be seen, from outside and from within.
#[test]
fn rough_glass_vanishes_in_a_furnace() {
    for index in ["1.5", "\"glass_F2_n\""] {
        for roughness in [0.05, 0.3, 1.0] {
            let text = format!(
                "{AROUND}[materials.m]\ntype = \"dielectric\"\nindex = {index}\nroughness = {roughness}\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n"
            );
            let got = spectrum(&text, &bins(8), DVec3::new(0.0, 0.0, -3.0), DVec3::new(0.4, 0.0, 3.0), 16384);
            let mean = got.iter().sum::<f64>() / 8.0;
            assert!((mean - 1.0).abs() < 0.02, "index {index}, roughness {roughness}: {got:?}");
        }
    }
}

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
fn matrix_file(folder: &std::path::Path, k: f64) -> String {
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
    let mut want = vec![0.0; 5];
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

/// Stokes vectors as the contract has them: +Q along the picture's right, +U counter-clockwise from it as seen looking towards
/// the source, V > 0 clockwise; and the same light in a turned camera is the same vector turned.
#[test]
fn stokes_frames_are_the_pictures() {
    let picture = |sheets: &str, up: [f64; 3]| {
        let text = format!(
            "{AROUND}[camera]\norigin = [0, 0, 0]\ntarget = [0, 1, 0]\nup = {up:?}\nfov_deg = 1\nwidth = 1\n{sheets}"
        );
        let scene = scene(&text);
        measured(&scene, &Sampling::points(vec![550.0]).unwrap(), What::Stokes, &PATH, &Probe::Pixel { x: 0, y: 0 }, 16)
    };
    let at =
        |y: f64, material: &str| quad([[-9.0, y, -9.0], [9.0, y, -9.0], [9.0, y, 9.0], [-9.0, y, 9.0]], material, "");
    for deg in [0.0f64, 20.0, 45.0, 100.0] {
        let (s, c) = deg.to_radians().sin_cos();
        let sheet = format!("[materials.p]\ntype = \"polarizer\"\naxis = [{c}, 0, {s}]\n{}", at(2.0, "p"));
        for turn in [0.0f64, 30.0, 77.0] {
            // The camera's up leans to the right by `turn`: everything in the picture turns counter-clockwise.
            let (ts, tc) = turn.to_radians().sin_cos();
            let got = picture(&sheet, [ts, 0.0, tc]);
            let (s2, c2) = (2.0 * (deg + turn)).to_radians().sin_cos();
            for (got, want) in got.iter().zip([0.5, 0.5 * c2, 0.5 * s2, 0.0]) {
                assert!((got - want).abs() < 1e-4, "{deg} {turn}: {got} for {want}");
            }
        }
    }
    // Light along the diagonal, whose upward part then falls a quarter of a wave behind the one to the right: it turns from
    // right to up, counter-clockwise.
    let circular = format!(
        "[materials.p]\ntype = \"polarizer\"\naxis = [1, 0, 1]\n[materials.q]\ntype = \"retarder\"\naxis = [1, 0, 0]\nretardance_nm = 137.5\n{}{}",
        at(3.0, "p"),
        at(2.0, "q")
    );
    let got = picture(&circular, [0.0, 0.0, 1.0]);
    for (got, want) in got.iter().zip([0.5, 0.0, 0.0, -0.5]) {
        assert!((got - want).abs() < 1e-5, "{got} for {want}");
    }
}

/// Light that is polarised in the plane of incidence passes a window at Brewster's angle whole; across it a share comes back.
#[test]
fn brewster_windows_part_s_and_p() {
    let brewster = 1.5f64.atan();
    let (s, c) = brewster.sin_cos();
    // The eye looks down at black glass (an opaque body of index 1.5) at that angle; a sheet stands before it.
    let window = "[materials.glass]\ntype = \"conductor\"\nn = 1.5\nk = 0\n";
    let seen = |axis: &str| {
        let text = format!(
            "{AROUND}{window}[materials.p]\ntype = \"polarizer\"\naxis = {axis}\n{}{}",
            level(0.0, "glass"),
            // At right angles to the way, between eye and glass.
            quad([[-s - c, -1.0, c - s], [-s + c, -1.0, c + s], [-s + c, 1.0, c + s], [-s - c, 1.0, c - s]], "p", "")
        );
        spectrum(&text, &bins(2), DVec3::new(-2.0 * s, 0.0, 2.0 * c), DVec3::new(s, 0.0, -c), 16)[0]
    };
    let (across, along) = (seen("[0, 1, 0]"), seen(&format!("[{c}, 0, {s}]")));
    assert!((across - 0.5 * 0.14792899).abs() < 1e-5, "{across}");
    assert!(along.abs() < 1e-7, "{along}");
}

/// Total reflection in a prism: nothing is lost, right up to grazing; a Fresnel rhomb's two reflections turn linear light circular.
#[test]
fn total_reflection_turns_phases() {
    // A slab of glass that the ray is in from the start, along which it bounces.
    for deg in [41.9f64, 45.0, 54.6, 80.0, 89.9] {
        let (s, c) = deg.to_radians().sin_cos();
        let text = format!(
            "polarization = true\n{AROUND}{BLACK}[materials.g]\ntype = \"dielectric\"\nindex = 1.5\n[materials.p]\ntype = \"polarizer\"\naxis = [{}, {}, {}]\n[lights.l]\nspectrum = 1\nradiance = 1\n[[shape]]\ntype = \"box\"\nmin = [-9e3, -9e3, -1]\nmax = [9e3, 9e3, 0]\nmaterial = \"g\"\n{}{}",
            // At 45 degrees to the plane of incidence, at right angles to the way down.
            c,
            1.0,
            s,
            // After one reflection at the top: a sheet at right angles to the way, and a lamp behind it.
            quad_across(DVec3::new(s, 0.0, -c) * 0.5 / c, DVec3::new(s, 0.0, -c), 0.2, "p", ""),
            quad_across(DVec3::new(s, 0.0, -c) * 0.6 / c, DVec3::new(s, 0.0, -c), 0.3, "black", "light = \"l\""),
        );
        let scene = scene(&text);
        let from = DVec3::new(-s, 0.0, -c) * 0.5 / c;
        let probe = ray(&scene, from, DVec3::new(s, 0.0, c));
        let got = measured(&scene, &Sampling::points(vec![550.0]).unwrap(), What::Stokes, &PATH, &probe, 16);
        let [i, q, u, v] = got[..] else { panic!() };
        assert!((i - 0.5).abs() < 1e-4, "{deg}: {i}");
        assert!((q * q + u * u + v * v - i * i).abs() < 1e-4, "{deg}: {got:?}");
        // tan(delta / 2) = cos sqrt(sin^2 - 1 / n^2) / sin^2.
        let retardance = 2.0 * (c * (s * s - 1.0 / 2.25).sqrt() / (s * s)).atan();
        assert!((v.abs() / i - retardance.sin()).abs() < 1e-3, "{deg}: V {v} for {}", retardance.sin());
    }
}

/// A square across a direction.
fn quad_across(at: DVec3, to: DVec3, half: f64, material: &str, rest: &str) -> String {
    let x = DVec3::Y * half;
    let y = to.cross(DVec3::Y).normalize() * half;
    let p = [at - x - y, at + x - y, at + x + y, at - x + y].map(|p| p.to_array());
    // Its front looks against the direction.
    let (a, b, c) = (DVec3::from(p[0]), DVec3::from(p[1]), DVec3::from(p[2]));
    let front = (b - a).cross(c - a).dot(to) < 0.0;
    quad(if front { p } else { [p[3], p[2], p[1], p[0]] }, material, rest)
}

/// The sky across the sun is polarised along its horizon as molecules do it, and a polariser sees it.
#[test]
fn skies_are_polarised_about_the_sun() {
    let text = format!(
        "[environment]\ntype = \"clear\"\nturbidity = 3\nsun = [0, 0.5, 0.8660254037844386]\npolarization = 0.8\n[camera]\ntype = \"panorama\"\norigin = [0, 0, 0]\ntarget = [0, 1, 0]\nup = [0, 0, 1]\nwidth = 64\n{BLACK}[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, -9]\nradius = 1\nmaterial = \"black\"\n"
    );
    let scene = scene(&text);
    let camera = scene.camera.clone().unwrap();
    let sun = DVec3::new(0.0, 0.5, 0.75f64.sqrt());
    for (x, y) in [(16, 8), (40, 4), (3, 12), (48, 10)] {
        let got = measured(&scene, &bins(4), What::Stokes, &PATH, &Probe::Pixel { x, y }, 64);
        let (_, to) = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, [0.0; 2]).unwrap();
        let to = to.as_dvec3();
        let cos = to.dot(sun);
        let degree = 0.8 * (1.0 - cos * cos) / (1.0 + cos * cos);
        // Along k = -to, from the picture's right to the sky's axis.
        let (right, k) = (to.cross(DVec3::Z).normalize(), -to);
        let axis = to.cross(sun).normalize();
        let angle = k.cross(right).dot(axis).atan2(right.dot(axis));
        for v in got.chunks(4) {
            let want = [degree * (2.0 * angle).cos(), degree * (2.0 * angle).sin(), 0.0];
            for (got, want) in v[1..].iter().zip(want) {
                assert!((got / v[0] - want).abs() < 0.02, "({x}, {y}): {} for {want}", got / v[0]);
            }
        }
    }
}

/// A film of no thickness is nothing; one of a millimetre is grey; a soap film between has the colours of its table, and loses nothing.
#[test]
fn films_are_averaged_over_bands() {
    let film = |nm: f64| {
        format!(
            "[materials.f]\ntype = \"film\"\nlayers = [{{ index = 1.33, thickness_nm = {nm} }}]\n{BLACK}[lights.l]\nspectrum = 1\nradiance = 1\n{}[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 9]\nnormal = [0, 0, -1]\nradius = 30\nmaterial = \"black\"\nlight = \"l\"\n",
            level(0.0, "f")
        )
    };
    // Seen from above, the lamp's light comes back.
    let back = |nm: f64, n: usize| spectrum(&film(nm), &bins(n), DVec3::Z, -DVec3::Z, 4096);
    assert!(back(0.0, 8).iter().all(|x| *x < 1e-6));
    let r = (0.33f64 / 2.33).powi(2);
    for x in back(1e6, 8) {
        assert!((x / (2.0 * r / (1.0 + r)) - 1.0).abs() < 0.15, "{x}");
    }
    let nm = [400.0, 500.0, 600.0, 700.0];
    let got = spectrum(&film(300.0), &Sampling::points(nm.to_vec()).unwrap(), DVec3::Z, -DVec3::Z, 1 << 14);
    for (got, want) in got.iter().zip([2.0614439e-05, 0.070790295, 0.058295763, 0.014921631]) {
        assert!((got - want).abs() < 0.002, "{got} for {want}");
    }
    // In a furnace it is not there, also where most of its light goes through.
    let text = format!(
        "{AROUND}[materials.f]\ntype = \"film\"\nlayers = [{{ index = 1.33, thickness_nm = 420 }}]\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"f\"\n"
    );
    let got = spectrum(&text, &bins(16), DVec3::new(0.0, 0.0, -3.0), DVec3::new(0.3, 0.0, 3.0), 4096);
    assert!(got.iter().all(|x| (x - 1.0).abs() < 0.01), "{got:?}");
}

/// A grating sends each wavelength its own way, loses nothing where orders vanish beyond grazing, and is a mirror where all do.
#[test]
fn gratings_lose_nothing_to_orders_that_are_not_there() {
    for pitch in [100.0, 500.0, 740.0, 1600.0, 20000.0] {
        for deg in [0.0f64, 40.0, 85.0] {
            let text = format!(
                "{AROUND}[materials.g]\ntype = \"grating\"\npitch_nm = {pitch}\norders = [0.3, 0.1]\nacross = [1, 0.3, 0]\n{}",
                level(0.0, "g")
            );
            let (s, c) = deg.to_radians().sin_cos();
            let got = spectrum(&text, &bins(8), DVec3::new(-s, 0.0, c), DVec3::new(s, 0.0, -c), 1 << 12);
            assert!(got.iter().all(|x| (x - 1.0).abs() < 0.05), "{pitch} nm at {deg}: {got:?}");
        }
    }
    // A sun where order 1 of 550 nm goes from a CD at normal incidence: 20.1055 degrees.
    let seen = |nm: f64| {
        let (s, c) = 20.10551f64.to_radians().sin_cos();
        let text = format!(
            "[materials.g]\ntype = \"grating\"\npitch_nm = 1600\norders = [0.25]\nacross = [1, 0, 0]\n[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = 1\ndirection = [{s}, 0, {c}]\ndiameter_deg = 0.01\n{}",
            level(0.0, "g")
        );
        spectrum(&text, &Sampling::points(vec![nm]).unwrap(), DVec3::Z, -DVec3::Z, 4096)[0]
    };
    assert!((seen(550.0) - 0.25).abs() < 0.02 && seen(548.0) == 0.0 && seen(552.0) == 0.0);
}

/// A star through a pupil of 3 mm is Airy's disk: dark rings where they belong, each wavelength's its own, and no light lost.
#[test]
fn a_pupil_shows_rings() {
    // A sun of 0.001 degrees, seen by a camera of parallel pixels of 4 arc seconds.
    let (pixels, arcsec) = (41, 8.0);
    let text = format!(
        "[camera]\norigin = [0, 0, 0]\ntarget = [0, 1, 0]\nup = [0, 0, 1]\nfov_deg = {}\nwidth = {pixels}\nheight = 1\npupil_mm = 2\n[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = 1\ndirection = [0, 1, 0]\ndiameter_deg = 0.0004\n{BLACK}[[shape]]\ntype = \"sphere\"\ncenter = [0, -9, 0]\nradius = 1\nmaterial = \"black\"\n",
        f64::from(pixels) * arcsec / 3600.0
    );
    let scene = scene(&text);
    let sampling = Sampling::points(vec![550.0]).unwrap();
    let at = |x: u32| measured(&scene, &sampling, What::Spectrum, &PATH, &Probe::Pixel { x, y: 0 }, 1 << 21)[0];
    let middle = at(20);
    // First ring at 69.18 arc seconds: 8.65 pixels off; the next maximum, 1.75 % of the middle, at 1.635 lambda / D = 92.7.
    let dark = at(29).min(at(28));
    let bright = at(31).max(at(32));
    assert!(middle > 0.0 && dark < 0.006 * middle, "{dark} of {middle}");
    assert!((bright / middle - 0.0175).abs() < 0.006, "{bright} of {middle}");
    // The pattern's own middle: pi D^2 / 4 lambda^2 times the sun's solid angle.
    let want =
        std::f64::consts::PI * 4e-6 / 4.0 / (550e-9f64).powi(2) * std::f64::consts::PI * 0.0002f64.to_radians().powi(2);
    assert!((middle / want - 1.0).abs() < 0.1, "{middle} for {want}");
}

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
                let probe = Probe::Irradiance { point, normal: Vec3A::from(-p.as_vec3a()), number: 1 };
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

/// Roughness far below the wavelength is a mirror; far above it has no mirror left; nothing is gained in a furnace.
#[test]
fn wave_roughness_has_both_limits() {
    let seen = |sigma: f64, around: bool| {
        let light = if around {
            AROUND.to_string()
        } else {
            format!(
                "[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = 1\ndirection = [0, 0, 1]\ndiameter_deg = 0.5\n"
            )
        };
        let text = format!(
            "{light}[materials.m]\ntype = \"wave_rough\"\nn = 0\nk = 5\nsigma_nm = {sigma}\ntau_nm = {}\n{}",
            2000.0f64.max(8.0 * sigma),
            level(0.0, "m")
        );
        spectrum(&text, &Sampling::points(vec![450.0, 650.0]).unwrap(), DVec3::Z, -DVec3::Z, 4096)
    };
    for (sigma, tolerance) in [(0.0, 1e-4), (0.1, 1e-4)] {
        assert!(seen(sigma, false).iter().all(|x| (x - 1.0).abs() < tolerance), "{:?}", seen(sigma, false));
    }
    // exp(-(4 pi sigma / lambda)^2) of the mirror: less of the blue. Beside it the lobe is far too wide to matter.
    for (got, nm) in seen(50.0, false).iter().zip([450.0, 650.0]) {
        let want = (-(4.0 * std::f64::consts::PI * 50.0 / nm).powi(2)).exp();
        assert!((got - want).abs() < 0.02, "{got} for {want}");
    }
    assert!(seen(5000.0, false).iter().all(|x| *x < 0.01));
    for sigma in [10.0, 100.0, 1000.0, 10000.0] {
        let got = seen(sigma, true);
        assert!(got.iter().all(|x| *x > 0.9 && *x < 1.01), "{sigma}: {got:?}");
    }
}

/// What cannot be is refused, each with the key that says it.
#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = matrix_file(folder.path(), 1.4);
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
