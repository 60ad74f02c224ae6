//! Layers of lights summed under other lamps are what rendering again would be.

mod common;

use common::{run, split, stdout_of};

const ROOM: &str = include_str!("../examples/relative/room.toml");

fn floats(stream: &[u8]) -> Vec<f32> {
    let (_, _, data) = split(stream);
    data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// A room whose three lamps have these spectra and luminances.
fn room(folder: &std::path::Path, name: &str, lamps: [(&str, f64); 3]) -> String {
    let mut text = ROOM.to_string();
    for (i, (spectrum, luminance)) in (1..).zip(lamps) {
        let old = format!("spectrum = \"LAMP{i}\"\nluminance = 3000");
        assert!(text.contains(&old));
        text = text.replace(&old, &format!("spectrum = \"{spectrum}\"\nluminance = {luminance:?}"));
    }
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_string()
}

const SMALL: [&str; 7] = ["--width", "24", "--samples", "8", "--seed", "3", "--quiet"];

/// A room before and after the tube replaces the first lamp, as bright as that: lots go by brightness, so that the paths are the same.
struct Change {
    before: String,
    after: String,
    folder: tempfile::TempDir,
}

const TUBE: &str = "--set=one=FL11";

fn change() -> Change {
    let folder = tempfile::tempdir().unwrap();
    let before = room(folder.path(), "before.toml", [("A", 3000.0), ("D65", 3000.0), ("FL2", 1000.0)]);
    let after = room(folder.path(), "after.toml", [("FL11", 3000.0), ("D65", 3000.0), ("FL2", 1000.0)]);
    Change { before, after, folder }
}

/// Largest difference over the largest number.
fn off(got: &[f32], want: &[f32]) -> f32 {
    assert_eq!(got.len(), want.len());
    let largest = want.iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.0);
    got.iter().zip(want).map(|(g, w)| (g - w).abs()).fold(0.0, f32::max) / largest
}

/// Full bands: pixel by pixel, to 1e-5, of the picture that is rendered again.
#[test]
fn bands_relit_are_bands_rendered_again() {
    let Change { before, after, folder: _folder } = change();
    let layers = stdout_of("spectrace", &[&[&before[..], "--per-light"], &SMALL[..]].concat(), b"");
    let relit = floats(&stdout_of("relight", &[&before, TUBE, "--quiet"], &layers));
    let again = floats(&stdout_of("spectrace", &[&[&after[..]], &SMALL[..]].concat(), b""));
    for (r, a) in relit.iter().zip(&again) {
        assert!((r - a).abs() <= 1e-5 * a.abs().max(1e-3), "{r} for {a}");
    }
    // The same lamps again give the picture that was rendered without layers.
    let plain = stdout_of("relight", &[&before[..], "--quiet"], &layers);
    let own = stdout_of("spectrace", &[&[&before[..]], &SMALL[..]].concat(), b"");
    assert!(off(&floats(&plain), &floats(&own)) < 1e-6);
}

/// Dimming is linear, lamp by lamp, and in the mean what rendering dimmed lamps gives, whose lots are others.
#[test]
fn lamps_are_dimmed_one_by_one() {
    let Change { before, folder, .. } = change();
    let layers = stdout_of("spectrace", &[&[&before[..], "--per-light"], &SMALL[..]].concat(), b"");
    let relit = |set: &[&str]| floats(&stdout_of("relight", &[&[&before[..], "--quiet"], set].concat(), &layers));
    let got = relit(&["--set=one=FL11:0.4", "--set=three=:0.25"]);
    let parts = ["--set=one=FL11", "--set=two=:1", "--set=three=:1"].map(|set| relit(&["--only", set]));
    let sum: Vec<f32> = (0..got.len()).map(|i| 0.4 * parts[0][i] + parts[1][i] + 0.25 * parts[2][i]).collect();
    assert!(off(&got, &sum) < 1e-6);
    let dimmed = room(folder.path(), "dimmed.toml", [("FL11", 1200.0), ("D65", 3000.0), ("FL2", 250.0)]);
    let again = floats(&stdout_of("spectrace", &[&dimmed, "--width=24", "--samples=256", "--quiet"], b""));
    let mean = |p: &[f32]| p.iter().skip(1).step_by(3).sum::<f32>();
    assert!((mean(&got) / mean(&again) - 1.0).abs() < 0.02, "{} {}", mean(&got), mean(&again));
}

