//! Pipelines as people use them: variables, batches, trees of stages, other programs, and every way in which a file can be wrong.

#![cfg(unix)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{data_path, fails, program, root, run, split, stdout_of, stream};

/// The search path with the programs that cargo built in front.
fn path() -> String {
    format!("{}:{}", program("luxpipe").parent().unwrap().display(), std::env::var("PATH").unwrap())
}

/// A shell command in the package's folder.
fn sh(line: &str) -> Output {
    Command::new("sh").args(["-c", line]).env("PATH", path()).current_dir(root()).output().unwrap()
}

fn write(folder: &Path, name: &str, text: &str) -> String {
    let file = folder.join(name);
    fs::write(&file, text.replace("OUT", folder.to_str().unwrap())).unwrap();
    file.to_str().unwrap().to_string()
}

/// All files below a folder but pipelines, with their bytes, and takes them away.
fn take(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(take(&path));
            continue;
        }
        if path.extension().is_some_and(|e| e == "toml") {
            continue;
        }
        found.push((path.display().to_string(), fs::read(&path).unwrap()));
        fs::remove_file(path).unwrap();
    }
    found.sort();
    found
}

/// Runs a pipeline and its shell form, which must leave the same files and the same standard output.
fn both_ways(folder: &Path, args: &[&str]) -> Vec<(String, Vec<u8>)> {
    let shown = stdout_of("luxpipe", args, b"");
    let fused = take(folder);
    let line = String::from_utf8(stdout_of("luxpipe", &[&["--shell"], args].concat(), b"")).unwrap();
    let shell = sh(&line);
    assert!(shell.status.success(), "{line}: {}", String::from_utf8_lossy(&shell.stderr));
    assert!(shell.stdout == shown, "standard output of {line}");
    let piped = take(folder);
    let names = |list: &[(String, Vec<u8>)]| list.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&fused), names(&piped), "{line}");
    for ((name, a), (_, b)) in fused.iter().zip(&piped) {
        assert!(a == b, "{name} differs between one process and {line}");
    }
    fused
}

const OFFICE: &str = "tests/data/radiance_office.hdr";

#[test]
fn stages_are_a_tree_and_the_shell_does_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
[[stage]]
run = "vonkries"
input = "tests/data/radiance_office.hdr"
to = "D50"
id = "adapted"
save = ["OUT/sub/a.tif", "OUT/a.exr"]

[[stage]]
run = "pcond"

[[stage]]
run = "xyz2rgb"
id = "shown"
save = "OUT/shown.pfm"

[[stage]]
run = "ra_png"
output = "OUT/a.png"

[[stage]]
after = "shown"
run = "ra_png"
bits = 16
output = "OUT/b.png"

[[stage]]
after = "adapted"
exec = ["sh", "-c", "cat"]
format = "rgbe"

[[stage]]
exec = ["cat"]
output = "OUT/c.hdr"

[[stage]]
after = "adapted"
run = "picinfo"

[[stage]]
after = "adapted"
exec = ["cat"]
id = "through"

[[stage]]
run = "ra_rgbe"
output = "OUT/d.hdr"

[[stage]]
after = "through"
exec = ["wc", "-c"]
output = "OUT/count.txt"
format = "xyze"
"#;
    let file = write(folder.path(), "tree.toml", text);
    let files = both_ways(folder.path(), &[&file]);
    let names: Vec<&str> = files.iter().map(|f| f.0.rsplit('/').next().unwrap()).collect();
    assert_eq!(names, ["a.exr", "a.png", "b.png", "c.hdr", "count.txt", "d.hdr", "shown.pfm", "a.tif"]);
    let rgbe = stdout_of("vonkries", &["--to", "D50", OFFICE], b"");
    let rgbe = stdout_of("pjoin", &["--format", "rgbe", "-"], &rgbe);
    assert!(files[3].1 == rgbe, "a program is given what format says");
    let all = stdout_of("luxpipe", &[&file], b"");
    assert!(String::from_utf8(all).unwrap().contains("213 x 157"), "one stage writes standard output");
}

