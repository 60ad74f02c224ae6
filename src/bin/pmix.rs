//! The program `pmix`: see luxpipe's src/filters/pmix.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Pmix>()
}
