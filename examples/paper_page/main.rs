//! The page of `make paper`: see page.rs.

mod page;

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut words = std::env::args_os().skip(1);
    let (Some(out), None) = (words.next(), words.next()) else {
        eprintln!("paper_page: one argument is needed, the folder to write index.html to");
        return ExitCode::FAILURE;
    };
    match page::run(Path::new(&out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("paper_page: {why}");
            ExitCode::FAILURE
        }
    }
}
