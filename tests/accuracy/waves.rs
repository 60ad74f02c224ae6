//! The cases of polarization, thin films, diffraction and fluorescence that have closed formulas.

use std::f64::consts::PI;

use super::cases::{list, rows};
use super::formulas::Row;
use luxpipe::optics::film::{self, Complex64, Medium, Stack};
use luxpipe::optics::polarization::{Response, rayleigh, sheet};
use luxpipe::optics::{aperture, grating, reradiation::Reradiation};

fn cos(deg: f64) -> f64 {
    deg.to_radians().cos()
}

/// All of them.
pub fn all(t: &toml::Table) -> Vec<Row> {
    let mut rows = Vec::new();
    boundaries(t, &mut rows);
    films(t, &mut rows);
    furnace(t, &mut rows);
    diffraction(t, &mut rows);
    fluorescence(t, &mut rows);
    rows
}

fn row(rows: &mut Vec<Row>, id: &str, what: String, want: f64, got: f64, tolerance: f64) {
    rows.push(Row(id.to_string(), what, want, got, tolerance));
}

/// Reflection and transmission, phases of total reflection, scattering by molecules.
fn boundaries(t: &toml::Table, all: &mut Vec<Row>) {
    for eta in ["1.33", "1.50", "1.52"] {
        let id = &format!("fresnel-dielectric-n{eta}");
        let n: f64 = eta.parse().unwrap();
        let brewster = list(t, id, "Brewster_deg")[0];
        row(all, id, "Brewster's angle".into(), brewster, n.atan().to_degrees(), 1e-5);
        let shares = film::shares(cos(brewster), 1.0, &[], n.into());
        let dop = |r: &Response| f64::from(r.relative().a.abs());
        row(all, id, "Rs there".into(), list(t, id, "Rs_at_Brewster")[0], shares.back.s, 1e-6);
        row(all, id, "Rp there".into(), 0.0, shares.back.p, 1e-6);
        row(all, id, "DOP reflected".into(), list(t, id, "DOP_reflected_at_Brewster")[0], dop(&shares.back), 1e-6);
        row(
            all,
            id,
            "DOP transmitted".into(),
            list(t, id, "DOP_transmitted_at_Brewster")[0],
            dop(&shares.through),
            1e-6,
        );
    }
    let id = "tir-phase-n1.50";
    for (i, deg) in list(t, id, "theta_deg").iter().enumerate() {
        let a = film::amplitudes(cos(*deg), 1.5, &[], 1.0.into());
        let [s, p] = a.back.map(|r| r.arg().to_degrees().abs());
        row(all, id, format!("s at {deg}"), list(t, id, "delta_s_deg")[i], s, 1e-3);
        row(all, id, format!("p at {deg}"), list(t, id, "delta_p_deg")[i], p, 1e-3);
        let cross = film::shares(cos(*deg), 1.5, &[], 1.0.into()).back.cross;
        row(
            all,
            id,
            format!("retardance at {deg}"),
            list(t, id, "retardance_deg")[i],
            cross.arg().to_degrees().abs(),
            1e-3,
        );
        row(all, id, format!("all comes back at {deg}"), 1.0, cross.norm(), 1e-9);
    }
    let id = "pol-rayleigh";
    for (i, deg) in list(t, id, "theta_deg").iter().enumerate() {
        row(all, id, format!("{deg} deg"), list(t, id, "DOP")[i], rayleigh(cos(*deg)), 1e-6);
    }
}

