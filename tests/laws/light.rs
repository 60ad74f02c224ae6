//! Light in random scenes.

use std::fmt::Write;
use std::process::Command;

use glam::{DQuat, DVec3};

use crate::chance::{Chance, holds};
use crate::common::{floats, program, split, stdout_of};

/// Every method, and what keeps it quick.
const METHODS: [(&str, &[&str]); 6] = [
    ("path", &["--bands", "8"]),
    ("local", &["--bands", "8"]),
    ("radiosity", &["--divide", "3", "--bands", "8"]),
    ("photon", &["--photons", "20000", "--bands", "8"]),
    ("march", &["--bands", "8"]),
    ("zonal", &["--zones", "3", "--element-rays", "64", "--bands", "8"]),
];

/// A room with a ball in fog, under a lamp, a point and a strip of sky; lamps have `power` of their light.
struct Room {
    matter: String,
    lamps: [f64; 3],
    fog: String,
}

impl Room {
    fn any(c: &mut Chance) -> Room {
        let mut matter = String::new();
        for name in ["floor", "wall", "back"] {
            writeln!(matter, "[materials.{name}]\nreflectance = {}", c.spectrum(0.05, 0.9)).unwrap();
        }
        let ball = match c.whole(0, 3) {
            0 => format!("type = \"coated\"\nreflectance = {}\nroughness = {}", c.spectrum(0.0, 0.9), c.share()),
            1 => format!("type = \"conductor\"\nmetal = \"Cu\"\nroughness = {}", c.between(0.05, 1.0)),
            2 => format!("type = \"dielectric\"\nindex = {}", c.between(1.1, 2.0)),
            _ => format!("reflectance = {}", c.spectrum(0.0, 1.0)),
        };
        writeln!(matter, "[materials.ball]\n{ball}").unwrap();
        let lamps = [c.decades(10.0, 1e4), c.decades(1.0, 1e3), c.decades(0.1, 100.0)];
        let fog = format!("extinction = {}\nalbedo = {}", c.between(0.05, 1.0), c.between(0.1, 0.95));
        Room { matter, lamps, fog }
    }

    /// The scene file, with so much of the light.
    fn text(&self, power: f64) -> String {
        let [area, point, sky] = self.lamps.map(|l| l * power);
        let quad =
            |points: [[f64; 3]; 4], rest: &str| format!("[[shape]]\ntype = \"quad\"\npoints = {points:?}\n{rest}\n");
        let mut text = format!(
            "medium = \"fog\"\n[media.fog]\n{}\n{}[materials.black]\nreflectance = 0\n\
             [camera]\norigin = [0, -1.9, 1]\ntarget = [0, 2, 0.9]\nup = [0, 0, 1]\nfov_deg = 70\nwidth = 6\nheight = 4\n\
             [lights.lamp]\nspectrum = \"FL2\"\nluminance = {area:e}\n\
             [lights.bulb]\ntype = \"point\"\nposition = [-1.2, 0.3, 1.6]\nspectrum = \"A\"\ncandela = {point:e}\n\
             [environment]\ntype = \"uniform\"\nspectrum = \"D65\"\nluminance = {sky:e}\n\
             [[shape]]\ntype = \"sphere\"\ncenter = [0.4, 0.6, 0.5]\nradius = 0.5\nmaterial = \"ball\"\n",
            self.fog, self.matter
        );
        let (x, y, z) = (2.0, 2.0, 2.0);
        text += &quad([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]], "material = \"floor\"");
        text += &quad([[-x, y, 0.0], [x, y, 0.0], [x, y, z], [-x, y, z]], "material = \"back\"");
        text += &quad([[-x, -y, 0.0], [-x, y, 0.0], [-x, y, z], [-x, -y, z]], "material = \"wall\"");
        text += &quad([[x, y, 0.0], [x, -y, 0.0], [x, -y, z], [x, y, z]], "material = \"wall\"");
        let lamp = [[-0.4, 0.0, 1.9], [-0.4, 0.8, 1.9], [0.4, 0.8, 1.9], [0.4, 0.0, 1.9]];
        text + &quad(lamp, "material = \"black\"\nlight = \"lamp\"")
    }
}

/// The bytes of a picture of a scene.
fn rendered(text: &str, args: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let all = [&[path.to_str().unwrap(), "--quiet", "--samples", "4"], args].concat();
    split(&stdout_of("spectrace", &all, b"")).2.to_vec()
}

/// Twice the light, twice the picture: whatever decides where to look counts shares of the light, not its amount.
#[test]
fn radiance_is_linear_in_power() {
    holds(3, |c| {
        let (room, power) = (Room::any(c), c.decades(1e-6, 1e6));
        for (method, args) in METHODS {
            let picture = |power| floats(&rendered(&room.text(power), &[&["--method", method], args].concat()));
            let (one, much) = (picture(1.0), picture(power));
            assert!(one.iter().any(|x| *x > 0.0), "{method}: nothing is seen");
            let most = one.iter().fold(0f32, |m, x| m.max(*x));
            for (a, b) in one.iter().zip(&much) {
                let off = (f64::from(*b) / power - f64::from(*a)).abs();
                assert!(
                    off <= 1e-4 * f64::from(a.abs().max(1e-3 * most)),
                    "{method}, {power} of the light: {b} for {a}"
                );
            }
        }
    });
}

/// Rows by rows are the picture, wherever it is cut.
#[test]
fn rows_are_the_pictures() {
    holds(2, |c| {
        let room = Room::any(c).text(1.0);
        let cut = c.whole(1, 3).to_string();
        for (method, args) in METHODS {
            let part = |rows: &str| rendered(&room, &[&["--method", method, "--rows", rows], args].concat());
            let whole = rendered(&room, &[&["--method", method], args].concat());
            let parts = [part(&format!("0:{cut}")), part(&format!("{cut}:4"))].concat();
            assert!(whole == parts, "{method}, cut after row {cut}");
        }
    });
}

