//! The cases, group by group.

use super::cases::{Case, Place, Value, list, rows};
use glam::DVec3;

const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;
const NO_END: u32 = u32::MAX;

/// A black ball below the ground, so that a scene has a surface.
const FAR: &str = "[materials.black]\nreflectance = 0\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, -3]\nradius = 0.5\nmaterial = \"black\"\n";

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn quad(points: [DVec3; 4], material: &str, rest: &str) -> String {
    let p: Vec<String> = points.iter().map(|p| format!("[{}, {}, {}]", p.x, p.y, p.z)).collect();
    format!("[[shape]]\ntype = \"quad\"\npoints = [{}]\nmaterial = \"{material}\"\n{rest}\n", p.join(", "))
}

/// A rectangle by a corner and two sides; front is that of u x v.
fn rectangle(corner: DVec3, u: DVec3, w: DVec3, material: &str, rest: &str) -> String {
    quad([corner, corner + u, corner + u + w, corner + w], material, rest)
}

fn case(id: &str, scenes: Vec<(String, u32)>, values: Vec<Value>) -> Case {
    Case { id: id.to_string(), scenes, values }
}

fn value(label: String, place: Place, want: f64, tolerance: f64) -> Value {
    Value { label, scene: 0, place, factor: 1.0, offset: 0.0, want, tolerance }
}

/// Values at places along a line.
fn along(name: &str, at: &[f64], want: &[f64], rel: f64, place: impl Fn(f64) -> Place) -> Vec<Value> {
    // An exact zero is held to the tolerance of the largest.
    let most = want.iter().fold(0.0, |a: f64, b| a.max(*b));
    let one = |(x, want): (&f64, &f64)| {
        let tolerance = rel * if *want == 0.0 { 0.01 * most } else { *want };
        value(format!("{name} {x}"), place(*x), *want, tolerance)
    };
    at.iter().zip(want).map(one).collect()
}

/// All cases that a renderer measures; the closed formulas of glass and Fresnel have tests of their own.
pub fn all(t: &toml::Table) -> Vec<Case> {
    let mut all = direct(t);
    all.push(close_light());
    all.push(patch(t));
    all.extend(form_factors(t));
    all.extend(spheres(t));
    all.extend(boxes(t));
    all.extend(furnaces(t));
    all.extend(super::media::all(t));
    all.push(corridor(t));
    all.extend(polarization(t));
    all.push(skies(t));
    all.push(roof(t));
    all.push(facade(t));
    all
}

fn direct(t: &toml::Table) -> Vec<Case> {
    let point = |rest: &str| {
        format!("{FAR}[lights.p]\ntype = \"point\"\nspectrum = \"E\"\nposition = [0, 0, 3]\ncandela = 1000\n{rest}")
    };
    let mut cases = Vec::new();
    let id = "cie5.2-point-isotropic";
    let up = |x: f64| Place::Point(v(x, 0.0, 0.0), Z);
    let x = list(t, id, "x_m");
    cases.push(case(id, vec![(point(""), NO_END)], along("x", &x, &list(t, id, "E_lux"), 1e-4, up)));
    let id = "cie5.2-point-cosine";
    let mut values = along("horizontal, x", &x, &list(t, id, "E_h_lux"), 1e-4, up);
    values.extend(along("vertical, x", &x, &list(t, id, "E_v_lux"), 1e-4, |x| Place::Point(v(x, 0.0, 0.0), -X)));
    cases.push(case(id, vec![(point("cosine_power = 1\ndirection = [0, 0, -1]"), NO_END)], values));
    let lamp = "[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = \"E\"\nluminance = 1000\n";
    let id = "cie5.3-area-disc";
    let disk = format!(
        "{lamp}[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 2]\nnormal = [0, 0, -1]\nradius = 0.5\nmaterial = \"black\"\nlight = \"l\"\n"
    );
    cases.push(case(id, vec![(disk, NO_END)], along("x", &x, &list(t, id, "E_lux"), 1e-3, up)));
    let id = "cie5.3-area-square";
    let square = format!("{lamp}{}", rectangle(v(-0.5, -0.5, 3.0), Y, X, "black", "light = \"l\""));
    let mut values = along("horizontal, x", &x, &list(t, id, "E_h_lux"), 1e-3, up);
    let z = list(t, id, "z_m");
    values.extend(along("vertical, z", &z, &list(t, id, "E_v_lux"), 1e-3, |z| Place::Point(v(2.0, 0.0, z), -X)));
    cases.push(case(id, vec![(square, NO_END)], values));
    let id = "direct-sun-0.533deg";
    let zenith = list(t, id, "zenith_deg");
    let sun = |deg: &f64| {
        let (s, c) = deg.to_radians().sin_cos();
        let text =
            format!("{FAR}[lights.s]\ntype = \"sun\"\nspectrum = \"E\"\nluminance = 1\ndirection = [{s}, 0, {c}]\n");
        (text, NO_END)
    };
    let mut values = along("zenith angle", &zenith, &list(t, id, "E"), 1e-4, |_| up(0.0));
    values.iter_mut().enumerate().for_each(|(i, v)| v.scene = i);
    cases.push(case(id, zenith.iter().map(sun).collect(), values));
    cases
}

