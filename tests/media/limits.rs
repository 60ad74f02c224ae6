//! Where methods fail: thin and thick, forward and lossless, from inside, one in another, wavelengths far apart, empty cells.

use glam::DVec3;
use luxpipe::medium::phase::{Phase, henyey_greenstein::HenyeyGreenstein};
use luxpipe::optics::slab::{self, Slab};
use luxpipe::render::estimate::What;

use crate::look::{At, Look, PATH, close, sky, slab};

const NM: [f64; 1] = [550.0];

fn down(cos: f64) -> At {
    let d = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
    At::Ray(-d * 0.3, d)
}

fn up() -> At {
    At::Ray(DVec3::new(0.1, 0.2, -1.3), DVec3::Z)
}

/// What a slab sends back and lets through of a sky above, by adding and doubling.
fn expected(depth: f64, albedo: f64, g: f32, cos: f64) -> (f64, f64) {
    let phase = HenyeyGreenstein::new(g);
    let p = |c: f64| 4.0 * std::f64::consts::PI * f64::from(phase.value((1.0 - c) as f32));
    let shares = slab::measure(&Slab { optical_depth: depth, albedo, eta: 1.0 }, &p, &[cos]).0[0];
    (shares.reflectance, shares.transmittance)
}

/// An optical depth of a millionth scatters half of a millionth back; of ten thousand nothing comes through, and all that is
/// to come back does.
#[test]
fn thin_and_thick() {
    let text = slab("extinction = 1e-6\nalbedo = 1") + &sky(true);
    let look = Look::new(&text, &PATH, &NM, What::Spectrum);
    close(look.mean(down(1.0), 256)[0], 0.5e-6, 2e-3, "thin, back");
    let text = slab("extinction = 1e4\nalbedo = 0.9") + &sky(true);
    let look = Look::new(&text, &PATH, &NM, What::Spectrum);
    close(look.mean(down(1.0), 4096)[0], expected(1e4, 0.9, 0.0, 1.0).0, 2e-3, "thick, back");
    assert!(look.mean(up(), 256)[0].0 < 1e-6);
}

/// g = 0.999, and albedo 1 - 1e-9.
#[test]
fn forward_and_lossless() {
    for (g, depth, albedo) in [(0.999, 20.0, 0.95), (0.9, 5.0, 1.0 - 1e-9), (0.0, 10.0, 1.0 - 1e-9)] {
        let keys =
            format!("extinction = {depth}\nalbedo = {albedo}\nphase = {{ type = \"henyey_greenstein\", g = {g} }}");
        let look = Look::new(&(slab(&keys) + &sky(true)), &PATH, &NM, What::Spectrum);
        let (back, on) = expected(depth, albedo, g, 1.0);
        let what = format!("g {g}, depth {depth}, albedo {albedo}");
        if back > 0.01 {
            close(look.mean(down(1.0), 4096)[0], back, 5e-3, &format!("{what}, back"));
        }
        close(look.mean(up(), 4096)[0], on, 5e-3, &format!("{what}, on"));
    }
}

/// A lamp within a medium: alone in what absorbs it fades by its distance; in what only scatters all of its light comes out.
#[test]
fn lamps_inside() {
    let scene = |medium: &str| {
        format!(
            "[media.m]\n{medium}\n[materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"b\"\n[lights.p]\ntype = \"point\"\nposition = [0, 0, 0]\nspectrum = 1\nintensity = 1\n"
        )
    };
    let outside = At::Point(DVec3::new(0.0, 0.0, 2.0), -DVec3::Z);
    let inside = At::Point(DVec3::new(0.0, 0.0, 0.5), -DVec3::Z);
    let look = Look::new(&scene("absorption = 3"), &PATH, &NM, What::Spectrum);
    close(look.mean(outside, 16)[0], 0.25 * (-3f64).exp(), 1e-5, "outside of what absorbs");
    close(look.mean(inside, 16)[0], 4.0 * (-1.5f64).exp(), 1e-5, "within it");
    let look = Look::new(&scene("scattering = 3"), &PATH, &NM, What::Spectrum);
    // Ways that pass near it are bright as 1 over their distance from it: a noise that no number of paths ends soon.
    let (value, error) = look.mean(outside, 16384)[0];
    assert!(error < 0.05 * 0.25 && (value - 0.25).abs() < 4.5 * error, "outside of what scatters: {value} +- {error}");
}

