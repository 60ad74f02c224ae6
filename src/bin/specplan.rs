//! The program `specplan`: see luxpipe's src/filters/specplan.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Specplan>()
}
