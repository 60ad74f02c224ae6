//! Films, gratings, openings, and roughness near the wavelength.

use glam::DVec3;
use luxpipe::render::estimate::{Probe, What};
use luxpipe::spectral::Sampling;

use super::scenes::*;

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

/// Roughness far below the wavelength is a mirror; far above it has no mirror left; nothing is gained in a furnace.
#[test]
fn wave_roughness_has_both_limits() {
    let seen = |sigma: f64, around: bool| {
        let light = if around {
            AROUND.to_string()
        } else {
            "[lights.s]\ntype = \"sun\"\nspectrum = 1\nradiance = 1\ndirection = [0, 0, 1]\ndiameter_deg = 0.5\n"
                .to_string()
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