#[test]
fn variables_and_lists_make_one_file_serve_a_batch() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["x one.hdr", "y.hdr"] {
        fs::copy(data_path("radiance_office.hdr"), folder.path().join(name).with_extension("pic")).unwrap();
    }
    let text = r#"
[set]
exposure = 0.5
out = "OUT/made/${shot.stem}-${white}"
[foreach]
shot = "OUT/*.pic"
white = ["D50", "A"]
[[stage]]
run = "vonkries"
input = "${shot}"
to = "${white}"
save = "${out}.exr"
[[stage]]
run = "pcond"
exposure = "${exposure}"
[[stage]]
run = "xyz2rgb"
[[stage]]
run = "ra_png"
output = "${out}.png"
"#;
    let file = write(folder.path(), "batch.toml", text);
    let pictures = folder.path().join("made");
    fs::create_dir(&pictures).unwrap();
    let files = both_ways(&pictures, &[&file]);
    let names: Vec<&str> = files.iter().map(|f| f.0.rsplit('/').next().unwrap()).collect();
    let want = [
        "x one-A.exr",
        "x one-A.png",
        "x one-D50.exr",
        "x one-D50.png",
        "y-A.exr",
        "y-A.png",
        "y-D50.exr",
        "y-D50.png",
    ];
    assert_eq!(names, want);
    stdout_of("luxpipe", &["--jobs", "3", &file], b"");
    assert!(take(&pictures) == files, "jobs side by side give other bytes");
    // One of the list by --set; a number stays one.
    stdout_of("luxpipe", &["--set", "white=A", "--set", "exposure=0.25", &file], b"");
    let some = take(&pictures);
    assert_eq!(some.len(), 4);
    assert!(some[0] == files[0] && some[1].1 != files[1].1);
    // Not in the list, but a white.
    stdout_of("luxpipe", &["--set", "white=D65", &file], b"");
    assert!(take(&pictures).iter().all(|f| f.0.contains("-D65.")));
    let counted = text.replace("\"OUT/*.pic\"", "{ from = 8, to = 10, step = 2, digits = 3 }");
    let counted = counted.replace("${shot}", "tests/data/radiance_office.hdr").replace("${shot.stem}", "f${shot}");
    let file = write(folder.path(), "counted.toml", &counted);
    let said = String::from_utf8(stdout_of("luxpipe", &["--dry-run", &file], b"")).unwrap();
    assert_eq!(said.matches("would write").count(), 4, "{said}");
    assert!(said.contains("made/f008-D50.png") && said.contains("made/f010-A.exr"), "{said}");
    assert!(take(&pictures).is_empty(), "--dry-run did something");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let good = r#"