/// Illuminance under the corner of a parallel a x b rectangle of luminance 1 at height h (Lambert's formula).
fn corner(a: f64, b: f64, h: f64) -> f64 {
    let half = |a: f64, b: f64| {
        let root = (h * h + a * a).sqrt();
        a / root * (b / root).atan()
    };
    0.5 * (half(a, b) + half(b, a))
}

/// A light of 4 x 4 m, 0.1 m above a plane: nearly a uniform sky in the middle.
fn close_light() -> Case {
    let text = format!(
        "[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = \"E\"\nluminance = 1000\n{}",
        rectangle(v(-2.0, -2.0, 0.1), Y * 4.0, X * 4.0, "black", "light = \"l\"")
    );
    let x = [0.0, 1.0, 1.9, 1.99, 2.0, 2.05, 2.5];
    // Four corners; outside one pair counts against the other.
    let under = |x: f64| 2000.0 * (corner(2.0 + x, 2.0, 0.1) + (2.0 - x).signum() * corner((2.0 - x).abs(), 2.0, 0.1));
    let want: Vec<f64> = x.iter().map(|x| under(*x)).collect();
    case("close-light-4x4", vec![(text, NO_END)], along("x", &x, &want, 1e-3, |x| Place::Point(v(x, 0.0, 0.0), Z)))
}

fn patch(t: &toml::Table) -> Case {
    let id = "cie5.6-diffuse-patch";
    // The sun must not graze the wall, and a disk of 0.001 degrees is as good as parallel light.
    let text = format!(
        "[materials.grey]\nreflectance = 0.5\ntwo_sided = false\n[lights.s]\ntype = \"sun\"\nspectrum = \"E\"\nlux = 1000\ndirection = [0, 0, 1]\ndiameter_deg = 0.001\n{}",
        rectangle(v(-2.0, 0.5, 0.0), X * 4.0, Y * 4.0, "grey", "")
    );
    let wall = list(t, id, "wall_z_m");
    let mut values = along("wall, z", &wall, &list(t, id, "wall_C"), 2e-3, |z| Place::Point(v(0.0, 0.0, z), Y));
    let ceiling = list(t, id, "ceiling_y_m");
    values.extend(along("ceiling, y", &ceiling, &list(t, id, "ceiling_C"), 2e-3, |y| Place::Point(v(0.0, y, 3.0), -Z)));
    values.iter_mut().for_each(|v| v.factor = 1.0 / 500.0);
    case(id, vec![(text, NO_END)], values)
}

/// Exitance 1 from a surface.
const EXITS_1: &str =
    "[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = \"E\"\nluminance = 0.3183098861837907\n";

