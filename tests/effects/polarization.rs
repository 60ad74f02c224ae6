//! Stokes vectors along whole paths.

use glam::DVec3;
use luxpipe::render::estimate::{Probe, What};
use luxpipe::spectral::Sampling;

use super::scenes::*;

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
