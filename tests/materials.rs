//! Laws that every material keeps, walking the list of kinds: energy, reciprocity, sampling as evaluated, spectra as scalars.

use luxpipe::color::Uplift;
use luxpipe::keys;
use luxpipe::material::probe::{Sample, at_angle};
use luxpipe::material::read::{Interiors, KINDS, Without, read_all};
use luxpipe::material::{Lobes, Material, Site};
use luxpipe::spectral::Spectrum;

use glam::Vec3A;

/// White materials of every kind at a roughness: what is asked for is the most that they may give back.
fn most(kind: &str, roughness: f64) -> String {
    let keys = match kind {
        "diffuse" | "mirror" => "reflectance = 1".to_string(),
        // n = 0, k > 0 is a perfect conductor.
        "conductor" => format!("n = 0\nk = 5\nroughness = {roughness}"),
        "coated" => format!("reflectance = 1\nindex = 1.5\nroughness = {roughness}"),
        "glass" => format!("index = {}", 1.0 + roughness),
        "dielectric" => format!("index = 1.5\nroughness = {roughness}"),
        "film" => format!("layers = [{{ index = 1.38, thickness_nm = {} }}]", 2000.0 * roughness),
        "grating" => format!("pitch_nm = {}\norders = [0.2, 0.05]\nacross = [1, 0, 0]", 600.0 + 2000.0 * roughness),
        "wave_rough" => format!("n = 0\nk = 5\nsigma_nm = {}\ntau_nm = 4000", 1000.0 * roughness),
        "fluorescent" => "reflectance = 1\nabsorption = 0\nemission = [[500, 1], [600, 0]]".to_string(),
        "translucent" => format!("reflectance = {roughness}\ntransmittance = {}", 1.0 - roughness),
        "boundary" => "interior = \"clear\"".to_string(),
        "subsurface" => "interior = \"white\"\nindex = 1.3".to_string(),
        "polarizer" => "axis = [1, 0, 0]\nleak = 1".to_string(),
        "retarder" => "axis = [1, 0, 0]\nretardance_nm = 137.5".to_string(),
        "plastic" | "metal" => {
            format!("reflectance = 1\nspecular = {}\nroughness = {roughness}", 0.02 + 0.9 * roughness)
        }
        "trans" => format!(
            "reflectance = 1\nspecular = 0.05\nroughness = {roughness}\ntransmitted = 0.6\ntransmitted_specular = 0.7"
        ),
        "mixture" => "of = [\"a\", \"b\"]\nshares = [0.4, 0.6]".to_string(),
        new => panic!("a new kind of material, {new}: say here what its whitest is"),
    };
    let parts = format!(
        "[materials.a]\ntype = \"diffuse\"\nreflectance = 1\n[materials.b]\ntype = \"coated\"\nreflectance = 1\nroughness = {roughness}\n"
    );
    format!("{parts}[materials.m]\ntype = \"{kind}\"\n{keys}\n")
}

/// Whether its whitest gives everything back.
fn is_lossless(kind: &str) -> bool {
    // Ward's lobes lose what would go below the surface; in Radiance's metal the rest is spread by the colour, white here.
    // What is reflected more than once in the pits is no part of He and Torrance's lobes.
    // The dipole does not make up for what Fresnel's reflection takes on the way out.
    !["plastic", "metal", "trans", "wave_rough", "subsurface"].contains(&kind)
}

fn with(text: &str, name: &str, mut test: impl FnMut(&dyn Material, Sample)) {
    let mut keys = keys::parse(text).unwrap();
    let mut inks = Vec::new();
    let tables = keys.tables("materials").unwrap();
    let (none, much) = (Spectrum::Constant(0.0), Spectrum::Constant(1000.0));
    let mut interiors = Interiors {
        names: ["clear", "white"].map(String::from).into(),
        reduced: vec![[none.clone(), none.clone()], [much, none]],
        bodies: Vec::new(),
    };
    let all = read_all(tables, std::path::Path::new("."), 1.0, &mut inks, &mut interiors, Without::default());
    let all = all.unwrap_or_else(|e| panic!("{text}: {e}"));
    let material = &*all.iter().find(|m| m.0 == name).unwrap().1;
    let srgb = Uplift::new().unwrap().basis().clone();
    for front in [true, false] {
        let site = Site { front, colour: Some([1.0; 3]), ..Site::default() };
        test(material, Sample { material, inks: &inks, srgb: &srgb, site });
    }
}

const ROUGHNESS: [f64; 10] = [0.0, 1e-4, 0.002, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0];
const ANGLES: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 89.0];

/// Seen from any direction, a material under light of 1 from everywhere shows at most 1 (n^2 of it beyond a boundary), and
/// 1 where it loses nothing.
#[test]
fn furnace() {
    for (kind, _) in KINDS {
        for roughness in ROUGHNESS {
            let most = most(kind, roughness);
            with(&most, "m", |_, sample| {
                for angle in ANGLES {
                    let [r, t] = sample.totals(at_angle(angle), &[550.0])[0];
                    let eta = if sample.site.front { 1.5 } else { 1.0 / 1.5 };
                    // Radiance beyond a boundary is squeezed: the power that goes there is t eta^2.
                    let t = if *kind == "dielectric" { t * eta * eta } else { t };
                    assert!(r + t <= 1.0 + 1e-3, "{kind}, roughness {roughness}, {angle} deg: {r} + {t}");
                    if is_lossless(kind) {
                        assert!(r + t > 1.0 - 2e-3, "{kind}, roughness {roughness}, {angle} deg: {r} + {t} is lost");
                    }
                }
            });
        }
    }
}

