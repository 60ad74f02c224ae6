//! Against the literature, closed forms and published tables.

use super::nodes::gauss;
use super::*;

/// Albedo, optical depth, and reflectance and transmittance at cosine 1, 0.5, 0.1 and for diffuse light, of
/// isotropic scattering without surfaces.
const ISOTROPIC: [[f64; 10]; 18] = [
    [1.0, 0.1, 0.0476886, 0.952311, 0.0910432, 0.908957, 0.323074, 0.676926, 0.0842971, 0.915703],
    [1.0, 1.0, 0.341329, 0.658671, 0.498376, 0.501624, 0.697664, 0.302336, 0.446594, 0.553406],
    [1.0, 5.0, 0.738721, 0.261279, 0.818996, 0.181004, 0.887836, 0.112164, 0.792343, 0.207657],
    [0.99, 0.1, 0.0471201, 0.951745, 0.0899582, 0.90788, 0.319234, 0.673231, 0.083293, 0.914711],
    [0.99, 1.0, 0.332922, 0.650978, 0.486518, 0.491628, 0.683371, 0.293429, 0.435962, 0.544352],
    [0.99, 5.0, 0.680078, 0.220628, 0.765839, 0.149597, 0.847146, 0.0921512, 0.737507, 0.173152],
    [0.9, 0.1, 0.0421014, 0.946746, 0.0803795, 0.898378, 0.285321, 0.640623, 0.0744273, 0.905955],
    [0.9, 1.0, 0.26741, 0.591625, 0.393662, 0.41484, 0.568988, 0.225753, 0.352712, 0.474746],
    [0.9, 5.0, 0.412541, 0.0766496, 0.506604, 0.0422424, 0.628555, 0.0247282, 0.476338, 0.0534214],
    [0.8, 0.1, 0.0367235, 0.94139, 0.0701145, 0.888196, 0.248959, 0.6057, 0.0649256, 0.896574],
    [0.8, 1.0, 0.210847, 0.5414, 0.312702, 0.350424, 0.465014, 0.170222, 0.280152, 0.416245],
    [0.8, 5.0, 0.28495, 0.0377713, 0.367838, 0.0161023, 0.490637, 0.00895689, 0.34168, 0.0229218],
    [0.5, 0.1, 0.021733, 0.926465, 0.0414983, 0.859828, 0.147482, 0.508478, 0.0384327, 0.870438],
    [0.5, 1.0, 0.0991192, 0.446058, 0.149754, 0.230285, 0.238759, 0.0711922, 0.134165, 0.306709],
    [0.5, 5.0, 0.115218, 0.0129191, 0.160143, 0.00223615, 0.24172, 0.00109733, 0.146541, 0.00528759],
    [0.2, 0.1, 0.00825494, 0.913051, 0.0157641, 0.834336, 0.056074, 0.42123, 0.0146016, 0.846956],
    [0.2, 1.0, 0.0319835, 0.392258, 0.049028, 0.164445, 0.0824536, 0.0208861, 0.0439345, 0.246269],
    [0.2, 5.0, 0.0352299, 0.0080817, 0.0508547, 0.00041212, 0.0826595, 0.000173174, 0.0462647, 0.00244614],
];

/// Albedo, plane albedos at the cosines below and spherical albedo, from Chandrasekhar's H function.
const HALF_SPACE: [(f64, [f64; 7], f64); 5] = [
    (0.2, [0.08265953, 0.07076439, 0.06237598, 0.05085477, 0.0431237, 0.03750792, 0.03523052], 0.04626487),
    (0.5, [0.2417208, 0.2126639, 0.191148, 0.1601444, 0.1383481, 0.1219899, 0.1152259], 0.1465444),
    (0.8, [0.4907097, 0.450536, 0.4183592, 0.3679698, 0.3293854, 0.2985263, 0.2852545], 0.3418668),
    (0.9, [0.6293358, 0.5916128, 0.5600164, 0.5079389, 0.4657814, 0.430541, 0.4149475], 0.4780245),
    (1.0, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0], 1.0),
];
const HALF_SPACE_COSINES: [f64; 7] = [0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0];

/// Index, reduced scattering and absorption per mm, and the share of normally incident light that comes back from
/// inside a half space of apple, chicken, ketchup, marble, skim milk and skin.
const MATERIALS: [(f64, [[f64; 3]; 3]); 6] = [
    (1.3, [[2.29, 2.39, 1.97], [0.003, 0.0034, 0.046], [0.84029, 0.83487, 0.5277]]),
    (1.3, [[0.15, 0.21, 0.38], [0.015, 0.077, 0.19], [0.30139, 0.13725, 0.10919]]),
    (1.3, [[0.18, 0.07, 0.03], [0.061, 0.97, 1.45], [0.14511, 0.0052917, 0.0015333]]),
    (1.5, [[2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071], [0.80444, 0.76749, 0.73089]]),
    (1.3, [[0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142], [0.81052, 0.80866, 0.68263]]),
    (1.3, [[0.74, 0.88, 1.01], [0.032, 0.17, 0.48], [0.43198, 0.20963, 0.11347]]),
];