[set]
white = "D50"
[[stage]]
run = "vonkries"
input = "tests/data/radiance_office.hdr"
to = "${white}"
id = "a"
[[stage]]
run = "pcond"
id = "b"
[[stage]]
run = "xyz2rgb"
[[stage]]
run = "ra_png"
output = "OUT/good.png"
"#;
    stdout_of("luxpipe", &[&write(folder.path(), "good.toml", good)], b"");
    take(folder.path());
    let cases = [
        ("id = \"b\"", "id = \"b\"\nafter = \"b\"", "line 12, column 9: a cycle: stages 2 (pcond) read each other"),
        ("id = \"a\"", "id = \"a\"\nafter = \"b\"", "a cycle: stages"),
        ("id = \"b\"", "id = \"a\"", "two stages have the id 'a'"),
        ("id = \"b\"", "id = \"b\"\nafter = \"c\"", "no stage has the id 'c'; there are a, b"),
        ("white = \"D50\"", "", "line 7, column 6: variable 'white' has no value"),
        ("white = \"D50\"", "white = \"${black}\"", "variable 'black' has no value"),
        ("white = \"D50\"", "white = \"${white}\"", "circle"),
        ("\"${white}\"", "\"${white\"", "without '}'"),
        ("run = \"pcond\"", "run = \"pcond\"\nhumann = true", "humann"),
        ("run = \"pcond\"", "run = \"pkond\"", "line 10, column 7: no filter 'pkond'"),
        ("run = \"pcond\"", "exec = [\"no-such-program\"]", "no program 'no-such-program' is found"),
        ("run = \"pcond\"", "exec = [\"false\"]", "false: ended with exit status: 1"),
        ("run = \"pcond\"", "exec = [\"sh\", \"-c\", \"head -c 100; exit 3\"]", "sh: ended with exit status: 3"),
        ("run = \"pcond\"", "exec = [\"head\", \"-c\", \"60\"]", "output of head"),
        ("run = \"pcond\"", "exec = \"cat\"", "exec must be a list"),
        ("run = \"pcond\"", "exec = []", "exec must be a list"),
        ("run = \"pcond\"", "exec = [\"cat\"]\nformat = \"png\"", "float, rgbe or xyze"),
        ("run = \"pcond\"", "exec = [\"cat\"]\nlinear = true", "unknown key 'linear'"),
        ("run = \"pcond\"", "exec = [\"cat\"]\nrun = \"pcond\"", "either run or exec"),
        ("run = \"pcond\"", "run = \"pcond\"\nmap = \"OUT/good.png\"", "two stages write"),
        ("run = \"pcond\"", "run = \"pcond\"\nsave = \"OUT/x.gif\"", "cannot save"),
        ("run = \"pcond\"", "run = \"pcond\"\nsave = [\"OUT/x.tif\", \"OUT/x.tif\"]", "two stages write"),
        ("[set]", "[foreach]\nshot = []\n[set]", "shot: the list is empty"),
        ("[set]", "[foreach]\nshot = [1, 2]\n[set]", "two jobs write"),
        ("[set]", "[foreach]\nshot = \"OUT/*.none\"\n[set]", "no file matches"),
        ("[set]", "[foreach]\nshot = { from = 1, to = 3, step = 0 }\n[set]", "do not lead"),
        ("[set]", "[foreach]\nshot = { from = 1, too = 3 }\n[set]", "'to' is missing"),
        ("[set]", "[foreach]\nshot = true\n[set]", "of type boolean"),
        ("[set]", "[foreach]\n\"s t\" = [1]\n[set]", "letters, digits"),
        ("[set]", "set = 3\n[sett]", "sett"),
        ("tests/data/radiance_office.hdr", "tests/bad/flat_cut.hdr", "row 2 of 2"),
    ];
    for (from, to, word) in cases {
        assert!(good.contains(from), "{from}");
        let file = write(folder.path(), "bad.toml", &good.replacen(from, to, 1));
        fails("luxpipe", &[&file], b"", 1, word);
        let left = take(folder.path());
        assert!(left.is_empty(), "{to} left {:?}", left.iter().map(|f| &f.0).collect::<Vec<_>>());
    }
    let file = write(folder.path(), "good.toml", good);
    fails("luxpipe", &["--set", "black=1", &file], b"", 2, "no such variable; it has white");
    fails("luxpipe", &["--set", "white", &file], b"", 2, "NAME=VALUE");
    fails("luxpipe", &["--set", "white=D64", &file], b"", 1, "D64");
    fails("luxpipe", &["--shell", "--make", &file], b"", 2, "cannot be used");
    fails("luxpipe", &["--parts", "2", &file], b"", 2, "--parts");
    fails("luxpipe", &["--make", "--parts", "2", &file], b"", 1, "no rows to be divided");
    fails("luxpipe", &["--jobs", "0", &file], b"", 2, "--jobs");
}