fn films(t: &toml::Table, all: &mut Vec<Row>) {
    let film = |n: f64, nm: f64, below: f64| Stack {
        outside: Medium::clear(1.0),
        layers: vec![(Medium::clear(n), nm)],
        below: Medium::clear(below),
    };
    let cases = [
        ("thinfilm-soap-300nm", film(1.33, 300.0, 1.0), vec![0.0, 30.0, 60.0]),
        ("thinfilm-soap-black-10nm", film(1.33, 10.0, 1.0), vec![0.0, 60.0]),
        ("thinfilm-MgF2-quarterwave-on-glass", film(1.38, 550.0 / 4.0 / 1.38, 1.52), vec![0.0, 45.0]),
    ];
    for (id, stack, angles) in cases {
        for deg in angles {
            for (i, nm) in list(t, id, "lambda_nm").iter().enumerate() {
                let back = stack.at(cos(deg), *nm).back;
                for (key, got) in [("Rs", back.s), ("Rp", back.p), ("R", back.mean())] {
                    row(
                        all,
                        id,
                        format!("{key} at {deg} deg, {nm} nm"),
                        list(t, id, &format!("{key}_{deg}deg"))[i],
                        got,
                        1e-6,
                    );
                }
            }
        }
    }
}

/// Power into each layer by the fields on both its sides: what comes back, goes through and stays is all there is.
fn furnace(t: &toml::Table, all: &mut Vec<Row>) {
    let id = "furnace-thinfilm-conductor";
    let want = list(t, id, "sum")[0];
    let gold = Complex64::new(0.43, 2.455);
    let silver = Complex64::new(0.06, 3.586);
    let glass = Complex64::from(1.52);
    // Name, layers with their thickness in nm, and what lies below.
    type Named<'a> = (&'a str, &'a [(Complex64, f64)], Complex64);
    let stacks: [Named; 4] = [
        ("gold", &[], gold),
        ("silver on glass", &[(silver, 30.0)], glass),
        ("film on gold", &[(Complex64::from(1.46), 220.0)], gold),
        (
            "lossless stack",
            &[(Complex64::from(2.3), 60.0), (Complex64::from(1.38), 100.0), (Complex64::from(2.3), 60.0)],
            glass,
        ),
    ];
    for (name, layers, below) in stacks {
        for deg in [0.0, 30.0, 60.0, 80.0, 89.0] {
            let (cos, sin, nm) = (cos(deg), f64::to_radians(deg).sin(), 548.6);
            let normal = |n: Complex64| (n * n - sin * sin).sqrt();
            let slabs: Vec<film::Slab> = layers.iter().map(|(n, d)| (*n, normal(*n) * (2.0 * PI * d / nm))).collect();
            let got = film::amplitudes(cos, 1.0, &slabs, below);
            for (k, p) in [("s", false), ("p", true)] {
                let i = usize::from(p);
                let admittance = |n: Complex64| if p { n * n / normal(n) } else { normal(n) };
                let outside = if p { 1.0 / cos } else { cos };
                // Fields along the surface, from below up: E and H of each boundary, and the power that crosses it.
                let (mut e, mut h) = (got.through[i], got.through[i] * admittance(below));
                let flux = |e: Complex64, h: Complex64| (e * h.conj()).re / outside;
                let through = flux(e, h);
                let mut stays = 0.0;
                for (n, phase) in slabs.iter().rev() {
                    let y = admittance(*n);
                    let below = flux(e, h);
                    let j = Complex64::I;
                    (e, h) = (e * phase.cos() - h * (j * phase.sin() / y), h * phase.cos() - e * (j * phase.sin() * y));
                    stays += flux(e, h) - below;
                }
                let back = got.back[i].norm_sqr();
                row(all, id, format!("{name}, {k} at {deg} deg"), want, back + stays + through, 1e-10);
            }
        }
    }
}

