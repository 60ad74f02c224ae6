//! plocal: laws of local tone mapping, through the real program.

mod common;

use common::{fails, floats, run, split, stdout_of, stream};

const XYZ: &str = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329\nPRIMARIES= 1 0 0 1 0 0 .333 .333";

/// A grey stream of these luminances.
fn grey(width: usize, luminances: &[f32]) -> Vec<u8> {
    let values: Vec<f32> = luminances.iter().flat_map(|l| [0.9505 * l, *l, 1.089 * l]).collect();
    stream(XYZ, &format!("-Y {} +X {width}", luminances.len() / width), &values)
}

/// Display values of a stream's pixels.
fn shown(args: &[&str], input: &[u8]) -> Vec<f32> {
    floats(split(&stdout_of("plocal", args, input)).2)
}

/// ln Ld on a display of 1 to 100 cd/m2.
fn ln_displayed(args: &[&str], width: usize, luminances: &[f32]) -> Vec<f64> {
    let y = shown(args, &grey(width, luminances)).into_iter().skip(1).step_by(3);
    y.map(|y| (1.0 + 99.0 * f64::from(y)).ln()).collect()
}

/// Repeatable numbers in -1 to 1.
fn noise(n: usize) -> Vec<f32> {
    let next = |s: &mut u32| {
        *s = s.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        Some((*s >> 8) as f32 / 8_388_608.0 - 1.0)
    };
    let mut state = 7u32;
    std::iter::from_fn(|| next(&mut state)).take(n).collect()
}

const METHODS: [[&str; 2]; 2] = [["--method", "base-detail"], ["--method", "retinex"]];

/// One value goes to the middle of the display in ln Ld, sqrt(1 x 100) = 10 cd/m2, with either method.
#[test]
fn a_constant_picture_stays_constant() {
    for method in METHODS {
        for v in shown(&method, &grey(20, &[37.0; 200])).chunks(3) {
            assert!((v[1] - 9.0 / 99.0).abs() < 1e-5, "{v:?}");
        }
    }
}

/// ln Ld = ln Lw - mean + middle, shifted until all shows.
#[test]
fn strength_0_is_the_linear_map_and_the_option_has_no_jumps() {
    let world: Vec<f32> = noise(1200).iter().map(|x| 50.0 * (1.5 * x).exp()).collect();
    let ln: Vec<f64> = world.iter().map(|l| f64::from(*l).ln()).collect();
    let shift = 10f64.ln() - ln.iter().sum::<f64>() / ln.len() as f64;
    assert!(ln.iter().all(|x| (x + shift) > 0.0 && (x + shift) < 100f64.ln()), "the scene must fit for this law");
    for method in METHODS {
        let got = ln_displayed(&[&method[..], &["--strength", "0"]].concat(), 40, &world);
        got.iter().zip(&ln).for_each(|(d, w)| assert!((d - w - shift).abs() < 1e-4, "{d} {}", w + shift));
        let near = ln_displayed(&[&method[..], &["--strength", "0.001"]].concat(), 40, &world);
        got.iter().zip(&near).for_each(|(a, b)| assert!((a - b).abs() < 0.01, "{a} {b}"));
    }
    // A scene that fits keeps its contrast with base-detail.
    let got = ln_displayed(&[], 40, &world);
    got.iter().zip(&ln).for_each(|(d, w)| assert!((d - w - shift).abs() < 1e-4, "{d} {}", w + shift));
}

#[test]
fn the_unit_of_light_and_the_threads_change_nothing() {
    let world: Vec<f32> = noise(2000).iter().map(|x| (6.0 * x).exp()).collect();
    let scaled: Vec<f32> = world.iter().map(|l| 300.0 * l).collect();
    for method in METHODS {
        let (a, b) = (shown(&method, &grey(50, &world)), shown(&method, &grey(50, &scaled)));
        a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).abs() < 1e-4 * a + 1e-5, "{a} {b}"));
        a.iter().skip(1).step_by(3).for_each(|y| assert!((0.0..=1.0).contains(y)));
        let threads = |n: &str| stdout_of("plocal", &[&method[..], &["--threads", n]].concat(), &grey(50, &world));
        assert!(threads("1") == threads("2"));
    }
}

const FAR: usize = 200;
/// A step of 1 : 1000 in the middle of 1000 x 24 pixels, with texture of 3 %.
fn step() -> (Vec<f32>, Vec<f32>) {
    let texture: Vec<f32> = noise(24_000).iter().map(|x| 0.03 * x).collect();
    let level = |i: usize| if i % 1000 < 500 { 1.0 } else { 1000.0 };
    (texture.iter().enumerate().map(|(i, t)| level(i) * t.exp()).collect(), texture)
}

/// How far the mean of ln Ld down a column leaves its level of the far field, within the window's reach of the edge.
fn halo(ln: &[f64]) -> f64 {
    let column = |x: usize| ln.iter().skip(x).step_by(1000).sum::<f64>() / (ln.len() / 1000) as f64;
    let level = |from: usize| (from..from + FAR).map(column).sum::<f64>() / FAR as f64;
    let (dark, light) = (level(100), level(700));
    // Three neighbours are averaged, so that the texture counts for less.
    let mean = |x: usize| (column(x - 1) + column(x) + column(x + 1)) / 3.0;
    (440..499).map(|x| (mean(x) - dark).abs()).chain((501..560).map(|x| (mean(x) - light).abs())).fold(0.0, f64::max)
}