/// Of overlapping bodies the medium of the higher priority counts; of equal ones that of the body entered last.
#[test]
fn one_in_another() {
    let scene = |first: i32, second: i32| {
        format!(
            "[media.one]\nabsorption = 1\npriority = {first}\n[media.two]\nabsorption = 3\npriority = {second}\n\
             [materials.one]\ntype = \"boundary\"\ninterior = \"one\"\n[materials.two]\ntype = \"boundary\"\ninterior = \"two\"\n\
             [[shape]]\ntype = \"box\"\nmin = [0, -1, -1]\nmax = [2, 1, 1]\nmaterial = \"one\"\n\
             [[shape]]\ntype = \"box\"\nmin = [1.5, -1.1, -1.1]\nmax = [2.5, 1.1, 1.1]\nmaterial = \"two\"\n{}",
            sky(false)
        )
    };
    // Forth: 1.5 m of one alone, 0.5 of both, 0.5 of two alone.
    let both = |inner: f64| (-(1.5 + 0.5 * inner + 0.5 * 3.0f64)).exp();
    let (forth, back) = (At::Ray(-DVec3::X, DVec3::X), At::Ray(3.0 * DVec3::X, -DVec3::X));
    for (first, second, at, inner) in
        [(1, 0, forth, 1.0), (0, 1, forth, 3.0), (0, 0, forth, 3.0), (0, 0, back, 1.0), (1, 0, back, 1.0)]
    {
        let look = Look::new(&scene(first, second), &PATH, &NM, What::Spectrum);
        close(look.mean(at, 1)[0], both(inner), 2e-5, &format!("priorities {first} and {second}"));
    }
    // The eye within both.
    let middle = At::Ray(DVec3::new(1.75, 0.0, 0.0), DVec3::X);
    let look = Look::new(&scene(1, 0), &PATH, &NM, What::Spectrum);
    close(look.mean(middle, 1)[0], (-(0.25 + 0.5 * 3.0f64)).exp(), 2e-5, "from within both");
}

/// Coefficients that differ a hundred times: no wavelength is much noisier than it would be alone.
#[test]
fn wavelengths_far_apart_are_no_noisier() {
    let keys = "extinction = [[400, 0.1], [500, 10], [600, 0.1], [700, 10]]\nalbedo = 0.95";
    let text = slab(keys) + &sky(true);
    let nm: Vec<f64> = (0..16).map(|i| 405.0 + 19.0 * f64::from(i)).collect();
    let together = Look::new(&text, &PATH, &nm, What::Spectrum).mean(down(0.7), 1024);
    for (nm, (value, error)) in nm.iter().zip(together) {
        let (alone, own) = Look::new(&text, &PATH, &[*nm], What::Spectrum).mean(down(0.7), 1024)[0];
        let off = (value - alone).abs() / (error * error + own * own).sqrt();
        assert!(off < 4.5, "{nm} nm: {value} +- {error}, alone {alone} +- {own}");
        assert!(error < 6.0 * own, "{nm} nm: an error of {error}, alone {own}");
    }
}

/// Smoke in voxels, some empty, by regular tracking and by null collisions: the same light, scattered and shadowed.
#[test]
fn grids_by_both_trackings() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("smoke.vol");
    let size = [12i32, 9, 7];
    let mut bytes = b"VOL\x03".to_vec();
    for word in [1, size[0], size[1], size[2], 1] {
        bytes.extend(word.to_le_bytes());
    }
    for x in [-1f32, -1.0, -1.0, 1.0, 1.0, 1.0] {
        bytes.extend(x.to_le_bytes());
    }
    for i in 0..size.iter().product::<i32>() {
        let value = if i % 12 < 4 { 0.0 } else { 0.2 * (i * 7919 % 11) as f32 };
        bytes.extend(value.to_le_bytes());
    }
    std::fs::write(&file, bytes).unwrap();
    let scene = |tracking: &str| {
        format!(
            "[media.m]\nextinction = [[400, 3], [700, 1]]\nalbedo = 0.8\ndensity = {{ grid = {{ file = '{}', tracking = \"{tracking}\" }} }}\n\
             [materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = \"b\"\n\
             [lights.p]\ntype = \"point\"\nposition = [0.5, 2, 1]\nspectrum = 1\nintensity = 1\n",
            file.display()
        )
    };
    let at = At::Ray(DVec3::new(0.4, 0.1, 3.0), -DVec3::Z);
    let [a, b] = ["regular", "null"]
        .map(|tracking| Look::new(&scene(tracking), &PATH, &[450.0, 650.0], What::Spectrum).mean(at, 4096));
    for ((a, ea), (b, eb)) in a.into_iter().zip(b) {
        assert!(a > 0.0 && ea < 0.03 * a && eb < 0.03 * b, "{a} +- {ea}, {b} +- {eb}");
        assert!((a - b).abs() < 4.5 * (ea * ea + eb * eb).sqrt(), "{a} +- {ea}, {b} +- {eb}");
    }
}