fn form_factors(t: &toml::Table) -> Vec<Case> {
    let mut cases = Vec::new();
    // What leaves 1 and meets 2 is, by reciprocity, the mean illuminance of 1 from exitance 1 of 2.
    let mut collect = |id: &str, of: &str, want: Vec<f64>, each: &dyn Fn(&[f64]) -> (String, Place)| {
        let mut scenes = Vec::new();
        let mut values = Vec::new();
        for (i, (sizes, want)) in rows(t, id, of).iter().zip(&want).enumerate() {
            let (text, place) = each(sizes);
            scenes.push((format!("{EXITS_1}{text}"), NO_END));
            let mut value = value(format!("{sizes:?}"), place, *want, 2e-3 * want);
            value.scene = i;
            values.push(value);
        }
        cases.push(case(id, scenes, values));
    };
    let id = "ff-parallel-rect";
    collect(id, "abc", list(t, id, "F12"), &|s| {
        let (u, w) = (X * s[0], Y * s[1]);
        (rectangle(v(0.0, 0.0, s[2]), w, u, "black", "light = \"l\""), Place::Area(DVec3::ZERO, u, w))
    });
    let id = "ff-perpendicular-rect";
    collect(id, "lwh", list(t, id, "F12"), &|s| {
        let (l, w, h) = (X * s[0], Y * s[1], Z * s[2]);
        (rectangle(DVec3::ZERO, h, l, "black", "light = \"l\""), Place::Area(DVec3::ZERO, l, w))
    });
    let id = "ff-coaxial-discs";
    collect(id, "r1r2h", list(t, id, "F12"), &|s| {
        let disk = format!(
            "[[shape]]\ntype = \"disk\"\ncenter = [0, 0, {}]\nnormal = [0, 0, -1]\nradius = {}\nmaterial = \"black\"\nlight = \"l\"\n",
            s[2], s[1]
        );
        (disk, Place::Disk(DVec3::ZERO, Z, s[0]))
    });
    let id = "ff-cube-closure";
    let text = format!("{EXITS_1}{}", walls([1.0; 3], &["black"; 6], &["light = \"l\""; 6]));
    let one = list(t, id, "closure")[0];
    let values = vec![value("closure".into(), Place::Area(DVec3::ZERO, X, Y), one, 2e-3)];
    cases.push(case(id, vec![(text, NO_END)], values));
    cases
}

/// The inside of a box at the origin: x-, x+, y-, y+, floor, ceiling.
fn walls([a, b, c]: [f64; 3], materials: &[&str; 6], rest: &[&str; 6]) -> String {
    let (x, y, z) = (X * a, Y * b, Z * c);
    let o = DVec3::ZERO;
    let all = [(o, y, z), (o + x, z, y), (o, z, x), (o + y, x, z), (o, x, y), (o + z, y, x)];
    all.iter().zip(materials).zip(rest).map(|(((o, u, w), m), r)| rectangle(*o, *u, *w, m, r)).collect()
}

fn spheres(t: &toml::Table) -> Vec<Case> {
    let text = |rho: f64, rest: &str| {
        format!(
            "[materials.wall]\nreflectance = {rho}\n[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\ninward = true\nmaterial = \"wall\"\n{rest}"
        )
    };
    let lamp = "[lights.p]\ntype = \"point\"\nspectrum = \"E\"\nposition = [0.3, 0.2, -0.1]\nlumens = 1000\n";
    let bottom = Place::Point(-Z, Z);
    // Direct light on the wall at (0, 0, -1).
    let to = v(0.3, 0.2, -0.1) + Z;
    let straight = 1000.0 / (4.0 * std::f64::consts::PI) * to.z / to.length().powi(3);
    let id = "cie5.8-sphere-indirect";
    let mut values = Vec::new();
    let rho = list(t, id, "rho");
    for (i, (rho, want)) in rho.iter().zip(list(t, id, "E_indirect_lux")).enumerate() {
        let tolerance = if *rho >= 0.95 { 0.01 * want } else { (0.005 * want).max(0.005 * 4.188288) };
        let label = format!("reflectance {rho}");
        let place = Place::Point(-Z, Z);
        values.push(Value { label, scene: i, place, factor: 1.0, offset: -straight, want, tolerance });
    }
    let scenes = rho.iter().map(|r| (text(*r, lamp), NO_END)).collect();
    let mut cases = vec![case(id, scenes, values)];
    let id = "sphere-bounce-truncation";
    let bounces = list(t, id, "bounces");
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for rho in [0.5, 0.8, 0.95] {
        for (n, want) in bounces.iter().zip(list(t, id, &format!("ratio_rho{rho}"))) {
            let all = 1000.0 / (4.0 * std::f64::consts::PI) * rho / (1.0 - rho);
            scenes.push((text(rho, lamp), *n as u32));
            let label = format!("reflectance {rho}, {n} bounces");
            let (scene, place) = (scenes.len() - 1, Place::Point(-Z, Z));
            values.push(Value {
                label,
                scene,
                place,
                factor: 1.0 / all,
                offset: -straight / all,
                want,
                tolerance: 1e-3 * want,
            });
        }
    }
    cases.push(case(id, scenes, values));
    let id = "sphere-port-spot";
    // A beam of 20 degrees leaves the wall outside its spot as one of 2 would, and is found sooner. The port is the flat
    // disk over a cap of 2 % of the area: 1 - cos = 0.04.
    let cos = 1.0 - 2.0 * 0.02;
    let radius = (1.0f64 - cos * cos).sqrt();
    let rest = format!(
        "[materials.port]\nreflectance = 0\n[[shape]]\ntype = \"disk\"\ncenter = [{cos}, 0, 0]\nnormal = [-1, 0, 0]\nradius = {radius}\nmaterial = \"port\"\n[lights.beam]\ntype = \"spot\"\nspectrum = \"E\"\nposition = [0, 0, 0]\ndirection = [0, 0, 1]\nfield_deg = 20\nlumens = 1\n"
    );
    let want = list(t, id, "E_wall")[0];
    cases.push(case(id, vec![(text(0.97, &rest), NO_END)], vec![value("wall".into(), bottom, want, 0.01 * want)]));
    cases
}