#[test]
fn the_halo_at_a_step_is_small_with_base_detail_and_large_with_retinex() {
    let (world, _) = step();
    let scale = ["--scale", "0.02"];
    let [base, retinex] =
        METHODS.map(|m| halo(&ln_displayed(&[&m[..], &scale, &["--detail", "1"]].concat(), 1000, &world)));
    println!("halo at a step of 1 : 1000, in ln Ld: base-detail {base:.4}, retinex {retinex:.4}");
    assert!(base < 0.05 && retinex > 10.0 * base, "{base} {retinex}");
}

/// Far from the step the base is flat, and texture has the contrast it had.
#[test]
fn detail_is_kept_and_multiplied() {
    let (world, texture) = step();
    for factor in [1.0, 2.0] {
        let ln = ln_displayed(&["--detail", &factor.to_string()], 1000, &world);
        let mut sums = [0.0; 2];
        for (i, (t, d)) in texture.iter().zip(&ln).enumerate().filter(|(i, _)| (100..300).contains(&(i % 1000))) {
            let _ = i;
            sums[0] += f64::from(*t) * d;
            sums[1] += f64::from(*t).powi(2);
        }
        let mean_t = texture.iter().enumerate().filter(|(i, _)| (100..300).contains(&(i % 1000)));
        let (n, mean_t) = mean_t.fold((0.0, 0.0), |(n, s), (_, t)| (n + 1.0, s + f64::from(*t)));
        let mean_d: f64 = (0..ln.len()).filter(|i| (100..300).contains(&(i % 1000))).map(|i| ln[i]).sum::<f64>() / n;
        let gain = (sums[0] - mean_t * mean_d) / (sums[1] - mean_t * mean_t / n);
        println!("detail x {factor}: gain {gain:.4}");
        assert!((gain / factor - 1.0).abs() < 0.05, "{gain}");
    }
}

#[test]
fn colours_keep_xy_or_follow_the_exponent() {
    let colours = [[20.0f32, 10.0, 3.0], [300.0, 500.0, 100.0], [1.0, 2.0, 4.0], [5.0, 5.0, 5.0]];
    let input = stream(XYZ, "-Y 2 +X 2", &colours.concat());
    for (out, c) in shown(&[], &input).chunks(3).zip(&colours).filter(|(out, _)| out[1] > 0.0) {
        let xy = |p: &[f32]| [p[0], p[1]].map(|v| v / (p[0] + p[1] + p[2]));
        xy(out).iter().zip(xy(c)).for_each(|(a, b)| assert!((a - b).abs() < 1e-5, "{out:?} {c:?}"));
    }
    let (kept, pale) = (shown(&[], &input), shown(&["--saturation", "0"], &input));
    for (a, b) in kept.chunks(3).zip(pale.chunks(3)) {
        assert!((a[1] - b[1]).abs() < 1e-6);
    }
    // Colours of BT.709 without saturation are its white, D65.
    let white = pale.chunks(3).last().unwrap();
    assert!((white[0] / white[1] - 0.3127 / 0.329).abs() < 1e-3, "{white:?}");
}

#[test]
fn degenerate_pictures_are_finite_and_told() {
    let worlds: Vec<(usize, Vec<f32>, &str)> = vec![
        (1, vec![5.0], ""),
        (1, vec![0.0], "black: nothing to map"),
        (9, vec![0.0; 81], "black: nothing to map"),
        (300, (1..=300).map(|i| i as f32).collect(), ""),
        (1, (1..=300).map(|i| i as f32).collect(), ""),
        (2, vec![1e-6, 1e8], ""),
        (4, vec![1.0, f32::NAN, 2.0, f32::INFINITY], "2 pixels with a component that is not finite"),
        (4, vec![1.0, -3.0, 2.0, 0.0], "1 pixels with a negative luminance"),
        (2, vec![3e38, 1e-40], ""),
    ];
    for (width, world, word) in &worlds {
        for method in METHODS {
            for extra in [&[][..], &["--saturation", "0.6", "--detail", "3", "--scale", "1"]] {
                let output = run("plocal", &[&method[..], extra].concat(), &grey(*width, world));
                let notes = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success() && notes.contains(word), "{world:?}: {notes}");
                let pixels = floats(split(&output.stdout).2);
                assert!(
                    pixels.len() == 3 * world.len() && pixels.iter().all(|x| x.is_finite()),
                    "{world:?}: {pixels:?}"
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_done_is_refused() {
    let input = grey(2, &[1.0; 4]);
    for (args, word) in [
        (&["--strength", "1.5"][..], "--strength"),
        (&["--edge", "1"], "--edge"),
        (&["--edge", "2", "--method", "retinex"], "base-detail"),
        (&["--scale", "0"], "share"),
        (&["--lddyn", "1"], "--lddyn"),
    ] {
        fails("plocal", args, &input, 2, word);
    }
    fails("plocal", &["--scale", "1deg"], &input, 1, "VIEW");
    fails("plocal", &["--memory", "10"], &input, 1, "--memory");
    let twice = stdout_of("plocal", &[], &input);
    fails("plocal", &[], &twice, 1, "display-referred already");
}
