//! The program `pglare`: see luxpipe's src/filters/pglare.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pglare>()
}