fn isotropic(_: f64) -> f64 {
    1.0
}

fn henyey_greenstein(g: f64) -> impl Fn(f64) -> f64 {
    move |cos| {
        let square = 1.0 + g * g - 2.0 * g * cos;
        (1.0 - g * g) / (square * square.sqrt())
    }
}

fn slab(optical_depth: f64, albedo: f64, eta: f64) -> Slab {
    Slab { optical_depth, albedo, eta }
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected} +- {tolerance}");
}

#[test]
fn isotropic_slabs_match_the_table() {
    for row in ISOTROPIC {
        let (beams, diffuse) = measure(&slab(row[1], row[0], 1.0), &isotropic, &[1.0, 0.5, 0.1]);
        for (shares, expected) in beams.iter().chain([&diffuse]).zip(row[2..].chunks_exact(2)) {
            close(shares.reflectance, expected[0], 1e-6);
            close(shares.transmittance, expected[1], 1e-6);
            assert_eq!(shares.specular, 0.0);
        }
    }
}

#[test]
fn half_spaces_match_the_h_function() {
    for (albedo, plane, spherical) in HALF_SPACE {
        let (beams, diffuse) = measure(&slab(f64::INFINITY, albedo, 1.0), &isotropic, &HALF_SPACE_COSINES);
        for (shares, expected) in beams.iter().chain([&diffuse]).zip(plane.iter().chain([&spherical])) {
            close(shares.reflectance, *expected, 1e-7);
            assert_eq!(shares.transmittance, 0.0);
        }
    }
}

#[test]
fn what_comes_back_from_inside_is_a_share_of_the_incident_light() {
    for (eta, [scattering, absorption, expected]) in MATERIALS {
        for ((s, a), expected) in scattering.iter().zip(absorption).zip(expected) {
            let (beams, _) = measure(&slab(f64::INFINITY, s / (s + a), eta), &isotropic, &[1.0]);
            close(beams[0].reflectance - beams[0].specular, expected, 6e-6);
        }
    }
}

/// Van de Hulst 1980 and Giovanelli 1955, as Wang, Jacques and Zheng (MCML, 1995) quote them, to their digits.
#[test]
fn literature_values_are_met() {
    let (beams, _) = measure(&slab(2.0, 0.9, 1.0), &henyey_greenstein(0.75), &[1.0]);
    close(beams[0].reflectance, 0.09739, 6e-6);
    close(beams[0].transmittance, 0.66096, 6e-6);
    let (beams, _) = measure(&slab(f64::INFINITY, 0.9, 1.5), &isotropic, &[1.0]);
    close(beams[0].reflectance, 0.2600, 1e-4);
}

#[test]
fn energy_is_conserved_without_absorption() {
    let cosines = [1.0, 0.4, 0.01];
    for eta in [1.0, 1.5, 0.75] {
        for (depth, g) in [(1e-9, 0.0), (1e-3, 0.9), (1.0, 0.999), (1e6, 0.0), (1e6, 0.999), (f64::INFINITY, 0.5)] {
            let (beams, diffuse) = measure(&slab(depth, 1.0, eta), &henyey_greenstein(g), &cosines);
            for shares in beams.iter().chain([&diffuse]) {
                close(shares.reflectance + shares.transmittance, 1.0, 1e-13);
            }
        }
    }
}

/// A sheet has R = 2 r / (1 + r); one that absorbs, T = t^2 e / (1 - r^2 e^2) and R = r (1 + e T).
#[test]
fn two_surfaces_without_scattering_match_the_geometric_series() {
    let cosines = [1.0, 0.6, 0.1];
    for (depth, albedo) in [(0.0, 0.9), (0.0, 0.0), (0.3, 0.0), (f64::INFINITY, 0.0)] {
        let (beams, _) = measure(&slab(depth, albedo, 1.5), &isotropic, &cosines);
        for (shares, cosine) in beams.iter().zip(cosines) {
            let inside = (1.0_f64 - (1.0 - cosine * cosine) / 2.25).sqrt();
            let s = (cosine - 1.5 * inside) / (cosine + 1.5 * inside);
            let p = (1.5 * cosine - inside) / (1.5 * cosine + inside);
            let r = 0.5 * (s * s + p * p);
            let fade = (-depth / inside).exp();
            let through = (1.0 - r) * (1.0 - r) * fade / (1.0 - r * r * fade * fade);
            close(shares.specular, r, 1e-14);
            close(shares.transmittance, through, 1e-14);
            close(shares.reflectance, r * (1.0 + fade * through), 1e-14);
            if depth == 0.0 {
                close(shares.reflectance, 2.0 * r / (1.0 + r), 1e-14);
            }
        }
    }
}

