//! The stability suite: every documented failure case of every method and filter, through the real programs.
//!
//! Each case of tests/stability/cases.toml is run, and must end as it says: exact, warned, refused or degraded.
//! docs/limits.md is the same list as a page, so that nobody meets a limit unwarned; `make stability` writes it.

mod common;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::{env, fs};

use common::{program, root, stream};
use serde::Deserialize;

const PAGE: &str = "docs/limits.md";

const HEAD: &str = "# Limits, and what happens there

Made by `make stability` from tests/stability/cases.toml; `cargo test --test stability` runs each row. A case is *exact*
where a closed form or the literature has its numbers, *warned* where there is a result and a note on standard error,
*refused* where there is one line and no result, and *degraded* where the result is worse and nothing is said.
";

/// How a case ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Exact,
    Warned,
    Refused,
    Degraded,
}

/// A float stream of one row.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    lines: String,
    pixels: Vec<Vec<f32>>,
}

/// One of tests/stability/cases.toml, whose head says what the keys are.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    method: String,
    input: String,
    outcome: Outcome,
    scene: Option<String>,
    scene_file: Option<PathBuf>,
    picture: Option<Row>,
    command: String,
    message: Option<String>,
    #[serde(default)]
    notes: Vec<String>,
    #[serde(default)]
    status: i32,
    #[serde(default)]
    expect: Vec<f64>,
    #[serde(default)]
    tolerance: f64,
    why: Option<String>,
    instead: Option<String>,
}

#[derive(Deserialize)]
struct Cases {
    case: Vec<Case>,
}

#[test]
fn every_case_ends_as_the_page_says() {
    let text = fs::read_to_string(root().join("tests/stability/cases.toml")).unwrap();
    let cases = toml::from_str::<Cases>(&text).unwrap().case;
    let faults: Vec<String> = cases.iter().filter_map(|case| case.fault(&case.run())).collect();
    assert!(faults.is_empty(), "{} of {} cases:\n{}", faults.len(), cases.len(), faults.join("\n"));
    let page = page(&cases);
    if env::var_os("STABILITY_WRITE").is_some() {
        fs::write(root().join(PAGE), &page).unwrap();
        print!("{page}");
    } else {
        assert_eq!(fs::read_to_string(root().join(PAGE)).unwrap(), page, "run: make stability");
    }
}

impl Case {
    fn run(&self) -> Output {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            path
        };
        let scene = self.scene.as_ref().map(|text| put("scene.toml", text.as_bytes()));
        let picture = self.picture.as_ref().map(|row| {
            put("picture.lux", &stream(&row.lines, &format!("-Y 1 +X {}", row.pixels.len()), &row.pixels.concat()))
        });
        Command::new("bash")
            .args(["-o", "pipefail", "-c", &self.command])
            .current_dir(root())
            .env("PATH", search_path())
            .env("TMP", folder.path())
            .envs(scene.or(self.scene_file.clone()).map(|path| ("SCENE", path)))
            .envs(picture.map(|path| ("PICTURE", path)))
            .output()
            .unwrap()
    }

    /// What it did that it should not have.
    fn fault(&self, output: &Output) -> Option<String> {
        let (said, printed) = (String::from_utf8_lossy(&output.stderr), String::from_utf8_lossy(&output.stdout));
        let told = self.message.as_ref().is_some_and(|m| said.lines().any(|line| line.contains(m)));
        let silent = said.lines().all(|line| self.notes.iter().any(|note| line.contains(note)));
        let as_said = match self.outcome {
            Outcome::Exact => silent && !self.expect.is_empty(),
            Outcome::Degraded => silent && self.why.is_some(),
            Outcome::Warned => told,
            Outcome::Refused => told && self.status != 0 && said.lines().count() == 1,
        };
        let numbers: Vec<f64> =
            printed.split(|c: char| c.is_whitespace() || c == ',').filter_map(|word| word.parse().ok()).collect();
        let near = |(got, want): (&f64, &f64)| (got - want).abs() <= self.tolerance * want.abs();
        // A number that is from nowhere proves nothing.
        let right = numbers.len() >= self.expect.len()
            && numbers.iter().zip(&self.expect).all(near)
            && (self.expect.is_empty() || self.why.is_some());
        let fine = as_said && right && output.status.code() == Some(self.status);
        (!fine).then(|| {
            let first = &numbers[..numbers.len().min(self.expect.len())];
            let Case { method, input, outcome, .. } = self;
            format!(
                "{method}: {input}: not {outcome:?}: {}, {first:?}, said: {said}\n  {}",
                output.status, self.command
            )
        })
    }

    /// A line of the page.
    fn line(&self) -> String {
        let mut what = match self.outcome {
            // A millionth is 0.0001 %; rounded, for floats.
            Outcome::Exact if self.tolerance > 0.0 => {
                format!("exact to {} %", (self.tolerance * 1e6).round() / 1e4)
            }
            Outcome::Exact => "exact".into(),
            Outcome::Warned => "warned".into(),
            Outcome::Refused => format!("refused, status {}", self.status),
            Outcome::Degraded => "degraded".into(),
        };
        if let Some(why) = &self.why {
            what += &format!(": {why}");
        }
        let says = self.message.as_ref().map_or(String::new(), |m| format!("`{m}`"));
        format!("| {} | {what} | {says} | {} |\n", self.input, self.instead.as_deref().unwrap_or_default())
    }
}

/// The filters that cargo built before all others.
fn search_path() -> OsString {
    let ours = program("spectrace").parent().unwrap().to_path_buf();
    let others = env::var_os("PATH").unwrap_or_default();
    env::join_paths([ours].into_iter().chain(env::split_paths(&others))).unwrap()
}

/// docs/limits.md: a table a method.
fn page(cases: &[Case]) -> String {
    let mut page = HEAD.to_string();
    for cases in cases.chunk_by(|a, b| a.method == b.method) {
        page += &format!(
            "\n## {}\n\n| input | what happens | what it says | instead |\n|---|---|---|---|\n",
            cases[0].method
        );
        cases.iter().for_each(|case| page += &case.line());
    }
    page
}