/// A stage that fails in the middle of the picture: what was whole before it stays, what hangs on it does not appear.
#[test]
fn a_failure_keeps_what_is_finished() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
[foreach]
shot = ["tests/data/radiance_office.hdr", "tests/bad/flat_cut.hdr", "tests/data/small_xyz.lux"]
[[stage]]
run = "spec2xyz"
input = "${shot}"
save = "OUT/${shot.stem}.exr"
[[stage]]
exec = ["sh", "-c", "cat > /dev/null; exit 4"]
output = "OUT/${shot.stem}.txt"
"#;
    let file = write(folder.path(), "p.toml", text);
    fails("luxpipe", &[&file], b"", 1, "sh: ended with exit status: 4");
    let names = |list: Vec<(String, Vec<u8>)>| -> Vec<String> {
        list.into_iter().map(|f| f.0.rsplit('/').next().unwrap().to_string()).collect()
    };
    assert_eq!(names(take(folder.path())), ["radiance_office.exr"], "the saved picture was whole");
    fails(
        "luxpipe",
        &["--keep-going", &file],
        b"",
        1,
        "3 of 3 jobs failed, 0 are done; the first: shot=tests/data/radiance_office.hdr",
    );
    assert_eq!(names(take(folder.path())), ["radiance_office.exr", "small_xyz.exr"]);
    let file = write(folder.path(), "p.toml", &text.replace("exit 4", "echo done"));
    fails("luxpipe", &["--keep-going", "--jobs", "2", &file], b"", 1, "1 of 3 jobs failed, 2 are done");
    assert_eq!(names(take(folder.path())).len(), 4);
    fails("luxpipe", &[&file], b"", 1, "flat_cut.hdr");
    assert_eq!(names(take(folder.path())).len(), 2);
    let file = write(folder.path(), "p.toml", &text.replace("output = \"OUT/${shot.stem}.txt\"\n", ""));
    fails("luxpipe", &["--jobs", "2", &file], b"", 2, "name an output, or run one at a time");
}

/// Rules know every file that a scene names, and leave alone what is newer than them.
#[test]
fn rules_for_make_depend_on_all_that_matters() {
    if !sh("make --version").status.success() {
        return; // make is needed to build; who tests without it tests the rest
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cube.obj"), "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("my paint.csv"), "wavelength_nm,value\n380,0.2\n780,0.7\n").unwrap();
    let scene = r#"
[camera]
type = "perspective"
origin = [0, -5, 1]
target = [0, 0, 0]
up = [0, 0, 1]
fov_deg = 40
width = 16
[materials.p]
type = "diffuse"
reflectance = "my paint.csv"
[[shape]]
type = "mesh"
file = "cube.obj"
material = "p"
[environment]
type = "uniform"
spectrum = "D65"
luminance = 100
"#;
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let text = r#"
[foreach]
seed = [1, 2]
[[stage]]
run = "spectrace"
scene = "OUT/scene.toml"
samples = 4
seed = "${seed}"
save = "OUT/out/a $1 ${seed}.exr"
[[stage]]
run = "vonkries"
to = "D50"
[[stage]]
run = "ra_rgbe"
output = "OUT/out/a${seed}.hdr"
"#;
    let file = write(folder.path(), "rules.toml", text);
    let whole = {
        stdout_of("luxpipe", &[&file], b"");
        take(&folder.path().join("out"))
    };
    for parts in ["1", "3"] {
        let rules = stdout_of("luxpipe", &["--make", "--parts", parts, &file], b"");
        let makefile = folder.path().join("rules.mk");
        fs::write(&makefile, &rules).unwrap();
        let text = String::from_utf8(rules).unwrap();
        for name in ["scene.toml", r"my\ paint.csv", "cube.obj", "rules.toml"] {
            assert!(text.contains(name), "{name} is no dependency: {text}");
        }
        let make = |more: &str| sh(&format!("make {more} -j2 -f {} rules", makefile.display()));
        let made = make("-s");
        assert!(made.status.success(), "{}\n{text}", String::from_utf8_lossy(&made.stderr));
        assert!(make("-q").status.success(), "made, and yet not up to date");
        let later = std::time::SystemTime::now() + Duration::from_secs(5);
        fs::File::options().append(true).open(folder.path().join("my paint.csv")).unwrap().set_modified(later).unwrap();
        assert_eq!(make("-q").status.code(), Some(1), "a new spectrum changes nothing");
        let earlier = later - Duration::from_secs(10_000);
        fs::File::options()
            .append(true)
            .open(folder.path().join("my paint.csv"))
            .unwrap()
            .set_modified(earlier)
            .unwrap();
        let files: Vec<_> = take(&folder.path().join("out")).into_iter().filter(|f| !f.0.contains(".parts/")).collect();
        assert!(files == whole, "{parts} parts: other bytes");
    }
}

/// `--resume` does what is missing, and what is older than what it is made of.
#[test]
fn a_rerun_does_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(data_path("radiance_office.hdr"), folder.path().join("in.pic")).unwrap();
    let text = r#"
