//! The program that charts error against time, on a small scene; its page in a browser where there is one.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{program, run};

fn tradeoff(folder: &Path, more: &[&str]) {
    let out = folder.join("out").to_str().unwrap().to_string();
    let fixed = ["--width=12", "--seconds=0.05", "--reference-seconds=0.4", "--samples=2", "-o", &out];
    let output = run("tradeoff", &[&fixed[..], more].concat(), b"");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
}

fn rows(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("out/tradeoff.csv")).unwrap();
    text.lines().map(|l| l.split(',').map(String::from).collect()).collect()
}

/// The table has each method and plan, plans err less the more wavelengths they have, and a kept reference is used again.
#[test]
fn methods_and_plans_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let plans = "--plans=relative,4,16,bands80,specplan";
    tradeoff(folder.path(), &["scenes/cornell.toml", "--methods=path,local", plans, "--filters"]);
    let table = rows(folder.path());
    let column = |name: &str| table[0].iter().position(|c| c == name).unwrap();
    let (kind, name, error) = (column("kind"), column("name"), column("delta_e_rms"));
    let of = |k: &str, n: &str| table.iter().filter(|r| r[kind] == k && r[name] == n).collect::<Vec<_>>();
    for (k, n) in [("method", "path"), ("method", "local"), ("method", "path by specplan"), ("plan", "specplan")] {
        assert!(!of(k, n).is_empty(), "{k} {n}: {table:?}");
    }
    let error = |n: &str| of("plan", n)[0][error].parse::<f64>().unwrap();
    assert_eq!(error("bands80"), 0.0);
    for few in ["relative", "4"] {
        assert!(error(few) > error("16") && error("16") > 0.0, "{few}: {table:?}");
    }
    for file in ["cornell-luminance.svg", "cornell-colour.png", "cornell-plans.svg", "tradeoff.html"] {
        assert!(std::fs::metadata(folder.path().join("out").join(file)).unwrap().len() > 1000, "{file}");
    }
    let setting = |t: &[Vec<String>]| t[1][column("setting")].clone();
    assert_eq!(setting(&table), "made now");
    tradeoff(folder.path(), &["scenes/cornell.toml", "--methods=none", "--plans=none"]);
    assert_eq!(setting(&rows(folder.path())), "kept");
}

/// What a method refuses is a row that says why.
#[test]
fn refusals_are_rows() {
    let folder = tempfile::tempdir().unwrap();
    let scene = ["scenes/fogbox.toml", "--methods=radiosity,march", "--plans=8"];
    tradeoff(folder.path(), &scene);
    let table = rows(folder.path());
    let note = table[0].iter().position(|c| c == "note").unwrap();
    assert!(table.iter().any(|r| r[2] == "radiosity" && r[note].contains("boundaries")), "{table:?}");
    tradeoff(folder.path(), &["scenes/fluorescence.toml", "--methods=none", "--plans=8"]);
    let table_of_dyes = rows(folder.path());
    assert!(table_of_dyes.iter().any(|r| r[2] == "8" && r[note].contains("fluoresces")), "{table_of_dyes:?}");
    assert!(table.iter().any(|r| r[2] == "march" && !r[4].is_empty()), "{table:?}");
}

#[test]
fn nonsense_is_refused() {
    for (args, code, word) in [
        (vec!["scenes/cornell.toml", "-o", "OUT", "--methods=magic"], 2, "magic"),
        (vec!["scenes/cornell.toml", "-o", "OUT", "--plans=0"], 2, "--plans"),
        (vec!["scenes/cornell.toml", "-o", "OUT", "--seconds=0"], 2, "--seconds"),
        (vec!["scenes/missing.toml", "-o", "OUT"], 1, "missing.toml"),
        (vec!["-o", "OUT"], 2, "SCENE"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out").to_str().unwrap().to_string();
        let args: Vec<&str> = args.into_iter().map(|a| if a == "OUT" { &out[..] } else { a }).collect();
        let output = run("tradeoff", &args, b"");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        assert!(text.contains(word) && text.lines().count() == 1, "{args:?}: {text}");
    }
}

/// A browser that the machine may have, or the one that CHROMIUM names.
fn browser() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let mut known = std::env::split_paths(&path).flat_map(|folder| names.map(|n| folder.join(n)));
    named.or_else(|| known.find(|p| p.is_file()))
}

/// The page's script runs, sorts nothing away, shows error maps when asked, and the page fits a telephone. Needs Chromium.
#[test]
fn the_page_works_in_a_browser() {
    let Some(browser) = browser() else {
        println!("no Chromium in PATH and no CHROMIUM: the page was not opened");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    tradeoff(folder.path(), &["scenes/cornell.toml", "--methods=path,local", "--plans=4,bands80", "--filters"]);
    let page = format!("file://{}/out/tradeoff.html", folder.path().display());
    let dom = |address: &str| {
        let output = Command::new(&browser)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--window-size=500,900",
                "--virtual-time-budget=3000",
            ])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .args(["--dump-dom", address])
            .output()
            .unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let (plain, maps) = (dom(&page), dom(&format!("{page}#maps")));
    let rows = rows(folder.path()).len() - 1;
    let counted = plain.split("data-rows=\"").nth(1).and_then(|t| t.split('"').next()).unwrap_or("none");
    assert!(counted.parse::<usize>().is_ok_and(|n| n > rows), "{counted} rows shown, {rows} in the table");
    assert!(plain.contains("data-overflow=\"false\""), "wider than a telephone");
    assert!(!plain.contains("<body class=\"maps\"") && maps.contains("class=\"maps\""));
    assert!(program("tradeoff").is_file() && plain.contains("data:image/png;base64,") && plain.contains("<polyline"));
}
