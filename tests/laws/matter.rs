//! Materials of every kind, with any numbers they may have.

use std::path::Path;

use glam::Vec3A;
use luxpipe::color::Uplift;
use luxpipe::keys;
use luxpipe::material::Site;
use luxpipe::material::probe::Sample;
use luxpipe::material::read::{Interiors, KINDS, Without, read_all};
use luxpipe::spectral::Spectrum;

use crate::chance::{Chance, holds};

const WAVELENGTHS: [f64; 3] = [420.0, 550.0, 680.0];

/// A material of a kind; and its index where a body begins behind it.
struct Matter {
    keys: String,
    index: f64,
}

/// Any material of a kind.
fn any(kind: &str, c: &mut Chance) -> Matter {
    // A fifth of them is smooth.
    let roughness = c.between(-0.25, 1.0).max(0.0);
    let index = c.between(1.02, 2.4);
    let axis = c.direction();
    let paint = c.spectrum(0.0, 1.0);
    let metal = format!("n = {}\nk = {}", c.spectrum(0.01, 4.0), c.spectrum(0.0, 8.0));
    let share = c.share();
    let keys = match kind {
        "diffuse" | "mirror" => format!("reflectance = {paint}"),
        "conductor" => format!("{metal}\nroughness = {roughness}"),
        "coated" => format!("reflectance = {paint}\nindex = {index}\nroughness = {roughness}"),
        "glass" => format!("index = {index}\ndepth = {}\npanes = {}", c.spectrum(0.0, 2.0), c.whole(1, 3)),
        "dielectric" => format!("index = {index}\nroughness = {roughness}"),
        "film" => {
            let layer = |c: &mut Chance| {
                let (index, k, thickness) = (c.between(1.0, 2.5), c.share().powi(4), c.decades(1.0, 1e4));
                format!("{{ index = {index}, k = {k}, thickness_nm = {thickness} }}")
            };
            let layers: Vec<String> = (0..c.whole(1, 3)).map(|_| layer(c)).collect();
            format!("layers = [{}]\n{metal}", layers.join(", "))
        }
        "grating" => {
            let (first, pitch) = (c.between(0.0, 0.4), c.decades(200.0, 2e4));
            let across = if axis.z.abs() > 0.9 { [1.0, 0.0, 0.0] } else { axis.to_array() };
            format!(
                "pitch_nm = {pitch}\norders = [{first}, {}]\nacross = {across:?}\nreflectance = {paint}",
                0.1 * share
            )
        }
        "wave_rough" => format!("{metal}\nsigma_nm = {}\ntau_nm = {}", 500.0 * roughness, c.decades(500.0, 1e4)),
        "fluorescent" => {
            let emission = "[[500, 0], [560, 1], [620, 0]]";
            format!("reflectance = {}\nabsorption = {}\nemission = {emission}", 0.5 * share, 0.5 * (1.0 - share))
        }
        "translucent" => {
            format!("reflectance = {}\ntransmittance = {}", c.spectrum(0.0, share), c.spectrum(0.0, 1.0 - share))
        }
        "boundary" => "interior = \"clear\"".to_string(),
        "subsurface" => format!("interior = \"milk\"\nindex = {}", c.between(1.0, 1.6)),
        "polarizer" => format!("axis = {:?}\ntransmittance = {share}\nleak = {}", axis.to_array(), share * c.share()),
        "retarder" => format!("axis = {:?}\nretardance_nm = {}", axis.to_array(), c.between(0.0, 700.0)),
        "plastic" | "metal" => format!("reflectance = {paint}\nspecular = {share}\nroughness = {roughness}"),
        "trans" => format!(
            "reflectance = {paint}\nspecular = {}\nroughness = {roughness}\ntransmitted = {share}\ntransmitted_specular = {}",
            0.5 * c.share(),
            c.share()
        ),
        "mixture" => format!("of = [\"a\", \"b\"]\nshares = [{share}, {}]", 1.0 - share),
        new => panic!("a new kind of material, {new}: say here which numbers it may have"),
    };
    Matter { keys, index }
}

/// Shows a material from both sides.
fn with(kind: &str, matter: &Matter, mut test: impl FnMut(Sample)) {
    let parts =
        "[materials.a]\nreflectance = 0.8\n[materials.b]\ntype = \"conductor\"\nmetal = \"Au\"\nroughness = 0.3\n";
    let text = format!("{parts}[materials.m]\ntype = \"{kind}\"\n{}\n", matter.keys);
    let (none, some, much) = (Spectrum::Constant(0.0), Spectrum::Constant(1.0), Spectrum::Constant(1000.0));
    let names = ["clear", "milk"].map(String::from).into();
    let mut interiors = Interiors { names, reduced: vec![[none.clone(), none], [much, some]], bodies: Vec::new() };
    let (mut keys, mut inks) = (keys::parse(&text).unwrap(), Vec::new());
    let tables = keys.tables("materials").unwrap();
    let all = read_all(tables, Path::new("."), 1.0, &mut inks, &mut interiors, Without::default());
    let all = all.unwrap_or_else(|e| panic!("{text}: {e}"));
    let material = &*all.iter().find(|m| m.0 == "m").unwrap().1;
    let srgb = Uplift::new().unwrap().basis().clone();
    for front in [true, false] {
        test(Sample { material, inks: &inks, srgb: &srgb, site: Site { front, ..Site::default() } });
    }
}