[foreach]
white = ["A", "D50", "D65"]
[[stage]]
run = "vonkries"
input = "OUT/in.pic"
to = "${white}"
[[stage]]
run = "ra_rgbe"
output = "OUT/${white}.hdr"
"#;
    let file = write(folder.path(), "p.toml", text);
    let again = || String::from_utf8(run("luxpipe", &["--resume", &file], b"").stderr).unwrap();
    assert_eq!(again(), "");
    assert!(again().contains("3 of 3 jobs were done already"));
    fs::remove_file(folder.path().join("D50.hdr")).unwrap();
    assert!(again().contains("2 of 3 jobs were done already"));
    assert!(folder.path().join("D50.hdr").exists());
    let later = std::time::SystemTime::now() + Duration::from_secs(5);
    fs::File::options().append(true).open(folder.path().join("in.pic")).unwrap().set_modified(later).unwrap();
    assert_eq!(again(), "", "made again of a newer picture");
}

/// kill -9 at 20 moments: a file under its final name is whole, and the same command at last leaves what an undisturbed one does.
#[test]
fn a_kill_leaves_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
[foreach]
seed = [1, 2, 3]
[[stage]]
run = "spectrace"
scene = "scenes/cornell.toml"
width = 96
samples = 16
seed = "${seed}"
save = ["OUT/out/${seed}.tif", "OUT/out/${seed}.exr"]
[[stage]]
run = "vonkries"
[[stage]]
run = "pcond"
[[stage]]
run = "xyz2rgb"
quiet = true
[[stage]]
run = "ra_png"
output = "OUT/out/${seed}.png"
"#;
    let file = write(folder.path(), "p.toml", text);
    let out = folder.path().join("out");
    let began = Instant::now();
    stdout_of("luxpipe", &[&file], b"");
    let takes = began.elapsed();
    let whole = take(&out);
    assert_eq!(whole.len(), 9);
    let mut lot = 12_345u32;
    for _ in 0..20 {
        let mut child = Command::new(program("luxpipe"))
            .args(["--resume", &file])
            .current_dir(root())
            .stdin(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        lot = lot.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        std::thread::sleep(takes.mul_f64(f64::from(lot) / f64::from(u32::MAX) * 0.6));
        child.kill().unwrap();
        child.wait().unwrap();
        for entry in fs::read_dir(&out).into_iter().flatten() {
            let path = entry.unwrap().path();
            let name = path.display().to_string();
            let hidden = path.file_name().unwrap().to_str().unwrap().starts_with('.');
            if let Some((_, bytes)) = whole.iter().find(|f| f.0 == name) {
                assert!(fs::read(&path).unwrap() == *bytes, "{name} is not whole");
            } else {
                assert!(hidden || name.ends_with(".checkpoint"), "{name} is nobody's");
            }
        }
        // Some are done by now; all over again then.
        if whole.iter().all(|f| Path::new(&f.0).exists()) {
            take(&out);
        }
    }
    stdout_of("luxpipe", &["--resume", &file], b"");
    let left: Vec<_> = take(&out).into_iter().filter(|f| !f.0.contains("/.luxpipe-")).collect();
    assert!(left == whole, "{:?}", left.iter().map(|f| &f.0).collect::<Vec<_>>());
}

