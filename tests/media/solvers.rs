//! Four solvers of Eq. (2) against closed forms and each other, and the dipole against a walk through the body.

use glam::DVec3;
use luxpipe::optics::dipole::Dipole;
use luxpipe::optics::slab::{self as layers, Slab};
use luxpipe::render::estimate::What;
use luxpipe::render::method::Choice;
use luxpipe::render::{march, photon};

use crate::look::{At, Look, PATH, close, sky, slab};

const NM: [f64; 1] = [550.0];

fn marching(step: f32, zones: Option<u32>) -> Choice {
    let zonal = zones.map(|along| march::solve::Options { along, rays: 512, memory: 1 << 30 });
    Choice::March(march::Options { step, zonal })
}

fn photons() -> Choice {
    Choice::Photon(photon::Options {
        photons: 200_000,
        passes: 4,
        count: 200,
        gather_once: false,
        step: 0.1,
        seed: 1,
        memory: 1 << 30,
        solution: None,
    })
}

fn table(id: &str) -> toml::Table {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ref/validation.toml");
    let all: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
    all[id].as_table().unwrap().clone()
}

/// What only absorbs and gives off light is exact, whatever the step.
#[test]
fn marching_is_exact_without_scattering() {
    for depth in [0.01f64, 1.0, 5.0] {
        let keys = format!("absorption = {depth}\nemission = 1");
        for step in [0.1, 10.0] {
            let look = Look::new(
                &(slab(&keys) + &format!("{}radiance = 0.25", sky(false).replace("radiance = 1\n", ""))),
                &marching(step, None),
                &NM,
                What::Spectrum,
            );
            let want = 0.25 * (-depth).exp() + 1.0 - (-depth).exp();
            close(look.mean(At::Ray(DVec3::Z, -DVec3::Z), 1)[0], want, 2e-5, &format!("depth {depth}, step {step}"));
        }
    }
}

/// Single scattering under a sun, the table of first-order radiances, within 0.5 %.
#[test]
fn marching_is_right_to_half_a_percent_for_single_scattering() {
    for row in table("single-scatter-slab")["rows"].as_array().unwrap() {
        let row: Vec<f64> = row.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect();
        let [albedo, depth, mu0, mu, back, on] = row[..] else { panic!() };
        let sin = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let keys = format!("extinction = {depth}\nalbedo = {albedo}");
        // The spectrum's irradiance is its solid angle times its radiance: 1 through a disk of 0.01 degrees.
        let half = 0.005f64.to_radians();
        let radiance = 1.0 / (std::f64::consts::PI * half.sin().powi(2));
        let sun = format!(
            "[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = {radiance}\ndirection = [{}, 0, {mu0}]\ndiameter_deg = 0.01\n",
            sin(mu0)
        );
        let look = Look::new(&(slab(&keys) + &sun), &marching(0.1, None), &NM, What::Spectrum);
        // Straight up the sun itself would be seen.
        let aside = mu.min(1.0 - 1e-6);
        let ray = |up: bool| {
            let d = DVec3::new(0.0, sin(aside), if up { aside } else { -aside });
            At::Ray(DVec3::new(0.0, 0.0, if up { -1.0 } else { 0.0 }) - d * 0.1, d)
        };
        close(look.mean(ray(false), 16)[0], back, 5e-3, &format!("back, {row:?}"));
        close(look.mean(ray(true), 16)[0], on, 5e-3, &format!("on, {row:?}"));
    }
}

/// Three solvers agree with path tracing on a cube of fog under a lamp, over a floor.
#[test]
fn solvers_agree_in_fog() {
    let text = "[media.fog]\nextinction = [[400, 3], [700, 1]]\nalbedo = 0.9\n[materials.fog]\ntype = \"boundary\"\ninterior = \"fog\"\n\
                [materials.floor]\nreflectance = 0.5\n[materials.lamp]\nreflectance = 0\n[lights.l]\nspectrum = 1\nradiance = 1\n\
                [[shape]]\ntype = \"box\"\nmaterial = \"fog\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
                [[shape]]\ntype = \"quad\"\nmaterial = \"floor\"\npoints = [[-3, -3, -1.01], [3, -3, -1.01], [3, 3, -1.01], [-3, 3, -1.01]]\n\
                [[shape]]\ntype = \"quad\"\nmaterial = \"lamp\"\nlight = \"l\"\npoints = [[-1, -1, 3], [-1, 1, 3], [1, 1, 3], [1, -1, 3]]\n";
    let nm = [450.0, 650.0];
    let rays: Vec<At> = (0..24)
        .map(|i| {
            let (x, z) = (0.3 * f64::from(i % 4) - 0.4, 0.28 * f64::from(i / 4) - 0.75);
            At::Ray(DVec3::new(x, -4.0, z), DVec3::Y)
        })
        .collect();
    let mean = |choice: &Choice, paths: u32| -> Vec<(f64, f64)> {
        let look = Look::new(text, choice, &nm, What::Spectrum);
        let all: Vec<Vec<(f64, f64)>> = rays.iter().map(|at| look.mean(*at, paths)).collect();
        let n = rays.len() as f64;
        (0..nm.len())
            .map(|k| {
                let sum = all.iter().fold((0.0, 0.0), |s, a| (s.0 + a[k].0 / n, s.1 + (a[k].1 / n).powi(2)));
                (sum.0, sum.1.sqrt())
            })
            .collect()
    };
    let path = mean(&PATH, 512);
    for (choice, share, name) in [(marching(0.1, Some(8)), 0.02, "zonal"), (photons(), 0.04, "photon map")] {
        for ((value, error), (want, own)) in mean(&choice, 8).into_iter().zip(&path) {
            assert!(*own < 0.005 * want, "{want} +- {own}");
            let most = 4.5 * (error * error + own * own).sqrt() + share * want;
            assert!((value - want).abs() < most, "{name}: {value} +- {error} for {want} +- {own}");
        }
    }
}

