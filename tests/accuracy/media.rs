//! The cases of media: layers wide enough to have no edge, seen along rays.

use std::f64::consts::PI;

use glam::DVec3;
use luxpipe::medium::phase::{Phase, rayleigh::Rayleigh};
use luxpipe::optics::dipole::Dipole;
use luxpipe::optics::slab::{self, Shares, Slab};

use super::cases::{Case, Place, Value, list, rows};
use super::formulas::Row;

const NO_END: u32 = u32::MAX;
/// Light of the layers that have some of their own, and of what is around.
const UNIT: &str = "spectrum = \"E\"\nluminance = ";

/// A layer of a thickness of 1 m below z = 0, filled with a medium of these keys; `thick` times as thick.
fn layer(medium: &str, thick: f64) -> String {
    wide(200, medium, thick)
}

/// The same, so many metres wide to either side.
fn wide(half: u32, medium: &str, thick: f64) -> String {
    format!(
        "[media.m]\n{medium}\n[materials.b]\ntype = \"boundary\"\ninterior = \"m\"\n[[shape]]\ntype = \"box\"\nmin = [-{half}, -{half}, -{thick}]\nmax = [{half}, {half}, 0]\nmaterial = \"b\"\n"
    )
}

fn around(luminance: f64, rest: &str) -> String {
    format!("[environment]\ntype = \"uniform\"\n{UNIT}{luminance}\n{rest}\n")
}

/// A sun that lights a surface facing it by 1 lx, its light falling at a cosine; all its light within the wavelengths measured.
fn sun(cos: f64) -> String {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    format!(
        "[lights.s]\ntype = \"sun\"\nspectrum = [[400, 1], [700, 1]]\nlux = 1\ndirection = [{sin}, 0, {cos}]\ndiameter_deg = 0.001\n"
    )
}

/// Along a direction that has a cosine with the vertical, aside of the sun's plane, to the middle of a face of the layer.
fn ray(cos: f64, up: bool, thick: f64) -> Place {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let direction = if up { DVec3::new(0.0, sin, cos) } else { DVec3::new(0.0, sin, -cos) };
    let face = DVec3::new(0.0, 0.0, if up { -thick } else { 0.0 });
    Place::Ray(face - direction * 0.2, direction)
}

fn value(label: String, scene: usize, place: Place, want: f64, tolerance: f64) -> Value {
    Value { label, scene, place, factor: 1.0, offset: 0.0, want, tolerance }
}

fn columns(t: &toml::Table, id: &str) -> Vec<String> {
    t[id]["columns"].as_array().unwrap().iter().map(|c| c.as_str().unwrap().to_string()).collect()
}

/// Those that a renderer measures.
pub fn all(t: &toml::Table) -> Vec<Case> {
    let mut cases = absorbing(t);
    cases.push(furnace(t));
    cases.push(single(t));
    cases.extend(layers(t));
    cases.push(half_spaces(t));
    cases
}

fn absorbing(t: &toml::Table) -> Vec<Case> {
    let id = "beer-lambert-homogeneous";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (i, depth) in list(t, id, "sigma_a_d").into_iter().enumerate() {
        scenes.push((format!("{}{}", layer(&format!("absorption = {depth}"), 1.0), around(1.0, "")), NO_END));
        for (key, cos) in [("T_normal", 1.0), ("T_60deg", 0.5)] {
            // The table has 1e-8 for its last place.
            let want = list(t, id, key)[i];
            values.push(value(format!("{key}, depth {depth}"), i, ray(cos, false, 1.0), want, (1e-5 * want).max(1e-8)));
        }
    }
    let mut cases = vec![Case { id: id.into(), scenes, values }];
    let id = "beer-lambert-emission";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (i, (depth, want)) in list(t, id, "tau").into_iter().zip(list(t, id, "L")).enumerate() {
        let keys = format!("absorption = {depth}\nemission = \"E\"\nluminance = 1");
        scenes.push((format!("{}{}", layer(&keys, 1.0), around(0.25, "")), NO_END));
        values.push(value(format!("depth {depth}"), i, ray(1.0, false, 1.0), want, 1e-5 * want));
    }
    cases.push(Case { id: id.into(), scenes, values });
    cases
}

