//! Every case of tests/ref/validation.toml that Eq. (1) covers, with at most two seconds each: the result lies within its
//! tolerance plus 4.5 standard errors, and the standard error is small enough that this says something.

#[path = "accuracy/cases.rs"]
mod cases;
#[path = "accuracy/formulas.rs"]
mod formulas;
#[path = "accuracy/list.rs"]
mod list;
#[path = "accuracy/media.rs"]
mod media;
#[path = "accuracy/waves.rs"]
mod waves;

use std::time::{Duration, Instant};

#[test]
fn no_case_is_forgotten() {
    let table = cases::table();
    let mut covered: Vec<String> = list::all(&table).into_iter().map(|c| c.id).collect();
    covered.extend(formulas::all(&table).into_iter().map(|r| r.0));
    let missing: Vec<&String> = table.keys().filter(|k| !covered.contains(k)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn formulas_are_those_of_the_table() {
    for formulas::Row(id, what, want, got, tolerance) in formulas::all(&cases::table()) {
        assert!((want - got).abs() <= tolerance, "{id}, {what}: {got} for {want}");
    }
}

#[test]
fn renders_lie_within_tolerance_and_error() {
    let mut wrong = Vec::new();
    let mut all = list::all(&cases::table());
    // Of the table of layers, whose every row is a case, a few; the rest are the slab solver's here, and `make accuracy`'s.
    let mut rows = 0;
    all.retain(|c| {
        rows += u32::from(c.id == "slab-isotropic-table");
        c.id != "slab-isotropic-table" || rows % 6 == 2
    });
    for (case, how) in all.iter().flat_map(|c| c.methods().map(move |how| (c, how))) {
        let start = Instant::now();
        let mut got = case.by(how, 2.0, Duration::from_secs(2));
        if case.values.iter().zip(&got).any(|(v, g)| g.standard_error > 5.0 * v.tolerance) {
            // Enough on a machine that has nothing else to do.
            got = case.by(how, 2.0, Duration::from_secs(10));
        }
        let (mut worst, mut noise) = (0.0f64, 0.0f64);
        for (v, g) in case.values.iter().zip(&got) {
            let off = (g.value - v.want).abs();
            worst = worst.max(off / (v.tolerance + 4.5 * g.standard_error));
            noise = noise.max(g.standard_error / v.tolerance);
            if off > v.tolerance + 4.5 * g.standard_error || g.standard_error > 5.0 * v.tolerance {
                wrong.push(format!(
                    "{} by {how:?}, {}: {} +- {} for {} +- {}",
                    case.id, v.label, g.value, g.standard_error, v.want, v.tolerance
                ));
            }
        }
        let (n, s) = (case.values.len(), start.elapsed().as_secs_f64());
        println!(
            "{:32} {:10} {n:3} values, worst {worst:.2} of what is allowed, error at most {noise:.2} tolerances, {s:.2} s",
            case.id,
            format!("{how:?}")
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