fn boxes(t: &toml::Table) -> Vec<Case> {
    let mut cases = Vec::new();
    let rooms = [
        ("radiosity-cube-A", [1.0; 3], [0.5; 6], 1.0),
        ("radiosity-room-C", [4.0, 4.0, 3.0], [0.5, 0.5, 0.5, 0.5, 0.2, 0.7], 100.0),
    ];
    for (id, size, rho, exitance) in rooms {
        let materials: String = (0..6).map(|i| format!("[materials.m{i}]\nreflectance = {}\n", rho[i])).collect();
        let luminance = exitance / std::f64::consts::PI;
        let lamp = format!("[lights.l]\nspectrum = \"E\"\nluminance = {luminance}\n");
        let text = format!(
            "{materials}{lamp}{}",
            walls(size, &["m0", "m1", "m2", "m3", "m4", "m5"], &["", "", "", "", "", "light = \"l\""])
        );
        let [a, b, c] = size;
        let (x, y, z) = (X * a, Y * b, Z * c);
        let sides = [(DVec3::ZERO, y, z), (x, z, y), (DVec3::ZERO, z, x), (y, x, z), (DVec3::ZERO, x, y), (z, y, x)];
        let names = ["x-", "x+", "y-", "y+", "floor", "ceiling"];
        let (means, centres) = (list(t, id, "mean_B_continuous"), list(t, id, "centre_B_continuous"));
        let mut values = Vec::new();
        // One of four like walls, floor and ceiling. B = exitance + reflectance x illuminance.
        for i in [0, 4, 5] {
            let (o, u, w) = sides[i];
            let offset = if i == 5 { exitance } else { 0.0 };
            let one = |label, place, want, rel: f64| Value {
                label,
                scene: 0,
                place,
                factor: rho[i],
                offset,
                want,
                tolerance: rel * want,
            };
            values.push(one(format!("{}, mean", names[i]), Place::Area(o, u, w), means[i], 0.005));
            let middle = Place::Point(o + (u + w) * 0.5, u.cross(w).normalize());
            values.push(one(format!("{}, centre", names[i]), middle, centres[i], 0.01));
        }
        cases.push(case(id, vec![(text, NO_END)], values));
    }
    let id = "parallel-plates-infinite";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (i, r) in rows(t, id, "r1r2").iter().enumerate() {
        let head = format!(
            "[materials.m1]\nreflectance = {}\n[materials.m2]\nreflectance = {}\n[materials.mirror]\ntype = \"mirror\"\nreflectance = 1\n[lights.l]\nspectrum = \"E\"\nluminance = {}\n",
            r[0],
            r[1],
            std::f64::consts::FRAC_1_PI
        );
        let m = "mirror";
        let text = walls([1.0; 3], &[m, m, m, m, "m1", "m2"], &["", "", "", "", "light = \"l\"", ""]);
        scenes.push((format!("{head}{text}"), NO_END));
        let (b1, b2) = (list(t, id, "B1")[i], list(t, id, "B2")[i]);
        let floor = Place::Point(v(0.5, 0.5, 0.0), Z);
        let ceiling = Place::Point(v(0.4, 0.3, 1.0), -Z);
        values.push(Value {
            label: format!("B1 {r:?}"),
            scene: i,
            place: floor,
            factor: r[0],
            offset: 1.0,
            want: b1,
            tolerance: 0.005 * b1,
        });
        values.push(Value {
            label: format!("B2 {r:?}"),
            scene: i,
            place: ceiling,
            factor: r[1],
            offset: 0.0,
            want: b2,
            tolerance: 0.005 * b2,
        });
    }
    cases.push(case(id, scenes, values));
    cases
}