/// Polarised light does not know which way the world is turned: a scene and its camera turned together give the same Stokes
/// vectors, and a camera rolled by psi turns (Q, U) by 2 psi and leaves I and V.
#[test]
fn stokes_vectors_turn_with_the_world() {
    let list = |v: DVec3| format!("{:?}", v.to_array());
    holds(24, |c| {
        let turn = DQuat::from_axis_angle(c.direction(), c.between(0.0, 6.2));
        let move_by = 3.0 * c.direction();
        // From the eye through a retarder onto a metal, by way of a polariser into a sky.
        // Not head on, where the plane of incidence is a matter of rounding.
        let (tilt, (south, east)) = (c.between(0.3, 0.9), c.between(0.0, 6.2).sin_cos());
        let normal = DVec3::new(tilt * east, -1.0, tilt * south).normalize();
        // Along the sheets: an axis that stands on one has no direction there.
        let away = DVec3::Y - 2.0 * normal.y * normal;
        let along = |n: DVec3, angle: f64| DQuat::from_axis_angle(n, angle) * n.any_orthonormal_vector();
        let axes = [along(DVec3::Y, c.between(0.0, 6.2)), along(away, c.between(0.0, 6.2))];
        let retardance = c.between(20.0, 500.0);
        let metal = *c.of(&["Ag", "Al", "Au", "Cu"]);
        let square = |at: DVec3, normal: DVec3, size: f64| {
            let right = normal.any_orthonormal_vector();
            let up = normal.cross(right);
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[u, v]| at + size * (u * right + v * up))
        };
        let picture = |turn: DQuat, by: DVec3, roll: f64| {
            let place = |p: DVec3| list(turn * p + by);
            let quad = |points: [DVec3; 4], material: &str| {
                let points = points.map(place).join(", ");
                format!("[[shape]]\ntype = \"quad\"\npoints = [{points}]\nmaterial = \"{material}\"\n")
            };
            let (sheet, pane) = (square(DVec3::Y, -DVec3::Y, 0.3), square(2.0 * DVec3::Y + 0.5 * away, away, 0.2));
            let mirror = square(2.0 * DVec3::Y, normal, 0.2);
            let text = format!(
                "[camera]\norigin = {}\ntarget = {}\nup = {}\nfov_deg = 0.01\nwidth = 1\n\
                 [environment]\ntype = \"uniform\"\nspectrum = \"E\"\nradiance = 1\n\
                 [materials.mirror]\ntype = \"conductor\"\nmetal = \"{metal}\"\n\
                 [materials.sheet]\ntype = \"retarder\"\naxis = {}\nretardance_nm = {retardance}\n\
                 [materials.pane]\ntype = \"polarizer\"\naxis = {}\n{}{}{}",
                place(DVec3::ZERO),
                place(DVec3::Y),
                list(turn * DVec3::new(roll.sin(), 0.0, roll.cos())),
                list(turn * axes[0]),
                list(turn * axes[1]),
                quad(sheet, "sheet"),
                quad(pane, "pane"),
                quad(mirror, "mirror"),
            );
            floats(&rendered(&text, &["--quantity", "stokes", "--wavelengths", "450,650"]))
        };
        let roll = c.between(-3.0, 3.0);
        let (here, there, rolled) =
            (picture(DQuat::IDENTITY, DVec3::ZERO, 0.0), picture(turn, move_by, 0.0), picture(turn, move_by, roll));
        assert!(here[0] > 0.01, "nothing is seen: {here:?}");
        let (s, k) = (2.0 * roll).sin_cos();
        for ((a, b), r) in here.chunks(4).zip(there.chunks(4)).zip(rolled.chunks(4)) {
            let [i, q, u, v] = [0, 1, 2, 3].map(|n| f64::from(a[n]));
            let near =
                |got: &[f32], want: [f64; 4]| got.iter().zip(want).all(|(g, w)| (f64::from(*g) - w).abs() < 2e-4 * i);
            assert!(near(b, [i, q, u, v]), "turned: {a:?} became {b:?}");
            // A camera that leans right sees the world lean left, counter-clockwise.
            assert!(near(r, [i, q * k - u * s, q * s + u * k, v]), "rolled by {roll}: {a:?} became {r:?}");
        }
    });
}

/// Whatever registers a processor has, the bits are the same.
#[test]
fn instruction_sets_change_nothing() {
    holds(1, |c| {
        let room = Room::any(c).text(1.0);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, room).unwrap();
        for (method, args) in METHODS {
            let picture = |set: &str| {
                let all = [&[path.to_str().unwrap(), "--quiet", "--samples", "4", "--method", method], args].concat();
                let done = Command::new(program("spectrace")).args(all).env("LUXPIPE_SIMD", set).output().unwrap();
                assert!(done.status.success(), "{set}: {}", String::from_utf8_lossy(&done.stderr));
                done.stdout
            };
            let plain = picture("plain");
            assert!(plain == picture("avx2") && plain == picture("widest"), "{method}");
        }
    });
    let odd =
        Command::new(program("spectrace")).arg("scenes/cornell.toml").env("LUXPIPE_SIMD", "mmx").output().unwrap();
    let message = String::from_utf8(odd.stderr).unwrap();
    assert_eq!((odd.status.code(), message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains("LUXPIPE_SIMD=mmx") && message.contains("avx2"), "{message}");
}