/// Diffuse light through an absorber is 2 E_3(depth); E_3(0.1) is from Abramowitz and Stegun, table 5.4.
#[test]
fn diffuse_light_through_an_absorber_follows_the_exponential_integral() {
    let (_, diffuse) = measure(&slab(0.1, 0.0, 1.0), &isotropic, &[]);
    close(diffuse.transmittance, 2.0 * 0.416_291_5, 2e-7);
    assert_eq!(diffuse.reflectance, 0.0);
}

#[test]
fn a_rarer_inside_mirrors_beyond_the_critical_angle() {
    let critical = (1.0_f64 - 0.75 * 0.75).sqrt();
    let (beams, diffuse) = measure(&slab(1.0, 0.5, 0.75), &isotropic, &[critical - 1e-6, critical + 1e-6]);
    assert_eq!(beams[0], Shares { reflectance: 1.0, transmittance: 0.0, specular: 1.0 });
    assert!(beams[1].reflectance < 1.0 && beams[1].transmittance > 0.0);
    assert!(diffuse.specular > 1.0 - 0.75 * 0.75 && diffuse.reflectance > diffuse.specular);
}

#[test]
fn diffuse_light_is_the_weighted_mean_of_beams() {
    let rule = gauss(24);
    let cosines: Vec<f64> = rule.iter().map(|&(mu, _)| mu).collect();
    for eta in [1.0, 1.4] {
        let (beams, diffuse) = measure(&slab(2.0, 0.8, eta), &henyey_greenstein(0.6), &cosines);
        let mean = |share: fn(&Shares) -> f64| -> f64 {
            rule.iter().zip(&beams).map(|(&(mu, weight), beam)| 2.0 * mu * weight * share(beam)).sum()
        };
        close(diffuse.reflectance, mean(|beam| beam.reflectance), 1e-6);
        close(diffuse.transmittance, mean(|beam| beam.transmittance), 1e-6);
        close(diffuse.specular, mean(|beam| beam.specular), 1e-6);
    }
}

#[test]
fn nodes_hardly_matter() {
    for (g, eta, steep, diffuse) in [(0.0, 1.5, 1e-9, 1e-9), (0.9, 1.5, 1e-5, 1e-6), (0.999, 1.33, 1e-3, 3e-4)] {
        let medium = slab(10.0, 0.99, eta);
        let few = measure_with(&medium, &henyey_greenstein(g), &[1.0, 0.7], NODES);
        let many = measure_with(&medium, &henyey_greenstein(g), &[1.0, 0.7], 64);
        for (a, b) in few.0.iter().zip(&many.0) {
            close(a.reflectance, b.reflectance, steep);
            close(a.transmittance, b.transmittance, steep);
        }
        close(few.1.reflectance, many.1.reflectance, diffuse);
        close(few.1.transmittance, many.1.transmittance, diffuse);
    }
}

/// Thin slabs scatter once: albedo depth / 2 back at normal incidence, to first order.
#[test]
fn a_thin_slab_keeps_its_digits() {
    let (beams, _) = measure(&slab(1e-9, 0.6, 1.0), &isotropic, &[1.0]);
    close(beams[0].reflectance, 0.3e-9, 1e-16);
    close(1.0 - beams[0].transmittance, 0.7e-9, 1e-15);
}

#[test]
fn moments_of_henyey_greenstein_are_powers() {
    for g in [0.5_f64, -0.9, 0.999] {
        for (l, moment) in legendre_moments(&henyey_greenstein(g), 80).iter().enumerate() {
            close(*moment, g.powi(l as i32), 1e-10);
        }
    }
}

#[test]
fn a_nearly_matched_index_is_continuous() {
    let (matched, _) = measure(&slab(1.0, 0.9, 1.0), &isotropic, &[1.0, 0.3]);
    for eta in [1.0 - 1e-9, 1.0 + 1e-9] {
        let (beams, _) = measure(&slab(1.0, 0.9, eta), &isotropic, &[1.0, 0.3]);
        for (beam, expected) in beams.iter().zip(&matched) {
            close(beam.reflectance, expected.reflectance, 1e-6);
            close(beam.transmittance, expected.transmittance, 1e-6);
        }
    }
}

#[test]
fn invalid_input_is_undefined_but_harmless() {
    for (depth, albedo, eta) in [(-1.0, 0.5, 1.0), (1.0, 1.5, 1.0), (1.0, f64::NAN, 1.0), (1.0, 0.5, 0.0)] {
        let (beams, diffuse) = measure(&slab(depth, albedo, eta), &isotropic, &[1.0]);
        assert!(beams[0].reflectance.is_nan() && diffuse.transmittance.is_nan());
    }
    let (beams, diffuse) = measure(&slab(1.0, 0.5, 1.5), &isotropic, &[f64::NAN, 0.0, 1.0]);
    assert!(beams[0].reflectance.is_nan() && beams[0].transmittance.is_nan());
    close(beams[1].reflectance, 1.0, 1e-6);
    assert!(beams[2].reflectance.is_finite() && diffuse.reflectance.is_finite());
    let (beams, _) = measure(&slab(1.0, 0.5, 1.0), &|_| f64::NAN, &[1.0]);
    assert!(beams[0].reflectance.is_nan());
}