const AROUND: &str = "[environment]\ntype = \"uniform\"\nspectrum = \"E\"\nluminance = 1\n";

fn furnaces(t: &toml::Table) -> Vec<Case> {
    let ball = |material: &str| {
        format!(
            "{AROUND}[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n[materials.m]\n{material}\n"
        )
    };
    let look = |y: f64| Place::Ray(v(-4.0, y, 0.1), X);
    let id = "white-furnace-lambert";
    let concave = format!(
        "{}[[shape]]\ntype = \"box\"\nmin = [-1.4, 0.5, -1]\nmax = [-0.6, 1.5, 1]\nmaterial = \"m\"\n",
        ball("reflectance = 1")
    );
    let values = [0.0, 0.3, 0.49, 0.8].map(|y| value(format!("y {y}"), look(y), list(t, id, "L")[0], 0.005));
    let mut cases = vec![case(id, vec![(concave, NO_END)], values.into())];
    let id = "grey-furnace-convex";
    let rho = list(t, id, "rho");
    let mut values = along("reflectance", &rho, &list(t, id, "L"), 0.003, |_| look(0.6));
    values.iter_mut().enumerate().for_each(|(i, v)| v.scene = i);
    cases.push(case(id, rho.iter().map(|r| (ball(&format!("reflectance = {r}")), NO_END)).collect(), values));
    let id = "furnace-inside-dielectric";
    let want = list(t, id, "L_inside")[0];
    let inside = |p: DVec3, d: DVec3| value(format!("from {p} to {d}"), Place::Ray(p, d), want, 0.005 * want);
    let values = vec![inside(DVec3::ZERO, X), inside(v(0.3, 0.2, 0.1), v(0.2, 1.0, 0.3))];
    cases.push(case(id, vec![(ball("type = \"dielectric\"\nindex = 1.5"), NO_END)], values));
    cases
}

fn corridor(t: &toml::Table) -> Case {
    let id = "mirror-corridor";
    let far = 2000.0;
    let sides = format!(
        "{}{}",
        rectangle(v(0.0, -far, -far), Y * 2.0 * far, Z * 2.0 * far, "mirror", ""),
        rectangle(v(1.0, -far, -far), Z * 2.0 * far, Y * 2.0 * far, "mirror", "")
    );
    let text = format!(
        "[materials.mirror]\ntype = \"mirror\"\nreflectance = 0.9\n[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = \"E\"\nluminance = 1\n{sides}{}",
        rectangle(v(0.0, -far, 1.0), Y * 2.0 * far, X, "black", "light = \"l\"")
    );
    // A ray that goes k widths across while it goes one along crosses k walls.
    let k = list(t, id, "k");
    let values = along("reflections", &k, &list(t, id, "L"), 1e-4, |k| Place::Ray(v(0.5, 0.0, 0.0), v(k, 0.0, 1.0)));
    case(id, vec![(text, NO_END)], values)
}

/// A lamp of luminance 1 at z = 20 that faces down; all its light lies within the wavelengths that are measured.
const ABOVE: &str = "[materials.black]\nreflectance = 0\n[lights.l]\nspectrum = [[400, 1], [700, 1]]\nluminance = 1\n[[shape]]\ntype = \"disk\"\ncenter = [0, 0, 20]\nnormal = [0, 0, -1]\nradius = 50\nmaterial = \"black\"\nlight = \"l\"\n";