fn furnace(t: &toml::Table) -> Case {
    let id = "furnace-thermal-medium";
    let want = list(t, id, "L")[0];
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (i, albedo) in [0.0, 0.5, 0.9, 1.0 - 1e-9, 1.0].into_iter().enumerate() {
        let keys = format!("extinction = 3\nalbedo = {albedo}\nemission = \"E\"\nluminance = 1");
        scenes.push((format!("{}{}", layer(&keys, 1.0), around(1.0, "")), NO_END));
        for cos in [1.0, 0.3] {
            values.push(value(format!("albedo {albedo}, cosine {cos}"), i, ray(cos, false, 1.0), want, 0.005));
        }
        let inside = Place::Ray(DVec3::new(0.0, 0.0, -0.3), DVec3::new(0.6, 0.0, 0.8));
        values.push(value(format!("albedo {albedo}, from inside"), i, inside, want, 0.005));
    }
    Case { id: id.into(), scenes, values }
}

fn single(t: &toml::Table) -> Case {
    let id = "single-scatter-slab";
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (i, row) in rows(t, id, "rows").iter().enumerate() {
        let [albedo, depth, mu0, mu, back, on] = row[..] else { panic!("{:?}", columns(t, id)) };
        let keys = format!("extinction = {depth}\nalbedo = {albedo}");
        // Light that scatters once leaves near where it came in; floats are as fine as the scene is small.
        scenes.push((format!("{}{}", wide(20, &keys, 1.0), sun(mu0)), 1));
        let label = |what: &str| format!("{what}, albedo {albedo}, depth {depth}, cosines {mu0} and {mu}");
        // What is exact to eight digits; aside of the sun itself.
        let (up, down) = (ray(mu.min(1.0 - 1e-9), true, 1.0), ray(mu, false, 1.0));
        values.push(value(label("back"), i, down, back, 1e-4 * back));
        values.push(value(label("on"), i, up, on, 1e-4 * on));
    }
    Case { id: id.into(), scenes, values }
}

/// One case a row of the table: by reciprocity the share of a beam is the radiance under a sky of 1.
fn layers(t: &toml::Table) -> Vec<Case> {
    let id = "slab-isotropic-table";
    let sky = around(1.0, "upper_half = true");
    let one = |row: &Vec<f64>| {
        let scene = layer(&format!("extinction = {}\nalbedo = {}", row[1], row[0]), 1.0);
        let label = |what: &str| format!("{what}, albedo {}, depth {}", row[0], row[1]);
        let mut values = Vec::new();
        for (name, want) in columns(t, id).iter().zip(row).skip(2) {
            let up = name.starts_with('T');
            let place = match name.split_once('_').map_or("", |n| n.1) {
                "mu1" => ray(1.0, up, 1.0),
                "mu05" => ray(0.5, up, 1.0),
                "mu01" => ray(0.1, up, 1.0),
                _ if up => Place::Point(DVec3::new(0.0, 0.0, -1.05), DVec3::Z),
                _ => Place::Point(DVec3::new(0.0, 0.0, 0.05), -DVec3::Z),
            };
            let factor = if matches!(place, Place::Point(..)) { 1.0 / PI } else { 1.0 };
            values.push(Value { factor, ..value(label(name), 0, place, *want, 5e-4) });
        }
        Case { id: id.into(), scenes: vec![(format!("{scene}{sky}"), NO_END)], values }
    };
    rows(t, id, "rows").iter().map(one).collect()
}

/// Radiance of a half space under a sun: w / 4 pi mu0 / (mu + mu0) H H. Light of albedo 1 takes a way without end there.
fn half_spaces(t: &toml::Table) -> Case {
    let id = "halfspace-H-function";
    let (mu, h) = (list(t, id, "mu"), rows(t, id, "H"));
    let (mut scenes, mut values) = (Vec::new(), Vec::new());
    for (albedo, h) in list(t, id, "albedo").into_iter().zip(&h).filter(|a| a.0 < 1.0) {
        for (from, to) in [(1, 2), (4, 7)] {
            let (mu0, mu) = (mu[from], mu[to]);
            let medium = layer(&format!("extinction = 5\nalbedo = {albedo}"), 10.0);
            scenes.push((format!("{medium}{}", sun(mu0)), NO_END));
            let k = albedo / (4.0 * PI) * mu0 / (mu + mu0);
            let (want, tolerance) = (k * h[from] * h[to], 5e-4 * k * (h[from] + h[to]));
            let label = format!("albedo {albedo}, from {mu0} to {mu}");
            values.push(value(label, scenes.len() - 1, ray(mu, false, 10.0), want, tolerance));
        }
    }
    Case { id: id.into(), scenes, values }
}