fn directions() -> Vec<Vec3A> {
    let mut all = Vec::new();
    for theta in [5f32, 25.0, 50.0, 75.0] {
        for phi in [0f32, 40.0, 150.0, 200.0] {
            let (s, c) = theta.to_radians().sin_cos();
            all.push(Vec3A::new(s * phi.to_radians().cos(), s * phi.to_radians().sin(), c));
        }
    }
    all
}

/// f(a, b) = f(b, a) for reflection; through a surface the other way round is seen from the back.
#[test]
fn rough_lobes_are_reciprocal() {
    for (kind, _) in KINDS.iter().filter(|k| !["glass", "mirror"].contains(&k.0)) {
        for roughness in [0.1, 0.3, 0.8] {
            with(&most(kind, roughness), "m", |_, sample| {
                for a in directions() {
                    for b in directions() {
                        let (f, g) = (sample.scattering(a, b, &[550.0])[0], sample.scattering(b, a, &[550.0])[0]);
                        assert!((f - g).abs() <= 1e-3 * f.abs().max(1e-3), "{kind} {roughness}: {f} {g} at {a} {b}");
                        if *kind == "dielectric" {
                            // From one side to the other: see below.
                            continue;
                        }
                        let through = sample.scattering(a, -b, &[550.0])[0];
                        let back = sample.scattering(b, -a, &[550.0])[0];
                        assert!((through - back).abs() <= 1e-3 * through.abs().max(1e-3), "{kind}: {through} {back}");
                    }
                }
            });
        }
    }
}

/// Light that comes through a rough boundary takes the same way back: f(in -> out) / n_out^2 is the same the other way round.
#[test]
fn rough_boundaries_are_reciprocal() {
    for index in ["1.5", "\"glass_SF10_n\"", "0.7"] {
        let text = format!("[materials.m]\ntype = \"dielectric\"\nindex = {index}\nroughness = 0.4\n");
        let n: f64 = index.parse().unwrap_or(1.7282497);
        let mut seen = Vec::new();
        with(&text, "m", |_, sample| {
            for a in directions() {
                for b in directions() {
                    let (a, b) = if sample.site.front { (a, b) } else { (b, a) };
                    seen.push(sample.scattering(a, -b, &[587.6])[0]);
                }
            }
        });
        let (front, back) = seen.split_at(seen.len() / 2);
        assert!(front.iter().any(|f| *f > 0.01));
        for (f, g) in front.iter().zip(back) {
            // Seen from the front the eye is outside: f has 1 / n^2 in it.
            assert!((f * n * n - g).abs() < 2e-3 * g.max(0.01), "{index}: {f} and {g}");
        }
    }
}

/// What a kernel samples has the density and the value that it evaluates to, and the densities sum to what is not lost.
#[test]
fn samples_are_as_evaluated() {
    for (kind, _) in KINDS {
        for roughness in [0.05, 0.3, 1.0] {
            with(&most(kind, roughness), "m", |material, sample| {
                for angle in [0.0, 40.0, 80.0] {
                    let out = at_angle(angle);
                    let mut lobes = Lobes::default();
                    material.lobes(&sample.site, out, &mut lobes);
                    for (i, lobe) in lobes.iter().enumerate().filter(|(_, l)| !l.kernel.is_specular()) {
                        let n = 64;
                        for k in 0..n * n {
                            let u = [((k % n) as f32 + 0.5) / n as f32, ((k / n) as f32 + 0.5) / n as f32];
                            let Some(turn) = lobe.kernel.sample(out, u) else { continue };
                            let value = lobe.kernel.evaluate(out, turn.inc);
                            let off = (turn.pdf / value.pdf - 1.0)
                                .abs()
                                .max((turn.weight * value.pdf / value.f_cos - 1.0).abs());
                            assert!(
                                off < 2e-2 || value.f_cos < 1e-3,
                                "{kind} {roughness} lobe {i}: {turn:?} {value:?}"
                            );
                            assert_eq!(turn.inc.z < 0.0, lobe.kernel.transmits());
                        }
                    }
                }
            });
        }
    }
}

/// The chance that a lot picks each lobe is its odds, and its factor makes up for it.
#[test]
fn lots_are_fair() {
    with(&most("mixture", 0.3), "m", |material, sample| {
        let mut lobes = Lobes::default();
        material.lobes(&sample.site, at_angle(50.0), &mut lobes);
        assert!(lobes.len() == 3);
        let mut sums = [0.0f64; 3];
        let n = 100_000;
        for i in 0..n {
            let lobe = lobes.choose((i as f32 + 0.5) / n as f32).unwrap();
            let which = lobes.iter().position(|l| std::ptr::addr_eq(l.kernel, lobe.kernel)).unwrap();
            sums[which] += f64::from(lobe.factor) / f64::from(n);
        }
        for (lobe, sum) in lobes.iter().zip(sums) {
            assert!((sum / f64::from(lobe.factor) - 1.0).abs() < 1e-3, "{sum} for {}", lobe.factor);
        }
    });
}