/// Exchange areas close to a thousandth, and zones thicker than a mean free path are reported.
#[test]
fn thick_zones_are_reported() {
    let thick = slab("extinction = 40\nalbedo = 0.5").replace("50", "1") + &sky(true);
    let said = Look::new(&thick, &marching(0.1, Some(4)), &NM, What::Spectrum).said();
    assert!(said.contains("mean free paths wide"), "{said}");
    let closure = said.split("close to ").nth(1).and_then(|s| s.split(',').next()).unwrap().parse::<f64>().unwrap();
    assert!(closure < 1e-3, "{said}");
    let thin = slab("extinction = 0.5\nalbedo = 0.5").replace("50", "1") + &sky(true);
    let said = Look::new(&thin, &marching(0.1, Some(4)), &NM, What::Spectrum).said();
    assert!(!said.contains("mean free paths"), "{said}");
}

/// A medium that shines as it absorbs, and reflects what it gives off: 1 within light of 1, also by zones.
#[test]
fn a_furnace_of_zones() {
    let keys = "extinction = 2\nalbedo = 0.7\nemission = 1";
    let text = slab(keys).replace("50", "1") + &sky(false);
    let look = Look::new(&text, &marching(0.1, Some(6)), &NM, What::Spectrum);
    let (value, error) = look.mean(At::Ray(DVec3::Z, -DVec3::Z), 64)[0];
    assert!((value - 1.0).abs() < 0.02 + 4.5 * error, "{value} +- {error}");
}

/// A body of milk as thick as its dipole takes it for, by the dipole: seen from above under an even sky it sends back what the formula
/// says, less what Fresnel's reflection keeps of what comes in and goes out.
#[test]
fn dipoles_send_back_their_total() {
    let text = "[media.m]\nscattering = [[400, 3000], [700, 2000]]\nabsorption = [[400, 30], [700, 2]]\n[materials.s]\ntype = \"subsurface\"\ninterior = \"m\"\nindex = 1.3\n\
                [[shape]]\ntype = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 0]\nmaterial = \"s\"\n".to_string() + &sky(true);
    let nm = [420.0, 550.0, 680.0];
    let look = Look::new(&text, &PATH, &nm, What::Spectrum);
    let got = look.mean(At::Ray(DVec3::new(0.0, 0.0, 1.0), -DVec3::Z), 16384);
    let sent = |cos: f64| {
        let (s, p, _) = luxpipe::optics::fresnel::polarised(cos, 1.3);
        0.5 * (s + p)
    };
    let inward = 1.0 - luxpipe::optics::fresnel::diffuse(1.3);
    for (nm, got) in nm.iter().zip(got) {
        let (s, a) = (3000.0 - (nm - 400.0) / 300.0 * 1000.0, 30.0 - (nm - 400.0) / 300.0 * 28.0);
        let total = Dipole::new(s, a, 1.3).total();
        let want = sent(1.0) + (1.0 - sent(1.0)) * inward * total;
        close(got, want, 4e-3, &format!("{nm} nm"));
    }
}

/// The same body by a walk through it, against adding and doubling: a half space with a surface of index 1.3.
#[test]
fn walks_through_bodies_are_exact() {
    for (s, a) in [(2000.0, 20.0), (500.0, 500.0)] {
        let text = format!(
            "[media.m]\nscattering = {s}\nabsorption = {a}\n[materials.s]\ntype = \"dielectric\"\ninterior = \"m\"\nindex = 1.3\n[[shape]]\ntype = \"box\"\nmin = [-0.2, -0.2, -0.4]\nmax = [0.2, 0.2, 0]\nmaterial = \"s\"\n{}",
            sky(true)
        );
        let look = Look::new(&text, &PATH, &NM, What::Spectrum);
        let got = look.mean(At::Ray(DVec3::new(0.0, 0.0, 0.1), -DVec3::Z), 8192)[0];
        let body = Slab { optical_depth: f64::INFINITY, albedo: s / (s + a), eta: 1.3 };
        let want = layers::measure(&body, &|_| 1.0, &[1.0]).0[0].reflectance;
        close(got, want, 5e-3, &format!("scattering {s}, absorption {a}"));
    }
}

/// Light that air scatters once at right angles is polarised altogether; straight on not at all.
#[test]
fn air_polarises() {
    let keys = "scattering = 1e-4\nphase = \"rayleigh\"";
    let half = 0.005f64.to_radians();
    let radiance = 1.0 / (std::f64::consts::PI * half.sin().powi(2));
    for (deg, want) in [(90f64, 1.0), (60.0, 0.6), (120.0, 0.6), (30.0, 0.14285714)] {
        let (sin, cos) = deg.to_radians().sin_cos();
        let sun = format!(
            "polarization = true\n{}[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = {radiance}\ndirection = [{sin}, {cos}, 0]\ndiameter_deg = 0.01\n",
            slab(keys)
        );
        let look = Look::new(&sun, &PATH, &NM, What::Stokes);
        // Along +y: light turns by the angle between the ways.
        let got = look.mean(At::Ray(DVec3::new(0.0, -60.0, -0.5), DVec3::Y), 64);
        let [i, q, u, v] = [got[0].0, got[1].0, got[2].0, got[3].0];
        let degree = (q * q + u * u + v * v).sqrt() / i;
        assert!(i > 0.0 && (degree - want).abs() < 2e-3, "{deg} degrees: {degree} for {want}");
    }
}
