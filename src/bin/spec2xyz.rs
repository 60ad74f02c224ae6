//! The program `spec2xyz`: see luxpipe's src/filters/spec2xyz.rs.

fn main() -> std::process::ExitCode {
    luxpipe::cli::main::<luxpipe::filters::Spec2xyz>()
}
