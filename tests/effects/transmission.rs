//! Bent light: a prism, bodies that absorb, rough ones; wavelengths that go apart.

use glam::DVec3;
use luxpipe::render::estimate::{Probe, What};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::spectral::Sampling;

use super::scenes::*;

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
        let through = Choice::Path(path::Options { max_bounces: 2, split: 4, pool: false });
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
        step: 0.1,
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

/// A floor and a lamp in an absorbing body, and the eye as well: light has its depth on both ways, found by looks at the lamp and by
/// running into it.
#[test]
fn lamps_within_bodies_are_absorbed() {
    let seen = |absorption: f64, radius: f64| {
        let text = format!(
            "{BLACK}[materials.m]\ntype = \"dielectric\"\nindex = 1\nabsorption = {absorption}\n[materials.floor]\nreflectance = 0.5\n[lights.l]\nspectrum = 1\nradiance = 1\n[[shape]]\ntype = \"box\"\nmin = [-3, -3, -0.5]\nmax = [3, 3, 3]\nmaterial = \"m\"\n[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\nradius = 0.5\nmaterial = \"floor\"\n[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 2]\nnormal = [0, 0, -1]\nradius = {radius}\nmaterial = \"black\"\nlight = \"l\"\n"
        );
        // From above the front of the body in, so that it is known where the eye's way lies: 2 m inside, aslant past the lamp.
        spectrum(&text, &bins(1), DVec3::new(2.9, 0.0, 3.5), DVec3::new(-2.9, 0.0, -3.5), 4096)[0]
    };
    let inside = 3.0 * (2.9f64.powi(2) + 3.5f64.powi(2)).sqrt() / 3.5;
    for (radius, tolerance) in [(0.01, 1e-3), (1.0, 0.02)] {
        let ratio = seen(0.5, radius) / seen(0.0, radius);
        // A wide lamp's edge is farther off: E by rings of it, cos^2 over the square of the way.
        let (n, mut with, mut without) = (1000, 0.0, 0.0);
        for i in 0..n {
            let r = radius * (f64::from(i) + 0.5) / f64::from(n);
            let way2 = 4.0 + r * r;
            let ring = r * 4.0 / (way2 * way2);
            with += ring * (-0.5 * way2.sqrt()).exp();
            without += ring;
        }
        let want = (-0.5 * inside).exp() * with / without;
        assert!((ratio / want - 1.0).abs() < tolerance, "radius {radius}: {ratio} for {want}");
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