fn diffraction(t: &toml::Table, all: &mut Vec<Row>) {
    let id = "grating-angles";
    for case in t[id]["rows"].as_array().unwrap() {
        let number = |k: &str| case[k].as_float().unwrap();
        let orders =
            |k: &str| case[k].as_array().unwrap().iter().map(|m| m.as_integer().unwrap() as i32).collect::<Vec<_>>();
        let (pitch, inc, nm) = (number("pitch_nm"), number("theta_i_deg"), number("lambda_nm"));
        let want: Vec<f64> = case["theta_m_deg"].as_array().unwrap().iter().map(|a| a.as_float().unwrap()).collect();
        for (m, want) in orders("orders").iter().zip(want) {
            let got = grating::order_deg(inc, *m, nm, pitch).unwrap_or(f64::NAN);
            row(all, id, format!("{pitch} nm, {inc} deg, {nm} nm, order {m}"), want, got, 1e-4);
        }
        for m in orders("evanescent") {
            let none = f64::from(grating::order_deg(inc, m, nm, pitch).is_none());
            row(all, id, format!("{pitch} nm, {inc} deg, {nm} nm, no order {m}"), 1.0, none, 1e-9);
        }
    }
    let id = "diffraction-limits";
    let arcsec = |mm: f64| aperture::first_ring_rad(mm * 1e-3, 550.0).to_degrees() * 3600.0;
    for (key, got) in [
        ("theta_arcsec_D2mm_550nm", arcsec(2.0)),
        ("theta_arcsec_D4mm_550nm", arcsec(4.0)),
        // An opening of 1 m at f / 8.
        ("airy_radius_um_f/8_550nm", aperture::first_ring_rad(1.0, 550.0) * 8.0 * 1e6),
        ("single_slit_100um_633nm_first_min_deg", aperture::slit_minimum_rad(100e-6, 633.0).to_degrees()),
    ] {
        let want = list(t, id, key)[0];
        row(all, id, key.into(), want, got, 1e-4 * want);
    }
    // Zeros of J1.
    let rings = [3.831705970207512, 7.015586669815619, 10.173468135062722];
    for (v, want) in rings.iter().zip(list(t, id, "encircled_energy_rings_1_2_3")) {
        row(all, id, format!("within v = {v:.3}"), want, aperture::encircled(*v), 1e-4 * want);
    }
}

fn fluorescence(t: &toml::Table, all: &mut Vec<Row>) {
    let id = "fluorescence-donaldson-5band";
    let m = rows(t, id, "M");
    let (reflectance, dye) = Reradiation::from_bands(375.0, 50.0, m.clone()).unwrap();
    let nm = list(t, id, "lambda_nm");
    let band = |i: usize| (nm[i] - 25.0, nm[i] + 25.0);
    for inc in 0..5 {
        for (out, row_out) in m.iter().enumerate() {
            let want = row_out[inc];
            let got = dye.between(band(out), band(inc)) + if inc == out { reflectance.at(nm[inc]) } else { 0.0 };
            row(all, id, format!("M {out} {inc}"), want, got, 1e-5 * want.max(1e-3));
        }
    }
    // No photon is gained, and what would gain is refused.
    let id = "fluorescence-energy-bound";
    for (what, k, fits) in [("as it is", 1.0, true), ("nothing", 0.0, true), ("1.3 times", 1.3, false)] {
        let scaled: Vec<Vec<f64>> = m.iter().map(|r| r.iter().map(|x| x * k).collect()).collect();
        let got = Reradiation::from_bands(375.0, 50.0, scaled).is_ok();
        row(all, id, what.into(), f64::from(fits), f64::from(got), 1e-9);
    }
    let mut up = m;
    up[0][1] = 1e-3;
    row(all, id, "a photon that gains".into(), 1.0, f64::from(Reradiation::from_bands(375.0, 50.0, up).is_err()), 1e-9);
    // Malus' law in matrices.
    let id = "pol-malus";
    let ideal = sheet(1.0, 0.0, 0.0);
    for (i, deg) in list(t, id, "theta_deg").iter().enumerate() {
        let (m, c) = (ideal.mueller(), f64::to_radians(2.0 * deg).cos());
        // (I, Q) after the first, Q seen from the second's axis.
        let got = m[0][0] * 0.5 + m[0][1] * 0.5 * c;
        row(all, id, format!("{deg} deg"), list(t, id, "S0")[i], got, 1e-6);
    }
}