/// Bands of rows, in any order, give the bytes of the whole; what does not fit is said.
#[test]
fn bands_are_put_together() {
    let folder = tempfile::tempdir().unwrap();
    for options in
        [&[][..], &["--output", "spectrum", "--bands", "9"], &["--output", "stokes", "--bands", "3"], &["--per-light"]]
    {
        let render = |rows: Option<&str>| {
            let mut args = vec!["scenes/cornell.toml", "--width", "24", "--samples", "2", "--split", "2"];
            args.extend(options);
            args.extend(rows.iter().flat_map(|r| ["--rows", r]));
            stdout_of("spectrace", &args, b"")
        };
        let whole = render(None);
        let band = |rows: &str| {
            let file = folder.path().join(format!("{}.lux", rows.replace(':', "-")));
            fs::write(&file, render(Some(rows))).unwrap();
            file.to_str().unwrap().to_string()
        };
        let bands = [band("7:8"), band("0:7"), band("8:24")];
        let all: Vec<&str> = bands.iter().map(String::as_str).collect();
        assert!(stdout_of("pjoin", &all, b"") == whole, "{options:?}");
        assert!(stdout_of("pjoin", &["-"], &whole) == whole, "a whole picture passes as it is");
        let file = folder.path().join("joined.lux");
        stdout_of("pjoin", &[&all[..], &["--output", file.to_str().unwrap()]].concat(), b"");
        assert!(fs::read(file).unwrap() == whole);
        fails("pjoin", &all[..2], b"", 1, "rows 8 to 24 of 24 are missing");
        fails("pjoin", &[all[0], all[2]], b"", 1, "rows 0 to 7 of 24 are missing");
        fails("pjoin", &[all[1], all[1]], b"", 1, "named twice");
        let more = band("6:9");
        fails("pjoin", &[&all[..], &[&more]].concat(), b"", 1, "6-9.lux: begins with row 6");
    }
    fails("pjoin", &[], b"", 2, "BAND");
    fails("pjoin", &["tests/data/small_xyz.lux", "tests/data/radiance_office.hdr"], b"", 1, "no ROWS line");
    let (lines, floats) = ("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= .3 .3", vec![1.0; 6]);
    for (rows, word) in [
        ("0 3 9", "has 2 rows"),
        ("3 3 9", "expected first row"),
        ("0 2", "expected first row"),
        ("-1 1 3", "expected"),
    ] {
        fails("pjoin", &["-"], &stream(&format!("{lines}\nROWS= {rows}"), "-Y 2 +X 1", &floats), 1, word);
    }
    let one = folder.path().join("one.lux");
    fs::write(&one, stream(&format!("{lines}\nROWS= 0 2 4"), "-Y 2 +X 1", &floats)).unwrap();
    let other = stream(&format!("{}\nROWS= 2 4 4", lines.replace(".3 .3", ".3 .4")), "-Y 2 +X 1", &floats);
    fails("pjoin", &[one.to_str().unwrap(), "-"], &other, 1, "another picture");
    let cut = stream(&format!("{lines}\nROWS= 2 4 4"), "-Y 2 +X 1", &floats[..5]);
    let file = folder.path().join("cut.lux");
    fs::write(&file, cut).unwrap();
    let output = run("pjoin", &[one.to_str().unwrap(), file.to_str().unwrap()], b"");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cut.lux: picture ends at row 2 of 2"));
}

/// plate + with - without, rounded once: what is alike in both cancels to the last bit.
#[test]
fn light_adds_up() {
    let folder = tempfile::tempdir().unwrap();
    let lines = "NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.3290";
    let picture = |name: &str, values: &[f32]| {
        let file = folder.path().join(name);
        fs::write(&file, stream(lines, "-Y 2 +X 1", values)).unwrap();
        file.to_str().unwrap().to_string()
    };
    let plate = [1.0f32, 2.0, 3.0, 0.1, 0.2, 0.3];
    let with = picture("with.lux", &[1e6, 7.0, 5.0, 3.0e5, 0.1, 0.5]);
    let without = picture("without.lux", &[1e6, 5.0, 6.0, 3.0e5, 0.2, 0.25]);
    let input = stream(lines, "-Y 2 +X 1", &plate);
    let mixed = stdout_of("pmix", &["--add", &with, "--subtract", &without], &input);
    let (head, _, bytes) = split(&mixed);
    let exact = |a: f32, b: f32, c: f32| (f64::from(a) + f64::from(b) - f64::from(c)) as f32;
    let want = [1.0, 4.0, 2.0, 0.1, exact(0.2, 0.1, 0.2), exact(0.3, 0.5, 0.25)];
    assert_eq!(common::floats(bytes), want);
    assert!(head.iter().any(|l| l == "pmix --add with.lux --subtract without.lux"), "{head:?}");
    let half = stdout_of("pmix", &["--weight", "0.5", "--add", &format!("-2:{with}")], &input);
    assert_eq!(common::floats(split(&half).2)[1], 1.0 - 14.0);
    // In a pipeline, by its keys.
    let out = tempfile::tempdir().unwrap();
    let text = format!(
        "[[stage]]\nrun = \"pmix\"\ninput = \"{with}\"\nsubtract = [\"0.5:{without}\"]\n[[stage]]\nrun = \"ra_pfm\"\noutput = \"OUT/d.pfm\"\n"
    );
    both_ways(out.path(), &[&write(out.path(), "p.toml", &text)]);
    let other = folder.path().join("wide.lux");
    fs::write(&other, stream(lines, "-Y 1 +X 2", &plate)).unwrap();
    fails("pmix", &["--add", other.to_str().unwrap()], &input, 1, "of one size");
    let shown = stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=display\nDISPLAY= 1 100", "-Y 2 +X 1", &plate);
    fs::write(&other, shown).unwrap();
    fails("pmix", &["--add", other.to_str().unwrap()], &input, 1, "only like can be added");
    assert!(split(&half).0.iter().any(|l| l == "pmix --weight 0.5 --add=-2:with.lux"));
    fails("pmix", &["--add", "nan:x"], &input, 2, "no picture");
    fails("pmix", &["--add", "none.lux"], &input, 1, "none.lux");
}

