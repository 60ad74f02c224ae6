//! `make accuracy`: every case of tests/ref/validation.toml to its tolerance, into docs/accuracy.md.

#[path = "../tests/accuracy/cases.rs"]
mod cases;
#[path = "../tests/accuracy/formulas.rs"]
mod formulas;
#[path = "../tests/accuracy/list.rs"]
mod list;
#[path = "../tests/accuracy/media.rs"]
mod media;
#[path = "../tests/accuracy/waves.rs"]
mod waves;

use std::fmt::Write;
use std::time::{Duration, Instant};

/// Time a case may take.
const LONGEST: Duration = Duration::from_secs(30);

const HEAD: &str = "# Accuracy

`make accuracy` measures every case of [tests/ref/validation.toml](../tests/ref/validation.toml) and writes this page:
closed forms, quadrature and converged solutions, each with its own source there; numbers \"cie\" are cases of CIE 171:2006. A
measurement goes on until its standard error is a fifth of the tolerance, or its share of 30 seconds is up. Path tracing claims all
cases, the other methods those that they can show; what these work out before they look is solved eight times, with other random
numbers each, for its standard error. Values beyond their tolerance are marked, apart from those that two standard errors explain. The line is that of the value of the case that comes out worst, by its distance over its
tolerance.

";

/// Seven digits.
fn shown(value: f64) -> String {
    if value.abs() < 0.01 { format!("{value:.6e}") } else { format!("{value:.6}") }
}

fn main() {
    let table = cases::table();
    let mut page = String::from(HEAD);
    page += "| case | method | values | worst of them | expected | got | standard error | tolerance | time, s |\n|---|---|---|---|---|---|---|---|---|\n";
    let (mut missed, mut noisy) = (0, 0);
    let all = list::all(&table);
    for (case, how) in all.iter().flat_map(|c| c.methods().map(move |how| (c, how))) {
        let start = Instant::now();
        let got = case.by(how, 0.2, LONGEST);
        let seconds = start.elapsed().as_secs_f64();
        let share = |i: usize| (got[i].value - case.values[i].want).abs() / case.values[i].tolerance;
        let worst = (0..got.len()).max_by(|a, b| share(*a).total_cmp(&share(*b))).unwrap_or(0);
        let (v, g) = (&case.values[worst], &got[worst]);
        let explained = |i: usize| {
            (got[i].value - case.values[i].want).abs() <= case.values[i].tolerance + 2.0 * got[i].standard_error
        };
        let out = (0..got.len()).filter(|i| share(*i) > 1.0 && !explained(*i)).count();
        let noise = (0..got.len()).filter(|i| share(*i) > 1.0 && explained(*i)).count();
        (missed, noisy) = (missed + out, noisy + noise);
        let mark = match (out, noise) {
            (0, 0) => String::new(),
            (0, n) => format!(" ({n} by noise)"),
            (n, _) => format!(" **({n} beyond their tolerance)**"),
        };
        let row = format!(
            "| {} | {how:?} | {}{mark} | {} | {} | {} | {:.1e} | {:.1e} | {seconds:.2} |",
            case.id,
            got.len(),
            v.label,
            shown(v.want),
            shown(g.value),
            g.standard_error,
            v.tolerance
        );
        println!("{row}");
        page += &row;
        page.push('\n');
    }
    page += "\n## Formulas\n\nWhat glass and Fresnel's equations are asked for directly.\n\n| case | method | values | worst of them | expected | got | tolerance |\n|---|---|---|---|---|---|\n";
    let mut rows = formulas::all(&table);
    while let Some(id) = rows.first().map(|r| r.0.clone()) {
        let (of, rest): (Vec<_>, Vec<_>) = rows.into_iter().partition(|r| r.0 == id);
        rows = rest;
        let off = |r: &formulas::Row| (r.3 - r.2).abs() / r.4;
        let Some(worst) = of.iter().max_by(|a, b| off(a).total_cmp(&off(b))) else { continue };
        missed += of.iter().filter(|r| off(r) > 1.0).count();
        let _ =
            writeln!(page, "| {id} | {} | {} | {:.8} | {:.8} | {:.0e} |", of.len(), worst.1, worst.2, worst.3, worst.4);
    }
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md");
    if let Err(e) = std::fs::write(&path, page) {
        eprintln!("{}: {e}", path.display());
        std::process::exit(1);
    }
    println!("{missed} values beyond their tolerance, {noisy} more by noise; written to docs/accuracy.md");
}