/// Polarisers in a row, and plates whose reflections are crossed.
fn polarization(t: &toml::Table) -> Vec<Case> {
    let id = "pol-malus";
    let sheets = |angles: &[f64]| {
        let sheet = |(i, deg): (usize, &f64)| {
            let (s, c) = deg.to_radians().sin_cos();
            let z = 1.0 + i as f64;
            format!(
                "[materials.p{i}]\ntype = \"polarizer\"\naxis = [{c}, {s}, 0]\n{}",
                rectangle(v(-5.0, -5.0, z), X * 10.0, Y * 10.0, &format!("p{i}"), "")
            )
        };
        format!("{ABOVE}{}", angles.iter().enumerate().map(sheet).collect::<String>())
    };
    let up = || Place::Ray(DVec3::ZERO, Z);
    let theta = list(t, id, "theta_deg");
    let mut scenes: Vec<(String, u32)> = theta.iter().map(|deg| (sheets(&[0.0, *deg]), NO_END)).collect();
    let s0 = list(t, id, "S0");
    let mut values: Vec<Value> =
        theta.iter().zip(&s0).map(|(d, w)| value(format!("{d} deg"), up(), *w, 1e-6)).collect();
    scenes.push((sheets(&[0.0, 45.0, 90.0]), NO_END));
    values.push(value("three".into(), up(), list(t, id, "three_polarizers_0_45_90")[0], 1e-6));
    for (n, want) in list(t, id, "N_stack_total90_N").iter().zip(list(t, id, "N_stack_S0 (first at 0, equal steps)")) {
        let angles: Vec<f64> = (0..*n as u32).map(|i| 90.0 * f64::from(i) / (n - 1.0)).collect();
        scenes.push((sheets(&angles), NO_END));
        values.push(value(format!("{n} sheets"), up(), want, 1e-6));
    }
    values.iter_mut().enumerate().for_each(|(i, v)| v.scene = i);
    let mut cases = vec![case(id, scenes, values)];
    let id = "pol-two-plates";
    // The eye looks along +x at a plate that sends it up to another, which turns about that way: black glass, so that a front
    // surface is all there is.
    let brewster = 1.5f64.atan();
    let mut scenes = Vec::new();
    let mut values = Vec::new();
    for (phi, want) in list(t, id, "phi_deg").iter().zip(list(t, id, "L")) {
        let mirrored = |d: DVec3, n: DVec3| d - n * (2.0 * d.dot(n));
        // Against the light, at Brewster's angle to the way.
        let facing = |d: DVec3, across: DVec3| -d * brewster.cos() + across * brewster.sin();
        let n1 = facing(X, Z);
        let d1 = mirrored(X, n1);
        let (s1, p1) = (d1.cross(n1).normalize(), d1.cross(d1.cross(n1)).normalize());
        let turn = phi.to_radians();
        let n2 = facing(d1, p1 * turn.cos() + s1 * turn.sin());
        let d2 = mirrored(d1, n2);
        let disk = |c: DVec3, n: DVec3, r: f64, material: &str, rest: &str| {
            format!(
                "[[shape]]\ntype = \"disk\"\ncenter = [{}, {}, {}]\nnormal = [{}, {}, {}]\nradius = {r}\nmaterial = \"{material}\"\n{rest}",
                c.x, c.y, c.z, n.x, n.y, n.z
            )
        };
        let text = format!(
            "polarization = true\n[materials.black]\nreflectance = 0\n[materials.plate]\ntype = \"conductor\"\nn = 1.5\nk = 0\n[lights.l]\nspectrum = \"E\"\nluminance = 1\n{}{}{}",
            disk(X * 5.0, n1, 0.5, "plate", ""),
            disk(X * 5.0 + d1 * 5.0, n2, 0.5, "plate", ""),
            disk(X * 5.0 + d1 * 5.0 + d2 * 5.0, -d2, 1.0, "black", "light = \"l\"\n"),
        );
        values.push(value(format!("{phi} deg"), Place::Ray(DVec3::ZERO, X), want, 1e-5));
        scenes.push((text, NO_END));
    }
    values.iter_mut().enumerate().for_each(|(i, v)| v.scene = i);
    cases.push(case(id, scenes, values));
    cases
}

fn sky(kind: u32) -> String {
    format!(
        "[environment]\ntype = \"cie\"\nsky = {kind}\nsun = [0, -0.5, 0.8660254037844386]\nspectrum = \"E\"\nluminance = 1\n"
    )
}

fn skies(t: &toml::Table) -> Case {
    let id = "sky-cie15-horizontal";
    let want = list(t, id, "Eh_over_Lz");
    let kinds: Vec<f64> = (1..=15).map(f64::from).collect();
    let mut values = along("type", &kinds, &want, 2e-3, |_| Place::Point(DVec3::ZERO, Z));
    values.iter_mut().enumerate().for_each(|(i, v)| v.scene = i);
    case(id, (1..=15).map(|k| (format!("{FAR}{}", sky(k)), NO_END)).collect(), values)
}