#[test]
fn the_doctor_knows_the_machine() {
    let text = String::from_utf8(stdout_of("luxpipe", &["doctor"], b"")).unwrap();
    let count = luxpipe::filters::ALL.len() + 2;
    assert!(text.contains(&format!("{count} of {count} in")), "{text}");
    assert!(text.contains("snakemake") && text.contains("processors"), "{text}");
}

/// The real Snakemake where there is one, each band a job; a killed job is done again, nothing else is.
#[test]
fn snakemake_runs_what_luxpipe_writes() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
[foreach]
seed = [1, 2]
[[stage]]
run = "spectrace"
scene = "SCENE"
width = 32
samples = 4
seed = "${seed}"
save = "OUT/out/{-odd} ${seed}.exr"
[[stage]]
run = "ra_rgbe"
output = "OUT/out/${seed}.hdr"
"#;
    let scene = root().join("scenes/cornell.toml");
    let file = write(folder.path(), "p.toml", &text.replace("SCENE", scene.to_str().unwrap()));
    stdout_of("luxpipe", &[&file], b"");
    let whole = take(&folder.path().join("out"));
    let snakefile = stdout_of("luxpipe", &["--snakemake", "--parts", "3", &file], b"");
    let snakefile = String::from_utf8(snakefile).unwrap();
    assert_eq!(snakefile.matches("\nrule job_").count(), 8, "{snakefile}");
    assert!(
        snakefile.contains("{-odd} 1.exr\",") && snakefile.contains("--threads {threads} --set seed=1"),
        "{snakefile}"
    );
    let odd = text.replace("SCENE", scene.to_str().unwrap()).replace("-odd", "odd");
    let odd = write(folder.path(), "odd.toml", &odd);
    fails("luxpipe", &["--snakemake", &odd], b"", 1, "takes {...} in a file's name for a pattern");
    let name = folder.path().join("Snakefile");
    fs::write(&name, &snakefile).unwrap();
    let Some(snakemake) = std::env::var_os("SNAKEMAKE").map(PathBuf::from).or_else(|| {
        let found = sh("command -v snakemake");
        found.status.success().then(|| String::from_utf8_lossy(&found.stdout).trim().into())
    }) else {
        return;
    };
    let run = |more: &[&str]| {
        let mut command = Command::new(&snakemake);
        command.args(["--cores", "2", "--snakefile", name.to_str().unwrap()]).args(more);
        command.env("PATH", path()).current_dir(folder.path()).output().unwrap()
    };
    let done = run(&[]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    fs::remove_file(folder.path().join("out/2.hdr")).unwrap();
    let again = String::from_utf8_lossy(&run(&[]).stderr).into_owned();
    assert!(again.contains("job_8        1") && !again.contains("job_7"), "{again}");
    let files: Vec<_> = take(&folder.path().join("out")).into_iter().filter(|f| !f.0.contains(".parts/")).collect();
    assert!(files == whole, "other bytes");
}
