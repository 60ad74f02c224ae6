//! What happens when things go wrong: damaged files, faults of the system, odd names, loads, and whether equal work gives equal bytes.
//! `cargo bench --bench trust -- hostile|faults|names|load|determinism [--count N] [--seed S] [--small] [--only NAME]` prints a section of
//! docs/reliability.md, and ends with status 1 when a demand is broken: the command that shows it is printed, its file kept.

mod corpus;
mod determinism;
mod escapes;
mod faults;
mod guard;
mod hostile;
mod load;
mod mutate;
mod names;
mod readers;
mod run;
mod subjects;
mod sudden;

use std::process::ExitCode;

use run::{Choice, Demands};

fn main() -> ExitCode {
    let choice = match Choice::parse(std::env::args().skip(1)) {
        Ok(choice) => choice,
        Err(e) => {
            eprintln!("trust: {e}");
            return ExitCode::from(2);
        }
    };
    // `cargo bench` and `cargo test --benches` start every bench: without a part there is nothing to do.
    let mut demands = Demands::new(&choice.part);
    let done = match choice.part.as_str() {
        "hostile" => hostile::section(&choice, &mut demands),
        "faults" => faults::section(&mut demands),
        "names" => names::section(&mut demands),
        "load" => load::section(&choice, &mut demands),
        "determinism" => determinism::section(&mut demands),
        _ => {
            eprintln!("trust: say what: hostile, faults, names, load or determinism");
            return ExitCode::SUCCESS;
        }
    };
    if let Err(e) = done {
        eprintln!("trust: {e}");
        return ExitCode::from(2);
    }
    demands.verdict()
}