const PANE: &str = "[materials.pane]\ntype = \"glass\"\nindex = 1.52\ndepth = 0.03\n";

/// Horizontal illuminance under a sky, from its own case.
fn horizontal(t: &toml::Table, kind: u32) -> f64 {
    list(t, "sky-cie15-horizontal", "Eh_over_Lz")[kind as usize - 1]
}

fn roof(t: &toml::Table) -> Case {
    let id = "cie5.9-5.10-roof-opening-4x4";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for kind in [1, 5, 12, 15] {
        for glazed in [false, true] {
            let corner = v(-2.0, -2.0, 0.0);
            let (x, y, z) = (X * 4.0, Y * 4.0, Z * 3.0);
            let sides = [(corner, y, z), (corner + x, z, y), (corner, z, x), (corner + y, x, z), (corner, x, y)];
            let mut text = format!("{}[materials.black]\nreflectance = 0\n", sky(kind));
            text += &sides.iter().map(|(o, u, w)| rectangle(*o, *u, *w, "black", "")).collect::<String>();
            if glazed {
                text += &format!("{PANE}{}", rectangle(corner + z, x, y, "pane", ""));
            }
            let key = format!("SC_{}percent_type{kind}", if glazed { "glazed_" } else { "" });
            let name = format!("type {kind}{}, x", if glazed { ", glazed" } else { "" });
            let mut some =
                along(&name, &list(t, id, "x_m"), &list(t, id, &key), 0.01, |x| Place::Point(v(x, 0.0, 0.0), Z));
            some.iter_mut().for_each(|v| (v.scene, v.factor) = (scenes.len(), 100.0 / horizontal(t, kind)));
            values.extend(some);
            scenes.push((text, NO_END));
        }
    }
    case(id, scenes, values)
}

fn facade(t: &toml::Table) -> Case {
    let id = "cie5.11-5.12-facade-opening";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    let y = list(t, id, "y_m");
    for kind in [1, 5, 12] {
        for glazed in [false, true] {
            let e = horizontal(t, kind);
            let mut text = format!("{}[materials.black]\nreflectance = 0\n", sky(kind));
            // The ground of reflectance 0.3 outside is lit by the whole sky: it shines as much.
            text += &format!("[lights.ground]\nspectrum = \"E\"\nluminance = {}\n", 0.3 * e / std::f64::consts::PI);
            text += &rectangle(v(-1e5, -1e5, 0.0), X * 2e5, Y * 1e5, "black", "light = \"ground\"");
            let wall = |x: f64, z: f64, w: f64, h: f64| rectangle(v(x, 0.0, z), X * w, Z * h, "black", "");
            text += &[
                wall(-9.0, 0.0, 18.0, 1.0),
                wall(-9.0, 2.0, 18.0, 7.0),
                wall(-9.0, 1.0, 8.0, 1.0),
                wall(1.0, 1.0, 8.0, 1.0),
            ]
            .concat();
            let room = v(-9.0, 0.0, 0.0);
            let (a, b, c) = (X * 18.0, Y * 9.0, Z * 9.0);
            for (o, u, w) in [(room, b, c), (room + a, c, b), (room + b, a, c), (room, a, b), (room + c, b, a)] {
                text += &rectangle(o, u, w, "black", "");
            }
            if glazed {
                text += &format!("{PANE}{}", rectangle(v(-1.0, 0.0, 1.0), X * 2.0, Z, "pane", ""));
            }
            let key = format!("SC_{}percent_floor_type{kind}", if glazed { "glazed_" } else { "" });
            let name = format!("floor, type {kind}{}, y", if glazed { ", glazed" } else { "" });
            let mut some = along(&name, &y, &list(t, id, &key), 0.01, |y| Place::Point(v(0.0, y, 0.0), Z));
            if !glazed {
                let ground = list(t, id, &format!("ERC_percent_ceiling_z2.5_type{kind}"));
                let name = format!("ceiling, type {kind}, y");
                some.extend(along(&name, &y, &ground, 0.01, |y| Place::Point(v(0.0, y, 2.5), -Z)));
            }
            some.iter_mut().for_each(|v| (v.scene, v.factor) = (scenes.len(), 100.0 / e));
            values.extend(some);
            scenes.push((text, NO_END));
        }
    }
    case(id, scenes, values)
}