/// A direction above the surface, not grazing it.
fn above(c: &mut Chance) -> Vec3A {
    let mut d = c.direction();
    d.z = d.z.abs().max(0.02);
    d.normalize().as_vec3a()
}

/// No more light leaves than came.
#[test]
fn matter_gains_no_energy() {
    for (kind, _) in KINDS {
        holds(6, |c| {
            let matter = any(kind, c);
            let out = above(c);
            with(kind, &matter, |sample| {
                // Radiance beyond a boundary is squeezed: the power that goes there is t eta^2.
                let eta = if sample.site.front { matter.index } else { 1.0 / matter.index };
                let squeeze = if *kind == "dielectric" { eta * eta } else { 1.0 };
                for ([r, t], nm) in sample.totals(out, &WAVELENGTHS).into_iter().zip(WAVELENGTHS) {
                    let sum = r + t * squeeze;
                    assert!((-1e-6..=1.0 + 1e-3).contains(&sum), "{kind} at {nm} nm: {r} + {t}\n{}", matter.keys);
                }
            });
        });
    }
}

/// What light does on its way, it does on its way back [Helmholtz]: f(a, b) = f(b, a), through a surface as well, where the other
/// end is seen from the back and f is divided by the square of the index.
#[test]
fn matter_is_reciprocal() {
    for (kind, _) in KINDS.iter().filter(|k| k.0 != "fluorescent") {
        holds(6, |c| {
            let matter = any(kind, c);
            let ways: Vec<_> = (0..16).map(|_| (above(c), above(c))).collect();
            let mut through = [Vec::new(), Vec::new()];
            with(kind, &matter, |sample| {
                for (a, b) in ways.iter().copied() {
                    let (f, g) = (sample.scattering(a, b, &WAVELENGTHS), sample.scattering(b, a, &WAVELENGTHS));
                    for (f, g) in f.iter().zip(&g) {
                        let near = (f - g).abs() <= 2e-3 * f.abs().max(1e-3);
                        assert!(near, "{kind}: {f} {g} at {a} {b}\n{}", matter.keys);
                    }
                    let (out, inc) = if sample.site.front { (a, b) } else { (b, a) };
                    through[usize::from(sample.site.front)].extend(sample.scattering(out, -inc, &WAVELENGTHS));
                }
            });
            let squeeze = if *kind == "dielectric" { matter.index.powi(2) } else { 1.0 };
            for (g, f) in through[0].iter().zip(&through[1]) {
                let f = f * squeeze;
                assert!((f - g).abs() <= 3e-3 * g.abs().max(1e-2), "{kind}: {f} {g} through\n{}", matter.keys);
            }
        });
    }
}

/// So it is with single ways, mirrored, straight or bent: who looks along where the light came from sees as much of what comes from where
/// the eye was.
#[test]
fn single_ways_go_both_ways() {
    let mut seen = Vec::new();
    for (kind, _) in KINDS.iter().filter(|k| k.0 != "fluorescent") {
        let found = std::cell::Cell::new(0);
        holds(8, |c| {
            let matter = any(kind, c);
            let (out, nm) = (above(c), *c.of(&WAVELENGTHS));
            let mut ways = Vec::new();
            with(kind, &matter, |sample| {
                if sample.site.front {
                    ways = sample.ways(out, nm);
                }
            });
            let along = |ways: &[(Vec3A, f64)], d: Vec3A| {
                ways.iter().filter(|w| w.0.distance(d) < 1e-3).map(|w| w.1).sum::<f64>()
            };
            for inc in ways.iter().filter(|w| w.1 > 1e-6).map(|w| w.0) {
                let share = along(&ways, inc);
                let through = inc.z < 0.0;
                // Seen from the back x stays and y and z turn over.
                let over = |v: Vec3A| if through { Vec3A::new(v.x, -v.y, -v.z) } else { v };
                // Radiance beyond a boundary is squeezed, there and back.
                let squeeze = if through && *kind == "dielectric" { matter.index.powi(4) } else { 1.0 };
                with(kind, &matter, |sample| {
                    if sample.site.front == through {
                        return;
                    }
                    let back = along(&sample.ways(over(inc), nm), over(out));
                    let near = (back - share * squeeze).abs() <= 2e-3 * back.max(0.01);
                    assert!(near, "{kind} at {nm} nm: {share} there, {back} back, {out} to {inc}\n{}", matter.keys);
                });
                found.set(found.get() + 1);
            }
        });
        seen.push((*kind, found.get()));
    }
    for kind in ["mirror", "glass", "dielectric", "film", "grating", "boundary", "polarizer", "retarder"] {
        assert!(seen.iter().any(|s| s.0 == kind && s.1 > 0), "{kind} has no single ways: {seen:?}");
    }
}