/// Those that formulas and the slab's solver answer, as `specprobe` prints them.
pub fn formulas(t: &toml::Table) -> Vec<Row> {
    let mut all = Vec::new();
    let mut row = |id: &str, what: String, want: f64, got: f64, tolerance: f64| {
        all.push(Row(id.into(), what, want, got, tolerance));
    };
    let isotropic = |_: f64| 1.0;
    let slab = |optical_depth, albedo, eta, cosines: &[f64]| {
        slab::measure(&Slab { optical_depth, albedo, eta }, &isotropic, cosines)
    };
    let id = "slab-isotropic-table";
    for r in rows(t, id, "rows") {
        let (beams, diffuse) = slab(r[1], r[0], 1.0, &[1.0, 0.5, 0.1]);
        let got = beams.iter().chain([&diffuse]).flat_map(|s: &Shares| [s.reflectance, s.transmittance]);
        for ((name, want), got) in columns(t, id).iter().zip(&r).skip(2).zip(got) {
            row(id, format!("slab, {name}, albedo {}, depth {}", r[0], r[1]), *want, got, 5e-4);
        }
    }
    let id = "halfspace-H-function";
    let (mu, albedos) = (list(t, id, "mu"), list(t, id, "albedo"));
    for (i, albedo) in albedos.iter().enumerate() {
        let (beams, diffuse) = slab(f64::INFINITY, *albedo, 1.0, &mu[1..]);
        for ((mu, want), got) in mu.iter().zip(&rows(t, id, "plane_albedo")[i]).skip(1).zip(beams) {
            row(id, format!("plane albedo, albedo {albedo}, cosine {mu}"), *want, got.reflectance, 5e-4);
        }
        let want = list(t, id, "spherical_albedo")[i];
        row(id, format!("spherical albedo, albedo {albedo}"), want, diffuse.reflectance, 5e-4);
    }
    let id = "beer-lambert-homogeneous";
    for (depth, want) in list(t, id, "sigma_a_d").into_iter().zip(list(t, id, "T_diffuse_2E3")) {
        let (_, diffuse) = slab(depth, 0.0, 1.0, &[]);
        row(id, format!("diffuse, depth {depth}"), want, diffuse.transmittance, 1e-5 * want);
    }
    let id = "dipole-total-reflectance";
    let names: Vec<&str> = t[id]["names"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    let table = |key| rows(t, id, key);
    let (scattering, absorption, eta) = (table("sigma_s_prime"), table("sigma_a"), list(t, id, "eta"));
    for (i, name) in names.iter().enumerate() {
        for k in 0..3 {
            let what = |of: &str| format!("{name}, channel {k}, {of}");
            let (s, a) = (scattering[i][k], absorption[i][k]);
            let total = |eta: f64| Dipole::new(s, a, eta).total();
            row(id, what("its index"), table("Rd_dipole_formula")[i][k], total(eta[i]), 1e-4);
            row(id, what("index 1.5"), table("Rd_dipole_eta1.5")[i][k], total(1.5), 1e-4);
            // Published to two digits; the paper's formula is 0.026 off its own table at one of them.
            if (*name, k) != ("Chicken1", 2) {
                row(id, what("as published"), table("published_diffuse_reflectance")[i][k], total(eta[i]), 0.02);
            }
            let exact = slab(f64::INFINITY, s / (s + a), eta[i], &[1.0]).0[0];
            let want = table("R_exact_isotropic_RTE_diffuse_part_normal_incidence")[i][k];
            row(id, what("transport"), want, exact.reflectance - exact.specular, 1e-4);
        }
    }
    let id = "dipole-radial-profile";
    let marble = Dipole::new(2.62, 0.0041, 1.5);
    for (r, want) in list(t, id, "r_mm").into_iter().zip(list(t, id, "Rd_per_mm2")) {
        row(id, format!("{r} mm"), want, marble.radial(r), 1e-4 * want);
    }
    let integral = list(t, id, "integral")[0];
    row(id, "integral".into(), integral, marble.total(), 1e-4 * integral);
    let id = "pol-rayleigh";
    for (deg, want) in list(t, id, "theta_deg").into_iter().zip(list(t, id, "phase_norm_4pi")) {
        let versine = 1.0 - deg.to_radians().cos();
        let got = 4.0 * PI * f64::from(Rayleigh.value(versine as f32));
        row(id, format!("phase function, {deg} deg"), want, got, 1e-6);
    }
    all
}
