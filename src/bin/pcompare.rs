//! The program `pcompare`: see luxpipe's src/filters/pcompare.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pcompare>()
}
