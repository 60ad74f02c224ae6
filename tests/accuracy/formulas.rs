//! The cases of glass and Fresnel's equations, which materials answer by themselves.

use super::cases::list;
use luxpipe::optics::fresnel;

/// A number: case, what, expected, got, tolerance.
pub struct Row(pub String, pub String, pub f64, pub f64, pub f64);

fn cos(deg: f64) -> f64 {
    deg.to_radians().cos()
}

/// All of them.
pub fn all(t: &toml::Table) -> Vec<Row> {
    let mut rows = Vec::new();
    for (id, depth, panes, tolerance) in [
        ("cie5.5-glass-clear", 0.0, 1, 1e-4),
        ("cie5.5-glass-6mm", 0.03, 1, 1e-4),
        ("glass-double-pane", 0.03, 2, 2e-4),
    ] {
        for (key, back) in [("T", false), ("R", true)] {
            for (deg, want) in list(t, id, "theta_deg").iter().zip(list(t, id, key)) {
                let got = fresnel::Stack::new(cos(*deg) as f32, 1.52, panes).share(depth, back);
                rows.push(Row(id.into(), format!("{key} at {deg} deg"), want, got.into(), tolerance));
            }
        }
    }
    for eta in ["1.33", "1.50", "1.52"] {
        let id = format!("fresnel-dielectric-n{eta}");
        let n: f64 = eta.parse().unwrap();
        for (i, deg) in list(t, &id, "theta_deg").iter().enumerate() {
            let (s, p, _) = fresnel::polarised(cos(*deg), n);
            for (key, got) in [("Rs", s), ("Rp", p), ("R_unpolarized", (s + p) / 2.0)] {
                rows.push(Row(id.clone(), format!("{key} at {deg} deg"), list(t, &id, key)[i], got, 1e-6));
            }
        }
        for (key, got) in
            [("hemispherical_R_external", fresnel::diffuse(n)), ("hemispherical_R_internal", fresnel::diffuse(1.0 / n))]
        {
            rows.push(Row(id.clone(), key.into(), list(t, &id, key)[0], got, 1e-4));
        }
    }
    for metal in ["Au", "Ag"] {
        let id = format!("fresnel-conductor-{metal}");
        let (n, k) = (list(t, &id, "n"), list(t, &id, "k"));
        for i in 0..n.len() {
            let normal = fresnel::conductor(1.0, n[i] as f32, k[i] as f32);
            rows.push(Row(id.clone(), format!("normal, n {}", n[i]), list(t, &id, "R_normal")[i], normal.into(), 1e-5));
            // 2 x integral of R cos by the midpoint rule.
            let steps = 2000;
            let half = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|j| 2.0 * half(j) * f64::from(fresnel::conductor(half(j) as f32, n[i] as f32, k[i] as f32)))
                .sum();
            rows.push(Row(
                id.clone(),
                format!("hemispherical, n {}", n[i]),
                list(t, &id, "R_hemispherical")[i],
                sum / f64::from(steps),
                1e-5,
            ));
        }
        for (i, deg) in list(t, &id, "theta_deg").iter().enumerate() {
            let (s, p, phase) = fresnel::conductor_polarised(cos(*deg), n[2], k[2]);
            let r = f64::from(fresnel::conductor(cos(*deg) as f32, n[2] as f32, k[2] as f32));
            let phases = "retardance_deg_arg(-rp*conj(rs))_time_exp(-iwt)";
            let (ws, wp) = (list(t, &id, "Rs")[i], list(t, &id, "Rp")[i]);
            rows.push(Row(id.clone(), format!("Rs at {deg} deg"), ws, s, 1e-5));
            rows.push(Row(id.clone(), format!("Rp at {deg} deg"), wp, p, 1e-5));
            rows.push(Row(id.clone(), format!("mean at {deg} deg"), (ws + wp) / 2.0, r, 1e-5));
            rows.push(Row(id.clone(), format!("retardance at {deg} deg"), list(t, &id, phases)[i], phase, 0.01));
        }
    }
    rows.extend(super::waves::all(t));
    rows.extend(super::media::formulas(t));
    rows
}
