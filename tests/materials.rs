//! Laws that every material keeps, walking the list of kinds: energy, reciprocity, sampling as evaluated, spectra as scalars.

use luxpipe::color::Uplift;
use luxpipe::keys;
use luxpipe::material::probe::{Sample, at_angle};
use luxpipe::material::read::{KINDS, read_all};
use luxpipe::material::{Lobes, Material, Site};

use glam::Vec3A;

/// White materials of every kind at a roughness: what is asked for is the most that they may give back.
fn most(kind: &str, roughness: f64) -> String {
    let keys = match kind {
        "diffuse" | "mirror" => "reflectance = 1".to_string(),
        // n = 0, k > 0 is a perfect conductor.
        "conductor" => format!("n = 0\nk = 5\nroughness = {roughness}"),
        "coated" => format!("reflectance = 1\nindex = 1.5\nroughness = {roughness}"),
        "glass" => format!("index = {}", 1.0 + roughness),
        "dielectric" => format!("index = {}", 1.0 + roughness),
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
    !["plastic", "metal", "trans"].contains(&kind)
}

fn with(text: &str, name: &str, test: impl Fn(&dyn Material, Sample)) {
    let mut keys = keys::parse(text).unwrap();
    let mut inks = Vec::new();
    let tables = keys.tables("materials").unwrap();
    let all = read_all(tables, std::path::Path::new("."), 1.0, &mut inks).unwrap_or_else(|e| panic!("{text}: {e}"));
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
                    let eta = if sample.site.front { 1.0 + roughness } else { 1.0 / (1.0 + roughness) };
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
    for (kind, _) in KINDS.iter().filter(|k| !["dielectric", "glass", "mirror"].contains(&k.0)) {
        for roughness in [0.1, 0.3, 0.8] {
            with(&most(kind, roughness), "m", |_, sample| {
                for a in directions() {
                    for b in directions() {
                        let (f, g) = (sample.scattering(a, b, &[550.0])[0], sample.scattering(b, a, &[550.0])[0]);
                        assert!((f - g).abs() <= 1e-3 * f.abs().max(1e-3), "{kind} {roughness}: {f} {g} at {a} {b}");
                        let through = sample.scattering(a, -b, &[550.0])[0];
                        let back = sample.scattering(b, -a, &[550.0])[0];
                        assert!((through - back).abs() <= 1e-3 * through.abs().max(1e-3), "{kind}: {through} {back}");
                    }
                }
            });
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
