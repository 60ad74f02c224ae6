//! The program `relight`: see luxpipe's src/filters/relight.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Relight>()
}