/// A plan's wavelengths: weights are found anew for the new lamps, and stay within the tolerance, and what is said of them.
#[test]
fn wavelengths_relit_stay_within_the_tolerance() {
    let Change { before, after, folder } = change();
    let plan = folder.path().join("a.plan");
    std::fs::write(&plan, stdout_of("specplan", &[&before, "--relight", "--tolerance", "1"], b"")).unwrap();
    let by_plan = ["--plan", plan.to_str().unwrap(), "--per-light"];
    let layers = stdout_of("spectrace", &[&[&before[..]], &by_plan[..], &SMALL[..]].concat(), b"");
    let relit = run("relight", &[&before, TUBE], &layers);
    let said = String::from_utf8_lossy(&relit.stderr).into_owned();
    let bound = said.split("within ").nth(1).and_then(|t| t.split(' ').next()).and_then(|t| t.parse::<f64>().ok());
    let bound = bound.unwrap_or_else(|| panic!("{said}"));
    let files = ["relit.lux", "again.lux"].map(|n| folder.path().join(n).to_str().unwrap().to_string());
    std::fs::write(&files[0], relit.stdout).unwrap();
    std::fs::write(&files[1], stdout_of("spectrace", &[&[&after[..]], &SMALL[..]].concat(), b"")).unwrap();
    let json =
        String::from_utf8(stdout_of("pcompare", &["--json", "--ignore-white", &files[1], &files[0]], b"")).unwrap();
    let largest = json.split("\"delta_e_2000\"").nth(1).and_then(|t| t.split("\"max\":").nth(1)).unwrap();
    let largest: f64 = largest.trim().split([',', '}']).next().unwrap().trim().parse().unwrap();
    assert!(largest > 0.0 && largest <= bound && largest <= 1.0, "{largest} for {bound}");
}

/// What does not go together is refused in a line.
#[test]
fn what_cannot_be_relit_is_refused() {
    let Change { before, folder, .. } = change();
    let layers = stdout_of("spectrace", &[&[&before[..], "--per-light"], &SMALL[..]].concat(), b"");
    let fails = |program: &str, args: &[&str], input: &[u8], code: i32, word: &str| {
        let output = run(program, args, input);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        assert!(text.contains(word) && text.lines().count() == 1, "{args:?}: {text}");
    };
    for (set, word) in [
        ("one", "LIGHT="),
        ("four=A", "no such light"),
        ("one=A:-1", "a factor"),
        ("one=A:x", "a factor"),
        ("one=nothing", "nothing"),
    ] {
        let output = run("relight", &[&before, &format!("--set={set}")], &layers);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(word) && text.lines().count() == 1, "{set}: {text}");
    }
    fails("relight", &["scenes/cornell.toml"], &layers, 1, "other lights");
    fails("relight", &[&before, "--set=one=:1", "--set=one=A"], &layers, 2, "twice");
    let other = room(folder.path(), "other.toml", [("A", 3000.0), ("D65", 3000.0), ("FL2", 900.0)]);
    fails("relight", &[&other], &layers, 1, "other lights");
    let sky = ["scenes/sphere.toml", "--per-light", "--width=4", "--samples=1", "--quiet"];
    let sky = stdout_of("spectrace", &sky, b"");
    fails("relight", &["scenes/sphere.toml", "--set=environment=A"], &sky, 1, "only be dimmed");
    let dark = ["scenes/sphere.toml", "--set=environment=:0", "--set=sun=:0", "--quiet"];
    assert!(floats(&stdout_of("relight", &dark, &sky)).iter().all(|x| *x == 0.0));
    let xyz = stdout_of("spectrace", &[&[&before[..]], &SMALL[..]].concat(), b"");
    fails("relight", &[&before], &xyz, 1, "per-light");
    fails("relight", &[&before], &layers[..layers.len() - 5], 1, "");
    fails("pcond", &[], &layers, 1, "LAYERS");
    fails("spectrace", &["scenes/fluorescence.toml", "--per-light", "--width=4"], b"", 1, "fluoresces");
    let plan = folder.path().join("three.plan");
    std::fs::write(&plan, stdout_of("specplan", &[&before, "--model", "relative"], b"")).unwrap();
    let three = [&before[..], "--per-light", "--plan", plan.to_str().unwrap()];
    fails("spectrace", &three, b"", 2, "channels");
}
